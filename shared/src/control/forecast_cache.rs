//! The last forecast, as far as control needs it, and the request for the next.

use super::free::FreeSwing;
use crate::forecast::{Forecast, ForecastRequest, MAX_ROWS, Target};
use crate::model::params::RigParams;
use crate::model::regime::Regime;

/// Range of a forecast in natural frequencies: from below where 1/1 begins to above where it doubles, at
/// every gap of the chapter's map.
const FORECAST_RANGE: (f32, f32) = (0.8, 3.0);

/// Below this share of A0 the forecast, made for A0, says nothing of contacts.
const LEAST_SHARE: f32 = 0.4;

/// The last forecast and the request for the next.
#[derive(Clone, Debug, Default)]
pub struct ForecastCache {
    /// A request nobody has taken yet.
    wanted: Option<ForecastRequest>,
    /// The request that is waited for.
    awaited: Option<u32>,
    /// Where to run.
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

    /// The request, once.
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

    /// Whether a forecast has come at all.
    pub fn has_come(&self) -> bool {
        self.has_come
    }

    /// The target's frequency, Hz, and force, N; 0 without a target.
    pub fn target_point(&self) -> (f32, f32) {
        let target = self.target.as_ref();
        target.map_or((0.0, 0.0), |t| (t.frequency_hz, t.orbit.force_n))
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
