//! Why a board is not fit to drive a rig.

use serde::{Deserialize, Serialize};

/// Reasons why the board itself is not fit to drive, as a set. A bit's meaning is part of the stored record: it never
/// changes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Unfit(u8);

impl Unfit {
    /// No reason: the board is fit to drive.
    pub const NONE: Self = Self(0);
    /// The crystal's clock did not come, or died: the clock in use is an oscillator without one.
    pub const CLOCK: Self = Self(1);
    /// The part's brown-out reset is not set to the level that its clock needs.
    pub const BROWN_OUT_LEVEL: Self = Self(2);
    /// The supply is, or was, below what the clock needs.
    pub const SUPPLY: Self = Self(4);
    /// The measuring reference is too far from its value: every sensor would read wrong.
    pub const REFERENCE: Self = Self(8);
    /// A register, or the settings in memory, are not what they were set to. (16 meant something once.)
    pub const CHANGED: Self = Self(32);

    /// Every reason, with what is wrong in words.
    pub const ALL: [(Self, &str); 5] = [
        (Self::CLOCK, "the crystal's clock is missing or died"),
        (
            Self::BROWN_OUT_LEVEL,
            "the brown-out reset is not at level 3",
        ),
        (Self::SUPPLY, "the supply is too low"),
        (Self::REFERENCE, "the measuring reference is off"),
        (
            Self::CHANGED,
            "a register or the settings in memory had changed by themselves",
        ),
    ];

    /// The reasons of either set.
    #[must_use]
    pub const fn and(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// This set if `so`, else none.
    #[must_use]
    pub const fn when(self, so: bool) -> Self {
        if so { self } else { Self::NONE }
    }

    /// Whether nothing is wrong.
    pub const fn is_none(self) -> bool {
        self.0 == 0
    }

    /// The set as a number.
    pub const fn bits(self) -> u8 {
        self.0
    }

    /// The set of a number; bits that stand for no reason are left out.
    pub fn from_bits(bits: u8) -> Self {
        let known = Self::ALL
            .iter()
            .fold(Self::NONE, |all, (one, _)| all.and(*one));
        Self(bits & known.0)
    }

    /// What is wrong, in words.
    pub fn reasons(self) -> impl Iterator<Item = &'static str> {
        let in_set = move |(one, _): &&(Self, _)| self.0 & one.0 != 0;
        Self::ALL.iter().filter(in_set).map(|(_, words)| *words)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_set_has_the_words_of_its_reasons_and_no_others() {
        let both = Unfit::CLOCK.and(Unfit::REFERENCE);
        assert_eq!(both.bits(), 9);
        let words: std::vec::Vec<_> = both.reasons().collect();
        assert_eq!(words.len(), 2);
        assert!(words[0].contains("clock") && words[1].contains("reference"));
        assert_eq!(Unfit::NONE.reasons().count(), 0);
        assert!(Unfit::CLOCK.when(false).is_none());
        assert_eq!(Unfit::from_bits(0xff).bits(), 47);
    }
}
