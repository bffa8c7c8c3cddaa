//! The impulse of the contacts against the change of speed they make.
//!
//! ∫F dt = m (v before + v after), both speeds relative to the cart, which the shaker has brought back to its course by the
//! time at which the second is known. As sums over the last contacts,
//! so that weak ones count for little and a misread one does nothing. A hammer that seems to fly away from the
//! surface into it makes the sum of speeds negative, and that is judged like any other number.

use crate::sense::Pulse;
use crate::settings::{Settings, strong_force_n, strong_speed_m_per_s};

/// Contacts in a row with a sum outside the range that trip.
pub const BAD_PULSES: u8 = 4;
/// Impulse over momentum of the last contacts; wider by what a late sensor may be worth ([`super::LATE_S`]).
pub const MOMENTUM_RANGE: (f32, f32) = (0.76, 1.32);
/// Upwards so many times wider: displacements 1 ms later than the force, the whole of which is unknown here, read the speeds up to
/// two thirds of the angle too small that the drive turns in it.
const LATER_THAN_FORCE: f32 = 2.5;
/// Impulse over momentum of a single contact, beyond which nothing needs to be averaged.
pub const GROSS_RANGE: (f32, f32) = (0.4, 2.5);
/// Contacts in a row outside that trip.
pub const GROSS_PULSES: u8 = 6;
/// Contacts in the sums.
const MEMORY: f32 = 16.0;
/// Contacts in the quick sums.
const QUICK_MEMORY: f32 = 4.0;
/// Quick over slow ratio within which the gains are steady: contacts of a healthy rig stay within.
const STEADY_RANGE: (f32, f32) = (0.95, 1.05);
/// Contacts after which limits and trip levels go by the sums.
const FEW: u8 = 4;
/// Contacts before the sums are judged.
const FEWEST: u8 = 12;

/// Fading sums of the contacts' impulses and changes of speed, and counts of those out of range.
#[derive(Clone, Copy, Debug)]
pub(super) struct Momentum {
    mass_kg: f32,
    /// Approach speed of a contact of twice the force from which one is detected. Of weaker ones some are missed.
    weak_m_per_s: f32,
    impulse_n_s: f32,
    speed_m_per_s: f32,
    quick_impulse_n_s: f32,
    quick_speed_m_per_s: f32,
    pulses: u8,
    bad: u8,
    gross: u8,
}

impl Momentum {
    pub fn new(settings: &Settings) -> Self {
        let rig = &settings.rig;
        let weak = 2.0 * settings.detection.on_n / strong_force_n(rig) as f32;
        Self {
            mass_kg: rig.mass_kg as f32,
            weak_m_per_s: weak * strong_speed_m_per_s(rig) as f32,
            impulse_n_s: 0.0,
            speed_m_per_s: 0.0,
            quick_impulse_n_s: 0.0,
            quick_speed_m_per_s: 0.0,
            pulses: 0,
            bad: 0,
            gross: 0,
        }
    }

    pub fn restart(&mut self) {
        self.impulse_n_s = 0.0;
        self.speed_m_per_s = 0.0;
        self.quick_impulse_n_s = 0.0;
        self.quick_speed_m_per_s = 0.0;
        self.pulses = 0;
        self.bad = 0;
        self.gross = 0;
    }

    /// Impulse over momentum of the last contacts, if there were enough and both have a sign.
    pub fn ratio(&self) -> Option<f32> {
        let ratio = quotient(self.impulse_n_s, self.mass_kg * self.speed_m_per_s);
        (self.pulses >= FEW && ratio > 0.0).then_some(ratio)
    }

    /// Whether the last few contacts have the ratio of the many before them: a gain that has just changed shows here first.
    pub fn is_steady(&self) -> bool {
        let quick = self.quick_impulse_n_s * self.speed_m_per_s;
        let slow = self.impulse_n_s * self.quick_speed_m_per_s;
        self.pulses < FEW || is_within(quick, slow, STEADY_RANGE)
    }

    /// A contact has ended, of a cart that turns by `late` rad while a sensor may be late; the ratio of the sums if it trips.
    pub fn pulse(&mut self, pulse: &Pulse, late: f32) -> Option<f32> {
        // Weak by both sensors: a hammer's that is dead makes hard contacts slow. A surface gives back less than all speed.
        let weak = pulse.approach_m_per_s < self.weak_m_per_s
            && pulse.approach_m_per_s > 0.0
            && pulse.impulse_n_s < 2.0 * self.mass_kg * self.weak_m_per_s;
        // Without a speed after it, the next contact came before that was known.
        if pulse.rebound_m_per_s == 0.0 || weak {
            return None;
        }
        let speed = pulse.approach_m_per_s + pulse.rebound_m_per_s;
        const KEPT: f32 = 1.0 - 1.0 / MEMORY;
        const QUICK_KEPT: f32 = 1.0 - 1.0 / QUICK_MEMORY;
        self.impulse_n_s = KEPT * self.impulse_n_s + pulse.impulse_n_s;
        self.speed_m_per_s = KEPT * self.speed_m_per_s + speed;
        self.quick_impulse_n_s = QUICK_KEPT * self.quick_impulse_n_s + pulse.impulse_n_s;
        self.quick_speed_m_per_s = QUICK_KEPT * self.quick_speed_m_per_s + speed;
        self.pulses = self.pulses.saturating_add(1);
        let one = self.mass_kg * speed;
        let gross = !is_within(pulse.impulse_n_s, one, GROSS_RANGE);
        if super::run(&mut self.gross, gross, GROSS_PULSES) {
            return Some(quotient(pulse.impulse_n_s, one));
        }
        if self.pulses <= FEWEST {
            return None;
        }
        let sum = self.mass_kg * self.speed_m_per_s;
        let (low, high) = MOMENTUM_RANGE;
        let outside = !is_within(
            self.impulse_n_s,
            sum,
            (low - late, high + LATER_THAN_FORCE * late),
        );
        let trips = super::run(&mut self.bad, outside, BAD_PULSES);
        trips.then(|| quotient(self.impulse_n_s, sum))
    }
}

/// Whether `impulse` over `momentum` is within `range`: never for a momentum of 0 or less, nor for NaN.
fn is_within(impulse: f32, momentum: f32, (low, high): (f32, f32)) -> bool {
    momentum > 0.0 && impulse >= low * momentum && impulse <= high * momentum
}

/// The quotient, 0 if there is none.
fn quotient(impulse: f32, momentum: f32) -> f32 {
    let ratio = impulse / momentum;
    if ratio.is_finite() { ratio } else { 0.0 }
}
