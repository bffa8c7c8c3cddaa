//! The peripherals, from the reference manual RM0390 and the register definitions of the crate stm32f4.
//!
//! Each is strict: an error names the register and the rule, and ends the run. Times are in [`UNITS_PER_S`].

pub mod adc;
pub mod capture;
pub mod dac;
pub mod dbgmcu;
pub mod dma;
pub mod exti;
pub mod flash;
pub mod gpio;
pub mod pwr;
pub mod rcc;
pub mod timer;
pub mod usart;
pub mod watchdog;

/// Units of time in a second: a multiple of every clock that is used (180, 90, 45, 16, 8 MHz).
pub const UNITS_PER_S: u64 = 720_000_000;
/// Units in a microsecond.
pub const UNITS_PER_US: u64 = UNITS_PER_S / 1_000_000;
/// A time that never comes.
pub const NEVER: u64 = u64::MAX;

/// What a register access ends with; the error names the broken rule.
pub type Access<T = ()> = Result<T, String>;

/// A write of some bits of a register.
#[derive(Clone, Copy, Debug)]
pub struct Write {
    /// Offset of the register.
    pub offset: u32,
    /// The word as it lies on the bus.
    pub value: u32,
    /// The bits that are written.
    pub mask: u32,
    /// When it is written, in units of time.
    pub now: u64,
}

impl Write {
    /// The register's new value, if of these bits only those `allowed` are set.
    ///
    /// # Errors
    /// A reserved bit is set.
    pub fn over(&self, before: u32, allowed: u32) -> Access<u32> {
        let new = before & !self.mask | self.value & self.mask;
        if new & !allowed & !before != 0 {
            return Err(format!(
                "{:#010x} sets reserved bits {:#010x}",
                self.value,
                new & !allowed
            ));
        }
        Ok(new)
    }

    /// The bits written as 1.
    pub fn ones(&self) -> u32 {
        self.value & self.mask
    }
}

/// The clocks, in units of time per cycle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Clocks {
    /// The clock of processor and AHB.
    pub hclk: u32,
    /// The clock of APB1's peripherals.
    pub pclk1: u32,
    /// The clock of APB2's peripherals.
    pub pclk2: u32,
    /// The clock of APB1's timers.
    pub timclk1: u32,
}

/// An interrupt by its number in the table of vectors (RM0390, table 38).
#[allow(missing_docs)]
pub mod interrupt {
    pub const FLASH: usize = 4;
    pub const DMA1: [usize; 8] = [11, 12, 13, 14, 15, 16, 17, 47];
    pub const DMA2: [usize; 8] = [56, 57, 58, 59, 60, 68, 69, 70];
    pub const ADC: usize = 18;
    pub const TIM2: usize = 28;
    pub const TIM3: usize = 29;
    pub const USART2: usize = 38;
    pub const UART5: usize = 53;
    pub const TIM6: usize = 54;
    pub const TIM7: usize = 55;
    pub const RCC: usize = 5;
    pub const PVD: usize = 1;
}
