//! A few named points: every stepper at every tick.

use shared::model::params::{RigParams, preset};
use shared::model::regime::Regime;

use numerics::engine::{Method, Plan, Precision, Setting, Start};
use numerics::{Error, parallel};

use crate::outcome::{SETTLING, real_frequency, settle, settle_reference};

/// A point with a name people know it by.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NamedPoint {
    /// Preset.
    pub rig: &'static str,
    /// Gap, mm.
    pub gap_mm: f64,
    /// Drive frequency over natural frequency.
    pub ratio: f64,
}

const fn point(rig: &'static str, gap_mm: f64, ratio: f64) -> NamedPoint {
    NamedPoint { rig, gap_mm, ratio }
}

/// The points: a 1/1 at a small and a large gap.
pub const POINTS: [NamedPoint; 2] = [point("wires", 0.0, 2.0), point("beam-135", 3.0, 1.3)];

/// The ticks, µs.
pub const TICKS_US: [f64; 6] = [5.0, 10.0, 20.0, 50.0, 100.0, 200.0];

const NARROW: Method = Method::Banded {
    eta_alpha_m: 5e-8,
    eta_beta_n: 1e-2,
};
const SMOOTHED: Method = Method::Smoothed {
    epsilon_alpha_m: 1e-7,
    epsilon_beta_n: 1.0,
};

/// The steppers compared.
pub const STEPPERS: [(Method, Precision); 3] = [
    (Method::Corrected, Precision::F32),
    (NARROW, Precision::F32),
    (SMOOTHED, Precision::F64),
];

/// Started from the settled reference, this long.
pub const PLAN: Plan = Plan {
    cycles: 120,
    transient: 80,
};

/// What one stepper made of one point at one tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepperCell {
    /// Error of the largest force relative to the reference's.
    pub force: f64,
    /// Error of the approach speed of the contact with that force.
    pub approach: f64,
    /// Whether the regime is the reference's.
    pub same_regime: bool,
}

/// A point's table: the reference's regime and force ratio, and a row of cells per stepper.
#[derive(Clone, Debug, PartialEq)]
pub struct PointTable {
    /// The point.
    pub point: NamedPoint,
    /// The reference's regime.
    pub regime: Regime,
    /// The reference's force over the hammer's weight.
    pub force_ratio: f64,
    /// Cells by stepper ([`STEPPERS`]) and tick ([`TICKS_US`]); `None` where the hammer left the model.
    pub rows: Vec<Vec<Option<StepperCell>>>,
}

impl NamedPoint {
    /// Its parameters.
    ///
    /// # Panics
    /// If the preset does not exist.
    pub fn params(&self) -> RigParams {
        RigParams {
            gap_m: self.gap_mm * 1e-3,
            ..preset(self.rig).expect("a preset's name")
        }
    }

    /// The drive frequency asked for, Hz.
    pub fn frequency_hz(&self) -> f64 {
        self.ratio * self.params().natural_frequency_hz()
    }

    /// Compares one setting, started where the reference settled, with the reference.
    pub fn cell(&self, setting: Setting, plan: Plan) -> Option<StepperCell> {
        let (params, asked) = (self.params(), self.frequency_hz());
        let real = real_frequency(setting, asked).ok()?;
        let truth = settle_reference(&params, real, Start::Rest, SETTLING).ok()?;
        let start = Start::Section(truth.section);
        let seen = settle(setting, &params, asked, start, plan).ok()?;
        Some(StepperCell {
            force: seen.force_error(&truth),
            approach: seen.approach_m_per_s / truth.approach_m_per_s - 1.0,
            same_regime: seen.regime == truth.regime,
        })
    }
}

/// Every stepper at every tick at one point.
///
/// # Errors
/// If a simulation fails, which none of the presets does.
pub fn table(point: NamedPoint) -> Result<PointTable, Error> {
    let settled = settle_reference(&point.params(), point.frequency_hz(), Start::Rest, SETTLING)?;
    let row = |&(method, precision): &(Method, Precision)| {
        let at = |tick_us: &f64| {
            let setting = Setting {
                method,
                precision,
                tick_s: tick_us * 1e-6,
            };
            point.cell(setting, PLAN)
        };
        parallel::map(&TICKS_US, at)
    };
    Ok(PointTable {
        point,
        regime: settled.regime,
        force_ratio: settled.force_n / point.params().weight_n(),
        rows: STEPPERS.iter().map(row).collect(),
    })
}
