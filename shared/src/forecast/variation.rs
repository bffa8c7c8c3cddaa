//! The linearisation of the motion, carried beside the march: the same steps in [`Tangent`] numbers, and
//! at each switch the jump of the derivative (the saltation), exact.
//!
//! At a switch the indicator h falls through zero at an instant that depends on where the hammer
//! started: t_e′ = −h′/ḣ. Up to t_e the old field acts, after it the new one, so that at a fixed time just
//! after the switch the rate has v′ + (a⁻ − a⁺) t_e′; the coordinate, whose rate does not jump, keeps q′.

use super::march::{ForecastModel, MarchStep, Setup};
use crate::model::drive::Drive;
use crate::model::rig::{Mode, Rig};
use crate::model::scalar::Real;
use crate::model::step::{Corrected, Span, State};
use crate::model::tangent::Tangent;

/// A hammer with its derivatives by the section it started on.
#[derive(Clone, Copy, Debug)]
pub struct Variation {
    rig: Rig<Tangent>,
    drive: Drive<Tangent>,
    drive_acceleration: Tangent,
    units: [f32; 2],
    state: State<Tangent>,
}

impl Variation {
    /// Starts at `section`, with derivatives in units of A0 and A0 Ω.
    pub fn new(model: &ForecastModel, setup: &Setup, section: [f32; 2]) -> Self {
        let mut variation = Self {
            rig: model.tangent,
            drive: setup.drive.map(Tangent::constant),
            drive_acceleration: Tangent::constant(setup.drive_acceleration),
            units: setup.units,
            state: State::default(),
        };
        variation.restart(section);
        variation
    }

    /// Starts anew from another `section` at phase 0.
    pub fn restart(&mut self, section: [f32; 2]) {
        let ([q, v], [a, b]) = (section, self.units);
        self.state = State::new(
            &self.rig,
            Tangent::new(q, [a, 0.0]),
            Tangent::new(v, [0.0, b]),
        );
        self.drive.restart();
    }

    /// Follows a step of the march.
    pub fn follow(&mut self, stretch: &MarchStep) {
        let (from, to) = stretch.part;
        let part = (Tangent::constant(from), Tangent::constant(to));
        let span = Span {
            drive: &self.drive,
            drive_acceleration: self.drive_acceleration,
            from: part.0,
            to: part.1,
        };
        self.state = Corrected::step(&self.rig, &span, &self.state, part).state;
        if stretch.switched {
            let drive = span.inertial(part.1);
            self.cross(drive);
        }
        if stretch.tick_ended {
            self.drive.advance();
        }
    }

    /// The value now: coordinate and rate, the very numbers of the march.
    pub fn section(&self) -> [f32; 2] {
        [self.state.q.hi.value, self.state.v.hi.value]
    }

    /// The derivative of the section by the one it started on, in units of A0 and A0 Ω, row by row.
    pub fn monodromy(&self) -> [[f32; 2]; 2] {
        let (q, v) = (self.state.q, self.state.v);
        let row = |hi: Tangent, lo: Tangent, unit: f32| {
            let ([a, b], [c, d]) = (hi.partial, lo.partial);
            [(a + c) / unit, (b + d) / unit]
        };
        [
            row(q.hi, q.lo, self.units[0]),
            row(v.hi, v.lo, self.units[1]),
        ]
    }

    /// Crosses the switch the state lies on, under the inertial acceleration `drive`.
    fn cross(&mut self, drive: Tangent) {
        let rig = &self.rig;
        let (q, v) = (self.state.q.hi, self.state.v.hi);
        let at = rig.kinematics(q, v);
        let approach = self.state.approach;
        let without = rig.acceleration(&at, v, drive, Tangent::ZERO);
        let entering = self.state.mode == Mode::Flight;
        let approach_there = if entering { at.rate } else { approach };
        let pushed = rig.acceleration(&at, v, drive, rig.force(&at, approach_there));
        let (before, after) = if entering {
            (without.value, pushed.value)
        } else {
            (pushed.value, without.value)
        };
        let instant = self.instant(before);
        if entering {
            let rate = rig.penetration_acceleration(&at, v, Tangent::constant(before));
            self.state.approach = shifted(at.rate, rate.value, instant);
        }
        self.state.v.hi = shifted(v, before - after, instant);
        self.state.mode = if entering {
            Mode::Contact
        } else {
            Mode::Flight
        };
    }

    /// t_e′ = −h′/ḣ, where the rate changes by `acceleration` until the switch.
    fn instant(&self, acceleration: f32) -> [f32; 2] {
        let state = &self.state;
        let (h, _) = Corrected::indicator_and_rate(&self.rig, state);
        // The same indicator with time for a direction: its derivative is ḣ.
        let (q, v) = (state.q.hi.value, state.v.hi.value);
        let mut in_time = *state;
        in_time.q.hi = Tangent::new(q, [v, 0.0]);
        in_time.v.hi = Tangent::new(v, [acceleration, 0.0]);
        in_time.approach = Tangent::constant(state.approach.value);
        let (rate, _) = Corrected::indicator_and_rate(&self.rig, &in_time);
        let [rate, _] = rate.partial;
        if rate == 0.0 {
            return [0.0; 2];
        }
        h.partial.map(|partial| -partial / rate)
    }
}

/// `x` with its derivatives moved by `rate` times those of an instant.
fn shifted(x: Tangent, rate: f32, [a, b]: [f32; 2]) -> Tangent {
    let [x0, x1] = x.partial;
    Tangent::new(x.value, [x0 + rate * a, x1 + rate * b])
}
