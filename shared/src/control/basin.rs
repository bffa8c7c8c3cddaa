//! Which basin of attraction the hammer is in, from the contacts of each drive period.

use super::Basin;

/// Drive periods without contact after which the hammer is in the basin without impact.
const SILENT_PERIODS: u8 = 12;
/// Drive periods with contact after which it is in the basin with impact.
const STRIKING_PERIODS: u8 = 4;

/// Counts drive periods with and without contact.
#[derive(Clone, Copy, Debug)]
pub(super) struct BasinTracker {
    basin: Basin,
    striking: u8,
    silent: u8,
}

impl BasinTracker {
    /// Before the first drive period: the basin is not known.
    pub const NEW: Self = Self {
        basin: Basin::Unknown,
        striking: 0,
        silent: 0,
    };

    /// The basin found last.
    pub fn basin(&self) -> Basin {
        self.basin
    }

    /// A drive period has ended with this many contacts: the basin, if it is another one now.
    pub fn strobe(&mut self, contacts: u16) -> Option<Basin> {
        if contacts > 0 {
            self.striking = self.striking.saturating_add(1);
            self.silent = 0;
        } else {
            self.silent = self.silent.saturating_add(1);
            self.striking = 0;
        }
        let basin = if self.striking >= STRIKING_PERIODS {
            Basin::Impact
        } else if self.silent >= SILENT_PERIODS {
            Basin::NoImpact
        } else {
            self.basin
        };
        let changed = basin != self.basin;
        self.basin = basin;
        changed.then_some(basin)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn four_striking_periods_or_twelve_silent_ones_decide() {
        let mut tracker = BasinTracker::NEW;
        assert!((0..3).all(|_| tracker.strobe(1).is_none()));
        assert_eq!(tracker.strobe(0), None);
        assert!((0..3).all(|_| tracker.strobe(2).is_none()));
        assert_eq!(tracker.strobe(1), Some(Basin::Impact));
        assert_eq!(tracker.strobe(1), None);
        assert!((0..11).all(|_| tracker.strobe(0).is_none()));
        assert_eq!(tracker.basin(), Basin::Impact);
        assert_eq!(tracker.strobe(0), Some(Basin::NoImpact));
    }
}
