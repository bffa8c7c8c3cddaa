//! Where hammer, bit, cart and ground are: put there, and told.

use shared::model::slider::Touch;

use super::flow::{DrillPoint, Energies};
use super::march::Drill;
use crate::flow::Scalar;

impl<R: Scalar> Drill<R> {
    /// Puts it on the section at coordinate, rate and compression; where they touch, the compression follows from the
    /// coordinate. The cart is on its course.
    pub fn place(&mut self, section: [R; 3]) {
        self.place_off(section, [R::ZERO; 2]);
    }

    /// [`Self::place`] with a cart that recoils `cart` (m, m/s) off its course. A bit is at rest on the ground.
    pub fn place_off(&mut self, [q, v, e]: [R; 3], cart: [R; 2]) {
        let at = self.body.place(q, v);
        self.point = DrillPoint {
            t: R::ZERO,
            q,
            v,
            e,
            lead: R::ZERO,
            cart,
            bit: [R::ZERO; 2],
            at,
        };
        self.open = None;
        self.struck = false;
        self.touch = Touch::Apart;
        if let Some(bit) = &self.bit {
            let under = bit.rest_compression(&self.slider);
            let pushes = bit.indicator(at.depth - under, at.rate) > R::ZERO;
            self.place_bit([under, R::ZERO]);
            if pushes {
                self.strike();
            }
            return;
        }
        if at.depth >= e && at.depth > R::ZERO {
            self.point.e = at.depth;
            let speed = self.flow().speed(&self.point);
            if self.slider.held_force(at.depth, speed) > R::ZERO {
                self.meet();
            }
        }
    }

    /// Puts a bit that is not struck on the ground at this depth (m) and rate (m/s).
    pub(super) fn place_bit(&mut self, bit: [R; 2]) {
        self.point.bit = bit;
        self.point.e = bit[0] - self.point.lead;
        self.touch = Touch::Held;
    }

    /// Depth of the bit beyond the nominal place of the front (m) and its rate (m/s); 0 without one.
    pub fn bit(&self) -> [R; 2] {
        self.point.bit
    }

    /// Whether the hammer touches: the ground, or the bit if there is one.
    pub fn hammer_touches(&self) -> bool {
        match self.bit {
            Some(_) => self.struck,
            None => self.touch != Touch::Apart,
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

    /// How the ground is touched, by the hammer, or by the bit if there is one.
    pub fn touch(&self) -> Touch {
        self.touch
    }

    /// Distance of the front beyond its nominal place, m. 0 on the section with [`super::Feed::Cart`].
    pub fn lead_m(&self) -> f64 {
        self.point.lead.to_f64()
    }

    /// The body's depth beyond the nominal place of the front, m, and its rate, m/s.
    pub fn depth(&self) -> (f64, f64) {
        let at = &self.point.at;
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

    /// Units of coordinate, rate, the cart's deviation and its rate: amplitudes, and amplitudes times Ω.
    pub fn all_units(&self) -> [f64; 4] {
        let (scale, length) = self.body.scales();
        [scale, scale * self.omega, length, length * self.omega]
    }

    /// Time since the start, s.
    pub(super) fn now_s(&self) -> f64 {
        self.cycle as f64 * self.period_s + self.point.t.to_f64()
    }

    /// Where energy went since the start, J.
    pub fn energies(&self) -> Energies {
        self.energies
    }
}
