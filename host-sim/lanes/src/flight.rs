//! Flight of the hammers in all lanes: one Taylor step. Where in it the surface is met: [`super::meet`].

use super::number::Num;
use super::series::sin_cos;
use super::width::LaneWidth;

/// Order of the Taylor step.
pub const ORDER: usize = 12;

/// Coefficients of x over the fraction s of the step.
pub type FlightPath<W> = [Num<W>; ORDER + 1];

/// What flight needs of the cells, per lane.
#[derive(Clone, Copy)]
pub struct FlightLanes<W: LaneWidth> {
    /// The surface from rest: wires θ_gap/σ, beams G.
    pub rest: Num<W>,
    /// Wires: σ². Beams: k3.
    pub bend: Num<W>,
    /// Wires: β. Beams: k1. With a cart that recoils, the slow part's k.
    pub spring: Num<W>,
    /// Beams: d. Wires: 0. With a cart that recoils, the slow part's d.
    pub damping: Num<W>,
    /// The reciprocal of the step (0 for a lane at rest).
    pub per_step: Num<W>,
    /// With a cart that recoils: what sin τ and cos τ drive. Without, sin τ alone drives.
    pub push: Option<[Num<W>; 2]>,
}

/// Where the hammers are.
#[derive(Clone, Copy)]
pub struct HammerLanes<W: LaneWidth> {
    /// Coordinate x; with a cart that recoils, that of the slow part.
    pub x: Num<W>,
    /// Rate x′ of that coordinate.
    pub v: Num<W>,
    /// Drive phase since the last strobe, rad.
    pub tau: Num<W>,
}

/// (k+1)-th and following weights 1/((k+1)(k+2)).
const fn weight(k: usize) -> f64 {
    1.0 / ((k + 1) * (k + 2)) as f64
}

/// Coefficient `k` of the product of two series: Σ a_j b_{k−j}.
#[inline(always)]
fn convolve<W: LaneWidth>(a: &FlightPath<W>, b: &FlightPath<W>, k: usize) -> Num<W> {
    // The middle first: the newest coefficients, at both ends, are the last to be ready.
    let middle = k.div_ceil(2);
    let mut sum = a[middle] * b[k - middle];
    for d in 1..=middle {
        if middle + d <= k {
            sum = a[middle + d].mul_add(b[k - middle - d], sum);
        }
        sum = a[middle - d].mul_add(b[k + d - middle], sum);
    }
    sum
}

/// Coefficient `k` of a series' square: Σ a_j a_{k−j}.
#[inline(always)]
fn itself<W: LaneWidth>(a: &FlightPath<W>, k: usize) -> Num<W> {
    if k == 0 {
        return a[0] * a[0];
    }
    let half = k.div_ceil(2);
    let mut sum = a[half - 1] * a[k + 1 - half];
    for j in (0..half - 1).rev() {
        sum = a[j].mul_add(a[k - j], sum);
    }
    sum = sum + sum;
    if k.is_multiple_of(2) {
        sum = a[k / 2].mul_add(a[k / 2], sum);
    }
    sum
}

/// Taylor coefficients of the flight from `at` over a step `h`, for either equation of motion.
#[inline(always)]
pub fn path<W: LaneWidth>(
    beams: bool,
    f: &FlightLanes<W>,
    at: &HammerLanes<W>,
    h: Num<W>,
) -> FlightPath<W> {
    let (sin, cos) = sin_cos(at.tau);
    let h2 = h * h;
    let zero = h.of(0.0);
    let mut drive = [zero; ORDER + 1];
    let (now, rate) = match f.push {
        None => (sin, cos),
        Some([s, c]) => (s.mul_add(sin, c * cos), c.mul_sub_from(sin, s * cos)),
    };
    drive[0] = now;
    drive[1] = h * rate;
    for k in 2..ORDER - 1 {
        drive[k] = -(drive[k - 2] * h2 * weight(k - 2));
    }
    let mut x = [zero; ORDER + 1];
    x[0] = at.x;
    x[1] = h * at.v;
    if beams {
        on_beams(f, h2, &drive, &mut x);
    } else {
        on_wires(f, h2, &drive, &mut x);
    }
    x
}

/// sin θ and cos θ as polynomials of y = θ/σ to its fifth and fourth power: 2e-7 of a right angle off at 0.3 rad.
#[inline(always)]
#[allow(unused_assignments, reason = "the last order's are not needed")]
fn on_wires<W: LaneWidth>(
    f: &FlightLanes<W>,
    h2: Num<W>,
    drive: &FlightPath<W>,
    x: &mut FlightPath<W>,
) {
    let zero = h2.of(0.0);
    let one = h2.of(1.0);
    let mut y = *x;
    y[0] = x[0] + f.rest;
    let (mut square, mut fourth) = ([zero; ORDER + 1], [zero; ORDER + 1]);
    // sin θ/σ = y U, cos θ = W.
    let (mut u, mut w) = ([zero; ORDER + 1], [zero; ORDER + 1]);
    let bend2 = f.bend * f.bend;
    let (u1, u2) = (f.bend * (-1.0 / 6.0), bend2 * (1.0 / 120.0));
    let (w1, w2) = (f.bend * -0.5, bend2 * (1.0 / 24.0));
    let lost = f.damping * f.per_step;
    macro_rules! next {
        ($($k:literal)*) => { $(
            square[$k] = itself(&y, $k);
            u[$k] = u1 * square[$k];
            w[$k] = w1 * square[$k];
            if $k < FOURTHS {
                fourth[$k] = itself(&square, $k);
                u[$k] = u2.mul_add(fourth[$k], u[$k]);
                w[$k] = w2.mul_add(fourth[$k], w[$k]);
            }
            if $k == 0 {
                u[0] = u[0] + one;
                w[0] = w[0] + one;
            }
            let push = convolve(&w, drive, $k);
            let mut pull = f.spring.mul_sub_from(convolve(&u, &y, $k), push);
            if f.push.is_some() {
                pull = pull - lost * x[$k + 1] * ($k + 1) as f64;
            }
            x[$k + 2] = h2 * weight($k) * pull;
            y[$k + 2] = x[$k + 2];
        )* };
    }
    next!(0 1 2 3 4 5 6 7 8 9 10);
}

/// Orders of θ⁴ that matter.
const FOURTHS: usize = 9;

#[inline(always)]
#[allow(unused_assignments, reason = "the last order's are not needed")]
fn on_beams<W: LaneWidth>(
    f: &FlightLanes<W>,
    h2: Num<W>,
    drive: &FlightPath<W>,
    x: &mut FlightPath<W>,
) {
    let mut y = *x;
    y[0] = x[0] + f.rest;
    let mut square = [h2.of(0.0); ORDER + 1];
    let lost = f.damping * f.per_step;
    macro_rules! next {
        ($($k:literal)*) => { $(
            square[$k] = itself(&y, $k);
            let cube = convolve(&square, &y, $k);
            let spring = f.spring.mul_add(y[$k], f.bend * cube);
            let damper = lost * x[$k + 1] * ($k + 1) as f64;
            x[$k + 2] = h2 * weight($k) * (drive[$k] - spring - damper);
            y[$k + 2] = x[$k + 2];
        )* };
    }
    next!(0 1 2 3 4 5 6 7 8 9 10);
}
