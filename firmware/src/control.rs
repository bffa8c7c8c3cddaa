//! The control task's work, the same on every board: the twin, a tick at a time.
//!
//! Nothing here blocks, allocates, formats or panics. What takes its time is done
//! by whoever receives the [`Report`]; see [`crate::monitor`].

use shared::drive::{Drive, DriveError};
use shared::params::{ParamError, RigParams, WIRES};
use shared::rig::{Mode, Rig};
use shared::step::Corrected;
use shared::twin::{Strobe, Twin};

/// Control ticks per second.
pub const TICK_RATE_HZ: u32 = 20_000;

/// Length of a control tick, s.
pub const TICK_S: f64 = 1.0 / TICK_RATE_HZ as f64;

/// The rig that is run: on wires at a gap of 0.0 mm, as in the field.
pub const RIG: RigParams = WIRES;

/// Drive frequency over natural frequency: in the middle of the range in which
/// this rig hits once per drive period.
pub const FREQUENCY_RATIO: f64 = 2.0;

/// Why there is nothing to control.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Refused {
    /// The rig cannot be.
    Rig(ParamError),
    /// The drive cannot be.
    Drive(DriveError),
}

/// What the control task hands over once per drive period, by value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Report {
    /// Counts reports (wraps); a jump shows that one was lost.
    pub sequence: u32,
    /// The section at drive phase 0 and the period that ended there.
    pub strobe: Strobe<f32>,
}

/// The control task's state.
#[derive(Clone, Copy, Debug)]
pub struct Control {
    twin: Twin<f32, Corrected>,
    reports: u32,
}

impl Control {
    /// [`RIG`] at rest under a drive of [`FREQUENCY_RATIO`].
    ///
    /// # Errors
    /// If rig or drive are refused.
    pub fn new() -> Result<Self, Refused> {
        let rig = Rig::new(&RIG).map_err(Refused::Rig)?;
        let frequency_hz = FREQUENCY_RATIO * RIG.natural_frequency_hz();
        let drive = Drive::new(frequency_hz, TICK_S).map_err(Refused::Drive)?;
        Ok(Self {
            twin: Twin::at_rest(rig, drive, Corrected),
            reports: 0,
        })
    }

    /// Steps the twin by one tick. A report is due once per drive period.
    ///
    /// Never inlined: what `cargo xtask bench-ticks` counts is what the boards run.
    #[inline(never)]
    pub fn tick(&mut self) -> Option<Report> {
        let strobe = self.twin.tick().strobe?;
        let sequence = self.reports;
        self.reports = sequence.wrapping_add(1);
        Some(Report { sequence, strobe })
    }

    /// Whether the hammer touches the surface.
    pub fn in_contact(&self) -> bool {
        self.twin.state().mode == Mode::Contact
    }

    /// The twin.
    pub fn twin(&self) -> &Twin<f32, Corrected> {
        &self.twin
    }
}
