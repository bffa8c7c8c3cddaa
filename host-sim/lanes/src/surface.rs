//! A contact by a law without a closed form, one lane at a time in f64: steps of Dormand and Prince's method of order 5 (J. R.
//! Dormand and P. J. Prince, Journal of Computational and Applied Mathematics 6 (1980) 19–26) to where the surface lets go. Of
//! Hertz's contact, rebound and largest force are met within 2e-6.

use shared::model::contact::Law;

use super::constants::Constants;
use super::form::crossing;

/// The law of a cell, and how it is without units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LawSurface {
    /// The law.
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
pub type State = [f64; 4];

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
const MOST: usize = 4000;

/// Errors of a step are kept below this share of the approach speed, and of the way it leads in a contact.
const TOLERANCE: f64 = 1e-7;

/// Longest step, in drive phase: over it the drive is held to third order.
const LONGEST: f64 = 0.03;

/// The first step, as a share of a contact at the drive's speed.
const FIRST: f64 = 0.05;

const A: [&[f64]; 6] = [
    &[1.0 / 5.0],
    &[3.0 / 40.0, 9.0 / 40.0],
    &[44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0],
    &[
        19_372.0 / 6_561.0,
        -25_360.0 / 2_187.0,
        64_448.0 / 6_561.0,
        -212.0 / 729.0,
    ],
    &[
        9_017.0 / 3_168.0,
        -355.0 / 33.0,
        46_732.0 / 5_247.0,
        49.0 / 176.0,
        -5_103.0 / 18_656.0,
    ],
    &[
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
    /// sin τ and cos τ at the beginning of the step.
    phase: (f64, f64),
}

impl Motion<'_> {
    /// Force over m A0 Ω².
    fn force(&self, [x, v, ..]: State) -> f64 {
        let LawSurface {
            law,
            depth_m,
            rate_m_per_s,
            ..
        } = *self.surface;
        let force_n = law.force(depth_m * x, rate_m_per_s * v, self.approach);
        force_n.max(0.0) / self.c.force_unit_n
    }

    /// Positive in contact ([`Law::indicator`]).
    fn indicator(&self, [x, v, ..]: State) -> f64 {
        let s = self.surface;
        s.law
            .indicator(s.depth_m * x, s.rate_m_per_s * v, self.approach)
    }

    /// [`LawSurface::factor`] without its rate.
    fn factor_of(&self, [_, v, ..]: State) -> f64 {
        self.surface.damping_factor(v, 0.0, self.approach).0
    }

    fn rates(&self, t: f64, state: State) -> State {
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
    fn step(&self, from: State, first: State, h: f64) -> (State, State, State) {
        if self.c.recoil.is_some() {
            self.step_of::<4>(from, first, h)
        } else {
            self.step_of::<2>(from, first, h)
        }
    }

    /// The same with the first `N` numbers moving.
    fn step_of<const N: usize>(&self, from: State, first: State, h: f64) -> (State, State, State) {
        let mut rates = [first; 7];
        let mut end = from;
        for (stage, weights) in A.iter().enumerate() {
            end = from;
            for i in 0..N {
                let sum: f64 = weights.iter().zip(&rates).map(|(a, k)| a * k[i]).sum();
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
        let (n, stiffness) = (self.law.exponent(), self.law.stiffness());
        // Where the force has taken up what the hammer brought at x′ = 1.
        let per_x = stiffness * libm::pow(self.depth_m, n) / c.force_unit_n;
        3.0 * libm::pow(0.5 * (n + 1.0) / per_x, 1.0 / (n + 1.0))
    }

    /// The motion from drive phase `tau` on in a contact that began with the rate `approach` (x′), for `end` at most, to where
    /// the surface lets go. `peak` grows to the largest force. How long it took, and how it went.
    pub fn press(
        &self,
        c: &Constants,
        (tau, end): (f64, f64),
        state: &mut State,
        approach: f64,
        peak: &mut f64,
    ) -> (f64, Press) {
        let mut motion = Motion {
            c,
            surface: self,
            approach: self.rate_m_per_s * approach,
            phase: (0.0, 0.0),
        };
        let lasts = self.lasts(c);
        let mut next = FIRST * lasts;
        let mut t = 0.0;
        let speed = approach.abs().max(state[1].abs());
        let units = [speed * lasts, speed, speed * lasts, speed];
        for _ in 0..MOST {
            motion.phase = libm::sincos(tau + t);
            let h = next.min(LONGEST).min(end - t);
            let first = motion.rates(0.0, *state);
            let (mut there, mut last, error) = motion.step(*state, first, h);
            let off = (0..4).map(|i| (error[i] / units[i]).abs());
            let off = off.fold(0.0, f64::max) / TOLERANCE;
            let change = (0.9 * libm::pow(off, -0.2)).clamp(0.2, 4.0);
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
                took = self.release(&motion, *state, first, (h, there));
                (there, last, _) = motion.step(*state, first, took);
                if motion.factor_of(there) > 0.0 {
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

    /// When in the step of length `h` to `there` the surface lets go.
    fn release(&self, motion: &Motion, from: State, first: State, (h, there): (f64, State)) -> f64 {
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
        if factor(until).0 < 0.0 {
            until = crossing(0.0, until, factor);
        }
        until
    }

    /// The largest force of a step.
    fn top(
        &self,
        motion: &Motion,
        (from, first): (State, State),
        (there, last): (State, State),
        h: f64,
    ) -> f64 {
        let slope = |state: State, rates: State| {
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

    /// A blow on wires at the gap 0, at drive phase 0, fast enough that nothing but the surface counts.
    fn blow(kind: LawKind, v: f64) -> (Constants, f64, State, f64) {
        let cell = Cell {
            params: RigParams {
                contact: kind.preset(),
                ..WIRES
            },
            frequency_hz: 3.7,
            start: [0.0, 0.0],
            phase: 0.0,
        };
        let c = Constants::new(&cell).unwrap();
        let surface = c.surface.unwrap();
        let (mut state, mut peak) = ([0.0, v, 0.0, 0.0], 0.0);
        let (t, press) = surface.press(&c, (0.0, 1.0), &mut state, v, &mut peak);
        assert!(matches!(press, Press::Released));
        (c, t, state, peak)
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
