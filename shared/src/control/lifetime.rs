//! What outlives a replacement of the settings.

use super::event::{EventKind, Events};
use super::operator::Operator;
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
    pub operator: Operator,
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
    /// The settings in use are not known to be this rig's ([`super::SettingsState::can_drive`]).
    settings_corrupt: bool,
}

impl Faults {
    /// As the board was started.
    pub fn at_boot(boot: &BootInfo) -> Self {
        Self {
            record: boot.record,
            condition: None,
            settings_corrupt: !boot.settings.can_drive(),
        }
    }

    /// The fault that the start itself is, if it is one.
    pub fn of_boot(boot: &BootInfo) -> Option<Fault> {
        match boot.reset {
            _ if !boot.settings.can_drive() => Some(Fault::CorruptSettings),
            ResetCause::Watchdog => Some(Fault::WatchdogReset),
            ResetCause::BrownOut => Some(Fault::BrownOut),
            _ => None,
        }
    }

    /// Good settings have come.
    pub fn settings_replaced(&mut self) {
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
    /// As a start finds it: it must be heard before the drive goes on; `false`: nobody need be there.
    pub fn expected(in_command: bool) -> Self {
        Self {
            in_command,
            silent_ticks: u32::MAX,
        }
    }

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
