//! Tables: the row that `simulate`, `sweep` and `pick` share, and rows of any kind as CSV or Parquet, and back from CSV.

mod columns;
mod parquet;
mod read;

use serde::Serialize;
use shared::model::params::RigParams;

pub use self::parquet::to_parquet;
pub use self::read::{Line, read_columns};
use crate::engine::Observation;

/// One run, as told to people and programs. Units are in the names.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// Name of the rig.
    pub rig: String,
    /// Clearance at rest, mm.
    pub gap_mm: f64,
    /// Drive frequency Ω/2π, Hz.
    pub frequency_hz: f64,
    /// Ω/ω.
    pub frequency_ratio: f64,
    /// p: contacts in n periods; when nothing repeats, in the last 16 recorded periods.
    pub impacts: u16,
    /// n; none when the section does not repeat, or nothing touches.
    pub periods: Option<u8>,
    /// "p/n", "none", "aperiodic" or "chatter".
    pub regime: String,
    /// Largest contact force in the recorded cycles over m g.
    pub force_ratio: f64,
    /// The same, N.
    pub force_n: f64,
    /// Approach speed of the strongest contact, m/s.
    pub approach_speed_m_per_s: Option<f64>,
    /// Duration of the strongest contact, ms.
    pub contact_time_ms: Option<f64>,
}

impl Row {
    /// From what a run showed.
    pub fn new(rig: &str, params: &RigParams, seen: &Observation) -> Self {
        Self {
            rig: rig.to_owned(),
            gap_mm: tidy(params.gap_m * 1e3),
            frequency_hz: tidy(seen.frequency_hz),
            frequency_ratio: tidy(seen.frequency_hz / params.natural_frequency_hz()),
            impacts: seen.regime.impacts(),
            periods: seen.regime.periods(),
            regime: seen.regime.to_string(),
            force_ratio: seen.force_n / params.weight_n(),
            force_n: seen.force_n,
            approach_speed_m_per_s: seen.strongest.map(|c| c.approach_speed_m_per_s),
            contact_time_ms: seen.strongest.map(|c| c.duration_s * 1e3),
        }
    }
}

/// Rows as CSV with a header line.
pub fn to_csv<T: Serialize>(rows: &[T]) -> Vec<u8> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    for row in rows {
        writer
            .serialize(row)
            .expect("a row of plain values always serialises");
    }
    writer.into_inner().expect("writing to memory cannot fail")
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
