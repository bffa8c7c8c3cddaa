//! The end of the program after a panic or a fault, once the outputs are safe.

use core::{
    panic::PanicInfo,
    sync::atomic::{AtomicBool, Ordering},
};

use super::retained;
use crate::hardware::fault::ProcessorFault;

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

/// A breakpoint for the debugger, if one is attached, and then standstill; else a reset, after which the
/// controller starts in Fault with the retained record.
fn end() -> ! {
    cortex_m::interrupt::disable();
    if cortex_m::peripheral::DCB::is_debugger_attached() {
        cortex_m::asm::bkpt();
        loop {
            cortex_m::asm::nop();
        }
    }
    cortex_m::peripheral::SCB::sys_reset()
}
