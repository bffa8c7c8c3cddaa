//! What happens during a run, and when.

use serde::Deserialize;
use shared::control;
use shared::model::params::RigParams;
use toml::Value;

use super::change::RigChange;
use super::complaint::{not_understood, out_of_range};
use super::definition::LONGEST_S;
use super::hardware::{TILT_DEG, friction};
use super::sensor_fault::SensorFault;
use crate::cart::Friction;
use crate::sensors::Defect;
use crate::under_test::Reset;
use files::UserError;

/// Something that happens at a time.
#[derive(Clone, Debug, PartialEq)]
pub struct Timed {
    /// When, s of rig time.
    pub at_s: f64,
    /// What happens then.
    pub act: ScenarioAct,
}

/// How the controller runs after a start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum StartMode {
    /// It seeks and holds by itself.
    #[default]
    Automatic,
    /// It follows the set-points that it is given.
    Manual,
}

impl From<StartMode> for control::Mode {
    fn from(mode: StartMode) -> Self {
        match mode {
            StartMode::Automatic => Self::Automatic,
            StartMode::Manual => Self::Manual,
        }
    }
}

/// What a drive does that does not obey its enable line.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Stuck {
    /// It goes on with the motion that it had.
    #[default]
    RunsOn,
    /// It keeps its power and follows its set-point.
    Powered,
}

fn once() -> u32 {
    1
}

/// An event of a scenario.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum ScenarioAct {
    /// The command to start.
    Start {
        /// By itself, or by hand.
        #[serde(default)]
        mode: StartMode,
    },
    /// The command to stop.
    Stop {},
    /// The command to clear the fault.
    ClearFault {},
    /// Somebody at the rig acknowledges an emergency stop.
    Acknowledge {},
    /// A set-point for manual mode.
    SetPoint {
        /// Drive frequency, Hz.
        frequency_hz: f64,
        /// Amplitude of the cart, mm.
        amplitude_mm: f64,
    },
    /// From now on the link is in command and sends its keep-alive twice a second.
    Link {},
    /// The link falls silent.
    LinkLoss {},
    /// The emergency-stop chain opens.
    EmergencyStop {
        /// For so long, s; left out: to the end.
        for_s: Option<f64>,
    },
    /// One or more sensors become defective.
    SensorFault(SensorFault),
    /// The hammer is pushed.
    Push {
        /// Change of its speed towards the surface, m/s.
        speed_m_per_s: f64,
    },
    /// The control task overruns before each of so many blocks.
    Overrun {
        /// How many blocks are hit; 1 if left out.
        #[serde(default = "once")]
        blocks: u32,
        /// One block in so many.
        #[serde(default = "once")]
        every: u32,
    },
    /// Blocks of samples are lost.
    LostBlock {
        /// How many blocks are lost; 1 if left out.
        #[serde(default = "once")]
        blocks: u32,
        /// One block in so many.
        #[serde(default = "once")]
        every: u32,
    },
    /// The true rig changes steadily into another.
    Drift {
        /// In so long, s.
        over_s: f64,
        /// Natural frequency, % more.
        #[serde(default)]
        natural_frequency_percent: f64,
        /// Contact stiffness, % more.
        #[serde(default)]
        contact_stiffness_percent: f64,
        /// Contact damping, % more.
        #[serde(default)]
        contact_damping_percent: f64,
        /// Clearance added to the gap, mm; may be negative.
        #[serde(default)]
        gap_offset_mm: f64,
        /// Restitution that the surface comes to have.
        restitution: Option<f64>,
    },
    /// The impact surface recedes from the hammer.
    Recede {
        /// By the energy that each blow leaves in it, mm/J.
        #[serde(default)]
        mm_per_j: f64,
        /// All the time, mm/s.
        #[serde(default)]
        mm_per_s: f64,
        /// At most so far, mm.
        up_to_mm: Option<f64>,
        /// For so long, s; left out: to the end.
        for_s: Option<f64>,
    },
    /// The drive no longer obeys its enable line.
    StuckDrive {
        /// What it does while the line is low.
        #[serde(default)]
        how: Stuck,
        /// For so long, s; left out: to the end.
        for_s: Option<f64>,
    },
    /// The whole rig tilts.
    Tilt {
        /// To so many degrees.
        degrees: f64,
        /// In so long, s.
        #[serde(default)]
        over_s: f64,
    },
    /// The friction of the cart's guide changes.
    CartFriction {
        /// While it slides, N.
        coulomb_n: Option<f64>,
        /// Before it slides, N.
        static_n: Option<f64>,
        /// Viscous friction per speed of the cart, N·s/m.
        viscous_n_s_per_m: Option<f64>,
        /// For so long, s; left out: to the end.
        for_s: Option<f64>,
    },
    /// The controller is reset.
    Reset {
        /// Why it is reset, which it finds out when it starts.
        cause: Reset,
    },
}

impl ScenarioAct {
    /// The change a drift makes.
    pub fn change(&self) -> Option<(RigChange, f64)> {
        match *self {
            Self::Drift {
                over_s,
                natural_frequency_percent,
                contact_stiffness_percent,
                contact_damping_percent,
                gap_offset_mm,
                restitution,
            } => Some((
                RigChange {
                    natural_frequency_percent,
                    contact_stiffness_percent,
                    contact_damping_percent,
                    gap_offset_mm,
                    restitution,
                },
                over_s,
            )),
            _ => None,
        }
    }

    /// The defects of a sensor fault, in the order of the sensors' codes.
    pub fn defects(&self) -> [Option<Defect>; 3] {
        match self {
            Self::SensorFault(how) => how.defects(),
            _ => [None; 3],
        }
    }

    /// Numbers with a range: key, value, and the range.
    fn numbers(&self) -> Vec<(&'static str, f64, (f64, f64))> {
        let long = |s: Option<f64>| ("for_s", s.unwrap_or(1.0), (1e-6, LONGEST_S));
        match *self {
            Self::SetPoint {
                frequency_hz,
                amplitude_mm,
            } => vec![
                ("frequency_hz", frequency_hz, (1e-3, 1e4)),
                ("amplitude_mm", amplitude_mm, (0.0, 100.0)),
            ],
            Self::EmergencyStop { for_s } => vec![long(for_s)],
            Self::SensorFault(how) => {
                let mut numbers = how.numbers();
                numbers.push(long(how.for_s));
                numbers
            }
            Self::Push { speed_m_per_s } => vec![("speed_m_per_s", speed_m_per_s, (-10.0, 10.0))],
            Self::Overrun { blocks, every } | Self::LostBlock { blocks, every } => {
                let most = (1.0, f64::from(u32::MAX));
                vec![
                    ("blocks", f64::from(blocks), most),
                    ("every", f64::from(every), most),
                ]
            }
            Self::Drift { over_s, .. } => vec![("over_s", over_s, (0.0, LONGEST_S))],
            Self::Recede {
                mm_per_j,
                mm_per_s,
                up_to_mm,
                for_s,
            } => vec![
                ("mm_per_j", mm_per_j, (0.0, 1e4)),
                ("mm_per_s", mm_per_s, (0.0, 100.0)),
                ("up_to_mm", up_to_mm.unwrap_or(1.0), (0.0, 50.0)),
                long(for_s),
            ],
            Self::StuckDrive { for_s, .. } | Self::CartFriction { for_s, .. } => vec![long(for_s)],
            Self::Tilt { degrees, over_s } => vec![
                ("degrees", degrees, TILT_DEG),
                ("over_s", over_s, (0.0, LONGEST_S)),
            ],
            _ => vec![],
        }
    }

    /// Checks its numbers, and that a drift leaves `rig` valid.
    fn check(&self, rig: &RigParams) -> Result<(), UserError> {
        for (key, value, (from, to)) in self.numbers() {
            if !(from..=to).contains(&value) {
                return Err(out_of_range(key, value, &format!("{from} to {to}")));
            }
        }
        match *self {
            Self::SensorFault(how) => how.check(),
            Self::Drift { .. } => {
                let (change, _) = self.change().unwrap_or_default();
                if change == RigChange::default() {
                    return Err(UserError::new(format!(
                        "a drift that changes nothing; give at least one of {}",
                        RigChange::KEYS.join(", ")
                    )));
                }
                change.check()?;
                change.fits(rig)?;
                Ok(change.apply(rig, 1.0).check()?)
            }
            Self::Recede {
                mm_per_j, mm_per_s, ..
            } if mm_per_j == 0.0 && mm_per_s == 0.0 => Err(UserError::new(
                "a surface that does not recede; give mm_per_j or mm_per_s",
            )),
            Self::CartFriction { .. } => self.friction().map(drop),
            _ => Ok(()),
        }
    }

    /// The friction of a change of friction.
    ///
    /// # Errors
    /// A number is out of its range.
    pub fn friction(&self) -> Result<Option<Friction>, UserError> {
        match *self {
            Self::CartFriction {
                coulomb_n,
                static_n,
                viscous_n_s_per_m,
                ..
            } => friction(coulomb_n, static_n, viscous_n_s_per_m),
            _ => Ok(None),
        }
    }
}

/// An event from its table, for a run of `rig`.
///
/// # Errors
/// The time is missing or out of range, a key is unknown, a value out of range, or the rig cannot change so.
pub fn timed(mut table: toml::Table, duration_s: f64, rig: &RigParams) -> Result<Timed, UserError> {
    let at_s = match table.remove("at_s") {
        Some(Value::Float(s)) => s,
        Some(Value::Integer(s)) => s as f64,
        _ => return Err(UserError::new("at_s = SECONDS is missing")),
    };
    if !(0.0..=duration_s).contains(&at_s) {
        return Err(UserError::new(format!(
            "at_s is {at_s}, must be from 0 to duration_s = {duration_s}"
        )));
    }
    let act =
        ScenarioAct::deserialize(Value::Table(table)).map_err(|e| not_understood(e.message()))?;
    act.check(rig)?;
    Ok(Timed { at_s, act })
}
