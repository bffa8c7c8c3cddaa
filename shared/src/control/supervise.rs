//! The transitions between states: by time, by command, by fault.

use super::basin::BasinTracker;
use super::block_health::BlockHealth;
use super::controller::{Controller, start_frequency};
use super::event::EventKind;
use super::force::ForceLoop;
use super::guard::Trip;
use super::lifetime::Remote;
use super::phase::{Phase, Seeking, SelfTestStart};
use super::proof::Proof;
use super::search::Search;
use super::self_test::{SelfTest, Zero};
use super::trim::Trim;
use super::{ActiveLimits, Mode, Refused, SettingsState, State};
use crate::fault::{Fault, FaultRecord};
use crate::settings::{DriveKind, strong_force_n, ticks_of};

/// How long a start waits for the forecast after the sensors are proven, s.
const FORECAST_PATIENCE_S: f32 = 120.0;

impl Controller {
    /// Once per block: times that run out, states that follow from others.
    pub(super) fn supervise(&mut self, ticks: usize) {
        let ticks = ticks as u32;
        self.blocks.served();
        self.life.remote.pass(ticks);
        let timeout_s = self.settings.trips.link_timeout_s;
        if self.life.phase.is_driving() && self.life.remote.is_lost(timeout_s) {
            self.trip(Trip::system(Fault::LinkTimeout, timeout_s));
        }
        self.check_contact(ticks);
        match &mut self.life.phase {
            Phase::Prove(_) => self.prove(),
            Phase::Ramp(search) if self.oscillator.amplitude_has_arrived() => {
                let next = match *search {
                    Some(search) => Phase::Seek(Seeking::new(search)),
                    None => Phase::Manual,
                };
                self.rig.identification.at_amplitude();
                self.change(next);
            }
            Phase::Seek(_) | Phase::Hold(_) => self.check_search(ticks),
            Phase::Stop if self.oscillator.amplitude_m() <= 0.0 => self.change(Phase::Idle),
            _ => {}
        }
        if self.life.phase.is_driving() {
            self.meet_a_surge();
        }
        self.limits.active = match self.state() {
            State::Ramp | State::Seek | State::Hold | State::Manual => {
                let kept = ActiveLimits::FREQUENCY | ActiveLimits::FEED;
                (self.limits.active & kept) | self.trim.limits()
            }
            _ => ActiveLimits::NONE,
        };
        if let Some(limits) = self.limits.change() {
            self.life.push(EventKind::Limits(limits));
        }
    }

    /// Trips when there has been no contact for too long where the hammer must strike, by itself or by hand.
    fn check_contact(&mut self, ticks: u32) {
        if !self.life.phase.is_driving() || self.life.is_in(State::Stop) {
            return;
        }
        let measured_m = self.seen.strobe.map_or(0.0, |strobe| strobe.amplitude_m);
        let hz = self.oscillator.frequency_hz();
        // A contact is sure to be detected from twice the force at which it begins.
        let least_n = 2.0 * self.settings.detection.on_n;
        if self.forecast.must_strike_at(hz, measured_m, least_n) {
            let passed = self.seen.ticks_without_contact.saturating_add(ticks);
            self.seen.ticks_without_contact = passed;
        }
        let limit_s = self.settings.trips.no_contact_s;
        if self.seen.ticks_without_contact > ticks_of(limit_s) {
            self.trip(Trip::system(Fault::NoContact, limit_s));
        }
    }

    /// Trips when the search has been without 1/1, or without Hold, for too long.
    fn check_search(&mut self, ticks: u32) {
        let limit_s = self.settings.trips.regime_lost_s;
        let held = self.life.is_in(State::Hold);
        let limited = !self.trim.limits().is_empty();
        let Some(seeking) = self.life.phase.seeking_mut() else {
            return;
        };
        if seeking.has_failed(ticks, held, limited, limit_s) {
            self.trip(Trip::system(Fault::RegimeLost, limit_s));
        }
    }

    /// The self test has found the zeros.
    pub(super) fn finish_self_test(&mut self, zero: Zero) {
        let rest_m = zero.relative_m.unwrap_or(0.0);
        self.sense.set_zero(zero.force_n, rest_m, zero.cart_m);
        self.guard.set_force_is_live(zero.force_is_live);
        let Phase::SelfTest(start) = &self.life.phase else {
            return;
        };
        let mode = start.mode;
        let nothing = self.forecast.has_come() && self.forecast.entered_target().is_none();
        if nothing && mode == Mode::Automatic {
            self.give_up();
            return;
        }
        if self.is_motor() {
            self.begin_ramp(mode, self.first_set_point());
            return;
        }
        let proof = Proof::new(mode, &self.settings, &zero, self.first_set_point());
        self.trim = Trim::new(&self.settings);
        self.trim.set_wanted_amplitude(proof.amplitude_m());
        self.seen.cart_peak_m = 0.0;
        self.change(Phase::Prove(proof));
    }

    /// The set-point of a start by hand to which none is sent.
    fn first_set_point(&self) -> (f32, f32) {
        (start_frequency(&self.settings), self.wanted_amplitude_m())
    }

    /// There is no stable 1/1 to go to.
    fn give_up(&mut self) {
        self.life.push(EventKind::NoTarget);
        self.change(Phase::Idle);
    }

    /// The small motion that proves the sensors: begins it, moves its amplitude, and goes on once it is over and there is
    /// a forecast to go by.
    fn prove(&mut self) {
        let Phase::Prove(proof) = &mut self.life.phase else {
            return;
        };
        if let Some(hz) = proof.begin() {
            self.oscillator.restart(hz);
            self.guard.restart(self.oscillator.drive().now());
        }
        let goal_m = self.trim.command() * proof.envelope();
        self.oscillator.aim_amplitude(goal_m);
        let (mode, by_hand) = (proof.mode, proof.by_hand);
        let Some(waited) = proof.over() else {
            return;
        };
        let patient = waited < ticks_of(FORECAST_PATIENCE_S);
        if mode == Mode::Automatic && !self.forecast.has_come() && patient {
            return;
        }
        self.begin_ramp(mode, by_hand);
    }

    /// The ramp begins: to the forecast's entry, or by hand to this set-point.
    fn begin_ramp(&mut self, mode: Mode, by_hand: (f32, f32)) {
        let search = match mode {
            Mode::Manual => None,
            Mode::Automatic => {
                let Some(target) = self.forecast.entered_target() else {
                    self.give_up();
                    return;
                };
                Some(Search::new(
                    &target,
                    self.range_hz(),
                    self.settings.aim.power,
                ))
            }
        };
        self.guard.restart(self.sensed_drive.now());
        self.plausibility.restart();
        self.seen.command_m = 0.0;
        self.seen.ticks_without_contact = 0;
        self.seen.cart_peak_m = 0.0;
        self.trim = Trim::new(&self.settings);
        self.go_by_the_worse();
        self.oscillator.silence();
        if let Some(search) = &search {
            self.oscillator.jump(search.goal_hz());
            let (target_hz, force_n) = self.forecast.target_point();
            self.force = ForceLoop::of(&self.settings);
            self.force.expect(force_n);
            let wanted_m = self.wanted_amplitude_m() * self.force.factor();
            self.trim.set_wanted_amplitude(wanted_m);
            self.trim.expect(force_n * self.force.factor(), target_hz);
        } else {
            let hz = self.within_limits(by_hand.0);
            self.oscillator.jump(hz);
            self.go_by_hand((hz, by_hand.1));
        }
        self.change(Phase::Ramp(search));
        self.command_amplitude();
    }

    /// Whether the drive is a motor's.
    pub(super) fn is_motor(&self) -> bool {
        self.settings.drive.kind == DriveKind::Motor
    }

    /// Sets the goal of the amplitude: what loop and limits allow.
    pub(super) fn command_amplitude(&mut self) {
        let goal_m = self.trim.command();
        self.oscillator.aim_amplitude(goal_m);
    }

    pub(super) fn start(&mut self, mode: Mode) -> Result<(), Refused> {
        self.settings_are_known()?;
        if !self.life.is_in(State::Idle) {
            return Err(Refused::WrongState);
        }
        if self.is_motor() && mode == Mode::Automatic {
            return Err(Refused::ByHandOnly);
        }
        let required = self.settings.operator.acknowledge;
        self.life.operator.start(required)?;
        // By hand, a computer that steers says so after the start.
        self.life.remote = Remote::expected(self.settings.operator.heartbeat);
        self.seen.basin = BasinTracker::NEW;
        // A goal of the last run is none of this one.
        self.oscillator.aim(self.oscillator.frequency_hz());
        self.sense.reset();
        self.rig.identification.reset();
        let test = SelfTest::new(&self.settings);
        self.change(Phase::SelfTest(SelfTestStart { mode, test }));
        Ok(())
    }

    pub(super) fn stop(&mut self) -> Result<(), Refused> {
        self.life.remote = Remote::default();
        match self.state() {
            State::Fault => return Err(Refused::WrongState),
            State::Idle | State::Stop => {}
            State::SelfTest => self.change(Phase::Idle),
            // There is no amplitude to ramp down.
            _ if self.is_motor() => self.change(Phase::Idle),
            _ => {
                self.oscillator.aim(self.oscillator.frequency_hz());
                self.oscillator.aim_amplitude(0.0);
                self.change(Phase::Stop);
            }
        }
        Ok(())
    }

    pub(super) fn clear_fault(&mut self) -> Result<(), Refused> {
        if !self.life.is_in(State::Fault) {
            return Err(Refused::WrongState);
        }
        self.settings_are_known()?;
        if self.life.operator.is_awaited() {
            return Err(Refused::NotAcknowledged);
        }
        if !self.life.faults.can_be_cleared() {
            return Err(Refused::StillFaulty);
        }
        self.clear();
        Ok(())
    }

    pub(super) fn set_point(&mut self, frequency_hz: f32, amplitude_m: f32) -> Result<(), Refused> {
        if !(frequency_hz.is_finite() && amplitude_m.is_finite()) {
            return Err(Refused::NotANumber);
        }
        if !self.life.phase.is_manual() {
            return Err(Refused::WrongState);
        }
        if frequency_hz <= 0.0 || amplitude_m < 0.0 {
            return Err(Refused::NoMotion);
        }
        if let Phase::Prove(proof) = &mut self.life.phase {
            proof.by_hand = (frequency_hz, amplitude_m);
            return Ok(());
        }
        let hz = self.within_limits(frequency_hz);
        self.oscillator.aim(hz);
        self.go_by_hand((hz, amplitude_m));
        self.command_amplitude();
        Ok(())
    }

    /// The frequency nearest to `asked_hz` within the limits; the report says whether it is another.
    fn within_limits(&mut self, asked_hz: f32) -> f32 {
        let (low, high) = self.range_hz();
        let hz = asked_hz.max(low).min(high);
        self.limits.active = ActiveLimits::FREQUENCY.when(hz != asked_hz);
        hz
    }

    /// Wants a set-point by hand, with no blow beyond a limit on the way there.
    fn go_by_hand(&mut self, (hz, amplitude_m): (f32, f32)) {
        self.trim.set_wanted_amplitude(amplitude_m);
        let way_hz = (self.oscillator.frequency_hz(), hz);
        let wanted_m = self.trim.wanted_m();
        let force_n = self.forecast.largest_force_n(way_hz, wanted_m);
        let force_n = force_n.unwrap_or_else(|| {
            strong_force_n(&self.settings.rig) as f32 * wanted_m / self.wanted_amplitude_m()
        });
        self.trim.expect(force_n, way_hz.0.max(hz));
    }

    pub(super) fn alive(&mut self) {
        self.life.remote.alive();
        if self.life.is_in(State::Fault) && self.life.faults.ends_with_the_link() {
            self.clear();
        }
    }

    /// Refuses whatever needs settings that are known to be this rig's.
    fn settings_are_known(&self) -> Result<(), Refused> {
        let state = self.life.operator.settings;
        if state.can_drive() {
            Ok(())
        } else {
            Err(Refused::SettingsUnknown(state))
        }
    }

    /// The older copy of the settings is that of this rig.
    pub(super) fn confirm_settings(&mut self) -> Result<(), Refused> {
        if self.life.operator.settings != SettingsState::OlderCopy {
            return Err(Refused::WrongState);
        }
        self.settings_came();
        Ok(())
    }

    /// The settings in use are this rig's.
    pub(super) fn settings_came(&mut self) {
        self.life.operator.settings = SettingsState::Stored;
        self.life.faults.settings_replaced();
    }

    fn clear(&mut self) {
        self.life.faults.clear();
        self.blocks = BlockHealth::default();
        self.life.push(EventKind::Cleared);
        self.change(Phase::Idle);
    }

    /// Switches the drive off; records the fault only then. In Fault, the fault joins the episode: the episode
    /// latches if any of its faults does.
    #[inline(never)]
    pub(super) fn trip(&mut self, trip: Trip) {
        if trip.fault == Fault::EmergencyStop {
            let required = self.settings.operator.acknowledge;
            self.life.operator.emergency(self.life.tick, required);
        }
        self.life.faults.stands(trip.fault);
        if !self.life.is_in(State::Fault) {
            self.oscillator.silence();
        }
        self.note(trip);
        self.change(Phase::Fault);
    }

    pub(super) fn note(&mut self, trip: Trip) {
        let Trip {
            fault,
            origin,
            value,
        } = trip;
        let hz = self.oscillator.frequency_hz();
        let record = FaultRecord::new(fault, origin, self.life.tick, value, hz);
        if self.life.faults.add(record) {
            let episode = self
                .life
                .faults
                .record
                .map_or(record.episode, |r| r.episode);
            self.life
                .push(EventKind::Fault(FaultRecord { episode, ..record }));
        }
    }

    pub(super) fn change(&mut self, to: Phase) {
        if self.life.change(to) && matches!(self.life.phase, Phase::Idle | Phase::Fault) {
            self.oscillator.silence();
        }
    }
}

#[cfg(test)]
mod tests;
