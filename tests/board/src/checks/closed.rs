//! The closed loop: board and plant, recorded over the link, compared with the desktop's controller.

use emulator::log::LogReader;
use files::made_from::MadeFrom;
use host_sim::link::recording::record;
use host_sim::progress::ProgressLine;
use host_sim::replay::replay;
use shared::control::{Command, Mode};

use super::session::Bench;
use super::{Found, Setup, must};
use crate::core::nvic::FIRST;
use crate::parts::interrupt;

/// Ticks from a sample to its set-point: a block gathered and a block worked on.
const LATENCY: usize = 20;

/// Requests after it: more bytes than the board's receive ring has.
const REQUESTS: usize = 300;

/// A step of the duty cycle, Hz.
const FREQUENCY_STEP_HZ: f32 = 50.0 / 18_000.0;

/// The field scenario, started over the link: recorded at full rate, every decision compared with the desktop's bit for
/// bit, every set-point at the pin with the controller's.
pub fn field(setup: &Setup) -> Found {
    let (mut bench, hello) = Bench::idle(setup)?;
    let folder = tempfile::tempdir()?;
    let ticks = (setup.seconds * f64::from(hello.tick_rate_hz)) as u64;
    let start = Some(Command::Start(Mode::Automatic));
    let began = (bench.now(), bench.rig.borrow().machine.instructions);
    let control = FIRST + interrupt::DMA2[0];
    let blocks = bench.entered(control);
    let (log, _) = record(
        &mut bench.client,
        &hello,
        &folder.path().join("board"),
        &MadeFrom::this_program(),
        ticks,
        start,
        &|| false,
    )?;
    let mut status = bench.client.status()?;
    for _ in 0..REQUESTS {
        status = bench.client.status()?;
    }
    let replayed = replay(&mut LogReader::open(&log)?, &ProgressLine::new("", 1, true))?;
    must(replayed.difference.is_none(), || {
        format!("the desktop decides otherwise: {:?}", replayed.difference)
    })?;
    must(replayed.ticks >= ticks, || {
        format!("{} ticks replayed of {ticks}", replayed.ticks)
    })?;
    let played = played(&bench, &mut LogReader::open(&log)?)?;
    let machine = &bench.rig.borrow().machine;
    let seconds = (machine.now - began.0) as f64 / crate::parts::UNITS_PER_S as f64;
    let per_block =
        (machine.instructions - began.1) as f64 / (machine.entered[control] - blocks) as f64;
    let text = format!(
        "{} ticks recorded without a gap, decisions bit-equal to the desktop's, {played} set-points at PA4 equal; then in \
         {:?} with {} overruns, {} packets lost; {:.1} million instructions a second of rig time, {per_block:.0} a block, \
         idle included",
        replayed.ticks,
        status.state,
        status.overruns,
        bench.client.lost(),
        (machine.instructions - began.1) as f64 / seconds / 1e6,
    );
    Ok((text, machine.now))
}

/// The recorded set-points must be those at the pin, 20 ticks after the samples that they were worked out from.
fn played(bench: &Bench, log: &mut LogReader) -> Result<usize, Box<dyn std::error::Error>> {
    let mut recorded = Vec::new();
    while let Some(block) = log.block()? {
        recorded.extend(
            block
                .ticks
                .iter()
                .map(|tick| (tick.frame, tick.output.dac.0, tick.output.frequency_hz)),
        );
    }
    let rig = bench.rig.borrow();
    // Where the recording begins among the samples: at the first frame of it, found by all of its first 2,000.
    let head = &recorded[..recorded.len().min(2000)];
    let at = rig
        .sampled
        .windows(head.len())
        .position(|window| {
            window
                .iter()
                .zip(head)
                .all(|(sample, (frame, ..))| sample == frame)
        })
        .ok_or("the recorded samples are not those that the ADC was given")?;
    let codes: Vec<u16> = recorded.iter().map(|(_, code, _)| *code).collect();
    // The code played at a tick is noted when the tick begins; the first is read ahead.
    let offset = (LATENCY - 2..=LATENCY + 2).find(|offset| {
        let pins = rig.played.get(at + offset..).unwrap_or_default();
        pins.len() >= 2000 && pins.iter().zip(&codes).all(|(pin, code)| pin == code)
    });
    let offset = offset.ok_or("the codes at PA4 are not those of the controller")?;
    // A block's frequency is at PC7 before the next block's last tick, and stays for a block.
    let wrong = recorded
        .iter()
        .enumerate()
        .skip(9)
        .step_by(10)
        .find(|(i, tick)| {
            let pin = rig.frequencies.get(at + i + 9);
            pin.is_some_and(|hz| (hz - tick.2).abs() > FREQUENCY_STEP_HZ)
        });
    must(wrong.is_none(), || {
        format!("the duty cycle at PC7 is not the controller's frequency: {wrong:?}")
    })?;
    let compared = codes.len().min(rig.played.len() - at - offset);
    Ok(compared)
}
