//! The controller with the little of a rig that it needs.

use shared::control::{BootInfo, Command, Controller, MAX_BLOCK, State};
use shared::fault::Fault;
use shared::forecast::{Forecast, ForecastOrbit, ForecastRow, Target};
use shared::io::{AdcCode, Frame, Output};
use shared::model::params::WIRES;
use shared::model::regime::Regime;
use shared::settings::{Settings, TICK_RATE_HZ};

/// A forecast of a 1/1 about 3.6 Hz.
pub fn forecast(id: u32) -> Forecast {
    let orbit = ForecastOrbit {
        force_n: 96.0,
        impulse_n_s: 0.031,
        approach_m_per_s: 0.08,
        onset_turns: 0.4,
        multiplier: 0.3,
        doubling_test: 0.9,
    };
    let rows = [2.0, 3.0, 4.0, 5.0].map(|frequency_hz| ForecastRow {
        frequency_hz,
        regime: Regime::Periodic {
            impacts: 1,
            periods: 1,
        },
        force_n: 90.0,
        orbit: Some(orbit),
    });
    Forecast {
        id,
        rows: rows.into_iter().collect(),
        target: Some(Target {
            frequency_hz: 3.6,
            orbit,
            band_hz: (2.5, 4.8),
            doubling_hz: Some(4.8),
            entry_hz: 3.6,
        }),
    }
}

/// What happens in a block.
#[derive(Clone, Debug)]
pub enum Happening {
    /// Samples of a rig that moves as told, with noise of so many codes.
    Sound { noise: u16 },
    /// Samples with pulses of force, codes above zero.
    Striking { code: u16 },
    /// Samples of these codes: force, hammer, cart.
    Wild { codes: [u16; 3] },
    /// The emergency chain opens.
    Emergency,
    /// Samples that do not arrive.
    Blind,
    /// The control task ends too late.
    Overrun,
    /// A command is given.
    Told(Command),
}

/// The controller with the little of a rig it needs: a cart that goes where it is told.
pub struct Bench {
    pub settings: Settings,
    pub controller: Controller,
    pub outputs: [Output; MAX_BLOCK],
    /// The forecast that it is given.
    pub forecast: fn(u32) -> Forecast,
    noise: u32,
}

impl Bench {
    /// The wires' settings, stored.
    pub fn new() -> Self {
        Self::born(&Settings::for_rig(&WIRES), &BootInfo::STORED)
    }

    pub fn born(settings: &Settings, boot: &BootInfo) -> Self {
        Self {
            settings: *settings,
            controller: Controller::new(settings, boot).unwrap(),
            outputs: [Output::SAFE; MAX_BLOCK],
            forecast,
            noise: 1,
        }
    }

    fn random(&mut self, below: u16) -> u16 {
        self.noise = self
            .noise
            .wrapping_mul(1_664_525)
            .wrapping_add(1_013_904_223);
        if below == 0 {
            0
        } else {
            (self.noise >> 16) as u16 % below
        }
    }

    fn frame(&mut self, output: Output, happening: &Happening) -> Frame {
        // The cart's sensor has about the shaker's scale: 1900 against 2047 codes for 2.5 mm.
        let cart = (f32::from(output.dac.0) - 2048.0) * 1900.0 / 2047.0;
        let (noise, push) = match happening {
            Happening::Sound { noise } => (*noise, 0),
            Happening::Striking { code } => (3, *code),
            _ => (3, 0),
        };
        let mut sound = Frame {
            force: AdcCode(600 + push + self.random(noise + 1)),
            // The hammer goes with the cart; its sensor reads 4.8 times as far.
            hammer: AdcCode((2048.0 + cart / 4.8) as u16 + self.random(noise + 1)),
            cart: AdcCode((2048.0 + cart) as u16 + self.random(noise + 1)),
            emergency: false,
        };
        match happening {
            Happening::Wild { codes } => {
                [sound.force, sound.hammer, sound.cart] = codes.map(AdcCode);
            }
            Happening::Emergency => sound.emergency = true,
            _ => {}
        }
        sound
    }

    /// A block of so many ticks; the samples that the controller was given.
    pub fn block(&mut self, ticks: usize, happening: &Happening) -> Vec<Frame> {
        let outputs = self.outputs;
        let frames: Vec<Frame> = outputs[..ticks]
            .iter()
            .map(|output| self.frame(*output, happening))
            .collect();
        match happening {
            Happening::Blind => self.controller.blind_block(&mut self.outputs[..ticks]),
            _ => self.controller.block(&frames, &mut self.outputs[..ticks]),
        }
        if let Happening::Overrun = happening {
            self.controller.note_overrun();
        }
        if let Happening::Told(command) = happening {
            let _ = self.controller.command(*command);
        }
        while self.controller.take_event().is_some() {}
        if let Some(request) = self.controller.forecast_request() {
            self.controller.deliver(&(self.forecast)(request.id));
        }
        frames
    }

    /// Blocks of a sound rig until `state`, at most `seconds`.
    pub fn reaches(&mut self, state: State, seconds: u32) -> bool {
        for _ in 0..seconds * TICK_RATE_HZ / 10 {
            self.block(10, &Happening::Sound { noise: 4 });
            if self.controller.state() == state {
                return true;
            }
        }
        false
    }
}

/// The faults of the present episode.
pub fn episode(controller: &Controller) -> Vec<Fault> {
    let record = controller.status().fault;
    record.map_or(vec![], |record| record.episode.faults().collect())
}
