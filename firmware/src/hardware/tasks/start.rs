//! From the reset to the first block.

use shared::{
    control::{BootInfo, Controller, SettingsState},
    link::store::Loaded,
    model::params::WIRES,
    settings::Settings,
};

use super::{Control, Link, Supervisor, log, retained, traps};
use crate::{bench::Bench, hardware::board, recorder::ControlRecorder};

/// What the tasks own.
pub struct Tasks {
    /// The controller, shared by all of them.
    pub recorder: ControlRecorder,
    /// What the control task owns.
    pub control: Control,
    /// The guard above the control task.
    pub block_monitor: board::BlockMonitor,
    /// What the link task owns.
    pub link: Link,
    /// What the supervisor owns.
    pub supervisor: Supervisor,
}

/// Takes the board into use; samples from now on.
pub fn start(mut core: cortex_m::Peripherals, device: board::Peripherals) -> Tasks {
    traps::clear(&mut core.DCB);
    let flags = board::reset_flags(&device.RCC);
    let left = retained::take();
    let Some(board) = board::set_up(device) else {
        panic!("a timer cannot be set to its rate");
    };
    core.DCB.enable_trace();
    core.DWT.enable_cycle_counter();

    let mut store = board.store;
    let bench = board.bench_asked && !board.wired;
    let (stored, state) = match store.load() {
        Some(Loaded::Settings(settings)) => (Some(settings), SettingsState::Stored),
        Some(Loaded::OlderCopy(settings)) => (Some(settings), SettingsState::OlderCopy),
        // The model needs no settings of a rig.
        Some(Loaded::Default) if bench => (None, SettingsState::Model),
        Some(Loaded::Default) => (None, SettingsState::Missing),
        Some(Loaded::Corrupt) | None => (None, SettingsState::Damaged),
    };
    let usual = Settings::for_rig(&WIRES);
    let settings = stored.unwrap_or(if bench { usual } else { usual.for_real() });
    let boot = BootInfo {
        reset: flags.cause(left.driving),
        record: left.record,
        settings: state,
        // Bench mode drives nothing.
        unfit: board.unfit.when(!bench),
    };
    let Ok(controller) = Controller::new(&settings, &boot) else {
        panic!("settings that passed their check are refused");
    };
    let record = controller.fault().copied();
    retained::keep(record.as_ref());
    retained::note_drive(false);
    log::start(&boot, left.crash, bench, board.bench_asked);
    log::unfit(board.unfit);

    let mut control = Control::new(
        (board.sampler, board.set_points),
        (board.chain, board.reports),
        board.enable.filter(|_| !bench),
        bench.then(|| Bench::new(&settings)),
        record,
    );
    let mut block_monitor = board.block_monitor;
    let link = Link::new(board.serial, board.link_timer, store);
    // Last of all, and the guard after the sampling: until the first block there is none to miss.
    control.begin();
    if !block_monitor.start() {
        panic!("a timer cannot be set to its rate");
    }
    let registers = board::registers();
    Tasks {
        recorder: ControlRecorder::new(controller),
        control,
        block_monitor,
        link,
        supervisor: Supervisor::new(board.led, board.button, bench, registers),
    }
}
