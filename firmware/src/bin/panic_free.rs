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
use shared::control::{Birth, Lockstep, MAX_BLOCK};
use shared::io::{Frame, Output};
use shared::params::WIRES;
use shared::settings::Settings;

#[entry]
fn main() -> ! {
    let settings = Settings::for_rig(&WIRES);
    let node = Lockstep::new(&black_box(settings), &black_box(Birth::default()));
    let mut outputs = [Output::SAFE; MAX_BLOCK];
    let Ok(mut node) = node else { loop {} };
    loop {
        let frames = black_box([Frame::default(); MAX_BLOCK]);
        node.exchange(&frames, &mut outputs, black_box(3));
        black_box(&outputs);
        let _ = node
            .controller
            .command(black_box(shared::control::Command::Alive));
        node.controller.note_overrun();
        node.exchange_blind(&mut outputs, black_box(3));
        let _ = node.controller.replace_settings(&black_box(settings));
        black_box(node.controller.status());
        black_box(node.controller.take_event());
    }
}

#[panic_handler]
fn panic(_: &core::panic::PanicInfo) -> ! {
    unsafe extern "C" {
        safe fn a_panic_can_be_reached_from_the_control_task() -> !;
    }
    a_panic_can_be_reached_from_the_control_task()
}
