//! Why this frequency, in one sentence.

use super::digits::{Digits, significant};
use numerics::CartModel;
use numerics::pick::Answer;
use serde::Serialize;

/// An answer with its sentence, as JSON has it.
#[derive(Serialize)]
pub struct Worded<'a> {
    #[serde(flatten)]
    answer: &'a Answer,
    why: String,
}

impl<'a> From<&'a Answer> for Worded<'a> {
    fn from(answer: &'a Answer) -> Self {
        Self {
            answer,
            why: why(answer),
        }
    }
}

/// Where jumps between the frequencies `low_hz` and `high_hz` are, in words.
pub fn jumping_at(low_hz: f64, high_hz: f64) -> String {
    if high_hz - low_hz < 5e-4 {
        format!("at {high_hz:.3} Hz")
    } else {
        format!("between {low_hz:.3} and {high_hz:.3} Hz")
    }
}

/// The strongest nominal 1/1 with the cart moved the other way, and with the answer's own cart under the same limits.
pub struct OtherCart {
    /// How it is moved.
    pub what: &'static str,
    /// Contact force over m g.
    pub force_ratio: f64,
    /// Its frequency, Hz.
    pub hz: f64,
    /// Contact force over m g with the answer's cart.
    pub own_force_ratio: f64,
    /// Its frequency, Hz.
    pub own_hz: f64,
}

/// What the other cart would give; none where it is not known.
pub fn other_cart(answer: &Answer) -> Option<OtherCart> {
    let recoil = answer.recoil_force_ratio.zip(answer.recoil_frequency_hz);
    let prescribed = answer
        .prescribed_force_ratio
        .zip(answer.prescribed_frequency_hz);
    let (what, other, own) = match answer.cart {
        CartModel::Recoil => ("with a prescribed cart", prescribed, recoil),
        CartModel::Prescribed => ("with a recoiling cart", recoil, prescribed),
    };
    let ((force_ratio, hz), (own_force_ratio, own_hz)) = other.zip(own)?;
    Some(OtherCart {
        what,
        force_ratio,
        hz,
        own_force_ratio,
        own_hz,
    })
}

/// Why this frequency, in one sentence.
pub fn why(answer: &Answer) -> String {
    let digits = Digits::of(answer);
    let end = match answer.period_doubling_hz {
        Some(hz) => format!(
            "the period doubles only at {} Hz, {:.0} % higher",
            digits.hz(hz),
            100.0 * (hz / answer.operating_frequency_hz - 1.0)
        ),
        None => format!(
            "the stable 1/1 ends at {} Hz",
            digits.hz(answer.stable_one_one_hz[1])
        ),
    };
    format!(
        "{}: {:.*} times the hammer's weight, {:.1} times the force at the natural frequency; {end}, {}{}.",
        strongest_of(answer),
        digits.force_ratio,
        answer.force_ratio,
        answer.force_ratio / answer.force_ratio_at_natural_frequency,
        jumps(answer),
        from_rest(answer)
    )
}

fn strongest_of(answer: &Answer) -> String {
    let binding = answer.limits.iter().filter(|l| l.binds).map(|l| l.name);
    let binding: Vec<_> = binding.collect();
    if answer.amplitude_lowered && answer.wanted_force_n.is_none() {
        return format!(
            "The shaker's force limits the stroke to {} mm; at this stroke it is the strongest stable 1/1 that is allowed",
            significant(answer.shaker.stroke_mm, 3)
        );
    }
    match (binding.as_slice(), &answer.uncertainty) {
        ([], None) => "It is the strongest stable 1/1 of the nominal rig".to_owned(),
        ([], Some(_)) => {
            "It is the strongest stable 1/1, and 1/1 stays stable over the whole uncertainty"
                .to_owned()
        }
        (names, _) => format!(
            "It is the strongest stable 1/1 that {} {} ({:.*} times the weight at {} Hz for the nominal rig without any limit)",
            names.join(" and "),
            if names.len() == 1 { "allows" } else { "allow" },
            Digits::of(answer).force_ratio,
            answer.nominal_optimum_force_ratio,
            Digits::of(answer).hz(answer.nominal_optimum_hz)
        ),
    }
}

fn jumps(answer: &Answer) -> String {
    let Some([low, high]) = answer.jump_range_hz else {
        return "and nothing jumps".to_owned();
    };
    let place = if answer.jump_free_in_safe_band {
        "though not"
    } else {
        "also"
    };
    format!(
        "but the hammer jumps {}, {place} inside the safe band",
        jumping_at(low, high)
    )
}

fn from_rest(answer: &Answer) -> String {
    let missing = answer.corners - answer.corners_reaching_one_one_from_rest;
    if answer.regime_from_rest != answer.regime {
        format!(
            "; from rest the hammer does not get there by itself (it ends in {}): it needs a push",
            answer.regime_from_rest
        )
    } else if missing > 0 {
        format!(
            "; from rest {missing} of {} corners of the uncertainty do not get there by themselves: they need a push",
            answer.corners
        )
    } else {
        String::new()
    }
}
