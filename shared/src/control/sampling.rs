//! What the controller makes of samples: per tick, per contact, per drive period.

use super::controller::Controller;
use super::event::EventKind;
use super::guard::Trip;
use super::phase::Phase;
use super::plausibility::Doubt;
use super::proof::Proven;
use super::search::{Beat, SearchStep};
use super::self_test::SelfTest;
use super::trim::Way;
use super::{ActiveLimits, State};
use crate::fault::{Fault, Origin};
use crate::io::Frame;
use crate::sense::{Pulse, Sample, Strobe};

/// Drive periods with one contact each, in a row, after which no contact too weak to be seen hides in the flights.
const CLEAN_PERIODS: u8 = 4;
/// Factor within which the natural frequency is known: as far to either side the force that the forecast has is reckoned with.
const NATURAL_SPREAD: f32 = 1.06;
/// Share of the full amplitude above which no code stands still for a drive period: three codes each way, of a sensor as coarse as
/// settings may have it.
const MOVES: f32 = 0.2;
/// Drive periods in a row beyond a limit after which a motor is switched off.
const BEYOND_PERIODS: u8 = 2;

impl Controller {
    /// Takes in one tick's samples: guards first, then self test and sensing.
    #[inline]
    pub(super) fn sample(&mut self, frame: &Frame) {
        let driving = self.life.phase.is_driving();
        let moving = driving && self.oscillator.amplitude_m() > MOVES * self.full_amplitude_m();
        let now = self.sensed_drive.now();
        let (sample, trip) = self.guard.check(frame, now, moving, driving);
        self.watch_the_cart(&sample, driving);
        let coasts = !driving && self.off_watch.may_coast();
        let at_its_end =
            |trip: &Trip| (trip.fault, trip.origin) == (Fault::SensorSaturated, Origin::Cart);
        if let Some(trip) = trip.filter(|trip| !(coasts && at_its_end(trip))) {
            self.trip(trip);
            return;
        }
        self.test(frame, &sample);
        self.process(sample, driving);
    }

    /// The self test and the motion that proves the sensors.
    #[inline]
    fn test(&mut self, frame: &Frame, sample: &Sample) {
        match &mut self.life.phase {
            Phase::SelfTest(start) => match start.test.tick(frame, sample) {
                None => {}
                // A drive that runs on from before a power-off is known by the motion alone.
                Some(Ok(_)) if !self.off_watch.is_still() => {
                    start.test = SelfTest::new(&self.settings);
                }
                Some(Ok(zero)) => self.finish_self_test(zero),
                Some(Err(trip)) => self.trip(trip),
            },
            Phase::Prove(proof) => {
                let command_m = self.oscillator.amplitude_m() * self.sensed_drive.sin();
                match proof.tick(sample, command_m) {
                    None => {}
                    Some(Ok(Proven { cart, hammer })) => {
                        self.life.push(EventKind::Proven { cart, hammer });
                    }
                    Some(Err(trip)) => self.trip(trip),
                }
            }
            _ => {}
        }
    }

    /// The cart must not move with the drive off, and no further than wanted with the drive on.
    #[inline]
    fn watch_the_cart(&mut self, sample: &Sample, driving: bool) {
        let cart_m = sample.cart_m;
        if driving {
            self.off_watch.driving();
            let out_m = libm::fabsf(cart_m - self.sense.cart_offset_m());
            self.seen.cart_peak_m = self.seen.cart_peak_m.max(out_m);
        } else if let Some(amplitude_m) = self.off_watch.tick(cart_m, sample.hammer_m - cart_m) {
            self.trip(Trip {
                fault: Fault::NotOff,
                origin: Origin::Cart,
                value: amplitude_m,
            });
        }
    }

    /// Passes a tick's samples on to sensing and identification, and acts on what they found.
    #[inline]
    fn process(&mut self, sample: Sample, driving: bool) {
        let found = self.sense.tick(sample, self.life.tick, &self.sensed_drive);
        // The small motion proves the sensors by itself; it is too slow and too small for the checks of a run.
        let running = driving && !matches!(self.life.phase, Phase::Prove(_));
        if running {
            let in_contact = self.sense.in_contact();
            self.note_contact(in_contact);
            if !in_contact {
                self.seen.free_force.0 += sample.force_n - self.sense.force_offset_n();
                self.seen.free_force.1 += 1;
            }
            // From where the hammer rested in the self test, as its contacts are: a zero that is wrong is no gap.
            let hammer_m = sample.hammer_m - self.sense.rest_relative_m();
            let from_rest = Sample { hammer_m, ..sample };
            self.rig.identification.flight(&from_rest, in_contact);
            let relative_m = hammer_m - sample.cart_m;
            if self.plausibility.is_past_the_surface(relative_m) {
                self.seen.ticks_without_contact = 0;
            }
            if let Some(pulse) = found.pulse {
                self.pulse(&pulse);
            }
        }
        if let Some(strobe) = found.strobe {
            self.seen.strobe = Some(strobe);
            let measured = self.sense.measured();
            if measured.periods > 0 {
                self.seen.regime = measured.regime;
            }
            if running {
                self.strobe(&strobe);
            }
        }
    }

    /// Notes that a contact begins.
    #[inline]
    fn note_contact(&mut self, in_contact: bool) {
        if in_contact && !self.seen.in_contact {
            self.seen.ticks_without_contact = 0;
        }
        self.seen.in_contact = in_contact;
    }

    fn pulse(&mut self, pulse: &Pulse) {
        self.seen.onset_turns = pulse.onset_turns;
        if let Some(surface_m) = self.rig.identification.surface_m() {
            self.plausibility.believe_surface(surface_m);
        }
        self.rig.identification.pulse(pulse);
        let trip = self.plausibility.pulse(pulse);
        // A blow of which the samples showed less, as the ringing fell, than the most of those before it; two in a row where one may be
        // noise.
        let beyond = pulse.peak_n * self.doubt().force > self.settings.trips.force_n;
        let again =
            core::mem::replace(&mut self.seen.too_strong, beyond) || self.sense.ringing().is_sure();
        let trip = trip.or_else(|| {
            (beyond && again).then_some(Trip {
                fault: Fault::OverForce,
                origin: Origin::Force,
                value: pulse.peak_n,
            })
        });
        if let Some(trip) = trip {
            self.trip(trip);
        }
    }

    /// How much too little the sensors may read, with what a surface that rings or is lossy may hide. Four ask for it: one copy is enough.
    #[inline(never)]
    fn doubt(&self) -> Doubt {
        let doubt = self.plausibility.doubt();
        Doubt {
            force: doubt.force
                * self.sense.ringing().doubt()
                * self.rig.identification.hidden_peak(),
            ..doubt
        }
    }

    /// Limits and trip levels go by the worse of two measurements that contradict each other.
    pub(super) fn go_by_the_worse(&mut self) {
        let doubt = self.doubt();
        let rest = (self.sense.force_zero_n(), self.sense.rest_relative_m());
        let ringing = self.sense.ringing();
        // Both say by how much a ringing hides a peak: the larger counts, not one on top of the other. Two samples may also reach more.
        let over_two = ringing.peak_over_two();
        let peak_over_two = over_two.min((over_two / ringing.doubt()).max(1.0));
        let shift_m = self.plausibility.zero_shift_m();
        self.guard
            .set_levels(&self.settings.trips, &doubt, peak_over_two, rest, shift_m);
        self.sense.set_zero_shift(shift_m);
        let by_hand = self.life.phase.is_manual();
        let doubt = Doubt {
            force: doubt.force * self.sense.ringing().limit_doubt(),
            ..doubt
        };
        self.trim.set_limits(&self.settings.limits, &doubt, by_hand);
    }

    /// A drive period has ended while the drive is on.
    fn strobe(&mut self, strobe: &Strobe) {
        let arrived = self.oscillator.frequency_has_arrived();
        if arrived && !self.seen.arrived {
            self.sense.frequency_changed();
        }
        self.seen.arrived = arrived;
        if let Some(basin) = self.seen.basin.strobe(strobe.contacts) {
            self.life.push(EventKind::Basin(basin));
        }
        let free_force = core::mem::take(&mut self.seen.free_force);
        self.sense
            .follow_zero(free_force.0 / free_force.1.max(1) as f32);
        if let Some(trip) = self.plausibility.free_force(free_force) {
            self.trip(trip);
            return;
        }
        if self.follow_the_command(strobe) {
            return;
        }
        let Some(seeking) = self.life.phase.seeking_mut() else {
            return;
        };
        seeking.strobe(strobe.contacts);
        let at_bound = seeking.search.is_at_bound();
        self.seek(strobe, arrived);
        // While a forecast of the rig as it is now is awaited, the last one contradicts nobody; nor does a frequency that a bound holds.
        if self.life.is_in(State::Hold) && !self.forecast.is_awaited() && !at_bound {
            let target = self.forecast.target_point();
            let hz = self.oscillator.frequency_hz();
            if let Some(trip) = self.plausibility.held(strobe, hz, target) {
                self.trip(trip);
                return;
            }
        }
        self.make_the_force(strobe);
        if let Some(rig) = self.rig.strobe(self.forecast.is_awaited()) {
            let (natural_hz, gap_m) = (rig.natural_frequency_hz() as f32, rig.gap_m as f32);
            self.life.push(EventKind::Identified { natural_hz, gap_m });
            self.request_forecast();
        }
    }

    /// Judges the cart against its command, and sets the command from it and from the limits: in every state that
    /// drives, whether frequency and amplitude stand or move. Whether it trips.
    fn follow_the_command(&mut self, strobe: &Strobe) -> bool {
        // Amplitude and frequency move evenly: the mean of a period is that of its ends.
        let now_m = self.oscillator.amplitude_m();
        let command_m = 0.5 * (now_m + self.seen.command_m);
        self.seen.command_m = now_m;
        self.note_clean_period(strobe);
        self.note_old_bound();
        let ratio = self.rig.identification.hammer_over_cart();
        let clean = self.seen.clean >= CLEAN_PERIODS;
        let hz = self.oscillator.frequency_hz();
        let trip = self.plausibility.ratio(ratio, clean, hz);
        if let Some(trip) = trip.or_else(|| self.plausibility.still(strobe, command_m, hz)) {
            self.trip(trip);
            return true;
        }
        self.go_by_the_worse();
        if self.is_motor() {
            return self.stop_a_motor_beyond_its_limits(strobe);
        }
        let rising = matches!(self.life.phase, Phase::Ramp(_));
        if let Some(trip) = self.plausibility.strobe(strobe, command_m, hz, rising) {
            self.trip(trip);
            return true;
        }
        let closed = !self.plausibility.doubts_the_cart();
        let steady = self.plausibility.is_steady();
        let near_hz = (hz / NATURAL_SPREAD, hz * NATURAL_SPREAD);
        let nominal_n = (self.forecast).largest_force_n(near_hz, self.trim.wanted_m());
        self.trim.set_way(match self.life.phase {
            Phase::Manual if self.oscillator.frequency_has_arrived() => Way::AtSetPoint,
            Phase::Manual => Way::ToSetPoint,
            Phase::Seek(_) => Way::Seeks,
            _ => Way::Stays,
        });
        self.trim
            .strobe(strobe, command_m, hz, (closed, steady), nominal_n);
        if !matches!(self.life.phase, Phase::Stop) {
            self.command_amplitude();
        }
        false
    }

    /// Counts the periods with one contact each, where the forecast has 1/1: elsewhere contacts too weak to be seen hide between them. What
    /// flights showed before is forgotten.
    fn note_clean_period(&mut self, strobe: &Strobe) {
        let hz = self.oscillator.frequency_hz();
        let clean = if strobe.contacts == 1 && self.forecast.may_have_one_one_at(hz) {
            self.seen.clean.saturating_add(1)
        } else {
            0
        };
        if clean == CLEAN_PERIODS && self.seen.clean < CLEAN_PERIODS {
            self.rig.identification.at_amplitude();
        }
        self.seen.clean = clean;
    }

    /// What flights show is forgotten while a bound of an old forecast holds the frequency: far below its best, a hammer that is
    /// pressed on the surface makes contacts too weak to be seen between its blows.
    fn note_old_bound(&mut self) {
        let awaited = self.forecast.is_awaited();
        let seeking = self.life.phase.seeking_mut();
        if awaited && seeking.is_some_and(|seeking| seeking.search.is_at_bound()) {
            self.rig.identification.at_amplitude();
        }
    }

    /// Nothing reduces the amplitude of a motor drive: beyond a limit it is switched off. Whether it was.
    fn stop_a_motor_beyond_its_limits(&mut self, strobe: &Strobe) -> bool {
        let (limits, doubt) = (&self.settings.limits, self.doubt());
        let beyond = ActiveLimits::FORCE.when(strobe.peak_n * doubt.force > limits.force_n)
            | ActiveLimits::TRAVEL.when(strobe.travel_m * doubt.travel > limits.travel_m);
        if beyond.is_empty() {
            self.seen.beyond = 0;
            return false;
        }
        self.seen.beyond = self.seen.beyond.saturating_add(1);
        if self.seen.beyond < BEYOND_PERIODS {
            return false;
        }
        self.life.push(EventKind::Limits(beyond));
        self.change(Phase::Idle);
        true
    }

    /// Once per block: a cart that goes further than wanted is met before the drive period is over.
    pub(super) fn meet_a_surge(&mut self) {
        let now = self.sensed_drive.now();
        let half = now.phase >> 31;
        let command_m = self.oscillator.amplitude_m();
        let surges = self.trim.surge(self.seen.cart_peak_m, command_m);
        if surges && !matches!(self.life.phase, Phase::Stop) {
            let amplitude_m = self.trim.command().min(command_m);
            self.oscillator.aim_amplitude(amplitude_m);
        }
        if surges || half != self.seen.half {
            self.seen.cart_peak_m = 0.0;
        }
        self.seen.half = half;
    }

    /// Moves the amplitude towards the force wanted, while 1/1 is held at its phase.
    fn make_the_force(&mut self, strobe: &Strobe) {
        let seeking = self.life.phase.seeking_mut();
        let found = seeking.is_some_and(|seeking| seeking.search.has_found());
        // A sensor whose gain has just fallen asks for more.
        if strobe.contacts != 1 || !found || !self.plausibility.is_steady() {
            self.force.interrupt();
            return;
        }
        let clamped = !self.trim.limits().is_empty();
        // No harder than asked, by either measurement.
        let peak_n = strobe.peak_n * self.doubt().force;
        if self.force.strobe(peak_n, clamped) {
            let wanted_m = self.wanted_amplitude_m() * self.force.factor();
            self.trim.set_wanted_amplitude(wanted_m);
            self.command_amplitude();
        }
    }

    /// One drive period of the search.
    fn seek(&mut self, strobe: &Strobe, arrived: bool) {
        let regime = self.sense.measured().regime;
        let beat = Beat::new(strobe, self.seen.onset_turns, regime);
        let frequency_hz = self.oscillator.frequency_hz();
        let Some(seeking) = self.life.phase.seeking_mut() else {
            return;
        };
        let search = &mut seeking.search;
        let step = search.strobe(&beat, frequency_hz, arrived);
        self.oscillator.aim(search.goal_hz());
        let at_bound = search.is_at_bound();
        let seeking = *seeking;
        let feed = ActiveLimits::FEED.when(self.rig.is_out_of_reach());
        self.limits.active = self.trim.limits() | ActiveLimits::FREQUENCY.when(at_bound) | feed;
        match step {
            SearchStep::On => {}
            SearchStep::Best {
                frequency_hz,
                impulse_n_s,
                found,
            } => {
                self.life.push(EventKind::Best {
                    frequency_hz,
                    impulse_n_s,
                });
                if found {
                    self.change(Phase::Hold(seeking));
                }
            }
            SearchStep::Doubling(frequency_hz) => {
                self.life.push(EventKind::Doubling { frequency_hz })
            }
            SearchStep::Lost => {
                self.life.reseeks = self.life.reseeks.saturating_add(1);
                self.life.push(EventKind::RegimeLost);
                if self.life.is_in(State::Hold) {
                    self.change(Phase::Seek(seeking));
                }
            }
        }
    }
}
