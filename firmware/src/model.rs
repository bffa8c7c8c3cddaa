//! The model of `shared` alone, a tick at a time: what `cargo xtask bench-ticks` counts.

use shared::model::drive::{Drive, DriveError};
use shared::model::params::{ParamError, RigParams, WIRES};
use shared::model::rig::{Rig, SwitchMode};
use shared::model::step::Corrected;
use shared::model::twin::Twin;
use shared::settings::TICK_S;

/// The rig that is run: on wires at a gap of 0.0 mm, as in the field.
pub const RIG: RigParams = WIRES;

/// Drive frequency over natural frequency: in the middle of the range in which
/// this rig hits once per drive period.
pub const FREQUENCY_RATIO: f64 = 2.0;

/// Why there is no model to run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NoModel {
    /// A parameter of the rig is out of range.
    Rig(ParamError),
    /// The drive frequency is out of range.
    Drive(DriveError),
}

/// The model under a drive.
#[derive(Clone, Copy, Debug)]
pub struct DrivenModel(Twin<f32, Corrected>);

impl DrivenModel {
    /// [`RIG`] at rest under a drive of [`FREQUENCY_RATIO`].
    ///
    /// # Errors
    /// If the rig or the drive is out of range.
    pub fn new() -> Result<Self, NoModel> {
        let rig = Rig::new(&RIG).map_err(NoModel::Rig)?;
        let frequency_hz = FREQUENCY_RATIO * RIG.natural_frequency_hz();
        let drive = Drive::new(frequency_hz, TICK_S).map_err(NoModel::Drive)?;
        Ok(Self(Twin::at_rest(rig, drive, Corrected)))
    }

    /// Steps by one tick; whether a drive period ended in it.
    ///
    /// Never inlined: what is counted is what is called.
    #[inline(never)]
    pub fn tick(&mut self) -> bool {
        self.0.tick().strobe.is_some()
    }

    /// Whether the hammer touches the surface.
    pub fn in_contact(&self) -> bool {
        self.0.state().mode == SwitchMode::Contact
    }
}
