//! The smoothing method against the switch on one section (figure 3.4, after Wiercigroch): how the cloud changes with
//! the width over which contact fades in, and what each costs.

use serde::Serialize;
use shared::model::contacts::Period;
use shared::model::regime::Detector;
use shared::model::rig::Rig;

use super::cloud::apart;
use super::{Portrait, SectionPoint, SectionRequest, sections};
use crate::error::{Error, MotionError};
use crate::lyapunov::{self, Exponents};
use crate::parallel;
use crate::progress::{Progress, check, step};
use crate::reference::Reference;

/// One width of the smoothing.
#[derive(Clone, Debug)]
pub struct Smoothing {
    /// ε_α, m; ε_β is the force of the law at this penetration.
    pub epsilon_m: f64,
    /// Section at drive phase 0: displacement (mm) and velocity (m/s) relative to the cart.
    pub points: Vec<(f64, f64)>,
    /// Figures of the section by the smoothing method.
    pub summary: SectionSummary,
}

/// The figures of a section.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SectionSummary {
    /// "switch", "switch, another start" or "smoothed".
    pub model: &'static str,
    /// ε_α, m; none for the switch.
    pub epsilon_m: Option<f64>,
    /// ε_β, N; none for the switch.
    pub epsilon_n: Option<f64>,
    /// Periods after which the section repeats; none if not within 16.
    pub section_periods: Option<u8>,
    /// Steps of the integrator per drive period, those refused included.
    pub steps_per_period: f64,
    /// Mean distance points must be carried to give the switch's cloud, over A0 and A0 Ω.
    pub carried: f64,
    /// Share of boxes occupied by one cloud alone.
    pub boxes_not_shared: f64,
    /// Total variation of the shares of points per box.
    pub variation: f64,
    /// Largest Lyapunov exponent, nats per drive period.
    pub largest_exponent_per_period: Option<f64>,
    /// Standard error of the largest Lyapunov exponent, nats per drive period.
    pub exponent_error_per_period: Option<f64>,
}

/// The switch, the switch from another start (what two equal models differ by), and the smoothed ones.
#[derive(Clone, Debug)]
pub struct SectionComparison {
    /// The section by the switch.
    pub exact: Portrait,
    /// Figures of the section by the switch.
    pub summary: SectionSummary,
    /// The switch again, from another start: no distance below this one's means anything.
    pub again: SectionSummary,
    /// The sections by the smoothing method, by falling width.
    pub smoothed: Vec<Smoothing>,
}

/// Widths compared unless others are asked for, m. On the wires at 1 mm and 2.7 times the natural frequency the widest
/// sticks, the middle one is periodic, and the narrowest is chaotic as the switch is.
pub const WIDTHS_M: [f64; 3] = [1e-6, 3e-7, 1e-7];

/// Most drive periods that an exponent is computed over.
const EXPONENT_PERIODS: u32 = 2000;

impl SectionComparison {
    /// All figures, the switch first.
    pub fn rows(&self) -> Vec<SectionSummary> {
        let switch = [self.summary.clone(), self.again.clone()];
        let smoothed = self.smoothed.iter().map(|s| s.summary.clone());
        switch.into_iter().chain(smoothed).collect()
    }
}

/// Runs the request's section at drive phase 0 by the switch and by the smoothing method at each width (m).
///
/// # Errors
/// As [`super::portrait`] and [`Reference::smoothed`].
pub fn against(
    request: &SectionRequest,
    widths_m: &[f64],
    progress: &dyn Progress,
) -> Result<SectionComparison, Error> {
    let mut widths = widths_m.to_vec();
    widths.sort_by(|a, b| b.total_cmp(a));
    let request = SectionRequest {
        phases: vec![0.0],
        ..request.clone()
    };
    let rig = Rig::<f64>::new(&request.params)?;
    let omega = std::f64::consts::TAU * request.frequency_hz;
    let [q, v] = request.start.section(&rig, omega)?;
    let units = (rig.amplitude() * 1e3, rig.amplitude() * omega);
    // Another start on the same attractor: shifted so far that the two forget each other within the transient.
    let other = SectionRequest {
        start: crate::engine::Start::Section([q - 0.01 * rig.coordinate_scale(), v]),
        ..request.clone()
    };
    // The same steps as with the smoothing method, so that their numbers tell of the equations alone.
    let switch = |request| sections(request, Reference::in_steps, progress);
    let (exact, (again, smoothed)) = rayon::join(
        || switch(&request),
        || {
            let again = switch(&other);
            let run = |width: &f64| run(&request, *width, progress);
            (again, parallel::try_map(&widths, run))
        },
    );
    let (exact, again, smoothed) = (exact?, again?, smoothed?);
    check(progress)?;
    let exact_run = Ran::from(&exact);
    let compared = Compared {
        hz: request.frequency_hz,
        units,
        reference: cloud(&exact_run.points, units),
    };
    let span = lyapunov::LyapunovSpan {
        transient: request.transient,
        periods: request.points.clamp(lyapunov::BLOCKS, EXPONENT_PERIODS),
    };
    let (params, hz) = (&request.params, request.frequency_hz);
    let exponents = lyapunov::exponents(params, hz, [q, v], span);
    let summary = compared.summary("switch", &exact_run, exponents.ok());
    let again = compared.summary("switch, another start", &Ran::from(&again), None);
    let smoothed = parallel::try_map(&smoothed, |(epsilon_m, ran)| {
        check(progress)?;
        let exponents = lyapunov::of_smoothed(params, hz, *epsilon_m, [q, v], span);
        Ok(Smoothing {
            epsilon_m: *epsilon_m,
            summary: compared.summary("smoothed", ran, exponents.ok()),
            points: ran.points.clone(),
        })
    })?;
    Ok(SectionComparison {
        smoothed,
        summary,
        again,
        exact,
    })
}

/// What sections are compared with, and how.
struct Compared {
    /// Drive frequency, Hz.
    hz: f64,
    /// A0 in mm, and A0 Ω in m/s.
    units: (f64, f64),
    /// The switch's section in these units.
    reference: Vec<(f64, f64)>,
}

impl Compared {
    fn summary(
        &self,
        model: &'static str,
        ran: &Ran,
        exponents: Option<Exponents>,
    ) -> SectionSummary {
        let apart = apart(&self.reference, &cloud(&ran.points, self.units));
        SectionSummary {
            model,
            epsilon_m: ran.epsilon.map(|e| e.0),
            epsilon_n: ran.epsilon.map(|e| e.1),
            section_periods: ran.section_periods,
            steps_per_period: ran.steps_per_period,
            carried: apart.carried,
            boxes_not_shared: apart.boxes_not_shared,
            variation: apart.variation,
            largest_exponent_per_period: exponents.map(|e| e.largest_per_period),
            exponent_error_per_period: exponents.map(|e| e.standard_error_per_s / self.hz),
        }
    }
}

/// Displacement (mm) and velocity (m/s) of `points`, divided by `units`.
fn cloud(points: &[(f64, f64)], units: (f64, f64)) -> Vec<(f64, f64)> {
    points
        .iter()
        .map(|p| (p.0 / units.0, p.1 / units.1))
        .collect()
}

/// A section, and how it was run.
struct Ran {
    /// Widths of the smoothing, m and N.
    epsilon: Option<(f64, f64)>,
    /// Displacement (mm) and velocity (m/s) of its points.
    points: Vec<(f64, f64)>,
    section_periods: Option<u8>,
    steps_per_period: f64,
}

impl From<&Portrait> for Ran {
    fn from(portrait: &Portrait) -> Self {
        let section = portrait.sections.first().into_iter().flatten();
        let point = |p: &SectionPoint| (p.relative_displacement_mm, p.relative_velocity_m_per_s);
        Self {
            epsilon: None,
            points: section.map(point).collect(),
            section_periods: portrait.regime.periods(),
            steps_per_period: portrait.steps_per_period,
        }
    }
}

/// The section of the model smoothed over `width_m`, after that width.
fn run(
    request: &SectionRequest,
    width_m: f64,
    progress: &dyn Progress,
) -> Result<(f64, Ran), Error> {
    let params = &request.params;
    let rig = Rig::<f64>::new(params)?;
    let omega = std::f64::consts::TAU * request.frequency_hz;
    let [q, v] = request.start.section(&rig, omega)?;
    let mut hammer = Reference::<f64>::smoothed(params, request.frequency_hz, width_m, (q, v))?;
    for _ in 0..request.transient {
        check(progress)?;
        hammer.run_period(&mut ());
    }
    let before = hammer.steps();
    let scale = rig.coordinate_scale();
    let mut detector = Detector::new(scale, scale * omega);
    let mut points = Vec::with_capacity(request.points as usize);
    for _ in 0..request.points {
        let (q, v) = hammer.state();
        if !(q.is_finite() && v.is_finite()) {
            return Err(MotionError::LostSmoothed { width_m }.into());
        }
        // A smoothed contact has no beginning to count: only the section is used.
        let touched = Period {
            touched: true,
            ..Period::default()
        };
        detector.push(q, v, &touched);
        points.push((
            rig.relative_displacement(q) * 1e3,
            rig.kinematics(q, v).rate,
        ));
        hammer.run_period(&mut ());
        step(progress, 1)?;
    }
    let ran = Ran {
        epsilon: Some((width_m, hammer.epsilon_n())),
        points,
        section_periods: detector.regime().periods(),
        steps_per_period: (hammer.steps() - before) as f64 / f64::from(request.points),
    };
    Ok((width_m, ran))
}
