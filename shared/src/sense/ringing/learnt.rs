//! What contacts have shown of the surface's ringing: means over them, in which noise is small.

use nalgebra::Complex;

use super::sine::{TAIL, exp, pole, products};
use super::{FEW, MOST};

/// Contacts in the means.
const RINGING_MEMORY: f32 = 128.0;
/// And in that of the amplitude.
const AMPLITUDE_MEMORY: f32 = 32.0;
/// Square of its distance from the mean amplitude, over the variance, from which on it is another ringing.
const OFF: f32 = 16.0;
/// How well it is known when a contact crossed its threshold, ticks.
const CROSSED: f32 = 0.05;
/// What is left of a tail without its ringing, over what was left of those before it (squares), if the surface does not ring as it did.
const OTHERWISE: f32 = 2.2;
/// Samples at either end of the tail that are compared.
const ENDS: usize = 16;
/// The first of them over the last (squares) from which on there is a ringing,
const LOUD: f32 = 1.7;
/// what noise leaves in their mean, over them (not squares), below which there is one,
const SURE: f32 = 0.5;
/// and over the contact's peak.
const QUIET: f32 = 1e-6;
/// Those of a surface whose ringing does not matter.
const SILENT: f32 = 1e-5;
/// True peak over what is read less 1, over the amplitude of the tails' first samples, where their pitch is not known: of a ringing that decays within 0.3 ms little
/// is left by then.
const GROWS: f32 = 5.0;
/// What the ringing found leaves of the first samples, over what it leaves of the last (squares), from which on it is not the only one.
const ANOTHER: f32 = 1.5;
/// The correlation of each sample that is left with the next, above which it is no noise behind the filter, of which it is a half.
const ALIKE: f32 = 0.7;

/// How the surface rings: means over the contacts, all over their peaks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Learnt {
    /// How many contacts are in them, up to [`RINGING_MEMORY`].
    contacts: f32,
    /// The tail: its noise is smaller by the root of that number.
    tail: [f32; TAIL],
    /// The ringing's complex amplitude at the crossing, and of how many contacts it is.
    amplitude: Complex<f32>,
    averaged: f32,
    /// Mean square of the tail's last samples.
    pub noise: f32,
    /// Contacts with a ringing, up to [`RINGING_MEMORY`].
    fitted: f32,
    /// What it leaves of the squares of the first, of the last and of all, and of the products of each with the next.
    left: [f32; 4],
}

impl Learnt {
    pub const NOTHING: Self = Self {
        contacts: 0.0,
        tail: [0.0; TAIL],
        amplitude: Complex::new(0.0, 0.0),
        averaged: 0.0,
        noise: 0.0,
        fitted: 0.0,
        left: [0.0; 4],
    };

    /// Takes in a tail, over its contact's peak.
    pub fn add(&mut self, tail: &[f32; TAIL]) {
        self.contacts = RINGING_MEMORY.min(self.contacts + 1.0);
        for (mean, new) in self.tail.iter_mut().zip(tail) {
            *mean += (new - *mean) / self.contacts;
        }
        let noise = products(tail, TAIL - ENDS, 0, ENDS) / ENDS as f32;
        self.noise += (noise - self.noise) / self.contacts;
    }

    /// Mean square of the mean tail's first and last samples.
    #[inline(never)]
    fn squares(&self) -> [f32; 2] {
        [0, TAIL - ENDS].map(|from| products(&self.tail, from, 0, ENDS) / ENDS as f32)
    }

    /// Whether the tails are louder at first than at last, and than their noise.
    pub fn rings(&self) -> bool {
        let [first, last] = self.squares();
        first > LOUD * last && first > QUIET && self.noise_share() < SURE
    }

    /// The ringing's pitch and decay, if the mean tail is a decaying sine.
    pub fn pole(&self) -> Option<Complex<f32>> {
        pole(&self.tail)
    }

    /// What noise leaves in the mean tail over its first samples.
    pub fn noise_share(&self) -> f32 {
        let [first, _] = self.squares();
        libm::sqrtf(self.noise / (self.contacts * first))
    }

    /// True peak over what is read, at most, by how loud the tails are.
    pub fn most(&self) -> f32 {
        let [first, last] = self.squares();
        MOST.min(1.0 + GROWS * libm::sqrtf(2.0 * (first - last).max(0.0)))
    }

    /// Whether the tails are too quiet for a ringing that matters.
    pub fn is_silent(&self) -> bool {
        let [first, _] = self.squares();
        first < SILENT
    }

    /// The ringing's amplitude at the first sample of a tail, `crossed_before` after the crossing, of which it is `own` with a variance of
    /// `noise`; and the variance of that. Contacts scatter by more where the crossing is known less well than the ringing turns.
    pub fn amplitude(
        &mut self,
        own: Complex<f32>,
        noise: f32,
        pole: Complex<f32>,
        crossed_before: f32,
    ) -> (Complex<f32>, f32) {
        let mean = self.amplitude * exp(pole * crossed_before);
        let off = own - mean;
        let late = CROSSED * pole.im;
        let timing = late * late * own.norm_sqr();
        // A ringing that is suddenly another one is learnt anew.
        if off.norm_sqr() > OFF * (timing + noise) {
            self.averaged = 0.0;
        }
        self.averaged = AMPLITUDE_MEMORY.min(self.averaged + 1.0);
        let weight = 1.0 / self.averaged;
        self.amplitude += off * exp(pole * -crossed_before) * weight;
        let known = timing + weight * noise;
        let own_weight = weight.max(known / (known + noise));
        (mean + off * own_weight, own_weight * noise)
    }

    /// Takes in what the ringing leaves of a tail; whether it explains them.
    pub fn explains(&mut self, left: &[f32; TAIL]) -> bool {
        self.fitted = RINGING_MEMORY.min(self.fitted + 1.0);
        let new = [
            products(left, 0, 0, ENDS),
            products(left, TAIL - ENDS, 0, ENDS),
            products(left, 0, 0, TAIL - 1),
            products(left, 0, 1, TAIL - 1),
        ];
        for (mean, new) in self.left.iter_mut().zip(new) {
            *mean += (new - *mean) / self.fitted;
        }
        let [first, last, all, next] = self.left;
        (first < ANOTHER * last && next < ALIKE * all) || first < SILENT * ENDS as f32
    }

    /// Whether a contact rings otherwise, of whose tail `left` (mean square) is left without the ringing learnt.
    pub fn is_contradicted(&self, left: f32) -> bool {
        left * (TAIL - 1) as f32 > OTHERWISE * self.left[2] && self.fitted >= f32::from(FEW)
    }
}
