//! What outlives a replacement of the settings.

use super::event::{EventKind, Events};
use super::operator::Operator;
use super::phase::Phase;
use super::{BootInfo, ResetCause, State};
use crate::fault::{Fault, FaultRecord, FaultSet};
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

/// The faults of the present episode, and what keeps them from being cleared.
///
/// Nothing takes a fault out of an episode but [`Self::clear`], which is for `ClearFault` with every cause gone, and
/// for a link that is heard again after nothing but a link timeout.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Faults {
    pub record: Option<FaultRecord>,
    /// Conditions that tripped in the last block.
    standing: FaultSet,
    /// Whether a whole block of samples has shown no condition since the last one.
    seen_clean: bool,
    /// The settings in use are not known to be this rig's ([`super::SettingsState::can_drive`]).
    settings_corrupt: bool,
    /// The board is not fit to drive: that lasts until it is started again.
    unfit: bool,
}

impl Faults {
    /// As the board was started.
    pub fn at_boot(boot: &BootInfo) -> Self {
        Self {
            record: boot.record,
            settings_corrupt: !boot.settings.can_drive(),
            unfit: !boot.unfit.is_none(),
            ..Self::default()
        }
    }

    /// The fault that the start itself is, if it is one.
    pub fn of_boot(boot: &BootInfo) -> Option<Fault> {
        match boot.reset {
            _ if !boot.settings.can_drive() => Some(Fault::CorruptSettings),
            ResetCause::Watchdog => Some(Fault::WatchdogReset),
            ResetCause::BrownOut => Some(Fault::BrownOut),
            ResetCause::WhileDriving => Some(Fault::ResetWhileDriving),
            _ => None,
        }
    }

    /// A block begins, with samples or without: what stood in the last is not known to stand any more.
    pub fn block_begins(&mut self) {
        self.standing = FaultSet::NONE;
    }

    /// A condition trips in this block.
    pub fn stands(&mut self, fault: Fault) {
        self.standing = self.standing.and(FaultSet::of(fault));
    }

    /// A block of samples has ended; `quiet`: nothing in it was on the way to a trip.
    pub fn block_ends(&mut self, quiet: bool) {
        self.seen_clean = quiet && self.standing.is_empty();
    }

    /// A block had no samples: nothing is known of the conditions.
    pub fn block_was_blind(&mut self) {
        self.seen_clean = false;
    }

    /// Good settings have come. What the samples show under them is not known yet.
    pub fn settings_replaced(&mut self) {
        self.seen_clean = false;
        self.settings_corrupt = false;
    }

    /// Adds a fault to the episode, or begins one. Whether it is the first of its number in it.
    pub fn add(&mut self, new: FaultRecord) -> bool {
        let known = self.record.is_some_and(|record| {
            // A sensor that went beyond its trip level and on to its rail has said one thing, not two.
            let beyond = matches!(record.fault, Fault::OverForce | Fault::OverTravel);
            let same = new.fault == Fault::SensorSaturated && new.origin == record.origin;
            record.episode.contains(new.fault) || (beyond && same)
        });
        if !known {
            self.record = Some(new.after(self.record));
        }
        !known
    }

    /// Whether every cause has gone.
    pub fn can_be_cleared(&self) -> bool {
        self.seen_clean && self.standing.is_empty() && !self.settings_corrupt && !self.unfit
    }

    /// Whether a link that is heard again ends the episode: it is of a link timeout alone, and nothing else stands.
    pub fn ends_with_the_link(&self) -> bool {
        let alone = FaultSet::of(Fault::LinkTimeout);
        self.record.is_some_and(|record| record.episode == alone)
            && self.seen_clean
            && self.standing.without(Fault::LinkTimeout).is_empty()
            && !self.settings_corrupt
            && !self.unfit
    }

    /// The episode is over.
    pub fn clear(&mut self) {
        self.record = None;
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::SettingsState;

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
        let of = |reset, settings| {
            Faults::of_boot(&BootInfo {
                reset,
                settings,
                ..BootInfo::STORED
            })
        };
        for good in [SettingsState::Stored, SettingsState::Model] {
            assert_eq!(of(ResetCause::PowerOn, good), None);
            assert_eq!(of(ResetCause::Watchdog, good), Some(Fault::WatchdogReset));
            assert_eq!(of(ResetCause::BrownOut, good), Some(Fault::BrownOut));
        }
        for bad in [
            SettingsState::Damaged,
            SettingsState::Missing,
            SettingsState::OlderCopy,
        ] {
            for reset in [ResetCause::Watchdog, ResetCause::PowerOn] {
                assert_eq!(of(reset, bad), Some(Fault::CorruptSettings));
            }
        }
    }

    #[test]
    fn a_fault_is_cleared_only_when_its_cause_has_gone() {
        let corrupt = BootInfo {
            settings: SettingsState::Damaged,
            ..BootInfo::STORED
        };
        let mut faults = Faults::at_boot(&corrupt);
        faults.block_ends(true);
        assert!(!faults.can_be_cleared(), "the settings are damaged");
        faults.settings_replaced();
        assert!(!faults.can_be_cleared(), "no samples seen under them");
        faults.block_begins();
        faults.block_ends(true);
        assert!(faults.can_be_cleared());
        faults.block_begins();
        faults.stands(Fault::SensorOpen);
        faults.block_ends(true);
        assert!(!faults.can_be_cleared());
        assert!(faults.record.is_none(), "nothing is recorded");
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

    #[test]
    fn an_episode_names_each_fault_once_and_a_sensor_on_its_way_to_the_rail_once() {
        use crate::fault::Origin;
        let record = |fault, origin| FaultRecord::new(fault, origin, 7, 400.0, 3.6);
        let mut faults = Faults::default();
        assert!(faults.add(record(Fault::OverForce, Origin::Force)));
        assert!(!faults.add(record(Fault::OverForce, Origin::Force)));
        // The force goes on to its rail; then the wire of another sensor lies at one.
        assert!(!faults.add(record(Fault::SensorSaturated, Origin::Force)));
        assert!(faults.add(record(Fault::SensorSaturated, Origin::Hammer)));
        let episode = faults.record.unwrap().episode;
        assert!(episode.contains(Fault::OverForce) && episode.contains(Fault::SensorSaturated));
    }

    #[test]
    fn after_a_block_without_samples_nothing_can_be_cleared() {
        let mut faults = Faults::default();
        faults.block_begins();
        faults.block_ends(true);
        assert!(faults.can_be_cleared());
        faults.block_begins();
        faults.block_was_blind();
        assert!(!faults.can_be_cleared());
    }
}
