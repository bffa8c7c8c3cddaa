//! The controller on the NUCLEO-G474RE: which interrupt starts which task. The board drives nothing yet (README.md).
//!
//! | task | priority | runs | deadline |
//! |---|---|---|---|
//! | `supply` | 4 | when the supply drops | the same as `emergency` |
//! | `emergency` | 4 | when the emergency-stop chain opens | none later than itself: a few stores |
//! | `watch_blocks` | 4 | 1 kHz | the same |
//! | `control` | 3 | each block of 10 ticks, 2 kHz; retains a fault's record | 492 µs |
//! | `link` | 2 | 1 kHz | 1 ms; what comes later is sent later |
//! | `supervise` | 1 | 100 Hz | 10 ms; the watchdog is not fed without it |
//! | `idle` | 0 | always | none; the forecast takes what time is left |
#![no_main]
#![no_std]

#[rtic::app(device = firmware::hardware::board::pac, dispatchers = [UART4, UART5])]
mod app {
    use firmware::hardware::{
        board,
        tasks::{self, Control, Forecasts, Link, Supervisor, drive},
    };
    use firmware::recorder::Recorder;
    use shared::forecast::Forecast;

    #[shared]
    struct Shared {
        recorder: Recorder,
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
    #[task(binds = DMA1_CH1, priority = 3, shared = [recorder], local = [control])]
    fn control(mut context: control::Context) {
        context.local.control.block(&mut context.shared.recorder);
    }

    /// The emergency-stop chain has opened.
    #[task(binds = EXTI9_5, priority = 4)]
    fn emergency(_: emergency::Context) {
        drive::take_away();
        board::acknowledge_chain();
    }

    /// The supply drops.
    #[task(binds = PVD_PVM, priority = 4)]
    fn supply(_: supply::Context) {
        board::supply_dropped();
    }

    /// Checks that blocks are being served.
    #[task(binds = TIM7, priority = 4, local = [block_monitor])]
    fn watch_blocks(context: watch_blocks::Context) {
        context.local.block_monitor.check();
    }

    /// Serves the link, and every tenth time calls the supervisor.
    #[task(binds = TIM6_DACUNDER, priority = 2, shared = [recorder, forecast], local = [link])]
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
