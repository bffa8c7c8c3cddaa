//! Stand-ins until sensing, identification and forecast are in.

use crate::forecast::{Forecast, Request};
use crate::sense::Pulse;
use crate::settings::Settings;

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
