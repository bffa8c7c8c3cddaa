//! What the controller makes of samples: per tick, per contact, per drive period.

use super::controller::Controller;
use super::event::EventKind;
use super::search::Step;
use super::{ActiveLimits, Basin, State};
use crate::io::Frame;
use crate::model::params::RigParams;
use crate::sense::identification::Estimates;
use crate::sense::{Pulse, Sample, Strobe};
use crate::settings::DriveKind;

/// Drive periods without contact after which the hammer is in the basin without impact.
const SILENT_PERIODS: u8 = 12;
/// Drive periods with contact after which it is in the basin with impact.
const STRIKING_PERIODS: u8 = 4;
/// Drive periods between two looks at what the rig has told of itself.
const IDENTIFY_PERIODS: u16 = 32;
/// A natural frequency further off than this is worth a new forecast, relative.
const NATURAL_STEP: f64 = 0.01;
/// A gap further off than this is worth a new forecast, m.
const GAP_STEP_M: f64 = 3e-5;
/// Largest relative standard error of a natural frequency that is believed.
const NATURAL_SIGMA: f32 = 0.003;
/// Largest standard error of a gap that is believed, m.
const GAP_SIGMA_M: f32 = 1e-5;

/// The rig of the settings with what has been identified surely enough in place of what was set. Contact
/// stiffness and damping stay as set: they cannot be told well enough from 20 kHz samples
/// ([`crate::sense::identification`]), and hardly move the target.
fn learned(set: &RigParams, believed: &RigParams, found: &Estimates) -> RigParams {
    let mut rig = *believed;
    if let Some(natural) = found.natural_hz
        && natural.sigma <= NATURAL_SIGMA * natural.value
    {
        let factor = f64::from(natural.value) / set.natural_frequency_hz();
        rig = set.with_natural_frequency_scaled(factor);
        rig.gap_m = believed.gap_m;
    }
    if let Some(gap) = found.gap_m
        && gap.sigma <= GAP_SIGMA_M
    {
        rig.gap_m = f64::from(gap.value);
    }
    rig
}

impl Controller {
    /// One tick's samples.
    #[inline]
    pub(super) fn sample(&mut self, frame: &Frame) {
        let driving = self.is_driving();
        let moving = driving && self.oscillator.amplitude_m() > 0.5 * self.wanted_amplitude_m();
        let now = self.sensed_drive.now();
        let (sample, trip) = self.guard.check(frame, now, moving, driving);
        if let Some(trip) = trip {
            self.condition = Some(trip.fault);
            self.trip(trip);
            return;
        }
        if self.state == State::SelfTest
            && let Some(end) = self.self_test.tick(frame, &sample)
        {
            match end {
                Ok(zero) => self.tested(zero),
                Err(trip) => self.trip(trip),
            }
        }
        self.process(sample, driving);
    }

    /// What the sensors tell in a tick.
    #[inline]
    pub(super) fn process(&mut self, sample: Sample, driving: bool) {
        let seen = self.sense.tick(sample, self.tick, &self.sensed_drive);
        if driving {
            let in_contact = self.sense.in_contact();
            self.note_contact(in_contact);
            self.identification.flight(&sample, in_contact);
            if let Some(pulse) = seen.pulse {
                self.pulse(&pulse);
            }
        }
        if let Some(strobe) = seen.strobe {
            self.last = Some(strobe);
            let measured = self.sense.measured();
            if measured.periods > 0 {
                self.regime = measured.regime;
            }
            if driving {
                self.strobe(&strobe);
            }
        }
    }

    /// Notes that a contact begins.
    #[inline]
    fn note_contact(&mut self, in_contact: bool) {
        if in_contact && !self.touched {
            self.timers.since_contact = 0;
        }
        self.touched = in_contact;
    }

    fn pulse(&mut self, pulse: &Pulse) {
        self.identification.pulse(pulse);
        if let Some(trip) = self.plausibility.pulse(pulse) {
            self.trip(trip);
        }
    }

    /// A drive period has ended while the drive is on.
    pub(super) fn strobe(&mut self, strobe: &Strobe) {
        let arrived = self.oscillator.frequency_has_arrived();
        if arrived && !self.arrived {
            self.sense.frequency_changed();
        }
        self.arrived = arrived;
        let settled = arrived && self.state != State::Ramp && self.state != State::Stop;
        self.note_basin(strobe);
        if settled {
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
        if matches!(self.state, State::Seek | State::Hold) {
            self.count_one_one(strobe);
            self.seek(strobe, arrived);
            self.update_believed_rig();
        }
    }

    pub(super) fn count_one_one(&mut self, strobe: &Strobe) {
        self.timers.good_periods = if strobe.contacts == 1 {
            self.timers.good_periods.saturating_add(1)
        } else {
            0
        };
        if self.timers.good_periods >= 8 {
            self.timers.since_one_one = 0;
        }
    }

    pub(super) fn seek(&mut self, strobe: &Strobe, arrived: bool) {
        let regime = self.sense.measured().regime;
        let frequency_hz = self.oscillator.frequency_hz();
        let Some(search) = &mut self.search else {
            return;
        };
        let step = search.strobe(strobe, regime, frequency_hz, arrived);
        let goal_hz = search.goal_hz();
        let held = search.is_at_bound();
        self.oscillator.aim(goal_hz);
        self.limits = self.trim.limits() | ActiveLimits::FREQUENCY.when(held);
        match step {
            Step::On => {}
            Step::Best {
                frequency_hz,
                impulse_n_s,
                found,
            } => {
                self.events.push(
                    self.tick,
                    EventKind::Best {
                        frequency_hz,
                        impulse_n_s,
                    },
                );
                if found {
                    self.change(State::Hold);
                }
            }
            Step::Doubling(frequency_hz) => {
                self.events
                    .push(self.tick, EventKind::Doubling { frequency_hz });
            }
            Step::Lost => {
                self.reseeks = self.reseeks.saturating_add(1);
                self.events.push(self.tick, EventKind::RegimeLost);
                if self.state == State::Hold {
                    self.change(State::Seek);
                }
            }
        }
    }

    /// Now and then: does the rig differ from what is believed? Then a new forecast is wanted.
    fn update_believed_rig(&mut self) {
        self.timers.identification += 1;
        if self.timers.identification < IDENTIFY_PERIODS {
            return;
        }
        self.timers.identification = 0;
        let rig = learned(
            &self.settings.rig,
            &self.believed,
            &self.identification.estimates(),
        );
        let natural = rig.natural_frequency_hz() / self.believed.natural_frequency_hz() - 1.0;
        let gap_m = rig.gap_m - self.believed.gap_m;
        let differs = !(-NATURAL_STEP..=NATURAL_STEP).contains(&natural)
            || !(-GAP_STEP_M..=GAP_STEP_M).contains(&gap_m);
        if differs && rig.check().is_ok() {
            self.believed = rig;
            self.events.push(
                self.tick,
                EventKind::Identified {
                    natural_hz: rig.natural_frequency_hz() as f32,
                    gap_m: rig.gap_m as f32,
                },
            );
            self.request_forecast();
        }
    }

    pub(super) fn note_basin(&mut self, strobe: &Strobe) {
        if strobe.contacts > 0 {
            self.striking = self.striking.saturating_add(1);
            self.silent = 0;
        } else {
            self.silent = self.silent.saturating_add(1);
            self.striking = 0;
        }
        let basin = if self.striking >= STRIKING_PERIODS {
            Basin::Impact
        } else if self.silent >= SILENT_PERIODS {
            Basin::NoImpact
        } else {
            self.basin
        };
        if basin != self.basin {
            self.basin = basin;
            self.events.push(self.tick, EventKind::Basin(basin));
        }
    }
}
