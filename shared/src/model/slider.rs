//! Ground that gives way: a massless slider held by dry friction, with a spring and a dashpot on top (after
//! Pavlovskaia, Wiercigroch and Grebogi, Physical Review E 64, 056224, 2001).
//!
//! The hammer strikes the slider's top. Spring k and dashpot c join the top to the slider's bottom, which the ground
//! holds with a dry friction of at most the threshold Pf. As long as the contact force k e + c ė is below Pf (e the
//! compression between top and bottom) the bottom stays where it is; at Pf it slips, and what it slips is progress that
//! is never given back. Once the hammer has left, the dashpot lets the top relax: c ė = −k e.
//!
//! # State
//! The compression e is bounded, and 0 soon after each contact. Where the bottom is, is not bounded: it drifts. The two
//! are kept apart. In contact the hammer's penetration, measured from the bottom (the *front* of the ground), is e, so
//! that a section with coordinates measured from the front repeats although the ground has gone.
//!
//! This is a type of its own and not a [`super::contact::Law`]: a law has no state, and the controller on the
//! microcontroller stores and sends laws; it neither knows nor needs a ground that gives way.

use serde::{Deserialize, Serialize};

use crate::model::number::{Allowed, ParamError, within};
use crate::model::scalar::{Compensated, Real};

/// Ground that gives way (SI: N, m, s).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Slider<R> {
    /// Stiffness k of the spring, N/m.
    pub stiffness: R,
    /// Damping c of the dashpot, N·s/m.
    pub damping: R,
    /// Pf, N: the contact force at which it gives way.
    pub threshold: R,
}

/// How hammer and ground touch.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Touch {
    /// Not at all: the slider's top relaxes.
    #[default]
    Apart,
    /// They touch, and the ground holds.
    Held,
    /// They touch, and the ground gives way at the threshold.
    Slipping,
}

const STIFFNESS: Allowed = Allowed(1e-3, 1e12, "a positive number from 0.001 to 1e12");
const DAMPING: Allowed = Allowed(0.0, 1e9, "a number from 0 to 1e9");
const THRESHOLD: Allowed = Allowed(1e-6, 1e12, "a positive number from 1e-6 to 1e12");

impl Slider<f64> {
    /// Checks every parameter.
    ///
    /// # Errors
    /// The first that is out of range.
    pub fn check(&self) -> Result<(), ParamError> {
        within("threshold_n", self.threshold, &THRESHOLD)?;
        within("ground_stiffness_n_per_m", self.stiffness, &STIFFNESS)?;
        within("ground_damping_n_s_per_m", self.damping, &DAMPING)
    }
}

impl<R: Real> Slider<R> {
    /// k/c, 1/s: how fast the top relaxes. 0 without a dashpot, where there is nothing to relax.
    #[inline]
    pub fn relaxation(&self) -> R {
        if self.damping > R::ZERO {
            self.stiffness / self.damping
        } else {
            R::ZERO
        }
    }

    /// k e + c ė at compression `e` and rate `speed`, N: the contact force while the ground holds. Below 0 the hammer
    /// leaves, above Pf the ground gives way.
    #[inline]
    pub fn held_force(&self, e: R, speed: R) -> R {
        self.stiffness * e + self.damping * speed
    }

    /// Contact force, N. `speed` is the hammer's speed into the ground, m/s.
    #[inline]
    pub fn force(&self, touch: Touch, e: R, speed: R) -> R {
        match touch {
            Touch::Apart => R::ZERO,
            Touch::Held => self.held_force(e, speed),
            Touch::Slipping => self.threshold,
        }
    }

    /// Rate ė of the compression, m/s.
    #[inline]
    pub fn compression_rate(&self, touch: Touch, e: R, speed: R) -> R {
        match touch {
            Touch::Apart => -(self.relaxation() * e),
            Touch::Held => speed,
            // k e + c ė = Pf.
            Touch::Slipping => self.relaxation() * (self.threshold / self.stiffness - e),
        }
    }

    /// How fast the front advances, m/s: never negative where `touch` is what [`Self::next`] says.
    #[inline]
    pub fn advance_rate(&self, touch: Touch, e: R, speed: R) -> R {
        match touch {
            Touch::Slipping => speed - self.compression_rate(touch, e, speed),
            _ => R::ZERO,
        }
    }

    /// What e tends to without an end of the phase, m: 0 while it relaxes, Pf/k while it slips. None in between,
    /// where e is the hammer's penetration.
    #[inline]
    pub fn compression_limit(&self, touch: Touch) -> Option<R> {
        match touch {
            Touch::Apart => Some(R::ZERO),
            Touch::Held => None,
            Touch::Slipping => Some(self.threshold / self.stiffness),
        }
    }

    /// How a hammer that has just met the top touches the ground.
    #[inline]
    pub fn at_onset(&self, e: R, speed: R) -> Touch {
        if self.held_force(e, speed) < self.threshold {
            Touch::Held
        } else {
            Touch::Slipping
        }
    }

    /// How they touch from here on, if they touched as `touch` until now. `penetration` is the hammer's, measured from
    /// the front, m.
    #[inline]
    pub fn next(&self, touch: Touch, penetration: R, e: R, speed: R) -> Touch {
        match touch {
            Touch::Apart if penetration < e => Touch::Apart,
            Touch::Apart => self.at_onset(e, speed),
            Touch::Held if self.held_force(e, speed) <= R::ZERO => Touch::Apart,
            Touch::Held => self.at_onset(e, speed),
            Touch::Slipping if self.advance_rate(touch, e, speed) > R::ZERO => Touch::Slipping,
            Touch::Slipping => Touch::Held,
        }
    }

    /// Power that the dashpot turns to heat, W.
    #[inline]
    pub fn dashpot_power(&self, touch: Touch, e: R, speed: R) -> R {
        let rate = self.compression_rate(touch, e, speed);
        self.damping * (rate * rate)
    }

    /// ½ k e², J.
    #[inline]
    pub fn stored_energy(&self, e: R) -> R {
        R::HALF * self.stiffness * (e * e)
    }

    /// This ground with its numbers converted to the scalar `T`.
    pub fn cast<T: Real>(&self) -> Slider<T> {
        let t = |x: R| T::from_f64(x.to_f64());
        Slider {
            stiffness: t(self.stiffness),
            damping: t(self.damping),
            threshold: t(self.threshold),
        }
    }
}

/// Ground that gives way, in steps of fixed length: its state beside that of the hammer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ground<R> {
    /// The ground's parameters.
    pub slider: Slider<R>,
    /// How it is touched.
    pub touch: Touch,
    /// Compression e between top and bottom of the slider, m.
    pub compression: R,
    /// How far the front is beyond its nominal place, m: what the blows have dug less what the feed has made up for.
    pub lead: R,
    /// Progress since the start, m. It grows without bound, so it is summed with compensation and nothing is ever
    /// computed from it.
    pub drift: Compensated<R>,
    /// What a step leaves of e above its limit: exp(−(k/c) h).
    decay: R,
}

impl<R: Real> Ground<R> {
    /// At rest, for steps of `step_s` (in contact and out of it).
    pub fn new(slider: &Slider<f64>, step_s: f64) -> Self {
        let relaxation = slider.relaxation();
        // Without a dashpot nothing is left over.
        let decay = if relaxation > 0.0 {
            libm::exp(-relaxation * step_s)
        } else {
            0.0
        };
        Self {
            slider: slider.cast(),
            touch: Touch::Apart,
            compression: R::ZERO,
            lead: R::ZERO,
            drift: Compensated::new(R::ZERO),
            decay: R::from_f64(decay),
        }
    }

    /// The force on a hammer that moves into the ground at `speed`, N.
    #[inline]
    pub fn force(&self, speed: R) -> R {
        self.slider.force(self.touch, self.compression, speed)
    }

    /// A step has ended with the hammer `past_nominal` beyond the front's nominal place (m) and moving at `speed` (m/s).
    /// Returns the progress of the step, m.
    ///
    /// While it slips, the force is Pf whatever the hammer does, and e goes its own way: what the hammer has moved beyond it
    /// is progress.
    pub fn step(&mut self, past_nominal: R, speed: R) -> R {
        let mut dug = R::ZERO;
        match self.slider.compression_limit(self.touch) {
            Some(limit) => {
                self.compression = limit + (self.compression - limit) * self.decay;
                if self.touch == Touch::Slipping {
                    dug = (past_nominal - self.compression - self.lead).max(R::ZERO);
                    self.lead += dug;
                    self.drift = self.drift.plus(dug);
                    self.compression = past_nominal - self.lead;
                }
            }
            None => self.compression = past_nominal - self.lead,
        }
        let penetration = past_nominal - self.lead;
        self.touch = self
            .slider
            .next(self.touch, penetration, self.compression, speed);
        if self.touch != Touch::Apart {
            self.compression = penetration;
        }
        dug
    }

    /// The feed moves the rig on by `by`, m.
    pub fn feed(&mut self, by: R) {
        self.lead += -by;
    }
}

#[cfg(test)]
mod tests;
