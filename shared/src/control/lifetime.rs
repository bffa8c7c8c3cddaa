//! What outlives a replacement of the settings.

use super::event::{EventKind, Events};
use super::phase::Phase;
use super::{BootInfo, ResetCause, State};
use crate::fault::{Fault, Record};
use crate::settings::ticks_of;

/// What lives as long as the controller: everything else is made from the settings.
#[derive(Clone, Debug, Default)]
pub(super) struct Lifetime {
    pub phase: Phase,
    /// Control ticks since the start (wraps).
    pub tick: u32,
    pub events: Events,
    pub faults: Faults,
    pub remote: Remote,
    /// Times 1/1 was lost and sought again.
    pub reseeks: u16,
    /// Overruns of the control task.
    pub overruns: u32,
    /// Number of the next forecast request.
    next_forecast_id: u32,
}

impl Lifetime {
    /// Enters an event at the present tick.
    pub fn push(&mut self, kind: EventKind) {
        self.events.push(self.tick, kind);
    }

    /// Goes to another state and reports it. False, and nothing changes, in that state already.
    pub fn change(&mut self, to: Phase) -> bool {
        let (from, to_state) = (self.phase.state(), to.state());
        if from == to_state {
            return false;
        }
        self.phase = to;
        self.push(EventKind::State { from, to: to_state });
        true
    }

    /// Whether it is in `state`.
    pub fn is_in(&self, state: State) -> bool {
        self.phase.state() == state
    }

    /// A number for a forecast request.
    pub fn forecast_id(&mut self) -> u32 {
        let id = self.next_forecast_id;
        self.next_forecast_id = id.wrapping_add(1);
        id
    }
}

/// The fault that is or was, and what keeps it from being cleared.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Faults {
    pub record: Option<Record>,
    /// A condition that trips was there in the last block.
    pub condition: Option<Fault>,
    /// The stored settings were damaged, and none have been sent since: the defaults in use fit no rig.
    settings_corrupt: bool,
}

impl Faults {
    /// As the board was started.
    pub fn at_boot(boot: &BootInfo) -> Self {
        Self {
            record: boot.record,
            condition: None,
            settings_corrupt: boot.settings_corrupt,
        }
    }

    /// The fault that the start itself is, if it is one.
    pub fn of_boot(boot: &BootInfo) -> Option<Fault> {
        match boot.reset {
            _ if boot.settings_corrupt => Some(Fault::CorruptSettings),
            ResetCause::Watchdog => Some(Fault::WatchdogReset),
            ResetCause::BrownOut => Some(Fault::BrownOut),
            _ => None,
        }
    }

    /// Good settings have come.
    pub fn settings_replaced(&mut self) {
        self.condition = None;
        self.settings_corrupt = false;
    }

    /// Whether the cause of the fault has gone.
    pub fn can_be_cleared(&self) -> bool {
        self.condition.is_none() && !self.settings_corrupt
    }

    /// Whether the recorded fault is `fault`.
    pub fn is(&self, fault: Fault) -> bool {
        self.record.is_some_and(|record| record.fault == fault)
    }
}

/// The computer that steers over the link, and how long it has been silent.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Remote {
    in_command: bool,
    silent_ticks: u32,
}

impl Remote {
    /// It has given a sign of life: it steers.
    pub fn alive(&mut self) {
        *self = Self {
            in_command: true,
            silent_ticks: 0,
        };
    }

    /// A block has passed.
    pub fn pass(&mut self, ticks: u32) {
        self.silent_ticks = self.silent_ticks.saturating_add(ticks);
    }

    /// Whether it steers and has been silent for longer than `timeout_s`; 0: for ever allowed.
    pub fn is_lost(&self, timeout_s: f32) -> bool {
        timeout_s > 0.0 && self.in_command && self.silent_ticks > ticks_of(timeout_s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn requests_are_numbered_and_a_change_is_one_only_once() {
        let mut life = Lifetime::default();
        assert_eq!([(); 3].map(|()| life.forecast_id()), [0, 1, 2]);
        let before = life.phase.state();
        assert!(life.is_in(before) && !life.is_in(State::Stop));
        assert!(life.change(Phase::Stop));
        assert!(life.is_in(State::Stop) && !life.is_in(before));
        assert!(!life.change(Phase::Stop));
        let event = life.events.take().unwrap();
        let change = EventKind::State {
            from: before,
            to: State::Stop,
        };
        assert_eq!(event.kind, change);
        assert!(life.events.take().is_none());
    }

    #[test]
    fn the_start_is_a_fault_after_a_watchdog_a_brown_out_or_damaged_settings() {
        let of = |reset, settings_corrupt| {
            Faults::of_boot(&BootInfo {
                reset,
                settings_corrupt,
                ..BootInfo::default()
            })
        };
        assert_eq!(of(BootInfo::default().reset, false), None);
        assert_eq!(of(ResetCause::Watchdog, false), Some(Fault::WatchdogReset));
        assert_eq!(of(ResetCause::BrownOut, false), Some(Fault::BrownOut));
        for reset in [ResetCause::Watchdog, BootInfo::default().reset] {
            assert_eq!(of(reset, true), Some(Fault::CorruptSettings));
        }
    }

    #[test]
    fn a_fault_is_cleared_only_when_its_cause_has_gone() {
        let corrupt = BootInfo {
            settings_corrupt: true,
            ..BootInfo::default()
        };
        let mut faults = Faults::at_boot(&corrupt);
        assert!(!faults.can_be_cleared());
        faults.settings_replaced();
        assert!(faults.can_be_cleared());
        faults.condition = Some(Fault::BrownOut);
        assert!(!faults.can_be_cleared());
        assert!(!faults.is(Fault::BrownOut), "nothing is recorded");
        faults.record = Some(Record {
            fault: Fault::BrownOut,
            origin: crate::fault::Origin::Force,
            tick: 0,
            value: 0.0,
            frequency_hz: 0.0,
        });
        assert!(faults.is(Fault::BrownOut) && !faults.is(Fault::WatchdogReset));
    }

    #[test]
    fn a_computer_that_steers_is_lost_after_the_timeout_and_not_before() {
        let mut remote = Remote::default();
        let half_s = crate::settings::ticks_of(0.5);
        remote.pass(3 * half_s);
        assert!(!remote.is_lost(0.5), "it does not steer");
        remote.alive();
        remote.pass(half_s - 1);
        remote.pass(1);
        assert!(!remote.is_lost(0.5));
        remote.pass(1);
        assert!(remote.is_lost(0.5));
        assert!(!remote.is_lost(0.0), "no timeout");
        remote.alive();
        assert!(!remote.is_lost(0.5));
    }
}
