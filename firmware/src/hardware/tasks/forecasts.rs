//! The forecast, a slice at a time, in idle time.

use core::sync::atomic::{AtomicU32, Ordering};

use rtic::Mutex;
use shared::forecast::{Forecast, Forecaster};

use crate::recorder::ControlRecorder;

/// Turns of the idle loop (wraps).
static TURNS: AtomicU32 = AtomicU32::new(0);

/// Turns since the start (wraps).
pub fn turns() -> u32 {
    TURNS.load(Ordering::Relaxed)
}

/// What the idle loop owns.
pub struct Forecasts {
    forecaster: Forecaster,
    waiting: bool,
}

impl Default for Forecasts {
    fn default() -> Self {
        Self {
            forecaster: Forecaster::new(),
            waiting: false,
        }
    }
}

impl Forecasts {
    /// A turn of the idle loop: takes a request that waits, computes a slice, delivers a forecast that is done.
    #[inline]
    pub fn turn(
        &mut self,
        recorder: &mut impl Mutex<T = ControlRecorder>,
        forecast: &mut impl Mutex<T = Forecast>,
    ) {
        if let Some(request) = recorder.lock(|recorder| recorder.taking().forecast_request()) {
            self.forecaster.start(&request);
            self.waiting = true;
        }
        let busy = self.forecaster.slice();
        if let Some(result) = self.forecaster.result().filter(|_| self.waiting && !busy) {
            self.waiting = false;
            forecast.lock(|last| last.clone_from(result));
            recorder.lock(|recorder| recorder.deliver(result));
        }
        TURNS.fetch_add(1, Ordering::Relaxed);
    }
}
