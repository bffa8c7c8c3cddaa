//! From the strobes of a cell to its outcome, and when a cell may stop early.

use shared::model::regime::{MAX_PERIODS, Regime, SECTION_TOLERANCE};

use super::constants::Constants;
use super::settling::Strobes;
use super::{CellOutcome, CellPlan, LaneStrobe};

/// A strobe, and what happened in the drive period that ended with it; without units.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StrobeRecord {
    /// Coordinate x, in cart amplitudes from the surface.
    pub x: f64,
    /// Rate x′, per radian of drive phase.
    pub v: f64,
    /// Largest contact force of the period, in units of m A0 Ω².
    pub force: f32,
    /// Contacts that began in the period.
    pub onsets: u16,
    /// Whether the surface was touched.
    pub touched: bool,
    /// Whether chatter ended in a sustained contact.
    pub chatter: bool,
}

impl StrobeRecord {
    /// The larger difference of coordinate and rate, on the section's scales.
    #[inline]
    fn distance(&self, other: &Self) -> f64 {
        (self.x - other.x).abs().max((self.v - other.v).abs())
    }
}

/// Every so many cycles a cell is tested for having converged.
const TEST_EVERY: usize = 8;

/// What is left between a section and the orbit it converges on when a cell stops early, in cart amplitudes (and A0 Ω):
/// a fiftieth of the section's tolerance.
pub const SETTLED_WITHIN: f64 = SECTION_TOLERANCE / 50.0;

/// Cycles that must have run before a cell may stop early.
const FIRST_TEST: usize = 40;

/// How many of the last cycles show it, if the section has converged: after some n ≤ 16 it repeats, with the same contacts, and ever closer, so that
/// what a geometric series leaves is below [`SETTLED_WITHIN`]. `grain` is the distance that rounding alone makes.
pub fn converged(records: &[StrobeRecord], grain: f64) -> Option<usize> {
    let count = records.len() - 1;
    if count < FIRST_TEST || !count.is_multiple_of(TEST_EVERY) {
        return None;
    }
    let last = records[count];
    let n = (1..=MAX_PERIODS).find(|n| last.distance(&records[count - n]) < SETTLED_WITHIN)?;
    // Beside a doubling an orbit repeats after 2n long before it does after n: then it has not converged.
    let divides = |m: &usize| n.is_multiple_of(*m);
    if (1..n)
        .filter(divides)
        .any(|m| last.distance(&records[count - m]) < SECTION_TOLERANCE)
    {
        return None;
    }
    // Whole repetitions, and at least eight cycles, now and before.
    let window = n * 8_usize.div_ceil(n);
    if count < 2 * window + n {
        return None;
    }
    let distance = |k: usize| records[k].distance(&records[k - n]);
    let largest = |from: usize| (from..from + window).map(distance).fold(0.0, f64::max);
    let even = |k: usize| {
        let (a, b) = (&records[k], &records[k - n]);
        a.onsets == b.onsets && a.chatter == b.chatter
    };
    let now = largest(count + 1 - window);
    let before = largest(count + 1 - 2 * window);
    let shrinks = now / before;
    // Every window to come holds this many steps of n cycles, and shrinks again.
    let left = now * (window / n) as f64 * shrinks / (1.0 - shrinks);
    let still = before < grain || (shrinks < 0.95 && left < SETTLED_WITHIN);
    (still && before < 0.5 * SECTION_TOLERANCE && (count + 1 - 2 * window..=count).all(even))
        .then_some(2 * window)
}

fn strobes(records: &[StrobeRecord]) -> Strobes<impl Fn(usize, usize) -> f64> {
    Strobes::new(records.len(), |i, j| records[j].distance(&records[i]))
}

/// What the records of a cell say. The first record is the section at the start.
pub fn outcome(
    c: &Constants,
    records: &[StrobeRecord],
    plan: &CellPlan,
    settled: Option<usize>,
) -> CellOutcome {
    let cycles = records.len() - 1;
    let recorded = settled.unwrap_or(plan.recorded as usize).min(cycles);
    let window = &records[cycles - recorded..];
    let regime = regime(window);
    // Of a section that has converged, the later half: it is nearer to the orbit.
    let latest = 1 + settled.map_or(0, |_| recorded / 2);
    let force = window[latest..].iter().fold(0.0_f32, |m, r| m.max(r.force));
    let units = (c.scale, c.scale * c.omega);
    let kept = cycles - (plan.strobes as usize).min(cycles);
    let last = records[cycles];
    let whole = strobes(records);
    let unsettled =
        settled.is_none() && strobes(&window[1..]).still_change(regime, cycles - recorded);
    let repeats = regime.periods().filter(|_| !unsettled);
    CellOutcome {
        regime,
        unsettled,
        force_n: f64::from(force) * c.force_unit_n,
        settled_after: repeats.map(|n| whole.settled_after(usize::from(n))),
        cycles: cycles as u32,
        searched: MAX_PERIODS.min(plan.recorded as usize / 2) as u8,
        last_contact: records[1..]
            .iter()
            .rposition(|r| r.touched)
            .map(|i| i as u32 + 1),
        uncertain: false,
        section: [last.x * units.0, last.v * units.1],
        strobes: records[kept + 1..]
            .iter()
            .map(|r| LaneStrobe {
                q: r.x * units.0,
                v: r.v * units.1,
                force_n: f64::from(r.force) * c.force_unit_n,
                onsets: r.onsets,
            })
            .collect(),
    }
}

/// The regime over a window, whose first record opens it, by the rule of [`shared::model::regime::Detector`].
pub fn regime(window: &[StrobeRecord]) -> Regime {
    let periods = window.len() - 1;
    if !window[1..].iter().any(|r| r.touched) {
        return Regime::None;
    }
    let contacts = |end: usize, n: usize| {
        let sum = window[end + 1 - n..=end]
            .iter()
            .map(|r| u32::from(r.onsets));
        u16::try_from(sum.sum::<u32>()).unwrap_or(u16::MAX)
    };
    let repeats = |n: usize| {
        window.len() >= 2 * n
            && (n..=periods).all(|k| window[k].distance(&window[k - n]) <= SECTION_TOLERANCE)
            && (n + 1..=periods).all(|k| window[k].onsets == window[k - n].onsets)
    };
    let found = (1..=MAX_PERIODS.min(periods))
        .find(|n| repeats(*n))
        .map(|n| (contacts(periods, n), n as u8));
    let in_window = contacts(periods, MAX_PERIODS.min(periods));
    let chatters = window[1..]
        .iter()
        .rev()
        .take(MAX_PERIODS)
        .any(|r| r.chatter);
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

#[cfg(test)]
mod tests {
    use super::*;
    use shared::model::contacts::Period;
    use shared::model::regime::Detector;

    /// A window of made-up strobes: repeating after `n`, with noise of `amount`, some contacts, perhaps chatter.
    fn window(seed: u64, length: usize, n: usize, amount: f64, chatter: bool) -> Vec<StrobeRecord> {
        let mut state = seed;
        let mut random = move || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            (state >> 33) as f64 / f64::from(1_u32 << 31)
        };
        let orbit: Vec<_> = (0..n).map(|_| (random(), random(), random())).collect();
        (0..length)
            .map(|k| {
                let (x, v, onsets) = orbit[k % n];
                let onsets = (3.0 * onsets) as u16 + u16::from(random() < 0.01);
                StrobeRecord {
                    x: x + amount * random(),
                    v: v + amount * random(),
                    force: 1.0,
                    onsets,
                    touched: onsets > 0,
                    chatter: chatter && random() < 0.05,
                }
            })
            .collect()
    }

    #[test]
    fn regimes_are_those_of_the_detector() {
        let mut kinds = std::collections::BTreeSet::new();
        for seed in 0..4000_u64 {
            let n = 1 + (seed % 18) as usize;
            let length = 2 + (seed % 103) as usize;
            let amount = [0.0, 5e-4, 1.1e-3, 1.0][(seed / 7 % 4) as usize];
            let records = window(seed, length, n, amount, seed % 5 == 0);
            let mut detector = Detector::<f64>::new(1.0, 1.0);
            for r in &records {
                let period = Period {
                    onsets: r.onsets,
                    touched: r.touched,
                    chatter: r.chatter,
                    peak_force: 1.0,
                };
                detector.push(r.x, r.v, &period);
            }
            let found = regime(&records);
            assert_eq!(found, detector.regime(), "seed {seed}");
            kinds.insert(found.to_string());
        }
        assert!(kinds.len() > 20, "{kinds:?}");
    }

    fn decaying(ratio: f64, first: f64, cycles: usize) -> Vec<StrobeRecord> {
        let at = |k: usize| first * ratio.powi(k as i32);
        (0..=cycles)
            .map(|k| StrobeRecord {
                x: at(k),
                onsets: 1,
                touched: true,
                ..StrobeRecord::default()
            })
            .collect()
    }

    #[test]
    fn a_section_has_converged_only_when_what_is_left_is_small() {
        // After 40 cycles 7e-6 and 3e-5 are left.
        assert_eq!(converged(&decaying(0.9, 5e-4, 40), 1e-9), Some(16));
        assert_eq!(converged(&decaying(0.9, 2e-3, 40), 1e-9), None);
        // So slow that the small steps still add up.
        assert_eq!(converged(&decaying(0.999, 1e-2, 160), 1e-9), None);
    }
}
