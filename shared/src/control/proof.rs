//! The active part of the self test: a small, slow motion of the cart that proves the cart's and the hammer's sensor
//! before any blow.
//!
//! ```text
//!                   .-.                 one drive period at a third of the natural frequency,
//!                .-'   \                that is three natural periods (1.6 s on the wires);
//!  set-point  .-'-------\-------.-'--   its amplitude rises evenly until the middle
//!                        \   .-'        and falls evenly afterwards
//!                         '-'
//! ```
//!
//! So slow a cart takes the hammer along: hammer over cart is about 1/(1 − r²) in flight (r = Ω/ω), 1 while the hammer is
//! pressed on the surface, and between the two where it only touches. Both sensors are correlated with the command over
//! the whole motion. Offsets and noise drop out, and so does most of a hammer that still swings: the motion contains next
//! to nothing at the natural frequency.
//!
//! Where the limits forbid so low a frequency, the lowest allowed one takes its place. Above [`HIGHEST`] the hammer's swing
//! depends too much on the true natural frequency to prove its sensor, and only the cart's is proven.

use super::Mode;
use super::guard::Trip;
use super::plausibility::LEAST_FOLLOW;
use super::self_test::Zero;
use crate::fault::{Fault, Origin};
use crate::sense::Sample;
use crate::settings::{Settings, TICK_RATE_HZ};

/// Frequency of the motion, in natural frequencies.
const FREQUENCY: f32 = 1.0 / 3.0;
/// Up to here the hammer's sensor is proven, in natural frequencies.
const HIGHEST: f32 = 0.6;
/// Drive periods of the motion, up to so many natural frequencies, and beyond.
const TURNS: [(f32, f32); 3] = [(0.35, 1.0), (0.5, 2.0), (f32::MAX, 3.0)];
/// Amplitude in the middle of the motion, in units of A0: where the hammer follows, and where it may swing.
const AMPLITUDE: (f32, f32) = (0.5, 0.2);
/// The motion has more drive periods where the slew of the amplitude would leave less than this, in units of A0: a motion much
/// smaller is lost in the friction of a guide.
const LEAST_AMPLITUDE: f32 = 0.3;
/// Least hammer over cart. A pressed hammer has 1.
const LEAST_RATIO: f32 = 0.75;
/// A cart that goes further than this times its command is a shaker's that answers more strongly, or a sensor's that reads
/// too much. The hammer tells: with sensors 5 % off, hammer over cart is 0.905 or more.
const STRONG: f32 = 1.3;
const LEAST_RATIO_OF_STRONG: f32 = 0.88;
/// Largest hammer over cart, in units of what a rig has whose natural frequency is [`SOFTER`] of the one believed.
const LARGEST_RATIO: f32 = 1.3;
const SOFTER: f32 = 1.0 / 1.15;
/// What a swinging hammer may add to hammer over cart, per swing over the motion's amplitude. Within 10 % of the natural
/// frequency it is 0.04 (at a third of it; 0.13 at the highest).
const SWING: f32 = 0.1;
/// No hammer may seem to go less far than this, however much it swings.
const LEAST_SIGN: f32 = 0.1;
/// Motions of which one must prove the sensors: a rig may be knocked during one.
const TRIES: u8 = 2;

/// What the motion has proven.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Proven {
    /// Motion of the cart, as its sensor shows it, over the motion commanded.
    pub cart: f32,
    /// Hammer over cart, if the motion was slow enough to prove it.
    pub hammer: Option<f32>,
}

/// The motion, and what it shows.
#[derive(Clone, Copy, Debug)]
pub(super) struct Proof {
    pub mode: Mode,
    /// Frequency and amplitude with which the ramp by hand begins.
    pub by_hand: (f32, f32),
    hz: f32,
    amplitude_m: f32,
    /// Ticks of a motion.
    length: u32,
    /// Hammer over cart of a healthy rig.
    range: Option<(f32, f32)>,
    stage: Stage,
    tries: u8,
    first: Sample,
    /// Sums of the command times itself, the cart and the hammer, m².
    sums: [f32; 3],
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Stage {
    /// The motion is to begin with the next block.
    Due,
    /// So many ticks of it have passed.
    Moving(u32),
    /// So many ticks ago it has proven the sensors.
    Over(u32),
}

impl Proof {
    /// For a rig with `settings` whose rest is `zero`.
    pub fn new(mode: Mode, settings: &Settings, zero: &Zero, by_hand: (f32, f32)) -> Self {
        let limits = &settings.limits;
        let natural_hz = (settings.rig.natural_frequency_hz() as f32).max(0.1);
        let hz = (FREQUENCY * natural_hz)
            .max(limits.min_frequency_hz)
            .min(limits.max_frequency_hz);
        let r = hz / natural_hz;
        let follows = r <= HIGHEST;
        let whole_m = settings.rig.amplitude_m as f32;
        let share = if follows { AMPLITUDE.0 } else { AMPLITUDE.1 };
        let slew_m_per_s = settings.drive.amplitude_slew_m_per_s;
        let turns = TURNS
            .iter()
            .find_map(|(to, turns)| (r <= *to).then_some(*turns))
            .unwrap_or(1.0)
            .max(libm::ceilf(
                2.0 * LEAST_AMPLITUDE * whole_m / slew_m_per_s * hz,
            ));
        let seconds = turns / hz;
        let amplitude_m = (share * whole_m)
            .min(limits.amplitude_m)
            .min(0.5 * seconds * slew_m_per_s);
        let softer = r / SOFTER;
        let swing = SWING * zero.swing_m / amplitude_m;
        let range = (
            (LEAST_RATIO - swing).max(LEAST_SIGN),
            LARGEST_RATIO / (1.0 - softer * softer) + swing,
        );
        Self {
            mode,
            by_hand,
            hz,
            amplitude_m,
            length: (seconds * TICK_RATE_HZ as f32) as u32,
            range: follows.then_some(range),
            stage: Stage::Due,
            tries: 0,
            first: Sample::default(),
            sums: [0.0; 3],
        }
    }

    /// Largest amplitude of the motion, m.
    pub fn amplitude_m(&self) -> f32 {
        self.amplitude_m
    }

    /// Begins a motion that is due. For the first, its frequency, Hz: at phase 0. The next one goes on where it ended, at
    /// phase 0 again.
    pub fn begin(&mut self) -> Option<f32> {
        let due = self.stage == Stage::Due;
        if due {
            self.stage = Stage::Moving(0);
        }
        (due && self.tries == 0).then_some(self.hz)
    }

    /// Share of the amplitude now.
    pub fn envelope(&self) -> f32 {
        match self.stage {
            Stage::Moving(ticks) => {
                let done = ticks as f32 / self.length as f32;
                2.0 * done.min(1.0 - done)
            }
            Stage::Due | Stage::Over(_) => 0.0,
        }
    }

    /// How long ago the sensors were proven, in ticks, once they are.
    pub fn over(&self) -> Option<u32> {
        match self.stage {
            Stage::Over(ticks) => Some(ticks),
            Stage::Due | Stage::Moving(_) => None,
        }
    }

    /// A tick, in which the command was `command_m`. At the end of the motion, what it has proven or the fault.
    #[inline]
    pub fn tick(&mut self, sample: &Sample, command_m: f32) -> Option<Result<Proven, Trip>> {
        let ticks = match &mut self.stage {
            Stage::Moving(ticks) => ticks,
            Stage::Over(ticks) => {
                *ticks = ticks.saturating_add(1);
                return None;
            }
            Stage::Due => return None,
        };
        if *ticks == 0 {
            self.first = *sample;
            self.sums = [0.0; 3];
        }
        // The command has no mean, so those of the sensors do not matter; without them the sums stay small.
        let [command, cart, hammer] = &mut self.sums;
        *command += command_m * command_m;
        *cart += command_m * (sample.cart_m - self.first.cart_m);
        *hammer += command_m * (sample.hammer_m - self.first.hammer_m);
        *ticks += 1;
        if *ticks < self.length {
            return None;
        }
        self.tries += 1;
        let judged = self.judge();
        let again = judged.is_err() && self.tries < TRIES;
        self.stage = if again { Stage::Due } else { Stage::Over(0) };
        (!again).then_some(judged)
    }

    fn judge(&self) -> Result<Proven, Trip> {
        let out_of_family = |origin, value| Trip {
            fault: Fault::SensorOutOfFamily,
            origin,
            value,
        };
        let [command, cart, hammer] = self.sums;
        let (cart, hammer) = (cart / command, hammer / command);
        // Written so that NaN does not follow.
        let follows = cart >= LEAST_FOLLOW;
        if !follows {
            return Err(out_of_family(Origin::Cart, cart));
        }
        let Some((low, high)) = self.range else {
            return Ok(Proven { cart, hammer: None });
        };
        let ratio = hammer / cart;
        let least = if cart > STRONG {
            low + (LEAST_RATIO_OF_STRONG - LEAST_RATIO)
        } else {
            low
        };
        if (least..=high).contains(&ratio) {
            return Ok(Proven {
                cart,
                hammer: Some(ratio),
            });
        }
        // A hammer that fits the command is contradicted by the cart alone.
        let origin = if (low..=high).contains(&hammer) {
            Origin::Cart
        } else {
            Origin::Hammer
        };
        Err(out_of_family(origin, ratio))
    }
}

#[cfg(test)]
mod tests;
