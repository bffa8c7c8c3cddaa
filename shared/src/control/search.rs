//! Seek and Hold: where the frequency goes.
//!
//! Seek goes to a frequency at which a start from rest comes to strike (the entry). As soon as there is one contact per
//! drive period, the frequency follows the phase of the contacts ([`super::lock`]). Hold is the same with the phase at its
//! goal; now and then a short climb corrects that goal ([`super::probe`]). Both stay within the stable band of the newest
//! forecast.

use super::lock::PhaseLock;
use super::probe::PhaseProbe;
use crate::forecast::Target;
use crate::model::regime::Regime;
use crate::sense::Strobe;
use crate::settings::TICK_S;

/// Distance kept from the ends of the forecast's stable band, relative.
const BAND_MARGIN: f32 = 0.03;
/// Distance kept from the forecast's doubling, relative.
const CLEARANCE: f32 = 0.04;
/// Drive periods with one contact each, in a row, after which the frequency follows their phase.
const LOCK_PERIODS: u8 = 3;
/// Drive periods at the entry without that, after which the entry is sought elsewhere.
const PATIENCE_PERIODS: u8 = 8;
/// Step of that search, relative, per drive period.
const WANDER: f32 = 0.015;
/// Lowest frequency of that search, relative to the forecast's entry.
const LOWEST_ENTRY: f32 = 0.55;
/// Weight of a drive period in the mean number of contacts per period.
const RATE_WEIGHT: f32 = 0.125;
/// Contacts per period above which the entry lies too low (chatter), and hence below which it lies too high.
const CROWDED: f32 = 1.3;
/// Largest phase error of a contact in Hold's reach, turns (5°, at which the impulse is 0.4 % below the strongest).
const NEAR_TURNS: f32 = 5.0 / 360.0;
/// Contacts in a row that near, or at a bound, after which the optimum is found.
const FOUND_PERIODS: u8 = 4;
/// Drive periods from Hold to the first climb, and between two.
const FIRST_CLIMB: u16 = 96;
const CLIMB_EVERY: u16 = 1024;
/// A drive period without exactly one contact adds this; one with, takes one off.
const BAD_WEIGHT: u8 = 2;
/// In Hold the drive period is made so many ticks longer and shorter in turn, for so many periods each (a power of two): where the samples
/// fall in a contact decides by up to 1 % what they show of its peak, and would stay the same for a minute where the period is a whole
/// number of ticks.
const DITHER: f32 = 0.25;
const DITHER_PERIODS: u16 = 8;
/// A loss within so many good drive periods of the one before is no accident: the phase retreats.
const AGAIN_PERIODS: u8 = 48;
/// At this the regime is lost: eight bad periods in a row, or more bad ones than a third.
const LOST_AT: u8 = 16;
/// Drive periods a doubling must be seen before it is believed: noise alternates for a while, too.
const DOUBLED_PERIODS: u8 = 16;

/// The phases of the search.
#[derive(Clone, Copy, Debug)]
enum SearchLeg {
    /// On the way to the entry, or waiting there for 1/1.
    Entry {
        periods: u8,
        one_one: u8,
        /// Mean number of contacts per period.
        rate: f32,
    },
    /// The frequency follows the phase.
    Locked { near: u8 },
    /// Holding, with so many drive periods to go until the next climb.
    Rest { periods: u16 },
    /// Holding, while a climb looks for the phase of the strongest contact.
    Climb(PhaseProbe),
}

impl SearchLeg {
    const ENTRY: Self = Self::Entry {
        periods: 0,
        one_one: 0,
        rate: 1.0,
    };
}

/// What a drive period has shown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Beat {
    /// Contacts that began in it.
    pub contacts: u16,
    /// Impulse of its contacts, N·s.
    pub impulse_n_s: f32,
    /// Phase of the last onset against the measured motion of the cart, turns.
    pub phase_turns: f32,
    /// Regime z = p/n, as measured last.
    pub regime: Regime,
}

impl Beat {
    /// Of a strobe, the drive phase of the last onset, and the regime.
    pub fn new(strobe: &Strobe, onset_turns: f32, regime: Regime) -> Self {
        Self {
            contacts: strobe.contacts,
            impulse_n_s: strobe.impulse_n_s,
            phase_turns: onset_turns - strobe.lag_rad * (0.5 * core::f32::consts::FRAC_1_PI),
            regime,
        }
    }
}

/// The effect of a drive period on the search.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SearchStep {
    /// Nothing to report: the search goes on.
    On,
    /// The best frequency is found (`found`: Seek is over with it) or corrected by a climb.
    Best {
        /// Drive frequency of this period, Hz.
        frequency_hz: f32,
        /// Impulse per contact, N·s.
        impulse_n_s: f32,
        /// Whether Seek is over with it.
        found: bool,
    },
    /// 1/1 is lost and sought again from the entry.
    Lost,
    /// The period doubled at this frequency, Hz: the search retreats from it.
    Doubling(f32),
}

/// The search for the operating frequency.
#[derive(Clone, Copy, Debug)]
pub struct Search {
    leg: SearchLeg,
    lock: PhaseLock,
    entry_hz: f32,
    floor_hz: f32,
    ceiling_hz: f32,
    range_hz: (f32, f32),
    goal_hz: f32,
    bad: u8,
    doubled: u8,
    /// Drive periods with one contact since 1/1 was lost last.
    good: u8,
}

impl Search {
    /// A search for `target` between the limits `range_hz`; `power`: for the most impact power.
    pub fn new(target: &Target, range_hz: (f32, f32), power: bool) -> Self {
        let mut search = Self {
            leg: SearchLeg::ENTRY,
            lock: PhaseLock::new(target.orbit.onset_turns, power),
            entry_hz: target.entry_hz,
            floor_hz: range_hz.0,
            ceiling_hz: range_hz.1,
            range_hz,
            goal_hz: target.entry_hz,
            bad: 0,
            doubled: 0,
            good: u8::MAX,
        };
        search.set_bounds(target, range_hz);
        search.goal_hz = search.entry_hz;
        search
    }

    /// The goal of the frequency, Hz.
    pub fn goal_hz(&self) -> f32 {
        self.goal_hz
    }

    /// Whether the frequency follows the phase and has found it; also while a climb corrects it.
    pub fn has_found(&self) -> bool {
        matches!(self.leg, SearchLeg::Rest { .. } | SearchLeg::Climb(_))
    }

    /// Whether a bound holds the goal.
    pub fn is_at_bound(&self) -> bool {
        self.goal_hz <= self.floor_hz || self.goal_hz >= self.ceiling_hz
    }

    /// A new forecast: its phase, band and entry count from now on.
    pub fn retarget(&mut self, target: &Target, range_hz: (f32, f32)) {
        self.lock.retarget(target.orbit.onset_turns);
        self.set_bounds(target, range_hz);
        if matches!(self.leg, SearchLeg::Entry { .. }) {
            self.enter();
        }
    }

    fn set_bounds(&mut self, target: &Target, range_hz: (f32, f32)) {
        let (low, high) = target.band_hz;
        let top = match target.doubling_hz {
            Some(hz) => hz * (1.0 - CLEARANCE),
            None => high * (1.0 - BAND_MARGIN),
        };
        self.range_hz = range_hz;
        self.floor_hz = (low * (1.0 + BAND_MARGIN)).max(range_hz.0).min(range_hz.1);
        self.ceiling_hz = top.min(range_hz.1).max(self.floor_hz);
        self.entry_hz = target.entry_hz.max(range_hz.0).min(range_hz.1);
    }

    fn enter(&mut self) {
        self.leg = SearchLeg::ENTRY;
        self.goal_hz = self.entry_hz;
    }

    /// A drive period has ended at `frequency_hz`; `arrived`: at the goal frequency.
    pub fn strobe(&mut self, beat: &Beat, frequency_hz: f32, arrived: bool) -> SearchStep {
        if let SearchLeg::Entry {
            periods,
            one_one,
            rate,
        } = self.leg
        {
            self.at_entry(beat, arrived, (periods, one_one, rate));
            return SearchStep::On;
        }
        let good = beat.contacts == 1;
        self.bad = if good {
            self.bad.saturating_sub(1)
        } else {
            self.bad.saturating_add(BAD_WEIGHT)
        };
        if self.bad >= LOST_AT {
            return self.mark_lost();
        }
        if !good {
            return SearchStep::On;
        }
        self.lock.pass();
        self.good = self.good.saturating_add(1);
        if self.has_doubled(beat.regime) {
            self.lock.retreat();
            return SearchStep::Doubling(frequency_hz);
        }
        self.follow(beat, frequency_hz)
    }

    fn at_entry(&mut self, beat: &Beat, arrived: bool, (periods, one_one, rate): (u8, u8, f32)) {
        let one_one = if beat.contacts == 1 { one_one + 1 } else { 0 };
        if one_one >= LOCK_PERIODS {
            self.bad = 0;
            self.doubled = 0;
            self.leg = SearchLeg::Locked { near: 0 };
            return;
        }
        let rate = rate + RATE_WEIGHT * (f32::from(beat.contacts) - rate);
        let patient = periods < PATIENCE_PERIODS;
        self.leg = SearchLeg::Entry {
            periods: periods.saturating_add(u8::from(patient && arrived)),
            one_one,
            rate,
        };
        if patient || !arrived {
            return;
        }
        // Chatter lies below 1/1, contacts in fewer periods than all above it.
        let step = if rate > CROWDED { WANDER } else { -WANDER };
        self.goal_hz *= 1.0 + step;
        let lowest = self.range_hz.0.max(LOWEST_ENTRY * self.entry_hz);
        if self.goal_hz < lowest || self.goal_hz > self.range_hz.1 {
            self.enter();
        }
    }

    /// A contact of 1/1 whose phase corrects the frequency.
    fn follow(&mut self, beat: &Beat, frequency_hz: f32) -> SearchStep {
        let mut step = SearchStep::On;
        let best = |found| SearchStep::Best {
            frequency_hz,
            impulse_n_s: beat.impulse_n_s,
            found,
        };
        let (mut offset, at_bound) = (0.0, self.is_at_bound());
        match &mut self.leg {
            SearchLeg::Climb(probe) => {
                offset = probe.offset_turns();
                if let Some(distance) = probe.strobe(beat.impulse_n_s) {
                    self.lock.correct(distance);
                    self.leg = SearchLeg::Rest {
                        periods: CLIMB_EVERY,
                    };
                    step = best(false);
                }
            }
            // At a bound there is nothing to climb.
            SearchLeg::Rest { periods: 0 } if !at_bound => {
                self.leg = SearchLeg::Climb(PhaseProbe::default());
            }
            SearchLeg::Rest { periods } => {
                *periods = periods.saturating_sub(1);
                let later = *periods & DITHER_PERIODS == 0;
                offset = if later { DITHER } else { -DITHER } * frequency_hz * TICK_S as f32;
            }
            SearchLeg::Locked { .. } | SearchLeg::Entry { .. } => {}
        }
        let error = self.lock.error_turns(beat.phase_turns, offset);
        let hz = self.lock.next_hz(frequency_hz, error);
        if hz.is_finite() {
            self.goal_hz = hz.max(self.floor_hz).min(self.ceiling_hz);
        }
        let is_near = libm::fabsf(error) < NEAR_TURNS || self.is_at_bound();
        if let SearchLeg::Locked { near } = &mut self.leg {
            *near = if is_near { *near + 1 } else { 0 };
            if *near >= FOUND_PERIODS {
                self.leg = SearchLeg::Rest {
                    periods: FIRST_CLIMB,
                };
                step = best(true);
            }
        }
        step
    }

    fn has_doubled(&mut self, regime: Regime) -> bool {
        let doubled = match regime {
            Regime::Periodic { impacts, periods } => {
                periods >= 2 && periods % 2 == 0 && impacts == u16::from(periods)
            }
            _ => false,
        };
        self.doubled = if doubled { self.doubled + 1 } else { 0 };
        let believed = self.doubled >= DOUBLED_PERIODS;
        if believed {
            self.doubled = 0;
        }
        believed
    }

    fn mark_lost(&mut self) -> SearchStep {
        if self.good < AGAIN_PERIODS {
            self.lock.retreat();
        }
        self.good = 0;
        self.bad = 0;
        self.lock.lose();
        self.enter();
        SearchStep::Lost
    }
}

#[cfg(test)]
mod tests;
