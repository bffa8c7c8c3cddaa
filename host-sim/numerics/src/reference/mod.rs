//! The reference: an event-located integrator in f64, written for truth, not for speed.
//!
//! It shares the rigs' equations of motion and the contact laws with `shared`, and nothing else: its own
//! time (seconds since drive phase 0), its own integrators, its own location of switches ([`switching`], to 1e-13 s by
//! Newton's iteration on the motion itself, grazing-safe). It is followed by power series where the equations are analytic,
//! and by Runge–Kutta steps ([`crate::flow`], adaptive, order 8) elsewhere; the tests compare both.
//!
//! Integrated in [`crate::dual::Dual`] numbers it yields the derivative of the section's return map along
//! with the map, event times included, which is the monodromy matrix with its saltation.

pub mod flow;
mod in_series;
mod observer;
mod series;
mod smoothed;
pub mod switching;

use std::f64::consts::TAU;

use shared::model::cart::Cart;
use shared::model::contacts::{Period, SUSTAINED_CONTACT_S};
use shared::model::params::{ParamError, RigParams};
use shared::model::rig::{Rig, SwitchMode};
use shared::model::step::Smoothed;

use crate::flow::{Pace, Scalar, StepEnded, reached};
pub use flow::{FlowPoint, FlowTotals};
pub use observer::{LocatedContact, Segment, TrajectoryObserver};

use flow::HammerFlow;
use observer::Within;
use series::Equations;

/// Errors of coordinate and rate are kept below this share of A0 and A0 Ω per step.
pub const TOLERANCE: f64 = 1e-12;

/// First step after a switch, s: a contact lasts some fifty of these.
const FIRST_STEP_S: f64 = 1e-5;

/// Steps per period of the faster of drive and hammer, at least.
const STEPS_PER_PERIOD: f64 = 24.0;

/// Steps after which a period is given up. Chatter needs some thousands; a hammer that was started deep
/// inside the surface, or swung over the top, never ends.
const MAX_STEPS_PER_PERIOD: u64 = 200_000;

/// A hammer in its cart, integrated from drive phase 0 to drive phase 0.
#[derive(Clone, Copy, Debug)]
pub struct Reference<R> {
    rig: Rig<R>,
    /// The rig in f64, for observers.
    plain: Rig<f64>,
    /// A cart that recoils.
    cart: Option<Cart<R>>,
    /// The cart that recoils, in f64.
    plain_cart: Option<Cart<f64>>,
    omega: f64,
    period_s: f64,
    tolerance: f64,
    units: (f64, f64),
    max_step: f64,
    point: FlowPoint<R>,
    mode: SwitchMode,
    approach: R,
    /// Arctangents in place of the switch.
    smoothed: Option<Smoothed<R>>,
    /// The equations of a motion that is followed by its power series where they are analytic.
    equations: Option<Equations>,
    cycle: u64,
    pace: Pace,
    open: Option<LocatedContact>,
    recent: [Option<f64>; 3],
    totals: FlowTotals,
}

impl<R: Scalar> Reference<R> {
    /// A hammer of `params` at drive phase 0 at rest, driven at `frequency_hz`.
    ///
    /// # Errors
    /// If a parameter is out of range: the first of them.
    ///
    /// # Panics
    /// If `frequency_hz` is not a positive number.
    pub fn at_rest(params: &RigParams, frequency_hz: f64) -> Result<Self, ParamError> {
        let rig = Rig::<R>::new(params)?;
        Self::new(params, frequency_hz, rig.rest(), R::ZERO)
    }

    /// A hammer at drive phase 0 at coordinate `q` and rate `v` (see [`shared::model::rig`] for the coordinate).
    ///
    /// # Errors
    /// If a parameter is out of range: the first of them.
    ///
    /// # Panics
    /// If `frequency_hz` is not a positive number.
    pub fn new(params: &RigParams, frequency_hz: f64, q: R, v: R) -> Result<Self, ParamError> {
        let mut hammer = Self::in_flight(params, frequency_hz, q, v)?;
        let at = hammer.rig.kinematics(q, v);
        if hammer.rig.indicator(&at, hammer.approach) > R::ZERO {
            hammer.open_contact();
        }
        Ok(hammer)
    }

    /// [`Self::new`], but on the side of the switch on which there is no contact, wherever the hammer is.
    fn in_flight(params: &RigParams, frequency_hz: f64, q: R, v: R) -> Result<Self, ParamError> {
        assert!(frequency_hz > 0.0 && frequency_hz.is_finite());
        let plain = Rig::<f64>::new(params)?;
        let omega = TAU * frequency_hz;
        let unit = TOLERANCE * plain.coordinate_scale();
        let fastest = frequency_hz.max(params.natural_frequency_hz());
        let rig = Rig::<R>::new(params)?;
        let hammer = Self::with(rig, plain, [q, v], (unit, unit * omega));
        Ok(Self {
            cart: Cart::of(params),
            plain_cart: Cart::of(params),
            omega,
            period_s: 1.0 / frequency_hz,
            max_step: 1.0 / (STEPS_PER_PERIOD * fastest),
            equations: Some(Equations::new(params, omega)),
            ..hammer
        })
    }

    /// In flight in a cart that stands still; errors of coordinate and rate are weighed by `units`.
    fn with(rig: Rig<R>, plain: Rig<f64>, [q, v]: [R; 2], units: (f64, f64)) -> Self {
        Self {
            rig,
            plain,
            cart: None,
            plain_cart: None,
            omega: 0.0,
            period_s: f64::MAX,
            tolerance: TOLERANCE,
            units,
            max_step: f64::INFINITY,
            point: FlowPoint::on_course(R::ZERO, q, v),
            mode: SwitchMode::Flight,
            approach: rig.kinematics(q, v).rate.max(R::ZERO),
            smoothed: None,
            equations: None,
            cycle: 0,
            pace: Pace::new(FIRST_STEP_S),
            open: None,
            recent: [None; 3],
            totals: FlowTotals::default(),
        }
    }

    /// This state at drive `phase` (turns, from 0 to below 1) instead of 0: the first period run is what is left
    /// of one.
    #[must_use]
    pub fn from_phase(mut self, phase: f64) -> Self {
        self.point.t = R::from_f64(phase * self.period_s);
        if let Some(open) = &mut self.open {
            open.onset_s = self.point.t.to_f64();
            open.peak_at_s = open.onset_s;
        }
        self
    }

    /// This hammer followed by Runge–Kutta steps alone, on both sides of the switch and for every contact law.
    #[must_use]
    pub fn in_steps(mut self) -> Self {
        self.equations = None;
        self
    }

    /// This hammer with errors per step kept below another share of A0 and A0 Ω than [`TOLERANCE`].
    #[must_use]
    pub(crate) fn with_tolerance(mut self, tolerance: f64) -> Self {
        let by = tolerance / self.tolerance;
        self.units = (self.units.0 * by, self.units.1 * by);
        self.tolerance = tolerance;
        self
    }

    /// This state with the cart `deviation` (m, m/s) off its course; one that is prescribed keeps to it.
    #[must_use]
    pub fn with_cart(mut self, deviation: [R; 2]) -> Self {
        if self.cart.is_some() {
            self.point.cart = deviation;
        }
        self
    }

    /// Where everything is now.
    pub fn point(&self) -> FlowPoint<R> {
        self.point
    }

    /// The rig in f64.
    pub fn rig(&self) -> &Rig<f64> {
        &self.plain
    }

    /// Coordinate and rate now.
    pub fn state(&self) -> (R, R) {
        (self.point.q, self.point.v)
    }

    /// Deviation of the cart from its course (m) and its rate (m/s) now.
    pub fn cart(&self) -> [R; 2] {
        self.point.cart
    }

    /// Drive period, s.
    pub fn period_s(&self) -> f64 {
        self.period_s
    }

    /// Drive periods done.
    pub fn cycle(&self) -> u64 {
        self.cycle
    }

    /// Where energy and momentum went since the start.
    pub fn totals(&self) -> FlowTotals {
        self.totals
    }

    /// Mechanical energy now, J, relative to the cart, without the surface's.
    pub fn energy_j(&self) -> f64 {
        let (q, v) = (self.point.q.to_f64(), self.point.v.to_f64());
        self.plain.energy(&self.plain.kinematics(q, v), v)
    }

    fn flow(&self) -> HammerFlow<'_, R> {
        let amplitude = self.plain.amplitude();
        HammerFlow {
            rig: &self.rig,
            plain: (&self.plain, self.plain_cart.as_ref()),
            omega: self.omega,
            drive_acceleration: amplitude * self.omega * self.omega,
            mode: self.mode,
            approach: self.approach,
            smoothed: self.smoothed,
            units: self.units,
            recoil: self.cart.as_ref().map(|cart| {
                let unit = self.tolerance * amplitude;
                (cart, (unit, unit * self.omega.max(cart.omega())))
            }),
        }
    }

    /// Sends every scalar of the state through `f`, which must leave the values as they are: to take the derivatives
    /// that dual numbers carry along other directions.
    pub fn redirect(&mut self, f: impl Fn(R) -> R) {
        self.point.q = f(self.point.q);
        self.point.v = f(self.point.v);
        self.point.cart = self.point.cart.map(&f);
        self.approach = f(self.approach);
    }

    /// Steps tried since the start, those refused included; what locating a switch takes is not counted.
    pub fn steps(&self) -> u64 {
        self.pace.tried
    }

    /// Runs to the next drive phase 0 and returns what happened on the way. If the motion cannot be followed, the state
    /// becomes NaN.
    pub fn run_period(&mut self, observer: &mut impl TrajectoryObserver) -> Period<f64> {
        let period = self.run_until(1.0, observer);
        self.cycle += 1;
        self.point.t = R::ZERO;
        period
    }

    /// Runs to a later drive `phase` (turns, at most 1) of the present period and returns what happened on the way. If the
    /// motion cannot be followed, the state becomes NaN.
    pub fn run_until(&mut self, phase: f64, observer: &mut impl TrajectoryObserver) -> Period<f64> {
        let mut period = Period {
            touched: self.mode == SwitchMode::Contact,
            ..Period::default()
        };
        let most = self.pace.tried + MAX_STEPS_PER_PERIOD;
        let end_s = phase * self.period_s;
        while let Some(ended) = self.advance(end_s, most, &mut period, observer) {
            if ended == StepEnded::AtStop {
                return period;
            }
        }
        // The model does not describe a motion that needs so many steps. The state becomes NaN, which every caller
        // tests for.
        let nowhere = R::from_f64(f64::NAN);
        self.point = FlowPoint {
            t: R::ZERO,
            q: nowhere,
            v: nowhere,
            cart: [nowhere; 2],
        };
        period
    }

    /// The next step of a motion that nothing stops, and why it ended; `None` if it was refused a hundred times.
    pub(crate) fn step_on(
        &mut self,
        observer: &mut impl TrajectoryObserver,
    ) -> Option<StepEnded<()>> {
        let most = self.pace.tried + 100;
        self.advance(f64::INFINITY, most, &mut Period::default(), observer)
    }

    /// The next step, to `end_s` (s after phase 0) at most, and why it ended; `None` once `most` were tried since the start.
    fn advance(
        &mut self,
        end_s: f64,
        most: u64,
        period: &mut Period<f64>,
        observer: &mut impl TrajectoryObserver,
    ) -> Option<StepEnded<()>> {
        if let Some(equations) = self.equations.filter(|e| e.hold(self.mode)) {
            return self.advance_in_series(&equations, end_s, most, period, observer);
        }
        let mut pace = self.pace;
        let advanced = pace.advance(&self.flow(), &self.point, end_s, self.max_step, most);
        self.pace = pace;
        let (step, ended) = advanced?;
        let flow = self.flow().in_values();
        let (start, end) = (self.point.in_values(), step.end.in_values());
        let accelerations = [start, end].map(|p| flow.acceleration(&p).0);
        let peak = (self.mode == SwitchMode::Contact).then(|| {
            let force = |tau| switching::force_and_rate(&flow, &reached(&flow, &start, tau));
            switching::force_peak((start.t, end.t), force)
        });
        self.tell(
            (start, end),
            Within::Ends(accelerations),
            peak,
            period,
            observer,
        );
        self.enter(&step.totals, step.end, period);
        if ended == StepEnded::Switched(()) {
            self.switch(period, observer);
        }
        Some(ended)
    }

    /// Seconds since the start.
    fn now_s(&self) -> f64 {
        self.cycle as f64 * self.period_s + self.point.t.to_f64()
    }

    /// Tells of a smooth piece of the motion; in contact, `peak` is when and how large its force was at its largest.
    fn tell(
        &mut self,
        (start, end): (FlowPoint<f64>, FlowPoint<f64>),
        within: Within,
        peak: Option<(f64, f64)>,
        period: &mut Period<f64>,
        observer: &mut impl TrajectoryObserver,
    ) {
        if let Some((peak_at, peak)) = peak {
            let began = self.cycle as f64 * self.period_s;
            if let Some(open) = &mut self.open
                && peak > open.peak_force_n
            {
                open.peak_force_n = peak;
                open.peak_at_s = began + peak_at;
            }
            period.touched = true;
            period.peak_force = period.peak_force.max(peak);
        }
        observer.segment(&Segment {
            rig: &self.plain,
            cycle: self.cycle,
            period_s: self.period_s,
            mode: self.mode,
            approach: self.approach.to_f64(),
            start,
            end,
            within,
        });
    }

    /// Enters a step that ended at `end`.
    fn enter(&mut self, totals: &FlowTotals, end: FlowPoint<R>, period: &mut Period<f64>) {
        if let Some(open) = &mut self.open {
            open.duration_s += end.t.to_f64() - self.point.t.to_f64();
            open.impulse_n_s += totals.impulse;
            open.energy_lost_j += totals.contact_work;
            let third = self.recent[2];
            period.chatter |= open.duration_s > SUSTAINED_CONTACT_S
                && third.is_some_and(|third| open.onset_s - third < self.period_s);
        }
        self.totals.add(totals, 1.0);
        self.point = end;
    }

    fn switch(&mut self, period: &mut Period<f64>, observer: &mut impl TrajectoryObserver) {
        self.pace.next = FIRST_STEP_S;
        match self.mode {
            SwitchMode::Flight => self.begin_contact(period),
            SwitchMode::Contact => {
                self.mode = SwitchMode::Flight;
                if let Some(mut contact) = self.open.take() {
                    let at = self.rig.kinematics(self.point.q, self.point.v);
                    contact.rebound_speed_m_per_s = -at.rate.to_f64();
                    observer.contact(&contact);
                }
            }
        }
    }

    fn begin_contact(&mut self, period: &mut Period<f64>) {
        self.open_contact();
        self.recent = [Some(self.now_s()), self.recent[0], self.recent[1]];
        period.onsets = period.onsets.saturating_add(1);
        period.touched = true;
    }

    /// Contact from here on; a run that starts within one does not count it as an onset.
    fn open_contact(&mut self) {
        let at = self.rig.kinematics(self.point.q, self.point.v);
        let now = self.now_s();
        self.mode = SwitchMode::Contact;
        self.approach = at.rate;
        self.open = Some(LocatedContact {
            onset_s: now,
            approach_speed_m_per_s: at.rate.to_f64(),
            peak_at_s: now,
            ..LocatedContact::default()
        });
    }
}

impl Reference<f64> {
    /// A hammer on `rig` released in flight at coordinate and rate `section` in a cart that stands still; errors of both
    /// are weighed by `units`, and no step is longer than `max_step` s.
    pub(crate) fn undriven(
        rig: &Rig<f64>,
        section: [f64; 2],
        units: (f64, f64),
        max_step: f64,
    ) -> Self {
        Self {
            max_step,
            ..Self::with(*rig, *rig, section, units)
        }
    }
}
