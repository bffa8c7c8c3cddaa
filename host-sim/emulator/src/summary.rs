//! Counts and sums over a run, kept while it runs, by the true contact force.

use shared::control::{State, Status};
use shared::fault::{Fault, Origin, Record};
use shared::model::params::RigParams;

use super::record::{Contact, Event, EventKind, TickRow};
use super::scenario::{Change, Scenario};

/// A fault that tripped.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tripped {
    /// The fault.
    pub fault: Fault,
    /// Which sensor.
    pub origin: Origin,
    /// Tick of the run at which its condition was seen.
    pub tick: u64,
    /// Ticks from then to the first in which the drive was off; none: it never went off.
    pub off_after: Option<u64>,
    /// Tick of the scenario's last event before it.
    pub injected: Option<u64>,
}

/// Sums over whole drive periods in Hold.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Held {
    /// Periods.
    pub periods: u64,
    /// Largest true force of each, added up, N.
    pub force_n: f64,
    /// Drive frequency of each, added up, Hz.
    pub frequency_hz: f64,
    /// Share of the rig's change that was done at each (0 to 1), added up.
    pub drifted: f64,
}

/// The rig before and after it changed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drifted {
    /// Before.
    pub from: RigParams,
    /// After.
    pub to: RigParams,
    began_s: f64,
    over_s: f64,
}

/// Counts and sums over a run.
#[derive(Clone, Debug)]
pub struct Summary {
    tick_s: f64,
    /// When the first start was given, s.
    pub started_s: Option<f64>,
    /// When Hold was first reached, s.
    pub hold_s: Option<f64>,
    /// The controller's last status.
    pub status: Option<Status>,
    /// Contacts.
    pub contacts: u64,
    /// When the last ended, s.
    pub last_contact_s: Option<f64>,
    /// The largest force there was, N.
    pub largest_n: f64,
    /// Largest displacement of the hammer relative to the cart, m.
    pub largest_travel_m: f64,
    /// Periods in Hold.
    pub held: Held,
    /// Faults, as they tripped.
    pub faults: Vec<Tripped>,
    /// How the rig changed.
    pub drifted: Option<Drifted>,
    /// Ticks run.
    pub ticks: u64,
    /// Whether every set-point frequency was finite.
    pub finite: bool,
    last_on: Option<u64>,
    last_act: Option<u64>,
    turns: f64,
    whole: bool,
    period_n: f64,
    holding: bool,
}

impl Summary {
    /// Nothing yet.
    pub fn new(scenario: &Scenario) -> Self {
        Self {
            tick_s: scenario.tick_s(),
            started_s: None,
            hold_s: None,
            status: None,
            contacts: 0,
            last_contact_s: None,
            largest_n: 0.0,
            largest_travel_m: 0.0,
            held: Held::default(),
            faults: Vec::new(),
            drifted: None,
            ticks: 0,
            finite: true,
            last_on: None,
            last_act: None,
            turns: 0.0,
            whole: false,
            period_n: 0.0,
            holding: false,
        }
    }

    /// The controller's state at the end.
    pub fn final_state(&self) -> State {
        self.status.map_or(State::Idle, |status| status.state)
    }

    /// Rig time run, s.
    pub fn end_s(&self) -> f64 {
        self.ticks as f64 * self.tick_s
    }

    /// A tick is done.
    #[inline]
    pub fn tick(&mut self, row: &TickRow) {
        self.ticks += 1;
        self.largest_n = self.largest_n.max(row.true_force_n);
        let travel_m = (row.hammer_m - row.cart_m).abs();
        self.largest_travel_m = self.largest_travel_m.max(travel_m);
        let hz = f64::from(row.output.frequency_hz);
        self.finite &= hz.is_finite();
        if row.output.enable {
            self.last_on = Some(row.tick);
        } else {
            self.went_off(row.tick);
        }
        if !(self.holding && row.output.enable) {
            self.whole = false;
            return;
        }
        self.turns += hz * self.tick_s;
        if self.turns >= 1.0 {
            self.turns -= 1.0;
            self.end_period(row.time_s, hz);
        }
    }

    /// A drive period ends; the first in Hold was not whole.
    fn end_period(&mut self, time_s: f64, hz: f64) {
        if self.whole {
            let drifted = self.drifted.map_or(0.0, |d| {
                let passed = (time_s - d.began_s).max(0.0);
                if d.over_s > passed {
                    passed / d.over_s
                } else {
                    1.0
                }
            });
            self.held.periods += 1;
            self.held.force_n += self.period_n;
            self.held.frequency_hz += hz;
            self.held.drifted += drifted;
        }
        self.whole = true;
        self.period_n = 0.0;
    }

    fn went_off(&mut self, tick: u64) {
        for fault in self.faults.iter_mut().rev() {
            if fault.off_after.is_some() {
                break;
            }
            fault.off_after = Some(tick.saturating_sub(fault.tick));
        }
    }

    /// A contact ended.
    pub fn contact(&mut self, contact: &Contact) {
        self.contacts += 1;
        self.last_contact_s = Some(contact.onset_s + contact.duration_s);
        self.largest_n = self.largest_n.max(contact.peak_force_n);
        self.period_n = self.period_n.max(contact.peak_force_n);
    }

    /// A block is done; `tick` is the next.
    pub fn block(&mut self, tick: u64, status: &Status) {
        self.holding = status.state == State::Hold;
        if self.holding && self.hold_s.is_none() {
            self.hold_s = Some(tick as f64 * self.tick_s);
        }
        self.status = Some(*status);
    }

    /// Something happened.
    pub fn event(&mut self, event: &Event) {
        if matches!(event.what, EventKind::Scenario { .. }) {
            self.last_act = Some(event.tick);
        }
    }

    /// The command to start was given at `time_s`.
    pub fn started(&mut self, time_s: f64) {
        self.started_s.get_or_insert(time_s);
    }

    /// A fault tripped, its condition having been seen at `tick`.
    pub fn fault(&mut self, record: &Record, tick: u64) {
        let was_on = self.last_on.is_some_and(|on| on >= tick);
        self.faults.push(Tripped {
            fault: record.fault,
            origin: record.origin,
            tick,
            off_after: (!was_on).then_some(0),
            injected: self.last_act,
        });
    }

    /// The rig begins to change from `rig`.
    pub fn drift(&mut self, rig: &RigParams, change: &Change, over_s: f64) {
        let before = self.drifted;
        self.drifted = Some(Drifted {
            from: before.map_or(*rig, |d| d.from),
            to: change.apply(rig, 1.0),
            began_s: before.map_or(self.end_s(), |d| d.began_s),
            over_s: before.map_or(0.0, |d| self.end_s() - d.began_s) + over_s,
        });
    }
}
