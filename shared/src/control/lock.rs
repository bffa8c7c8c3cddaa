//! The lock: the frequency follows the phase at which the hammer strikes.
//!
//! In 1/1 the hammer meets the surface at a phase of the cart's own motion that rises steadily with the frequency, from
//! some 80° where 1/1 begins to some 245° where it doubles. At the optimum it is near 180° at every gap and on every rig:
//! the hammer strikes as the cart passes the middle of its travel at full speed. Force and impulse are flat there; the
//! phase is steep: about one turn per relative frequency. So one contact tells where the optimum lies to a thousandth of
//! the frequency, and from which side. The field calls control by this phase autoresonant (Babitsky et al., Mechatronics
//! 14, 2004, p. 91).
//!
//! The phase wanted is that of the forecast's target ([`crate::forecast::ForecastOrbit::onset_turns`]), corrected by what rare
//! climbs find ([`super::probe`]) and, for some time after 1/1 was lost or doubled, moved towards the safe side.

/// Share of the phase error that each contact corrects.
const GAIN: f32 = 0.4;
/// Drive periods by which a change of the phase error is carried on: the phase lags behind a frequency that moves.
const LEAD: f32 = 0.5;
/// Phase of the contact over relative frequency, turns: 0.97 at no gap, 1.2 at 2.4 mm (forecasts of the wires).
const SLOPE: f32 = 1.0;
/// Largest phase error that a contact corrects for, and largest change of it that is carried on, turns: a longer way is gone
/// in steps.
const LARGEST: f32 = 0.1;
/// How far beyond the strongest contact the most impact power lies, turns. Energy per contact goes with the square of the
/// impulse, 1 − 2 c δ², contacts per second with the frequency, 1 + δ/slope: their product is largest at δ = 1/(4 c slope),
/// 4.9° at no gap and 4° at 2.4 mm.
const POWER: f32 = 4.6 / 360.0;
/// Share of the distance found by a climb that is gone at once: one climb is noisy, many are not.
const SHARE: f32 = 0.5;
/// Longest correction by one climb, turns.
const REACH: f32 = 2.0 / 360.0;
/// Farthest that climbs may move the phase from the forecast's, turns.
const TRIM: f32 = 5.0 / 360.0;
/// By how much the phase retreats when 1/1 was lost or doubled, turns.
const RETREAT: f32 = 5.0 / 360.0;
/// Farthest that all retreats together may move the phase, turns.
const FARTHEST: f32 = 20.0 / 360.0;
/// What comes back of a retreat per drive period with one contact: half of it in 70 periods.
const RETURN: f32 = 0.01;

/// The phase wanted, and where it comes from.
#[derive(Clone, Copy, Debug, Default)]
pub struct PhaseLock {
    forecast_turns: f32,
    /// Distance wanted from the phase of the strongest contact, turns.
    lead_turns: f32,
    trim_turns: f32,
    retreat_turns: f32,
    /// Error of the contact before, turns.
    last_turns: f32,
}

impl PhaseLock {
    /// A lock to the phase of the forecast's target, turns; `power`: to that of the most impact power.
    pub fn new(forecast_turns: f32, power: bool) -> Self {
        Self {
            forecast_turns,
            lead_turns: if power { POWER } else { 0.0 },
            ..Self::default()
        }
    }

    /// A new forecast: what climbs have found stays.
    pub fn retarget(&mut self, forecast_turns: f32) {
        self.forecast_turns = forecast_turns;
    }

    /// The phase wanted, turns.
    pub fn wanted_turns(&self) -> f32 {
        self.forecast_turns + self.lead_turns + self.trim_turns - self.retreat_turns
    }

    /// A climb has found the strongest contact at this distance from the phase held, turns.
    pub fn correct(&mut self, distance_turns: f32) {
        let moved = SHARE * (distance_turns + self.lead_turns);
        if moved.is_finite() {
            let trim = self.trim_turns + moved.clamp(-REACH, REACH);
            self.trim_turns = trim.clamp(-TRIM, TRIM);
        }
    }

    /// 1/1 was lost: the next contact's error is no change of the last one's.
    pub fn lose(&mut self) {
        self.last_turns = 0.0;
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
    pub fn next_hz(&mut self, frequency_hz: f32, error_turns: f32) -> f32 {
        let change = (error_turns - self.last_turns).clamp(-LARGEST, LARGEST);
        self.last_turns = error_turns;
        let error = (error_turns + LEAD * change).clamp(-LARGEST, LARGEST);
        frequency_hz * (1.0 - GAIN / SLOPE * error)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Periods until the phase stays within `within` turns, for a phase of `slope` turns per relative frequency, and the
    /// frequency then, relative to the best.
    fn settle(slope: f32, start: f32, within: f32) -> (usize, f32) {
        let mut lock = PhaseLock::new(0.508, false);
        let (mut relative, mut last_bad) = (start, 0);
        for period in 1..200 {
            let phase = 0.508 + slope * (relative - 1.0);
            let error = lock.error_turns(phase, 0.0);
            if error.abs() > within {
                last_bad = period;
            }
            relative = lock.next_hz(relative, error);
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

    /// What was carried on into the first contact after a loss moved the frequency by up to 2 %.
    #[test]
    fn after_a_loss_the_first_contact_is_as_after_a_start() {
        let start = PhaseLock::new(0.508, false).next_hz(3.6, 0.05);
        let mut lock = PhaseLock::new(0.508, false);
        lock.next_hz(3.6, -0.1);
        lock.lose();
        assert_eq!(lock.next_hz(3.6, 0.05), start);
        assert_ne!(lock.next_hz(3.6, 0.05), start, "the second one is not");
    }

    #[test]
    fn phases_wrap_and_a_retreat_passes() {
        let mut lock = PhaseLock::new(0.95, false);
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
        lock.correct(f32::NAN);
        lock.correct(1.0);
        assert!((lock.wanted_turns() - (0.95 + 2.0 / 360.0)).abs() < 1e-4);
        for _ in 0..9 {
            lock.correct(1.0);
        }
        assert!((lock.wanted_turns() - (0.95 + 5.0 / 360.0)).abs() < 1e-4);
        // A new forecast keeps what the climbs have found.
        lock.retarget(0.9);
        assert!((lock.wanted_turns() - (0.9 + 5.0 / 360.0)).abs() < 1e-4);
    }

    #[test]
    fn the_most_power_lies_beyond_the_strongest_contact_and_climbs_keep_it_there() {
        let mut lock = PhaseLock::new(0.5, true);
        let power = lock.wanted_turns();
        assert!((power - 0.5 - 4.6 / 360.0).abs() < 1e-6);
        // The strongest contact is where the forecast has it: nothing to correct.
        lock.correct(0.5 - power);
        assert!((lock.wanted_turns() - power).abs() < 1e-6);
        // Energy times rate, at no gap: c and slope as measured there.
        let rate = |degrees: f32| 1.0 + degrees / 360.0 / 0.97;
        let energy = |degrees: f32| 1.0 - 2.0 * 1.45e-4 * degrees * degrees;
        let best = (0..100).map(|k| 0.1 * k as f32).max_by(|a, b| {
            let power = |degrees: f32| rate(degrees) * energy(degrees);
            power(*a).total_cmp(&power(*b))
        });
        assert!((best.unwrap() - 4.9).abs() < 0.3, "{best:?}");
    }
}
