//! Where in a step the switch falls.
//!
//! A step is first searched on the quintic through its ends (value, rate and acceleration there), at
//! interior points and at every extremum of the indicator, so that a crossing and return inside one step
//! is found; what the quintic suspects is then decided, and located, by steps of the integrator itself.

use shared::model::rig::SwitchMode;

use super::flow::{FlowPoint, HammerFlow};
use super::series::Series;
use crate::flow::{Scalar, reached};
use crate::root::{halved, maximum};

/// Interior points per step at which the indicator is computed.
const SAMPLES: usize = 8;

/// An extremum this close below the surface is decided by the integrator, m.
const GRAZING_MARGIN_M: f64 = 2e-10;

/// Newton's iteration stops when it moves by less than this, s.
const TIME_TOLERANCE_S: f64 = 1e-13;

/// The quintic through both ends of a step.
#[derive(Clone, Copy, Debug)]
pub struct Arc {
    /// Length of the step, s.
    pub length: f64,
    coefficients: [f64; 6],
}

impl Arc {
    /// From (coordinate, rate, acceleration) at both ends, `length` s apart.
    pub fn new(length: f64, start: (f64, f64, f64), end: (f64, f64, f64)) -> Self {
        let (q0, v0, a0) = (start.0, start.1 * length, start.2 * length * length);
        let (v1, a1) = (end.1 * length, end.2 * length * length);
        let rise = end.0 - q0 - v0 - 0.5 * a0;
        let slope = v1 - v0 - a0;
        let bend = a1 - a0;
        Self {
            length,
            coefficients: [
                q0,
                v0,
                0.5 * a0,
                10.0 * rise - 4.0 * slope + 0.5 * bend,
                -15.0 * rise + 7.0 * slope - bend,
                6.0 * rise - 3.0 * slope + 0.5 * bend,
            ],
        }
    }

    /// Coordinate and rate at the fraction `s` of the step.
    pub fn at(&self, s: f64) -> (f64, f64) {
        let c = &self.coefficients;
        let q = c.iter().rev().fold(0.0, |sum, c| sum * s + c);
        let powers = (1..6).rev().fold(0.0, |sum, k| sum * s + k as f64 * c[k]);
        (q, powers / self.length)
    }
}

/// The time after `from` (s) at which the mode's side of the switch is left, if it is within the step of
/// length `h` that ended at `end`.
pub fn locate(
    flow: &HammerFlow<f64>,
    from: &FlowPoint<f64>,
    h: f64,
    end: &FlowPoint<f64>,
) -> Option<f64> {
    let of = |p: &FlowPoint<f64>| {
        let at = flow.rig.kinematics(p.q, p.v);
        (at.delta, at.rate)
    };
    if flow.mode == SwitchMode::Flight && out_of_reach(of(from), h, of(end)) {
        return None;
    }
    let (a0, _) = flow.acceleration(from);
    let (a1, _) = flow.acceleration(end);
    let arc = Arc::new(h, (from.q, from.v, a0), (end.q, end.v, a1));
    let exact = |s: f64| reached(flow, from, s * h);
    let about = |s: f64| {
        let (q, v) = arc.at(s);
        let at = flow.rig.kinematics(q, v);
        (at.delta, at.rate)
    };
    searched(flow, (from, end), h, 40, about, exact)
}

/// [`locate`] in a piece of a motion that is known as a series, from `after` s after its start on.
pub fn locate_in(
    flow: &HammerFlow<f64>,
    series: &Series<f64>,
    (from, end): (&FlowPoint<f64>, &FlowPoint<f64>),
    (after, h): (f64, f64),
) -> Option<f64> {
    let about = |s: f64| series.penetration(after + s * h);
    let exact = |s: f64| series.point(after + s * h);
    searched(flow, (from, end), h, 6, about, exact)
}

/// When the side of the switch is left, s after the start of a piece of `h` s from `from` to `end`: searched on penetration
/// and its rate at a share of its length (`about`), decided and located where the motion really is (`exact`). The bracket is
/// halved on the former `halvings` times before Newton's iteration begins.
fn searched(
    flow: &HammerFlow<f64>,
    (from, end): (&FlowPoint<f64>, &FlowPoint<f64>),
    h: f64,
    halvings: u32,
    about: impl Fn(f64) -> (f64, f64),
    exact: impl Fn(f64) -> FlowPoint<f64>,
) -> Option<f64> {
    // Positive: the mode's side is left.
    let sign = match flow.mode {
        SwitchMode::Flight => 1.0,
        SwitchMode::Contact => -1.0,
    };
    let guess = |s: f64| {
        let (delta, rate) = about(s);
        let law = flow.rig.law();
        sign * law.indicator(delta, rate, flow.approach_at(rate))
    };
    let at = |j: usize| j as f64 / SAMPLES as f64;
    let mut values = [0.0; SAMPLES + 1];
    for (j, value) in values.iter_mut().enumerate() {
        *value = if j == SAMPLES {
            sign * flow.indicator(end)
        } else {
            guess(at(j))
        };
    }
    let mut bracket = (1..=SAMPLES)
        .find(|j| values[*j] > 0.0)
        .map(|j| (at(j - 1), at(j)));
    let before = bracket.map_or(SAMPLES, |(a, _)| (a * SAMPLES as f64).round() as usize);
    for j in 0..=before {
        let (a, b) = (j.saturating_sub(1), (j + 1).min(SAMPLES));
        // In the outermost pieces there is an extremum only if the indicator heads for it.
        let turns = match j {
            0 => sign * indicator_slope(flow, from) > 0.0,
            SAMPLES => sign * indicator_slope(flow, end) < 0.0,
            _ => true,
        };
        if turns && values[j] >= values[a] && values[j] >= values[b] {
            let margin = GRAZING_MARGIN_M * indicator_per_metre(flow);
            let top = maximum(guess, (at(a), at(b)), 1e-6, at(a));
            if guess(top) > -margin {
                let there = |s: f64| sign * flow.indicator(&exact(s));
                let top = maximum(there, (at(a), at(b)), 1e-9, at(a));
                if there(top) > 0.0 {
                    bracket = Some((at(a), top));
                    break;
                }
            }
        }
    }
    let (low, high) = bracket?;
    let (_, guessed) = halved((low, high), halvings, |s| guess(s) > 0.0);
    Some(h * root(flow, &exact, h, (low, guessed, high), sign))
}

/// The time `at` (s) that [`locate`] found: the same value; in dual numbers, with the derivatives of the instant. `reached`
/// is where the motion is after a time.
pub fn instant<R: Scalar>(flow: &HammerFlow<R>, reached: impl Fn(R) -> FlowPoint<R>, at: f64) -> R {
    let at = R::from_f64(at);
    let there = reached(at);
    let slope = indicator_slope(&flow.in_values(), &there.in_values());
    at.as_root_of(flow.indicator(&there), slope)
}

/// Whether the surface is too far away to be met in a flight of `h` s, given penetration and rate at both ends.
pub fn out_of_reach(from: (f64, f64), h: f64, end: (f64, f64)) -> bool {
    let reach = h * (from.1.abs() + end.1.abs());
    from.0.max(end.0) + reach < 0.0
}

/// What a metre of penetration adds to the indicator.
fn indicator_per_metre(flow: &HammerFlow<f64>) -> f64 {
    match flow.rig.law() {
        shared::model::contact::Law::SpringDashpot { stiffness, .. } => *stiffness,
        _ => 1.0,
    }
}

/// dI/dt along the flow, by a central difference about a point where I is nearly zero.
fn indicator_slope(flow: &HammerFlow<f64>, p: &FlowPoint<f64>) -> f64 {
    const DT: f64 = 1e-9;
    let (a, _) = flow.acceleration(p);
    let at = |dt: f64| {
        let (q, v) = (p.q + dt * (p.v + 0.5 * dt * a), p.v + dt * a);
        flow.indicator(&FlowPoint::on_course(p.t + dt, q, v))
    };
    (at(DT) - at(-DT)) / (2.0 * DT)
}

/// Where the side is left, in fractions of the piece: by Newton's iteration from `s` on, and by bisection of the bracket
/// where Newton's does not settle.
fn root(
    flow: &HammerFlow<f64>,
    exact: &impl Fn(f64) -> FlowPoint<f64>,
    h: f64,
    (low, mut s, high): (f64, f64, f64),
    sign: f64,
) -> f64 {
    for _ in 0..8 {
        let there = exact(s);
        let g = sign * flow.indicator(&there);
        let slope = sign * indicator_slope(flow, &there);
        let correction = g / slope;
        if !correction.is_finite() {
            break;
        }
        let next = s - correction / h;
        if next < low || next > high {
            break;
        }
        s = next;
        if correction.abs() < TIME_TOLERANCE_S {
            return s;
        }
    }
    let left = |s: f64| sign * flow.indicator(&exact(s)) > 0.0;
    halved((low, high), 60, left).1
}

/// The contact force and its rate at a point, N and N/s.
pub fn force_and_rate(flow: &HammerFlow<f64>, p: &FlowPoint<f64>) -> (f64, f64) {
    let (a, force) = flow.acceleration(p);
    let at = flow.rig.kinematics(p.q, p.v);
    let (by_delta, by_rate) = flow.rig.law().gradient(at.delta, at.rate, flow.approach);
    let change = flow.rig.penetration_acceleration(&at, p.v, a);
    (force, by_delta * at.rate + by_rate * change)
}

/// When and how large the force is at its largest between two times in contact, N; `force` is what it and its rate are some
/// time (s) after the first.
pub fn force_peak((t0, t1): (f64, f64), force: impl Fn(f64) -> (f64, f64)) -> (f64, f64) {
    let (f0, r0) = force(0.0);
    let (f1, r1) = force(t1 - t0);
    if !(r0 > 0.0 && r1 < 0.0) {
        return if f0 > f1 { (t0, f0) } else { (t1, f1) };
    }
    // Secant on the force's rate, kept inside the bracket where it would leave it.
    let (mut a, mut b) = ((0.0, r0), (t1 - t0, r1));
    let mut best = if f0 > f1 { (t0, f0) } else { (t1, f1) };
    for _ in 0..12 {
        let secant = a.0 - a.1 * (b.0 - a.0) / (b.1 - a.1);
        let inside = secant.clamp(a.0 + 0.01 * (b.0 - a.0), b.0 - 0.01 * (b.0 - a.0));
        let (now, rate) = force(inside);
        if now > best.1 {
            best = (t0 + inside, now);
        }
        if rate > 0.0 {
            a = (inside, rate);
        } else {
            b = (inside, rate);
        }
        if b.0 - a.0 < 1e-9 {
            break;
        }
    }
    best
}
