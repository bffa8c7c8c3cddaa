//! Which frequency to run the hammer at for the largest rate of penetration: [`crate::pick`] with another objective, on
//! ground that gives way instead of the surface that stays.
//!
//! The stable 1/1 on the ground is followed over frequency by its multipliers ([`branch`]). What is left of it for every
//! member of the uncertainty of rig and ground ([`members`]) and within the limits is searched for the largest nominal
//! rate. [`crate::pick::Answer`] carries what every pick says, its forces and bands being those on the ground (the band is
//! where the rate is above 90 % of that chosen); [`answer::OnGround`] carries the rest.

pub mod answer;
pub mod branch;
pub mod members;
mod observe;

use std::f64::consts::TAU;

use shared::model::slider::Slider;

use self::answer::{OnGround, rate_sensitivity};
use self::branch::{Case, GroundBranch};
use self::members::{Crowd, with_ground};
use self::observe::{Observed, jumps, seed};
use super::orbit::DrillOrbit;
use super::search::GroundUncertainty;
use crate::branch::End;
use crate::error::{Error, PickError};
use crate::pick::answer::{LimitUse, drive_force};
use crate::pick::bending::{Bending, on_beams};
use crate::pick::{Answer, BAND_SHARE, CartModel, Limits, Uncertainty, pick};
use crate::progress::{Progress, WithinStep, check, step};
use crate::row::{NamedRig, tidy};
use crate::sweep::spread;

/// Ratios Ω/ω to which the 1/1 is followed.
const SEARCH_RATIOS: (f64, f64) = (0.4, 5.0);

/// Points of the curve that is drawn, beside those the branch was followed by.
const CURVE_POINTS: usize = 100;

/// Steps of progress.
pub const STEPS: u64 = 6;

/// What is asked for.
#[derive(Clone, Copy, Debug)]
pub struct Request {
    /// The ground.
    pub ground: Slider<f64>,
    /// How far it is unknown; counts where `uncertainty` is given.
    pub ground_uncertainty: GroundUncertainty,
    /// How far the rig is unknown. None: rig and ground are exact.
    pub uncertainty: Option<Uncertainty>,
    /// What must be kept.
    pub limits: Limits,
}

/// The answer and what its picture is drawn from.
#[derive(Clone, Debug)]
pub struct RopPick {
    /// What every pick says.
    pub answer: Answer,
    /// What this one says beside it.
    pub ground: OnGround,
    /// The nominal stable 1/1: (Hz, µm/s).
    pub curve: Vec<(f64, f64)>,
}

/// Picks the frequency with the largest rate of penetration of `rig` on the ground of `request`, at its own gap and with
/// its own cart.
///
/// # Errors
/// As [`pick`]; [`Error::NoProgress`] if nothing gives way anywhere.
pub fn pick_rop(
    rig: &NamedRig,
    request: &Request,
    progress: &dyn Progress,
) -> Result<RopPick, Error> {
    rig.params.check()?;
    request.ground.check()?;
    let limits = request.limits.with_shaker_of(&rig.params);
    let case = Case {
        params: rig.params,
        ground: request.ground,
    };
    let within = WithinStep(progress);
    let branch = nominal_branch(rig, &case, &within)?;
    step(progress, 1)?;
    let rate = |o: &DrillOrbit| Some(o.rate_m_per_s());
    let power = |o: &DrillOrbit| Some(o.contact_j * o.frequency_hz);
    let lost = || no_one_one(rig);
    let nominal = branch.best(branch.range(), rate).ok_or_else(lost)?;
    let strongest = branch.best(branch.range(), power).ok_or_else(lost)?;

    let uncertainty = request.uncertainty;
    let members = uncertainty.map_or(Vec::new(), |u| {
        with_ground(u, request.ground_uncertainty).members()
    });
    let crowd = Crowd {
        case: &case,
        branch: &branch,
        members: &members,
    };
    let corners = uncertainty.map_or(0, |u| {
        with_ground(u, request.ground_uncertainty).corners().len()
    });
    let robust = crowd.common_range(nominal.frequency_hz, corners);
    let robust = robust.ok_or_else(|| {
        rig.no_pick(PickError::NoneRobust {
            share: robust_share(crowd, nominal.frequency_hz, corners),
        })
    })?;
    step(progress, 1)?;
    let field = Field { crowd, limits };
    let chosen = field.best(robust).ok_or_else(|| {
        rig.no_pick(PickError::Limits {
            range_hz: robust,
            limits,
            feasible: Box::default(),
        })
    })?;
    check(progress)?;
    let hz = chosen.frequency_hz;
    let spread_at = crowd.spread(hz);
    let spread_at =
        spread_at.ok_or_else(|| rig.no_pick(PickError::MemberLost { frequency_hz: hz }))?;
    let enough = |hz: f64| {
        let there = branch.at(hz);
        there.is_some_and(|o| o.rate_m_per_s() >= BAND_SHARE * chosen.rate_m_per_s())
    };
    let band = branch.interval(hz, branch.range(), enough);
    let open = (band.0.max(robust.0), band.1.min(robust.1));
    let safe = branch.interval(hz, open, |hz| field.allows(hz));
    let safe_worst = [safe.0, safe.1].map(|hz| crowd.spread(hz));
    step(progress, 1)?;
    let jumps = jumps(&case, &branch)?;
    step(progress, 1)?;
    let uncertain = uncertainty.map(|u| (u, request.ground_uncertainty));
    let seen = Observed::of(&case, &chosen, &crowd, uncertain)?;
    let other = other_cart(rig, &case, &within);
    step(progress, 1)?;
    let rigid = pick(rig, None, Limits::default(), &within).ok();
    let rigid_hz = rigid.map(|p| p.answer.operating_frequency_hz);
    check(progress)?;

    let um = |m_per_s: f64| 1e6 * m_per_s;
    let cart = CartModel::of(&rig.params);
    let (recoil, prescribed) = match cart {
        CartModel::Recoil => (Some(chosen), other),
        CartModel::Prescribed => (other, Some(chosen)),
    };
    let weight = rig.params.weight_n();
    let params = &rig.params;
    let in_safe = |hz: &f64| (safe.0..=safe.1).contains(hz);
    let answer = Answer {
        rig: rig.name.clone(),
        gap_mm: tidy(params.gap_m * 1e3),
        cart,
        recoil_force_ratio: recoil.map(|o| o.force_n / weight),
        recoil_frequency_hz: recoil.map(|o| o.frequency_hz),
        prescribed_force_ratio: prescribed.map(|o| o.force_n / weight),
        prescribed_frequency_hz: prescribed.map(|o| o.frequency_hz),
        shaker_loop: rig.shaker,
        operating_frequency_hz: hz,
        frequency_ratio: hz / params.natural_frequency_hz(),
        regime: seen.on_orbit.regime,
        regime_from_rest: seen.from_rest,
        corners: seen.corners,
        corners_reaching_one_one_from_rest: seen.corners_reaching,
        force_ratio: chosen.force_n / weight,
        force_n: chosen.force_n,
        force_ratio_worst: spread_at.weakest_n / weight,
        force_ratio_largest: spread_at.strongest_n / weight,
        approach_speed_m_per_s: seen.blow.approach_speed_m_per_s,
        contact_time_ms: 1e3 * seen.blow.duration_s,
        band_hz: band.into(),
        safe_band_hz: safe.into(),
        safe_band_force_ratio_worst: safe_worst.map(|s| s.map(|s| s.weakest_n / weight)),
        stable_one_one_hz: branch.range().into(),
        stable_one_one_ends: [branch.low.end, branch.high.end],
        robust_band_hz: robust.into(),
        period_doubling_hz: (branch.high.end == End::PeriodDoubling)
            .then_some(branch.high.frequency_hz),
        multipliers: chosen.multipliers().modulus(),
        multipliers_worst: spread_at.multiplier,
        jump_free: jumps.is_empty(),
        jump_free_in_safe_band: !jumps.iter().any(in_safe),
        jump_range_hz: jumps.first().zip(jumps.last()).map(|(a, b)| [*a, *b]),
        nominal_optimum_hz: nominal.frequency_hz,
        nominal_optimum_force_ratio: nominal.force_n / weight,
        impact_power_w: chosen.contact_j * hz,
        power_optimum_hz: strongest.frequency_hz,
        power_optimum_w: strongest.contact_j * strongest.frequency_hz,
        force_ratio_at_natural_frequency: seen.force_at_natural_n / weight,
        shaker: seen.shaker(params, &chosen),
        limits: field.which_decide(&chosen, robust, !members.is_empty()),
        sensitivity: Vec::new(),
        uncertainty: uncertainty.map(|u| Uncertainty {
            contact_stiffness_percent: 0.0,
            contact_damping_percent: 0.0,
            ..u
        }),
        amplitude_mm: tidy(params.amplitude_m * 1e3),
        amplitude_lowered: false,
        bending: Bending {
            on_beams: on_beams(params),
            ..Bending::default()
        },
    };
    let ground = OnGround {
        objective: "rop",
        threshold_n: request.ground.threshold,
        ground_stiffness_n_per_m: request.ground.stiffness,
        ground_damping_n_s_per_m: request.ground.damping,
        uncertain: uncertainty.map(|_| request.ground_uncertainty),
        rate_of_penetration_um_per_s: um(chosen.rate_m_per_s()),
        rate_worst_um_per_s: um(spread_at.least_m_per_s),
        rate_largest_um_per_s: um(spread_at.most_m_per_s),
        safe_band_rate_worst_um_per_s: safe_worst.map(|s| s.map(|s| um(s.least_m_per_s))),
        progress_per_blow_um: um(chosen.progress_m),
        energy_per_blow_mj: 1e3 * chosen.contact_j,
        share_into_progress: request.ground.threshold * chosen.progress_m / chosen.contact_j,
        feed_needed_mm_per_s: 1e3 * chosen.rate_m_per_s(),
        nominal_optimum_rate_um_per_s: um(nominal.rate_m_per_s()),
        force_optimum_hz: rigid_hz,
        force_optimum_rate_um_per_s: rigid_hz
            .and_then(|hz| branch.at(hz))
            .map(|o| um(o.rate_m_per_s())),
        recoil_rate_um_per_s: recoil.map(|o| um(o.rate_m_per_s())),
        prescribed_rate_um_per_s: prescribed.map(|o| um(o.rate_m_per_s())),
        rate_sensitivity: rate_sensitivity(&case, &chosen, uncertainty, request.ground_uncertainty),
    };
    step(progress, 1)?;
    Ok(RopPick {
        answer,
        ground,
        curve: curve(&branch),
    })
}

/// The largest share of the uncertainty's corners with which every one of them has a stable 1/1 at a common frequency, in
/// hundredths.
fn robust_share(crowd: Crowd, from_hz: f64, corners: usize) -> Option<f64> {
    let robust = |hundredths: u32| {
        let share = f64::from(hundredths) / 100.0;
        let smaller = crowd.members[..corners].iter();
        let members: Vec<_> = smaller.map(|m| m.scaled(share)).collect();
        let crowd = Crowd {
            members: &members,
            ..crowd
        };
        crowd.common_range(from_hz, corners).is_some()
    };
    let (mut with, mut without) = (0, 100);
    while without - with > 1 {
        let middle = (with + without) / 2;
        if robust(middle) {
            with = middle;
        } else {
            without = middle;
        }
    }
    (with > 0).then_some(f64::from(with) / 100.0)
}

fn no_one_one(rig: &NamedRig) -> Error {
    rig.no_pick(PickError::NoOneOne {
        gap_m: rig.params.gap_m,
        ratios: SEARCH_RATIOS,
        nearest_gap_m: None,
    })
}

/// The stable 1/1 about the one that drills fastest from rest.
fn nominal_branch(
    rig: &NamedRig,
    case: &Case,
    progress: &dyn Progress,
) -> Result<GroundBranch, Error> {
    let seed = seed(rig, case, progress)?.ok_or_else(|| no_one_one(rig))?;
    let natural_hz = rig.params.natural_frequency_hz();
    let limits = (SEARCH_RATIOS.0 * natural_hz, SEARCH_RATIOS.1 * natural_hz);
    Ok(GroundBranch::follow(*case, seed, limits))
}

/// The nominal orbit with the largest rate with the cart moved the other way. None where its shaker is not known, or it has
/// no such orbit.
fn other_cart(rig: &NamedRig, case: &Case, progress: &dyn Progress) -> Option<DrillOrbit> {
    let other = if rig.params.cart.recoils() {
        rig.clone().prescribed()
    } else {
        rig.recoiling()?
    };
    let case = Case {
        params: other.params,
        ..*case
    };
    let branch = nominal_branch(&other, &case, progress).ok()?;
    branch.best(branch.range(), |o| Some(o.rate_m_per_s()))
}

fn curve(branch: &GroundBranch) -> Vec<(f64, f64)> {
    let (low, high) = branch.range();
    let mut nodes = spread(low, high, CURVE_POINTS);
    nodes.extend(branch.orbits.iter().map(|o| o.frequency_hz));
    nodes.sort_by(f64::total_cmp);
    let point = |hz: &f64| Some((*hz, 1e6 * branch.at(*hz)?.rate_m_per_s()));
    nodes.iter().filter_map(point).collect()
}

/// What is chosen from.
struct Field<'a> {
    crowd: Crowd<'a>,
    limits: Limits,
}

impl Field<'_> {
    /// Whether the limits allow the nominal orbit at `hz`.
    fn allows(&self, hz: f64) -> bool {
        self.crowd
            .branch
            .at(hz)
            .is_some_and(|o| self.allowed(&o, self.limits))
    }

    fn allowed(&self, orbit: &DrillOrbit, limits: Limits) -> bool {
        let (params, hz) = (&self.crowd.case.params, orbit.frequency_hz);
        // What is at a limit to the last digits keeps it.
        let keeps =
            |value: f64, limit: Option<f64>| limit.is_none_or(|most| value <= most * (1.0 + 1e-9));
        keeps(hz, limits.max_frequency_hz)
            && keeps(drive_force(params, hz), limits.max_drive_force_n)
            && limits.max_loop_force_n.is_none_or(|most| {
                observe::loop_force_n(self.crowd.case, orbit).is_none_or(|n| n <= most)
            })
            && limits.max_force_n.is_none_or(|most| {
                let spread = self.crowd.spread(hz);
                spread.is_some_and(|s| s.strongest_n <= most)
            })
    }

    /// The orbit with the largest rate in `range_hz` within the limits.
    fn best(&self, range_hz: (f64, f64)) -> Option<DrillOrbit> {
        self.best_within(range_hz, self.limits)
    }

    fn best_within(&self, range_hz: (f64, f64), limits: Limits) -> Option<DrillOrbit> {
        let at_one = drive_force(&self.crowd.case.params, 1.0);
        let by_drive = limits.max_drive_force_n.map(|max| (max / at_one).sqrt());
        let tops = [limits.max_frequency_hz, by_drive].into_iter().flatten();
        let top = tops.fold(range_hz.1, f64::min);
        self.crowd.branch.best((range_hz.0, top), |o| {
            self.allowed(o, limits).then(|| o.rate_m_per_s())
        })
    }

    /// A limit decides when dropping it, and it alone, gives more.
    fn which_decide(
        &self,
        chosen: &DrillOrbit,
        robust: (f64, f64),
        uncertain: bool,
    ) -> Vec<LimitUse> {
        let limits = self.limits;
        let more = |found: Option<DrillOrbit>| {
            found.is_some_and(|o| o.rate_m_per_s() > chosen.rate_m_per_s() * (1.0 + 1e-6))
        };
        let mut uses = Vec::new();
        if uncertain {
            let certain = Field {
                crowd: Crowd {
                    members: &[],
                    ..self.crowd
                },
                limits,
            };
            uses.push(LimitUse {
                name: "the uncertainty",
                limit: None,
                binds: more(certain.best(self.crowd.branch.range())),
            });
        }
        let (mut force, mut frequency, mut drive, mut held) = (limits, limits, limits, limits);
        force.max_force_n = None;
        frequency.max_frequency_hz = None;
        drive.max_drive_force_n = None;
        held.max_loop_force_n = None;
        let given = [
            ("max_force_n", limits.max_force_n, force),
            ("max_frequency_hz", limits.max_frequency_hz, frequency),
            ("max_drive_force_n", limits.max_drive_force_n, drive),
            ("shaker_max_force_n", limits.max_loop_force_n, held),
        ];
        let given = given.into_iter().filter(|(_, limit, _)| limit.is_some());
        uses.extend(given.map(|(name, limit, without)| LimitUse {
            name,
            limit,
            binds: more(self.best_within(robust, without)),
        }));
        uses
    }
}

/// A0 Ω at `hz`, m/s.
fn peak_speed(amplitude_m: f64, hz: f64) -> f64 {
    amplitude_m * TAU * hz
}
