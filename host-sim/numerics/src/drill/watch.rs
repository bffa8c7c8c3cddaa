//! What the shaker's loop must give while the hammer drills.

use super::flow::DrillStep;
use super::march::Drill;
use crate::flow::{Scalar, reached};

/// Points of a step at which the force is taken, beside its start.
const POINTS: u32 = 4;

impl<R: Scalar> Drill<R> {
    /// This drill, watching the force of the shaker's loop from now on.
    #[must_use]
    pub fn watching_the_loop(mut self) -> Self {
        self.loop_force_n = self.body.recoils().then_some(0.0);
        self
    }

    /// The largest force of the loop, N, either way, since it is watched. None with a prescribed cart.
    pub fn largest_loop_force_n(&self) -> Option<f64> {
        self.loop_force_n
    }

    /// Takes in the step that is about to be accepted.
    pub(super) fn watch_loop(&mut self, step: &DrillStep<R>) {
        let Some(mut largest) = self.loop_force_n else {
            return;
        };
        let length = (step.end.t - self.point.t).to_f64();
        for k in 1..=POINTS {
            let part = R::from_f64(length * f64::from(k) / f64::from(POINTS));
            let p = reached(&self.flow(), &self.point, part);
            let angle = p.t * R::from_f64(self.omega);
            let force = self.body.loop_force(angle, p.cart).abs();
            // A number that is none stays: f64::max would drop it.
            if force > largest || force.is_nan() {
                largest = force;
            }
        }
        self.loop_force_n = Some(largest);
    }
}
