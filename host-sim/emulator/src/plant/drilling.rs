//! The plant on ground that gives way, and its feed.

use shared::model::rig::SwitchMode;

use super::Plant;
use crate::ground::PlantGround;

impl Plant {
    /// This plant, which must be in flight, on ground that gives way; none: on the rig's own surface.
    #[must_use]
    pub fn on_ground(mut self, ground: Option<PlantGround>) -> Self {
        self.bodies.ground = ground;
        self
    }

    /// How far the ground has given way since the start, m.
    pub fn progress_m(&self) -> f64 {
        self.progress_m
    }

    /// In flight the feed makes up for a share of the progress in each tick.
    #[inline]
    pub(super) fn feed(&mut self) {
        if let Some(ground) = &self.bodies.ground
            && self.bodies.mode == SwitchMode::Flight
        {
            self.state.front *= 1.0 - (self.tick_s / ground.feed_s).min(1.0);
        }
    }
}
