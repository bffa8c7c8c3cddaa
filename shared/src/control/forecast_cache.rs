//! The last forecast, as far as control needs it, and the request for the next.

use super::free::FreeSwing;
use crate::forecast::{Forecast, ForecastRequest, MAX_ROWS, Target};
use crate::model::params::RigParams;
use crate::model::regime::Regime;

/// Range of a forecast in natural frequencies: from below where 1/1 begins to above where it doubles, at
/// every gap of the chapter's map.
const FORECAST_RANGE: (f32, f32) = (0.8, 3.0);

/// Below this share of A0 the forecast, made for A0, says nothing of contacts.
const LEAST_SHARE: f32 = 0.2;

/// The last forecast and the request for the next.
#[derive(Clone, Debug, Default)]
pub struct ForecastCache {
    /// A request nobody has taken yet.
    wanted: Option<ForecastRequest>,
    /// The request that is waited for.
    awaited: Option<u32>,
    /// The last forecast's frequency to run at; none without a stable 1/1, or before the first forecast.
    target: Option<Target>,
    /// Whether a forecast has come at all.
    has_come: bool,
    /// The swing of a hammer that does not touch.
    free: FreeSwing,
    /// Frequency, and the force, N, with which a start from rest strikes there; 0 if it does not.
    strikes: heapless::Vec<(f32, f32), MAX_ROWS>,
}

impl ForecastCache {
    /// Requests a forecast of `rig`, as far as it lies within `limits_hz`, under number `id`.
    pub fn request(&mut self, id: u32, rig: &RigParams, limits_hz: (f32, f32)) {
        let natural_hz = rig.natural_frequency_hz() as f32;
        let (low, high) = limits_hz;
        let from = (FORECAST_RANGE.0 * natural_hz).max(low);
        let to = (FORECAST_RANGE.1 * natural_hz).min(high).max(from);
        self.awaited = Some(id);
        self.wanted = Some(ForecastRequest {
            id,
            rig: *rig,
            range_hz: (from, to),
            rows: MAX_ROWS as u8,
        });
    }

    /// Gives out the request that nobody has taken yet, once; `None` if there is none.
    pub fn take_request(&mut self) -> Option<ForecastRequest> {
        self.wanted.take()
    }

    /// Takes in a forecast of `rig`; false, and nothing changes, for one that was not requested last.
    pub fn take_in(&mut self, forecast: &Forecast, rig: &RigParams) -> bool {
        if self.awaited != Some(forecast.id) {
            return false;
        }
        self.awaited = None;
        self.has_come = true;
        self.target = forecast.target;
        self.free = FreeSwing::new(rig);
        self.strikes.clear();
        for row in &forecast.rows {
            // As many rows as fit: both have room for the same number.
            let strikes = row.regime != Regime::None;
            let force_n = if strikes { row.force_n } else { 0.0 };
            let _ = self.strikes.push((row.frequency_hz, force_n));
        }
        true
    }

    /// Whether one was requested and has not come.
    pub fn is_awaited(&self) -> bool {
        self.awaited.is_some()
    }

    /// Whether a forecast has come at all.
    pub fn has_come(&self) -> bool {
        self.has_come
    }

    /// The target's frequency, Hz, and force, N; 0 without a target.
    pub fn target_point(&self) -> (f32, f32) {
        let target = self.target.as_ref();
        target.map_or((0.0, 0.0), |t| (t.frequency_hz, t.orbit.force_n))
    }

    /// Whether there may be a stable 1/1 at `hz`: within the target's band, or without a target.
    pub fn may_have_one_one_at(&self, hz: f32) -> bool {
        let target = self.target.as_ref();
        target.is_none_or(|target| (target.band_hz.0..=target.band_hz.1).contains(&hz))
    }

    /// The largest force that the forecast has between these frequencies and one row beyond, for an amplitude of
    /// `amplitude_m` and in proportion to it, N. None without a forecast.
    ///
    /// Above its last row the hammer strikes in every second or third period only, at most as hard as at the target, in
    /// proportion to the frequency: a 1/n at n times the target's frequency is a 1/1 of a cart n times as fast.
    pub fn largest_force_n(&self, (from_hz, to_hz): (f32, f32), amplitude_m: f32) -> Option<f32> {
        let share = self.free.share_of_full(amplitude_m);
        let (low, high) = (from_hz.min(to_hz), from_hz.max(to_hz));
        let (target_hz, target_n) = self.target_point();
        let mut largest_n = if (low..=high).contains(&target_hz) {
            target_n
        } else {
            0.0
        };
        let mut below = 0.0_f32;
        for &(row_hz, row_n) in &self.strikes {
            if row_hz < low {
                below = row_n;
                continue;
            }
            largest_n = largest_n.max(row_n);
            if row_hz > high {
                break;
            }
        }
        let is_beyond = self
            .strikes
            .last()
            .is_some_and(|&(last_hz, _)| last_hz < high);
        if is_beyond && target_hz > 0.0 {
            largest_n = largest_n.max(target_n * high / target_hz);
        }
        self.has_come.then(|| largest_n.max(below) * share)
    }

    /// Whether there must be a contact of more than `force_n` at `hz` with a cart amplitude of `amplitude_m`: the
    /// forecast has it from rest on both sides, with force in proportion to the amplitude, and a free swing would
    /// touch.
    pub fn must_strike_at(&self, hz: f32, amplitude_m: f32, force_n: f32) -> bool {
        let share = self.free.share_of_full(amplitude_m);
        if share < LEAST_SHARE || !self.free.must_touch(hz, amplitude_m) {
            return false;
        }
        let strikes = |row_n: f32| row_n * share > force_n;
        let mut below = None;
        for &(row_hz, row_n) in &self.strikes {
            if row_hz > hz {
                return strikes(row_n) && strikes(below.unwrap_or(row_n));
            }
            below = Some(row_n);
        }
        below.is_some_and(strikes)
    }

    /// The target, entered where the hammer must strike. (The forecast starts from rest at full amplitude; the
    /// amplitude of a real start rises slowly, and its swing follows the free one.)
    pub fn entered_target(&self) -> Option<Target> {
        let target = self.target?;
        let certain_hz = self.free.certain_up_to(target.entry_hz);
        Some(Target {
            entry_hz: certain_hz.min(target.entry_hz),
            ..target
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::forecast::{ForecastOrbit, ForecastRow};
    use crate::model::params::WIRES;

    /// A forecast whose rows strike or do not.
    fn forecast(id: u32, rows: &[(f32, bool)], entry_hz: f32) -> Forecast {
        let mut forecast = Forecast {
            id,
            ..Forecast::default()
        };
        for &(frequency_hz, strikes) in rows {
            let regime = if strikes {
                Regime::Aperiodic { impacts: 3 }
            } else {
                Regime::None
            };
            let row = ForecastRow {
                frequency_hz,
                regime,
                force_n: if strikes { 80.0 } else { 0.0 },
                orbit: None,
            };
            forecast.rows.push(row).unwrap();
        }
        forecast.target = Some(Target {
            frequency_hz: 3.7,
            orbit: ForecastOrbit {
                force_n: 80.0,
                impulse_n_s: 0.03,
                approach_m_per_s: 0.08,
                onset_turns: 0.4,
                multiplier: 0.3,
                doubling_test: 0.9,
            },
            band_hz: (2.5, 4.0),
            doubling_hz: None,
            entry_hz,
        });
        forecast
    }

    #[test]
    fn what_is_requested_lies_within_the_limits() {
        let natural_hz = WIRES.natural_frequency_hz() as f32;
        let range = |limits: (f32, f32)| {
            let mut cache = ForecastCache::default();
            assert!(cache.take_request().is_none());
            cache.request(4, &WIRES, limits);
            let request = cache.take_request().unwrap();
            assert!(cache.take_request().is_none(), "once");
            assert_eq!((request.id, usize::from(request.rows)), (4, MAX_ROWS));
            (
                request.range_hz.0 / natural_hz,
                request.range_hz.1 / natural_hz,
            )
        };
        let close = |found: (f32, f32), wanted: (f32, f32)| {
            let off = (found.0 - wanted.0).abs().max((found.1 - wanted.1).abs());
            assert!(off < 1e-6, "{found:?} {wanted:?}");
        };
        close(range((0.1 * natural_hz, 9.0 * natural_hz)), FORECAST_RANGE);
        close(range((1.1 * natural_hz, 2.0 * natural_hz)), (1.1, 2.0));
        close(range((5.0 * natural_hz, 6.0 * natural_hz)), (5.0, 5.0));
    }

    #[test]
    fn only_the_forecast_requested_last_is_taken_in_and_only_once() {
        let mut cache = ForecastCache::default();
        assert_eq!(cache.target_point(), (0.0, 0.0));
        assert!(cache.entered_target().is_none());
        cache.request(4, &WIRES, (1.0, 5.0));
        cache.request(5, &WIRES, (1.0, 5.0));
        let rows = [(2.0, true)];
        assert!(!cache.take_in(&forecast(4, &rows, 3.7), &WIRES));
        assert!(!cache.has_come() && cache.target_point() == (0.0, 0.0));
        assert!(cache.take_in(&forecast(5, &rows, 3.7), &WIRES));
        assert!(cache.has_come() && cache.target_point() == (3.7, 80.0));
        assert!(!cache.take_in(&forecast(5, &rows, 3.7), &WIRES));
    }

    #[test]
    fn the_hammer_must_strike_between_rows_that_strike_if_its_free_swing_reaches() {
        let rows = [(2.0, false), (2.5, true), (3.0, true), (3.5, false)];
        let mut cache = ForecastCache::default();
        cache.request(0, &WIRES, (1.0, 5.0));
        assert!(
            !cache.must_strike_at(2.7, WIRES.amplitude_m as f32, 14.0),
            "no forecast yet"
        );
        assert!(cache.take_in(&forecast(0, &rows, 3.7), &WIRES));
        // At no gap, every free swing touches.
        for (hz, expected) in [
            (1.9, false),
            (2.2, false),
            (2.5, true),
            (2.7, true),
            (3.2, false),
            (3.6, false),
        ] {
            assert_eq!(
                cache.must_strike_at(hz, WIRES.amplitude_m as f32, 14.0),
                expected,
                "{hz}"
            );
        }
        assert_eq!(cache.entered_target().unwrap().entry_hz, 3.7);
        let all = rows.map(|(hz, _)| (hz, true));
        cache.request(1, &WIRES, (1.0, 5.0));
        assert!(cache.take_in(&forecast(1, &all, 3.7), &WIRES));
        assert!([1.9, 2.2, 3.6].iter().all(|hz| cache.must_strike_at(
            *hz,
            WIRES.amplitude_m as f32,
            14.0
        )));
        // With a gap of 2.4 mm the free swing, A0 r²/(r² − 1), falls short of it above 1.37 natural frequencies at the latest.
        let open = WIRES.with_gap_mm(2.4).unwrap();
        cache.request(2, &open, (1.0, 5.0));
        assert!(cache.take_in(&forecast(2, &all, 3.7), &open));
        assert!(
            cache.must_strike_at(2.0, WIRES.amplitude_m as f32, 14.0)
                && !cache.must_strike_at(2.6, WIRES.amplitude_m as f32, 14.0)
        );
        let target = cache.entered_target().unwrap();
        assert!((2.0..2.6).contains(&target.entry_hz), "{target:?}");
        assert_eq!(target.frequency_hz, 3.7);
    }

    #[test]
    fn above_its_last_row_the_largest_force_goes_with_the_frequency() {
        let mut cache = ForecastCache::default();
        cache.request(0, &WIRES, (1.0, 5.0));
        assert!(cache.take_in(&forecast(0, &[(2.0, true), (5.0, true)], 3.7), &WIRES));
        let full_m = WIRES.amplitude_m as f32;
        // 80 N at 3.7 Hz.
        for (hz, share, expected_n) in [
            (4.9, 1.0, 80.0),
            (5.0, 1.0, 80.0),
            (7.4, 1.0, 160.0),
            (7.4, 0.5, 80.0),
        ] {
            let largest_n = cache.largest_force_n((hz, hz), share * full_m).unwrap();
            assert!((largest_n - expected_n).abs() < 1e-3, "{hz}: {largest_n}");
        }
    }

    #[test]
    fn a_small_motion_need_not_strike_and_the_force_goes_with_the_amplitude() {
        let mut cache = ForecastCache::default();
        cache.request(0, &WIRES, (1.0, 5.0));
        assert!(cache.take_in(&forecast(0, &[(2.0, true), (3.0, true)], 3.7), &WIRES));
        let full_m = WIRES.amplitude_m as f32;
        // 80 N at A0: 40 N at half of it.
        assert!(cache.must_strike_at(2.5, 0.5 * full_m, 39.0));
        assert!(!cache.must_strike_at(2.5, 0.5 * full_m, 41.0));
        // Below a fifth of A0 the forecast says nothing.
        assert!(cache.must_strike_at(2.5, 0.21 * full_m, 1.0));
        assert!(!cache.must_strike_at(2.5, 0.19 * full_m, 1.0));
    }
}
