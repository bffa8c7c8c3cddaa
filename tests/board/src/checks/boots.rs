//! The board starts, in every way.

use shared::control::State;
use shared::fault::Fault;
use shared::link::LinkAct;

use super::benchmark::{DEADLINE, within_deadline};
use super::session::Bench;
use super::{Found, Setup, must};
use crate::core::nvic::FIRST;
use crate::machine::{Around, Change};
use crate::parts::gpio::Outside;
use crate::parts::rcc::External;
use crate::parts::{UNITS_PER_S, UNITS_PER_US, interrupt};
use crate::rig::{DELIVERED, LEVEL_3, port, wired};

/// The control task's interrupt: the end of a half of the samples.
const CONTROL: usize = FIRST + interrupt::DMA2[0];
/// The block monitor's and the link's.
const MONITOR: usize = FIRST + interrupt::TIM7;
const LINK: usize = FIRST + interrupt::TIM6;

/// Power on, all as it should be: clocks, rates, pins.
pub fn cold(setup: &Setup) -> Found {
    let mut bench = Bench::power_up(setup, wired())?;
    bench.advance_ms(150)?;
    rates(&mut bench)?;
    let hclk = bench.rig.borrow().machine.parts.rcc.hclk_hz()?;
    must(hclk == 180_000_000, || format!("HCLK is {hclk} Hz"))?;
    let changes = bench.changes_since(0);
    must(
        !changes.contains(&(0, Change::Enable(Some(true)))),
        String::new,
    )?;
    let rose = changes
        .iter()
        .any(|(_, change)| *change == Change::Enable(Some(true)));
    must(!rose, || "PA8 was high without a start".into())?;
    let first = |wanted: Change| {
        changes
            .iter()
            .find(|(_, c)| *c == wanted)
            .map_or(0.0, |(at, _)| *at as f64 / 720e3)
    };
    let unusable = bench.rig.borrow().machine.parts.adc.unusable;
    let text = format!(
        "PA8 driven low after {:.1} ms, PA4 at the middle after {:.1} ms, 180 MHz; 2 kHz, 1 kHz, 1 kHz exactly; \
         {unusable} conversion(s) that give nothing to be used",
        first(Change::Enable(Some(false))),
        first(Change::Dac(Some(2048)))
    );
    Ok((text, bench.now()))
}

/// Control, block monitor and link at 2, 1 and 1 kHz.
fn rates(bench: &mut Bench) -> Result<(), Box<dyn std::error::Error>> {
    let before = [CONTROL, MONITOR, LINK].map(|n| bench.entered(n));
    bench.advance_ms(100)?;
    let per_100_ms = [0, 1, 2].map(|i| bench.entered([CONTROL, MONITOR, LINK][i]) - before[i]);
    must(per_100_ms == [200, 100, 100], || {
        format!("control, monitor and link ran {per_100_ms:?} times in 100 ms, not 200, 100, 100")
    })
}

fn refuses_to_drive(bench: &mut Bench, why: &str) -> Result<String, Box<dyn std::error::Error>> {
    let status = bench.must_be(State::Fault)?;
    let record = status.fault.ok_or("no record")?;
    must(record.episode.contains(Fault::BoardUnfit), || {
        format!("{why}: {record:?}")
    })?;
    let fault = format!("{:?}, with BoardUnfit in the episode", record.fault);
    let rose = bench
        .changes_since(0)
        .iter()
        .any(|(_, change)| *change == Change::Enable(Some(true)));
    must(!rose, || format!("{why}: PA8 was high"))?;
    Ok(fault)
}

/// The debugger's clock never comes.
pub fn without_crystal(setup: &Setup) -> Found {
    let mut around = wired();
    around.hse = External::Missing;
    around.lsi_hz = 47_000;
    let mut bench = Bench::power_up(setup, around)?;
    // Past the watchdog's period, with an LSI at its fastest: 47 kHz make 1.36 s of 2 s (DS10693, 6.3.9).
    bench.advance_ms(2_000)?;
    let changes = bench.changes_since(0);
    let resets = changes
        .iter()
        .filter(|(_, change)| matches!(change, Change::Reset(_)))
        .count();
    let at = changes
        .iter()
        .find(|(_, change)| *change == Change::Dac(Some(2048)))
        .map_or(0, |(at, _)| *at);
    let waited = format!(
        "{resets} start(s), outputs on after {:.2} s",
        at as f64 / UNITS_PER_S as f64
    );
    must(resets == 1, || {
        format!("{waited}: the watchdog ends the wait for the clock")
    })?;
    let fault = refuses_to_drive(&mut bench, "without the clock")?;
    let hclk = bench.rig.borrow().machine.parts.rcc.hclk_hz()?;
    Ok((
        format!(
            "{waited}; runs from HSI at {} MHz, in Fault: {fault}",
            hclk / 1_000_000
        ),
        bench.now(),
    ))
}

/// It comes 0.2 s late, which is waited for; and 0.7 s, after it was given up.
pub fn late_crystal(setup: &Setup) -> Found {
    let mut around = wired();
    around.hse = External::Clock(8_000_000, UNITS_PER_S / 5);
    let mut bench = Bench::power_up(setup, around)?;
    bench.advance_ms(600)?;
    let started = bench
        .changes_since(0)
        .iter()
        .find(|(_, c)| *c == Change::Dac(Some(2048)))
        .map(|(at, _)| *at);
    let started = started.ok_or("the set-point's output did not come on")?;
    let fault = bench.status()?.fault;
    must(
        !fault.is_some_and(|record| record.episode.contains(Fault::BoardUnfit)),
        || format!("after 0.2 s: {fault:?}"),
    )?;
    around.hse = External::Clock(8_000_000, 7 * UNITS_PER_S / 10);
    let units = bench.now() + on_its_own(setup, around, "after 0.7 s")?;
    let text = format!(
        "after 0.2 s: waits for it, PA4 at the middle after {:.0} ms; after 0.7 s: from HSI, in Fault",
        started as f64 / UNITS_PER_US as f64 / 1e3
    );
    Ok((text, units))
}

/// A start that must end in Fault, with right rates from HSI; the rig time of it.
fn on_its_own(setup: &Setup, around: Around, why: &str) -> Result<u64, Box<dyn std::error::Error>> {
    let mut bench = Bench::power_up(setup, around)?;
    bench.advance_ms(1_200)?;
    refuses_to_drive(&mut bench, why)?;
    rates(&mut bench).map_err(|error| format!("{why}: {error}"))?;
    Ok(bench.now())
}

/// What comes in is a clock of another frequency.
pub fn another_clock(setup: &Setup) -> Found {
    let mut units = 0;
    for hz in [4_000_000, 7_400_000, 8_600_000, 16_000_000] {
        let mut around = wired();
        around.hse = External::Clock(hz, 0);
        units += on_its_own(setup, around, &format!("{hz} Hz"))?;
    }
    let text = "4, 7.4, 8.6 and 16 MHz: from HSI, in Fault, with BoardUnfit in the episode; rates are right";
    Ok((text.into(), units))
}

/// When the start has to do with the crystal's clock, µs after power-up (it is switched on after 19.8 ms, PA4 is in the middle after
/// 21.1), and steps in it.
const CLOCK_FROM_US: u64 = 19_780;
const CLOCK_STEP_US: u64 = 59;
const CLOCK_STEPS: u64 = 24;
/// Looks at what the start has come to, half a second each.
const MOST_LOOKS: usize = 10;

/// The clock stops at some instant of the start, for good or for 3 ms. The board ends up with right rates, and does not drive
/// without the clock; whether PA8 is low all the time is looked at, too.
pub fn clock_stops(setup: &Setup) -> Found {
    let mut units = 0;
    let mut ends = [0; 3];
    let few = if setup.short.is_some() { 4 } else { 1 };
    for i in (0..CLOCK_STEPS).step_by(few) {
        for comes_back in [false, true] {
            let mut bench = Bench::power_up(setup, wired())?;
            let at_us = CLOCK_FROM_US + i * CLOCK_STEP_US;
            bench.rig.borrow_mut().advance(at_us)?;
            bench.rig.borrow_mut().machine.set_hse(External::Missing)?;
            if comes_back {
                bench.rig.borrow_mut().advance(3_000)?;
                bench.rig.borrow_mut().machine.set_hse(External::RUNNING)?;
            }
            // A start that waits without end is ended by the watchdog.
            let why = format!("stops after {at_us} µs, comes back: {comes_back}");
            let mut right = Ok(());
            for _ in 0..MOST_LOOKS {
                bench.advance_ms(400)?;
                right = rates(&mut bench);
                if right.is_ok() {
                    break;
                }
            }
            right.map_err(|error| format!("{why}: {error}"))?;
            let fault = bench.status()?.fault;
            let unfit = fault.is_some_and(|record| record.episode.contains(Fault::BoardUnfit));
            must(unfit || comes_back, || format!("{why}: {fault:?}"))?;
            let high = |(_, change): &(u64, Change)| *change == Change::Enable(Some(true));
            must(!bench.changes_since(0).iter().any(high), || {
                format!("{why}: PA8 was high")
            })?;
            let resets = bench.changes_since(1);
            let reset = |(_, change): &(u64, Change)| matches!(change, Change::Reset(_));
            ends[usize::from(unfit) + usize::from(unfit && !resets.iter().any(reset))] += 1;
            units += bench.now();
        }
    }
    let [fit, again, at_once] = ends;
    let text = format!(
        "at {} instants: {at_once} times in Fault at once, {again} after a reset, {fit} times with the clock that came back",
        CLOCK_STEPS.div_ceil(few as u64)
    );
    Ok((text, units))
}

/// A wired board: neither a short press nor one that is not let go starts it; two seconds and the release do.
pub fn button_starts(setup: &Setup) -> Found {
    let (mut bench, _) = Bench::idle(setup)?;
    let from = bench.now();
    let button = |bench: &mut Bench, level: Outside, ms: u64| {
        bench.rig.borrow_mut().machine.set_pin(port::C, 13, level);
        bench.advance_ms(ms)
    };
    button(&mut bench, Outside::Low, 500)?;
    button(&mut bench, Outside::High, 200)?;
    button(&mut bench, Outside::Low, 5_000)?;
    bench.must_be(State::Idle)?;
    let pulses = |(_, change): &(u64, Change)| *change == Change::Enable(Some(true));
    must(!bench.changes_since(from).iter().any(pulses), || {
        "PA8 was high before the button was let go".into()
    })?;
    let let_go = bench.now();
    button(&mut bench, Outside::High, 100)?;
    while !bench.rig.borrow_mut().is_driven() {
        must(bench.now() - let_go < 8 * UNITS_PER_S, || {
            "no pulses 8 s after the button was let go".into()
        })?;
        bench.advance_ms(50)?;
    }
    let seconds = (bench.now() - let_go) as f64 / UNITS_PER_S as f64;
    button(&mut bench, Outside::Low, 100)?;
    let state = bench.status()?.state;
    must(matches!(state, State::Idle | State::Stop), || {
        format!("{state:?} after a press while it drives")
    })?;
    Ok((
        format!("0.5 s: nothing; 5 s: pulses {seconds:.1} s after it was let go; a press stops it"),
        bench.now() - from,
    ))
}

/// Bench mode: nothing wired, button held.
pub fn button_held(setup: &Setup) -> Found {
    let mut around = wired();
    for (port, pin) in [(port::A, 0), (port::A, 1), (port::B, 0), (port::B, 5)] {
        around.pins[port][pin] = Outside::Open;
    }
    around.pins[port::C][13] = Outside::Low;
    let mut bench = Bench::power_up(setup, around)?;
    bench.advance_ms(300)?;
    bench.rig.borrow_mut().machine.start_profile();
    let button = |bench: &mut Bench, level: Outside, ms: u64| {
        bench.rig.borrow_mut().machine.set_pin(port::C, 13, level);
        bench.advance_ms(ms)
    };
    button(&mut bench, Outside::High, 100)?;
    let status = bench.must_be(State::Idle)?;
    must(status.fault.is_none(), || {
        format!("a fault in bench mode: {:?}", status.fault)
    })?;
    // A press by accident starts nothing, however often.
    for _ in 0..3 {
        button(&mut bench, Outside::Low, 500)?;
        button(&mut bench, Outside::High, 100)?;
    }
    bench.must_be(State::Idle)?;
    button(&mut bench, Outside::Low, 2200)?;
    bench.must_be(State::Idle)?;
    button(&mut bench, Outside::High, 100)?;
    let status = bench.status()?;
    let state = status.state;
    must(matches!(state, State::SelfTest | State::Prove), || {
        format!(
            "{state:?} after two seconds of the button: {:?}",
            status.fault
        )
    })?;
    let started = bench.now();
    while bench.status()?.state != State::Hold {
        let waited_s = (bench.now() - started) / UNITS_PER_S;
        must(waited_s < 20, || "no Hold in 20 s of bench mode".to_owned())?;
        bench.advance_ms(100)?;
    }
    let hold_s = (bench.now() - started) as f64 / UNITS_PER_S as f64;
    // The next press stops it, and held on starts nothing again.
    button(&mut bench, Outside::Low, 3500)?;
    bench.must_be(State::Idle)?;
    let rig = bench.rig.borrow();
    let profile = rig.machine.profile.as_deref().ok_or("no profile")?;
    let [table, _, misses] = profile.longest;
    within_deadline(misses)?;
    let text = format!(
        "the model replaces the rig, idle without stored settings; a start wants the button for two seconds; Hold \
         {hold_s:.1} s after it; a block takes {table} to \
         {misses} cycles of {DEADLINE}"
    );
    Ok((text, rig.machine.now))
}

/// Whether the program takes a board with these option bytes for fit.
fn fit(setup: &Setup, options: u32) -> Result<bool, Box<dyn std::error::Error>> {
    let mut around = wired();
    around.options = options;
    let mut bench = Bench::power_up(setup, around)?;
    bench.advance_ms(100)?;
    let fault = bench.status()?.fault;
    Ok(!fault.is_some_and(|record| record.episode.contains(Fault::BoardUnfit)))
}

/// Option bytes with the brown-out reset at level 3 and off: the program must tell them apart.
pub fn brown_out_off(setup: &Setup) -> Found {
    let (on, off) = (fit(setup, LEVEL_3)?, fit(setup, DELIVERED)?);
    must(on && !off, || {
        format!("level 3 accepted: {on}, off accepted: {off}")
    })?;
    Ok(("refused; level 3 is accepted".into(), UNITS_PER_S / 5))
}

/// A board as it is delivered, and the link's command; after the next power-up it is fit. While it drives, the command is refused.
pub fn brown_out_set(setup: &Setup) -> Found {
    let mut around = wired();
    around.options = DELIVERED;
    let mut bench = Bench::power_up(setup, around)?;
    bench.advance_ms(100)?;
    bench.client.hello()?;
    bench.client.open_session(false)?;
    bench.client.steer(LinkAct::SetBrownOut)?;
    let options = bench.rig.borrow().machine.around.options;
    must((options ^ LEVEL_3) & !3 == 0, || {
        format!("option bytes {options:#010x}")
    })?;
    let units = bench.now();
    must(fit(setup, options)?, || "not fit after it".into())?;
    let mut bench = Bench::driving(setup)?;
    bench.client.hello()?;
    bench.client.open_session(true)?;
    must(bench.client.steer(LinkAct::SetBrownOut).is_err(), || {
        "option bytes are written while it drives".into()
    })?;
    Ok((
        "off as delivered; the link's command, a power-up, and the board is fit; refused while it drives".into(),
        units,
    ))
}

/// The supply is gone at once while the board drives, and comes back: RAM says so, and the reset's flags.
pub fn after_brown_out(setup: &Setup) -> Found {
    let mut bench = Bench::driving(setup)?;
    let from = bench.now();
    {
        let machine = &mut bench.rig.borrow_mut().machine;
        machine.set_supply(2.0);
        machine.set_supply(3.3);
    }
    bench.advance_ms(100)?;
    let gone = bench.enable_gone_us(from)?;
    must(gone == 0.0, || format!("PA8 was high {gone} µs after it"))?;
    bench.must_be_in(Fault::BrownOut)?;
    Ok((
        "Fault, and the record shows BrownOut".into(),
        bench.now() - from,
    ))
}
