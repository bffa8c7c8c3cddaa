//! What the shaker's position loop must give along an orbit.

use shared::model::cart::Cart;
use shared::model::params::RigParams;

use super::Orbit;
use crate::reference::{Reference, Segment, TrajectoryObserver};

/// Points of a smooth piece at which the force is taken, beside its start.
const POINTS: u32 = 16;

/// The largest force of the position loop over a period of `orbit`, N, either way. None with a prescribed cart, and where
/// the motion cannot be followed.
pub fn loop_force_n(params: &RigParams, orbit: &Orbit) -> Option<f64> {
    let cart = Cart::<f64>::of(params)?;
    let [q, v] = orbit.section;
    let hammer = Reference::<f64>::new(params, orbit.frequency_hz, q, v).ok()?;
    let omega = std::f64::consts::TAU * orbit.frequency_hz;
    let mut largest = Largest {
        cart,
        omega,
        acceleration: params.amplitude_m * omega * omega,
        force_n: 0.0,
    };
    let mut hammer = hammer.with_cart(orbit.cart);
    for _ in 0..orbit.periods {
        hammer.run_period(&mut largest);
    }
    largest.force_n.is_finite().then_some(largest.force_n)
}

struct Largest {
    cart: Cart<f64>,
    omega: f64,
    /// Peak acceleration of the cart's course, A0 Ω², m/s².
    acceleration: f64,
    force_n: f64,
}

impl TrajectoryObserver for Largest {
    fn segment(&mut self, segment: &Segment) {
        let (from, to) = (segment.start.t, segment.end.t);
        for k in 0..=POINTS {
            let t = from + (to - from) * f64::from(k) / f64::from(POINTS);
            let course = self.acceleration * (self.omega * t).sin();
            let force = self.cart.force(course, segment.cart(t)).abs();
            // A number that is none stays: f64::max would drop it.
            if force > self.force_n || force.is_nan() {
                self.force_n = force;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use shared::model::cart::{ASSUMED_SHAKER, CartDrive, LoopParams};
    use shared::model::params::WIRES;

    use super::*;
    use crate::branch::one_one_branches;

    /// A loop so stiff that the cart hardly moves off its course carries the cart's inertia and the contact; a soft one
    /// carries about what it feeds forward.
    #[test]
    fn the_loop_carries_the_cart_and_a_stiff_one_the_contact_too() {
        let at = |frequency_hz: f64| {
            let held = LoopParams {
                frequency_hz,
                ..ASSUMED_SHAKER
            };
            let params = RigParams {
                cart: CartDrive::Loop(held),
                ..WIRES
            };
            let orbit = one_one_branches(&params, (1.0, 3.0))[0].at(3.67).unwrap();
            (loop_force_n(&params, &orbit).unwrap(), orbit)
        };
        let cart_n =
            WIRES.cart_mass_kg * WIRES.amplitude_m * (std::f64::consts::TAU * 3.67_f64).powi(2);
        let (soft, orbit) = at(4.0);
        assert!(
            soft > 0.8 * cart_n && soft < 2.0 * cart_n,
            "{soft} {cart_n}"
        );
        // The contact's impulse leaves the cart with a speed that the damper of the loop meets.
        let (usual, _) = at(50.0);
        let kick = orbit.contact.impulse_n_s / WIRES.cart_mass_kg;
        let damper = 2.0 * 0.7 * WIRES.cart_mass_kg * std::f64::consts::TAU * 50.0;
        let expected = damper * kick;
        assert!(
            usual > 0.7 * expected && usual < 1.2 * expected + cart_n,
            "{usual} {expected}"
        );
        let (stiff, orbit) = at(1000.0);
        assert!(stiff > 0.5 * orbit.force_n, "{stiff}");
        let prescribed = one_one_branches(&WIRES, (1.0, 3.0))[0].at(3.67).unwrap();
        assert_eq!(loop_force_n(&WIRES, &prescribed), None);
    }
}
