//! The end of the program after a panic or a fault, once the outputs are safe.

use core::{
    panic::PanicInfo,
    sync::atomic::{AtomicBool, Ordering},
};

use shared::control::Unfit;

use super::retained;
use crate::hardware::{board, fault::ProcessorFault};

/// Whether a panic or fault is being reported.
static REPORTING: AtomicBool = AtomicBool::new(false);

/// Retains a panic for the next run, logs it and ends this one.
pub fn report_panic(info: &PanicInfo) -> ! {
    // A panic within a log call would find the logger taken, and panic again.
    if !REPORTING.swap(true, Ordering::Relaxed) {
        retained::note_crash(None, 0);
        defmt::error!("panic: {}", defmt::Display2Format(info));
    }
    end()
}

/// Retains a fault for the next run, logs it and ends this one.
pub fn report_fault(fault: &ProcessorFault) -> ! {
    if !REPORTING.swap(true, Ordering::Relaxed) {
        retained::note_crash(fault.address, fault.status);
        match fault.address {
            Some(pc) => defmt::error!("fault at {=u32:#010x}, CFSR {=u32:#x}", pc, fault.status),
            None => defmt::error!(
                "fault with the stack overflowed, CFSR {=u32:#x}",
                fault.status
            ),
        }
    }
    end()
}

/// Makes the outputs safe, retains why the board is not fit to drive any more, logs it and ends this run.
pub fn unfit(why: Unfit) -> ! {
    board::make_outputs_safe();
    if !REPORTING.swap(true, Ordering::Relaxed) {
        retained::note_unfit(why);
        defmt::error!("not fit to drive, reasons {=u8}", why.bits());
    }
    end()
}

/// Time for a debugger to fetch the last lines of the log, in turns of 3 to 4 cycles: 20 ms at 180 MHz, a
/// quarter of a second on the power-up clock.
const FETCHING: u32 = 1_000_000;

/// A reset, after which the controller starts in Fault with the retained record. There is no breakpoint for a debugger: a
/// processor that stands still watches over nothing.
fn end() -> ! {
    cortex_m::interrupt::disable();
    board::feed_watchdog();
    cortex_m::asm::delay(FETCHING);
    cortex_m::peripheral::SCB::sys_reset()
}
