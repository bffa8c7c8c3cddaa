//! The smooth flow of one phase of the contact: hammer by Dormand–Prince 8(5,3), compression of the ground in closed
//! form, because it relaxes and slips by itself whatever the hammer does.

use shared::model::slider::{Slider, Touch};

use super::body::{Body, Motion, Place};
use crate::reference::Scalar;
use crate::reference::tableau::{A, B, C, E3, E5, STAGES, error};

/// Where everything is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point<R> {
    /// Since drive phase 0, s.
    pub t: R,
    /// The body's coordinate.
    pub q: R,
    /// Its rate.
    pub v: R,
    /// Compression of the ground's top, m.
    pub e: R,
    /// How far the front is beyond its nominal place, m.
    pub lead: R,
    /// Deviation of the cart from its course (m) and its rate (m/s): 0 where it keeps to it.
    pub cart: [R; 2],
}

/// Where energy went, J.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Energies {
    /// From the drive into the body.
    pub drive: f64,
    /// Taken by the support's damping.
    pub damping: f64,
    /// Taken from the body by the contact, as its equation of motion has it.
    pub contact: f64,
    /// Put into the ground: contact force times speed.
    pub ground: f64,
    /// Turned to heat by the ground's dashpot.
    pub dashpot: f64,
    /// Spent on progress: threshold times advance.
    pub progress: f64,
    /// ∫F dt, N·s.
    pub impulse: f64,
    /// From the shaker into a cart that recoils.
    pub shaker: f64,
}

impl Energies {
    /// Adds `weight` times `other`.
    pub fn add(&mut self, other: &Self, weight: f64) {
        self.drive += weight * other.drive;
        self.damping += weight * other.damping;
        self.contact += weight * other.contact;
        self.ground += weight * other.ground;
        self.dashpot += weight * other.dashpot;
        self.progress += weight * other.progress;
        self.impulse += weight * other.impulse;
        self.shaker += weight * other.shaker;
    }
}

/// What the flow is under.
#[derive(Clone, Copy, Debug)]
pub struct Field<'a, R> {
    /// What strikes.
    pub body: &'a Body<R>,
    /// The ground.
    pub slider: &'a Slider<R>,
    /// Phase of the contact.
    pub touch: Touch,
    /// Ω, rad/s.
    pub omega: f64,
    /// Speed at which the rig is fed towards the ground, m/s.
    pub feed: f64,
    /// Errors of coordinate, rate, and the cart's deviation and its rate are weighed by these.
    pub units: [f64; 4],
}

/// A step taken.
#[derive(Clone, Copy, Debug)]
pub struct Step<R> {
    /// Where it ended.
    pub end: Point<R>,
    /// Error estimate relative to the tolerance (≤ 1: accept).
    pub error: f64,
    /// Progress, m.
    pub dug: R,
    /// Energies.
    pub energies: Energies,
}

impl<R: Scalar> Field<'_, R> {
    /// The hammer's speed into the ground, m/s.
    #[inline]
    pub fn speed(&self, at: &Place<R>) -> R {
        at.rate + R::from_f64(self.feed)
    }

    /// The state after `tau`, with the body and its cart at `moved`: coordinate, rate, deviation and its rate.
    pub fn after(&self, from: &Point<R>, tau: R, moved: [R; 4]) -> (Point<R>, Place<R>) {
        let [q, v, off, off_rate] = moved;
        let at = self.body.place(q, v);
        let fed = from.lead - tau * R::from_f64(self.feed);
        let (e, lead) = match self.slider.compression_limit(self.touch) {
            None => (at.depth - fed, fed),
            Some(limit) => {
                let e = limit + (from.e - limit) * (-(self.slider.relaxation() * tau)).exp();
                match self.touch {
                    Touch::Slipping => (e, at.depth - e),
                    _ => (e, fed),
                }
            }
        };
        let end = Point {
            t: from.t + tau,
            q,
            v,
            e,
            lead,
            cart: [off, off_rate],
        };
        (end, at)
    }

    /// Contact force and accelerations.
    #[inline]
    pub fn motion(&self, p: &Point<R>, at: &Place<R>) -> (R, Motion<R>) {
        let force = self.slider.force(self.touch, p.e, self.speed(at));
        let angle = p.t * R::from_f64(self.omega);
        (force, self.body.motion(at, p.v, angle, force, p.cart))
    }

    /// One step of length `h`.
    pub fn step(&self, from: &Point<R>, h: R) -> Step<R> {
        let mut rates = [[R::ZERO; 4]; STAGES];
        let mut energies = Energies::default();
        let length = h.to_f64();
        // A cart that keeps to its course costs nothing.
        let count = if self.body.recoils() { 4 } else { 2 };
        for stage in 0..STAGES {
            let moved = moved(from, h, &rates, A[stage], count);
            let tau = h * R::from_f64(C[stage]);
            let (p, at) = self.after(from, tau, moved);
            let (force, motion) = self.motion(&p, &at);
            rates[stage] = [p.v, motion.acceleration, p.cart[1], motion.deviation];
            if let Some((_, weight)) = B.iter().find(|(i, _)| *i == stage) {
                energies.add(&self.powers(&p, &at, force, &motion), weight * length);
            }
        }
        let (end, _) = self.after(from, h, moved(from, h, &rates, B, count));
        let dug = match self.touch {
            Touch::Slipping => end.lead - from.lead + h * R::from_f64(self.feed),
            _ => R::ZERO,
        };
        self.exactly(from, &end, dug.to_f64(), &mut energies);
        let estimate = |weights: &[(usize, f64)]| {
            let mut square = 0.0;
            for (j, unit) in self.units[..count].iter().enumerate() {
                let errors = weights.iter().map(|&(i, w)| w * rates[i][j].to_f64());
                square += (errors.sum::<f64>() / unit).powi(2);
            }
            square.sqrt() * length.abs()
        };
        Step {
            end,
            error: error(estimate(E5), estimate(E3)),
            dug,
            energies,
        }
    }

    fn powers(&self, p: &Point<R>, at: &Place<R>, force: R, motion: &Motion<R>) -> Energies {
        let angle = p.t * R::from_f64(self.omega);
        let body = self.body.powers(at, p.v, angle, force, p.cart, motion);
        let speed = self.speed(at);
        Energies {
            drive: body.drive,
            damping: body.damping,
            contact: body.contact,
            ground: (force * speed).to_f64(),
            dashpot: self.slider.dashpot_power(self.touch, p.e, speed).to_f64(),
            progress: 0.0,
            impulse: force.to_f64(),
            shaker: body.shaker,
        }
    }

    /// What has a closed form: the progress, and the dashpot's heat while e goes its own way: with x the distance from its
    /// limit, c ẋ = −k x and so ∫c ẋ² dt = ½ k (x0² − x1²).
    fn exactly(&self, from: &Point<R>, end: &Point<R>, dug: f64, energies: &mut Energies) {
        energies.progress = self.slider.threshold.to_f64() * dug;
        if let Some(limit) = self.slider.compression_limit(self.touch) {
            let stored = |p: &Point<R>| self.slider.stored_energy(p.e - limit).to_f64();
            energies.dashpot = stored(from) - stored(end);
        }
    }
}

/// Coordinate, rate, and the cart's deviation and its rate, after `h` at the weighted rates; the first `count` move.
#[inline]
fn moved<R: Scalar>(
    from: &Point<R>,
    h: R,
    rates: &[[R; 4]; STAGES],
    weights: &[(usize, f64)],
    count: usize,
) -> [R; 4] {
    let mut end = [from.q, from.v, from.cart[0], from.cart[1]];
    for (j, x) in end[..count].iter_mut().enumerate() {
        let mut sum = R::ZERO;
        for &(i, weight) in weights {
            sum += rates[i][j] * R::from_f64(weight);
        }
        *x += h * sum;
    }
    end
}
