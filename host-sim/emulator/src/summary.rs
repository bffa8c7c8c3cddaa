//! Counts and sums over a run, kept while it runs, by the true contact force.

use shared::control::{State, Status};
use shared::fault::{Fault, FaultRecord, Origin};
use shared::model::params::RigParams;

use super::record::{RunEvent, RunEventKind, TickRow, TrueContact};
use super::rig_path::RigPath;
use super::scenario::Scenario;
use super::world::levelled;

/// A fault that tripped.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tripped {
    /// Which fault tripped.
    pub fault: Fault,
    /// The sensor that the fault blames; `System`: none.
    pub origin: Origin,
    /// Tick of the run at which its condition was seen.
    pub tick: u64,
    /// Ticks from then to the first in which the drive was off; none: it never went off.
    pub off_after: Option<u64>,
    /// Tick of the scenario's last event before it.
    pub injected: Option<u64>,
}

/// Force over a stretch of time in which the controller was asked to run: from a start to a stop. While the drive
/// is off in it, for whatever reason, the force is none.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ForceSpan {
    /// Length of this time, s.
    pub time_s: f64,
    /// Largest true force of each drive period times its length, added up, N·s.
    pub force_n_s: f64,
}

impl ForceSpan {
    fn add(&mut self, time_s: f64, force_n: f64) {
        self.time_s += time_s;
        self.force_n_s += force_n * time_s;
    }

    /// Mean largest force of a drive period, N; none if no time counted.
    pub fn force_n(&self) -> Option<f64> {
        (self.time_s > 0.0).then(|| self.force_n_s / self.time_s)
    }
}

/// Nearer than this to a contact no drive period is cut, turns.
const CLEAR_TURNS: f64 = 0.1;

/// Turns since the last drive period was cut, at the end of a contact: near a cut, half a turn to go to the next. Else the
/// least jitter would put two contacts into one period and none into the next.
pub fn cut_away_from_contacts(turns: f64) -> f64 {
    if (CLEAR_TURNS..=1.0 - CLEAR_TURNS).contains(&turns) {
        turns
    } else {
        0.5
    }
}

/// Counts and sums over a run.
#[derive(Clone, Debug, Default)]
pub struct RunSummary {
    tick_s: f64,
    /// When the first start was given, s.
    pub started_s: Option<f64>,
    /// When Hold was first reached, s.
    pub hold_s: Option<f64>,
    /// The controller's last status.
    pub status: Option<Status>,
    /// How many contacts have ended.
    pub contacts: u64,
    /// When the last ended, s.
    pub last_contact_s: Option<f64>,
    /// The largest force there was, N.
    pub largest_n: f64,
    /// Largest displacement of the hammer relative to the cart, m.
    pub largest_travel_m: f64,
    /// Largest displacement of the cart, fixed frame, m.
    pub largest_cart_m: f64,
    /// How far the ground has given way, m: at the first Hold, and now.
    pub progress_m: [f64; 2],
    /// Longest time for which the drive stayed powered while a fault of the scenario was present, s.
    pub driven_with_fault_s: f64,
    /// From the first start on.
    pub asked: ForceSpan,
    /// From the first Hold on, whatever came after.
    pub held: ForceSpan,
    /// Whole drive periods in Hold.
    pub hold_periods: u64,
    /// Drive frequency of each, added up, Hz.
    pub hold_hz: f64,
    /// Faults, as they tripped.
    pub faults: Vec<Tripped>,
    /// How the rig changed.
    pub rigs: RigPath,
    /// Ticks run so far.
    pub ticks: u64,
    /// Whether every set-point frequency was finite.
    pub finite: bool,
    last_on: Option<u64>,
    last_act: Option<u64>,
    turns: f64,
    /// Whether the period began in Hold.
    whole: bool,
    period_n: f64,
    period_s: f64,
    holding: bool,
    /// Whether a start was given and no stop since.
    running: bool,
    /// Whether the period began after the first Hold.
    counts_held: bool,
    with_fault_s: f64,
}

impl RunSummary {
    /// The ground has given way so far, m.
    pub fn progress(&mut self, now_m: f64) {
        self.progress_m[1] = now_m;
        if self.hold_s.is_none() {
            self.progress_m[0] = now_m;
        }
    }

    /// Rate of penetration from the first Hold on, m/s.
    pub fn rate_of_penetration(&self) -> Option<f64> {
        let time_s = self.end_s() - self.hold_s?;
        let [before, now] = self.progress_m;
        (time_s > 0.0).then(|| (now - before) / time_s)
    }

    /// The summary of a run of `scenario` before its first tick.
    pub fn new(scenario: &Scenario) -> Self {
        Self {
            tick_s: scenario.tick_s(),
            rigs: RigPath::new(&levelled(&scenario.true_rig, scenario.mounting.tilt_rad)),
            finite: true,
            ..Self::default()
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
        self.largest_cart_m = self.largest_cart_m.max(row.cart_m.abs());
        if row.powered && row.faulty {
            self.with_fault_s += self.tick_s;
            self.driven_with_fault_s = self.driven_with_fault_s.max(self.with_fault_s);
        } else {
            self.with_fault_s = 0.0;
        }
        self.count(row.output.enable, hz);
    }

    /// Counts a tick of a drive period, or of the time in which the drive is off.
    #[inline]
    fn count(&mut self, on: bool, hz: f64) {
        self.whole &= self.holding && on;
        if !self.running {
            self.period_s = 0.0;
            self.period_n = 0.0;
            return;
        }
        self.period_s += self.tick_s;
        if on {
            self.turns += hz * self.tick_s;
        }
        if !on || self.turns >= 1.0 {
            self.turns = if on { self.turns - 1.0 } else { 0.0 };
            self.end_period(hz);
        }
    }

    /// A drive period ends, or a tick without drive.
    fn end_period(&mut self, hz: f64) {
        let (time_s, force_n) = (self.period_s, self.period_n);
        self.asked.add(time_s, force_n);
        if self.counts_held {
            self.held.add(time_s, force_n);
        }
        let held_s = if self.counts_held { time_s } else { 0.0 };
        self.rigs.counted(time_s, held_s);
        if self.whole {
            self.hold_periods += 1;
            self.hold_hz += hz;
        }
        self.whole = self.holding;
        self.counts_held = self.hold_s.is_some();
        self.period_s = 0.0;
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

    /// Counts a contact that ended.
    pub fn contact(&mut self, contact: &TrueContact) {
        self.contacts += 1;
        self.last_contact_s = Some(contact.onset_s + contact.duration_s);
        self.largest_n = self.largest_n.max(contact.peak_force_n);
        self.period_n = self.period_n.max(contact.peak_force_n);
        self.turns = cut_away_from_contacts(self.turns);
    }

    /// A block is done; `tick` is the next.
    pub fn block(&mut self, tick: u64, status: &Status) {
        self.holding = status.state == State::Hold;
        if self.holding && self.hold_s.is_none() {
            self.hold_s = Some(tick as f64 * self.tick_s);
        }
        self.status = Some(*status);
    }

    /// Takes note of an event; those of the scenario count as the last cause of a fault.
    pub fn event(&mut self, event: &RunEvent) {
        if matches!(event.what, RunEventKind::Scenario { .. }) {
            self.last_act = Some(event.tick);
        }
    }

    /// The command to start was given at `time_s`.
    pub fn started(&mut self, time_s: f64) {
        self.started_s.get_or_insert(time_s);
        self.running = true;
    }

    /// The command to stop was given.
    pub fn stopped(&mut self) {
        self.running = false;
    }

    /// A fault tripped, its condition having been seen at `tick`.
    pub fn fault(&mut self, record: &FaultRecord, tick: u64) {
        let was_on = self.last_on.is_some_and(|on| on >= tick);
        self.faults.push(Tripped {
            fault: record.fault,
            origin: record.origin,
            tick,
            off_after: (!was_on).then_some(0),
            injected: self.last_act,
        });
    }

    /// The rig is now this one.
    pub fn rig(&mut self, rig: &RigParams) {
        self.rigs.is(rig, self.ticks as f64 * self.tick_s);
    }
}
