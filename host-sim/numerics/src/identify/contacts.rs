//! The impacts in a force record: where they are, how hard, and the noise between them.

use std::ops::Range;

use super::quiet::Quiet;
use crate::error::{Error, RecordError};
use crate::signal::Signal;

/// Less than this share of the largest force is not taken for an impact.
const SMALLEST_SHARE: f64 = 1e-3;

/// An impact rises this many standard deviations over the noise: of a million samples none does so by chance.
const DEVIATIONS: f64 = 6.0;

/// An impact is over when the force has kept below the threshold so long, s: the surface rings, and one contact
/// shows several peaks.
const SILENCE_S: f64 = 5e-3;

/// A record, its offset and drift taken off, and its impacts.
#[derive(Clone, Debug, PartialEq)]
pub struct MeasuredImpacts {
    /// Name of the record ([`Signal::name`]).
    pub name: String,
    /// Times of the samples, rising, s.
    pub time_s: Vec<f64>,
    /// Force less its offset, N.
    pub force_n: Vec<f64>,
    /// From sample to sample, s.
    pub sample_s: f64,
    /// Force shown at the first sample where nothing happens, N.
    pub offset_n: f64,
    /// How fast that rises, N/s.
    pub drift_n_per_s: f64,
    /// Whether the zero steps or wanders: that near each contact is then taken off.
    pub zero_steps: bool,
    /// Standard deviation of the offset, N.
    pub offset_deviation_n: f64,
    /// Standard deviation of a sample where nothing happens, quantisation included, N; 0: none seen.
    pub noise_n: f64,
    /// Standard deviation of a sample where nothing happens, quantisation left out, N.
    pub white_n: f64,
    /// Step of a quantised record, N; 0: not quantised.
    pub step_n: f64,
    /// How much more sums of the noise vary than those of independent samples would: 1 for white noise.
    pub colour: f64,
    /// An impact is where the force is over this, N.
    pub threshold_n: f64,
    /// The impacts, in time.
    pub impacts: Vec<Impact>,
}

/// One impact of a record.
#[derive(Clone, Debug, PartialEq)]
pub struct Impact {
    /// First sample over the threshold.
    pub first: usize,
    /// When that was, s.
    pub at_s: f64,
    /// Largest sample of the impact, the offset taken off, N.
    pub peak_n: f64,
    /// ∫F dt over the window, N·s.
    pub impulse_n_s: f64,
    /// The samples compared: from before the onset to well after the release.
    pub window: Range<usize>,
}

impl MeasuredImpacts {
    /// How long the force is over the threshold in the window of `impact`, s. Between two samples over it, all the time;
    /// before the first and after the last, half the distance to the next sample, the nearer of the two.
    pub fn time_over_s(&self, impact: &Impact) -> f64 {
        let times = &self.time_s;
        let over = |k: usize| self.force_n.get(k).is_some_and(|f| *f > self.threshold_n);
        let gap = |k: usize| times.get(k + 1).map_or(f64::INFINITY, |t| t - times[k]);
        let inside = impact.window.clone().filter(|k| *k > 0 && over(*k));
        let one = |k: usize| {
            let (before, after) = (gap(k - 1), gap(k));
            let edge = 0.5 * before.min(after);
            let half = |over: bool, gap: f64| if over { 0.5 * gap } else { edge };
            half(over(k - 1), before) + half(over(k + 1), after)
        };
        inside.map(one).sum()
    }
}

/// The first impacts of a record, `most` of them.
///
/// # Errors
/// If the record has no force, or no impact stands out in it.
pub fn measure(signal: &Signal, most: usize) -> Result<MeasuredImpacts, Error> {
    let name = &signal.name;
    let Some(force) = &signal.force_n else {
        return Err(signal.lacks(RecordError::NoForce));
    };
    let sample_s = signal.sample_s();
    let times = &signal.time_s;
    let finest_n = 1e-6 * force.iter().fold(0.0_f64, |m, f| m.max(*f));
    let step_n = quantisation(force).filter(|step| *step > finest_n);
    let step_n = step_n.unwrap_or(0.0);
    let quiet = Quiet::of(times, force, step_n);
    let pairs = force.iter().zip(times);
    let force_n: Vec<f64> = pairs.map(|(f, t)| f - quiet.zero(*t, times[0])).collect();
    let largest = force_n.iter().fold(0.0_f64, |m, f| m.max(*f));
    let rounding_n = step_n / 12.0_f64.sqrt();
    let noise_n = quiet.deviation_n.max(rounding_n);
    let white_n = if quiet.deviation_n > rounding_n {
        (noise_n.powi(2) - rounding_n.powi(2)).sqrt()
    } else {
        quiet.deviation_n
    };
    let threshold_n = (DEVIATIONS * noise_n).max(SMALLEST_SHARE * largest);
    if largest <= 2.0 * threshold_n {
        return Err(signal.lacks(RecordError::OnlyNoise {
            largest_n: largest,
            noise_n,
        }));
    }
    let mut measured = MeasuredImpacts {
        name: name.clone(),
        time_s: signal.time_s.clone(),
        force_n,
        sample_s,
        offset_n: quiet.offset_n,
        drift_n_per_s: quiet.drift_n_per_s,
        zero_steps: !quiet.local.is_empty(),
        offset_deviation_n: quiet.offset_deviation_n,
        noise_n,
        white_n,
        step_n,
        colour: quiet.colour,
        threshold_n,
        impacts: Vec::new(),
    };
    measured.impacts = find(&measured, most);
    if measured.impacts.is_empty() {
        return Err(signal.lacks(RecordError::NothingBeforeContact));
    }
    Ok(measured)
}

/// The step of a quantised record: the smallest difference there is, if all others are multiples of it.
fn quantisation(force: &[f64]) -> Option<f64> {
    let differences = force.windows(2).map(|w| (w[1] - w[0]).abs());
    let least = differences
        .clone()
        .filter(|d| *d > 0.0)
        .min_by(f64::total_cmp)?;
    let whole = |d: f64| (d / least - (d / least).round()).abs() < 1e-3;
    differences.clone().all(whole).then_some(least)
}

/// ∫ f dt by trapezoids.
fn integral(times: &[f64], values: &[f64], range: Range<usize>) -> f64 {
    let pairs = times[range.clone()]
        .windows(2)
        .zip(values[range].windows(2));
    pairs
        .map(|(t, f)| 0.5 * (f[0] + f[1]) * (t[1] - t[0]))
        .sum()
}

fn find(measured: &MeasuredImpacts, most: usize) -> Vec<Impact> {
    let force = &measured.force_n;
    let times = &measured.time_s;
    let mut impacts = Vec::new();
    let mut at = 0;
    while impacts.len() < most {
        let over = |f: &f64| *f > measured.threshold_n;
        let Some(first) = force[at..].iter().position(over).map(|i| at + i) else {
            break;
        };
        let mut last = first;
        let mut i = first;
        while i < force.len() && times[i] <= times[last] + SILENCE_S {
            if force[i].abs() > measured.threshold_n {
                last = i;
            }
            i += 1;
        }
        at = (last + 1).max(first + 1);
        let peak_n = force[first..=last].iter().fold(0.0_f64, |m, f| m.max(*f));
        if peak_n > 2.0 * measured.threshold_n && first > 0 {
            impacts.push(impact(measured, first, last, peak_n));
        }
    }
    impacts
}

/// The window follows from impulse over peak, which is a half to two thirds of the contact's length under any law,
/// and which ringing hardly moves.
fn impact(measured: &MeasuredImpacts, first: usize, last: usize, peak_n: f64) -> Impact {
    let force = &measured.force_n;
    let times = &measured.time_s;
    let until = (last + 1).min(force.len() - 1);
    let width = integral(times, force, first - 1..until + 1) / peak_n;
    let width = width.max(2.0 * measured.sample_s);
    let at = |t: f64| times.partition_point(|x| *x < t);
    let begin = at(times[first] - width).min(first.saturating_sub(4));
    let end = at(times[first] + 4.0 * width).max(first + 8);
    let window = begin..end.min(force.len());
    let impulse = integral(times, force, window.clone());
    Impact {
        first,
        at_s: measured.time_s[first],
        peak_n,
        impulse_n_s: impulse,
        window,
    }
}
