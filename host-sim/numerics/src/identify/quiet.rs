//! What a force record shows where nothing happens: its zero, how that drifts, and the noise.

use std::ops::Range;

/// Samples of a window whose mean and deviation are looked at.
const WINDOW: usize = 50;

/// The windows are ordered by deviation, and the one at this share stands for the quiet ones: contacts and ringing are
/// a small part of a drop test, and of a driven hammer's record less than three quarters.
const QUIET_SHARE: f64 = 0.25;

/// A window is quiet up to this many times that deviation: so far above it the chance puts one window in ten thousand.
const WITHIN: f64 = 1.5;

/// A window is left out when its mean is this many deviations of the means away from the straight line through them.
const AWAY: f64 = 5.0;

/// A slope of the zero counts when it is this many of its standard deviations.
const SIGNIFICANT: f64 = 4.0;

/// Samples over which noise may hang together.
const LAGS: usize = 40;

/// The record where nothing happens.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quiet {
    /// Force shown at the record's first sample without force, N.
    pub offset_n: f64,
    /// How fast that rises, N/s.
    pub drift_n_per_s: f64,
    /// Standard deviation of a sample, N; 0: none seen.
    pub deviation_n: f64,
    /// What sums over many samples vary more than those of independent ones would: 1 for white noise.
    pub colour: f64,
    /// Standard deviation of the offset, N.
    pub offset_deviation_n: f64,
}

impl Quiet {
    /// Of a record quantised in steps of `step_n` N (0: not).
    pub fn of(time_s: &[f64], force_n: &[f64], step_n: f64) -> Self {
        let windows = windows(time_s, force_n);
        let mut sorted: Vec<f64> = windows.iter().map(|w| w.deviation).collect();
        sorted.sort_by(f64::total_cmp);
        let usual = sorted[(QUIET_SHARE * (sorted.len() - 1) as f64) as usize];
        let limit = (WITHIN * usual).max(if step_n > 0.0 { 0.7 * step_n } else { 0.0 });
        let mut calm: Vec<Window> = windows
            .into_iter()
            .filter(|w| w.deviation <= limit * (1.0 + 1e-9))
            .collect();
        let mut line = (median(calm.iter().map(|w| w.mean)), 0.0);
        // The first rounds are about the median, which outliers do not move.
        for round in 0..6 {
            let off = |w: &Window| w.mean - line.0 - line.1 * (w.time_s - time_s[0]);
            let spread = 1.4826 * median(calm.iter().map(|w| off(w).abs()));
            let about = usual / (WINDOW as f64).sqrt();
            let reach = AWAY * spread.max(about) + 0.3 * step_n + 1e-12 * line.0.abs();
            calm.retain(|w| off(w).abs() <= reach);
            line = straight(&calm, time_s[0], round > 0);
        }
        Self::about(line, &calm, time_s, force_n, step_n)
    }

    fn about(
        (offset_n, drift_n_per_s): (f64, f64),
        calm: &[Window],
        time_s: &[f64],
        force_n: &[f64],
        step_n: f64,
    ) -> Self {
        let rest = |i: usize| force_n[i] - offset_n - drift_n_per_s * (time_s[i] - time_s[0]);
        let count = calm.iter().map(|w| w.range.len()).sum::<usize>() as f64;
        let square = |lag: usize| -> f64 {
            let of = |w: &Window| -> f64 {
                let range = w.range.start..w.range.end - lag;
                range.map(|i| rest(i) * rest(i + lag)).sum()
            };
            let share = 1.0 - lag as f64 / WINDOW as f64;
            calm.iter().map(of).sum::<f64>() / share
        };
        let whole = square(0);
        let deviation = (whole / (count - 2.0).max(1.0)).sqrt();
        // But for rounding.
        let deviation_n = if deviation > 1e-12 * offset_n.abs() {
            deviation
        } else {
            0.0
        };
        let mut colour = 1.0;
        if deviation_n > 0.3 * step_n && deviation_n > 0.0 {
            for lag in 1..LAGS {
                let tie = square(lag) / whole;
                if tie < 3.0 / count.sqrt() {
                    break;
                }
                colour += 2.0 * tie;
            }
        }
        // A record that rests on one code shows its zero no better than half a step.
        let hidden = if deviation_n < 0.4 * step_n {
            step_n / 12.0_f64.sqrt()
        } else {
            0.0
        };
        Self {
            offset_n,
            drift_n_per_s,
            deviation_n,
            colour,
            offset_deviation_n: hidden.max(deviation_n * (colour / count.max(1.0)).sqrt()),
        }
    }
}

struct Window {
    range: Range<usize>,
    time_s: f64,
    mean: f64,
    deviation: f64,
}

fn windows(time_s: &[f64], force_n: &[f64]) -> Vec<Window> {
    let size = WINDOW.min(force_n.len());
    let one = |i: usize| {
        let range = i * size..(i + 1) * size;
        let values = &force_n[range.clone()];
        let mean = values.iter().sum::<f64>() / size as f64;
        let square: f64 = values.iter().map(|f| (f - mean).powi(2)).sum();
        Window {
            time_s: 0.5 * (time_s[range.start] + time_s[range.end - 1]),
            range,
            mean,
            deviation: (square / (size as f64 - 1.0).max(1.0)).sqrt(),
        }
    };
    (0..force_n.len() / size).map(one).collect()
}

fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(0.0)
}

/// Value at `from_s` and slope of the straight line through the means; level if the slope does not count, or is not
/// `sloped`.
fn straight(windows: &[Window], from_s: f64, sloped: bool) -> (f64, f64) {
    let n = windows.len() as f64;
    if n < 1.0 {
        return (0.0, 0.0);
    }
    let time = windows.iter().map(|w| w.time_s).sum::<f64>() / n;
    let mean = windows.iter().map(|w| w.mean).sum::<f64>() / n;
    let (mut tt, mut tf, mut ff) = (0.0, 0.0, 0.0);
    for w in windows {
        let (t, f) = (w.time_s - time, w.mean - mean);
        tt += t * t;
        tf += t * f;
        ff += f * f;
    }
    if !sloped || n < 8.0 || tt == 0.0 {
        return (mean, 0.0);
    }
    let slope = tf / tt;
    let left = ((ff - slope * tf) / (n - 2.0)).max(0.0);
    if slope.abs() <= SIGNIFICANT * (left / tt).sqrt() {
        return (mean, 0.0);
    }
    (mean - slope * (time - from_s), slope)
}
