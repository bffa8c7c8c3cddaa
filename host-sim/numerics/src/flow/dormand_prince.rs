//! One step of Dormand and Prince's method of order 8 with error estimates of orders 5 and 3.

use shared::Real as _;

use super::tableau::{A, B, C, E3, E5, STAGES, WEIGHTS};
use super::{Flow, Scalar};

pub use super::tableau::{combined, length, next, shorter};

/// A step taken from a point of type `P`, with what was integrated beside it.
#[derive(Clone, Copy, Debug)]
pub struct FlowStep<R, P, T> {
    /// Point at which the step ended.
    pub end: P,
    /// Length of the step, s.
    pub length: R,
    /// Error estimate relative to the tolerance (≤ 1: accept).
    pub error: f64,
    /// What was integrated beside the motion.
    pub totals: T,
}

/// The rates of `N` numbers at the stages of a step.
pub type StageRates<R, const N: usize> = [[R; N]; STAGES];

/// A step of `F`.
pub type StepOf<F, const N: usize> =
    FlowStep<<F as Flow<N>>::Number, <F as Flow<N>>::Point, <F as Flow<N>>::Totals>;

/// One step of length `h` (s) of `flow` from `from`, whatever its error.
pub fn step<F: Flow<N>, const N: usize>(flow: &F, from: &F::Point, h: F::Number) -> StepOf<F, N> {
    stepped(flow, from, h, h.to_f64())
}

/// Where such a step ends, by itself.
pub fn reached<F: Flow<N>, const N: usize>(flow: &F, from: &F::Point, h: F::Number) -> F::Point {
    stepped(flow, from, h, 0.0).end
}

/// A step whose powers count for `span` s each. How many numbers move is made one that the compiler knows, so that it
/// unrolls the loops over them.
fn stepped<F: Flow<N>, const N: usize>(
    flow: &F,
    from: &F::Point,
    h: F::Number,
    span: f64,
) -> StepOf<F, N> {
    match flow.moving() {
        2 => step_of::<F, N, 2>(flow, from, h, span),
        4 => step_of::<F, N, 4>(flow, from, h, span),
        _ => step_of::<F, N, N>(flow, from, h, span),
    }
}

/// [`stepped`] with the first `M` of the `N` numbers moving.
#[inline(never)]
fn step_of<F: Flow<N>, const N: usize, const M: usize>(
    flow: &F,
    from: &F::Point,
    h: F::Number,
    span: f64,
) -> StepOf<F, N> {
    let start = flow.numbers(from);
    let mut rates = [[F::Number::ZERO; N]; STAGES];
    let mut totals = F::Totals::default();
    for stage in 0..STAGES {
        let numbers = moved::<_, N, M>(&start, h, &rates, A[stage]);
        let at = flow.after(from, h.scaled(C[stage]), numbers);
        flow.rates(&at, &mut rates[stage], WEIGHTS[stage] * span, &mut totals);
    }
    let estimate = |weights: &[(usize, f64)]| {
        let mut sums = [0.0; N];
        for &(i, weight) in weights {
            for j in 0..M {
                sums[j] += weight * rates[i][j].to_f64();
            }
        }
        sums
    };
    FlowStep {
        end: flow.after(from, h, moved::<_, N, M>(&start, h, &rates, B)),
        length: h,
        error: flow.error(&estimate(E5), &estimate(E3), h.to_f64()),
        totals,
    }
}

/// x + h Σ w ẋ for the first `M` of the numbers x, an even number. They go two by two: more do not fit in a processor's
/// registers where they are dual.
#[inline(always)]
fn moved<R: Scalar, const N: usize, const M: usize>(
    from: &[R; N],
    h: R,
    rates: &StageRates<R, N>,
    weights: &[(usize, f64)],
) -> [R; N] {
    let mut end = *from;
    for j in (0..M).step_by(2) {
        let (mut first, mut second) = (R::ZERO, R::ZERO);
        for &(i, weight) in weights {
            first += rates[i][j].scaled(weight);
            second += rates[i][j + 1].scaled(weight);
        }
        end[j] = from[j] + h * first;
        end[j + 1] = from[j + 1] + h * second;
    }
    end
}
