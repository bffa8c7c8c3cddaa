//! Controller and forecast in programs in which time stands still between blocks.

use super::{BootInfo, Controller};
use crate::forecast::{Forecast, Forecaster};
use crate::io::{Frame, Output};
use crate::model::params::ParamError;
use crate::settings::Settings;

/// The results of an exchange besides the outputs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Exchanged {
    /// Whether a forecast was delivered before the block.
    pub delivered: bool,
}

/// Controller and forecast, the latter a fixed number of slices per block: the same run, bit for bit, on
/// the desktop and under QEMU.
#[derive(Clone, Debug)]
pub struct Lockstep {
    /// The controller: takes commands, gives status and events.
    pub controller: Controller,
    forecaster: Forecaster,
    waiting: bool,
}

impl Lockstep {
    /// Both at their start.
    ///
    /// # Errors
    /// If a setting is out of range: the first such.
    pub fn new(settings: &Settings, boot: &BootInfo) -> Result<Self, ParamError> {
        Ok(Self {
            controller: Controller::new(settings, boot)?,
            forecaster: Forecaster::new(),
            waiting: false,
        })
    }

    /// A block of samples, in ticks' order, against the set-points of the next block; then `slices` of the
    /// forecast. Frames and outputs are paired; of unequal numbers the shorter counts.
    pub fn exchange(&mut self, frames: &[Frame], outputs: &mut [Output], slices: u32) -> Exchanged {
        let exchanged = self.block(frames, outputs);
        self.idle(slices);
        exchanged
    }

    /// A block whose samples did not arrive.
    pub fn exchange_blind(&mut self, outputs: &mut [Output], slices: u32) -> Exchanged {
        let exchanged = self.blind_block(outputs);
        self.idle(slices);
        exchanged
    }

    /// The part of [`Self::exchange`] at control priority.
    pub fn block(&mut self, frames: &[Frame], outputs: &mut [Output]) -> Exchanged {
        let delivered = self.deliver();
        self.controller.block(frames, outputs);
        Exchanged { delivered }
    }

    /// The part of [`Self::exchange_blind`] at control priority.
    pub fn blind_block(&mut self, outputs: &mut [Output]) -> Exchanged {
        let delivered = self.deliver();
        self.controller.blind_block(outputs);
        Exchanged { delivered }
    }

    /// The last forecast that is done, for the reader; none while one is being made.
    pub fn forecast(&self) -> Option<&Forecast> {
        self.forecaster.result()
    }

    fn deliver(&mut self) -> bool {
        if !self.waiting {
            return false;
        }
        let Some(forecast) = self.forecaster.result() else {
            return false;
        };
        self.controller.deliver(forecast);
        self.waiting = false;
        true
    }

    /// The part of an exchange in idle time.
    pub fn idle(&mut self, slices: u32) {
        if let Some(request) = self.controller.forecast_request() {
            self.forecaster.start(&request);
            self.waiting = true;
        }
        for _ in 0..slices {
            if !self.forecaster.slice() {
                break;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::params::WIRES;

    /// Exchanges until the forecast is delivered.
    fn exchanges(exchange: impl Fn(&mut Lockstep) -> Exchanged) -> u32 {
        let mut node = Lockstep::new(&Settings::for_rig(&WIRES), &BootInfo::STORED).unwrap();
        for count in 1..1_000_000 {
            let had_one = node.forecast().is_some();
            let delivered = exchange(&mut node).delivered;
            assert_eq!(
                delivered, had_one,
                "delivered with the block after it is done"
            );
            let target_hz = node.controller.status().target_hz;
            if delivered {
                let made = node.forecast().and_then(|forecast| forecast.target);
                assert_eq!(made.map(|target| target.frequency_hz), Some(target_hz));
                return count;
            }
            assert_eq!(target_hz, 0.0);
        }
        panic!("no forecast");
    }

    #[test]
    fn a_forecast_takes_its_slices_with_samples_and_without_and_is_delivered_once() {
        let blind = |slices: u32| {
            exchanges(move |node| node.exchange_blind(&mut [Output::SAFE; 10], slices))
        };
        let sighted = |slices: u32| {
            exchanges(move |node| {
                node.exchange(&[Frame::default(); 10], &mut [Output::SAFE; 10], slices)
            })
        };
        let count = sighted(2000);
        assert!(count > 10, "{count}");
        assert_eq!(blind(2000), count);
        assert!(sighted(4000).abs_diff(count / 2) <= 1);
    }
}
