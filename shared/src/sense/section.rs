//! The measured regime z = p/n.
//!
//! The model's detector ([`crate::model::regime::Detector`]) asks for a section that repeats to 1e-3; a measured one
//! never does. Here a drive period is described by what survives noise: the number of contacts, their
//! impulse, the phase of the first onset, and the observer's displacement and rate at drive phase 0. Over
//! a window of up to [`WINDOW`] periods every n up to [`LONGEST`] is tried: the periods are sorted into n
//! classes, and the scatter left within the classes is compared
//!
//! - with a bound: above it the section does not repeat with n;
//! - with the scatter left by multiples of n: if one of them explains much more (a ratio of variances that
//!   noise reaches practically never, and classes further apart than a floor), n is not enough. So a 2/2 differs
//!   from a noisy 1/1 by its alternation, not by its scatter.
//!
//! The smallest n that passes both is the answer. For n up to 5 one period in the window may have the
//! wrong number of contacts (one missed, or one too many); it and its successor are then left out.
//!
//! **Where a period is cut** matters: an onset that falls on the cut jitters to either side. Periods
//! are recorded twice, cut at drive phase 0 and at ½, and the record with fewer onsets near its cut decides.
//!
//! **Delay.** A period is entered a quarter turn after its cut. After a change of frequency the first answer
//! needs 4 periods; n needs min(3n, 16). When the regime changes by itself, the last [`RECENT`]
//! periods decide as soon as no n fits the whole window: 7 or 8 periods. No contact at all is
//! reported after 4 periods without contact.
//!
//! **Limits.** A doubling whose impulses alternate by less than 2.5 % either side of the mean, and whose onsets by
//! less than 0.002 turns, is called 1/n. Chatter is reported as the p/n that was counted: sticking is
//! not seen on the force signal.

mod fit;

use super::SensedRegime;
use crate::model::regime::Regime;
use fit::{Entry, FEATURES, SectionFit, fit_of};

/// Drive periods looked at.
pub const WINDOW: usize = 16;

/// Largest n tried, drive periods.
pub const LONGEST: usize = 8;

/// Periods that decide while a change of regime passes through the window.
pub const RECENT: usize = 8;

/// Ticks between two parts of the work: one part is up to 11,000 instructions (counted in QEMU), an answer takes 17, and
/// the two windows close a period half a drive period apart (385 ticks at 26 Hz).
const PAUSE: u8 = 19;

/// Fewest periods an answer rests on.
const FEWEST: usize = 4;

/// Scatter within classes up to which the section repeats: of the impulse (share of the mean), onset phase
/// (turns), displacement (of A0), rate (of A0 Ω).
const REPEATS: [f32; FEATURES] = [0.08, 0.012, 0.15, 0.15];

/// Distance between classes below which they count as one, same units.
const FLOOR: [f32; FEATURES] = [0.025, 0.002, 0.03, 0.04];

/// Onsets this near to the cut count against it, turns.
const NEAR: f32 = 0.08;

/// Periods cut at one drive phase.
#[derive(Clone, Copy, Debug, PartialEq)]
struct PeriodWindow {
    /// Closed periods, newest first.
    entries: [Entry; WINDOW],
    count: usize,
    /// Being filled: periods by (cycle of the cut) parity.
    open: [Entry; 2],
    fits: [[SectionFit; LONGEST]; 2],
    /// Next n to try: 0 to 2 · LONGEST; beyond: done.
    next: usize,
    measured: SensedRegime,
}

const NOTHING: SensedRegime = SensedRegime {
    regime: Regime::None,
    periods: 0,
};

impl PeriodWindow {
    const NEW: Self = Self {
        entries: [Entry {
            contacts: 0,
            near_cut: 0,
            features: [0.0; FEATURES],
        }; WINDOW],
        count: 0,
        open: [Entry {
            contacts: 0,
            near_cut: 0,
            features: [0.0; FEATURES],
        }; 2],
        fits: [[SectionFit {
            consistent: false,
            contacts: 0,
            variance: [0.0; FEATURES],
        }; LONGEST]; 2],
        next: usize::MAX,
        measured: NOTHING,
    };

    fn slot(&mut self, cycle: u32) -> &mut Entry {
        let [even, odd] = &mut self.open;
        if cycle & 1 == 0 { even } else { odd }
    }

    fn onset(&mut self, cycle: u32, turns: f32) {
        let entry = self.slot(cycle);
        if entry.contacts == 0 {
            entry.features[1] = turns;
        }
        entry.contacts = entry.contacts.saturating_add(1);
        if !(NEAR..=1.0 - NEAR).contains(&turns) {
            entry.near_cut = entry.near_cut.saturating_add(1);
        }
    }

    fn impulse(&mut self, cycle: u32, impulse_n_s: f32) {
        let entry = self.slot(cycle);
        // No onset entered: the contact outlasted its period's closing.
        if entry.contacts > 0 {
            entry.features[0] += impulse_n_s;
        }
    }

    fn close(&mut self, cycle: u32) {
        let entry = core::mem::take(self.slot(cycle));
        self.entries.rotate_right(1);
        if let Some(first) = self.entries.first_mut() {
            *first = entry;
        }
        self.count = (self.count + 1).min(WINDOW);
        self.next = 0;
    }

    fn near_cut(&self) -> u32 {
        let near = self.entries.iter().take(self.count);
        near.map(|entry| u32::from(entry.near_cut)).sum()
    }

    /// One n per call; at the end, the answer.
    fn work(&mut self) {
        let window = [self.count, self.count.min(RECENT)];
        let (which, n) = (self.next / LONGEST, self.next % LONGEST + 1);
        if let (Some(&count), Some(fits)) = (window.get(which), self.fits.get_mut(which)) {
            let entries = self.entries.get(..count).unwrap_or(&[]);
            if let Some(fit) = fits.get_mut(n - 1) {
                *fit = fit_of(entries, n);
            }
            self.next += 1;
        } else if which == 2 {
            self.next = usize::MAX;
            self.measured = self.evaluate();
        }
    }

    fn evaluate(&self) -> SensedRegime {
        let silent = self.entries.iter().take(self.count.min(FEWEST));
        let whole = self.count as u8;
        if silent.map(|entry| entry.contacts).all(|c| c == 0) && self.is_silent() {
            return SensedRegime {
                regime: Regime::None,
                periods: whole,
            };
        }
        let recent = self.count.min(RECENT);
        let [long, short] = &self.fits;
        for (fits, count) in [(long, self.count), (short, recent)] {
            if let Some((impacts, n)) = smallest(fits, count) {
                return SensedRegime {
                    regime: Regime::Periodic {
                        impacts,
                        periods: n as u8,
                    },
                    periods: count as u8,
                };
            }
        }
        let counted = self.entries.iter().take(self.count);
        SensedRegime {
            regime: Regime::Aperiodic {
                impacts: counted.map(|entry| u16::from(entry.contacts)).sum(),
            },
            periods: whole,
        }
    }

    /// Whether there was no contact for longer than between any two contacts in the window.
    fn is_silent(&self) -> bool {
        let entries = self.entries.get(..self.count).unwrap_or(&[]);
        let silence = entries.iter().take_while(|e| e.contacts == 0).count();
        let before = entries.get(silence..).unwrap_or(&[]);
        let (mut run, mut longest) = (0, 0);
        for entry in before {
            run = if entry.contacts == 0 { run + 1 } else { 0 };
            longest = longest.max(run);
        }
        before.is_empty() || silence > longest + 2
    }
}

/// The smallest n that repeats and that no multiple of it beats, with its contacts.
fn smallest(fits: &[SectionFit; LONGEST], count: usize) -> Option<(u16, usize)> {
    let usable = |n: usize| count >= FEWEST.max((3 * n).min(WINDOW));
    let found = (1..=LONGEST).zip(fits).find(|(n, fit)| {
        let repeats = fit.consistent
            && usable(*n)
            && fit.contacts > 0
            && fit.variance.iter().zip(&REPEATS).all(|(v, r)| *v <= r * r);
        repeats
            && !(1..=LONGEST)
                .zip(fits)
                .any(|(m, other)| m > *n && m % n == 0 && usable(m) && explains_more(fit, other, m))
    });
    found.map(|(n, fit)| (fit.contacts, n))
}

/// Whether n = `m` explains what `fit` leaves as scatter.
fn explains_more(fit: &SectionFit, other: &SectionFit, m: usize) -> bool {
    let ratio = match m {
        2 => 4.0,
        3 | 4 => 6.0,
        _ => 16.0,
    };
    other.consistent
        && fit
            .variance
            .iter()
            .zip(&other.variance)
            .zip(&FLOOR)
            .any(|((v, w), floor)| *v > ratio * *w && *v - *w > floor * floor)
}

/// The measured regime: fed with onsets, impulses and strobes, a little work per tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SensedSection {
    at_zero: PeriodWindow,
    at_half: PeriodWindow,
    /// Last quarter of the drive period seen, and its cycle.
    quarter: Option<(u32, u32)>,
    /// Closings to let pass: the period under way is not whole.
    skip: [u8; 2],
    /// One more of them after a start: the observer does not know the cart yet.
    fresh: bool,
    /// Ticks until the next part of the work.
    wait: u8,
}

impl Default for SensedSection {
    fn default() -> Self {
        Self {
            at_zero: PeriodWindow::NEW,
            at_half: PeriodWindow::NEW,
            quarter: None,
            skip: [1; 2],
            fresh: true,
            wait: 0,
        }
    }
}

impl SensedSection {
    /// Forgets what it saw; the period under way does not count.
    pub fn restart(&mut self) {
        *self = Self {
            fresh: false,
            ..Self::default()
        };
    }

    /// A contact began at drive phase `phase` (2⁻³² turns) of period `cycle`.
    pub fn onset(&mut self, cycle: u32, phase: u32) {
        self.at_zero.onset(cycle, turns(phase));
        let (cycle, phase) = half_later(cycle, phase);
        self.at_half.onset(cycle, turns(phase));
    }

    /// A contact that began then has ended, with this impulse, N·s.
    pub fn impulse(&mut self, cycle: u32, phase: u32, impulse_n_s: f32) {
        self.at_zero.impulse(cycle, impulse_n_s);
        let (cycle, _) = half_later(cycle, phase);
        self.at_half.impulse(cycle, impulse_n_s);
    }

    /// Displacement (in A0) and rate (in A0 Ω) at the start of period `cycle`.
    pub fn strobe(&mut self, cycle: u32, displacement: f32, rate: f32) {
        let set = |entry: &mut Entry| {
            entry.features[2] = displacement;
            entry.features[3] = rate;
        };
        // The period that this strobe opens, or that has it in its middle.
        set(self.at_zero.slot(cycle));
        set(self.at_half.slot(cycle));
    }

    /// Once per tick, with the drive's phase: closes periods and does a part of the work.
    #[inline]
    pub fn tick(&mut self, cycle: u32, phase: u32) {
        let now = (cycle, phase >> 30);
        if self.quarter != Some(now) {
            let first = self.quarter.is_none();
            self.quarter = Some(now);
            if first {
                // A start in the quarter before a closing: that one's period is over already.
                let least = 1 + u8::from(self.fresh);
                self.skip = [least + u8::from(now.1 == 0), least + u8::from(now.1 == 2)];
            } else {
                self.turn(now);
            }
        } else if self.wait > 0 {
            self.wait -= 1;
        } else if self.at_zero.next != usize::MAX {
            self.wait = PAUSE;
            self.at_zero.work();
        } else if self.at_half.next != usize::MAX {
            self.wait = PAUSE;
            self.at_half.work();
        }
    }

    fn turn(&mut self, (cycle, quarter): (u32, u32)) {
        let [zero, half] = &mut self.skip;
        // Cut at 0: period `cycle − 1` is entered a quarter turn into `cycle`. Cut at ½: period `cycle`, from ½ of
        // `cycle − 1` to ½ of `cycle`, is entered at ¾.
        match quarter {
            1 if *zero > 0 => {
                *zero -= 1;
                *self.at_zero.slot(cycle.wrapping_sub(1)) = Entry::default();
            }
            1 => self.at_zero.close(cycle.wrapping_sub(1)),
            3 if *half > 0 => {
                *half -= 1;
                *self.at_half.slot(cycle) = Entry::default();
            }
            3 => self.at_half.close(cycle),
            _ => {}
        }
    }

    /// The regime by the record with fewer onsets near its cut; at drive phase 0 if they are equal.
    pub fn measured(&self) -> SensedRegime {
        if self.at_half.near_cut() < self.at_zero.near_cut() {
            self.at_half.measured
        } else {
            self.at_zero.measured
        }
    }
}

/// This instant (cycle and phase) in periods cut at ½, numbered by the drive phase 0 in their middle.
fn half_later(cycle: u32, phase: u32) -> (u32, u32) {
    let (phase, wrapped) = phase.overflowing_add(1 << 31);
    (cycle.wrapping_add(u32::from(wrapped)), phase)
}

fn turns(phase: u32) -> f32 {
    phase as f32 * (1.0 / 4_294_967_296.0)
}

#[cfg(test)]
mod tests;
