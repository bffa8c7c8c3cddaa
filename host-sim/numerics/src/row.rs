//! One run as a row of a table, and numbers without the noise of a unit conversion.

use std::fmt;

use serde::{Serialize, Serializer};
use shared::model::cart::{CartDrive, LoopParams};
use shared::model::params::{PRESETS, RigParams, preset};
use shared::model::regime::Regime;

use crate::engine::Observation;
use crate::error::{Error, MotionError, PickError};
use crate::lanes::CellOutcome;
use crate::uncertainty::Stated;

/// How the cart is moved.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum CartModel {
    /// As prescribed: the chapter's model.
    Prescribed,
    /// By a shaker, recoiling from the contacts.
    Recoil,
}

impl CartModel {
    /// How the cart of `params` is moved.
    pub fn of(params: &RigParams) -> Self {
        if params.cart.recoils() {
            Self::Recoil
        } else {
            Self::Prescribed
        }
    }

    /// What was found with a cart moved so and with the other one, in the order: recoiling, prescribed.
    pub(crate) fn sorted<T>(self, own: T, other: T) -> [T; 2] {
        match self {
            Self::Recoil => [own, other],
            Self::Prescribed => [other, own],
        }
    }

    /// What a heading says of it.
    pub fn words(self) -> &'static str {
        match self {
            Self::Prescribed => "cart prescribed",
            Self::Recoil => "cart recoils",
        }
    }
}

/// A rig and its name.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedRig {
    /// The preset's name, or the stem of the file the rig was read from; in brackets what is set over it.
    pub name: String,
    /// Its parameters, with the cart as it is computed with.
    pub params: RigParams,
    /// The shaker that moves its cart, if one is known.
    pub shaker: Option<LoopParams>,
    /// What was set over the preset or the file it was read from, `key=value`.
    pub overridden: Vec<String>,
    /// What its file states of its uncertainty.
    pub stated: Stated,
    /// Whether its file, or what is set over it, states the shaker's largest force: else it is that of the preset, assumed.
    pub shaker_force_told: bool,
}

impl NamedRig {
    /// A rig called `name`, whose shaker is the one its cart is computed with, if any.
    pub fn new(name: impl Into<String>, params: RigParams) -> Self {
        let shaker = match params.cart {
            CartDrive::Prescribed => None,
            CartDrive::Loop(held) => Some(held),
        };
        Self {
            name: name.into(),
            params,
            shaker,
            overridden: Vec::new(),
            stated: Stated::default(),
            shaker_force_told: false,
        }
    }

    /// This rig with its cart moved as prescribed.
    #[must_use]
    pub fn prescribed(mut self) -> Self {
        self.params.cart = CartDrive::Prescribed;
        self
    }

    /// This rig with a cart that recoils under its shaker. `None` if no shaker is known.
    pub fn recoiling(&self) -> Option<Self> {
        let mut rig = self.clone();
        rig.params.cart = CartDrive::Loop(self.shaker?);
        Some(rig)
    }

    /// This rig with its cart moved the other way. `None` if no shaker is known.
    pub fn with_the_other_cart(&self) -> Option<Self> {
        if self.params.cart.recoils() {
            Some(self.clone().prescribed())
        } else {
            self.recoiling()
        }
    }

    /// The preset `name`.
    ///
    /// # Errors
    /// [`Error::Preset`] if there is none of this name.
    pub fn preset(name: &str) -> Result<Self, Error> {
        let params = preset(name).ok_or_else(|| Error::Preset(name.to_owned()))?;
        Ok(Self::new(name, params))
    }

    /// All four, in their order.
    pub fn presets() -> Vec<Self> {
        PRESETS.map(|(name, params)| Self::new(name, params)).into()
    }

    /// The error that says why this rig has no operating point.
    pub fn no_pick(&self, what: PickError) -> Error {
        Error::Pick {
            rig: self.name.clone(),
            what,
        }
    }
}

/// One run. Units are in the names. As tables have it, nothing is known of a run that failed.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RunRow {
    /// Name of the rig.
    pub rig: String,
    /// Clearance at rest, mm.
    pub gap_mm: f64,
    /// How the cart is moved.
    pub cart: CartModel,
    /// Drive frequency Ω/2π, Hz.
    pub frequency_hz: f64,
    /// Drive frequency over the natural frequency, Ω/ω.
    pub frequency_ratio: f64,
    /// p: contacts in n periods; when nothing repeats, in the last 16 recorded periods.
    pub impacts: Option<u16>,
    /// n; none when the section does not repeat, or nothing touches.
    pub periods: Option<u8>,
    /// Of a run that failed it is not known.
    #[serde(skip)]
    pub regime: Regime,
    /// The regime as tables have it, unless the motion still changes or the run failed.
    #[serde(rename = "regime")]
    pub outcome: Outcome,
    /// Largest contact force in the recorded cycles over m g.
    #[serde(serialize_with = "if_a_number")]
    pub force_ratio: f64,
    /// Largest contact force in the recorded cycles, N.
    #[serde(serialize_with = "if_a_number")]
    pub force_n: f64,
    /// Approach speed of the strongest contact, m/s.
    pub approach_speed_m_per_s: Option<f64>,
    /// Duration of the strongest contact, ms.
    pub contact_time_ms: Option<f64>,
    /// Whether the hammer could not be followed: its forces are then no numbers, and its regime is not known.
    #[serde(skip)]
    pub failed: bool,
    /// Why not, where that is known.
    #[serde(skip)]
    pub failure: Option<MotionError>,
}

/// What became of a run. As text "p/n", "none", "aperiodic", "chatter", "unsettled" or "failed".
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Outcome {
    /// The regime over the recorded cycles of a run that settled.
    Regime(Regime),
    /// The motion still changes.
    Unsettled,
    /// The hammer could not be followed.
    Failed,
}

impl Outcome {
    /// Of a run that showed `regime`, if it settled and did not fail.
    pub fn new(regime: Regime, unsettled: bool, failed: bool) -> Self {
        match (failed, unsettled) {
            (true, _) => Self::Failed,
            (false, true) => Self::Unsettled,
            (false, false) => Self::Regime(regime),
        }
    }
}

impl fmt::Display for Outcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Regime(regime) => f.pad(&regime.to_string()),
            Self::Unsettled => f.pad("unsettled"),
            Self::Failed => f.pad("failed"),
        }
    }
}

impl Serialize for Outcome {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl RunRow {
    /// The row of a run of the rig `rig` with `params`.
    pub fn new(rig: &str, params: &RigParams, seen: &Observation) -> Self {
        let shown = (seen.regime, seen.unsettled, seen.force_n);
        Self {
            approach_speed_m_per_s: seen.strongest.map(|c| c.approach_speed_m_per_s),
            contact_time_ms: seen.strongest.map(|c| c.duration_s * 1e3),
            ..Self::of(rig, params, seen.frequency_hz, shown)
        }
    }

    /// The row of a run in the lanes, which know no contact's speed and duration.
    pub(crate) fn of_cell(rig: &str, params: &RigParams, hz: f64, run: &CellOutcome) -> Self {
        Self::of(rig, params, hz, (run.regime, run.unsettled, run.force_n))
    }

    /// What every run shows at `hz`: its regime, whether that may pass, and its largest force, N.
    fn of(
        rig: &str,
        params: &RigParams,
        hz: f64,
        (regime, unsettled, force_n): (Regime, bool, f64),
    ) -> Self {
        Self {
            impacts: Some(regime.impacts()),
            periods: regime.periods(),
            regime,
            outcome: Outcome::new(regime, unsettled, false),
            force_ratio: force_n / params.weight_n(),
            force_n,
            failed: false,
            ..Self::failed(rig, params, hz)
        }
    }

    /// Whether what the regime calls the motion may pass: it still changes.
    pub fn unsettled(&self) -> bool {
        self.outcome == Outcome::Unsettled
    }

    /// The row of a run at `frequency_hz` whose hammer could not be followed.
    pub fn failed(rig: &str, params: &RigParams, frequency_hz: f64) -> Self {
        Self {
            rig: rig.to_owned(),
            gap_mm: tidy(params.gap_m * 1e3),
            cart: CartModel::of(params),
            frequency_hz: tidy(frequency_hz),
            frequency_ratio: tidy(frequency_hz / params.natural_frequency_hz()),
            impacts: None,
            periods: None,
            regime: Regime::None,
            outcome: Outcome::Failed,
            force_ratio: f64::NAN,
            force_n: f64::NAN,
            approach_speed_m_per_s: None,
            contact_time_ms: None,
            failed: true,
            failure: None,
        }
    }
}

fn if_a_number<S: Serializer>(x: &f64, serializer: S) -> Result<S::Ok, S::Error> {
    (!x.is_nan()).then_some(x).serialize(serializer)
}

/// Serialises a regime as its name in tables: "p/n", "none", "aperiodic" or "chatter".
///
/// # Errors
/// Those of the serializer.
pub fn regime_as_text<S: Serializer>(regime: &Regime, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_str(regime)
}

/// The regime without the numbers that its name does not say.
pub fn kind(regime: Regime) -> Regime {
    match regime {
        Regime::Aperiodic { .. } => Regime::Aperiodic { impacts: 0 },
        Regime::Chatter { .. } => Regime::Chatter {
            impacts: 0,
            periods: None,
        },
        other => other,
    }
}

/// `value` with `digits` significant digits, without an exponent.
pub fn significant(value: f64, digits: usize) -> String {
    if value == 0.0 || !value.is_finite() {
        return format!("{value}");
    }
    let place = digits as i32 - 1 - value.abs().log10().floor() as i32;
    if place >= 0 {
        return format!("{value:.*}", place as usize);
    }
    let scale = 10f64.powi(-place);
    format!("{:.0}", (value / scale).round() * scale)
}

/// Which of those of its kind the `i`-th of `all` is, from 1.
pub(crate) fn number<T, K: PartialEq>(all: &[T], i: usize, kind: impl Fn(&T) -> K) -> usize {
    let before = all[..i].iter().filter(|one| kind(one) == kind(&all[i]));
    1 + before.count()
}

/// The least and the largest of `values`: +∞ and −∞ of none.
pub(crate) fn extent(values: impl Iterator<Item = f64>) -> [f64; 2] {
    values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| {
        [low.min(x), high.max(x)]
    })
}

/// Removes the last-digit noise of a unit conversion, so that 2.4 mm prints as 2.4.
pub fn tidy(x: f64) -> f64 {
    let rounded = (x * 1e9).round() / 1e9;
    if (rounded - x).abs() <= 1e-12 * x.abs() {
        rounded
    } else {
        x
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn significant_digits_need_no_exponent() {
        for (value, digits, shown) in [
            (0.004_216, 2, "0.0042"),
            (3.676_7, 2, "3.7"),
            (86.94, 2, "87"),
            (1234.0, 2, "1200"),
            (0.0, 2, "0"),
        ] {
            assert_eq!(significant(value, digits), shown);
        }
    }
}
