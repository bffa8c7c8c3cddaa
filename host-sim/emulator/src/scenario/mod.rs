//! Scenarios: a true rig, what the controller believes, how long, and what happens when. In TOML.

mod builtin;
mod event;
mod file;

use std::path::Path;

use serde::Deserialize;
use shared::model::contact::Law;
use shared::model::params::RigParams;
use shared::settings::{Settings, TICK_S};

use super::sensors::SensorParams;
use super::shaker::ShakerParams;
use files::UserError;
use files::read_text;
use files::rigfile::nearest;

pub use builtin::BUILTIN;
pub use event::{Act, Fault, Mode, Timed};

/// Longest run, s: the tick counter of the controller wraps after 2.5 days.
const LONGEST_S: f64 = 2.0 * 86_400.0;

/// A scenario, checked.
#[derive(Clone, Debug, PartialEq)]
pub struct Scenario {
    /// Its name.
    pub name: String,
    /// What it is for, in a sentence.
    pub description: String,
    /// Rig time, s.
    pub duration_s: f64,
    /// Seed of the noise.
    pub seed: u64,
    /// Control ticks per block.
    pub block_ticks: usize,
    /// Slices of the forecast per block.
    pub slices_per_block: u32,
    /// How much longer a tick truly is than the controller believes, millionths.
    pub clock_ppm: f64,
    /// The rig as it truly is at the start.
    pub true_rig: RigParams,
    /// What the controller is told, the believed rig in it.
    pub settings: Settings,
    /// The shaker.
    pub shaker: ShakerParams,
    /// Whether the cart follows its set-point whatever force that takes.
    pub prescribed: bool,
    /// The sensors.
    pub sensors: SensorParams,
    /// What happens, by rising time.
    pub events: Vec<Timed>,
    /// What must come out.
    pub expect: Expect,
}

impl Scenario {
    /// True length of a tick, s.
    pub fn tick_s(&self) -> f64 {
        TICK_S * (1.0 + 1e-6 * self.clock_ppm)
    }

    /// Blocks of the run.
    pub fn blocks(&self) -> u64 {
        let ticks = self.duration_s / self.tick_s();
        (ticks / self.block_ticks as f64).round().max(1.0) as u64
    }
}

/// What must come out of a run. What is left out is not asked for, but for faults: those not named must not
/// trip.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Expect {
    /// State at the end, in lower case: `hold`.
    pub final_state: Option<String>,
    /// Names of the faults that trip, in their order.
    #[serde(default)]
    pub faults: Vec<String>,
    /// Smallest share of the optimum's force held.
    pub min_force_share: Option<f64>,
    /// Hold must be reached this soon after the first start, s.
    pub hold_within_s: Option<f64>,
    /// Basin at the end: `impact`, `no-impact`.
    pub basin: Option<String>,
    /// Fewest times the regime must be lost and sought again.
    pub min_reseeks: Option<u16>,
    /// Most ticks from a fault's condition to the drive being off.
    pub drive_off_within_ticks: Option<u64>,
}

/// A change of a rig: how the true one differs from the one its keys say, or what it drifts to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Change {
    /// Natural frequency, % more.
    pub natural_frequency_percent: f64,
    /// Contact stiffness, % more.
    pub contact_stiffness_percent: f64,
    /// Contact damping (ci, or λ), % more.
    pub contact_damping_percent: f64,
    /// Clearance, mm more.
    pub gap_offset_mm: f64,
}

impl Change {
    /// The keys, as `[true_rig]` may use them beside a rig's own.
    pub const KEYS: [&str; 4] = [
        "natural_frequency_percent",
        "contact_stiffness_percent",
        "contact_damping_percent",
        "gap_offset_mm",
    ];

    /// Refuses what leaves no rig.
    ///
    /// # Errors
    /// One line with the key and its range.
    pub fn check(&self) -> Result<(), UserError> {
        let values = [
            (self.natural_frequency_percent, (-90.0, 900.0)),
            (self.contact_stiffness_percent, (-99.0, 1e6)),
            (self.contact_damping_percent, (-100.0, 1e6)),
            (self.gap_offset_mm, (-100.0, 100.0)),
        ];
        for (key, (value, (from, to))) in Self::KEYS.iter().zip(values) {
            if !(from..=to).contains(&value) {
                return Err(file::out_of_range(key, value, &format!("{from} to {to}")));
            }
        }
        Ok(())
    }

    /// `rig` with this `share` (0 to 1) of the change.
    #[must_use]
    pub fn apply(&self, rig: &RigParams, share: f64) -> RigParams {
        let times = |percent: f64| 1.0 + 0.01 * percent * share;
        let mut changed = rig.with_natural_frequency_scaled(times(self.natural_frequency_percent));
        changed.gap_m += 1e-3 * self.gap_offset_mm * share;
        let stiffer = times(self.contact_stiffness_percent);
        let damped = times(self.contact_damping_percent);
        match &mut changed.contact {
            Law::Hertz { stiffness, .. } | Law::LankaraniNikravesh { stiffness, .. } => {
                *stiffness *= stiffer;
            }
            Law::SpringDashpot { stiffness, damping } => {
                *stiffness *= stiffer;
                *damping *= damped;
            }
            Law::HuntCrossley {
                stiffness,
                damping_ratio,
                ..
            } => {
                *stiffness *= stiffer;
                *damping_ratio *= damped;
            }
        }
        changed
    }
}

/// The built-in scenario called `name`, or the one in the file of that path.
///
/// # Errors
/// One line that says what, where and the mend.
pub fn load(name: &str) -> Result<Scenario, UserError> {
    if let Some((_, text)) = BUILTIN.iter().find(|(n, _)| *n == name) {
        return parse(name, text, name);
    }
    let path = Path::new(name);
    let looks_like_a_file = path.extension().is_some() || path.components().count() > 1;
    if !looks_like_a_file && !path.exists() {
        let hint = nearest(name, BUILTIN.iter().map(|(n, _)| *n));
        return Err(UserError::new(format!(
            "no scenario is called '{name}'{hint}; `host-sim scenarios` lists them, or give a FILE.toml"
        )));
    }
    let text = read_text(path)?;
    let stem = path.file_stem().map(|s| s.to_string_lossy().into_owned());
    parse(stem.as_deref().unwrap_or(name), &text, name)
}

/// The scenario in `text`, called `name` unless it says otherwise; `place` begins complaints.
///
/// # Errors
/// One line.
pub fn parse(name: &str, text: &str, place: &str) -> Result<Scenario, UserError> {
    file::parse(name, text, place)
}
