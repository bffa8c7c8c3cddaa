//! The controller: from samples to set-points, and when to switch off.
//!
//! ```text
//!              Start             zeros found        sensors proven        amplitude reached
//!        Idle -------> SelfTest ------------> Prove ---------------> Ramp -------------------> Seek
//!         ^ ^                                   |                     |                        |  ^
//!         | |  amplitude 0                      |                     |  (by hand)     at goal |  |1/1 lost
//!         | +-------------- Stop <---- Stop ----+---------------------+------> Manual          v  |
//!         |                                                                                  Hold-+
//!         | ClearFault, cause gone
//!        Fault <--- any state: a condition of the fault table; the drive is off first
//! ```
//!
//! [`Controller`] is all work at control priority, a block of samples at a time. [`Lockstep`] adds the forecast,
//! for programs in which time stands still between blocks (desktop, QEMU).

mod basin;
mod block_health;
mod controller;
mod event;
mod force;
mod forecast_cache;
mod free;
mod guard;
mod lifetime;
mod limits;
mod lock;
mod lockstep;
mod off_watch;
mod operator;
mod oscillator;
mod phase;
mod plausibility;
mod probe;
mod proof;
mod rig_estimate;
mod sampling;
mod search;
mod self_test;
mod supervise;
#[cfg(test)]
mod test_rig;
mod trim;
mod unfit;

pub use controller::Controller;
pub use event::{EVENT_CAPACITY, Event, EventKind, Events};
pub use guard::{OPEN_TICKS, OVER_FORCE_TICKS, OVER_TRAVEL_TICKS, SATURATED_TICKS};
pub use limits::ActiveLimits;
pub use lockstep::{Exchanged, Lockstep};
pub use plausibility::{BAD_PERIODS, BAD_PULSES, FAR_PULSES};
pub use unfit::Unfit;

use serde::{Deserialize, Serialize};

use crate::fault::FaultRecord;
use crate::model::regime::Regime;

/// Samples in a block at most.
pub const MAX_BLOCK: usize = 32;

/// What the controller is doing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[repr(u8)]
pub enum State {
    /// Drive off, waiting for a start.
    #[default]
    Idle = 0,
    /// Drive off, testing the sensors.
    SelfTest = 1,
    /// Drive on, amplitude rising at the frequency the search starts from.
    Ramp = 2,
    /// Looking for 1/1, then going to the phase of the forecast's target.
    Seek = 3,
    /// Holding the phase wanted: that of the forecast's target, as climbs have corrected it.
    Hold = 4,
    /// Amplitude falling, then the drive goes off.
    Stop = 5,
    /// Drive off after a fault.
    Fault = 6,
    /// Frequency and amplitude are given by hand.
    Manual = 7,
    /// Drive on, a small and slow motion that proves the sensors.
    Prove = 8,
}

/// Who chooses the frequency.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Mode {
    /// The controller seeks and holds the operating frequency.
    #[default]
    Automatic,
    /// The sender of [`Command::SetPoint`].
    Manual,
}

/// A command to the running controller.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Command {
    /// From Idle: self test, then run.
    Start(Mode),
    /// Ramp down and go idle, from any state but Fault.
    Stop,
    /// From Fault, once its cause has gone: back to Idle.
    ClearFault,
    /// Manual set-points; clamped to the limits.
    SetPoint {
        /// Drive frequency, Hz.
        frequency_hz: f32,
        /// Cart amplitude, m.
        amplitude_m: f32,
    },
    /// The link in command is alive.
    Alive,
    /// Somebody at the rig has seen the emergency stop: the board's button. Refused over the link.
    Acknowledge {
        /// The chain's own report has shown it open since the last start; not so where only the relay, the power stage or the
        /// guard of the enable stopped the drive.
        opened: bool,
    },
    /// The older copy of the settings is that of this rig ([`SettingsState::OlderCopy`]).
    ConfirmSettings,
}

/// Why a command was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Refused {
    /// Not in this state.
    WrongState,
    /// A number in it is not finite.
    NotANumber,
    /// The fault's cause is still there.
    StillFaulty,
    /// The settings are out of range.
    BadSettings,
    /// The settings are not known to be this rig's: send them, or confirm an older copy.
    SettingsUnknown(SettingsState),
    /// The emergency stop must be acknowledged at the board first.
    NotAcknowledged,
    /// A motor drive runs by hand only: its amplitude is the mechanism's, and no limit could reduce it.
    ByHandOnly,
    /// A frequency that is not positive, or a negative amplitude.
    NoMotion,
    /// Settings ask for an acknowledgement, and the emergency-stop chain was not opened and acknowledged since the last start.
    ChainNotTried,
}

/// Which basin of attraction the hammer ended in after it was disturbed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Basin {
    /// Not known yet: too few drive periods in a row with contact, or without.
    #[default]
    Unknown,
    /// The hammer strikes.
    Impact,
    /// The hammer swings without touching.
    NoImpact,
}

/// The state of the controller, as reported.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Status {
    /// Control ticks since the start (wraps).
    pub tick: u32,
    /// What the controller is doing.
    pub state: State,
    /// The present or last fault; survives a reset.
    pub fault: Option<FaultRecord>,
    /// Limits that clamp now.
    pub limits: ActiveLimits,
    /// Commanded drive frequency, Hz; given while the drive is off, too.
    pub frequency_hz: f32,
    /// Commanded cart amplitude, m.
    pub amplitude_m: f32,
    /// Measured cart amplitude, m.
    pub measured_amplitude_m: f32,
    /// Measured lag of the cart behind the command, rad.
    pub lag_rad: f32,
    /// Regime measured last; [`Regime::None`] before the first measurement.
    pub regime: Regime,
    /// Measured peak force of the last drive period, N.
    pub peak_n: f32,
    /// Mean impulse per contact over the last drive periods, N·s.
    pub impulse_n_s: f32,
    /// The forecast's target, Hz; 0 without one.
    pub target_hz: f32,
    /// The forecast's force there, N.
    pub target_n: f32,
    /// Which basin the last disturbance ended in.
    pub basin: Basin,
    /// Times the regime was lost and sought again.
    pub reseeks: u16,
    /// Overruns of the control task.
    pub overruns: u32,
    /// Events that nobody took in time, and that are lost.
    pub events_dropped: u16,
}

/// Why the board last started.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum ResetCause {
    /// The supply came on.
    #[default]
    PowerOn,
    /// The reset line, with the drive off.
    Pin,
    /// The program reset the board itself.
    Software,
    /// The watchdog ran out and reset the board.
    Watchdog,
    /// The supply dropped and reset the board.
    BrownOut,
    /// The reset line or a debugger, with the drive on.
    WhileDriving,
}

/// Where the settings in use come from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SettingsState {
    /// Somebody sent them for this rig: the newest that are stored, or sent since the start.
    Stored,
    /// Those stored cannot be read; defaults stand in for them.
    Damaged,
    /// None were ever stored; defaults stand in for them.
    #[default]
    Missing,
    /// The newest that were stored cannot be read; an older copy stands in for them.
    OlderCopy,
    /// A model's own: no rig is driven (bench mode, QEMU).
    Model,
}

impl SettingsState {
    /// Whether a rig may be driven with them.
    pub const fn can_drive(self) -> bool {
        matches!(self, Self::Stored | Self::Model)
    }
}

/// Why and with what the board started. By default no settings were ever stored, so it drives nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct BootInfo {
    /// Why the board started.
    pub reset: ResetCause,
    /// The fault record that survived the reset.
    pub record: Option<FaultRecord>,
    /// Where the settings come from.
    pub settings: SettingsState,
    /// Why the board is not fit to drive a rig. It stays so until it is started again.
    pub unfit: Unfit,
}

impl BootInfo {
    /// A plain power-on with stored settings.
    pub const STORED: Self = Self {
        reset: ResetCause::PowerOn,
        record: None,
        settings: SettingsState::Stored,
        unfit: Unfit::NONE,
    };
}
