//! The two engines behind one interface: the event-located reference and the switch model, observed
//! drive period by drive period.

use shared::Real;
use shared::contacts::Period;
use shared::drive::{Drive, TURN};
use shared::params::RigParams;
use shared::regime::{Detector, Regime};
use shared::rig::Rig;
use shared::step::{Corrected, State};
use shared::twin::Twin;

use crate::error::UserError;
use crate::reference::{Contact, Observer, Reference, Segment};

/// Which arithmetic the switch model runs in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Precision {
    /// As on the microcontroller.
    F32,
    /// For analysis.
    F64,
}

/// What integrates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Engine {
    /// The event-located reference ([`crate::reference`]).
    Event,
    /// The switch model of `shared` with the corrected stepper, at a fixed tick.
    Switch {
        /// Its arithmetic.
        precision: Precision,
        /// Its tick, s.
        tick_s: f64,
    },
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
    /// A displacement beyond the wire's length.
    pub fn section(self, rig: &Rig<f64>, omega: f64) -> Result<[f64; 2], UserError> {
        let moving = |x: f64, v: f64| {
            let q = rig.coordinate_at(x);
            let rate = rig.coordinate_rate_at(q, v);
            let inside = rig.kinematics(q, 0.0).delta;
            if !(q.is_finite() && rate.is_finite()) {
                Err(UserError::new(format!(
                    "the start displacement {} mm is out of the rig's reach; choose a smaller one",
                    x * 1e3
                )))
            } else if inside > DEEPEST_START_M {
                Err(UserError::new(format!(
                    "the start displacement {} mm is {} mm inside the impact surface; start at the gap or below",
                    x * 1e3,
                    inside * 1e3
                )))
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

/// One recorded instant.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Sample {
    /// Time since the start, s.
    pub time_s: f64,
    /// l sin θ or Δ, mm.
    pub relative_displacement_mm: f64,
    /// Its rate, m/s.
    pub relative_velocity_m_per_s: f64,
    /// In the fixed frame (3-18): x, mm.
    pub displacement_mm: f64,
    /// In the fixed frame: ẋ, m/s.
    pub velocity_m_per_s: f64,
    /// Contact force, N.
    pub force_n: f64,
}

/// Keeps what the recorded cycles did.
#[derive(Clone, Debug, Default)]
pub struct Recorder {
    /// Samples per drive period kept; 0 keeps none.
    pub samples_per_period: usize,
    /// The samples, in time.
    pub samples: Vec<Sample>,
    /// The finished contacts, in time.
    pub contacts: Vec<Contact>,
}

/// A hammer that can be run a drive period at a time.
pub trait Machine {
    /// Runs to the next drive phase 0; enters what happened in `recorder`, if there is one.
    fn period(&mut self, recorder: Option<&mut Recorder>) -> Period<f64>;
    /// Coordinate and rate on the section now.
    fn section(&self) -> [f64; 2];
    /// The rig.
    fn rig(&self) -> &Rig<f64>;
    /// The frequency really driven, Hz (the switch model rounds it to its phase accumulator).
    fn frequency_hz(&self) -> f64;
}

/// A hammer of `params` driven at `frequency_hz` from `start`.
///
/// # Errors
/// A parameter, frequency or start that cannot be.
pub fn machine(
    engine: Engine,
    params: &RigParams,
    frequency_hz: f64,
    start: Start,
) -> Result<Box<dyn Machine>, UserError> {
    if !(frequency_hz > 0.0 && frequency_hz.is_finite()) {
        return Err(UserError::new(format!(
            "the drive frequency is {frequency_hz} Hz, must be a positive number"
        )));
    }
    let plain = Rig::<f64>::new(params)?;
    let section = start.section(&plain, std::f64::consts::TAU * frequency_hz)?;
    Ok(match engine {
        Engine::Event => {
            let hammer = Reference::<f64>::new(params, frequency_hz, section[0], section[1])?;
            Box::new(Event {
                hammer,
                frequency_hz,
            })
        }
        Engine::Switch {
            precision: Precision::F32,
            tick_s,
        } => Box::new(Switch::<f32>::new(
            params,
            plain,
            frequency_hz,
            tick_s,
            section,
        )?),
        Engine::Switch {
            precision: Precision::F64,
            tick_s,
        } => Box::new(Switch::<f64>::new(
            params,
            plain,
            frequency_hz,
            tick_s,
            section,
        )?),
    })
}

struct Event {
    hammer: Reference<f64>,
    frequency_hz: f64,
}

impl Machine for Event {
    fn period(&mut self, recorder: Option<&mut Recorder>) -> Period<f64> {
        match recorder {
            Some(recorder) => {
                let mut sampler = Sampler {
                    frequency_hz: self.frequency_hz,
                    recorder,
                };
                self.hammer.run_period(&mut sampler)
            }
            None => self.hammer.run_period(&mut ()),
        }
    }
    fn section(&self) -> [f64; 2] {
        self.hammer.state().into()
    }
    fn rig(&self) -> &Rig<f64> {
        self.hammer.rig()
    }
    fn frequency_hz(&self) -> f64 {
        self.frequency_hz
    }
}

/// Samples the reference's smooth pieces: evenly in flight, and a few times per piece in contact, which
/// is over long before the next even sample.
struct Sampler<'a> {
    frequency_hz: f64,
    recorder: &'a mut Recorder,
}

impl Observer for Sampler<'_> {
    fn segment(&mut self, segment: &Segment) {
        let per_period = self.recorder.samples_per_period;
        if per_period == 0 {
            return;
        }
        let began_s = segment.cycle as f64 / self.frequency_hz;
        let mut take = |t: f64| {
            let (q, v) = segment.at(t);
            let force = segment.force(q, v);
            let phase = t * self.frequency_hz;
            let sample = sample(
                segment.rig,
                began_s + t,
                self.frequency_hz,
                phase,
                q,
                v,
                force,
            );
            self.recorder.samples.push(sample);
        };
        let (start, end) = (segment.start.t, segment.end.t);
        if segment.mode == shared::rig::Mode::Contact {
            const PIECES: usize = 6;
            (0..=PIECES).for_each(|i| take(start + (end - start) * i as f64 / PIECES as f64));
            return;
        }
        let spacing = 1.0 / (self.frequency_hz * per_period as f64);
        let mut k = (start / spacing).ceil();
        while k * spacing < end {
            take(k * spacing);
            k += 1.0;
        }
    }

    fn contact(&mut self, contact: &Contact) {
        self.recorder.contacts.push(*contact);
    }
}

fn sample(
    rig: &Rig<f64>,
    time_s: f64,
    frequency_hz: f64,
    turns: f64,
    q: f64,
    v: f64,
    force: f64,
) -> Sample {
    let (sin, cos) = (std::f64::consts::TAU * turns).sin_cos();
    let relative = rig.relative_displacement(q);
    let rate = rig.kinematics(q, v).rate;
    let omega = std::f64::consts::TAU * frequency_hz;
    Sample {
        time_s,
        relative_displacement_mm: relative * 1e3,
        relative_velocity_m_per_s: rate,
        displacement_mm: (relative + rig.amplitude() * sin) * 1e3,
        velocity_m_per_s: rate + rig.amplitude() * omega * cos,
        force_n: force,
    }
}

struct Switch<R> {
    twin: Twin<R, Corrected>,
    plain: Rig<f64>,
    section: [f64; 2],
    ticks: u64,
}

impl<R: Real> Switch<R> {
    fn new(
        params: &RigParams,
        plain: Rig<f64>,
        frequency_hz: f64,
        tick_s: f64,
        section: [f64; 2],
    ) -> Result<Self, UserError> {
        let rig = Rig::<R>::new(params)?;
        let drive = Drive::new(frequency_hz, tick_s)?;
        let state = State::new(&rig, R::from_f64(section[0]), R::from_f64(section[1]));
        Ok(Self {
            twin: Twin::new(rig, drive, Corrected, state),
            plain,
            section,
            ticks: 0,
        })
    }
}

impl<R: Real> Machine for Switch<R> {
    fn period(&mut self, mut recorder: Option<&mut Recorder>) -> Period<f64> {
        let frequency_hz = self.twin.drive().frequency_hz();
        let per_period = (1.0 / (frequency_hz * self.twin.drive().tick_s().to_f64())).max(1.0);
        loop {
            let tick = self.twin.tick();
            self.ticks += 1;
            if let Some(recorder) = recorder.as_deref_mut() {
                let turns =
                    |s: shared::drive::Stamp| f64::from(s.cycle) + f64::from(s.phase) / TURN;
                if let Some(contact) = &tick.contact {
                    recorder.contacts.push(Contact {
                        onset_s: turns(contact.onset) / frequency_hz,
                        duration_s: contact.duration_s.to_f64(),
                        approach_speed_m_per_s: contact.approach_speed.to_f64(),
                        rebound_speed_m_per_s: contact.rebound_speed.to_f64(),
                        peak_force_n: contact.peak_force.to_f64(),
                        peak_at_s: f64::NAN,
                        impulse_n_s: contact.impulse.to_f64(),
                        energy_lost_j: contact.energy_lost.to_f64(),
                    });
                }
                let every =
                    (per_period / recorder.samples_per_period.max(1) as f64).max(1.0) as u64;
                let wanted = self.ticks.is_multiple_of(every) || tick.force > R::ZERO;
                if recorder.samples_per_period > 0 && wanted {
                    let (now, state) = (turns(self.twin.drive().now()), self.twin.state());
                    let (q, v) = (state.q.hi.to_f64(), state.v.hi.to_f64());
                    let force = tick.force.to_f64();
                    let time_s = now / frequency_hz;
                    let sample = sample(&self.plain, time_s, frequency_hz, now, q, v, force);
                    recorder.samples.push(sample);
                }
            }
            if let Some(strobe) = tick.strobe {
                self.section = [strobe.q.to_f64(), strobe.v.to_f64()];
                return Period {
                    onsets: strobe.period.onsets,
                    touched: strobe.period.touched,
                    chatter: strobe.period.chatter,
                    peak_force: strobe.period.peak_force.to_f64(),
                };
            }
        }
    }
    fn section(&self) -> [f64; 2] {
        self.section
    }
    fn rig(&self) -> &Rig<f64> {
        &self.plain
    }
    fn frequency_hz(&self) -> f64 {
        self.twin.drive().frequency_hz()
    }
}

/// How long to run and what to keep.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Plan {
    /// Drive periods in all.
    pub cycles: u32,
    /// How many of the first are not recorded.
    pub transient: u32,
}

/// What the recorded cycles of a run showed.
#[derive(Clone, Debug)]
pub struct Observation {
    /// Frequency really driven, Hz.
    pub frequency_hz: f64,
    /// The regime over the recorded cycles.
    pub regime: Regime,
    /// Largest contact force, N.
    pub force_n: f64,
    /// The finished contact with the largest force.
    pub strongest: Option<Contact>,
    /// The section, oldest first: coordinate and rate.
    pub section: Vec<[f64; 2]>,
}

/// Runs `machine` through `plan`.
///
/// # Errors
/// The hammer left what the model describes (swung over the top, or was thrown out of all reach).
pub fn observe(
    machine: &mut dyn Machine,
    plan: Plan,
    recorder: &mut Recorder,
) -> Result<Observation, UserError> {
    let scale = machine.rig().coordinate_scale();
    let omega = std::f64::consts::TAU * machine.frequency_hz();
    let mut detector = Detector::new(scale, scale * omega);
    let opening = Period::default();
    for _ in 0..plan.transient {
        machine.period(None);
        within_reach(machine)?;
    }
    let [q, v] = machine.section();
    detector.push(q, v, &opening);
    let mut force_n = 0.0_f64;
    let mut section = Vec::new();
    for _ in plan.transient..plan.cycles {
        let period = machine.period(Some(recorder));
        within_reach(machine)?;
        let [q, v] = machine.section();
        detector.push(q, v, &period);
        section.push([q, v]);
        force_n = force_n.max(period.peak_force);
    }
    let strongest = recorder.contacts.iter().copied();
    Ok(Observation {
        frequency_hz: machine.frequency_hz(),
        regime: detector.regime(),
        force_n,
        strongest: strongest.max_by(|a, b| a.peak_force_n.total_cmp(&b.peak_force_n)),
        section,
    })
}

/// Whether the hammer is still where the model holds: on wires below the horizontal, on beams within a
/// metre.
fn within_reach(machine: &dyn Machine) -> Result<(), UserError> {
    const FARTHEST: f64 = 1.0;
    let [q, v] = machine.section();
    if q.abs() < FARTHEST && v.is_finite() {
        return Ok(());
    }
    Err(UserError::new(format!(
        "at {} Hz the hammer leaves what the model describes (beyond 1 rad or 1 m); use a smaller amplitude or start",
        machine.frequency_hz()
    )))
}
