//! The smooth flow of one phase of the contact: hammer, cart and bit by their rates, compression of the ground in closed
//! form, because it relaxes and slips by itself whatever the hammer does.

use shared::model::bit::Bit;
use shared::model::slider::{Slider, Touch};

use super::body::{Body, BodyAccelerations, BodyPlace};
use super::exits::Exit;
use crate::flow::dormand_prince::combined;
use crate::flow::{Flow, FlowStep, Scalar};

/// State of body, cart, bit and ground at an instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DrillPoint<R> {
    /// Since drive phase 0, s.
    pub t: R,
    /// Coordinate q of the body, measured from the nominal place of the front.
    pub q: R,
    /// Rate of the body's coordinate, in its unit per s.
    pub v: R,
    /// Compression of the ground's top, m.
    pub e: R,
    /// How far the front is beyond its nominal place, m.
    pub lead: R,
    /// Deviation of the cart from its course (m) and its rate (m/s): 0 where it keeps to it.
    pub cart: [R; 2],
    /// The bit's depth beyond the nominal place of the front (m) and its rate (m/s): 0 without a bit.
    pub bit: [R; 2],
    /// How deep that puts the body.
    pub at: BodyPlace<R>,
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
    /// Impulse of the contact force on the body, ∫F dt, N·s.
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

/// Body, cart, bit and ground in one phase of the contact.
#[derive(Clone, Copy, Debug)]
pub struct DrillFlow<'a, R> {
    /// The body that strikes.
    pub body: &'a Body<R>,
    /// The ground, which gives way.
    pub slider: &'a Slider<R>,
    /// The bit between body and ground, if there is one.
    pub bit: Option<&'a Bit<R>>,
    /// Phase of the contact with the ground: the body's, or the bit's.
    pub touch: Touch,
    /// Whether body and bit touch.
    pub struck: bool,
    /// Angular frequency Ω of the drive, rad/s.
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
    pub motion: BodyAccelerations<R>,
    /// Acceleration of the bit, m/s²: 0 without one.
    pub bit: R,
}

/// A step of hammer and ground.
pub type DrillStep<R> = FlowStep<R, DrillPoint<R>, Energies>;

impl<R: Scalar> DrillFlow<'_, R> {
    /// The speed into the ground of what stands on it, m/s.
    #[inline]
    pub fn speed(&self, p: &DrillPoint<R>) -> R {
        let rate = if self.bit.is_some() {
            p.bit[1]
        } else {
            p.at.rate
        };
        rate + R::from_f64(self.feed)
    }

    /// The depth of what stands on the ground beyond the nominal place of the front, m.
    #[inline]
    pub fn depth(&self, p: &DrillPoint<R>) -> R {
        if self.bit.is_some() {
            p.bit[0]
        } else {
            p.at.depth
        }
    }

    /// How much deeper the body is than the bit, m, and how much faster, m/s.
    #[inline]
    pub fn into_bit(&self, p: &DrillPoint<R>) -> [R; 2] {
        [p.at.depth - p.bit[0], p.at.rate - p.bit[1]]
    }

    /// Forces and accelerations at a point.
    #[inline]
    pub fn acting(&self, p: &DrillPoint<R>) -> Acting<R> {
        let ground = self.slider.force(self.touch, p.e, self.speed(p));
        let angle = p.t * R::from_f64(self.omega);
        let motion = |forces| self.body.motion(&p.at, p.v, angle, forces, p.cart);
        let Some(bit) = self.bit else {
            return Acting {
                force: ground,
                ground,
                motion: motion([ground, R::ZERO]),
                bit: R::ZERO,
            };
        };
        let force = if self.struck {
            let [x, rate] = self.into_bit(p);
            bit.force(x, rate)
        } else {
            R::ZERO
        };
        let pressed = bit.pressed(force, ground);
        let motion = motion([force, pressed]);
        Acting {
            force,
            ground,
            motion,
            bit: bit.acceleration(pressed, motion.carried),
        }
    }

    fn powers(&self, p: &DrillPoint<R>, now: &Acting<R>) -> Energies {
        let angle = p.t * R::from_f64(self.omega);
        let (force, motion) = (now.force, &now.motion);
        let body = self.body.powers(&p.at, p.v, angle, force, p.cart, motion);
        let speed = self.speed(p);
        let mut bit = [0.0; 3];
        if let Some(of) = self.bit {
            let [_, w] = p.bit;
            let heat = of.dashpot_power(p.at.rate - w);
            bit = [
                (force * w).to_f64(),
                ((of.feed_force + of.mass * motion.carried) * w).to_f64(),
                if self.struck { heat.to_f64() } else { 0.0 },
            ];
        }
        Energies {
            ground: (now.ground * speed).to_f64(),
            dashpot: self.slider.dashpot_power(self.touch, p.e, speed).to_f64(),
            impulse: force.to_f64(),
            bit: bit[0],
            bit_drive: bit[1],
            bit_heat: bit[2],
            ..body
        }
    }

    /// Progress in a step, m, and energies, J: what has a closed form are the progress and the dashpot's heat while e goes its
    /// own way: with x the distance from its limit, c ẋ = −k x and so ∫c ẋ² dt = ½ k (x0² − x1²).
    pub fn gained(&self, from: &DrillPoint<R>, step: &DrillStep<R>) -> (R, Energies) {
        let dug = match self.touch {
            Touch::Slipping => step.end.lead - from.lead + step.length * R::from_f64(self.feed),
            _ => R::ZERO,
        };
        let mut energies = step.totals;
        energies.progress = self.slider.threshold.to_f64() * dug.to_f64();
        if let Some(limit) = self.slider.compression_limit(self.touch) {
            let stored = |p: &DrillPoint<R>| self.slider.stored_energy(p.e - limit).to_f64();
            energies.dashpot = stored(from) - stored(&step.end);
        }
        (dug, energies)
    }
}

impl<R: Scalar> Flow<6> for DrillFlow<'_, R> {
    type Number = R;
    type Point = DrillPoint<R>;
    type Totals = Energies;
    type Exit = Exit;

    #[inline]
    fn time(&self, point: &DrillPoint<R>) -> R {
        point.t
    }

    #[inline]
    fn numbers(&self, p: &DrillPoint<R>) -> States<R> {
        let ([off, off_rate], [depth, depth_rate]) = (p.cart, p.bit);
        [p.q, p.v, off, off_rate, depth, depth_rate]
    }

    #[inline]
    fn moving(&self) -> usize {
        match (self.bit, self.body.recoils()) {
            (Some(_), _) => 6,
            (None, true) => 4,
            (None, false) => 2,
        }
    }

    #[inline]
    fn after(&self, from: &DrillPoint<R>, tau: R, numbers: States<R>) -> DrillPoint<R> {
        let [q, v, off, off_rate, depth, depth_rate] = numbers;
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
        DrillPoint {
            t: from.t + tau,
            q,
            v,
            e,
            lead,
            cart: [off, off_rate],
            bit: [depth, depth_rate],
            at,
        }
    }

    #[inline]
    fn rates(&self, p: &DrillPoint<R>, rates: &mut States<R>, weight: f64, totals: &mut Energies) {
        let now = self.acting(p);
        if weight != 0.0 {
            totals.add(&self.powers(p, &now), weight);
        }
        let motion = &now.motion;
        *rates = [
            p.v,
            motion.acceleration,
            p.cart[1],
            motion.deviation,
            p.bit[1],
            now.bit,
        ];
    }

    #[inline]
    fn error(&self, fifth: &States<f64>, third: &States<f64>, h: f64) -> f64 {
        let size = |errors: &States<f64>| {
            let over = errors.iter().zip(self.units).take(self.moving());
            let square = over.fold(0.0, |sum, (error, unit)| sum + (error / unit).powi(2));
            square.sqrt() * h.abs()
        };
        combined(size(fifth), size(third))
    }

    fn exit(&self, from: &DrillPoint<R>, _: f64, end: &DrillPoint<R>) -> Option<(Exit, R)> {
        self.first_exit(from, end)
    }
}
