//! How the operating point moves over a parameter: a row for each value, and the sentence that sums them up.

use files::UserError;
use files::words::digits::{decimals, significant};
use numerics::CartModel;
use numerics::Error;
use numerics::NamedRig;
use numerics::pick::PickAnswer;
use numerics::row::tidy;
use serde::{Deserialize, Serialize};

/// One value of the parameter. Units are in the names; what a value without a pick lacks is empty.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct OverRow {
    /// The parameter, as rig files name it.
    pub parameter: String,
    /// Its value, in the unit of its name.
    pub value: f64,
    /// Name of the rig, without the parameter.
    pub rig: String,
    /// Clearance at rest, mm.
    pub gap_mm: f64,
    /// The frequency to run at, Hz.
    pub operating_frequency_hz: Option<f64>,
    /// The frequency to run at over the natural frequency, Ω/ω.
    pub frequency_ratio: Option<f64>,
    /// Contact force over m g there.
    pub force_ratio: Option<f64>,
    /// Contact force there, N.
    pub force_n: Option<f64>,
    /// The least over the uncertainty.
    pub force_ratio_worst: Option<f64>,
    /// The largest over the uncertainty.
    pub force_ratio_largest: Option<f64>,
    /// The safe band, Hz: 1/1 stable over the uncertainty, force above 90 %, limits kept.
    pub safe_band_low_hz: Option<f64>,
    /// Its upper end, Hz.
    pub safe_band_high_hz: Option<f64>,
    /// Where the nominal 1/1 is stable, Hz.
    pub stable_low_hz: Option<f64>,
    /// Its upper end, Hz.
    pub stable_high_hz: Option<f64>,
    /// Where the period doubles, Hz.
    pub period_doubling_hz: Option<f64>,
    /// Largest modulus of a multiplier at the operating point.
    pub multiplier: Option<f64>,
    /// Whether the hammer jumps: up and down sweeps across the stable 1/1 differ, or the stable 1/1 ends in a fold.
    pub jumps: Option<bool>,
    /// The regime a run from rest settles on at the operating frequency.
    pub from_rest: Option<String>,
    /// Which cart the answer is for: `recoil` or `prescribed`.
    pub cart: Option<String>,
    /// The cart's amplitude, mm: less than the rig's where the shaker's limits ask for it.
    pub amplitude_mm: Option<f64>,
    /// Energy that the contacts take from the hammer, W.
    pub impact_power_w: Option<f64>,
    /// Largest force of the shaker's position loop, N.
    pub loop_force_n: Option<f64>,
    /// The limits that decide the frequency; none if the force alone does.
    pub decided_by: Option<String>,
    /// Why there is no pick.
    pub no_pick: Option<String>,
}

impl OverRow {
    /// The row of `value` of `parameter`, with which `rig` gives `found`.
    pub fn new(
        (parameter, value): (&str, f64),
        (name, rig): (&str, &NamedRig),
        found: Result<&PickAnswer, &Error>,
    ) -> Self {
        let a = found.ok();
        let deciding = |a: &PickAnswer| {
            let names = a.limits.iter().filter(|l| l.binds).map(|l| l.name);
            names.collect::<Vec<_>>().join(" and ")
        };
        Self {
            parameter: parameter.to_owned(),
            value,
            rig: name.to_owned(),
            gap_mm: tidy(rig.params.gap_m * 1e3),
            operating_frequency_hz: a.map(|a| a.operating_frequency_hz),
            frequency_ratio: a.map(|a| a.frequency_ratio),
            force_ratio: a.map(|a| a.force_ratio),
            force_n: a.map(|a| a.force_n),
            force_ratio_worst: a.map(|a| a.force_ratio_worst),
            force_ratio_largest: a.map(|a| a.force_ratio_largest),
            safe_band_low_hz: a.map(|a| a.safe_band_hz[0]),
            safe_band_high_hz: a.map(|a| a.safe_band_hz[1]),
            stable_low_hz: a.map(|a| a.stable_one_one_hz[0]),
            stable_high_hz: a.map(|a| a.stable_one_one_hz[1]),
            period_doubling_hz: a.and_then(|a| a.period_doubling_hz),
            multiplier: a.map(|a| a.multipliers),
            jumps: a.map(|a| !a.jump_free),
            from_rest: a.map(|a| a.regime_from_rest.to_string()),
            cart: a.map(|a| cart(a.cart).to_owned()),
            amplitude_mm: a.map(|a| a.amplitude_mm),
            impact_power_w: a.map(|a| a.impact_power_w),
            loop_force_n: a.and_then(|a| a.shaker.loop_force_n),
            decided_by: a.map(deciding).filter(|names| !names.is_empty()),
            no_pick: found
                .err()
                .map(|error| UserError::from(error.clone()).to_string()),
        }
    }
}

fn cart(cart: CartModel) -> &'static str {
    match cart {
        CartModel::Recoil => "recoil",
        CartModel::Prescribed => "prescribed",
    }
}

/// The least and the largest of what the rows have; none if none has any.
fn ends(rows: &[OverRow], value: impl Fn(&OverRow) -> Option<f64>) -> Option<(f64, f64)> {
    let values: Vec<f64> = rows.iter().filter_map(value).collect();
    let low = values.iter().copied().reduce(f64::min)?;
    Some((low, values.iter().copied().reduce(f64::max)?))
}

/// Values that differ by less than this share are said to stay.
const STAYS: f64 = 1e-3;

/// Where a quantity goes over the rows, by rising value of the parameter: what it has at the first and at the last of them
/// and in percent which way it went, or between what it lies if it turns on the way. None if no row has it.
fn course(
    rows: &[&OverRow],
    unit: &str,
    [higher, lower]: [&str; 2],
    value: impl Fn(&OverRow) -> Option<f64>,
) -> Option<String> {
    let known = rows.iter().filter_map(|r| Some((r.value, value(r)?)));
    let known: Vec<(f64, f64)> = known.collect();
    let less = |a: &&(f64, f64), b: &&(f64, f64)| a.1.total_cmp(&b.1);
    let (least, most) = (known.iter().min_by(less)?, known.iter().max_by(less)?);
    let (first, last) = (known.first()?.1, known.last()?.1);
    let hair = STAYS * most.1.abs();
    let digits = decimals(0.1 * (most.1 - least.1).max(0.01 * most.1), 4);
    let shown = |x: f64| format!("{x:.digits$}");
    if known.len() == 1 {
        return Some(format!("is {}{unit}", shown(first)));
    }
    if most.1 - least.1 <= hair {
        return Some(format!("stays at {}{unit}", shown(first)));
    }
    // Held against the farthest so far: many small steps back are a way back.
    let sign = (last - first).signum();
    let mut farthest = f64::NEG_INFINITY;
    let one_way = known.iter().all(|(_, y)| {
        farthest = farthest.max(sign * y);
        sign * y >= farthest - hair
    });
    let percent = 100.0 * (last / first - 1.0);
    let places = if percent.abs() < 9.95 { 1 } else { 0 };
    let change = |which| format!("({:.places$} % {which})", percent.abs());
    let (from, to) = (shown(first), shown(last));
    Some(if one_way && sign > 0.0 {
        format!("rises from {from} to {to}{unit} {}", change(higher))
    } else if one_way {
        format!("falls from {from} to {to}{unit} {}", change(lower))
    } else {
        format!(
            "turns on the way: it lies between {}{unit} (at {}) and {}{unit} (at {}), and goes from {from} to {to}{unit}",
            shown(least.1),
            significant(least.0, 4),
            shown(most.1),
            significant(most.0, 4)
        )
    })
}

/// Rig, gap and cart of the rows, as a heading has them.
pub fn of_rig(rows: &[OverRow]) -> String {
    let Some(first) = rows.first() else {
        return String::new();
    };
    let gap = match first.parameter.as_str() {
        "gap_mm" => String::new(),
        _ => format!(", gap {:?} mm", first.gap_mm),
    };
    let cart = rows.iter().find_map(|row| row.cart.as_deref());
    let cart = match cart {
        Some("recoil") => ", cart recoils",
        Some(_) => ", cart prescribed",
        None => "",
    };
    format!("{}{gap}{cart}", first.rig)
}

/// What `rows` say together: where frequency and force go from the least value of the parameter to the largest.
pub fn summary(rows: &[OverRow]) -> String {
    let Some(first) = rows.first() else {
        return String::new();
    };
    let mut rising: Vec<&OverRow> = rows.iter().collect();
    rising.sort_by(|a, b| a.value.total_cmp(&b.value));
    let picked = ends(rows, |r| r.no_pick.is_none().then_some(r.value));
    let whole = ends(rows, |r| Some(r.value));
    let (from, to) = picked.or(whole).unwrap_or((first.value, first.value));
    let over = match from == to {
        true => format!("{} = {}", first.parameter, significant(from, 4)),
        false => format!(
            "{} from {} to {}",
            first.parameter,
            significant(from, 4),
            significant(to, 4)
        ),
    };
    let force = ["more", "less"];
    let found = (
        course(&rising, " Hz", ["higher", "lower"], |r| {
            r.operating_frequency_hz
        }),
        course(&rising, " N", force, |r| r.force_n),
        course(&rising, "", force, |r| r.force_ratio),
    );
    let (Some(hz), Some(newtons), Some(ratio)) = found else {
        return format!("With {over} there is no frequency to run at.");
    };
    let missing = rows.iter().filter(|r| r.no_pick.is_some()).count();
    let missing = match missing {
        0 => String::new(),
        n => format!(" {n} of {} values have no frequency to run at.", rows.len()),
    };
    format!(
        "With {over} the frequency to run at {hz}. The force {newtons}; as a multiple of the weight it {ratio}.{missing} {}",
        common_band(rows)
    )
}

/// The frequencies that are safe at every value.
fn common_band(rows: &[OverRow]) -> String {
    let low = ends(rows, |r| r.safe_band_low_hz).map(|(_, most)| most);
    let high = ends(rows, |r| r.safe_band_high_hz).map(|(least, _)| least);
    match low.zip(high) {
        Some((low, high)) if low < high => {
            let (up, down) = ((low * 1e3).ceil() / 1e3, (high * 1e3).floor() / 1e3);
            format!("{up:.3} to {down:.3} Hz lies in the safe band of every pick.")
        }
        _ => "No frequency lies in the safe band of every pick.".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use numerics::PickLimits;
    use numerics::pick::pick;
    use shared::model::params::{RigParams, WIRES};

    fn row(value: f64, amplitude_m: f64, gap_m: f64) -> OverRow {
        let params = RigParams {
            amplitude_m,
            gap_m,
            ..WIRES
        };
        let rig = NamedRig::new("wires", params);
        let found = pick(&rig, None, PickLimits::default(), &());
        let found = found.as_ref().map(|pick| &pick.answer);
        OverRow::new(("amplitude_mm", value), ("wires", &rig), found)
    }

    /// A row with these numbers and nothing else of its own.
    fn told(value: f64, (hz, force_n, force_ratio): (f64, f64, f64)) -> OverRow {
        OverRow {
            value,
            parameter: "mass_kg".to_owned(),
            operating_frequency_hz: Some(hz),
            force_n: Some(force_n),
            force_ratio: Some(force_ratio),
            ..row(value, 0.5e-3, 0.0)
        }
    }

    #[test]
    fn the_sentence_says_which_way_each_quantity_goes() {
        // Frequency falls, newtons rise, over the weight it falls; the order given does not matter.
        let heavier = [
            told(0.4, (3.6710, 93.1, 23.8)),
            told(0.2, (3.6863, 83.2, 42.4)),
        ];
        // In steps so small that each by itself would be called no change.
        let slow: Vec<_> = (0..9)
            .map(|k| f64::from(k) / 8.0)
            .map(|x| told(0.2 + 0.2 * x, (3.6863 - 0.0153 * x, 83.2, 42.4)))
            .collect();
        let text = summary(&slow);
        assert!(
            text.contains("falls from 3.686 to 3.671 Hz (0.4 % lower)"),
            "{text}"
        );
        let turns = [
            told(0.2, (3.0, 80.0, 20.0)),
            told(0.3, (3.0, 120.0, 20.001)),
            told(0.4, (3.0, 100.0, 20.0)),
        ];
        for (rows, parts) in [
            (
                &heavier[..],
                &[
                    "mass_kg from 0.2000 to 0.4000",
                    "falls from 3.686 to 3.671 Hz (0.4 % lower)",
                    "The force rises from 83.2 to 93.1 N (12 % more)",
                    "as a multiple of the weight it falls from 42 to 24 (44 % less)",
                ][..],
            ),
            (
                &turns,
                &[
                    "the frequency to run at stays at 3.000 Hz.",
                    "lies between 80 N (at 0.2000) and 120 N (at 0.3000), and goes from 80 to 100 N",
                    "as a multiple of the weight it stays at 20.00.",
                ],
            ),
            (
                &turns[..1],
                &["mass_kg = 0.2000", "is 3.000 Hz", "is 80.00 N"],
            ),
        ] {
            let text = summary(rows);
            for part in parts {
                assert!(text.contains(part), "{part}: {text}");
            }
        }
    }

    #[test]
    fn the_sentence_is_made_of_the_rows() {
        // At a gap of 0 the force is proportional to the amplitude, and the frequency does not depend on it.
        let rows = [row(0.5, 0.5e-3, 0.0), row(1.0, 1e-3, 0.0)];
        let ratio = rows[1].force_ratio.unwrap() / rows[0].force_ratio.unwrap();
        assert!((ratio - 2.0).abs() < 0.01, "{ratio}");
        let text = summary(&rows);
        assert!(text.contains("amplitude_mm from 0.5000 to 1.000"), "{text}");
        assert!(text.contains("(100 % more)"), "{text}");
        assert!(text.contains("stays at"), "{text}");
        assert!(text.contains("in the safe band of every pick"), "{text}");
        let none = row(0.01, 1e-5, 2e-3);
        assert!(none.no_pick.as_ref().unwrap().contains("no stable 1/1"));
        assert_eq!((none.force_ratio, none.gap_mm), (None, 2.0));
        let text = summary(&[rows[0].clone(), none.clone()]);
        assert!(text.contains("1 of 2 values have no frequency"), "{text}");
        assert!(summary(&[none]).contains("no frequency to run at"));
        assert_eq!(summary(&[]), "");
    }
}
