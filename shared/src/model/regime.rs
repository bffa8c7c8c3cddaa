//! Impact regimes z = p/n, detected on the Poincaré section at drive phase 0.

use core::fmt::Write;

use serde::{Deserialize, Serialize};

use crate::model::contacts::Period;
use crate::model::scalar::Real;

/// Longest section period looked for.
pub const MAX_PERIODS: usize = 16;

/// Two points of the section are the same when neither their displacements differ by more than this
/// share of A0, nor their velocities by more than this share of A0 Ω.
pub const SECTION_TOLERANCE: f64 = 1e-3;

/// The impact regime over a window of drive periods.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Regime {
    /// No contact in the window.
    None,
    /// z = p/n: `impacts` contacts in `periods` drive periods, after which the section repeats. Not
    /// reduced: a period-doubled 1/1 is 2/2. 0/1 is a hammer that stays pressed on throughout.
    Periodic {
        /// p: contacts in `periods` drive periods.
        impacts: u16,
        /// n, 1 to [`MAX_PERIODS`].
        periods: u8,
    },
    /// No n up to [`MAX_PERIODS`] after which section and contact count repeat over the whole window.
    Aperiodic {
        /// Contacts in the last [`MAX_PERIODS`] drive periods (fewer if the window is shorter).
        impacts: u16,
    },
    /// Within one period three or more onsets ended in a stay longer than 5 ms.
    Chatter {
        /// Contacts in `periods` drive periods, or in the last [`MAX_PERIODS`].
        impacts: u16,
        /// n, if the section repeats.
        periods: Option<u8>,
    },
}

impl Regime {
    /// p: contacts per repetition (per last [`MAX_PERIODS`] periods when nothing repeats).
    pub fn impacts(self) -> u16 {
        match self {
            Self::None => 0,
            Self::Periodic { impacts, .. }
            | Self::Aperiodic { impacts }
            | Self::Chatter { impacts, .. } => impacts,
        }
    }

    /// n: drive periods per repetition, if the section repeats with contacts.
    pub fn periods(self) -> Option<u8> {
        match self {
            Self::Periodic { periods, .. } => Some(periods),
            Self::Chatter { periods, .. } => periods,
            Self::None | Self::Aperiodic { .. } => None,
        }
    }

    /// Whether this is z = `impacts`/`periods`.
    pub fn is(self, impacts: u16, periods: u8) -> bool {
        self == Self::Periodic { impacts, periods }
    }
}

impl core::fmt::Display for Regime {
    /// "p/n", "none", "aperiodic" or "chatter", padded to the width asked for.
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::None => f.pad("none"),
            Self::Periodic { impacts, periods } => {
                // Longest: "65535/255".
                let mut name = heapless::String::<9>::new();
                write!(name, "{impacts}/{periods}")?;
                f.pad(&name)
            }
            Self::Aperiodic { .. } => f.pad("aperiodic"),
            Self::Chatter { .. } => f.pad("chatter"),
        }
    }
}

/// Detects the regime from the strobes of a window, in constant space and time per strobe.
///
/// For every n up to [`MAX_PERIODS`] it keeps the largest distance between points n periods apart and
/// whether the number of contacts per n periods was always the same. n is accepted once at least n pairs
/// have been compared, so 2n strobes (2n − 1 recorded periods) are needed to see n.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Detector<R> {
    displacement_scale: R,
    velocity_scale: R,
    tolerance: R,
    /// The last [`MAX_PERIODS`] + 1 strobes, newest at `(seen − 1) % len`.
    ring: [Point<R>; MAX_PERIODS + 1],
    seen: u32,
    candidates: [Candidate<R>; MAX_PERIODS],
    touched: bool,
    last_chatter: Option<u32>,
}

#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Point<R> {
    q: R,
    v: R,
    /// Contacts counted up to this strobe (wraps).
    onsets: u32,
}

#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Candidate<R> {
    mismatch: R,
    impacts: Option<u32>,
    uneven: bool,
}

impl<R: Real> Detector<R> {
    /// A detector for coordinates compared on the scales `displacement` and `velocity` (A0 and A0 Ω in
    /// the coordinate's units), with the usual [`SECTION_TOLERANCE`].
    pub fn new(displacement: R, velocity: R) -> Self {
        Self::with_tolerance(displacement, velocity, SECTION_TOLERANCE)
    }

    /// A detector as [`Self::new`] makes it, with another tolerance (a share of the scales).
    pub fn with_tolerance(displacement: R, velocity: R, tolerance: f64) -> Self {
        Self {
            displacement_scale: displacement,
            velocity_scale: velocity,
            tolerance: R::from_f64(tolerance),
            ring: [Point::default(); MAX_PERIODS + 1],
            seen: 0,
            candidates: [Candidate::default(); MAX_PERIODS],
            touched: false,
            last_chatter: None,
        }
    }

    /// A strobe at coordinate `q` and rate `v`, and what happened in the period that ended with it.
    pub fn push(&mut self, q: R, v: R, period: &Period<R>) {
        const LEN: u32 = MAX_PERIODS as u32 + 1;
        let last = self.ring[(self.seen.wrapping_sub(1) % LEN) as usize];
        let before = if self.seen == 0 { 0 } else { last.onsets };
        let point = Point {
            q,
            v,
            onsets: before.wrapping_add(u32::from(period.onsets)),
        };
        for (n, candidate) in (1..).zip(&mut self.candidates) {
            if self.seen < n {
                break;
            }
            let earlier = self.ring[((self.seen - n) % LEN) as usize];
            let dq = (point.q - earlier.q).abs() / self.displacement_scale;
            let dv = (point.v - earlier.v).abs() / self.velocity_scale;
            candidate.mismatch = dq.max(dv).max(candidate.mismatch);
            let impacts = point.onsets.wrapping_sub(earlier.onsets);
            candidate.uneven |= candidate.impacts.is_some_and(|p| p != impacts);
            candidate.impacts = Some(impacts);
        }
        // The first strobe opens the window: what came before it is not recorded.
        self.touched |= self.seen > 0 && period.touched;
        if self.seen > 0 && period.chatter {
            self.last_chatter = Some(self.seen);
        }
        self.ring[(self.seen % LEN) as usize] = point;
        self.seen = self.seen.saturating_add(1);
    }

    /// Drive periods recorded so far (the first strobe opens the window).
    pub fn periods_seen(&self) -> u32 {
        self.seen.saturating_sub(1)
    }

    /// The regime over the window so far.
    pub fn regime(&self) -> Regime {
        if !self.touched {
            return Regime::None;
        }
        let narrow = |count: u32| u16::try_from(count).unwrap_or(u16::MAX);
        let repeats = (1_u8..).zip(&self.candidates).find(|(n, candidate)| {
            self.seen >= 2 * u32::from(*n)
                && candidate.mismatch <= self.tolerance
                && !candidate.uneven
        });
        let found = repeats.and_then(|(n, c)| c.impacts.map(|p| (narrow(p), n)));
        let longest = self.candidates.iter().rev().find_map(|c| c.impacts);
        let in_window = narrow(longest.unwrap_or(0));
        let chatters = self
            .last_chatter
            .is_some_and(|at| self.seen - at <= MAX_PERIODS as u32);
        match (chatters, found) {
            (true, Some((impacts, n))) => Regime::Chatter {
                impacts,
                periods: Some(n),
            },
            (true, None) => Regime::Chatter {
                impacts: in_window,
                periods: None,
            },
            (false, Some((impacts, periods))) => Regime::Periodic { impacts, periods },
            (false, None) => Regime::Aperiodic { impacts: in_window },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(points: impl Iterator<Item = (f64, u16)>) -> Regime {
        let mut detector = Detector::new(1.0, 1.0);
        for (q, onsets) in points {
            let period = Period {
                onsets,
                touched: onsets > 0,
                ..Period::default()
            };
            detector.push(q, 0.0, &period);
        }
        detector.regime()
    }

    #[test]
    fn a_name_is_padded_to_the_width_asked_for() {
        let largest = Regime::Periodic {
            impacts: u16::MAX,
            periods: u8::MAX,
        };
        assert_eq!(std::format!("{largest}"), "65535/255");
        let one = Regime::Periodic {
            impacts: 1,
            periods: 1,
        };
        assert_eq!(
            std::format!("{one:<5}|{:>5}|", Regime::None),
            "1/1  | none|"
        );
    }

    #[test]
    fn every_kind_is_told() {
        assert_eq!(run((0..40).map(|k| (f64::from(k).sin(), 0))), Regime::None);
        assert!(run((0..40).map(|_| (0.5, 1))).is(1, 1));
        assert!(run((0..40).map(|k| (f64::from(k % 2), 1))).is(2, 2));
        assert!(run((0..40).map(|k| (f64::from(k % 2), k as u16 % 2))).is(1, 2));
        assert!(run((0..40).map(|k| (f64::from(k % 16), 1))).is(16, 16));
        let irrational = run((0..40).map(|k| ((f64::from(k) * 1.7).sin(), 1)));
        assert_eq!(irrational, Regime::Aperiodic { impacts: 16 });
    }

    #[test]
    fn a_doubling_below_the_tolerance_is_not_seen_and_above_it_is() {
        let at = |amount: f64| run((0..40).map(move |k| (amount * f64::from(k % 2), 1)));
        assert!(at(0.9 * SECTION_TOLERANCE).is(1, 1));
        assert!(at(1.1 * SECTION_TOLERANCE).is(2, 2));
    }

    #[test]
    fn the_same_section_with_uneven_contacts_does_not_repeat() {
        assert!(run((0..40).map(|k| (0.0, 1 + u16::from(k % 2 == 0)))).is(3, 2));
    }

    #[test]
    fn a_window_too_short_for_n_does_not_claim_it() {
        let regime = run((0..9).map(|k| (f64::from(k % 5), 1)));
        assert!(matches!(regime, Regime::Aperiodic { .. }), "{regime:?}");
        assert!(run((0..10).map(|k| (f64::from(k % 5), 1))).is(5, 5));
    }

    #[test]
    fn coordinate_and_rate_are_each_compared_on_their_own_scale() {
        let (displacement, velocity) = (1e-3, 0.04);
        let doubled_by = |q: f64, v: f64| {
            let mut detector = Detector::new(displacement, velocity);
            for k in 0..40 {
                let period = Period {
                    onsets: 1,
                    touched: true,
                    ..Period::default()
                };
                let off = f64::from(k % 2);
                detector.push(q * displacement * off, v * velocity * off, &period);
            }
            detector.regime()
        };
        let (below, above) = (0.9 * SECTION_TOLERANCE, 1.1 * SECTION_TOLERANCE);
        assert!(doubled_by(below, below).is(1, 1));
        assert!(doubled_by(above, 0.0).is(2, 2));
        assert!(doubled_by(0.0, above).is(2, 2));
    }

    #[test]
    fn the_first_point_of_the_window_must_repeat_too() {
        assert!(run([0.0, 0.0, 0.0].into_iter().map(|q| (q, 1))).is(1, 1));
        let regime = run([1.0, 0.0, 0.0].into_iter().map(|q| (q, 1)));
        assert_eq!(regime, Regime::Aperiodic { impacts: 2 });
    }

    /// A first strobe after the period `first`, then `more` strobes after periods like `then`.
    fn after(first: Period<f64>, more: u32, then: Period<f64>) -> Detector<f64> {
        let mut detector = Detector::new(1.0, 1.0);
        detector.push(0.0, 0.0, &first);
        for _ in 0..more {
            detector.push(0.0, 0.0, &then);
        }
        detector
    }

    #[test]
    fn what_came_before_the_first_strobe_is_not_part_of_the_window() {
        let chatter = Period {
            onsets: 5,
            touched: true,
            chatter: true,
            ..Period::default()
        };
        let one = Period {
            onsets: 1,
            touched: true,
            ..Period::default()
        };
        assert_eq!(after(chatter, 0, one).periods_seen(), 0);
        let silent = after(chatter, 5, Period::default());
        assert_eq!((silent.regime(), silent.periods_seen()), (Regime::None, 5));
        assert!(after(chatter, 5, one).regime().is(1, 1));
    }

    #[test]
    fn chatter_counts_for_as_many_periods_as_are_looked_at() {
        let one = Period {
            onsets: 1,
            touched: true,
            ..Period::default()
        };
        let mut detector = after(one, 20, one);
        let chatter = Period {
            chatter: true,
            ..one
        };
        detector.push(0.0, 0.0, &chatter);
        for _ in 1..MAX_PERIODS {
            detector.push(0.0, 0.0, &one);
        }
        let chattered = Regime::Chatter {
            impacts: 1,
            periods: Some(1),
        };
        assert_eq!(detector.regime(), chattered);
        detector.push(0.0, 0.0, &one);
        assert!(detector.regime().is(1, 1));
    }

    #[test]
    fn what_does_not_repeat_has_no_period() {
        assert_eq!(Regime::None.periods(), None);
        let irrational = run((0..40).map(|k| ((f64::from(k) * 1.7).sin(), 1)));
        assert_eq!((irrational.impacts(), irrational.periods()), (16, None));
    }

    #[test]
    fn chatter_keeps_impacts_and_periods() {
        let mut detector = Detector::<f32>::new(1.0, 1.0);
        for _ in 0..10 {
            let period = Period {
                onsets: 7,
                touched: true,
                chatter: true,
                peak_force: 1.0,
            };
            detector.push(0.0, 0.0, &period);
        }
        let regime = detector.regime();
        assert_eq!(
            regime,
            Regime::Chatter {
                impacts: 7,
                periods: Some(1)
            }
        );
        assert_eq!((regime.impacts(), regime.periods()), (7, Some(1)));
    }
}
