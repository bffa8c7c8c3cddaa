//! Whether anything is wired to the sensor pins, probed before they become analogue.
//!
//! A pin with nothing on it follows the part's own pull resistors (some 40 kΩ); so does one with only the 220 kΩ
//! pull-down of an open sensor wire. A conditioner's output does not: it holds its voltage, and the pin reads
//! the same under both.

use stm32f4xx_hal::gpio::{Input, PA0, PA1, PB0, Pin, Pull};

use super::sampling::SensorPins;

/// How long a pin is left to follow, in turns of 3 to 4 cycles before the clocks are set up (16 MHz): 1 ms, twenty
/// times 40 kΩ · 1 nF.
const SETTLING: u32 = 5_000;

/// Probes the three pins, then makes them analogue. True if a voltage holds any of them.
pub fn probe(pins: (PA0<Input>, PA1<Input>, PB0<Input>)) -> (SensorPins, bool) {
    let (mut force, mut hammer, mut cart) = pins;
    let held = [held(&mut force), held(&mut hammer), held(&mut cart)];
    (
        (
            force.into_analog(),
            hammer.into_analog(),
            cart.into_analog(),
        ),
        held.contains(&true),
    )
}

/// Whether a pin reads the same pulled up and pulled down.
fn held<const P: char, const N: u8>(pin: &mut Pin<P, N, Input>) -> bool {
    let mut under = |pull| {
        pin.set_internal_resistor(pull);
        cortex_m::asm::delay(SETTLING);
        pin.is_high()
    };
    let (up, down) = (under(Pull::Up), under(Pull::Down));
    pin.set_internal_resistor(Pull::None);
    up == down
}
