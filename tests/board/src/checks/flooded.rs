//! A computer that floods the wire: the drive hears the button all the same.

use shared::control::State;
use shared::link::{BAUD, MAX_FRAME, Packet, ToBoard, encode};

use super::session::Bench;
use super::{Found, Setup, must};
use crate::core::nvic::FIRST;
use crate::parts::UNITS_PER_S;
use crate::parts::gpio::Outside;
use crate::parts::interrupt;
use crate::rig::port;

/// Flooded before the button is pressed, pressed, and flooded after that, ms.
const BEFORE_MS: u64 = 2_500;
const PRESSED_MS: u64 = 60;
const AFTER_MS: u64 = 2_500;
/// Turns that the link may miss, of 1,000 in a second.
const MISSED: u64 = 10;

/// What the computer sends again and again: requests of three kinds, the ends of frames, and noise.
fn floods() -> Result<Vec<(String, Vec<u8>)>, &'static str> {
    let mut floods = vec![
        ("zeros".into(), vec![0]),
        (
            "noise".into(),
            (0..5_003_u32)
                .map(|i| (i.wrapping_mul(2_654_435_761) >> 24) as u8)
                .collect(),
        ),
    ];
    for message in [ToBoard::GetStatus, ToBoard::GetSettings, ToBoard::Hello] {
        let name = format!("{message:?}");
        let sequence = 1;
        let mut place = [0; MAX_FRAME];
        let frame = encode(&Packet { sequence, message }, &mut place).ok_or("no frame")?;
        floods.push((name, frame.to_vec()));
    }
    Ok(floods)
}

/// Bytes without a break at the wire's rate while it drives: link and supervisor keep their turns, the button stops the drive, and
/// the watchdog is content.
pub fn flooded(setup: &Setup) -> Found {
    let mut most = 0;
    let mut units = 0;
    let floods = floods()?;
    for (name, bytes) in &floods {
        let mut bench = Bench::driving(setup)?;
        let from = bench.now();
        // The supervisor's is every tenth of the link's.
        let tasks = [(interrupt::TIM6, 1), (interrupt::UART5, 10)];
        let turns = tasks.map(|(task, every)| every * bench.entered(FIRST + task));
        let bytes_per_ms = (BAUD / 10_000) as usize;
        let mut wire = bytes.iter().copied().cycle();
        let mut flood = |bench: &mut Bench, ms: u64| -> Result<(), Box<dyn std::error::Error>> {
            for _ in 0..ms {
                let bytes: Vec<u8> = wire.by_ref().take(bytes_per_ms).collect();
                bench.rig.borrow_mut().machine.send(&bytes);
                bench.advance_ms(1)?;
                bench.rig.borrow_mut().machine.parts.usart.sent.clear();
            }
            Ok(())
        };
        flood(&mut bench, BEFORE_MS)?;
        for ((task, every), before) in tasks.into_iter().zip(turns) {
            let now = every * bench.entered(FIRST + task);
            let missed = BEFORE_MS.saturating_sub(now - before);
            must(missed <= MISSED * BEFORE_MS / 1_000, || {
                format!("{name}: interrupt {task} has missed {missed} of {BEFORE_MS} ms")
            })?;
            most = most.max(missed);
        }
        let driven = bench.rig.borrow_mut().is_driven();
        must(driven, || format!("{name}: the drive went off"))?;
        let press = |bench: &Bench, level| {
            bench.rig.borrow_mut().machine.set_pin(port::C, 13, level);
        };
        press(&bench, Outside::Low);
        flood(&mut bench, PRESSED_MS)?;
        press(&bench, Outside::High);
        flood(&mut bench, AFTER_MS)?;
        // What still lies in the ring is answered.
        bench.advance_ms(200)?;
        bench.rig.borrow_mut().machine.parts.usart.sent.clear();
        bench.must_be(State::Idle)?;
        units += bench.now() - from;
    }
    Ok((
        format!(
            "zeros, noise, GetStatus, GetSettings and Hello at {BAUD} Bd for {:.1} s each: the button stops the drive, {most} of \
             {BEFORE_MS} ms without a turn of link or supervisor at most",
            (units / floods.len() as u64) as f64 / UNITS_PER_S as f64
        ),
        units,
    ))
}
