//! Sums, shifts and saturation as the processor defines them.

use super::op::shift;

/// Sum with carry in: result, carry out, overflow.
#[inline(always)]
pub fn add(a: u32, b: u32, carry: bool) -> (u32, bool, bool) {
    let (sum, first) = a.overflowing_add(b);
    let (sum, second) = sum.overflowing_add(u32::from(carry));
    (
        sum,
        first | second,
        (a ^ sum) & (b ^ sum) & 0x8000_0000 != 0,
    )
}

/// A shift by `amount` (any): result and carry out.
#[inline]
pub fn shift(kind: u32, value: u32, amount: u32, carry: bool) -> (u32, bool) {
    if kind == shift::RRX {
        return (value >> 1 | u32::from(carry) << 31, value & 1 == 1);
    }
    if amount == 0 {
        return (value, carry);
    }
    match kind {
        shift::LSL if amount < 32 => (value << amount, value >> (32 - amount) & 1 == 1),
        shift::LSL => (0, amount == 32 && value & 1 == 1),
        shift::LSR if amount < 32 => (value >> amount, value >> (amount - 1) & 1 == 1),
        shift::LSR => (0, amount == 32 && value >> 31 == 1),
        shift::ASR => {
            let amount = amount.min(32);
            let top = ((value as i32) >> (amount - 1)) & 1 == 1;
            (((value as i32) >> amount.min(31)) as u32, top)
        }
        _ => {
            let result = value.rotate_right(amount & 31);
            (result, result >> 31 == 1)
        }
    }
}

/// `value` held to `bits` bits with sign, and whether it had to be.
pub fn saturate_signed(value: i64, bits: u32) -> (i32, bool) {
    let most = (1i64 << (bits - 1)) - 1;
    let held = value.clamp(-most - 1, most);
    (held as i32, held != value)
}

/// `value` held to `bits` bits without sign, and whether it had to be.
pub fn saturate_unsigned(value: i64, bits: u32) -> (u32, bool) {
    let held = value.clamp(0, (1i64 << bits) - 1);
    (held as u32, held != value)
}

/// The half of a word as a signed number: 0 low, 1 high.
pub fn half(value: u32, which: u32) -> i64 {
    i64::from((value >> (16 * which)) as u16 as i16)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_carry_and_overflow() {
        assert_eq!(add(0xffff_ffff, 0, true), (0, true, false));
        assert_eq!(add(0x7fff_ffff, 1, false), (0x8000_0000, false, true));
        assert_eq!(add(5, !5, true), (0, true, false));
    }

    #[test]
    fn shifts_by_32_and_more() {
        assert_eq!(shift(shift::LSL, 1, 32, false), (0, true));
        assert_eq!(shift(shift::LSR, 0x8000_0000, 32, false), (0, true));
        assert_eq!(shift(shift::LSR, 0x8000_0000, 33, true), (0, false));
        assert_eq!(
            shift(shift::ASR, 0x8000_0000, 40, false),
            (0xffff_ffff, true)
        );
        assert_eq!(shift(shift::ROR, 1, 32, false), (1, false));
        assert_eq!(shift(shift::RRX, 1, 1, true), (0x8000_0000, true));
    }

    #[test]
    fn saturation_says_that_it_happened() {
        assert_eq!(saturate_signed(40_000, 16), (32_767, true));
        assert_eq!(saturate_unsigned(-1, 8), (0, true));
        assert_eq!(saturate_unsigned(255, 8), (255, false));
    }
}
