//! Registers and settings that change by themselves while it drives.

use shared::control::{State, Unfit};
use shared::fault::Fault;

use super::session::Bench;
use super::{Found, Setup, must};
use crate::memory::RAM;

/// They are looked at once a second.
const LONGEST_MS: u64 = 1_100;

/// What is changed: an address, and what the register's value is turned into.
type Register = (&'static str, u32, fn(u32) -> u32);

/// One of each part of the set-up.
const REGISTERS: [Register; 5] = [
    ("TIM2's reload 10 % longer", 0x4000_002c, |reload| {
        reload + reload / 10
    }),
    (
        "the block monitor's timer stopped",
        0x4000_1400,
        |control| control & !1,
    ),
    ("the supply's detector off", 0x4000_7000, |control| {
        control & !(1 << 4)
    }),
    (
        "the emergency stop's interrupt masked",
        0x4001_3c00,
        |mask| mask & !(1 << 5),
    ),
    ("the reports' pins without pull-up", 0x4002_000c, |pulls| {
        pulls & !(3 << 18)
    }),
];

/// It must be off, and say why.
fn must_be_found(bench: &mut Bench, what: &str) -> Result<(), Box<dyn std::error::Error>> {
    bench.advance_ms(LONGEST_MS)?;
    let driven = bench.rig.borrow_mut().is_driven();
    must(!driven, || format!("{what}: the drive goes on"))?;
    bench.advance_ms(300)?;
    let record = bench.must_be(State::Fault)?.fault.ok_or("no record")?;
    let why = f32::from(Unfit::CHANGED.bits());
    must(
        (record.fault, record.value) == (Fault::BoardUnfit, why),
        || format!("{what}: then {:?} {}", record.fault, record.value),
    )
}

/// Each register in turn, and the settings.
pub fn by_themselves(setup: &Setup) -> Found {
    let mut units = 0;
    for (what, address, changed) in REGISTERS {
        let mut bench = Bench::driving(setup)?;
        let from = bench.now();
        {
            let machine = &mut bench.rig.borrow_mut().machine;
            let value = machine.peek(address)?;
            machine.poke(address, changed(value))?;
        }
        must_be_found(&mut bench, what)?;
        units += bench.now() - from;
    }
    let mut bench = Bench::driving(setup)?;
    let from = bench.now();
    let limit = bench.scenario.settings.trips.force_n.to_le_bytes();
    let places = {
        let machine = &mut bench.rig.borrow_mut().machine;
        let words = machine.ram.chunks_exact_mut(4);
        let found = words.filter(|word| **word == limit);
        found.map(|word| word[2] ^= 1).count()
    };
    must(places > 0, || format!("no trip level from {RAM:#x} on"))?;
    must_be_found(&mut bench, "the settings' trip level")?;
    units += bench.now() - from;
    Ok((
        format!(
            "{} registers and the settings, one at a time: off within {LONGEST_MS} ms, then in Fault: BoardUnfit {}",
            REGISTERS.len(),
            Unfit::CHANGED.bits()
        ),
        units,
    ))
}
