//! Contact laws: the force between hammer and impact surface from penetration δ and its rate δ̇
//! (equations 3-2 to 3-5).
//!
//! A contact pushes, never pulls. Two indicators decide (equation 3-20): h_α = δ (touching) and
//! h_β = F (pushing). After the spring-dashpot lets go, δ is still positive while F would pull: that is
//! free flight. So "in contact" is min(ki δ, F) > 0, never δ alone.

use serde::{Deserialize, Serialize};

use crate::model::scalar::Real;

/// A contact law with its parameters (SI: N, m, s).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Law<R> {
    /// Hertz, F = ki δⁿ (3-2). Loses no energy.
    Hertz {
        /// ki, N/mⁿ.
        stiffness: R,
        /// n.
        exponent: R,
    },
    /// Spring-dashpot, F = ki δ + ci δ̇ (3-3), the law the chapter identified (Table 3.1).
    SpringDashpot {
        /// ki, N/m.
        stiffness: R,
        /// ci, N·s/m.
        damping: R,
    },
    /// Hunt–Crossley, F = ki δⁿ (1 + λ δ̇) (3-4), λ = ci/ki.
    HuntCrossley {
        /// ki, N/mⁿ.
        stiffness: R,
        /// n.
        exponent: R,
        /// λ, s/m.
        damping_ratio: R,
    },
    /// Lankarani–Nikravesh, F = ki δⁿ (1 + ¾ (1 − e²) δ̇/δ̇⁻) (3-5), δ̇⁻ the approach speed.
    LankaraniNikravesh {
        /// ki, N/mⁿ.
        stiffness: R,
        /// n.
        exponent: R,
        /// Newton's coefficient of restitution e the law is given. What comes out is larger for small
        /// e: even e = 0 rebounds at about 0.66 of the approach speed.
        restitution: R,
    },
}

/// Smallest approach speed the Lankarani–Nikravesh law divides by, m/s: below it a contact is as
/// good as static, and the quotient δ̇/δ̇⁻ would lose meaning.
pub const APPROACH_SPEED_FLOOR_M_PER_S: f64 = 1e-4;

/// Penetration that weighs as much as the whole damping factor in the nonlinear laws' indicator, m.
const INDICATOR_LENGTH_M: f64 = 1e-6;

impl<R: Real> Law<R> {
    /// ki, N/m or N/mⁿ.
    #[inline]
    pub fn stiffness(&self) -> R {
        match *self {
            Self::Hertz { stiffness, .. }
            | Self::SpringDashpot { stiffness, .. }
            | Self::HuntCrossley { stiffness, .. }
            | Self::LankaraniNikravesh { stiffness, .. } => stiffness,
        }
    }

    /// The exponent n (1 for the spring-dashpot).
    #[inline]
    pub fn exponent(&self) -> R {
        match *self {
            Self::Hertz { exponent, .. }
            | Self::HuntCrossley { exponent, .. }
            | Self::LankaraniNikravesh { exponent, .. } => exponent,
            Self::SpringDashpot { .. } => R::ONE,
        }
    }

    /// F as the law's formula gives it, N: negative where the law would pull. `approach` is δ̇⁻, the
    /// penetration rate at onset, m/s (only the Lankarani–Nikravesh law reads it).
    ///
    /// For the nonlinear laws δ ≤ 0 gives 0.
    #[inline]
    pub fn force(&self, delta: R, rate: R, approach: R) -> R {
        match *self {
            Self::SpringDashpot { stiffness, damping } => stiffness * delta + damping * rate,
            _ => self.elastic(delta) * self.damping_factor(rate, approach),
        }
    }

    /// F(0, δ̇), N: the force at the very onset, which the band's Σα field uses (3-28). The
    /// spring-dashpot's damper acts at once; the nonlinear laws start from zero.
    #[inline]
    pub fn onset_force(&self, rate: R) -> R {
        match *self {
            Self::SpringDashpot { damping, .. } => damping * rate,
            _ => R::ZERO,
        }
    }

    /// A function that is positive in contact and negative in flight: min(ki δ, F) for the spring-dashpot,
    /// and a smooth equivalent of min(δ, 1 + λδ̇) for the others. It is continuous along a trajectory,
    /// so that its zeros can be located.
    #[inline]
    pub fn indicator(&self, delta: R, rate: R, approach: R) -> R {
        match *self {
            Self::SpringDashpot { stiffness, damping } => {
                let spring = stiffness * delta;
                spring.min(spring + damping * rate)
            }
            _ => {
                let factor = self.damping_factor(rate, approach);
                delta.min(R::from_f64(INDICATOR_LENGTH_M) * factor)
            }
        }
    }

    /// A function that is positive in contact and falls through zero at release. For the spring-dashpot F
    /// alone, which, unlike [`Self::indicator`], is not zero at onset too.
    #[inline]
    pub fn release_indicator(&self, delta: R, rate: R, approach: R) -> R {
        match self {
            Self::SpringDashpot { .. } => self.force(delta, rate, approach),
            _ => self.indicator(delta, rate, approach),
        }
    }

    /// Partial derivatives (∂F/∂δ, ∂F/∂δ̇) of [`Self::force`], N/m and N·s/m.
    #[inline]
    pub fn gradient(&self, delta: R, rate: R, approach: R) -> (R, R) {
        match *self {
            Self::SpringDashpot { stiffness, damping } => (stiffness, damping),
            _ if delta > R::ZERO => {
                let elastic = self.elastic(delta);
                let slope = self.exponent() * elastic / delta;
                (
                    slope * self.damping_factor(rate, approach),
                    elastic * self.damping_per_speed(approach),
                )
            }
            _ => (R::ZERO, R::ZERO),
        }
    }

    /// ki δⁿ, N; 0 for δ ≤ 0.
    #[inline]
    fn elastic(&self, delta: R) -> R {
        if delta <= R::ZERO {
            return R::ZERO;
        }
        let exponent = self.exponent();
        if exponent == R::ONE + R::HALF {
            self.stiffness() * (delta * delta.sqrt())
        } else {
            self.stiffness() * delta.powf(exponent)
        }
    }

    /// The nonlinear laws' 1 + (damping per speed) δ̇.
    #[inline]
    fn damping_factor(&self, rate: R, approach: R) -> R {
        R::ONE + self.damping_per_speed(approach) * rate
    }

    /// λ, or ¾ (1 − e²)/δ̇⁻, s/m.
    #[inline]
    fn damping_per_speed(&self, approach: R) -> R {
        match *self {
            Self::HuntCrossley { damping_ratio, .. } => damping_ratio,
            Self::LankaraniNikravesh { restitution, .. } => {
                let floor = R::from_f64(APPROACH_SPEED_FLOOR_M_PER_S);
                let loss = R::from_f64(0.75) * (R::ONE - restitution * restitution);
                loss / approach.max(floor)
            }
            Self::Hertz { .. } | Self::SpringDashpot { .. } => R::ZERO,
        }
    }

    /// The same law in another scalar.
    pub fn cast<T: Real>(&self) -> Law<T> {
        let t = |x: R| T::from_f64(x.to_f64());
        match *self {
            Self::Hertz {
                stiffness,
                exponent,
            } => Law::Hertz {
                stiffness: t(stiffness),
                exponent: t(exponent),
            },
            Self::SpringDashpot { stiffness, damping } => Law::SpringDashpot {
                stiffness: t(stiffness),
                damping: t(damping),
            },
            Self::HuntCrossley {
                stiffness,
                exponent,
                damping_ratio,
            } => Law::HuntCrossley {
                stiffness: t(stiffness),
                exponent: t(exponent),
                damping_ratio: t(damping_ratio),
            },
            Self::LankaraniNikravesh {
                stiffness,
                exponent,
                restitution,
            } => Law::LankaraniNikravesh {
                stiffness: t(stiffness),
                exponent: t(exponent),
                restitution: t(restitution),
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LAWS: [Law<f64>; 4] = [
        Law::Hertz {
            stiffness: 2.1e8,
            exponent: 1.6,
        },
        Law::SpringDashpot {
            stiffness: 5.5e6,
            damping: 1.2e3,
        },
        Law::HuntCrossley {
            stiffness: 2.1e8,
            exponent: 1.6,
            damping_ratio: 0.6,
        },
        Law::LankaraniNikravesh {
            stiffness: 2.1e8,
            exponent: 1.5,
            restitution: 0.8,
        },
    ];

    #[test]
    fn indicator_is_positive_exactly_where_the_surface_is_touched_and_pushes() {
        for law in LAWS {
            for delta in [-1e-3, -1e-6, 1e-7, 1e-5, 1e-4] {
                for rate in [-3.0, -0.5, -0.01, 0.0, 0.2] {
                    let contact = delta > 0.0 && law.force(delta, rate, 0.1) > 0.0;
                    let indicator = law.indicator(delta, rate, 0.1);
                    assert_eq!(indicator > 0.0, contact, "{law:?} {delta} {rate}");
                }
            }
        }
    }

    #[test]
    fn gradient_matches_finite_differences() {
        for law in LAWS {
            let (delta, rate) = (2e-5, -0.03);
            let (by_delta, by_rate) = law.gradient(delta, rate, 0.1);
            let (h, v) = (1e-10, 1e-5);
            let force = |d, r| law.force(d, r, 0.1);
            let fd = (force(delta + h, rate) - force(delta - h, rate)) / (2.0 * h);
            let fr = (force(delta, rate + v) - force(delta, rate - v)) / (2.0 * v);
            assert!((by_delta - fd).abs() <= 1e-4 * fd.abs(), "{law:?}");
            assert!((by_rate - fr).abs() <= 1e-4 * fr.abs() + 1e-9, "{law:?}");
        }
    }

    #[test]
    fn only_the_spring_dashpot_jumps_at_onset() {
        for law in LAWS {
            let jumps = law.onset_force(0.08) > 0.0;
            assert_eq!(jumps, matches!(law, Law::SpringDashpot { .. }));
            assert_eq!(law.onset_force(0.08), law.force(0.0, 0.08, 0.08));
        }
    }
}
