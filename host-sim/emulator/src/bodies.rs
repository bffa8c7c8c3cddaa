//! Two bodies: hammer m in cart M, and the smooth flow of both between switches.
//!
//! The hammer's equation is [`shared::model::rig`]'s, relative to the cart. It is affine in the cart's acceleration
//! ÿ, which enters as the inertial acceleration −ÿ: δ̈ = d0 − d1 ÿ. With the shaker's force Fs on the cart,
//! M ÿ = Fs − m (ÿ + δ̈), so ÿ = (Fs − m d0)/(M + m (1 − d1)). On a tilted rig gravity g sin α acts along the travel on
//! both: on the hammer as an inertial acceleration does.

use shared::model::rig::{Kinematics, Rig, SwitchMode};

use super::cart::Mounting;
use super::ground::PlantGround;
use super::motor::Motor;
use super::shaker::{Gains, Loop, SetPointPath};

/// Where both bodies are.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BodiesState {
    /// The hammer's coordinate relative to the cart ([`shared::model::rig`]).
    pub q: f64,
    /// Rate of `q`: rad/s on wires, m/s on beams.
    pub v: f64,
    /// Cart displacement y, m.
    pub y: f64,
    /// Cart speed ẏ, m/s.
    pub w: f64,
    /// Position of the armature (m) or angle of the crank (rad), where there is one.
    pub z: f64,
    /// Rate of `z`: speed of the armature (m/s) or of the crank (rad/s).
    pub u: f64,
    /// Bend of the friction's bristles, m.
    pub p: f64,
    /// How far the front of ground that gives way is beyond the gap, m.
    pub front: f64,
}

impl BodiesState {
    /// `weight` times `other` on top.
    #[inline]
    fn plus(&self, other: &Self, weight: f64) -> Self {
        Self {
            q: self.q + weight * other.q,
            v: self.v + weight * other.v,
            y: self.y + weight * other.y,
            w: self.w + weight * other.w,
            z: self.z + weight * other.z,
            u: self.u + weight * other.u,
            p: self.p + weight * other.p,
            front: self.front + weight * other.front,
        }
    }
}

/// Integrated beside the motion: where energy and momentum went.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PlantTotals {
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
    /// Energy that friction, end stops and the armature's joint took, J.
    pub cart_work: f64,
}

impl PlantTotals {
    /// `weight` times `other` on top.
    #[inline]
    pub fn add(&mut self, other: &Self, weight: f64) {
        self.impulse += weight * other.impulse;
        self.contact_work += weight * other.contact_work;
        self.shaker_impulse += weight * other.shaker_impulse;
        self.shaker_work += weight * other.shaker_work;
        self.damping_work += weight * other.damping_work;
        self.cart_work += weight * other.cart_work;
    }
}

/// What both bodies are under during a tick.
#[derive(Clone, Copy, Debug)]
pub struct PlantBodies {
    /// The hammer's equation of motion, relative to the cart.
    pub rig: Rig<f64>,
    /// Mass M of the cart without the hammer, kg.
    pub cart_mass_kg: f64,
    /// How the cart is moved.
    pub shaker: Loop,
    /// How it is mounted.
    pub mounting: Mounting,
    /// Ground that gives way, in place of the rig's contact.
    pub ground: Option<PlantGround>,
    /// Gravity along the cart's travel, m/s²: of a rig that is tilted.
    pub along: f64,
    /// Speed that the motor is to have, rad/s.
    pub wanted_rad_s: f64,
    /// The set-point over the tick.
    pub path: SetPointPath,
    /// Whether the drive is enabled.
    pub on: bool,
    /// Side of the switch.
    pub mode: SwitchMode,
    /// δ̇⁻ of the contact, m/s.
    pub approach: f64,
}

/// Rates at a point, and what acts there.
#[derive(Clone, Copy, Debug, Default)]
pub struct PlantRates {
    /// Rate of the state.
    pub state: BodiesState,
    /// Contact force on the hammer, N; 0 in flight.
    pub force: f64,
    /// Rates of the totals.
    pub powers: PlantTotals,
}

impl PlantBodies {
    /// Position of the hammer relative to the surface.
    #[inline]
    pub fn kinematics(&self, state: &BodiesState) -> Kinematics<f64> {
        self.rig.kinematics(state.q, state.v)
    }

    /// Rates at `state`, `s` seconds into the tick.
    #[inline]
    pub fn rates(&self, state: &BodiesState, s: f64) -> PlantRates {
        let (rig, v) = (&self.rig, state.v);
        let at = self.kinematics(state);
        let force = match self.mode {
            SwitchMode::Flight => 0.0,
            SwitchMode::Contact => self.contact_force(&at, state),
        };
        let m = rig.mass();
        // The hammer relative to the cart as a function of the cart's acceleration.
        let still = rig.acceleration(&at, v, self.along, force);
        let still_surface = rig.penetration_acceleration(&at, v, still);
        let per_drive = rig.acceleration(&at, v, self.along + 1.0, force) - still;
        let surface_per_drive = at.slope * per_drive;
        let hammer = Hammer {
            pull: m * still_surface - (self.cart_mass_kg + m) * self.along,
            moved: self.cart_mass_kg + m * (1.0 - surface_per_drive),
        };
        let want = self.path.at(s);
        let cart = match &self.shaker {
            Loop::Force(gains) => self.pushed(gains, state, want, &hammer),
            Loop::Prescribed => self.prescribed(state, want.2, &hammer),
            Loop::Crank(motor) => self.cranked(motor, state, &hammer),
        };
        PlantRates {
            state: BodiesState {
                q: v,
                v: still - per_drive * cart.acceleration,
                y: cart.speed,
                w: cart.acceleration,
                z: state.u,
                u: cart.inner_acceleration,
                p: cart.bend_rate,
                front: self.ground.map_or(0.0, |g| g.front_rate(&at, state.front)),
            },
            force,
            powers: PlantTotals {
                impulse: force,
                contact_work: rig.contact_power(&at, v, force),
                shaker_impulse: cart.drive_n,
                shaker_work: cart.drive_w,
                damping_work: rig.damping_power(v),
                cart_work: cart.lost_w,
            },
        }
    }

    /// The force of the contact, N, negative where its law would pull.
    #[inline]
    pub fn contact_force(&self, at: &Kinematics<f64>, state: &BodiesState) -> f64 {
        match &self.ground {
            None => self.rig.force(at, self.approach),
            Some(ground) => ground.force(at, state.front),
        }
    }

    /// What the mounting does to a cart at a position and a speed: force (N), rate of the bristles (m/s), power lost (W).
    #[inline]
    fn mounted(&self, position: f64, speed: f64, bend_m: f64) -> (f64, f64, f64) {
        let (mut force, mut bend_rate, mut lost) = (0.0, 0.0, 0.0);
        if let Some(friction) = &self.mounting.friction {
            let (against, rate, taken) = friction.at(bend_m, speed);
            force -= against;
            bend_rate = rate;
            lost += taken;
        }
        if let Some(stops) = &self.mounting.stops {
            let (pushed, taken) = stops.at(position, speed);
            force += pushed;
            lost += taken;
        }
        (force, bend_rate, lost)
    }

    /// The cart under a shaker.
    #[inline]
    fn pushed(
        &self,
        gains: &Gains,
        state: &BodiesState,
        want: (f64, f64, f64),
        hammer: &Hammer,
    ) -> Cart {
        let (mounted_n, bend_rate, mut lost_w) = self.mounted(state.y, state.w, state.p);
        let (drive_n, drive_speed, on_cart, inner_acceleration) = match &gains.armature {
            None => {
                let force = gains.force(self.on, want, state.y, state.w);
                (force, state.w, force, 0.0)
            }
            Some(armature) => {
                let force = gains.force(self.on, want, state.z, state.u);
                let closing = state.u - state.w;
                let damper = armature.damping * closing;
                let joint = armature.stiffness * (state.z - state.y) + damper;
                lost_w += damper * closing;
                let inner = (force - joint) / armature.mass_kg + self.along;
                (force, state.u, joint, inner)
            }
        };
        Cart {
            speed: state.w,
            acceleration: (on_cart + mounted_n - hammer.pull) / hammer.moved,
            inner_acceleration,
            bend_rate,
            drive_n,
            drive_w: drive_n * drive_speed,
            lost_w,
        }
    }

    /// The cart on its prescribed course.
    #[inline]
    fn prescribed(&self, state: &BodiesState, acceleration: f64, hammer: &Hammer) -> Cart {
        let drive_n = hammer.moved * acceleration + hammer.pull;
        Cart {
            speed: state.w,
            acceleration,
            drive_n,
            drive_w: drive_n * state.w,
            ..Cart::default()
        }
    }

    /// The cart on its crank.
    #[inline]
    fn cranked(&self, motor: &Motor, state: &BodiesState, hammer: &Hammer) -> Cart {
        let (position, slope, bend) = motor.crank(state.z);
        let speed = slope * state.u;
        let (mounted_n, bend_rate, lost_w) = self.mounted(position, speed, state.p);
        let torque = motor.torque(self.on, self.wanted_rad_s, state.u);
        // The rod's force is what cart and hammer need: moved (y′ φ̈ + y″ φ̇²) + pull − mounted.
        let turning = bend * state.u * state.u;
        let held_back = hammer.moved * turning + hammer.pull - mounted_n;
        let inertia = motor.inertia + hammer.moved * slope * slope;
        let inner_acceleration = (torque - slope * held_back) / inertia;
        let acceleration = slope * inner_acceleration + turning;
        Cart {
            speed,
            acceleration,
            inner_acceleration,
            bend_rate,
            drive_n: hammer.moved * acceleration + hammer.pull - mounted_n,
            drive_w: torque * state.u,
            lost_w,
        }
    }

    /// Runge and Kutta's fourth-order step of length `h` from `s` seconds into the tick; adds to `totals`.
    #[inline]
    pub fn step(
        &self,
        from: &BodiesState,
        s: f64,
        h: f64,
        totals: &mut PlantTotals,
    ) -> BodiesState {
        let half = 0.5 * h;
        let a = self.rates(from, s);
        let b = self.rates(&from.plus(&a.state, half), s + half);
        let c = self.rates(&from.plus(&b.state, half), s + half);
        let d = self.rates(&from.plus(&c.state, h), s + h);
        let (outer, inner) = (h / 6.0, h / 3.0);
        totals.add(&a.powers, outer);
        totals.add(&b.powers, inner);
        totals.add(&c.powers, inner);
        totals.add(&d.powers, outer);
        let sum = |f: fn(&BodiesState) -> f64| {
            f(from) + outer * (f(&a.state) + f(&d.state)) + inner * (f(&b.state) + f(&c.state))
        };
        let mut state = BodiesState {
            q: sum(|x| x.q),
            v: sum(|x| x.v),
            y: sum(|x| x.y),
            w: sum(|x| x.w),
            z: sum(|x| x.z),
            u: sum(|x| x.u),
            p: sum(|x| x.p),
            front: sum(|x| x.front),
        };
        if let Loop::Crank(motor) = &self.shaker {
            let (position, slope, _) = motor.crank(state.z);
            state.y = position;
            state.w = slope * state.u;
        }
        state
    }

    /// > 0 in contact, < 0 in flight; what the switch is located by.
    pub fn indicator(&self, state: &BodiesState) -> f64 {
        let at = self.kinematics(state);
        if let Some(ground) = &self.ground {
            return ground.indicator(self.mode, &at, state.front);
        }
        match self.mode {
            SwitchMode::Flight => self.rig.indicator(&at, at.rate.max(0.0)),
            SwitchMode::Contact => {
                let law = self.rig.law();
                law.release_indicator(at.delta, at.rate, self.approach)
            }
        }
    }

    /// Contact force at `state` and its rate of change, N and N/s.
    pub fn force_and_rate(&self, state: &BodiesState, s: f64) -> (f64, f64) {
        let at = self.kinematics(state);
        let rates = self.rates(state, s);
        let change = self
            .rig
            .penetration_acceleration(&at, state.v, rates.state.v);
        if let Some(ground) = &self.ground {
            return (rates.force, ground.force_rate(at.rate, change));
        }
        let law = self.rig.law();
        let (by_delta, by_rate) = law.gradient(at.delta, at.rate, self.approach);
        (rates.force, by_delta * at.rate + by_rate * change)
    }

    /// Mechanical energy of both bodies, the support, armature or crank and mounting, fixed frame, without the
    /// surface's, J.
    pub fn energy_j(&self, state: &BodiesState) -> f64 {
        let at = self.kinematics(state);
        let (m, w) = (self.rig.mass(), state.w);
        let both = self.cart_mass_kg + m;
        let relative = self.rig.energy(&at, state.v);
        let mut energy = relative + m * w * at.rate + 0.5 * both * w * w;
        energy -= self.along * (both * state.y + m * at.delta);
        match &self.shaker {
            Loop::Force(gains) => {
                if let Some(armature) = &gains.armature {
                    let stretch = state.z - state.y;
                    energy += 0.5 * armature.mass_kg * state.u * state.u;
                    energy += 0.5 * armature.stiffness * stretch * stretch;
                    energy -= self.along * armature.mass_kg * state.z;
                }
            }
            Loop::Crank(motor) => energy += 0.5 * motor.inertia * state.u * state.u,
            Loop::Prescribed => {}
        }
        let Mounting {
            friction, stops, ..
        } = &self.mounting;
        energy += friction.map_or(0.0, |f| f.energy_j(state.p));
        energy + stops.map_or(0.0, |s| s.energy_j(state.y))
    }
}

/// How the hammer loads the cart: the force that moves the cart is `moved` ÿ + `pull`.
struct Hammer {
    pull: f64,
    moved: f64,
}

/// The cart and what drives it, at a point.
#[derive(Clone, Copy, Debug, Default)]
struct Cart {
    speed: f64,
    acceleration: f64,
    /// Of the armature or the crank.
    inner_acceleration: f64,
    bend_rate: f64,
    /// Force of the drive, N, and its power, W.
    drive_n: f64,
    drive_w: f64,
    lost_w: f64,
}
