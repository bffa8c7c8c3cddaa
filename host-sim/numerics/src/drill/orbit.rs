//! Periodic orbits on ground that gives way, and their multipliers.
//!
//! With [`Feed::Cart`] the section has the coordinates q, q̇ and e, all measured from the front of the ground, and the
//! deviation of a cart that recoils and its rate; what has been dug is in none of them. So the return map's derivative
//! exists as with a surface that stays, and dual numbers give it, switches included.
//!
//! A bit between hammer and ground has a depth and a rate more. On the section it must have come to rest on the ground: what
//! is left of its motion has then died before the next blow, so its two multipliers are 0 and are left out.

use shared::model::params::RigParams;
use shared::model::slider::Touch;

use super::blow::Feed;
use super::march::Drill;
use super::run::DrillSetting;
use crate::dual::Dual;
use crate::orbit::{Monodromy, Multipliers, Section};

/// A compression below this share of Pf/k at drive phase 0 is as good as none.
const RELAXED: f64 = 1e-9;

/// A bit rests where the ground presses back with its feed force, to this share of Pf.
const RESTS: f64 = 1e-2;

/// Newton steps before giving up.
const ITERATIONS: usize = 20;

/// A fixed point is found when the return map moves it by less than this share of A0 and A0 Ω.
const CLOSURE: f64 = 1e-10;

/// An orbit that repeats after one drive period, on ground that gives way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DrillOrbit {
    /// Drive frequency, Hz.
    pub frequency_hz: f64,
    /// Coordinate and rate on the section, and the cart's deviation and its rate.
    pub section: Section,
    /// Derivative of the return map, in units of A0 and A0 Ω.
    pub monodromy: Monodromy,
    /// Contacts in the period.
    pub impacts: u16,
    /// Largest contact force, N.
    pub force_n: f64,
    /// Energy that the contacts take from the hammer in the period, J.
    pub contact_j: f64,
    /// Progress in the period, m.
    pub progress_m: f64,
    /// Derivative of that progress along the section, m per unit of A0 and A0 Ω; the last two are 0 with a prescribed cart.
    pub progress_slope_m: [f64; 4],
}

impl DrillOrbit {
    /// The two leading eigenvalues of the monodromy matrix.
    pub fn multipliers(&self) -> Multipliers {
        self.monodromy.multipliers()
    }

    /// Whether every multiplier lies inside the unit circle.
    pub fn is_stable(&self) -> bool {
        self.multipliers().modulus() < 1.0
    }

    /// Whether it is a stable 1/1.
    pub fn is_stable_one_one(&self) -> bool {
        self.impacts == 1 && self.is_stable()
    }

    /// Rate of penetration, m/s.
    pub fn rate_m_per_s(&self) -> f64 {
        self.progress_m * self.frequency_hz
    }
}

/// The period-one orbit near the section point `guess`, by Newton's iteration. None if there is none near, or the ground
/// is still compressed at drive phase 0, or a bit does not rest there (the section would have a coordinate more).
pub fn shoot(
    params: &RigParams,
    setting: &DrillSetting,
    frequency_hz: f64,
    guess: Section,
) -> Option<DrillOrbit> {
    if params.cart.recoils() {
        along::<4>(params, setting, frequency_hz, guess)
    } else {
        along::<2>(params, setting, frequency_hz, guess)
    }
}

/// [`shoot`] with derivatives along the first `N` directions of the section.
fn along<const N: usize>(
    params: &RigParams,
    setting: &DrillSetting,
    frequency_hz: f64,
    guess: Section,
) -> Option<DrillOrbit> {
    let feed = Feed::Cart;
    let setting = DrillSetting { feed, ..*setting };
    let mut x = guess;
    let mut bit_at = None;
    for _ in 0..ITERATIONS {
        let mut drill = Drill::<Dual<N>>::through(params, &setting, frequency_hz).ok()?;
        let units = drill.all_units();
        let start = [0, 1, 2, 3].map(|i| {
            let mut at = Dual::<N>::constant(x[i]);
            if i < N {
                at.eps[i] = units[i];
            }
            at
        });
        let none = Dual::constant(0.0);
        drill.place_off([start[0], start[1], none], [start[2], start[3]]);
        if let Some(at) = bit_at {
            drill.place_bit(at);
        }
        let (period, dug) = drill.run_period(&mut Vec::new());
        let [q, v, _] = drill.section();
        let [off, off_rate] = drill.cart();
        let end = [q, v, off, off_rate];
        if !(q.re.is_finite() && rests(&drill, &setting)) {
            return None;
        }
        // Where it is now is where it begins on the orbit.
        bit_at = setting
            .bit
            .map(|_| drill.bit().map(|x| Dual::constant(x.re)));
        let miss = [0, 1, 2, 3].map(|i| (end[i].re - x[i]) / units[i]);
        let mut derivative = [[0.0; 4]; 4];
        let mut progress_slope_m = [0.0; 4];
        for j in 0..N {
            for i in 0..N {
                derivative[i][j] = end[i].eps[j] / units[i];
            }
            progress_slope_m[j] = dug.eps[j];
        }
        let monodromy = Monodromy::new(N, derivative);
        if crate::orbit::largest(miss) < CLOSURE {
            return Some(DrillOrbit {
                frequency_hz,
                section: x,
                monodromy,
                impacts: period.onsets,
                force_n: period.peak_force,
                contact_j: drill.energies().contact,
                progress_m: dug.re,
                progress_slope_m,
            });
        }
        let step = monodromy.newton_step(miss);
        let length = crate::orbit::largest(step);
        if !length.is_finite() {
            return None;
        }
        let damping = (1.0 / length).min(1.0);
        for i in 0..4 {
            x[i] += damping * step[i] * units[i];
        }
    }
    None
}

/// Whether the ground is relaxed and untouched, or the bit stands still on it and nothing strikes it.
fn rests<const N: usize>(drill: &Drill<Dual<N>>, setting: &DrillSetting) -> bool {
    let DrillSetting { ground, bit, .. } = setting;
    let [_, _, e] = drill.section();
    let Some(bit) = bit else {
        let relaxed = e.re.abs() < RELAXED * ground.threshold / ground.stiffness;
        return relaxed && drill.touch() == Touch::Apart;
    };
    let [_, w] = drill.bit();
    let off = ground.held_force(e.re, w.re) - bit.feed_force;
    !drill.hammer_touches() && drill.touch() == Touch::Held && off.abs() < RESTS * ground.threshold
}
