//! What the world does to the board: pins, supply, the crystal's clock, the link's bytes, a debugger; and what tests do.

use crate::core::Try;
use crate::core::op::Op;
use crate::machine::Machine;
use crate::memory::FLASH;
use crate::parts::gpio::Outside;
use crate::parts::rcc::{External, cause};
use crate::stop::Stop;

impl Machine {
    /// Other contents of the flash, and a reset.
    pub fn set_flash(&mut self, bytes: &[u8]) {
        self.flash.copy_from_slice(bytes);
        self.ops.fill(Op::NOT_DECODED);
        self.forget_waiting();
        self.reset(cause::POWER_ON | cause::BROWN_OUT | cause::PIN);
    }

    /// Writes a register from outside, as a debugger does.
    ///
    /// # Errors
    /// A rule of the peripheral is broken.
    pub fn poke(&mut self, address: u32, value: u32) -> Result<(), Stop> {
        self.write_part(address, value, u32::MAX)
            .map_err(|trap| self.stop(format!("{trap:?}")))
    }

    /// Reads a register from outside, as a debugger does.
    ///
    /// # Errors
    /// A rule of the peripheral is broken.
    pub fn peek(&mut self, address: u32) -> Result<u32, Stop> {
        self.read_part(address)
            .map_err(|trap| self.stop(format!("{trap:?}")))
    }

    /// Halts the processor from outside, as a debugger does.
    pub fn stand_still(&mut self) {
        self.halt("from outside");
    }

    /// The world changes a pin.
    pub fn set_pin(&mut self, port: usize, pin: usize, outside: Outside) {
        self.around.pins[port][pin] = outside;
        self.parts.gpio[port].outside[pin] = outside;
        self.settle_pins();
        self.settle_lines();
    }

    /// The supply changes: the voltage detector and the brown-out reset see it.
    pub fn set_supply(&mut self, supply_v: f64) {
        self.around.supply_v = supply_v;
        self.parts.pwr.supply_v = supply_v;
        // Brown-out levels 3 to 0, falling (DS10693, table 22).
        let threshold = [2.83, 2.54, 2.24, 1.7][(self.around.options >> 2 & 3) as usize];
        if supply_v < threshold {
            self.reset(cause::BROWN_OUT | cause::PIN);
            return;
        }
        self.settle_pins();
        self.settle_lines();
    }

    /// The world changes the HSE's pin.
    ///
    /// # Errors
    /// The clocks break a rule.
    pub fn set_hse(&mut self, external: External) -> Result<(), Stop> {
        self.around.hse = external;
        self.parts.rcc.set_external(external, self.now);
        self.clocks_changed().map_err(|why| self.stop(why))?;
        self.settle_lines();
        self.reschedule();
        Ok(())
    }

    /// The link's other end sends bytes.
    pub fn send(&mut self, bytes: &[u8]) {
        self.parts.usart.arrive(bytes, self.now);
        self.reschedule();
    }

    /// Switches the floating point on, as a program does.
    pub fn enable_float(&mut self) {
        self.system.switch_float_on();
    }

    /// Lays half words into the flash, for tests.
    pub fn place_code(&mut self, address: u32, code: &[u16]) {
        let at = (address - FLASH) as usize;
        for (i, half) in code.iter().enumerate() {
            self.flash[at + 2 * i..at + 2 * i + 2].copy_from_slice(&half.to_le_bytes());
        }
        self.forget(at..at + 2 * code.len());
    }

    /// One instruction, without exceptions: for tests.
    ///
    /// # Errors
    /// It faults, or breaks a rule.
    pub fn one(&mut self) -> Try {
        self.step()
    }

    /// Whether a store has failed behind its instruction's back.
    pub fn take_late_fault(&mut self) -> bool {
        std::mem::take(&mut self.late_fault)
    }
}
