//! What a debugger may have left in the part.
#![allow(unsafe_code)]

use cortex_m::peripheral::DCB;

/// The vector catches of DEMCR (ARMv7-M reference manual, C1.6.5): VC_CORERESET, VC_MMERR to VC_INTERR and
/// VC_HARDERR.
const VECTOR_CATCHES: u32 = 0x0000_07f1;

/// Clears the traps that halt the processor at a fault or a reset, before the program can make the outputs safe. A
/// debugger sets them, and no reset clears them: only power-off does. To be called first.
///
/// A debugger that is attached can set them again; so do not flash a board that drives (docs/flashing.md).
pub fn clear(dcb: &mut DCB) {
    // SAFETY: trace enable and the debug monitor's bits stay as they are; without catches, faults go to their handlers.
    unsafe { dcb.demcr.modify(|demcr| demcr & !VECTOR_CATCHES) };
}
