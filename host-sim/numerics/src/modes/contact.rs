//! In contact: all modes together, by adaptive steps of Dormand–Prince 8(5,3).

use super::{ModalRig, PerMode, State};
use crate::reference::TOLERANCE;
use crate::reference::flow::Totals;
use crate::reference::tableau::{A, B, C, E3, E5, STAGES, error};

/// The flow in contact. The stages are not those of [`crate::reference::flow`]: each has all modes, and plain `f64`.
#[derive(Clone, Copy, Debug)]
pub struct ContactFlow<'a> {
    /// The rig.
    pub rig: &'a ModalRig,
    /// Ω, rad/s.
    pub omega: f64,
}

/// A step taken.
#[derive(Clone, Copy, Debug)]
pub struct Step {
    /// Where it ended.
    pub end: State,
    /// Error estimate relative to the tolerance (≤ 1: accept).
    pub error: f64,
    /// What was integrated beside it.
    pub totals: Totals,
}

impl ContactFlow<'_> {
    /// A0 Ω² sin Ωt, m/s².
    pub fn drive(&self, t: f64) -> f64 {
        self.rig.amplitude_m * self.omega * self.omega * (self.omega * t).sin()
    }

    /// F, N, and dF/dt, N/s.
    pub fn force(&self, state: &State) -> (f64, f64) {
        let (delta, rate) = self.rig.penetration(state);
        let force = self.rig.force(state);
        let a = self.rig.accelerations(state, self.drive(state.t), force);
        let (by_delta, by_rate) = self.rig.law.gradient(delta, rate, 0.0);
        (force, by_delta * rate + by_rate * a.iter().sum::<f64>())
    }

    /// One step of length `h`, s.
    pub fn step(&self, from: &State, h: f64) -> Step {
        let mut rates = [(PerMode::default(), PerMode::default()); STAGES];
        let mut totals = Totals::default();
        for stage in 0..STAGES {
            let mut at = moved(from, h, A[stage], &rates);
            at.t = from.t + h * C[stage];
            let (force, drive) = (self.rig.force(&at), self.drive(at.t));
            rates[stage] = (at.v, self.rig.accelerations(&at, drive, force));
            if let Some((_, weight)) = B.iter().find(|(i, _)| *i == stage) {
                let w = weight * h;
                totals = totals.plus(Totals {
                    impulse: w * force,
                    contact_work: w * force * at.tip_rate(),
                    inertial_work: w * self.rig.inertial_power(&at, drive),
                    damping_work: w * self.rig.losses(&at).iter().sum::<f64>(),
                });
            }
        }
        let mut end = moved(from, h, B, &rates);
        end.t = from.t + h;
        Step {
            end,
            error: self.error(h, &rates),
            totals,
        }
    }

    /// The error of the worst mode, over the tolerance.
    fn error(&self, h: f64, rates: &[(PerMode, PerMode); STAGES]) -> f64 {
        let unit = TOLERANCE * self.rig.amplitude_m;
        let estimate = |weights: &[(usize, f64)], mode: usize| {
            let (mut q, mut v) = (0.0, 0.0);
            for &(i, w) in weights {
                q += w * rates[i].0[mode];
                v += w * rates[i].1[mode];
            }
            (q / unit).hypot(v / (unit * self.omega)) * h
        };
        let one = |mode: usize| error(estimate(E5, mode), estimate(E3, mode));
        (0..self.rig.modes.len()).map(one).fold(0.0, f64::max)
    }
}

fn moved(
    from: &State,
    h: f64,
    weights: &[(usize, f64)],
    rates: &[(PerMode, PerMode); STAGES],
) -> State {
    let mut at = *from;
    for &(i, weight) in weights {
        for mode in 0..super::MAX_MODES {
            at.q[mode] += h * weight * rates[i].0[mode];
            at.v[mode] += h * weight * rates[i].1[mode];
        }
    }
    at
}
