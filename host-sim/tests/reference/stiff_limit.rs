//! The orbit that shooting finds approaches the closed form of [`crate::bouncing`] as the contact stiffens.

use std::f64::consts::{PI, TAU};

use numerics::orbit::{Orbit, shoot};

use crate::bouncing::{Bouncing, NATURAL_HZ, bouncing, stiffened};

const GAP_M: f64 = 1e-3;
const RATIO: f64 = 1.5;

fn stable() -> Bouncing {
    let inside = |b: &Bouncing| b.trace.abs() < 1.0 + b.determinant && b.speed > 0.0;
    let found = bouncing(RATIO * NATURAL_HZ, GAP_M).into_iter().find(inside);
    found.expect("one of the two orbits is stable")
}

/// Errors of impact speed, phase, determinant and trace.
fn errors(orbit: &Orbit, exact: &Bouncing) -> [f64; 4] {
    let phase = orbit.contact.onset_s * orbit.frequency_hz * TAU;
    let [[a, b], [c, d]] = orbit.monodromy.hammer();
    [
        orbit.contact.approach_speed_m_per_s / exact.speed - 1.0,
        (phase - exact.phase + PI).rem_euclid(TAU) - PI,
        (a * d - b * c) / exact.determinant - 1.0,
        (a + d) - exact.trace,
    ]
    .map(f64::abs)
}

#[test]
fn the_orbit_found_by_shooting_converges_to_the_closed_form_with_the_contact_time() {
    let exact = stable();
    let mut last: Option<[f64; 4]> = None;
    for times in [4.0, 8.0, 16.0, 32.0, 64.0] {
        let orbit = shoot(&stiffened(times, GAP_M), RATIO * NATURAL_HZ, exact.section)
            .expect("the closed form is near enough to start from");
        assert_eq!(orbit.impacts, 1);
        let now = errors(&orbit, &exact);
        println!("{times}: {now:?}");
        if let Some(last) = last {
            for (k, (before, after)) in last.iter().zip(now).enumerate() {
                let order = (before / after).log2();
                let name = ["speed", "phase", "determinant", "trace"][k];
                // First order or better: halving the contact halves the error.
                assert!(
                    order > 0.85,
                    "{name} at {times}: order {order:.2}, {after:.1e}"
                );
            }
        }
        last = Some(now);
    }
    let last = last.unwrap();
    assert!(last.iter().all(|e| *e < 2e-3), "{last:?}");
}

#[test]
fn the_other_orbit_is_unstable() {
    let orbits = bouncing(RATIO * NATURAL_HZ, GAP_M);
    let physical = |b: &&Bouncing| b.speed > 0.0;
    let stable = orbits.iter().filter(physical);
    let stable = stable.filter(|b| b.trace.abs() < 1.0 + b.determinant);
    assert_eq!(stable.count(), 1);
}
