//! What to measure first: how the best frequency and its force move with each parameter.

use serde::Serialize;
use shared::model::cart::{CartDrive, LoopParams};
use shared::model::contact::Law;
use shared::model::params::{RigParams, SupportParams};

use crate::branch::{Case, beside};
use crate::interpolation::around;
use crate::orbit::{Orbit, stable_of_many};
use crate::parallel;
use crate::root::{halved, maximum, vertex};
use crate::uncertainty::Uncertainty;

/// Change of the nominal optimum with one parameter.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Sensitivity {
    /// Name of the parameter, as rig files have it, or in words; in brackets what is kept as it is.
    pub parameter: &'static str,
    /// The change it is per: "1 %" of the parameter, or "0.01 mm" of gap.
    pub per: &'static str,
    /// Change of the best frequency, %.
    pub frequency_percent: f64,
    /// Change of the force there, %.
    pub force_percent: f64,
    /// How well the parameter is known, % either way; none for the gap, and where no uncertainty is stated.
    pub uncertainty_percent: Option<f64>,
    /// How well the gap is known, mm either way; none for other parameters.
    pub uncertainty_mm: Option<f64>,
    /// The contact stiffness is up to this many times as large, or as small; none where it is known in %.
    pub uncertainty_factor: Option<f64>,
    /// How far the best frequency is uncertain because of it, % either way.
    pub frequency_over_uncertainty_percent: Option<f64>,
    /// How far the force there is uncertain because of it, % either way; where a parameter is known to a factor, % upwards.
    pub force_over_uncertainty_percent: Option<f64>,
    /// Smallest and largest change of the force, %, over all that the parameter may be: computed, not by the slope. None
    /// where this was not done ([`compute_ranges`]), or where the stable 1/1 does not reach the ends.
    pub force_range_percent: Option<[f64; 2]>,
}

impl Sensitivity {
    /// The row of a parameter that nothing is known of yet but its slope.
    fn new(parameter: &'static str, per: &'static str, frequency: f64, force: f64) -> Self {
        Self {
            parameter,
            per,
            frequency_percent: frequency,
            force_percent: force,
            ..Self::default()
        }
    }

    /// How far the force is open, %: by what is known best of it.
    pub fn force_open_percent(&self) -> f64 {
        let range = self.force_range_percent;
        let farther = range.map(|[low, high]| low.abs().max(high.abs()));
        farther
            .or(self.force_over_uncertainty_percent)
            .unwrap_or(0.0)
    }

    /// How many steps (of 1 % or 0.01 mm) it is to both ends of what the parameter may be.
    fn ends(&self) -> Option<[f64; 2]> {
        let about = |steps: f64| [-steps, steps];
        let factor = self.uncertainty_factor;
        let by_factor = factor.map(|x| [100.0 * (1.0 / x - 1.0), 100.0 * (x - 1.0)]);
        by_factor
            .or(self.uncertainty_mm.map(|mm| about(mm / GAP_STEP_MM)))
            .or(self.uncertainty_percent.map(about))
            .filter(|[_, high]| *high > 0.0)
    }

    /// This row for a parameter known as well as `uncertainty` says. Where the damping ratio is known, the damping of
    /// the spring-dashpot goes with its stiffness.
    #[must_use]
    pub fn known_to(mut self, uncertainty: &Uncertainty, contact: &Law<f64>) -> Self {
        let together = matches!(contact, Law::SpringDashpot { .. })
            && uncertainty.contact_damping_ratio_percent.is_some();
        let damping = uncertainty.contact_damping_ratio_percent;
        let damping = damping.unwrap_or(uncertainty.contact_damping_percent);
        let percent = match self.parameter {
            NATURAL_FREQUENCY => uncertainty.natural_frequency_percent,
            AMPLITUDE => uncertainty.amplitude_percent,
            MASS => uncertainty.mass_percent,
            CONTACT_STIFFNESS if together => return self,
            STIFFNESS_AND_DAMPING if !together => return self,
            CONTACT_STIFFNESS | STIFFNESS_AND_DAMPING => {
                if let Some(factor) = uncertainty.contact_stiffness_factor {
                    self.uncertainty_factor = Some(factor);
                    return self.over_factor(factor);
                }
                uncertainty.contact_stiffness_percent
            }
            CONTACT_DAMPING | OTHER_CONTACT_DAMPING => damping,
            CART_MASS => uncertainty.cart_mass_percent,
            SHAKER_LOOP => uncertainty.shaker_loop_percent,
            SHAKER_DAMPING => uncertainty.shaker_damping_percent,
            GAP => {
                self.uncertainty_mm = Some(uncertainty.gap_mm);
                return self.over(uncertainty.gap_mm / GAP_STEP_MM);
            }
            _ => return self,
        };
        self.uncertainty_percent = Some(percent);
        self.over(percent)
    }

    /// This row with what an uncertainty of `factor` does: a power of it, whose exponent is the slope.
    fn over_factor(mut self, factor: f64) -> Self {
        let upwards = |percent: f64| 100.0 * (factor.powf(percent.abs()) - 1.0);
        self.frequency_over_uncertainty_percent = Some(upwards(self.frequency_percent));
        self.force_over_uncertainty_percent = Some(upwards(self.force_percent));
        self
    }

    /// This row with what an uncertainty of so many `steps` (of 1 % or 0.01 mm) does, by the slope.
    fn over(mut self, steps: f64) -> Self {
        self.frequency_over_uncertainty_percent = Some(self.frequency_percent.abs() * steps);
        self.force_over_uncertainty_percent = Some(self.force_percent.abs() * steps);
        self
    }
}

const NATURAL_FREQUENCY: &str = "natural_frequency_hz";
const AMPLITUDE: &str = "amplitude_mm";
const MASS: &str = "mass_kg (same natural frequency)";
const CONTACT_STIFFNESS: &str = "contact_stiffness_n_per_m";
const GAP: &str = "gap_mm";
const CART_MASS: &str = "cart_mass_kg (same loop frequency)";
const SHAKER_LOOP: &str = "shaker_loop_hz";
const SHAKER_DAMPING: &str = "shaker_damping_ratio";
const STIFFNESS_AND_DAMPING: &str = "contact stiffness (same restitution)";
const CONTACT_DAMPING: &str = "contact_damping_n_s_per_m";
const OTHER_CONTACT_DAMPING: &str = "contact damping";
const RESTITUTION: &str = "contact restitution (same stiffness)";

/// The step of everything else.
const PERCENT: &str = "1 %";

/// The step of the gap in the table, mm.
const GAP_STEP_MM: f64 = 0.01;

type Change = Box<dyn Fn(&RigParams, f64) -> Option<RigParams> + Sync>;

/// A parameter, the step it is changed by, and how.
type NamedChange = (&'static str, &'static str, Change);

/// The table for `params`, about the nominal optimum `best`. A parameter whose change leads off the stable
/// 1/1 is left out.
pub fn table(params: &RigParams, best: &Orbit) -> Vec<Sensitivity> {
    let rows = changes(params);
    let rows = parallel::map(&rows, |(parameter, per, change)| {
        let up = optimum(&change(params, 1.0)?, best)?;
        let down = optimum(&change(params, -1.0)?, best)?;
        Some(Sensitivity::new(
            parameter,
            per,
            50.0 * (up.frequency_hz - down.frequency_hz) / best.frequency_hz,
            50.0 * (up.force_n - down.force_n) / best.force_n,
        ))
    });
    let mut rows: Vec<_> = rows.into_iter().flatten().collect();
    rows.sort_by(|a, b| b.force_percent.abs().total_cmp(&a.force_percent.abs()));
    rows
}

/// Computes the force over all that the `count` parameters may be that leave it most open to first order.
pub fn compute_ranges(rows: &mut [Sensitivity], count: usize, params: &RigParams, best: &Orbit) {
    let mut worst: Vec<_> = rows.iter_mut().collect();
    worst.sort_by(|a, b| b.force_open_percent().total_cmp(&a.force_open_percent()));
    worst.truncate(count);
    let ranges = parallel::map(&worst, |row| range(row, params, best));
    for (row, range) in worst.into_iter().zip(ranges) {
        row.force_range_percent = range;
    }
}

/// Smallest and largest change of the force, %, over all that the parameter of `row` may be.
fn range(row: &Sensitivity, params: &RigParams, best: &Orbit) -> Option<[f64; 2]> {
    let changes = changes(params);
    let (_, per, change) = changes.iter().find(|change| change.0 == row.parameter)?;
    let [low, high] = row.ends()?;
    let forces = |steps| forces_to(params, (*per == PERCENT, steps), change, best);
    let (below, above) = rayon::join(|| forces(low), || forces(high));
    let all = below?.into_iter().chain(above?);
    let least_and_most = all.fold([best.force_n; 2], |[least, most], force| {
        [least.min(force), most.max(force)]
    });
    Some(least_and_most.map(|force| 100.0 * (force / best.force_n - 1.0)))
}

/// Forces of the best 1/1 on the way from `params` to it changed by so many steps, each followed from the one before.
fn forces_to(
    params: &RigParams,
    (of_percent, steps): (bool, f64),
    change: &Change,
    best: &Orbit,
) -> Option<Vec<f64>> {
    /// As far as the optimum is followed at once: 4 % of a parameter, 0.02 mm of gap.
    const AT_ONCE: f64 = 0.04;
    change(params, steps)?;
    let whole = 1.0 + 0.01 * steps;
    let length = if of_percent { whole.ln() } else { 0.02 * steps };
    let stages = (length.abs() / AT_ONCE).ceil().max(1.0);
    let mut orbit = best.clone();
    let force = |stage: u32| {
        let share = f64::from(stage) / stages;
        let steps = if of_percent {
            100.0 * (whole.powf(share) - 1.0)
        } else {
            share * steps
        };
        orbit = optimum(&change(params, steps)?, &orbit)?;
        Some(orbit.force_n)
    };
    (1..=stages as u32).map(force).collect()
}

/// Each parameter as a function of (rig, steps of 1 % or 0.01 mm).
fn changes(params: &RigParams) -> Vec<NamedChange> {
    fn percent(name: &'static str, change: fn(&mut RigParams, f64)) -> NamedChange {
        let changed: Change = Box::new(move |params, steps| {
            let mut rig = *params;
            change(&mut rig, 1.0 + 0.01 * steps);
            rig.check().is_ok().then_some(rig)
        });
        (name, PERCENT, changed)
    }
    fn of_the_loop(rig: &mut RigParams, change: impl FnOnce(&mut LoopParams)) {
        if let CartDrive::Loop(held) = &mut rig.cart {
            change(held);
        }
    }
    let by_gap: Change = Box::new(|params, steps| {
        let gap_m = params.gap_m + 1e-3 * GAP_STEP_MM * steps;
        let rig = RigParams { gap_m, ..*params };
        rig.check().is_ok().then_some(rig)
    });
    let mut rows = vec![
        percent(NATURAL_FREQUENCY, |rig, by| {
            *rig = rig.with_natural_frequency_scaled(by);
        }),
        percent(AMPLITUDE, |rig, by| rig.amplitude_m *= by),
        percent(MASS, |rig, by| rig.mass_kg *= by),
        percent(CONTACT_STIFFNESS, |rig, by| {
            rig.contact = rig.contact.scaled(by, 1.0);
        }),
        (GAP, "0.01 mm", by_gap),
    ];
    if params.cart.recoils() {
        rows.extend([
            percent(CART_MASS, |rig, by| rig.cart_mass_kg *= by),
            percent(SHAKER_LOOP, |rig, by| {
                of_the_loop(rig, |held| held.frequency_hz *= by);
            }),
            percent(SHAKER_DAMPING, |rig, by| {
                of_the_loop(rig, |held| held.damping_ratio *= by);
            }),
            percent("shaker_feed_forward", |rig, by| {
                of_the_loop(rig, |held| held.feed_forward *= by);
            }),
        ]);
    }
    if let SupportParams::Beams { .. } = params.support {
        rows.push(percent("damping_ratio", |rig, by| {
            if let SupportParams::Beams { damping_ratio, .. } = &mut rig.support {
                *damping_ratio *= by;
            }
        }));
    }
    let damping: fn(&mut RigParams, f64) = |rig, by| rig.contact = rig.contact.scaled(1.0, by);
    match params.contact {
        Law::SpringDashpot { .. } => {
            let by_restitution: Change =
                Box::new(|params, steps| with_restitution(params, 1.0 + 0.01 * steps));
            rows.extend([
                percent(CONTACT_DAMPING, damping),
                percent(STIFFNESS_AND_DAMPING, |rig, by| {
                    rig.contact = rig.contact.scaled(by, by.sqrt());
                }),
                (RESTITUTION, PERCENT, by_restitution),
            ]);
        }
        law if law.kind().is_lossy() => rows.push(percent(OTHER_CONTACT_DAMPING, damping)),
        _ => {}
    }
    rows
}

/// Restitution of a free mass on a spring-dashpot of damping ratio ζ < 1:
/// exp(−2ζ/√(1−ζ²) · atan(√(1−ζ²)/ζ)), the contact ending where the force vanishes.
pub fn restitution(zeta: f64) -> f64 {
    let root = (1.0 - zeta * zeta).sqrt();
    (-2.0 * zeta / root * (root / zeta).atan()).exp()
}

/// Contact time of the same mass, s, with the contact's natural frequency `omega` in rad/s: (π − 2 asin ζ)/(ω √(1−ζ²)).
pub fn contact_time_s(zeta: f64, omega: f64) -> f64 {
    (std::f64::consts::PI - 2.0 * zeta.asin()) / (omega * (1.0 - zeta * zeta).sqrt())
}

/// The damping ratio of a contact with this restitution: [`restitution`] inverted by bisection. `None` unless it lies between
/// what no damping and critical damping give.
pub fn damping_ratio_of_restitution(wanted: f64) -> Option<f64> {
    let (a, b) = (1e-9, 1.0 - 1e-9);
    if !(restitution(b)..restitution(a)).contains(&wanted) {
        return None;
    }
    // Restitution falls with damping.
    Some(halved((a, b), 80, |zeta| restitution(zeta) <= wanted).0)
}

/// Damping ratio of the contact, ci/(2√(ki m)).
pub fn contact_damping_ratio(params: &RigParams) -> Option<f64> {
    match params.contact {
        Law::SpringDashpot { stiffness, damping } => {
            Some(damping / (2.0 * (stiffness * params.mass_kg).sqrt()))
        }
        _ => None,
    }
}

/// `params` with the contact's restitution scaled by `by`, through ci.
fn with_restitution(params: &RigParams, by: f64) -> Option<RigParams> {
    let zeta = contact_damping_ratio(params)?;
    if !(0.0..1.0).contains(&zeta) || zeta == 0.0 {
        return None;
    }
    let scaled = damping_ratio_of_restitution(by * restitution(zeta))?;
    let contact = params.contact.scaled(1.0, scaled / zeta);
    Some(RigParams { contact, ..*params })
}

/// The best 1/1 of a slightly different rig, near `best`.
fn optimum(rig: &RigParams, best: &Orbit) -> Option<Orbit> {
    /// How near the search comes to the largest force, as a share of the frequency. The force is flat there, so the parabola
    /// through the three best comes nearer.
    const NEAR: f64 = 1e-4;
    let hz = best.frequency_hz;
    let mut known = vec![stable_of_many(rig, hz, best.at())?];
    let within = (0.95 * hz, 1.05 * hz);
    let value = |hz| force_beside(rig, &mut known, hz).unwrap_or(f64::NEG_INFINITY);
    maximum(value, within, NEAR * hz, hz);
    let mut points: Vec<_> = known.iter().map(|o| (o.frequency_hz, o.force_n)).collect();
    points.sort_by(|a, b| b.1.total_cmp(&a.1));
    if let [first, second, third, ..] = points[..] {
        let turn = vertex([first, second, third]);
        if (turn - first.0).abs() < NEAR * hz {
            force_beside(rig, &mut known, turn);
        }
    }
    known
        .into_iter()
        .max_by(|a, b| a.force_n.total_cmp(&b.force_n))
}

/// The force of the stable 1/1 at `hz`, N, found beside orbits `known`, by rising frequency, of which it is one then.
fn force_beside(rig: &RigParams, known: &mut Vec<Orbit>, hz: f64) -> Option<f64> {
    let above = known.partition_point(|o| o.frequency_hz < hz);
    if let Some(known) = known.get(above).filter(|o| o.frequency_hz == hz) {
        return Some(known.force_n);
    }
    let near = around(known, hz, 2, |o| o.frequency_hz);
    let near: Vec<_> = near.iter().map(RigParams::place).collect();
    let found = stable_of_many(rig, hz, beside(&near, hz))?;
    let force_n = found.force_n;
    known.insert(above, found);
    Some(force_n)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::limits::PickLimits;
    use crate::pick::pick;
    use crate::row::NamedRig;
    use shared::model::params::WIRES;
    use shared::model::rig::Rig;

    /// The slope says -14 to +14 %.
    #[test]
    fn the_range_of_the_force_holds_that_of_the_rigs_in_it() {
        let picked = |rig: RigParams| {
            let rig = NamedRig::new("wires", rig);
            pick(&rig, None, PickLimits::default(), &()).unwrap()
        };
        let nominal = picked(WIRES);
        let hz = nominal.answer.operating_frequency_hz;
        let scale = Rig::<f64>::new(&WIRES).unwrap().coordinate_scale();
        let [q, v] = nominal.section;
        let section = [q * scale, v * scale * std::f64::consts::TAU * hz];
        let best = crate::orbit::shoot(&WIRES, hz, section).unwrap();
        let known = Uncertainty {
            contact_damping_percent: 40.0,
            ..Uncertainty::default()
        };
        let rows = nominal.answer.sensitivity.iter().cloned();
        let mut rows: Vec<_> = rows.map(|r| r.known_to(&known, &WIRES.contact)).collect();
        compute_ranges(&mut rows, 1, &WIRES, &best);
        let computed: Vec<_> = rows
            .iter()
            .filter_map(|r| Some((r.parameter, r.force_range_percent?)))
            .collect();
        let [(CONTACT_DAMPING, [least, most])] = computed[..] else {
            panic!("{computed:?}");
        };
        let change = |by: f64| {
            let contact = WIRES.contact.scaled(1.0, by);
            let there = picked(RigParams { contact, ..WIRES }).answer.force_n;
            100.0 * (there / nominal.answer.force_n - 1.0)
        };
        let [low, middle, high] = [0.6, 0.88, 1.4].map(change);
        assert!((most - low.max(high)).abs() < 1e-3, "{most} {low} {high}");
        // Between the ends the force is smaller than at both.
        assert!(
            middle < -1.0 && (least - middle).abs() < 0.5,
            "{least} {middle}"
        );
    }

    #[test]
    fn the_closed_form_gives_the_known_contact() {
        let zeta = contact_damping_ratio(&WIRES).unwrap();
        assert!((zeta - 0.469).abs() < 5e-4, "{zeta}");
        assert!((restitution(zeta) - 0.317).abs() < 5e-4);
        assert!(
            (damping_ratio_of_restitution(restitution(zeta)).unwrap() / zeta - 1.0).abs() < 1e-9
        );
        let omega = (5.5e6f64 / 0.298).sqrt();
        assert!((contact_time_s(zeta, omega) - 0.570_751e-3).abs() < 1e-9);
    }

    #[test]
    fn restitution_is_scaled_as_asked() {
        let before = restitution(contact_damping_ratio(&WIRES).unwrap());
        let rig = with_restitution(&WIRES, 1.01).unwrap();
        let after = restitution(contact_damping_ratio(&rig).unwrap());
        assert!((after / before - 1.01).abs() < 1e-12);
    }
}
