//! One point of the map: the motion there, and the other motions that exist beside it.

use numerics::NamedRig;
use numerics::basins::{AttractorShare, BasinsRequest, explore};
use numerics::engine::answer::{ContactRow, RunAnswer, SectionRow, contact_rows, section_rows};
use numerics::engine::{CycleRecorder, Engine, Plan, RecordedSample, Start, machine, observe};
use numerics::orbit::{Orbit, Stability, on_course, shoot_at};
use serde::{Deserialize, Serialize};
use serde_json::json;
use shared::model::rig::Rig;

use super::rig;
use crate::json::{read, write};

#[derive(Deserialize)]
struct Asked {
    rig: rig::RigAsked,
    gap_mm: f64,
    frequency_hz: f64,
    /// Coordinate and rate at drive phase 0, in A0 and A0 Ω; left out: from rest.
    start: Option<[f64; 2]>,
}

impl Asked {
    /// Where the run begins, in the rig's coordinate.
    fn start(&self, rig: &NamedRig) -> Result<Start, String> {
        let Some([q, v]) = self.start else {
            return Ok(Start::Rest);
        };
        let units = units(rig, self.frequency_hz)?;
        Ok(Start::Section([q * units[0], v * units[1]]))
    }
}

/// A0 and A0 Ω in the rig's coordinate.
fn units(rig: &NamedRig, frequency_hz: f64) -> Result<[f64; 2], String> {
    let scale = Rig::<f64>::new(&rig.params)
        .map_err(line)?
        .coordinate_scale();
    Ok([scale, scale * std::f64::consts::TAU * frequency_hz])
}

/// Cycles of the run, as `simulate` has them by default.
const PLAN: Plan = Plan {
    cycles: 600,
    transient: 480,
};

/// Samples of a drive period in the time history.
const SAMPLES: usize = 360;

/// Drive periods of the time history, at least; more where the motion repeats only after more.
const SHOWN: u32 = 2;

/// How a small disturbance of the motion dies away or grows.
#[derive(Serialize)]
struct Multipliers {
    /// Real and imaginary part of the two leading ones.
    multipliers: [(f64, f64); 2],
    modulus: f64,
    stability: Stability,
    periods: u8,
    impacts: u16,
    /// Largest contact force over m g.
    force_ratio: f64,
    frequency_hz: f64,
}

impl Multipliers {
    fn new(rig: &NamedRig, orbit: &Orbit) -> Self {
        Self {
            multipliers: orbit.eigenvalues(),
            modulus: orbit.multipliers().modulus(),
            stability: orbit.stability(),
            periods: orbit.periods,
            impacts: orbit.impacts,
            force_ratio: orbit.force_n / rig.params.weight_n(),
            frequency_hz: orbit.frequency_hz,
        }
    }
}

#[derive(Serialize)]
struct Found {
    /// The run, as the command `simulate` answers.
    #[serde(flatten)]
    answer: RunAnswer,
    /// Of the periodic orbit that the run settled on, if it did and touches.
    orbit: Option<Multipliers>,
    /// The last drive periods of the run.
    history: Vec<RecordedSample>,
    /// Drive periods of them.
    history_periods: u32,
    /// The recorded cycles at drive phase 0.
    section: Vec<SectionRow>,
    /// Contacts in the time history.
    contacts: Vec<ContactRow>,
}

/// The motion at a point of the map, from rest or from a point of the section.
pub fn orbit(argument: &[u8]) -> Result<Vec<u8>, String> {
    let asked: Asked = read(argument)?;
    let rig = asked.rig.at_gap(asked.gap_mm)?;
    let mut hammer = machine(
        Engine::Event,
        &rig.params,
        asked.frequency_hz,
        asked.start(&rig)?,
    )
    .map_err(line)?;
    let mut recorder = CycleRecorder::default();
    let seen = observe(hammer.as_mut(), PLAN, &mut recorder).map_err(line)?;
    let answer = RunAnswer::new(&rig, Engine::Event, PLAN, &seen, &recorder);
    let section = section_rows(&seen, hammer.rig());
    let settled = hammer.section();
    let periods = seen.regime.periods().unwrap_or(1);
    let mut history = CycleRecorder {
        samples_per_period: SAMPLES,
        ..CycleRecorder::default()
    };
    let history_periods = u32::from(periods).max(SHOWN);
    for _ in 0..history_periods {
        hammer.period(Some(&mut history));
    }
    let orbit = seen.regime.periods().and_then(|n| {
        let found = shoot_at(&rig.params, asked.frequency_hz, on_course(settled), n)?;
        Some(Multipliers::new(&rig, &found))
    });
    write(&Found {
        answer,
        orbit,
        contacts: contact_rows(&history),
        history: history.samples,
        history_periods,
        section,
    })
}

/// Starts along each side of the window of [`neighbours`].
const GRID: (usize, usize) = (24, 16);

#[derive(Serialize)]
struct Neighbour {
    #[serde(flatten)]
    share: AttractorShare,
    /// Of its orbit, if it repeats.
    orbit: Option<Multipliers>,
}

/// The motions that starts from a grid of displacements and velocities settle on, with the share of the starts: those of the
/// command `basins`, on a coarse grid.
pub fn neighbours(argument: &[u8]) -> Result<Vec<u8>, String> {
    let asked: Asked = read(argument)?;
    let rig = asked.rig.at_gap(asked.gap_mm)?;
    let query = BasinsRequest {
        samples: 0,
        ..BasinsRequest::usual(rig.clone(), asked.frequency_hz, GRID.0, GRID.1)
    };
    let summary = explore(Engine::Event, &query, &()).map_err(line)?.summary();
    let units = units(&rig, asked.frequency_hz)?;
    let motion = |share: AttractorShare| {
        let orbit = share.section_middle.zip(share.periods).and_then(|(x, n)| {
            let section = [x[0] * units[0], x[1] * units[1]];
            shoot_at(&rig.params, asked.frequency_hz, on_course(section), n)
        });
        Neighbour {
            orbit: orbit.map(|orbit| Multipliers::new(&rig, &orbit)),
            share,
        }
    };
    let motions: Vec<_> = summary.attractors.into_iter().map(motion).collect();
    write(&json!({
        "starts": summary.grid,
        "displacement_mm": summary.displacement_mm,
        "velocity_m_per_s": summary.velocity_m_per_s,
        "cycles": summary.cycles,
        "motions": motions,
    }))
}

fn line(error: impl Into<files::UserError>) -> String {
    error.into().to_string()
}

#[cfg(test)]
mod tests {
    use serde_json::Value;

    use super::*;

    const POINT: &[u8] =
        br#"{"rig":{"source":"wires","recoil":false},"gap_mm":0.0,"frequency_hz":4.0}"#;

    #[test]
    fn the_history_follows_the_recorded_cycles_and_the_orbit_has_multipliers() {
        let found: Value = serde_json::from_slice(&orbit(POINT).unwrap()).unwrap();
        assert_eq!(found["regime"], "1/1");
        assert_eq!(found["section"].as_array().unwrap().len(), 120);
        let history = found["history"].as_array().unwrap();
        // Contacts have samples of their own.
        assert!(history.len() >= SAMPLES * SHOWN as usize);
        assert!(history[0]["time_s"].as_f64().unwrap() >= 600.0 / 4.0 - 1e-9);
        let orbit = &found["orbit"];
        assert_eq!(orbit["stability"], "stable");
        assert!(orbit["modulus"].as_f64().unwrap() < 1.0);
        let (run, shot) = (&found["force_ratio"], &orbit["force_ratio"]);
        let apart = run.as_f64().unwrap() / shot.as_f64().unwrap() - 1.0;
        assert!(apart.abs() < 1e-6, "{apart}");
    }

    #[test]
    fn the_shares_of_the_motions_are_all_of_the_starts() {
        let found: Value = serde_json::from_slice(&neighbours(POINT).unwrap()).unwrap();
        let motions = found["motions"].as_array().unwrap();
        let shares: f64 = motions.iter().map(|m| m["share"].as_f64().unwrap()).sum();
        assert!((shares - 1.0).abs() < 1e-9, "{shares}");
        assert!(motions.iter().any(|m| m["name"] == "1/1"));
    }
}
