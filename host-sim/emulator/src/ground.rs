//! Ground that gives way under the plant's hammer: [`shared::model::slider`].
//!
//! The top of the ground relaxes within a thousandth of a second after a contact. So in flight the plant takes it as
//! relaxed, as the spring-dashpot of a surface that stays is.

use shared::model::contact::Law;
use shared::model::rig::{Kinematics, SwitchMode};
use shared::model::slider::{Slider, Touch};

/// The ground, and whether it gives way at the moment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlantGround {
    /// Stiffness k and damping c of the ground, and the contact force at which it gives way.
    pub slider: Slider<f64>,
    /// The feed makes up for the progress with this time constant, s.
    pub feed_s: f64,
    /// Whether the contact force has reached the threshold.
    pub slipping: bool,
}

impl PlantGround {
    /// How hammer and ground touch, in contact.
    fn touch(&self) -> Touch {
        if self.slipping {
            Touch::Slipping
        } else {
            Touch::Held
        }
    }

    /// Contact force in N, where the ground's front is `front` metres beyond the gap.
    #[inline]
    pub fn force(&self, at: &Kinematics<f64>, front: f64) -> f64 {
        self.slider.force(self.touch(), at.delta - front, at.rate)
    }

    /// Its rate, N/s, at the hammer's speed and acceleration into the ground.
    #[inline]
    pub fn force_rate(&self, speed: f64, acceleration: f64) -> f64 {
        if self.slipping {
            0.0
        } else {
            self.slider.held_force(speed, acceleration)
        }
    }

    /// How fast the front advances, m/s.
    #[inline]
    pub fn front_rate(&self, at: &Kinematics<f64>, front: f64) -> f64 {
        if self.slipping {
            let e = at.delta - front;
            self.slider.advance_rate(Touch::Slipping, e, at.rate)
        } else {
            0.0
        }
    }

    /// Positive in contact while neither the hammer leaves nor the ground begins or ends to give way; in flight negative
    /// until the hammer meets the ground.
    pub fn indicator(&self, mode: SwitchMode, at: &Kinematics<f64>, front: f64) -> f64 {
        let e = at.delta - front;
        match mode {
            SwitchMode::Flight => {
                let (stiffness, damping) = (self.slider.stiffness, self.slider.damping);
                Law::SpringDashpot { stiffness, damping }.indicator(e, at.rate, 0.0)
            }
            SwitchMode::Contact if self.slipping => self.front_rate(at, front),
            SwitchMode::Contact => {
                let force = self.slider.held_force(e, at.rate);
                force.min(self.slider.threshold - force)
            }
        }
    }

    /// A contact begins: finds out whether the ground gives way from the start.
    pub fn begin(&mut self, at: &Kinematics<f64>, front: f64) {
        let touch = self.slider.at_onset(at.delta - front, at.rate);
        self.slipping = touch == Touch::Slipping;
    }

    /// A phase of the contact has ended. Returns whether the contact goes on.
    pub fn goes_on(&mut self, at: &Kinematics<f64>, front: f64) -> bool {
        if self.slipping {
            self.slipping = false;
            return true;
        }
        let force = self.slider.held_force(at.delta - front, at.rate);
        self.slipping = force > 0.5 * self.slider.threshold;
        self.slipping
    }
}
