//! The controller's settings: the rig, the calibration of sensors and shaker, limits and trip levels. They are
//! checked as a whole and replaced as a whole.

mod check;

pub use check::check_shaker;

use core::f64::consts::TAU;

use serde::{Deserialize, Serialize};

use crate::io::Channel;
use crate::model::contact::Law;
use crate::model::params::RigParams;

/// Control ticks per second: one sample and one set-point each.
pub const TICK_RATE_HZ: u32 = 20_000;

/// Length of a control tick, s.
pub const TICK_S: f64 = 1.0 / TICK_RATE_HZ as f64;

/// Whole control ticks in a time, s.
pub(crate) fn ticks_of(seconds: f32) -> u32 {
    (seconds * TICK_RATE_HZ as f32) as u32
}

/// What moves the cart.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum DriveKind {
    /// A shaker with a position loop: a set-point per tick through the DAC.
    Shaker,
    /// A motor with an eccentric: a frequency set-point; the amplitude is the mechanism's.
    Motor,
}

/// What drives the cart: its kind, its calibration, and how fast it may change.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct DriveSettings {
    /// What moves the cart.
    pub kind: DriveKind,
    /// Cart displacement per DAC code, m.
    pub m_per_code: f32,
    /// Fastest change of frequency, Hz/s.
    pub frequency_slew_hz_per_s: f32,
    /// Fastest change of amplitude, m/s.
    pub amplitude_slew_m_per_s: f32,
}

/// Limits: the controller stays within them and reports when they clamp. They are not faults.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Limits {
    /// Largest contact force held, N: the amplitude is reduced until the force is below.
    pub force_n: f32,
    /// Largest hammer displacement relative to the cart held, m: the amplitude is reduced.
    pub travel_m: f32,
    /// Lowest drive frequency, Hz.
    pub min_frequency_hz: f32,
    /// Highest drive frequency, Hz.
    pub max_frequency_hz: f32,
    /// Largest commanded cart amplitude, m.
    pub amplitude_m: f32,
}

/// Trip levels: beyond them the drive is switched off.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Trips {
    /// Contact force, N.
    pub force_n: f32,
    /// Hammer displacement relative to the cart, m.
    pub travel_m: f32,
    /// Cart displacement, m, either way.
    pub cart_m: f32,
    /// Longest time without contact where the forecast has one, s.
    pub no_contact_s: f32,
    /// Longest time without 1/1 while it is sought again, s.
    pub regime_lost_s: f32,
    /// Longest silence of the link while it steers, s; 0: no limit.
    pub link_timeout_s: f32,
}

/// Contact detection on the force signal.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Detection {
    /// A contact begins above this force, N.
    pub on_n: f32,
    /// It may end below this one, N.
    pub off_n: f32,
    /// And ends once the force has stayed below it this long, s: longer than the surface's ringing.
    pub refractory_s: f32,
}

/// Who must be there.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct OperatorSettings {
    /// In automatic mode, too, a program on the link must keep giving signs of life; without them the drive goes off
    /// after [`Trips::link_timeout_s`].
    pub heartbeat: bool,
    /// After an emergency stop, somebody must press the board's button before the fault can be cleared. And each start wants the
    /// chain to have been opened, and that acknowledged, since the last one: so its report is known to work.
    pub acknowledge: bool,
}

/// Which of the power stage's reports are wired to the board; one that is not is not looked at.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Interlock {
    /// A mirror contact of the relay that the enable holds.
    pub relay: bool,
    /// The power stage's "ready".
    pub ready: bool,
}

/// When a sensor was calibrated and how well. It changes nothing that the controller does: it is kept with the values it is
/// about, so that nobody measures by a calibration that nobody knows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Calibration {
    /// The day, as year · 10,000 + month · 100 + day; 0: never.
    pub day: u32,
    /// Expanded uncertainty (k = 2) of a reading, of full scale, %; 0: not known.
    pub uncertainty_percent: f32,
}

/// Those of the three sensors.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Calibrations {
    /// Calibration of the force sensor.
    pub force: Calibration,
    /// Calibration of the hammer's displacement sensor.
    pub hammer: Calibration,
    /// Calibration of the cart's displacement sensor.
    pub cart: Calibration,
}

/// What the controller aims at.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Aim {
    /// Mean peak force wanted, N: the amplitude is drawn up or down until it is there. 0: as it comes at the rig's
    /// amplitude.
    pub force_n: f32,
    /// The most impact power (energy per contact times contacts per second) instead of the strongest contact: the frequency
    /// is some 1 % higher.
    pub power: bool,
}

/// All settings of the controller, checked and replaced as a whole.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Settings {
    /// The believed rig; its `amplitude_m` is the amplitude held.
    pub rig: RigParams,
    /// Force sensor: its zero, and N per code.
    pub force: Channel,
    /// Hammer displacement sensor, fixed frame, m.
    pub hammer: Channel,
    /// Cart displacement sensor, fixed frame, m.
    pub cart: Channel,
    /// What drives the cart.
    pub drive: DriveSettings,
    /// Limits that the controller keeps without a fault.
    pub limits: Limits,
    /// Levels beyond which the drive is switched off.
    pub trips: Trips,
    /// How contacts are found on the force signal.
    pub detection: Detection,
    /// Who must be there.
    pub operator: OperatorSettings,
    /// What it aims at.
    pub aim: Aim,
    /// What the power stage reports.
    pub interlock: Interlock,
    /// When and how well the sensors were calibrated.
    pub calibration: Calibrations,
}

/// Peak force of a strong 1/1 at a gap of 0.0 mm in units of A0 ω √(ki m): 96 N on the wires of Tables
/// 3.1 and 3.2 (`host-sim pick`), and the same for the beams, whose force grows with ω.
const STRONG_FORCE: f64 = 7.4;

/// Its approach speed in units of A0 ω: 0.08 m/s on the wires.
const STRONG_SPEED: f64 = 7.9;

/// ki of Table 3.1, N/m, for the nonlinear laws: their presets make the same contact, in other units.
const CONTACT_STIFFNESS: f64 = 5.5e6;

/// Amplitude of the chapter's rigs, m: for which the ranges of displacement below are.
const USUAL_AMPLITUDE_M: f64 = 0.89e-3;

/// Peak force of a strong 1/1 at no gap and the rig's amplitude, N, for who has no forecast. Five ask for it: one copy is enough.
#[inline(never)]
pub fn strong_force_n(rig: &RigParams) -> f64 {
    let omega = TAU * rig.natural_frequency_hz();
    let stiffness = match rig.contact {
        Law::SpringDashpot { stiffness, .. } => stiffness,
        _ => CONTACT_STIFFNESS,
    };
    STRONG_FORCE * rig.amplitude_m * omega * libm::sqrt(stiffness * rig.mass_kg)
}

/// Approach speed of that contact, m/s.
pub fn strong_speed_m_per_s(rig: &RigParams) -> f64 {
    STRONG_SPEED * rig.amplitude_m * TAU * rig.natural_frequency_hz()
}

impl Settings {
    /// These settings for a rig that is really there: a program on the link must be heard while the drive is on, in
    /// automatic mode, too, and the emergency stop is tried before each start.
    #[must_use]
    pub fn for_real(mut self) -> Self {
        self.operator = OperatorSettings {
            heartbeat: true,
            acknowledge: true,
        };
        self
    }

    /// Settings for a rig with sensors and a shaker that suit it: force to about five times the strongest 1/1,
    /// displacements ±12 mm (hammer) and ±2.5 mm (cart), a shaker of ±2.5 mm, and with them limits and trip levels of
    /// displacement. Where the amplitude is above the chapter's 0.89 mm, these are larger in proportion.
    pub fn for_rig(rig: &RigParams) -> Self {
        let strong = strong_force_n(rig);
        let larger = (rig.amplitude_m / USUAL_AMPLITUDE_M).max(1.0) as f32;
        let strong_n = strong as f32;
        let natural_hz = rig.natural_frequency_hz() as f32;
        let amplitude_m = rig.amplitude_m as f32;
        let displacement = |full_m: f32| Channel {
            zero_code: 2048.0,
            unit_per_code: full_m / 1900.0,
        };
        Self {
            rig: *rig,
            force: Channel {
                zero_code: 600.0,
                unit_per_code: 5.0 * strong_n / 3300.0,
            },
            hammer: displacement(larger * 12e-3),
            cart: displacement(larger * 2.5e-3),
            drive: DriveSettings {
                kind: DriveKind::Shaker,
                m_per_code: larger * 2.5e-3 / 2047.0,
                frequency_slew_hz_per_s: 0.2 * natural_hz,
                amplitude_slew_m_per_s: amplitude_m,
            },
            limits: Limits {
                force_n: 2.5 * strong_n,
                travel_m: larger * 9e-3,
                min_frequency_hz: 0.3 * natural_hz,
                max_frequency_hz: 4.0 * natural_hz,
                amplitude_m: 1.5 * amplitude_m,
            },
            trips: Trips {
                force_n: 4.0 * strong_n,
                travel_m: larger * 10e-3,
                cart_m: larger * 2.0e-3,
                no_contact_s: 5.0,
                regime_lost_s: 60.0,
                link_timeout_s: 2.0,
            },
            detection: Detection {
                on_n: 0.15 * strong_n,
                off_n: 0.08 * strong_n,
                refractory_s: 1.5e-3,
            },
            operator: OperatorSettings::default(),
            aim: Aim::default(),
            interlock: Interlock::default(),
            calibration: Calibrations::default(),
        }
    }
}
