//! Values that can be, and are probably in another unit.

use shared::model::contact::Law;
use shared::model::params::{RigParams, SupportParams};

/// A hammer heavier than this, kg, was probably weighed in grams.
const HEAVY_HAMMER_KG: f64 = 50.0;
/// A cart heavier than this, kg, was probably weighed in grams.
const HEAVY_CART_KG: f64 = 2_000.0;
/// An amplitude smaller than this, mm, was probably measured in metres.
const SMALL_AMPLITUDE_MM: f64 = 0.01;
/// A wire shorter than this, mm, was probably measured in metres.
const SHORT_WIRE_MM: f64 = 2.0;
/// A gap narrower than this, mm, but not 0, was probably measured in metres.
const NARROW_GAP_MM: f64 = 5e-3;
/// A contact softer than this, N/m, was probably measured in N/mm. Rubber has 1.3e4, the steel of Table 3.1 5.5e3 N/mm.
const SOFT_CONTACT_N_PER_M: f64 = 6e3;
/// Beams damped more than this were probably given in percent.
const DAMPED: f64 = 0.2;

/// A line for each value of `params` that looks like one in another unit: what it says, and what was probably meant.
pub fn doubts(params: &RigParams) -> Vec<String> {
    let mut lines = Vec::new();
    let mut doubt = |doubtful: bool, key: &str, value: f64, read: &str, unit: &str, factor: f64| {
        if doubtful {
            let meant = tidy(value * factor);
            lines.push(format!(
                "warning: {key} = {value} means {value} {read}; if it was measured in {unit}, write {key} = {meant}"
            ));
        }
    };
    let mass = params.mass_kg;
    doubt(mass > HEAVY_HAMMER_KG, "mass_kg", mass, "kg", "grams", 1e-3);
    let cart = params.cart_mass_kg;
    doubt(
        cart > HEAVY_CART_KG,
        "cart_mass_kg",
        cart,
        "kg",
        "grams",
        1e-3,
    );
    let amplitude = tidy(params.amplitude_m * 1e3);
    let small = amplitude < SMALL_AMPLITUDE_MM;
    doubt(small, "amplitude_mm", amplitude, "mm", "metres", 1e3);
    let gap = tidy(params.gap_m * 1e3);
    let narrow = gap != 0.0 && gap.abs() < NARROW_GAP_MM;
    doubt(narrow, "gap_mm", gap, "mm", "metres", 1e3);
    match params.support {
        SupportParams::Wires { length_m, .. } => {
            let length = tidy(length_m * 1e3);
            let short = length < SHORT_WIRE_MM;
            doubt(short, "wire_length_mm", length, "mm", "metres", 1e3);
        }
        SupportParams::Beams { damping_ratio, .. } => {
            let damped = damping_ratio > DAMPED;
            doubt(
                damped,
                "damping_ratio",
                damping_ratio,
                "of critical",
                "percent",
                1e-2,
            );
        }
    }
    if let Law::SpringDashpot { stiffness, .. } = params.contact {
        let soft = stiffness < SOFT_CONTACT_N_PER_M;
        doubt(
            soft,
            "contact_stiffness_n_per_m",
            stiffness,
            "N/m",
            "N/mm",
            1e3,
        );
    }
    lines
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
