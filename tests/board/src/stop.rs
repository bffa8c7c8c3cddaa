//! Why and where a run ended before its time.

use crate::machine::Machine;
use crate::memory::FLASH;
use crate::parts::UNITS_PER_US;

/// Why a run ended before its time.
#[derive(Clone, Debug, PartialEq)]
pub struct Stop {
    /// The rule that was broken.
    pub why: String,
    /// The instruction's address, the instruction, and where in the source.
    pub address: u32,
    /// Half words of the instruction and what it is.
    pub instruction: String,
    /// Source file and line, or "unknown".
    pub place: String,
}

impl std::fmt::Display for Stop {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "{}\n  at {:#010x}: {}\n  in {}",
            self.why, self.address, self.instruction, self.place
        )
    }
}

impl std::error::Error for Stop {}

impl Machine {
    /// The run ends at the instruction in work.
    pub(crate) fn stop(&self, why: impl Into<String>) -> Stop {
        let address = self.cpu.r[15].wrapping_sub(4);
        let op = self.ops.get((address.wrapping_sub(FLASH) >> 1) as usize);
        let halves = format!(
            "{:04x} {:04x}",
            self.half(address),
            self.half(address.wrapping_add(2))
        );
        Stop {
            why: format!(
                "{} (at {:.3} ms)",
                why.into(),
                self.now as f64 / UNITS_PER_US as f64 / 1e3
            ),
            address,
            instruction: op.map_or(halves.clone(), |op| format!("{halves}, {:?}", op.kind)),
            place: self.image.place_of(address),
        }
    }
}
