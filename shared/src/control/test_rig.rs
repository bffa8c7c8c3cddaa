//! A rig for the tests of the controller: its cart goes where it is told, its hammer moves with it.

use std::vec::Vec;

use super::{BootInfo, Command, Controller, EventKind, Mode, State};
use crate::forecast::{Forecast, ForecastOrbit, ForecastRow, Target};
use crate::io::{AdcCode, Frame, Output};
use crate::model::params::WIRES;
use crate::model::regime::Regime;
use crate::settings::Settings;

/// A 1/1 at 3.6 Hz, entered at `entry_hz`.
pub fn target(entry_hz: f32) -> Target {
    Target {
        frequency_hz: 3.6,
        orbit: ForecastOrbit {
            force_n: 96.0,
            impulse_n_s: 0.031,
            approach_m_per_s: 0.08,
            onset_turns: 0.5,
            multiplier: 0.3,
            doubling_test: 0.9,
        },
        band_hz: (2.5, 4.8),
        doubling_hz: None,
        entry_hz,
    }
}

pub struct TestRig {
    pub controller: Controller,
    pub outputs: [Output; 10],
    pub chain_open: bool,
    /// The cart's motion over the one commanded.
    pub cart_gain: f32,
    /// What the hammer's sensor gives whatever the hammer does.
    pub hammer_stuck: Option<AdcCode>,
    random: u32,
}

impl TestRig {
    pub fn with(change: impl FnOnce(&mut Settings)) -> Self {
        let mut settings = Settings::for_rig(&WIRES);
        change(&mut settings);
        Self {
            controller: Controller::new(&settings, &BootInfo::STORED).unwrap(),
            outputs: [Output::SAFE; 10],
            chain_open: false,
            cart_gain: 1.0,
            hammer_stuck: None,
            random: 1,
        }
    }

    /// Whether the whole block drives.
    pub fn is_enabled(&self) -> bool {
        self.outputs.iter().all(|output| output.enable)
    }

    fn noise(&mut self) -> u16 {
        self.random = self
            .random
            .wrapping_mul(1_664_525)
            .wrapping_add(1_013_904_223);
        (self.random >> 16) as u16 % 4
    }

    pub fn block(&mut self) {
        let frames = self.outputs.map(|output| {
            // The cart's sensor has about the shaker's scale.
            let codes = (f32::from(output.dac.0) - 2048.0) * 1900.0 / 2047.0;
            let cart = self.cart_gain * codes;
            Frame {
                force: AdcCode(600 + self.noise()),
                hammer: self
                    .hammer_stuck
                    .unwrap_or(AdcCode((2048.0 + 0.3 * cart) as u16 + self.noise())),
                cart: AdcCode((2048.0 + cart) as u16 + self.noise()),
                emergency: self.chain_open,
            }
        });
        self.controller.block(&frames, &mut self.outputs);
    }

    pub fn pass(&mut self, seconds: f32) {
        for _ in 0..(2000.0 * seconds) as u32 {
            self.block();
        }
    }

    /// Answers the forecast that is asked for; from 2 to 5 Hz the hammer strikes with `strikes_n`.
    pub fn forecast_of(&mut self, target: Option<Target>, strikes_n: f32) {
        let request = self
            .controller
            .forecast_request()
            .expect("one is asked for");
        let rows = [2.0, 3.0, 4.0, 5.0].map(|frequency_hz| ForecastRow {
            frequency_hz,
            regime: if strikes_n > 0.0 {
                Regime::Aperiodic { impacts: 1 }
            } else {
                Regime::None
            },
            force_n: strikes_n,
            orbit: None,
        });
        self.controller.deliver(&Forecast {
            id: request.id,
            rows: rows.into_iter().collect(),
            target,
        });
    }

    /// Answers the forecast that is asked for; the hammer is nowhere sure to strike.
    pub fn forecast(&mut self, target: Option<Target>) {
        self.forecast_of(target, 0.0);
    }

    pub fn starts(&mut self, mode: Mode, state: State) {
        self.controller.command(Command::Start(mode)).unwrap();
        for _ in 0..60 * 2000 {
            if self.controller.state() == state {
                return;
            }
            self.block();
        }
        panic!("{:?}", self.controller.status());
    }

    pub fn events(&mut self) -> Vec<EventKind> {
        core::iter::from_fn(|| self.controller.take_event())
            .map(|event| event.kind)
            .collect()
    }
}
