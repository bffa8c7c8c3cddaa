//! What the controller makes of samples: per tick, per contact, per drive period.

use super::controller::Controller;
use super::event::EventKind;
use super::phase::Phase;
use super::search::Step;
use super::{ActiveLimits, State};
use crate::io::Frame;
use crate::sense::{Pulse, Sample, Strobe};
use crate::settings::DriveKind;

impl Controller {
    /// One tick's samples.
    #[inline]
    pub(super) fn sample(&mut self, frame: &Frame) {
        let driving = self.life.phase.is_driving();
        let moving = driving && self.oscillator.amplitude_m() > 0.5 * self.wanted_amplitude_m();
        let now = self.sensed_drive.now();
        let (sample, trip) = self.guard.check(frame, now, moving, driving);
        if let Some(trip) = trip {
            self.trip(trip);
            return;
        }
        if let Phase::SelfTest(start) = &mut self.life.phase
            && let Some(end) = start.test.tick(frame, &sample)
        {
            match end {
                Ok(zero) => self.finish_self_test(zero),
                Err(trip) => self.trip(trip),
            }
        }
        self.process(sample, driving);
    }

    /// Passes a tick's samples on to sensing and identification, and acts on what they found.
    #[inline]
    fn process(&mut self, sample: Sample, driving: bool) {
        let found = self.sense.tick(sample, self.life.tick, &self.sensed_drive);
        if driving {
            let in_contact = self.sense.in_contact();
            self.note_contact(in_contact);
            self.rig.identification.flight(&sample, in_contact);
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
            if driving {
                self.strobe(&strobe);
            }
        }
    }

    /// Notes that a contact begins.
    #[inline]
    fn note_contact(&mut self, in_contact: bool) {
        if in_contact
            && !self.seen.in_contact
            && let Some(seeking) = self.life.phase.seeking_mut()
        {
            seeking.contact();
        }
        self.seen.in_contact = in_contact;
    }

    fn pulse(&mut self, pulse: &Pulse) {
        self.rig.identification.pulse(pulse);
        if let Some(trip) = self.plausibility.pulse(pulse) {
            self.trip(trip);
        }
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
        let moves_by_itself = matches!(self.life.phase, Phase::Ramp(_) | Phase::Stop);
        if arrived && !moves_by_itself {
            let command_m = self.oscillator.amplitude_m();
            if let Some(trip) = self.plausibility.strobe(strobe, command_m) {
                self.trip(trip);
                return;
            }
            let closed = self.settings.drive.kind == DriveKind::Shaker;
            self.trim.strobe(strobe, closed);
            let amplitude_m = self.trim.command();
            self.oscillator.aim_amplitude(amplitude_m);
        }
        let Some(seeking) = self.life.phase.seeking_mut() else {
            return;
        };
        seeking.strobe(strobe.contacts);
        self.seek(strobe, arrived);
        if let Some(rig) = self.rig.strobe() {
            let (natural_hz, gap_m) = (rig.natural_frequency_hz() as f32, rig.gap_m as f32);
            self.life.push(EventKind::Identified { natural_hz, gap_m });
            self.request_forecast();
        }
    }

    /// One drive period of the search.
    fn seek(&mut self, strobe: &Strobe, arrived: bool) {
        let regime = self.sense.measured().regime;
        let frequency_hz = self.oscillator.frequency_hz();
        let Some(seeking) = self.life.phase.seeking_mut() else {
            return;
        };
        let search = &mut seeking.search;
        let step = search.strobe(strobe, regime, frequency_hz, arrived);
        self.oscillator.aim(search.goal_hz());
        let at_bound = search.is_at_bound();
        let seeking = *seeking;
        self.limits.active = self.trim.limits() | ActiveLimits::FREQUENCY.when(at_bound);
        match step {
            Step::On => {}
            Step::Best {
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
            Step::Doubling(frequency_hz) => self.life.push(EventKind::Doubling { frequency_hz }),
            Step::Lost => {
                self.life.reseeks = self.life.reseeks.saturating_add(1);
                self.life.push(EventKind::RegimeLost);
                if self.life.is_in(State::Hold) {
                    self.change(Phase::Seek(seeking));
                }
            }
        }
    }
}
