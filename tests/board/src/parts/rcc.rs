//! Reset and clock control (RM0390, chapter 6).
//!
//! Modelled: HSI, HSE (bypassed) of any frequency, late and with pauses, PLL, with their ready delays, the clock switch and
//! prescalers, the clock security system, enables and resets of the peripherals, reset flags, LSI. Not: LSE, RTC, PLLI2S and
//! PLLSAI, MCO, spread spectrum, the low-power enables' effect, interrupts of the clocks' readiness.
//!
//! A clock that pauses leaves HSERDY as it is; a PLL that has locked goes on with it, slowly, and one that has not does not lock.

use super::pwr::Running;
use super::{Access, Clocks, NEVER, UNITS_PER_S, UNITS_PER_US, Write};

/// Reset flags of RCC_CSR.
#[allow(missing_docs)]
pub mod cause {
    pub const BROWN_OUT: u32 = 1 << 25;
    pub const PIN: u32 = 1 << 26;
    pub const POWER_ON: u32 = 1 << 27;
    pub const SOFTWARE: u32 = 1 << 28;
    pub const WATCHDOG: u32 = 1 << 29;
}

/// How long the oscillators and the PLL take (DS10693, 6.3.8 to 6.3.11), in units of time.
const HSI_DELAY: u64 = 3 * UNITS_PER_US;
const HSE_DELAY: u64 = 20 * UNITS_PER_US;
const PLL_DELAY: u64 = 150 * UNITS_PER_US;
const LSI_DELAY: u64 = 20 * UNITS_PER_US;
const SWITCH_DELAY: u64 = UNITS_PER_US / 4;
/// How long the HSE must pause for the clock security system (not given; believed).
const SECURITY_DELAY: u64 = 2 * UNITS_PER_US;

/// Bits of RCC_CR, and the PLL's source in RCC_PLLCFGR.
const HSEON: u32 = 1 << 16;
const CSSON: u32 = 1 << 19;
const PLLON: u32 = 1 << 24;
const FROM_HSE: u32 = 1 << 22;

const CR_BITS: u32 = 0x050d_00f9;
const PLLCFGR_BITS: u32 = 0x7f43_7fff;
const CFGR_BITS: u32 = 0xffff_fcf3;
const AHB1: u32 = 0x6064_10ff;
const APB1: u32 = 0x3fff_c9ff;
const APB2: u32 = 0x00c7_7f33;

/// What the HSE's pin is given.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum External {
    /// No clock at all.
    Missing,
    /// A clock of so many Hz, from this time on.
    Clock(u64, u64),
}

impl External {
    /// 8 MHz, from the debugger.
    pub const RUNNING: Self = Self::Clock(8_000_000, 0);
}

/// Reset and clock control with its registers, and the oscillators.
#[derive(Clone, Debug)]
pub struct Rcc {
    cr: u32,
    pllcfgr: u32,
    cfgr: u32,
    /// The switch as it stands, and when it follows what is asked.
    switched: u32,
    switch_at: u64,
    hsi_at: u64,
    hse_at: u64,
    pll_at: u64,
    lsi_at: u64,
    /// When the clock security system acts.
    security_at: u64,
    csr: u32,
    cir: u32,
    /// AHB1, AHB2, AHB3, APB1, APB2: enables.
    enables: [u32; 5],
    resets: [u32; 5],
    others: [u32; 0x26],
    /// What comes in at the HSE's pin.
    pub external: External,
    /// The clock security system has acted: an NMI is due.
    pub security_event: bool,
}

impl Rcc {
    /// After a reset for these reasons.
    pub fn new(flags: u32, external: External) -> Self {
        Self {
            cr: 0x8081,
            pllcfgr: 0x2400_3010,
            cfgr: 0,
            switched: 0,
            switch_at: NEVER,
            hsi_at: 0,
            hse_at: NEVER,
            pll_at: NEVER,
            lsi_at: NEVER,
            security_at: NEVER,
            csr: flags,
            cir: 0,
            enables: [0; 5],
            resets: [0; 5],
            others: [0; 0x26],
            external,
            security_event: false,
        }
    }

    fn hse_alive(&self, now: u64) -> bool {
        matches!(self.external, External::Clock(_, from) if now >= from)
    }

    fn hse_ready(&self, now: u64) -> bool {
        self.cr & HSEON != 0 && now >= self.hse_at
    }

    fn hse_hz(&self) -> u64 {
        match self.external {
            External::Clock(hz, _) => hz,
            External::Missing => 8_000_000,
        }
    }

    /// The period of HSE_RTC, in units of time, while there is one.
    pub fn hse_rtc(&self, now: u64) -> Option<u64> {
        let divider = u64::from(self.cfgr >> 16 & 0x1f);
        let there = self.hse_ready(now) && self.hse_alive(now) && divider >= 2;
        there.then(|| divider * UNITS_PER_S / self.hse_hz())
    }

    fn pll_ready(&self, now: u64) -> bool {
        self.cr & 1 << 24 != 0 && now >= self.pll_at
    }

    /// Frequency of the PLL's main output, Hz.
    fn pll_hz(&self) -> Result<u64, String> {
        let source = if self.pllcfgr & FROM_HSE != 0 {
            self.hse_hz()
        } else {
            16_000_000
        };
        let (m, n) = (
            u64::from(self.pllcfgr & 0x3f),
            u64::from(self.pllcfgr >> 6 & 0x1ff),
        );
        let p = 2 * (u64::from(self.pllcfgr >> 16 & 3) + 1);
        if m < 2 || !(50..=432).contains(&n) {
            return Err(format!("PLL: M {m} from 2, N {n} from 50 to 432"));
        }
        let input = source / m;
        let vco = input * n;
        if !(950_000..=2_100_000).contains(&input) || !(100_000_000..=432_000_000).contains(&vco) {
            return Err(format!(
                "PLL: {input} Hz in must be 0.95 to 2.1 MHz, VCO {vco} Hz 100 to 432 MHz"
            ));
        }
        Ok(vco / p)
    }

    /// The system clock, Hz.
    ///
    /// # Errors
    /// The PLL's settings are out of their range.
    pub fn sysclk_hz(&self) -> Access<u64> {
        match self.switched {
            0 => Ok(16_000_000),
            1 => Ok(self.hse_hz()),
            _ => self.pll_hz(),
        }
    }

    /// HCLK, Hz.
    ///
    /// # Errors
    /// See [`Self::sysclk_hz`].
    pub fn hclk_hz(&self) -> Access<u64> {
        let shift =
            [0, 0, 0, 0, 0, 0, 0, 0, 1, 2, 3, 4, 6, 7, 8, 9][(self.cfgr >> 4 & 15) as usize];
        Ok(self.sysclk_hz()? >> shift)
    }

    /// All clocks.
    ///
    /// # Errors
    /// A clock is above its limit, or no divisor of the time base.
    pub fn clocks(&self) -> Access<Clocks> {
        let hclk = self.hclk_hz()?;
        let apb = |bits: u32| if bits & 4 == 0 { 1 } else { 2 << (bits & 3) };
        let (one, two) = (apb(self.cfgr >> 10 & 7), apb(self.cfgr >> 13 & 7));
        if hclk > 180_000_000 || hclk / one > 45_000_000 || hclk / two > 90_000_000 {
            return Err(format!(
                "HCLK {hclk} Hz, APB1 1/{one}, APB2 1/{two}: above 180, 45 or 90 MHz"
            ));
        }
        let units = |hz: u64| {
            if UNITS_PER_S.is_multiple_of(hz) {
                Ok((UNITS_PER_S / hz) as u32)
            } else {
                Err(format!(
                    "a clock of {hz} Hz does not divide this machine's time base"
                ))
            }
        };
        let timers = if one == 1 { 1 } else { 2 };
        Ok(Clocks {
            hclk: units(hclk)?,
            pclk1: units(hclk / one)?,
            pclk2: units(hclk / two)?,
            timclk1: units(hclk / one * timers)?,
        })
    }

    /// Whether the clock of a bus's peripheral is on: bus 0 to 4 as AHB1, AHB2, AHB3, APB1, APB2.
    pub fn is_enabled(&self, bus: usize, bit: u32) -> bool {
        self.enables[bus] >> bit & 1 == 1
    }

    /// Whether it has a clock, and is not held in reset.
    pub fn works(&self, (bus, bit): (usize, u32)) -> bool {
        self.is_enabled(bus, bit) && !self.is_held(bus, bit)
    }

    /// What the over-drive wants to know; PWR's own clock does not count.
    pub fn running(&self) -> Running {
        let pwr = [0, 0, 0, 1 << 28, 0];
        Running {
            pll: self.cr & 1 << 24 != 0,
            on_pll: self.switched == 2,
            peripherals: (0..5).any(|bus| self.enables[bus] & !pwr[bus] != 0),
        }
    }

    /// Whether the LSI is on by itself.
    pub fn lsi_is_on(&self) -> bool {
        self.csr & 1 == 1
    }

    /// Whether it is held in reset.
    pub fn is_held(&self, bus: usize, bit: u32) -> bool {
        self.resets[bus] >> bit & 1 == 1
    }

    /// When something changes by itself.
    pub fn next(&self) -> u64 {
        self.switch_at.min(self.security_at)
    }

    /// Follows the switch, and the clock security system.
    pub fn run(&mut self, now: u64) {
        if now >= self.switch_at {
            self.switched = self.cfgr & 3;
            self.switch_at = NEVER;
        }
        if now >= self.security_at {
            // Back to HSI, HSE and PLL off, an NMI (6.2.7).
            self.security_at = NEVER;
            self.cr = self.cr & !(HSEON | PLLON | CSSON) | 1;
            self.cfgr &= !3;
            self.switched = 0;
            self.switch_at = NEVER;
            self.cir |= 1 << 7;
            self.security_event = true;
        }
    }

    /// The HSE's pin changes.
    pub fn set_external(&mut self, external: External, now: u64) {
        self.external = external;
        let alive = self.hse_alive(now);
        let change = |on: bool, ready_at: u64, delay: u64| match alive {
            true if on && ready_at == NEVER => now + delay,
            false if now < ready_at => NEVER,
            _ => ready_at,
        };
        self.hse_at = change(self.cr & HSEON != 0, self.hse_at, HSE_DELAY);
        if self.pllcfgr & FROM_HSE != 0 {
            self.pll_at = change(self.cr & PLLON != 0, self.pll_at, PLL_DELAY);
        }
        self.settle_security(now);
    }

    /// The clock security system watches a clock that was ready, and is not there.
    fn settle_security(&mut self, now: u64) {
        let watches = self.cr & CSSON != 0 && self.hse_ready(now);
        self.security_at = if watches && !self.hse_alive(now) {
            self.security_at.min(now + SECURITY_DELAY)
        } else {
            NEVER
        };
    }

    /// Whether the system clock stands on an oscillator that has died.
    pub fn is_stalled(&self, now: u64) -> bool {
        let on_hse = self.switched == 1 || self.switched == 2 && self.pllcfgr & FROM_HSE != 0;
        on_hse && !self.hse_alive(now)
    }

    /// Reads the register at `offset`, its flags as they are at `now`.
    pub fn read(&self, offset: u32, now: u64) -> Access<u32> {
        Ok(match offset {
            0x00 => {
                let ready = |at: bool, bit: u32| u32::from(at) << bit;
                self.cr & !0x0202_0002
                    | ready(self.cr & 1 != 0 && now >= self.hsi_at, 1)
                    | ready(self.hse_ready(now), 17)
                    | ready(self.pll_ready(now), 25)
            }
            0x04 => self.pllcfgr,
            0x08 => self.cfgr & !0xc | self.switched << 2,
            0x0c => self.cir,
            0x10 | 0x14 | 0x18 => self.resets[(offset as usize - 0x10) / 4],
            0x20 | 0x24 => self.resets[(offset as usize - 0x20) / 4 + 3],
            0x30 | 0x34 | 0x38 => self.enables[(offset as usize - 0x30) / 4],
            0x40 | 0x44 => self.enables[(offset as usize - 0x40) / 4 + 3],
            0x74 => self.csr & !2 | u32::from(self.csr & 1 == 1 && now >= self.lsi_at) << 1,
            0x8c | 0x94 => self.others[offset as usize / 4],
            _ => return Err("is not modelled".into()),
        })
    }

    /// Writes. Bits of a peripheral's reset that go from 0 to 1 are returned with the bus.
    pub fn write(&mut self, w: Write) -> Access<Option<(usize, u32)>> {
        match w.offset {
            0x00 => self.control(w)?,
            0x04 => {
                if self.cr & 1 << 24 != 0 {
                    return Err("the PLL must be off when it is changed (6.3.2)".into());
                }
                self.pllcfgr = w.over(self.pllcfgr, PLLCFGR_BITS)?;
            }
            0x08 => self.configure(w)?,
            0x0c => {
                if w.ones() & !0x00ff_7f00 & !0xff != 0 || w.ones() & 0x7f00 != 0 {
                    return Err("interrupts of the clocks are not modelled".into());
                }
                if w.ones() & 1 << 23 != 0 {
                    self.cir &= !(1 << 7);
                    self.security_event = false;
                }
            }
            0x10 | 0x14 | 0x18 | 0x20 | 0x24 => {
                let bus = bus_of(w.offset - 0x10);
                let new = w.over(self.resets[bus], [AHB1, 0xff, 3, APB1, APB2][bus])?;
                let rising = new & !self.resets[bus];
                self.resets[bus] = new;
                return Ok((rising != 0).then_some((bus, rising)));
            }
            0x30 | 0x34 | 0x38 | 0x40 | 0x44 => {
                let bus = bus_of(w.offset - 0x30);
                self.enables[bus] = w.over(self.enables[bus], [AHB1, 0xff, 3, APB1, APB2][bus])?;
            }
            0x74 => {
                let new = w.over(self.csr & 1, 0xff00_0003)?;
                if new & 1 == 1 && self.csr & 1 == 0 {
                    self.lsi_at = w.now + LSI_DELAY;
                }
                let flags = if new & 1 << 24 != 0 {
                    0
                } else {
                    self.csr & 0xfe00_0000
                };
                self.csr = flags | new & 1;
            }
            0x8c | 0x94 => {
                let slot = &mut self.others[w.offset as usize / 4];
                *slot = w.over(*slot, u32::MAX)?;
            }
            _ => return Err("is not modelled".into()),
        }
        Ok(None)
    }

    fn control(&mut self, w: Write) -> Access {
        let new = w.over(self.cr, CR_BITS | 0x0202_ff02)?;
        let new = new & !0xff00 | 0x8000;
        let turned_on = |bit: u32| new & !self.cr & 1 << bit != 0;
        let turned_off = |bit: u32| self.cr & !new & 1 << bit != 0;
        let in_use = [0, 16, 24][self.switched as usize];
        if turned_off(in_use) {
            return Err("the oscillator in use as system clock is switched off".into());
        }
        if turned_on(24) && self.pllcfgr & FROM_HSE != 0 && !self.hse_ready(w.now) {
            return Err("the PLL is switched on before its HSE is ready".into());
        }
        if turned_on(16) && new & 1 << 18 == 0 {
            return Err("HSE without bypass: this board has no crystal there".into());
        }
        if turned_on(0) {
            self.hsi_at = w.now + HSI_DELAY;
        }
        if turned_on(16) {
            self.hse_at = match self.external {
                External::Clock(_, from) => w.now.max(from) + HSE_DELAY,
                External::Missing => NEVER,
            };
        }
        if turned_on(24) {
            self.pll_hz()?;
            let fed = self.pllcfgr & FROM_HSE == 0 || self.hse_alive(w.now);
            self.pll_at = if fed { w.now + PLL_DELAY } else { NEVER };
        }
        self.cr = new;
        self.settle_security(w.now);
        Ok(())
    }

    fn configure(&mut self, w: Write) -> Access {
        let new = w.over(self.cfgr, CFGR_BITS | 0xc)? & !0xc;
        let ready = match new & 3 {
            0 => self.cr & 1 == 1 && w.now >= self.hsi_at,
            1 => self.hse_ready(w.now),
            2 => self.pll_ready(w.now),
            _ => return Err("PLL_R as system clock is not modelled".into()),
        };
        if !ready {
            return Err("the system clock is switched to an oscillator that is not ready".into());
        }
        if new & 3 != self.cfgr & 3 {
            self.switch_at = w.now + SWITCH_DELAY;
        }
        self.cfgr = new;
        Ok(())
    }
}

/// The bus of a register, by its place among enables or resets.
fn bus_of(place: u32) -> usize {
    match place {
        0x00 => 0,
        0x04 => 1,
        0x08 => 2,
        0x10 => 3,
        _ => 4,
    }
}
