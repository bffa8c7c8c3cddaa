//! Stand-ins until sensing, identification and forecast are in.

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
