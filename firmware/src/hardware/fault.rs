//! Panics and processor faults, the same on every board: outputs are made safe,
//! then the fault is reported, then the program ends.
#![allow(unsafe_code)]

use core::{arch::naked_asm, panic::PanicInfo};

use cortex_m::peripheral::SCB;
use cortex_m_rt::ExceptionFrame;

use super::board;

/// What is known of a processor fault.
pub struct ProcessorFault {
    /// The instruction it happened at; unknown if the stack had overflowed.
    pub address: Option<u32>,
    /// The processor's account of it, CFSR.
    pub status: u32,
}

#[panic_handler]
fn panic(info: &PanicInfo) -> ! {
    cortex_m::interrupt::disable();
    board::make_outputs_safe();
    board::report_panic(info)
}

/// Every fault ends here, among them the one of a stack that has left RAM: then
/// there is no stack to run on. So a fresh one is taken before anything else.
#[unsafe(naked)]
#[unsafe(no_mangle)]
unsafe extern "C" fn HardFault() -> ! {
    naked_asm!(
        "mrs r0, msp",
        "movw r1, #:lower16:_stack_start",
        "movt r1, #:upper16:_stack_start",
        "msr msp, r1",
        "b {on_fresh_stack}",
        on_fresh_stack = sym on_fresh_stack,
    )
}

/// Goes on from [`HardFault`] with the stack pointer as it was.
extern "C" fn on_fresh_stack(frame: usize) -> ! {
    board::make_outputs_safe();

    unsafe extern "C" {
        static _stack_start: u8;
        static _stack_end: u8;
    }
    let (top, bottom) = (
        &raw const _stack_start as usize,
        &raw const _stack_end as usize,
    );
    let readable = frame >= bottom && frame <= top - size_of::<ExceptionFrame>();
    // SAFETY: the processor has put a frame there, and it lies within the stack.
    // The new stack may grow over it only after this.
    let address = readable.then(|| unsafe { (*(frame as *const ExceptionFrame)).pc() });
    // SAFETY: a read without side effect of a register that is always there.
    let status = unsafe { (*SCB::PTR).cfsr.read() };
    board::report_fault(&ProcessorFault { address, status })
}
