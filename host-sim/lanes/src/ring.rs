//! The ring of a recoiling cart in flight, in all lanes: short steps while it lasts.

use super::cart::Ringing;
use super::flight::{FlightLanes, FlightPath, HammerLanes, ORDER, path};
use super::job::Tuning;
use super::number::Num;
use super::width::LaneWidth;

/// Steps by the height of the ring: the highest, in cart amplitudes, that a step of so many radians of the ring follows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reach([(f64, f64); HEIGHTS.len()]);

/// Heights of the ring that [`Reach`] has a step for, in cart amplitudes, falling.
const HEIGHTS: [f64; 10] = [1.0, 0.1, 3e-2, 1e-2, 3e-3, 1e-3, 3e-4, 1e-4, 3e-5, 1e-5];

impl Reach {
    /// The steps after which the Taylor series of order 12 leaves `error`, in cart amplitudes.
    pub fn new(error: f64) -> Self {
        let longest = |height: f64| {
            // height φ¹³/13! = error.
            libm::pow(error / height * 6_227_020_800.0, 1.0 / 13.0)
        };
        Self(HEIGHTS.map(|height| (height, longest(height))))
    }
}

/// A step of a flight in which the cart may ring.
pub struct Flown<W: LaneWidth> {
    /// The hammer's path over the step, the ring in it.
    pub path: FlightPath<W>,
    /// Length of the step, drive phase.
    pub h: Num<W>,
    /// Reciprocal of the step; 0 for a lane at rest.
    pub per_step: Num<W>,
    /// The ring's path over the step.
    pub ring: FlightPath<W>,
}

/// That step from `at` and `ring`, at most `full` long.
#[inline(always)]
pub fn flight_with_ring<W: LaneWidth>(
    beams: bool,
    ringing: &Ringing<Num<W>>,
    mut field: FlightLanes<W>,
    mut at: HammerLanes<W>,
    full: Num<W>,
    ring: [Num<W>; 2],
    tuning: &Tuning,
) -> Flown<W> {
    field.spring = ringing.spring;
    field.damping = ringing.damping;
    field.push = Some([ringing.drive_sin, ringing.drive_cos]);
    let rung = rung(
        ringing,
        ring,
        (full, field.per_step),
        &tuning.reach,
        tuning.dead,
    );
    field.per_step = rung.per_step;
    at.x = at.x + rung.folded;
    let mut whole = path(beams, &field, &at, rung.h);
    let ring = ring_path(ringing, rung.ring, rung.h);
    for (c, z) in whole.iter_mut().zip(&ring) {
        *c = *c + *z;
    }
    Flown {
        path: whole,
        h: rung.h,
        per_step: rung.per_step,
        ring,
    }
}

/// The ring now, and the step that its height allows.
#[derive(Clone, Copy)]
struct Rung<W: LaneWidth> {
    /// z and z′; both 0 once the ring has died out.
    ring: [Num<W>; 2],
    /// Length of the step, drive phase.
    h: Num<W>,
    /// Its reciprocal (0 for a lane at rest).
    per_step: Num<W>,
    /// What of z is left to the slow part, as the ring has died out.
    folded: Num<W>,
}

/// A step of at most `full` (its reciprocal `per_full`): shorter while the ring `z`, `w` is higher than `dead`.
#[inline(always)]
fn rung<W: LaneWidth>(
    r: &Ringing<Num<W>>,
    [z, w]: [Num<W>; 2],
    (full, per_full): (Num<W>, Num<W>),
    reach: &Reach,
    dead: f64,
) -> Rung<W> {
    let zero = z.of(0.0);
    let swing = w * r.short;
    let square = z.mul_add(z, swing * swing);
    let over = square.lt(zero.of(dead * dead));
    let mut phase = zero.of(reach.0[0].1 * 0.7);
    for (height, longest) in reach.0 {
        let lower = square.lt(zero.of(height * height));
        phase = lower.choose(zero.of(longest), phase);
    }
    let short = phase * r.short;
    let rings = !over & short.lt(full);
    Rung {
        ring: [over.choose(zero, z), over.choose(zero, w)],
        h: rings.choose(short, full),
        per_step: rings.choose(zero.of(1.0) / short, per_full),
        folded: over.choose(z, zero),
    }
}

/// Taylor coefficients of the ring over a step `h`.
#[inline(always)]
fn ring_path<W: LaneWidth>(r: &Ringing<Num<W>>, [z, w]: [Num<W>; 2], h: Num<W>) -> FlightPath<W> {
    let mut c = [z; ORDER + 1];
    c[1] = h * w;
    let loss = -(r.a * h);
    let pull = -(r.b * h * h);
    for k in 0..ORDER - 1 {
        let first = loss * (1.0 / (k + 2) as f64);
        let second = pull * (1.0 / ((k + 1) * (k + 2)) as f64);
        c[k + 2] = first.mul_add(c[k + 1], second * c[k]);
    }
    c
}
