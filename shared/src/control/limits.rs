//! Which limits clamp, as a set.

use core::ops::{BitAnd, BitOr, BitOrAssign, SubAssign};

use serde::{Deserialize, Serialize};

/// The limits that clamp now. Written as one number: 1 force, 2 travel, 4 frequency, 8
/// amplitude, 16 feed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct ActiveLimits(u8);

impl ActiveLimits {
    /// No limit clamps.
    pub const NONE: Self = Self(0);
    /// The force limit reduces the amplitude.
    pub const FORCE: Self = Self(1);
    /// The travel limit reduces the amplitude.
    pub const TRAVEL: Self = Self(2);
    /// A frequency limit holds the frequency.
    pub const FREQUENCY: Self = Self(4);
    /// The amplitude limit holds the command.
    pub const AMPLITUDE: Self = Self(8);
    /// The surface has receded beyond the amplitude's reach: feed the tool.
    pub const FEED: Self = Self(16);
    /// Every limit clamps.
    pub const ALL: Self = Self(31);

    /// Each limit with its name.
    const NAMES: [(Self, &str); 5] = [
        (Self::FORCE, "force"),
        (Self::TRAVEL, "travel"),
        (Self::FREQUENCY, "frequency"),
        (Self::AMPLITUDE, "amplitude"),
        (Self::FEED, "feed"),
    ];

    /// The number it is written as.
    pub const fn bits(self) -> u8 {
        self.0
    }

    /// Whether no limit clamps.
    pub const fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// Whether every limit of `other` clamps.
    pub const fn contains(self, other: Self) -> bool {
        self.0 & other.0 == other.0
    }

    /// `self` if `clamps`, no limit otherwise.
    pub const fn when(self, clamps: bool) -> Self {
        if clamps { self } else { Self::NONE }
    }

    /// Names of the limits in the set.
    pub fn names(self) -> impl Iterator<Item = &'static str> {
        let clamping = Self::NAMES
            .into_iter()
            .filter(move |(limit, _)| self.contains(*limit));
        clamping.map(|(_, name)| name)
    }
}

impl BitOr for ActiveLimits {
    type Output = Self;

    fn bitor(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
}

impl BitOrAssign for ActiveLimits {
    fn bitor_assign(&mut self, other: Self) {
        self.0 |= other.0;
    }
}

impl BitAnd for ActiveLimits {
    type Output = Self;

    fn bitand(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }
}

impl SubAssign for ActiveLimits {
    /// Takes the limits of `other` out.
    fn sub_assign(&mut self, other: Self) {
        self.0 &= !other.0;
    }
}

/// The limits that clamp, and those reported last.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct LimitReport {
    pub active: ActiveLimits,
    reported: ActiveLimits,
}

impl LimitReport {
    /// The set, if it differs from the one reported last; it counts as reported then.
    pub fn change(&mut self) -> Option<ActiveLimits> {
        let changed = self.active != self.reported;
        self.reported = self.active;
        changed.then_some(self.active)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    #[test]
    fn the_number_on_the_wire_is_stable() {
        let each = [
            ActiveLimits::FORCE,
            ActiveLimits::TRAVEL,
            ActiveLimits::FREQUENCY,
            ActiveLimits::AMPLITUDE,
            ActiveLimits::FEED,
        ];
        for (bit, limit) in each.into_iter().enumerate() {
            assert_eq!(limit.bits(), 1 << bit);
            let mut bytes = [0; 2];
            assert_eq!(postcard::to_slice(&limit, &mut bytes).unwrap(), [1 << bit]);
        }
        let all = each.into_iter().fold(ActiveLimits::NONE, BitOr::bitor);
        assert_eq!(all, ActiveLimits::ALL);
    }

    #[test]
    fn limits_enter_and_leave_the_set_one_by_one() {
        let mut limits = ActiveLimits::NONE;
        assert!(limits.is_empty());
        limits |= ActiveLimits::FORCE | ActiveLimits::AMPLITUDE;
        assert_eq!(limits.names().collect::<Vec<_>>(), ["force", "amplitude"]);
        limits -= ActiveLimits::FORCE | ActiveLimits::TRAVEL;
        assert_eq!(limits, ActiveLimits::AMPLITUDE);
        assert!(!limits.contains(ActiveLimits::ALL));
        assert_eq!(limits | ActiveLimits::FORCE.when(false), limits);
        assert_eq!(limits | limits, limits);
    }
}
