//! A run from rest, a drive period at a time.

use shared::model::contacts::{Contact as Finished, ContactPiece, Period};
use std::f64::consts::TAU;

use super::LinearMotion;
use super::run::{LinearLeg, PeriodEvents};
use crate::modes::dense::dot;
use crate::modes::log::Log;
use crate::modes::{ModalRig, ModalState};

/// Onsets after which a period is given up.
const MOST_ONSETS: u32 = 2000;

/// A hammer with its modes and its cart, from drive phase 0 to drive phase 0.
#[derive(Clone, Debug)]
pub struct Follower {
    motion: LinearMotion,
    amplitude_m: f64,
    omega: f64,
    section: Vec<f64>,
    touching: bool,
    log: Log,
}

impl Follower {
    /// The hammer of `motion` and `rig` at rest relative to the cart at drive phase 0.
    pub fn at_rest(motion: LinearMotion, rig: &ModalRig) -> Self {
        Self {
            amplitude_m: rig.amplitude_m,
            omega: TAU * motion.frequency_hz,
            section: vec![0.0; motion.section_size()],
            motion,
            touching: false,
            log: Log::default(),
        }
    }

    /// Where the hammer is at drive phase 0.
    pub fn state(&self) -> ModalState {
        self.state_of(&self.section, 0.0).0
    }

    /// The contact with the largest force since this was last asked.
    pub fn take_strongest(&mut self) -> Option<Finished<f64>> {
        self.log.take_strongest()
    }

    /// Where the hammer is at drive phase 0, in A0 and A0 Ω.
    pub fn section(&self) -> &[f64] {
        &self.section
    }

    /// Runs a drive period that nobody watches; contacts in it are forgotten. If the motion cannot be followed, the
    /// state becomes NaN.
    pub fn skip(&mut self) {
        self.go_on(None);
        self.log = Log::default();
        self.touching = false;
    }

    fn go_on(&mut self, seen: Option<&mut PeriodEvents>) {
        match self.motion.run(&self.section, MOST_ONSETS, seen) {
            Some(end) => self.section = end,
            None => self.section.fill(f64::NAN),
        }
    }

    /// Runs to the next drive phase 0 and returns what happened on the way; `see` is told each state with the cart's
    /// deviation (m), `worked` what the surface took (J). If the motion cannot be followed, the state becomes NaN.
    pub fn run_period(
        &mut self,
        mut see: impl FnMut(&ModalState, f64),
        mut worked: impl FnMut(f64),
    ) -> Period<f64> {
        let mut seen = PeriodEvents {
            path: Some(Vec::new()),
            ..PeriodEvents::default()
        };
        let mut start = self.motion.at_phase_zero(&self.section);
        self.go_on(Some(&mut seen));
        let mut phase = 0.0;
        for leg in seen.path.take().unwrap_or_default() {
            if leg.touching != self.touching {
                let rate = dot(&self.motion.rate, &start) * self.motion.units.1;
                self.touching = leg.touching;
                self.log.switch(leg.touching, phase / TAU, rate);
            }
            if leg.touching {
                worked(self.press(&start, &leg));
            }
            let half = 0.5 * leg.length;
            for (k, z) in (1_u8..).zip(&leg.states) {
                let (state, deviation) = self.state_of(z, phase + f64::from(k) * half);
                see(&state, deviation);
            }
            phase += leg.length;
            [_, start] = leg.states;
        }
        Period {
            peak_force: seen.force * self.motion.units.0,
            ..self.log.close_period()
        }
    }

    /// Enters a piece of a contact that begins at `start`; what the surface took in it, J. The integrals are those of the quintic through the values at
    /// the ends and the middle and the slopes at the ends.
    fn press(&mut self, start: &[f64], leg: &LinearLeg) -> f64 {
        let motion = &self.motion;
        let states = [start, &leg.states[0], &leg.states[1]];
        let force = states.map(|z| dot(&motion.force, z) * motion.units.0);
        let rate = states.map(|z| dot(&motion.rate, z) * motion.units.1);
        // Slopes of force and rate at the beginning and at the end.
        let slopes = [0, 2].map(|k| {
            let mut rates = vec![0.0; states[k].len()];
            motion.pressing.a.apply(states[k], &mut rates);
            let of = |row: &[f64], unit: f64| dot(row, &rates) * unit * self.omega;
            (
                of(&motion.force, motion.units.0),
                of(&motion.rate, motion.units.1),
            )
        });
        let span_s = leg.length / self.omega;
        let integral = |f: [f64; 3], slope: [f64; 2]| {
            span_s * (7.0 * f[0] + 16.0 * f[1] + 7.0 * f[2]) / 30.0
                + span_s * span_s * (slope[0] - slope[1]) / 60.0
        };
        let [first, last] = slopes;
        let power = |k: usize, (force_rate, acceleration): (f64, f64)| {
            force_rate * rate[k] + force[k] * acceleration
        };
        let work = integral(
            [0, 1, 2].map(|k| force[k] * rate[k]),
            [power(0, first), power(2, last)],
        );
        let piece = ContactPiece {
            span_s,
            force: (force[0], force[2]),
            force_rate: (first.0, last.0),
            impulse: integral(force, [first.0, last.0]),
            work,
        };
        self.log.add(&piece);
        work
    }

    /// The state of `z` at a drive phase (rad), and the cart's deviation, m.
    fn state_of(&self, z: &[f64], phase: f64) -> (ModalState, f64) {
        let n = self.motion.modes;
        let mut state = ModalState {
            t: phase / self.omega,
            ..ModalState::default()
        };
        for i in 0..n {
            state.q[i] = z[i] * self.amplitude_m;
            state.v[i] = z[n + i] * self.motion.units.1;
        }
        let deviation = if self.motion.recoils { z[2 * n] } else { 0.0 };
        (state, deviation * self.amplitude_m)
    }
}
