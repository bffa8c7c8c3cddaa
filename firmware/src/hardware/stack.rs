//! The largest use of the stack so far: the start-up code fills it with a pattern (cortex-m-rt's `paint-stack`),
//! and words that no longer hold it were used.
#![allow(unsafe_code)]

use cortex_m_rt::STACK_PAINT_VALUE;

unsafe extern "C" {
    static _stack_start: u32;
    static _stack_end: u32;
}

/// Bytes reserved for the stack.
pub fn reserved() -> usize {
    (&raw const _stack_start as usize) - (&raw const _stack_end as usize)
}

/// Most bytes of the stack in use at once since the start. Reads every unused word: not for control.
pub fn peak() -> usize {
    let bottom = &raw const _stack_end;
    let words = reserved() / size_of::<u32>();
    // SAFETY: words of the stack's own memory; what they hold does not matter, and nothing is written.
    let painted =
        (0..words).take_while(|i| unsafe { bottom.add(*i).read_volatile() } == STACK_PAINT_VALUE);
    reserved() - painted.count() * size_of::<u32>()
}
