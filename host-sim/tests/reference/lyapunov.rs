//! Lyapunov exponents against closed forms, multipliers, the divergence, two nearby trajectories, and the hard impact
//! oscillator with its own saltation matrix.

use std::f64::consts::TAU;

use numerics::lyapunov::{BLOCKS, Exponents, LyapunovSpan, exponents, of_smoothed};
use numerics::orbit::{Multipliers, shoot};
use numerics::reference::{LocatedContact, Reference};
use shared::model::cart::{ASSUMED_SHAKER, CartDrive};
use shared::model::contact::Law;
use shared::model::params::{BEAM_150, BEAM_170, RigParams, SupportParams, WIRES};
use shared::model::rig::Rig;

use crate::support::close;

fn with_gap(params: RigParams, gap_mm: f64) -> (RigParams, [f64; 2]) {
    let params = RigParams {
        gap_m: gap_mm * 1e-3,
        ..params
    };
    let rest = Rig::<f64>::new(&params).unwrap().rest();
    (params, [rest, 0.0])
}

fn at(
    params: &RigParams,
    ratio: f64,
    section: [f64; 2],
    transient: u32,
    periods: u32,
) -> Exponents {
    let hz = ratio * params.natural_frequency_hz();
    let plan = LyapunovSpan { transient, periods };
    exponents(params, hz, section, plan).unwrap()
}

/// Without contact the beams are a linear damped oscillator but for κ Δ², which is below 1e-4 of k: both exponents
/// are −ζω. The directions turn, so the mean is off by a bounded amount over the number of periods.
#[test]
fn a_damped_oscillator_has_its_damping_twice() {
    let (params, rest) = with_gap(BEAM_170, 3.5);
    let found = at(&params, 0.3, rest, 100, 1000);
    let damping = -0.004 * TAU * 4.5;
    close(
        "sum",
        found.largest_per_s + found.other_per_s.unwrap(),
        2.0 * damping,
        1e-9,
    );
    close("largest", found.largest_per_s, damping, 5e-3);
    assert_eq!(found.meaning(), "contracting");
}

/// On a periodic orbit the exponents are ln |multiplier| per period: 1/1 orbits with two real multipliers.
#[test]
fn a_periodic_orbit_has_the_logarithms_of_its_multipliers() {
    let mut compared = 0;
    for (params, ratio) in
        [(1.0, 1.8), (1.0, 1.9), (2.4, 1.5)].map(|(g, r)| (with_gap(WIRES, g).0, r))
    {
        let hz = ratio * params.natural_frequency_hz();
        let mut hammer = Reference::<f64>::at_rest(&params, hz).unwrap();
        (0..400).for_each(|_| {
            hammer.run_period(&mut ());
        });
        let orbit = shoot(&params, hz, hammer.state().into()).expect("a settled 1/1");
        let Multipliers::Real(a, b) = orbit.multipliers() else {
            continue;
        };
        let (large, small) = (a.abs().max(b.abs()), a.abs().min(b.abs()));
        let found = at(&params, ratio, orbit.section, 100, 200);
        close("largest", found.largest_per_s, large.ln() * hz, 1e-7);
        close("other", found.other_per_s.unwrap(), small.ln() * hz, 1e-7);
        compared += 1;
    }
    assert_eq!(compared, 3);
}

/// The same with a cart that recoils: two of its four multipliers are its own, e^−ζω T of its loop and so next to nothing,
/// and the two largest are the exponents. Without a cart in the derivative they would be those of another motion.
#[test]
fn a_periodic_orbit_in_a_cart_that_recoils_has_its_two_largest() {
    for ratio in [1.8, 1.9] {
        let params = RigParams {
            cart: CartDrive::Loop(ASSUMED_SHAKER),
            ..with_gap(WIRES, 1.0).0
        };
        let hz = ratio * params.natural_frequency_hz();
        let mut hammer = Reference::<f64>::at_rest(&params, hz).unwrap();
        (0..400).for_each(|_| {
            hammer.run_period(&mut ());
        });
        let section = hammer.state().into();
        let orbit = shoot(&params, hz, section).expect("a settled 1/1");
        let Multipliers::Real(a, b) = orbit.multipliers() else {
            panic!("{:?}", orbit.multipliers());
        };
        let (large, small) = (a.abs().max(b.abs()), a.abs().min(b.abs()));
        let found = at(&params, ratio, section, 400, 200);
        close("largest", found.largest_per_s, large.ln() * hz, 1e-6);
        close("second", found.other_per_s.unwrap(), small.ln() * hz, 1e-6);
    }
}

/// The sum is the mean divergence: the support's damper all the time, the contact's while there is contact (the force
/// jumps at onset without a determinant). Both rigs, the wires in chaos.
#[test]
fn the_sum_is_what_the_dampers_leave() {
    for ((params, rest), ratio) in [(with_gap(WIRES, 2.4), 1.6), (with_gap(BEAM_150, 1.0), 1.5)] {
        let hz = ratio * params.natural_frequency_hz();
        let periods = 60;
        let found = at(&params, ratio, rest, 0, periods);
        let mut hammer = Reference::<f64>::new(&params, hz, rest[0], rest[1]).unwrap();
        let mut contacts = Vec::<LocatedContact>::new();
        // Chaos parts this and the dual trajectory, whose steps differ, more slowly than that.
        (0..periods).for_each(|_| {
            hammer.run_period(&mut contacts);
        });
        let touching: f64 = contacts.iter().map(|c| c.duration_s).sum();
        let share = touching / (f64::from(periods) / hz);
        let (support, slope) = match params.support {
            SupportParams::Wires { length_m, .. } => {
                let sin = params.gap_m / length_m;
                (0.0, (1.0 - sin * sin).sqrt())
            }
            SupportParams::Beams {
                natural_frequency_hz,
                damping_ratio,
                ..
            } => (2.0 * damping_ratio * TAU * natural_frequency_hz, 1.0),
        };
        let divergence = -(support + slope * 1.2e3 / params.mass_kg * share);
        assert!(contacts.len() > 20, "{}", contacts.len());
        // cos θ changes by 2e-6 during a contact.
        let sum = found.largest_per_s + found.other_per_s.unwrap();
        close("divergence", sum, divergence, 1e-5);
    }
}

/// The wires have no damping: without contact the motion is quasi-periodic, and directions grow at most linearly.
#[test]
fn a_quasi_periodic_motion_has_none() {
    let (params, rest) = with_gap(WIRES, 3.5);
    let found = at(&params, 0.4, rest, 100, 2000);
    assert!(found.largest_per_period.abs() < 1e-3, "{found:?}");
    close(
        "sum",
        1.0 + found.largest_per_s + found.other_per_s.unwrap(),
        1.0,
        1e-9,
    );
}

/// In chaos, against the growth of the distance to a second trajectory that is set back to 1e-7 of A0 after every
/// period: no derivative taken. Both means carry the standard error.
#[test]
fn chaos_grows_as_two_nearby_trajectories_part() {
    let (params, rest) = with_gap(WIRES, 1.0);
    let ratio = 2.7;
    let found = at(&params, ratio, rest, 100, 3000);
    assert_eq!(found.meaning(), "chaotic");

    const NEAR: f64 = 1e-7;
    let hz = ratio * params.natural_frequency_hz();
    let scale = Rig::<f64>::new(&params).unwrap().coordinate_scale();
    let units = [scale, scale * TAU * hz];
    let next = |x: [f64; 2]| -> [f64; 2] {
        let mut hammer = Reference::<f64>::new(&params, hz, x[0], x[1]).unwrap();
        hammer.run_period(&mut ());
        hammer.state().into()
    };
    let mut x = [rest[0] - 0.01 * scale, 0.0];
    let mut apart = [NEAR, 0.0];
    let mut sum = 0.0;
    for k in 0..2600 {
        let y = next([x[0] + apart[0] * units[0], x[1] + apart[1] * units[1]]);
        x = next(x);
        let gone = [0, 1].map(|i| (y[i] - x[i]) / units[i]);
        let length = gone[0].hypot(gone[1]);
        apart = gone.map(|d| d * NEAR / length);
        if k >= 100 {
            sum += (length / NEAR).ln();
        }
    }
    let (near, error) = (sum / 2500.0, found.standard_error_per_s / hz);
    // Two independent means of one standard error each: four of the difference's.
    assert!(
        (near - found.largest_per_period).abs() < 4.0 * 1.5 * error,
        "{near} {found:?}"
    );
    assert!(found.largest_per_period > 10.0 * error, "{found:?}");
}

/// A linear oscillator that bounces from a hard wall with restitution e: flight in closed form, saltation as in
/// textbooks ([[−e, 0], [(a₊ + e a₋)/v, −e]]). Gives ln of the largest growth, per period, by block.
mod hard {
    use super::*;

    pub struct Oscillator {
        pub omega: f64,
        pub zeta: f64,
        pub gap: f64,
        pub amplitude: f64,
        pub drive: f64,
        pub restitution: f64,
    }

    impl Oscillator {
        /// Acceleration at displacement x, velocity v, time t.
        fn acceleration(&self, x: f64, v: f64, t: f64) -> f64 {
            let push = self.amplitude * self.drive.powi(2) * (self.drive * t).sin();
            push - 2.0 * self.zeta * self.omega * v - self.omega.powi(2) * x
        }

        /// The steady forced motion and its rate at time t.
        fn forced(&self, t: f64) -> (f64, f64) {
            let stiff = self.omega.powi(2) - self.drive.powi(2);
            let damp = 2.0 * self.zeta * self.omega * self.drive;
            let size = self.amplitude * self.drive.powi(2) / stiff.hypot(damp);
            let angle = self.drive * t - damp.atan2(stiff);
            (size * angle.sin(), size * self.drive * angle.cos())
        }

        /// e^{A s}: the free motion's propagator.
        fn free(&self, s: f64) -> [[f64; 2]; 2] {
            let (w, decay) = (self.omega, self.zeta * self.omega);
            let wd = w * (1.0 - self.zeta * self.zeta).sqrt();
            let (sin, cos, fade) = ((wd * s).sin(), (wd * s).cos(), (-decay * s).exp());
            [
                [fade * (cos + decay / wd * sin), fade * sin / wd],
                [-fade * w * w / wd * sin, fade * (cos - decay / wd * sin)],
            ]
        }

        fn fly(&self, (x, v): (f64, f64), t: f64, s: f64) -> (f64, f64) {
            let ((f0, g0), (f1, g1)) = (self.forced(t), self.forced(t + s));
            let m = self.free(s);
            let (dx, dv) = (x - f0, v - g0);
            (
                f1 + m[0][0] * dx + m[0][1] * dv,
                g1 + m[1][0] * dx + m[1][1] * dv,
            )
        }

        /// One drive period of state and direction.
        fn period(&self, state: &mut (f64, f64), direction: &mut [f64; 2]) {
            let period = TAU / self.drive;
            let turn = |m: [[f64; 2]; 2], d: [f64; 2]| m.map(|row| row[0] * d[0] + row[1] * d[1]);
            let (mut t, step) = (0.0, period / 500.0);
            let mut last_impact = -1.0;
            while t < period {
                let s = step.min(period - t);
                let to = self.fly(*state, t, s);
                let leaving = t - last_impact < 1e-12 && state.1 < 0.0;
                if to.0 < self.gap || (leaving && to.1 < 0.0) {
                    *state = to;
                    *direction = turn(self.free(s), *direction);
                    t += s;
                    continue;
                }
                let (mut low, mut high) = (0.0, s);
                for _ in 0..60 {
                    let middle = 0.5 * (low + high);
                    if self.fly(*state, t, middle).0 < self.gap {
                        low = middle;
                    } else {
                        high = middle;
                    }
                }
                let (_, v) = self.fly(*state, t, low);
                *direction = turn(self.free(low), *direction);
                t += low;
                let e = self.restitution;
                let (before, after) = (
                    self.acceleration(self.gap, v, t),
                    self.acceleration(self.gap, -e * v, t),
                );
                let corner = (after + e * before) / v;
                *direction = turn([[-e, 0.0], [corner, -e]], *direction);
                *state = (self.gap, -e * v);
                last_impact = t;
            }
        }

        /// Mean growth per period and its standard error, by blocks.
        pub fn exponent(&self, transient: usize, periods: usize) -> (f64, f64) {
            let (mut state, mut direction) = ((0.0, 0.0), [1.0, 0.0]);
            let mut booked = Vec::new();
            for k in 0..transient + periods {
                self.period(&mut state, &mut direction);
                let length = direction[0].hypot(direction[1] / self.drive);
                direction = direction.map(|d| d / length);
                if k >= transient {
                    booked.push(length.ln());
                }
            }
            let mean = |x: &[f64]| x.iter().sum::<f64>() / x.len() as f64;
            let blocks: Vec<f64> = booked.chunks_exact(periods / 20).map(mean).collect();
            let centre = mean(&blocks);
            let spread: f64 = blocks.iter().map(|b| (b - centre).powi(2)).sum();
            (centre, (spread / (20.0 * 19.0)).sqrt())
        }
    }
}

/// Table 3.1's contact made 64 times shorter keeps its restitution and is as good as hard. Its exponent in chaos is the
/// hard oscillator's.
#[test]
fn in_the_stiff_limit_chaos_is_that_of_the_hard_impact_oscillator() {
    const TIMES: f64 = 64.0;
    let (natural_hz, zeta, ratio, gap_mm) = (5.25, 0.02, 2.65, 1.0);
    let damped = 1.2e3 / (2.0 * (5.5e6_f64 * 0.298).sqrt());
    let root = (1.0 - damped * damped).sqrt();
    let oscillator = hard::Oscillator {
        omega: TAU * natural_hz,
        zeta,
        gap: gap_mm * 1e-3,
        amplitude: BEAM_150.amplitude_m,
        drive: TAU * natural_hz * ratio,
        restitution: (-2.0 * damped / root * damped.acos()).exp(),
    };
    let soft = RigParams {
        support: SupportParams::Beams {
            natural_frequency_hz: natural_hz,
            damping_ratio: zeta,
            cubic_stiffness_n_per_m3: Some(0.0),
        },
        contact: Law::SpringDashpot {
            stiffness: 5.5e6 * TIMES * TIMES,
            damping: 1.2e3 * TIMES,
        },
        ..BEAM_150
    };
    let (params, rest) = with_gap(soft, gap_mm);
    let found = at(&params, ratio, rest, 200, 4000);
    let hz = ratio * natural_hz;
    let (mean, error) = oscillator.exponent(200, 4000);
    let both = error.hypot(found.standard_error_per_s / hz);
    println!("{mean} {error} {found:?}");
    assert!(mean > 10.0 * error, "{mean} {error}");
    assert!(
        (found.largest_per_period - mean).abs() < 4.0 * both,
        "{mean} {error} {found:?}"
    );
}

/// The smoothing method's exponent, which needs no saltation, comes to the switch's on a periodic orbit as its width
/// shrinks.
#[test]
fn the_smoothed_contact_comes_to_the_same_exponent() {
    let (params, rest) = with_gap(WIRES, 1.0);
    let hz = 1.8 * params.natural_frequency_hz();
    let exact = at(&params, 1.8, rest, 300, 40).largest_per_s;
    let plan = LyapunovSpan {
        transient: 300,
        periods: 2 * BLOCKS,
    };
    let error = |width: f64| {
        (of_smoothed(&params, hz, width, rest, plan)
            .unwrap()
            .largest_per_s
            - exact)
            .abs()
    };
    let (wide, narrow) = (error(1e-7), error(1e-8));
    println!("{exact} {wide} {narrow}");
    assert!(
        narrow < 0.3 * wide && narrow < 0.01 * exact.abs(),
        "{wide} {narrow}"
    );
}
