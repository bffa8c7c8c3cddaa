//! What the controller senses and identifies, held to the reference through realistic sensors: 2 % noise on
//! all of them, 12 bits, an anti-alias filter, ringing of half the peak at 3 kHz, a cart that lags.

mod contacts;
mod identification;
mod regimes;
mod rig;

use rig::{Recording, Sensors, record};
use shared::model::params::RigParams;
use shared::sense::identification::Identification;
use shared::sense::{Pulse, Sense, SensedRegime, Strobe};
use shared::settings::Settings;

/// Periods recorded: at 100 one contact more or less shows, and a mean is known to a tenth of its scatter.
const PERIODS: usize = 100;

/// What the controller sensed in a recording, and the recording.
struct Seen {
    recording: Recording,
    pulses: Vec<Pulse>,
    strobes: Vec<Strobe>,
    /// The regime sensed at every strobe.
    measured: Vec<SensedRegime>,
    /// The observer's innovation at every strobe.
    health: Vec<f32>,
    identify: Identification,
}

/// Senses `rig`, driven at `ratio` of its natural frequency, with settings that may believe otherwise.
fn watch(settings: &Settings, rig: &RigParams, ratio: f64, sensors: &Sensors) -> Seen {
    let recording = record(rig, settings, ratio, PERIODS, sensors);
    let mut sense = Sense::new(settings);
    let mut drive = recording.drive;
    let mut seen = Seen {
        recording,
        pulses: vec![],
        strobes: vec![],
        measured: vec![],
        health: vec![],
        identify: Identification::new(settings),
    };
    for (tick, sample) in (0..).zip(&seen.recording.samples) {
        let now = sense.tick(*sample, tick, &drive);
        seen.identify.flight(sample, sense.in_contact());
        if let Some(pulse) = now.pulse {
            seen.identify.pulse(&pulse);
            seen.pulses.push(pulse);
        }
        if let Some(strobe) = now.strobe {
            seen.strobes.push(strobe);
            seen.measured.push(sense.measured());
            seen.health.push(sense.health());
        }
        drive.advance();
    }
    seen
}

/// Mean and standard deviation.
fn spread(values: impl Iterator<Item = f64> + Clone) -> (f64, f64) {
    let count = values.clone().count() as f64;
    let mean = values.clone().sum::<f64>() / count;
    let square = values.map(|v| (v - mean).powi(2)).sum::<f64>() / count;
    (mean, square.sqrt())
}
