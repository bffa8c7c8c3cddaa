//! Poincaré sections (figures 3.15–3.23): the points of a trajectory at one or several drive phases, as many as chaos
//! needs; and how the smoothing method changes them (figure 3.4).

pub mod against;
pub mod answer;
pub mod cloud;

use std::f64::consts::TAU;

use serde::Serialize;
use shared::model::params::RigParams;
use shared::model::regime::{Detector, Regime};
use shared::model::rig::Rig;

use crate::engine::{self, CycleRecorder, RecordedSample, Start, event, observe};
use crate::error::{Error, MotionError};
use crate::lanes::strobes;
use crate::progress::{Progress, check, step};
use crate::range::within;
use crate::reference::{Reference, Segment, TrajectoryObserver};
use crate::row::Outcome;

/// The sections to compute of one trajectory.
#[derive(Clone, Debug, PartialEq)]
pub struct SectionRequest {
    /// The rig, with its gap.
    pub params: RigParams,
    /// Drive frequency, Hz.
    pub frequency_hz: f64,
    /// Where to start, at drive phase 0.
    pub start: Start,
    /// Drive phases of the sections, turns from 0 to below 1.
    pub phases: Vec<f64>,
    /// Drive periods before the first point.
    pub transient: u32,
    /// Points of each section.
    pub points: u32,
}

impl SectionRequest {
    /// Refuses what cannot be computed, before anything runs.
    ///
    /// # Errors
    /// If frequency, phases or points are out of range.
    pub fn check(&self) -> Result<(), Error> {
        engine::check_frequency(self.frequency_hz, &self.params)?;
        within([("points", f64::from(self.points), 1.0, 1e7)])?;
        if let Some(bad) = self.phases.iter().find(|p| !(0.0..1.0).contains(*p)) {
            return Err(Error::SectionPhase(*bad));
        }
        if !self.phases.is_sorted_by(|one, next| one < next) {
            return Err(Error::SectionPhaseOrder);
        }
        Ok(())
    }
}

/// A point of a section.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SectionPoint {
    /// Drive phase of the section, turns.
    pub phase_turns: f64,
    /// Drive period it lies in, counted from the first recorded.
    pub period: u64,
    /// l sin θ or Δ, mm.
    pub relative_displacement_mm: f64,
    /// Rate of l sin θ or Δ, m/s.
    pub relative_velocity_m_per_s: f64,
    /// In the fixed frame (3-18): x, mm.
    pub displacement_mm: f64,
    /// In the fixed frame: ẋ, m/s.
    pub velocity_m_per_s: f64,
    /// Contacts that begin in its drive period, from phase 0 to phase 0.
    pub contacts: u16,
    /// Largest contact force in that period, N.
    pub force_n: f64,
}

/// A trajectory on its sections.
#[derive(Clone, Debug)]
pub struct Portrait {
    /// The points, section by section, each in time.
    pub sections: Vec<Vec<SectionPoint>>,
    /// Regime over all recorded periods.
    pub regime: Regime,
    /// Whether nothing repeats and the motion still changes: it is then not known to be aperiodic.
    pub unsettled: bool,
    /// Largest contact force, N.
    pub force_n: f64,
    /// The trajectory over the periods after the last point, for a line in the phase plane.
    pub trajectory: Vec<RecordedSample>,
    /// Steps of the integrator per recorded drive period, those refused included, those that locate a switch not.
    pub steps_per_period: f64,
    /// Coordinate and rate on the section at phase 0 at the end.
    pub end: [f64; 2],
}

impl Portrait {
    /// Its regime, or that it has not settled.
    pub fn outcome(&self) -> Outcome {
        Outcome::new(self.regime, self.unsettled, false)
    }
}

/// Drive periods of [`Portrait::trajectory`].
pub const TRAJECTORY_PERIODS: u32 = 8;
const SAMPLES_PER_PERIOD: usize = 400;

/// Picks the points at the phases out of the smooth pieces of the trajectory: on the quintic through the ends of the
/// step, whose error is below 1e-8 of A0.
struct Strober<'a> {
    times_s: &'a [f64],
    /// Coordinate and rate, deviation of the cart and its rate.
    found: Vec<((f64, f64), [f64; 2])>,
}

impl TrajectoryObserver for Strober<'_> {
    fn segment(&mut self, segment: &Segment) {
        // Sections come in rising phase, so points are found in their order.
        while let Some(t) = self.times_s.get(self.found.len()) {
            if *t >= segment.end.t {
                break;
            }
            self.found.push((segment.at(*t), segment.cart(*t)));
        }
    }
}

/// Runs the trajectory and takes its sections.
///
/// # Errors
/// If a parameter, the frequency, the start or a phase is out of range, or if the hammer leaves what the model
/// describes, or if the work is interrupted.
pub fn portrait(request: &SectionRequest, progress: &dyn Progress) -> Result<Portrait, Error> {
    sections(request, |hammer| hammer, progress)
}

/// [`portrait`] of a hammer that is followed `by` some method.
fn sections(
    request: &SectionRequest,
    by: fn(Reference<f64>) -> Reference<f64>,
    progress: &dyn Progress,
) -> Result<Portrait, Error> {
    let SectionRequest {
        params,
        frequency_hz,
        ..
    } = request;
    request.check()?;
    let rig = Rig::<f64>::new(params)?;
    let omega = TAU * frequency_hz;
    let [q, v] = request.start.section(&rig, omega)?;
    let mut hammer = by(Reference::<f64>::new(params, *frequency_hz, q, v)?);
    for _ in 0..request.transient {
        check(progress)?;
        hammer.run_period(&mut ());
        within_reach(&hammer, *frequency_hz)?;
    }
    let times: Vec<f64> = request
        .phases
        .iter()
        .map(|p| p * hammer.period_s())
        .collect();
    let scale = rig.coordinate_scale();
    let mut detector = Detector::new(scale, scale * omega);
    let (q, v) = hammer.state();
    detector.push(q, v, &shared::model::contacts::Period::default());
    let mut sections = vec![Vec::with_capacity(request.points as usize); times.len()];
    let (mut force_n, steps) = (0.0_f64, hammer.steps());
    for period in 0..u64::from(request.points) {
        let mut strober = Strober {
            times_s: &times,
            found: Vec::with_capacity(times.len()),
        };
        let happened = hammer.run_period(&mut strober);
        within_reach(&hammer, *frequency_hz)?;
        let (q, v) = hammer.state();
        detector.push(q, v, &happened);
        force_n = force_n.max(happened.peak_force);
        for (k, ((q, v), [deviation, drift])) in strober.found.into_iter().enumerate() {
            let phase_turns = request.phases[k];
            let relative = rig.relative_displacement(q);
            let rate = rig.kinematics(q, v).rate;
            let (sin, cos) = (TAU * phase_turns).sin_cos();
            sections[k].push(SectionPoint {
                phase_turns,
                period,
                relative_displacement_mm: relative * 1e3,
                relative_velocity_m_per_s: rate,
                displacement_mm: (relative + rig.amplitude() * sin + deviation) * 1e3,
                velocity_m_per_s: rate + rig.amplitude() * omega * cos + drift,
                contacts: happened.onsets,
                force_n: happened.peak_force,
            });
        }
        step(progress, 1)?;
    }
    let end: [f64; 2] = hammer.state().into();
    let regime = detector.regime();
    let unsettled = {
        let of = |p: &SectionPoint| {
            [
                p.relative_displacement_mm * 1e-3,
                p.relative_velocity_m_per_s,
            ]
        };
        let section: Vec<_> = sections.iter().take(1).flatten().map(of).collect();
        let units = [rig.amplitude(), rig.amplitude() * omega];
        strobes(&section, units).still_change(regime, request.transient as usize)
    };
    Ok(Portrait {
        sections,
        regime,
        unsettled,
        force_n,
        trajectory: trajectory(params, *frequency_hz, end, hammer.cart())?,
        steps_per_period: (hammer.steps() - steps) as f64 / f64::from(request.points),
        end,
    })
}

/// Samples of a few periods from `section` on, with the cart `deviation` off its course.
fn trajectory(
    params: &RigParams,
    frequency_hz: f64,
    section: [f64; 2],
    deviation: [f64; 2],
) -> Result<Vec<RecordedSample>, Error> {
    let mut hammer = event::machine(params, frequency_hz, section, deviation, 0.0)?;
    let mut recorder = CycleRecorder {
        samples_per_period: SAMPLES_PER_PERIOD,
        ..CycleRecorder::default()
    };
    let plan = engine::Plan {
        cycles: TRAJECTORY_PERIODS,
        transient: 0,
    };
    observe(hammer.as_mut(), plan, &mut recorder)?;
    Ok(recorder.samples)
}

fn within_reach(hammer: &Reference<f64>, frequency_hz: f64) -> Result<(), Error> {
    let (q, v) = hammer.state();
    if q.abs() < 1.0 && v.is_finite() {
        return Ok(());
    }
    Err(MotionError::LostOnSection { frequency_hz }.into())
}
