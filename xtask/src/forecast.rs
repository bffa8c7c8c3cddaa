//! A whole forecast on the microcontroller's instruction set: what it costs, and that it finds, bit for
//! bit, what the same code finds here.

use shared::{
    forecast::{Forecast, ForecastRequest, Forecaster},
    model::cart::{ASSUMED_SHAKER, CartDrive},
    model::params::{RigParams, WIRES},
};

use crate::{JobResult, qemu::Said};

/// The carts of the forecasts, and the instructions that each may cost in all. One that recoils rings after each contact, in
/// shorter steps, and has twice as many derivatives.
const CARTS: [(&str, CartDrive, u64); 2] = [
    ("prescribed", CartDrive::Prescribed, 200_000_000),
    ("recoil", CartDrive::Loop(ASSUMED_SHAKER), 600_000_000),
];

/// The forecast that QEMU runs for such a cart, computed on this machine.
fn here(cart: CartDrive) -> JobResult<Forecast> {
    let mut forecaster = Forecaster::new();
    forecaster.start(&ForecastRequest::bench(&RigParams { cart, ..WIRES }));
    while forecaster.slice() {}
    let found = forecaster.result();
    found.cloned().ok_or_else(|| "no forecast here".into())
}

/// Runs the forecasts in QEMU, prints what they cost, and compares what they found. The firmware is built.
pub fn run() -> JobResult {
    let said = Said::by("forecast")?;
    println!(
        "\nforecasts of 40 rows, wires at 0.0 mm, 0.75 to 2.9 times the natural frequency; {} bytes:",
        said.number("bytes")?
    );
    for (name, cart, budget) in CARTS {
        compare(&said, name, cart, budget)?;
    }
    println!("the microcontroller's forecasts and this machine's agree bit for bit");
    Ok(())
}

fn compare(said: &Said, name: &str, cart: CartDrive, budget: u64) -> JobResult {
    let word = |word: &str| format!("{name}-{word}");
    let total = said.instructions(&word("total"))?;
    let worst = said.instructions(&word("worst"))?;
    let slices = said.number(&word("slices"))?;
    println!(
        "{name}: {slices} slices, {total} instructions; longest slice {worst}, mean {}",
        total / slices.max(1)
    );
    let found = here(cart)?;
    let target = found.target.ok_or("no target here")?;
    println!(
        "{name}: target {} Hz, {} N, digest {:#010x}",
        target.frequency_hz,
        target.orbit.force_n,
        found.digest()
    );
    let same = said.number(&word("digest"))? == u64::from(found.digest())
        && said.number(&word("target"))? == u64::from(target.frequency_hz.to_bits())
        && said.number(&word("force"))? == u64::from(target.orbit.force_n.to_bits());
    if !same {
        return Err(
            format!("the microcontroller's {name} forecast differs from this machine's").into(),
        );
    }
    if total > budget {
        return Err(format!("the {name} forecast takes more than {budget} instructions").into());
    }
    Ok(())
}
