//! By how much a sensor may read too little: limits and trip levels go by the worse of two measurements.
//!
//! Two sensors that contradict each other a little trip nothing, since nobody knows which of them is wrong. Until it is
//! known, the more dangerous of the two counts: the limit and the trip level of what may be larger than it reads are divided
//! by how much larger. Nothing here ever makes a limit or a trip level wider.

/// How many times its reading each value may truly be, from 1 to [`Doubt::MOST`]; the travel to 2. What a
/// surface that rings or is lossy may hide comes on top, in the controller.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Doubt {
    /// Contact force: how many times its reading it may truly be.
    pub force: f32,
    /// Displacement of the hammer relative to the cart.
    pub travel: f32,
    /// Displacement of the cart.
    pub cart: f32,
}

/// The most by what nothing trips by.
const MOST_UNSURE: f32 = 2.0;

/// Sensors that differ by no more than this agree: those of a healthy rig are within 2 %.
const AGREES: f32 = 0.98;

impl Doubt {
    /// The most: sensors that are further apart trip.
    pub const MOST: f32 = 4.0 / 3.0;

    /// From the impulse of the contacts over the momentum they change (`momentum`) and the gain of the hammer's sensor over
    /// the cart's (`ratio`), 1 for what is not known.
    pub fn new(momentum: f32, ratio: f32) -> Self {
        let hammer = at_least_one(AGREES / ratio);
        Self {
            // A hammer that reads less makes the momentum too small as well.
            force: at_least_one(hammer * AGREES / momentum),
            travel: hammer.max(at_least_one(AGREES * momentum)),
            cart: at_least_one(AGREES * ratio),
        }
    }

    /// Raises the travel's factor for a hammer's sensor that may have the gain `ratio` over the cart's. Nothing trips
    /// by it, so it may go further than [`Doubt::MOST`].
    pub fn or_hammer_reads(self, ratio: f32) -> Self {
        Self {
            travel: self.travel.max(within(AGREES / ratio, MOST_UNSURE)),
            ..self
        }
    }
}

fn at_least_one(factor: f32) -> f32 {
    within(factor, Doubt::MOST)
}

/// Written so that NaN doubts nothing. Six ask for it: one copy is enough.
#[inline(never)]
fn within(factor: f32, most: f32) -> f32 {
    if factor > 1.0 { factor.min(most) } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sensors_that_agree_are_not_doubted() {
        for momentum in [0.98, 1.0, 1.02] {
            for ratio in [0.98, 1.0, 1.02] {
                let none = Doubt {
                    force: 1.0,
                    travel: 1.0,
                    cart: 1.0,
                };
                assert_eq!(Doubt::new(momentum, ratio), none);
            }
        }
    }

    #[test]
    fn what_may_be_larger_than_it_reads_is_doubted_by_as_much() {
        for times in [0.76_f32, 0.8, 0.85, 0.9] {
            // The truth stays below 110 %, and little is given away.
            let enough = |doubt: f32| doubt * times > 0.93 && doubt * times < 1.03;
            let force = Doubt::new(times, 1.0);
            assert!(enough(force.force) && force.cart == 1.0, "{force:?}");
            let hammer = Doubt::new(1.0, times);
            assert!(enough(hammer.travel) && hammer.cart == 1.0, "{hammer:?}");
            // The contacts tell it before the flights do.
            let early = Doubt::new(1.0 / times, 1.0);
            assert!(enough(early.travel) && early.force == 1.0, "{early:?}");
            let cart = Doubt::new(1.0, 1.0 / times);
            assert!(enough(cart.cart) && cart.force == 1.0, "{cart:?}");
            let both = Doubt::new(1.0, times);
            assert!(enough(both.force), "force and hammer alike: {both:?}");
        }
    }

    #[test]
    fn a_hammer_that_may_read_less_narrows_the_travel_alone() {
        let sure = Doubt::new(0.9, 1.0);
        for (ratio, travel) in [
            (0.75, 0.98 / 0.75),
            (0.5, 1.96),
            (0.3, 2.0),
            (1.3, 1.0),
            (f32::INFINITY, 1.0),
        ] {
            let unsure = sure.or_hammer_reads(ratio);
            assert_eq!(unsure, Doubt { travel, ..sure }, "{ratio}");
        }
    }

    #[test]
    fn no_number_makes_a_limit_wider_or_closes_it() {
        let odd = [0.0, -1.0, 1e-30, 1e30, f32::NAN, f32::INFINITY, -0.0];
        for momentum in odd {
            for ratio in odd {
                let doubt = Doubt::new(momentum, ratio);
                for one in [doubt.force, doubt.travel, doubt.cart] {
                    assert!((1.0..=Doubt::MOST).contains(&one), "{doubt:?}");
                }
            }
        }
    }
}
