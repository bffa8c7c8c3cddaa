//! The controller on QEMU's MPS2 AN386: the same control task as on the board, in
//! the same app structure.
//!
//! Time here is lock-step: nothing ticks but `idle`, which pends the control
//! interrupt as soon as the last tick is done. So a run is the same every time,
//! and takes as long as the computing does. It ends with success if the hammer
//! has settled to the regime it must have.
#![no_main]
#![no_std]

use cortex_m_rt as _;

#[rtic::app(device = firmware::hardware::qemu::device, peripherals = false)]
mod app {
    use cortex_m::peripheral::SCB;
    use cortex_m_semihosting::hprintln;
    use firmware::{
        control::{Control, FREQUENCY_RATIO, RIG, Report},
        hardware::qemu,
        monitor::Monitor,
    };

    /// Windows run; all but the last let the start die away.
    const WINDOWS: u32 = 3;

    #[shared]
    struct Shared {
        report: Option<Report>,
    }

    #[local]
    struct Local {
        control: Control,
        monitor: Monitor,
    }

    #[init]
    fn init(_: init::Context) -> (Shared, Local) {
        let Ok(control) = Control::new() else {
            panic!("the preset rig is refused by its own check");
        };
        let drive_hz = control.twin().drive().frequency_hz();
        hprintln!(
            "gap {:.1} mm, drive {:.3} Hz, ratio {:.2}",
            RIG.gap_m * 1e3,
            drive_hz,
            FREQUENCY_RATIO
        );
        let local = Local {
            monitor: Monitor::new(&control),
            control,
        };
        (Shared { report: None }, local)
    }

    /// Lets time pass, listens to the control task, and ends the run.
    #[idle(shared = [report], local = [monitor])]
    fn idle(mut context: idle::Context) -> ! {
        let (mut ticks, mut windows) = (0_u32, 0_u32);
        loop {
            SCB::set_pendst();
            ticks += 1;
            let report = context.shared.report.lock(Option::take);
            let Some(window) = report.and_then(|report| context.local.monitor.take(&report)) else {
                continue;
            };
            windows += 1;
            hprintln!(
                "tick {}: regime {}, {} contacts, force ratio {:.2}",
                ticks,
                window.regime,
                window.contacts,
                window.force_ratio
            );
            if windows == WINDOWS {
                qemu::exit(window.regime.is(1, 1) && window.lost == 0);
            }
        }
    }

    /// Steps the model by one tick. Deadline: none, time waits for it here.
    #[task(binds = SysTick, priority = 2, shared = [report], local = [control])]
    fn control(mut context: control::Context) {
        if let Some(report) = context.local.control.tick() {
            context.shared.report.lock(|slot| *slot = Some(report));
        }
    }
}
