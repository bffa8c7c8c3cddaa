//! Periodic orbits by shooting on the section at drive phase 0, with their monodromy multipliers.

use shared::contacts::Period;
use shared::params::RigParams;
use shared::rig::Rig;

use crate::dual::Dual;
use crate::reference::{Contact, Reference};

/// A fixed point of the section's return map: an orbit that repeats after one drive period.
#[derive(Clone, Debug, PartialEq)]
pub struct Orbit {
    /// Drive frequency, Hz.
    pub frequency_hz: f64,
    /// Coordinate and rate on the section, in the rig's coordinate ([`shared::rig`]).
    pub section: [f64; 2],
    /// Monodromy matrix in units of A0 and A0 Ω, row by row.
    pub monodromy: [[f64; 2]; 2],
    /// Onsets in the period.
    pub impacts: u16,
    /// Largest contact force, N.
    pub force_n: f64,
    /// The contact with the largest force.
    pub contact: Contact,
    /// Energy the shaker puts in per period, J: what contact and damping take.
    pub energy_per_period_j: f64,
}

/// The two multipliers of an orbit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Multipliers {
    /// Two real ones, the smaller first.
    Real(f64, f64),
    /// A complex pair of this modulus.
    Complex(f64),
}

impl Multipliers {
    /// Largest modulus: below 1 the orbit is stable.
    pub fn modulus(self) -> f64 {
        match self {
            Self::Real(a, b) => a.abs().max(b.abs()),
            Self::Complex(modulus) => modulus,
        }
    }

    /// The smallest real multiplier, if real: −1 is a period doubling.
    pub fn smallest_real(self) -> Option<f64> {
        match self {
            Self::Real(a, _) => Some(a),
            Self::Complex(_) => None,
        }
    }
}

impl Orbit {
    /// Eigenvalues of the monodromy matrix.
    pub fn multipliers(&self) -> Multipliers {
        let [[a, b], [c, d]] = self.monodromy;
        let (mean, det) = (0.5 * (a + d), a * d - b * c);
        let discriminant = 0.25 * (a - d).powi(2) + b * c;
        if discriminant >= 0.0 {
            // The larger root directly, the other from the determinant: no cancellation.
            let big = mean + discriminant.sqrt().copysign(mean);
            let small = if big == 0.0 { 0.0 } else { det / big };
            Multipliers::Real(big.min(small), big.max(small))
        } else {
            Multipliers::Complex(det.sqrt())
        }
    }

    /// Whether this is a stable z = 1/1.
    pub fn is_stable_one_one(&self) -> bool {
        self.impacts == 1 && self.multipliers().modulus() < 1.0
    }
}

/// Newton steps before giving up.
const ITERATIONS: usize = 15;

/// A fixed point is found when the return map moves it by less than this share of A0 and A0 Ω.
const CLOSURE: f64 = 1e-10;

/// Finds the period-one orbit near `guess` (coordinate and rate on the section) by Newton's iteration on
/// the return map, whose derivative the dual-number integration gives exactly.
///
/// `None` if Newton's iteration does not settle, or leaves the hammer without contact.
pub fn shoot(params: &RigParams, frequency_hz: f64, guess: [f64; 2]) -> Option<Orbit> {
    let mut x = guess;
    for _ in 0..ITERATIONS {
        let mut contacts = Vec::<Contact>::new();
        let image = map(params, frequency_hz, x, &mut contacts)?;
        let Image {
            end,
            period,
            units,
            energy_j,
        } = image;
        let miss = [(end[0].re - x[0]) / units[0], (end[1].re - x[1]) / units[1]];
        // Derivative in section units.
        let m = |i: usize, j: usize| end[i].eps[j] * units[j] / units[i];
        let monodromy = [[m(0, 0), m(0, 1)], [m(1, 0), m(1, 1)]];
        if miss[0].abs().max(miss[1].abs()) < CLOSURE {
            let strongest = contacts
                .into_iter()
                .max_by(|a, b| a.peak_force_n.total_cmp(&b.peak_force_n))?;
            return Some(Orbit {
                frequency_hz,
                section: x,
                monodromy,
                impacts: period.onsets,
                force_n: period.peak_force,
                contact: strongest,
                energy_per_period_j: energy_j,
            });
        }
        // (I − M) step = miss.
        let [[a, b], [c, d]] = monodromy;
        let (a, b, c, d) = (1.0 - a, -b, -c, 1.0 - d);
        let det = a * d - b * c;
        let step = [
            (d * miss[0] - b * miss[1]) / det,
            (a * miss[1] - c * miss[0]) / det,
        ];
        let length = step[0].abs().max(step[1].abs());
        if !length.is_finite() {
            return None;
        }
        // A step of several amplitudes leads out of where the linearisation holds.
        let damping = (3.0 / length).min(1.0);
        x[0] += damping * step[0] * units[0];
        x[1] += damping * step[1] * units[1];
    }
    None
}

struct Image {
    end: [Dual<2>; 2],
    period: Period<f64>,
    units: [f64; 2],
    energy_j: f64,
}

/// One period of the return map with its derivative.
fn map(
    params: &RigParams,
    frequency_hz: f64,
    x: [f64; 2],
    contacts: &mut Vec<Contact>,
) -> Option<Image> {
    let (q, v) = (Dual::variable(x[0], 0), Dual::variable(x[1], 1));
    let mut hammer = Reference::<Dual<2>>::new(params, frequency_hz, q, v).ok()?;
    let scale = hammer.rig().coordinate_scale();
    let units = [scale, scale * std::f64::consts::TAU * frequency_hz];
    if !plausible(hammer.rig(), x, units) {
        return None;
    }
    let period = hammer.run_period(contacts);
    let (q, v) = hammer.state();
    Some(Image {
        end: [q, v],
        period,
        units,
        energy_j: hammer.totals().inertial_work,
    })
}

/// Whether a section point can belong to an orbit: not deep inside the surface, nor far out. Newton's
/// iteration may propose others, and following them would be long and senseless.
fn plausible(rig: &Rig<f64>, x: [f64; 2], units: [f64; 2]) -> bool {
    const FAR: f64 = 60.0;
    const DEEP: f64 = 0.2;
    let penetration = rig.kinematics(x[0], x[1]).delta;
    // A comparison with a number that is none is false.
    (x[0] / units[0]).abs() < FAR
        && (x[1] / units[1]).abs() < FAR
        && penetration < DEEP * rig.amplitude()
}
