//! The hammer's motion as a power series of time, where its equations are analytic: in flight, and in a contact of the
//! spring-dashpot law.
//!
//! The coefficients follow from one another: those of a product from those of its factors, those of sine and cosine from
//! those of the angle (À. Jorba and M. Zou, *Experimental Mathematics* 14 (2005) 99–117). One series reaches as far as
//! some five steps of a Runge–Kutta method of order 8 at the same error, at the cost of one, and gives the motion at any
//! time within it. The tests compare both.

#[cfg(test)]
mod tests;

use shared::model::cart::CartDrive;
use shared::model::contact::Law;
use shared::model::params::{RigParams, SupportParams, Torque};
use shared::model::rig::{Rig, SwitchMode};

use super::flow::{FlowPoint, FlowTotals};
use crate::flow::Scalar;

/// Coefficients of a series. Fewer reach less far, more take longer than they reach: 18 to 23 give the answer in the same time.
const TERMS: usize = 20;

/// Errors of derivatives are kept below this many times the share of them that errors of the motion are kept below.
const OF_DERIVATIVES: f64 = 100.0;

/// What holds the hammer.
#[derive(Clone, Copy, Debug)]
enum Support {
    Wires {
        length: f64,
        gravity: f64,
        torque: Torque,
    },
    /// Stiffness, damping and cubic stiffness over the hammer's mass.
    Beams {
        stiffness: f64,
        damping: f64,
        cubic: f64,
    },
}

/// A cart that recoils: its mass (kg), stiffness (N/m) and damping (N·s/m) of its loop, the mass that is fed forward (kg).
#[derive(Clone, Copy, Debug)]
struct Loop {
    mass: f64,
    stiffness: f64,
    damping: f64,
    forward: f64,
}

/// The constants of the equations of motion.
#[derive(Clone, Copy, Debug)]
pub struct Equations {
    support: Support,
    mass: f64,
    gap: f64,
    cart: Option<Loop>,
    /// Stiffness (N/m) and damping (N·s/m) of a contact that is linear.
    contact: Option<(f64, f64)>,
    /// Ω, rad/s.
    omega: f64,
    /// A0 Ω², m/s².
    drive: f64,
}

/// The motion from a point on.
#[derive(Clone, Copy, Debug)]
pub struct Series<R> {
    origin: FlowPoint<R>,
    /// Those of the hammer's coordinate.
    q: [R; TERMS],
    /// Those of the cart's deviation from its course, m.
    off: [R; TERMS],
    /// Those of the penetration (m), of the cart's acceleration (m/s²) and of the contact force (N).
    delta: [f64; TERMS],
    cart: [f64; TERMS],
    force: [f64; TERMS],
    /// Side of the switch.
    mode: SwitchMode,
    /// Length by which the force turns the hammer, m; none where it acts along the penetration.
    lever: Option<f64>,
    /// Damping of the support, N·s/m.
    damping: f64,
    mass: f64,
}

impl Equations {
    /// Those of `params` driven at `omega` (rad/s).
    pub fn new(params: &RigParams, omega: f64) -> Self {
        let support = match params.support {
            SupportParams::Wires {
                length_m: length,
                gravity_m_per_s2: gravity,
                torque,
                ..
            } => Support::Wires {
                length,
                gravity,
                torque,
            },
            SupportParams::Beams {
                natural_frequency_hz,
                damping_ratio,
                cubic_stiffness_n_per_m3,
            } => {
                let own = std::f64::consts::TAU * natural_frequency_hz;
                let stiffness = own * own;
                Support::Beams {
                    stiffness,
                    damping: 2.0 * damping_ratio * own,
                    cubic: cubic_stiffness_n_per_m3.map_or(stiffness, |k| k / params.mass_kg),
                }
            }
        };
        let cart = match params.cart {
            CartDrive::Prescribed => None,
            CartDrive::Loop(held) => {
                let (mass, own) = (
                    params.cart_mass_kg,
                    std::f64::consts::TAU * held.frequency_hz,
                );
                Some(Loop {
                    mass,
                    stiffness: mass * own * own,
                    damping: 2.0 * held.damping_ratio * mass * own,
                    forward: held.feed_forward * mass,
                })
            }
        };
        let contact = match params.contact {
            Law::SpringDashpot { stiffness, damping } => Some((stiffness, damping)),
            _ => None,
        };
        Self {
            support,
            mass: params.mass_kg,
            gap: params.gap_m,
            cart,
            contact,
            omega,
            drive: params.amplitude_m * omega * omega,
        }
    }

    /// Whether the motion is analytic on this side of the switch.
    pub fn hold(&self, mode: SwitchMode) -> bool {
        mode == SwitchMode::Flight || self.contact.is_some()
    }

    /// The motion from `from` on, on the side `mode` of the switch.
    #[inline(never)]
    pub fn series<R: Scalar>(
        &self,
        rig: &Rig<R>,
        mode: SwitchMode,
        from: &FlowPoint<R>,
    ) -> Series<R> {
        let at = rig.kinematics(from.q, from.v);
        let (lever, wires) = match self.support {
            Support::Wires { length, .. } => (length, true),
            Support::Beams { .. } => (1.0, false),
        };
        let inverse_lever = 1.0 / lever;
        let contact = self.contact.filter(|_| mode == SwitchMode::Contact);
        let zero = [R::ZERO; TERMS];
        // Coordinate and its rate; sine and cosine of the angle, or the deflection (m), its square and 1.
        let (mut q, mut v, mut sin, mut cos) = (zero, zero, zero, zero);
        let (mut off, mut cart, mut square, mut force) = (zero, zero, zero, zero);
        let mut values = [[0.0; TERMS]; 3];
        (q[0], q[1], v[0]) = (from.q, from.v, from.v);
        sin[0] = (at.delta + R::from_f64(self.gap)).scaled(inverse_lever);
        cos[0] = at.slope.scaled(inverse_lever);
        sin[1] = cos[0] * v[0];
        [off[0], off[1]] = from.cart;
        let angle = from.t.scaled(self.omega);
        let (mut course, mut turned) = (
            angle.sin().scaled(self.drive),
            (angle + R::from_f64(std::f64::consts::FRAC_PI_2))
                .sin()
                .scaled(self.drive),
        );
        // What of a cart's and a hammer's inertia answers to a force on the cart.
        let moved = self.cart.map(|held| {
            let along = R::ONE - cos[0] * cos[0];
            R::ONE / (R::from_f64(held.mass) + along.scaled(self.mass))
        });
        for k in 0..TERMS - 2 {
            let next = (k + 1) as f64;
            let delta = if k == 0 {
                at.delta
            } else {
                sin[k].scaled(lever)
            };
            if let Some((stiffness, damping)) = contact {
                let rate = sin[k + 1].scaled(lever * next);
                force[k] = delta.scaled(stiffness) + rate.scaled(damping);
            }
            let pushed = force[k].scaled(1.0 / self.mass);
            // The coordinate's acceleration but for what the cart's has to do with it, in m/s², and what the curve of its
            // path adds to that of the penetration.
            let (still, curve) = match self.support {
                Support::Wires {
                    gravity, torque, ..
                } => {
                    let swung = convolved(&cos[1..=k], &cart[..k]);
                    let bent = convolved(&sin[1..=k], &v[..k]);
                    let along = convolved(&cos[1..=k], &v[1..=k]);
                    cos[k + 1] = -(bent + sin[0] * v[k]).scaled(1.0 / next);
                    let along = along + cos[k + 1] * v[0];
                    let pushed = match torque {
                        Torque::Literal => pushed,
                        Torque::Cosine => {
                            convolved(&cos[..=k], &force[..=k]).scaled(1.0 / self.mass)
                        }
                    };
                    (-(swung + sin[k].scaled(gravity) + pushed), along)
                }
                Support::Beams {
                    stiffness,
                    damping,
                    cubic,
                } => {
                    square[k] = convolved(&sin[..=k], &sin[..=k]);
                    let thrice = convolved(&square[..=k], &sin[..=k]);
                    let held =
                        sin[k].scaled(stiffness) + v[k].scaled(damping) + thrice.scaled(cubic);
                    (-(held + pushed), R::ZERO)
                }
            };
            cart[k] = match (self.cart, moved) {
                (Some(held), Some(moved)) => {
                    let hold = off[k].scaled(held.stiffness)
                        + off[k + 1].scaled(held.damping * next)
                        + course.scaled(held.forward);
                    let pull = cos[0] * still + curve.scaled(lever * next);
                    -(hold + pull.scaled(self.mass)) * moved
                }
                _ => -course,
            };
            let by = 1.0 / (next * (next + 1.0));
            q[k + 2] = (still - cos[0] * cart[k]).scaled(inverse_lever * by);
            v[k + 1] = q[k + 2].scaled(next + 1.0);
            sin[k + 2] = if wires {
                cos[0] * q[k + 2] + curve.scaled(1.0 / (next + 1.0))
            } else {
                q[k + 2]
            };
            off[k + 2] = (cart[k] + course).scaled(by);
            values[1][k] = cart[k].to_f64();
            values[2][k] = force[k].to_f64();
            (course, turned) = (
                turned.scaled(self.omega / next),
                -course.scaled(self.omega / next),
            );
        }
        for (value, s) in values[0].iter_mut().zip(sin) {
            *value = lever * s.to_f64();
        }
        values[0][0] = at.delta.to_f64();
        let [delta, cart, force] = values;
        let (straight, damping) = match self.support {
            Support::Wires { torque, .. } => ((torque == Torque::Literal).then_some(lever), 0.0),
            Support::Beams { damping, .. } => (None, self.mass * damping),
        };
        Series {
            origin: *from,
            q,
            off,
            delta,
            cart,
            force,
            mode,
            lever: straight,
            damping,
            mass: self.mass,
        }
    }
}

/// The last coefficient of the product of two power series, of as many each. (Sums side by side would not fit the registers.)
#[inline]
fn convolved<R: Scalar>(a: &[R], b: &[R]) -> R {
    let mut sum = R::ZERO;
    for (a, b) in a.iter().zip(b.iter().rev()) {
        sum += *a * *b;
    }
    sum
}

/// The power series of these coefficients and its derivative at `tau`.
#[inline]
fn sum<R: Scalar>(coefficients: &[R; TERMS], tau: R) -> (R, R) {
    let (mut value, mut rate) = (R::ZERO, R::ZERO);
    for c in coefficients.iter().rev() {
        rate = rate * tau + value;
        value = value * tau + *c;
    }
    (value, rate)
}

impl<R: Scalar> Series<R> {
    /// Where everything is `tau` (s) after the start.
    pub fn point(&self, tau: R) -> FlowPoint<R> {
        let ((q, v), (off, off_rate)) = (sum(&self.q, tau), sum(&self.off, tau));
        FlowPoint {
            t: self.origin.t + tau,
            q,
            v,
            cart: [off, off_rate],
        }
    }

    /// How far it may be followed, s: until its last two terms are as large as `units` (of coordinate and rate, and of the
    /// cart's), which are `tolerance` of its size, or those of a derivative as large as
    /// [`OF_DERIVATIVES`] times that share of what it is at the start. NaN where the motion
    /// cannot be followed.
    pub fn reach(&self, tolerance: f64, units: (f64, f64), cart: Option<(f64, f64)>) -> f64 {
        let cart = cart.unwrap_or(units);
        let of = |x: R, along: Option<usize>| match along {
            None => x.to_f64().abs(),
            Some(along) => x.derivatives()[along].abs(),
        };
        let place =
            |k: usize, along| (of(self.q[k], along) / units.0).max(of(self.off[k], along) / cart.0);
        let rate =
            |k: usize, along| (of(self.q[k], along) / units.1).max(of(self.off[k], along) / cart.1);
        let last = [TERMS - 2, TERMS - 1];
        let mut largest = last.map(|k| [place(k, None), rate(k, None)]);
        for along in (0..self.origin.q.derivatives().len()).map(Some) {
            let small = OF_DERIVATIVES * tolerance * place(0, along).max(rate(1, along));
            if small > 0.0 {
                for (largest, k) in largest.iter_mut().zip(last) {
                    largest[0] = largest[0].max(place(k, along) / small);
                    largest[1] = largest[1].max(rate(k, along) / small);
                }
            }
        }
        let mut reach = f64::INFINITY;
        for ([place, rate], k) in largest.into_iter().zip(last) {
            if !(self.q[k].to_f64() + self.off[k].to_f64()).is_finite() {
                return f64::NAN;
            }
            let n = k as f64;
            let (place, rate) = (place.powf(-1.0 / n), (n * rate).powf(-1.0 / (n - 1.0)));
            reach = reach.min(place).min(rate);
        }
        reach
    }

    /// Without its derivatives.
    pub fn in_values(&self) -> Series<f64> {
        Series {
            origin: self.origin.in_values(),
            q: self.q.map(R::to_f64),
            off: self.off.map(R::to_f64),
            delta: self.delta,
            cart: self.cart,
            force: self.force,
            mode: self.mode,
            lever: self.lever,
            damping: self.damping,
            mass: self.mass,
        }
    }
}

impl Series<f64> {
    /// When it starts, s after drive phase 0.
    pub fn starts(&self) -> f64 {
        self.origin.t
    }

    /// The coordinate's acceleration at `tau` (s) after the start.
    pub fn acceleration(&self, tau: f64) -> f64 {
        let term = |sum: f64, k: usize| sum * tau + (k * (k - 1)) as f64 * self.q[k];
        (2..TERMS).rev().fold(0.0, term)
    }

    /// Coordinate and rate at `tau` (s) after the start.
    pub fn at(&self, tau: f64) -> (f64, f64) {
        sum(&self.q, tau)
    }

    /// Penetration and its rate at `tau` (s) after the start.
    pub fn penetration(&self, tau: f64) -> (f64, f64) {
        sum(&self.delta, tau)
    }

    /// Contact force and its rate at `tau` (s) after the start, N and N/s.
    pub fn force(&self, tau: f64) -> (f64, f64) {
        sum(&self.force, tau)
    }

    /// Where energy and momentum went in the first `tau` s.
    pub fn totals(&self, tau: f64) -> FlowTotals {
        // ∫ t^k dt from 0 to tau.
        let mut powers = [0.0; 2 * TERMS];
        let mut power = tau;
        for (k, integral) in powers.iter_mut().enumerate() {
            *integral = power / (k + 1) as f64;
            power *= tau;
        }
        let dot = |x: &[f64; TERMS], y: &[f64; TERMS]| -> f64 {
            x.iter().zip(y).map(|(x, y)| x * y).sum()
        };
        // What ∫ x ẏ dt is for a coefficient of x, from those of y.
        let rates = |y: &[f64; TERMS]| {
            let mut sums = [0.0; TERMS];
            for k in 1..TERMS {
                let rate = k as f64 * y[k];
                for (sum, power) in sums.iter_mut().zip(&powers[k - 1..]) {
                    *sum += rate * power;
                }
            }
            sums
        };
        let by_delta = rates(&self.delta);
        let mut totals = FlowTotals {
            inertial_work: -self.mass * dot(&self.cart, &by_delta),
            ..FlowTotals::default()
        };
        if self.mode == SwitchMode::Contact {
            let mut plain = [0.0; TERMS];
            plain.copy_from_slice(&powers[..TERMS]);
            totals.impulse = dot(&self.force, &plain);
            totals.contact_work = match self.lever {
                Some(lever) => lever * dot(&self.force, &rates(&self.q)),
                None => dot(&self.force, &by_delta),
            };
        }
        if self.damping != 0.0 {
            let mut speed = [0.0; TERMS];
            for k in 1..TERMS {
                speed[k - 1] = k as f64 * self.q[k];
            }
            totals.damping_work = self.damping * dot(&speed, &rates(&self.q));
        }
        totals
    }
}
