//! Between contacts: every mode in closed form.

use super::{ModalRig, ModalState, PerMode};

/// A free flight from a state on: each mode's forced motion, and its own, which decays.
#[derive(Clone, Debug)]
pub struct Flight<'a> {
    rig: &'a ModalRig,
    omega: f64,
    start: f64,
    /// Forced motion: (sine, cosine) coefficient of Ωt.
    forced: [(f64, f64); super::MAX_MODES],
    /// Own motion since the start: (cosine, sine) coefficient.
    own: [(f64, f64); super::MAX_MODES],
}

/// The tip in flight, and how fast it can change from here on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlyingTip {
    /// δ, m; δ̇, m/s; δ̈, m/s².
    pub delta: [f64; 3],
    /// Bound on |δ̈| and on |d³δ/dt³| for all later times of the flight.
    pub bounds: [f64; 2],
}

impl<'a> Flight<'a> {
    /// From `state` on, under the drive at `omega` = Ω, rad/s.
    pub fn new(rig: &'a ModalRig, omega: f64, state: &ModalState) -> Self {
        let zeta = rig.damping_ratio;
        let (sin, cos) = (omega * state.t).sin_cos();
        let mut flight = Self {
            rig,
            omega,
            start: state.t,
            forced: Default::default(),
            own: Default::default(),
        };
        for (i, mode) in rig.modes.iter().enumerate() {
            let push = mode.participation_kg / mode.mass_kg * rig.amplitude_m * omega * omega;
            let stiff = mode.omega * mode.omega - omega * omega;
            let damp = 2.0 * zeta * mode.omega * omega;
            let square = stiff * stiff + damp * damp;
            let (s, c) = (push * stiff / square, -push * damp / square);
            flight.forced[i] = (s, c);
            let q = state.q[i] - s * sin - c * cos;
            let v = state.v[i] - omega * (s * cos - c * sin);
            flight.own[i] = (q, (v + zeta * mode.omega * q) / damped(mode.omega, zeta));
        }
        flight
    }

    /// The state at `t` (s after drive phase 0, not before the flight's start).
    pub fn at(&self, t: f64) -> ModalState {
        let zeta = self.rig.damping_ratio;
        let (drive_sin, drive_cos) = (self.omega * t).sin_cos();
        let mut state = ModalState {
            t,
            ..ModalState::default()
        };
        for (i, mode) in self.rig.modes.iter().enumerate() {
            let (s, c) = self.forced[i];
            let (a, b) = self.own[i];
            let rate = damped(mode.omega, zeta);
            let since = t - self.start;
            let (sin, cos) = (rate * since).sin_cos();
            let fading = (-zeta * mode.omega * since).exp();
            let own = fading * (a * cos + b * sin);
            let turning = fading * rate * (b * cos - a * sin);
            state.q[i] = own + s * drive_sin + c * drive_cos;
            state.v[i] =
                turning - zeta * mode.omega * own + self.omega * (s * drive_cos - c * drive_sin);
        }
        state
    }

    /// The tip at the state of [`Self::at`].
    pub fn tip(&self, state: &ModalState) -> FlyingTip {
        let drive = self.rig.amplitude_m * self.omega * self.omega * (self.omega * state.t).sin();
        let a: PerMode = self.rig.accelerations(state, drive, 0.0);
        let (delta, rate) = self.rig.penetration(state);
        let mut bounds = [0.0; 2];
        for (i, mode) in self.rig.modes.iter().enumerate() {
            let since = state.t - self.start;
            let fading = (-self.rig.damping_ratio * mode.omega * since).exp();
            // A damped oscillation of amplitude R turns in the complex plane at the rate ω: |q̈| ≤ ω² R.
            let own = fading * self.own[i].0.hypot(self.own[i].1);
            let forced = self.forced[i].0.hypot(self.forced[i].1);
            let (fast, slow) = (mode.omega.powi(2) * own, self.omega.powi(2) * forced);
            bounds[0] += fast + slow;
            bounds[1] += mode.omega * fast + self.omega * slow;
        }
        FlyingTip {
            delta: [delta, rate, a.iter().sum()],
            bounds,
        }
    }
}

/// The damped mode's own rate, rad/s.
fn damped(omega: f64, zeta: f64) -> f64 {
    omega * (1.0 - zeta * zeta).sqrt()
}
