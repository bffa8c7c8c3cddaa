//! The shaker: from a set-point code to the force on the cart.
//!
//! The code is held for a tick (zero-order hold), smoothed by two first-order lags (the amplifier's delay and
//! the droop of its amplitude with frequency), and followed by a position loop of finite force:
//! F = kp (y* − y) + kd (ẏ* − ẏ) + share · M ÿ*, at most ±F_max. Disabled, the shaker gives no force of its
//! own; its suspension and its shorted coil bring the cart to rest in the middle.
//!
//! The armature is one with the cart, or has a mode of its own ([`ArmatureParams`]).

use std::f64::consts::TAU;

use shared::model::cart::{CartDrive, LoopParams};
use shared::model::params::{ParamError, RigParams};
use shared::settings::check_shaker;

use super::motor::{Motor, MotorParams};

/// Parameters of a shaker: its position loop, largest force, amplifier and armature.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShakerParams {
    /// Natural frequency of the position loop with the cart alone, Hz: kp = M (2π f)².
    pub loop_hz: f64,
    /// Damping ratio of the position loop: kd = 2 ζ M 2π f.
    pub loop_damping_ratio: f64,
    /// F_max, N; may be infinite.
    pub force_n: f64,
    /// Share of M ÿ* that is fed forward.
    pub feed_forward: f64,
    /// Time constant of the amplifier's lag, s.
    pub lag_s: f64,
    /// Corner of the amplitude's droop, Hz: the amplitude is down by 3 dB there.
    pub droop_hz: f64,
    /// Natural frequency of the cart on the suspension when the drive is off, Hz.
    pub suspension_hz: f64,
    /// Damping ratio of the cart when the drive is off.
    pub suspension_damping_ratio: f64,
    /// Force lost per speed, N·s/m: the shaker's mechanical impedance.
    pub impedance_n_s_per_m: f64,
    /// Whether its wires are exchanged: it moves the other way.
    pub reversed: bool,
    /// An armature that is not rigidly joined to the cart.
    pub armature: Option<ArmatureParams>,
}

impl ShakerParams {
    /// What a controller of `rig` is told of this shaker: its position loop.
    ///
    /// # Errors
    /// Why the controller's settings do not take such a loop: it is then told nothing.
    pub fn believed_by(&self, rig: &RigParams) -> Result<CartDrive, ParamError> {
        let cart = CartDrive::Loop(LoopParams {
            frequency_hz: self.loop_hz,
            damping_ratio: self.loop_damping_ratio,
            feed_forward: self.feed_forward,
            max_force_n: self.force_n.min(1e9),
        });
        let told = RigParams { cart, ..*rig };
        check_shaker(&told)?;
        Ok(cart)
    }
}

/// An armature with a mode of its own: the shaker's force acts on it, the position loop measures it, and a spring with a
/// damper joins it to the cart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ArmatureParams {
    /// Mass of the armature, kg.
    pub mass_kg: f64,
    /// Natural frequency of the cart on the joint while the armature is held, Hz.
    pub hz: f64,
    /// Damping ratio of the same.
    pub damping_ratio: f64,
}

/// An armature in the equations of motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Armature {
    /// Mass of the armature, kg.
    pub mass_kg: f64,
    /// Of the joint, N/m.
    pub stiffness: f64,
    /// Of the joint, N·s/m.
    pub damping: f64,
}

impl Armature {
    fn new(params: &ArmatureParams, cart_mass_kg: f64) -> Self {
        let omega = TAU * params.hz;
        Self {
            mass_kg: params.mass_kg,
            stiffness: cart_mass_kg * omega * omega,
            damping: 2.0 * params.damping_ratio * cart_mass_kg * omega,
        }
    }
}

impl Default for ShakerParams {
    /// A 200 N laboratory shaker: a loop of 50 Hz damped at 0.7, 0.5 ms of lag, 3 dB down at 80 Hz.
    fn default() -> Self {
        Self {
            loop_hz: 50.0,
            loop_damping_ratio: 0.7,
            force_n: 200.0,
            feed_forward: 1.0,
            lag_s: 0.5e-3,
            droop_hz: 80.0,
            suspension_hz: 5.0,
            suspension_damping_ratio: 0.5,
            impedance_n_s_per_m: 0.0,
            reversed: false,
            armature: None,
        }
    }
}

/// The set-point over one tick: a cubic through position and rate at both ends.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SetPointPath {
    start_m: f64,
    start_rate: f64,
    half_bend: f64,
    sixth_jerk: f64,
}

impl SetPointPath {
    /// From (position m, rate m/s) at the start to the same at the end, `length_s` later.
    pub fn new(length_s: f64, start: (f64, f64), end: (f64, f64)) -> Self {
        let rise = (end.0 - start.0) / length_s;
        let inverse = 1.0 / length_s;
        Self {
            start_m: start.0,
            start_rate: start.1,
            half_bend: (3.0 * rise - 2.0 * start.1 - end.1) * inverse,
            sixth_jerk: (start.1 + end.1 - 2.0 * rise) * (inverse * inverse),
        }
    }

    /// Position (m), rate (m/s) and acceleration (m/s²), `s` seconds into the tick.
    #[inline]
    pub fn at(&self, s: f64) -> (f64, f64, f64) {
        let (b, j) = (self.half_bend, self.sixth_jerk);
        (
            self.start_m + s * (self.start_rate + s * (b + s * j)),
            self.start_rate + s * (2.0 * b + s * (3.0 * j)),
            2.0 * b + s * (6.0 * j),
        )
    }
}

/// The two lags between the DAC and the loop, exact for a set-point that is held over each tick.
#[derive(Clone, Copy, Debug)]
pub struct Smoother {
    tick_s: f64,
    /// Output of the first lag and of the second, m.
    state: (f64, f64),
    second_s: f64,
    first_decay: f64,
    second_decay: f64,
    cross: f64,
}

impl Smoother {
    /// At rest in the middle. Both time constants must be positive.
    pub fn new(shaker: &ShakerParams, tick_s: f64) -> Self {
        let (first_s, second_s) = (shaker.lag_s, 1.0 / (TAU * shaker.droop_hz));
        let (first, second) = ((-tick_s / first_s).exp(), (-tick_s / second_s).exp());
        let apart = (first_s - second_s) / second_s;
        // What the first lag's distance adds to the second over a tick: the integral of both decays.
        let cross = if apart.abs() < 1e-6 {
            tick_s / second_s * second
        } else {
            (first - second) / apart * (first_s / second_s)
        };
        Self {
            tick_s,
            state: (0.0, 0.0),
            second_s,
            first_decay: first,
            second_decay: second,
            cross,
        }
    }

    /// Where the set-point is, m, and its rate, m/s.
    pub fn now(&self) -> (f64, f64) {
        let (first, second) = self.state;
        (second, (first - second) / self.second_s)
    }

    /// The path over the tick in which `metres` is held.
    #[inline]
    pub fn tick(&mut self, metres: f64) -> SetPointPath {
        let start = self.now();
        let (first, second) = (self.state.0 - metres, self.state.1 - metres);
        self.state = (
            or_none(metres + first * self.first_decay),
            or_none(metres + second * self.second_decay + first * self.cross),
        );
        SetPointPath::new(self.tick_s, start, self.now())
    }
}

/// `metres`, or 0 where it is next to nothing: a set-point that dies away would end in numbers so small that a processor takes
/// a hundred times as long over each.
fn or_none(metres: f64) -> f64 {
    if metres.abs() < 1e-200 { 0.0 } else { metres }
}

/// What moves the cart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ShakerDrive {
    /// A shaker of finite force.
    Shaker(ShakerParams),
    /// Something that follows the set-point whatever force that takes.
    Prescribed,
    /// A motor with a crank.
    Motor(MotorParams),
}

/// How the cart is moved, in the equations of motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Loop {
    /// By a shaker of finite force.
    Force(Gains),
    /// Exactly along the set-point, whatever force that takes.
    Prescribed,
    /// By a crank that a motor turns.
    Crank(Motor),
}

/// The loop's gains for a cart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gains {
    position: f64,
    rate: f64,
    acceleration: f64,
    limit_n: f64,
    spring: f64,
    damper: f64,
    impedance: f64,
    /// The armature, where it is not one with the cart.
    pub armature: Option<Armature>,
}

impl Gains {
    /// Gains of `shaker` with a cart of `cart_mass_kg`.
    pub fn new(shaker: &ShakerParams, cart_mass_kg: f64) -> Self {
        let (omega, rest) = (TAU * shaker.loop_hz, TAU * shaker.suspension_hz);
        let mass_kg = cart_mass_kg + shaker.armature.map_or(0.0, |a| a.mass_kg);
        Self {
            position: mass_kg * omega * omega,
            rate: 2.0 * shaker.loop_damping_ratio * mass_kg * omega,
            acceleration: shaker.feed_forward * mass_kg,
            limit_n: shaker.force_n,
            spring: mass_kg * rest * rest,
            damper: 2.0 * shaker.suspension_damping_ratio * mass_kg * rest,
            impedance: shaker.impedance_n_s_per_m,
            armature: shaker.armature.map(|a| Armature::new(&a, cart_mass_kg)),
        }
    }

    /// How far a force displaces the cart while the drive is off, m/N.
    pub fn compliance(&self) -> f64 {
        1.0 / self.spring
    }

    /// Force of the shaker, N, for a set-point (position, rate, acceleration) and what it moves at `y`, `rate`.
    #[inline]
    pub fn force(&self, on: bool, want: (f64, f64, f64), y: f64, rate: f64) -> f64 {
        if !on {
            return -self.spring * y - self.damper * rate;
        }
        let loop_n = self.position * (want.0 - y) + self.rate * (want.1 - rate);
        let wanted_n = loop_n + self.acceleration * want.2;
        wanted_n.clamp(-self.limit_n, self.limit_n) - self.impedance * rate
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_path_has_the_ends_it_was_given() {
        let path = SetPointPath::new(5e-5, (1e-3, 0.2), (1.5e-3, -0.1));
        let close = |a: (f64, f64, f64), b: (f64, f64)| {
            assert!((a.0 - b.0).abs() < 1e-16 && (a.1 - b.1).abs() < 1e-13);
        };
        close(path.at(0.0), (1e-3, 0.2));
        close(path.at(5e-5), (1.5e-3, -0.1));
    }

    #[test]
    fn both_lags_follow_their_closed_form_and_equal_ones_do_not_divide_by_zero() {
        for (lag_s, droop_s) in [(0.5e-3, 2e-3), (1e-3, 1e-3), (1e-3, 1.000_000_5e-3)] {
            let shaker = ShakerParams {
                lag_s,
                droop_hz: 1.0 / (TAU * droop_s),
                ..ShakerParams::default()
            };
            let mut smoother = Smoother::new(&shaker, 5e-5);
            for _ in 0..40 {
                smoother.tick(1e-3);
            }
            // Step response of two lags after 2 ms.
            let t: f64 = 40.0 * 5e-5;
            let want = if (lag_s - droop_s).abs() < 1e-8 {
                1.0 - (1.0 + t / lag_s) * (-t / lag_s).exp()
            } else {
                let (a, b) = (lag_s, droop_s);
                1.0 - (a * (-t / a).exp() - b * (-t / b).exp()) / (a - b)
            };
            let got = smoother.now().0 / 1e-3;
            assert!((got - want).abs() < 1e-6, "{lag_s} {droop_s}: {got} {want}");
        }
    }

    /// Numbers that are subnormal slow a processor down a hundredfold.
    #[test]
    fn a_set_point_that_dies_away_ends_at_nothing() {
        let mut smoother = Smoother::new(&ShakerParams::default(), 5e-5);
        smoother.tick(1e-3);
        for _ in 0..100_000 {
            let path = smoother.tick(0.0);
            let (y, rate, acceleration) = path.at(5e-5);
            let all = [path.sixth_jerk, path.half_bend, y, rate, acceleration];
            assert!(all.iter().all(|x| !x.is_subnormal()), "{path:?}");
        }
        assert_eq!(smoother.tick(0.0), SetPointPath::default());
    }

    #[test]
    fn force_is_finite_and_off_is_off() {
        let gains = Gains::new(&ShakerParams::default(), 5.38);
        let want = (1.0, 0.0, 0.0);
        assert_eq!(gains.force(true, want, 0.0, 0.0), 200.0);
        assert_eq!(gains.force(false, want, 0.0, 0.0), 0.0);
        assert!(gains.force(false, want, 1e-3, 0.0) < 0.0);
    }
}
