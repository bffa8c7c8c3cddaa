//! The rigs the real one may be: every corner of the stated uncertainty, and seeded samples inside it.

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::Serialize;

use crate::error::Error;
use crate::range::within_samples;

mod member;
#[cfg(test)]
mod tests;

pub use member::Member;

/// Half-widths of what is not known exactly.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Uncertainty {
    /// Natural frequency, % either way (wires: through their length).
    pub natural_frequency_percent: f64,
    /// Cart amplitude, % either way.
    pub amplitude_percent: f64,
    /// Contact stiffness, % either way.
    pub contact_stiffness_percent: f64,
    /// In its place a factor: the stiffness is up to so many times as large, or as small.
    pub contact_stiffness_factor: Option<f64>,
    /// Contact damping, % either way, whatever the stiffness.
    pub contact_damping_percent: f64,
    /// In its place the contact's damping ratio, % either way: the damping then goes with the square root of the stiffness.
    /// A law whose damping has no scale (λ, or a restitution) keeps it at another stiffness as it is.
    pub contact_damping_ratio_percent: Option<f64>,
    /// Gap, mm either way.
    pub gap_mm: f64,
    /// Samples inside the corners.
    pub samples: u32,
    /// Seed of the samples.
    pub seed: u64,
    /// Hammer mass at the same natural frequency, % either way.
    pub mass_percent: f64,
    /// Cart mass at the same loop frequency, % either way (a cart that recoils).
    pub cart_mass_percent: f64,
    /// Natural frequency of the shaker's position loop, % either way (a cart that recoils).
    pub shaker_loop_percent: f64,
    /// Damping ratio of that loop, % either way (a cart that recoils).
    pub shaker_damping_percent: f64,
}

/// What is said of a rig's uncertainty, for example in its file; `None` where nothing is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Stated {
    /// Natural frequency, % either way (wires: through their length).
    pub natural_frequency_percent: Option<f64>,
    /// Cart amplitude, % either way.
    pub amplitude_percent: Option<f64>,
    /// Contact stiffness, % either way.
    pub contact_stiffness_percent: Option<f64>,
    /// Contact stiffness as a factor: up to so many times as large, or as small; in place of the %.
    pub contact_stiffness_factor: Option<f64>,
    /// Contact damping, % either way, whatever the stiffness.
    pub contact_damping_percent: Option<f64>,
    /// The contact's damping ratio, % either way; in place of the damping.
    pub contact_damping_ratio_percent: Option<f64>,
    /// Gap, mm either way.
    pub gap_mm: Option<f64>,
    /// Hammer mass at the same natural frequency, % either way.
    pub mass_percent: Option<f64>,
    /// Cart mass at the same loop frequency, % either way (a cart that recoils).
    pub cart_mass_percent: Option<f64>,
    /// Natural frequency of the shaker's position loop, % either way (a cart that recoils).
    pub shaker_loop_percent: Option<f64>,
    /// Damping ratio of the shaker's position loop, % either way (a cart that recoils).
    pub shaker_damping_percent: Option<f64>,
}

impl Uncertainty {
    /// Refuses more samples than a pick can take.
    ///
    /// # Errors
    /// If there are too many.
    pub fn check(&self) -> Result<(), Error> {
        within_samples(self.samples, 100_000)
    }
}

impl Stated {
    /// What is stated here, else what is stated in `other`. The two ways to state the contact's stiffness, or its damping, take
    /// each other's place.
    #[must_use]
    pub fn or(&self, other: &Self) -> Self {
        let damping =
            self.contact_damping_percent.is_some() || self.contact_damping_ratio_percent.is_some();
        let of_damping = if damping { self } else { other };
        let stiffness =
            self.contact_stiffness_percent.is_some() || self.contact_stiffness_factor.is_some();
        let of_stiffness = if stiffness { self } else { other };
        Self {
            natural_frequency_percent: self
                .natural_frequency_percent
                .or(other.natural_frequency_percent),
            amplitude_percent: self.amplitude_percent.or(other.amplitude_percent),
            contact_stiffness_percent: of_stiffness.contact_stiffness_percent,
            contact_stiffness_factor: of_stiffness.contact_stiffness_factor,
            contact_damping_percent: of_damping.contact_damping_percent,
            contact_damping_ratio_percent: of_damping.contact_damping_ratio_percent,
            gap_mm: self.gap_mm.or(other.gap_mm),
            mass_percent: self.mass_percent.or(other.mass_percent),
            cart_mass_percent: self.cart_mass_percent.or(other.cart_mass_percent),
            shaker_loop_percent: self.shaker_loop_percent.or(other.shaker_loop_percent),
            shaker_damping_percent: self.shaker_damping_percent.or(other.shaker_damping_percent),
        }
    }

    /// The uncertainty of a rig whose cart recoils or not: what is stated, else the usual widths. What only a cart that
    /// recoils feels has no width for one that does not.
    pub fn complete(&self, samples: u32, seed: u64, recoils: bool) -> Uncertainty {
        let of_recoil = |stated: Option<f64>| stated.filter(|_| recoils);
        let replaced = |by: Option<f64>| by.map(|_| 0.0);
        let stiffness = replaced(self.contact_stiffness_factor).or(self.contact_stiffness_percent);
        let damping = replaced(self.contact_damping_ratio_percent).or(self.contact_damping_percent);
        let mut all = Uncertainty {
            contact_stiffness_factor: self.contact_stiffness_factor,
            contact_damping_ratio_percent: self.contact_damping_ratio_percent,
            samples,
            seed,
            ..Uncertainty::usual(recoils)
        };
        for (width, stated) in [
            (
                &mut all.natural_frequency_percent,
                self.natural_frequency_percent,
            ),
            (&mut all.amplitude_percent, self.amplitude_percent),
            (&mut all.contact_stiffness_percent, stiffness),
            (&mut all.contact_damping_percent, damping),
            (&mut all.gap_mm, self.gap_mm),
            (&mut all.mass_percent, self.mass_percent),
            (
                &mut all.cart_mass_percent,
                of_recoil(self.cart_mass_percent),
            ),
            (
                &mut all.shaker_loop_percent,
                of_recoil(self.shaker_loop_percent),
            ),
            (
                &mut all.shaker_damping_percent,
                of_recoil(self.shaker_damping_percent),
            ),
        ] {
            *width = stated.unwrap_or(*width);
        }
        all
    }
}

impl Default for Uncertainty {
    /// Of a cart moved as prescribed.
    fn default() -> Self {
        Self {
            natural_frequency_percent: 2.0,
            amplitude_percent: 5.0,
            contact_stiffness_percent: 20.0,
            contact_stiffness_factor: None,
            contact_damping_percent: 20.0,
            contact_damping_ratio_percent: None,
            gap_mm: 0.05,
            samples: 256,
            seed: 1,
            mass_percent: 0.0,
            cart_mass_percent: 0.0,
            shaker_loop_percent: 0.0,
            shaker_damping_percent: 0.0,
        }
    }
}

/// Dimensions of the uncertainty.
const DIMENSIONS: usize = 9;
/// This dimension, the hammer's mass, moves with the next, the cart's, in the corners: it is weighed to little, and a corner
/// of its own would double their number. In the samples they move by themselves.
const WITH_THE_NEXT: usize = 5;
/// Where more axes than this are open, the corners are a fraction of all: so many axes freely, and each of the others on
/// the side that [`GENERATORS`] say.
const FREE: usize = 6;
/// The free axes whose sides multiply to that of the first and of the second axis beyond them. With two, this is the design
/// 2^(8−2) of resolution V of the textbooks (Box, Hunter and Hunter, Statistics for Experimenters; NIST/SEMATECH e-Handbook
/// of Statistical Methods, 5.3.3.4): every side of any four axes meets every side of the others' four, and the first five
/// axes have all their corners.
const GENERATORS: [&[usize]; 2] = [&[0, 1, 2, 3], &[0, 1, 4, 5]];

impl Uncertainty {
    /// The usual widths, of a cart that recoils or not.
    pub fn usual(recoils: bool) -> Self {
        let prescribed = Self::default();
        if !recoils {
            return prescribed;
        }
        Self {
            cart_mass_percent: 5.0,
            shaker_loop_percent: 30.0,
            shaker_damping_percent: 30.0,
            ..prescribed
        }
    }

    /// The half-widths of the deviations of a [`Member`].
    fn half_widths(&self) -> [f64; DIMENSIONS] {
        let damping = self.contact_damping_ratio_percent;
        let stiffness = match self.contact_stiffness_factor {
            Some(factor) => factor.ln(),
            None => self.contact_stiffness_percent / 100.0,
        };
        [
            self.natural_frequency_percent / 100.0,
            self.amplitude_percent / 100.0,
            stiffness,
            damping.unwrap_or(self.contact_damping_percent) / 100.0,
            self.gap_mm / 1e3,
            self.mass_percent / 100.0,
            self.cart_mass_percent / 100.0,
            self.shaker_loop_percent / 100.0,
            self.shaker_damping_percent / 100.0,
        ]
    }

    /// The dimensions that have a width, those that move together in the corners as one.
    fn axes(&self) -> Vec<Vec<usize>> {
        let widths = self.half_widths();
        let mut axes: Vec<Vec<usize>> = Vec::new();
        for i in (0..DIMENSIONS).filter(|i| widths[*i] != 0.0) {
            match axes.last_mut() {
                Some(last) if *last == [WITH_THE_NEXT] && i == WITH_THE_NEXT + 1 => last.push(i),
                _ => axes.push(vec![i]),
            }
        }
        axes
    }

    /// How many of the members are corners: all of them up to six dimensions, else a quarter or half.
    fn corner_count(&self) -> usize {
        match self.axes().len() {
            0 => 0,
            axes => 1 << axes.min(FREE),
        }
    }

    /// The corners of the dimensions that have a width: all of them for up to six, else a fraction.
    pub fn corners(&self) -> Vec<Member> {
        self.members()
            .into_iter()
            .take(self.corner_count())
            .collect()
    }

    /// Every member: the corners, then the samples inside them.
    pub fn members(&self) -> Vec<Member> {
        let widths = self.half_widths();
        let axes = self.axes();
        if axes.is_empty() {
            return Vec::new();
        }
        let corner = |bits: usize| {
            let side = |axis: usize| if bits >> axis & 1 == 0 { -1.0 } else { 1.0 };
            let mut deviation = [0.0; DIMENSIONS];
            for (axis, dimensions) in axes.iter().enumerate() {
                let side = match axis.checked_sub(FREE) {
                    None => side(axis),
                    Some(beyond) => GENERATORS[beyond].iter().map(|free| side(*free)).product(),
                };
                for i in dimensions {
                    deviation[*i] = side;
                }
            }
            deviation
        };
        let mut random = ChaCha8Rng::seed_from_u64(self.seed);
        let corners = (0..self.corner_count()).map(corner);
        let samples = (0..self.samples).map(|_| {
            let mut deviation = [0.0; DIMENSIONS];
            for i in axes.iter().flatten() {
                deviation[*i] = random.random_range(-1.0..=1.0);
            }
            deviation
        });
        let member = |d: [f64; DIMENSIONS]| Member {
            deviations: std::array::from_fn(|i| d[i] * widths[i]),
            stiffness_factor: self.contact_stiffness_factor.is_some(),
            damping_ratio: self.contact_damping_ratio_percent.is_some(),
        };
        corners.chain(samples).map(member).collect()
    }
}
