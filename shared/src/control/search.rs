//! Seek and Hold: where the frequency goes.
//!
//! Seek goes to a frequency from which a start from rest comes to strike (the entry), follows the 1/1 to
//! the forecast's target, and climbs from there on measured force. Hold waits at the best frequency and
//! climbs again, in narrow steps, for as long as it runs. Both stay within the stable band, away from the
//! doubling and from where the regime was once lost.

use super::climb::{Advice, Climb, Probe};
use crate::forecast::Target;
use crate::model::regime::Regime;
use crate::sense::Strobe;

/// Distance kept from the ends of the forecast's stable band, relative.
const BAND_MARGIN: f32 = 0.03;
/// Distance kept from a doubling, forecast or met, and from where the regime was lost.
const CLEARANCE: f32 = 0.04;
/// Drive periods at the entry until the hammer must be striking, and at the target until it must be 1/1.
const SETTLE_PERIODS: u16 = 24;
/// Drive periods at the best frequency between two climbs of Hold.
const REST_PERIODS: u16 = 64;
/// A drive period without exactly one contact adds this; one with, takes one off.
const BAD_WEIGHT: u8 = 2;
/// At this the regime is lost: eight bad periods in a row, or more bad ones than a third.
const LOST_AT: u8 = 16;
/// A climb that moves less than this many steps has found the top.
const FOUND_STEPS: f32 = 0.5;
/// Drive periods a doubling must be seen before it is believed: noise alternates for a while, too.
const DOUBLED_PERIODS: u8 = 16;
/// Most climbs in Seek: an optimum that keeps moving is followed in Hold.
const MAX_CLIMBS: u8 = 6;

/// The phases of the search.
#[derive(Clone, Copy, Debug)]
enum SearchLeg {
    /// On the way to the entry, or waiting there for the hammer to strike.
    Entry { periods: u16 },
    /// On the way to the target, or settling there.
    Target { periods: u16 },
    /// Climbing.
    Climb(Climb),
    /// Waiting at the best frequency.
    Rest { periods: u16 },
}

/// The effect of a strobe on the search.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Step {
    /// Nothing to report.
    On,
    /// A climb has ended at this best frequency, Hz, with this impulse, N·s.
    Best {
        /// Frequency, Hz.
        frequency_hz: f32,
        /// Impulse per contact, N·s.
        impulse_n_s: f32,
        /// Whether Seek is over with it.
        found: bool,
    },
    /// 1/1 is lost and sought again from the entry.
    Lost,
    /// The period doubled at this frequency, Hz: the search keeps away from it.
    Doubling(f32),
}

/// The search for the operating frequency.
#[derive(Clone, Copy, Debug)]
pub struct Search {
    leg: SearchLeg,
    holding: bool,
    entry_hz: f32,
    best_hz: f32,
    floor_hz: f32,
    ceiling_hz: f32,
    /// Bounds met while searching, beside the forecast ones.
    met_ceiling_hz: f32,
    met_floor_hz: f32,
    goal_hz: f32,
    bad: u8,
    lost_at_rest: u8,
    doubled: u8,
    climbs: u8,
}

impl Search {
    /// A search for `target` between the limits `range_hz`.
    pub fn new(target: &Target, range_hz: (f32, f32)) -> Self {
        let mut search = Self {
            leg: SearchLeg::Entry { periods: 0 },
            holding: false,
            entry_hz: target.entry_hz,
            best_hz: target.frequency_hz,
            floor_hz: range_hz.0,
            ceiling_hz: range_hz.1,
            met_ceiling_hz: range_hz.1,
            met_floor_hz: range_hz.0,
            goal_hz: target.entry_hz,
            bad: 0,
            lost_at_rest: 0,
            doubled: 0,
            climbs: 0,
        };
        search.set_bounds(target, range_hz);
        search.goal_hz = search.entry_hz;
        search
    }

    /// The goal of the frequency, Hz.
    pub fn goal_hz(&self) -> f32 {
        self.goal_hz
    }

    /// Whether a bound holds the goal.
    pub fn is_at_bound(&self) -> bool {
        self.goal_hz <= self.floor_hz || self.goal_hz >= self.ceiling_hz
    }

    /// A new forecast: sets the bounds anew. While seeking, the search goes to the new target, unless it climbs
    /// near it already.
    pub fn retarget(&mut self, target: &Target, range_hz: (f32, f32)) {
        self.set_bounds(target, range_hz);
        if self.holding {
            self.best_hz = self.within_bounds(self.best_hz);
            return;
        }
        let target_hz = self.within_bounds(target.frequency_hz);
        let near = libm::fabsf(target_hz - self.best_hz) <= Probe::SEEK.step * target_hz;
        match self.leg {
            SearchLeg::Climb(_) if near => {}
            SearchLeg::Entry { .. } => {
                self.best_hz = target_hz;
                self.goal_hz = self.entry_hz;
            }
            _ => {
                self.best_hz = target_hz;
                self.leg = SearchLeg::Target { periods: 0 };
                self.goal_hz = target_hz;
            }
        }
    }

    fn set_bounds(&mut self, target: &Target, range_hz: (f32, f32)) {
        let (low, high) = target.band_hz;
        let top = match target.doubling_hz {
            Some(hz) => hz * (1.0 - CLEARANCE),
            None => high * (1.0 - BAND_MARGIN),
        };
        self.floor_hz = (low * (1.0 + BAND_MARGIN)).max(range_hz.0);
        self.ceiling_hz = top.min(range_hz.1).max(self.floor_hz);
        self.entry_hz = target.entry_hz.max(range_hz.0).min(range_hz.1);
        self.best_hz = self.within_bounds(self.best_hz);
    }

    /// `hz` within the forecast bounds and those met.
    fn within_bounds(&self, hz: f32) -> f32 {
        let floor = self.floor_hz.max(self.met_floor_hz);
        let ceiling = self.ceiling_hz.min(self.met_ceiling_hz).max(floor);
        hz.max(floor).min(ceiling)
    }

    /// A drive period has ended at `frequency_hz`; `arrived`: at the goal frequency and amplitude.
    pub fn strobe(
        &mut self,
        strobe: &Strobe,
        regime: Regime,
        frequency_hz: f32,
        arrived: bool,
    ) -> Step {
        let good = strobe.contacts == 1;
        let watched = !matches!(self.leg, SearchLeg::Entry { .. });
        if watched {
            self.bad = if good {
                self.bad.saturating_sub(1)
            } else {
                self.bad.saturating_add(BAD_WEIGHT)
            };
            if self.bad >= LOST_AT {
                return self.mark_lost(frequency_hz);
            }
        }
        if !arrived {
            return Step::On;
        }
        if watched && let Some(step) = self.doubled(regime) {
            return step;
        }
        match self.leg {
            SearchLeg::Entry { periods } => self.at_entry(periods, strobe.contacts),
            SearchLeg::Target { periods } => self.at_target(periods),
            SearchLeg::Climb(climb) => self.climb(climb, strobe, good),
            SearchLeg::Rest { periods } => {
                self.leg = if periods < REST_PERIODS {
                    SearchLeg::Rest {
                        periods: periods + 1,
                    }
                } else {
                    self.lost_at_rest = 0;
                    self.start_climb()
                };
                Step::On
            }
        }
    }

    fn at_entry(&mut self, periods: u16, contacts: u16) -> Step {
        // Counts striking periods up, others down to none.
        let periods = if contacts > 0 {
            periods + 1
        } else {
            periods.saturating_sub(1)
        };
        self.leg = SearchLeg::Entry { periods };
        if periods >= SETTLE_PERIODS {
            self.bad = 0;
            self.leg = SearchLeg::Target { periods: 0 };
            self.goal_hz = self.best_hz;
        }
        Step::On
    }

    fn at_target(&mut self, periods: u16) -> Step {
        if periods < SETTLE_PERIODS {
            self.leg = SearchLeg::Target {
                periods: periods + 1,
            };
        } else {
            self.climbs = 0;
            self.leg = self.start_climb();
        }
        Step::On
    }

    fn climb(&mut self, mut climb: Climb, strobe: &Strobe, good: bool) -> Step {
        // Only periods with one contact count: others would bend the parabola.
        let advice = if good {
            climb.strobe(strobe.impulse_n_s)
        } else {
            Advice::Stay
        };
        self.leg = SearchLeg::Climb(climb);
        match advice {
            Advice::Stay => Step::On,
            Advice::Go(hz) => {
                self.goal_hz = hz;
                Step::On
            }
            Advice::Top {
                frequency_hz,
                moved,
                impulse_n_s,
            } => self.finish_climb(frequency_hz, moved, impulse_n_s),
        }
    }

    fn finish_climb(&mut self, frequency_hz: f32, moved: f32, impulse_n_s: f32) -> Step {
        let top_hz = self.within_bounds(frequency_hz);
        let held = libm::fabsf(top_hz - self.best_hz) < FOUND_STEPS * Probe::SEEK.step * top_hz;
        self.best_hz = top_hz;
        self.goal_hz = top_hz;
        self.climbs = self.climbs.saturating_add(1);
        let found = libm::fabsf(moved) < FOUND_STEPS || held || self.climbs >= MAX_CLIMBS;
        if self.holding || found {
            let first = !self.holding;
            self.holding = true;
            self.leg = SearchLeg::Rest { periods: 0 };
            return Step::Best {
                frequency_hz: top_hz,
                impulse_n_s,
                found: first,
            };
        }
        self.leg = self.start_climb();
        Step::Best {
            frequency_hz: top_hz,
            impulse_n_s,
            found: false,
        }
    }

    /// A climb about the best frequency, moved so that all three of its points are clear.
    fn start_climb(&mut self) -> SearchLeg {
        let probe = if self.holding {
            Probe::HOLD
        } else {
            Probe::SEEK
        };
        let lowest = self.within_bounds(0.0);
        let highest = self.within_bounds(f32::MAX);
        let middle = self
            .best_hz
            .min(highest / (1.0 + probe.step))
            .max(lowest / (1.0 - probe.step));
        let climb = Climb::new(probe, middle);
        self.goal_hz = climb.frequency_hz();
        SearchLeg::Climb(climb)
    }

    fn doubled(&mut self, regime: Regime) -> Option<Step> {
        let doubled = match regime {
            Regime::Periodic { impacts, periods } => {
                periods >= 2 && periods % 2 == 0 && impacts == u16::from(periods)
            }
            _ => false,
        };
        self.doubled = if doubled {
            self.doubled.saturating_add(1)
        } else {
            0
        };
        if self.doubled < DOUBLED_PERIODS {
            return None;
        }
        self.doubled = 0;
        let seen_hz = self.goal_hz;
        if seen_hz >= self.best_hz {
            self.met_ceiling_hz = seen_hz * (1.0 - CLEARANCE);
        } else {
            self.met_floor_hz = seen_hz * (1.0 + CLEARANCE);
        }
        self.best_hz = self.within_bounds(self.best_hz);
        self.goal_hz = self.best_hz;
        self.leg = SearchLeg::Target { periods: 0 };
        Some(Step::Doubling(seen_hz))
    }

    fn mark_lost(&mut self, lost_hz: f32) -> Step {
        // Lost away from the best frequency: the edge lies on that side. Lost at it twice in a row: the same.
        // On the way from the entry, the edge lies ahead.
        let at_rest = matches!(self.leg, SearchLeg::Rest { .. });
        if at_rest {
            self.lost_at_rest = self.lost_at_rest.saturating_add(1);
        }
        if !at_rest || self.lost_at_rest > 1 {
            let on_the_way_up =
                matches!(self.leg, SearchLeg::Target { .. }) && self.entry_hz <= self.best_hz;
            if on_the_way_up || lost_hz >= self.best_hz {
                self.met_ceiling_hz = self.met_ceiling_hz.min(lost_hz * (1.0 - CLEARANCE));
            } else {
                self.met_floor_hz = self.met_floor_hz.max(lost_hz * (1.0 + CLEARANCE));
            }
        }
        self.best_hz = self.within_bounds(self.best_hz);
        self.bad = 0;
        self.holding = false;
        self.leg = SearchLeg::Entry { periods: 0 };
        self.goal_hz = self.entry_hz;
        Step::Lost
    }
}
