//! Sensing: contacts, the hammer between them, the section, the regime and the cart, from samples.
//!
//! [`Sense::tick`] takes one instant's samples and the commanded drive and passes them on:
//!
//! | module | finds |
//! |---|---|
//! | [`pulse`] | contacts: onset, largest sample, impulse, duration; what merges |
//! | [`ringing`] | the surface's ringing after them, and the true peak behind it |
//! | [`observer`] | displacement and rate relative to the cart; approach and rebound speeds |
//! | [`harmonic`] | the cart's amplitude and its lag behind the command |
//! | [`section`] | the regime z = p/n, robust to noise and to one missed contact |
//!
//! A [`Pulse`] is handed out once its rebound speed is known: a twenty-fifth of the natural period after the
//! release (22 ms at 1.82 Hz, 6 ms at 6.5 Hz), or when the next contact begins. Fault checks on the force
//! must use the samples.

pub mod harmonic;
pub mod identification;
mod motion;
pub mod observer;
pub mod pulse;
pub mod ringing;
pub mod section;

use serde::{Deserialize, Serialize};

use crate::model::contact::Law;
use crate::model::drive::Drive;
use crate::model::params::RigParams;
use crate::model::regime::Regime;
use crate::settings::{Settings, TICK_S};

use harmonic::Harmonic;
use motion::PeriodMotion;
use observer::Observer;
use pulse::{PulseDetector, PulseEdge};
use ringing::{Ringing, RingingContact};
use section::SensedSection;

/// One tick's samples in SI units, fixed frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sample {
    /// Contact force, N.
    pub force_n: f32,
    /// Hammer displacement x, m.
    pub hammer_m: f32,
    /// Cart displacement y, m.
    pub cart_m: f32,
}

/// One contact as measured.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Pulse {
    /// Control tick of the onset.
    pub onset_tick: u32,
    /// Drive phase at the onset, turns, 0 to 1.
    pub onset_turns: f32,
    /// Largest force, N, without the surface's ringing as far as that is known ([`ringing`]).
    pub peak_n: f32,
    /// Impulse ∫F dt of the contact, N·s.
    pub impulse_n_s: f32,
    /// Time above the upper threshold, onset to first fall, interpolated, s; the fall is that of the force
    /// without its ringing.
    pub duration_s: f32,
    /// Displacement of the hammer relative to the cart at the onset, m, from the observer.
    pub relative_m: f32,
    /// Speed of the hammer relative to the cart just before, m/s, from the observer.
    pub approach_m_per_s: f32,
    /// And just after, away from the surface, m/s; 0 until enough samples have been seen.
    pub rebound_m_per_s: f32,
}

/// The measured section: once per drive period, at drive phase 0.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Strobe {
    /// Hammer displacement relative to the cart, m (observer).
    pub relative_m: f32,
    /// Rate of that displacement, m/s (observer).
    pub rate_m_per_s: f32,
    /// Contacts that began in the period.
    pub contacts: u16,
    /// Largest force of the period, N, without the surface's ringing as far as that is known ([`ringing`]).
    pub peak_n: f32,
    /// Impulse of the period's contacts, N·s.
    pub impulse_n_s: f32,
    /// Largest displacement of the hammer relative to the cart in the period, m, either way; from where the zero may have moved to
    /// ([`Sense::set_zero_shift`]), if that is farther.
    pub travel_m: f32,
    /// How much the hammer itself moved, root mean square, m.
    pub hammer_m: f32,
    /// Cart amplitude at the drive frequency, m.
    pub amplitude_m: f32,
    /// Lag of the cart behind the command, rad.
    pub lag_rad: f32,
}

/// The events of a tick.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SensedTick {
    /// A contact that ended.
    pub pulse: Option<Pulse>,
    /// The strobe, if the tick passed drive phase 0.
    pub strobe: Option<Strobe>,
}

/// The measured regime and the number of periods it rests on.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SensedRegime {
    /// Measured regime z = p/n.
    pub regime: Regime,
    /// Drive periods it rests on.
    pub periods: u8,
}

const TICK: f32 = TICK_S as f32;

/// Share of the distance from the force's zero made good per drive period.
const ZERO_FOLLOWS: f32 = 0.25;

/// Share of 1/ω after a release at which the rebound speed is taken.
const REBOUND_AFTER: f32 = 0.25;

/// All sensing of the controller.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sense {
    pulses: PulseDetector,
    ringing: Ringing,
    observer: Observer,
    harmonic: Harmonic,
    section: SensedSection,
    motion: PeriodMotion,
    /// A0 believed, m: scale of the section's displacements.
    amplitude_m: f32,
    force_offset_n: f32,
    /// How far the force's zero has moved since, N.
    force_drift_n: f32,
    rest_relative_m: f32,
    zero_shift_m: f32,
    rebound_ticks: u32,
    last_phase: u32,
    last_cycle: Option<u32>,
    /// The contact under way or waiting for its rebound speed, with its drive period and phase.
    current: Option<Current>,
    period: Strobe,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Current {
    pulse: Pulse,
    cycle: u32,
    phase: u32,
    ended: bool,
}

impl Sense {
    /// Senses a rig as the settings describe it.
    pub fn new(settings: &Settings) -> Self {
        let omega = (core::f64::consts::TAU * settings.rig.natural_frequency_hz()) as f32;
        let ticks = REBOUND_AFTER / (omega * TICK);
        Self {
            pulses: PulseDetector::new(&settings.detection, TICK),
            ringing: Ringing::new(settings, TICK),
            observer: Observer::new(settings, TICK),
            harmonic: Harmonic::default(),
            section: SensedSection::default(),
            motion: PeriodMotion::default(),
            amplitude_m: settings.rig.amplitude_m as f32,
            force_offset_n: 0.0,
            force_drift_n: 0.0,
            rest_relative_m: 0.0,
            zero_shift_m: 0.0,
            rebound_ticks: if ticks < 1000.0 { ticks as u32 } else { 1000 },
            last_phase: 0,
            last_cycle: None,
            current: None,
            period: Strobe::default(),
        }
    }

    /// Starts anew; the offsets stay.
    pub fn reset(&mut self) {
        self.pulses.reset();
        self.ringing.reset();
        self.observer.reset();
        self.harmonic.reset();
        self.section.restart();
        self.motion = PeriodMotion::default();
        self.last_cycle = None;
        self.current = None;
        self.period = Strobe::default();
    }

    /// The frequency has changed: the regime is measured anew, from whole periods at the new frequency.
    pub fn frequency_changed(&mut self) {
        self.section.restart();
    }

    /// Sets the readings at rest: force, N, x − y, m, and y, m. They are subtracted from now on.
    pub fn set_zero(&mut self, force_offset_n: f32, rest_relative_m: f32, cart_m: f32) {
        self.harmonic.set_offset(cart_m);
        self.force_offset_n = force_offset_n;
        self.force_drift_n = 0.0;
        self.rest_relative_m = rest_relative_m;
    }

    /// Sets how far the zero of x − y may have moved, m.
    pub fn set_zero_shift(&mut self, shift_m: f32) {
        self.zero_shift_m = shift_m;
    }

    /// One tick: its samples, its number, and the drive as commanded for that instant.
    pub fn tick(&mut self, sample: Sample, tick: u32, drive: &Drive<f32>) -> SensedTick {
        let force_n = sample.force_n - self.force_offset_n - self.force_drift_n;
        let relative_m = sample.hammer_m - sample.cart_m - self.rest_relative_m;
        let now = drive.now();
        let increment = now.phase.wrapping_sub(self.last_phase);
        self.last_phase = now.phase;

        let strobe = self.strobe(now.cycle, increment);
        let (sin, cos) = (drive.sin(), drive.cos());
        self.harmonic.tick(sample.cart_m, sin, cos);
        self.motion.tick(sample.hammer_m);
        let cart = self.harmonic.last();
        // A jump of the phase is a restart of the drive, not a frequency.
        let angle = if increment <= crate::model::drive::MAX_INCREMENT {
            increment as f32 * ANGLE_PER_PHASE
        } else {
            0.0
        };
        let omega = angle * (1.0 / TICK);
        let inertial = omega * omega * (cart.sine * sin + cart.cosine * cos);
        self.observer.tick(relative_m, inertial);
        self.section.tick(now.cycle, now.phase);

        let travel_m = largest(self.period.travel_m, relative_m);
        self.period.travel_m = largest(travel_m, relative_m - self.zero_shift_m);
        let edge = self.pulses.tick(force_n);
        if let Some(contact) = self.ringing.tick(force_n, &edge) {
            self.end(&contact);
        }
        let pulse = match edge {
            PulseEdge::None => self.settle(),
            PulseEdge::Began { ago } => {
                let before = self.current.take().map(|current| current.pulse);
                let back = (ago * increment as f32) as u32;
                let (phase, borrowed) = now.phase.overflowing_sub(back);
                let cycle = now.cycle.wrapping_sub(u32::from(borrowed));
                self.begin(tick, ago, cycle, phase);
                before
            }
            PulseEdge::Ended(raw) => {
                if let Some(current) = &mut self.current {
                    let ticks = raw.first_fall + raw.crossed_before;
                    current.pulse.duration_s = ticks * TICK;
                }
                None
            }
        };
        SensedTick { pulse, strobe }
    }

    fn strobe(&mut self, cycle: u32, increment: u32) -> Option<Strobe> {
        if self.last_cycle == Some(cycle) {
            return None;
        }
        let first = self.last_cycle.is_none();
        self.last_cycle = Some(cycle);
        if first {
            return None;
        }
        let cart = self.harmonic.strobe();
        let (relative_m, rate_m_per_s) = self.observer.relative();
        let omega = increment as f32 * ANGLE_PER_PHASE * (1.0 / TICK);
        let speed = self.amplitude_m * omega;
        if speed > 0.0 {
            let displacement = relative_m / self.amplitude_m;
            self.section
                .strobe(cycle, displacement, rate_m_per_s / speed);
        }
        let strobe = Strobe {
            relative_m,
            rate_m_per_s,
            amplitude_m: cart.amplitude_m(),
            lag_rad: cart.lag_rad(),
            peak_n: self.ringing.take_largest(),
            hammer_m: self.motion.take_rms_m(),
            ..self.period
        };
        self.period = Strobe::default();
        Some(strobe)
    }

    fn begin(&mut self, tick: u32, ago: f32, cycle: u32, phase: u32) {
        let approach = self.observer.contact(ago * TICK);
        self.section.onset(cycle, phase);
        self.period.contacts = self.period.contacts.saturating_add(1);
        let pulse = Pulse {
            onset_tick: tick.wrapping_sub(1),
            onset_turns: phase as f32 * (1.0 / 4_294_967_296.0),
            relative_m: self.observer.relative().0,
            approach_m_per_s: approach,
            ..Pulse::default()
        };
        self.current = Some(Current {
            pulse,
            cycle,
            phase,
            ended: false,
        });
    }

    fn end(&mut self, contact: &RingingContact) {
        if let Some(current) = &mut self.current {
            let impulse_n_s = contact.sum_n * TICK;
            current.pulse.peak_n = contact.peak_n;
            current.pulse.impulse_n_s = impulse_n_s;
            current.ended = true;
            self.period.impulse_n_s += impulse_n_s;
            self.section
                .impulse(current.cycle, current.phase, impulse_n_s);
        }
    }

    /// Hands out the contact that has ended once its rebound speed is known.
    #[inline]
    fn settle(&mut self) -> Option<Pulse> {
        let current = self.current.as_ref()?;
        let (rebound, flown) = self.observer.rebound();
        if !current.ended || flown < self.rebound_ticks {
            return None;
        }
        let pulse = Pulse {
            rebound_m_per_s: rebound,
            ..current.pulse
        };
        self.current = None;
        Some(pulse)
    }

    /// The regime, and how many drive periods it rests on; 0 periods: not known yet.
    pub fn measured(&self) -> SensedRegime {
        self.section.measured()
    }

    /// Displacement of the hammer relative to the cart, m (from the rest position given to [`Self::set_zero`], if any),
    /// and its rate, m/s.
    pub fn relative(&self) -> (f32, f32) {
        self.observer.relative()
    }

    /// The observer's innovation in standard deviations: about 1 while sensors and model agree, 10 at most.
    pub fn health(&self) -> f32 {
        self.observer.health()
    }

    /// Cart amplitude, m, and lag behind the command, rad, over the last whole drive period.
    pub fn cart(&self) -> (f32, f32) {
        let cart = self.harmonic.last();
        (cart.amplitude_m(), cart.lag_rad())
    }

    /// What the ringing makes of the force.
    pub fn ringing(&self) -> &Ringing {
        &self.ringing
    }

    /// What the force sensor read at zero in the self test, N.
    #[inline]
    pub fn force_offset_n(&self) -> f32 {
        self.force_offset_n
    }

    /// What the force sensor reads at zero now, N.
    pub fn force_zero_n(&self) -> f32 {
        self.force_offset_n + self.force_drift_n
    }

    /// What the hammer read at rest in the self test relative to the cart, m; 0 if it did not come to rest.
    pub fn rest_relative_m(&self) -> f32 {
        self.rest_relative_m
    }

    /// Outside contacts the force was `free_n` on average, by the zero of the self test: the zero follows it.
    pub fn follow_zero(&mut self, free_n: f32) {
        if free_n.is_finite() {
            self.force_drift_n += ZERO_FOLLOWS * (free_n - self.force_drift_n);
        }
    }

    /// Middle of the cart's motion, m.
    #[inline]
    pub fn cart_offset_m(&self) -> f32 {
        self.harmonic.offset_m()
    }

    /// Whether a contact is under way (its refractory time included).
    pub fn in_contact(&self) -> bool {
        self.pulses.is_open()
    }

    /// Lone samples above the threshold that were no contacts (wraps).
    pub fn glitches(&self) -> u32 {
        self.pulses.glitches()
    }
}

/// rad per unit of the drive's phase.
const ANGLE_PER_PHASE: f32 = (core::f64::consts::TAU / crate::model::drive::TURN) as f32;

/// ω₀ = √(k/m) of the believed contact, rad/s.
fn contact_omega(rig: &RigParams) -> f64 {
    let stiffness = match rig.contact {
        Law::SpringDashpot { stiffness, .. } => stiffness,
        // The nonlinear presets make the contact of Table 3.1.
        _ => 5.5e6,
    };
    libm::sqrt(stiffness / rig.mass_kg)
}

#[inline]
fn largest(so_far: f32, value: f32) -> f32 {
    let size = if value < 0.0 { -value } else { value };
    if size > so_far { size } else { so_far }
}

#[cfg(test)]
mod tests;
