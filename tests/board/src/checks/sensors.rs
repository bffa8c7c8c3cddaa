//! Sensors that read what no sensor reads: a rail, an open wire. Each of the three.

use shared::fault::Fault;

use super::faults::{Strike, struck};
use super::{Found, Setup};

/// A tick, µs, and the ticks that docs/controller.md allows from detection to the pin: two blocks.
const TICK_US: f64 = 50.0;
const TWO_BLOCKS: u32 = 20;

/// Name, input (force, hammer, cart), code, fault, and the ticks in a row that it takes (docs/controller.md).
type Case = (&'static str, usize, u16, Fault, u32);

const RAILS: [Case; 6] = [
    ("force low", 0, 100, Fault::SensorSaturated, 20),
    ("force high", 0, 4095, Fault::OverForce, 2),
    ("hammer low", 1, 100, Fault::OverTravel, 4),
    ("hammer high", 1, 4095, Fault::OverTravel, 4),
    ("cart low", 2, 100, Fault::OverTravel, 4),
    ("cart high", 2, 4095, Fault::OverTravel, 4),
];

const WIRES: [Case; 3] = [
    ("force", 0, 0, Fault::SensorOpen, 3),
    ("hammer", 1, 0, Fault::SensorOpen, 3),
    ("cart", 2, 0, Fault::SensorOpen, 3),
];

fn all(setup: &Setup, cases: &[Case]) -> Found {
    let mut text = Vec::new();
    let mut units = 0;
    for (name, input, code, wanted, ticks) in cases {
        let strike = Strike {
            limit_us: TICK_US * f64::from(ticks + TWO_BLOCKS),
            wait_ms: 60,
            wanted: *wanted,
        };
        let found = struck(setup, &strike, |bench| {
            bench.rig.borrow_mut().forced[*input] = Some(*code);
            Ok(())
        });
        let found = found.map_err(|e| format!("{name}: {e}"))?;
        text.push(format!(
            "{name} {:.2} ms of {:.2}, {wanted:?}",
            found.gone_us / 1e3,
            strike.limit_us / 1e3
        ));
        units += found.units;
    }
    Ok((text.join("; "), units))
}

/// A code at a rail.
pub fn rails(setup: &Setup) -> Found {
    all(setup, &RAILS)
}

/// Nothing at the pin but its resistor to ground.
pub fn open_wires(setup: &Setup) -> Found {
    all(setup, &WIRES)
}
