//! Frames waiting for the wire.

use heapless::Deque;

/// A queue of `N` bytes that takes frames whole or not at all, and never waits.
#[derive(Debug, Default)]
pub struct ByteQueue<const N: usize> {
    bytes: Deque<u8, N>,
    dropped: u32,
}

impl<const N: usize> ByteQueue<N> {
    /// An empty queue.
    pub const fn new() -> Self {
        Self {
            bytes: Deque::new(),
            dropped: 0,
        }
    }

    /// Bytes that still fit.
    pub fn free(&self) -> usize {
        N.saturating_sub(self.bytes.len())
    }

    /// Takes `frame` if that leaves `reserve` bytes free; else counts it as dropped. Returns whether it was taken.
    pub fn push(&mut self, frame: &[u8], reserve: usize) -> bool {
        if frame.len().saturating_add(reserve) > self.free() {
            self.dropped = self.dropped.saturating_add(1);
            return false;
        }
        for byte in frame {
            // There is room for all of it.
            let _ = self.bytes.push_back(*byte);
        }
        true
    }

    /// Frames that found no room.
    pub fn dropped(&self) -> u32 {
        self.dropped
    }

    /// The next byte for the wire.
    pub fn pop(&mut self) -> Option<u8> {
        self.bytes.pop_front()
    }

    /// Moves the next bytes for the wire into `out`; returns how many.
    pub fn drain(&mut self, out: &mut [u8]) -> usize {
        let mut moved = 0;
        for place in out {
            let Some(byte) = self.bytes.pop_front() else {
                break;
            };
            *place = byte;
            moved += 1;
        }
        moved
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_go_in_whole_or_not_at_all() {
        let mut queue = ByteQueue::<10>::new();
        assert!(queue.push(&[1, 2, 3, 4], 0));
        assert!(!queue.push(&[5, 6, 7], 4));
        assert!(queue.push(&[5, 6, 7], 3));
        assert!(!queue.push(&[8; 4], 0));
        assert_eq!((queue.free(), queue.dropped()), (3, 2));
        let mut out = [0; 6];
        assert_eq!(queue.drain(&mut out), 6);
        assert_eq!(out, [1, 2, 3, 4, 5, 6]);
        assert_eq!((queue.pop(), queue.pop()), (Some(7), None));
        assert_eq!(queue.drain(&mut out), 0);
    }
}
