//! The controller on QEMU's MPS2 AN386 in bench mode, as on a bare board: the model takes the place of the rig.
//!
//! Time here is lock-step: nothing ticks but `idle`, which pends the control interrupt as soon as the last block
//! and its slices of the forecast are done. So a run is the same every time, and takes as long as the computing
//! does. It ends with success if the controller has reached Hold by itself and stayed there, and prints how
//! much stack and how many instructions that took (under `-icount shift=0`; `cargo xtask size` holds them to
//! their budgets).
#![no_main]
#![no_std]

use cortex_m_rt as _;

#[rtic::app(device = firmware::hardware::board::device, peripherals = false)]
mod app {
    use cortex_m::peripheral::SCB;
    use cortex_m_semihosting::hprintln;
    use firmware::{
        BLOCK_TICKS,
        bench::Bench,
        hardware::{
            board::{self, SysTickStopwatch},
            stack,
        },
        histogram::Histogram,
    };
    use shared::{
        control::{BootInfo, Command, Lockstep, Mode, SettingsState, State},
        io::{Frame, Output},
        model::cart::{ASSUMED_SHAKER, CartDrive},
        model::params::{RigParams, WIRES},
        settings::{Settings, TICK_RATE_HZ},
    };

    /// Slices of the forecast per block.
    const SLICES: u32 = 20;
    /// Hold must be reached within this long, s of rig time.
    const WITHIN_S: u32 = 300;
    /// Hold must then last this long, s.
    const KEPT_S: u32 = 10;

    #[shared]
    struct Shared {
        lockstep: Lockstep,
        histogram: Histogram,
    }

    #[local]
    struct Local {
        bench: Bench,
        outputs: [Output; BLOCK_TICKS],
        stopwatch: SysTickStopwatch,
    }

    #[init]
    fn init(context: init::Context) -> (Shared, Local) {
        // The model's cart does not recoil; the forecast's does, since that is the one that needs more.
        let settings = Settings::for_rig(&RigParams {
            cart: CartDrive::Loop(ASSUMED_SHAKER),
            ..WIRES
        });
        let boot = BootInfo {
            settings: SettingsState::Model,
            ..BootInfo::STORED
        };
        let Ok(mut lockstep) = Lockstep::new(&settings, &boot) else {
            panic!("the preset's settings are refused by their own check");
        };
        let started = lockstep.controller.command(Command::Start(Mode::Automatic));
        assert!(started.is_ok(), "a start in Idle is refused");
        let local = Local {
            bench: Bench::new(&settings),
            outputs: [Output::SAFE; BLOCK_TICKS],
            stopwatch: SysTickStopwatch::start(context.core.SYST),
        };
        let shared = Shared {
            lockstep,
            histogram: Histogram::default(),
        };
        (shared, local)
    }

    /// Lets time pass, prints events, and ends the run.
    #[idle(shared = [lockstep, histogram])]
    fn idle(mut context: idle::Context) -> ! {
        let mut held_since = None;
        loop {
            SCB::set_pendst();
            cortex_m::asm::isb();
            let (status, event) = context.shared.lockstep.lock(|lockstep| {
                lockstep.idle(SLICES);
                (
                    lockstep.controller.status(),
                    lockstep.controller.take_event(),
                )
            });
            if let Some(event) = event {
                let seconds = event.tick as f32 / TICK_RATE_HZ as f32;
                hprintln!("{:8.2} s  {:?}", seconds, event.kind);
            }
            held_since = match (status.state, held_since) {
                (State::Hold, None) => Some(status.tick),
                (State::Hold, since) => since,
                _ => None,
            };
            let kept = held_since.is_some_and(|since| status.tick - since >= KEPT_S * TICK_RATE_HZ);
            let too_long = status.tick >= WITHIN_S * TICK_RATE_HZ;
            if kept || too_long || status.state == State::Fault {
                let (used, reserved) = (stack::peak(), stack::reserved());
                hprintln!(
                    "{:?} at {:.3} Hz, peak {:.1} N, regime {}; forecast {:.3} Hz, {:.1} N",
                    status.state,
                    status.frequency_hz,
                    status.peak_n,
                    status.regime,
                    status.target_hz,
                    status.target_n
                );
                hprintln!("stack {} of {}", used, reserved);
                let (median, worst) = context.shared.histogram.lock(|t| (t.median(), t.worst()));
                hprintln!(
                    "instructions per tick, each block's mean: median {}, worst {}",
                    median,
                    worst
                );
                board::exit(kept && used < reserved);
            }
        }
    }

    /// A block. Deadline: none, time waits for it here.
    #[task(binds = SysTick, priority = 2, shared = [lockstep, histogram], local = [bench, outputs, stopwatch])]
    fn control(mut context: control::Context) {
        let outputs: &mut [Output; BLOCK_TICKS] = context.local.outputs;
        let mut frames = [Frame::default(); BLOCK_TICKS];
        context.local.bench.block(outputs, &mut frames);
        let stopwatch: &SysTickStopwatch = context.local.stopwatch;
        let began = stopwatch.now();
        context
            .shared
            .lockstep
            .lock(|lockstep| lockstep.block(&frames, outputs));
        let instructions = stopwatch.since(began) * board::NANOSECONDS;
        let per_tick = instructions.div_ceil(BLOCK_TICKS as u32);
        context
            .shared
            .histogram
            .lock(|histogram| histogram.add(per_tick));
    }
}
