//! Contacts that the lanes' short expansion cannot represent, one at a time in f64: sustained contacts, contacts during
//! which the section comes, and hops that end before the hammer has left the surface.
//!
//! Contact is the closed form of [`super::touch`] without expansions, sampled every 0.7 radians of the transient (a sine
//! alone once the transient has decayed); flight while F < 0 < x is a Taylor step of third order.

use std::f64::consts::TAU;

use shared::model::contacts::SUSTAINED_CONTACT_S;

use super::constants::Constants;
use super::form::{DEAD_AFTER, Form, Turning, crossing};
use super::surface::{LawSurface, Press};

/// Releases and onsets after which a sustained contact is given up.
const MOST: usize = 500;

/// Step of a flight with x > 0 beside a surface without a closed form, in drive phase.
const LEAVING_STEP: f64 = 0.005;

/// Side of the switch while x > 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SwitchSide {
    /// The contact force acts.
    Contact,
    /// The force has ended, but x > 0 still.
    Leaving,
}

/// A hammer in sustained contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sustained {
    /// Coordinate x, in cart amplitudes into the surface.
    pub x: f64,
    /// Rate x′, per radian of drive phase.
    pub v: f64,
    /// The rate with which this contact began.
    pub approach: f64,
    /// A cart that recoils: its deviation and rate.
    pub cart: [f64; 2],
    /// Drive phase since the last strobe.
    pub tau: f64,
    /// Side of the switch.
    pub side: SwitchSide,
    /// Largest force of this period.
    pub peak: f64,
    /// Onsets of this period.
    pub onsets: u32,
    /// Phases of the last three onsets, latest first, from the last strobe.
    pub recent: [f64; 3],
    /// Whether chatter has ended in a sustained contact in this period.
    pub chatter: bool,
}

/// How a sustained contact went on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SustainedEvent {
    /// It reached the section (`tau` = 2π).
    Section,
    /// The hammer is out: x = 0, v < 0.
    Out,
    /// It cannot be followed.
    Lost,
}

impl Sustained {
    /// Continues to the section, or until the hammer is out.
    pub fn run(&mut self, c: &Constants) -> SustainedEvent {
        for _ in 0..MOST {
            let event = match self.side {
                SwitchSide::Contact => self.press(c),
                SwitchSide::Leaving => self.leave(c),
            };
            if !(self.x.is_finite() && self.v.is_finite()) {
                return SustainedEvent::Lost;
            }
            if let Some(event) = event {
                return event;
            }
        }
        SustainedEvent::Lost
    }

    fn begin(&mut self) {
        self.side = SwitchSide::Contact;
        self.onsets += 1;
        self.approach = self.v;
        self.recent = [self.tau, self.recent[0], self.recent[1]];
    }

    /// In contact until F falls through zero or the section comes.
    fn press(&mut self, c: &Constants) -> Option<SustainedEvent> {
        let end = TAU - self.tau;
        let release = match &c.surface {
            None => self.press_in_closed_form(c, end),
            Some(surface) => match self.press_by_law(surface, c, end) {
                Press::Released => Some(()),
                Press::Held => None,
                Press::Lost => return Some(SustainedEvent::Lost),
            },
        };
        let stayed = (self.tau - self.recent[0]) / c.omega;
        self.chatter |= stayed > SUSTAINED_CONTACT_S && self.recent[0] - self.recent[2] < TAU;
        if release.is_none() {
            self.tau = TAU;
            return Some(SustainedEvent::Section);
        }
        self.side = SwitchSide::Leaving;
        None
    }

    /// In contact for `end` at most, or until it is released.
    fn press_in_closed_form(&mut self, c: &Constants, end: f64) -> Option<()> {
        let form = Form::new(c, self.tau, [self.x, self.v], self.cart);
        let release = self.find_release(&form, end);
        let t = release.unwrap_or(end);
        (self.x, self.v) = form.state(t);
        if let Some(together) = &form.together {
            self.cart = together.cart(&form, t);
        }
        self.tau += t;
        release.map(|_| ())
    }

    /// In contact by a law without a closed form, for `end` at most, or until it is released.
    fn press_by_law(&mut self, surface: &LawSurface, c: &Constants, end: f64) -> Press {
        let mut state = [self.x, self.v, self.cart[0], self.cart[1]];
        let span = (self.tau, end);
        let (t, press) = surface.press(c, span, &mut state, self.approach, &mut self.peak);
        [self.x, self.v, self.cart[0], self.cart[1]] = state;
        self.tau += t;
        press
    }

    /// The first release before `end`, and the peaks on the way.
    fn find_release(&mut self, form: &Form, end: f64) -> Option<f64> {
        let mut turning = Turning::new(form);
        let mut before = (0.0, turning.force());
        let mut here = before;
        self.peak = self.peak.max(here.1);
        for k in 1.. {
            if here.0 >= end {
                return None;
            }
            let over = |decay: f64| decay * here.0 > DEAD_AFTER;
            let together = form.together.as_ref();
            if over(
                form.c
                    .decay
                    .min(together.map_or(f64::INFINITY, |t| t.decay)),
            ) || turning.dead()
            {
                return self.find_slow_release(form, here.0, end);
            }
            turning.turn();
            let t = (f64::from(k) * turning.step).min(end);
            let force = if t < end {
                turning.force()
            } else {
                form.force(t).0
            };
            let next = (t, force);
            let bend = before.1 + next.1 - 2.0 * here.1;
            if here.1 < before.1 && here.1 < next.1 && here.1 < 0.25 * bend {
                let (at, lowest) = form.extremum(before.0, next.0, here.0);
                if lowest < 0.0 {
                    return Some(form.release(before.0, at));
                }
            }
            if here.1 >= before.1 && here.1 >= next.1 && here.1 - bend > self.peak {
                let (_, top) = form.extremum(before.0, next.0, here.0);
                self.peak = self.peak.max(top);
            }
            self.peak = self.peak.max(next.1);
            if next.1 <= 0.0 {
                return Some(form.release(here.0, t));
            }
            (before, here) = (here, next);
        }
        None
    }

    /// The first release between `from` and `end`, where the transient is negligible and F is R sin(τ + ψ) + M.
    fn find_slow_release(&mut self, form: &Form, from: f64, end: f64) -> Option<f64> {
        let (sin, cos, mean) = form.slow();
        let swing = libm::hypot(sin, cos);
        let angle = form.tau + libm::atan2(cos, sin);
        // The next time after `from` at which τ + ψ is `wanted`, give or take turns.
        let next = |wanted: f64| from + (wanted - angle - from).rem_euclid(TAU);
        let top = next(0.25 * TAU);
        let release = if mean.abs() < swing {
            next(0.5 * TAU + libm::asin(mean / swing))
        } else if mean < 0.0 {
            from
        } else {
            f64::INFINITY
        };
        if top < release.min(end) {
            self.peak = self.peak.max(swing + mean);
        }
        (release < end).then_some(release)
    }

    /// Free flight with x > 0 until it is out, F rises through zero, or the section comes.
    fn leave(&mut self, c: &Constants) -> Option<SustainedEvent> {
        let lag = c.contact_damper / c.contact_spring;
        let step = match &c.surface {
            None => (2.0 * lag).max(0.1 / c.pulsation),
            Some(_) => LEAVING_STEP,
        };
        loop {
            if self.x <= 0.0 && self.v < 0.0 {
                self.x = 0.0;
                return Some(SustainedEvent::Out);
            }
            let h = step.min(TAU - self.tau);
            let (sin, cos) = libm::sincos(self.tau);
            let hold = c.pull - c.damping * self.v;
            let beside = c
                .recoil
                .map(|recoil| recoil.joint.beside(self.cart, hold, (sin, cos)));
            let (a, j) = match &beside {
                None => {
                    let a = c.drive * sin + c.pull - c.damping * self.v;
                    (a, c.drive * cos - c.damping * a)
                }
                Some(beside) => (beside.x2, beside.x3),
            };
            let at = |t: f64| {
                (
                    self.x + t * (self.v + t * (0.5 * a + t * j / 6.0)),
                    self.v + t * (a + 0.5 * t * j),
                )
            };
            let force = |t: f64| {
                let (x, v) = at(t);
                if let Some(surface) = &c.surface {
                    return surface.factor(v, a + t * j, self.approach);
                }
                (
                    c.contact_spring * x + c.contact_damper * v,
                    c.contact_spring * v + c.contact_damper * (a + t * j),
                )
            };
            let leaves = at(h).0 < 0.0;
            let until = if leaves { crossing(0.0, h, at) } else { h };
            let comes_back = force(until).0 > 0.0;
            let back = comes_back.then(|| crossing(0.0, until, force));
            let out = leaves.then_some(());
            let t = back.unwrap_or(until);
            (self.x, self.v) = at(t);
            if let Some(beside) = &beside {
                self.cart = beside.cart_after(t);
            }
            self.tau += t;
            if back.is_some() {
                self.begin();
                return None;
            }
            if out.is_some() {
                self.x = 0.0;
                return Some(SustainedEvent::Out);
            }
            if h < step {
                self.tau = TAU;
                return Some(SustainedEvent::Section);
            }
            if !self.x.is_finite() {
                return Some(SustainedEvent::Lost);
            }
        }
    }
}
