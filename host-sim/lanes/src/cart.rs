//! A cart that recoils, in the lanes: its motion split into what decays and what goes slowly with hammer and drive.
//!
//! In flight the motion is the sum of two. The slow part obeys an equation like that of a prescribed cart's hammer, with a
//! spring, damping and drive that are a little different; the cart goes with it as the linear system says
//! ([`super::linear`]). The *ring* is the cart's own motion on its loop, which a contact starts and the loop's damper
//! ends: z″ = −a z′ − b z in closed form, on wires linear about the angle of the surface. The hammer's coordinate is
//! x = slow + z.
//!
//! In contact the roles are the same: the hammer on the surface rings, hammer and cart on the loop go slowly.

use core::ops::{Add, Mul, Sub};

use shared::model::cart::LoopParams;

use super::linear::{DampedPair, Hold, LinearBodies};

macro_rules! quantities {
    ($(#[$meta:meta])* $name:ident: $($(#[$of:meta])* $field:ident)*) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, Default, PartialEq)]
        pub struct $name<T> {
            $($(#[$of])* pub $field: T,)*
        }

        impl<T> $name<T> {
            /// Every quantity through `f`.
            #[inline(always)]
            pub fn map<U>(&self, f: impl Fn(&T) -> U) -> $name<U> {
                $name { $($field: f(&self.$field),)* }
            }

            /// Every quantity put where it belongs.
            pub fn put(&mut self, from: &$name<f64>, f: impl Fn(&mut T, f64)) {
                $(f(&mut self.$field, from.$field);)*
            }
        }
    };
}

quantities! {
    /// What a flight needs: the slow part's drive, spring and damping, and the ring.
    Ringing:
    /// sin τ's share in what drives the slow part.
    drive_sin
    /// cos τ's share in what drives the slow part.
    drive_cos
    /// a of the ring z″ = −a z′ − b z.
    a
    /// b of the ring z″ = −a z′ − b z.
    b
    /// 1/√b: drive phase per radian of the ring.
    short
    /// k of the slow part y″ = drive − k y − d y′, nearly the support's.
    spring
    /// d of the slow part y″ = drive − k y − d y′.
    damping
}

quantities! {
    /// What a contact needs, and both ends of a flight. `q` stands for a deviation of the cart, `v` for its rate.
    Joint:
    /// Cart of a slow flight: η and η′ by the hammer's distance from rest.
    q_by_x
    v_by_x
    /// Cart of a slow flight: η and η′ by the hammer's rate.
    q_by_v
    v_by_v
    /// Cart of a slow flight: η and η′ by sin τ.
    q_by_sin
    v_by_sin
    /// Cart of a slow flight: η and η′ by cos τ.
    q_by_cos
    v_by_cos
    /// Cart of a ring: η and η′ by z.
    q_by_ring
    v_by_ring
    /// Cart of a ring: η and η′ by z′.
    q_by_ring_v
    v_by_ring_v
    /// z of the ring: by what the slow flight does not have of the cart's η and η′.
    ring_by_q
    ring_by_v
    /// z′ of the ring: by what the slow flight does not have of the cart's η and η′.
    ring_v_by_q
    ring_v_by_v
    /// The cart as the drive forces it in contact.
    forced_sin
    forced_cos
    /// η of the slow pair in contact: by what x, x′, η and η′ have beyond the forced motion.
    slow_q_by_x
    slow_q_by_v
    slow_q_by_q
    slow_q_by_w
    /// η′ of the slow pair in contact: by what x, x′, η and η′ have beyond the forced motion.
    slow_v_by_x
    slow_v_by_v
    slow_v_by_q
    slow_v_by_w
    /// a and b of the slow pair in contact.
    slow_a
    slow_b
    /// The hammer in the slow pair: x by η and η′.
    x_by_slow
    x_by_slow_v
    /// The cart in the pair that rings: η and η′ by z and z′.
    q_by_touch
    q_by_touch_v
    v_by_touch
    v_by_touch_v
    /// x″ in flight beside the surface: by sin τ, η, η′ and the support.
    push_sin
    push_q
    push_v
    push_hold
    /// η″ in flight beside the surface: by sin τ and, with a minus, by η, η′ and the support.
    recoil_sin
    recoil_q
    recoil_v
    recoil_hold
}

/// A number, or one per lane.
pub trait LaneValue: Copy + Add<Output = Self> + Mul<Output = Self> + Sub<Output = Self> {}
impl<T: Copy + Add<Output = T> + Mul<Output = T> + Sub<Output = T>> LaneValue for T {}

impl<T: LaneValue> Joint<T> {
    /// The cart of a flight: the hammer's slow part `y` from rest, its rate `v`, the ring and its rate.
    #[inline(always)]
    pub fn cart(&self, [y, v]: [T; 2], [z, w]: [T; 2], (sin, cos): (T, T)) -> [T; 2] {
        let slow = self.slow([y, v], (sin, cos));
        [
            slow[0] + self.q_by_ring * z + self.q_by_ring_v * w,
            slow[1] + self.v_by_ring * z + self.v_by_ring_v * w,
        ]
    }

    #[inline(always)]
    fn slow(&self, [y, v]: [T; 2], (sin, cos): (T, T)) -> [T; 2] {
        [
            self.q_by_x * y + self.q_by_v * v + self.q_by_sin * sin + self.q_by_cos * cos,
            self.v_by_x * y + self.v_by_v * v + self.v_by_sin * sin + self.v_by_cos * cos,
        ]
    }

    /// The ring and its rate in a flight of a hammer `y` from rest with rate `v` whose cart is at `cart`.
    #[inline(always)]
    pub fn ring(&self, whole: [T; 2], cart: [T; 2], phase: (T, T)) -> [T; 2] {
        let slow = self.slow(whole, phase);
        let (q, v) = (cart[0] - slow[0], cart[1] - slow[1]);
        [
            self.ring_by_q * q + self.ring_by_v * v,
            self.ring_v_by_q * q + self.ring_v_by_v * v,
        ]
    }

    /// η and its first three derivatives, x″ and x‴ in flight beside the surface, with `hold` = pull − d x′.
    #[inline(always)]
    pub fn beside(&self, cart: [T; 2], hold: T, (sin, cos): (T, T)) -> Beside<T> {
        let [q, v] = cart;
        let q2 =
            self.recoil_sin * sin - self.recoil_q * q - self.recoil_v * v - self.recoil_hold * hold;
        let q3 = self.recoil_sin * cos - self.recoil_q * v - self.recoil_v * q2;
        Beside {
            x2: self.push_sin * sin + self.push_q * q + self.push_v * v + self.push_hold * hold,
            x3: self.push_sin * cos + self.push_q * v + self.push_v * q2,
            cart: [q, v, q2, q3],
        }
    }
}

/// A moment of a flight beside the surface.
#[derive(Clone, Copy)]
pub struct Beside<T> {
    /// Acceleration x″ of the hammer.
    pub x2: T,
    /// Third derivative x‴ of the hammer's coordinate.
    pub x3: T,
    /// η and its first three derivatives.
    pub cart: [T; 4],
}

impl Beside<f64> {
    /// The cart and its rate `t` later.
    pub fn cart_after(&self, t: f64) -> [f64; 2] {
        let [q, v, q2, q3] = self.cart;
        [
            q + t * (v + t * (0.5 * q2 + t * q3 / 6.0)),
            v + t * (q2 + 0.5 * t * q3),
        ]
    }
}

/// A recoiling cart in a cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Recoil {
    /// Constants of a flight.
    pub ringing: Ringing<f64>,
    /// Constants of a contact, and of both ends of a flight.
    pub joint: Joint<f64>,
    /// The pair that rings in contact.
    pub touch: DampedPair,
    /// What the drive forces of x in contact, by sin τ and cos τ.
    pub forced: [f64; 2],
}

/// A support and a surface, for [`Recoil::new`].
pub struct Around {
    /// Mass of the hammer over that of the cart.
    pub mass_ratio: f64,
    /// Sine of the wires' angle at the surface; 0 on beams.
    pub sin: f64,
    /// Whether it is the wires' angle that moves.
    pub wires: bool,
    /// The support about rest.
    pub rest: Hold,
    /// The support at the surface.
    pub beside: Hold,
    /// Support and surface together.
    pub touch: Hold,
}

/// On wires: the loop's square over the faster of drive's and hammer's, at least. With less, what is left out (products of
/// the ring and the wires' bend) counts.
const STIFFEST_WIRES: f64 = 9.0;

/// In contact: the slow pair's phase over a contact, at most, for which its third order is enough.
const LONGEST_SLOW: f64 = 0.8;

impl Recoil {
    /// The ring in a flight of a hammer at `y` (from rest), with its rate, in a cart at `cart`, at drive phase `tau`.
    pub fn ring(&self, y: [f64; 2], cart: [f64; 2], tau: f64) -> [f64; 2] {
        self.joint.ring(y, cart, libm::sincos(tau))
    }

    /// The constants of a cell driven at `omega`; none where loop, hammer and surface are not well apart.
    pub fn new(held: &LoopParams, omega: f64, around: &Around) -> Option<Self> {
        let still = LinearBodies::new(held, around.mass_ratio, omega, 0.0);
        let there = LinearBodies::new(held, around.mass_ratio, omega, around.sin);
        let apart = |own: f64, other: f64| !(0.5..2.0).contains(&(own / other));
        let Around {
            rest,
            beside,
            touch,
            ..
        } = *around;
        if around.wires && still.spring < STIFFEST_WIRES * rest.stiffness.max(1.0) {
            return None;
        }
        if !apart(still.spring, rest.stiffness) {
            return None;
        }
        let alone = DampedPair {
            a: still.damper,
            b: still.spring,
        };
        let (hammer, _) = still.pairs(rest, alone)?;
        let (_, ring) = there.pairs(beside, alone)?;
        let gain = there.gain();
        let joined = DampedPair {
            a: there.damper / gain,
            b: there.spring / gain,
        };
        let (bounce, slow) = there.pairs(touch, joined)?;
        ring.oscillation()?;
        let (decay, pulsation) = bounce.oscillation()?;
        let (slow_decay, slow_pulsation) = slow.oscillation()?;
        let lasts = core::f64::consts::PI / pulsation;
        let sound = slow.b.sqrt() * lasts < LONGEST_SLOW
            && slow_decay < decay
            && slow_pulsation < pulsation;
        if !sound {
            return None;
        }
        let mut joint = Joint::default();
        let [drive_sin, drive_cos] = in_flight(&mut joint, &still, rest, hammer);
        let weights = ring.weights(there.cart_by_hammer(beside, ring));
        ringing(&mut joint, weights);
        let forced = in_contact(&mut joint, &there, touch, bounce, slow);
        joint.push_sin = there.lever * (1.0 - there.lag);
        joint.push_q = there.lever * there.spring;
        joint.push_v = there.lever * there.damper;
        joint.push_hold = gain;
        joint.recoil_sin = there.lag;
        joint.recoil_q = there.spring;
        joint.recoil_v = there.damper;
        joint.recoil_hold = there.share;
        Some(Self {
            ringing: Ringing {
                drive_sin,
                drive_cos,
                a: ring.a,
                b: ring.b,
                short: 1.0 / ring.b.sqrt(),
                spring: hammer.b,
                damping: hammer.a,
            },
            joint,
            touch: bounce,
            forced,
        })
    }
}

/// The slow flight: the cart by the hammer, and what drives the hammer.
fn in_flight(
    j: &mut Joint<f64>,
    bodies: &LinearBodies,
    rest: Hold,
    hammer: DampedPair,
) -> [f64; 2] {
    let [[sin, cos], [cart_sin, cart_cos]] = bodies.driven(rest);
    let [[qx, qv], [vx, vv]] = hammer.weights(bodies.cart_by_hammer(rest, hammer));
    (j.q_by_x, j.q_by_v, j.v_by_x, j.v_by_v) = (qx, qv, vx, vv);
    j.q_by_sin = cart_sin - qx * sin + qv * cos;
    j.q_by_cos = cart_cos - qx * cos - qv * sin;
    j.v_by_sin = -cart_cos - vx * sin + vv * cos;
    j.v_by_cos = cart_sin - vx * cos - vv * sin;
    let DampedPair { a, b } = hammer;
    [(b - 1.0) * sin - a * cos, (b - 1.0) * cos + a * sin]
}

/// The ring: the cart by it (`weights`), and it by the cart.
fn ringing(j: &mut Joint<f64>, weights: [[f64; 2]; 2]) {
    let [[qz, qw], [vz, vw]] = weights;
    (j.q_by_ring, j.q_by_ring_v, j.v_by_ring, j.v_by_ring_v) = (qz, qw, vz, vw);
    // What the ring takes of x and x′ is no longer the slow flight's.
    let (qz, qw) = (qz - j.q_by_x, qw - j.q_by_v);
    let (vz, vw) = (vz - j.v_by_x, vw - j.v_by_v);
    let whole = qz * vw - qw * vz;
    (j.ring_by_q, j.ring_by_v) = (vw / whole, -qw / whole);
    (j.ring_v_by_q, j.ring_v_by_v) = (-vz / whole, qz / whole);
}

/// The contact: both pairs. Returns what the drive forces of x.
fn in_contact(
    j: &mut Joint<f64>,
    bodies: &LinearBodies,
    touch: Hold,
    bounce: DampedPair,
    slow: DampedPair,
) -> [f64; 2] {
    let [forced, [cart_sin, cart_cos]] = bodies.driven(touch);
    (j.forced_sin, j.forced_cos) = (cart_sin, cart_cos);
    let on = bounce.weights(bodies.cart_by_hammer(touch, bounce));
    let [[qz, qw], [vz, vw]] = on;
    (j.q_by_touch, j.q_by_touch_v, j.v_by_touch, j.v_by_touch_v) = (qz, qw, vz, vw);
    let back = slow.weights(bodies.hammer_by_cart(touch, slow));
    [j.x_by_slow, j.x_by_slow_v] = back[0];
    (j.slow_a, j.slow_b) = (slow.a, slow.b);
    // (1 − on back) u = cart − on hammer.
    let product = |r: usize, c: usize| on[r][0] * back[0][c] + on[r][1] * back[1][c];
    let (m00, m01) = (1.0 - product(0, 0), -product(0, 1));
    let (m10, m11) = (-product(1, 0), 1.0 - product(1, 1));
    let whole = m00 * m11 - m01 * m10;
    let inverse = [[m11 / whole, -m01 / whole], [-m10 / whole, m00 / whole]];
    let by_hammer = |r: usize, c: usize| -(inverse[r][0] * on[0][c] + inverse[r][1] * on[1][c]);
    (j.slow_q_by_x, j.slow_q_by_v) = (by_hammer(0, 0), by_hammer(0, 1));
    (j.slow_v_by_x, j.slow_v_by_v) = (by_hammer(1, 0), by_hammer(1, 1));
    (j.slow_q_by_q, j.slow_q_by_w) = (inverse[0][0], inverse[0][1]);
    (j.slow_v_by_q, j.slow_v_by_w) = (inverse[1][0], inverse[1][1]);
    forced
}
