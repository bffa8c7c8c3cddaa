//! Digits for a person: those that the uncertainty leaves. Tables and JSON have all of them.

use numerics::pick::PickAnswer;
pub use numerics::row::significant;

/// Decimals of the quantities of an answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Digits {
    /// Of frequencies, in Hz.
    frequency: usize,
    /// Of ratios of frequencies.
    pub ratio: usize,
    /// Of the force over the weight.
    pub force_ratio: usize,
    /// Of the force in N.
    pub force_n: usize,
    /// Significant digits of what follows from them.
    pub others: usize,
}

/// Where the parameters are taken as exact.
const EXACT: Digits = Digits {
    frequency: 4,
    ratio: 3,
    force_ratio: 2,
    force_n: 2,
    others: 4,
};

impl Digits {
    /// Those of `answer`: down to the digit in which its uncertainty begins.
    pub fn of(answer: &PickAnswer) -> Self {
        if answer.uncertainty.is_none() {
            return EXACT;
        }
        let shares = answer.sensitivity.iter();
        let shares = shares.filter_map(|row| row.frequency_over_uncertainty_percent);
        let percent = shares.map(|share| share * share).sum::<f64>().sqrt();
        let half_hz = answer.operating_frequency_hz * percent / 100.0;
        let half_ratio = 0.5 * (answer.force_ratio_largest - answer.force_ratio_worst);
        let half_n = half_ratio * answer.force_n / answer.force_ratio;
        // Two digits of the nominal value at least, and one of the weakest: 2.42 is not 2, and 0.4 not 0.
        let weakest = answer.force_ratio_worst / answer.force_ratio;
        let of = |half: f64, value: f64, most: usize| {
            let least = places(value, 2).max(places(weakest * value, 1));
            decimals(half, most).max(least).min(most)
        };
        Self {
            frequency: decimals(half_hz, EXACT.frequency),
            ratio: 2,
            force_ratio: of(half_ratio, answer.force_ratio, EXACT.force_ratio),
            force_n: of(half_n, answer.force_n, EXACT.force_n),
            others: 2,
        }
    }

    /// A frequency in Hz as text, without its unit.
    pub fn hz(self, hz: f64) -> String {
        format!("{hz:.*}", self.frequency)
    }

    /// The frequency to run at: rounded, and with another digit where it would be rounded out of the safe band.
    pub fn run_at(self, answer: &PickAnswer) -> String {
        let hz = answer.operating_frequency_hz;
        let [low, high] = answer.safe_band_hz;
        let kept = |decimals: &usize| {
            let shown = format!("{hz:.decimals$}").parse::<f64>();
            shown.is_ok_and(|shown| (low..=high).contains(&shown))
        };
        match (self.frequency..=EXACT.frequency).find(kept) {
            Some(decimals) => format!("{hz:.decimals$}"),
            // On an end of the band: rounded into it.
            None => {
                let scale = 10f64.powi(EXACT.frequency as i32);
                let into = match hz - low < high - hz {
                    true => (hz * scale - 1e-6).ceil(),
                    false => (hz * scale + 1e-6).floor(),
                };
                format!("{:.*}", EXACT.frequency, into / scale)
            }
        }
    }

    /// The safe band, in as many digits as it takes for the frequency to run at to lie in it.
    pub fn safe_band(self, answer: &PickAnswer) -> String {
        let hz = answer.operating_frequency_hz;
        let [low, high] = answer.safe_band_hz;
        let within = |frequency: &usize| {
            let scale = 10f64.powi(*frequency as i32);
            ((low * scale - 1e-6).ceil()..=(high * scale + 1e-6).floor()).contains(&(hz * scale))
        };
        let frequency = (self.frequency..=EXACT.frequency).find(within);
        match frequency {
            Some(frequency) => Self { frequency, ..self }.band([low, high]),
            None => format!("{low:.4} to {high:.4}"),
        }
    }

    /// A band of frequencies, rounded inwards: "3.34 to 4.03".
    pub fn band(self, [low, high]: [f64; 2]) -> String {
        let scale = 10f64.powi(self.frequency as i32);
        // What is on a digit already stays there.
        let up = (low * scale - 1e-6).ceil() / scale;
        let down = (high * scale + 1e-6).floor() / scale;
        if up < down {
            format!("{} to {}", self.hz(up), self.hz(down))
        } else {
            format!("{low:.4} to {high:.4}")
        }
    }

    /// What follows from frequency and force: so many significant digits.
    pub fn other(self, value: f64) -> String {
        significant(value, self.others)
    }
}

/// Decimals that show the first digit of `half_width`, `most` at most.
pub fn decimals(half_width: f64, most: usize) -> usize {
    if half_width <= 0.0 || !half_width.is_finite() {
        return most;
    }
    let place = -half_width.log10().floor();
    (place.max(0.0) as usize).min(most)
}

/// Decimals that show `digits` significant digits of `value`; none for 0 or less.
fn places(value: f64, digits: i32) -> usize {
    if value > 0.0 {
        (digits - 1 - value.log10().floor() as i32).max(0) as usize
    } else {
        0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits_end_where_the_uncertainty_begins() {
        for (half_width, shown) in [
            (0.0735, 2),
            (0.26, 1),
            (6.6, 0),
            (19.0, 0),
            (0.0, 4),
            (1e-9, 4),
        ] {
            assert_eq!(decimals(half_width, 4), shown, "{half_width}");
        }
    }

    #[test]
    fn a_band_is_rounded_inwards() {
        let digits = Digits {
            frequency: 2,
            ..EXACT
        };
        assert_eq!(digits.band([3.3382, 4.0351]), "3.34 to 4.03");
        assert_eq!(digits.band([3.33, 4.03]), "3.33 to 4.03");
        // A band narrower than a digit keeps its digits.
        assert_eq!(digits.band([3.3312, 3.3391]), "3.3312 to 3.3391");
    }
}
