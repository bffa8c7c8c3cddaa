//! A motion apart from the method that integrates it.
//!
//! A [`Flow`] is smooth motion in one phase: what moves and how fast, how errors are weighed, and where the phase ends.
//! [`dormand_prince`] takes a step of any flow, [`march`] strings steps together up to a switch or a given time. What
//! happens at a switch is the caller's, and so is the next phase, which is the next flow.

pub mod dormand_prince;
pub mod march;
mod scalar;
mod tableau;

pub use dormand_prince::{FlowStep, reached, step};
pub use march::{Pace, StepEnded};
pub use scalar::Scalar;

/// One phase of a motion whose state is a point over `N` numbers that have rates.
pub trait Flow<const N: usize> {
    /// What its numbers are.
    type Number: Scalar;
    /// Where everything is, the time included.
    type Point: Copy;
    /// What is integrated beside the motion, such as energies, J.
    type Totals: Default;
    /// How the phase can end.
    type Exit;

    /// The time of a point, s.
    fn time(&self, point: &Self::Point) -> Self::Number;

    /// The numbers that have rates.
    fn numbers(&self, point: &Self::Point) -> [Self::Number; N];

    /// How many of them move in this phase: the first so many. The others keep their values and cost nothing.
    fn moving(&self) -> usize {
        N
    }

    /// The point `tau` (s) after `from`, given its numbers; what has a closed form follows from the time.
    fn after(
        &self,
        from: &Self::Point,
        tau: Self::Number,
        numbers: [Self::Number; N],
    ) -> Self::Point;

    /// Enters the rates at a point. Unless `weight` (s) is 0, the powers there times `weight` are added to `totals`.
    fn rates(
        &self,
        at: &Self::Point,
        rates: &mut [Self::Number; N],
        weight: f64,
        totals: &mut Self::Totals,
    );

    /// The error of a step of `h` s over the tolerance, from the estimates of orders 5 and 3 of the mean rates' errors.
    fn error(&self, fifth: &[f64; N], third: &[f64; N], h: f64) -> f64;

    /// Whether a step of `h` s to `end` must be halved before an end of the phase can be looked for in it.
    fn too_long(&self, _from: &Self::Point, _h: f64, _end: &Self::Point) -> bool {
        false
    }

    /// How the phase ends within the step of `h` s from `from` to `end`, and how long after `from` (s).
    fn exit(
        &self,
        from: &Self::Point,
        h: f64,
        end: &Self::Point,
    ) -> Option<(Self::Exit, Self::Number)>;
}
