//! The link's wire: how much is sent at once, and the bit rate.
//!
//! Rates ([`shared::link::RATES`]): the usual one carries a recording of every tick. Whether a debugger's serial port passes so much on has not been
//! tried. So there is a slower rate, at which everything but a recording of every tick goes through. The board finds out
//! which of them the computer uses: bytes at the wrong rate have no stop bit where one must be.

use shared::link::RATES;

/// Bytes sent at once at most. The link task starts a sending at most once per millisecond, while a recording brings 180 to
/// 198 bytes in that time and the wire carries 225. A sending must be long enough that the turns it occupies beyond the
/// first are used to the full: 256 bytes take 1.14 ms, so two turns, and carry 128 bytes per millisecond.
pub const CHUNK: usize = 1024;

/// Turns with errors, without a good packet, after which the other rate is tried.
const ERRORS: u8 = 2;
/// A packet so many turns ago still speaks for the present rate: disturbances happen.
const FAITHFUL: u16 = 1_000;

/// Finds the rate that the computer uses.
#[derive(Clone, Copy, Debug, Default)]
pub struct RateFinder {
    at: usize,
    errors: u8,
    silent: u16,
    good: u32,
    started: bool,
}

impl RateFinder {
    /// A turn of the link task, a millisecond: whether bytes came that were none at this rate, and how many good packets
    /// there have been (wraps). The rate to go on with, if it is another.
    pub fn turn(&mut self, error: bool, good: u32) -> Option<u32> {
        if good != self.good {
            *self = Self {
                at: self.at,
                good,
                started: true,
                ..Self::default()
            };
            return None;
        }
        self.silent = self.silent.saturating_add(1);
        self.errors = self.errors.saturating_add(u8::from(error));
        let faithful = self.started && self.silent < FAITHFUL;
        if self.errors < ERRORS || faithful {
            return None;
        }
        *self = Self {
            at: (self.at + 1) % RATES.len(),
            good,
            ..Self::default()
        };
        RATES.get(self.at).copied()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use shared::link::{BAUD, ByteQueue};

    /// Frames lost of a recording of `seconds`, after a disturbance of `pause_ms` in which the wire took nothing; sendings
    /// of at most `chunk` bytes. First those of the disturbance and the 0.5 s after it, then all later ones.
    fn lost(chunk: usize, baud: u32, pause_ms: u32, seconds: u32) -> (u32, u32) {
        let mut queue = ByteQueue::<4096>::new();
        let mut buffer = std::vec![0; chunk];
        // A 10-bit byte on the wire, µs; the wire is busy until then.
        let byte_us = 10.0e6 / f64::from(baud);
        let mut busy_until_us = 0.0;
        let mut at_first = 0;
        for turn in 0..1_000 * seconds {
            let now_us = 1e3 * f64::from(turn);
            // Two blocks per turn, of the longest 99 bytes each.
            for _ in 0..2 {
                queue.push(&[0; 99], 0);
            }
            if turn >= pause_ms && now_us >= busy_until_us {
                let count = queue.drain(&mut buffer);
                busy_until_us = now_us + byte_us * count as f64;
            }
            if turn == pause_ms + 500 {
                at_first = queue.dropped();
            }
        }
        (at_first, queue.dropped() - at_first)
    }

    #[test]
    fn after_a_disturbance_a_recording_loses_nothing_more() {
        // What fits into the queue is not lost at all, and what was lost is over when the disturbance is.
        assert_eq!(lost(CHUNK, BAUD, 10, 20), (0, 0));
        let (during, later) = lost(CHUNK, BAUD, 100, 20);
        assert!(during > 0);
        assert_eq!(later, 0);
        // With sendings of 256 bytes it would lose for ever: 128 bytes a millisecond against 198.
        let (_, later) = lost(256, BAUD, 10, 20);
        assert!(later > 10_000, "{later}");
    }

    #[test]
    fn the_slower_rate_cannot_carry_a_recording() {
        assert!(lost(CHUNK, RATES[1], 0, 20).1 > 10_000);
    }

    #[test]
    fn the_computers_rate_is_found_and_kept() {
        let mut finder = RateFinder::default();
        assert_eq!(finder.turn(true, 0), None);
        assert_eq!(finder.turn(false, 0), None);
        assert_eq!(finder.turn(true, 0), Some(RATES[1]));
        // Packets speak for it, through noise and for a second after them.
        assert_eq!(finder.turn(false, 1), None);
        assert!((0..500).all(|_| finder.turn(true, 1).is_none()));
        assert_eq!(finder.turn(true, 2), None);
        assert!((1..FAITHFUL).all(|_| finder.turn(true, 2).is_none()));
        assert_eq!(finder.turn(true, 2), Some(RATES[0]));
        // Silence says nothing.
        assert!((0..5_000).all(|_| finder.turn(false, 2).is_none()));
    }
}
