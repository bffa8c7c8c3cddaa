//! Where in a step a phase of the contact ends.

use shared::model::slider::Touch;

use super::flow::{Acting, DrillFlow, DrillPoint};
use crate::flow::{Flow as _, Scalar, reached};
use crate::reference::switching::Arc;
use crate::root::maximum;

/// Interior points per step at which the ends are looked for.
const SAMPLES: usize = 8;

/// Newton's iteration stops when it moves by less than this share of the step.
const SHARE_TOLERANCE: f64 = 1e-13;

/// How a phase ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Exit {
    /// Hammer or bit meets the ground's top.
    Meets,
    /// The contact force falls to 0.
    Leaves,
    /// The contact force reaches the threshold.
    GivesWay,
    /// The front comes to rest.
    Holds,
    /// The hammer meets the bit.
    Strikes,
    /// The force between hammer and bit falls to 0.
    Parts,
}

/// How the phase of the contact with the ground can end.
fn exits(touch: Touch) -> &'static [Exit] {
    match touch {
        Touch::Apart => &[Exit::Meets],
        Touch::Held => &[Exit::Leaves, Exit::GivesWay],
        Touch::Slipping => &[Exit::Holds],
    }
}

/// Paths of the body and of the bit through a step.
struct Paths {
    body: Arc,
    bit: Option<Arc>,
}

impl<R: Scalar> DrillFlow<'_, R> {
    /// Positive beyond the end of the phase.
    fn beyond(&self, exit: Exit, p: &DrillPoint<R>) -> R {
        let (slider, speed) = (self.slider, self.speed(p));
        match exit {
            Exit::Meets => self.depth(p) - p.lead - p.e,
            Exit::Strikes | Exit::Parts => self.beyond_bit(exit, p),
            Exit::Leaves => -slider.held_force(p.e, speed),
            Exit::GivesWay => slider.held_force(p.e, speed) - slider.threshold,
            Exit::Holds => -slider.advance_rate(self.touch, p.e, speed),
        }
    }

    /// [`Self::beyond`] of [`Exit::Strikes`] and [`Exit::Parts`]; −∞ without a bit.
    fn beyond_bit(&self, exit: Exit, p: &DrillPoint<R>) -> R {
        let Some(bit) = self.bit else {
            return R::from_f64(f64::NEG_INFINITY);
        };
        let [x, rate] = self.into_bit(p);
        if exit == Exit::Strikes {
            bit.indicator(x, rate)
        } else {
            -bit.force(x, rate)
        }
    }

    /// Rate of [`Self::beyond`] at `p`, per s.
    fn beyond_rate(&self, exit: Exit, p: &DrillPoint<R>) -> f64 {
        let (slider, speed) = (self.slider, self.speed(p));
        let now = self.acting(p);
        let acceleration = now.motion.acceleration;
        let body = self.body.depth_acceleration(&p.at, p.v, acceleration);
        let deeper = if self.bit.is_some() { now.bit } else { body };
        let compression = slider.compression_rate(self.touch, p.e, speed);
        let rate = match exit {
            Exit::Meets => speed - compression,
            Exit::Strikes | Exit::Parts => {
                let Some(bit) = self.bit else {
                    return f64::NAN;
                };
                let ([_, rate], change) = (self.into_bit(p), body - now.bit);
                if exit == Exit::Strikes {
                    bit.indicator_rate(rate, change)
                } else {
                    -bit.force(rate, change)
                }
            }
            Exit::Leaves => -slider.held_force(speed, deeper),
            Exit::GivesWay => slider.held_force(speed, deeper),
            Exit::Holds => -(slider.relaxation() * compression) - deeper,
        };
        rate.to_f64()
    }

    /// Rate of the contact force while the ground holds, N/s.
    pub fn held_force_rate(&self, p: &DrillPoint<R>) -> f64 {
        self.beyond_rate(Exit::GivesWay, p)
    }

    /// Rate of the force between hammer and bit, N/s. 0 without a bit.
    pub fn struck_force_rate(&self, p: &DrillPoint<R>) -> f64 {
        if self.bit.is_none() {
            return 0.0;
        }
        -self.beyond_rate(Exit::Parts, p)
    }

    /// The first end of the phase within the step from `from` to `end`: how, and how long after `from`.
    pub fn first_exit(&self, from: &DrillPoint<R>, end: &DrillPoint<R>) -> Option<(Exit, R)> {
        let h = (end.t - from.t).to_f64();
        if self.out_of_reach(from, end, h) {
            return None;
        }
        let (a, b) = (self.acting(from), self.acting(end));
        let body = |p: &DrillPoint<R>, now: &Acting<R>| {
            let acceleration = now.motion.acceleration.to_f64();
            (p.q.to_f64(), p.v.to_f64(), acceleration)
        };
        let bit = |p: &DrillPoint<R>, now: &Acting<R>| {
            let [u, w] = p.bit;
            (u.to_f64(), w.to_f64(), now.bit.to_f64())
        };
        let paths = Paths {
            body: Arc::new(h, body(from, &a), body(end, &b)),
            bit: self.bit.map(|_| Arc::new(h, bit(from, &a), bit(end, &b))),
        };
        let found = exits(self.touch)
            .iter()
            .chain(self.blows(from, end, h))
            .filter_map(|exit| Some((*exit, self.root(*exit, from, end, &paths)?)));
        found.min_by(|a, b| a.1.to_f64().total_cmp(&b.1.to_f64()))
    }

    /// How the phase of the contact of hammer and bit can end in this step.
    fn blows(&self, from: &DrillPoint<R>, end: &DrillPoint<R>, h: f64) -> &'static [Exit] {
        if self.bit.is_none() {
            return &[];
        }
        if self.struck {
            return &[Exit::Parts];
        }
        let apart = |p: &DrillPoint<R>| {
            let [x, rate] = self.into_bit(p);
            (x.to_f64(), rate.to_f64().abs())
        };
        let (a, b) = (apart(from), apart(end));
        if a.0.max(b.0) + h * (a.1 + b.1) < 0.0 {
            return &[];
        }
        &[Exit::Strikes]
    }

    /// Whether the ground is too far away to be met in this step.
    fn out_of_reach(&self, from: &DrillPoint<R>, end: &DrillPoint<R>, h: f64) -> bool {
        if self.touch != Touch::Apart || self.bit.is_some() {
            return false;
        }
        let clearance = |p: &DrillPoint<R>| {
            let beyond = self.beyond(Exit::Meets, p).to_f64();
            (beyond, self.speed(p).to_f64().abs(), p.e.to_f64())
        };
        let (a, b) = (clearance(from), clearance(end));
        a.0.max(b.0) + h * (a.1 + b.1) + a.2 < 0.0
    }

    /// When within the step the phase ends so.
    fn root(
        &self,
        exit: Exit,
        from: &DrillPoint<R>,
        end: &DrillPoint<R>,
        paths: &Paths,
    ) -> Option<R> {
        let h = paths.body.length;
        let guess = |s: f64| {
            let (q, v) = paths.body.at(s);
            let (u, w) = paths.bit.map_or((0.0, 0.0), |bit| bit.at(s));
            // No end of a phase depends on where the cart is.
            let [off, off_rate] = from.cart;
            let [q, v, u, w] = [q, v, u, w].map(R::from_f64);
            let p = self.after(from, R::from_f64(s * h), [q, v, off, off_rate, u, w]);
            self.beyond(exit, &p).to_f64()
        };
        let exact = |s: f64| {
            let p = reached(self, from, R::from_f64(s * h));
            let value = self.beyond(exit, &p).to_f64();
            (value, self.beyond_rate(exit, &p) * h)
        };
        let end_value = self.beyond(exit, end).to_f64();
        let bracket = bracket(&guess, end_value, |s| exact(s).0)?;
        let s = newton(&exact, bracket);
        let time = R::from_f64(s * h);
        let p = reached(self, from, time);
        let value = self.beyond(exit, &p);
        // Same value; in dual numbers, with the derivatives of the instant.
        Some(time.as_root_of(value, self.beyond_rate(exit, &p)))
    }
}

/// Shares of the step between which `guess` rises through 0 for the first time. What only the guess says of an extremum
/// near 0 is decided by `exact`.
fn bracket(
    guess: &impl Fn(f64) -> f64,
    end: f64,
    exact: impl Fn(f64) -> f64,
) -> Option<(f64, f64)> {
    let at = |j: usize| j as f64 / SAMPLES as f64;
    let mut values = [0.0; SAMPLES + 1];
    for (j, value) in values.iter_mut().enumerate() {
        *value = if j == SAMPLES { end } else { guess(at(j)) };
    }
    let spread = values.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
    for j in 1..=SAMPLES {
        if values[j] > 0.0 {
            return Some((at(j - 1), at(j)));
        }
        // A top between the samples: it comes and turns away within the step.
        let top = j < SAMPLES && values[j] >= values[j - 1] && values[j] >= values[j + 1];
        if top && values[j] > -0.1 * spread {
            let s = maximum(guess, (at(j - 1), at(j + 1)), 1e-9, at(j));
            if guess(s) > -1e-9 * spread && exact(s) > 0.0 {
                return Some((at(j - 1), s));
            }
        }
    }
    None
}

/// The root in a bracket: Newton's iteration on the integrator itself, held in the bracket by bisection.
fn newton(exact: &impl Fn(f64) -> (f64, f64), (mut low, mut high): (f64, f64)) -> f64 {
    let mut s = 0.5 * (low + high);
    for _ in 0..60 {
        let (value, rate) = exact(s);
        if value > 0.0 {
            high = s;
        } else {
            low = s;
        }
        let by_newton = s - value / rate;
        let next = if by_newton > low && by_newton < high {
            by_newton
        } else {
            0.5 * (low + high)
        };
        if (next - s).abs() < SHARE_TOLERANCE || high - low < SHARE_TOLERANCE {
            return next;
        }
        s = next;
    }
    s
}
