//! The band as the chapter uses it.

use super::{Span, State, Stepper, book_at_end, runge_kutta};
use crate::contacts::Ledger;
use crate::rig::Rig;
use crate::scalar::Real;
use crate::switch::{Band, banded_force};

/// The switch model with a band and nothing else: each Runge–Kutta stage uses the field of the subspace
/// it lies in.
///
/// What to expect of it: the band takes about 2 η_α ci/m of speed from each contact (below that speed it
/// traps the hammer), so η_α must be near 5e-8 m for half a percent; but a 20 kHz tick travels 4e-6 m and
/// steps over such a band, and then the force is wrong by where the onset fell in the tick: up to a third
/// at 50 µs. The accuracy page of the book has the figures; [`super::Corrected`] is the cure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Banded<R> {
    /// The band's widths.
    pub band: Band<R>,
}

impl<R: Real> Stepper<R> for Banded<R> {
    #[inline]
    fn advance(&self, rig: &Rig<R>, span: &Span<R>, state: &mut State<R>, ledger: &mut Ledger<R>) {
        let approach = state.approach;
        let moved = runge_kutta(rig, span, state, (span.from, span.to), |at| {
            banded_force(rig.law(), at.delta, at.rate, approach, &self.band)
        });
        book_at_end(rig, span, state, &moved, ledger);
    }

    #[inline]
    fn force(&self, rig: &Rig<R>, state: &State<R>) -> R {
        let at = rig.kinematics(state.q.hi, state.v.hi);
        banded_force(rig.law(), at.delta, at.rate, state.approach, &self.band)
    }
}
