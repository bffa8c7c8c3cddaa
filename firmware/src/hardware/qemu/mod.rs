//! MPS2 AN386 as QEMU plays it: a Cortex-M4F that talks through semihosting.
//!
//! Text goes to QEMU's standard output, and the exit code is the run's verdict.

pub mod pipes;

use core::panic::PanicInfo;

use cortex_m_semihosting::{
    debug::{self, EXIT_FAILURE, EXIT_SUCCESS},
    hprintln,
};

use cortex_m::peripheral::{SYST, syst::SystClkSource};

use super::fault::ProcessorFault;

/// The processor's clock, which also feeds SysTick.
pub const CLOCK_HZ: u32 = 25_000_000;
/// Nanoseconds per count of SysTick.
pub const NANOSECONDS: u32 = 1_000_000_000 / CLOCK_HZ;

/// What RTIC expects to find in a device crate.
///
/// The app binds the processor's own SysTick alone, so no interrupt line of
/// this board needs a name.
pub mod device {
    pub use Interrupt as interrupt;

    /// Interrupt lines of the board in use: none.
    pub enum Interrupt {}

    /// Priority bits the board's interrupt controller implements.
    pub const NVIC_PRIO_BITS: u8 = 3;
}

/// SysTick counts down from here: 24 bits.
const SYSTICK_MASK: u32 = 0x00ff_ffff;

/// SysTick as a stopwatch. Under `-icount shift=0` QEMU lets a nanosecond go by per instruction, so what it
/// reads are instructions, in steps of 40; never cycles.
pub struct SysTickStopwatch(());

impl SysTickStopwatch {
    /// Starts SysTick on the processor's clock, as a stopwatch.
    pub fn start(mut systick: SYST) -> Self {
        systick.set_clock_source(SystClkSource::Core);
        systick.set_reload(SYSTICK_MASK);
        systick.clear_current();
        systick.enable_counter();
        Self(())
    }

    /// SysTick's count now; it counts down and wraps.
    #[inline]
    pub fn now(&self) -> u32 {
        SYST::get_current()
    }

    /// Counts since `before` (less than 0.6 s).
    #[inline]
    pub fn since(&self, before: u32) -> u32 {
        before.wrapping_sub(SYST::get_current()) & SYSTICK_MASK
    }
}

/// Ends the run with success or failure as QEMU's exit code.
pub fn exit(success: bool) -> ! {
    debug::exit(if success { EXIT_SUCCESS } else { EXIT_FAILURE });
    // Without semihosting there is nobody to hear it.
    loop {
        cortex_m::asm::nop();
    }
}

/// Nothing to do: this board drives nothing.
pub fn make_outputs_safe() {}

/// Prints a panic and fails the run.
pub fn report_panic(info: &PanicInfo) -> ! {
    hprintln!("{}", info);
    exit(false)
}

/// Prints a fault and fails the run.
pub fn report_fault(fault: &ProcessorFault) -> ! {
    match fault.address {
        Some(pc) => hprintln!("fault at {:#010x}, CFSR {:#x}", pc, fault.status),
        None => hprintln!("fault with the stack overflowed, CFSR {:#x}", fault.status),
    }
    exit(false)
}
