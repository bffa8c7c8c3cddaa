//! The simulated motion over its period, at any instant.

use shared::model::regime::Regime;

use crate::engine::{CycleRecorder, Plan, RecordedSample, machine, observe};
use crate::error::Error;
use crate::row::extent;

use super::{ComparisonRequest, MeasuredFrame};

/// Times this close are the same, s.
const SAME_INSTANT_S: f64 = 1e-9;

/// Time between samples kept, s: ten to a contact.
const SAMPLE_S: f64 = 5e-5;

/// Samples per drive period kept, at least and at most.
const SAMPLES: (f64, f64) = (400.0, 20_000.0);

/// Drive periods kept of a motion that does not repeat.
const UNREPEATED: u32 = 16;

/// A simulated motion after its transient, sampled over one repetition.
#[derive(Clone, Debug)]
pub struct SimulatedMotion {
    /// Drive frequency really simulated, Hz: the switch engine rounds the one asked for.
    pub frequency_hz: f64,
    /// "p/n", "none", "aperiodic" or "chatter".
    pub regime: Regime,
    /// Whether the section repeats; true of a motion without contact, too.
    pub repeats: bool,
    /// Drive periods kept: those of one repetition, or as many as are there.
    pub periods: u32,
    /// Largest contact force of the recorded cycles, N.
    pub force_n: f64,
    /// Contacts over drive periods.
    pub contacts_per_period: f64,
    /// Section points in both frames are the samples at whole periods; here all samples, time from drive phase 0.
    pub samples: Vec<RecordedSample>,
}

/// The motion at an instant, in the frame asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SimulatedInstant {
    /// Displacement in the frame asked for, mm.
    pub displacement_mm: f64,
    /// Velocity in the frame asked for, m/s.
    pub velocity_m_per_s: f64,
    /// Contact force, N.
    pub force_n: f64,
}

impl SimulatedMotion {
    /// The hammer of `question` driven at `frequency_hz` from its start, settled.
    ///
    /// # Errors
    /// If a parameter or the frequency is out of range.
    pub fn new(question: &ComparisonRequest, frequency_hz: f64) -> Result<Self, Error> {
        let plan = Plan {
            // The last periods are sampled; there must be enough of them.
            cycles: question
                .plan
                .cycles
                .max(question.plan.transient + UNREPEATED),
            ..question.plan
        };
        let mut hammer = machine(
            question.engine,
            &question.params,
            frequency_hz,
            question.start,
        )?;
        let frequency_hz = hammer.frequency_hz();
        let per_period = (1.0 / (frequency_hz * SAMPLE_S)).clamp(SAMPLES.0, SAMPLES.1);
        let early = Plan {
            cycles: plan.cycles - UNREPEATED,
            transient: plan.transient.min(plan.cycles - UNREPEATED - 1),
        };
        let mut quiet = CycleRecorder::default();
        let settled = observe(hammer.as_mut(), early, &mut quiet)?;
        let mut recorder = CycleRecorder {
            samples_per_period: per_period as usize,
            ..CycleRecorder::default()
        };
        let last = Plan {
            cycles: UNREPEATED,
            transient: 0,
        };
        let seen = observe(hammer.as_mut(), last, &mut recorder)?;
        let n = settled.regime.periods().map(u32::from);
        let silent = settled.regime == Regime::None;
        let repeats = n.is_some() || silent;
        let periods = n.unwrap_or(if silent { 1 } else { UNREPEATED });
        let contacts = recorder.contacts.len() as f64 / f64::from(UNREPEATED);
        let mut simulated = Self {
            frequency_hz,
            regime: settled.regime,
            repeats,
            periods,
            force_n: settled.force_n.max(seen.force_n),
            contacts_per_period: contacts,
            samples: with_jumps(recorder.samples),
        };
        simulated.keep_last(f64::from(plan.cycles));
        Ok(simulated)
    }

    /// Keeps the last repetition, its time from 0.
    fn keep_last(&mut self, end_turns: f64) {
        let begin = (end_turns - f64::from(self.periods)) / self.frequency_hz;
        let slack = 1e-6 / self.frequency_hz;
        self.samples.retain(|s| s.time_s >= begin - slack);
        for sample in &mut self.samples {
            sample.time_s -= begin;
        }
    }

    /// How long it takes to repeat, s.
    pub fn span_s(&self) -> f64 {
        f64::from(self.periods) / self.frequency_hz
    }

    /// The motion at `time_s` after drive phase 0 (any number of repetitions on).
    pub fn at(&self, time_s: f64, frame: MeasuredFrame) -> SimulatedInstant {
        let span = self.span_s();
        let time = time_s.rem_euclid(span);
        let n = self.samples.len();
        // A sample at the very onset was taken in contact, whatever its clock's last digits are.
        let after = self
            .samples
            .partition_point(|s| s.time_s <= time + SAME_INSTANT_S);
        let (a, b) = (&self.samples[(after + n - 1) % n], &self.samples[after % n]);
        let from = if after == 0 {
            a.time_s - span
        } else {
            a.time_s
        };
        let to = if after == n {
            b.time_s + span
        } else {
            b.time_s
        };
        let share = if to > from {
            (time - from) / (to - from)
        } else {
            0.0
        };
        let mix = |x: f64, y: f64| x + share * (y - x);
        let (da, db) = (frame.of(a), frame.of(b));
        SimulatedInstant {
            displacement_mm: mix(da.displacement_mm, db.displacement_mm),
            velocity_m_per_s: mix(da.velocity_m_per_s, db.velocity_m_per_s),
            force_n: mix(a.force_n, b.force_n),
        }
    }

    /// The motion at its own instants from `from_s` to `to_s`, s, each with its instant: no contact is missed in between.
    pub fn between(
        &self,
        (from_s, to_s): (f64, f64),
        frame: MeasuredFrame,
    ) -> Vec<(f64, SimulatedInstant)> {
        let span = self.span_s();
        let turns = (from_s / span).floor() as i64..=(to_s / span).floor() as i64;
        let all = turns.flat_map(|turn| {
            let samples = self.samples.iter();
            samples.map(move |sample| (turn as f64 * span + sample.time_s, sample))
        });
        all.filter(|(time_s, _)| (from_s..=to_s).contains(time_s))
            .map(|(time_s, sample)| (time_s, frame.of(sample)))
            .collect()
    }

    /// How long the force is over `threshold_n` in a contact, mean of the contacts that reach twice as much, s; none if
    /// none does.
    pub fn contact_time_s(&self, threshold_n: f64) -> Option<f64> {
        let contacts = self.contacts(threshold_n);
        let times = contacts.iter().map(|contact| contact.1 - contact.0);
        (!contacts.is_empty()).then(|| times.sum::<f64>() / contacts.len() as f64)
    }

    /// From when to when the force is over `threshold_n`, where it reaches twice as much, s.
    pub fn contacts(&self, threshold_n: f64) -> Vec<(f64, f64)> {
        let mut contacts = Vec::new();
        let mut open: Option<(f64, f64)> = None;
        let n = self.samples.len();
        // Round the repetition from a sample without contact on: none is cut in two.
        let begin = (self.samples.iter()).position(|s| s.force_n <= threshold_n);
        for k in begin.map_or(0..0, |begin| begin..begin + n) {
            let nth = |k: usize| RecordedSample {
                time_s: self.samples[k % n].time_s + (k / n) as f64 * self.span_s(),
                ..self.samples[k % n]
            };
            let (a, b) = (nth(k), nth(k + 1));
            let crossing = |a: RecordedSample, b: RecordedSample| {
                let share = (threshold_n - a.force_n) / (b.force_n - a.force_n);
                a.time_s + share * (b.time_s - a.time_s)
            };
            match (a.force_n > threshold_n, b.force_n > threshold_n) {
                (false, true) => open = Some((crossing(a, b), b.force_n)),
                (true, false) => {
                    let whole = open
                        .take()
                        .filter(|(_, peak_n)| *peak_n > 2.0 * threshold_n);
                    contacts.extend(whole.map(|(from, _)| (from, crossing(a, b))));
                }
                _ => {
                    if let Some((_, peak_n)) = &mut open {
                        *peak_n = peak_n.max(b.force_n);
                    }
                }
            }
        }
        contacts
    }

    /// Farthest to farthest, mm.
    pub fn peak_to_peak_mm(&self, frame: MeasuredFrame) -> f64 {
        let [low, high] = extent(self.samples.iter().map(|s| frame.of(s).displacement_mm));
        high - low
    }

    /// Displacement (mm) and velocity (m/s) at each drive phase 0.
    pub fn section(&self, frame: MeasuredFrame) -> Vec<(f64, f64)> {
        let at = |k: u32| {
            let at = self.at(f64::from(k) / self.frequency_hz, frame);
            (at.displacement_mm, at.velocity_m_per_s)
        };
        (0..self.periods).map(at).collect()
    }
}

/// `samples` with each onset twice: the force jumps there, and would else rise from the last sample of the flight on.
fn with_jumps(samples: Vec<RecordedSample>) -> Vec<RecordedSample> {
    let mut all = Vec::with_capacity(samples.len());
    let mut touched = true;
    for sample in samples {
        let touches = sample.force_n > 0.0;
        if touches && !touched {
            all.push(RecordedSample {
                force_n: 0.0,
                ..sample
            });
        }
        touched = touches;
        all.push(sample);
    }
    all
}

impl MeasuredFrame {
    /// A sample in this frame.
    pub fn of(self, sample: &RecordedSample) -> SimulatedInstant {
        let (displacement_mm, velocity_m_per_s) = match self {
            Self::Fixed => (sample.displacement_mm, sample.velocity_m_per_s),
            Self::Relative => (
                sample.relative_displacement_mm,
                sample.relative_velocity_m_per_s,
            ),
        };
        SimulatedInstant {
            displacement_mm,
            velocity_m_per_s,
            force_n: sample.force_n,
        }
    }
}
