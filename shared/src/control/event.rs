//! Events of the timeline.

use heapless::Deque;
use serde::{Deserialize, Serialize};

use super::{ActiveLimits, Basin, State};
use crate::fault::FaultRecord;

/// Events that can wait to be taken.
pub const EVENT_CAPACITY: usize = 16;

/// The kinds of events.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum EventKind {
    /// The controller went from one state to another.
    State {
        /// State before the change.
        from: State,
        /// State after the change.
        to: State,
    },
    /// A fault tripped, or was there from the start.
    Fault(FaultRecord),
    /// A fault was cleared.
    Cleared,
    /// A forecast was delivered: its target, Hz and N; 0 without a stable 1/1 in the range.
    Forecast {
        /// Frequency of the forecast's target, Hz; 0 without one.
        target_hz: f32,
        /// Peak contact force forecast at the target, N; 0 without one.
        force_n: f32,
    },
    /// The start was given up: there is no stable 1/1 within the limits.
    NoTarget,
    /// The identified rig differs from the believed one: a new forecast is requested.
    Identified {
        /// Natural frequency of the identified rig, Hz.
        natural_hz: f32,
        /// Gap of the identified rig, m.
        gap_m: f32,
    },
    /// The search moved on to a new best frequency, Hz.
    Best {
        /// The new best drive frequency, Hz.
        frequency_hz: f32,
        /// Mean impulse per contact there, N·s.
        impulse_n_s: f32,
    },
    /// 1/1 was lost; it is sought again.
    RegimeLost,
    /// The period doubled: the search stays clear of this frequency.
    Doubling {
        /// Drive frequency at which the doubling was seen, Hz.
        frequency_hz: f32,
    },
    /// The hammer has come to another basin of attraction.
    Basin(Basin),
    /// The set of limits that clamp has changed.
    Limits(ActiveLimits),
    /// A small motion has proven the sensors.
    Proven {
        /// Motion of the cart, as its sensor shows it, over the motion commanded.
        cart: f32,
        /// Hammer over cart; none if the limits allow no motion slow enough to prove it.
        hammer: Option<f32>,
    },
}

/// An event with its time.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Event {
    /// Control ticks since the start (wraps).
    pub tick: u32,
    /// What happened, with its numbers.
    pub kind: EventKind,
}

/// Events waiting to be taken. When they are full, new events are dropped and counted.
#[derive(Clone, Debug, Default)]
pub struct Events {
    waiting: Deque<Event, EVENT_CAPACITY>,
    dropped: u16,
}

impl Events {
    /// Adds an event at control tick `tick`; if the queue is full, it is dropped and counted.
    pub fn push(&mut self, tick: u32, kind: EventKind) {
        if self.waiting.push_back(Event { tick, kind }).is_err() {
            self.dropped = self.dropped.saturating_add(1);
        }
    }

    /// Takes the oldest event out; `None` if none waits.
    pub fn take(&mut self) -> Option<Event> {
        self.waiting.pop_front()
    }

    /// Events dropped so far.
    pub fn dropped(&self) -> u16 {
        self.dropped
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn events_beyond_the_room_for_them_are_counted_and_the_oldest_kept() {
        let mut events = Events::default();
        for tick in 0..EVENT_CAPACITY as u32 + 3 {
            events.push(tick, EventKind::Cleared);
        }
        assert_eq!(events.dropped(), 3);
        for tick in 0..EVENT_CAPACITY as u32 {
            assert_eq!(events.take().map(|event| event.tick), Some(tick));
        }
        assert_eq!(events.take(), None);
        assert_eq!(events.dropped(), 3);
    }
}
