//! Orbits of one drive period, by Newton's iteration on the return map.

use super::LinearMotion;
use super::run::{MOST_ONSETS, PeriodEvents};
use crate::modes::dense::Square;

/// Newton steps before giving up.
const ITERATIONS: usize = 20;
/// A fixed point is found when the return map moves it by less than this share of A0 and A0 Ω.
const CLOSURE: f64 = 1e-9;

/// A 1/1 orbit, or what else repeats after one period.
#[derive(Clone, Debug, PartialEq)]
pub struct ModalOrbit {
    /// Drive frequency, Hz.
    pub frequency_hz: f64,
    /// Onsets in the period.
    pub impacts: u32,
    /// Largest contact force, N.
    pub force_n: f64,
    /// Approach speed of the contact with it, m/s.
    pub approach_m_per_s: f64,
    /// Largest modulus of a multiplier.
    pub multiplier: f64,
    /// Where it is at drive phase 0, in A0 and A0 Ω.
    pub(super) section: Vec<f64>,
}

impl ModalOrbit {
    /// Whether this is a stable 1/1.
    pub fn is_stable_one_one(&self) -> bool {
        self.impacts == 1 && self.multiplier < 1.0
    }
}
impl LinearMotion {
    /// The section point after one period from `section`, and the derivative of the return map there.
    pub(super) fn image(&self, section: &[f64]) -> Option<(Vec<f64>, Square, PeriodEvents)> {
        let mut seen = PeriodEvents::default();
        let end = self.run(section, MOST_ONSETS, Some(&mut seen))?;
        let mut product = Square::one(section.len() + 3);
        for (i, (touching, time)) in seen.pieces.iter().enumerate() {
            product = self.phase(*touching).over(*time).times(&product);
            if let Some(saltation) = seen.saltations.get(i) {
                product = saltation.times(&product);
            }
        }
        Some((end, product.block(section.len()), seen))
    }
    /// The orbit of one drive period near `guess`, by Newton's iteration on the return map. `None` if it does not settle,
    /// or leaves the hammer without contact.
    pub fn shoot(&self, guess: &[f64]) -> Option<ModalOrbit> {
        if guess.len() != self.section_size() {
            return None;
        }
        let mut x = guess.to_vec();
        for _ in 0..ITERATIONS {
            let (end, monodromy, seen) = self.image(&x)?;
            let miss: Vec<f64> = end.iter().zip(&x).map(|(e, x)| e - x).collect();
            let off = miss.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
            if off < CLOSURE {
                return (seen.force > 0.0).then(|| ModalOrbit {
                    frequency_hz: self.frequency_hz,
                    impacts: seen.onsets,
                    force_n: seen.force * self.units.0,
                    approach_m_per_s: seen.approach * self.units.1,
                    multiplier: monodromy.spectral_radius(),
                    section: x,
                });
            }
            let step = monodromy.solve_fixed(&miss)?;
            let length = step.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
            if !length.is_finite() {
                return None;
            }
            let damping = (3.0 / length).min(1.0);
            x.iter_mut().zip(step).for_each(|(x, s)| *x += damping * s);
        }
        None
    }

    /// The orbit that this motion settles on or near, sought first next to `near`, then after some periods from there, then
    /// from rest.
    pub fn orbit(&self, near: Option<&ModalOrbit>) -> Option<ModalOrbit> {
        const SETTLE: u32 = 60;
        const FROM_REST: u32 = 250;
        let stable = |found: Option<ModalOrbit>| found.filter(ModalOrbit::is_stable_one_one);
        let direct = near.and_then(|orbit| stable(self.shoot(&orbit.section)));
        let settled = || {
            let at = self.after(&near?.section, SETTLE)?;
            stable(self.shoot(&at))
        };
        let from_rest = || stable(self.shoot(&self.from_rest(FROM_REST)?));
        direct.or_else(settled).or_else(from_rest)
    }
}
