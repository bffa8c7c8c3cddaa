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
    /// Cart amplitude A0 of the rig, m.
    amplitude_m: f32,
    /// The gap with the margin, m.
    gap_m: f32,
}

impl FreeSwing {
    /// The free swing of `rig`, with the margin on its gap.
    pub fn new(rig: &RigParams) -> Self {
        Self {
            natural_hz: rig.natural_frequency_hz() as f32,
            amplitude_m: rig.amplitude_m as f32,
            gap_m: MARGIN * rig.gap_m as f32,
        }
    }

    /// Whether a free swing at `hz` with a cart amplitude of `amplitude_m` would touch: then the hammer must strike.
    pub fn must_touch(&self, hz: f32, amplitude_m: f32) -> bool {
        let r = hz / self.natural_hz;
        let square = r * r;
        amplitude_m * square >= self.gap_m * libm::fabsf(1.0 - square)
    }

    /// How far the hammer itself swings at `hz`, in amplitudes of the cart: 1/|1 − r²|.
    pub fn own(&self, hz: f32) -> f32 {
        let r = hz / self.natural_hz;
        1.0 / libm::fabsf(1.0 - r * r)
    }

    /// `amplitude_m` as a share of A0, 0 without one.
    pub fn share_of_full(&self, amplitude_m: f32) -> f32 {
        if self.amplitude_m > 0.0 {
            amplitude_m / self.amplitude_m
        } else {
            0.0
        }
    }

    /// The highest frequency up to `hz` at which the hammer must strike.
    pub fn certain_up_to(&self, hz: f32) -> f32 {
        // r² = reach (r² − 1), above the resonance.
        if self.gap_m <= self.amplitude_m {
            return hz;
        }
        let edge = libm::sqrtf(self.gap_m / (self.gap_m - self.amplitude_m));
        hz.min(self.natural_hz * edge)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::params::WIRES;

    #[test]
    fn at_no_gap_it_must_touch_everywhere_and_at_a_large_one_near_resonance() {
        assert_eq!(FreeSwing::default().share_of_full(1e-3), 0.0);
        let closed = FreeSwing::new(&WIRES);
        assert_eq!(closed.share_of_full(0.5 * WIRES.amplitude_m as f32), 0.5);
        assert!(closed.must_touch(1.0, 1e-4) && closed.must_touch(9.0, 1e-4));
        assert_eq!(closed.certain_up_to(3.66), 3.66);
        let natural_hz = WIRES.natural_frequency_hz() as f32;
        assert!((closed.own(3.0 * natural_hz) - 0.125).abs() < 1e-6);
        let open = FreeSwing::new(&RigParams {
            gap_m: 2.4e-3,
            ..WIRES
        });
        let entry = open.certain_up_to(2.75);
        assert!((entry / 1.82 - 1.203).abs() < 1e-3, "{}", entry / 1.82);
        let full_m = WIRES.amplitude_m as f32;
        assert!(open.must_touch(0.999 * entry, full_m) && !open.must_touch(1.001 * entry, full_m));
        assert!(!open.must_touch(0.999 * entry, 0.99 * full_m));
        assert_eq!(open.certain_up_to(2.0), 2.0);
    }
}
