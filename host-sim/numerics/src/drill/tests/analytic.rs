//! The published oscillator once more, by another method: each phase has a solution in closed form, and its end is found
//! by bisection on it. Nothing of the integrator is used.

use crate::drill::DrillPlan;
use crate::drill::published::{Drifting, PERIOD_TWO};

/// Mass seen from the front, its rate, compression of the top; drift beside it.
#[derive(Clone, Copy)]
struct State {
    t: f64,
    p: f64,
    y: f64,
    e: f64,
    drift: f64,
}

#[derive(Clone, Copy, PartialEq)]
enum Phase {
    Apart,
    Held,
    Slipping,
}

/// Free flight under b − `held` + a cos ωt for `s`: position and rate gained are exact.
fn flight(m: &Drifting, t: f64, s: f64, y: f64, held: f64) -> (f64, f64) {
    let w = m.omega;
    let (angle, end) = (w * t, w * (t + s));
    let speed = y + (m.b - held) * s + m.a / w * (end.sin() - angle.sin());
    let way = y * s + 0.5 * (m.b - held) * s * s
        - m.a / (w * w) * (end.cos() - angle.cos())
        - m.a / w * angle.sin() * s;
    (way, speed)
}

/// In contact with the ground held: p'' + 2ξ p' + p = b + a cos ωt.
fn held(m: &Drifting, from: &State, s: f64) -> (f64, f64) {
    let w = m.omega;
    let (re, im) = (1.0 - w * w, 2.0 * m.xi * w);
    let size = re * re + im * im;
    let forced = |t: f64| {
        let (sin, cos) = (w * t).sin_cos();
        let p = m.b + m.a * (re * cos + im * sin) / size;
        (p, m.a * w * (im * cos - re * sin) / size)
    };
    let (p0, y0) = forced(from.t);
    let (u, v) = (from.p - p0, from.y - y0);
    let damped = (1.0 - m.xi * m.xi).sqrt();
    let (sin, cos) = (damped * s).sin_cos();
    let fade = (-m.xi * s).exp();
    let c = (v + m.xi * u) / damped;
    let p = fade * (u * cos + c * sin);
    let y = fade * (v * cos - (m.xi * c + damped * u) * sin);
    let (p1, y1) = forced(from.t + s);
    (p + p1, y + y1)
}

fn after(m: &Drifting, phase: Phase, from: &State, s: f64) -> State {
    let decay = (-s / (2.0 * m.xi)).exp();
    let t = from.t + s;
    match phase {
        Phase::Apart => {
            let (way, y) = flight(m, from.t, s, from.y, 0.0);
            let (p, e) = (from.p + way, from.e * decay);
            State {
                t,
                p,
                y,
                e,
                ..*from
            }
        }
        Phase::Held => {
            let (p, y) = held(m, from, s);
            State {
                t,
                p,
                y,
                e: p,
                ..*from
            }
        }
        Phase::Slipping => {
            let (way, y) = flight(m, from.t, s, from.y, 1.0);
            let e = 1.0 + (from.e - 1.0) * decay;
            let dug = way - (e - from.e);
            let drift = from.drift + dug;
            State {
                t,
                p: e,
                y,
                e,
                drift,
            }
        }
    }
}

/// Positive while the phase lasts.
fn lasts(m: &Drifting, phase: Phase, s: &State) -> f64 {
    let force = s.e + 2.0 * m.xi * s.y;
    match phase {
        Phase::Apart => s.e - s.p,
        Phase::Held => force.min(1.0 - force),
        Phase::Slipping => s.y - (1.0 - s.e) / (2.0 * m.xi),
    }
}

fn next(m: &Drifting, phase: Phase, s: &State) -> Phase {
    let force = s.e + 2.0 * m.xi * s.y;
    match phase {
        Phase::Held if force < 0.5 => Phase::Apart,
        Phase::Slipping => Phase::Held,
        _ if force < 1.0 => Phase::Held,
        _ => Phase::Slipping,
    }
}

/// Progress in each of `periods` drive periods.
fn progress(m: &Drifting, periods: u32) -> Vec<f64> {
    let (mut s, mut phase) = (
        State {
            t: 0.0,
            p: 0.0,
            y: 0.0,
            e: 0.0,
            drift: 0.0,
        },
        Phase::Apart,
    );
    let period = std::f64::consts::TAU / m.omega;
    let step = 0.02_f64;
    (0..periods)
        .map(|_| {
            s.t = 0.0;
            let before = s.drift;
            while s.t < period {
                let mut h = step.min(period - s.t);
                let mut end = after(m, phase, &s, h);
                if lasts(m, phase, &end) < 0.0 {
                    let (mut low, mut high) = (0.0, h);
                    for _ in 0..60 {
                        h = 0.5 * (low + high);
                        end = after(m, phase, &s, h);
                        if lasts(m, phase, &end) < 0.0 {
                            high = h;
                        } else {
                            low = h;
                        }
                    }
                    end = after(m, phase, &s, high);
                    phase = next(m, phase, &end);
                }
                s = end;
            }
            s.drift - before
        })
        .collect()
}

#[test]
fn the_integrator_and_the_closed_forms_drift_alike() {
    let stable = [
        Drifting {
            a: 0.3,
            b: 0.1,
            xi: 0.01,
            omega: 0.1,
        },
        Drifting {
            a: 0.3,
            b: 0.15,
            xi: 0.1,
            omega: 0.1,
        },
        Drifting {
            a: 0.3,
            b: 0.2,
            xi: 0.3,
            omega: 0.3,
        },
    ];
    for motion in stable {
        let settled = progress(&motion, 416);
        let mean = settled[400..].iter().sum::<f64>() / 16.0;
        let plan = DrillPlan {
            settle: 400,
            recorded: 16,
        };
        let row = motion.run(plan).unwrap();
        let apart = row.progress_per_period / mean - 1.0;
        assert!(
            apart.abs() < 1e-6,
            "{motion:?}: {} {mean}",
            row.progress_per_period
        );
    }
}

/// Over the whole diagram at the usual parameters: what repeats after the same number of periods drifts alike by both
/// methods, and what does not repeat by one does not by the other.
#[test]
fn the_diagram_is_that_of_the_closed_forms() {
    let mut compared = 0;
    for step in 0..14 {
        let motion = Drifting {
            b: 0.03 + 0.02 * f64::from(step),
            ..PERIOD_TWO
        };
        let plan = DrillPlan {
            settle: 400,
            // A whole number of 1, 2, 3, 4, 6 and 8 periods.
            recorded: 48,
        };
        let row = motion.run(plan).unwrap();
        let settled = progress(&motion, 448);
        let last = &settled[400..];
        let repeats = |n: usize| {
            let apart = |i: usize| (last[i] - last[i - n]).abs();
            (n..48).map(apart).fold(0.0, f64::max) < 1e-5
        };
        let periods = (1..=16).find(|n| repeats(*n));
        assert_eq!(row.periods.map(usize::from), periods, "b {}", motion.b);
        if periods.is_some() {
            let mean = last.iter().sum::<f64>() / 48.0;
            let apart = row.progress_per_period / mean - 1.0;
            assert!(apart.abs() < 1e-6, "b {}: {apart}", motion.b);
            compared += 1;
        }
    }
    assert!(compared >= 4, "{compared}");
}
