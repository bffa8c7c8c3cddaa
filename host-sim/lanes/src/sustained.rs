//! Contacts that the lanes' short expansion cannot represent, one at a time in f64: sustained contacts, contacts during
//! which the section comes, and hops that end before the hammer has left the surface.
//!
//! Contact is the closed form of [`super::touch`] without expansions, sampled every 0.7 radians of the transient (a sine
//! alone once the transient has decayed); flight while F < 0 < x is a Taylor step of third order.

use std::f64::consts::TAU;

use shared::model::contacts::SUSTAINED_CONTACT_S;

use super::constants::Constants;

/// Phase of the transient between samples of the force, rad.
const SAMPLE_ANGLE: f64 = 0.7;

/// Decay after which the transient is negligible: e⁻¹⁶ of it is left.
const DEAD_AFTER: f64 = 16.0;

/// The transient is negligible, too, when its force is less than this share of the forced one.
const DEAD_BELOW: f64 = 1e-7;

/// Releases and onsets after which a sustained contact is given up.
const MOST: usize = 500;

/// Side of the switch while x > 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// The force acts.
    Contact,
    /// The force has ended, but x > 0 still.
    Leaving,
}

/// A hammer in sustained contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sustained {
    /// Coordinate.
    pub x: f64,
    /// Rate.
    pub v: f64,
    /// Drive phase since the last strobe.
    pub tau: f64,
    /// Side of the switch.
    pub side: Side,
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
pub enum Event {
    /// It reached the section (`tau` = 2π).
    Section,
    /// The hammer is out: x = 0, v < 0.
    Out,
    /// It cannot be followed.
    Lost,
}

impl Sustained {
    /// Continues to the section, or until the hammer is out.
    pub fn run(&mut self, c: &Constants) -> Event {
        for _ in 0..MOST {
            let event = match self.side {
                Side::Contact => self.press(c),
                Side::Leaving => self.leave(c),
            };
            if !(self.x.is_finite() && self.v.is_finite()) {
                return Event::Lost;
            }
            if let Some(event) = event {
                return event;
            }
        }
        Event::Lost
    }

    fn begin(&mut self) {
        self.side = Side::Contact;
        self.onsets += 1;
        self.recent = [self.tau, self.recent[0], self.recent[1]];
    }

    /// In contact until F falls through zero or the section comes.
    fn press(&mut self, c: &Constants) -> Option<Event> {
        let form = Form::new(c, self.tau, self.x, self.v);
        let end = TAU - self.tau;
        let release = self.find_release(&form, end);
        let t = release.unwrap_or(end);
        (self.x, self.v) = form.state(t);
        self.tau += t;
        let stayed = (self.tau - self.recent[0]) / c.omega;
        self.chatter |= stayed > SUSTAINED_CONTACT_S && self.recent[0] - self.recent[2] < TAU;
        if release.is_none() {
            self.tau = TAU;
            return Some(Event::Section);
        }
        self.side = Side::Leaving;
        None
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
            if form.c.decay * here.0 > DEAD_AFTER || turning.dead() {
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

    /// The same from `from` on, where the transient is negligible and F is R sin(τ + ψ) + M.
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
    fn leave(&mut self, c: &Constants) -> Option<Event> {
        let lag = c.contact_damper / c.contact_spring;
        let step = (2.0 * lag).max(0.1 / c.pulsation);
        loop {
            if self.x <= 0.0 && self.v < 0.0 {
                self.x = 0.0;
                return Some(Event::Out);
            }
            let h = step.min(TAU - self.tau);
            let (sin, cos) = libm::sincos(self.tau);
            let a = c.drive * sin + c.pull - c.damping * self.v;
            let j = c.drive * cos - c.damping * a;
            let at = |t: f64| {
                (
                    self.x + t * (self.v + t * (0.5 * a + t * j / 6.0)),
                    self.v + t * (a + 0.5 * t * j),
                )
            };
            let force = |t: f64| {
                let (x, v) = at(t);
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
            self.tau += t;
            if back.is_some() {
                self.begin();
                return None;
            }
            if out.is_some() {
                self.x = 0.0;
                return Some(Event::Out);
            }
            if h < step {
                self.tau = TAU;
                return Some(Event::Section);
            }
            if !self.x.is_finite() {
                return Some(Event::Lost);
            }
        }
    }
}

/// Where `at` (value and slope) takes the sign it has at `high`, between `low` and `high`.
fn crossing(low: f64, high: f64, at: impl Fn(f64) -> (f64, f64)) -> f64 {
    let rises = at(high).0 > 0.0;
    let (mut low, mut high) = (low, high);
    let mut t = high;
    for _ in 0..80 {
        let (value, slope) = at(t);
        if (value > 0.0) == rises {
            high = t;
        } else {
            low = t;
        }
        let newton = t - value / slope;
        let inside = low < newton && newton < high;
        let next = if inside { newton } else { 0.5 * (low + high) };
        let moved = (next - t).abs();
        t = next;
        if moved <= 1e-12 * high {
            break;
        }
    }
    t
}

/// The closed form of a contact from drive phase `tau`.
struct Form<'a> {
    c: &'a Constants,
    tau: f64,
    a: f64,
    b: f64,
    push: (f64, f64),
}

impl<'a> Form<'a> {
    fn new(c: &'a Constants, tau: f64, x: f64, v: f64) -> Self {
        let (sin, cos) = libm::sincos(tau);
        let forced = c.forced_sin * sin + c.forced_cos * cos + c.forced_mean;
        let rate = c.forced_sin * cos - c.forced_cos * sin;
        let a = x - forced;
        let b = (v - rate + c.decay * a) / c.pulsation;
        Self {
            c,
            tau,
            a,
            b,
            push: c.force_amplitudes(a, b),
        }
    }

    /// The forced part of F: what multiplies sin τ and cos τ, and the mean.
    fn slow(&self) -> (f64, f64, f64) {
        let c = self.c;
        (
            c.contact_spring * c.forced_sin - c.contact_damper * c.forced_cos,
            c.contact_spring * c.forced_cos + c.contact_damper * c.forced_sin,
            c.contact_spring * c.forced_mean,
        )
    }

    /// e^(−μt) cos νt and e^(−μt) sin νt.
    fn transient(&self, t: f64) -> (f64, f64) {
        let decay = -self.c.decay * t;
        if decay < -2.0 * DEAD_AFTER {
            return (0.0, 0.0);
        }
        let (sin, cos) = libm::sincos(self.c.pulsation * t);
        let left = libm::exp(decay);
        (left * cos, left * sin)
    }

    /// Coordinate and rate.
    fn state(&self, t: f64) -> (f64, f64) {
        let c = self.c;
        let (cos, sin) = self.transient(t);
        let z = self.a * cos + self.b * sin;
        let turn = c.pulsation * (self.b * cos - self.a * sin);
        let (s, k) = libm::sincos(self.tau + t);
        (
            z + c.forced_sin * s + c.forced_cos * k + c.forced_mean,
            turn - c.decay * z + c.forced_sin * k - c.forced_cos * s,
        )
    }

    /// Force and its first two derivatives.
    fn force(&self, t: f64) -> (f64, f64, f64) {
        let c = self.c;
        let (cos, sin) = self.transient(t);
        let (a, b) = self.push;
        let (mu, nu) = (c.decay, c.pulsation);
        let (a1, b1) = (nu * b - mu * a, -nu * a - mu * b);
        let (a2, b2) = (nu * b1 - mu * a1, -nu * a1 - mu * b1);
        let (s, k) = libm::sincos(self.tau + t);
        let swing = c.forced_sin * s + c.forced_cos * k;
        let rate = c.forced_sin * k - c.forced_cos * s;
        let (stiff, damp) = (c.contact_spring, c.contact_damper);
        (
            a * cos + b * sin + stiff * (swing + c.forced_mean) + damp * rate,
            a1 * cos + b1 * sin + stiff * rate - damp * swing,
            a2 * cos + b2 * sin - stiff * swing - damp * rate,
        )
    }

    /// The extremum of F between `low` and `high`, and its time.
    fn extremum(&self, low: f64, high: f64, from: f64) -> (f64, f64) {
        let mut t = from;
        for _ in 0..2 {
            let (_, slope, bend) = self.force(t);
            t = (t - slope / bend).clamp(low, high);
        }
        (t, self.force(t).0)
    }

    /// Where F falls through zero between `low` and `high`.
    fn release(&self, low: f64, high: f64) -> f64 {
        crossing(low, high, |t| {
            let (value, slope, _) = self.force(t);
            (value, slope)
        })
    }
}

/// The force of a closed form at even steps, by rotation.
struct Turning {
    step: f64,
    /// Both transient terms of F, and how a step turns and shrinks them.
    transient: (f64, f64),
    shrink: (f64, f64),
    /// Both forced terms of F, and how a step turns them.
    forced: (f64, f64),
    turn: (f64, f64),
    mean: f64,
}

impl Turning {
    fn new(form: &Form) -> Self {
        let c = form.c;
        let step = SAMPLE_ANGLE / c.pulsation;
        let (sample_sin, sample_cos) = libm::sincos(SAMPLE_ANGLE);
        let (sin, cos) = libm::sincos(form.tau);
        let (p, q, mean) = form.slow();
        let left = libm::exp(-c.decay * step);
        let (turn_sin, turn_cos) = libm::sincos(step);
        Self {
            step,
            transient: form.push,
            shrink: (left * sample_cos, left * sample_sin),
            forced: (p * sin + q * cos, p * cos - q * sin),
            turn: (turn_cos, turn_sin),
            mean,
        }
    }

    fn force(&self) -> f64 {
        self.transient.0 + self.forced.0 + self.mean
    }

    /// Whether drive and support alone make the force from here on.
    fn dead(&self) -> bool {
        let square = |(a, b): (f64, f64)| a * a + b * b;
        let least = DEAD_BELOW * DEAD_BELOW * (square(self.forced) + self.mean * self.mean);
        square(self.transient) < least
    }

    fn turn(&mut self) {
        self.transient = turned(self.transient, self.shrink);
        self.forced = turned(self.forced, self.turn);
    }
}

/// (a, b) → (a c + b s, b c − a s).
fn turned((a, b): (f64, f64), (c, s): (f64, f64)) -> (f64, f64) {
    (a * c + b * s, b * c - a * s)
}
