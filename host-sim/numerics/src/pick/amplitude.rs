//! Another amplitude: a lower one where the shaker cannot give the rig's, or the one that gives the force wanted.

use super::case::PickCase;
use super::choose::PickField;
use crate::limits::PickLimits;
use crate::progress::{Progress, WithinStep};
use crate::row::NamedRig;

/// The shaker's limits are kept up to this many times the frequency that is strongest at the lower amplitude, so that the
/// choice is not the top of its band.
const MARGIN: f64 = 1.05;
/// Amplitudes tried. Forces go with the amplitude at no gap, where the second fits.
const TRIALS: usize = 10;

/// `rig` at the first of a few lower and lower amplitudes at which its best nominal 1/1 needs no more than the shaker's limits
/// allow. None if it does at the rig's own, so that lowering it is no help, or at no lower one, or there is no 1/1.
pub fn lowered<C: PickCase>(
    rig: &NamedRig,
    case: &C,
    limits: PickLimits,
    progress: &dyn Progress,
) -> Option<NamedRig> {
    let most = limits.shaker_force_n(&rig.params)?;
    let free = limits.without_the_shaker();
    let mut lower = rig.clone();
    for trial in 0..TRIALS {
        let there = case.with(&lower.params);
        let orbit = best_within(&lower, &there, free, progress)?;
        let needed = MARGIN * MARGIN * there.shaker_force_n(&orbit) / most;
        if needed <= 1.0 {
            return (trial > 0).then_some(lower);
        }
        lower.params.amplitude_m *= 0.999 / needed;
    }
    None
}

/// Amplitudes tried for a force that is wanted.
const TRIALS_FOR_FORCE: usize = 40;

/// The amplitude at which `force` has the value wanted, to `tolerance` of it, and what came with the force there: `force` at an
/// amplitude is larger the larger that is, about in proportion. `force` is none where there is no orbit: the amplitude is too
/// small for the gap, then. None if there is no such amplitude.
///
/// # Errors
/// Those of `force`.
pub fn for_force<T, E>(
    from_m: f64,
    (wanted_n, tolerance): (f64, f64),
    mut force: impl FnMut(f64) -> Result<Option<(f64, T)>, E>,
) -> Result<Option<T>, E> {
    let (mut weak, mut strong) = (0.0, f64::INFINITY);
    let mut last: Option<(f64, f64)> = None;
    let mut amplitude_m = from_m;
    for _ in 0..TRIALS_FOR_FORCE {
        let found = force(amplitude_m)?;
        let reached = found.as_ref().map_or(0.0, |(n, _)| *n);
        if let Some((n, what)) = found
            && (n / wanted_n - 1.0).abs() <= tolerance
        {
            return Ok(Some(what));
        }
        if reached < wanted_n {
            weak = amplitude_m;
        } else {
            strong = amplitude_m;
        }
        let power = last.map(|(m, n): (f64, f64)| (reached / n).ln() / (amplitude_m / m).ln());
        let power = power.filter(|p| p.is_finite() && *p > 0.2).unwrap_or(1.0);
        let next = amplitude_m * (wanted_n / reached).powf(1.0 / power);
        last = (reached > 0.0).then_some((amplitude_m, reached));
        amplitude_m = if weak < next && next < strong {
            next
        } else if strong.is_infinite() {
            2.0 * weak
        } else if weak == 0.0 {
            0.5 * strong
        } else {
            (weak * strong).sqrt()
        };
    }
    Ok(None)
}

/// The best nominal 1/1 within `limits`.
pub fn best_within<C: PickCase>(
    rig: &NamedRig,
    case: &C,
    limits: PickLimits,
    progress: &dyn Progress,
) -> Option<C::Orbit> {
    let branch = &case.best_branch(rig, &WithinStep(progress)).ok()?;
    PickField::nominal(rig, branch, progress).best(branch.range(), limits)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_amplitude_of_a_force_is_found_also_past_where_there_is_no_orbit() {
        // Nothing up to 1, then steeper than in proportion.
        let force = |a: f64| Ok::<_, ()>((a > 1.0).then_some((a * a - 1.0, a)));
        for from in [0.2, 1.5, 30.0] {
            let found = for_force(from, (8.0, 1e-6), force).unwrap().unwrap();
            assert!((found - 3.0).abs() < 1e-5, "{found} from {from}");
        }
        let flat = |_| Ok::<_, ()>(Some((1.0, ())));
        assert_eq!(for_force(1.0, (8.0, 1e-6), flat), Ok(None));
        assert_eq!(
            for_force(1.0, (8.0, 1e-6), |_| Err::<Option<(f64, ())>, _>(7)),
            Err(7)
        );
    }
}
