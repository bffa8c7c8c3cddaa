//! Two bodies: hammer m in cart M, and the smooth flow of both between switches.
//!
//! The hammer's equation is [`shared::model::rig`]'s, relative to the cart. It is affine in the cart's acceleration
//! ÿ, which enters as the inertial acceleration −ÿ: δ̈ = d0 − d1 ÿ. With the shaker's force Fs on the cart,
//! M ÿ = Fs − m (ÿ + δ̈), so ÿ = (Fs − m d0)/(M + m (1 − d1)).

use shared::model::rig::{Kinematics, Mode, Rig};

use super::shaker::{Loop, Path};

/// Where both bodies are.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct State {
    /// The hammer's coordinate relative to the cart ([`shared::model::rig`]).
    pub q: f64,
    /// Its rate.
    pub v: f64,
    /// Cart displacement y, m.
    pub y: f64,
    /// Cart speed ẏ, m/s.
    pub w: f64,
}

/// Integrated beside the motion: where energy and momentum went.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Totals {
    /// ∫F dt of the contact force, N·s.
    pub impulse: f64,
    /// Energy the contact took, J.
    pub contact_work: f64,
    /// ∫Fs dt of the shaker's force, N·s.
    pub shaker_impulse: f64,
    /// Work of the shaker, J.
    pub shaker_work: f64,
    /// Energy the support's damping took, J.
    pub damping_work: f64,
}

impl Totals {
    /// `weight` times `other` on top.
    #[inline]
    pub fn add(&mut self, other: &Self, weight: f64) {
        self.impulse += weight * other.impulse;
        self.contact_work += weight * other.contact_work;
        self.shaker_impulse += weight * other.shaker_impulse;
        self.shaker_work += weight * other.shaker_work;
        self.damping_work += weight * other.damping_work;
    }
}

/// What both bodies are under during a tick.
#[derive(Clone, Copy, Debug)]
pub struct Bodies {
    /// The hammer.
    pub rig: Rig<f64>,
    /// M, kg.
    pub cart_mass_kg: f64,
    /// How the cart is moved.
    pub shaker: Loop,
    /// The set-point over the tick.
    pub path: Path,
    /// Whether the drive is enabled.
    pub on: bool,
    /// Side of the switch.
    pub mode: Mode,
    /// δ̇⁻ of the contact, m/s.
    pub approach: f64,
}

/// Rates at a point, and what acts there.
#[derive(Clone, Copy, Debug, Default)]
pub struct Rates {
    /// Rate of the state.
    pub state: State,
    /// Contact force, N.
    pub force: f64,
    /// Rates of the totals.
    pub powers: Totals,
}

impl Bodies {
    /// Position of the hammer relative to the surface.
    #[inline]
    pub fn kinematics(&self, state: &State) -> Kinematics<f64> {
        self.rig.kinematics(state.q, state.v)
    }

    /// Rates at `state`, `s` seconds into the tick.
    #[inline]
    pub fn rates(&self, state: &State, s: f64) -> Rates {
        let (rig, v) = (&self.rig, state.v);
        let at = self.kinematics(state);
        let force = match self.mode {
            Mode::Flight => 0.0,
            Mode::Contact => rig.force(&at, self.approach),
        };
        let want = self.path.at(s);
        let (m, cart) = (rig.mass(), self.cart_mass_kg);
        let still = rig.acceleration(&at, v, 0.0, force);
        let still_surface = rig.penetration_acceleration(&at, v, still);
        let per_drive = rig.acceleration(&at, v, 1.0, force) - still;
        let surface_per_drive = at.slope * per_drive;
        let (shaker_n, cart_acceleration) = match &self.shaker {
            Loop::Force(gains) => {
                let shaker_n = gains.force(self.on, want, state.y, state.w);
                let moved = cart + m * (1.0 - surface_per_drive);
                (shaker_n, (shaker_n - m * still_surface) / moved)
            }
            Loop::Prescribed => {
                let surface = still_surface - surface_per_drive * want.2;
                ((cart + m) * want.2 + m * surface, want.2)
            }
        };
        Rates {
            state: State {
                q: v,
                v: still - per_drive * cart_acceleration,
                y: state.w,
                w: cart_acceleration,
            },
            force,
            powers: Totals {
                impulse: force,
                contact_work: rig.contact_power(&at, v, force),
                shaker_impulse: shaker_n,
                shaker_work: shaker_n * state.w,
                damping_work: rig.damping_power(v),
            },
        }
    }

    /// Runge and Kutta's fourth-order step of length `h` from `s` seconds into the tick; adds to `totals`.
    #[inline]
    pub fn step(&self, from: &State, s: f64, h: f64, totals: &mut Totals) -> State {
        let half = 0.5 * h;
        let a = self.rates(from, s);
        let b = self.rates(&moved(from, &a.state, half), s + half);
        let c = self.rates(&moved(from, &b.state, half), s + half);
        let d = self.rates(&moved(from, &c.state, h), s + h);
        let (outer, inner) = (h / 6.0, h / 3.0);
        totals.add(&a.powers, outer);
        totals.add(&b.powers, inner);
        totals.add(&c.powers, inner);
        totals.add(&d.powers, outer);
        let sum = |f: fn(&State) -> f64| {
            f(from) + outer * (f(&a.state) + f(&d.state)) + inner * (f(&b.state) + f(&c.state))
        };
        State {
            q: sum(|x| x.q),
            v: sum(|x| x.v),
            y: sum(|x| x.y),
            w: sum(|x| x.w),
        }
    }

    /// > 0 in contact, < 0 in flight; what the switch is located by.
    pub fn indicator(&self, state: &State) -> f64 {
        let at = self.kinematics(state);
        match self.mode {
            Mode::Flight => self.rig.indicator(&at, at.rate.max(0.0)),
            Mode::Contact => {
                let law = self.rig.law();
                law.release_indicator(at.delta, at.rate, self.approach)
            }
        }
    }

    /// Contact force at `state` and its rate of change, N and N/s.
    pub fn force_and_rate(&self, state: &State, s: f64) -> (f64, f64) {
        let at = self.kinematics(state);
        let rates = self.rates(state, s);
        let change = self
            .rig
            .penetration_acceleration(&at, state.v, rates.state.v);
        let law = self.rig.law();
        let (by_delta, by_rate) = law.gradient(at.delta, at.rate, self.approach);
        (rates.force, by_delta * at.rate + by_rate * change)
    }

    /// Mechanical energy of both bodies and the support, fixed frame, without the surface's, J.
    pub fn energy_j(&self, state: &State) -> f64 {
        let at = self.kinematics(state);
        let (m, w) = (self.rig.mass(), state.w);
        let relative = self.rig.energy(&at, state.v);
        relative + m * w * at.rate + 0.5 * (self.cart_mass_kg + m) * w * w
    }

    /// Horizontal momentum of both bodies, fixed frame, kg·m/s.
    pub fn momentum(&self, state: &State) -> f64 {
        let at = self.kinematics(state);
        let m = self.rig.mass();
        (self.cart_mass_kg + m) * state.w + m * at.rate
    }
}

#[inline]
fn moved(from: &State, rate: &State, h: f64) -> State {
    State {
        q: from.q + h * rate.q,
        v: from.v + h * rate.v,
        y: from.y + h * rate.y,
        w: from.w + h * rate.w,
    }
}
