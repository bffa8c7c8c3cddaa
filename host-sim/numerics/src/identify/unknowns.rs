//! What is sought, where it is sought, and where the searches begin.

use shared::model::contact::{Law, LawKind};
use shared::model::number::Number;
use shared::model::params::RigParams;
use shared::model::rig::Rig;

use super::SearchSettings;
use super::contacts::{Impact, MeasuredImpacts};
use crate::drop_test::impacts;
use crate::error::{DropTestError, Error};

/// The exponent of the nonlinear laws where it is not sought: Hertz's for curved bodies.
const EXPONENT: f64 = 1.5;

/// ki and the damping are sought from a thousandth to a thousand times their first guess.
const DECADES: f64 = 3.0;

/// One parameter that is sought.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unknown {
    /// As rig files name it, or `release_mm`.
    pub key: &'static str,
    log: bool,
    /// Range, in coordinates of the search.
    pub range: (f64, f64),
    guess: f64,
    /// A step of the search.
    pub step: f64,
}

impl Unknown {
    /// The parameter at a coordinate, in the unit of its key.
    pub fn value(&self, x: f64) -> f64 {
        if self.log { x.exp() } else { x }
    }
}

/// All that is sought.
#[derive(Clone, Debug, PartialEq)]
pub struct Unknowns {
    family: LawKind,
    list: Vec<Unknown>,
    release_m: f64,
    seek_release: bool,
}

/// A first guess of the contact from the first impact.
struct Guess {
    mass_kg: f64,
    /// Speed of the hammer at the first onset, m/s.
    speed: f64,
    /// Rebound speed over approach speed.
    restitution: f64,
    peak_n: f64,
    /// Peak over momentum, 1/s: about the contact's natural frequency.
    omega: f64,
}

impl Guess {
    fn new(impact: &Impact, mass_kg: f64, speed: f64) -> Self {
        let momentum = mass_kg * speed;
        Self {
            mass_kg,
            speed,
            restitution: (impact.impulse_n_s / momentum - 1.0).clamp(0.05, 0.95),
            peak_n: impact.peak_n,
            omega: impact.peak_n / momentum,
        }
    }

    /// The parameters of `family`, its exponent apart.
    fn unknowns(&self, family: LawKind) -> Vec<Unknown> {
        let linear = !has_exponent(family);
        let unknown = |number: Number| self.unknown(number, linear);
        family.without_exponent().map(unknown).collect()
    }

    fn unknown(&self, number: Number, linear: bool) -> Unknown {
        let key = number.key;
        let (omega, restitution) = (self.omega, self.restitution);
        match key {
            "contact_stiffness_n_per_m" if linear => {
                log(key, self.mass_kg * omega * omega, DECADES)
            }
            "contact_stiffness_n_per_m" => {
                let deepest = self.speed / omega;
                log(key, self.peak_n / deepest.powf(EXPONENT), DECADES)
            }
            "contact_damping_n_s_per_m" => {
                // Peak ≈ m v ω₀, and e = exp(−2ζφ/√(1 − ζ²)), near enough e^(−2.4 ζ).
                let zeta = -restitution.ln() / 2.4;
                log(key, 2.0 * zeta * self.mass_kg * omega, DECADES)
            }
            "contact_damping_ratio_s_per_m" => {
                let lambda = 1.5 * (1.0 - restitution) / (restitution * self.speed);
                log(key, lambda, DECADES)
            }
            _ => plain(key, restitution.min(0.9), (number.range().0, 0.999), 0.1),
        }
    }
}

fn has_exponent(family: LawKind) -> bool {
    family.numbers().len() > family.without_exponent().count()
}

/// A parameter searched for by its logarithm, up to `up` decades above the guess.
fn log(key: &'static str, guess: f64, up: f64) -> Unknown {
    Unknown {
        key,
        log: true,
        range: (
            guess.ln() - DECADES * std::f64::consts::LN_10,
            guess.ln() + up * std::f64::consts::LN_10,
        ),
        guess: guess.ln(),
        step: 0.3,
    }
}

/// A parameter searched for by its value.
fn plain(key: &'static str, guess: f64, range: (f64, f64), step: f64) -> Unknown {
    Unknown {
        key,
        log: false,
        range,
        guess,
        step,
    }
}

impl Unknowns {
    /// What `settings` ask for, with first guesses from the record: the impulse gives the restitution, peak and
    /// impulse the stiffness.
    ///
    /// # Errors
    /// If the release is out of range, or the hammer released there has no contact.
    pub fn new(
        measured: &MeasuredImpacts,
        params: &RigParams,
        family: LawKind,
        settings: &SearchSettings,
    ) -> Result<Self, Error> {
        let rig = Rig::<f64>::new(params)?;
        let first = impacts(params, &rig, settings.release_m, 1)?;
        let Some(first) = first.first() else {
            return Err(DropTestError::NoContactAt {
                release_m: settings.release_m,
            }
            .into());
        };
        let guess = Guess::new(
            &measured.impacts[0],
            params.mass_kg,
            first.contact.approach_speed_m_per_s,
        );
        let mut list = guess.unknowns(family);
        let seek_exponent = settings.seek_exponent && has_exponent(family);
        if seek_exponent {
            list.push(plain("contact_exponent", EXPONENT, (1.0, 3.0), 0.1));
        }
        if settings.seek_release {
            let mm = settings.release_m * 1e3;
            let (a, b) = (0.5 * mm, 1.5 * mm);
            list.push(plain(
                "release_mm",
                mm,
                (a.min(b), a.max(b)),
                0.05 * mm.abs(),
            ));
        }
        Ok(Self {
            family,
            list,
            release_m: settings.release_m,
            seek_release: settings.seek_release,
        })
    }

    /// The parameters that are sought.
    pub fn list(&self) -> &[Unknown] {
        &self.list
    }

    /// Where the searches begin: the guess, a fifth and five times the stiffness, a third and three times the
    /// damping, and all of these together.
    pub fn starts(&self) -> Vec<Vec<f64>> {
        let guess: Vec<f64> = self.list.iter().map(|u| u.guess).collect();
        let damped = self.family.is_lossy();
        let second = if damped {
            vec![0.0, -1.0, 1.0]
        } else {
            vec![0.0]
        };
        let mut starts = Vec::new();
        for a in [0.0, -1.0, 1.0] {
            for b in &second {
                let mut x = guess.clone();
                x[0] += a * 5.0_f64.ln();
                if damped {
                    let by = if self.list[1].log { 3.0_f64.ln() } else { 0.3 };
                    let range = self.list[1].range;
                    x[1] = (x[1] + b * by).clamp(range.0 + 0.01, range.1 - 0.05);
                }
                starts.push(x);
            }
        }
        starts
    }

    /// Law and release (m) at a point of the search; none outside the ranges.
    pub fn read(&self, x: &[f64]) -> Option<(Law<f64>, f64)> {
        let inside = |(u, x): (&Unknown, &f64)| *x >= u.range.0 && *x <= u.range.1;
        if !self.list.iter().zip(x).all(inside) {
            return None;
        }
        let mut law = self.family.preset();
        if let Some(exponent) = law.number_mut("contact_exponent") {
            *exponent = EXPONENT;
        }
        for (unknown, x) in self.list.iter().zip(x) {
            if let Some(number) = law.number_mut(unknown.key) {
                *number = unknown.value(*x);
            }
        }
        let release_m = if self.seek_release {
            let last = self.list.len() - 1;
            self.list[last].value(x[last]) * 1e-3
        } else {
            self.release_m
        };
        Some((law, release_m))
    }
}
