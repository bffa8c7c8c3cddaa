//! A scenario's events as a list of actions due at ticks.

use shared::control::Command;

use super::cart::Friction;
use super::scenario::{RigChange, Scenario, ScenarioAct, Stuck, Timed};
use super::sensors::Defect;
use super::under_test::Reset;
use super::world::Recession;

/// An action and when it is due.
#[derive(Clone, Debug, PartialEq)]
pub struct Due {
    /// Tick of the run from which it has effect.
    pub tick: u64,
    /// What is done then.
    pub what: Doing,
    /// The action as a sentence for the timeline.
    pub text: String,
}

/// An action of the scenario, on the rig or on the controller.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Doing {
    /// A command is given.
    Command(Command),
    /// The link takes command, or falls silent.
    Link(bool),
    /// The emergency-stop chain opens or closes, at this time in the tick, s.
    Emergency(bool, f64),
    /// Sensors go wrong, in the order of their codes.
    Defects(usize, [Option<Defect>; 3]),
    /// The defects that this number was given to are over.
    DefectsOver(usize),
    /// The hammer is pushed, m/s.
    Push(f64),
    /// Blocks whose control task overruns.
    Overrun(Spell),
    /// Blocks whose samples are lost.
    Lost(Spell),
    /// The rig changes, over so many seconds.
    Drift(RigChange, f64),
    /// The surface recedes; none: no more.
    Recede(Option<Recession>),
    /// The drive no longer obeys its enable line, or does again.
    Stuck(Option<Stuck>),
    /// The rig tilts to an angle (rad), over so many seconds.
    Tilt(f64, f64),
    /// The cart's friction changes.
    Friction(Option<Friction>),
    /// The controller is reset.
    Reset(Reset),
}

impl Doing {
    /// Whether it acts on the rig, then at its very tick; all others act on the controller, between blocks.
    pub fn is_physical(&self) -> bool {
        let on_the_controller = matches!(
            self,
            Self::Command(_) | Self::Link(_) | Self::Overrun(_) | Self::Lost(_) | Self::Reset(_)
        );
        !on_the_controller
    }
}

/// A number of blocks that are hit, one in `every`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Spell {
    /// How many are still to be hit.
    pub left: u32,
    /// One block in so many is hit.
    pub every: u32,
    /// Blocks since the last that was hit.
    pub since: u32,
}

impl Spell {
    fn new(left: u32, every: u32) -> Self {
        // The first block is hit.
        Self {
            left,
            every,
            since: every,
        }
    }

    /// Whether this block is hit.
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

/// A time that is a whole number of ticks but for its rounding is one, ticks.
const ROUNDING: f64 = 1e-6;

/// The actions of a scenario, by rising tick.
pub fn schedule(scenario: &Scenario) -> Vec<Due> {
    // The emergency-stop chain opens and closes within a tick, everything else between two.
    let tick_at = |s: f64, what: &Doing| {
        let ticks = s / scenario.tick_s();
        match what {
            Doing::Emergency(..) => (ticks + ROUNDING).floor() as u64,
            _ => ticks.round() as u64,
        }
    };
    let mut due = Vec::new();
    for (id, Timed { at_s, act }) in scenario.events.iter().enumerate() {
        let (what, end) = doing(act, id, *at_s, scenario);
        due.push(Due {
            tick: tick_at(*at_s, &what),
            what,
            text: act.text(),
        });
        if let Some((for_s, what)) = end {
            due.push(Due {
                tick: tick_at(at_s + for_s, &what),
                what,
                text: format!("over: {}", act.text()),
            });
        }
    }
    due.sort_by_key(|d| d.tick);
    due
}

/// The action of an act with this number at this time, and the one that ends it after so many seconds.
fn doing(
    act: &ScenarioAct,
    id: usize,
    at_s: f64,
    scenario: &Scenario,
) -> (Doing, Option<(f64, Doing)>) {
    let command = |command| (Doing::Command(command), None);
    match *act {
        ScenarioAct::Start { mode } => command(Command::Start(mode.into())),
        ScenarioAct::Stop {} => command(Command::Stop),
        ScenarioAct::ClearFault {} => command(Command::ClearFault),
        ScenarioAct::Acknowledge {} => command(Command::Acknowledge { opened: true }),
        ScenarioAct::SetPoint {
            frequency_hz,
            amplitude_mm,
        } => command(Command::SetPoint {
            frequency_hz: frequency_hz as f32,
            amplitude_m: (1e-3 * amplitude_mm) as f32,
        }),
        ScenarioAct::Link {} => (Doing::Link(true), None),
        ScenarioAct::LinkLoss {} => (Doing::Link(false), None),
        ScenarioAct::EmergencyStop { for_s } => {
            let end = for_s.map(|s| (s, Doing::Emergency(false, at_s + s)));
            (Doing::Emergency(true, at_s), end)
        }
        ScenarioAct::SensorFault(how) => {
            let end = how.for_s.map(|s| (s, Doing::DefectsOver(id)));
            (Doing::Defects(id, act.defects()), end)
        }
        ScenarioAct::Push { speed_m_per_s } => (Doing::Push(speed_m_per_s), None),
        ScenarioAct::Overrun { blocks, every } => (Doing::Overrun(Spell::new(blocks, every)), None),
        ScenarioAct::LostBlock { blocks, every } => (Doing::Lost(Spell::new(blocks, every)), None),
        ScenarioAct::Drift { .. } => {
            let (change, over_s) = act.change().unwrap_or_default();
            (Doing::Drift(change, over_s), None)
        }
        ScenarioAct::Recede {
            mm_per_j,
            mm_per_s,
            up_to_mm,
            for_s,
        } => {
            let recession = Recession {
                m_per_j: 1e-3 * mm_per_j,
                m_per_s: 1e-3 * mm_per_s,
                left_m: up_to_mm.map_or(f64::INFINITY, |mm| 1e-3 * mm),
            };
            let end = for_s.map(|s| (s, Doing::Recede(None)));
            (Doing::Recede(Some(recession)), end)
        }
        ScenarioAct::StuckDrive { how, for_s } => {
            let end = for_s.map(|s| (s, Doing::Stuck(None)));
            (Doing::Stuck(Some(how)), end)
        }
        ScenarioAct::Tilt { degrees, over_s } => (Doing::Tilt(degrees.to_radians(), over_s), None),
        ScenarioAct::CartFriction { for_s, .. } => {
            let before = scenario.mounting.friction;
            let end = for_s.map(|s| (s, Doing::Friction(before)));
            // Its numbers were checked when it was read.
            (Doing::Friction(act.friction().unwrap_or_default()), end)
        }
        ScenarioAct::Reset { cause } => (Doing::Reset(cause), None),
    }
}
