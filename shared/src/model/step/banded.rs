//! The band as the chapter uses it.

use super::{HammerState, Span, Stepper, record_at_end, runge_kutta};
use crate::model::contacts::Ledger;
use crate::model::rig::Rig;
use crate::model::scalar::Real;
use crate::model::switch::{Band, banded_force};

/// The switch model with a band and nothing else: each Runge–Kutta stage uses the field of the subspace
/// it lies in.
///
/// What to expect of it. Crossing the band takes 2 η_α ci/m of speed (a slower hammer is trapped in it), half
/// of which it would lose without a band too: half a percent of force needs an η_α below about 1e-7 m. But a
/// 20 kHz tick travels 4e-6 m and steps over such a band almost every time, and then the force is wrong by
/// where in the tick the onset fell: for one contact at 0.08 m/s, with η_α = 5e-8 m, by up to 1.6 % at 10 µs,
/// 6.6 % at 50 µs and 25 % at 200 µs (measured, docs/accuracy.md). [`super::Corrected`] is the cure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Banded<R> {
    /// Widths η_α and η_β of the band.
    pub band: Band<R>,
}

impl<R: Real> Stepper<R> for Banded<R> {
    #[inline]
    fn advance(
        &self,
        rig: &Rig<R>,
        span: &Span<R>,
        state: &mut HammerState<R>,
        ledger: &mut Ledger<R>,
    ) {
        let approach = state.approach;
        let moved = runge_kutta(rig, span, state, (span.from, span.to), |at| {
            banded_force(rig.law(), at.delta, at.rate, approach, &self.band)
        });
        record_at_end(rig, span, state, &moved, ledger);
    }

    #[inline]
    fn force(&self, rig: &Rig<R>, state: &HammerState<R>) -> R {
        let at = rig.kinematics(state.q.hi, state.v.hi);
        banded_force(rig.law(), at.delta, at.rate, state.approach, &self.band)
    }
}
