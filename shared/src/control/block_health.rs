//! Leaky counts of blocks that came late or without samples.

/// A spoilt block (overrun, missing samples) adds this to its count; a good one takes one off.
const SPOILT_WEIGHT: u8 = 4;
/// At this many the fault trips: three in a row, or more than one in five.
const SPOILT_AT: u8 = 10;

/// Counts of late blocks and of blocks without samples.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct BlockHealth {
    overruns: u8,
    stale: u8,
}

impl BlockHealth {
    /// A block's samples have arrived.
    pub fn samples_arrived(&mut self) {
        self.stale = self.stale.saturating_sub(1);
    }

    /// A block's samples have not arrived: the count, if it trips.
    pub fn samples_missing(&mut self) -> Option<u8> {
        self.stale = self.stale.saturating_add(SPOILT_WEIGHT);
        (self.stale >= SPOILT_AT).then_some(self.stale)
    }

    /// A block has been served, late or not.
    pub fn served(&mut self) {
        self.overruns = self.overruns.saturating_sub(1);
    }

    /// The control task ended too late; whether that trips. The late block is served, too, and takes one off
    /// again: hence one more than for missing samples, and the level of two blocks more.
    pub fn overran(&mut self) -> bool {
        self.overruns = self.overruns.saturating_add(SPOILT_WEIGHT + 1);
        self.overruns >= SPOILT_AT + 2
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn three_in_a_row_trip_and_one_in_five_does_not() {
        let mut health = BlockHealth::default();
        let trips = [(); 3].map(|()| {
            let trip = health.overran();
            health.served();
            trip
        });
        assert_eq!(trips, [false, false, true]);
        let mut health = BlockHealth::default();
        assert_eq!(
            [(); 3].map(|()| health.samples_missing()),
            [None, None, Some(12)]
        );
        let mut health = BlockHealth::default();
        for block in 0..1000 {
            if block % 5 == 0 {
                assert_eq!(health.samples_missing(), None);
                assert!(!health.overran());
            } else {
                health.samples_arrived();
            }
            health.served();
        }
    }
}
