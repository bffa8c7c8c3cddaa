//! What the power stage and the enable's relay report back.
//!
//! | input | closed to ground | must be so |
//! |---|---|---|
//! | relay | the relay that the enable's pulses hold has dropped (its mirror contact) | 0.1 s after the enable went off; not so 0.1 s after it came on |
//! | ready | the power stage is ready | 1 s after the enable came on, as long as it is on |
//!
//! An open wire reads as a relay that has not dropped and a stage that is not ready. What contradicts the enable counts as
//! an open chain (fault 1): the controller sees it in its samples, so that a recording has it, too.

use shared::settings::Interlock as Wired;

/// Blocks of 0.5 ms that a contradiction must last, 10 ms: contacts bounce.
const LASTS: u16 = 20;
/// The relay's time to pull in or drop, blocks: 0.1 s.
const RELAY: u16 = 200;
/// The power stage's time to become ready, blocks: 1 s.
const READY: u16 = 2_000;

/// What the inputs show.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Inputs {
    /// The relay has dropped.
    pub dropped: bool,
    /// The power stage is ready.
    pub ready: bool,
}

/// The inputs held against the enable.
#[derive(Clone, Copy, Debug, Default)]
pub struct InterlockInputs {
    enabled: bool,
    /// Blocks since the enable last changed.
    since: u16,
    /// Blocks in a row with a contradiction.
    against: u16,
}

impl InterlockInputs {
    /// Once per block: whether the inputs contradict the enable; `wired`: which of them the rig has.
    #[inline]
    pub fn contradicts(&mut self, enabled: bool, inputs: Inputs, wired: Wired) -> bool {
        if enabled != self.enabled {
            (self.enabled, self.since) = (enabled, 0);
        }
        self.since = self.since.saturating_add(1);
        let relay = wired.relay && self.since > RELAY && inputs.dropped == enabled;
        let ready = wired.ready && self.since > READY && enabled && !inputs.ready;
        self.against = if relay || ready {
            self.against.saturating_add(1)
        } else {
            0
        };
        self.against >= LASTS
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BOTH: Wired = Wired {
        relay: true,
        ready: true,
    };

    /// Blocks until the inputs contradict, if they do within two seconds.
    fn found(interlock: &mut InterlockInputs, on: bool, dropped: bool, ready: bool) -> Option<u32> {
        let inputs = Inputs { dropped, ready };
        (1..4_000).find(|_| interlock.contradicts(on, inputs, BOTH))
    }

    #[test]
    fn a_relay_that_does_not_follow_is_found_within_110_ms_either_way() {
        let mut interlock = InterlockInputs::default();
        assert_eq!(found(&mut interlock, false, true, false), None);
        // On, and the relay does not pull in.
        assert_eq!(found(&mut interlock, true, true, true), Some(220));
        // Welded: off, and it does not drop.
        assert_eq!(found(&mut interlock, false, false, true), Some(220));
        // It has dropped after all.
        assert_eq!(found(&mut interlock, false, true, true), None);
    }

    #[test]
    fn a_power_stage_has_a_second_to_become_ready() {
        let mut interlock = InterlockInputs::default();
        assert_eq!(found(&mut interlock, true, false, false), Some(2_020));
        assert_eq!(
            found(&mut InterlockInputs::default(), true, false, true),
            None
        );
        // It bounces for less than 10 ms.
        let ready = |ready| Inputs {
            dropped: false,
            ready,
        };
        for _ in 0..3_000 {
            interlock.contradicts(true, ready(true), BOTH);
        }
        assert!((0..19).all(|_| !interlock.contradicts(true, ready(false), BOTH)));
        assert!(!interlock.contradicts(true, ready(true), BOTH));
    }

    #[test]
    fn what_is_not_wired_says_nothing() {
        let open = Inputs {
            dropped: false,
            ready: false,
        };
        let mut interlock = InterlockInputs::default();
        let wired = Wired::default();
        let silent = |on| !interlock.contradicts(on, open, wired);
        assert!((0..6_000).map(|i| i >= 3_000).all(silent));
    }
}
