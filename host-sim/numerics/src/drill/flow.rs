//! The smooth flow of one phase of the contact: hammer by Dormand–Prince 8(5,3), compression of the ground in closed
//! form, because it relaxes and slips by itself whatever the hammer does.

use shared::model::bit::Bit;
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
    /// The bit's depth beyond the nominal place of the front (m) and its rate (m/s): 0 without a bit.
    pub bit: [R; 2],
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
    /// From hammer into bit.
    pub bit: f64,
    /// From static feed force and inertia into the bit.
    pub bit_drive: f64,
    /// Turned to heat between hammer and bit.
    pub bit_heat: f64,
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
        self.bit += weight * other.bit;
        self.bit_drive += weight * other.bit_drive;
        self.bit_heat += weight * other.bit_heat;
    }
}

/// What the flow is under.
#[derive(Clone, Copy, Debug)]
pub struct Field<'a, R> {
    /// What strikes.
    pub body: &'a Body<R>,
    /// The ground.
    pub slider: &'a Slider<R>,
    /// The bit between body and ground, if there is one.
    pub bit: Option<&'a Bit<R>>,
    /// Phase of the contact with the ground: the body's, or the bit's.
    pub touch: Touch,
    /// Whether body and bit touch.
    pub struck: bool,
    /// Ω, rad/s.
    pub omega: f64,
    /// Speed at which the rig is fed towards the ground, m/s.
    pub feed: f64,
    /// Errors of [`States`] are weighed by these.
    pub units: States<f64>,
}

/// Coordinate, rate, the cart's deviation and its rate, the bit's depth and its rate.
pub type States<R> = [R; 6];

/// What acts at a point.
#[derive(Clone, Copy, Debug)]
pub struct Acting<R> {
    /// Contact force on the body, N.
    pub force: R,
    /// Force on the ground, N: the same without a bit.
    pub ground: R,
    /// Accelerations of body and cart.
    pub motion: Motion<R>,
    /// Acceleration of the bit, m/s²: 0 without one.
    pub bit: R,
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
    /// The speed into the ground of what stands on it, m/s.
    #[inline]
    pub fn speed(&self, p: &Point<R>, at: &Place<R>) -> R {
        let rate = if self.bit.is_some() {
            p.bit[1]
        } else {
            at.rate
        };
        rate + R::from_f64(self.feed)
    }

    /// The depth of what stands on the ground beyond the nominal place of the front, m.
    #[inline]
    pub fn depth(&self, p: &Point<R>, at: &Place<R>) -> R {
        if self.bit.is_some() {
            p.bit[0]
        } else {
            at.depth
        }
    }

    /// The state after `tau`, with everything that moves at `moved`.
    pub fn after(&self, from: &Point<R>, tau: R, moved: States<R>) -> (Point<R>, Place<R>) {
        let [q, v, off, off_rate, depth, depth_rate] = moved;
        let at = self.body.place(q, v);
        let fed = from.lead - tau * R::from_f64(self.feed);
        let deep = if self.bit.is_some() { depth } else { at.depth };
        let (e, lead) = match self.slider.compression_limit(self.touch) {
            None => (deep - fed, fed),
            Some(limit) => {
                let e = limit + (from.e - limit) * (-(self.slider.relaxation() * tau)).exp();
                match self.touch {
                    Touch::Slipping => (e, deep - e),
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
            bit: [depth, depth_rate],
        };
        (end, at)
    }

    /// Forces and accelerations.
    #[inline]
    pub fn acting(&self, p: &Point<R>, at: &Place<R>) -> Acting<R> {
        let ground = self.slider.force(self.touch, p.e, self.speed(p, at));
        let angle = p.t * R::from_f64(self.omega);
        let Some(bit) = self.bit else {
            return Acting {
                force: ground,
                ground,
                motion: self.body.motion(at, p.v, angle, [ground, R::ZERO], p.cart),
                bit: R::ZERO,
            };
        };
        let force = if self.struck {
            bit.force(at.depth - p.bit[0], at.rate - p.bit[1])
        } else {
            R::ZERO
        };
        let pressed = bit.pressed(force, ground);
        let motion = self.body.motion(at, p.v, angle, [force, pressed], p.cart);
        Acting {
            force,
            ground,
            motion,
            bit: bit.acceleration(pressed, motion.carried),
        }
    }

    /// One step of length `h`.
    pub fn step(&self, from: &Point<R>, h: R) -> Step<R> {
        let mut rates = [[R::ZERO; 6]; STAGES];
        let mut energies = Energies::default();
        let length = h.to_f64();
        let count = self.moving();
        for stage in 0..STAGES {
            let moved = moved(from, h, &rates, A[stage], count);
            let tau = h * R::from_f64(C[stage]);
            let (p, at) = self.after(from, tau, moved);
            let now = self.acting(&p, &at);
            let motion = &now.motion;
            rates[stage] = [
                p.v,
                motion.acceleration,
                p.cart[1],
                motion.deviation,
                p.bit[1],
                now.bit,
            ];
            if let Some((_, weight)) = B.iter().find(|(i, _)| *i == stage) {
                energies.add(&self.powers(&p, &at, &now), weight * length);
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

    /// How many of [`States`] move: a cart that keeps to its course and a bit that is not there cost nothing.
    fn moving(&self) -> usize {
        match (self.bit, self.body.recoils()) {
            (Some(_), _) => 6,
            (None, true) => 4,
            (None, false) => 2,
        }
    }

    fn powers(&self, p: &Point<R>, at: &Place<R>, now: &Acting<R>) -> Energies {
        let angle = p.t * R::from_f64(self.omega);
        let (force, motion) = (now.force, &now.motion);
        let body = self.body.powers(at, p.v, angle, force, p.cart, motion);
        let speed = self.speed(p, at);
        let mut bit = [0.0; 3];
        if let Some(of) = self.bit {
            let [_, w] = p.bit;
            let heat = of.dashpot_power(at.rate - w);
            bit = [
                (force * w).to_f64(),
                ((of.feed_force + of.mass * motion.carried) * w).to_f64(),
                if self.struck { heat.to_f64() } else { 0.0 },
            ];
        }
        Energies {
            drive: body.drive,
            damping: body.damping,
            contact: body.contact,
            ground: (now.ground * speed).to_f64(),
            dashpot: self.slider.dashpot_power(self.touch, p.e, speed).to_f64(),
            progress: 0.0,
            impulse: force.to_f64(),
            shaker: body.shaker,
            bit: bit[0],
            bit_drive: bit[1],
            bit_heat: bit[2],
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

/// [`States`] after `h` at the weighted rates; the first `count` move.
#[inline]
fn moved<R: Scalar>(
    from: &Point<R>,
    h: R,
    rates: &[States<R>; STAGES],
    weights: &[(usize, f64)],
    count: usize,
) -> States<R> {
    let ([off, off_rate], [depth, depth_rate]) = (from.cart, from.bit);
    let mut end = [from.q, from.v, off, off_rate, depth, depth_rate];
    for (j, x) in end[..count].iter_mut().enumerate() {
        let mut sum = R::ZERO;
        for &(i, weight) in weights {
            sum += rates[i][j] * R::from_f64(weight);
        }
        *x += h * sum;
    }
    end
}
