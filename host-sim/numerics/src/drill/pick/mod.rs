//! Which frequency to run the hammer at for the largest rate of penetration: [`crate::pick`] with another objective, on
//! ground that gives way instead of the surface that stays.
//!
//! The flow is that of every pick; here is what differs: where the nominal stable 1/1 is found and how it is followed
//! ([`branch`]), what rig and ground may be ([`members`]), and what runs show. [`crate::pick::PickAnswer`] carries what every
//! pick says, its forces and bands being those on the ground (the band is where the rate is above 90 % of that chosen);
//! [`answer::OnGround`] carries the rest.

pub mod answer;
pub mod branch;
pub mod members;
mod observe;

use shared::model::bit::Bit;
use shared::model::params::RigParams;
use shared::model::slider::Slider;

use self::answer::{OnGround, rate_sensitivity};
use self::branch::{DrillCase, follow};
use self::members::with_ground;
use self::observe::seed;
use super::blow::Feed;
use super::orbit::DrillOrbit;
use super::run::DrillSetting;
use super::search::GroundUncertainty;
use crate::branch::Branch;
use crate::error::{Error, PickError};
use crate::limits::PickLimits;
use crate::pick::bending::{Bending, BendingRequest, Bent, on_beams};
use crate::pick::case::{OrbitNumbers, PickCase};
use crate::pick::robust::Robust;
use crate::pick::runs::{Jumps, Runs};
use crate::pick::sensitivity::Sensitivity;
use crate::pick::{PickAnswer, PickRequest, SEARCH_RATIOS, Springs, pick, pick_case};
use crate::progress::{Progress, WithinStep, check};
use crate::row::NamedRig;
use crate::uncertainty::{Member, Uncertainty};

/// What is asked for.
#[derive(Clone, Copy, Debug)]
pub struct DrillPickRequest {
    /// The nominal ground, which gives way.
    pub ground: Slider<f64>,
    /// A bit between hammer and ground.
    pub bit: Option<Bit<f64>>,
    /// How far it is unknown; counts where `uncertainty` is given.
    pub ground_uncertainty: GroundUncertainty,
    /// How far the rig is unknown. None: rig and ground are exact.
    pub uncertainty: Option<Uncertainty>,
    /// What must be kept.
    pub limits: PickLimits,
}

impl DrillPickRequest {
    /// How far rig and ground are unknown; the ground is where the contact would be.
    fn whole_uncertainty(&self) -> Option<Uncertainty> {
        let with = |rig| with_ground(rig, self.ground_uncertainty);
        self.uncertainty.map(with)
    }

    /// Steps of progress of its pick.
    pub fn steps(&self) -> u64 {
        crate::pick::steps(self.whole_uncertainty())
    }
}

/// The answer and what its picture is drawn from.
#[derive(Clone, Debug)]
pub struct RopPick {
    /// What every pick says.
    pub answer: PickAnswer,
    /// What this one says beside it.
    pub ground: OnGround,
    /// The nominal stable 1/1: (Hz, µm/s).
    pub curve: Vec<(f64, f64)>,
}

/// Picks the frequency with the largest rate of penetration of `rig` on the ground of `request`, at its own gap and with
/// its own cart. Where no frequency keeps the limits of the shaker, the amplitude is lowered until one does.
///
/// # Errors
/// As [`pick`]; [`Error::NoProgress`] if nothing gives way anywhere.
pub fn pick_rop(
    rig: &NamedRig,
    request: &DrillPickRequest,
    progress: &dyn Progress,
) -> Result<RopPick, Error> {
    let (uncertainty, ground) = (request.uncertainty, request.ground);
    let case = DrillCase {
        params: rig.params,
        setting: DrillSetting::new(ground, request.bit, Feed::Cart),
    };
    let asked = PickRequest {
        springs: Springs::default(),
        uncertainty: request.whole_uncertainty(),
        limits: request.limits,
    };
    let (answer, found) = pick_case(rig, &case, asked, progress)?;
    let rigid = pick(
        &found.rig,
        None,
        PickLimits::default(),
        &WithinStep(progress),
    )
    .ok();
    let rigid_hz = rigid.map(|p| p.answer.operating_frequency_hz);
    check(progress)?;
    let um = |m_per_s: f64| 1e6 * m_per_s;
    let (branch, chosen, spread) = (&found.branch, &found.choice.orbit, &found.choice.spread);
    let [recoil, prescribed] = found.by_cart();
    let ground = OnGround {
        objective: "rop",
        threshold_n: ground.threshold,
        ground_stiffness_n_per_m: ground.stiffness,
        ground_damping_n_s_per_m: ground.damping,
        bit_mass_kg: request.bit.map(|b| b.mass),
        bit_feed_force_n: request.bit.map(|b| b.feed_force),
        uncertain: uncertainty.map(|_| request.ground_uncertainty),
        rate_of_penetration_um_per_s: um(chosen.rate_m_per_s()),
        rate_worst_um_per_s: um(spread.least),
        rate_largest_um_per_s: um(spread.most),
        safe_band_rate_worst_um_per_s: found.safe_spread.map(|s| Some(um(s?.least))),
        progress_per_blow_um: um(chosen.progress_m),
        energy_per_blow_mj: 1e3 * chosen.contact_j,
        share_into_progress: ground.threshold * chosen.progress_m / chosen.contact_j,
        feed_needed_mm_per_s: 1e3 * chosen.rate_m_per_s(),
        nominal_optimum_rate_um_per_s: um(found.nominal.rate_m_per_s()),
        force_optimum_hz: rigid_hz,
        force_optimum_rate_um_per_s: rigid_hz
            .and_then(|hz| branch.at(hz))
            .map(|o| um(o.rate_m_per_s())),
        recoil_rate_um_per_s: recoil.map(|best| um(best.worth)),
        prescribed_rate_um_per_s: prescribed.map(|best| um(best.worth)),
        rate_sensitivity: rate_sensitivity(
            &branch.case,
            chosen,
            uncertainty,
            request.ground_uncertainty,
        ),
    };
    let answer = PickAnswer {
        uncertainty: uncertainty.map(|u| Uncertainty {
            contact_stiffness_percent: 0.0,
            contact_damping_percent: 0.0,
            contact_stiffness_factor: None,
            contact_damping_ratio_percent: None,
            ..u
        }),
        bending: Bending {
            modes: on_beams(&rig.params).then_some(1),
            ..answer.bending
        },
        ..answer
    };
    let curve = found.curve.into_iter();
    Ok(RopPick {
        answer,
        ground,
        curve: curve.map(|(hz, rate)| (hz, um(rate))).collect(),
    })
}

/// On ground, the rate of penetration is made largest.
impl PickCase for DrillCase {
    type Followed = Member;

    fn check(&self) -> Result<(), Error> {
        self.params.check()?;
        let DrillSetting { ground, bit, .. } = &self.setting;
        ground.check()?;
        if let Some(bit) = bit {
            bit.check(ground)?;
        }
        Ok(())
    }

    fn with(&self, params: &RigParams) -> Self {
        Self {
            params: *params,
            ..*self
        }
    }

    fn numbers_of(orbit: &DrillOrbit) -> OrbitNumbers {
        OrbitNumbers {
            frequency_hz: orbit.frequency_hz,
            worth: orbit.rate_m_per_s(),
            force_n: orbit.force_n,
            multiplier: orbit.multipliers().modulus(),
            is_stable_one_one: orbit.is_stable_one_one(),
            impact_power_w: orbit.contact_j * orbit.frequency_hz,
        }
    }

    fn shaker_force_n(&self, orbit: &DrillOrbit) -> f64 {
        observe::shaker_force_n(self, orbit)
    }

    /// About the one that drills fastest from rest.
    fn best_branch(&self, rig: &NamedRig, progress: &dyn Progress) -> Result<Branch<Self>, Error> {
        let none = || {
            rig.no_pick(PickError::NoOneOne {
                gap_m: rig.params.gap_m,
                ratios: SEARCH_RATIOS,
                nearest_gap_m: None,
            })
        };
        let seed = seed(rig, self, progress)?.ok_or_else(none)?;
        let natural_hz = rig.params.natural_frequency_hz();
        let limits = (SEARCH_RATIOS.0 * natural_hz, SEARCH_RATIOS.1 * natural_hz);
        Ok(follow(*self, seed, limits))
    }

    fn drawn_at(branch: &Branch<Self>, hz: f64) -> Option<f64> {
        Some(branch.at(hz)?.rate_m_per_s())
    }

    fn stable_at(&self, rig: &Member, orbit: &DrillOrbit) -> Option<DrillOrbit> {
        members::followed(self, rig, orbit)
    }

    fn common_range(
        branch: &Branch<Self>,
        members: &[Member],
        nominal: &DrillOrbit,
        progress: &dyn Progress,
    ) -> Option<Robust<Self>> {
        let hz = members::common_range(branch, members, nominal.frequency_hz, progress)?;
        let members = members.to_vec();
        Some(Robust { hz, members })
    }

    /// What bending modes change there has not been computed.
    fn bent(&self, _: BendingRequest, _: &dyn Progress) -> Result<Option<Bent>, Error> {
        Ok(None)
    }

    fn jumps(_: &NamedRig, branch: &Branch<Self>, progress: &dyn Progress) -> Result<Jumps, Error> {
        observe::jumps(branch, progress)
    }

    fn runs(&self, chosen: &DrillOrbit, uncertainty: Option<Uncertainty>) -> Result<Runs, Error> {
        observe::runs(self, chosen, uncertainty)
    }

    /// The rate's are another table ([`OnGround::rate_sensitivity`]).
    fn sensitivity(&self, _: &DrillOrbit, _: Option<Uncertainty>) -> Vec<Sensitivity> {
        Vec::new()
    }
}
