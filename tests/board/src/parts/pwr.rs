//! Power control (RM0390, chapter 5): regulator's scale, over-drive and their ready flags, the voltage detector.
//! Not modelled: the low-power modes, the backup domain.

use super::{Access, UNITS_PER_US, Write};

/// How long the over-drive and its switch take (DS10693, 6.3.5: not given; RM0390 5.1.4 asks to wait for the flag).
const OVERDRIVE_DELAY: u64 = 40 * UNITS_PER_US;
const SWITCH_DELAY: u64 = 40 * UNITS_PER_US;

/// Scale, over-drive and its switch.
const VOS: u32 = 3 << 14;
const ODEN: u32 = 1 << 16;
const ODSWEN: u32 = 1 << 17;

const CR_BITS: u32 = 0x003f_ebff;

/// What of the clocks matters here.
#[derive(Clone, Copy, Debug)]
pub struct Running {
    /// The PLL is on.
    pub pll: bool,
    /// The PLL is the system clock.
    pub on_pll: bool,
    /// Some peripheral has a clock.
    pub peripherals: bool,
}

/// Power control with its registers.
#[derive(Clone, Debug)]
pub struct Pwr {
    cr: u32,
    overdrive_at: u64,
    switched_at: u64,
    /// Supply voltage, V.
    pub supply_v: f64,
}

impl Pwr {
    /// Power control after a reset.
    pub fn new(supply_v: f64) -> Self {
        Self {
            cr: 0xc000,
            overdrive_at: 0,
            switched_at: 0,
            supply_v,
        }
    }

    /// The highest HCLK that scale and over-drive allow, Hz (RM0390, table 17).
    pub fn limit_hz(&self, now: u64) -> u64 {
        let over = self.cr & (ODEN | ODSWEN) == ODEN | ODSWEN && now >= self.switched_at;
        match (self.cr >> 14 & 3, over) {
            (3, true) => 180_000_000,
            (3, false) | (2, true) => 168_000_000,
            (2, false) => 144_000_000,
            _ => 120_000_000,
        }
    }

    /// While the over-drive switches, no peripheral may have a clock, and the PLL may not be the system clock (5.1.4).
    ///
    /// # Errors
    /// They have, or it is.
    pub fn check_switching(&self, now: u64, running: Running) -> Access {
        if now >= self.switched_at {
            return Ok(());
        }
        if running.peripherals {
            return Err("the over-drive switches while a peripheral has a clock (5.1.4)".into());
        }
        if running.on_pll {
            return Err("the over-drive switches while the PLL is the system clock (5.1.4)".into());
        }
        Ok(())
    }

    /// Whether the supply is below the voltage detector's threshold (DS10693, table 22: falling edges).
    pub fn is_low(&self) -> bool {
        let threshold =
            [2.04, 2.19, 2.35, 2.51, 2.66, 2.82, 2.93, 3.03][(self.cr >> 5 & 7) as usize];
        self.cr & 0x10 != 0 && self.supply_v < threshold
    }

    /// Reads the register at `offset`, its flags as they are at `now`.
    pub fn read(&self, offset: u32, now: u64) -> Access<u32> {
        match offset {
            0 => Ok(self.cr),
            4 => {
                let over = self.cr >> 16 & 1 == 1 && now >= self.overdrive_at;
                let switched = self.cr >> 17 & 1 == 1 && now >= self.switched_at;
                Ok(u32::from(self.is_low()) << 2
                    | 1 << 14
                    | u32::from(over) << 16
                    | u32::from(switched) << 17)
            }
            _ => Err("is not modelled".into()),
        }
    }

    /// Writes the register at `w.offset`, if what is running allows it.
    pub fn write(&mut self, w: Write, running: Running) -> Access {
        if w.offset != 0 {
            return Err("is not modelled".into());
        }
        let new = w.over(self.cr, CR_BITS)?;
        let changed = new ^ self.cr;
        if changed & VOS != 0 && running.pll {
            return Err("the regulator's scale is changed while the PLL is on (5.4.1)".into());
        }
        if changed & new & ODEN != 0 {
            self.overdrive_at = w.now + OVERDRIVE_DELAY;
        }
        if changed & new & ODSWEN != 0 && (new & ODEN == 0 || w.now < self.overdrive_at) {
            return Err("ODSWEN before the over-drive is ready (5.1.4)".into());
        }
        if changed & ODSWEN != 0 {
            self.switched_at = w.now + SWITCH_DELAY;
        }
        self.cr = new;
        self.check_switching(w.now, running)
    }
}
