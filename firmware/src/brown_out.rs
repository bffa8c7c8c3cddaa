//! Which brown-out level the part is set to, from its option bytes.

/// Whether the brown-out reset is at level 3 (2.7 to 3.6 V), by the option register FLASH_OPTCR.
///
/// BOR_LEV, bits 2 and 3, counts downwards: 0 is level 3, and 3 is off, as the part is delivered (RM0390, "Flash option
/// control register", and ST's own `OB_BOR_LEVEL3`). The names of the register in `stm32f4` 0.16 count upwards.
pub fn is_level_3(optcr: u32) -> bool {
    optcr & LEVEL == 0
}

/// The option register with level 3 and all else as it was.
pub fn at_level_3(optcr: u32) -> u32 {
    optcr & !LEVEL
}

/// BOR_LEV, bits 2 and 3 of FLASH_OPTCR: both 1 is off, both 0 is level 3.
const LEVEL: u32 = 3 << 2;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn as_delivered_it_is_off() {
        assert!(!is_level_3(0x0fff_aaed));
        // ST's values: level 1 0x08, level 2 0x04, level 3 0x00.
        assert!(!is_level_3(0x0fff_aae9) && !is_level_3(0x0fff_aae5));
        assert!(is_level_3(0x0fff_aae1));
        assert_eq!(at_level_3(0x0fff_aaed), 0x0fff_aae1);
    }
}
