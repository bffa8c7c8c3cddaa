//! A fit by the whole force.

use super::contacts::{Impact, MeasuredImpacts};
use super::least_squares::Solved;
use super::profile::{self, Profile};
use super::shape::{self, ForceShape};
use super::unknowns::Unknowns;
use super::whole::Whole;
use super::{IdentifiedFit, ImpactRow, Misfit, SensorFound};
use shared::model::contact::{Law, LawKind};

/// A law that misses the whole force by more than this share of it, noise apart, is refused.
pub const REFUSED_SHARE: f64 = 0.02;

/// What χ² is divided by where the filter is seen: the 95 % point of two degrees of freedom (parameter and filter) over
/// that of one, 5.991/3.841. With that of one the intervals held the truth in 17 of 20 records.
const SEEN_FILTER: f64 = 1.560;

/// [`SEEN_FILTER`] where the filter is too fast to be seen, or digital. Filter and onsets then have several leasts
/// between two samples, and χ² is no parabola: the 95 % point of three (parameter, filter, onset), 7.815/3.841.
const UNSEEN_FILTER: f64 = 2.035;

/// Rounds of least squares for a point of a profile: it begins beside one.
pub const PROFILE_ROUNDS: usize = 15;

/// The law as `whole` has it, with intervals.
pub fn fit(
    measured: &MeasuredImpacts,
    unknowns: &Unknowns,
    whole: &Whole,
) -> Option<IdentifiedFit> {
    let shape = &whole.shape;
    let mut best = whole.best.clone();
    let per_cost = match (whole.intervals, shape.shows_filter(&best.x)) {
        (false, _) => f64::INFINITY,
        (_, true) if !shape.jumps(&best.x) => SEEN_FILTER,
        _ => UNSEEN_FILTER,
    };
    let least = |x: &[f64], held: &[usize]| {
        let solved = shape.solve(x, held, PROFILE_ROUNDS);
        solved.unwrap_or_else(|| Solved::nowhere(x))
    };
    let (profiles, sought) = profile::all(&least, unknowns, &mut best, per_cost);
    let (found, _) = unknowns.read(&best.x[..unknowns.list().len()])?;
    fitted(measured, whole, &best.x, found, (profiles, sought))
}

/// The fit with the `profiles` and the law `found`, the sensor as the whole force's search has it at `x`, and what that
/// search says of the record. `sought` simulations made the profiles.
pub fn fitted(
    measured: &MeasuredImpacts,
    whole: &Whole,
    x: &[f64],
    found: Law<f64>,
    (profiles, sought): (Vec<Profile>, u64),
) -> Option<IdentifiedFit> {
    let shape = &whole.shape;
    Some(IdentifiedFit {
        law: LawKind::SpringDashpot,
        misfit: Misfit::Force,
        refused: whole.beyond_noise > REFUSED_SHARE,
        intervals: whole.intervals,
        times_noise: whole.times_noise,
        misses_share: whole.beyond_noise,
        rms_n: whole.rms_n,
        noise_n: shape::unit_n(measured),
        parameters: profiles.iter().map(|p| p.estimate.clone()).collect(),
        degrees_of_freedom: shape.data().saturating_sub(x.len()),
        widened: whole.widened,
        starts: whole.starts,
        starts_agreeing: whole.agreeing,
        simulations: whole.evaluations + sought,
        sensor: SensorFound::new(&shape.sensor(x), measured),
        impacts: impact_rows(measured, shape, x)?,
        warnings: Vec::new(),
        ring: whole.ring,
        found,
        release_m: shape.release_m(x)?,
        shown: shape.shown(x, &shape.contacts(x)?),
        profiles,
    })
}

/// The impacts at a point of the whole force's search.
fn impact_rows(
    measured: &MeasuredImpacts,
    shape: &ForceShape,
    x: &[f64],
) -> Option<Vec<ImpactRow>> {
    let contacts = shape.contacts(x)?;
    let shown = shape.shown(x, &contacts);
    let row = |(i, impact): (usize, &Impact)| {
        let contact = contacts.contact(i);
        let forces = &measured.force_n[shape.windows[i].clone()];
        let pairs = forces.iter().zip(&shown[i]);
        let squares: f64 = pairs.map(|(f, s)| (f - s).powi(2)).sum();
        ImpactRow {
            impact: i + 1,
            measured_at_s: impact.at_s,
            model_at_s: contact.map_or(f64::NAN, |c| c.onset_s),
            measured_peak_n: impact.peak_n,
            model_peak_n: shown[i].iter().fold(0.0_f64, |m, f| m.max(*f)),
            model_contact_time_ms: contact.map_or(0.0, |c| c.duration_s * 1e3),
            measured_impulse_n_s: impact.impulse_n_s,
            model_impulse_n_s: contact.map_or(0.0, |c| c.impulse_n_s),
            residual_n: (squares / forces.len() as f64).sqrt(),
        }
    };
    Some(measured.impacts.iter().enumerate().map(row).collect())
}
