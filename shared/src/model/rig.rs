//! Equations of motion of both rigs, once, for any scalar.
//!
//! # Coordinate
//! The generalised coordinate q is measured from the contact configuration, not from rest: on wires
//! q = θ − θ_gap with sin θ_gap = gap/l, on beams q = Δ − gap with Δ = x − y. So q = 0 is where the hammer
//! touches, and f32 resolves a penetration of 1e-8 m just as well at a 3.5 mm gap as at 0.0 mm: nothing
//! is ever computed as the small difference of two large numbers.
//!
//! # Frame
//! Everything is relative to the cart, which moves as y = A0 sin Ωt; its acceleration enters as the
//! inertial acceleration `drive` = A0 Ω² sin Ωt.

use crate::model::contact::Law;
use crate::model::params::{ParamError, RigParams, SupportParams, Torque};
use crate::model::scalar::Real;

#[derive(Clone, Copy, Debug, PartialEq)]
enum Support<R> {
    Wires {
        length: R,
        inverse_length: R,
        gravity: R,
        sin_gap: R,
        cos_gap: R,
        torque: Torque,
    },
    Beams {
        stiffness_over_mass: R,
        damping_over_mass: R,
        cubic_over_mass: R,
    },
}

/// A rig, ready to be stepped: parameters reduced to what the equations of motion need.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rig<R> {
    support: Support<R>,
    gap: R,
    amplitude: R,
    mass: R,
    inverse_mass: R,
    law: Law<R>,
    /// q of a hammer at rest.
    rest: R,
}

/// Where the hammer is relative to the impact surface, and how the coordinate maps to it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Kinematics<R> {
    /// Penetration δ, m (negative: a clearance).
    pub delta: R,
    /// Penetration rate δ̇, m/s.
    pub rate: R,
    /// dδ/dq: l cos θ (m/rad) or 1.
    pub slope: R,
    /// sin θ (wires) or Δ in m (beams).
    deflection: R,
    /// cos θ (wires) or 1.
    cosine: R,
}

/// Which side of the switch the hammer is on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SwitchMode {
    /// Γ−: no contact force.
    #[default]
    Flight,
    /// Γ+: the contact law acts.
    Contact,
}

impl<R: Real> Rig<R> {
    /// Reduces parameters to a rig.
    ///
    /// # Errors
    /// If a parameter is out of range: the first such ([`RigParams::check`]).
    pub fn new(params: &RigParams) -> Result<Self, ParamError> {
        params.check()?;
        let r = R::from_f64;
        let support = match params.support {
            SupportParams::Wires {
                length_m,
                gravity_m_per_s2,
                torque,
                ..
            } => {
                let sin_gap = params.gap_m / length_m;
                Support::Wires {
                    length: r(length_m),
                    inverse_length: r(1.0 / length_m),
                    gravity: r(gravity_m_per_s2),
                    sin_gap: r(sin_gap),
                    cos_gap: r(libm::sqrt(1.0 - sin_gap * sin_gap)),
                    torque,
                }
            }
            SupportParams::Beams {
                natural_frequency_hz,
                damping_ratio,
                cubic_stiffness_n_per_m3,
            } => {
                let omega = core::f64::consts::TAU * natural_frequency_hz;
                let stiffness = params.mass_kg * omega * omega;
                let cubic = cubic_stiffness_n_per_m3.unwrap_or(stiffness);
                Support::Beams {
                    stiffness_over_mass: r(omega * omega),
                    damping_over_mass: r(2.0 * damping_ratio * omega),
                    cubic_over_mass: r(cubic / params.mass_kg),
                }
            }
        };
        Ok(Self {
            support,
            gap: r(params.gap_m),
            amplitude: r(params.amplitude_m),
            mass: r(params.mass_kg),
            inverse_mass: r(1.0 / params.mass_kg),
            law: params.contact.cast(),
            rest: r(rest_coordinate(params)),
        })
    }

    /// q of the hammer at rest: θ = 0 or Δ = 0; with a negative gap, where the support that presses the
    /// hammer on and the surface balance.
    #[inline]
    pub fn rest(&self) -> R {
        self.rest
    }

    /// Hammer mass m, kg.
    #[inline]
    pub fn mass(&self) -> R {
        self.mass
    }

    /// This rig with the cart amplitude `amplitude`, m.
    pub fn with_amplitude(self, amplitude: R) -> Self {
        Self { amplitude, ..self }
    }

    /// Cart amplitude A0, m.
    #[inline]
    pub fn amplitude(&self) -> R {
        self.amplitude
    }

    /// Contact law between hammer and impact surface.
    #[inline]
    pub fn law(&self) -> &Law<R> {
        &self.law
    }

    /// A0 in units of the coordinate: what displacements on the section are compared with.
    #[inline]
    pub fn coordinate_scale(&self) -> R {
        match self.support {
            Support::Wires { inverse_length, .. } => self.amplitude * inverse_length,
            Support::Beams { .. } => self.amplitude,
        }
    }

    /// The coordinate of a hammer displaced by `relative_m` from rest at zero gap (l sin θ, or Δ), m.
    /// Host side only: NaN where |`relative_m`| > l.
    pub fn coordinate_at(&self, relative_m: f64) -> R {
        let gap = self.gap.to_f64();
        match self.support {
            Support::Wires { length, .. } => {
                let l = length.to_f64();
                R::from_f64(libm::asin(relative_m / l) - libm::asin(gap / l))
            }
            Support::Beams { .. } => R::from_f64(relative_m - gap),
        }
    }

    /// q̇ of a hammer at `q` that moves at `velocity` (d/dt of l sin θ or Δ), m/s.
    pub fn coordinate_rate_at(&self, q: R, velocity: R) -> R {
        velocity / self.kinematics(q, R::ZERO).slope
    }

    /// Displacement relative to the cart, m: l sin θ (3-18) or Δ = x − y.
    #[inline]
    pub fn relative_displacement(&self, q: R) -> R {
        self.kinematics(q, R::ZERO).delta + self.gap
    }

    /// Penetration and its rate (3-17, 3-33).
    #[inline]
    pub fn kinematics(&self, q: R, v: R) -> Kinematics<R> {
        match self.support {
            Support::Wires {
                length,
                sin_gap,
                cos_gap,
                ..
            } => {
                let (sin, versin) = q.sin_versin();
                // sin θ − sin θ_gap and cos θ, from q = θ − θ_gap without cancellation.
                let past_gap = sin * cos_gap - versin * sin_gap;
                let cosine = cos_gap - (versin * cos_gap + sin * sin_gap);
                let slope = length * cosine;
                Kinematics {
                    delta: length * past_gap,
                    rate: slope * v,
                    slope,
                    deflection: sin_gap + past_gap,
                    cosine,
                }
            }
            Support::Beams { .. } => Kinematics {
                delta: q,
                rate: v,
                slope: R::ONE,
                deflection: q + self.gap,
                cosine: R::ONE,
            },
        }
    }

    /// Contact force as the law gives it (N, negative where it would pull), whatever the mode.
    #[inline]
    pub fn force(&self, at: &Kinematics<R>, approach: R) -> R {
        self.law.force(at.delta, at.rate, approach)
    }

    /// > 0 in contact, < 0 in flight; continuous ([`Law::indicator`]).
    #[inline]
    pub fn indicator(&self, at: &Kinematics<R>, approach: R) -> R {
        self.law.indicator(at.delta, at.rate, approach)
    }

    /// q̈ under the inertial acceleration `drive` (m/s²) and the contact force `force` (N): equations
    /// 3-26 and 3-27 for wires, 3-36 and 3-37 for beams.
    #[inline]
    pub fn acceleration(&self, at: &Kinematics<R>, v: R, drive: R, force: R) -> R {
        let push = drive - force * self.inverse_mass;
        match self.support {
            Support::Wires {
                inverse_length,
                gravity,
                torque: Torque::Literal,
                ..
            } => {
                let driven = drive * at.cosine - gravity * at.deflection;
                inverse_length * (driven - force * self.inverse_mass)
            }
            Support::Wires {
                inverse_length,
                gravity,
                torque: Torque::Cosine,
                ..
            } => inverse_length * (push * at.cosine - gravity * at.deflection),
            Support::Beams {
                stiffness_over_mass,
                damping_over_mass,
                cubic_over_mass,
            } => {
                let x = at.deflection;
                push - damping_over_mass * v - x * (stiffness_over_mass + cubic_over_mass * (x * x))
            }
        }
    }

    /// What a unit of `drive` adds to [`Rig::acceleration`].
    #[inline]
    pub fn acceleration_per_drive(&self, at: &Kinematics<R>) -> R {
        match self.support {
            Support::Wires { inverse_length, .. } => inverse_length * at.cosine,
            Support::Beams { .. } => R::ONE,
        }
    }

    /// δ̈, m/s², from q̈: the rate at which a damper's force changes.
    #[inline]
    pub fn penetration_acceleration(&self, at: &Kinematics<R>, v: R, acceleration: R) -> R {
        match self.support {
            Support::Wires { length, .. } => {
                at.slope * acceleration - length * at.deflection * (v * v)
            }
            Support::Beams { .. } => acceleration,
        }
    }

    /// Power the contact force takes from the hammer, W: the force (or torque) that the equation of
    /// motion really applies, times q̇. With the literal torque of 3-16 this is F l θ̇, not F δ̇.
    #[inline]
    pub fn contact_power(&self, at: &Kinematics<R>, v: R, force: R) -> R {
        match self.support {
            Support::Wires {
                length,
                torque: Torque::Literal,
                ..
            } => force * length * v,
            _ => force * at.rate,
        }
    }

    /// Kinetic and potential energy relative to the cart, J.
    pub fn energy(&self, at: &Kinematics<R>, v: R) -> R {
        let half = R::HALF * self.mass;
        match self.support {
            Support::Wires {
                length, gravity, ..
            } => {
                let fall = length * (at.deflection * at.deflection / (R::ONE + at.cosine));
                let speed = length * v;
                half * speed * speed + self.mass * gravity * fall
            }
            Support::Beams {
                stiffness_over_mass,
                cubic_over_mass,
                ..
            } => {
                let x2 = at.deflection * at.deflection;
                half * (v * v + x2 * (stiffness_over_mass + R::HALF * cubic_over_mass * x2))
            }
        }
    }

    /// Power of the inertial force m A0 Ω² sin Ωt on the hammer, W.
    pub fn inertial_power(&self, at: &Kinematics<R>, drive: R) -> R {
        self.mass * drive * at.rate
    }

    /// Power the support's damping takes from the hammer, W (none on wires).
    pub fn damping_power(&self, v: R) -> R {
        match self.support {
            Support::Wires { .. } => R::ZERO,
            Support::Beams {
                damping_over_mass, ..
            } => self.mass * damping_over_mass * v * v,
        }
    }
}

/// The rest position of `params` in the coordinate q.
fn rest_coordinate(params: &RigParams) -> f64 {
    if params.gap_m >= 0.0 {
        return match params.support {
            SupportParams::Wires { length_m, .. } => -libm::asin(params.gap_m / length_m),
            SupportParams::Beams { .. } => -params.gap_m,
        };
    }
    // Pressed on: ki δⁿ rises and the support's force falls as δ goes from 0 to −gap; they meet once.
    let support = |x: f64| match params.support {
        SupportParams::Wires {
            length_m,
            gravity_m_per_s2,
            ..
        } => -params.mass_kg * gravity_m_per_s2 * x / length_m,
        SupportParams::Beams {
            natural_frequency_hz,
            cubic_stiffness_n_per_m3,
            ..
        } => {
            let omega = core::f64::consts::TAU * natural_frequency_hz;
            let stiffness = params.mass_kg * omega * omega;
            let cubic = cubic_stiffness_n_per_m3.unwrap_or(stiffness);
            -x * (stiffness + cubic * x * x)
        }
    };
    let (stiffness, exponent) = (params.contact.stiffness(), params.contact.exponent());
    let (mut low, mut high) = (0.0, -params.gap_m);
    for _ in 0..1100 {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            break;
        }
        if stiffness * libm::pow(middle, exponent) < support(middle + params.gap_m) {
            low = middle;
        } else {
            high = middle;
        }
    }
    let delta = 0.5 * (low + high);
    match params.support {
        SupportParams::Wires { length_m, .. } => {
            libm::asin((delta + params.gap_m) / length_m) - libm::asin(params.gap_m / length_m)
        }
        SupportParams::Beams { .. } => delta,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::params::{BEAM_150, PRESETS, WIRES};

    fn close(a: f64, b: f64, relative: f64) {
        assert!((a - b).abs() <= relative * b.abs(), "{a} against {b}");
    }

    #[test]
    fn wires_follow_equation_3_15() {
        let params = RigParams {
            gap_m: 2.4e-3,
            ..WIRES
        };
        let rig = Rig::<f64>::new(&params).unwrap();
        let (theta, theta_dot, drive) = (-0.05_f64, 0.7, 0.3);
        let q = theta - (params.gap_m / 0.075).asin();
        let at = rig.kinematics(q, theta_dot);
        close(at.delta, 0.075 * theta.sin() - 2.4e-3, 1e-12);
        close(at.rate, 0.075 * theta_dot * theta.cos(), 1e-13);
        let want = (drive * theta.cos() - 9.81 * theta.sin()) / 0.075;
        close(rig.acceleration(&at, theta_dot, drive, 0.0), want, 1e-12);
        let pushed = rig.acceleration(&at, theta_dot, drive, 50.0);
        close(pushed, want - 50.0 / (0.298 * 0.075), 1e-12);
    }

    #[test]
    fn beams_follow_equation_3_30() {
        let params = RigParams {
            gap_m: 1e-3,
            ..BEAM_150
        };
        let rig = Rig::<f64>::new(&params).unwrap();
        let (delta, rate, drive) = (-4e-3, 0.1, 0.2);
        let at = rig.kinematics(delta - 1e-3, rate);
        let omega = core::f64::consts::TAU * 5.25;
        let (k, c) = (0.298 * omega * omega, 2.0 * 0.004 * 0.298 * omega);
        close(c, 0.0786, 1e-3);
        let want = drive - (c * rate + k * delta + k * delta.powi(3) + 30.0) / 0.298;
        close(rig.acceleration(&at, rate, drive, 30.0), want, 1e-12);
    }

    #[test]
    fn energy_changes_by_the_power_of_what_acts() {
        for (_, params) in PRESETS {
            let rig = Rig::<f64>::new(&params).unwrap();
            let (q, v, drive, force) = (-0.02, 0.11, 0.4, 12.0);
            let at = rig.kinematics(q, v);
            let a = rig.acceleration(&at, v, drive, force);
            let h = 1e-6;
            let energy = |t: f64| {
                let (q, v) = (q + v * t + 0.5 * a * t * t, v + a * t);
                rig.energy(&rig.kinematics(q, v), v)
            };
            let rate = (energy(h) - energy(-h)) / (2.0 * h);
            let power = rig.inertial_power(&at, drive)
                - rig.damping_power(v)
                - rig.contact_power(&at, v, force);
            close(rate, power, 1e-6);
        }
    }

    #[test]
    fn penetration_keeps_its_relative_accuracy_in_f32_at_a_large_gap() {
        let params = RigParams {
            gap_m: 3.56e-3,
            ..WIRES
        };
        let (fine, coarse) = (
            Rig::<f64>::new(&params).unwrap(),
            Rig::<f32>::new(&params).unwrap(),
        );
        for q in [1e-7_f32, 3e-6, 1e-4, -1e-4, -0.05] {
            let want = fine.kinematics(f64::from(q), 0.0).delta;
            close(f64::from(coarse.kinematics(q, 0.0).delta), want, 3e-7);
        }
    }

    #[test]
    fn a_hammer_pressed_on_rests_in_equilibrium() {
        let soft = crate::model::contact::Law::SpringDashpot {
            stiffness: 200.0,
            damping: 1.0,
        };
        let laws = crate::model::contact::LAWS.iter().map(|(_, law)| *law);
        for contact in laws.chain([soft]) {
            for (_, params) in PRESETS {
                for gap_m in [-1e-20, -1e-9, -0.05e-3, -1e-3] {
                    let params = RigParams {
                        gap_m,
                        contact,
                        ..params
                    };
                    let rig = Rig::<f64>::new(&params).unwrap();
                    let at = rig.kinematics(rig.rest(), 0.0);
                    let force = rig.force(&at, 0.0);
                    let pressing = rig.acceleration(&at, 0.0, 0.0, 0.0).abs();
                    let left = rig.acceleration(&at, 0.0, 0.0, force).abs();
                    assert!(
                        left <= 1e-6 * pressing + 1e-9,
                        "{contact:?} {gap_m}: {left}"
                    );
                }
            }
        }
    }
}
