//! From the answers to the rig file: each value, how well it is known, and its source.

mod contact;

use std::f64::consts::TAU;

use super::answers::{Answers, Support};
use crate::own_rig::file::RigFile;
use crate::own_rig::reading::{From, OwnReading};
use files::UserError;
use shared::model::params::GRAVITY_M_PER_S2;

/// How well a hand with a stopwatch times one span, s either way.
const HAND_S: f64 = 0.2;
/// How well the gap is known that nobody measured, mm.
const ASSUMED_GAP_MM: f64 = 0.05;
/// What is missing where nothing says how stiff the contact is.
const SURFACE_MISSING: &str = "--surface (or --contact-time with --restitution, or --drop-test)";
/// The damping ratio of beams that nobody measured: the chapter's.
const ASSUMED_DAMPING_RATIO: f64 = 0.004;

/// The file, and what must be said about it.
#[derive(Debug)]
pub struct Described {
    /// The rig file, which may still lack its contact.
    pub file: RigFile,
    /// Notes for a person.
    pub notes: Vec<String>,
    /// The answers that a drop test still has to add the contact to.
    pub contact_open: bool,
}

/// The rig file of `answers`, all of it but the contact of a drop test.
///
/// # Errors
/// An answer is missing, or contradicts another.
pub fn describe(answers: &Answers) -> Result<Described, UserError> {
    let (Some(support), Some(mass), Some(stroke), Some(cart)) = (
        answers.support,
        &answers.mass,
        &answers.stroke,
        &answers.cart_mass,
    ) else {
        return Err(missing(answers));
    };
    let mut described = Described {
        file: RigFile::default(),
        notes: Vec::new(),
        contact_open: answers.drop_test.is_some(),
    };
    described.file.word("support", support.name(), "as given");
    let weighed = ("mass_kg", "mass_percent");
    described.quantity(weighed, mass, 1.0, "weighed", "--mass");
    let hz = described.frequency(answers, support)?;
    described.damping(answers, support);
    let half = ("amplitude_mm", "amplitude_percent");
    described.quantity(half, stroke, 500.0, "half the stroke", "--stroke");
    described.gap(answers, support, hz)?;
    let weighed = ("cart_mass_kg", "cart_mass_percent");
    described.quantity(weighed, cart, 1.0, "weighed", "--cart-mass");
    described.shaker(answers);
    if !described.contact_open {
        // The hammer strikes at some 3.5 times the greatest speed of a cart at twice the natural frequency (pick, the chapter's).
        let speed = 3.5 * 0.5 * stroke.value * 2.0 * TAU * hz;
        described.measured_contact(answers, mass.value, speed)?;
    }
    Ok(described)
}

/// The options without which there is no rig, where they are missing.
fn missing(answers: &Answers) -> UserError {
    let beams = answers.support == Some(Support::Beams);
    let frequency = answers.swings.is_some()
        || answers.natural_frequency.is_some()
        || (!beams && answers.wire_length.is_some());
    let timed = if beams {
        "--swings with --swing-time (or --natural-frequency)"
    } else {
        "--wire-length (or --swings with --swing-time, or --natural-frequency)"
    };
    let contact = answers.drop_test.is_some()
        || answers.surface.is_some()
        || (answers.contact_time.is_some() && answers.restitution.is_some());
    let all = [
        ("--support", answers.support.is_some()),
        ("--mass", answers.mass.is_some()),
        (timed, frequency),
        ("--stroke", answers.stroke.is_some()),
        ("--cart-mass", answers.cart_mass.is_some()),
        (SURFACE_MISSING, contact),
    ];
    let open = all.iter().filter(|(_, there)| !there);
    let open: Vec<_> = open.map(|(option, _)| *option).collect();
    UserError::new(format!(
        "rig new: {} missing; measure and give {} (on a terminal the program asks)",
        open.join(", "),
        if open.len() == 1 { "it" } else { "them" }
    ))
}

/// Hz, as far as the answers give it.
pub fn known_hz(answers: &Answers) -> Option<f64> {
    let swings = answers.swings.zip(answers.swing_time.as_ref());
    let timed = swings.map(|(swings, time)| swung(swings, time).0);
    let given = answers.natural_frequency.as_ref().map(|hz| hz.value);
    let length = answers.wire_length.as_ref();
    given
        .or(timed)
        .or(length.map(|length| of_length(length.value)))
}

/// Hz of wires of `m` metres.
fn of_length(m: f64) -> f64 {
    (GRAVITY_M_PER_S2 / m).sqrt() / TAU
}

/// Refuses a gap that a hammer with this natural frequency does not reach.
///
/// # Errors
/// In words: the gap, and what it is too large for.
pub fn possible_gap(support: Support, hz: f64, gap: &OwnReading) -> Result<(), String> {
    let length = GRAVITY_M_PER_S2 / (TAU * hz).powi(2);
    if support == Support::Beams || gap.value.abs() <= 0.5 * length {
        return Ok(());
    }
    Err(format!(
        "{} is more than half the wires' length ({:.1} mm)",
        gap.text,
        1e3 * length
    ))
}

/// Refuses a natural frequency that this support cannot have, or wires' length with beams.
///
/// # Errors
/// What is given, and what can be.
pub fn check_frequency(answers: &Answers, support: Support) -> Result<(), UserError> {
    if support == Support::Beams && answers.wire_length.is_some() {
        return Err(UserError::new(
            "--wire-length is for wires; time some swings of the beams: --swings with --swing-time",
        ));
    }
    let given = (answers.natural_frequency.as_ref()).map(|hz| (hz.value, hz.text.clone()));
    let timed = answers.swings.zip(answers.swing_time.as_ref());
    let timed = timed.map(|(swings, time)| swung(swings, time));
    for (option, value) in [("--natural-frequency", given), ("--swing-time", timed)] {
        if let Some(value) = value {
            natural_frequency(support, value).map_err(|why| UserError::new(why).at(option))?;
        }
    }
    Ok(())
}

/// Hz, if a hammer on this support can have it.
///
/// # Errors
/// In words: what was given, and what can be.
pub fn natural_frequency(support: Support, (hz, given): (f64, String)) -> Result<f64, String> {
    let (from, to) = match support {
        // 100 m and 1 mm.
        Support::Wires => (0.05, 15.7),
        Support::Beams => (0.01, 1e4),
    };
    if (from..=to).contains(&hz) {
        return Ok(hz);
    }
    let name = support.name();
    Err(format!(
        "{given} are {hz:.4} Hz; a hammer on {name} has from {from} to {to} Hz"
    ))
}

/// The frequency of so many swings, Hz, and how it was measured.
pub fn swung(swings: u32, time: &OwnReading) -> (f64, String) {
    let hz = f64::from(swings) / time.value;
    (hz, format!("{swings} swings in {}", time.text))
}

impl Described {
    /// A value of the file, `factor` times a reading, with its half-width, which is relative.
    fn quantity(
        &mut self,
        (key, width): (&'static str, &'static str),
        reading: &OwnReading,
        factor: f64,
        how: &str,
        option: &str,
    ) {
        let source = format!("{how}: {}", self.read(option, reading));
        self.file.number(key, factor * reading.value, &source);
        self.file
            .width(width, reading.percent(), &reading.from.to_string());
    }

    /// A reading as it was written, with what is doubtful about it, which is also said aloud.
    fn read(&mut self, option: &str, reading: &OwnReading) -> String {
        let text = &reading.text;
        match &reading.doubt {
            None => text.clone(),
            Some(doubt) => {
                self.notes.push(format!("note: {option} {text}: {doubt}"));
                format!("{text} ({doubt})")
            }
        }
    }

    /// Writes the natural frequency, and gives it in Hz.
    fn frequency(&mut self, answers: &Answers, support: Support) -> Result<f64, UserError> {
        let wires = support == Support::Wires;
        if wires {
            self.file.number(
                "gravity_m_per_s2",
                GRAVITY_M_PER_S2,
                "as the chapter has it",
            );
            self.file.word("torque", "literal", "as the chapter has it");
        }
        check_frequency(answers, support)?;
        let known = ("natural_frequency_hz", "natural_frequency_percent");
        if let Some(reading) = &answers.natural_frequency {
            self.quantity(known, reading, 1.0, "given", "--natural-frequency");
            return Ok(reading.value);
        }
        if let Some((swings, time)) = answers.swings.zip(answers.swing_time.as_ref()) {
            let (hz, _) = swung(swings, time);
            let source = format!("{swings} swings in {}", self.read("--swing-time", time));
            self.file.number(known.0, hz, &source);
            let (width, how) = match time.from {
                From::LastDigit => (
                    time.half_width.hypot(HAND_S),
                    format!("one reading by hand: {HAND_S} s either way"),
                ),
                from => (time.half_width, from.to_string()),
            };
            let percent = 100.0 * width / time.value;
            self.file.width(known.1, percent, &how);
            if let Some(length) = &answers.wire_length {
                self.compare(hz, percent, of_length(length.value), 0.5 * length.percent());
            }
            return Ok(hz);
        }
        let Some(length) = answers.wire_length.as_ref() else {
            return Err(missing(answers));
        };
        let source = format!("measured: {}", self.read("--wire-length", length));
        self.file
            .number("wire_length_mm", 1e3 * length.value, &source);
        self.file.width(
            known.1,
            0.5 * length.percent(),
            &format!("half that of the wires' length, {}", length.from),
        );
        Ok(of_length(length.value))
    }

    /// Says so if the length of the wires contradicts the swings.
    fn compare(&mut self, timed_hz: f64, timed_percent: f64, length_hz: f64, length_percent: f64) {
        let apart = 100.0 * (length_hz / timed_hz - 1.0);
        if apart.abs() > timed_percent + length_percent {
            let than = if apart < 0.0 { "less" } else { "more" };
            let apart = apart.abs();
            self.notes.push(format!(
                "note: the wires' length gives {length_hz:.3} Hz, {apart:.1} % {than} than the swings ({timed_hz:.3} Hz). The difference exceeds both errors; the file has the frequency of the swings (measure the length to the hammer's centre of mass)"
            ));
        }
    }

    fn damping(&mut self, answers: &Answers, support: Support) {
        if support == Support::Wires {
            if answers.damping_ratio.is_some() || answers.ring_down.is_some() {
                self.notes.push(
                    "note: the model of wires has no damping; the measured damping is left out"
                        .to_owned(),
                );
            }
            return;
        }
        let (ratio, source) = if let Some(reading) = &answers.damping_ratio {
            let source = format!("given: {}", self.read("--damping-ratio", reading));
            (reading.value, source)
        } else if let Some(swings) = &answers.ring_down {
            (
                of_decrement(swings.decrement),
                format!("ringing down, mm:mm:swings: {}", swings.text),
            )
        } else {
            (
                ASSUMED_DAMPING_RATIO,
                "not measured: the chapter's; it hardly changes the answer".to_owned(),
            )
        };
        self.file.number("damping_ratio", ratio, &source);
    }

    fn gap(&mut self, answers: &Answers, support: Support, hz: f64) -> Result<(), UserError> {
        let (gap, source, how) = match &answers.gap {
            None => (
                OwnReading::assumed(0.0, ASSUMED_GAP_MM / 1e3),
                "not measured: hung so that it just touches".to_owned(),
                "not measured: assumed".to_owned(),
            ),
            Some(gap) => (
                gap.clone(),
                format!("measured: {}", gap.text),
                gap.from.to_string(),
            ),
        };
        possible_gap(support, hz, &gap).map_err(|why| UserError::new(format!("--gap {why}")))?;
        self.file.number("gap_mm", 1e3 * gap.value, &source);
        // A gap written 0 has no unit, and no digit that says how well it is known.
        let width = if gap.value == 0.0 && gap.from == From::LastDigit {
            ASSUMED_GAP_MM
        } else {
            1e3 * gap.half_width
        };
        self.file.width("gap_tolerance_mm", width, &how);
        Ok(())
    }

    fn shaker(&mut self, answers: &Answers) {
        let Some(held) = &answers.shaker_loop else {
            self.notes.push("note: the shaker is not known, so the cart is moved as prescribed; a real one recoils, and the force is smaller (give --shaker-loop, and pick computes it)".to_owned());
            return;
        };
        let known = ("shaker_loop_hz", "shaker_loop_percent");
        self.quantity(known, held, 1.0, "given", "--shaker-loop");
        if let Some(ratio) = &answers.shaker_damping_ratio {
            let source = format!("given: {}", ratio.text);
            self.file
                .number("shaker_damping_ratio", ratio.value, &source);
        }
        match &answers.shaker_force {
            Some(force) => {
                let source = format!("given: {}", self.read("--shaker-force", force));
                self.file.number("shaker_max_force_n", force.value, &source);
            }
            None => self.notes.push(
                "note: the shaker's largest force is not known, so it limits nothing (--shaker-force)"
                    .to_owned(),
            ),
        }
    }
}

/// Damping ratio from the logarithmic decrement per swing.
fn of_decrement(decrement: f64) -> f64 {
    decrement / TAU.hypot(decrement)
}

#[cfg(test)]
mod tests {
    use super::super::answers::ring_down;
    use super::*;

    #[test]
    fn a_ring_down_gives_the_damping_ratio() {
        // exp(−2π ζ n/√(1−ζ²)) with ζ = 0.004, n = 20: 0.60489.
        let decrement = ring_down("5:3.02445:20").unwrap().decrement;
        assert!((of_decrement(decrement) / 0.004 - 1.0).abs() < 1e-4);
        for bad in [
            "5:5:20", "3:5:20", "5:3", "5:0:20", "a:b:c", "5:3:0", "5:3:20:x",
        ] {
            assert!(ring_down(bad).is_err(), "{bad}");
        }
    }
}
