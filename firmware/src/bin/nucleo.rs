//! The controller on the NUCLEO-F446RE.
//!
//! A skeleton yet: the model runs on the board in real time and the drive stays
//! off. Two tasks: `control` at 20 kHz, above everything else, and `report` for
//! what may take its time. They share nothing; a report travels by value, and one
//! that finds the last still in work is dropped, which its sequence number shows.
#![no_main]
#![no_std]

#[rtic::app(device = stm32f4xx_hal::pac, dispatchers = [UART4])]
mod app {
    use firmware::{
        control::{Control, Report},
        hardware::nucleo::{Board, ControlTimer},
        monitor::Monitor,
    };
    use stm32f4xx_hal::gpio::{Output, PA5};

    #[shared]
    struct Shared {}

    #[local]
    struct Local {
        control: Control,
        timer: ControlTimer,
        monitor: Monitor,
        led: PA5<Output>,
    }

    #[init]
    fn init(context: init::Context) -> (Shared, Local) {
        let mut board = Board::new(context.device);
        let Ok(control) = Control::new() else {
            panic!("the preset rig is refused by its own check");
        };
        defmt::info!("control starts, drive is off");
        assert!(board.timer.start(), "no timer setting gives the tick rate");
        let local = Local {
            monitor: Monitor::new(&control),
            control,
            timer: board.timer,
            led: board.led,
        };
        (Shared {}, local)
    }

    /// Steps the model by one tick.
    ///
    /// Deadline: 50 µs after the timer's update, when the next one is due. A tick
    /// that ends later has overrun: the next starts at once, late; if yet another
    /// was due by then, that one is lost and the model falls behind the clock.
    /// Overruns are counted and reported.
    #[task(binds = TIM2, priority = 2, local = [control, timer, overruns: u32 = 0])]
    fn control(context: control::Context) {
        let local = context.local;
        local.timer.acknowledge();
        if let Some(report) = local.control.tick() {
            // Refused while the last report is in work.
            let _ = report::spawn(report, *local.overruns);
        }
        if local.timer.overrun() {
            *local.overruns = local.overruns.saturating_add(1);
        }
    }

    /// Shows life on the LED with every drive period, and logs every window of
    /// them. No deadline but the next report, a drive period away.
    ///
    /// Writing a log frame holds interrupts off for as long as it takes to copy,
    /// so frames are short and their numbers are formatted on the host.
    #[task(priority = 1, local = [monitor, led])]
    async fn report(context: report::Context, report: Report, overruns: u32) {
        let local = context.local;
        local.led.toggle();
        if let Some(window) = local.monitor.take(&report) {
            defmt::info!(
                "regime {=u16}/{=u8}, {=u32} contacts, force ratio {=f32}",
                window.regime.impacts(),
                window.regime.periods().unwrap_or(0),
                window.contacts,
                window.force_ratio,
            );
            if overruns > 0 || window.lost > 0 {
                defmt::warn!(
                    "{=u32} overruns, {=u32} reports lost",
                    overruns,
                    window.lost
                );
            }
        }
    }
}
