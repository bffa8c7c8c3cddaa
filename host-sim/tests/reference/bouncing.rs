//! In the limit of a stiff contact the linear oscillator bounces with Newton's restitution e, and its
//! period-one orbit is known in closed form: F. Peterka, "Laws of impact motion of mechanical systems
//! with one degree of freedom", Acta Technica ČSAV 19 (1974); S. W. Shaw and P. J. Holmes, "A
//! periodically forced piecewise linear oscillator", J. Sound Vib. 90(1), 129–155 (1983).

use std::f64::consts::TAU;

use shared::model::contact::Law;
use shared::model::params::{BEAM_150, RigParams, SupportParams};

pub const NATURAL_HZ: f64 = 5.25;
pub const ZETA: f64 = 0.02;
const MASS_KG: f64 = 0.298;

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
pub fn stiffened(times: f64, gap_m: f64) -> RigParams {
    RigParams {
        support: SupportParams::Beams {
            natural_frequency_hz: NATURAL_HZ,
            damping_ratio: ZETA,
            cubic_stiffness_n_per_m3: Some(0.0),
        },
        mass_kg: MASS_KG,
        gap_m,
        contact: Law::SpringDashpot {
            stiffness: 5.5e6 * times * times,
            damping: 1.2e3 * times,
        },
        ..BEAM_150
    }
}

/// The 1/1 orbit of the oscillator that bounces with restitution e.
pub struct Bouncing {
    /// Impact speed, m/s.
    pub speed: f64,
    /// Drive phase of the impact, rad.
    pub phase: f64,
    /// Of the linearised return map.
    pub determinant: f64,
    pub trace: f64,
    /// Coordinate (from the surface) and rate at drive phase 0.
    pub section: [f64; 2],
    /// The flight: amplitude of the forced part, m; its phase at the impact, rad; a, m; β.
    flight: [f64; 4],
    drive: f64,
    gap_m: f64,
}

/// Between impacts, t after the impact at drive phase α: Δ = P sin(Ωt + α − ψ) + h(t), with the free
/// decay h from (a, h′(0)). That the orbit closes asks h(T) = h(0) = a, which fixes h′(0) = k₀ a and
/// h′(T) = k₁ a; impact asks Δ̇(0) = −e Δ̇(T). With Δ = gap at both ends, sin² + cos² = 1 gives a quadratic
/// for a. Both roots are returned; they are no numbers where the quadratic has none.
pub fn bouncing(frequency_hz: f64, gap_m: f64) -> [Bouncing; 2] {
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
    let (qa, qb) = (1.0 + (kappa / drive).powi(2), -2.0 * gap_m);
    let qc = gap_m * gap_m - forced * forced;
    let root = (qb * qb - 4.0 * qa * qc).sqrt();
    [-1.0, 1.0].map(|side| {
        let a = (-qb + side * root) / (2.0 * qa);
        let speed = speed_per_a * a;
        let angle = ((gap_m - a) / forced).atan2(kappa * a / (forced * drive));
        let phase = (angle + lag).rem_euclid(TAU);
        // One period of flight, then the impact's saltation [[−e, 0], [(a₊ + e a₋)/v, −e]].
        let push = BEAM_150.amplitude_m * drive * drive * phase.sin() - w * w * gap_m;
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
                forced * turn.sin() + h - gap_m,
                forced * drive * turn.cos() + rate,
            ],
            flight: [forced, phase - lag, a, beta],
            drive,
            gap_m,
        }
    })
}

impl Bouncing {
    /// Positive before, negative after a multiplier passes −1.
    pub fn doubling_test(&self) -> f64 {
        1.0 + self.trace + self.determinant
    }

    /// Clearance at the nearest turn-back between two impacts, m: 0 where a second contact is about to begin; infinite
    /// if the hammer does not turn back on the way.
    pub fn near_miss_m(&self) -> f64 {
        const POINTS: usize = 4000;
        let w = TAU * NATURAL_HZ;
        let (decay, wd) = (ZETA * w, w * (1.0 - ZETA * ZETA).sqrt());
        let [forced, phase, a, beta] = self.flight;
        let at = |t: f64| {
            let h = (-decay * t).exp() * a * ((wd * t).cos() + beta * (wd * t).sin());
            forced * (self.drive * t + phase).sin() + h - self.gap_m
        };
        let dt = TAU / self.drive / POINTS as f64;
        let mut nearest = f64::INFINITY;
        for i in 1..POINTS - 1 {
            let t = i as f64 * dt;
            let (before, here, after) = (at(t - dt), at(t), at(t + dt));
            if here >= before && here > after {
                // The top of the parabola through the three.
                let bend = before - 2.0 * here + after;
                nearest = nearest.min(-(here - (after - before).powi(2) / (8.0 * bend)));
            }
        }
        nearest
    }
}
