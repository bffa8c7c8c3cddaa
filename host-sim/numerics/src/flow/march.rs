//! Steps one after the other: their lengths, and why each ended.

use shared::Real as _;

use super::Flow;
use super::dormand_prince::{StepOf, next, shorter, step};

/// Why a step ended where it did.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StepEnded<X> {
    /// It was as long as its error allowed.
    Within,
    /// The phase ended so.
    Switched(X),
    /// The time to stop at came.
    AtStop,
}

/// The lengths of a march's steps.
#[derive(Clone, Copy, Debug)]
pub struct Pace {
    /// The length to try next, s.
    pub next: f64,
    /// The length to try after a switch, s.
    first: f64,
    /// Steps tried since the start, those refused included; what locating a switch takes is not counted.
    pub tried: u64,
}

impl Pace {
    /// The pace of a march whose steps after the start and after each switch are tried at `first` s.
    pub fn new(first: f64) -> Self {
        Self {
            next: first,
            first,
            tried: 0,
        }
    }

    /// The next step of `flow` from `from` that is accurate enough: no longer than `longest` (s), to an end of the phase or
    /// to the time `stop` (s) at most, where it ends exactly, whatever time carries derivatives. `None` once `most` steps
    /// were tried since the start.
    pub fn advance<F: Flow<N>, const N: usize>(
        &mut self,
        flow: &F,
        from: &F::Point,
        stop: f64,
        longest: f64,
        most: u64,
    ) -> Option<(StepOf<F, N>, StepEnded<F::Exit>)> {
        while self.tried < most {
            self.tried += 1;
            let begin = flow.time(from);
            let to_go = stop - begin.to_f64();
            let wanted = self.next.min(longest);
            let last = to_go <= wanted;
            let h = wanted.min(to_go);
            let length = if last {
                F::Number::from_f64(stop) - begin
            } else {
                F::Number::from_f64(h)
            };
            let whole = step(flow, from, length);
            if whole.error > 1.0 {
                self.next = shorter(h, whole.error);
                continue;
            }
            if flow.too_long(from, h, &whole.end) {
                self.next = 0.5 * h;
                continue;
            }
            if let Some((exit, at)) = flow.exit(from, h, &whole.end) {
                self.next = self.first;
                return Some((step(flow, from, at), StepEnded::Switched(exit)));
            }
            if last {
                return Some((whole, StepEnded::AtStop));
            }
            self.next = next(h, whole.error);
            return Some((whole, StepEnded::Within));
        }
        None
    }
}
