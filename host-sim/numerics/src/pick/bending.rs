//! What the higher bending modes of beam springs change about a pick.
//!
//! The lumped rig has the springs' first mode alone. Each contact rings the others, too, and where a multiple of the drive
//! frequency meets the second mode, the ringing builds up from contact to contact and the force falls. So a pick on beams
//! is made in two steps: the lumped rig says where 1/1 is stable and within the limits, for every rig of the uncertainty; in
//! there the rig with several modes, in the same cart, says how strong it is, and from where to where its force holds.

use std::f64::consts::TAU;
use std::ops::RangeInclusive;

use serde::Serialize;
use shared::model::params::{RigParams, SupportParams};

use super::BAND_SHARE;
use crate::error::Error;
use crate::modes::linear::{LinearMotion, ModalOrbit};
use crate::modes::{Beam, TipJoint};
use crate::parallel;
use crate::progress::{Progress, check};
use crate::sweep::spread;
use crate::uncertainty::Member;

/// Modes that the force is compared with: a sixth to an eighth change it by less than 0.1 %.
const MOST_MODES: usize = 5;
/// A mode that changes no force in the band by more than this share is left out.
const MATTERS: f64 = 0.01;
/// The lumped choice is kept where the modes leave it this share of their own best.
const KEPT: f64 = 0.99;
/// Frequencies in the band.
const FREQUENCIES: usize = 61;
/// Masses of the springs over their uncertainty, beside the nominal one.
const MASSES: usize = 8;
/// Halvings between two frequencies of the band.
const HALVINGS: u32 = 10;
/// Steps of a low-discrepancy sequence: the golden ratio's.
const GOLDEN: f64 = 0.618_033_988_749_894_9;

/// The beam springs, of which the chapter gives no mass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Springs {
    /// How they are held, and their mass over the hammer's.
    pub beam: Beam,
    /// Uncertainty of that mass, % either way.
    pub mass_percent: f64,
}

impl Default for Springs {
    /// Two steel strips of 20 by 0.5 mm and 170 mm length, known to a fifth (docs/beam-modes.md).
    fn default() -> Self {
        Self {
            beam: Beam {
                tip: TipJoint::Guided,
                mass_ratio: 0.1,
            },
            mass_percent: 20.0,
        }
    }
}

impl Springs {
    /// With their mass off by the share `deviation` (−1 to 1) of its uncertainty.
    fn off(&self, deviation: f64) -> Beam {
        Beam {
            mass_ratio: self.beam.mass_ratio * (1.0 + 0.01 * self.mass_percent * deviation),
            ..self.beam
        }
    }
}

/// What the modes change. Nothing is there for wires, nor where the modes cannot be computed: for another contact law than
/// the spring-dashpot, or a cubic stiffness.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Bending {
    /// Whether the hammer is on beam springs.
    #[serde(skip)]
    pub on_beams: bool,
    /// Bending modes that the answer is made with: those that change the force in the band by more than 1 %.
    pub modes: Option<usize>,
    /// Mass of the springs over the hammer's, assumed.
    pub springs_mass_ratio: Option<f64>,
    /// Its uncertainty, % either way; none if the parameters are exact.
    pub springs_mass_percent: Option<f64>,
    /// Frequency of the second mode, Hz.
    pub second_mode_hz: Option<f64>,
    /// Force ratio at the operating frequency with these modes.
    pub modes_force_ratio: Option<f64>,
    /// Smallest force ratio there over the uncertainty, the springs' mass included.
    pub modes_force_ratio_worst: Option<f64>,
    /// Largest force ratio at the operating frequency over the uncertainty, the springs' mass included.
    pub modes_force_ratio_largest: Option<f64>,
    /// Largest modulus of a multiplier there over the uncertainty.
    pub modes_multipliers_worst: Option<f64>,
    /// Rigs within the uncertainty that were computed there with these modes.
    pub modes_rigs: Option<usize>,
    /// How many of them have a stable 1/1.
    pub modes_rigs_one_one: Option<usize>,
    /// The frequency that one mode alone would choose, Hz.
    pub one_mode_frequency_hz: Option<f64>,
    /// The safe band of one mode alone, Hz.
    pub one_mode_safe_band_hz: Option<[f64; 2]>,
    /// Smallest force in that band with these modes and nominal springs, over that at the operating frequency; 0 where 1/1
    /// is lost.
    pub one_mode_safe_band_force_share: Option<f64>,
    /// Where in that band a multiple of the drive frequency meets the second mode, Hz.
    pub modes_weak_hz: Option<Vec<f64>>,
    /// Smallest force in the safe band over the uncertainty of the springs' mass, over that at the operating frequency; 0
    /// where 1/1 is lost.
    pub safe_band_force_share_any_springs: Option<f64>,
}

/// A pick made with one mode, to be checked with more of them.
#[derive(Clone, Copy)]
pub struct BendingRequest<'a> {
    /// Parameters of the nominal rig.
    pub params: &'a RigParams,
    /// Its beam springs, and how far their mass is uncertain.
    pub springs: Springs,
    /// The rigs of the uncertainty; none if the parameters are exact.
    pub members: &'a [Member],
    /// How many of them, the first, are corners.
    pub corners: usize,
    /// The frequency that one mode alone chooses, Hz.
    pub chosen_hz: f64,
    /// Its safe band, Hz.
    pub band_hz: (f64, f64),
    /// Where the choice may lie, Hz.
    pub kept_hz: (f64, f64),
    /// Largest contact force allowed, N.
    pub max_force_n: Option<f64>,
}

/// What the modes say.
#[derive(Clone, Debug, PartialEq)]
pub struct Bent {
    /// What the modes change, for the answer.
    pub bending: Bending,
    /// The frequency to run at, Hz.
    pub chosen_hz: f64,
    /// About it, the part of the band in which the force holds with the modes, Hz.
    pub band_hz: (f64, f64),
}

/// A rig with so many modes: its force and 1/1 at any frequency.
#[derive(Clone, Copy)]
struct Modal<'a> {
    params: &'a RigParams,
    beam: Beam,
    modes: usize,
}

impl Modal<'_> {
    fn at(&self, hz: f64, near: Option<&ModalOrbit>) -> Option<ModalOrbit> {
        let motion = LinearMotion::of(self.params, self.beam, self.modes, hz).ok()?;
        motion.orbit(near)
    }

    /// Along `frequencies_hz`, each from the last; None where there is no stable 1/1.
    fn along(&self, frequencies_hz: &[f64], near: Option<&ModalOrbit>) -> Vec<Option<ModalOrbit>> {
        let mut last = near.cloned();
        let each = frequencies_hz.iter().map(|hz| {
            let found = self.at(*hz, last.as_ref());
            if found.is_some() {
                last.clone_from(&found);
            }
            found
        });
        each.collect()
    }
}

fn force(orbit: Option<&ModalOrbit>) -> f64 {
    orbit.map_or(0.0, |orbit| orbit.force_n)
}

impl BendingRequest<'_> {
    /// What the modes say. None for wires and where they cannot be computed, or have no stable 1/1 anywhere in the band.
    ///
    /// # Errors
    /// If the work is interrupted.
    pub fn run(&self, progress: &dyn Progress) -> Result<Option<Bent>, Error> {
        let beam = self.springs.beam;
        if !on_beams(self.params)
            || LinearMotion::of(self.params, beam, MOST_MODES, self.chosen_hz).is_err()
        {
            return Ok(None);
        }
        let natural_hz = self.params.natural_frequency_hz();
        let second_hz = beam.modes(self.params.mass_kg, natural_hz, 2)?[1].omega / TAU;
        let (low, high) = self.band_hz;
        let grid = spread(low, high, FREQUENCIES);
        let counts: Vec<usize> = (1..=MOST_MODES).collect();
        let curves = parallel::map(&counts, |modes| self.with(*modes).along(&grid, None));
        check(progress)?;
        let modes = needed(&curves);
        let (modal, curve) = (self.with(modes), &curves[modes - 1]);
        let Some((chosen_hz, chosen)) = self.choose(modal, &grid, curve) else {
            return Ok(None);
        };
        let band_hz = self.holding(modal, (&grid, curve), &chosen);
        let weight = self.params.weight_n();
        let share = |orbit: &Option<ModalOrbit>| force(orbit.as_ref()) / chosen.force_n;
        let least = |curve: &[Option<ModalOrbit>]| curve.iter().map(share).fold(1.0, f64::min);
        let (over, rigs) = self.over_the_uncertainty(modal, &chosen);
        check(progress)?;
        let any_springs = self.any_springs(modal, band_hz, &chosen);
        check(progress)?;
        let uncertain = !self.members.is_empty();
        let bending = Bending {
            on_beams: true,
            modes: Some(modes),
            springs_mass_ratio: Some(beam.mass_ratio),
            springs_mass_percent: uncertain.then_some(self.springs.mass_percent),
            second_mode_hz: Some(second_hz),
            modes_force_ratio: Some(chosen.force_n / weight),
            modes_force_ratio_worst: Some(over.force_n[0] / weight),
            modes_force_ratio_largest: Some(over.force_n[1] / weight),
            modes_multipliers_worst: Some(over.multiplier),
            modes_rigs: Some(rigs),
            modes_rigs_one_one: Some(over.one_one),
            one_mode_frequency_hz: Some(self.chosen_hz),
            one_mode_safe_band_hz: Some([low, high]),
            one_mode_safe_band_force_share: Some(least(curve)),
            modes_weak_hz: Some(meeting(second_hz, low..=high)),
            safe_band_force_share_any_springs: uncertain.then(|| least(&any_springs)),
        };
        Ok(Some(Bent {
            bending,
            chosen_hz,
            band_hz,
        }))
    }

    fn with(&self, modes: usize) -> Modal<'_> {
        Modal {
            params: self.params,
            beam: self.springs.beam,
            modes,
        }
    }

    /// The lumped choice, if the modes leave it nearly their best; else the frequency of their best.
    fn choose(
        &self,
        modal: Modal,
        grid: &[f64],
        curve: &[Option<ModalOrbit>],
    ) -> Option<(f64, ModalOrbit)> {
        let allowed = |orbit: &&ModalOrbit| self.max_force_n.is_none_or(|n| orbit.force_n <= n);
        let (low, high) = self.kept_hz;
        let found = curve.iter().flatten().filter(allowed);
        let found = found.filter(|orbit| (low..=high).contains(&orbit.frequency_hz));
        let best = found.reduce(|a, b| if b.force_n > a.force_n { b } else { a });
        let enough = best.map_or(0.0, |best| KEPT * best.force_n);
        let nearest = grid
            .iter()
            .zip(curve)
            .filter_map(|(hz, orbit)| Some(((hz - self.chosen_hz).abs(), orbit.as_ref()?)))
            .min_by(|a, b| a.0.total_cmp(&b.0))?
            .1;
        let kept = modal
            .at(self.chosen_hz, Some(nearest))
            .filter(|orbit| allowed(&orbit) && orbit.force_n >= enough);
        match kept {
            Some(orbit) => Some((self.chosen_hz, orbit)),
            None => best.map(|best| (best.frequency_hz, best.clone())),
        }
    }

    /// The part of the band about `chosen` in which 1/1 is stable and the force above [`BAND_SHARE`] of its own.
    fn holding(
        &self,
        modal: Modal,
        (grid, curve): (&[f64], &[Option<ModalOrbit>]),
        chosen: &ModalOrbit,
    ) -> (f64, f64) {
        let holds = |orbit: Option<&ModalOrbit>| force(orbit) >= BAND_SHARE * chosen.force_n;
        let walk = |points: Vec<(&f64, &Option<ModalOrbit>)>| {
            let mut last = chosen.clone();
            for (hz, orbit) in points {
                if let Some(orbit) = orbit.as_ref().filter(|orbit| holds(Some(orbit))) {
                    last = orbit.clone();
                    continue;
                }
                let mut outside = *hz;
                for _ in 0..HALVINGS {
                    let middle = 0.5 * (last.frequency_hz + outside);
                    match modal.at(middle, Some(&last)) {
                        Some(orbit) if holds(Some(&orbit)) => last = orbit,
                        _ => outside = middle,
                    }
                }
                break;
            }
            last.frequency_hz
        };
        let points = || grid.iter().zip(curve);
        let above = points().filter(|(hz, _)| **hz > chosen.frequency_hz);
        let below = points().filter(|(hz, _)| **hz < chosen.frequency_hz);
        (walk(below.rev().collect()), walk(above.collect()))
    }

    /// Every rig of the uncertainty with springs of other masses, at the frequency of `chosen`: the corners with the
    /// lightest, nominal and heaviest springs, the others with masses spread evenly. Of exact parameters, the nominal one.
    fn over_the_uncertainty(&self, modal: Modal, chosen: &ModalOrbit) -> (Over, usize) {
        let (corners, inside) = self.members.split_at(self.corners);
        let at_corners = corners
            .iter()
            .flat_map(|member| [-1.0, 0.0, 1.0].map(|deviation| (member, deviation)));
        let others = inside.iter().enumerate().map(|(i, member)| {
            let turn = (i as f64 * GOLDEN).fract();
            (member, 2.0 * turn - 1.0)
        });
        let rigs: Vec<_> = at_corners.chain(others).collect();
        let each = parallel::map(&rigs, |(member, deviation)| {
            let params = member.apply(self.params, 1.0);
            let rig = Modal {
                params: &params,
                beam: self.springs.off(*deviation),
                ..modal
            };
            Over::of(rig.at(chosen.frequency_hz, Some(chosen)).as_ref())
        });
        let nominal = Over::of(Some(chosen));
        let all = each.into_iter().fold(nominal, Over::with);
        (all, rigs.len() + 1)
    }

    /// The nominal rig in `band_hz` with springs of every mass of their uncertainty.
    fn any_springs(
        &self,
        modal: Modal,
        (low, high): (f64, f64),
        chosen: &ModalOrbit,
    ) -> Vec<Option<ModalOrbit>> {
        if self.members.is_empty() {
            return Vec::new();
        }
        let grid = spread(low, high, FREQUENCIES);
        let masses: Vec<usize> = (0..=MASSES).collect();
        let each = parallel::map(&masses, |k| {
            let rig = Modal {
                beam: self.springs.off(2.0 * *k as f64 / MASSES as f64 - 1.0),
                ..modal
            };
            rig.along(&grid, Some(chosen))
        });
        each.concat()
    }
}

/// Whether `params` hangs on beam springs.
pub fn on_beams(params: &RigParams) -> bool {
    matches!(params.support, SupportParams::Beams { .. })
}

/// How many modes it takes for forces within [`MATTERS`] of those of the most modes, by the curves of 1, 2, 3 ... modes.
fn needed(curves: &[Vec<Option<ModalOrbit>>]) -> usize {
    let most = &curves[curves.len() - 1];
    let near = |curve: &[Option<ModalOrbit>]| {
        curve.iter().zip(most).all(|pair| match pair {
            (Some(a), Some(b)) => (a.force_n / b.force_n - 1.0).abs() <= MATTERS,
            (None, None) => true,
            _ => false,
        })
    };
    curves
        .iter()
        .position(|curve| near(curve))
        .map_or(curves.len(), |i| i + 1)
}

/// The frequencies in `band` of which a multiple is `mode_hz`, rising.
fn meeting(mode_hz: f64, band: RangeInclusive<f64>) -> Vec<f64> {
    let (first, last) = (mode_hz / band.end(), mode_hz / band.start());
    let multiples = (first.ceil() as u32..=last.floor() as u32).rev();
    multiples.map(|k| mode_hz / f64::from(k)).collect()
}

/// What rigs have in common.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Over {
    /// Smallest and largest force of those with a stable 1/1, N.
    force_n: [f64; 2],
    multiplier: f64,
    one_one: usize,
}

impl Over {
    fn of(orbit: Option<&ModalOrbit>) -> Self {
        let lost = Self {
            force_n: [f64::INFINITY, 0.0],
            multiplier: 0.0,
            one_one: 0,
        };
        orbit.map_or(lost, |orbit| Self {
            force_n: [orbit.force_n; 2],
            multiplier: orbit.multiplier,
            one_one: 1,
        })
    }

    fn with(self, other: Self) -> Self {
        Self {
            force_n: [
                self.force_n[0].min(other.force_n[0]),
                self.force_n[1].max(other.force_n[1]),
            ],
            multiplier: self.multiplier.max(other.multiplier),
            one_one: self.one_one + other.one_one,
        }
    }
}

#[cfg(test)]
mod tests;
