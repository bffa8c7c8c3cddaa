//! The two engines behind one interface: the event-located reference and the switch model, observed
//! drive period by drive period.

pub mod answer;
pub(crate) mod event;
pub mod recorder;
pub mod switch;

use std::collections::VecDeque;

use shared::model::contacts::Period;
use shared::model::params::RigParams;
use shared::model::regime::{Detector, Regime};
use shared::model::rig::Rig;

use crate::error::{Error, MapError, MotionError, StartError};
use crate::lanes::strobes;
use crate::reference::LocatedContact;
pub use recorder::{CycleRecorder, RecordedSample};
pub use switch::{Method, Precision, Setting, Switch};

/// Which engine integrates the motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Engine {
    /// The event-located reference ([`mod@crate::reference`]).
    Event,
    /// The switch model of `shared`, at a fixed tick.
    Switch(Setting),
}

/// Where a run begins, at drive phase 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Start {
    /// At rest relative to the cart.
    Rest,
    /// At rest in the fixed frame: moving at −A0 Ω relative to the cart.
    FixedFrameRest,
    /// Displaced (l sin θ or Δ) and moving relative to the cart, m and m/s.
    Moving(f64, f64),
    /// Coordinate and rate on the section, as another run left them.
    Section([f64; 2]),
}

impl Start {
    /// Coordinate and rate on the section.
    ///
    /// # Errors
    /// If the displacement is out of the rig's reach, or inside the surface.
    pub fn section(self, rig: &Rig<f64>, omega: f64) -> Result<[f64; 2], Error> {
        let moving = |x: f64, v: f64| {
            let q = rig.coordinate_at(x);
            let rate = rig.coordinate_rate_at(q, v);
            let inside = rig.kinematics(q, 0.0).delta;
            if !(q.is_finite() && rate.is_finite()) {
                Err(StartError::OutOfReach { displacement_m: x }.into())
            } else if inside > DEEPEST_START_M {
                Err(StartError::InsideSurface {
                    displacement_m: x,
                    depth_m: inside,
                }
                .into())
            } else {
                Ok([q, rate])
            }
        };
        match self {
            Self::Rest => Ok([rig.rest(), 0.0]),
            Self::FixedFrameRest => moving(0.0, -rig.amplitude() * omega),
            Self::Moving(x, v) => moving(x, v),
            Self::Section(section) => Ok(section),
        }
    }
}

/// A start may press this deep into the surface, m.
const DEEPEST_START_M: f64 = 1e-4;

/// A hammer that can be run a drive period at a time.
pub trait Machine {
    /// Runs to the next drive phase 0; enters what happened in `recorder`, if there is one.
    fn period(&mut self, recorder: Option<&mut CycleRecorder>) -> Period<f64>;
    /// Coordinate and rate on the section now.
    fn section(&self) -> [f64; 2];
    /// The rig, in f64 whatever the arithmetic of the machine.
    fn rig(&self) -> &Rig<f64>;
    /// The frequency really driven, Hz (the switch model rounds it to its phase accumulator).
    fn frequency_hz(&self) -> f64;
    /// The tick that the contacts so far need, s, if the machine's is too long for them.
    fn tick_needed_s(&self) -> Option<f64> {
        None
    }
}

/// A hammer of `params` driven at `frequency_hz` from `start`.
///
/// # Errors
/// If a parameter, the frequency or the start is out of range.
pub fn machine(
    engine: Engine,
    params: &RigParams,
    frequency_hz: f64,
    start: Start,
) -> Result<Box<dyn Machine>, Error> {
    machine_at(engine, params, frequency_hz, start, 0.0)
}

/// [`machine`] starting at drive `phase` (turns, from 0 to below 1): the first period run is what is left of one.
///
/// # Errors
/// As [`machine`]; also if the phase is out of range, or not 0 with the switch model.
pub fn machine_at(
    engine: Engine,
    params: &RigParams,
    frequency_hz: f64,
    start: Start,
    phase: f64,
) -> Result<Box<dyn Machine>, Error> {
    check_frequency(frequency_hz, params)?;
    if !(0.0..1.0).contains(&phase) {
        return Err(StartError::Phase(phase).into());
    }
    let rig = Rig::<f64>::new(params)?;
    let section = start.section(&rig, std::f64::consts::TAU * frequency_hz)?;
    match engine {
        Engine::Event => event::machine(params, frequency_hz, section, [0.0; 2], phase),
        Engine::Switch(_) if params.cart.recoils() => Err(Error::Recoil("the switch model")),
        Engine::Switch(_) if phase != 0.0 => Err(StartError::SwitchPhase.into()),
        Engine::Switch(setting) => switch::machine(setting, params, frequency_hz, section),
    }
}

/// Frequencies over the natural frequency that are run at all. Below, a drive period takes minutes of rig
/// time in which the hammer only follows its own swing; above, the drive hardly moves the hammer.
pub const RATIOS: std::ops::RangeInclusive<f64> = 0.01..=1000.0;

/// Checks that a rig can be driven at `frequency_hz`.
///
/// # Errors
/// If the frequency is not a positive number, or its ratio to the natural frequency is outside [`RATIOS`].
pub fn check_frequency(frequency_hz: f64, params: &RigParams) -> Result<(), Error> {
    if !(frequency_hz > 0.0 && frequency_hz.is_finite()) {
        return Err(Error::Frequency(frequency_hz));
    }
    let ratio = frequency_hz / params.natural_frequency_hz();
    if RATIOS.contains(&ratio) {
        return Ok(());
    }
    Err(Error::FrequencyRatio {
        frequency_hz,
        ratio,
    })
}

/// How long to run and what to keep.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Plan {
    /// Drive periods in all.
    pub cycles: u32,
    /// How many of the first are not recorded.
    pub transient: u32,
}

impl Plan {
    /// A plan that records something.
    ///
    /// # Errors
    /// If no cycle is left to record.
    pub fn new(cycles: u32, transient: u32) -> Result<Self, Error> {
        match cycles {
            0 => Err(MapError::NoCycles.into()),
            _ if transient >= cycles => Err(Error::NothingLeft { transient, cycles }),
            _ => Ok(Self { cycles, transient }),
        }
    }
}

/// Refuses runs of `cycles` of which not the last `recorded` can be recorded.
///
/// # Errors
/// If either is 0, or more are recorded than are run.
pub fn check_recorded(recorded: u32, cycles: u32) -> Result<(), Error> {
    match recorded {
        _ if cycles == 0 => Err(MapError::NoCycles.into()),
        _ if (1..=cycles).contains(&recorded) => Ok(()),
        _ => Err(Error::Recorded { recorded, cycles }),
    }
}

/// What the recorded cycles of a run showed.
#[derive(Clone, Debug)]
pub struct Observation {
    /// Frequency really driven, Hz.
    pub frequency_hz: f64,
    /// The regime over the recorded cycles.
    pub regime: Regime,
    /// Whether what the regime calls the motion may pass: it still changes. See [`Observation::settled_after`].
    pub unsettled: bool,
    /// The number of drive periods from the start after which the section repeats, not recorded ones included; none if
    /// it does not by the end.
    pub settled_after: Option<u32>,
    /// Largest contact force, N.
    pub force_n: f64,
    /// The finished contact with the largest force.
    pub strongest: Option<LocatedContact>,
    /// The section over the recorded cycles, oldest first: coordinate and rate.
    pub section: Vec<[f64; 2]>,
}

/// Runs `machine` through `plan`.
///
/// # Errors
/// If the hammer leaves what the model describes, beyond 1 rad or 1 m, or if the switch model's tick is too long for a
/// contact it met.
pub fn observe(
    machine: &mut dyn Machine,
    plan: Plan,
    recorder: &mut CycleRecorder,
) -> Result<Observation, Error> {
    observe_after(machine, plan, recorder, |_| None)
}

/// [`observe`] for a run of which nobody asks when what is recorded happened: a transient ends as soon as the motion
/// has come to repeat after a few drive periods, and what repeats is recorded a few times.
///
/// # Errors
/// As [`observe`].
pub fn observe_settled(machine: &mut dyn Machine, plan: Plan) -> Result<Observation, Error> {
    let mut arrival = Arrival::of(machine, STILL);
    observe_after(machine, plan, &mut CycleRecorder::default(), |at| {
        arrival.at(&at)
    })
}

/// What moves less than this between two strobes, in A0 and A0 Ω, has settled to rounding.
pub(crate) const STILL: f64 = 1e-12;

/// Whether a motion has come to repeat: a strobe lies within `still` of one a few drive periods before, having lain a thousand
/// times as far from it once. One that was on an orbit from the start has not arrived there: it may leave yet.
pub(crate) struct Arrival {
    /// Of a coordinate and of its rate.
    units: [f64; 2],
    still: f64,
    /// The last strobes, the newest last.
    last: VecDeque<Vec<f64>>,
    farthest: f64,
}

impl Arrival {
    /// Drive periods after which a motion may repeat.
    const MOST: usize = 8;

    /// Of a machine that is about to start; `still` is in A0 and A0 Ω.
    pub(crate) fn of(machine: &dyn Machine, still: f64) -> Self {
        let scale = machine.rig().coordinate_scale();
        Self {
            units: [
                scale,
                scale * std::f64::consts::TAU * machine.frequency_hz(),
            ],
            ..Self::of_section(&machine.section(), still)
        }
    }

    /// Of a motion that starts at `section`, which is in A0 and A0 Ω already.
    pub(crate) fn of_section(section: &[f64], still: f64) -> Self {
        Self {
            units: [1.0; 2],
            still,
            last: [section.to_vec()].into(),
            farthest: 0.0,
        }
    }

    /// After how many drive periods it repeats, at the strobe `section`, which comes one drive period after the last. None
    /// before it does.
    pub(crate) fn at(&mut self, section: &[f64]) -> Option<usize> {
        let moved = |before: &Vec<f64>| {
            let pairs = section.iter().zip(before).zip(self.units.iter().cycle());
            let moved = pairs.map(|((x, before), unit)| ((x - before) / unit).abs());
            moved.fold(0.0, f64::max)
        };
        let last = self.last.back().map_or(0.0, moved);
        self.farthest = self.farthest.max(last);
        let again = self.last.iter().rev().position(|b| moved(b) < self.still);
        if self.last.len() == Self::MOST {
            self.last.pop_front();
        }
        self.last.push_back(section.to_vec());
        again
            .filter(|_| self.farthest > 1e3 * self.still)
            .map(|before| before + 1)
    }
}

/// How many periods are recorded in place of `recorded`, of a motion that has come to repeat after as many as `repeats` says,
/// with `left` periods of its transient to go: twelve repetitions, and the few more after which it is where it would be after
/// all. None if the transient goes on: what is left out of it are whole repetitions.
pub(crate) fn repeated(repeats: Option<usize>, left: usize, recorded: usize) -> Option<usize> {
    const TIMES: usize = 12;
    let n = repeats.filter(|n| left.is_multiple_of(*n))?;
    Some(recorded.min(TIMES * n + recorded % n))
}

fn observe_after(
    machine: &mut dyn Machine,
    plan: Plan,
    recorder: &mut CycleRecorder,
    mut arrived: impl FnMut([f64; 2]) -> Option<usize>,
) -> Result<Observation, Error> {
    let scale = machine.rig().coordinate_scale();
    let omega = std::f64::consts::TAU * machine.frequency_hz();
    let mut detector = Detector::new(scale, scale * omega);
    let opening = Period::default();
    let mut sections = vec![machine.section()];
    let [transient, mut recorded] =
        [plan.transient, plan.cycles - plan.transient].map(|n| n as usize);
    for left in (0..transient).rev() {
        machine.period(None);
        within_reach(machine)?;
        sections.push(machine.section());
        if let Some(fewer) = repeated(arrived(machine.section()), left, recorded) {
            recorded = fewer;
            break;
        }
    }
    let recorded_from = sections.len();
    let [q, v] = machine.section();
    detector.push(q, v, &opening);
    let mut force_n = 0.0_f64;
    for _ in 0..recorded {
        let period = machine.period(Some(recorder));
        within_reach(machine)?;
        let [q, v] = machine.section();
        detector.push(q, v, &period);
        sections.push([q, v]);
        force_n = force_n.max(period.peak_force);
    }
    let strongest = recorder.contacts.iter().copied();
    let (regime, units) = (detector.regime(), [scale, scale * omega]);
    let seen = strobes(&sections[recorded_from..], units);
    let unsettled = seen.still_change(regime, plan.transient as usize);
    let periods = regime.periods().map(usize::from);
    let periods = match unsettled {
        true => (seen.repeats_late()).filter(|late| periods.is_none_or(|n| *late < n)),
        false => periods,
    };
    let settled_after = periods.map(|n| strobes(&sections, units).settled_after(n));
    Ok(Observation {
        frequency_hz: machine.frequency_hz(),
        regime,
        unsettled,
        settled_after,
        force_n,
        strongest: strongest.max_by(|a, b| a.peak_force_n.total_cmp(&b.peak_force_n)),
        section: sections[recorded_from..].to_vec(),
    })
}

/// Whether the hammer is still where the model holds (on wires below the horizontal, on beams within a metre), and was
/// followed in steps that are short enough.
pub(crate) fn within_reach(machine: &dyn Machine) -> Result<(), Error> {
    const FARTHEST: f64 = 1.0;
    let [q, v] = machine.section();
    let frequency_hz = machine.frequency_hz();
    if let Some(needed_s) = machine.tick_needed_s() {
        return Err(MotionError::TickTooLong {
            frequency_hz,
            needed_s,
        }
        .into());
    }
    if q.abs() < FARTHEST && v.is_finite() {
        return Ok(());
    }
    Err(if q.is_finite() {
        MotionError::LeftModel { frequency_hz }.into()
    } else {
        MotionError::Lost { frequency_hz }.into()
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::branch::one_one_branches;
    use crate::orbit::shoot;
    use shared::model::params::WIRES;

    /// Beyond the doubling the 1/1 is unstable: a run that begins on it stays there for as long as rounding takes to grow.
    #[test]
    fn a_motion_arrives_at_what_attracts_it_and_not_at_what_it_began_on() {
        let branch = &one_one_branches(&WIRES, (1.0, 3.0))[0];
        let arrives = |hz: f64, start: Start| {
            let mut hammer = machine(Engine::Event, &WIRES, hz, start).unwrap();
            let mut arrival = Arrival::of(hammer.as_ref(), STILL);
            (1..300).find(|_| {
                hammer.period(None);
                arrival.at(&hammer.section()) == Some(1)
            })
        };
        let stable = arrives(3.0, Start::Rest).unwrap();
        assert!((10..200).contains(&stable), "{stable}");
        let last = branch.orbits.last().unwrap();
        let hz = 1.01 * last.frequency_hz;
        let unstable = shoot(&WIRES, hz, last.section).unwrap();
        assert!(!unstable.is_stable());
        assert_eq!(arrives(hz, Start::Section(unstable.section)), None);
    }

    /// A transient cut short changes nothing of what is seen after it.
    #[test]
    fn what_is_observed_of_a_settled_run_is_what_the_whole_run_shows() {
        let plan = Plan {
            cycles: 320,
            transient: 300,
        };
        for hz in [2.0, 3.0, 4.5, 5.2, 7.4] {
            let mut whole = machine(Engine::Event, &WIRES, hz, Start::Rest).unwrap();
            let mut short = machine(Engine::Event, &WIRES, hz, Start::Rest).unwrap();
            let a = observe(whole.as_mut(), plan, &mut CycleRecorder::default()).unwrap();
            let b = observe_settled(short.as_mut(), plan).unwrap();
            assert_eq!((a.regime, a.unsettled), (b.regime, b.unsettled), "{hz}");
            assert_eq!(a.settled_after, b.settled_after, "{hz}");
            assert!((a.force_n / b.force_n - 1.0).abs() < 1e-9, "{hz}");
        }
    }
}
