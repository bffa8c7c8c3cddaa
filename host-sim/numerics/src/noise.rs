//! Reproducible noise.

use rand::{RngCore, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Gaussian numbers of mean 0 and deviation 1, the same for the same seed (Marsaglia's polar method).
#[derive(Clone, Debug)]
pub struct Noise {
    random: ChaCha8Rng,
    spare: Option<f64>,
}

impl Noise {
    /// The sequence that belongs to `seed`.
    pub fn new(seed: u64) -> Self {
        Self {
            random: ChaCha8Rng::seed_from_u64(seed),
            spare: None,
        }
    }

    /// The next Gaussian number.
    #[inline]
    pub fn sample(&mut self) -> f64 {
        if let Some(spare) = self.spare.take() {
            return spare;
        }
        loop {
            let bits = self.random.next_u64();
            let unit = |half: u64| f64::from(half as u32 as i32) / 2_147_483_648.0;
            let (a, b) = (unit(bits), unit(bits >> 32));
            let square = a * a + b * b;
            if square > 0.0 && square < 1.0 {
                let size = (-2.0 * square.ln() / square).sqrt();
                self.spare = Some(size * b);
                return size * a;
            }
        }
    }

    /// An evenly distributed number from 0 to 1.
    pub fn even(&mut self) -> f64 {
        self.random.next_u64() as f64 / u64::MAX as f64
    }
}
