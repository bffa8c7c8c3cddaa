//! Periodic orbits by shooting on the section at drive phase 0, with their monodromy multipliers.

mod loop_force;
mod monodromy;
mod watch;

use shared::model::params::RigParams;
use shared::model::rig::Rig;

use crate::flow::Scalar;
use crate::reference::{LocatedContact, Reference, TOLERANCE, TrajectoryObserver};
pub use loop_force::loop_force_n;
pub(crate) use monodromy::seeds;
pub use monodromy::{Monodromy, Multipliers};
pub use watch::OrbitWatch;

/// A point of the section: coordinate and rate of the hammer, deviation of the cart from its course (m) and its rate (m/s).
/// The last two are 0 with a prescribed cart.
pub type Section = [f64; 4];

/// The section point of a hammer at coordinate and rate `hammer` in a cart that is on its course.
pub fn on_course(hammer: [f64; 2]) -> Section {
    [hammer[0], hammer[1], 0.0, 0.0]
}

/// A fixed point of the section's return map taken `periods` times: an orbit that repeats after as many drive periods.
#[derive(Clone, Debug, PartialEq)]
pub struct Orbit {
    /// Drive frequency, Hz.
    pub frequency_hz: f64,
    /// Drive periods after which it repeats.
    pub periods: u8,
    /// Coordinate and rate on the section, in the rig's coordinate ([`shared::model::rig`]).
    pub section: [f64; 2],
    /// Deviation of the cart from its course there, m, and its rate, m/s: 0 with a prescribed cart.
    pub cart: [f64; 2],
    /// Every point on the section, `section` first: one for each drive period.
    pub strobes: Vec<[f64; 2]>,
    /// Monodromy matrix over all periods.
    pub monodromy: Monodromy,
    /// Onsets in all periods.
    pub impacts: u16,
    /// Largest contact force, N.
    pub force_n: f64,
    /// Largest contact force in each drive period, N, from the section point of the same index on.
    pub period_forces_n: Vec<f64>,
    /// The contact with the largest force.
    pub contact: LocatedContact,
    /// What else was seen on the way round.
    pub seen: OrbitWatch,
    /// Energy the shaker puts in per drive period, J: what contact and damping take.
    pub energy_per_period_j: f64,
}

impl Orbit {
    /// The two leading eigenvalues of the monodromy matrix.
    pub fn multipliers(&self) -> Multipliers {
        self.monodromy.multipliers()
    }

    /// The two leading multipliers as (real part, imaginary part); of a complex pair the one above the real axis first.
    pub fn eigenvalues(&self) -> [(f64, f64); 2] {
        self.monodromy.leading()
    }

    /// Where it is on the section: the hammer and the cart.
    pub fn at(&self) -> Section {
        [self.section[0], self.section[1], self.cart[0], self.cart[1]]
    }

    /// Whether this is a stable z = 1/1.
    pub fn is_stable_one_one(&self) -> bool {
        self.periods == 1 && self.impacts == 1 && self.is_stable()
    }

    /// Whether every multiplier lies inside the unit circle.
    pub fn is_stable(&self) -> bool {
        self.stability() == Stability::Stable
    }

    /// What becomes of a small disturbance.
    pub fn stability(&self) -> Stability {
        let multipliers = self.multipliers();
        match multipliers {
            Multipliers::Complex(modulus) if (modulus - 1.0).abs() < NEUTRAL => Stability::Neutral,
            _ if multipliers.modulus() < 1.0 => Stability::Stable,
            _ => Stability::Unstable,
        }
    }

    /// det(I + M): passes 0 where a multiplier passes −1, a period doubling.
    pub fn doubling_test(&self) -> f64 {
        self.monodromy.doubling_test()
    }

    /// det(I − M): passes 0 where a multiplier passes +1, a fold.
    pub fn fold_test(&self) -> f64 {
        self.monodromy.fold_test()
    }

    /// The smallest approach speed of its contacts that can graze, m/s: 0 where one of them does. None if none of them
    /// can.
    pub fn slowest_approach_m_per_s(&self) -> Option<f64> {
        let speeds = self.seen.grazing_contacts();
        speeds.map(|c| c.approach_speed_m_per_s).reduce(f64::min)
    }

    /// The shortest flight between two of its contacts, as a share of the shorter of the two: 0 where they merge.
    pub fn shortest_flight(&self) -> Option<f64> {
        let period_s = f64::from(self.periods) / self.frequency_hz;
        self.seen.shortest_flight(period_s)
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

/// What becomes of a small disturbance of an orbit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Stability {
    /// It dies away: every multiplier lies inside the unit circle.
    Stable,
    /// It neither grows nor dies away: the multipliers lie on the unit circle, since nothing takes energy. The linear
    /// theory does not decide.
    Neutral,
    /// It grows: a multiplier lies outside the unit circle.
    Unstable,
}

/// A complex pair of multipliers this close to the unit circle lies on it: rounding decides on which side. Every damper
/// and every contact that takes energy takes more than this.
const NEUTRAL: f64 = 1e-6;

/// Newton steps before giving up.
const ITERATIONS: usize = 15;

/// A fixed point is found when the return map moves it by less than this share of A0 and A0 Ω.
pub(crate) const CLOSURE: f64 = 1e-10;

/// How exactly an orbit is found.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Exactness {
    /// Errors of a step are kept below this share of A0 and A0 Ω.
    tolerance: f64,
    /// It is found when the return map moves it by less than this share of the same.
    closure: f64,
    /// Whether derivatives near the orbit do: then only the first guess is followed with them. They tell of its stability
    /// where no multiplier is of this modulus there; else the orbit is followed with them, too.
    near: Option<f64>,
}

impl Exactness {
    /// To rounding: what [`shoot`] gives.
    pub(crate) const FULL: Self = Self {
        tolerance: TOLERANCE,
        closure: CLOSURE,
        near: None,
    };
    /// Its force to some 1e-7, for one rig of many.
    pub(crate) const OF_MANY: Self = Self {
        tolerance: 1e-10,
        closure: 1e-8,
        near: Some(0.8),
    };
    /// To what a picture shows.
    pub(crate) const DRAWN: Self = Self {
        tolerance: 1e-7,
        closure: 1e-4,
        near: Some(f64::INFINITY),
    };
}

/// Finds the period-one orbit near `guess` (coordinate and rate on the section, the cart on its course) by Newton's
/// iteration on the return map, whose derivative the dual-number integration gives exactly.
///
/// `None` if Newton's iteration does not settle, or leaves the hammer without contact.
pub fn shoot(params: &RigParams, frequency_hz: f64, guess: [f64; 2]) -> Option<Orbit> {
    shoot_at(params, frequency_hz, on_course(guess), 1)
}

/// [`shoot`] from a guess of the cart's deviation as well, for an orbit that repeats after `periods` drive periods. One
/// that repeats sooner is found, too: [`Orbit::asymmetry`] tells them apart.
pub fn shoot_at(
    params: &RigParams,
    frequency_hz: f64,
    guess: Section,
    periods: u8,
) -> Option<Orbit> {
    shoot_to(Exactness::FULL, params, frequency_hz, guess, periods)
}

/// The stable 1/1 near `guess`, for one rig of many.
pub(crate) fn stable_of_many(
    params: &RigParams,
    frequency_hz: f64,
    guess: Section,
) -> Option<Orbit> {
    let found = shoot_to(Exactness::OF_MANY, params, frequency_hz, guess, 1);
    found.filter(Orbit::is_stable_one_one)
}

/// [`shoot_at`] to this `exactness` instead of the full one.
pub(crate) fn shoot_to(
    exactness: Exactness,
    params: &RigParams,
    frequency_hz: f64,
    guess: Section,
    periods: u8,
) -> Option<Orbit> {
    /// How much smaller a miss must become with derivatives from nearby.
    const SMALLER: f64 = 0.25;
    let (mut x, mut last, mut known) = (guess, f64::INFINITY, None);
    for _ in 0..ITERATIONS {
        let image = if let Some(near) = known {
            let tolerance = exactness.tolerance;
            let (mut image, _) = ReturnMapImage::from(tolerance, params, frequency_hz, x, 1)?;
            image.monodromy = near;
            image
        } else {
            ReturnMapImage::of(exactness, params, frequency_hz, x, periods)?
        };
        let miss = image.miss(x);
        let size = largest(miss);
        let calm = |image: &ReturnMapImage| {
            let modulus = image.monodromy.multipliers().modulus();
            exactness.near.is_some_and(|most| modulus < most)
        };
        if size < exactness.closure {
            if known.is_none() || calm(&image) {
                return image.orbit(frequency_hz, x);
            }
            known = None;
            continue;
        }
        let near = exactness.near.is_some() && periods == 1;
        let use_again = near && (known.is_none() || size < SMALLER * last);
        known = use_again.then_some(image.monodromy);
        last = size;
        // (I − M) step = miss.
        let step = image.monodromy.newton_step(miss);
        let length = largest(step);
        if !length.is_finite() {
            return None;
        }
        // A step of several amplitudes leads out of where the linearisation holds.
        let damping = (3.0 / length).min(1.0);
        for i in 0..4 {
            x[i] += damping * step[i] * image.units[i];
        }
    }
    None
}

/// The largest magnitude; NaN if a number is none.
pub(crate) fn largest(x: Section) -> f64 {
    let mut largest = 0.0_f64;
    for x in x {
        if x.is_nan() {
            return x;
        }
        largest = largest.max(x.abs());
    }
    largest
}

/// The return map of some periods with its derivative, and what happened on the way.
pub(crate) struct ReturnMapImage {
    end: Section,
    /// The derivative in units of A0 and A0 Ω.
    pub(crate) monodromy: Monodromy,
    /// A0 and A0 Ω in the rig's coordinate, and in m and m/s.
    pub(crate) units: Section,
    onsets: u16,
    period_forces_n: Vec<f64>,
    strobes: Vec<[f64; 2]>,
    seen: OrbitWatch,
    energy_j: f64,
}

impl ReturnMapImage {
    /// Of the section point `x` after `periods`. `None` for a point that belongs to no orbit, or whose motion cannot
    /// be followed.
    pub(crate) fn of(
        exactness: Exactness,
        params: &RigParams,
        frequency_hz: f64,
        x: Section,
        periods: u8,
    ) -> Option<Self> {
        let tolerance = exactness.tolerance;
        if params.cart.recoils() {
            Self::along::<4>(tolerance, params, frequency_hz, x, periods)
        } else {
            Self::along::<2>(tolerance, params, frequency_hz, x, periods)
        }
    }

    /// [`Self::of`] to this `tolerance`, with derivatives along the first `N` directions of the section.
    fn along<const N: usize>(
        tolerance: f64,
        params: &RigParams,
        frequency_hz: f64,
        x: Section,
        periods: u8,
    ) -> Option<Self> {
        let start = seeds::<N>(x);
        let (mut image, end) = Self::from(tolerance, params, frequency_hz, start, periods)?;
        image.monodromy = Monodromy::of_seeds(end, image.units);
        Some(image)
    }

    /// Of `start` after `periods`, without a monodromy matrix yet, and where it ends.
    fn from<R: Scalar>(
        tolerance: f64,
        params: &RigParams,
        frequency_hz: f64,
        start: [R; 4],
        periods: u8,
    ) -> Option<(Self, [R; 4])> {
        let x = start.map(R::to_f64);
        let mut hammer = Reference::new(params, frequency_hz, start[0], start[1])
            .ok()?
            .with_cart([start[2], start[3]])
            .with_tolerance(tolerance);
        let scale = hammer.rig().coordinate_scale();
        let amplitude = hammer.rig().amplitude();
        let rate = |unit: f64| unit * std::f64::consts::TAU * frequency_hz;
        let units = [scale, rate(scale), amplitude, rate(amplitude)];
        let mut seen = OrbitWatch::default();
        let (mut onsets, mut period_forces_n) = (0_u16, Vec::new());
        let mut strobes = vec![[x[0], x[1]]];
        for _ in 0..periods {
            let (q, v) = hammer.state();
            if !plausible(hammer.rig(), [q.to_f64(), v.to_f64()], units) {
                return None;
            }
            let period = hammer.run_period(&mut seen);
            onsets = onsets.saturating_add(period.onsets);
            period_forces_n.push(period.peak_force);
            let (q, v) = hammer.state();
            strobes.push([q.to_f64(), v.to_f64()]);
        }
        strobes.pop();
        let (q, v) = hammer.state();
        let cart = hammer.cart();
        let end = [q, v, cart[0], cart[1]];
        let energy_j = hammer.totals().inertial_work;
        if in_contact(hammer.rig(), [x[0], x[1]]) && !seen.contacts.is_empty() {
            // The first contact began before the start. Seen whole, it is the one under way at the end.
            seen.contacts.remove(0);
            let end_s = f64::from(periods) * hammer.period_s();
            let mut after = Vec::new();
            hammer.run_period(&mut after);
            seen.contacts.extend(
                after
                    .into_iter()
                    .filter(|c: &LocatedContact| c.onset_s < end_s),
            );
        }
        let image = Self {
            end: end.map(R::to_f64),
            monodromy: Monodromy::new(0, [[0.0; 4]; 4]),
            units,
            onsets,
            period_forces_n,
            strobes,
            seen,
            energy_j,
        };
        Some((image, end))
    }

    /// How far the image is from `x`, in units of A0 and A0 Ω.
    pub(crate) fn miss(&self, x: Section) -> Section {
        [0, 1, 2, 3].map(|i| (self.end[i] - x[i]) / self.units[i])
    }

    /// The orbit, if `x` is a fixed point. `None` without contact.
    pub(crate) fn orbit(self, frequency_hz: f64, x: Section) -> Option<Orbit> {
        let contacts = self.seen.contacts.iter().copied();
        let strongest = contacts.max_by(|a, b| a.peak_force_n.total_cmp(&b.peak_force_n))?;
        let periods = self.strobes.len() as u8;
        Some(Orbit {
            frequency_hz,
            periods,
            section: [x[0], x[1]],
            cart: [x[2], x[3]],
            strobes: self.strobes,
            monodromy: self.monodromy,
            impacts: self.onsets,
            force_n: self.period_forces_n.iter().copied().fold(0.0, f64::max),
            period_forces_n: self.period_forces_n,
            contact: strongest,
            seen: self.seen,
            energy_per_period_j: self.energy_j / f64::from(periods),
        })
    }
}

/// Where hammer and cart are that begin on `state` at drive phase `from` (turns), `turns` drive periods later. `None` where
/// the motion cannot be followed.
pub(crate) fn carried<R: Scalar>(
    params: &RigParams,
    frequency_hz: f64,
    [q, v, e, w]: [R; 4],
    (from, turns): (f64, f64),
    watch: &mut impl TrajectoryObserver,
) -> Option<[R; 4]> {
    let phase = from.rem_euclid(1.0);
    let hammer = Reference::new(params, frequency_hz, q, v).ok()?;
    let mut hammer = hammer.from_phase(phase).with_cart([e, w]);
    let end = phase + turns;
    for _ in 0..end.floor() as u32 {
        hammer.run_period(watch);
    }
    let rest = end - end.floor();
    if rest > 0.0 && turns > 0.0 {
        hammer.run_until(rest, watch);
    }
    let (q, v) = hammer.state();
    let [e, w] = hammer.cart();
    let all = [q, v, e, w];
    all.iter().all(|x| x.to_f64().is_finite()).then_some(all)
}

fn in_contact(rig: &Rig<f64>, x: [f64; 2]) -> bool {
    let at = rig.kinematics(x[0], x[1]);
    rig.indicator(&at, at.rate.max(0.0)) > 0.0
}

/// Whether a section point can belong to an orbit: not deep inside the surface, nor far out. Newton's
/// iteration may propose others, and following them would be long and senseless.
fn plausible(rig: &Rig<f64>, x: [f64; 2], units: Section) -> bool {
    const FAR: f64 = 60.0;
    const DEEP: f64 = 0.2;
    let penetration = rig.kinematics(x[0], x[1]).delta;
    // Comparisons with NaN are false.
    (x[0] / units[0]).abs() < FAR
        && (x[1] / units[1]).abs() < FAR
        && penetration < DEEP * rig.amplitude()
}
