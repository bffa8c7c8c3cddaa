//! The smoothing method, for comparison.

use core::f64::consts::FRAC_1_PI;

use super::{HammerState, Span, Stepper, record_at_end, runge_kutta};
use crate::model::contacts::Ledger;
use crate::model::rig::Rig;
use crate::model::scalar::Real;

/// Arctangents in place of the switch: F is multiplied by (½ + atan(δ/ε_α)/π)(½ + atan(F/ε_β)/π).
///
/// The narrower the transition, the stiffer the equation and the smaller the step it needs; the wider,
/// the further from the switch it stands for. In chaos its section differs from the switch's however
/// small ε is chosen (the chapter's figure 3.4, after Wiercigroch).
///
/// The contact record keeps the law's F as the peak force; the force that acts is F times the two factors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Smoothed<R> {
    /// ε_α, m: penetration over which contact fades in.
    pub epsilon_alpha: R,
    /// ε_β, N: force over which contact fades out.
    pub epsilon_beta: R,
}

impl<R: Real> Smoothed<R> {
    #[inline]
    fn smooth_step(x: R) -> R {
        R::HALF + x.atan() * R::from_f64(FRAC_1_PI)
    }

    /// The force that acts where the law gives `force` (N) at penetration `delta` (m).
    #[inline]
    pub fn blended(&self, delta: R, force: R) -> R {
        force
            * Self::smooth_step(delta / self.epsilon_alpha)
            * Self::smooth_step(force / self.epsilon_beta)
    }
}

impl<R: Real> Stepper<R> for Smoothed<R> {
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
            self.blended(at.delta, rig.force(at, approach))
        });
        record_at_end(rig, span, state, &moved, ledger);
    }

    #[inline]
    fn force(&self, rig: &Rig<R>, state: &HammerState<R>) -> R {
        let at = rig.kinematics(state.q.hi, state.v.hi);
        self.blended(at.delta, rig.force(&at, state.approach))
    }
}
