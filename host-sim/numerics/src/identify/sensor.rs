//! The force sensor as the fit has it: a gain, a zero, a second-order filter, and the surface's ringing after each
//! contact.

use shared::model::rig::Rig;
use std::f64::consts::TAU;

use crate::contact_law::undriven::Course;
use crate::low_pass::{self, State};

/// Steps in a contact at least.
const STEPS: f64 = 100.0;

/// A damped swing after each contact's largest force, over that force: the real and the imaginary part of
/// exp(−t/τ + 2πift) are two swings a quarter turn apart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Swing {
    /// Size of the real part.
    pub cos: f64,
    /// Size of the imaginary part.
    pub sin: f64,
    /// Frequency, Hz.
    pub hz: f64,
    /// Time constant, s.
    pub decay_s: f64,
}

/// How the sensor shows a contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sensor {
    /// What it shows over what there is.
    pub gain: f64,
    /// What it shows without force, N.
    pub offset_n: f64,
    /// One over the angular frequency of the filter's corner, s; 0: no filter.
    pub filter_s: f64,
    /// The filter's damping ratio.
    pub filter_damping: f64,
    /// The ringing.
    pub swing: Option<Swing>,
}

/// A contact as the filter shows it.
pub struct Pulse<'a> {
    rig: &'a Rig<f64>,
    course: &'a Course,
    filter_s: f64,
    damping: f64,
    step_s: f64,
    /// The filter's state and the force at each step; empty without a filter.
    states: Vec<(State, f64)>,
}

impl<'a> Pulse<'a> {
    /// Of `course`, sampled every `sample_s`.
    pub fn new(rig: &'a Rig<f64>, course: &'a Course, sensor: &Sensor, sample_s: f64) -> Self {
        let duration = course.contact.duration_s;
        let count = (duration / (0.25 * sample_s)).clamp(STEPS, 1e5).ceil();
        let mut pulse = Self {
            rig,
            course,
            filter_s: sensor.filter_s,
            damping: sensor.filter_damping,
            step_s: duration / count,
            states: Vec::new(),
        };
        if sensor.filter_s <= 1e-3 * sample_s {
            pulse.filter_s = 0.0;
            return pulse;
        }
        let phase = pulse.step_s / sensor.filter_s;
        let decay = low_pass::decay(pulse.damping, phase);
        let force = |i: usize| course.force(rig, (i as f64 * pulse.step_s).min(duration));
        let mut now = ([0.0; 2], force(0));
        pulse.states.push(now);
        for i in 1..=count as usize {
            let next = force(i);
            let state = low_pass::advance(pulse.damping, phase, &decay, now.0, now.1, next);
            now = (state, next);
            pulse.states.push(now);
        }
        pulse
    }

    /// The filtered force `t` s after the onset, N.
    fn force(&self, t: f64) -> f64 {
        if t < 0.0 {
            return 0.0;
        }
        if self.states.is_empty() {
            return self.course.force(self.rig, t);
        }
        let last = self.states.len() - 1;
        let at = ((t / self.step_s) as usize).min(last);
        let (state, from) = self.states[at];
        let rest = t - at as f64 * self.step_s;
        let phase = rest / self.filter_s;
        if phase < 1e-9 {
            return state[0];
        }
        let decay = low_pass::decay(self.damping, phase);
        if at == last {
            // After the release the force is 0.
            return low_pass::advance(self.damping, phase, &decay, state, 0.0, 0.0)[0];
        }
        let to = from + (self.states[at + 1].1 - from) * rest / self.step_s;
        low_pass::advance(self.damping, phase, &decay, state, from, to)[0]
    }

    /// The filtered ringing `t` s after the onset, N.
    fn ringing(&self, swing: &Swing, t: f64) -> f64 {
        let contact = &self.course.contact;
        let since = t - (contact.peak_at_s - contact.onset_s);
        if since < 0.0 || since > 40.0 * swing.decay_s {
            return 0.0;
        }
        let (rate, turn) = (-1.0 / swing.decay_s, TAU * swing.hz);
        let size = (rate * since).exp();
        let (sin, cos) = (turn * since).sin_cos();
        let mut shown = [size * cos, size * sin];
        if self.filter_s > 0.0 {
            // An exponential input exp(λt) passes with H(λ) = 1/(μ² + 2ζμ + 1), μ = λ/ωc, and the state (1, μ)H decays.
            let mu = [rate * self.filter_s, turn * self.filter_s];
            let square = times(mu, mu);
            let under = [
                square[0] + 2.0 * self.damping * mu[0] + 1.0,
                square[1] + 2.0 * self.damping * mu[1],
            ];
            let norm = under[0] * under[0] + under[1] * under[1];
            let passed = [under[0] / norm, -under[1] / norm];
            let [first, _] = low_pass::decay(self.damping, since / self.filter_s);
            let left = [
                shown[0] - first[0] - first[1] * mu[0],
                shown[1] - first[1] * mu[1],
            ];
            shown = times(passed, left);
        }
        contact.peak_force_n * (swing.cos * shown[0] + swing.sin * shown[1])
    }

    /// What `sensor` shows `t` s after the onset, N.
    pub fn shown(&self, sensor: &Sensor, t: f64) -> f64 {
        let ringing = sensor.swing.map_or(0.0, |swing| self.ringing(&swing, t));
        sensor.gain * (self.force(t) + ringing) + sensor.offset_n
    }
}

fn times(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0] * b[0] - a[1] * b[1], a[0] * b[1] + a[1] * b[0]]
}
