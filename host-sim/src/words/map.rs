//! How far maps agree, in one line.

use numerics::map::{Agreement, Similarity};

/// An agreement cell by cell, percentages first.
pub fn agreement(found: &Agreement) -> String {
    let apart = found.cells - found.same_label;
    let coexisting = match found.coexisting {
        Some(count) if apart > 0 => format!(
            "; in {count} of the {apart} with another label both motions exist (started on the first, the reference stays on it)"
        ),
        _ => String::new(),
    };
    format!(
        "same label {}; of the {} that repeat in both, same p/n {}, force within 0.1 % {}; flagged {}{coexisting}",
        percent(found.same_label, found.cells),
        found.both_periodic,
        percent(found.same_p_n, found.both_periodic),
        percent(found.same_force, found.both_periodic),
        percent(found.uncertain, found.cells),
    )
}

/// The similarity of two rigs' maps.
pub fn similarity(found: &Similarity) -> String {
    let [a, b] = &found.rigs;
    format!(
        "{a} and {b}: same regime in {} of {} cells, in {} where one of the two strikes, in {} where both repeat within two periods",
        percent(found.same, found.cells),
        found.cells,
        percent(found.same_striking, found.striking),
        percent(found.same_orderly, found.orderly),
    )
}

/// "99.12 %", or "-" of nothing.
pub fn percent(part: usize, whole: usize) -> String {
    if whole == 0 {
        return "-".to_owned();
    }
    format!("{:.2} %", 100.0 * part as f64 / whole as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_are_percentages_and_of_nothing_a_dash() {
        let found = Agreement {
            cells: 6,
            same_label: 4,
            ..Agreement::default()
        };
        assert!(agreement(&found).contains("same label 66.67 %"));
        assert!(agreement(&Agreement::default()).contains("same label -"));
    }
}
