//! Where the rate of penetration is largest, and what that is worth to know.

use serde::Serialize;
use shared::model::regime::Regime;
use shared::model::slider::Slider;

use super::blow::Feed;
use super::orbit;
use super::run::{DrillPlan, DrillRow, DrillSetting, run};
use crate::error::Error;
use crate::limits::PickLimits;
use crate::parallel;
use crate::pick::pick;
use crate::progress::{Progress, WithinStep, check};
use crate::root::maximum;
use crate::row::CartModel;
use crate::row::{NamedRig, regime_as_text, tidy};
use crate::sweep::spread;

/// The best frequency is searched to this share of the natural frequency.
const RESOLUTION: f64 = 2e-4;

/// A corner's own best is sought within this share of the nominal best frequency, first at so many points.
const NEAR: f64 = 0.12;
const NEAR_POINTS: usize = 13;

/// How far the ground is unknown.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct GroundUncertainty {
    /// Pf, % either way.
    pub threshold_percent: f64,
    /// k, % either way.
    pub ground_stiffness_percent: f64,
}

/// A corner of the uncertainty.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Corner {
    /// Threshold force Pf of the ground in this corner, N.
    pub threshold_n: f64,
    /// Stiffness k of the ground in this corner, N/m.
    pub ground_stiffness_n_per_m: f64,
    /// What it drills at the nominal best frequency, µm/s.
    pub rate_at_nominal_um_per_s: f64,
    /// Regime of this corner at the nominal best frequency.
    #[serde(serialize_with = "regime_as_text")]
    pub regime_at_nominal: Regime,
    /// Its own best Ω/ω, within 12 % of the nominal.
    pub best_frequency_ratio: f64,
    /// What it drills there, µm/s.
    pub best_rate_um_per_s: f64,
}

/// The answer at one gap.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DrillAnswer {
    /// Clearance at rest, mm.
    pub gap_mm: f64,
    /// Where the rate of penetration is largest with one blow in each drive period (with any motion, where there is no
    /// such).
    pub best: DrillRow,
    /// Largest modulus of a multiplier there, where the motion is a 1/1.
    pub multiplier: Option<f64>,
    /// The frequency that `pick` gives for a surface that stays (nominal, the same cart), Hz. None where it has no answer.
    pub rigid_frequency_hz: Option<f64>,
    /// The frequency that `pick` gives for a surface that stays, over the natural frequency.
    pub rigid_frequency_ratio: Option<f64>,
    /// Contact force there on the surface that stays, N.
    pub rigid_force_n: Option<f64>,
    /// Rate of penetration there, µm/s.
    pub rigid_rate_um_per_s: Option<f64>,
    /// Rate of penetration at the frequency that `pick` gives, over the largest of this answer.
    pub rigid_share: Option<f64>,
    /// Ω/ω of the first and last frequency of the range at which the contact force reaches the threshold.
    pub threshold_reached_ratios: Option<(f64, f64)>,
    /// Corners of the uncertainty.
    pub corners: Vec<Corner>,
    /// How the cart is moved in this answer.
    pub cart: CartModel,
    /// The largest rate of penetration with a cart that recoils, µm/s: of this answer, or near its frequency. None where no
    /// shaker is known.
    pub recoil_rate_um_per_s: Option<f64>,
    /// The frequency of that, Hz.
    pub recoil_frequency_hz: Option<f64>,
    /// The largest rate of penetration with the cart as prescribed, µm/s: of this answer, or near its frequency.
    pub prescribed_rate_um_per_s: Option<f64>,
    /// The frequency of that, Hz.
    pub prescribed_frequency_hz: Option<f64>,
    /// With a bit: the largest rate of penetration near this frequency without it, µm/s.
    pub without_bit_rate_um_per_s: Option<f64>,
    /// The frequency of that, Hz.
    pub without_bit_frequency_hz: Option<f64>,
}

/// Runs of a rig on the ground, for a search among them.
#[derive(Clone, Copy, Debug)]
pub struct DrillRuns<'a> {
    /// The hammer, its cart and its gap.
    pub rig: &'a NamedRig,
    /// Ground, bit and feed.
    pub setting: DrillSetting,
    /// How long the runs are.
    pub plan: DrillPlan,
}

impl DrillRuns<'_> {
    /// The answer at the gap of the rig. `rows` are its runs over frequency, rising: the best is searched around the best of
    /// them. A step of the progress is a corner.
    ///
    /// # Errors
    /// If a parameter is out of range, a motion cannot be followed, or the work is interrupted. [`Error::NoProgress`] if no row
    /// makes progress.
    pub fn advise(
        &self,
        rows: &[DrillRow],
        uncertainty: Option<GroundUncertainty>,
        progress: &dyn Progress,
    ) -> Result<DrillAnswer, Error> {
        let (rig, setting) = (self.rig, self.setting);
        let with = |setting: DrillSetting| DrillRuns { setting, ..*self };
        let among = match Among::OneOne.best(rows) {
            Some(_) => Among::OneOne,
            None => Among::All,
        };
        let best = self.refined(rows, among)?;
        check(progress)?;
        let natural_hz = rig.params.natural_frequency_hz();
        let multiplier = self.multiplier(&best);
        let rigid = pick(rig, None, PickLimits::default(), &WithinStep(progress)).ok();
        let rigid_hz = rigid.as_ref().map(|p| p.answer.operating_frequency_hz);
        let rigid_row = rigid_hz.map(|hz| self.at(hz)).transpose()?;
        let near = spread(
            (1.0 - NEAR) * best.frequency_hz,
            (1.0 + NEAR) * best.frequency_hz,
            NEAR_POINTS,
        );
        let corners = uncertainty.map_or(Vec::new(), |u| grounds(&setting.ground, u));
        let corners = parallel::try_map(&corners, |ground| {
            let ground = *ground;
            let there = with(DrillSetting { ground, ..setting });
            let corner = there.corner(best.frequency_hz, (&near, among))?;
            crate::progress::step(progress, 1)?;
            Ok(corner)
        })?;
        let cart = CartModel::of(&rig.params);
        let numbers = |row: &DrillRow| (row.rate_of_penetration_um_per_s, row.frequency_hz);
        let other = match &rig.with_the_other_cart() {
            Some(rig) => DrillRuns { rig, ..*self }.best_near((&near, among))?,
            None => None,
        };
        let [recoil, prescribed] = cart.sorted(Some(numbers(&best)), other.as_ref().map(numbers));
        let bare = with(DrillSetting {
            bit: None,
            ..setting
        });
        let without_bit = match setting.bit {
            None => None,
            Some(_) => bare.best_near((&near, among))?,
        };
        let reached = |r: &&DrillRow| r.ground_force_n >= (1.0 - 1e-9) * r.threshold_n;
        let first = rows.iter().find(reached);
        let last = rows.iter().rev().find(reached);
        let rate = |row: &DrillRow| row.rate_of_penetration_um_per_s;
        let rigid_rate = rigid_row.as_ref().map(rate);
        Ok(DrillAnswer {
            gap_mm: best.gap_mm,
            multiplier,
            rigid_frequency_hz: rigid_hz,
            rigid_frequency_ratio: rigid_hz.map(|hz| hz / natural_hz),
            rigid_force_n: rigid.as_ref().map(|p| p.answer.force_n),
            rigid_rate_um_per_s: rigid_rate,
            rigid_share: rigid_rate.map(|own| own / rate(&best)),
            threshold_reached_ratios: first
                .zip(last)
                .map(|(a, b)| (a.frequency_ratio, b.frequency_ratio)),
            corners,
            cart,
            recoil_rate_um_per_s: recoil.map(|r| r.0),
            recoil_frequency_hz: recoil.map(|r| r.1),
            prescribed_rate_um_per_s: prescribed.map(|r| r.0),
            prescribed_frequency_hz: prescribed.map(|r| r.1),
            without_bit_rate_um_per_s: without_bit.as_ref().map(rate),
            without_bit_frequency_hz: without_bit.as_ref().map(|b| b.frequency_hz),
            best,
        })
    }

    fn at(&self, frequency_hz: f64) -> Result<DrillRow, Error> {
        let (rig, setting) = (self.rig, &self.setting);
        let seen = run(&rig.params, setting, frequency_hz, self.plan)?;
        Ok(DrillRow::new(rig, setting, frequency_hz, &seen))
    }

    /// The best of `rows` (runs over frequency, rising) among those that count, refined between its neighbours.
    ///
    /// # Errors
    /// [`Error::NoProgress`] if no such row makes progress; else as [`run`].
    pub fn refined(&self, rows: &[DrillRow], among: Among) -> Result<DrillRow, Error> {
        let Some(index) = among.best(rows) else {
            return Err(Error::NoProgress {
                threshold_n: self.setting.ground.threshold,
            });
        };
        let low = rows[index.saturating_sub(1)].frequency_hz;
        let high = rows[(index + 1).min(rows.len() - 1)].frequency_hz;
        let here = &rows[index];
        let tolerance = RESOLUTION * self.rig.params.natural_frequency_hz();
        if high - low <= tolerance {
            return Ok(here.clone());
        }
        let found = |hz: f64| self.at(hz).map_or(f64::NEG_INFINITY, |r| among.rate(&r));
        let hz = maximum(found, (low, high), tolerance, here.frequency_hz);
        let top = self.at(tidy(hz))?;
        // Where it is not smooth, the search between the neighbours may end lower than it began.
        Ok(if among.rate(&top) > among.rate(here) {
            top
        } else {
            here.clone()
        })
    }

    /// Largest modulus of a multiplier of the 1/1 that the run at `best` settled on.
    fn multiplier(&self, best: &DrillRow) -> Option<f64> {
        // Where the gap sets itself, the section has a coordinate more.
        if !best.regime.is(1, 1) || matches!(self.setting.feed, Feed::Speed(_)) {
            return None;
        }
        let seen = run(
            &self.rig.params,
            &self.setting,
            best.frequency_hz,
            self.plan,
        )
        .ok()?;
        let (params, setting) = (&self.rig.params, &self.setting);
        let orbit = orbit::shoot(params, setting, best.frequency_hz, seen.guess())?;
        Some(orbit.multipliers().modulus())
    }

    /// The best near `near_hz`. None where nothing gives way.
    fn best_near(&self, (near_hz, among): (&[f64], Among)) -> Result<Option<DrillRow>, Error> {
        let rows = parallel::try_map(near_hz, |hz| self.at(*hz))?;
        Ok(self.refined(&rows, among).ok())
    }

    fn corner(&self, nominal_hz: f64, near: (&[f64], Among)) -> Result<Corner, Error> {
        let here = self.at(nominal_hz)?;
        let rate = |row: &DrillRow| row.rate_of_penetration_um_per_s;
        let better = self
            .best_near(near)?
            .filter(|best| rate(best) > rate(&here));
        let best = better.as_ref().unwrap_or(&here);
        Ok(Corner {
            threshold_n: self.setting.ground.threshold,
            ground_stiffness_n_per_m: self.setting.ground.stiffness,
            rate_at_nominal_um_per_s: here.rate_of_penetration_um_per_s,
            regime_at_nominal: here.regime,
            best_frequency_ratio: best.frequency_ratio,
            best_rate_um_per_s: best.rate_of_penetration_um_per_s,
        })
    }
}

/// Which motions count in the search for the best rate of penetration.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Among {
    /// One blow in each drive period, the motion that is recommended.
    OneOne,
    /// Every motion, whatever its regime.
    All,
}

impl Among {
    /// Rate of penetration of a row that counts.
    fn rate(self, row: &DrillRow) -> f64 {
        if self == Self::All || row.regime.is(1, 1) {
            row.rate_of_penetration_um_per_s
        } else {
            f64::NEG_INFINITY
        }
    }

    /// The row with the largest rate that counts, if it makes progress, and its index.
    pub fn best(self, rows: &[DrillRow]) -> Option<usize> {
        let all = 0..rows.len();
        let best = all.max_by(|a, b| self.rate(&rows[*a]).total_cmp(&self.rate(&rows[*b])));
        best.filter(|i| self.rate(&rows[*i]) > 0.0)
    }
}

/// The corners of Pf and k. The dashpot goes with the spring: its time constant c/k stays.
fn grounds(nominal: &Slider<f64>, u: GroundUncertainty) -> Vec<Slider<f64>> {
    let both = |percent: f64| {
        let share = 0.01 * percent;
        if share > 0.0 {
            vec![1.0 - share, 1.0 + share]
        } else {
            vec![1.0]
        }
    };
    let mut found = Vec::new();
    for by in both(u.threshold_percent) {
        for stiffer in both(u.ground_stiffness_percent) {
            found.push(Slider {
                stiffness: nominal.stiffness * stiffer,
                damping: nominal.damping * stiffer,
                threshold: nominal.threshold * by,
            });
        }
    }
    found
}
