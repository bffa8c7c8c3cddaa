//! A check, not to be run: links only if no panic can be reached from the
//! control task's work.
//!
//! The panic handler calls a function that nobody defines. As long as a panic
//! is left in the program after optimisation, so is the handler, and the linker
//! names the missing function.
#![no_main]
#![no_std]
#![allow(unsafe_code)]

use core::hint::black_box;

use cortex_m_rt::entry;
use firmware::control::Control;

#[entry]
fn main() -> ! {
    let control = Control::new();
    loop {
        if let Ok(mut control) = black_box(control) {
            black_box(control.tick());
        }
    }
}

#[panic_handler]
fn panic(_: &core::panic::PanicInfo) -> ! {
    unsafe extern "C" {
        safe fn a_panic_can_be_reached_from_the_control_task() -> !;
    }
    a_panic_can_be_reached_from_the_control_task()
}
