//! The published drifting oscillator: a free mass under a static and a harmonic force on the same ground, without
//! dimensions: x'' = b + a cos ωτ − F, with k = Pf = m = 1 and c = 2ξ (Pavlovskaia, Wiercigroch and Grebogi, Physical
//! Review E 64, 056224, 2001; Pavlovskaia and Wiercigroch, Chaos, Solitons and Fractals 19, 2004, "Analytical drift
//! reconstruction for visco-elastic impact oscillators operating in periodic and chaotic regimes").
//!
//! Nothing holds the mass in place, so the front of the ground can be taken as origin at any time: the bounded motion is
//! that of p = x − v, the mass seen from the front, and the gap between them at the start does not matter.

use serde::Serialize;
use shared::model::contacts::Period;
use shared::model::regime::{Detector, Regime};
use shared::model::slider::Slider;

use super::body::FreeMass;
use super::march::Drill;
use super::run::DrillPlan;
use crate::error::{Error, MotionError};
use crate::parallel;
use crate::progress::{Progress, step};
use crate::row::regime_as_text;

/// Its parameters, without dimensions.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Drifting {
    /// Amplitude of the harmonic force over Pf.
    pub a: f64,
    /// Static force over Pf.
    pub b: f64,
    /// Damping: c = 2ξ.
    pub xi: f64,
    /// Drive frequency ω over √(k/m).
    pub omega: f64,
}

/// A motion that the authors show: figure 3 of the second paper, "phase plane of a period two motion".
pub const PERIOD_TWO: Drifting = Drifting {
    a: 0.3,
    b: 0.1,
    xi: 0.01,
    omega: 0.1,
};

/// What it does at one set of parameters.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DriftingRow {
    /// Amplitude of the harmonic force over Pf.
    pub a: f64,
    /// Static force over Pf.
    pub b: f64,
    /// Damping ratio ξ: c = 2ξ.
    pub xi: f64,
    /// Drive frequency ω over √(k/m).
    pub omega: f64,
    /// Drive periods after which the motion repeats; none if it does not.
    pub periods: Option<u8>,
    /// Regime: contacts over drive periods.
    #[serde(serialize_with = "regime_as_text")]
    pub regime: Regime,
    /// Progress per drive period over Pf/k.
    pub progress_per_period: f64,
    /// Progress per unit of time, over Pf/√(k m).
    pub progression_rate: f64,
    /// Points of the section at ωτ = 0 (p and its rate), one for each recorded period.
    #[serde(skip)]
    pub section: Vec<(f64, f64)>,
}

impl Drifting {
    /// The integrator of this motion, touching the ground at rest.
    ///
    /// # Errors
    /// The first parameter out of range.
    pub fn start(&self) -> Result<Drill<f64>, Error> {
        let hz = self.omega / std::f64::consts::TAU;
        if !(hz > 0.0 && hz.is_finite()) {
            return Err(Error::Frequency(hz));
        }
        let ground = Slider {
            stiffness: 1.0,
            damping: 2.0 * self.xi,
            threshold: 1.0,
        };
        let mass = FreeMass {
            mass: 1.0,
            static_force: self.b,
            amplitude: self.a,
        };
        Ok(Drill::free(mass, 0.0, &ground, hz)?)
    }

    /// Runs it.
    ///
    /// # Errors
    /// If a parameter is out of range, or the motion cannot be followed.
    pub fn run(&self, plan: DrillPlan) -> Result<DriftingRow, Error> {
        let mut drill = self.start()?;
        let mut blows = Vec::new();
        for _ in 0..plan.settle {
            drill.run_period(&mut blows);
            blows.clear();
        }
        // The section's own size is a few units: the drive moves a free mass by a/ω².
        let scale = self.a / (self.omega * self.omega);
        let mut detector = Detector::with_tolerance(scale, scale * self.omega, 1e-5);
        let mut section = Vec::with_capacity(plan.recorded as usize);
        let [q, v, _] = drill.section();
        detector.push(q, v, &Period::default());
        let before = drill.drift_m();
        for _ in 0..plan.recorded {
            let (period, _) = drill.run_period(&mut blows);
            let [q, v, _] = drill.section();
            if q.is_nan() {
                let frequency_hz = self.omega / std::f64::consts::TAU;
                return Err(MotionError::Lost { frequency_hz }.into());
            }
            detector.push(q, v, &period);
            section.push((q, v));
        }
        let regime = detector.regime();
        let per_period = (drill.drift_m() - before) / f64::from(plan.recorded);
        Ok(DriftingRow {
            a: self.a,
            b: self.b,
            xi: self.xi,
            omega: self.omega,
            periods: regime.periods(),
            regime,
            progress_per_period: per_period,
            progression_rate: per_period / drill.period_s(),
            section,
        })
    }
}

/// Runs every one of `motions`. A step of the progress is a motion.
///
/// # Errors
/// If a parameter is out of range, a motion cannot be followed, or the work is interrupted.
pub fn diagram(
    motions: &[Drifting],
    plan: DrillPlan,
    progress: &dyn Progress,
) -> Result<Vec<DriftingRow>, Error> {
    parallel::try_map(motions, |motion| {
        let row = motion.run(plan)?;
        step(progress, 1)?;
        Ok(row)
    })
}
