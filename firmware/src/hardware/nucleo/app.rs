//! The controller on the NUCLEO-F446RE.
//!
//! | task | priority | runs | deadline |
//! |---|---|---|---|
//! | `supply` | 4 | when the supply drops | the same as `emergency`; does not return with the drive on |
//! | `emergency` | 4 | when the emergency-stop chain opens | none later than itself: a few stores |
//! | `watch_blocks` | 4 | 1 kHz | the same |
//! | `control` | 3 | each block of 10 ticks, 2 kHz; retains a fault's record | 491 µs |
//! | `link` | 2 | 1 kHz | 1 ms; what comes later is sent later |
//! | `supervise` | 1 | 100 Hz | 10 ms; the watchdog is not fed without it |
//! | `idle` | 0 | always | none; the forecast takes what time is left |
//!
//! Tasks share two things, by locks that are short: the recorder (the controller) and the last forecast.
//!
//! In bench mode (docs/flashing.md) the model takes the place of the rig: the samples come from [`Bench`], and the
//! drive's enable line, kept low, is not handed to any task.
#![no_main]
#![no_std]

#[rtic::app(device = stm32f4xx_hal::pac, dispatchers = [UART4, UART5])]
mod app {
    use core::sync::atomic::{AtomicU32, Ordering};

    use cortex_m::peripheral::DWT;
    use firmware::{
        BLOCK_TICKS,
        bench::Bench,
        button::{self, Button},
        hardware::nucleo::{Board, Store, block_monitor, drive, retained},
        hardware::{
            nucleo::{self, log},
            stack,
        },
        interlock::Interlock,
        led::{LedPattern, Shown},
        link_device::BoardLink,
        liveness::{Liveness, Progress},
        record_keeper::RecordKeeper,
        recorder::Recorder,
        wire::RateFinder,
    };
    use shared::{
        control::{BootInfo, Controller, SettingsState, Unfit},
        forecast::{Forecast, Forecaster},
        io::{Frame, Output},
        link::Session,
        link::store::Loaded,
        model::params::WIRES,
        settings::{Interlock as Wired, Settings},
    };

    /// Bytes waiting for the wire at most.
    const QUEUE: usize = 4096;

    /// Turns of the idle loop (wraps).
    static IDLES: AtomicU32 = AtomicU32::new(0);
    /// Turns of the link task (wraps).
    static LINKS: AtomicU32 = AtomicU32::new(0);
    /// Processor cycles of the last block and of the longest since it was last logged.
    static CYCLES: [AtomicU32; 2] = [AtomicU32::new(0), AtomicU32::new(0)];

    #[shared]
    struct Shared {
        recorder: Recorder,
        forecast: Forecast,
    }

    #[local]
    struct Local {
        sampler: nucleo::Sampler,
        set_points: nucleo::SetPoints,
        chain: drive::Chain,
        enable: Option<drive::Enable>,
        bench: Option<Bench>,
        outputs: [Output; BLOCK_TICKS],
        keeper: RecordKeeper,
        reports: nucleo::Reports,
        interlock: Interlock,
        block_monitor: block_monitor::BlockMonitor,
        serial: nucleo::Serial,
        rate: RateFinder,
        link_timer: nucleo::LinkTimer,
        session: Session<QUEUE>,
        store: Store,
        supervisor: Supervisor,
        forecaster: Forecaster,
    }

    /// State of the supervisor.
    pub struct Supervisor {
        led: nucleo::LedPin,
        pin: nucleo::ButtonPin,
        button: Button,
        pattern: LedPattern,
        watchdog: nucleo::Watchdog,
        liveness: Liveness,
        bench: bool,
        steps: u32,
    }

    #[init]
    fn init(mut context: init::Context) -> (Shared, Local) {
        nucleo::clear_traps(&mut context.core.DCB);
        let flags = nucleo::reset_flags(&context.device.RCC);
        let left = retained::take();
        let Some(board) = Board::new(context.device) else {
            panic!("a timer cannot be set to its rate");
        };
        context.core.DCB.enable_trace();
        context.core.DWT.enable_cycle_counter();

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
        let settings = stored.unwrap_or_else(|| Settings::for_rig(&WIRES));
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
        log::start(&boot, left.crash, bench, board.bench_asked);
        log::unfit(board.unfit);

        let supervisor = Supervisor {
            led: board.led,
            button: Button::new(board.button.is_pressed()),
            pin: board.button,
            pattern: LedPattern::default(),
            watchdog: board.watchdog,
            liveness: Liveness::default(),
            bench,
            steps: 0,
        };
        let shared = Shared {
            recorder: Recorder::new(controller),
            forecast: Forecast::default(),
        };
        let mut local = Local {
            sampler: board.sampler,
            set_points: board.set_points,
            chain: board.chain,
            enable: (!bench).then_some(board.enable),
            bench: bench.then(|| Bench::new(&settings)),
            outputs: [Output::SAFE; BLOCK_TICKS],
            keeper: RecordKeeper::new(boot.record),
            reports: board.reports,
            interlock: Interlock::default(),
            block_monitor: board.block_monitor,
            serial: board.serial,
            rate: RateFinder::default(),
            link_timer: board.link_timer,
            session: Session::new(),
            store,
            supervisor,
            forecaster: Forecaster::new(),
        };
        // Last of all, and the guard after the sampling: until the first block there is none to miss.
        local.sampler.start();
        if !local.block_monitor.start() {
            panic!("a timer cannot be set to its rate");
        }
        (shared, local)
    }

    /// A block: what was sampled in the last 10 ticks in, the set-points of the 10 after the next out.
    ///
    /// Deadline: the set-points 491 µs after the interrupt, when the DMA fetches the first of them; the rest 500 µs, when
    /// the next block is complete. A block that ends later has overrun: what it writes late is played half old, half new,
    /// the next block starts at once, and the overrun is reported to the controller; more than one in five and it trips. If
    /// two blocks were due, the older is lost. If none is served for 2 to 3 ms, `watch_blocks` takes the enable away.
    #[task(binds = DMA2_STREAM0, priority = 3, shared = [recorder],
        local = [sampler, set_points, chain, enable, bench, outputs, keeper, reports, interlock,
            wired: Wired = Wired { relay: false, ready: false }])]
    fn control(mut context: control::Context) {
        let began = DWT::cycle_count();
        let local = context.local;
        let outputs: &mut [Output; BLOCK_TICKS] = local.outputs;
        let arrived = local.sampler.arrived();
        let enabled = drive::is_driving();
        let against = local
            .interlock
            .contradicts(enabled, local.reports.read(), *local.wired);
        let tripped = local.chain.tripped() || (against && local.enable.is_some());
        if local.sampler.reference_is_lost() && enabled {
            nucleo::make_outputs_safe();
            nucleo::report_unfit(Unfit::REFERENCE);
        }
        let mut frames = [Frame::default(); BLOCK_TICKS];
        match local.bench {
            Some(bench) => bench.block(outputs, &mut frames),
            None => frames = local.sampler.take(arrived.half, tripped),
        }
        let stale = block_monitor::take_stale() || arrived.failed || !arrived.any;
        let late = arrived.lost && !block_monitor::is_paused();
        let record = context.shared.recorder.lock(|recorder| {
            if late {
                recorder.note_overrun();
            }
            recorder.block((!stale).then_some(&frames), outputs);
            *local.wired = recorder.controller().settings().interlock;
            recorder.controller().fault().copied()
        });
        let in_time = if arrived.any {
            local.set_points.play(arrived.half, outputs) || block_monitor::is_paused()
        } else {
            // Whichever of them is played: nothing tells.
            for half in nucleo::HALVES {
                local.set_points.play(half, outputs);
            }
            true
        };
        if let Some(enable) = local.enable {
            enable.apply(outputs.iter().all(|output| output.enable), tripped);
        }
        // The drive is off; a reset from here on finds the fault.
        local.keeper.after_block(record.as_ref(), retained::keep);
        if arrived.any {
            block_monitor::block_served();
        }

        let cycles = DWT::cycle_count().wrapping_sub(began);
        let [last, longest] = &CYCLES;
        last.store(cycles, Ordering::Relaxed);
        longest.fetch_max(cycles, Ordering::Relaxed);
        if local.sampler.overrun() || !in_time {
            context.shared.recorder.lock(Recorder::note_overrun);
        }
    }

    /// The emergency-stop chain has opened: the enable goes low at once. The controller sees the open chain with
    /// its next block.
    #[task(binds = EXTI9_5, priority = 4)]
    fn emergency(_: emergency::Context) {
        drive::take_away();
        drive::acknowledge();
    }

    /// The supply drops.
    #[task(binds = PVD, priority = 4)]
    fn supply(_: supply::Context) {
        nucleo::supply_dropped();
    }

    /// Checks that blocks are being served.
    #[task(binds = TIM7, priority = 4, local = [block_monitor])]
    fn watch_blocks(context: watch_blocks::Context) {
        context.local.block_monitor.check();
    }

    /// Serves the link, and every tenth time calls the supervisor.
    #[task(binds = TIM6_DAC, priority = 2, shared = [recorder, forecast],
        local = [serial, rate, link_timer, session, store, turns: u32 = 0, boot: u32 = 0])]
    fn link(mut context: link::Context) {
        let local = context.local;
        local.link_timer.acknowledge();
        while context
            .shared
            .recorder
            .lock(|recorder| recorder.takes_commands())
        {
            let Some(byte) = local.serial.read() else {
                break;
            };
            if *local.boot == 0 {
                // Processor cycles until a program on a computer first sent something: never the same twice.
                *local.boot = DWT::cycle_count() | 1;
            }
            let mut device = BoardLink {
                recorder: &mut context.shared.recorder,
                forecast: &mut context.shared.forecast,
                settings_store: local.store,
                board: "NUCLEO-F446RE",
                boot: *local.boot,
            };
            local.session.receive(byte, &mut device);
        }
        let mut device = BoardLink {
            recorder: &mut context.shared.recorder,
            forecast: &mut context.shared.forecast,
            settings_store: local.store,
            board: "NUCLEO-F446RE",
            boot: *local.boot,
        };
        local.session.poll(&mut device);
        local
            .serial
            .send(|bytes| local.session.queue().drain(bytes));
        let good = local.session.counters().good;
        if let Some(baud) = local.rate.turn(local.serial.take_errors(), good) {
            local.serial.set_rate(baud);
        }
        LINKS.fetch_add(1, Ordering::Relaxed);
        *local.turns = local.turns.wrapping_add(1);
        if local.turns.is_multiple_of(10) {
            // Refused while the last one runs; then the watchdog is not fed.
            let _ = supervise::spawn();
        }
    }

    /// Button, LED, watchdog, and the log.
    #[task(priority = 1, shared = [recorder], local = [supervisor])]
    async fn supervise(mut context: supervise::Context) {
        let own: &mut Supervisor = context.local.supervisor;
        let (status, awaited) = context.shared.recorder.lock(|recorder| {
            let controller = recorder.controller();
            (controller.status(), controller.awaits_acknowledgement())
        });
        if own.button.step(own.pin.is_pressed()) {
            let command = button::meaning(status.state, awaited);
            if let Err(why) = context
                .shared
                .recorder
                .lock(|recorder| recorder.command(command))
            {
                log::refused(why);
            }
        }
        let shown = Shown {
            state: status.state,
            fault: status.fault.map_or(0, |record| record.fault.code()),
            bench: own.bench,
        };
        own.led.set(own.pattern.step(shown));
        let progress = Progress {
            blocks: block_monitor::blocks_served(),
            links: LINKS.load(Ordering::Relaxed),
            idles: IDLES.load(Ordering::Relaxed),
        };
        if own.liveness.step(progress) {
            own.watchdog.feed();
        }
        while let Some(event) = context
            .shared
            .recorder
            .lock(|recorder| recorder.taking().take_event())
        {
            log::event(&event.kind);
        }
        own.steps = own.steps.wrapping_add(1);
        if own.steps.is_multiple_of(100) {
            if status.events_dropped > 0 {
                defmt::warn!("{=u16} events were lost", status.events_dropped);
            }
            let [last, longest] = &CYCLES;
            defmt::info!(
                "{=str} {=f32} Hz, peak {=f32} N, cycles per block: last {=u32}, longest {=u32}, stack {=usize} B",
                log::state_name(status.state),
                status.frequency_hz,
                status.peak_n,
                last.load(Ordering::Relaxed),
                longest.swap(0, Ordering::Relaxed),
                stack::peak(),
            );
        }
    }

    /// The forecast, a slice at a time, in idle time.
    #[idle(shared = [recorder, forecast], local = [forecaster])]
    fn idle(mut context: idle::Context) -> ! {
        let forecaster: &mut Forecaster = context.local.forecaster;
        let mut waiting = false;
        loop {
            let recorder = &mut context.shared.recorder;
            if let Some(request) = recorder.lock(|recorder| recorder.taking().forecast_request()) {
                forecaster.start(&request);
                waiting = true;
            }
            let busy = forecaster.slice();
            if let Some(result) = forecaster.result().filter(|_| waiting && !busy) {
                waiting = false;
                context.shared.forecast.lock(|last| last.clone_from(result));
                recorder.lock(|recorder| recorder.deliver(result));
            }
            IDLES.fetch_add(1, Ordering::Relaxed);
        }
    }
}
