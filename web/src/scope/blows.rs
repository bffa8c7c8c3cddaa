//! Blow by blow: peak, impulse, and the phase of the cart's motion at which the hammer strikes.

use std::collections::VecDeque;

use serde::Serialize;
use shared::settings::{Detection, TICK_S};

/// Length of a control tick, s.
const TICK: f32 = TICK_S as f32;

/// So many of the last blows are kept.
const KEPT: usize = 200;

/// Share of the cart's last amplitude by which it must have been below the middle before a passage counts.
const BELOW: f32 = 0.1;

/// A blow as the force sensor measured it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct MeasuredBlow {
    /// When it began, s since the scope's first tick.
    pub time_s: f64,
    /// Largest measured force of the blow, N.
    pub peak_n: f32,
    /// Impulse ∫F dt while the force was above the one that ends a blow, N·s.
    pub impulse_n_s: f32,
    /// Of the cart's measured motion: 0 where it passes the middle towards positive; none: it does not move.
    pub phase_deg: Option<f64>,
}

/// Finds blows, as the controller does: from above one force until it has stayed below another for some time.
#[derive(Debug)]
pub struct Blows {
    detection: Detection,
    last: VecDeque<MeasuredBlow>,
    now: Option<MeasuredBlow>,
    /// How long the force has been low, s.
    low_s: f32,
    cart: Cart,
}

/// The cart's passages through the middle.
#[derive(Debug, Default)]
struct Cart {
    was_mm: f32,
    /// Least since the last passage, and the amplitude it gave before.
    least_mm: f32,
    amplitude_mm: f32,
    upward_s: Option<f64>,
}

impl Cart {
    fn tick(&mut self, time_s: f64, cart_mm: f32) {
        self.least_mm = self.least_mm.min(cart_mm);
        let far = self.least_mm < -BELOW * self.amplitude_mm && self.least_mm < 0.0;
        if far && self.was_mm < 0.0 && cart_mm >= 0.0 {
            let back = cart_mm / (cart_mm - self.was_mm);
            self.upward_s = Some(time_s - f64::from(back) * TICK_S);
            self.amplitude_mm = -self.least_mm;
            self.least_mm = 0.0;
        }
        self.was_mm = cart_mm;
    }

    fn phase_deg(&self, time_s: f64, hz: f32) -> Option<f64> {
        let since_s = time_s - self.upward_s?;
        let turns = since_s * f64::from(hz);
        // Longer ago than a drive period: it no longer moves.
        (hz > 0.0 && turns < 1.5).then(|| 360.0 * turns.rem_euclid(1.0))
    }
}

impl Blows {
    /// No blow yet, to be found by the forces and the time of `detection`.
    pub fn new(detection: &Detection) -> Self {
        Self {
            detection: *detection,
            last: VecDeque::new(),
            now: None,
            low_s: 0.0,
            cart: Cart::default(),
        }
    }

    /// The last ones, oldest first.
    pub fn last(&self) -> impl Iterator<Item = &MeasuredBlow> {
        self.last.iter()
    }

    /// Something is missing: a blow under way is not counted.
    pub fn interrupt(&mut self) {
        self.now = None;
        self.cart = Cart::default();
    }

    /// A tick: force, cart and drive frequency (0: the drive is off).
    pub fn tick(&mut self, time_s: f64, force_n: f32, cart_mm: f32, hz: f32) {
        self.cart.tick(time_s, cart_mm);
        let Detection {
            on_n,
            off_n,
            refractory_s,
        } = self.detection;
        let Some(blow) = &mut self.now else {
            if force_n > on_n {
                self.low_s = 0.0;
                self.now = Some(MeasuredBlow {
                    time_s,
                    peak_n: force_n,
                    impulse_n_s: force_n * TICK,
                    phase_deg: self.cart.phase_deg(time_s, hz),
                });
            }
            return;
        };
        blow.peak_n = blow.peak_n.max(force_n);
        if force_n >= off_n {
            self.low_s = 0.0;
            blow.impulse_n_s += force_n * TICK;
            return;
        }
        self.low_s += TICK;
        if self.low_s > refractory_s {
            self.last.extend(self.now.take());
            if self.last.len() > KEPT {
                self.last.pop_front();
            }
        }
    }
}
