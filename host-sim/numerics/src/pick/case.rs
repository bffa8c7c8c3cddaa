//! What a pick asks of a rig, on a surface that stays or on ground: the same flow serves both.

use shared::model::params::RigParams;

use super::answer::{impact_power, shaker_force};
use super::bending::{BendingRequest, Bent};
use super::follow::Followed;
use super::robust::{self, Robust};
use super::runs::{Jumps, Runs};
use super::sensitivity::{self, Sensitivity};
use super::{RANGES_COMPUTED, best_branch};
use crate::branch::{Branch, Case};
use crate::error::Error;
use crate::orbit::Orbit;
use crate::progress::Progress;
use crate::row::NamedRig;
use crate::uncertainty::{Member, Uncertainty};

/// What a pick asks of an orbit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OrbitNumbers {
    /// Drive frequency, Hz.
    pub frequency_hz: f64,
    /// What is made largest: the contact force, N, or the rate of penetration, m/s.
    pub worth: f64,
    /// Largest contact force, N.
    pub force_n: f64,
    /// Largest modulus of a multiplier.
    pub multiplier: f64,
    /// Whether it is a stable 1/1.
    pub is_stable_one_one: bool,
    /// Energy that the contacts take from the hammer per second, W.
    pub impact_power_w: f64,
}

/// A rig whose best frequency is picked, and what is made largest.
pub trait PickCase: Case {
    /// A rig of the uncertainty, and what is known of its 1/1.
    type Followed: Clone + PartialEq + Sync;

    /// Whether it can be.
    ///
    /// # Errors
    /// The first parameter out of range.
    fn check(&self) -> Result<(), Error>;

    /// This case with the rig of `params`.
    fn with(&self, params: &RigParams) -> Self;

    /// What a pick asks of `orbit`.
    fn numbers_of(orbit: &Self::Orbit) -> OrbitNumbers;

    /// Largest force of the shaker for `orbit`, N.
    fn shaker_force_n(&self, orbit: &Self::Orbit) -> f64;

    /// The nominal stable 1/1 worth most.
    ///
    /// # Errors
    /// If there is none.
    fn best_branch(&self, rig: &NamedRig, progress: &dyn Progress) -> Result<Branch<Self>, Error>;

    /// What is made largest at `hz`, as it is drawn.
    fn drawn_at(branch: &Branch<Self>, hz: f64) -> Option<f64>;

    /// The 1/1 of a rig of the uncertainty at the frequency of the nominal `orbit`, if that is stable.
    fn stable_at(&self, rig: &Self::Followed, orbit: &Self::Orbit) -> Option<Self::Orbit>;

    /// The frequencies at which every member has a stable 1/1, sought from the `nominal` orbit. A step of the progress is a
    /// member. None if there is no such frequency, or the work is interrupted.
    fn common_range(
        branch: &Branch<Self>,
        members: &[Member],
        nominal: &Self::Orbit,
        progress: &dyn Progress,
    ) -> Option<Robust<Self>>;

    /// What bending modes change.
    ///
    /// # Errors
    /// If the work is interrupted.
    fn bent(&self, request: BendingRequest, progress: &dyn Progress)
    -> Result<Option<Bent>, Error>;

    /// Where the hammer jumps. A step of the progress is a run.
    ///
    /// # Errors
    /// If a run cannot be followed, or the work is interrupted.
    fn jumps(
        rig: &NamedRig,
        branch: &Branch<Self>,
        progress: &dyn Progress,
    ) -> Result<Jumps, Error>;

    /// What settled runs show of the orbit `chosen`.
    ///
    /// # Errors
    /// If a run cannot be followed.
    fn runs(&self, chosen: &Self::Orbit, uncertainty: Option<Uncertainty>) -> Result<Runs, Error>;

    /// How the `nominal` optimum moves with each parameter.
    fn sensitivity(
        &self,
        nominal: &Self::Orbit,
        uncertainty: Option<Uncertainty>,
    ) -> Vec<Sensitivity>;
}

/// On a surface that stays, the contact force is made largest.
impl PickCase for RigParams {
    type Followed = Followed;

    fn check(&self) -> Result<(), Error> {
        Ok(RigParams::check(self)?)
    }

    fn with(&self, params: &RigParams) -> Self {
        *params
    }

    fn numbers_of(orbit: &Orbit) -> OrbitNumbers {
        OrbitNumbers {
            frequency_hz: orbit.frequency_hz,
            worth: orbit.force_n,
            force_n: orbit.force_n,
            multiplier: orbit.multipliers().modulus(),
            is_stable_one_one: orbit.is_stable_one_one(),
            impact_power_w: impact_power(orbit),
        }
    }

    fn shaker_force_n(&self, orbit: &Orbit) -> f64 {
        shaker_force(self, orbit)
    }

    fn best_branch(&self, rig: &NamedRig, _: &dyn Progress) -> Result<Branch, Error> {
        best_branch(rig)
    }

    fn drawn_at(branch: &Branch, hz: f64) -> Option<f64> {
        branch.force_n_at(hz)
    }

    fn stable_at(&self, rig: &Followed, orbit: &Orbit) -> Option<Orbit> {
        rig.stable_at(self, orbit)
    }

    fn common_range(
        branch: &Branch,
        members: &[Member],
        nominal: &Orbit,
        progress: &dyn Progress,
    ) -> Option<Robust> {
        robust::common_range(members, branch, nominal, progress)
    }

    fn bent(
        &self,
        request: BendingRequest,
        progress: &dyn Progress,
    ) -> Result<Option<Bent>, Error> {
        request.run(progress)
    }

    fn jumps(rig: &NamedRig, branch: &Branch, progress: &dyn Progress) -> Result<Jumps, Error> {
        Jumps::find(rig, branch, progress)
    }

    fn runs(&self, chosen: &Orbit, uncertainty: Option<Uncertainty>) -> Result<Runs, Error> {
        Runs::of(self, uncertainty, chosen)
    }

    fn sensitivity(&self, nominal: &Orbit, uncertainty: Option<Uncertainty>) -> Vec<Sensitivity> {
        let mut rows = sensitivity::table(self, nominal);
        if let Some(u) = &uncertainty {
            let known = rows.into_iter().map(|row| row.known_to(u, &self.contact));
            rows = known.collect();
            sensitivity::compute_ranges(&mut rows, RANGES_COMPUTED, self, nominal);
        }
        rows
    }
}
