//! The lock: the frequency follows the phase at which the hammer strikes.
//!
//! In 1/1 the hammer meets the surface at a phase of the cart's own motion that rises steadily with the frequency, from
//! some 80° where 1/1 begins to some 245° where it doubles. At the optimum it is near 180° at every gap and on every rig:
//! the hammer strikes as the cart passes the middle of its travel at full speed. Force and impulse are flat there; the
//! phase is steep: about one turn per relative frequency. So one contact tells where the optimum lies to a thousandth of
//! the frequency, and from which side. The field calls control by this phase autoresonant (Babitsky et al., Mechatronics
//! 14, 2004, p. 91).
//!
//! The phase wanted is that of the forecast's target ([`crate::forecast::Orbit::onset_turns`]), corrected by what rare
//! climbs find ([`super::probe`]) and, for some time after 1/1 was lost or doubled, moved towards the safe side.

/// Share of the phase error that each contact corrects.
const GAIN: f32 = 0.5;
/// Phase of the contact over relative frequency, turns: 0.97 at no gap, 1.2 at 2.4 mm (forecasts of the wires).
const SLOPE: f32 = 1.0;
/// Largest phase error that a contact corrects for, turns: a longer way is gone in steps.
const LARGEST: f32 = 0.1;
/// Farthest that climbs may move the phase from the forecast's, turns.
const TRIM: f32 = 5.0 / 360.0;
/// By how much the phase retreats when 1/1 was lost or doubled, turns.
const RETREAT: f32 = 5.0 / 360.0;
/// Farthest retreat, turns.
const FARTHEST: f32 = 20.0 / 360.0;
/// What comes back of a retreat per drive period with one contact: half of it in 70 periods.
const RETURN: f32 = 0.01;

/// The phase wanted, and where it comes from.
#[derive(Clone, Copy, Debug, Default)]
pub struct PhaseLock {
    forecast_turns: f32,
    trim_turns: f32,
    retreat_turns: f32,
}

impl PhaseLock {
    /// A lock to the phase of the forecast's target, turns.
    pub fn new(forecast_turns: f32) -> Self {
        Self {
            forecast_turns,
            ..Self::default()
        }
    }

    /// A new forecast: what climbs have found stays.
    pub fn retarget(&mut self, forecast_turns: f32) {
        self.forecast_turns = forecast_turns;
    }

    /// The phase wanted, turns.
    pub fn wanted_turns(&self) -> f32 {
        self.forecast_turns + self.trim_turns - self.retreat_turns
    }

    /// A climb has found a better phase, this far from the present one, turns.
    pub fn correct(&mut self, moved_turns: f32) {
        self.trim_turns = (self.trim_turns + moved_turns).clamp(-TRIM, TRIM);
    }

    /// 1/1 was lost or has doubled.
    pub fn retreat(&mut self) {
        self.retreat_turns = (self.retreat_turns + RETREAT).min(FARTHEST);
    }

    /// A drive period with one contact has passed.
    pub fn pass(&mut self) {
        self.retreat_turns -= RETURN * self.retreat_turns;
    }

    /// The phase measured less the one wanted `offset_turns` from the lock's own, turns, −½ to ½.
    pub fn error_turns(&self, phase_turns: f32, offset_turns: f32) -> f32 {
        let error = phase_turns - self.wanted_turns() - offset_turns;
        error - libm::floorf(error + 0.5)
    }

    /// The frequency that corrects a phase error at `frequency_hz`, Hz.
    pub fn next_hz(frequency_hz: f32, error_turns: f32) -> f32 {
        let error = error_turns.clamp(-LARGEST, LARGEST);
        frequency_hz * (1.0 - GAIN / SLOPE * error)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Periods until the phase stays within `within` turns, for a phase of `slope` turns per relative frequency, and the
    /// frequency then, relative to the best.
    fn settle(slope: f32, start: f32, within: f32) -> (usize, f32) {
        let lock = PhaseLock::new(0.508);
        let (mut relative, mut last_bad) = (start, 0);
        for period in 1..200 {
            let phase = 0.508 + slope * (relative - 1.0);
            let error = lock.error_turns(phase, 0.0);
            if error.abs() > within {
                last_bad = period;
            }
            relative = PhaseLock::next_hz(relative, error);
        }
        (last_bad, relative)
    }

    #[test]
    fn the_optimum_is_reached_from_either_side_whatever_the_slope() {
        for slope in [0.5, 0.97, 1.2, 2.0] {
            for start in [0.8, 0.98, 1.02, 1.2] {
                let (periods, relative) = settle(slope, start, 0.005);
                assert!(periods < 35, "{slope} from {start}: {periods} periods");
                assert!((relative - 1.0).abs() < 1e-4, "{slope} {start}: {relative}");
            }
        }
    }

    #[test]
    fn phases_wrap_and_a_retreat_passes() {
        let mut lock = PhaseLock::new(0.95);
        assert!((lock.error_turns(0.05, 0.0) - 0.1).abs() < 1e-6);
        lock.retreat();
        assert!((lock.wanted_turns() - (0.95 - 5.0 / 360.0)).abs() < 1e-6);
        for _ in 0..10 {
            lock.retreat();
        }
        assert!((lock.wanted_turns() - (0.95 - 20.0 / 360.0)).abs() < 1e-6);
        for _ in 0..1000 {
            lock.pass();
        }
        assert!((lock.wanted_turns() - 0.95).abs() < 1e-4);
        lock.correct(1.0);
        assert!((lock.wanted_turns() - (0.95 + 5.0 / 360.0)).abs() < 1e-4);
    }
}
