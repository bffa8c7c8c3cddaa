//! Hammer and ground from drive phase 0 to drive phase 0.

use std::f64::consts::TAU;

use shared::model::contacts::{Period, SUSTAINED_CONTACT_S};
use shared::model::params::{ParamError, RigParams};
use shared::model::slider::{Slider, Touch};

use super::blow::{Blow, Feed};
use super::body::{Body, Carried, FreeMass, resting};
use super::exits::Exit;
use super::flow::{Energies, Field, Point, Step};
use crate::golden::maximum;
use crate::reference::{Scalar, TOLERANCE, tableau};

/// Steps per period of the drive, at least.
const STEPS_PER_PERIOD: f64 = 24.0;

/// Longest step in contact, as a share of the shorter of √(m/k) and m/c.
const CONTACT_STEP: f64 = 0.2;

/// First step after a switch, as a share of the longest in contact.
const FIRST_STEP: f64 = 0.2;

/// Steps after which a period is given up.
const MAX_STEPS_PER_PERIOD: usize = 100_000;

/// What strikes and what is struck, driven at one frequency.
#[derive(Clone, Debug)]
pub struct Drill<R> {
    pub(super) body: Body<R>,
    slider: Slider<R>,
    feed: Feed,
    /// Speed of the feed now, m/s.
    speed: f64,
    pub(super) omega: f64,
    period_s: f64,
    tolerance: f64,
    longest: (f64, f64),
    pub(super) point: Point<R>,
    touch: Touch,
    cycle: u64,
    next_step: f64,
    /// Progress since the start, m, and in the period under way.
    drift: f64,
    dug: R,
    open: Option<Blow>,
    onsets: [f64; 3],
    energies: Energies,
    /// The largest force of the shaker's loop, N, where it is watched.
    pub(super) loop_force_n: Option<f64>,
}

impl<R: Scalar> Drill<R> {
    /// The hammer of `params` at rest on ground that gives way, in its cart (prescribed or recoiling, as `params` say) that
    /// is on its course, at drive phase 0.
    ///
    /// # Errors
    /// The first parameter out of range.
    ///
    /// # Panics
    /// If `frequency_hz` is not a positive number.
    pub fn hammer(
        params: &RigParams,
        slider: &Slider<f64>,
        feed: Feed,
        frequency_hz: f64,
    ) -> Result<Self, ParamError> {
        slider.check()?;
        let rest = resting(params, slider)?;
        let body = Body::Hammer(Carried::new(params, TAU * frequency_hz)?);
        let fastest = frequency_hz.max(params.natural_frequency_hz());
        let mut drill = Self::new(body, slider, feed, frequency_hz, fastest);
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
        Self {
            body,
            slider: slider.cast(),
            feed,
            speed: match feed {
                Feed::Speed(speed) => speed,
                _ => 0.0,
            },
            omega: TAU * frequency_hz,
            period_s: 1.0 / frequency_hz,
            tolerance: TOLERANCE,
            longest: (1.0 / (STEPS_PER_PERIOD * fastest_hz), in_contact),
            point: Point {
                t: R::ZERO,
                q: R::ZERO,
                v: R::ZERO,
                e: R::ZERO,
                lead: R::ZERO,
                cart: [R::ZERO; 2],
            },
            touch: Touch::Apart,
            cycle: 0,
            next_step: FIRST_STEP * in_contact,
            drift: 0.0,
            dug: R::ZERO,
            open: None,
            onsets: [f64::NEG_INFINITY; 3],
            energies: Energies::default(),
            loop_force_n: None,
        }
    }

    /// The same with errors per step below this share of the amplitude.
    #[must_use]
    pub fn with_tolerance(mut self, tolerance: f64) -> Self {
        self.tolerance = tolerance;
        self
    }

    /// Puts it on the section at coordinate, rate and compression; where they touch, the compression follows from the
    /// coordinate. The cart is on its course.
    pub fn place(&mut self, section: [R; 3]) {
        self.place_off(section, [R::ZERO; 2]);
    }

    /// The same with a cart that recoils `cart` (m, m/s) off its course.
    pub fn place_off(&mut self, [q, v, e]: [R; 3], cart: [R; 2]) {
        self.point = Point {
            t: R::ZERO,
            q,
            v,
            e,
            lead: R::ZERO,
            cart,
        };
        self.open = None;
        self.touch = Touch::Apart;
        let at = self.body.place(q, v);
        if at.depth >= e && at.depth > R::ZERO {
            self.point.e = at.depth;
            let speed = self.field().speed(&at);
            if self.slider.held_force(at.depth, speed) > R::ZERO {
                self.open_contact();
            }
        }
    }

    /// Coordinate, rate and compression on the section.
    pub fn section(&self) -> [R; 3] {
        [self.point.q, self.point.v, self.point.e]
    }

    /// Deviation of the cart from its course (m) and its rate (m/s) now.
    pub fn cart(&self) -> [R; 2] {
        self.point.cart
    }

    /// Whether the cart recoils.
    pub fn recoils(&self) -> bool {
        self.body.recoils()
    }

    /// How hammer and ground touch.
    pub fn touch(&self) -> Touch {
        self.touch
    }

    /// Distance of the front beyond its nominal place, m. 0 on the section with [`Feed::Cart`].
    pub fn lead_m(&self) -> f64 {
        self.point.lead.to_f64()
    }

    /// The body's depth beyond the nominal place of the front, m, and its rate, m/s.
    pub fn depth(&self) -> (f64, f64) {
        let at = self.body.place(self.point.q, self.point.v);
        (at.depth.to_f64(), at.rate.to_f64())
    }

    /// Progress since the start, m.
    pub fn drift_m(&self) -> f64 {
        self.drift
    }

    /// Drive period, s.
    pub fn period_s(&self) -> f64 {
        self.period_s
    }

    /// Units of coordinate and rate: the amplitude and amplitude times Ω.
    pub fn units(&self) -> (f64, f64) {
        let [q, v, ..] = self.all_units();
        (q, v)
    }

    /// The same, and those of the cart's deviation and its rate.
    pub fn all_units(&self) -> [f64; 4] {
        let (scale, length) = self.body.scales();
        [scale, scale * self.omega, length, length * self.omega]
    }

    /// Where energy went since the start, J.
    pub fn energies(&self) -> Energies {
        self.energies
    }

    /// Energy of the body and that stored in the ground now, J.
    pub fn energy_now_j(&self) -> (f64, f64) {
        let p = &self.point;
        let stored = self.slider.stored_energy(p.e).to_f64();
        (self.body.energy(p.q, p.v), stored)
    }

    pub(super) fn field(&self) -> Field<'_, R> {
        Field {
            body: &self.body,
            slider: &self.slider,
            touch: self.touch,
            omega: self.omega,
            feed: self.speed,
            units: self.all_units().map(|unit| unit * self.tolerance),
        }
    }

    /// Runs to the next drive phase 0; finished contacts go to `blows`. Returns what happened, and the progress (m). If
    /// the motion cannot be followed, the state becomes NaN.
    pub fn run_period(&mut self, blows: &mut Vec<Blow>) -> (Period<f64>, R) {
        let mut period = Period {
            touched: self.touch != Touch::Apart,
            ..Period::default()
        };
        self.dug = R::ZERO;
        for _ in 0..MAX_STEPS_PER_PERIOD {
            let to_go = self.period_s - self.point.t.to_f64();
            let wanted = self.next_step.min(self.longest_now());
            let last = to_go <= wanted;
            let h = wanted.min(to_go);
            let length = if last {
                R::from_f64(self.period_s) - self.point.t
            } else {
                R::from_f64(h)
            };
            let step = self.field().step(&self.point, length);
            if step.error > 1.0 {
                self.next_step = tableau::shorter(h, step.error);
                continue;
            }
            if let Some((exit, at)) = self.field().first_exit(&self.point, &step.end) {
                let part = self.field().step(&self.point, at);
                self.accept(&part, &mut period);
                self.switch(exit, &mut period, blows);
                self.next_step = FIRST_STEP * self.longest.1;
                continue;
            }
            self.accept(&step, &mut period);
            if last {
                self.end_period();
                return (period, self.dug);
            }
            self.next_step = tableau::next(h, step.error);
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
                p.lead = R::ZERO;
            }
            // The ground must not come to where the hammer is.
            Feed::Ground => {
                let depth = self.body.place(p.q, p.v).depth;
                if self.touch == Touch::Apart && depth < p.e {
                    p.lead = R::ZERO;
                }
            }
            Feed::Steady => self.speed = self.dug.to_f64() / self.period_s,
            Feed::Speed(_) => {}
        }
        if self.feed == Feed::Steady && self.touch == Touch::Apart {
            // What the speed of the last period was short of.
            self.point.lead = R::ZERO;
        }
    }

    fn longest_now(&self) -> f64 {
        if self.touch != Touch::Apart {
            return self.longest.1;
        }
        // While the top still comes back close to the hammer, no hop must be stepped over.
        let e = self.point.e.to_f64();
        let away = self.point.lead.to_f64() + e - self.depth().0;
        if away < 20.0 * e {
            let relaxation = self.slider.relaxation().to_f64();
            return self.longest.0.min(0.25 / relaxation);
        }
        self.longest.0
    }

    fn accept(&mut self, step: &Step<R>, period: &mut Period<f64>) {
        if self.touch != Touch::Apart {
            let peak = self.peak(step);
            if let Some(open) = &mut self.open {
                open.peak_force_n = open.peak_force_n.max(peak);
                open.duration_s += (step.end.t - self.point.t).to_f64();
                open.progress_m += step.dug.to_f64();
                open.energy_lost_j += step.energies.contact;
                open.impulse_n_s += step.energies.impulse;
                let third = self.onsets[2];
                period.chatter |=
                    open.duration_s > SUSTAINED_CONTACT_S && open.onset_s - third < self.period_s;
            }
            period.touched = true;
            period.peak_force = period.peak_force.max(peak);
        }
        self.watch_loop(step);
        self.energies.add(&step.energies, 1.0);
        self.drift += step.dug.to_f64();
        self.dug += step.dug;
        self.point = step.end;
    }

    /// The largest force in a step in contact, N.
    fn peak(&self, step: &Step<R>) -> f64 {
        let field = self.field();
        let force = |p: &Point<R>| {
            let at = self.body.place(p.q, p.v);
            field.motion(p, &at).0.to_f64()
        };
        let ends = force(&self.point).max(force(&step.end));
        let rises = |p: &Point<R>| field.held_force_rate(p) > 0.0;
        if self.touch != Touch::Held || !rises(&self.point) || rises(&step.end) {
            return ends;
        }
        let h = (step.end.t - self.point.t).to_f64();
        let within = |s: f64| force(&field.step(&self.point, R::from_f64(s * h)).end);
        let top = within(maximum(within, (0.0, 1.0), 1e-4, 0.5));
        top.max(ends).min(self.slider.threshold.to_f64())
    }

    fn switch(&mut self, exit: Exit, period: &mut Period<f64>, blows: &mut Vec<Blow>) {
        match exit {
            Exit::Meets => {
                self.open_contact();
                period.onsets = period.onsets.saturating_add(1);
                period.touched = true;
            }
            Exit::Leaves => {
                self.touch = Touch::Apart;
                blows.extend(self.open.take());
            }
            Exit::GivesWay => self.touch = Touch::Slipping,
            Exit::Holds => self.touch = Touch::Held,
        }
    }

    fn open_contact(&mut self) {
        let p = &self.point;
        let at = self.body.place(p.q, p.v);
        let speed = self.field().speed(&at);
        let onset_s = self.cycle as f64 * self.period_s + p.t.to_f64();
        self.touch = self.slider.at_onset(p.e, speed);
        self.open = Some(Blow {
            onset_s,
            approach_speed_m_per_s: speed.to_f64(),
            ..Blow::default()
        });
        self.onsets = [onset_s, self.onsets[0], self.onsets[1]];
    }
}
