//! A link-time check, not to be run. It links only if no panic can be reached from the
//! control task, the forecast's slices, or the decoding of bytes from the link.
//!
//! The panic handler calls a function that nobody defines. As long as a panic
//! is left in the program after optimisation, so is the handler, and the linker
//! names the missing function.
#![no_main]
#![no_std]
#![allow(unsafe_code)]

use core::hint::black_box;

use cortex_m_rt::entry;
use firmware::{
    BLOCK_TICKS,
    bench::Bench,
    interlock::{Inputs, InterlockInputs},
    ramp::Ramp,
    record_keeper::RecordKeeper,
    recorder::ControlRecorder,
    reference::RunReadings,
};
use shared::control::{BootInfo, Controller, Lockstep, MAX_BLOCK};
use shared::io::{Frame, Output};
use shared::link::{Decoder, FromBoard, MAX_FRAME, Packet, Recording, ToBoard, encode};
use shared::model::params::WIRES;
use shared::settings::Settings;

#[entry]
fn main() -> ! {
    let settings = Settings::for_rig(&WIRES);
    let node = Lockstep::new(&black_box(settings), &black_box(BootInfo::STORED));
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
        board(&settings);
        link();
    }
}

/// A block as the board runs it, in bench mode and recorded.
#[inline(never)]
fn board(settings: &Settings) {
    let Ok(controller) = Controller::new(settings, &black_box(BootInfo::STORED)) else {
        return;
    };
    let mut recorder = ControlRecorder::new(controller);
    let mut bench = Bench::new(settings);
    let mut outputs = black_box([Output::SAFE; BLOCK_TICKS]);
    let mut frames = [Frame::default(); BLOCK_TICKS];
    recorder.record(black_box(true));
    let (mut ramp, mut keeper) = black_box((Ramp::default(), RecordKeeper::default()));
    let (mut interlock, mut reference) =
        black_box((InterlockInputs::default(), RunReadings::default()));
    let inputs = Inputs {
        dropped: true,
        ready: true,
    };
    for _ in 0..black_box(9) {
        bench.block(&outputs, &mut frames);
        let _ = recorder.command(black_box(shared::control::Command::Stop));
        black_box(reference.is_lost(black_box(1500), black_box(1500)));
        black_box(interlock.contradicts(black_box(true), black_box(inputs), settings.interlock));
        recorder.block(black_box(Some(&frames)), &mut outputs);
        keeper.after_block(recorder.controller().fault(), |record| {
            black_box(record);
        });
        for output in &outputs {
            black_box(ramp.step(output));
        }
        black_box((&ramp, &keeper));
        while let Some(exchange) = recorder.take_block() {
            black_box(Recording::pack(&exchange));
        }
    }
}

/// Bytes from the wire into a packet, and a packet into bytes.
#[inline(never)]
fn link() {
    let mut decoder = Decoder::new();
    let mut frame = [0; MAX_FRAME];
    for byte in black_box([0_u8; 64]) {
        if let Some(Packet { message, sequence }) = decoder.push::<ToBoard>(byte) {
            black_box(message);
            let packet = Packet {
                sequence,
                message: black_box(None::<FromBoard>),
            };
            black_box(encode(&packet, &mut frame));
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
