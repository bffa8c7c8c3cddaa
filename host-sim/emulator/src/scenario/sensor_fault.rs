//! A sensor fault as a scenario writes it: which sensors, what is wrong, and the numbers that go with it.

use serde::Deserialize;
use shared::settings::TICK_S;

use crate::sensors::{BadContactEnd, Defect, EmulatedSensor};
use files::UserError;

/// The sensors that a fault strikes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Which {
    /// The sensor of the contact force.
    #[default]
    Force,
    /// The sensor of the hammer's displacement.
    Hammer,
    /// The sensor of the cart's displacement.
    Cart,
    /// The displacement sensors of hammer and cart.
    Displacements,
    /// All three sensors.
    All,
}

impl From<EmulatedSensor> for Which {
    fn from(sensor: EmulatedSensor) -> Self {
        match sensor {
            EmulatedSensor::Force => Self::Force,
            EmulatedSensor::Hammer => Self::Hammer,
            EmulatedSensor::Cart => Self::Cart,
        }
    }
}

impl Which {
    fn has(self, sensor: EmulatedSensor) -> bool {
        match self {
            Self::All => true,
            Self::Displacements => sensor != EmulatedSensor::Force,
            one => one == sensor.into(),
        }
    }
}

/// What is wrong with a sensor.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SensorDefect {
    /// Its wire is open.
    #[default]
    Open,
    /// It is at its upper rail.
    Saturated,
    /// It is at its lower rail.
    SaturatedLow,
    /// Its code stays at the last value.
    Frozen,
    /// Its gain is wrong by `times`.
    Gain,
    /// Its supply is wrong by `times`: the signal at zero too.
    Supply,
    /// Its gain grows by `percent_per_s`.
    GainDrift,
    /// Its sign is reversed.
    Reversed,
    /// It is off by `offset_n` or `offset_um`.
    Offset,
    /// It goes off by `drift_n_per_s` or `drift_um_per_s`.
    OffsetDrift,
    /// It measures nothing, but has noise: its own, or `noise_n` or `noise_um`.
    Dead,
    /// It reads `delay_ms` late.
    Delayed,
    /// It reads later by `delay_ms_per_s`.
    DelayDrift,
    /// Its wire and that of the other displacement are exchanged.
    Swapped,
    /// It is at an end (`at`) in so many `ticks` `of` so many.
    Intermittent,
}

/// A sensor fault with the keys it may have.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SensorFault {
    /// The sensors that the fault strikes.
    pub sensor: Which,
    /// What is wrong with them.
    pub fault: SensorDefect,
    /// How many times too large it reads, or its supply is.
    pub times: Option<f64>,
    /// For so long, s; left out: to the end.
    pub for_s: Option<f64>,
    /// How fast its gain grows, %/s.
    pub percent_per_s: Option<f64>,
    /// Added to the force, N.
    pub offset_n: Option<f64>,
    /// Added to a displacement, µm.
    pub offset_um: Option<f64>,
    /// Added to the force per second, N/s.
    pub drift_n_per_s: Option<f64>,
    /// Added to a displacement per second, µm/s.
    pub drift_um_per_s: Option<f64>,
    /// Noise of a dead force sensor, N.
    pub noise_n: Option<f64>,
    /// Noise of a dead displacement sensor, µm.
    pub noise_um: Option<f64>,
    /// How late it reads, ms.
    pub delay_ms: Option<f64>,
    /// How fast its delay grows, ms/s.
    pub delay_ms_per_s: Option<f64>,
    /// Ticks at an end.
    pub ticks: Option<u32>,
    /// Length of the bad contact's cycle, ticks: of so many, `ticks` are at an end.
    pub of: Option<u32>,
    /// Where a bad contact pulls the signal; left out: as an open wire does.
    pub at: Option<BadContactEnd>,
}

/// Keys in N and µm of offset, drift and noise.
const OFFSET: [&str; 2] = ["offset_n", "offset_um"];
const DRIFT: [&str; 2] = ["drift_n_per_s", "drift_um_per_s"];
const NOISE: [&str; 2] = ["noise_n", "noise_um"];

impl SensorFault {
    /// Every number that was given but `for_s`: key, value and range.
    pub(super) fn numbers(&self) -> Vec<(&'static str, f64, (f64, f64))> {
        const REACH: (f64, f64) = (-1e5, 1e5);
        let count = |n: Option<u32>| n.map(f64::from);
        let of = f64::from(self.of.unwrap_or(u32::MAX));
        [
            ("times", self.times, (-100.0, 100.0)),
            ("percent_per_s", self.percent_per_s, (-1e4, 1e4)),
            (OFFSET[0], self.offset_n, REACH),
            (OFFSET[1], self.offset_um, REACH),
            (DRIFT[0], self.drift_n_per_s, REACH),
            (DRIFT[1], self.drift_um_per_s, REACH),
            (NOISE[0], self.noise_n, (0.0, REACH.1)),
            (NOISE[1], self.noise_um, (0.0, REACH.1)),
            ("delay_ms", self.delay_ms, (0.05, 10_000.0)),
            ("delay_ms_per_s", self.delay_ms_per_s, (0.0, 100.0)),
            ("of", count(self.of), (1.0, 1e9)),
            ("ticks", count(self.ticks), (1.0, of)),
        ]
        .into_iter()
        .filter_map(|(key, value, range)| Some((key, value?, range)))
        .collect()
    }

    /// The keys that the fault takes, and whether it needs them.
    fn takes(&self) -> (Vec<&'static str>, bool) {
        // Of a key in N and in µm, those that the sensors have.
        let units = |keys: [&'static str; 2]| {
            let force = self.sensor.has(EmulatedSensor::Force);
            let length =
                self.sensor.has(EmulatedSensor::Hammer) || self.sensor.has(EmulatedSensor::Cart);
            let keys = keys.into_iter().zip([force, length]);
            keys.filter_map(|(key, has)| has.then_some(key)).collect()
        };
        match self.fault {
            SensorDefect::Gain | SensorDefect::Supply => (vec!["times"], true),
            SensorDefect::GainDrift => (vec!["percent_per_s"], true),
            SensorDefect::Offset => (units(OFFSET), true),
            SensorDefect::OffsetDrift => (units(DRIFT), true),
            SensorDefect::Dead => (units(NOISE), false),
            SensorDefect::Delayed => (vec!["delay_ms"], true),
            SensorDefect::DelayDrift => (vec!["delay_ms_per_s"], true),
            SensorDefect::Intermittent => (vec!["ticks", "of"], true),
            SensorDefect::Open
            | SensorDefect::Saturated
            | SensorDefect::SaturatedLow
            | SensorDefect::Frozen
            | SensorDefect::Reversed
            | SensorDefect::Swapped => (vec![], false),
        }
    }

    /// Whether the keys are those of the fault.
    pub(super) fn check(&self) -> Result<(), UserError> {
        let (takes, needed) = self.takes();
        let given: Vec<_> = self.numbers().iter().map(|(key, ..)| *key).collect();
        let name = format!("{:?}", self.fault).to_lowercase();
        if let Some(key) = given.iter().find(|key| !takes.contains(key)) {
            let list = if takes.is_empty() {
                "no number".to_owned()
            } else {
                takes.join(" and ")
            };
            return Err(UserError::new(format!(
                "{key} goes with another fault; this one ({name}) takes {list}"
            )));
        }
        if self.at.is_some() && self.fault != SensorDefect::Intermittent {
            return Err(UserError::new(
                "at goes with fault = \"intermittent\" alone; leave it out",
            ));
        }
        if self.fault == SensorDefect::Swapped && self.sensor != Which::Displacements {
            return Err(UserError::new(
                "fault = \"swapped\" goes with sensor = \"displacements\"",
            ));
        }
        match takes.iter().find(|key| needed && !given.contains(key)) {
            None => Ok(()),
            Some(key) => Err(UserError::new(format!(
                "this fault ({name}) needs {key} = N"
            ))),
        }
    }

    /// The defect of each sensor, in the order of their codes.
    pub(super) fn defects(&self) -> [Option<Defect>; 3] {
        EmulatedSensor::ALL.map(|sensor| self.sensor.has(sensor).then(|| self.defect(sensor)))
    }

    fn defect(&self, sensor: EmulatedSensor) -> Defect {
        let of = |[newtons, micrometres]: [Option<f64>; 2]| match sensor {
            EmulatedSensor::Force => newtons,
            _ => micrometres.map(|um| 1e-6 * um),
        };
        let times = self.times.unwrap_or(1.0);
        match self.fault {
            SensorDefect::Open => Defect::Open,
            SensorDefect::Saturated => Defect::Saturated,
            SensorDefect::SaturatedLow => Defect::SaturatedLow,
            SensorDefect::Frozen => Defect::Frozen,
            SensorDefect::Gain => Defect::Gain(times),
            SensorDefect::Supply => Defect::Supply(times),
            SensorDefect::GainDrift => Defect::GainDrift(0.01 * self.percent_per_s.unwrap_or(0.0)),
            SensorDefect::Reversed => Defect::Reversed,
            SensorDefect::Swapped => Defect::Swapped,
            SensorDefect::Offset => {
                Defect::Offset(of([self.offset_n, self.offset_um]).unwrap_or(0.0))
            }
            SensorDefect::OffsetDrift => {
                Defect::OffsetDrift(of([self.drift_n_per_s, self.drift_um_per_s]).unwrap_or(0.0))
            }
            SensorDefect::Dead => Defect::Dead(of([self.noise_n, self.noise_um])),
            SensorDefect::Delayed => {
                let ticks = 1e-3 * self.delay_ms.unwrap_or(0.0) / TICK_S;
                Defect::Delayed(ticks.round() as u32)
            }
            SensorDefect::DelayDrift => {
                Defect::DelayDrift(1e-3 * self.delay_ms_per_s.unwrap_or(0.0))
            }
            SensorDefect::Intermittent => Defect::Intermittent {
                at: self.at.unwrap_or_default(),
                ticks: self.ticks.unwrap_or(1),
                of: self.of.unwrap_or(1),
            },
        }
    }

    /// In words, for the timeline.
    pub(super) fn text(&self) -> String {
        let who = match self.sensor {
            Which::Displacements => "displacement sensors".to_owned(),
            Which::All => "all sensors".to_owned(),
            one => format!("{one:?} sensor").to_lowercase(),
        };
        let number = |value: Option<f64>| value.unwrap_or(0.0);
        let both = |[newtons, um]: [Option<f64>; 2], rest: &str| {
            let force = newtons.map(|n| format!("{n} N{rest}"));
            let length = um.map(|um| format!("{um} µm{rest}"));
            let all: Vec<_> = force.into_iter().chain(length).collect();
            all.join(", ")
        };
        let what = match self.fault {
            SensorDefect::Gain => format!("reads {} times too large", number(self.times)),
            SensorDefect::Supply => format!("has {} times its supply", number(self.times)),
            SensorDefect::GainDrift => {
                format!("reads {} % more each second", number(self.percent_per_s))
            }
            SensorDefect::Reversed => "reads with its sign reversed".to_owned(),
            SensorDefect::Swapped => "exchanged with one another".to_owned(),
            SensorDefect::Offset => {
                format!("is off by {}", both([self.offset_n, self.offset_um], ""))
            }
            SensorDefect::OffsetDrift => format!(
                "drifts by {}",
                both([self.drift_n_per_s, self.drift_um_per_s], "/s")
            ),
            SensorDefect::Dead => "is dead but noisy".to_owned(),
            SensorDefect::Delayed => format!("is {} ms late", number(self.delay_ms)),
            SensorDefect::DelayDrift => {
                format!("is {} ms later each second", number(self.delay_ms_per_s))
            }
            SensorDefect::Intermittent => {
                let at = format!("{:?}", self.at.unwrap_or_default()).to_lowercase();
                let (ticks, of) = (self.ticks.unwrap_or(1), self.of.unwrap_or(1));
                format!("is {at} in {ticks} ticks of {of}")
            }
            SensorDefect::Open
            | SensorDefect::Saturated
            | SensorDefect::SaturatedLow
            | SensorDefect::Frozen => format!("{:?}", self.fault).to_lowercase(),
        };
        format!("{who} {what}")
    }
}
