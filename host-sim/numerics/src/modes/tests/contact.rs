//! In contact: all modes together.

use super::{MAX_MODES, ModalRig, ModalState};
use crate::flow::dormand_prince::combined;
use crate::flow::{Flow, reached};
use crate::reference::TOLERANCE;
use crate::reference::flow::FlowTotals;

/// A release is located when what is left to it is less than this, s.
pub const TIME_TOLERANCE_S: f64 = 1e-13;

/// Shortest step on where nothing is about to happen, s.
pub const SHORTEST_S: f64 = 1e-9;

/// Coordinate and rate of each mode in turn.
const NUMBERS: usize = 2 * MAX_MODES;

/// The modes while the hammer touches.
#[derive(Clone, Copy, Debug)]
pub struct ContactFlow<'a> {
    /// The rig in modal coordinates.
    pub rig: &'a ModalRig,
    /// Drive frequency Ω, rad/s.
    pub omega: f64,
}

impl ContactFlow<'_> {
    /// A0 Ω² sin Ωt, m/s².
    pub fn drive(&self, t: f64) -> f64 {
        self.rig.amplitude_m * self.omega * self.omega * (self.omega * t).sin()
    }

    /// F, N, and dF/dt, N/s.
    pub fn force(&self, state: &ModalState) -> (f64, f64) {
        let (delta, rate) = self.rig.penetration(state);
        let force = self.rig.force(state);
        let a = self.rig.accelerations(state, self.drive(state.t), force);
        let (by_delta, by_rate) = self.rig.law.gradient(delta, rate, 0.0);
        (force, by_delta * rate + by_rate * a.iter().sum::<f64>())
    }

    /// How long after `from` the force has just fallen to 0, given that it has `h` s after, at `end`: Newton's iteration,
    /// kept in a bracket.
    fn release(&self, from: &ModalState, h: f64, end: &ModalState) -> f64 {
        let (mut low, mut high) = (0.0, h);
        let (mut best, mut length) = (*end, h);
        for _ in 0..100 {
            let (force, slope) = self.force(&best);
            let newton = length - force / slope;
            length = if newton > low && newton < high {
                newton
            } else {
                0.5 * (low + high)
            };
            let there = reached(self, from, length);
            let (force, _) = self.force(&there);
            if force > 0.0 {
                low = length;
            } else {
                high = length;
            }
            let moved = (there.t - best.t).abs();
            best = there;
            if high - low < TIME_TOLERANCE_S || (force <= 0.0 && moved < TIME_TOLERANCE_S) {
                break;
            }
        }
        if self.force(&best).0 > 0.0 {
            high
        } else {
            length
        }
    }
}

impl Flow<NUMBERS> for ContactFlow<'_> {
    type Number = f64;
    type Point = ModalState;
    type Totals = FlowTotals;
    type Exit = ();

    fn time(&self, state: &ModalState) -> f64 {
        state.t
    }

    fn numbers(&self, state: &ModalState) -> [f64; NUMBERS] {
        alternating(&state.q, &state.v)
    }

    fn moving(&self) -> usize {
        2 * self.rig.modes.len()
    }

    fn after(&self, from: &ModalState, tau: f64, numbers: [f64; NUMBERS]) -> ModalState {
        let mut state = ModalState {
            t: from.t + tau,
            ..ModalState::default()
        };
        for (mode, [q, v]) in numbers.as_chunks().0.iter().enumerate() {
            (state.q[mode], state.v[mode]) = (*q, *v);
        }
        state
    }

    fn rates(
        &self,
        at: &ModalState,
        rates: &mut [f64; NUMBERS],
        weight: f64,
        totals: &mut FlowTotals,
    ) {
        let (force, drive) = (self.rig.force(at), self.drive(at.t));
        if weight != 0.0 {
            totals.impulse += weight * force;
            totals.contact_work += weight * force * at.tip_rate();
            totals.inertial_work += weight * self.rig.inertial_power(at, drive);
            totals.damping_work += weight * self.rig.losses(at).iter().sum::<f64>();
        }
        *rates = alternating(&at.v, &self.rig.accelerations(at, drive, force));
    }

    /// That of the worst mode.
    fn error(&self, fifth: &[f64; NUMBERS], third: &[f64; NUMBERS], h: f64) -> f64 {
        let unit = TOLERANCE * self.rig.amplitude_m;
        let size = |[q, v]: &[f64; 2]| (q / unit).hypot(v / (unit * self.omega)) * h;
        let modes = fifth.as_chunks().0.iter().zip(third.as_chunks().0);
        modes
            .map(|(fifth, third)| combined(size(fifth), size(third)))
            .fold(0.0, f64::max)
    }

    /// Whether the force falls below 0 between two points at which it pushes, on the cubic through both.
    fn too_long(&self, from: &ModalState, h: f64, end: &ModalState) -> bool {
        let length = end.t - from.t;
        let ((f0, r0), (f1, r1)) = (self.force(from), self.force(end));
        if h <= SHORTEST_S || f1 <= 0.0 || r0 >= 0.0 || r1 <= 0.0 {
            return false;
        }
        let (d0, d1, rise) = (r0 * length, r1 * length, f1 - f0);
        let (bend, jerk) = (3.0 * rise - 2.0 * d0 - d1, d0 + d1 - 2.0 * rise);
        let cubic = |s: f64| f0 + s * (d0 + s * (bend + s * jerk));
        (1..8).any(|k| cubic(f64::from(k) / 8.0) < 0.0)
    }

    fn exit(&self, from: &ModalState, h: f64, end: &ModalState) -> Option<((), f64)> {
        (self.force(end).0 <= 0.0).then(|| ((), self.release(from, h, end)))
    }
}

/// The numbers of two lists in turn.
fn alternating(a: &[f64; MAX_MODES], b: &[f64; MAX_MODES]) -> [f64; NUMBERS] {
    std::array::from_fn(|k| if k % 2 == 0 { a[k / 2] } else { b[k / 2] })
}
