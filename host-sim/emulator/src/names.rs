//! States and basins by the names that scenarios, logs and verdicts use.

use shared::control::{Basin, State};

/// Every state of the controller.
pub const STATES: [State; 9] = [
    State::Idle,
    State::SelfTest,
    State::Ramp,
    State::Seek,
    State::Hold,
    State::Stop,
    State::Fault,
    State::Manual,
    State::Prove,
];

/// Every basin of attraction that the controller tells apart.
pub const BASINS: [Basin; 3] = [Basin::Impact, Basin::NoImpact, Basin::Unknown];

/// The name of a state.
pub fn state_name(state: State) -> &'static str {
    match state {
        State::Idle => "idle",
        State::SelfTest => "self-test",
        State::Ramp => "ramp",
        State::Seek => "seek",
        State::Hold => "hold",
        State::Stop => "stop",
        State::Fault => "fault",
        State::Manual => "manual",
        State::Prove => "prove",
    }
}

/// The name of a basin.
pub fn basin_name(basin: Basin) -> &'static str {
    match basin {
        Basin::Unknown => "unknown",
        Basin::Impact => "impact",
        Basin::NoImpact => "no-impact",
    }
}
