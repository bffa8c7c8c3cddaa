//! What a board says, in names and units for the page.

use emulator::names::{basin_name, state_name};
use files::settings_file;
use serde::Serialize;
use serde_json::{Value, json};
use shared::control::{self, Refused, SettingsState};
use shared::fault::Fault;
use shared::link::{LinkAnswer, PROTOCOL_VERSION, Refusal};
use shared::settings::TICK_RATE_HZ;

/// What some bytes said.
#[derive(Debug, Default, Serialize)]
pub struct Heard {
    /// Answers in their order: `request`, `kind` and what belongs to it.
    pub answers: Vec<Value>,
    /// The last status, if one was streamed.
    pub status: Option<ShownStatus>,
    /// Packets of the board that did not arrive.
    pub lost: u64,
    /// Those that the board itself could not send, since it started.
    pub dropped_by_board: u32,
    /// Gaps in the recorded ticks, and ticks in them.
    pub gaps: u32,
    /// Ticks missing in those gaps.
    pub lost_ticks: u64,
    /// Length of the recording, s.
    pub recorded_s: Option<f64>,
    /// Why the recording cannot go on.
    pub recording_broke: Option<String>,
}

/// A status in names and units.
#[derive(Debug, Serialize)]
pub struct ShownStatus {
    time_s: f64,
    state: &'static str,
    frequency_hz: f32,
    amplitude_mm: f32,
    measured_amplitude_mm: f32,
    lag_deg: f32,
    regime: String,
    peak_n: f32,
    impulse_n_s: f32,
    target_hz: f32,
    target_n: f32,
    basin: &'static str,
    limits: Vec<&'static str>,
    reseeks: u16,
    overruns: u32,
    fault: Option<Value>,
}

impl ShownStatus {
    /// Of a controller's status.
    pub fn of(status: &control::Status) -> Self {
        Self {
            time_s: f64::from(status.tick) / f64::from(TICK_RATE_HZ),
            state: state_name(status.state),
            frequency_hz: status.frequency_hz,
            amplitude_mm: 1e3 * status.amplitude_m,
            measured_amplitude_mm: 1e3 * status.measured_amplitude_m,
            lag_deg: status.lag_rad.to_degrees(),
            regime: status.regime.to_string(),
            peak_n: status.peak_n,
            impulse_n_s: status.impulse_n_s,
            target_hz: status.target_hz,
            target_n: status.target_n,
            basin: basin_name(status.basin),
            limits: status.limits.names().collect(),
            reseeks: status.reseeks,
            overruns: status.overruns,
            fault: status.fault.map(|record| {
                let episode: Vec<_> = record.episode.faults().map(Fault::name).collect();
                json!({
                    "code": record.fault.code(),
                    "name": record.fault.name(),
                    "value": record.value,
                    "frequency_hz": record.frequency_hz,
                    "episode": episode,
                })
            }),
        }
    }
}

/// An answer to the request of this number.
pub fn shown(request: u16, answer: &LinkAnswer) -> Value {
    match answer {
        LinkAnswer::Hello(hello) => json!({
            "request": request, "kind": "hello", "fits": hello.protocol == PROTOCOL_VERSION, "protocol": hello.protocol,
            "firmware": hello.firmware.as_str(), "board": hello.board.as_str(), "block_ticks": hello.block_ticks,
        }),
        LinkAnswer::Done => json!({ "request": request, "kind": "done" }),
        LinkAnswer::Refused(refusal) => {
            json!({ "request": request, "kind": "refused", "why": reason(*refusal) })
        }
        LinkAnswer::Status(status) => {
            json!({ "request": request, "kind": "status", "status": ShownStatus::of(status) })
        }
        LinkAnswer::Settings(settings) => json!({
            "request": request, "kind": "settings", "toml": settings_file::to_toml(settings),
            "min_frequency_hz": settings.limits.min_frequency_hz, "max_frequency_hz": settings.limits.max_frequency_hz,
            "limit_amplitude_mm": 1e3 * settings.limits.amplitude_m, "limit_force_n": settings.limits.force_n,
            "amplitude_mm": 1e3 * settings.rig.amplitude_m, "link_timeout_s": settings.trips.link_timeout_s,
        }),
        LinkAnswer::Board(board) => json!({
            "request": request, "kind": "board", "boot": board.boot, "granted": board.granted, "held": board.held,
            "settings": board.settings, "awaits_acknowledgement": board.awaits_acknowledgement,
        }),
        LinkAnswer::Session(_) => json!({ "request": request, "kind": "session" }),
        other => json!({ "request": request, "kind": "other", "text": format!("{other:?}") }),
    }
}

/// Why a board refused something, and what to do in the page.
fn reason(refusal: Refusal) -> &'static str {
    match refusal {
        Refusal::Controller(Refused::WrongState) => "not in this state",
        Refusal::Controller(Refused::NotANumber) => "a number in it is not finite",
        Refusal::Controller(Refused::NoMotion) => {
            "a frequency is positive, and an amplitude is not negative"
        }
        Refusal::Controller(Refused::StillFaulty) => {
            "the fault's cause is still there; remove it and clear again"
        }
        Refusal::Controller(Refused::BadSettings) => "the settings are out of range",
        Refusal::Controller(Refused::ByHandOnly) => {
            "the drive is a motor, whose amplitude no limit can reduce: start it by hand"
        }
        Refusal::Controller(Refused::SettingsUnknown(SettingsState::OlderCopy)) => {
            "the newest settings are damaged and an older copy is in use: read them, then write them again or others"
        }
        Refusal::Controller(Refused::SettingsUnknown(_)) => {
            "the board has no settings of this rig: write them"
        }
        Refusal::Controller(Refused::NotAcknowledged) => {
            "the emergency stop must be acknowledged at the board: close the chain, press the button, then clear"
        }
        Refusal::Controller(Refused::ChainNotTried) => {
            "each start wants the emergency stop tried: press it, release it, press the board's button, then clear"
        }
        Refusal::NotStored => {
            "the settings are in use but could not be stored: they are lost at the next reset; write them again"
        }
        Refusal::NotAvailable => "this board cannot do that",
        Refusal::NoSession => "this page does not command the board; take the command",
        Refusal::SomebodySteers => "another page commands the board",
        Refusal::Old => "the message is older than the last; try again",
        Refusal::AtTheBoard => "that is done at the board, with its button",
    }
}
