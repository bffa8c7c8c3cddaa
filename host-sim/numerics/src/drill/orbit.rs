//! Periodic orbits on ground that gives way, and their multipliers.
//!
//! With [`Feed::Cart`] the section has the coordinates q, q̇ and e, all measured from the front of the ground; what has
//! been dug is in none of them. So the return map's derivative exists as with a surface that stays, and dual numbers give
//! it, switches included.

use shared::model::params::RigParams;
use shared::model::slider::{Slider, Touch};

use super::march::{Drill, Feed};
use crate::dual::Dual;
use crate::orbit::Multipliers;

/// A compression below this share of Pf/k at drive phase 0 is as good as none.
const RELAXED: f64 = 1e-9;

/// Newton steps before giving up.
const ITERATIONS: usize = 20;

/// A fixed point is found when the return map moves it by less than this share of A0 and A0 Ω.
const CLOSURE: f64 = 1e-10;

/// A period-one orbit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DrillOrbit {
    /// Coordinate and rate on the section.
    pub section: [f64; 2],
    /// Derivative of the return map, in units of A0 and A0 Ω.
    pub monodromy: [[f64; 2]; 2],
    /// Contacts in the period.
    pub impacts: u16,
    /// Progress in the period, m.
    pub progress_m: f64,
    /// Derivative of that progress by coordinate and rate on the section, m per unit of A0 and A0 Ω.
    pub progress_slope_m: [f64; 2],
}

impl DrillOrbit {
    /// The eigenvalues of the monodromy matrix.
    pub fn multipliers(&self) -> Multipliers {
        let [[a, b], [c, d]] = self.monodromy;
        let (half, det) = (0.5 * (a + d), a * d - b * c);
        let square = half * half - det;
        if square < 0.0 {
            return Multipliers::Complex(det.sqrt());
        }
        let root = square.sqrt();
        Multipliers::Real(half - root, half + root)
    }

    /// Whether every multiplier lies inside the unit circle.
    pub fn is_stable(&self) -> bool {
        self.multipliers().modulus() < 1.0
    }
}

/// The period-one orbit near the section point `guess`, by Newton's iteration. None if there is none near, or the ground
/// is still compressed at drive phase 0 (the section would have a third coordinate).
pub fn shoot(
    params: &RigParams,
    ground: &Slider<f64>,
    frequency_hz: f64,
    guess: [f64; 2],
) -> Option<DrillOrbit> {
    let mut x = guess;
    for _ in 0..ITERATIONS {
        let mut drill = Drill::<Dual<2>>::hammer(params, ground, Feed::Cart, frequency_hz).ok()?;
        let (q_unit, v_unit) = drill.units();
        let units = [q_unit, v_unit];
        let mut start = [Dual::constant(0.0); 3];
        for i in 0..2 {
            start[i] = Dual::variable(x[i], i);
            start[i].eps[i] = units[i];
        }
        drill.place(start);
        let (period, dug) = drill.run_period(&mut Vec::new());
        let end = drill.section();
        let relaxed = end[2].re.abs() < RELAXED * ground.threshold / ground.stiffness;
        if !(end[0].re.is_finite() && relaxed && drill.touch() == Touch::Apart) {
            return None;
        }
        let miss = [0, 1].map(|i| (end[i].re - x[i]) / units[i]);
        let monodromy = [0, 1].map(|i| [0, 1].map(|j: usize| end[i].eps[j] / units[i]));
        if miss[0].abs().max(miss[1].abs()) < CLOSURE {
            return Some(DrillOrbit {
                section: x,
                monodromy,
                impacts: period.onsets,
                progress_m: dug.re,
                progress_slope_m: dug.eps,
            });
        }
        // (I − M) step = miss.
        let [[a, b], [c, d]] = monodromy;
        let (a, d) = (1.0 - a, 1.0 - d);
        let det = a * d - b * c;
        let step = [
            (d * miss[0] + b * miss[1]) / det,
            (c * miss[0] + a * miss[1]) / det,
        ];
        let length = step[0].abs().max(step[1].abs());
        if !length.is_finite() {
            return None;
        }
        let damping = (1.0 / length).min(1.0);
        for i in 0..2 {
            x[i] += damping * step[i] * units[i];
        }
    }
    None
}
