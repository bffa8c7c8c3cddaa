//! What is known of the future: the forecast as far as control needs it.

use super::free::FreeSwing;
use crate::forecast::{ForecastRequest, MAX_ROWS, Target};

/// What is known of the future.
#[derive(Clone, Debug, Default)]
pub struct ForecastCache {
    /// Number of the next request.
    pub next_id: u32,
    /// A request nobody has taken yet.
    pub wanted: Option<ForecastRequest>,
    /// The request that is waited for.
    pub awaited: Option<u32>,
    /// Where to run.
    pub target: Option<Target>,
    /// Whether a forecast has come at all.
    pub come: bool,
    /// The swing of a hammer that does not touch.
    pub free: FreeSwing,
    /// Frequency and whether a start from rest strikes there.
    pub strikes: heapless::Vec<(f32, bool), MAX_ROWS>,
}

impl ForecastCache {
    /// Whether there must be contact at `hz`: the forecast has it from rest on both sides, and a free swing
    /// would touch.
    pub fn must_strike_at(&self, hz: f32) -> bool {
        if !self.free.must_touch(hz) {
            return false;
        }
        let mut below = None;
        for &(row_hz, strikes) in &self.strikes {
            if row_hz > hz {
                return strikes && below.unwrap_or(strikes);
            }
            below = Some(strikes);
        }
        below.unwrap_or(false)
    }

    /// The forecast's target, entered where the hammer must strike. (The forecast starts from rest at full
    /// amplitude; the amplitude of a real start rises slowly, and its swing follows the free one.)
    pub fn entered(&self, target: &Target) -> Target {
        let certain_hz = self.free.certain_up_to(target.entry_hz);
        Target {
            entry_hz: certain_hz.min(target.entry_hz),
            ..*target
        }
    }
}
