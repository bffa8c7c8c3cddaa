//! Why the board was reset, from RCC's status register.

use stm32f4xx_hal::pac;

use crate::reset::Flags;

/// Reads and clears the flags; to be called once, at the start.
pub fn flags(rcc: &pac::RCC) -> Flags {
    let csr = rcc.csr().read();
    let flags = Flags {
        watchdog: csr.wdgrstf().bit() || csr.wwdgrstf().bit(),
        software: csr.sftrstf().bit(),
        power_on: csr.porrstf().bit(),
        brown_out: csr.borrstf().bit(),
        pin: csr.padrstf().bit(),
    };
    rcc.csr().modify(|_, w| w.rmvf().set_bit());
    flags
}
