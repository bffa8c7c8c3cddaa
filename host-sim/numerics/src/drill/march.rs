//! Hammer and ground from drive phase 0 to drive phase 0.

use std::f64::consts::TAU;

use shared::model::bit::Bit;
use shared::model::contacts::Period;
use shared::model::params::{ParamError, RigParams};
use shared::model::slider::{Slider, Touch};

use super::blow::{Feed, GroundBlow};
use super::body::{Body, Carried, FreeMass, resting};
use super::flow::{DrillFlow, DrillPoint, Energies};
use super::run::DrillSetting;
use crate::flow::{Pace, Scalar, StepEnded};
use crate::reference::TOLERANCE;

/// Steps per period of the drive, at least.
const STEPS_PER_PERIOD: f64 = 24.0;

/// Longest step in contact, as a share of the shorter of √(m/k) and m/c.
const CONTACT_STEP: f64 = 0.2;

/// First step after a switch, as a share of the longest in contact.
const FIRST_STEP: f64 = 0.2;

/// Longest step of a bit that stands on the ground, in units of the time in which its fastest motion dies: beyond 6 the
/// integrator is not stable.
const RESTING_STEP: f64 = 3.0;

/// Steps after which a period is given up.
const MAX_STEPS_PER_PERIOD: u64 = 100_000;

/// What strikes and what is struck, driven at one frequency.
#[derive(Clone, Debug)]
pub struct Drill<R> {
    pub(super) body: Body<R>,
    pub(super) slider: Slider<R>,
    pub(super) bit: Option<Bit<R>>,
    feed: Feed,
    /// Speed of the feed now, m/s.
    speed: f64,
    pub(super) omega: f64,
    pub(super) period_s: f64,
    tolerance: f64,
    /// In flight, and in contact.
    longest: (f64, f64),
    /// While a bit stands on the ground and nothing strikes it.
    longest_resting: f64,
    pub(super) point: DrillPoint<R>,
    pub(super) touch: Touch,
    /// Whether hammer and bit touch.
    pub(super) struck: bool,
    pub(super) cycle: u64,
    pace: Pace,
    /// Progress since the start, m, and in the period under way.
    pub(super) drift: f64,
    pub(super) dug: R,
    pub(super) open: Option<GroundBlow>,
    /// When hammer and bit last parted, s since the start.
    pub(super) parted_s: f64,
    pub(super) onsets: [f64; 3],
    pub(super) energies: Energies,
    /// The largest force of the shaker's loop, N, where it is watched.
    pub(super) loop_force_n: Option<f64>,
}

impl<R: Scalar> Drill<R> {
    /// The hammer of `params` at rest on ground that gives way, in its cart (prescribed or recoiling, as `params` say) that
    /// is on its course, at drive phase 0. It strikes through a bit that stands on the ground where there is one.
    ///
    /// # Errors
    /// The first parameter out of range.
    ///
    /// # Panics
    /// If `frequency_hz` is not a positive number.
    pub fn through(
        params: &RigParams,
        setting: &DrillSetting,
        frequency_hz: f64,
    ) -> Result<Self, ParamError> {
        let slider = &setting.ground;
        slider.check()?;
        let rest = resting(params, slider)?;
        let body = Body::Hammer(Carried::new(params, TAU * frequency_hz)?);
        let fastest = frequency_hz.max(params.natural_frequency_hz());
        let mut drill = Self::new(body, slider, setting.feed, frequency_hz, fastest);
        if let Some(bit) = &setting.bit {
            drill = drill.with_bit(bit, slider)?;
        }
        drill.place([R::from_f64(rest), R::ZERO, R::ZERO]);
        Ok(drill)
    }

    /// The published drifting oscillator, touching the ground at rest less `gap`.
    ///
    /// # Errors
    /// The first parameter of the ground out of range.
    ///
    /// # Panics
    /// If `frequency_hz` is not a positive number.
    pub fn free(
        mass: FreeMass,
        gap: f64,
        slider: &Slider<f64>,
        frequency_hz: f64,
    ) -> Result<Self, ParamError> {
        slider.check()?;
        let body = Body::Free(mass);
        let mut drill = Self::new(body, slider, Feed::Cart, frequency_hz, frequency_hz);
        drill.place([R::from_f64(-gap), R::ZERO, R::ZERO]);
        Ok(drill)
    }

    /// This drill with a bit on the ground. It must be placed anew.
    ///
    /// # Errors
    /// The first parameter of the bit out of range.
    pub(super) fn with_bit(
        mut self,
        bit: &Bit<f64>,
        slider: &Slider<f64>,
    ) -> Result<Self, ParamError> {
        bit.check(slider)?;
        let fastest = |stiffness: f64, damping: f64| {
            // The root of m s² + c s + k that is farthest from 0.
            let (omega2, half) = (stiffness / bit.mass, 0.5 * damping / bit.mass);
            let beyond = half * half - omega2;
            if beyond > 0.0 {
                half + beyond.sqrt()
            } else {
                omega2.sqrt()
            }
        };
        let struck = fastest(
            slider.stiffness + bit.stiffness,
            slider.damping + bit.damping,
        );
        self.longest.1 = self.longest.1.min(CONTACT_STEP / struck);
        self.longest_resting = RESTING_STEP / fastest(slider.stiffness, slider.damping);
        self.pace = Pace::new(FIRST_STEP * self.longest.1);
        self.bit = Some(bit.cast());
        Ok(self)
    }

    fn new(
        body: Body<R>,
        slider: &Slider<f64>,
        feed: Feed,
        frequency_hz: f64,
        fastest_hz: f64,
    ) -> Self {
        assert!(frequency_hz > 0.0 && frequency_hz.is_finite());
        let mass = body.mass();
        let damped = mass / slider.damping.max(f64::MIN_POSITIVE);
        let in_contact = CONTACT_STEP * (mass / slider.stiffness).sqrt().min(damped);
        let at = body.place(R::ZERO, R::ZERO);
        Self {
            body,
            slider: slider.cast(),
            bit: None,
            feed,
            speed: match feed {
                Feed::Speed(speed) => speed,
                _ => 0.0,
            },
            omega: TAU * frequency_hz,
            period_s: 1.0 / frequency_hz,
            tolerance: TOLERANCE,
            longest: (1.0 / (STEPS_PER_PERIOD * fastest_hz), in_contact),
            longest_resting: f64::INFINITY,
            point: DrillPoint {
                t: R::ZERO,
                q: R::ZERO,
                v: R::ZERO,
                e: R::ZERO,
                lead: R::ZERO,
                cart: [R::ZERO; 2],
                bit: [R::ZERO; 2],
                at,
            },
            touch: Touch::Apart,
            struck: false,
            cycle: 0,
            pace: Pace::new(FIRST_STEP * in_contact),
            drift: 0.0,
            dug: R::ZERO,
            open: None,
            parted_s: f64::NEG_INFINITY,
            onsets: [f64::NEG_INFINITY; 3],
            energies: Energies::default(),
            loop_force_n: None,
        }
    }

    /// This drill with errors per step below this share of the amplitude.
    #[must_use]
    pub fn with_tolerance(mut self, tolerance: f64) -> Self {
        self.tolerance = tolerance;
        self
    }

    pub(super) fn flow(&self) -> DrillFlow<'_, R> {
        DrillFlow {
            body: &self.body,
            slider: &self.slider,
            bit: self.bit.as_ref(),
            touch: self.touch,
            struck: self.struck,
            omega: self.omega,
            feed: self.speed,
            units: {
                let [q, v, length, speed] = self.all_units();
                [q, v, length, speed, length, speed].map(|unit| unit * self.tolerance)
            },
        }
    }

    /// Runs to the next drive phase 0; finished contacts go to `blows`. Returns what happened, and the progress (m). If
    /// the motion cannot be followed, the state becomes NaN.
    pub fn run_period(&mut self, blows: &mut Vec<GroundBlow>) -> (Period<f64>, R) {
        let mut period = Period {
            touched: self.hammer_touches(),
            ..Period::default()
        };
        self.dug = R::ZERO;
        let mut pace = self.pace;
        let most = pace.tried + MAX_STEPS_PER_PERIOD;
        while let Some((step, ended)) = {
            let (stop, longest) = (self.period_s, self.longest_now());
            pace.advance(&self.flow(), &self.point, stop, longest, most)
        } {
            self.accept(&step, &mut period);
            match ended {
                StepEnded::Switched(exit) => self.switch(exit, &mut period, blows),
                StepEnded::Within | StepEnded::AtStop => self.close_blow(blows),
            }
            if ended == StepEnded::AtStop {
                self.pace = pace;
                self.end_period();
                return (period, self.dug);
            }
        }
        let nowhere = R::from_f64(f64::NAN);
        self.point.q = nowhere;
        self.point.t = R::ZERO;
        (period, nowhere)
    }

    fn end_period(&mut self) {
        self.cycle += 1;
        self.point.t = R::ZERO;
        let p = &mut self.point;
        match self.feed {
            Feed::Cart => {
                (p.q, p.v) = self.body.drawn_back(p.q, p.v, p.lead);
                p.at = self.body.place(p.q, p.v);
                self.ground_comes_back();
            }
            // The ground must not come to where the hammer is.
            Feed::Ground => {
                let top = if self.bit.is_some() {
                    p.bit[0] - p.lead
                } else {
                    p.e
                };
                if !self.hammer_touches() && self.point.at.depth < top {
                    self.ground_comes_back();
                }
            }
            Feed::Steady => self.speed = self.dug.to_f64() / self.period_s,
            Feed::Speed(_) => {}
        }
        if self.feed == Feed::Steady && !self.hammer_touches() {
            // What the speed of the last period was short of.
            self.ground_comes_back();
        }
    }

    /// To its nominal place, with the bit on it.
    fn ground_comes_back(&mut self) {
        let p = &mut self.point;
        if self.bit.is_some() {
            p.bit[0] -= p.lead;
        }
        p.lead = R::ZERO;
    }

    fn longest_now(&self) -> f64 {
        if self.hammer_touches() {
            return self.longest.1;
        }
        if self.touch != Touch::Apart {
            return self.longest.0.min(self.longest_resting);
        }
        // While the top still comes back close to what left it, no hop must be stepped over.
        let e = self.point.e.to_f64();
        let deep = match self.bit {
            Some(_) => self.point.bit[0].to_f64(),
            None => self.depth().0,
        };
        let away = self.point.lead.to_f64() + e - deep;
        if away < 20.0 * e {
            let relaxation = self.slider.relaxation().to_f64();
            return self.longest.0.min(0.25 / relaxation);
        }
        self.longest.0
    }
}
