//! The controller on the NUCLEO-F446RE: which interrupt starts which task.
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
//! In bench mode (docs/flashing.md) the model takes the place of the rig: the samples come from
//! [`firmware::bench::Bench`], and the drive's enable line, kept low, is not handed to any task.
#![no_main]
#![no_std]

#[rtic::app(device = firmware::hardware::board::pac, dispatchers = [UART4, UART5])]
mod app {
    use firmware::hardware::{
        board,
        tasks::{self, Control, Forecasts, Link, Supervisor, drive},
    };
    use firmware::recorder::ControlRecorder;
    use shared::forecast::Forecast;

    #[shared]
    struct Shared {
        recorder: ControlRecorder,
        forecast: Forecast,
    }

    #[local]
    struct Local {
        control: Control,
        block_monitor: board::BlockMonitor,
        link: Link,
        supervisor: Supervisor,
        forecasts: Forecasts,
    }

    #[init]
    fn init(context: init::Context) -> (Shared, Local) {
        let tasks = tasks::start(context.core, context.device);
        let shared = Shared {
            recorder: tasks.recorder,
            forecast: Forecast::default(),
        };
        let local = Local {
            control: tasks.control,
            block_monitor: tasks.block_monitor,
            link: tasks.link,
            supervisor: tasks.supervisor,
            forecasts: Forecasts::default(),
        };
        (shared, local)
    }

    /// A block of samples is complete.
    #[task(binds = DMA2_STREAM0, priority = 3, shared = [recorder], local = [control])]
    fn control(mut context: control::Context) {
        context.local.control.block(&mut context.shared.recorder);
    }

    /// The emergency-stop chain has opened: the enable goes low at once. The controller sees the open chain with
    /// its next block.
    #[task(binds = EXTI9_5, priority = 4)]
    fn emergency(_: emergency::Context) {
        drive::take_away();
        board::acknowledge_chain();
    }

    /// The supply drops: the enable goes low; if the drive was on, a record and a reset follow.
    #[task(binds = PVD, priority = 4)]
    fn supply(_: supply::Context) {
        board::supply_dropped();
    }

    /// Checks that blocks are being served.
    #[task(binds = TIM7, priority = 4, local = [block_monitor])]
    fn watch_blocks(context: watch_blocks::Context) {
        context.local.block_monitor.check();
    }

    /// Serves the link, and every tenth time calls the supervisor.
    #[task(binds = TIM6_DAC, priority = 2, shared = [recorder, forecast], local = [link])]
    fn link(context: link::Context) {
        let (mut recorder, mut forecast) = (context.shared.recorder, context.shared.forecast);
        if context.local.link.turn(&mut recorder, &mut forecast) {
            // Refused while the last one runs; then the watchdog is not fed.
            let _ = supervise::spawn();
        }
    }

    /// Button, LED, watchdog, and the log.
    #[task(priority = 1, shared = [recorder], local = [supervisor])]
    async fn supervise(mut context: supervise::Context) {
        context.local.supervisor.step(&mut context.shared.recorder);
    }

    /// The forecast, a slice at a time, in idle time.
    #[idle(shared = [recorder, forecast], local = [forecasts])]
    fn idle(context: idle::Context) -> ! {
        let (mut recorder, mut forecast) = (context.shared.recorder, context.shared.forecast);
        loop {
            context.local.forecasts.turn(&mut recorder, &mut forecast);
        }
    }
}
