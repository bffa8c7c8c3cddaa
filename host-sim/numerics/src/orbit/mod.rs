//! Periodic orbits by shooting on the section at drive phase 0, with their monodromy multipliers.

mod watch;

use shared::model::params::RigParams;
use shared::model::rig::Rig;

use crate::dual::Dual;
use crate::reference::{Contact, Reference};
pub use watch::Watch;

/// A fixed point of the section's return map taken `periods` times: an orbit that repeats after as many drive periods.
#[derive(Clone, Debug, PartialEq)]
pub struct Orbit {
    /// Drive frequency, Hz.
    pub frequency_hz: f64,
    /// Drive periods after which it repeats.
    pub periods: u8,
    /// Coordinate and rate on the section, in the rig's coordinate ([`shared::model::rig`]).
    pub section: [f64; 2],
    /// Every point on the section, `section` first: one for each drive period.
    pub strobes: Vec<[f64; 2]>,
    /// Monodromy matrix over all periods in units of A0 and A0 Ω, row by row.
    pub monodromy: [[f64; 2]; 2],
    /// Onsets in all periods.
    pub impacts: u16,
    /// Largest contact force, N.
    pub force_n: f64,
    /// Largest contact force in each drive period, N, from the section point of the same index on.
    pub period_forces_n: Vec<f64>,
    /// The contact with the largest force.
    pub contact: Contact,
    /// What else was seen on the way round.
    pub seen: Watch,
    /// Energy the shaker puts in per drive period, J: what contact and damping take.
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

    /// The same as real and imaginary parts.
    pub fn eigenvalues(&self) -> [(f64, f64); 2] {
        let [[a, _], [_, d]] = self.monodromy;
        match self.multipliers() {
            Multipliers::Real(small, big) => [(small, 0.0), (big, 0.0)],
            Multipliers::Complex(modulus) => {
                let re = 0.5 * (a + d);
                let im = (modulus * modulus - re * re).max(0.0).sqrt();
                [(re, im), (re, -im)]
            }
        }
    }

    /// Whether this is a stable z = 1/1.
    pub fn is_stable_one_one(&self) -> bool {
        self.periods == 1 && self.impacts == 1 && self.is_stable()
    }

    /// Whether every multiplier lies inside the unit circle.
    pub fn is_stable(&self) -> bool {
        self.multipliers().modulus() < 1.0
    }

    /// det(I + M): passes 0 where a multiplier passes −1, a period doubling.
    pub fn doubling_test(&self) -> f64 {
        let [[a, b], [c, d]] = self.monodromy;
        1.0 + (a + d) + (a * d - b * c)
    }

    /// det(I − M): passes 0 where a multiplier passes +1, a fold.
    pub fn fold_test(&self) -> f64 {
        let [[a, b], [c, d]] = self.monodromy;
        1.0 - (a + d) + (a * d - b * c)
    }

    /// The smallest approach speed of its contacts, m/s: 0 where one of them grazes.
    pub fn slowest_approach_m_per_s(&self) -> f64 {
        let speeds = self.seen.contacts.iter();
        speeds
            .map(|c| c.approach_speed_m_per_s)
            .fold(f64::INFINITY, f64::min)
    }

    /// How far apart, in units of A0 and A0 Ω, the section points are that would be one if the orbit repeated after
    /// `periods`/`factor` periods already. 0 where `factor` does not divide the periods.
    pub fn asymmetry(&self, factor: u8, units: [f64; 2]) -> [f64; 2] {
        let (n, factor) = (usize::from(self.periods), usize::from(factor));
        if factor < 2 || !n.is_multiple_of(factor) {
            return [0.0; 2];
        }
        let (first, other) = (self.strobes[0], self.strobes[n / factor]);
        [0, 1].map(|i| (other[i] - first[i]) / units[i])
    }
}

/// Newton steps before giving up.
const ITERATIONS: usize = 15;

/// A fixed point is found when the return map moves it by less than this share of A0 and A0 Ω.
pub(crate) const CLOSURE: f64 = 1e-10;

/// Finds the period-one orbit near `guess` (coordinate and rate on the section) by Newton's iteration on
/// the return map, whose derivative the dual-number integration gives exactly.
///
/// `None` if Newton's iteration does not settle, or leaves the hammer without contact.
pub fn shoot(params: &RigParams, frequency_hz: f64, guess: [f64; 2]) -> Option<Orbit> {
    shoot_periods(params, frequency_hz, guess, 1)
}

/// The same for an orbit that repeats after `periods` drive periods. One that repeats sooner is found, too:
/// [`Orbit::asymmetry`] tells them apart.
pub fn shoot_periods(
    params: &RigParams,
    frequency_hz: f64,
    guess: [f64; 2],
    periods: u8,
) -> Option<Orbit> {
    let mut x = guess;
    for _ in 0..ITERATIONS {
        let image = Image::of(params, frequency_hz, x, periods)?;
        let miss = image.miss(x);
        if miss[0].abs().max(miss[1].abs()) < CLOSURE {
            return image.orbit(frequency_hz, x);
        }
        // (I − M) step = miss.
        let [[a, b], [c, d]] = image.monodromy();
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
        x[0] += damping * step[0] * image.units[0];
        x[1] += damping * step[1] * image.units[1];
    }
    None
}

/// The return map of some periods with its derivative, and what happened on the way.
pub(crate) struct Image {
    end: [Dual<2>; 2],
    /// A0 and A0 Ω in the rig's coordinate.
    pub(crate) units: [f64; 2],
    onsets: u16,
    period_forces_n: Vec<f64>,
    strobes: Vec<[f64; 2]>,
    seen: Watch,
    energy_j: f64,
}

impl Image {
    /// Of the section point `x` after `periods`. `None` for a point that belongs to no orbit, or whose motion cannot
    /// be followed.
    pub(crate) fn of(
        params: &RigParams,
        frequency_hz: f64,
        x: [f64; 2],
        periods: u8,
    ) -> Option<Self> {
        let (q, v) = (Dual::variable(x[0], 0), Dual::variable(x[1], 1));
        let mut hammer = Reference::<Dual<2>>::new(params, frequency_hz, q, v).ok()?;
        let scale = hammer.rig().coordinate_scale();
        let units = [scale, scale * std::f64::consts::TAU * frequency_hz];
        let mut seen = Watch::default();
        let (mut onsets, mut period_forces_n) = (0_u16, Vec::new());
        let mut strobes = vec![x];
        for _ in 0..periods {
            let (q, v) = hammer.state();
            if !plausible(hammer.rig(), [q.re, v.re], units) {
                return None;
            }
            let period = hammer.run_period(&mut seen);
            onsets = onsets.saturating_add(period.onsets);
            period_forces_n.push(period.peak_force);
            let (q, v) = hammer.state();
            strobes.push([q.re, v.re]);
        }
        strobes.pop();
        let (q, v) = hammer.state();
        let energy_j = hammer.totals().inertial_work;
        if in_contact(hammer.rig(), x) && !seen.contacts.is_empty() {
            // The first contact began before the start. Seen whole, it is the one under way at the end.
            seen.contacts.remove(0);
            let end_s = f64::from(periods) * hammer.period_s();
            let mut after = Vec::new();
            hammer.run_period(&mut after);
            seen.contacts
                .extend(after.into_iter().filter(|c: &Contact| c.onset_s < end_s));
        }
        Some(Self {
            end: [q, v],
            units,
            onsets,
            period_forces_n,
            strobes,
            seen,
            energy_j,
        })
    }

    /// How far the image is from `x`, in units of A0 and A0 Ω.
    pub(crate) fn miss(&self, x: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|i| (self.end[i].re - x[i]) / self.units[i])
    }

    /// The derivative in units of A0 and A0 Ω.
    pub(crate) fn monodromy(&self) -> [[f64; 2]; 2] {
        let m = |i: usize, j: usize| self.end[i].eps[j] * self.units[j] / self.units[i];
        [[m(0, 0), m(0, 1)], [m(1, 0), m(1, 1)]]
    }

    /// The orbit, if `x` is a fixed point. `None` without contact.
    pub(crate) fn orbit(self, frequency_hz: f64, x: [f64; 2]) -> Option<Orbit> {
        let monodromy = self.monodromy();
        let contacts = self.seen.contacts.iter().copied();
        let strongest = contacts.max_by(|a, b| a.peak_force_n.total_cmp(&b.peak_force_n))?;
        let periods = self.strobes.len() as u8;
        Some(Orbit {
            frequency_hz,
            periods,
            section: x,
            strobes: self.strobes,
            monodromy,
            impacts: self.onsets,
            force_n: self.period_forces_n.iter().copied().fold(0.0, f64::max),
            period_forces_n: self.period_forces_n,
            contact: strongest,
            seen: self.seen,
            energy_per_period_j: self.energy_j / f64::from(periods),
        })
    }
}

/// Where the section point `x` is after `periods`, without derivatives. `None` where the motion cannot be followed.
pub(crate) fn after_periods(
    params: &RigParams,
    frequency_hz: f64,
    x: [f64; 2],
    periods: u8,
) -> Option<[f64; 2]> {
    let mut hammer = Reference::<f64>::new(params, frequency_hz, x[0], x[1]).ok()?;
    for _ in 0..periods {
        hammer.run_period(&mut ());
    }
    let (q, v) = hammer.state();
    (q.is_finite() && v.is_finite()).then_some([q, v])
}

fn in_contact(rig: &Rig<f64>, x: [f64; 2]) -> bool {
    let at = rig.kinematics(x[0], x[1]);
    rig.indicator(&at, at.rate.max(0.0)) > 0.0
}

/// Whether a section point can belong to an orbit: not deep inside the surface, nor far out. Newton's
/// iteration may propose others, and following them would be long and senseless.
fn plausible(rig: &Rig<f64>, x: [f64; 2], units: [f64; 2]) -> bool {
    const FAR: f64 = 60.0;
    const DEEP: f64 = 0.2;
    let penetration = rig.kinematics(x[0], x[1]).delta;
    // Comparisons with NaN are false.
    (x[0] / units[0]).abs() < FAR
        && (x[1] / units[1]).abs() < FAR
        && penetration < DEEP * rig.amplitude()
}
