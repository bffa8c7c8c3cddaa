//! Phrases of the errors' lines.

use super::RecordError;
use crate::limits::PickLimits;
use crate::row::{significant, tidy};

/// A time in microseconds, rounded down to two digits.
pub(super) fn short_of_us(time_s: f64) -> f64 {
    let us = time_s * 1e6;
    let digit = 10.0_f64.powf(us.log10().floor() - 1.0);
    // Dividing by a whole number prints without a tail of digits.
    if digit < 1.0 {
        let per_us = (1.0 / digit).round();
        (us * per_us).floor() / per_us
    } else {
        (us / digit).floor() * digit
    }
}

pub(super) fn mm(metres: f64) -> f64 {
    tidy(metres * 1e3)
}

/// What a record lacks, behind the record's name where that says more.
pub(super) fn in_record(record: &str, what: &RecordError) -> String {
    match what {
        RecordError::NoContacts | RecordError::NoFrequency | RecordError::NothingToSearch => {
            what.to_string()
        }
        _ => format!("{record}: {what}"),
    }
}

pub(super) fn only_noise(largest_n: f64, noise_n: f64) -> String {
    if largest_n == 0.0 {
        return "the force is the same in every sample: no impact to identify from; was the record cut before the first impact?".to_owned();
    }
    format!(
        "the largest force, {} N, does not stand out of the noise of {} N: no impact to identify from",
        significant(largest_n, 3),
        significant(noise_n, 3)
    )
}

pub(super) fn other_gap(nearest_gap_m: Option<f64>) -> String {
    match nearest_gap_m {
        Some(gap_m) => format!("there is one at {:.3} mm", gap_m * 1e3),
        None => "try a larger amplitude".to_owned(),
    }
}

pub(super) fn share_left(share: Option<f64>) -> String {
    match share {
        Some(share) => format!(
            "{:.0} % of that uncertainty still allows one",
            100.0 * share
        ),
        None => "not even a hundredth of it allows one".to_owned(),
    }
}

/// What the limits would have to be at least, four digits, rounded up so that they can be kept.
pub(super) fn nearest_limits(feasible: PickLimits) -> String {
    let up = |x: f64| {
        let scale = 10f64.powi(3 - x.abs().log10().floor() as i32);
        (x * scale).ceil() / scale
    };
    let least = named(PickLimits {
        max_force_n: feasible.max_force_n.map(up),
        max_frequency_hz: feasible.max_frequency_hz.map(up),
        max_shaker_force_n: feasible.max_shaker_force_n.map(up),
        rig_shaker_force_n: feasible.rig_shaker_force_n.map(up),
    });
    match least.as_slice() {
        [] => "relax one of them".to_owned(),
        least => format!("the nearest that can be kept: {}", least.join(" and ")),
    }
}

pub(super) fn named(limits: PickLimits) -> Vec<String> {
    let one = |name: &str, limit: Option<f64>| limit.map(|limit| format!("{name} = {limit}"));
    [
        one("max_force_n", limits.max_force_n),
        one("max_frequency_hz", limits.max_frequency_hz),
        one("max_shaker_force_n", limits.max_shaker_force_n),
        one("shaker_max_force_n", limits.rig_shaker_force_n),
    ]
    .into_iter()
    .flatten()
    .collect()
}
