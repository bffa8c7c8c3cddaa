//! The whole force as residuals: samples, and what is known beforehand.

use nalgebra::DVector;

use super::{CLOCK, Contacts, FILTER, ForceShape, GAIN, OFFSET, RELEASE};
use crate::identify::least_squares::Problem;

impl ForceShape<'_> {
    /// What is known beforehand: value at `x`, expected, deviation.
    fn priors(&self, x: &[f64]) -> [(f64, f64, f64); 5] {
        let laws = self.laws();
        // In a clean record the zero is known to rounding.
        let zero = self
            .measured
            .offset_deviation_n
            .max(1e-3 * self.deviation_n);
        let shape = x[laws + self.ringing_at() - 1];
        let (usual, deviation) = self.model.known();
        [
            (x[laws + RELEASE], 1.0, self.release_deviation()),
            (self.gain(x), 1.0, self.gain_deviation()),
            (x[laws + OFFSET], 0.0, zero),
            (
                x[laws + CLOCK],
                1.0,
                0.01 * self.settings.clock_percent.max(1e-7),
            ),
            (shape, usual, deviation),
        ]
    }

    fn gather(&self, x: &[f64], shown: &[Vec<f64>]) -> DVector<f64> {
        let per = 1.0 / self.deviation_n;
        let mut all = Vec::with_capacity(self.data() + 5);
        for (window, shown) in self.windows.iter().zip(shown) {
            let forces = &self.measured.force_n[window.clone()];
            all.extend(forces.iter().zip(shown).map(|(f, s)| (s - f) * per));
        }
        all.extend(
            self.priors(x)
                .map(|(value, mean, deviation)| (value - mean) / deviation),
        );
        DVector::from_vec(all)
    }

    /// How far a coordinate is moved for its derivative.
    fn nudge(&self, x: &[f64], k: usize) -> f64 {
        let laws = self.laws();
        let size = if k < laws {
            1e-5 * self.unknowns.list()[k].step.abs().max(0.1)
        } else if k >= self.first_onset() {
            1e-4
        } else {
            match k - laws {
                RELEASE | GAIN | CLOCK => 1e-6,
                OFFSET => 1e-3 * self.deviation_n,
                FILTER => 1e-3,
                j if j < self.ringing_at() => 1e-4,
                _ => 1e-5,
            }
        };
        let (low, high) = self.range(x, k);
        if x[k] + size > high && x[k] - size >= low {
            -size
        } else {
            size
        }
    }
}

impl Problem for ForceShape<'_> {
    type Seen = (Contacts, Vec<Vec<f64>>);

    fn residuals(&self, x: &[f64]) -> Option<(DVector<f64>, Self::Seen)> {
        let contacts = self.contacts(x)?;
        let shown = self.shown(x, &contacts);
        let all = self.gather(x, &shown);
        all.iter()
            .all(|r| r.is_finite())
            .then_some((all, (contacts, shown)))
    }

    fn column(&self, x: &[f64], at: &(DVector<f64>, Self::Seen), k: usize) -> Option<DVector<f64>> {
        let (here, (contacts, shown)) = at;
        let by = self.nudge(x, k);
        let mut moved = x.to_vec();
        moved[k] += by;
        let there = if k <= self.laws() + RELEASE {
            let contacts = self.contacts(&moved)?;
            self.shown(&moved, &contacts)
        } else if k >= self.first_onset() {
            let mut there = shown.clone();
            let i = k - self.first_onset();
            there[i] = self.shown_impact(&moved, contacts, i);
            there
        } else {
            self.shown(&moved, contacts)
        };
        Some((self.gather(&moved, &there) - here) / by)
    }

    fn range(&self, x: &[f64], k: usize) -> (f64, f64) {
        let laws = self.laws();
        if k < laws {
            return self.unknowns.list()[k].range;
        }
        if k >= self.first_onset() {
            let i = k - self.first_onset();
            let before = (self.measured.impacts[i].first - self.windows[i].start) as f64;
            if !self.jumps(x) {
                return (-before, self.latest(x));
            }
            let low = x[k].floor();
            return (low + 1e-3, low + 0.999);
        }
        match k - laws {
            RELEASE | GAIN | CLOCK => (0.2, 5.0),
            OFFSET => (f64::NEG_INFINITY, f64::INFINITY),
            j if j < self.ringing_at() => {
                let widest = self.measured.impacts[0].window.len() as f64;
                self.model.range(j - FILTER, widest)
            }
            j => match (j - self.ringing_at(), self.ringing) {
                (2, Some(guess)) => (guess.hz.ln() - 0.3, guess.hz.ln() + 0.3),
                (3, Some(guess)) => (guess.decay_s.ln() - 2.0, guess.decay_s.ln() + 2.0),
                _ => (-10.0, 10.0),
            },
        }
    }
}
