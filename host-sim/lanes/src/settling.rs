//! Whether a motion whose strobes are recorded is still on its way to another one.

use shared::model::regime::{MAX_PERIODS, Regime, SECTION_TOLERANCE};

/// A motion is called aperiodic only if the later half of what is recorded begins after so many drive periods, and all
/// that is recorded is as long as twice the longest period looked for.
const SETTLING: usize = 64;
/// A distance between points n periods apart that shrinks to less than this share from one half of the record to the
/// other belongs to a motion that still settles.
const SHRINKS: f64 = 0.5;

/// The recorded strobes: how many, and how far two of them are apart, in units of the section.
#[derive(Clone, Copy)]
pub struct Strobes<D> {
    count: usize,
    distance: D,
}

impl<D: Fn(usize, usize) -> f64> Strobes<D> {
    /// `count` strobes, of which `distance` says how far two are apart.
    pub fn new(count: usize, distance: D) -> Self {
        Self { count, distance }
    }

    /// The largest distance between strobes of `range` that are `n` periods apart.
    fn apart(&self, range: std::ops::Range<usize>, n: usize) -> f64 {
        let pairs = range.start..range.end.saturating_sub(n);
        let distances = pairs.map(|k| (self.distance)(k, k + n));
        distances.fold(0.0, f64::max)
    }

    /// The shortest period with which the last half of the strobes repeats.
    pub fn repeats_late(&self) -> Option<usize> {
        let half = self.count / 2..self.count;
        let longest = MAX_PERIODS.min(half.len() / 2);
        (1..=longest).find(|n| self.apart(half.clone(), *n) <= SECTION_TOLERANCE)
    }

    /// The first strobe from which on each equals the one `n` periods later.
    pub fn settled_after(&self, n: usize) -> u32 {
        let last = self.count.saturating_sub(n);
        let differs = |k: &usize| (self.distance)(*k, k + n) > SECTION_TOLERANCE;
        (0..last).rev().find(differs).map_or(0, |k| k as u32 + 1)
    }

    /// Whether what `regime` calls the motion may pass: these strobes came `before` periods after the start.
    ///
    /// A motion that does not repeat may yet come to repeat. One that repeats after an even number of periods may be half
    /// of that whose alternation dies out slowly, as it does beside a period doubling, or whose alternation has only begun.
    pub fn still_change(&self, regime: Regime, before: usize) -> bool {
        match regime {
            Regime::Aperiodic { .. } => self.may_repeat(before),
            Regime::Periodic { impacts, periods } if periods % 2 == 0 && impacts % 2 == 0 => {
                self.alternation_changes(usize::from(periods) / 2)
            }
            _ => false,
        }
    }

    fn may_repeat(&self, before: usize) -> bool {
        let half = self.count / 2;
        let mut periods = 1..=MAX_PERIODS.min(half / 2);
        self.count < 2 * MAX_PERIODS
            || before + half < SETTLING
            || self.repeats_late().is_some()
            || periods.any(|n| self.apart(half..self.count, n) < SHRINKS * self.apart(0..half, n))
    }

    /// Whether the distance between strobes `n` periods apart falls far below what it is now if it goes on so: by the limit
    /// that Aitken's formula gives for its largest values in three parts of the record. At the doubling itself it falls as
    /// 1/√k, of which the formula makes two thirds. Or whether it grows ever faster, so that there is no limit yet.
    fn alternation_changes(&self, n: usize) -> bool {
        const FAR: f64 = 0.75;
        let part = self.count / 3;
        if part < 3 * n {
            return false;
        }
        let begin = self.count - 3 * part;
        let [first, second, third] =
            [0, 1, 2].map(|k| self.apart(begin + k * part..begin + (k + 1) * part, n));
        let (earlier, later) = (first - second, second - third);
        // What rounding alone moves says nothing.
        let moves = later.abs() > 1e-2 * SECTION_TOLERANCE;
        let falls = earlier > later && later > 0.0;
        let dies = falls && third - later * later / (earlier - later) < FAR * third;
        moves && (dies || later < earlier && earlier < 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DOUBLED: Regime = Regime::Periodic {
        impacts: 2,
        periods: 2,
    };

    fn changes(regime: Regime, strobes: impl Fn(usize) -> f64) -> bool {
        let distance = |i, j| (strobes(i) - strobes(j)).abs();
        Strobes::new(100, distance).still_change(regime, 200)
    }

    fn alternating(amount: impl Fn(f64) -> f64) -> bool {
        let sign = |k: usize| if k.is_multiple_of(2) { 1.0 } else { -1.0 };
        changes(DOUBLED, |k| sign(k) * amount(k as f64))
    }

    #[test]
    fn an_alternation_that_dies_out_is_no_doubling() {
        assert!(alternating(|k| 0.01 * 0.99_f64.powf(k)));
        assert!(alternating(|k| 0.01 * 0.998_f64.powf(k)));
        // At the doubling itself, 200 periods after the start.
        assert!(alternating(|k| 0.5 / (200.0 + k).sqrt()));
    }

    #[test]
    fn an_alternation_that_grows_ever_faster_has_not_settled() {
        assert!(alternating(|k| 0.01 * 1.01_f64.powf(k)));
        assert!(alternating(|k| 0.001 * 1.05_f64.powf(k)));
    }

    #[test]
    fn an_alternation_that_stays_or_comes_to_what_stays_is_one() {
        assert!(!alternating(|_| 0.01));
        assert!(!alternating(|k| 0.01 * (1.0 + 0.95_f64.powf(k))));
        assert!(!alternating(|k| 0.01 + 1e-9 * (k / 7.0).sin()));
        assert!(!alternating(|k| 0.02 - 0.01 * 0.97_f64.powf(k)));
    }

    #[test]
    fn what_does_not_repeat_is_aperiodic_only_if_it_does_not_shrink() {
        let aperiodic = Regime::Aperiodic { impacts: 16 };
        assert!(changes(aperiodic, |k| 0.9_f64.powf(k as f64)));
        assert!(!changes(aperiodic, |k| (1.7 * k as f64).sin()));
    }
}
