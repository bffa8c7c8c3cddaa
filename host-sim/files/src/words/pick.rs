//! Why this frequency, in one sentence.

use super::digits::{Digits, significant};
use numerics::CartModel;
use numerics::limits::LimitUse;
use numerics::pick::PickAnswer;
use serde::Serialize;

/// An answer with its sentence, as JSON has it.
#[derive(Serialize)]
pub struct WordedPick<'a> {
    #[serde(flatten)]
    answer: &'a PickAnswer,
    why: String,
}

impl<'a> From<&'a PickAnswer> for WordedPick<'a> {
    fn from(answer: &'a PickAnswer) -> Self {
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

/// A length to a micrometre; below 0.1 mm to three digits.
pub fn rounded_mm(mm: f64) -> f64 {
    let decimals = (2.0 - mm.log10().floor()).clamp(3.0, 15.0);
    let per_mm = 10.0_f64.powi(decimals as i32);
    (mm * per_mm).round() / per_mm
}

/// The limit of the shaker that was asked for.
pub fn shaker_limit(a: &PickAnswer) -> Option<&LimitUse> {
    let told =
        |limit: &&LimitUse| of_shaker(limit) && (a.wanted_force_n.is_some() || !assumed(limit));
    a.limits.iter().find(told)
}

/// What the shaker would have to give, if it is more than it can.
pub fn beyond(a: &PickAnswer) -> Option<String> {
    let most = shaker_limit(a)?.limit?;
    let needed = a.shaker.loop_force_n.unwrap_or(a.shaker.force_n);
    let here = Digits::of(a).other(needed);
    is_beyond(needed, most).then(|| format!("it needs {here} N and can give {most} N"))
}

/// That the shaker cannot give it, and why, behind what it is asked for; empty where it can.
pub fn cannot(a: &PickAnswer) -> String {
    beyond(a).map_or(String::new(), |why| format!("; the shaker cannot: {why}"))
}

/// The stroke of the answer where it is not the rig's own, and whether the shaker can give it, as a sentence and a space.
pub fn at_stroke(a: &PickAnswer) -> String {
    if a.wanted_force_n.is_none() && !a.amplitude_lowered {
        return String::new();
    }
    format!(
        "At {} mm of stroke{}. ",
        rounded_mm(a.shaker.stroke_mm),
        cannot(a)
    )
}

/// Whether a force is more than the shaker can give, beyond what the search for that very force leaves.
pub fn is_beyond(needed_n: f64, most_n: f64) -> bool {
    needed_n > most_n * (1.0 + 1e-6)
}

/// Whether it is the limit of the shaker's force.
pub fn of_shaker(limit: &LimitUse) -> bool {
    ["max_shaker_force_n", "shaker_max_force_n"].contains(&limit.name)
}

/// Whether it is that of the shaker assumed for a preset, and decides nothing.
pub fn assumed(limit: &LimitUse) -> bool {
    limit.assumed && !limit.binds
}

/// The strongest nominal 1/1 with the cart moved the other way, and with the answer's own cart under the same limits.
pub struct OtherCart {
    /// How it is moved.
    pub what: &'static str,
    /// Contact force over m g.
    pub force_ratio: f64,
    /// Drive frequency of that 1/1, Hz.
    pub hz: f64,
    /// Contact force over m g with the answer's cart.
    pub own_force_ratio: f64,
    /// Drive frequency with the answer's cart, Hz.
    pub own_hz: f64,
}

/// What the other cart would give; none where it is not known.
pub fn other_cart(answer: &PickAnswer) -> Option<OtherCart> {
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
pub fn why(answer: &PickAnswer) -> String {
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

fn strongest_of(answer: &PickAnswer) -> String {
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

fn jumps(answer: &PickAnswer) -> String {
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

fn from_rest(answer: &PickAnswer) -> String {
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
