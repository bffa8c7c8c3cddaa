//! A motor drive: an induction motor behind a frequency converter turns a crank, and a rod moves the cart.
//!
//! The cart's amplitude is the crank's. Its frequency is the motor's speed, which lags behind the set-point and slips
//! under load: T = K (Ω* − φ̇) within ±T_max, J φ̈ = T − F y′(φ), where F is the rod's force on the cart.

use std::f64::consts::TAU;

/// A motor with a crank.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotorParams {
    /// Radius of the crank, m: the cart's amplitude.
    pub crank_m: f64,
    /// Radius over the rod's length, 0 (a sine) to below 1.
    pub rod_ratio: f64,
    /// Inertia of motor, gear and crank at the crank's shaft, kg·m².
    pub inertia_kg_m2: f64,
    /// Speed lost per torque at the crank's shaft, Hz/(N·m).
    pub slip_hz_per_n_m: f64,
    /// Largest torque of the motor at the crank's shaft, either way, N·m.
    pub torque_n_m: f64,
    /// Time constant of the converter's frequency, s.
    pub lag_s: f64,
    /// Time constant in which it runs down without power, s.
    pub coast_s: f64,
}

impl MotorParams {
    /// For a crank of this radius and a cart and hammer of this mass together: a flywheel that evens the speed out, and a
    /// slip of a few percent at full load.
    pub fn for_cart(crank_m: f64, mass_kg: f64) -> Self {
        let moved = mass_kg * crank_m * crank_m;
        // Power to turn the moved mass up to 10 Hz in a second, ten times over.
        let torque_n_m = 10.0 * 20.0 * moved * TAU * 10.0;
        Self {
            crank_m,
            rod_ratio: 0.0,
            inertia_kg_m2: 20.0 * moved,
            slip_hz_per_n_m: 0.3 / torque_n_m,
            torque_n_m,
            lag_s: 0.1,
            coast_s: 0.3,
        }
    }
}

/// The motor in the equations of motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motor {
    radius: f64,
    rod_ratio: f64,
    pub(super) inertia: f64,
    torque_per_speed: f64,
    most_torque: f64,
    brake: f64,
}

impl Motor {
    /// The motor that has these parameters.
    pub fn new(params: &MotorParams) -> Self {
        Self {
            radius: params.crank_m,
            rod_ratio: params.rod_ratio,
            inertia: params.inertia_kg_m2,
            torque_per_speed: 1.0 / (TAU * params.slip_hz_per_n_m),
            most_torque: params.torque_n_m,
            brake: params.inertia_kg_m2 / params.coast_s,
        }
    }

    /// The cart's position y(φ) in m, and its first and second derivative by the angle.
    #[inline]
    pub fn crank(&self, angle: f64) -> (f64, f64, f64) {
        let (sin, cos) = angle.sin_cos();
        let ratio = self.rod_ratio;
        if ratio == 0.0 {
            let r = self.radius;
            return (r * sin, r * cos, -r * sin);
        }
        let root = (1.0 - ratio * ratio * cos * cos).sqrt();
        let bent = (root - (1.0 - ratio * ratio).sqrt()) / ratio;
        let both = sin * cos;
        let second = (cos * cos - sin * sin) / root - ratio * ratio * both * both / root.powi(3);
        (
            self.radius * (sin + bent),
            self.radius * (cos + ratio * both / root),
            self.radius * (ratio * second - sin),
        )
    }

    /// Torque on the crank's shaft, N·m, at a wanted and a true speed, rad/s.
    #[inline]
    pub fn torque(&self, on: bool, wanted: f64, speed: f64) -> f64 {
        if !on {
            return -self.brake * speed;
        }
        (self.torque_per_speed * (wanted - speed)).clamp(-self.most_torque, self.most_torque)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_cranks_derivatives_are_those_of_its_position_and_the_stroke_is_twice_its_radius() {
        for rod_ratio in [0.0, 0.3, 0.6] {
            let params = MotorParams {
                rod_ratio,
                ..MotorParams::for_cart(1e-3, 5.0)
            };
            let motor = Motor::new(&params);
            let (mut low, mut high) = (f64::MAX, f64::MIN);
            for k in 0..2000 {
                let angle = TAU * f64::from(k) / 2000.0;
                let h = 1e-5;
                let (a, b) = (motor.crank(angle - h), motor.crank(angle + h));
                let (y, first, second) = motor.crank(angle);
                assert!(((b.0 - a.0) / (2.0 * h) - first).abs() < 1e-11);
                assert!(((b.1 - a.1) / (2.0 * h) - second).abs() < 1e-11);
                low = low.min(y);
                high = high.max(y);
            }
            assert!((high - low - 2e-3).abs() < 1e-8, "{}", high - low);
            assert!(motor.crank(0.0).0.abs() < 1e-18);
        }
    }
}
