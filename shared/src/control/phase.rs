//! The controller's state with the data that belongs to it.

use super::proof::Proof;
use super::search::Search;
use super::self_test::SelfTest;
use super::{Mode, State};
use crate::settings::ticks_of;

/// Drive periods with one contact each, in a row, after which 1/1 counts as regained.
const REGAINED_PERIODS: u8 = 8;
/// Times the limit without 1/1 after which a search that never comes to Hold ends, too.
const SOUGHT: f32 = 2.0;
/// The same share of it without a single contact since the start, while a limit reduces the amplitude: what the force sensor does not show
/// may be beyond the limit, and a search has been where the hammer must strike by then.
const BLIND: f32 = 0.25;

/// What the controller is doing, with what it needs for it.
#[derive(Clone, Copy, Debug, Default)]
pub(super) enum Phase {
    #[default]
    Idle,
    SelfTest(SelfTestStart),
    /// The small motion that proves the sensors, then waiting for the forecast.
    Prove(Proof),
    /// The amplitude rises; then the search takes over, or manual set-points without one.
    Ramp(Option<Search>),
    Seek(Seeking),
    Hold(Seeking),
    Stop,
    Fault,
    Manual,
}

impl Phase {
    /// The [`State`] that is reported of this phase.
    pub fn state(&self) -> State {
        match self {
            Self::Idle => State::Idle,
            Self::SelfTest(_) => State::SelfTest,
            Self::Prove(_) => State::Prove,
            Self::Ramp(_) => State::Ramp,
            Self::Seek(_) => State::Seek,
            Self::Hold(_) => State::Hold,
            Self::Stop => State::Stop,
            Self::Fault => State::Fault,
            Self::Manual => State::Manual,
        }
    }

    /// Whether the drive is enabled.
    pub fn is_driving(&self) -> bool {
        matches!(
            self,
            Self::Prove(_)
                | Self::Ramp(_)
                | Self::Seek(_)
                | Self::Hold(_)
                | Self::Stop
                | Self::Manual
        )
    }

    /// Whether set-points are given by hand.
    pub fn is_manual(&self) -> bool {
        match self {
            Self::Ramp(None) | Self::Manual => true,
            Self::Prove(proof) => proof.mode == Mode::Manual,
            _ => false,
        }
    }

    /// The search, from the ramp on.
    pub fn search_mut(&mut self) -> Option<&mut Search> {
        match self {
            Self::Ramp(search) => search.as_mut(),
            Self::Seek(seeking) | Self::Hold(seeking) => Some(&mut seeking.search),
            _ => None,
        }
    }

    /// The search and its times, while it runs.
    pub fn seeking_mut(&mut self) -> Option<&mut Seeking> {
        match self {
            Self::Seek(seeking) | Self::Hold(seeking) => Some(seeking),
            _ => None,
        }
    }
}

/// A start: the self test, and who is to choose the frequency after it.
#[derive(Clone, Copy, Debug)]
pub(super) struct SelfTestStart {
    pub mode: Mode,
    pub test: SelfTest,
}

/// The search, and how long it has been without what it needs.
#[derive(Clone, Copy, Debug)]
pub(super) struct Seeking {
    pub search: Search,
    ticks_without_one_one: u32,
    /// Ticks in Seek since the last Hold.
    ticks_sought: u32,
    /// Whether there has been a contact.
    touched: bool,
    /// Drive periods in a row with one contact each.
    one_one_periods: u8,
}

impl Seeking {
    pub fn new(search: Search) -> Self {
        Self {
            search,
            ticks_without_one_one: 0,
            ticks_sought: 0,
            touched: false,
            one_one_periods: 0,
        }
    }

    /// A drive period has ended with this many contacts.
    pub fn strobe(&mut self, contacts: u16) {
        self.touched |= contacts > 0;
        self.one_one_periods = if contacts == 1 {
            self.one_one_periods.saturating_add(1)
        } else {
            0
        };
        if self.one_one_periods >= REGAINED_PERIODS {
            self.ticks_without_one_one = 0;
        }
    }

    /// A block has passed, in Hold or not. Whether there was no 1/1 for longer than `limit_s`, no Hold for [`SOUGHT`] times that, or not
    /// one contact for [`BLIND`] of it and a limit reduces the amplitude (`limited`).
    pub fn has_failed(&mut self, ticks: u32, held: bool, limited: bool, limit_s: f32) -> bool {
        self.ticks_without_one_one = self.ticks_without_one_one.saturating_add(ticks);
        self.ticks_sought = if held {
            0
        } else {
            self.ticks_sought.saturating_add(ticks)
        };
        self.ticks_without_one_one > ticks_of(limit_s)
            || self.ticks_sought > ticks_of(SOUGHT * limit_s)
            || (limited && !self.touched && self.ticks_without_one_one > ticks_of(BLIND * limit_s))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::forecast::{ForecastOrbit, Target};

    #[test]
    fn one_one_that_does_not_come_back_is_missed_after_the_limit() {
        let orbit = ForecastOrbit {
            force_n: 96.0,
            impulse_n_s: 0.031,
            approach_m_per_s: 0.08,
            onset_turns: 0.4,
            multiplier: 0.3,
            doubling_test: 0.9,
        };
        let target = Target {
            frequency_hz: 3.6,
            orbit,
            band_hz: (2.5, 4.8),
            doubling_hz: None,
            entry_hz: 3.6,
        };
        let second = ticks_of(1.0);
        let mut seeking = Seeking::new(Search::new(&target, (1.4, 7.3), false));
        let strobes = |seeking: &mut Seeking, contacts: [u16; 8]| {
            for number in contacts {
                seeking.strobe(number);
            }
        };
        assert!(!seeking.has_failed(second / 4, false, true, 1.0));
        assert!(!seeking.has_failed(1, false, false, 1.0), "nothing limited");
        assert!(seeking.has_failed(1, false, true, 1.0), "not one contact");
        let mut seeking = Seeking::new(Search::new(&target, (1.4, 7.3), false));
        assert!(!seeking.has_failed(second - 10, true, false, 1.0));
        // Eight drive periods with one contact each bring it back.
        strobes(&mut seeking, [1; 8]);
        strobes(&mut seeking, [0; 8]);
        assert!(!seeking.has_failed(second - 10, true, false, 1.0));
        // Seven do not.
        strobes(&mut seeking, [1, 1, 1, 1, 1, 1, 1, 0]);
        strobes(&mut seeking, [1, 1, 1, 1, 1, 1, 1, 2]);
        assert!(
            !seeking.has_failed(10, true, false, 1.0),
            "exactly the limit"
        );
        assert!(seeking.has_failed(1, true, false, 1.0));
        assert!(seeking.has_failed(1, true, false, 1.0));
        // 1/1 that is never near its goal: Seek ends, and Hold begins its time anew.
        let mut seeking = Seeking::new(Search::new(&target, (1.4, 7.3), false));
        let mut passes = |ticks: u32, held: bool| {
            strobes(&mut seeking, [1; 8]);
            seeking.has_failed(ticks, held, false, 1.0)
        };
        assert!(!passes(second - 10, false) && !passes(second - 10, false));
        assert!(!passes(10, true));
        assert!(!passes(second - 10, false) && !passes(second - 10, false));
        assert!(passes(21, false));
    }
}
