//! A short climb on measured impulse that corrects the phase at which the hammer is to strike.
//!
//! Near the optimum the impulse of a 1/1 falls with the square of the phase's distance from the best one,
//! I = I₀ (1 − c δ²). c hardly depends on rig and gap ([`BEND`]), so two points either side of the present phase are
//! enough: δ = (I₊ − I₋)/(I₊ + I₋)/(2 c s) for points s apart from it. The impulse is measured and not the peak: the
//! surface's ringing adds to the peak and averages out of the impulse.

/// Distance of both points from the phase that is held, turns (6°: 0.5 % of the force).
const STEP: f32 = 6.0 / 360.0;
/// c, per square turn: from the forecasts of all presets at gaps of 0 to 2.4 mm, 1.3e-4 to 1.5e-4 per square degree.
const BEND: f32 = 1.45e-4 * 360.0 * 360.0;
/// Drive periods left out after each change of phase.
const SETTLE_PERIODS: u8 = 6;
/// Drive periods measured at each visit of a point.
const MEASURE_PERIODS: u8 = 24;
/// Order of the visits. High, low, low, high: an impulse that drifts at a steady rate moves both means alike. The last is
/// back at the phase held.
const VISITS: [f32; 5] = [1.0, -1.0, -1.0, 1.0, 0.0];

/// The climb under way.
#[derive(Clone, Copy, Debug, Default)]
pub struct PhaseProbe {
    visit: u8,
    periods: u8,
    /// Sums of the impulse at the higher and the lower phase, N·s.
    sums: (f32, f32),
}

impl PhaseProbe {
    /// Distance of the point being measured from the phase that is held, turns.
    pub fn offset_turns(&self) -> f32 {
        STEP * self.sign()
    }

    fn sign(&self) -> f32 {
        VISITS.get(usize::from(self.visit)).copied().unwrap_or(0.0)
    }

    /// A drive period with one contact of `impulse_n_s` has ended. At the end of the climb, how far from the phase held
    /// the contact is strongest, turns; not a number if nothing can be said.
    pub fn strobe(&mut self, impulse_n_s: f32) -> Option<f32> {
        self.periods += 1;
        if self.periods > SETTLE_PERIODS {
            let sign = self.sign();
            if sign > 0.0 {
                self.sums.0 += impulse_n_s;
            } else if sign < 0.0 {
                self.sums.1 += impulse_n_s;
            }
        }
        if self.periods < SETTLE_PERIODS + MEASURE_PERIODS {
            return None;
        }
        self.periods = 0;
        self.visit += 1;
        if usize::from(self.visit) < VISITS.len() {
            return None;
        }
        let (high, low) = self.sums;
        Some((high - low) / (high + low) / (2.0 * BEND * STEP))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Climbs on `impulse(phase, period)`, phase in degrees, from `start` for `climbs` climbs.
    fn climb(start: f32, climbs: usize, impulse: impl Fn(f32, u32) -> f32) -> f32 {
        let mut phase = start;
        let mut period = 0;
        for _ in 0..climbs {
            let mut probe = PhaseProbe::default();
            loop {
                period += 1;
                let at = phase + 360.0 * probe.offset_turns();
                if let Some(distance) = probe.strobe(impulse(at, period)) {
                    phase += 360.0 * distance;
                    break;
                }
            }
        }
        phase
    }

    #[test]
    fn a_hill_is_climbed_from_either_side_and_its_top_is_kept() {
        let hill = |phase: f32, _| 0.024 * (1.0 - 1.45e-4 * (phase - 183.0) * (phase - 183.0));
        for start in [179.0, 183.0, 187.0] {
            let top = climb(start, 1, hill);
            assert!((top - 183.0).abs() < 0.1, "{start} led to {top}");
        }
    }

    #[test]
    fn an_impulse_that_drifts_moves_no_top() {
        let hill = |phase: f32, period: u32| {
            (1.0 - 1e-4 * period as f32) * (1.0 - 1.45e-4 * (phase - 183.0) * (phase - 183.0))
        };
        let top = climb(183.0, 1, hill);
        assert!((top - 183.0).abs() < 0.1, "{top}");
    }

    #[test]
    fn what_is_no_number_says_nothing_and_a_plain_moves_nothing() {
        assert!(climb(183.0, 1, |_, _| f32::NAN).is_nan());
        assert!(climb(183.0, 1, |_, _| 0.0).is_nan());
        assert_eq!(climb(183.0, 1, |_, _| 1.0), 183.0);
    }

    #[test]
    fn a_climb_goes_six_degrees_up_down_down_up_and_back() {
        let mut probe = PhaseProbe::default();
        for (visit, degrees) in [6.0, -6.0, -6.0, 6.0, 0.0].into_iter().enumerate() {
            for period in 1..=30 {
                assert!((360.0 * probe.offset_turns() - degrees).abs() < 1e-4);
                let ends = probe.strobe(0.024).is_some();
                assert_eq!(ends, visit == 4 && period == 30);
            }
        }
        assert_eq!(probe.offset_turns(), 0.0);
    }

    #[test]
    fn the_six_contacts_after_each_change_do_not_count_and_the_mean_of_the_others_does() {
        let hill = |phase: f32| 0.024 * (1.0 - 1.45e-4 * (phase - 183.0) * (phase - 183.0));
        let top = climb(181.0, 1, |phase, period| match (period - 1) % 30 {
            0..6 => 10.0,
            // Contacts alternate by 2 %.
            k if k % 2 == 0 => 1.01 * hill(phase),
            _ => 0.99 * hill(phase),
        });
        assert!((top - 183.0).abs() < 0.1, "{top}");
        // Nor does what comes while the phase returns.
        let top = climb(
            181.0,
            1,
            |phase, period| if period > 120 { 0.0 } else { hill(phase) },
        );
        assert!((top - 183.0).abs() < 0.1, "{top}");
    }
}
