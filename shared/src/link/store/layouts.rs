//! The payload of a slot by its layout. What an earlier layout did not have gets the value that its program worked with.

use serde::Deserialize;

use crate::io::Channel;
use crate::model::cart::CartDrive;
use crate::model::contact::Law;
use crate::model::params::{RigParams, SupportParams};
use crate::settings::{
    Aim, Calibrations, Detection, DriveSettings, Interlock, Limits, OperatorSettings, Settings,
    Trips,
};

use super::LAYOUT;

/// The settings in a payload; none if the layout is not known, or there are too many bytes or too few.
pub(super) fn decode(layout: u16, payload: &[u8]) -> Option<Settings> {
    match layout {
        1 => exactly::<Layout1>(payload).map(|first| first.with(None)),
        2 => exactly::<Layout2>(payload)
            .map(|second| second.first.with(Some((second.operator, second.aim)))),
        LAYOUT => exactly(payload),
        _ => None,
    }
}

fn exactly<'a, T: Deserialize<'a>>(payload: &'a [u8]) -> Option<T> {
    match postcard::take_from_bytes(payload) {
        Ok((value, [])) => Some(value),
        _ => None,
    }
}

/// That of version 0.2.0.
#[derive(Deserialize)]
struct Layout1 {
    rig: Rig,
    force: Channel,
    hammer: Channel,
    cart: Channel,
    drive: DriveSettings,
    limits: Limits,
    trips: Trips,
    detection: Detection,
}

/// With who must be there and what is aimed at.
#[derive(Deserialize)]
struct Layout2 {
    first: Layout1,
    operator: OperatorSettings,
    aim: Aim,
}

/// A rig whose cart was prescribed.
#[derive(Deserialize)]
struct Rig {
    support: SupportParams,
    mass_kg: f64,
    cart_mass_kg: f64,
    amplitude_m: f64,
    gap_m: f64,
    contact: Law<f64>,
}

impl Layout1 {
    fn with(self, later: Option<(OperatorSettings, Aim)>) -> Settings {
        let rig = self.rig;
        let (operator, aim) = later.unwrap_or_default();
        Settings {
            rig: RigParams {
                support: rig.support,
                mass_kg: rig.mass_kg,
                cart_mass_kg: rig.cart_mass_kg,
                amplitude_m: rig.amplitude_m,
                gap_m: rig.gap_m,
                contact: rig.contact,
                cart: CartDrive::Prescribed,
            },
            force: self.force,
            hammer: self.hammer,
            cart: self.cart,
            drive: self.drive,
            limits: self.limits,
            trips: self.trips,
            detection: self.detection,
            operator,
            aim,
            interlock: Interlock::default(),
            calibration: Calibrations::default(),
        }
    }
}
