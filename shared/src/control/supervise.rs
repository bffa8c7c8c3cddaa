//! The states, and what leads from one to another.

use super::controller::{Controller, ticks_of};
use super::event::EventKind;
use super::guard::Trip;
use super::search::Search;
use super::self_test::{SelfTest, Zero};
use super::trim::Trim;
use super::{ActiveLimits, Basin, Mode, Refused, State};
use crate::fault::{Fault, Record};

/// How long a start waits for the forecast, s.
const FORECAST_PATIENCE_S: f32 = 120.0;

impl Controller {
    /// Once per block: times that run out, states that follow from others.
    pub(super) fn supervise(&mut self, ticks: usize) {
        self.timers.overruns = self.timers.overruns.saturating_sub(1);
        let ticks = ticks as u32;
        self.timers.in_state = self.timers.in_state.saturating_add(ticks);
        let trips = self.settings.trips;
        self.timers.since_alive = self.timers.since_alive.saturating_add(ticks);
        let silent = trips.link_timeout_s > 0.0
            && self.timers.remote
            && self.is_driving()
            && self.timers.since_alive > ticks_of(trips.link_timeout_s);
        if silent {
            self.trip(Trip::system(Fault::LinkTimeout, trips.link_timeout_s));
        }
        match self.state {
            State::SelfTest => {}
            State::Ramp if self.oscillator.has_arrived() => self.ramped(),
            State::Seek | State::Hold => self.check_contacts(ticks),
            State::Stop if self.oscillator.amplitude_m() <= 0.0 => self.change(State::Idle),
            _ => {}
        }
        let limits = self.limits;
        self.limits = match self.state {
            State::Seek | State::Hold | State::Manual => {
                (limits & ActiveLimits::FREQUENCY) | self.trim.limits()
            }
            _ => ActiveLimits::NONE,
        };
        if self.limits != self.told_limits {
            self.told_limits = self.limits;
            self.events.push(self.tick, EventKind::Limits(self.limits));
        }
    }

    /// The two faults of a hammer that does not do what it should.
    pub(super) fn check_contacts(&mut self, ticks: u32) {
        let trips = self.settings.trips;
        let hz = self.oscillator.frequency_hz();
        if self.forecast.must_strike_at(hz) {
            self.timers.since_contact = self.timers.since_contact.saturating_add(ticks);
        }
        if self.timers.since_contact > ticks_of(trips.no_contact_s) {
            self.trip(Trip::system(Fault::NoContact, trips.no_contact_s));
            return;
        }
        self.timers.since_one_one = self.timers.since_one_one.saturating_add(ticks);
        if self.timers.since_one_one > ticks_of(trips.regime_lost_s) {
            self.trip(Trip::system(Fault::RegimeLost, trips.regime_lost_s));
        }
    }

    /// The self test has found the zeros.
    pub(super) fn tested(&mut self, zero: Zero) {
        let rest_m = zero.relative_m.unwrap_or(0.0);
        self.sense.set_zero(zero.force_n, rest_m);
        self.guard.set_force_is_live(zero.force_is_live);
        if self.mode == Mode::Automatic {
            let patient = self.timers.in_state < ticks_of(FORECAST_PATIENCE_S);
            if !self.forecast.come && patient {
                // The forecast is still in work: look at the sensors once more meanwhile.
                self.self_test = SelfTest::new(&self.settings);
                return;
            }
            let Some(target) = self.forecast.target else {
                self.events.push(self.tick, EventKind::NoTarget);
                self.change(State::Idle);
                return;
            };
            let target = self.forecast.entered(&target);
            let search = Search::new(&target, self.range_hz());
            self.oscillator.jump(search.goal_hz());
            self.search = Some(search);
        } else {
            self.search = None;
        }
        self.guard.restart(self.sensed_drive.now());
        self.plausibility.restart();
        self.trim = Trim::new(&self.settings);
        if let (Mode::Automatic, Some(target)) = (self.mode, &self.forecast.target) {
            self.trim.expect(target.orbit.force_n);
        }
        let amplitude_m = self.trim.command();
        self.oscillator.aim_amplitude(amplitude_m);
        self.change(State::Ramp);
    }

    pub(super) fn ramped(&mut self) {
        self.timers.since_contact = 0;
        self.timers.since_one_one = 0;
        self.timers.good_periods = 0;
        self.change(match self.mode {
            Mode::Automatic => State::Seek,
            Mode::Manual => State::Manual,
        });
    }

    pub(super) fn start(&mut self, mode: Mode) {
        self.mode = mode;
        // Whoever steers says so after the start.
        self.timers.remote = false;
        self.self_test = SelfTest::new(&self.settings);
        self.timers.since_alive = 0;
        self.basin = Basin::Unknown;
        self.striking = 0;
        self.silent = 0;
        self.sense.reset();
        self.identification.reset();
        self.change(State::SelfTest);
    }

    pub(super) fn stop(&mut self) {
        self.search = None;
        self.oscillator.aim(self.oscillator.frequency_hz());
        self.oscillator.aim_amplitude(0.0);
        self.change(State::Stop);
    }

    pub(super) fn set_point(&mut self, frequency_hz: f32, amplitude_m: f32) -> Result<(), Refused> {
        if !(frequency_hz.is_finite() && amplitude_m.is_finite()) {
            return Err(Refused::NotANumber);
        }
        if self.mode != Mode::Manual || !self.is_driving() || self.state == State::Stop {
            return Err(Refused::WrongState);
        }
        let (low, high) = self.range_hz();
        let clamped_hz = frequency_hz.max(low).min(high);
        self.limits = ActiveLimits::FREQUENCY.when(clamped_hz != frequency_hz);
        self.oscillator.aim(clamped_hz);
        self.trim
            .set_wanted_amplitude(amplitude_m.min(self.settings.limits.amplitude_m));
        let amplitude_m = self.trim.command();
        self.oscillator.aim_amplitude(amplitude_m);
        Ok(())
    }

    pub(super) fn alive(&mut self) {
        self.timers.since_alive = 0;
        self.timers.remote = true;
        let waits = self.record.is_some_and(|r| r.fault == Fault::LinkTimeout);
        if self.state == State::Fault && waits {
            self.clear();
        }
    }

    pub(super) fn clear(&mut self) {
        self.record = None;
        self.timers.overruns = 0;
        self.timers.stale = 0;
        self.events.push(self.tick, EventKind::Cleared);
        self.change(State::Idle);
    }

    /// Off first; then the record.
    pub(super) fn trip(&mut self, trip: Trip) {
        self.condition = Some(trip.fault);
        if self.state == State::Fault {
            return;
        }
        self.oscillator.silence();
        self.search = None;
        self.note(trip);
        self.change(State::Fault);
    }

    pub(super) fn note(&mut self, trip: Trip) {
        let Trip {
            fault,
            origin,
            value,
        } = trip;
        let record = Record {
            fault,
            origin,
            tick: self.tick,
            value,
            frequency_hz: self.oscillator.frequency_hz(),
        };
        self.record = Some(record);
        self.events.push(self.tick, EventKind::Fault(record));
    }

    pub(super) fn change(&mut self, to: State) {
        let from = self.state;
        if from == to {
            return;
        }
        self.state = to;
        self.timers.in_state = 0;
        if matches!(to, State::Idle | State::Fault) {
            self.oscillator.silence();
            self.search = None;
        }
        self.events.push(self.tick, EventKind::State { from, to });
    }
}
