//! From the answers to the rig file: each value, how well it is known, and its source.

mod contact;

use std::f64::consts::TAU;

use super::answers::{Answers, Support};
use crate::own_rig::file::RigFile;
use crate::own_rig::reading::{From, Reading, read};
use files::UserError;
use shared::model::params::GRAVITY_M_PER_S2;

/// How well a hand with a stopwatch times one span, s either way.
const HAND_S: f64 = 0.2;
/// How well the gap is known that nobody measured, mm.
const ASSUMED_GAP_MM: f64 = 0.05;
/// The damping ratio of beams that nobody measured: the chapter's.
const ASSUMED_DAMPING_RATIO: f64 = 0.004;

/// The file, and what must be said about it.
#[derive(Debug)]
pub struct Described {
    /// The file.
    pub file: RigFile,
    /// Notes for a person.
    pub notes: Vec<String>,
    /// The answers that a drop test still has to add the contact to.
    pub contact_open: bool,
}

/// The rig file of `answers`, all of it but the contact of a drop test.
///
/// # Errors
/// An answer is missing, or cannot be used.
pub fn describe(answers: &Answers) -> Result<Described, UserError> {
    let missing = missing(answers);
    if !missing.is_empty() {
        return Err(UserError::new(format!(
            "rig new: {} missing; measure and give {} (on a terminal the program asks)",
            missing.join(", "),
            if missing.len() == 1 { "it" } else { "them" }
        )));
    }
    let mut described = Described {
        file: RigFile::default(),
        notes: Vec::new(),
        contact_open: answers.drop_test.is_some(),
    };
    let support = answers.support.unwrap_or(Support::Wires);
    described.file.word("support", support.name(), "as given");
    let mass = needed("--mass-g", answers.mass_g.as_deref())?;
    described.quantity(
        "mass_kg",
        mass.value / 1e3,
        "mass_percent",
        &mass,
        "weighed",
        "g",
    );
    described.frequency(answers, support)?;
    described.damping(answers, support)?;
    let stroke = needed("--stroke-mm", answers.stroke_mm.as_deref())?;
    described.quantity(
        "amplitude_mm",
        stroke.value / 2.0,
        "amplitude_percent",
        &stroke,
        "half the stroke",
        "mm",
    );
    described.gap(answers)?;
    let cart = needed("--cart-mass-kg", answers.cart_mass_kg.as_deref())?;
    described.quantity(
        "cart_mass_kg",
        cart.value,
        "cart_mass_percent",
        &cart,
        "weighed",
        "kg",
    );
    described.shaker(answers)?;
    if !described.contact_open {
        described.measured_contact(answers, mass.value / 1e3)?;
    }
    Ok(described)
}

/// The options without which there is no rig, where they are missing.
fn missing(answers: &Answers) -> Vec<&'static str> {
    let frequency = match answers.support {
        Some(Support::Beams) => answers.swings.is_some() || answers.natural_frequency_hz.is_some(),
        _ => {
            answers.swings.is_some()
                || answers.natural_frequency_hz.is_some()
                || answers.wire_length_mm.is_some()
        }
    };
    let timed = match answers.support {
        Some(Support::Beams) => "--swings with --swing-time-s",
        _ => "--wire-length-mm or --swings with --swing-time-s",
    };
    let all = [
        ("--support", answers.support.is_some()),
        ("--mass-g", answers.mass_g.is_some()),
        (timed, frequency),
        ("--stroke-mm", answers.stroke_mm.is_some()),
        ("--cart-mass-kg", answers.cart_mass_kg.is_some()),
    ];
    let open = all.iter().filter(|(_, there)| !there);
    open.map(|(option, _)| *option).collect()
}

/// The positive reading of an option.
fn needed(option: &str, text: Option<&str>) -> Result<Reading, UserError> {
    let text = text.unwrap_or_default();
    let reading = read(text).map_err(|why| UserError::new(format!("{option} {text}: {why}")))?;
    if reading.value <= 0.0 {
        return Err(UserError::new(format!(
            "{option} is {}, must be a positive number",
            reading.value
        )));
    }
    Ok(reading)
}

impl Described {
    /// A value of the file with its half-width, which is relative.
    fn quantity(
        &mut self,
        key: &'static str,
        value: f64,
        width: &'static str,
        reading: &Reading,
        how: &str,
        unit: &str,
    ) {
        let source = format!("{how}: {} {unit}", reading.text);
        self.file.number(key, value, &source);
        self.file
            .width(width, reading.percent(), &reading.from.to_string());
    }

    fn frequency(&mut self, answers: &Answers, support: Support) -> Result<(), UserError> {
        let given = |option, text: &Option<String>| {
            text.as_deref()
                .map(|text| needed(option, Some(text)))
                .transpose()
        };
        let known = given("--natural-frequency-hz", &answers.natural_frequency_hz)?;
        let length = given("--wire-length-mm", &answers.wire_length_mm)?;
        if support == Support::Wires {
            self.file.number(
                "gravity_m_per_s2",
                GRAVITY_M_PER_S2,
                "as the chapter has it",
            );
            self.file.word("torque", "literal", "as the chapter has it");
        } else if length.is_some() {
            return Err(UserError::new(
                "--wire-length-mm is for wires; time some swings of the beams: --swings with --swing-time-s",
            ));
        }
        if let Some(reading) = known {
            self.quantity(
                "natural_frequency_hz",
                reading.value,
                "natural_frequency_percent",
                &reading,
                "given",
                "Hz",
            );
            return Ok(());
        }
        let of_length = |mm: f64| (GRAVITY_M_PER_S2 / (mm / 1e3)).sqrt() / TAU;
        if let Some((swings, time)) = timed(answers)? {
            let hz = f64::from(swings) / time.value;
            let source = format!("{swings} swings in {} s", time.text);
            self.file.number("natural_frequency_hz", hz, &source);
            let how = match time.from {
                From::LastDigit => format!("one reading by hand: {HAND_S} s either way"),
                from => from.to_string(),
            };
            self.file
                .width("natural_frequency_percent", time.percent(), &how);
            if let Some(length) = &length {
                self.compare(
                    hz,
                    time.percent(),
                    of_length(length.value),
                    0.5 * length.percent(),
                );
            }
            return Ok(());
        }
        let length = length.ok_or_else(|| UserError::new("rig new: no length and no swings"))?;
        self.file.number(
            "wire_length_mm",
            length.value,
            &format!("measured: {} mm", length.text),
        );
        self.file.width(
            "natural_frequency_percent",
            0.5 * length.percent(),
            &format!("half that of the wires' length, {}", length.from),
        );
        Ok(())
    }

    /// Says so if the length of the wires contradicts the swings.
    fn compare(&mut self, timed_hz: f64, timed_percent: f64, length_hz: f64, length_percent: f64) {
        let apart = 100.0 * (length_hz / timed_hz - 1.0);
        if apart.abs() > timed_percent + length_percent {
            self.notes.push(format!(
                "note: the wires' length gives {length_hz:.3} Hz, {apart:+.1} % of what the swings give ({timed_hz:.3} Hz), more than both can be wrong; the swings decide (a hammer is longer than a point, and a length is measured to its centre of mass)"
            ));
        }
    }

    fn damping(&mut self, answers: &Answers, support: Support) -> Result<(), UserError> {
        let given = [
            &answers.damping_ratio,
            &answers.decrement,
            &answers.ring_down,
        ];
        if support == Support::Wires {
            if given.iter().any(|answer| answer.is_some()) {
                self.notes.push(
                    "note: the model of wires has no damping; what was measured of it is left out"
                        .to_owned(),
                );
            }
            return Ok(());
        }
        let (ratio, source) = if let Some(text) = &answers.damping_ratio {
            let reading = needed("--damping-ratio", Some(text))?;
            (reading.value, format!("given: {}", reading.text))
        } else if let Some(text) = &answers.decrement {
            let reading = needed("--decrement", Some(text))?;
            (
                of_decrement(reading.value),
                format!("logarithmic decrement {}", reading.text),
            )
        } else if let Some(text) = &answers.ring_down {
            (
                of_decrement(ring_down(text)?),
                format!("ringing down, mm:mm:swings: {text}"),
            )
        } else {
            (
                ASSUMED_DAMPING_RATIO,
                "not measured: the chapter's; it hardly moves the answer".to_owned(),
            )
        };
        self.file.number("damping_ratio", ratio, &source);
        Ok(())
    }

    fn gap(&mut self, answers: &Answers) -> Result<(), UserError> {
        let (gap, source) = match &answers.gap_mm {
            None => (
                Reading::assumed(0.0, ASSUMED_GAP_MM),
                "not measured: hung so that it just touches".to_owned(),
            ),
            Some(text) => {
                let gap =
                    read(text).map_err(|why| UserError::new(format!("--gap-mm {text}: {why}")))?;
                let source = format!("measured: {} mm", gap.text);
                (gap, source)
            }
        };
        self.file.number("gap_mm", gap.value, &source);
        let how = match answers.gap_mm {
            None => "not measured: assumed".to_owned(),
            Some(_) => gap.from.to_string(),
        };
        self.file.width("gap_tolerance_mm", gap.half_width, &how);
        Ok(())
    }

    fn shaker(&mut self, answers: &Answers) -> Result<(), UserError> {
        let Some(text) = &answers.shaker_loop_hz else {
            self.notes.push("note: the shaker is not known, so the cart is moved as prescribed; a real one recoils, and the hammer strikes less hard (give --shaker-loop-hz, and pick says how much)".to_owned());
            return Ok(());
        };
        let held = needed("--shaker-loop-hz", Some(text))?;
        self.quantity(
            "shaker_loop_hz",
            held.value,
            "shaker_loop_percent",
            &held,
            "given",
            "Hz",
        );
        if let Some(ratio) = answers.shaker_damping_ratio {
            self.file.number("shaker_damping_ratio", ratio, "given");
        }
        Ok(())
    }
}

/// The swings timed, and their time; a single reading has the hand's uncertainty.
fn timed(answers: &Answers) -> Result<Option<(u32, Reading)>, UserError> {
    let Some(swings) = answers.swings else {
        return Ok(None);
    };
    if swings == 0 {
        return Err(UserError::new(
            "--swings is 0, must be at least 1; 20 or more are well timed by hand",
        ));
    }
    let mut time = needed("--swing-time-s", answers.swing_time_s.as_deref())?;
    if time.from == From::LastDigit {
        time.half_width = time.half_width.hypot(HAND_S);
    }
    Ok(Some((swings, time)))
}

/// Damping ratio from the logarithmic decrement per swing.
fn of_decrement(decrement: f64) -> f64 {
    decrement / TAU.hypot(decrement)
}

/// Decrement from FROM:TO:SWINGS.
fn ring_down(text: &str) -> Result<f64, UserError> {
    let parts: Vec<_> = text
        .split(':')
        .map(|part| part.trim().parse::<f64>())
        .collect();
    match parts.as_slice() {
        [Ok(from), Ok(to), Ok(swings)]
            if *to > 0.0
                && from > to
                && *swings >= 1.0
                && from.is_finite()
                && swings.is_finite() =>
        {
            Ok((from / to).ln() / swings)
        }
        _ => Err(UserError::new(format!(
            "--ring-down {text}: write FROM:TO:SWINGS, the swing in mm at first, a smaller one at last, and full swings between: 5:3.1:20"
        ))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ring_down_gives_the_damping_ratio() {
        // exp(−2π ζ n/√(1−ζ²)) with ζ = 0.004, n = 20: 0.60489.
        let decrement = ring_down("5:3.02445:20").unwrap();
        assert!((of_decrement(decrement) / 0.004 - 1.0).abs() < 1e-4);
        for bad in ["5:5:20", "3:5:20", "5:3", "5:0:20", "a:b:c", "5:3:0"] {
            assert!(ring_down(bad).is_err(), "{bad}");
        }
    }
}
