//! The blocks of samples: which half of the ring one lies in, how many were served, and what happens without them.
//!
//! Once per millisecond, above every other task, it is checked that blocks are being served. If the control task hangs
//! or is starved, or the samples stop, the drive's enable is taken away 2 to 3 ms after the last block. So it is where the
//! link or the supervisor has not run for 100 ms: nothing would hear a stop or the button.

use core::sync::atomic::{AtomicBool, AtomicU32, Ordering};

use super::{drive, link, supervisor};

/// Blocks served since the start (wraps).
static SERVED: AtomicU32 = AtomicU32::new(0);
/// Set while the flash is erased or written: no block can be served then, and the drive is off.
static PAUSED: AtomicBool = AtomicBool::new(false);
/// Set when the enable was taken away; the control task takes it and reports stale samples.
static ACTED: AtomicBool = AtomicBool::new(false);
/// Set while the link or the supervisor is late.
static LATE: AtomicBool = AtomicBool::new(false);
/// Looks of the guard (wraps).
static LOOKS: AtomicU32 = AtomicU32::new(0);

/// Looks, one per millisecond, between two turns of the link, and of the supervisor, at most.
const PATIENCE: u8 = 100;

/// Both halves of the ring, in its order.
pub const HALVES: [Half; 2] = [Half(0), Half(1)];

/// One half of the ring: which of the two the DMA has just filled. The set-points worked out from it go
/// into the same half of theirs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Half(usize);

impl Half {
    /// The half that is complete, with so many samples `left` until the ring of `samples` begins anew: not the one that is
    /// being written.
    #[inline]
    pub fn complete(left: u16, samples: u16) -> Self {
        Self(usize::from(left > samples / 2))
    }

    /// Which half of the ring, 0 or 1.
    #[inline]
    pub fn index(self) -> usize {
        self.0 & 1
    }
}

/// The block of an interrupt.
#[derive(Clone, Copy, Debug)]
pub struct Arrived {
    /// Whether a block has come; else the guard asks for the controller's reaction to none.
    pub any: bool,
    /// The half that is complete.
    pub half: Half,
    /// Whether the block before it was never taken: the control task came a whole block late.
    pub lost: bool,
    /// Whether the DMA reports an error.
    pub failed: bool,
}

/// Counts a block as served; to be called at the end of the control task.
#[inline]
pub fn served_one() {
    SERVED.fetch_add(1, Ordering::Relaxed);
}

/// Blocks served since the start (wraps).
#[inline]
pub fn served() -> u32 {
    SERVED.load(Ordering::Relaxed)
}

/// Whether blocks were missing since the last call.
#[inline]
pub fn take_stale() -> bool {
    ACTED.swap(false, Ordering::Relaxed)
}

/// Whether the link or the supervisor is late now.
#[inline]
pub fn others_are_late() -> bool {
    LATE.load(Ordering::Relaxed)
}

/// Looks of the guard since the start (wraps).
pub fn looks() -> u32 {
    LOOKS.load(Ordering::Relaxed)
}

/// Runs `work`, during which the processor may stand still; the drive is off.
pub fn paused<T>(work: impl FnOnce() -> T) -> T {
    PAUSED.store(true, Ordering::Relaxed);
    let result = work();
    PAUSED.store(false, Ordering::Relaxed);
    result
}

/// Whether missing blocks are expected now.
#[inline]
pub fn is_paused() -> bool {
    PAUSED.load(Ordering::Relaxed)
}

/// Looks once per millisecond whether blocks are served, and whether link and supervisor have run.
#[derive(Debug, Default)]
pub struct BlockGuard {
    seen: u32,
    missed: u8,
    turns: [u32; 2],
    /// Looks since those of the link and of the supervisor have changed.
    silent: [u8; 2],
}

impl BlockGuard {
    /// A look. Two blocks are due between two of them; none, twice in a row, is a stall: then the enable is taken away, and
    /// the answer is true. The board asks for the control task then: if it was the samples that stopped, the controller
    /// learns it by a block without samples, which does not count as served. The watchdog resets a board that stays so.
    #[inline]
    pub fn finds_a_stall(&mut self) -> bool {
        LOOKS.fetch_add(1, Ordering::Relaxed);
        let now = served();
        let stalled = now == self.seen && !is_paused();
        self.seen = now;
        self.missed = if stalled {
            self.missed.saturating_add(1)
        } else {
            0
        };
        let acts = self.missed >= 2;
        if acts {
            drive::take_away();
            ACTED.store(true, Ordering::Relaxed);
        }
        self.look_at_others();
        acts
    }

    /// Takes the enable away while the link or the supervisor is late: the controller gets blocks without samples then.
    #[inline]
    fn look_at_others(&mut self) {
        let now = [link::turns(), supervisor::turns()];
        let both = self.silent.iter_mut().zip(self.turns.iter().zip(now));
        for (silent, (before, now)) in both {
            *silent = if *before == now && !is_paused() {
                silent.saturating_add(1)
            } else {
                0
            };
        }
        self.turns = now;
        let late = self.silent.iter().any(|silent| *silent > PATIENCE);
        if late {
            drive::take_away();
        }
        LATE.store(late, Ordering::Relaxed);
    }
}
