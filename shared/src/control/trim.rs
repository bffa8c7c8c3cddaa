//! The amplitude loop, and the limits that reduce the amplitude.
//!
//! Limits clamp and are reported; they are no faults. Loop and limits work once per drive period, in every state
//! that drives and while frequency and amplitude move. A cart that moves further than wanted, as with a
//! resonance of the shaker, is met within half a drive period: [`Trim::surge`].

use super::limits::ActiveLimits;
use super::plausibility::Doubt;
use crate::sense::Strobe;
use crate::settings::{Limits, Settings, strong_force_n};

/// Share of the amplitude error corrected per drive period.
const GAIN: f32 = 0.2;
/// How far the loop may move the command from the amplitude wanted: little upwards, since a cart that seems to
/// move less may be a sensor that reads less; far downwards, for a resonance of the shaker.
const RANGE: (f32, f32) = (0.05, 1.3);
/// Measured over wanted amplitude, above which the whole error is corrected at once.
const EXCESS: f32 = 1.1;
/// A cart further out than this times the amplitude wanted is a surge.
const SURGE: f32 = 1.25;
/// What a surge is answered with, as a share of the command that would make the wanted amplitude: the motion still
/// grows.
const SURGE_ANSWER: f32 = 0.7;
/// A mean command below this share of the wanted amplitude says nothing of the response.
const LEAST_COMMAND: f32 = 0.2;
/// Drive periods between two reductions: the hammer needs some to respond.
const ANSWER_PERIODS: u8 = 4;
/// Drive periods between two reductions where a limit is exceeded by more than a tenth.
const URGENT_PERIODS: u8 = 1;
/// Share of a limit at which the amplitude begins where more is expected.
const EXPECTED: f32 = 0.9;
/// Least share of the wanted amplitude that the limits leave.
const LEAST_DRAW: f32 = 0.05;
/// Factor by which a reduced amplitude recovers per drive period.
const RELEASE: f32 = 1.01;
/// Share per second by which a reduced amplitude recovers after a period without contact: that says nothing of force.
const BLIND_RELEASE: f32 = 0.02;
/// Drive periods in a row within a limit before what it took returns: the blows of an aperiodic motion differ.
const CALM_PERIODS: u8 = 12;
/// Share of a limit below which what it took returns.
const NEARLY: f32 = 0.95;
/// So many times the share at which a limit was nearly reached at a set-point by hand may return: readings are noisy.
const NOISE: f32 = 1.02;
/// As much more of a limit as was reached in the last drive period is expected in the next, at most this, while the frequency
/// moves.
const GROWTH: f32 = 0.2;
/// Shares of the limits of force and travel that are used by hand: the blows of an aperiodic motion differ, and where the 1/1 doubles
/// the travel grows faster than a limit answers.
const BY_HAND: (f32, f32) = (0.97, 0.92);
/// What rounding may add to an amplitude at its limit.
const ROUNDING: f32 = 1e-6;
/// What the rebound of the strongest 1/1 adds to the travel, in amplitudes: 0.32 of its approach speed, 7.9 A0 ω, over ω.
const REBOUND_TRAVEL: f32 = 2.5;
/// What the cart itself adds to the travel where it strikes at its own highest speed, in amplitudes: Ω/ω, and so much for its own
/// displacement. With the rebound of the strongest 1/1, near Ω/ω = 2, that makes 5 amplitudes on wires and beams; at 2.7, where the
/// 1/1 doubles and its travel jumps from 3.5 to 4.7 amplitudes within a second, 4.7.
const CART_TRAVEL: f32 = 0.5;

/// What the frequency does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Way {
    /// It follows the phase of the contacts, or stays.
    Stays,
    /// It is searched for: the force may grow faster than a limit answers.
    Seeks,
    /// It is on its way to a set-point by hand: the same, and the forecast there counts.
    ToSetPoint,
    /// It is there: what was too much there stays too much.
    AtSetPoint,
}

/// The amplitude loop, with the limits that reduce the amplitude.
#[derive(Clone, Copy, Debug)]
pub struct Trim {
    wanted_m: f32,
    /// Largest cart amplitude that may be commanded, m.
    largest_m: f32,
    /// Whether more was asked for.
    asked_beyond: bool,
    /// How many times its reading the cart's amplitude may be.
    cart_doubt: f32,
    force_n: f32,
    travel_m: f32,
    /// Travel by the rebound over the force of the blow, m/N.
    rebound_m_per_n: f32,
    natural_hz: f32,
    /// Command over the amplitude that it is to make: what the loop corrects.
    gain: f32,
    /// Share of the wanted amplitude that the limits allow.
    draw: f32,
    /// The largest share that returns. A motion that becomes smaller at a set-point by hand may be a sensor that reads less: there it
    /// is little more than that at which a limit was nearly reached; the next set-point makes it whole.
    most: f32,
    way: Way,
    /// Drive periods until the next reduction.
    wait: u8,
    /// Drive periods in a row within the limits.
    calm: u8,
    /// The larger of force and travel over their limits, in the last drive period.
    over: f32,
    limits: ActiveLimits,
}

impl Trim {
    /// Holds the rig's amplitude within the limits of `settings`.
    pub fn new(settings: &Settings) -> Self {
        Self {
            wanted_m: settings.rig.amplitude_m as f32,
            largest_m: settings.limits.amplitude_m,
            asked_beyond: false,
            cart_doubt: 1.0,
            force_n: settings.limits.force_n,
            travel_m: settings.limits.travel_m,
            rebound_m_per_n: REBOUND_TRAVEL * settings.rig.amplitude_m as f32
                / strong_force_n(&settings.rig) as f32,
            natural_hz: settings.rig.natural_frequency_hz() as f32,
            gain: 1.0,
            draw: 1.0,
            most: 1.0,
            way: Way::Stays,
            wait: 0,
            calm: 0,
            over: 0.0,
            limits: ActiveLimits::NONE,
        }
    }

    /// The limits from now on: those of the settings, nearer by what is doubted, and by hand.
    pub fn set_limits(&mut self, limits: &Limits, doubt: &Doubt, by_hand: bool) {
        let (of_force, of_travel) = if by_hand { BY_HAND } else { (1.0, 1.0) };
        self.force_n = of_force * limits.force_n / doubt.force;
        self.travel_m = of_travel * limits.travel_m / doubt.travel;
        self.cart_doubt = doubt.cart;
    }

    /// What the frequency does from now on.
    pub fn set_way(&mut self, way: Way) {
        self.way = way;
    }

    /// The amplitude wanted, m: at most what the limit leaves, which then clamps.
    pub fn set_wanted_amplitude(&mut self, amplitude_m: f32) {
        self.asked_beyond = amplitude_m > self.largest_m * (1.0 + ROUNDING);
        self.wanted_m = amplitude_m.max(0.0).min(self.largest_m);
    }

    /// The largest travel with blows of `force_n` at `hz` and the wanted amplitude, m.
    fn expected_travel_m(&self, force_n: f32, hz: f32) -> f32 {
        let cart_m = self.wanted_m * (hz / self.natural_hz + CART_TRAVEL);
        self.rebound_m_per_n * force_n + cart_m
    }

    /// Takes the force forecast at the wanted amplitude and `hz`: if it, or the travel then, exceeds its limit, the
    /// initial amplitude is reduced accordingly (both are proportional to the amplitude of a 1/1 at no gap).
    pub fn expect(&mut self, force_n: f32, hz: f32) {
        self.most = 1.0;
        let travel_m = self.expected_travel_m(force_n, hz);
        for (share, limit) in [
            (force_n / self.force_n, ActiveLimits::FORCE),
            (travel_m / self.travel_m, ActiveLimits::TRAVEL),
        ] {
            if share > 1.0 {
                self.draw = (EXPECTED / share).min(self.draw).max(LEAST_DRAW);
                self.limits |= limit;
            }
        }
    }

    /// Limits that reduce the amplitude, or hold the command, now.
    pub fn limits(&self) -> ActiveLimits {
        self.limits
    }

    /// The amplitude wanted, m.
    pub fn wanted_m(&self) -> f32 {
        self.wanted_m
    }

    /// A period without contact, or on the way to another frequency, does not show the force that comes: the amplitude is at
    /// most what keeps the limits by the forecast of `nominal_n` at the wanted amplitude; without a forecast it does not rise.
    /// The share that this leaves.
    fn by_forecast(&self, nominal_n: Option<f32>, hz: f32) -> f32 {
        let share = nominal_n.map(|n| {
            let by_travel = self.travel_m / self.expected_travel_m(n, hz);
            EXPECTED * by_travel.min(self.force_n / n)
        });
        share.unwrap_or(self.draw).clamp(LEAST_DRAW, 1.0)
    }

    /// A drive period at `hz` has ended, in which the command was `command_m` on average. `closed`: whether the loop may
    /// correct upwards, too; `steady`: whether what a limit took may return; `nominal_n`: the force by the forecast at the
    /// wanted amplitude.
    pub fn strobe(
        &mut self,
        strobe: &Strobe,
        command_m: f32,
        hz: f32,
        (closed, steady): (bool, bool),
        nominal_n: Option<f32>,
    ) {
        // The amplitude that this command was to make.
        let expected_m = command_m / self.gain;
        if expected_m > LEAST_COMMAND * self.wanted_m {
            self.correct(strobe.amplitude_m / expected_m, closed);
        }
        let blind = if strobe.contacts == 0 || self.way == Way::ToSetPoint {
            self.by_forecast(nominal_n, hz)
        } else {
            1.0
        };
        self.limits -= ActiveLimits::FORCE | ActiveLimits::TRAVEL;
        let over_force = strobe.peak_n / self.force_n;
        let over_travel = strobe.travel_m / self.travel_m;
        let over = over_force.max(over_travel);
        let growth = over - core::mem::replace(&mut self.over, over);
        let over = match self.way {
            Way::Stays | Way::AtSetPoint => over,
            Way::Seeks | Way::ToSetPoint => over + growth.clamp(0.0, GROWTH),
        };
        let urgent = over > 1.1;
        self.wait = self.wait.saturating_sub(1);
        self.calm = if over > 1.0 {
            0
        } else {
            self.calm.saturating_add(1)
        };
        if over > 1.0 && (self.wait == 0 || urgent && self.wait <= ANSWER_PERIODS - URGENT_PERIODS)
        {
            // On the way up it is the amplitude reached so far that is too much.
            let reached = if self.wanted_m > 0.0 {
                self.draw.min(expected_m / self.wanted_m)
            } else {
                self.draw
            };
            self.draw = (reached / over.min(2.0)).max(LEAST_DRAW);
            self.wait = ANSWER_PERIODS + 1;
        } else if self.calm > CALM_PERIODS && over < NEARLY && steady {
            let release = if strobe.contacts > 0 {
                RELEASE
            } else {
                1.0 + BLIND_RELEASE / hz.max(1.0)
            };
            self.draw = (self.draw * release).min(self.most);
        }
        if over > NEARLY && self.way == Way::AtSetPoint {
            self.most = (NOISE * self.draw).min(1.0);
        }
        self.draw = self.draw.min(blind);
        if self.draw < 1.0 {
            let limit = if over_force >= over_travel || self.draw >= blind {
                ActiveLimits::FORCE
            } else {
                ActiveLimits::TRAVEL
            };
            self.limits |= limit;
        }
    }

    /// Corrects the gain by measured over expected amplitude.
    fn correct(&mut self, ratio: f32, closed: bool) {
        let factor = if ratio > EXCESS {
            1.0 / ratio.min(2.0)
        } else if closed || ratio > 1.0 {
            1.0 + GAIN * (1.0 - ratio).clamp(-0.5, 0.5)
        } else {
            1.0
        };
        let gain = self.gain * factor;
        if gain.is_finite() {
            self.gain = gain.clamp(RANGE.0, RANGE.1);
        }
    }

    /// The cart was `peak_m` from its middle since the last call, with a command of `command_m`. Whether that is too
    /// far: the command is reduced then.
    pub fn surge(&mut self, peak_m: f32, command_m: f32) -> bool {
        let target_m = self.wanted_m * self.draw;
        // While the wanted amplitude falls, the command is above it for a while.
        let surges = peak_m > SURGE * target_m.max(command_m) && target_m > 0.0;
        if surges {
            let gain = SURGE_ANSWER * command_m / peak_m;
            self.gain = gain.min(self.gain).clamp(RANGE.0, RANGE.1);
        }
        surges
    }

    /// The amplitude to command, m.
    pub fn command(&mut self) -> f32 {
        // Neither the command nor what the amplitude may truly be beyond its reading exceeds the limit.
        let largest_reading_m = self.largest_m / self.cart_doubt;
        let reading_m = self.wanted_m * self.draw;
        let doubted = self.cart_doubt > 1.0 && reading_m > largest_reading_m;
        let reading_m = if doubted {
            largest_reading_m
        } else {
            reading_m
        };
        let command = reading_m * self.gain;
        let beyond = command > self.largest_m;
        self.limits -= ActiveLimits::AMPLITUDE;
        self.limits |= ActiveLimits::AMPLITUDE.when(doubted || beyond || self.asked_beyond);
        if beyond { self.largest_m } else { command }
    }
}

#[cfg(test)]
mod tests;
