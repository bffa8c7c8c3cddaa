//! A scenario's events as a list of things due at ticks.

use shared::control::{self, Command};

use super::scenario::{Act, Change, Scenario, Timed};
use super::sensors::{Defect, Sensor};
use super::under_test::Reset;

/// Something due.
#[derive(Clone, Debug, PartialEq)]
pub struct Due {
    /// Tick of the run from which it holds.
    pub tick: u64,
    /// What.
    pub what: Doing,
    /// In words.
    pub text: String,
}

/// What is done.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Doing {
    /// A command is given.
    Command(Command),
    /// The link takes command, or falls silent.
    Link(bool),
    /// The emergency-stop chain opens or closes.
    Emergency(bool),
    /// A sensor goes wrong, or right again.
    Defect(Sensor, Option<Defect>),
    /// The hammer is pushed, m/s.
    Push(f64),
    /// Blocks that overrun, one in so many.
    Overrun(Spell),
    /// Blocks that do not come, one in so many.
    Lost(Spell),
    /// The rig changes, in so many seconds.
    Drift(Change, f64),
    /// The controller is reset.
    Reset(Reset),
}

impl Doing {
    /// Whether it happens to the rig, in the middle of a block if need be; the rest happens to the controller,
    /// between blocks.
    pub fn is_physical(&self) -> bool {
        matches!(
            self,
            Self::Emergency(_) | Self::Defect(..) | Self::Push(_) | Self::Drift(..)
        )
    }
}

/// So many blocks, one in `every`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Spell {
    /// Blocks left.
    pub left: u32,
    /// One in so many.
    pub every: u32,
    /// Blocks since the last.
    pub since: u32,
}

impl Spell {
    fn new(left: u32, every: u32) -> Self {
        // The first falls at once.
        Self {
            left,
            every,
            since: every,
        }
    }

    /// Whether it hits this block.
    pub fn hits(&mut self) -> bool {
        if self.left == 0 {
            return false;
        }
        self.since += 1;
        if self.since < self.every {
            return false;
        }
        self.since = 0;
        self.left -= 1;
        true
    }
}

/// What is due when, by rising tick.
pub fn schedule(scenario: &Scenario) -> Vec<Due> {
    let tick_at = |s: f64| (s / scenario.tick_s()).round() as u64;
    let mut due = Vec::new();
    for Timed { at_s, act } in &scenario.events {
        let (what, end) = doing(act);
        due.push(Due {
            tick: tick_at(*at_s),
            what,
            text: act.text(),
        });
        if let Some((for_s, what)) = end {
            due.push(Due {
                tick: tick_at(at_s + for_s),
                what,
                text: format!("over: {}", act.text()),
            });
        }
    }
    due.sort_by_key(|d| d.tick);
    due
}

/// What an act does, and what ends it after so many seconds.
fn doing(act: &Act) -> (Doing, Option<(f64, Doing)>) {
    let command = |command| (Doing::Command(command), None);
    match *act {
        Act::Start { mode } => command(Command::Start(mode.into())),
        Act::Stop {} => command(Command::Stop),
        Act::ClearFault {} => command(Command::ClearFault),
        Act::SetPoint {
            frequency_hz,
            amplitude_mm,
        } => command(Command::SetPoint {
            frequency_hz: frequency_hz as f32,
            amplitude_m: (1e-3 * amplitude_mm) as f32,
        }),
        Act::Link {} => (Doing::Link(true), None),
        Act::LinkLoss {} => (Doing::Link(false), None),
        Act::EmergencyStop { for_s } => {
            let end = for_s.map(|s| (s, Doing::Emergency(false)));
            (Doing::Emergency(true), end)
        }
        Act::SensorFault {
            sensor,
            fault,
            times,
            for_s,
        } => {
            let end = for_s.map(|s| (s, Doing::Defect(sensor, None)));
            (Doing::Defect(sensor, Some(fault.defect(times))), end)
        }
        Act::Push { speed_m_per_s } => (Doing::Push(speed_m_per_s), None),
        Act::Overrun { blocks, every } => (Doing::Overrun(Spell::new(blocks, every)), None),
        Act::LostBlock { blocks, every } => (Doing::Lost(Spell::new(blocks, every)), None),
        Act::Drift { .. } => {
            let (change, over_s) = act.change().unwrap_or_default();
            (Doing::Drift(change, over_s), None)
        }
        Act::Reset { cause } => (Doing::Reset(cause), None),
    }
}

/// A state's name as scenarios write it.
pub fn state_name(state: control::State) -> &'static str {
    match state {
        control::State::Idle => "idle",
        control::State::SelfTest => "self-test",
        control::State::Ramp => "ramp",
        control::State::Seek => "seek",
        control::State::Hold => "hold",
        control::State::Stop => "stop",
        control::State::Fault => "fault",
        control::State::Manual => "manual",
    }
}
