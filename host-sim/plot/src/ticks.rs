//! Round numbers on axes, and ranges that hold the data.

use super::Range;

/// Round values on an axis and how to write them.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Ticks {
    /// Positions in axis units, ascending.
    pub values: Vec<f64>,
    /// Digits after the point, after division by `10^exponent`.
    decimals: usize,
    /// Power of ten taken out of the labels (0 or a multiple of 3).
    pub exponent: i32,
    /// Whether a position is the decimal logarithm of the value written.
    log: bool,
}

impl Ticks {
    /// Round values inside `lo..=hi`, about `most` of them at the most.
    pub fn new(lo: f64, hi: f64, most: usize) -> Self {
        let raw = (hi - lo) / most.max(1) as f64;
        let power = raw.log10().floor() as i32;
        let mantissa = raw / 10f64.powi(power);
        let (round, step_power) = [(1.0, power), (2.0, power), (5.0, power)]
            .into_iter()
            .find(|(m, _)| mantissa <= m * (1.0 + 1e-9))
            .unwrap_or((1.0, power + 1));
        let step = round * 10f64.powi(step_power);

        let first = (lo / step - 1e-9).ceil();
        let last = (hi / step + 1e-9).floor();
        let count = (last - first).clamp(0.0, 2.0 * most as f64) as usize;
        // `+ 0.0` turns a negative zero into zero.
        let values = (0..=count)
            .map(|k| (first + k as f64) * step + 0.0)
            .filter(|v| (lo..=hi).contains(v) || (v - lo).abs().min((v - hi).abs()) < step * 1e-6)
            .map(|v| v.clamp(lo, hi))
            .collect();

        let largest = lo.abs().max(hi.abs()).log10().floor() as i32;
        let exponent = if (-3..6).contains(&largest) {
            0
        } else {
            largest.div_euclid(3) * 3
        };
        let decimals = (exponent - step_power).max(0) as usize;
        Self {
            values,
            decimals,
            exponent,
            log: false,
        }
    }

    /// Values inside `lo..=hi`, which are decimal logarithms, for a logarithmic axis: powers of ten, and over less than
    /// two decades their double and fivefold too.
    pub fn logarithmic(lo: f64, hi: f64, most: usize) -> Self {
        let most = most.max(1);
        let (first, last) = (lo.floor() as i32, hi.ceil() as i32);
        let factors: &[f64] = if hi - lo < 2.0 && most >= 3 {
            &[1.0, 2.0, 5.0]
        } else {
            &[1.0]
        };
        let stride = ((hi - lo) / most as f64).ceil().max(1.0) as i32;
        let powers = (first..=last).filter(|k| k.rem_euclid(stride) == 0);
        let values = powers.flat_map(|k| factors.iter().map(move |f| f64::from(k) + f.log10()));
        Self {
            values: values.filter(|v| (lo..=hi).contains(v)).collect(),
            decimals: 0,
            exponent: 0,
            log: true,
        }
    }

    /// How `value` is written; the power of ten is named by [`Ticks::factor`].
    pub fn label(&self, value: f64) -> String {
        if self.log {
            let power = (value + 1e-9).floor();
            let text = match 10f64.powf(value - power).round() * 10f64.powf(power) {
                v if (-3.0..=4.0).contains(&power) => {
                    format!("{:.*}", (-power).max(0.0) as usize, v)
                }
                v => format!("{v:.0e}"),
            };
            return text.replace('-', "\u{2212}");
        }
        let text = format!("{:.*}", self.decimals, value / 10f64.powi(self.exponent));
        let is_zero = text.chars().all(|c| matches!(c, '-' | '0' | '.'));
        let text = if is_zero {
            text.trim_start_matches('-').to_owned()
        } else {
            text
        };
        text.replace('-', "\u{2212}")
    }

    /// `" (×1e6)"` when a power of ten was taken out, else nothing.
    pub fn factor(&self) -> String {
        match self.exponent {
            0 => String::new(),
            power => format!(" (×1e{power})").replace('-', "\u{2212}"),
        }
    }
}

/// Values an axis can show: finite, and small enough that differences are too.
pub(crate) fn is_drawable(value: f64) -> bool {
    value.abs() < 1e300
}

/// The ends of an axis that shows `values` as `range` asks, with `margin`
/// (a share of the span) free at each end. Never empty, always finite.
pub(crate) fn axis_range(
    range: Range,
    values: impl Iterator<Item = f64>,
    margin: f64,
) -> (f64, f64) {
    if let Range::Fixed(a, b) = range {
        let (lo, hi) = (a.min(b), a.max(b));
        if is_drawable(lo) && is_drawable(hi) && !is_point(lo, hi) {
            return (lo, hi);
        }
    }
    let zero = (range == Range::WithZero).then_some(0.0);
    let (lo, hi) = values
        .filter(|v| is_drawable(*v))
        .chain(zero)
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), v| {
            (lo.min(v), hi.max(v))
        });
    if lo > hi {
        return (0.0, 1.0);
    }
    if is_point(lo, hi) {
        let half = if lo.abs() < 1e-280 {
            1.0
        } else {
            lo.abs() * 0.1
        };
        return (lo - half, hi + half);
    }
    let pad = (hi - lo) * margin;
    let keep = |end: f64, padded: f64| {
        if zero.is_some() && end == 0.0 {
            0.0
        } else {
            padded
        }
    };
    (keep(lo, lo - pad), keep(hi, hi + pad))
}

/// True when two ends are too close to tell numbers between them apart.
fn is_point(lo: f64, hi: f64) -> bool {
    let size = lo.abs().max(hi.abs());
    hi - lo <= size * 1e-9 || size < 1e-290
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(lo: f64, hi: f64, most: usize) -> Vec<String> {
        let ticks = Ticks::new(lo, hi, most);
        ticks.values.iter().map(|v| ticks.label(*v)).collect()
    }

    #[test]
    fn ticks_are_round_numbers_inside_the_range() {
        assert_eq!(labels(19.0, 61.0, 5), ["20", "30", "40", "50", "60"]);
        assert_eq!(labels(-0.31, 0.31, 4), ["−0.2", "0.0", "0.2"]);
        assert_eq!(
            labels(0.0, 1.0, 5),
            ["0.0", "0.2", "0.4", "0.6", "0.8", "1.0"]
        );
    }

    #[test]
    fn long_numbers_lose_a_power_of_ten() {
        let ticks = Ticks::new(0.0, 3.2e-5, 4);
        assert_eq!(ticks.factor(), " (×1e−6)");
        assert_eq!(ticks.label(ticks.values[1]), "10");
        assert_eq!(Ticks::new(0.0, 2.5e7, 5).factor(), " (×1e6)");
        assert_eq!(Ticks::new(0.0, 250.0, 5).factor(), "");
    }

    #[test]
    fn logarithmic_ticks_are_powers_of_ten() {
        let labels = |lo: f64, hi: f64, most| {
            let ticks = Ticks::logarithmic(lo, hi, most);
            ticks
                .values
                .iter()
                .map(|v| ticks.label(*v))
                .collect::<Vec<_>>()
        };
        assert_eq!(labels(-5.2, -1.9, 8), ["1e−5", "1e−4", "0.001", "0.01"]);
        assert_eq!(labels(-0.1, 1.1, 8), ["1", "2", "5", "10"]);
        assert_eq!(
            labels(-12.0, 0.0, 4),
            ["1e−12", "1e−9", "1e−6", "0.001", "1"]
        );
        assert_eq!(labels(3.0, 6.0, 8), ["1000", "10000", "1e5", "1e6"]);
    }

    #[test]
    fn a_range_is_never_empty() {
        let none = std::iter::empty;
        assert_eq!(axis_range(Range::Auto, none(), 0.05), (0.0, 1.0));
        let one = axis_range(Range::Auto, [5.0, 5.0].into_iter(), 0.05);
        assert!(one.0 < 5.0 && 5.0 < one.1);
        let wild = [f64::NAN, f64::INFINITY, 2.0, f64::MAX, 4.0];
        assert_eq!(axis_range(Range::Auto, wild.into_iter(), 0.0), (2.0, 4.0));
        assert_eq!(axis_range(Range::Fixed(3.0, 3.0), none(), 0.0), (0.0, 1.0));
        assert_eq!(axis_range(Range::Fixed(9.0, 3.0), none(), 0.0), (3.0, 9.0));
        assert_eq!(
            axis_range(Range::WithZero, [10.0].into_iter(), 0.1),
            (0.0, 11.0)
        );
    }

    #[test]
    fn hard_ranges_do_not_loop_or_panic() {
        for (lo, hi) in [
            (-1e299, 1e299),
            (1e-280, 2e-280),
            (1e9, 1e9 + 2.0),
            (-1e-12, 1e-12),
        ] {
            let ticks = Ticks::new(lo, hi, 6);
            assert!(ticks.values.len() <= 13, "{lo} {hi}");
            assert!(ticks.values.iter().all(|v| (lo..=hi).contains(v)));
        }
    }
}
