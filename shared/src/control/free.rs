//! The free swing: at which frequencies it reaches the surface, and the hammer must strike.
//!
//! Under y = A0 sin Ωt the swing relative to the cart settles to A0 r²/|1 − r²|, r = Ω/ω (linear, its damping
//! left out: 0 on wires, 0.004 on beams). Where that is less than the gap, swinging free lasts beside
//! striking, and a hammer that has lost the surface does not come back by itself.

use crate::model::params::RigParams;

/// The free swing must exceed the gap by this factor for contact to be certain.
const MARGIN: f32 = 1.2;

/// The free swing of a rig.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FreeSwing {
    natural_hz: f32,
    /// Gap over A0, with the margin.
    reach: f32,
}

impl FreeSwing {
    /// Of `rig`.
    pub fn new(rig: &RigParams) -> Self {
        let amplitude_m = rig.amplitude_m as f32;
        let reach = if amplitude_m > 0.0 {
            MARGIN * rig.gap_m as f32 / amplitude_m
        } else {
            0.0
        };
        Self {
            natural_hz: rig.natural_frequency_hz() as f32,
            reach,
        }
    }

    /// Whether a free swing at `hz` would touch: then the hammer must strike.
    pub fn must_touch(&self, hz: f32) -> bool {
        let r = hz / self.natural_hz;
        let square = r * r;
        square >= self.reach * libm::fabsf(1.0 - square)
    }

    /// The highest frequency up to `hz` at which the hammer must strike.
    pub fn certain_up_to(&self, hz: f32) -> f32 {
        // r² = reach (r² − 1), above the resonance.
        if self.reach <= 1.0 {
            return hz;
        }
        let edge = libm::sqrtf(self.reach / (self.reach - 1.0));
        hz.min(self.natural_hz * edge)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::params::WIRES;

    #[test]
    fn at_no_gap_it_must_touch_everywhere_and_at_a_large_one_near_resonance() {
        let closed = FreeSwing::new(&WIRES);
        assert!(closed.must_touch(1.0) && closed.must_touch(9.0));
        assert_eq!(closed.certain_up_to(3.66), 3.66);
        let open = FreeSwing::new(&RigParams {
            gap_m: 2.4e-3,
            ..WIRES
        });
        let entry = open.certain_up_to(2.75);
        assert!((entry / 1.82 - 1.203).abs() < 1e-3, "{}", entry / 1.82);
        assert!(open.must_touch(0.999 * entry) && !open.must_touch(1.001 * entry));
        assert_eq!(open.certain_up_to(2.0), 2.0);
    }
}
