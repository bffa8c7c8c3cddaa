//! A contact of the spring-dashpot in all lanes at once, in closed form: from the onset to where the hammer, let go by
//! the surface, passes x = 0 on its way out.
//!
//! In contact the motion is linear (to 1e-5 of the penetration): a damped oscillation plus the motion that drive and
//! support force. The oscillation is expanded about the phases at which a contact without outer force peaks and
//! releases, so that only short polynomials are left. What these cannot represent (sustained contacts, contacts during
//! which the section comes, hops that end before the hammer has left) is reported, and computed by [`super::sustained`].

use super::cart::{Beside, Joint};
use super::number::{Mask, Num};
use super::series::{horner, polynomial, sin_cos};
use super::width::LaneWidth;

/// Order of the expansions.
const ORDER: usize = 6;

/// Farthest the release may be from where it is expected, in transient phase.
const REACH: f64 = 0.7;

/// The search for the release has come to rest when its last move was shorter, in transient phase.
const AT_REST: f64 = 1e-3;

/// Longest contact, in drive phase, over which the drive is held to second order.
const LONGEST: f64 = 0.15;

/// What a contact needs of the cells, per lane.
#[derive(Clone, Copy)]
pub struct SurfaceLanes<W: LaneWidth> {
    /// Wires: cos θ at the surface, which the drive acts by there. Beams: 1.
    pub drive: Num<W>,
    /// Constant part of x″ at the surface.
    pub pull: Num<W>,
    /// The support's damping: d on beams, 0 on wires.
    pub damping: Num<W>,
    /// κc: contact force per x.
    pub spring: Num<W>,
    /// γc: contact force per x′.
    pub damper: Num<W>,
    /// μ: the transient's decay per τ.
    pub decay: Num<W>,
    /// ν: the transient's angular frequency per τ.
    pub pulsation: Num<W>,
    /// 1/ν, the reciprocal of `pulsation`.
    pub short: Num<W>,
    /// ρ = decay over pulsation.
    pub rho: Num<W>,
    /// sin τ's share in the contact's forced motion.
    pub forced_sin: Num<W>,
    /// cos τ's share in the contact's forced motion.
    pub forced_cos: Num<W>,
    /// Constant share in the contact's forced motion.
    pub forced_mean: Num<W>,
    /// Where a contact without outer force releases.
    pub release: Anchor<W>,
    /// Where its force peaks.
    pub peak: Anchor<W>,
    /// A cart that recoils.
    pub cart: Option<HeldCart<W>>,
}

/// A cart that recoils, at the onset.
#[derive(Clone, Copy)]
pub struct HeldCart<W: LaneWidth> {
    /// What the cell has of it.
    pub joint: Joint<Num<W>>,
    /// Its deviation and rate.
    pub at: [Num<W>; 2],
}

/// A phase of the transient: φ, e^(−ρφ) cos φ, e^(−ρφ) sin φ.
#[derive(Clone, Copy)]
pub struct Anchor<W: LaneWidth> {
    /// Phase φ of the transient.
    pub phase: Num<W>,
    /// e^(−ρφ) cos φ.
    pub cos: Num<W>,
    /// e^(−ρφ) sin φ.
    pub sin: Num<W>,
}

/// What a contact did.
#[derive(Clone, Copy)]
pub struct ContactResult<W: LaneWidth> {
    /// Whether the other fields are valid.
    pub good: Mask<W>,
    /// Drive phase when x = 0 is passed outbound.
    pub tau: Num<W>,
    /// Rate x′ as x = 0 is passed: negative.
    pub v: Num<W>,
    /// Largest force of the contact, in units of m A0 Ω².
    pub force: Num<W>,
    /// Where a cart that recoils is then, and its rate.
    pub cart: [Num<W>; 2],
    /// Whether the contact was so shallow that there may have been none.
    pub grazing: Mask<W>,
}

/// The transient e^(−ρφ)(a cos φ + b sin φ).
#[derive(Clone, Copy)]
struct Transient<W: LaneWidth> {
    a: Num<W>,
    b: Num<W>,
}

impl<W: LaneWidth> Transient<W> {
    /// Taylor coefficients about an anchor, in φ.
    #[inline(always)]
    fn about<const N: usize>(&self, anchor: &Anchor<W>, rho: Num<W>) -> [Num<W>; N] {
        let (a, b) = (self.a, self.b);
        let mut c = [a; N];
        c[0] = a.mul_add(anchor.cos, b * anchor.sin);
        let rise = rho.mul_sub_from(a, b);
        let fall = rho.mul_add(b, a);
        c[1] = fall.mul_sub_from(anchor.sin, rise * anchor.cos);
        let loss = rho * -2.0;
        let pull = -(rho.mul_add(rho, rho.of(1.0)));
        for k in 0..N - 2 {
            let first = loss * (1.0 / (k + 2) as f64);
            let second = pull * (1.0 / ((k + 1) * (k + 2)) as f64);
            c[k + 2] = first.mul_add(c[k + 1], second * c[k]);
        }
        c
    }
}

/// An acceleration that is none, over A0 Ω².
const STILL: f64 = 1e-12;

/// Runs a contact that begins at drive phase `tau` (0 to 2π) with rate `v` > 0. A contact less deep than
/// `grazing` is reported as such.
#[inline(always)]
pub fn contact<W: LaneWidth>(
    s: &SurfaceLanes<W>,
    tau: Num<W>,
    v: Num<W>,
    grazing: f64,
) -> ContactResult<W> {
    let one = v.of(1.0);
    let zero = v.of(0.0);
    let (sin, cos) = sin_cos(tau);
    let (short, rho) = (s.short, s.rho);
    // The forced motion and its derivatives by τ.
    let swing = s.forced_sin.mul_add(sin, s.forced_cos * cos);
    let swing1 = s.forced_cos.mul_sub_from(sin, s.forced_sin * cos);
    let mut course = [swing + s.forced_mean, swing1, -swing, -swing1];
    let mut slow = [zero; 5];
    if let Some(held) = &s.cart {
        let off = [-course[0], v - course[1]];
        let together = slow_pair(&held.joint, off, held.at, (sin, cos));
        for (all, added) in course.iter_mut().zip(together.hammer) {
            *all = *all + added;
        }
        slow = together.cart;
    }
    let [forced, forced1, forced2, forced3] = course;
    let moved = Transient {
        a: -forced,
        b: (s.decay.mul_sub_from(forced, v - forced1)) * short,
    };
    let (k, c) = (s.spring, s.damper);
    let push = Transient {
        a: k.mul_add(
            moved.a,
            c * s.decay.mul_sub_from(moved.a, s.pulsation * moved.b),
        ),
        b: k * moved.b - c * s.decay.mul_add(moved.b, s.pulsation * moved.a),
    };
    let force0 = k.mul_add(forced, c * forced1);
    let force1 = c.mul_add(forced2, k * forced1);
    let force2 = k.mul_add(forced2, c * forced3);
    let slow_force = [force0, force1, force2];
    // Release: F falls through zero.
    let mut f: [Num<W>; ORDER + 1] = push.about(&s.release, rho);
    add_slow(&mut f, &slow_force, &s.release, short);
    let mut steep = one / f[1];
    let (mut falls, mut last) = (f[1].lt(zero), one);
    let first = -(f[0] * steep);
    // The parabola's root to second order, where it bends little.
    let bend = f[2] * steep * first;
    let little = bend.abs().lt(one * 0.3);
    let mut d = little.choose(bend.mul_sub_from(first, first), first);
    d = d.max(one * -REACH).min(one * REACH);
    for _ in 0..3 {
        let (value, slope) = horner(&f, d);
        falls = slope.lt(zero);
        // 1/slope, refined without division.
        for _ in 0..2 {
            steep = steep * slope.mul_sub_from(steep, one + one);
        }
        last = value * steep;
        d = d - last;
    }
    let near = d.abs().lt(one * REACH) & last.abs().lt(one * AT_REST);
    let z: [Num<W>; ORDER + 1] = moved.about(&s.release, rho);
    let (z0, z1) = horner(&z, d);
    let t = (s.release.phase + d) * short;
    let x = z0 + taylor3(course, t);
    let turn = s.pulsation * z1;
    let rate = s.pulsation.mul_add(z1, forced1) + t * t.mul_add(forced3 * 0.5, forced2);
    // Flight from there to x = 0.
    let (push0, push1) = (s.drive * sin, s.drive * cos);
    let mut beside = None;
    if let Some(HeldCart { joint, .. }) = &s.cart {
        let cart = [
            joint.q_by_touch * z0
                + joint.q_by_touch_v * turn
                + taylor3([slow[0], slow[1], slow[2], slow[3]], t),
            joint.v_by_touch * z0
                + joint.v_by_touch_v * turn
                + taylor3([slow[1], slow[2], slow[3], slow[4]], t),
        ];
        let hold = s.damping.mul_sub_from(rate, s.pull);
        beside = Some(joint.beside(
            cart,
            hold,
            (
                taylor3([sin, cos, -sin, -cos], t),
                taylor3([cos, -sin, -cos, sin], t),
            ),
        ));
    }
    let (e, e1) = match &beside {
        None => (
            s.damping
                .mul_sub_from(rate, taylor3([push0, push1, -push0, -push1], t) + s.pull),
            push1 - t * push0,
        ),
        Some(beside) => (beside.x2, beside.x3),
    };
    let inside = rate.mul_add(rate, -(e * x * 2.0));
    let root = inside.max(one * 1e-30).sqrt();
    let sum = root - rate;
    let quotient = one / (sum * root);
    let mut out = (x + x) * (quotient * root);
    let height = x + out * (rate + out * (e * 0.5 + out * e1 * (1.0 / 6.0)));
    // Newton's slope is −root, but for the drive's own change.
    out = height.mul_add(quotient * sum, out);
    let leaving = rate + out * (e + out * e1 * 0.5);
    let whole = t + out;
    let clear = (rate * rate * 0.05).lt(inside)
        & leaving.lt(zero)
        & rate.lt(zero)
        & !(x.lt(v * short * -1e-4))
        & whole.lt(one * LONGEST);
    let (force, peaked) = peak(s, &push, (rho, short), &slow_force, s.damper * v);
    let mut cart = [zero; 2];
    if let Some(Beside { cart: then, .. }) = beside {
        let [q, v, q2, q3] = then;
        cart = [
            taylor3([q, v, q2, q3], out),
            taylor3([v, q2, q3, zero], out),
        ];
    }
    let arrival = match &s.cart {
        None => push0 + s.pull,
        Some(held) => held.joint.beside(held.at, s.pull, (sin, cos)).x2,
    };
    ContactResult {
        good: near & falls & clear & peaked & zero.lt(v),
        tau: tau + whole,
        v: leaving,
        force,
        // A top v²/(2|e|) above the surface. Of a hammer at rest on it, e is rounding.
        grazing: (v * v).lt((arrival + STILL) * (-2.0 * grazing)),
        cart,
    }
}

/// The pair in contact in which hammer and cart go together.
struct Together<W: LaneWidth> {
    /// x and its first three derivatives.
    hammer: [Num<W>; 4],
    /// The cart and its first four derivatives, its course's swing included.
    cart: [Num<W>; 5],
}

/// That pair for a hammer that is `x`, `v` off what the drive forces, in a cart at `q`, `w`.
#[inline(always)]
fn slow_pair<W: LaneWidth>(
    j: &Joint<Num<W>>,
    [x, v]: [Num<W>; 2],
    [q, w]: [Num<W>; 2],
    (sin, cos): (Num<W>, Num<W>),
) -> Together<W> {
    let course = j.forced_sin.mul_add(sin, j.forced_cos * cos);
    let course1 = j.forced_cos.mul_sub_from(sin, j.forced_sin * cos);
    let (q, w) = (q - course, w - course1);
    let u0 = j.slow_q_by_x * x + j.slow_q_by_v * v + j.slow_q_by_q * q + j.slow_q_by_w * w;
    let u1 = j.slow_v_by_x * x + j.slow_v_by_v * v + j.slow_v_by_q * q + j.slow_v_by_w * w;
    let next = |u: Num<W>, u1: Num<W>| -(j.slow_a * u1 + j.slow_b * u);
    let u2 = next(u0, u1);
    let u3 = next(u1, u2);
    let u4 = next(u2, u3);
    let x = |u: Num<W>, u1: Num<W>| j.x_by_slow * u + j.x_by_slow_v * u1;
    Together {
        hammer: [x(u0, u1), x(u1, u2), x(u2, u3), x(u3, u4)],
        cart: [
            u0 + course,
            u1 + course1,
            u2 - course,
            u3 - course1,
            u4 + course,
        ],
    }
}

/// Adds the slow force (value and two derivatives by τ at the onset) to an expansion about an anchor; `short` = 1/ν.
#[inline(always)]
fn add_slow<W: LaneWidth, const N: usize>(
    f: &mut [Num<W>; N],
    slow: &[Num<W>; 3],
    anchor: &Anchor<W>,
    short: Num<W>,
) {
    let t = anchor.phase * short;
    let slope = t.mul_add(slow[2], slow[1]);
    f[0] = f[0] + t.mul_add(t.mul_add(slow[2] * 0.5, slow[1]), slow[0]);
    f[1] = slope.mul_add(short, f[1]);
    f[2] = (slow[2] * short).mul_add(short * 0.5, f[2]);
}

/// c0 + c1 t + c2 t²/2 + c3 t³/6.
#[inline(always)]
fn taylor3<W: LaneWidth>(c: [Num<W>; 4], t: Num<W>) -> Num<W> {
    let inner = t.mul_add(c[3] * (1.0 / 6.0), c[2] * 0.5);
    t.mul_add(t.mul_add(inner, c[1]), c[0])
}

/// The largest force, and whether it was found: `at_onset` or the top of the expansion about the peak's anchor.
#[inline(always)]
fn peak<W: LaneWidth>(
    s: &SurfaceLanes<W>,
    push: &Transient<W>,
    (rho, short): (Num<W>, Num<W>),
    slow: &[Num<W>; 3],
    at_onset: Num<W>,
) -> (Num<W>, Mask<W>) {
    let zero = rho.of(0.0);
    let mut f: [Num<W>; 6] = push.about(&s.peak, rho);
    add_slow(&mut f, slow, &s.peak, short);
    let curve = f[2] + f[2];
    let mut flat = rho.of(1.0) / curve;
    let first = -(f[1] * flat);
    let slope = polynomial(&[f[1], curve, f[3] * 3.0, f[4] * 4.0, f[5] * 5.0], first);
    let bend = polynomial(&[curve, f[3] * 6.0, f[4] * 12.0, f[5] * 20.0], first);
    for _ in 0..2 {
        flat = flat * bend.mul_sub_from(flat, rho.of(2.0));
    }
    let d = slope.mul_sub_from(flat, first).max(-s.peak.phase);
    let top = polynomial(&f, d);
    let falls_from_onset = !(zero.lt(s.peak.phase)) & !(zero.lt(f[1]));
    let found = d.abs().lt(zero.of(REACH)) & f[2].lt(zero);
    let force = falls_from_onset.choose(at_onset, top.max(at_onset));
    (force, found | falls_from_onset)
}
