//! The closed form of a contact, one lane at a time in f64: from any state of it, at any later time.

use super::cart::Joint;
use super::constants::Constants;

/// Phase of the transient between samples of the force, rad.
const SAMPLE_ANGLE: f64 = 0.7;

/// Decay after which the transient is negligible: e⁻¹⁶ of it is left.
pub const DEAD_AFTER: f64 = 16.0;

/// The transient is negligible, too, when its force is less than this share of the forced one.
const DEAD_BELOW: f64 = 1e-7;

/// Where `at` (value and slope) takes the sign it has at `high`, between `low` and `high`.
pub fn crossing(low: f64, high: f64, at: impl Fn(f64) -> (f64, f64)) -> f64 {
    let rises = at(high).0 > 0.0;
    let (mut low, mut high) = (low, high);
    let mut t = high;
    for _ in 0..80 {
        let (value, slope) = at(t);
        if (value > 0.0) == rises {
            high = t;
        } else {
            low = t;
        }
        let newton = t - value / slope;
        let inside = low < newton && newton < high;
        let next = if inside { newton } else { 0.5 * (low + high) };
        let moved = (next - t).abs();
        t = next;
        if moved <= 1e-12 * high {
            break;
        }
    }
    t
}

/// The closed form of a contact from drive phase `tau`.
pub struct Form<'a> {
    pub c: &'a Constants,
    pub tau: f64,
    a: f64,
    b: f64,
    push: (f64, f64),
    pub together: Option<Together<'a>>,
}

impl<'a> Form<'a> {
    pub fn new(c: &'a Constants, tau: f64, [x, v]: [f64; 2], cart: [f64; 2]) -> Self {
        let (sin, cos) = libm::sincos(tau);
        let forced = c.forced_sin * sin + c.forced_cos * cos + c.forced_mean;
        let rate = c.forced_sin * cos - c.forced_cos * sin;
        let (mut a, mut rate) = (x - forced, v - rate);
        let together = c.recoil.as_ref().map(|recoil| {
            let together = Together::new(c, &recoil.joint, [a, rate], cart, (sin, cos));
            a -= together.hammer.0;
            rate -= together.slope(together.hammer).0;
            together
        });
        let b = (rate + c.decay * a) / c.pulsation;
        Self {
            c,
            tau,
            a,
            b,
            push: c.force_amplitudes(a, b),
            together: together.map(|together| together.under((a, b), (c.decay, c.pulsation))),
        }
    }

    /// The forced part of F: what multiplies sin τ and cos τ, and the mean.
    pub fn slow(&self) -> (f64, f64, f64) {
        let c = self.c;
        (
            c.contact_spring * c.forced_sin - c.contact_damper * c.forced_cos,
            c.contact_spring * c.forced_cos + c.contact_damper * c.forced_sin,
            c.contact_spring * c.forced_mean,
        )
    }

    /// e^(−μt) cos νt and e^(−μt) sin νt.
    pub fn transient(&self, t: f64) -> (f64, f64) {
        let decay = -self.c.decay * t;
        if decay < -2.0 * DEAD_AFTER {
            return (0.0, 0.0);
        }
        let (sin, cos) = libm::sincos(self.c.pulsation * t);
        let left = libm::exp(decay);
        (left * cos, left * sin)
    }

    /// The hammer's coordinate and rate `t` after `tau`.
    pub fn state(&self, t: f64) -> (f64, f64) {
        let c = self.c;
        let (cos, sin) = self.transient(t);
        let z = self.a * cos + self.b * sin;
        let turn = c.pulsation * (self.b * cos - self.a * sin);
        let (s, k) = libm::sincos(self.tau + t);
        let (x, v) = self.together.as_ref().map_or((0.0, 0.0), |together| {
            let shape = together.shape(t);
            (
                dot(together.hammer, shape),
                dot(together.slope(together.hammer), shape),
            )
        });
        (
            z + c.forced_sin * s + c.forced_cos * k + c.forced_mean + x,
            turn - c.decay * z + c.forced_sin * k - c.forced_cos * s + v,
        )
    }

    /// Force and its first two derivatives.
    pub fn force(&self, t: f64) -> (f64, f64, f64) {
        let c = self.c;
        let (cos, sin) = self.transient(t);
        let (a, b) = self.push;
        let (mu, nu) = (c.decay, c.pulsation);
        let (a1, b1) = (nu * b - mu * a, -nu * a - mu * b);
        let (a2, b2) = (nu * b1 - mu * a1, -nu * a1 - mu * b1);
        let (s, k) = libm::sincos(self.tau + t);
        let swing = c.forced_sin * s + c.forced_cos * k;
        let rate = c.forced_sin * k - c.forced_cos * s;
        let (stiff, damp) = (c.contact_spring, c.contact_damper);
        let [f, f1, f2] = self.together.as_ref().map_or([0.0; 3], |together| {
            let shape = together.shape(t);
            let slope = together.slope(together.push);
            [together.push, slope, together.slope(slope)].map(|force| dot(force, shape))
        });
        (
            a * cos + b * sin + stiff * (swing + c.forced_mean) + damp * rate + f,
            a1 * cos + b1 * sin + stiff * rate - damp * swing + f1,
            a2 * cos + b2 * sin - stiff * swing - damp * rate + f2,
        )
    }

    /// The extremum of F between `low` and `high`, and its time.
    pub fn extremum(&self, low: f64, high: f64, from: f64) -> (f64, f64) {
        let mut t = from;
        for _ in 0..2 {
            let (_, slope, bend) = self.force(t);
            t = (t - slope / bend).clamp(low, high);
        }
        (t, self.force(t).0)
    }

    /// Where F falls through zero between `low` and `high`.
    pub fn release(&self, low: f64, high: f64) -> f64 {
        crossing(low, high, |t| {
            let (value, slope, _) = self.force(t);
            (value, slope)
        })
    }
}

/// The pair in which hammer and cart go together, where the cart recoils: amplitudes of e^(−μt) cos νt and e^(−μt) sin νt.
pub struct Together<'a> {
    joint: &'a Joint<f64>,
    pub decay: f64,
    pulsation: f64,
    /// Amplitudes of the cart's deviation in this pair.
    cart: (f64, f64),
    /// Amplitudes of the hammer's coordinate in this pair.
    hammer: (f64, f64),
    /// Amplitudes of the contact force in this pair.
    push: (f64, f64),
    /// The cart in the other pair.
    touch: (f64, f64),
}

impl<'a> Together<'a> {
    /// The pair for a hammer that is `x`, `v` off what the drive forces, in a cart at `q`, `w`.
    fn new(
        c: &Constants,
        joint: &'a Joint<f64>,
        [x, v]: [f64; 2],
        [q, w]: [f64; 2],
        (sin, cos): (f64, f64),
    ) -> Self {
        let j = joint;
        let q = q - j.forced_sin * sin - j.forced_cos * cos;
        let w = w - j.forced_sin * cos + j.forced_cos * sin;
        let u = j.slow_q_by_x * x + j.slow_q_by_v * v + j.slow_q_by_q * q + j.slow_q_by_w * w;
        let u1 = j.slow_v_by_x * x + j.slow_v_by_v * v + j.slow_v_by_q * q + j.slow_v_by_w * w;
        let decay = 0.5 * j.slow_a;
        let pulsation = (j.slow_b - decay * decay).sqrt();
        let mut pair = Self {
            joint,
            decay,
            pulsation,
            cart: (u, (u1 + decay * u) / pulsation),
            hammer: (0.0, 0.0),
            push: (0.0, 0.0),
            touch: (0.0, 0.0),
        };
        pair.hammer = mixed(
            pair.cart,
            pair.slope(pair.cart),
            (j.x_by_slow, j.x_by_slow_v),
        );
        let force = (c.contact_spring, c.contact_damper);
        pair.push = mixed(pair.hammer, pair.slope(pair.hammer), force);
        pair
    }

    /// Adds the cart's amplitudes in the other pair, from those of the hammer, `a` and `b`.
    fn under(mut self, (a, b): (f64, f64), (decay, pulsation): (f64, f64)) -> Self {
        let slope = (pulsation * b - decay * a, -pulsation * a - decay * b);
        self.touch = mixed(
            (a, b),
            slope,
            (self.joint.q_by_touch, self.joint.q_by_touch_v),
        );
        self
    }

    /// The amplitudes of the derivative.
    fn slope(&self, (a, b): (f64, f64)) -> (f64, f64) {
        let (mu, nu) = (self.decay, self.pulsation);
        (nu * b - mu * a, -nu * a - mu * b)
    }

    /// e^(−μt) cos νt and e^(−μt) sin νt.
    fn shape(&self, t: f64) -> (f64, f64) {
        let left = libm::exp(-self.decay * t);
        let (sin, cos) = libm::sincos(self.pulsation * t);
        (left * cos, left * sin)
    }

    /// The cart and its rate in `form` at `t`.
    pub fn cart(&self, form: &Form, t: f64) -> [f64; 2] {
        let (shape, other) = (self.shape(t), form.transient(t));
        let (sin, cos) = libm::sincos(form.tau + t);
        let (forced_sin, forced_cos) = (self.joint.forced_sin, self.joint.forced_cos);
        let (mu, nu) = (form.c.decay, form.c.pulsation);
        let (a, b) = self.touch;
        let turned = (nu * b - mu * a, -nu * a - mu * b);
        [
            dot(self.cart, shape) + dot(self.touch, other) + forced_sin * sin + forced_cos * cos,
            dot(self.slope(self.cart), shape) + dot(turned, other) + forced_sin * cos
                - forced_cos * sin,
        ]
    }
}

fn dot((a, b): (f64, f64), (c, d): (f64, f64)) -> f64 {
    a * c + b * d
}

/// k x + c y, by amplitudes.
fn mixed(x: (f64, f64), y: (f64, f64), (k, c): (f64, f64)) -> (f64, f64) {
    (k * x.0 + c * y.0, k * x.1 + c * y.1)
}

/// The force of a closed form at even steps, by rotation.
pub struct Turning {
    pub step: f64,
    /// Both transient terms of F, and how a step turns and shrinks them.
    transient: (f64, f64),
    shrink: (f64, f64),
    /// Both terms of F in the pair in which hammer and cart go together, and how a step turns and shrinks them.
    together: (f64, f64),
    shrink_together: (f64, f64),
    /// Both forced terms of F, and how a step turns them.
    forced: (f64, f64),
    turn: (f64, f64),
    mean: f64,
}

impl Turning {
    pub fn new(form: &Form) -> Self {
        let c = form.c;
        let step = SAMPLE_ANGLE / c.pulsation;
        let (sample_sin, sample_cos) = libm::sincos(SAMPLE_ANGLE);
        let (sin, cos) = libm::sincos(form.tau);
        let (p, q, mean) = form.slow();
        let left = libm::exp(-c.decay * step);
        let (turn_sin, turn_cos) = libm::sincos(step);
        Self {
            step,
            transient: form.push,
            shrink: (left * sample_cos, left * sample_sin),
            together: form.together.as_ref().map_or((0.0, 0.0), |t| t.push),
            shrink_together: form.together.as_ref().map_or((0.0, 0.0), |t| t.shape(step)),
            forced: (p * sin + q * cos, p * cos - q * sin),
            turn: (turn_cos, turn_sin),
            mean,
        }
    }

    pub fn force(&self) -> f64 {
        self.transient.0 + self.forced.0 + self.mean + self.together.0
    }

    /// Whether drive and support alone make the force from here on.
    pub fn dead(&self) -> bool {
        let square = |(a, b): (f64, f64)| a * a + b * b;
        let least = DEAD_BELOW * DEAD_BELOW * (square(self.forced) + self.mean * self.mean);
        square(self.transient) < least && square(self.together) <= least
    }

    pub fn turn(&mut self) {
        self.transient = turned(self.transient, self.shrink);
        self.together = turned(self.together, self.shrink_together);
        self.forced = turned(self.forced, self.turn);
    }
}

/// (a, b) → (a c + b s, b c − a s).
fn turned((a, b): (f64, f64), (c, s): (f64, f64)) -> (f64, f64) {
    (a * c + b * s, b * c - a * s)
}
