//! The first part of a pick, in a fraction of its time: for who waits.

use serde::Serialize;

use super::{BAND_SHARE, best_branch, curve, no_one_one, worth_band};
use crate::branch::BranchEnd;
use crate::error::Error;
use crate::row::NamedRig;

/// Points of the curve, beside those the branch was followed by.
const CURVE_POINTS: usize = 40;

/// Where the nominal rig is strongest. Uncertainty, limits, jumps and the beams' bending are not looked at: they may move
/// the operating point.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Outline {
    /// Name of the rig.
    pub rig: String,
    /// Where the stable 1/1 is strongest, Hz.
    pub nominal_optimum_hz: f64,
    /// `nominal_optimum_hz` over the natural frequency.
    pub frequency_ratio: f64,
    /// Contact force over m g there.
    pub nominal_optimum_force_ratio: f64,
    /// Contact force at `nominal_optimum_hz`, N.
    pub force_n: f64,
    /// Share of that force down to which the band reaches.
    pub band_share: f64,
    /// Where the stable 1/1 has at least this share of that force, Hz.
    pub band_hz: [f64; 2],
    /// Where it is stable, Hz.
    pub stable_one_one_hz: [f64; 2],
    /// How it ends, below and above.
    pub stable_one_one_ends: [BranchEnd; 2],
    /// The stable 1/1: Hz and contact force over m g.
    pub curve: Vec<(f64, f64)>,
}

/// Finds it.
///
/// # Errors
/// If a parameter is out of range, or if there is no stable 1/1.
pub fn outline(rig: &NamedRig) -> Result<Outline, Error> {
    let params = &rig.params;
    params.check()?;
    let branch = best_branch(rig)?;
    let strongest = branch.best(branch.range(), |orbit| orbit.force_n);
    let strongest = strongest.ok_or_else(|| no_one_one(rig))?;
    let weight_n = params.weight_n();
    let drawn = curve(&branch, CURVE_POINTS).into_iter();
    Ok(Outline {
        rig: rig.name.clone(),
        nominal_optimum_hz: strongest.frequency_hz,
        frequency_ratio: strongest.frequency_hz / params.natural_frequency_hz(),
        nominal_optimum_force_ratio: strongest.force_n / weight_n,
        force_n: strongest.force_n,
        band_share: BAND_SHARE,
        band_hz: worth_band(&branch, &strongest).into(),
        stable_one_one_hz: branch.range().into(),
        stable_one_one_ends: [branch.low.end, branch.high.end],
        curve: drawn
            .map(|(hz, force_n)| (hz, force_n / weight_n))
            .collect(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::limits::PickLimits;
    use crate::pick::pick;

    #[test]
    fn the_outline_is_the_nominal_pick_s() {
        let rig = NamedRig::preset("wires").unwrap().prescribed();
        let first = outline(&rig).unwrap();
        let whole = pick(&rig, None, PickLimits::default(), &()).unwrap().answer;
        assert_eq!(first.nominal_optimum_hz, whole.nominal_optimum_hz);
        assert_eq!(
            first.nominal_optimum_force_ratio,
            whole.nominal_optimum_force_ratio
        );
        assert_eq!(first.stable_one_one_hz, whole.stable_one_one_hz);
        assert_eq!(first.stable_one_one_ends, whole.stable_one_one_ends);
        assert_eq!(first.band_hz, whole.band_hz);
        let top = first.curve.iter().map(|point| point.1).fold(0.0, f64::max);
        assert!((0.99..1.0 + 1e-9).contains(&(top / first.nominal_optimum_force_ratio)));
    }
}
