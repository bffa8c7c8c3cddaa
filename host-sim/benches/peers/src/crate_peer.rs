//! The wires rig by a Rust crate: `differential-equations`, dopri5, switches located on its dense output.

use std::error::Error;
use std::f64::consts::TAU;
use std::path::Path;

use differential_equations::interpolate::Interpolation;
use differential_equations::methods::ExplicitRungeKutta;
use differential_equations::ode::{ODE, OrdinaryNumericalMethod};
use differential_equations::status::Status;
use numerics::lanes::{Cell, LaneStrobe};
use shared::model::rig::{Kinematics, Rig};

use crate::{CYCLES, RECORDED, Timing, timed, write};

const RTOL: f64 = 1e-6;
const ATOL: f64 = 1e-8;

type State = [f64; 2];

/// One side of the switch.
struct Side<'a> {
    rig: &'a Rig<f64>,
    omega: f64,
    contact: bool,
}

impl Side<'_> {
    fn at(&self, y: &State) -> Kinematics<f64> {
        self.rig.kinematics(y[0], y[1])
    }

    fn force(&self, y: &State) -> f64 {
        self.rig.force(&self.at(y), 0.0)
    }

    fn acceleration(&self, t: f64, y: &State) -> f64 {
        let drive = self.rig.amplitude() * self.omega * self.omega * (self.omega * t).sin();
        let at = self.at(y);
        let force = if self.contact { self.rig.force(&at, 0.0) } else { 0.0 };
        self.rig.acceleration(&at, y[1], drive, force)
    }

    fn force_rate(&self, t: f64, y: &State) -> f64 {
        let at = self.at(y);
        let (k, c) = self.rig.law().gradient(at.delta, at.rate, 0.0);
        let change = self.rig.penetration_acceleration(&at, y[1], self.acceleration(t, y));
        k * at.rate + c * change
    }

    /// Positive: this side of the switch is left.
    fn leaving(&self, y: &State) -> f64 {
        if self.contact {
            -self.force(y)
        } else {
            self.rig.indicator(&self.at(y), 0.0)
        }
    }
}

impl ODE<f64, State> for Side<'_> {
    fn diff(&self, t: f64, y: &State, d: &mut State) {
        *d = [y[1], self.acceleration(t, y)];
    }
}

/// Root of `f` in [a, b], f(a) < 0 < f(b), by the Illinois method with bisections; ends on the positive side.
fn root(mut f: impl FnMut(f64) -> f64, (mut a, mut fa): (f64, f64), (mut b, mut fb): (f64, f64)) -> f64 {
    for i in 0..100 {
        if b - a <= 1e-13 {
            break;
        }
        let secant = (a * fb - b * fa) / (fb - fa);
        let middle = 0.5 * (a + b);
        let c = if i % 8 != 7 && secant > a && secant < b { secant } else { middle };
        let fc = f(c);
        if fc > 0.0 {
            (b, fb) = (c, fc);
            fa *= 0.5;
        } else {
            (a, fa) = (c, fc);
            fb *= 0.5;
        }
    }
    b
}

fn simulate(cell: &Cell) -> Result<Vec<LaneStrobe>, Box<dyn Error>> {
    let rig = Rig::<f64>::new(&cell.params)?;
    let period = 1.0 / cell.frequency_hz;
    let last = f64::from(CYCLES) * period;
    let mut side = Side {
        rig: &rig,
        omega: TAU * cell.frequency_hz,
        contact: false,
    };
    let (mut t, mut y) = (0.0, cell.start);
    side.contact = side.leaving(&y) > 0.0;
    let (mut strobes, mut now, mut cycle) = (Vec::new(), LaneStrobe::default(), 1);
    while cycle <= CYCLES {
        let mut method = ExplicitRungeKutta::dopri5()
            .rtol(RTOL)
            .atol(ATOL)
            .h0(1e-5)
            .h_max(period / 16.0)
            .max_steps(usize::MAX);
        let failed = |e| format!("{e:?}");
        method.init(&side, t, 2.0 * last, &y).map_err(failed)?;
        loop {
            method.step(&side).map_err(failed)?;
            if matches!(method.status(), Status::RejectedStep) {
                continue;
            }
            let (t0, mut t1) = (method.t_prev(), method.t());
            let (y0, y1) = (*method.y_prev(), *method.y());
            let mut at = |t: f64| method.interpolate(t).expect("inside the step");
            let (g0, mut g1) = (side.leaving(&y0), side.leaving(&y1));
            let mut leaves = g1 > 0.0;
            if !leaves && !side.contact && y0[1] > 0.0 && y1[1] < 0.0 {
                // The hammer turns inside the step: the crest may have touched.
                let top = root(|t| -at(t)[1], (t0, -y0[1]), (t1, -y1[1]));
                let crest = side.leaving(&at(top));
                if crest > 0.0 {
                    (leaves, t1, g1) = (true, top, crest);
                }
            }
            let end = if leaves {
                root(|t| side.leaving(&at(t)), (t0, g0.min(-1e-300)), (t1, g1))
            } else {
                t1
            };
            let ye = at(end);
            if side.contact {
                now.force_n = now.force_n.max(side.force(&y0)).max(side.force(&ye));
                let (r0, r1) = (side.force_rate(t0, &y0), side.force_rate(end, &ye));
                if r0 > 0.0 && r1 < 0.0 {
                    let top = root(|t| -side.force_rate(t, &at(t)), (t0, -r0), (end, -r1));
                    now.force_n = now.force_n.max(side.force(&at(top)));
                }
            }
            while cycle <= CYCLES && f64::from(cycle) * period <= end {
                [now.q, now.v] = at(f64::from(cycle) * period);
                if cycle >= CYCLES - RECORDED {
                    strobes.push(now);
                }
                now = LaneStrobe::default();
                cycle += 1;
            }
            if leaves {
                side.contact = !side.contact;
                now.onsets += u16::from(side.contact);
                (t, y) = (end, ye);
                break;
            }
            if cycle > CYCLES {
                break;
            }
        }
    }
    Ok(strobes)
}

/// All cells, timed.
pub fn run(cells: &[Cell], out: &Path) -> Result<(), Box<dyn Error>> {
    let all = || cells.iter().map(simulate).collect::<Result<Vec<_>, _>>();
    let (found, cpu_s) = timed(all);
    let timing = Timing {
        name: "differential-equations 0.7.0, dopri5, dense output, 1e-6".into(),
        cycles: cells.len() as u64 * u64::from(CYCLES),
        cpu_s,
    };
    write(out, "crate", &found?.into_iter().enumerate().collect(), &timing)
}
