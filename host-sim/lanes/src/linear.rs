//! Hammer and cart as one linear system of fourth order, about one angle of the wires (or on beams), in f64.
//!
//! With η the cart's deviation from its course over A0 and s what support and surface do to the hammer,
//!
//! ```text
//! x″ = λ (1−g) sin τ + λ (κ η + γ η′) + G s,   s = pull − K x − C x′,   G = 1 + λ μ
//! η″ = g sin τ − κ η − γ η′ − μ s
//! ```
//!
//! ([`shared::model::cart`], whose sin² of the angle makes λ, μ and g here.) Its characteristic polynomial is the product
//! of two quadratics: of the hammer (on its support, or on the surface) and of the cart on its loop. Each has a
//! pair of motions in which the other body follows as p x + q x′.

use shared::model::cart::LoopParams;

/// z″ = −a z′ − b z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DampedPair {
    /// a: twice the rate of decay.
    pub a: f64,
    /// Square of the angular frequency without damping.
    pub b: f64,
}

impl DampedPair {
    /// Decay and angular frequency, if it oscillates well.
    pub fn oscillation(self) -> Option<(f64, f64)> {
        let square = self.b - 0.25 * self.a * self.a;
        (square > 0.01 * self.b).then(|| (0.5 * self.a, square.sqrt()))
    }

    /// What z, z′ become under p z + q z′ and its derivative: the four weights, by row.
    pub fn weights(self, [p, q]: [f64; 2]) -> [[f64; 2]; 2] {
        [[p, q], [-q * self.b, p - q * self.a]]
    }
}

/// What support or surface do: s = pull − K x − C x′ (`pull` acts at the surface alone).
#[derive(Clone, Copy, Debug)]
pub struct Hold {
    /// K: what acts against x.
    pub stiffness: f64,
    /// C: what acts against x′.
    pub damping: f64,
}

/// Hammer and cart: the constants of the module's two equations.
#[derive(Clone, Copy, Debug)]
pub struct LinearBodies {
    /// λ = cos θ: share of the cart's acceleration that acts on the hammer.
    pub lever: f64,
    /// κ: stiffness of the cart's loop over the mass that it moves, in units of Ω².
    pub spring: f64,
    /// γ: damping of the cart's loop over the mass that it moves, in units of Ω.
    pub damper: f64,
    /// g: share of the course's acceleration that the feed-forward lacks.
    pub lag: f64,
    /// μ: how much of s acts back on the cart.
    pub share: f64,
}

impl LinearBodies {
    /// A hammer of `mass_ratio` carts at angle `sin` (its sine; 0 on beams) in a cart held by `held`, driven at `omega`.
    pub fn new(held: &LoopParams, mass_ratio: f64, omega: f64, sin: f64) -> Self {
        let moved = 1.0 + mass_ratio * sin * sin;
        let cos = (1.0 - sin * sin).sqrt();
        let own = core::f64::consts::TAU * held.frequency_hz / omega;
        Self {
            lever: cos,
            spring: own * own / moved,
            damper: 2.0 * held.damping_ratio * own / moved,
            lag: (moved - held.feed_forward) / moved,
            share: mass_ratio * cos / moved,
        }
    }

    /// G = 1 + λ μ: how many times more s accelerates a hammer whose cart recoils.
    pub fn gain(&self) -> f64 {
        1.0 + self.lever * self.share
    }

    /// The hammer's and the cart's quadratic, by Newton's method from guesses; none where it finds none.
    pub fn pairs(&self, hold: Hold, guess: DampedPair) -> Option<(DampedPair, DampedPair)> {
        let (stiff, damp) = (hold.stiffness, hold.damping);
        let c3 = self.gain() * damp + self.damper;
        let c2 = self.gain() * stiff + self.spring + damp * self.damper;
        let c1 = stiff * self.damper + damp * self.spring;
        let c0 = stiff * self.spring;
        let (mut a2, mut b2) = (guess.a, guess.b);
        for _ in 0..60 {
            let a1 = c3 - a2;
            let b1 = c2 - b2 - a1 * a2;
            let (r1, r0) = (a1 * b2 + a2 * b1 - c1, b1 * b2 - c0);
            let lean = a2 - a1;
            let (r1_a, r1_b) = (b1 - b2 + a2 * lean, -lean);
            let (r0_a, r0_b) = (b2 * lean, b1 - b2);
            let whole = r1_a * r0_b - r1_b * r0_a;
            let step_a = (r1 * r0_b - r0 * r1_b) / whole;
            let step_b = (r0 * r1_a - r1 * r0_a) / whole;
            a2 -= step_a;
            b2 -= step_b;
            let moved = step_a.abs() / b2.abs().sqrt() + step_b.abs() / b2.abs();
            if !moved.is_finite() {
                return None;
            }
            if moved < 1e-12 {
                let a1 = c3 - a2;
                let b1 = c2 - b2 - a1 * a2;
                let sound = b1 > 0.0 && b2 > 0.0 && a1 >= 0.0 && a2 >= 0.0;
                return sound.then_some((DampedPair { a: a1, b: b1 }, DampedPair { a: a2, b: b2 }));
            }
        }
        None
    }

    /// p and q of η = p x + q x′ in a pair of motions.
    pub fn cart_by_hammer(&self, hold: Hold, pair: DampedPair) -> [f64; 2] {
        let (k, c) = (self.lever * self.spring, self.lever * self.damper);
        follows(
            k,
            c,
            pair,
            hold.stiffness * self.gain(),
            hold.damping * self.gain(),
        )
    }

    /// p and q of x = p η + q η′ in a pair of motions.
    pub fn hammer_by_cart(&self, hold: Hold, pair: DampedPair) -> [f64; 2] {
        let (k, c) = (self.share * hold.stiffness, self.share * hold.damping);
        follows(k, c, pair, self.spring, self.damper)
    }

    /// What sin τ drives: x and η, each by its share of sin τ and of cos τ.
    pub fn driven(&self, hold: Hold) -> [[f64; 2]; 2] {
        // (s² + G C s + G K) x − λ (κ + γ s) η = λ (1−g), −μ (K + C s) x + (s² + γ s + κ) η = g, at s = i.
        let gain = self.gain();
        let own = [gain * hold.stiffness - 1.0, gain * hold.damping];
        let back = [-self.lever * self.spring, -self.lever * self.damper];
        let on = [-self.share * hold.stiffness, -self.share * hold.damping];
        let cart = [self.spring - 1.0, self.damper];
        let pushes = [self.lever * (1.0 - self.lag), self.lag];
        let whole = minus(times(own, cart), times(back, on));
        let x = minus(times(cart, [pushes[0], 0.0]), times(back, [pushes[1], 0.0]));
        let eta = minus(times(own, [pushes[1], 0.0]), times(on, [pushes[0], 0.0]));
        [over(x, whole), over(eta, whole)]
    }
}

/// p, q of y = p z + q z′ for z″ = −a z′ − b z with z″ + own_c z′ + own_k z = k y + c y′.
fn follows(k: f64, c: f64, pair: DampedPair, own_k: f64, own_c: f64) -> [f64; 2] {
    let DampedPair { a, b } = pair;
    let (left_k, left_c) = (own_k - b, own_c - a);
    // k p − c b q = left_k, c p + (k − c a) q = left_c.
    let whole = k * (k - c * a) + c * c * b;
    [
        (left_k * (k - c * a) + left_c * c * b) / whole,
        (left_c * k - left_k * c) / whole,
    ]
}

fn times([a, b]: [f64; 2], [c, d]: [f64; 2]) -> [f64; 2] {
    [a * c - b * d, a * d + b * c]
}

fn minus([a, b]: [f64; 2], [c, d]: [f64; 2]) -> [f64; 2] {
    [a - c, b - d]
}

fn over([a, b]: [f64; 2], [c, d]: [f64; 2]) -> [f64; 2] {
    let size = c * c + d * d;
    [(a * c + b * d) / size, (b * c - a * d) / size]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(a: f64, b: f64, scale: f64) {
        assert!((a - b).abs() <= 1e-9 * scale, "{a} against {b}");
    }

    /// Every pair and the driven motion, put into the equations of both bodies.
    #[test]
    fn the_split_motions_obey_both_equations() {
        let held = shared::model::cart::ASSUMED_SHAKER;
        let flight = Hold {
            stiffness: 0.25,
            damping: 3e-3,
        };
        let contact = Hold {
            stiffness: 3.5e4,
            damping: 170.0,
        };
        for (sin, feed_forward) in [(0.0, 1.0), (0.04, 0.9)] {
            let held = shared::model::cart::LoopParams {
                feed_forward,
                ..held
            };
            let bodies = LinearBodies::new(&held, 0.0554, 23.0, sin);
            let LinearBodies {
                lever,
                spring,
                damper,
                lag,
                share,
            } = bodies;
            for hold in [flight, contact] {
                let gain = if hold.stiffness > 1.0 {
                    bodies.gain()
                } else {
                    1.0
                };
                let guess = DampedPair {
                    a: damper / gain,
                    b: spring / gain,
                };
                let (hammer, cart) = bodies.pairs(hold, guess).unwrap();
                let obey = |x: [f64; 3], q: [f64; 3], sin: f64| {
                    let held = -hold.stiffness * x[0] - hold.damping * x[1];
                    let pushed = spring * q[0] + damper * q[1];
                    let hammer = lever * ((1.0 - lag) * sin + pushed) + bodies.gain() * held;
                    let cart = lag * sin - pushed - share * held;
                    near(x[2], hammer, hold.stiffness.max(1.0));
                    near(q[2], cart, hold.stiffness.max(1.0));
                };
                for pair in [hammer, cart] {
                    let [p, q] = bodies.cart_by_hammer(hold, pair);
                    let [back_p, back_q] = bodies.hammer_by_cart(hold, pair);
                    for (z, z1) in [(1.0, 0.0), (0.3, -2.0)] {
                        let z2 = -pair.a * z1 - pair.b * z;
                        let z3 = -pair.a * z2 - pair.b * z1;
                        let other =
                            |p: f64, q: f64| [p * z + q * z1, p * z1 + q * z2, p * z2 + q * z3];
                        obey([z, z1, z2], other(p, q), 0.0);
                        obey(other(back_p, back_q), [z, z1, z2], 0.0);
                    }
                }
                let [x, q] = bodies.driven(hold);
                for tau in [0.0_f64, 0.9] {
                    let (sin, cos) = tau.sin_cos();
                    let wave = |[s, c]: [f64; 2]| {
                        let here = s * sin + c * cos;
                        [here, s * cos - c * sin, -here]
                    };
                    obey(wave(x), wave(q), sin);
                }
            }
        }
    }
}
