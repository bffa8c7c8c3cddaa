//! A lower amplitude, where the shaker cannot give the rig's.

use super::answer::drive_force;
use super::choose::{Field, Limits};
use super::{best_branch, range};
use crate::orbit::loop_force_n;
use crate::progress::Progress;
use crate::row::NamedRig;

/// The shaker's limits are kept up to this many times the frequency that is strongest at the lower amplitude, so that the
/// choice is not the top of its band.
const MARGIN: f64 = 1.05;
/// Amplitudes tried. Forces go with the amplitude at no gap, where the second fits.
const TRIALS: usize = 10;

/// `rig` at the amplitude at which its strongest nominal 1/1 needs no more than the shaker's limits allow. None if it does
/// at the rig's own, so that lowering it is no help, or at no lower one.
pub fn lowered(rig: &NamedRig, limits: Limits, progress: &dyn Progress) -> Option<NamedRig> {
    let free = Limits {
        max_drive_force_n: None,
        max_loop_force_n: None,
        ..limits
    };
    lower_until(rig, |lower| {
        let branch = best_branch(lower).ok()?;
        let field = Field {
            rig: lower,
            branch: &branch,
            members: &[],
            progress,
        };
        let orbit = field.best(range(&branch), free)?;
        let params = &lower.params;
        let drive = limits
            .max_drive_force_n
            .map(|most| drive_force(params, orbit.frequency_hz) / most);
        let held = limits
            .max_loop_force_n
            .and_then(|most| Some(loop_force_n(params, &orbit)? / most));
        Some(drive.unwrap_or(0.0).max(held.unwrap_or(0.0)))
    })
}

/// `rig` at the first of a few lower and lower amplitudes at which it needs no more than the shaker's limits allow;
/// `needed_over_allowed` is what the best orbit of a rig needs over what they allow. None if that is so at the rig's own
/// amplitude, or at none, or there is no orbit.
pub fn lower_until(
    rig: &NamedRig,
    needed_over_allowed: impl Fn(&NamedRig) -> Option<f64>,
) -> Option<NamedRig> {
    let mut lower = rig.clone();
    for trial in 0..TRIALS {
        let needed = MARGIN * MARGIN * needed_over_allowed(&lower)?;
        if needed <= 1.0 {
            return (trial > 0).then_some(lower);
        }
        lower.params.amplitude_m *= 0.999 / needed;
    }
    None
}
