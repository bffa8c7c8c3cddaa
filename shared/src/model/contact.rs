//! Contact laws: the force between hammer and impact surface from penetration δ and its rate δ̇
//! (equations 3-2 to 3-5).
//!
//! A contact pushes, never pulls. Two indicators decide (equation 3-20): h_α = δ (touching) and
//! h_β = F (pushing). After the spring-dashpot lets go, δ is still positive while F would pull: that is
//! free flight. So "in contact" is min(ki δ, F) > 0, never δ alone.

use serde::{Deserialize, Serialize};

use crate::model::number::{Allowed, Number, ParamError};
use crate::model::scalar::Real;

const STIFFNESS: Number = Number::new(
    "contact_stiffness_n_per_m",
    "ki (N/m^n for the nonlinear laws)",
    &Allowed(1e-3, 1e18, "a positive number from 0.001 to 1e18"),
);
const DAMPING: Number = Number::new(
    "contact_damping_n_s_per_m",
    "ci (spring-dashpot)",
    &Allowed(0.0, 1e12, "a number from 0 to 1e12"),
);
const EXPONENT: Number = Number::new(
    "contact_exponent",
    "n (nonlinear laws)",
    &Allowed(1.0, 4.0, "a number from 1 to 4"),
);
const DAMPING_RATIO: Number = Number::new(
    "contact_damping_ratio_s_per_m",
    "lambda = ci/ki (hunt-crossley)",
    &Allowed(0.0, 1e6, "a number from 0 to 1e6"),
);
const RESTITUTION: Number = Number::new(
    "contact_restitution",
    "e (lankarani-nikravesh, flores)",
    &Allowed(0.0, 1.0, "a number from 0 to 1"),
);

/// Restitution e of a law that divides by it: at least 0.01.
const RESTITUTION_ABOVE_ZERO: Number = Number::new(
    RESTITUTION.key,
    RESTITUTION.meaning,
    &Allowed(0.01, 1.0, "a number from 0.01 to 1"),
);

/// The numbers that a law may have, in the order of a rig file.
pub const NUMBERS: [Number; 5] = [STIFFNESS, DAMPING, EXPONENT, DAMPING_RATIO, RESTITUTION];

/// Makes [`Law`] and [`LawKind`] from a list of laws: name, formula with what is identified, and each law's numbers. A new
/// law goes to the end: settings in flash hold its place in the list.
macro_rules! laws {
    ($(
        $(#[$about:meta])*
        $law:ident = $name:literal, $formula:literal {
            $($(#[$meaning:meta])* $field:ident: $number:ident,)+
        }
    )+) => {
        /// A contact law with its parameters (SI: N, m, s).
        #[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
        pub enum Law<R> {
            $($(#[$about])* $law { $($(#[$meaning])* $field: R,)+ },)+
        }

        /// Which contact law, without its parameters.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
        #[serde(rename_all = "kebab-case")]
        pub enum LawKind {
            $($(#[$about])* $law,)+
        }

        impl LawKind {
            /// Its name, as rig files have it.
            pub const fn name(self) -> &'static str {
                match self { $(Self::$law => $name,)+ }
            }

            /// Its formula, and what of it is identified.
            pub const fn formula(self) -> &'static str {
                match self { $(Self::$law => $formula,)+ }
            }

            /// The law's numbers, in the order of a rig file.
            pub const fn numbers(self) -> &'static [Number] {
                match self { $(Self::$law => &[$($number),+],)+ }
            }
        }

        impl<R> Law<R> {
            /// Which law this is.
            pub const fn kind(&self) -> LawKind {
                match self { $(Self::$law { .. } => LawKind::$law,)+ }
            }

            /// The number called `key`; none if this law has none.
            pub fn number_mut(&mut self, key: &str) -> Option<&mut R> {
                match self {
                    $(Self::$law { $($field),+ } => {
                        $(if key == $number.key {
                            return Some($field);
                        })+
                        None
                    })+
                }
            }
        }

        impl<R: Real> Law<R> {
            /// This law with its numbers converted to the scalar `T`.
            pub fn cast<T: Real>(&self) -> Law<T> {
                match *self {
                    $(Self::$law { $($field),+ } => Law::$law {
                        $($field: T::from_f64($field.to_f64())),+
                    },)+
                }
            }
        }

        impl Law<f64> {
            /// Checks every number.
            ///
            /// # Errors
            /// If one is out of range: the first such.
            pub fn check(&self) -> Result<(), ParamError> {
                match *self {
                    $(Self::$law { $($field),+ } => { $($number.check($field)?;)+ })+
                }
                Ok(())
            }
        }
    };
}

laws! {
    /// Hertz, F = ki δⁿ (3-2). Loses no energy.
    Hertz = "hertz", "F = ki δⁿ (3-2): ki" {
        /// Contact stiffness ki, N/mⁿ.
        stiffness: STIFFNESS,
        /// Exponent n of the penetration.
        exponent: EXPONENT,
    }
    /// Spring-dashpot, F = ki δ + ci δ̇ (3-3), the law the chapter identified (Table 3.1).
    SpringDashpot = "spring-dashpot", "F = ki δ + ci δ̇ (3-3): ki and ci" {
        /// Contact stiffness ki, N/m.
        stiffness: STIFFNESS,
        /// Contact damping ci, N·s/m.
        damping: DAMPING,
    }
    /// Hunt–Crossley, F = ki δⁿ (1 + λ δ̇) (3-4), λ = ci/ki.
    HuntCrossley = "hunt-crossley", "F = ki δⁿ(1 + λ δ̇) (3-4): ki and λ" {
        /// Contact stiffness ki, N/mⁿ.
        stiffness: STIFFNESS,
        /// Exponent n of the penetration.
        exponent: EXPONENT,
        /// Damping λ = ci/ki, s/m.
        damping_ratio: DAMPING_RATIO,
    }
    /// Lankarani–Nikravesh, F = ki δⁿ (1 + ¾ (1 − e²) δ̇/δ̇⁻) (3-5), δ̇⁻ the approach speed.
    LankaraniNikravesh = "lankarani-nikravesh", "F = ki δⁿ(1 + ¾(1 − e²) δ̇/δ̇⁻) (3-5): ki and e" {
        /// Contact stiffness ki, N/mⁿ.
        stiffness: STIFFNESS,
        /// Exponent n of the penetration.
        exponent: EXPONENT,
        /// Newton's coefficient of restitution e the law is given. What comes out is larger for small
        /// e: even e = 0 rebounds at about 0.66 of the approach speed.
        restitution: RESTITUTION,
    }
    /// Flores, Machado, Silva and Martins, F = ki δⁿ (1 + 8 (1 − e)/(5 e) δ̇/δ̇⁻), δ̇⁻ the approach speed: made for contacts
    /// that lose much (Multibody System Dynamics 25 (2011) 357–375).
    Flores = "flores", "F = ki δⁿ(1 + 8(1 − e)/(5e) δ̇/δ̇⁻) (Flores 2011): ki and e" {
        /// Contact stiffness ki, N/mⁿ.
        stiffness: STIFFNESS,
        /// Exponent n of the penetration.
        exponent: EXPONENT,
        /// Newton's coefficient of restitution e. What comes out is at most 0.046 less.
        restitution: RESTITUTION_ABOVE_ZERO,
    }
}

/// The spring-dashpot of Table 3.1.
pub const TABLE_3_1: Law<f64> = Law::SpringDashpot {
    stiffness: 5.5e6,
    damping: 1.2e3,
};

/// The contact laws by name, each with parameters that make the contact of Table 3.1 (0.570751 ms and
/// restitution 0.316902 at 0.08 m/s, 0.298 kg against a fixed wall) as far as the law can: Table 3.1's ki
/// is in N/m and fits the spring-dashpot alone. All last as long. Hunt–Crossley and Flores also rebound as
/// much; Hertz loses nothing (restitution 1); Lankarani–Nikravesh rebounds at 0.662962 even at e = 0, its
/// lowest. A test in host-sim solves them anew.
pub const LAWS: [(&str, Law<f64>); 5] = [
    TABLE_3_1.entry(),
    Law::Hertz {
        stiffness: 2.515_020e9,
        exponent: 1.5,
    }
    .entry(),
    Law::HuntCrossley {
        stiffness: 4.520_403e9,
        exponent: 1.5,
        damping_ratio: 35.993_66,
    }
    .entry(),
    Law::LankaraniNikravesh {
        stiffness: 2.897_038e9,
        exponent: 1.5,
        restitution: 0.0,
    }
    .entry(),
    Law::Flores {
        stiffness: 4.520_403e9,
        exponent: 1.5,
        restitution: 0.357_183,
    }
    .entry(),
];

impl LawKind {
    /// All of them, in the order of [`LAWS`].
    pub fn all() -> impl Iterator<Item = Self> {
        LAWS.iter().map(|(_, law)| law.kind())
    }

    /// The law called `name`; none if there is none.
    pub fn named(name: &str) -> Option<Self> {
        Self::all().find(|kind| kind.name() == name)
    }

    /// The law with the parameters it has in [`LAWS`].
    pub fn preset(self) -> Law<f64> {
        let own = LAWS.iter().find(|(_, law)| law.kind() == self);
        own.map_or(TABLE_3_1, |(_, law)| *law)
    }

    /// Its numbers without the exponent: the stiffness, and how much is lost. They are what an identification seeks.
    pub fn without_exponent(self) -> impl Iterator<Item = Number> {
        let numbers = self.numbers().iter().copied();
        numbers.filter(|number| *number != EXPONENT)
    }

    /// Whether a parameter decides how much energy is lost.
    pub fn is_lossy(self) -> bool {
        self.without_exponent().count() > 1
    }

    /// Whether the force depends on the approach speed at the onset.
    pub const fn needs_approach_speed(self) -> bool {
        matches!(self, Self::LankaraniNikravesh | Self::Flores)
    }
}

impl Law<f64> {
    const fn entry(self) -> (&'static str, Self) {
        (self.kind().name(), self)
    }

    /// This law with its stiffness and what damps it scaled: ci, λ, 1 − e² (kept at or below 1), or
    /// Flores's (1 − e)/e (as far as e may be).
    #[must_use]
    pub fn scaled(mut self, by_stiffness: f64, by_damping: f64) -> Self {
        match &mut self {
            Self::Hertz { .. } => {}
            Self::SpringDashpot { damping, .. } => *damping *= by_damping,
            Self::HuntCrossley { damping_ratio, .. } => *damping_ratio *= by_damping,
            Self::LankaraniNikravesh { restitution: e, .. } => {
                let loss = ((1.0 - *e * *e) * by_damping).min(1.0);
                *e = Real::sqrt(1.0 - loss);
            }
            Self::Flores { restitution: e, .. } => {
                let scaled = *e / (*e + (1.0 - *e) * by_damping);
                *e = scaled.max(RESTITUTION_ABOVE_ZERO.range().0);
            }
        }
        if let Some(stiffness) = self.number_mut(STIFFNESS.key) {
            *stiffness *= by_stiffness;
        }
        self
    }
}

/// Smallest approach speed that a law divides by, m/s: below it a contact is as
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
            | Self::LankaraniNikravesh { stiffness, .. }
            | Self::Flores { stiffness, .. } => stiffness,
        }
    }

    /// The exponent n (1 for the spring-dashpot).
    #[inline]
    pub fn exponent(&self) -> R {
        match *self {
            Self::Hertz { exponent, .. }
            | Self::HuntCrossley { exponent, .. }
            | Self::LankaraniNikravesh { exponent, .. }
            | Self::Flores { exponent, .. } => exponent,
            Self::SpringDashpot { .. } => R::ONE,
        }
    }

    /// F as the law's formula gives it, N: negative where the law would pull. `approach` is δ̇⁻, the
    /// penetration rate at onset, m/s ([`LawKind::needs_approach_speed`]).
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

    /// λ, or what takes its place, s/m.
    // One copy of it in the image is enough.
    #[inline(never)]
    fn damping_per_speed(&self, approach: R) -> R {
        let loss = match *self {
            Self::HuntCrossley { damping_ratio, .. } => return damping_ratio,
            Self::LankaraniNikravesh { restitution: e, .. } => R::from_f64(0.75) * (R::ONE - e * e),
            Self::Flores { restitution: e, .. } => R::from_f64(1.6) * (R::ONE - e) / e,
            Self::Hertz { .. } | Self::SpringDashpot { .. } => return R::ZERO,
        };
        loss / approach.max(R::from_f64(APPROACH_SPEED_FLOOR_M_PER_S))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LAWS: [Law<f64>; 5] = [
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
        Law::Flores {
            stiffness: 2.1e8,
            exponent: 1.5,
            restitution: 0.4,
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
    fn a_law_with_more_or_less_damping_is_one_that_can_be() {
        for law in LAWS {
            for mut law in [law, LawKind::preset(law.kind())] {
                if let Some(e) = law.number_mut(RESTITUTION.key) {
                    *e = 0.02;
                }
                for by in [0.0, 0.5, 1.0, 1.2, 10.0] {
                    assert_eq!(law.scaled(2.0, by).check(), Ok(()), "{law:?} {by}");
                }
            }
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
