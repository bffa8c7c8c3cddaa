//! The lines of the log. Numbers and fixed words only: they are put together on the computer. Formatting texts here, as
//! `Debug` does, would take thousands of instructions with the logger taken. A line that comes while another is being
//! written, from a task above it, is dropped (`drop-on-contention` of defmt-rtt), and no interrupt is ever masked for one.

use defmt_rtt as _;
use shared::control::{
    Basin, BootInfo, EventKind, Refused, ResetCause, SettingsState, State, Unfit,
};
use shared::fault::FaultRecord;

use super::{blocks, retained::Crash};

defmt::timestamp!("{=u32:ms}", blocks::served() / 2);

/// Why and with what the board started.
pub fn start(boot: &BootInfo, crash: Option<Crash>, bench: bool, asked: bool) {
    let cause = match boot.reset {
        ResetCause::PowerOn => "power on",
        ResetCause::Pin => "reset pin",
        ResetCause::Software => "its own program",
        ResetCause::Watchdog => "watchdog",
        ResetCause::BrownOut => "supply dropped",
        ResetCause::WhileDriving => "while driving",
    };
    defmt::info!("started: {=str}", cause);
    if let Some(record) = &boot.record {
        fault(record);
    }
    if let Some(crash) = crash {
        defmt::warn!(
            "crashed at {=u32:#010x}, CFSR {=u32:#x}",
            crash.address,
            crash.status
        );
    }
    match boot.settings {
        SettingsState::Stored | SettingsState::Model => {}
        SettingsState::Missing => defmt::error!(
            "no settings were ever stored; starts are refused until those of this rig are sent"
        ),
        SettingsState::Damaged => defmt::error!(
            "the stored settings are damaged; starts are refused until those of this rig are sent"
        ),
        SettingsState::OlderCopy => defmt::error!(
            "the newest settings are damaged; starts are refused until the older copy in use is confirmed or others are sent"
        ),
    }
    match (bench, asked) {
        (true, _) => {
            defmt::info!("bench mode: the model replaces the rig, the drive stays off")
        }
        (false, true) => defmt::warn!("bench mode refused: something is wired to the inputs"),
        _ => {}
    }
}

/// Why the board is not fit to drive a rig, a line for each reason.
pub fn unfit(unfit: Unfit) {
    for why in unfit.reasons() {
        defmt::warn!("not fit to drive a rig: {=str}", why);
    }
}

/// The button's command was refused.
pub fn refused(why: Refused) {
    let why = match why {
        Refused::WrongState => "not in this state",
        Refused::NotANumber => "not a number",
        Refused::NoMotion => "no motion",
        Refused::StillFaulty => "the fault's cause is still there",
        Refused::BadSettings => "the settings are out of range",
        Refused::SettingsUnknown(_) => "the settings are not known to be this rig's",
        Refused::NotAcknowledged => "the emergency stop must be acknowledged first",
        Refused::ChainNotTried => "open the emergency-stop chain and acknowledge it first",
        Refused::ByHandOnly => "a motor drive runs by hand only",
    };
    defmt::warn!("button: refused, {=str}", why);
}

/// An event of the timeline.
pub fn event(kind: &EventKind) {
    match kind {
        EventKind::State { from, to } => {
            defmt::info!("{=str} to {=str}", state_name(*from), state_name(*to));
        }
        EventKind::Fault(record) => fault(record),
        EventKind::Cleared => defmt::info!("fault cleared"),
        EventKind::Forecast { target_hz, force_n } => {
            defmt::info!("forecast: {=f32} Hz, {=f32} N", target_hz, force_n);
        }
        EventKind::NoTarget => defmt::warn!("no stable 1/1 within the limits"),
        EventKind::Identified { natural_hz, gap_m } => {
            defmt::info!("identified: {=f32} Hz, gap {=f32} m", natural_hz, gap_m);
        }
        EventKind::Best {
            frequency_hz,
            impulse_n_s,
        } => defmt::info!("best: {=f32} Hz, {=f32} N s", frequency_hz, impulse_n_s),
        EventKind::RegimeLost => defmt::warn!("1/1 lost"),
        EventKind::Doubling { frequency_hz } => {
            defmt::warn!("period doubled at {=f32} Hz", frequency_hz);
        }
        EventKind::Basin(Basin::Impact) => defmt::info!("the hammer strikes"),
        EventKind::Basin(Basin::NoImpact) => defmt::warn!("the hammer swings free"),
        EventKind::Basin(Basin::Unknown) => defmt::info!("basin not known"),
        EventKind::Limits(limits) => defmt::info!("limits that act: {=u8:#x}", limits.bits()),
        EventKind::Proven { cart, hammer } => {
            let hammer = hammer.unwrap_or(0.0);
            defmt::info!("sensors proven: cart {=f32}, hammer {=f32}", cart, hammer);
        }
    }
}

fn fault(record: &FaultRecord) {
    defmt::warn!(
        "fault {=u8} {=str}: value {=f32}, at tick {=u32}, {=f32} Hz; episode {=u32:#x}",
        record.fault.code(),
        record.fault.name(),
        record.value,
        record.tick,
        record.frequency_hz,
        record.episode.bits()
    );
}

/// The name of a state.
pub fn state_name(state: State) -> &'static str {
    match state {
        State::Idle => "Idle",
        State::SelfTest => "SelfTest",
        State::Prove => "Prove",
        State::Ramp => "Ramp",
        State::Seek => "Seek",
        State::Hold => "Hold",
        State::Manual => "Manual",
        State::Stop => "Stop",
        State::Fault => "Fault",
    }
}
