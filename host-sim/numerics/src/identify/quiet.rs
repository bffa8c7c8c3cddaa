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

/// The zero near a contact is the median of so many windows about each one.
const NEAR: usize = 9;

/// The zero steps when these medians are off the straight line by more than this many deviations of a window's mean.
const STEPPED: f64 = 1.5;

/// The record where nothing happens.
#[derive(Clone, Debug, PartialEq)]
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
    /// Where the zero steps or wanders: times, and how much it is off the straight line there, N; else empty.
    pub local: Vec<(f64, f64)>,
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
        let all: Vec<Window> = calm.clone();
        let level = median(calm.iter().map(|w| w.mean)).unwrap_or(0.0);
        let mut line = (level, 0.0);
        // The first rounds are about the median, which outliers do not move.
        for round in 0..6 {
            let off = |w: &Window| w.mean - line.0 - line.1 * (w.time_s - time_s[0]);
            let spread = 1.4826 * median(calm.iter().map(|w| off(w).abs())).unwrap_or(0.0);
            let about = usual / (WINDOW as f64).sqrt();
            let reach = AWAY * spread.max(about) + 0.3 * step_n + 1e-12 * line.0.abs();
            calm.retain(|w| off(w).abs() <= reach);
            line = straight(&calm, time_s[0], round > 0);
        }
        let (near, stepped) = near(&all, step_n);
        if stepped {
            let level = median(near.iter().copied()).unwrap_or(0.0);
            let pairs = all.into_iter().zip(near);
            let local = |(w, zero): (Window, f64)| Window {
                local: zero - level,
                ..w
            };
            line = (level, 0.0);
            calm = pairs.map(local).collect();
            let off = |w: &Window| (w.mean - level - w.local).abs();
            let reach = AWAY * 1.4826 * median(calm.iter().map(off)).unwrap_or(0.0) + 0.3 * step_n;
            calm.retain(|w| off(w) <= reach);
        }
        let mut quiet = Self::about(line, &calm, time_s, force_n, step_n);
        if stepped {
            let samples = (NEAR * WINDOW) as f64;
            let own = quiet.deviation_n * (quiet.colour / samples).sqrt();
            quiet.offset_deviation_n = quiet.offset_deviation_n.max(own);
            quiet.local = calm.iter().map(|w| (w.time_s, w.local)).collect();
        }
        quiet
    }

    /// The force shown without force at `t`, N, in a record that begins at `from_s`.
    pub fn zero(&self, t: f64, from_s: f64) -> f64 {
        let line = self.offset_n + self.drift_n_per_s * (t - from_s);
        let after = self.local.partition_point(|(at, _)| *at < t);
        let before = after.checked_sub(1).and_then(|i| self.local.get(i));
        let local = match (before, self.local.get(after)) {
            (Some((a, from)), Some((b, to))) => from + (to - from) * (t - a) / (b - a),
            (Some((_, only)), None) | (None, Some((_, only))) => *only,
            (None, None) => 0.0,
        };
        line + local
    }

    fn about(
        (offset_n, drift_n_per_s): (f64, f64),
        calm: &[Window],
        time_s: &[f64],
        force_n: &[f64],
        step_n: f64,
    ) -> Self {
        let rest = |w: &Window, i: usize| {
            force_n[i] - offset_n - drift_n_per_s * (time_s[i] - time_s[0]) - w.local
        };
        let count = calm.iter().map(|w| w.range.len()).sum::<usize>() as f64;
        let square = |lag: usize| -> f64 {
            let of = |w: &Window| -> f64 {
                let range = w.range.start..w.range.end - lag;
                range.map(|i| rest(w, i) * rest(w, i + lag)).sum()
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
        let colour = if deviation_n > 0.3 * step_n && deviation_n > 0.0 {
            correlated(LAGS, count, whole, square)
        } else {
            1.0
        };
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
            local: Vec::new(),
            offset_deviation_n: hidden.max(deviation_n * (colour / count.max(1.0)).sqrt()),
        }
    }
}

/// How much more sums of `count` numbers vary than those of independent ones would, by the products `square` of numbers so
/// many samples apart: up to `lags`, while they stand out of chance. `whole` is that of each with itself.
pub fn correlated(lags: usize, count: f64, whole: f64, square: impl Fn(usize) -> f64) -> f64 {
    let ties = (1..lags).map(|lag| square(lag) / whole);
    let real = ties.take_while(|tie| *tie >= 3.0 / count.sqrt());
    real.fold(1.0, |colour, tie| colour + 2.0 * tie)
}

#[derive(Clone)]
struct Window {
    range: Range<usize>,
    /// How much the zero is off the straight line here.
    local: f64,
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
            local: 0.0,
            mean,
            deviation: (square / (size as f64 - 1.0).max(1.0)).sqrt(),
        }
    };
    (0..force_n.len() / size).map(one).collect()
}

/// The median of [`NEAR`] windows about each one, and whether these say that the zero steps or wanders: they are off the
/// straight line by more than the windows are off them.
fn near(windows: &[Window], step_n: f64) -> (Vec<f64>, bool) {
    let half = NEAR / 2;
    let one = |i: usize| {
        let range = i.saturating_sub(half)..(i + half + 1).min(windows.len());
        median(windows[range].iter().map(|w| w.mean)).unwrap_or(0.0)
    };
    let near: Vec<f64> = (0..windows.len()).map(one).collect();
    let from_s = windows.first().map_or(0.0, |w| w.time_s);
    let level = |(w, mean): (&Window, &f64)| Window {
        mean: *mean,
        ..w.clone()
    };
    let level: Vec<Window> = windows.iter().zip(&near).map(level).collect();
    let line = straight(&level, from_s, true);
    let off = |w: &Window| w.mean - line.0 - line.1 * (w.time_s - from_s);
    let square = level.iter().map(|w| off(w).powi(2)).sum::<f64>() / level.len().max(1) as f64;
    let apart = windows.iter().zip(&near).map(|(w, n)| (w.mean - n).abs());
    let scatter = median(apart).unwrap_or(0.0);
    let stepped = square.sqrt() > STEPPED * 1.4826 * scatter + 0.3 * step_n;
    (near, stepped)
}

/// The middle one, by size; of an even number the upper.
pub fn median(values: impl Iterator<Item = f64>) -> Option<f64> {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
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
