//! The strongest 1/1 that a rig can hold, to judge a run by.
//!
//! Under prescribed motion it is the strongest stable 1/1 of the reference, as `pick --nominal` finds it. A
//! cart that recoils is another matter: a blow of the wires' hammer throws the cart forward by some 7 % of the
//! approach speed, and the hammer rebounds that much slower in the fixed frame; no controller can hold the
//! force of prescribed motion then. So for two bodies the plant itself is driven along a pure sine whose
//! fundamental on the cart is A0, started on the reference's orbit, and its force searched over frequency.

use std::f64::consts::TAU;

use shared::model::params::RigParams;
use shared::settings::TICK_S;

use super::bodies::BodiesState;
use super::cart::Mounting;
use super::plant::{Plant, ShakerDrive};
use super::shaker::SetPointPath;
use numerics::branch::{Branch, strongest_branch};
use numerics::orbit::{Orbit, shoot};
use numerics::pick::SEARCH_RATIOS;

/// Where the two bodies are tried, relative to the reference's optimum.
const TRIED: [f64; 8] = [0.91, 0.93, 0.95, 0.97, 0.99, 1.01, 1.03, 1.05];
/// Where the search begins among them: most rigs' best is next to it.
const BEGIN: usize = 4;
/// Where the reference's optimum at another amplitude is searched, relative to the one known.
const NEAR: (f64, f64) = (0.95, 1.05);
/// Most drive periods settled before the cart's amplitude is measured and corrected, each time.
const SETTLED: [u32; 3] = [40, 20, 30];
/// Relative change of the force from one period to the next, [`STILL_PERIODS`] times in a row, at which it has settled.
const STILL: f64 = 1e-7;
/// In so many periods in a row the force must change by at most [`STILL`].
const STILL_PERIODS: u32 = 4;
/// Drive periods over which force and amplitude are averaged once settled.
const MEASURED: u32 = 10;

/// A frequency and the force there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Optimum {
    /// Drive frequency, Hz.
    pub frequency_hz: f64,
    /// Largest force of a drive period, N.
    pub force_n: f64,
}

/// The branch of the strongest stable 1/1 of `rig` under prescribed motion, and its strongest orbit.
pub fn prescribed(rig: &RigParams) -> Option<(Branch, Orbit)> {
    let branch = strongest_branch(rig, SEARCH_RATIOS)?;
    let orbit = branch.best(branch.range(), |orbit| orbit.force_n)?;
    Some((branch, orbit))
}

/// The strongest 1/1 of `rig` with a cart that recoils on its `drive` and `mounting`, near the one under prescribed
/// motion.
pub fn two_bodies(rig: &RigParams, drive: &ShakerDrive, mounting: &Mounting) -> Option<Optimum> {
    let (branch, top) = prescribed(rig)?;
    let orbit = |hz: f64| branch.at(hz);
    around(rig, drive, mounting, top.frequency_hz, orbit)
}

/// The optimum of [`two_bodies`] for `rig`, and for the same rig at `amplitude_m`, which should not be far from its own:
/// the second reference's orbits are found from the first's.
pub fn two_bodies_at(
    rig: &RigParams,
    amplitude_m: f64,
    drive: &ShakerDrive,
    mounting: &Mounting,
) -> [Option<Optimum>; 2] {
    let other = RigParams {
        amplitude_m,
        ..*rig
    };
    let Some((branch, top)) = prescribed(rig) else {
        return [None, two_bodies(&other, drive, mounting)];
    };
    let own = |hz: f64| branch.at(hz);
    let first = around(rig, drive, mounting, top.frequency_hz, own);
    let larger = amplitude_m / rig.amplitude_m;
    let near = |hz: f64| {
        let guess = own(hz)?.section.map(|x| larger * x);
        shoot(&other, hz, guess).filter(Orbit::is_stable_one_one)
    };
    let (low, high) = (NEAR.0 * top.frequency_hz, NEAR.1 * top.frequency_hz);
    let force = |hz: f64| near(hz).map(|orbit| (orbit.force_n, ()));
    let second = match branch.largest((low, high), force) {
        // Not at an end of what was searched.
        Some((hz, ())) if (1.001 * low..0.999 * high).contains(&hz) => {
            around(&other, drive, mounting, hz, near)
        }
        _ => two_bodies(&other, drive, mounting),
    };
    [first, second]
}

/// The strongest near the reference's optimum at `top_hz`, each run started on the reference's `orbit` at its frequency.
fn around(
    rig: &RigParams,
    drive: &ShakerDrive,
    mounting: &Mounting,
    top_hz: f64,
    orbit: impl Fn(f64) -> Option<Orbit>,
) -> Option<Optimum> {
    let at = |frequency_hz: f64| {
        let section = orbit(frequency_hz)?.section;
        let plant = Plant::mounted(rig, drive, mounting, TICK_S).ok()?;
        let force_n = held_force(plant, rig, frequency_hz, section)?;
        Some(Optimum {
            frequency_hz,
            force_n,
        })
    };
    let mut known = [None; TRIED.len()];
    let mut force = |i: usize| -> Option<Optimum> {
        *known
            .get_mut(i)?
            .get_or_insert_with(|| at(TRIED[i] * top_hz))
    };
    let i = climb(TRIED.len(), BEGIN, |i| force(i).map(|o| o.force_n))?;
    let best = force(i)?;
    let neighbours = i.checked_sub(1).and_then(&mut force).zip(force(i + 1));
    // The top of the parabola through the best and its neighbours.
    let refined = neighbours.and_then(|(a, b)| {
        let bend = a.force_n - 2.0 * best.force_n + b.force_n;
        let shift = 0.5 * (a.force_n - b.force_n) / bend;
        at(best.frequency_hz + shift * (b.frequency_hz - best.frequency_hz))
    });
    [Some(best), refined]
        .into_iter()
        .flatten()
        .max_by(|a, b| a.force_n.total_cmp(&b.force_n))
}

/// The place of `count` with the largest value, uphill from `begin`; none where no place has one.
fn climb(count: usize, begin: usize, mut value: impl FnMut(usize) -> Option<f64>) -> Option<usize> {
    // From a place without a value, to the nearest that has one.
    let mut places: Vec<usize> = (0..count).collect();
    places.sort_by_key(|i| i.abs_diff(begin));
    let mut best = places.into_iter().find_map(|i| Some((i, value(i)?)))?;
    for step in [-1, 1] {
        while let Some(i) = best.0.checked_add_signed(step).filter(|i| *i < count)
            && let Some(higher) = value(i).filter(|v| *v > best.1)
        {
            best = (i, higher);
        }
    }
    Some(best.0)
}

/// Mean over drive periods of the largest force of `plant`, driven at `frequency_hz` with the rig's amplitude
/// as the fundamental of its cart; none if it does not strike exactly once per period.
pub fn held_force(
    plant: Plant,
    rig: &RigParams,
    frequency_hz: f64,
    section: [f64; 2],
) -> Option<f64> {
    // Whole ticks per period.
    let ticks = (1.0 / (frequency_hz * TICK_S)).round();
    let omega = TAU * frequency_hz;
    let mut run = Sine {
        plant: plant.with_tick(1.0 / (frequency_hz * ticks)),
        ticks: ticks as u32,
        omega,
        amplitude_m: rig.amplitude_m,
    };
    run.plant.set_state(BodiesState {
        q: section[0],
        v: section[1],
        y: 0.0,
        w: rig.amplitude_m * omega,
        ..BodiesState::default()
    });
    let mut last = None;
    for settle in SETTLED {
        let (mut before_n, mut still) = (0.0, 0);
        for _ in 0..settle {
            let force_n = run.period().force_n;
            let change = (force_n - before_n).abs();
            still = if change <= STILL * force_n {
                still + 1
            } else {
                0
            };
            before_n = force_n;
            if still >= STILL_PERIODS {
                break;
            }
        }
        let mut sum = Period::default();
        for _ in 0..MEASURED {
            let period = run.period();
            sum.force_n += period.force_n;
            sum.sine_m += period.sine_m;
            sum.cosine_m += period.cosine_m;
            sum.contacts += period.contacts;
        }
        let share = 1.0 / f64::from(MEASURED);
        let fundamental_m = share * sum.sine_m.hypot(sum.cosine_m);
        last = (sum.contacts == MEASURED).then_some((share * sum.force_n, fundamental_m));
        run.amplitude_m *= rig.amplitude_m / fundamental_m;
    }
    let (force_n, fundamental_m) = last?;
    // The last correction was small; force goes with the amplitude.
    Some(force_n * rig.amplitude_m / fundamental_m)
}

/// A plant on a sine.
struct Sine {
    plant: Plant,
    ticks: u32,
    omega: f64,
    amplitude_m: f64,
}

/// What a period brought.
#[derive(Default)]
struct Period {
    force_n: f64,
    contacts: u32,
    sine_m: f64,
    cosine_m: f64,
}

impl Sine {
    fn period(&mut self) -> Period {
        let mut period = Period::default();
        let count = f64::from(self.ticks);
        let tick_s = TAU / (self.omega * count);
        let (a, w) = (self.amplitude_m, self.amplitude_m * self.omega);
        let (mut sin, mut cos) = (0.0, 1.0);
        for k in 1..=self.ticks {
            let next = (TAU * f64::from(k) / count).sin_cos();
            let path = SetPointPath::new(tick_s, (a * sin, w * cos), (a * next.0, w * next.1));
            (sin, cos) = next;
            self.plant.tick(path, true);
            for contact in self.plant.finished() {
                period.force_n = period.force_n.max(contact.peak_force_n);
                period.contacts += 1;
            }
            period.sine_m += 2.0 / count * self.plant.cart_m() * sin;
            period.cosine_m += 2.0 / count * self.plant.cart_m() * cos;
        }
        period
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_top_is_climbed_to_from_either_side_and_from_where_there_is_nothing() {
        for top in 0..8_usize {
            for begin in 0..8 {
                let mut asked = 0;
                let found = climb(8, begin, |i| {
                    asked += 1;
                    // Places below the second have no value.
                    (i >= 2).then(|| -(i.abs_diff(top) as f64))
                });
                assert_eq!(found, Some(top.max(2)), "{top} from {begin}");
                assert!(asked <= 12, "{asked}");
            }
        }
        assert_eq!(climb(8, 4, |_| None), None);
        assert_eq!(climb(8, 4, |i| Some(i as f64)), Some(7));
    }
}
