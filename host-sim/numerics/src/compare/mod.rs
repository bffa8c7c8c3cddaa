//! A measured motion beside the simulated one, as figures 3.16 to 3.23 lay them over each other: time history, phase
//! plane and section, and how far apart they are.

mod align;
mod simulated;

use serde::Serialize;
use shared::model::params::RigParams;
use shared::model::regime::Regime;

use crate::engine::{Engine, Plan, Start};
use crate::error::{Error, RecordError};
use crate::identify::{EVERY_CONTACT, MeasuredImpacts, measure};
use crate::row::extent;
use crate::signal::Signal;
pub use align::pitch;
pub use simulated::{SimulatedInstant, SimulatedMotion};

/// In which frame the measured displacement is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum MeasuredFrame {
    /// Of the laboratory, as the chapter's (3-18)
    Fixed,
    /// Relative to the cart
    Relative,
}

/// What a record is to be compared with: the simulated rig, its drive, and how it is run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ComparisonRequest {
    /// The rig, with its gap.
    pub params: RigParams,
    /// Engine that simulates the motion.
    pub engine: Engine,
    /// Where it starts: which of several motions at one frequency it ends in.
    pub start: Start,
    /// The drive, Hz; none: found from the record.
    pub frequency_hz: Option<f64>,
    /// How long is simulated before it is compared.
    pub plan: Plan,
    /// The frame of the measured displacement.
    pub frame: MeasuredFrame,
}

/// One measured sample and the simulation at that instant.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ComparedSample {
    /// The record's own time, s.
    pub time_s: f64,
    /// Drive phase at that instant, turns from 0 to below 1.
    pub drive_phase: f64,
    /// Measured displacement in the frame of the record, mm; none if it was not measured.
    pub measured_displacement_mm: Option<f64>,
    /// Simulated displacement in the frame of the measured one, mm.
    pub simulated_displacement_mm: f64,
    /// By a straight line through the samples about it, m/s.
    pub measured_velocity_m_per_s: Option<f64>,
    /// Simulated velocity in the frame of the measured displacement, m/s.
    pub simulated_velocity_m_per_s: f64,
    /// Measured contact force, N; none if it was not measured.
    pub measured_force_n: Option<f64>,
    /// Simulated contact force, N.
    pub simulated_force_n: f64,
}

/// Where the drive frequency of a comparison is from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum FrequencySource {
    /// The question gives it.
    Given,
    /// The motion of the cart.
    Cart,
    /// The displacement or the force of the record.
    Record,
}

impl FrequencySource {
    /// Its name, as it is serialised.
    pub fn name(self) -> &'static str {
        match self {
            Self::Given => "given",
            Self::Cart => "cart",
            Self::Record => "record",
        }
    }
}

/// What to keep in mind about a comparison.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Note {
    /// The simulation does not repeat, so the histories drift apart.
    NotRepeating,
    /// The cart moves by another amplitude than the simulation assumes.
    CartAmplitude {
        /// The cart's measured amplitude, mm.
        measured_mm: f64,
        /// The cart's amplitude in the simulation, mm.
        assumed_mm: f64,
    },
    /// The cart was measured, but does not move at the drive frequency alone; its phase is not used.
    CartUnused,
    /// No contact stands out in the measured force.
    NoContact,
    /// The contacts have few samples: their measured time and peak are coarse.
    CoarseContacts {
        /// In a contact, on average.
        samples: f64,
    },
    /// The drive frequency was found from the displacement or the force.
    FrequencyFound,
}

/// How far apart they are.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ComparisonErrors {
    /// Drive frequency of the simulation, Hz.
    pub frequency_hz: f64,
    /// Drive frequency over the natural frequency, Ω/ω.
    pub frequency_ratio: f64,
    /// Where the drive frequency is from.
    pub frequency_from: FrequencySource,
    /// What is added to the record's time to stand at the simulation's drive phase 0, s.
    pub shift_s: f64,
    /// The cart's measured amplitude, mm.
    pub cart_amplitude_mm: Option<f64>,
    /// Regime of the simulation, as text: "p/n", "none", "aperiodic" or "chatter".
    #[serde(serialize_with = "crate::row::regime_as_text")]
    pub regime: Regime,
    /// Number of samples compared: all of the record.
    pub samples: usize,
    /// Root mean square of simulated − measured displacement, mm.
    pub displacement_rms_mm: Option<f64>,
    /// Root mean square of simulated − measured displacement over the measured peak-to-peak displacement, %.
    pub displacement_rms_percent: Option<f64>,
    /// Mean of simulated − measured: a sensor's zero, or a rig that hangs aslant, mm.
    pub displacement_mean_mm: Option<f64>,
    /// Measured peak-to-peak displacement, mm.
    pub measured_peak_to_peak_mm: Option<f64>,
    /// Simulated peak-to-peak displacement, mm.
    pub simulated_peak_to_peak_mm: f64,
    /// Root mean square of simulated − measured force, N.
    pub force_rms_n: Option<f64>,
    /// Largest measured force, N.
    pub measured_force_n: Option<f64>,
    /// Mean of the measured contacts' peaks, N.
    pub measured_peak_mean_n: Option<f64>,
    /// Largest simulated force, N.
    pub simulated_force_n: f64,
    /// Simulated over measured largest force, less 1, %.
    pub force_peak_percent: Option<f64>,
    /// Measured contacts per drive period.
    pub measured_contacts_per_period: Option<f64>,
    /// Simulated contacts per drive period.
    pub simulated_contacts_per_period: f64,
    /// Measured time over the noise's threshold, mean of the contacts, ms.
    pub measured_contact_time_ms: Option<f64>,
    /// Time of the simulated force over the threshold of the measured one's noise, mean of the contacts, ms.
    pub simulated_contact_time_ms: Option<f64>,
    /// What to keep in mind.
    #[serde(skip)]
    pub notes: Vec<Note>,
}

/// Both motions, and what is between them.
#[derive(Clone, Debug)]
pub struct Comparison {
    /// How far the two motions are apart, in figures.
    pub errors: ComparisonErrors,
    /// Each sample of the record with the simulation at its instant.
    pub rows: Vec<ComparedSample>,
    /// The simulated motion over its period.
    pub simulated: SimulatedMotion,
}

/// Lays `signal` over a simulation.
///
/// # Errors
/// If the drive frequency is not found or out of range, if a parameter is out of range, or if the record is shorter
/// than one drive period.
pub fn compare(signal: &Signal, question: &ComparisonRequest) -> Result<Comparison, Error> {
    let (candidates, from) = align::drive(signal, question)?;
    let mut best: Option<(f64, SimulatedMotion, f64)> = None;
    let mut refused = None;
    for frequency_hz in candidates {
        let simulated = match SimulatedMotion::new(question, frequency_hz) {
            Ok(simulated) => simulated,
            Err(error) => {
                refused = Some(error);
                continue;
            }
        };
        let (shift_s, misfit) = align::shift(signal, &simulated, question.frame);
        if best.as_ref().is_none_or(|b| misfit < b.2) {
            best = Some((shift_s, simulated, misfit));
        }
    }
    let Some((shift_s, simulated, _)) = best else {
        return Err(refused.unwrap_or_else(|| signal.lacks(RecordError::NoFrequency)));
    };
    let span = signal.time_s.last().unwrap_or(&0.0) - signal.time_s[0];
    if span * simulated.frequency_hz < 1.0 {
        return Err(signal.lacks(RecordError::ShorterThanPeriod {
            span_s: span,
            frequency_hz: simulated.frequency_hz,
        }));
    }
    let rows = rows(signal, &simulated, shift_s, question.frame);
    let errors = errors(signal, question, &simulated, (shift_s, from), &rows);
    Ok(Comparison {
        errors,
        rows,
        simulated,
    })
}

fn rows(
    signal: &Signal,
    simulated: &SimulatedMotion,
    shift_s: f64,
    frame: MeasuredFrame,
) -> Vec<ComparedSample> {
    let velocity = signal
        .displacement_mm
        .as_ref()
        .map(|d| align::rate(&signal.time_s, d, 0.01 / simulated.frequency_hz));
    let row = |(i, t): (usize, &f64)| {
        let at = simulated.at(t + shift_s, frame);
        ComparedSample {
            time_s: *t,
            drive_phase: ((t + shift_s) * simulated.frequency_hz).rem_euclid(1.0),
            measured_displacement_mm: signal.displacement_mm.as_ref().map(|d| d[i]),
            simulated_displacement_mm: at.displacement_mm,
            measured_velocity_m_per_s: velocity.as_ref().map(|v| v[i] * 1e-3),
            simulated_velocity_m_per_s: at.velocity_m_per_s,
            measured_force_n: signal.force_n.as_ref().map(|f| f[i]),
            simulated_force_n: at.force_n,
        }
    };
    signal.time_s.iter().enumerate().map(row).collect()
}

/// The figures of a comparison.
fn errors(
    signal: &Signal,
    question: &ComparisonRequest,
    simulated: &SimulatedMotion,
    (shift_s, frequency_from): (f64, FrequencySource),
    rows: &[ComparedSample],
) -> ComparisonErrors {
    let displacement = Difference::of(
        rows,
        |r| r.measured_displacement_mm,
        |r| r.simulated_displacement_mm,
    );
    let force = Difference::of(rows, |r| r.measured_force_n, |r| r.simulated_force_n);
    let travel = signal.displacement_mm.as_ref().map(|all| {
        let [low, high] = extent(all.iter().copied());
        high - low
    });
    let found = signal.force_n.as_ref();
    let found = found.and_then(|_| measure(signal, &EVERY_CONTACT).ok());
    let contacts = found.as_ref().and_then(Contacts::of);
    // One definition of the contact time: over the same threshold.
    let modelled = found.and_then(|m| simulated.contact_time_s(m.threshold_n));
    let cart_amplitude_mm = signal
        .cart_mm
        .as_ref()
        .and_then(|cart| align::cart_swing(signal, cart, simulated.frequency_hz))
        .map(|(amplitude, _)| amplitude);
    let mut errors = ComparisonErrors {
        frequency_hz: simulated.frequency_hz,
        frequency_ratio: simulated.frequency_hz / question.params.natural_frequency_hz(),
        frequency_from,
        shift_s,
        cart_amplitude_mm,
        regime: simulated.regime,
        samples: rows.len(),
        displacement_rms_mm: displacement.map(|d| d.rms),
        displacement_rms_percent: displacement.zip(travel).map(|(d, t)| 100.0 * d.rms / t),
        displacement_mean_mm: displacement.map(|d| d.mean),
        measured_peak_to_peak_mm: travel,
        simulated_peak_to_peak_mm: simulated.peak_to_peak_mm(question.frame),
        force_rms_n: force.map(|f| f.rms),
        measured_force_n: contacts.map(|c| c.largest_n),
        measured_peak_mean_n: contacts.map(|c| c.mean_n),
        simulated_force_n: simulated.force_n,
        force_peak_percent: contacts.map(|c| 100.0 * (simulated.force_n / c.largest_n - 1.0)),
        measured_contacts_per_period: contacts
            .map(|c| c.count / (c.span_s * simulated.frequency_hz)),
        simulated_contacts_per_period: simulated.contacts_per_period,
        measured_contact_time_ms: contacts.map(|c| c.duration_s * 1e3),
        simulated_contact_time_ms: modelled.map(|s| s * 1e3),
        notes: Vec::new(),
    };
    errors.notes = notes(signal, question, simulated, &errors, contacts);
    errors
}

/// With fewer samples in a contact its measured time and peak are coarse.
const FEW_SAMPLES: f64 = 10.0;

/// Simulated − measured, over all samples.
#[derive(Clone, Copy)]
struct Difference {
    rms: f64,
    mean: f64,
}

impl Difference {
    /// `None` if a sample was not measured.
    fn of(
        rows: &[ComparedSample],
        measured: fn(&ComparedSample) -> Option<f64>,
        model: fn(&ComparedSample) -> f64,
    ) -> Option<Self> {
        let each: Option<Vec<f64>> = rows.iter().map(|r| Some(model(r) - measured(r)?)).collect();
        each.map(|all| {
            let n = all.len() as f64;
            let square = all.iter().map(|x| x * x).sum::<f64>() / n;
            Self {
                rms: square.sqrt(),
                mean: all.iter().sum::<f64>() / n,
            }
        })
    }
}

/// The contacts of a force at the record's instants.
#[derive(Clone, Copy)]
struct Contacts {
    count: f64,
    /// Length of the record, s.
    span_s: f64,
    /// Mean time over the noise's threshold, s.
    duration_s: f64,
    /// Largest peak, N.
    largest_n: f64,
    /// Mean of the peaks, N.
    mean_n: f64,
    /// Samples over the threshold, mean of the contacts.
    samples: f64,
}

impl Contacts {
    /// `None` if no contact stands out in it.
    fn of(found: &MeasuredImpacts) -> Option<Self> {
        if found.impacts.is_empty() {
            return None;
        }
        let count = found.impacts.len() as f64;
        let times = &found.time_s;
        let durations = found.impacts.iter().map(|impact| found.time_over_s(impact));
        let over = |k: &usize| found.force_n[*k] > found.threshold_n;
        let samples = found.impacts.iter();
        let samples = samples.map(|impact| impact.window.clone().filter(over).count());
        let peaks = || found.impacts.iter().map(|i| i.peak_n);
        Some(Self {
            count,
            span_s: times[times.len() - 1] - times[0] + found.sample_s,
            duration_s: durations.sum::<f64>() / count,
            largest_n: peaks().fold(0.0_f64, f64::max),
            mean_n: peaks().sum::<f64>() / count,
            samples: samples.sum::<usize>() as f64 / count,
        })
    }
}

fn notes(
    signal: &Signal,
    question: &ComparisonRequest,
    simulated: &SimulatedMotion,
    errors: &ComparisonErrors,
    contacts: Option<Contacts>,
) -> Vec<Note> {
    let mut notes = Vec::new();
    if !simulated.repeats {
        notes.push(Note::NotRepeating);
    }
    let assumed_mm = question.params.amplitude_m * 1e3;
    if let Some(measured_mm) = errors.cart_amplitude_mm
        && (measured_mm / assumed_mm - 1.0).abs() > 0.01
    {
        notes.push(Note::CartAmplitude {
            measured_mm,
            assumed_mm,
        });
    }
    if signal.cart_mm.is_some() && errors.cart_amplitude_mm.is_none() {
        notes.push(Note::CartUnused);
    }
    if signal.force_n.is_some() && errors.measured_force_n.is_none() {
        notes.push(Note::NoContact);
    }
    if let Some(few) = contacts.filter(|c| c.samples < FEW_SAMPLES) {
        notes.push(Note::CoarseContacts {
            samples: few.samples,
        });
    }
    if errors.frequency_from == FrequencySource::Record {
        notes.push(Note::FrequencyFound);
    }
    notes
}

#[cfg(test)]
mod tests;
