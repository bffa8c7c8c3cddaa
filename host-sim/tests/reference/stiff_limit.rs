//! In the limit of a stiff contact the linear oscillator bounces with Newton's restitution e, and its
//! period-one orbit is known in closed form: F. Peterka, "Laws of impact motion of mechanical systems
//! with one degree of freedom", Acta Technica ČSAV 19 (1974); S. W. Shaw and P. J. Holmes, "A
//! periodically forced piecewise linear oscillator", J. Sound Vib. 90(1), 129–155 (1983).

use std::f64::consts::{PI, TAU};

use host_sim::orbit::{Orbit, shoot};
use shared::contact::Law;
use shared::params::{BEAM_150, RigParams, SupportParams};

const NATURAL_HZ: f64 = 5.25;
const ZETA: f64 = 0.02;
const MASS_KG: f64 = 0.298;
const GAP_M: f64 = 1e-3;
const RATIO: f64 = 1.5;

/// The contact's damping ratio with Table 3.1, kept while the contact stiffens: so e stays.
fn contact_zeta() -> f64 {
    1.2e3 / (2.0 * (5.5e6_f64 * MASS_KG).sqrt())
}

fn restitution() -> f64 {
    let zeta = contact_zeta();
    let root = (1.0 - zeta * zeta).sqrt();
    (-2.0 * zeta / root * zeta.acos()).exp()
}

/// Table 3.1's contact made `times` shorter.
fn stiffened(times: f64) -> RigParams {
    RigParams {
        support: SupportParams::Beams {
            natural_frequency_hz: NATURAL_HZ,
            damping_ratio: ZETA,
            cubic_stiffness_n_per_m3: Some(0.0),
        },
        mass_kg: MASS_KG,
        gap_m: GAP_M,
        contact: Law::SpringDashpot {
            stiffness: 5.5e6 * times * times,
            damping: 1.2e3 * times,
        },
        ..BEAM_150
    }
}

/// The 1/1 orbit of the oscillator that bounces with restitution e.
struct Bouncing {
    /// Impact speed, m/s.
    speed: f64,
    /// Drive phase of the impact, rad.
    phase: f64,
    /// Of the linearised return map.
    determinant: f64,
    trace: f64,
    /// Coordinate (from the surface) and rate at drive phase 0.
    section: [f64; 2],
}

/// Between impacts, t after the impact at drive phase α: Δ = P sin(Ωt + α − ψ) + h(t), with the free
/// decay h from (a, h′(0)). That the orbit closes asks h(T) = h(0) = a, which fixes h′(0) = k₀ a and
/// h′(T) = k₁ a; impact asks Δ̇(0) = −e Δ̇(T). With Δ = gap at both ends, sin² + cos² = 1 gives a quadratic
/// for a. Both roots are returned.
fn bouncing(frequency_hz: f64) -> [Bouncing; 2] {
    let (w, drive, e) = (TAU * NATURAL_HZ, TAU * frequency_hz, restitution());
    let (decay, wd) = (ZETA * w, w * (1.0 - ZETA * ZETA).sqrt());
    let period = TAU / drive;
    let (sin, cos, fade) = (
        (wd * period).sin(),
        (wd * period).cos(),
        (-decay * period).exp(),
    );
    let (stiff, damp) = (w * w - drive * drive, 2.0 * decay * drive);
    let forced = BEAM_150.amplitude_m * drive * drive / stiff.hypot(damp);
    let lag = damp.atan2(stiff);
    // h = e^(−decay t) (a cos + β a sin), closed after a period.
    let beta = (1.0 / fade - cos) / sin;
    let k0 = -decay + wd * beta;
    let k1 = fade * ((-decay + wd * beta) * cos - (decay * beta + wd) * sin);
    let speed_per_a = (k1 - k0) / (1.0 + e);
    // Forced part at impact: position gap − a, velocity (speed_per_a − k1) a = κ a.
    let kappa = speed_per_a - k1;
    let (qa, qb) = (1.0 + (kappa / drive).powi(2), -2.0 * GAP_M);
    let qc = GAP_M * GAP_M - forced * forced;
    let root = (qb * qb - 4.0 * qa * qc).sqrt();
    [-1.0, 1.0].map(|side| {
        let a = (-qb + side * root) / (2.0 * qa);
        let speed = speed_per_a * a;
        let angle = ((GAP_M - a) / forced).atan2(kappa * a / (forced * drive));
        let phase = (angle + lag).rem_euclid(TAU);
        // One period of flight, then the impact's saltation [[−e, 0], [(a₊ + e a₋)/v, −e]].
        let push = BEAM_150.amplitude_m * drive * drive * phase.sin() - w * w * GAP_M;
        let before = push - 2.0 * decay * speed;
        let after = push + 2.0 * decay * e * speed;
        let corner = (after + e * before) / speed;
        let flight = [
            [cos + decay / wd * sin, sin / wd],
            [-w * w / wd * sin, cos - decay / wd * sin],
        ];
        let trace = fade * (-e * (flight[0][0] + flight[1][1]) + flight[0][1] * corner);
        // Back at drive phase 0: from the impact on to the end of the period.
        let t = (TAU - phase) / drive;
        let turn = drive * t + phase - lag;
        let (s, c, f) = ((wd * t).sin(), (wd * t).cos(), (-decay * t).exp());
        let h = f * a * (c + beta * s);
        let rate = f * a * ((wd * beta - decay) * c - (wd + decay * beta) * s);
        Bouncing {
            speed,
            phase,
            determinant: e * e * fade * fade,
            trace,
            section: [
                forced * turn.sin() + h - GAP_M,
                forced * drive * turn.cos() + rate,
            ],
        }
    })
}

fn stable() -> Bouncing {
    let inside = |b: &Bouncing| b.trace.abs() < 1.0 + b.determinant && b.speed > 0.0;
    let found = bouncing(RATIO * NATURAL_HZ).into_iter().find(inside);
    found.expect("one of the two orbits is stable")
}

/// Errors of impact speed, phase, determinant and trace.
fn errors(orbit: &Orbit, exact: &Bouncing) -> [f64; 4] {
    let phase = orbit.contact.onset_s * orbit.frequency_hz * TAU;
    let [[a, b], [c, d]] = orbit.monodromy;
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
        let orbit = shoot(&stiffened(times), RATIO * NATURAL_HZ, exact.section)
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
    let orbits = bouncing(RATIO * NATURAL_HZ);
    let physical = |b: &&Bouncing| b.speed > 0.0;
    let stable = orbits.iter().filter(physical);
    let stable = stable.filter(|b| b.trace.abs() < 1.0 + b.determinant);
    assert_eq!(stable.count(), 1);
}
