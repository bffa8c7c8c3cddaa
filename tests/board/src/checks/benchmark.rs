//! What a long run costs: interrupts, masks, stack, losses, and the bounds of a block's cycles.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use host_sim::progress::ProgressLine;
use shared::link::ToBoard;
use signal_hook::consts::TERM_SIGNALS;
use signal_hook::flag;

use super::session::Bench;
use super::{Found, Setup, must};
use crate::memory::RAM;
use crate::parts::UNITS_PER_S;
use crate::profile::USED;

/// What the stack is filled with before the program starts (cortex-m-rt, `paint-stack`).
const PAINT: [u8; 4] = [0xcc; 4];

/// When a block's set-points must be there, cycles after its interrupt (docs/wiring.md), and the whole block.
pub(super) const DEADLINE: u64 = 88_380;
const BLOCK: u64 = 90_000;

/// True once an interrupt (Ctrl-C, SIGTERM) has come: the first ends the benchmark, which then says what it has found so far;
/// any after it ends the program.
fn interrupted() -> Arc<AtomicBool> {
    let came = Arc::new(AtomicBool::new(false));
    for signal in TERM_SIGNALS {
        // Without a handler an interrupt ends the program at once.
        let _ = flag::register_conditional_shutdown(*signal, 130, came.clone());
        let _ = flag::register(*signal, came.clone());
    }
    came
}

/// The field scenario from the first pulse on, in the short form from Hold on: a contact's block takes longest. Streaming at full
/// rate.
pub fn benchmark(setup: &Setup) -> Found {
    let mut bench = match setup.short {
        Some(_) => Bench::holding(setup)?,
        None => Bench::driving(setup)?,
    };
    bench.client.hello()?;
    bench.client.tell(ToBoard::StreamFrames { on: true })?;
    let (from, before, counts) = {
        let rig = &mut bench.rig.borrow_mut();
        rig.keeps = false;
        rig.forget_changes();
        rig.machine.start_profile();
        (
            rig.machine.now,
            rig.machine.entered,
            [rig.machine.instructions, rig.machine.passed],
        )
    };
    let began = Instant::now();
    let end = from + (setup.seconds * UNITS_PER_S as f64) as u64;
    let mut streamed = 0u64;
    let progress = ProgressLine::new("seconds of rig time", setup.seconds as u64, false);
    let ends = interrupted();
    while bench.now() < end && !ends.load(Ordering::SeqCst) {
        bench.rig.borrow_mut().forget_changes();
        progress.inc(((bench.now() - from) / UNITS_PER_S).saturating_sub(progress.done()));
        streamed += u64::from(bench.client.streamed(Duration::from_millis(1))?.is_some());
    }
    let seconds = (bench.now() - from) as f64 / UNITS_PER_S as f64;
    progress.finish();
    ends.store(true, Ordering::SeqCst);
    let took_s = began.elapsed().as_secs_f64();
    let lost = bench.client.lost();
    bench.client.tell(ToBoard::StreamFrames { on: false })?;
    let status = bench.client.status()?;
    let rig = bench.rig.borrow();
    let machine = &rig.machine;
    let profile = machine.profile.as_deref().ok_or("no profile")?;
    let mut text = format!(
        "{seconds:.0} s, {streamed} messages, {lost} packets and {} bytes lost, {} overruns, in {:?}; stack {} B at most\n",
        machine.parts.usart.lost,
        status.overruns,
        status.state,
        stack(&rig.machine)?
    );
    let all = machine.instructions - counts[0];
    let passed = machine.passed - counts[1];
    text += &format!(
        "        {all} instructions, of them {passed} in waiting that was passed over; {took_s:.1} s for it: {:.1} million a \
         second, {:.3} s per second of rig time; fingerprint {:#018x}\n",
        all as f64 / took_s / 1e6,
        took_s / seconds,
        rig.fingerprint()
    );
    text +=
        "        interrupt                  count     per s   longest wait, cycles of the table\n";
    for (i, (number, name)) in USED.iter().enumerate() {
        let count = machine.entered[*number] - before[*number];
        text += &format!(
            "        {name:<24} {count:>8} {:>9.1} {:>8}\n",
            count as f64 / seconds,
            profile.waited[i]
        );
    }
    text += "        priority  longest masked, instructions  from\n";
    for (level, (count, at)) in profile.longest_mask.iter().enumerate() {
        let used = USED
            .iter()
            .any(|(number, _)| usize::from(machine.nvic.priority[*number] >> 4) == level);
        if used {
            let place = machine.image.place_of(*at);
            let place = own_line(&place);
            text += &format!(
                "        {:#04x}      {count:>8}                      {place}\n",
                level << 4
            );
        }
    }
    text += "        cycles of the control task     table  accelerator's model  all misses\n";
    let mean = profile.sum.map(|sum| sum / profile.blocks.max(1));
    for (name, [table, model, misses]) in [
        ("mean", mean),
        ("longest", profile.longest),
        ("longest from its interrupt", profile.response),
    ] {
        text += &format!("        {name:<28} {table:>7} {model:>20} {misses:>11}\n");
    }
    let [table, _, misses] = profile.response;
    within_deadline(misses).map_err(|why| format!("{why}\n{text}"))?;
    must(lost == 0, || format!("{lost} packets lost\n{text}"))?;
    text += &format!(
        "        bounds, not cycles of silicon: of the {DEADLINE} until the set-points must be there (a block: {BLOCK}) the \
         longest takes {:.0} to {:.0} %: the deadline holds at the upper bound",
        100.0 * table as f64 / DEADLINE as f64,
        100.0 * misses as f64 / DEADLINE as f64,
    );
    Ok((text, machine.now - from))
}

/// The longest block must end in time at the upper bound of its cycles.
pub(super) fn within_deadline(cycles: u64) -> Result<(), String> {
    if cycles < DEADLINE {
        return Ok(());
    }
    Err(format!(
        "a block takes up to {cycles} cycles at the upper bound (all misses), and {DEADLINE} are there"
    ))
}

/// Of the functions inlined at a place, the innermost that is the program's own, without the folders before it.
fn own_line(place: &str) -> String {
    let own = place.lines().find(|line| line.contains("/firmware/src/"));
    let line = own.or(place.lines().next()).unwrap_or_default().trim();
    let (name, path) = line.rsplit_once(" (").unwrap_or((line, ""));
    let (_, file) = path.rsplit_once('/').unwrap_or(("", path));
    // Of a long name, what is last says most.
    let from = name.len().saturating_sub(60);
    let name = name.get(from..).unwrap_or(name);
    format!("{name} ({file}")
}

/// Bytes of the stack that no longer hold what they were filled with.
fn stack(machine: &crate::machine::Machine) -> Result<usize, String> {
    let end = |name: &str| {
        let at = machine.image.symbol(name);
        at.map(|at| (at - RAM) as usize)
            .ok_or_else(|| format!("no symbol {name}"))
    };
    let (bottom, top) = (end("_stack_end")?, end("_stack_start")?);
    let words = machine.ram[bottom..top].chunks_exact(4);
    let untouched = words.take_while(|word| *word == PAINT).count();
    Ok(top - bottom - 4 * untouched)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_upper_bound_is_what_must_hold() {
        within_deadline(DEADLINE - 1).unwrap();
        within_deadline(DEADLINE).unwrap_err();
    }
}
