//! A measured motion beside the simulated one, as figures 3.16 to 3.23 lay them over each other: time history, phase
//! plane and section, and how far apart they are.

mod align;
mod simulated;

use serde::Serialize;
use shared::model::params::RigParams;
use shared::model::regime::Regime;

use crate::engine::{Engine, Plan, Start};
use crate::error::{Error, RecordError};
use crate::identify::{Settings, measure};
use crate::signal::Signal;
pub use align::pitch;
pub use simulated::Simulated;

/// In which frame the measured displacement is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Frame {
    /// Of the laboratory, as the chapter's (3-18)
    Fixed,
    /// Relative to the cart
    Relative,
}

/// What is asked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Question {
    /// The rig, with its gap.
    pub params: RigParams,
    /// What simulates.
    pub engine: Engine,
    /// Where it starts: which of several motions at one frequency it ends in.
    pub start: Start,
    /// The drive, Hz; none: found from the record.
    pub frequency_hz: Option<f64>,
    /// How long is simulated before it is compared.
    pub plan: Plan,
    /// The frame of the measured displacement.
    pub frame: Frame,
}

/// One measured sample and the simulation at that instant.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Row {
    /// The record's own time, s.
    pub time_s: f64,
    /// Drive phase, turns.
    pub drive_phase: f64,
    /// Displacement, mm.
    pub measured_displacement_mm: Option<f64>,
    /// Displacement, mm.
    pub simulated_displacement_mm: f64,
    /// By a straight line through the samples about it, m/s.
    pub measured_velocity_m_per_s: Option<f64>,
    /// Velocity, m/s.
    pub simulated_velocity_m_per_s: f64,
    /// Contact force, N.
    pub measured_force_n: Option<f64>,
    /// Contact force, N.
    pub simulated_force_n: f64,
}

/// How far apart they are.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Errors {
    /// The drive, Hz.
    pub frequency_hz: f64,
    /// Ω/ω.
    pub frequency_ratio: f64,
    /// Where it is from: "given", "cart" or "record".
    pub frequency_from: &'static str,
    /// What is added to the record's time to stand at the simulation's drive phase 0, s.
    pub shift_s: f64,
    /// The cart's measured amplitude, mm.
    pub cart_amplitude_mm: Option<f64>,
    /// The simulation's regime.
    #[serde(serialize_with = "crate::row::regime_as_text")]
    pub regime: Regime,
    /// Samples compared.
    pub samples: usize,
    /// Root mean square of simulated − measured displacement, mm.
    pub displacement_rms_mm: Option<f64>,
    /// The same over the measured peak-to-peak displacement, %.
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
    /// Contact time of the simulation's strongest contact, ms.
    pub simulated_contact_time_ms: Option<f64>,
    /// What to keep in mind.
    pub notes: Vec<String>,
}

/// Both motions, and what is between them.
#[derive(Clone, Debug)]
pub struct Comparison {
    /// The figures.
    pub errors: Errors,
    /// Sample by sample.
    pub rows: Vec<Row>,
    /// The simulated motion over its period.
    pub simulated: Simulated,
}

/// Lays `signal` over a simulation.
///
/// # Errors
/// A drive that cannot be found or cannot be, a rig that cannot be, a record too short for one drive period.
pub fn compare(signal: &Signal, question: &Question) -> Result<Comparison, Error> {
    let (candidates, from) = align::drive(signal, question)?;
    let mut best: Option<(f64, Simulated, f64)> = None;
    let mut refused = None;
    for frequency_hz in candidates {
        let simulated = match Simulated::new(question, frequency_hz) {
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
    let errors = errors(signal, question, &simulated, shift_s, from, &rows);
    Ok(Comparison {
        errors,
        rows,
        simulated,
    })
}

fn rows(signal: &Signal, simulated: &Simulated, shift_s: f64, frame: Frame) -> Vec<Row> {
    let velocity = signal
        .displacement_mm
        .as_ref()
        .map(|d| align::rate(&signal.time_s, d, 0.01 / simulated.frequency_hz));
    let row = |(i, t): (usize, &f64)| {
        let at = simulated.at(t + shift_s, frame);
        Row {
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

fn errors(
    signal: &Signal,
    question: &Question,
    simulated: &Simulated,
    shift_s: f64,
    from: &'static str,
    rows: &[Row],
) -> Errors {
    let off = |measured: fn(&Row) -> Option<f64>, model: fn(&Row) -> f64| {
        let each: Option<Vec<f64>> = rows.iter().map(|r| Some(model(r) - measured(r)?)).collect();
        each.map(|all| {
            let n = all.len() as f64;
            let square = all.iter().map(|x| x * x).sum::<f64>() / n;
            (square.sqrt(), all.iter().sum::<f64>() / n)
        })
    };
    let displacement = off(
        |r| r.measured_displacement_mm,
        |r| r.simulated_displacement_mm,
    );
    let force = off(|r| r.measured_force_n, |r| r.simulated_force_n);
    let travel = signal.displacement_mm.as_ref().map(|d| {
        let high = d.iter().fold(f64::NEG_INFINITY, |m, x| m.max(*x));
        high - d.iter().fold(f64::INFINITY, |m, x| m.min(*x))
    });
    let everything = Settings {
        release_m: 0.0,
        seek_release: false,
        seek_exponent: false,
        impacts: usize::MAX,
    };
    let times = &signal.time_s;
    let span = times[times.len() - 1] - times[0] + signal.sample_s();
    let contacts = signal
        .force_n
        .as_ref()
        .and_then(|_| measure(signal, &everything).ok());
    let count = contacts.as_ref().map(|c| c.impacts.len() as f64);
    let over = contacts.as_ref().map(|c| {
        let long = |i: &crate::identify::Impact| {
            let inside = i.window.clone().skip(1);
            let over = inside.filter(|k| c.force_n[*k] > c.threshold_n);
            over.map(|k| c.time_s[k] - c.time_s[k - 1]).sum::<f64>()
        };
        c.impacts.iter().map(long).sum::<f64>() / c.impacts.len() as f64
    });
    let largest = contacts
        .as_ref()
        .map(|c| c.impacts.iter().fold(0.0_f64, |m, i| m.max(i.peak_n)));
    let mean = contacts
        .as_ref()
        .map(|c| c.impacts.iter().map(|i| i.peak_n).sum::<f64>() / c.impacts.len() as f64);
    let mut notes = Vec::new();
    if !simulated.repeats {
        notes.push("the simulation does not repeat: histories drift apart, compare the phase plane and the forces".to_owned());
    }
    let cart_amplitude_mm = signal
        .cart_mm
        .as_ref()
        .and_then(|cart| align::cart_swing(signal, cart, simulated.frequency_hz))
        .map(|(amplitude, _)| amplitude);
    let assumed_mm = question.params.amplitude_m * 1e3;
    if let Some(mm) = cart_amplitude_mm
        && (mm / assumed_mm - 1.0).abs() > 0.01
    {
        notes.push(format!(
            "the cart moves by {mm:.4} mm, the simulation's by {assumed_mm:.4} mm: --set amplitude_mm={mm:.4} compares like with like"
        ));
    }
    if signal.cart_mm.is_some() && cart_amplitude_mm.is_none() {
        notes.push(
            "the cart does not move at this frequency alone: its phase is not used".to_owned(),
        );
    }
    if signal.force_n.is_some() && contacts.is_none() {
        notes.push("no contact stands out in the measured force".to_owned());
    }
    if from == "record" {
        notes.push("the drive frequency is found from the record: the strongest pitch or a multiple of it, whichever the simulation is most like; give --frequency if it is known".to_owned());
    }
    Errors {
        frequency_hz: simulated.frequency_hz,
        frequency_ratio: simulated.frequency_hz / question.params.natural_frequency_hz(),
        frequency_from: from,
        shift_s,
        cart_amplitude_mm,
        regime: simulated.regime.clone(),
        samples: rows.len(),
        displacement_rms_mm: displacement.map(|d| d.0),
        displacement_rms_percent: displacement.zip(travel).map(|(d, t)| 100.0 * d.0 / t),
        displacement_mean_mm: displacement.map(|d| d.1),
        measured_peak_to_peak_mm: travel,
        simulated_peak_to_peak_mm: simulated.peak_to_peak_mm(question.frame),
        force_rms_n: force.map(|f| f.0),
        measured_force_n: largest,
        measured_peak_mean_n: mean,
        simulated_force_n: simulated.force_n,
        force_peak_percent: largest.map(|f| 100.0 * (simulated.force_n / f - 1.0)),
        measured_contacts_per_period: count.map(|n| n / (span * simulated.frequency_hz)),
        simulated_contacts_per_period: simulated.contacts_per_period,
        measured_contact_time_ms: over.map(|s| s * 1e3),
        simulated_contact_time_ms: simulated.contact_time_s.map(|s| s * 1e3),
        notes,
    }
}

#[cfg(test)]
mod tests;
