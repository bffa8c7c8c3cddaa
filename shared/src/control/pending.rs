//! Stand-ins until sensing, identification and forecast are in.

use crate::drive::Drive;
use crate::forecast::{Forecast, Request};
use crate::regime::Regime;
use crate::sense::{Measured, Pulse, Sample, Seen};
use crate::settings::Settings;

#[derive(Clone, Debug)]
pub struct Sense;
impl Sense {
    pub fn new(_: &Settings) -> Self {
        Self
    }
    pub fn tick(&mut self, _: Sample, _: u32, _: &Drive<f32>) -> Seen {
        Seen::default()
    }
    pub fn measured(&self) -> Measured {
        Measured {
            regime: Regime::None,
            periods: 0,
        }
    }
    pub fn set_zero(&mut self, _: f32, _: f32) {}
    pub fn relative(&self) -> (f32, f32) {
        (0.0, 0.0)
    }
    pub fn reset(&mut self) {}
}

#[derive(Clone, Debug)]
pub struct Identify;
impl Identify {
    pub fn new(_: &Settings) -> Self {
        Self
    }
    pub fn pulse(&mut self, _: &Pulse) {}
}

#[derive(Clone, Debug)]
pub struct Forecaster;
impl Forecaster {
    pub fn new() -> Self {
        Self
    }
    pub fn start(&mut self, _: &Request) {}
    pub fn slice(&mut self) -> bool {
        false
    }
    pub fn result(&self) -> Option<&Forecast> {
        None
    }
}
