//! The controller.

use serde::{Deserialize, Serialize};

use crate::fault::Record;
use crate::regime::Regime;

/// What the controller is doing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[repr(u8)]
pub enum State {
    /// Drive off, waiting for a start.
    #[default]
    Idle = 0,
    /// Drive off, looking at the sensors.
    SelfTest = 1,
    /// Drive on, amplitude rising at the frequency the search starts from.
    Ramp = 2,
    /// Going to the forecast's target, then climbing on measured force.
    Seek = 3,
    /// Holding the maximum.
    Hold = 4,
    /// Amplitude falling, then the drive goes off.
    Stop = 5,
    /// Drive off after a fault.
    Fault = 6,
    /// Frequency and amplitude are given by hand.
    Manual = 7,
}

/// Who chooses the frequency.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Mode {
    /// The controller seeks and holds the operating frequency.
    #[default]
    Automatic,
    /// Whoever sends [`Command::SetPoint`].
    Manual,
}

/// What the controller can be told while it runs.
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
}

/// Why a command was not obeyed.
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
}

/// Which basin of attraction the hammer ended in after it was disturbed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Basin {
    /// Not told yet.
    #[default]
    Unknown,
    /// It strikes.
    Impact,
    /// It swings without touching.
    NoImpact,
}

/// Everything worth reporting, by value.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Status {
    /// Control ticks since the start (wraps).
    pub tick: u32,
    /// What the controller is doing.
    pub state: State,
    /// The fault that is or was; survives the reset.
    pub fault: Option<Record>,
    /// Limits that clamp now, as bits: 1 force, 2 travel, 4 frequency, 8 amplitude.
    pub limits: u8,
    /// Drive frequency, Hz.
    pub frequency_hz: f32,
    /// Commanded cart amplitude, m.
    pub amplitude_m: f32,
    /// Measured cart amplitude, m.
    pub measured_amplitude_m: f32,
    /// Measured lag of the cart behind the command, rad.
    pub lag_rad: f32,
    /// Measured regime.
    pub regime: Regime,
    /// Measured peak force of the last drive period, N.
    pub peak_n: f32,
    /// Mean impulse per contact over the last drive periods, N·s.
    pub impulse_ns: f32,
    /// The forecast's target, Hz; 0: none yet.
    pub target_hz: f32,
    /// The forecast's force there, N.
    pub target_n: f32,
    /// Which basin the last disturbance ended in.
    pub basin: Basin,
    /// Times the regime was lost and sought again.
    pub reseeks: u16,
    /// Overruns of the control task.
    pub overruns: u32,
}
