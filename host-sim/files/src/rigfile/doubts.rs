//! Values that can be, and are probably in another unit.

use numerics::knob::Knob;
use shared::model::contact::LawKind;
use shared::model::params::RigParams;

/// A parameter, which of its values are doubtful, what such a value reads as, and the unit that was probably meant, with its factor.
type Doubt = (
    &'static str,
    fn(f64) -> bool,
    &'static str,
    &'static str,
    f64,
);

/// Of contacts, rubber has 1.3e4 N/m, the steel of Table 3.1 5.5e3 N/mm.
const DOUBTS: [Doubt; 7] = [
    ("mass_kg", |kg| kg > 50.0, "kg", "grams", 1e-3),
    ("cart_mass_kg", |kg| kg > 2_000.0, "kg", "grams", 1e-3),
    ("amplitude_mm", |mm| mm < 0.01, "mm", "metres", 1e3),
    (
        "gap_mm",
        |mm| mm != 0.0 && mm.abs() < 5e-3,
        "mm",
        "metres",
        1e3,
    ),
    ("wire_length_mm", |mm| mm < 2.0, "mm", "metres", 1e3),
    ("damping_ratio", |c| c > 0.2, "of critical", "percent", 1e-2),
    (STIFFNESS, |k| k < 6e3, "N/m", "N/mm", 1e3),
];

/// Doubted with a spring-dashpot only: the laws with an exponent give it another unit.
const STIFFNESS: &str = "contact_stiffness_n_per_m";

/// A line for each value of `params` that looks like one in another unit: what it says, and what was probably meant.
pub fn doubts(params: &RigParams) -> Vec<String> {
    let linear = params.contact.kind() == LawKind::SpringDashpot;
    let line = |(key, doubtful, read, unit, factor): Doubt| {
        let value = Knob::named(key)?.of(params)?;
        let value = if read == "mm" { tidy(value) } else { value };
        (doubtful(value) && (linear || key != STIFFNESS)).then(|| {
            let meant = tidy(value * factor);
            format!(
                "warning: {key} = {value} means {value} {read}; if it was measured in {unit}, write {key} = {meant}"
            )
        })
    };
    DOUBTS.into_iter().filter_map(line).collect()
}

/// Nine digits: without the last ones of a multiplication.
fn tidy(value: f64) -> f64 {
    format!("{value:.9e}").parse().unwrap_or(value)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rigfile::load;
    use shared::model::params::PRESETS;

    #[test]
    fn the_presets_raise_no_doubt() {
        for (name, params) in PRESETS {
            assert_eq!(doubts(&params), Vec::<String>::new(), "{name}");
        }
    }

    #[test]
    fn a_value_in_another_unit_is_named_with_what_was_meant() {
        for (set, meant) in [
            (
                "mass_kg=298",
                "if it was measured in grams, write mass_kg = 0.298",
            ),
            ("cart_mass_kg=5380", "write cart_mass_kg = 5.38"),
            ("amplitude_mm=0.00089", "write amplitude_mm = 0.89"),
            ("wire_length_mm=0.75", "write wire_length_mm = 750"),
            ("gap_mm=0.0024", "write gap_mm = 2.4"),
            (
                "contact_stiffness_n_per_m=5500",
                "write contact_stiffness_n_per_m = 5500000",
            ),
        ] {
            let rig = load("wires", &[set.to_owned()]).unwrap();
            let lines = doubts(&rig.params);
            assert_eq!(lines.len(), 1, "{set}: {lines:?}");
            assert!(lines[0].contains(meant), "{set}: {lines:?}");
        }
        // Soft rubber is none.
        let rig = load("wires", &["contact_stiffness_n_per_m=1.3e4".to_owned()]).unwrap();
        assert_eq!(doubts(&rig.params), Vec::<String>::new());
        let rig = load("beam-170", &["damping_ratio=0.4".to_owned()]).unwrap();
        assert!(doubts(&rig.params)[0].contains("write damping_ratio = 0.004"));
    }
}
