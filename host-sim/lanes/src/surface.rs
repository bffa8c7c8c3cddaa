//! A contact by a law without a closed form, one lane at a time in f64: steps of Dormand and Prince's method of order 5 (J. R.
//! Dormand and P. J. Prince, Journal of Computational and Applied Mathematics 6 (1980) 19–26) to where the surface lets go. Of
//! Hertz's contact, rebound and largest force are met within 2e-6.

use shared::model::contact::Law;

use super::constants::Constants;
use super::form::crossing;

/// The law of a cell, and how it is without units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LawSurface {
    pub law: Law<f64>,
    /// Penetration per x, m.
    pub depth_m: f64,
    /// Its rate per x′, m/s.
    pub rate_m_per_s: f64,
    /// Contact force over what acts on x″: the torque's share.
    pub torque: f64,
    /// The support's spring about the surface.
    pub beside: f64,
}

/// x, x′, the cart's deviation and its rate.
pub type PressState = [f64; 4];

/// How a contact went.
pub enum Press {
    /// The surface has let go.
    Released,
    /// The time has come before.
    Held,
    /// It cannot be followed.
    Lost,
}

/// Steps after which a contact is given up.
const MOST: usize = 20_000;

/// Errors of a step are kept below this share of the approach speed, and of the way it leads in a contact.
const TOLERANCE: f64 = 1e-7;

/// A contact that begins more slowly, at rest on the surface say, is as accurate as one that begins with this x′.
const SLOWEST: f64 = 1e-3;

/// Longest step, in drive phase: over it the drive is held to third order.
const LONGEST: f64 = 0.03;

/// The longest step outward, over the time to the surface at the rate there.
const OUTWARD: f64 = 1.005;

/// The first step, as a share of a contact at the drive's speed.
const FIRST: f64 = 0.006;

const A: [[f64; 6]; 6] = [
    [1.0 / 5.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    [3.0 / 40.0, 9.0 / 40.0, 0.0, 0.0, 0.0, 0.0],
    [44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0, 0.0, 0.0, 0.0],
    [
        19_372.0 / 6_561.0,
        -25_360.0 / 2_187.0,
        64_448.0 / 6_561.0,
        -212.0 / 729.0,
        0.0,
        0.0,
    ],
    [
        9_017.0 / 3_168.0,
        -355.0 / 33.0,
        46_732.0 / 5_247.0,
        49.0 / 176.0,
        -5_103.0 / 18_656.0,
        0.0,
    ],
    [
        35.0 / 384.0,
        0.0,
        500.0 / 1_113.0,
        125.0 / 192.0,
        -2_187.0 / 6_784.0,
        11.0 / 84.0,
    ],
];
const C: [f64; 6] = [0.2, 0.3, 0.8, 8.0 / 9.0, 1.0, 1.0];
/// Order 5 less order 4.
const E: [f64; 7] = [
    71.0 / 57_600.0,
    0.0,
    -71.0 / 16_695.0,
    71.0 / 1_920.0,
    -17_253.0 / 339_200.0,
    22.0 / 525.0,
    -1.0 / 40.0,
];

/// The motion in contact from a drive phase on.
struct Motion<'a> {
    c: &'a Constants,
    surface: &'a LawSurface,
    approach: f64,
    /// Force over m A0 Ω² per xⁿ, undamped.
    per_power: f64,
    /// Exponent n of the law; none stands for 1.5, for which a square root is enough.
    exponent: Option<f64>,
    /// What x′ adds to the damping's factor, which is 1 at rest.
    per_rate: f64,
    /// sin τ and cos τ at the beginning of the step.
    phase: (f64, f64),
}

impl Motion<'_> {
    /// Force over m A0 Ω²: every law without a closed form is ki δⁿ (1 + d δ̇) ([`Law::force`]).
    #[inline]
    fn force(&self, [x, v, ..]: PressState) -> f64 {
        if x <= 0.0 {
            return 0.0;
        }
        let power = self
            .exponent
            .map_or_else(|| x * x.sqrt(), |n| libm::pow(x, n));
        (self.per_power * power * (1.0 + self.per_rate * v)).max(0.0)
    }

    /// Positive in contact ([`Law::indicator`]).
    fn indicator(&self, [x, v, ..]: PressState) -> f64 {
        let s = self.surface;
        s.law
            .indicator(s.depth_m * x, s.rate_m_per_s * v, self.approach)
    }

    fn rates(&self, t: f64, state: PressState) -> PressState {
        let [x, v, q, w] = state;
        let (c, s) = (self.c, self.surface);
        let (sin0, cos0) = self.phase;
        let sin = sin0 + t * (cos0 - 0.5 * t * (sin0 + t / 3.0 * cos0));
        let hold = c.pull - s.beside * x - c.damping * v - s.torque * self.force(state);
        let Some(recoil) = &c.recoil else {
            return [v, c.drive * sin + hold, 0.0, 0.0];
        };
        let j = &recoil.joint;
        [
            v,
            j.push_sin * sin + j.push_q * q + j.push_v * w + j.push_hold * hold,
            w,
            j.recoil_sin * sin - j.recoil_q * q - j.recoil_v * w - j.recoil_hold * hold,
        ]
    }

    /// A step of length `h`, and its error.
    fn step(
        &self,
        from: PressState,
        first: PressState,
        h: f64,
    ) -> (PressState, PressState, PressState) {
        if self.c.recoil.is_some() {
            self.step_of::<4>(from, first, h)
        } else {
            self.step_of::<2>(from, first, h)
        }
    }

    /// A step, and its error, with only the first `N` numbers of the state moving.
    fn step_of<const N: usize>(
        &self,
        from: PressState,
        first: PressState,
        h: f64,
    ) -> (PressState, PressState, PressState) {
        let mut rates = [first; 7];
        let mut end = from;
        for stage in 0..6 {
            end = from;
            for i in 0..N {
                let sum: f64 = (0..=stage).map(|k| A[stage][k] * rates[k][i]).sum();
                end[i] += h * sum;
            }
            rates[stage + 1] = self.rates(C[stage] * h, end);
        }
        let mut error = [0.0; 4];
        for i in 0..N {
            let sum: f64 = E.iter().zip(&rates).map(|(e, k)| e * k[i]).sum();
            error[i] = h * sum;
        }
        (end, rates[6], error)
    }
}

impl LawSurface {
    /// How long a contact at the drive's speed lasts, about, in drive phase.
    fn lasts(&self, c: &Constants) -> f64 {
        let n = self.law.exponent();
        // Where the force has taken up what the hammer brought at x′ = 1.
        3.0 * libm::pow(0.5 * (n + 1.0) / self.per_power(c), 1.0 / (n + 1.0))
    }

    /// Force over m A0 Ω² per xⁿ, undamped.
    fn per_power(&self, c: &Constants) -> f64 {
        self.law.stiffness() * libm::pow(self.depth_m, self.law.exponent()) / c.force_unit_n
    }

    /// The equations of a contact that begins with the rate `approach` (x′).
    fn motion<'a>(&'a self, c: &'a Constants, approach: f64) -> Motion<'a> {
        let approach = self.rate_m_per_s * approach;
        let still = self.damping_factor(0.0, 1.0, approach);
        Motion {
            c,
            surface: self,
            approach,
            per_power: self.per_power(c),
            exponent: Some(self.law.exponent()).filter(|n| *n != 1.5),
            per_rate: still.1 / still.0,
            phase: (0.0, 0.0),
        }
    }

    /// The motion from drive phase `tau` on in a contact that began with the rate `approach` (x′), for `end` at most, to where
    /// the surface lets go. `peak` grows to the largest force. How long it took, and how it went.
    pub fn press(
        &self,
        c: &Constants,
        (tau, end): (f64, f64),
        state: &mut PressState,
        approach: f64,
        peak: &mut f64,
    ) -> (f64, Press) {
        let mut motion = self.motion(c, approach);
        let lasts = self.lasts(c);
        let mut next = FIRST * lasts;
        let mut t = 0.0;
        let speed = approach.abs().max(state[1].abs()).max(SLOWEST);
        let units = [speed * lasts, speed, speed * lasts, speed];
        for _ in 0..MOST {
            motion.phase = libm::sincos(tau + t);
            let mut h = next.min(LONGEST).min(end - t);
            let [x, v, ..] = *state;
            if v < 0.0 && x > 0.0 {
                // Not far beyond the surface, where the force ends: the error's estimate would count that.
                h = h.min(OUTWARD * x / -v);
            }
            let first = motion.rates(0.0, *state);
            let (mut there, mut last, error) = motion.step(*state, first, h);
            let off = (0..4).map(|i| (error[i] / units[i]).abs());
            let off = off.fold(0.0, f64::max) / TOLERANCE;
            // A fourth root in place of a fifth: it is rounded alike everywhere, and quick.
            let change = (0.9 / off.sqrt().sqrt()).clamp(0.2, 4.0);
            next = h * change;
            if off > 1.0 {
                continue;
            }
            if !there[0].is_finite() {
                return (t, Press::Lost);
            }
            let released = motion.indicator(there) <= 0.0;
            let mut took = h;
            if released {
                let by_factor;
                (took, by_factor) = self.release(&motion, *state, first, (h, there));
                (there, last, _) = motion.step(*state, first, took);
                if !by_factor {
                    // By its depth: there it is, but for rounding.
                    there[0] = 0.0;
                }
            }
            *peak = peak.max(self.top(&motion, (*state, first), (there, last), took));
            *state = there;
            t += took;
            if released {
                return (t, Press::Released);
            }
            if t >= end {
                return (end, Press::Held);
            }
        }
        (t, Press::Lost)
    }

    /// What the damping makes of the elastic force, in a unit of its own, and its rate: negative where the surface would pull.
    pub fn factor(&self, v: f64, acceleration: f64, approach: f64) -> (f64, f64) {
        self.damping_factor(v, acceleration, self.rate_m_per_s * approach)
    }

    fn damping_factor(&self, v: f64, acceleration: f64, approach: f64) -> (f64, f64) {
        // It is straight in the rate, and the law's indicator where the depth does not count.
        let at = |v: f64| self.law.indicator(1.0, self.rate_m_per_s * v, approach);
        let still = at(0.0);
        (at(v), (at(-0.5) - still) * -2.0 * acceleration)
    }

    /// When in the step of length `h` to `there` the surface lets go, and whether it does so since it would pull, still pressed in.
    fn release(
        &self,
        motion: &Motion,
        from: PressState,
        first: PressState,
        (h, there): (f64, PressState),
    ) -> (f64, bool) {
        let by_depth = there[0] <= 0.0;
        let at = |s: f64| motion.step(from, first, s);
        let depth = |s: f64| {
            let ([x, v, ..], ..) = at(s);
            (x, v)
        };
        let factor = |s: f64| {
            let ([_, v, ..], rates, _) = at(s);
            self.damping_factor(v, rates[1], motion.approach)
        };
        let mut until = if by_depth { crossing(0.0, h, depth) } else { h };
        let by_factor = factor(until).0 < 0.0;
        if by_factor {
            until = crossing(0.0, until, factor);
        }
        (until, by_factor)
    }

    /// The largest force of a step.
    fn top(
        &self,
        motion: &Motion,
        (from, first): (PressState, PressState),
        (there, last): (PressState, PressState),
        h: f64,
    ) -> f64 {
        let slope = |state: PressState, rates: PressState| {
            let (by_depth, by_rate) = self.law.gradient(
                self.depth_m * state[0],
                self.rate_m_per_s * state[1],
                motion.approach,
            );
            by_depth * self.depth_m * rates[0] + by_rate * self.rate_m_per_s * rates[1]
        };
        let end = motion.force(there);
        let (rises, falls) = (slope(from, first), slope(there, last));
        if !(rises > 0.0 && falls < 0.0) {
            return end.max(motion.force(from));
        }
        let at = |s: f64| {
            let (state, rates, _) = motion.step(from, first, s);
            (motion.force(state), slope(state, rates))
        };
        // Where the slope, taken as straight between three places, vanishes.
        let mut s = h * rises / (rises - falls);
        let middle = at(s).1;
        s = if middle > 0.0 {
            s + (h - s) * middle / (middle - falls)
        } else {
            s * rises / (rises - middle)
        };
        at(s).0.max(end)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Cell;
    use shared::model::contact::LawKind;
    use shared::model::params::{RigParams, WIRES};

    /// Of wires at the gap 0 with this law.
    fn constants(law: Law<f64>) -> Constants {
        let cell = Cell {
            params: RigParams {
                contact: law,
                ..WIRES
            },
            frequency_hz: 3.7,
            start: [0.0, 0.0],
            phase: 0.0,
        };
        Constants::new(&cell).unwrap()
    }

    /// A blow on wires at the gap 0, at drive phase 0, fast enough that nothing but the surface counts.
    fn blow(kind: LawKind, v: f64) -> (Constants, f64, PressState, f64) {
        let c = constants(kind.preset());
        let surface = c.surface.unwrap();
        let (mut state, mut peak) = ([0.0, v, 0.0, 0.0], 0.0);
        let (t, press) = surface.press(&c, (0.0, 1.0), &mut state, v, &mut peak);
        assert!(matches!(press, Press::Released));
        (c, t, state, peak)
    }

    /// A law of another form than ki δⁿ (1 + d δ̇) fails here: [`Motion::force`] must learn it.
    #[test]
    fn the_force_is_the_law_s() {
        for (kind, exponent) in LawKind::all().flat_map(|kind| [(kind, 1.5), (kind, 2.2)]) {
            if kind == LawKind::SpringDashpot {
                continue;
            }
            let mut law = kind.preset();
            *law.number_mut("contact_exponent").unwrap() = exponent;
            let c = constants(law);
            let surface = c.surface.unwrap();
            let motion = surface.motion(&c, 2.0);
            for (x, v) in [
                (1e-3, 1.0),
                (0.02, 0.0),
                (0.01, -0.3),
                (0.01, -40.0),
                (-1e-3, 1.0),
            ] {
                let force_n = law.force(
                    surface.depth_m * x,
                    surface.rate_m_per_s * v,
                    surface.rate_m_per_s * 2.0,
                );
                let expected = force_n.max(0.0) / c.force_unit_n;
                let force = motion.force([x, v, 0.0, 0.0]);
                assert!(
                    (force - expected).abs() <= 1e-9 * expected,
                    "{kind:?} {x} {v}: {force} {expected}"
                );
            }
        }
    }

    /// Hertz's contact in closed form: it gives back all, is deepest where the spring has taken up what the hammer brought, and
    /// lasts 2.943 times that depth over the approach speed (K. L. Johnson, *Contact Mechanics*, 1985, section 11.4).
    #[test]
    fn hertz_s_contact_is_the_closed_form() {
        let v = 1e3;
        let (c, t, [x, rebound, ..], peak) = blow(LawKind::Hertz, v);
        let speed = c.surface.unwrap().rate_m_per_s * v;
        let (mass, law) = (WIRES.mass_kg, LawKind::Hertz.preset());
        let deepest_m = (1.25 * mass * speed * speed / law.stiffness()).powf(0.4);
        assert_eq!(x, 0.0);
        assert!((rebound / -v - 1.0).abs() < 2e-6, "{rebound}");
        let lasts = t / c.omega * speed / deepest_m;
        assert!((lasts - 2.943_275).abs() < 1e-5, "{lasts}");
        let force_n = peak * c.force_unit_n;
        let expected = law.stiffness() * deepest_m.powf(1.5);
        assert!((force_n / expected - 1.0).abs() < 2e-6, "{force_n}");
    }

    /// [`shared::model::contact::LAWS`]: all last as long at 0.08 m/s, and each gives back its share.
    #[test]
    fn the_laws_presets_last_and_rebound_as_they_were_made_to() {
        for (kind, restitution) in [
            (LawKind::Hertz, 1.0),
            (LawKind::HuntCrossley, 0.316_902),
            (LawKind::LankaraniNikravesh, 0.662_962),
            (LawKind::Flores, 0.316_902),
        ] {
            let unit = blow(kind, 1e3).0.surface.unwrap().rate_m_per_s;
            let v = 0.08 / unit;
            let (c, t, [_, rebound, ..], _) = blow(kind, v);
            // The drive moves the hammer by 1e-3 of its speed meanwhile.
            let ms = 1e3 * t / c.omega;
            assert!((ms - 0.570_751).abs() < 0.01, "{kind:?}: {ms}");
            assert!(
                (rebound / -v - restitution).abs() < 0.01,
                "{kind:?}: {rebound}"
            );
        }
    }
}
