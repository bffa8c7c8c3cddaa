//! Events in words.

use super::event::{ScenarioAct, StartMode, Stuck};

impl ScenarioAct {
    /// In words, for the timeline.
    pub fn text(&self) -> String {
        let for_so_long = |s: Option<f64>| s.map_or(String::new(), |s| format!(" for {s} s"));
        match self {
            Self::Start {
                mode: StartMode::Automatic,
            } => "start".into(),
            Self::Start {
                mode: StartMode::Manual,
            } => "start by hand".into(),
            Self::Stop {} => "stop".into(),
            Self::ClearFault {} => "clear fault".into(),
            Self::Acknowledge {} => "acknowledge".into(),
            Self::SetPoint {
                frequency_hz,
                amplitude_mm,
            } => format!("set point {frequency_hz} Hz, {amplitude_mm} mm"),
            Self::Link {} => "link in command".into(),
            Self::LinkLoss {} => "link silent".into(),
            Self::EmergencyStop { for_s } => format!("emergency stop{}", for_so_long(*for_s)),
            Self::SensorFault(how) => format!("{}{}", how.text(), for_so_long(how.for_s)),
            Self::Push { speed_m_per_s } => format!("push by {speed_m_per_s} m/s"),
            Self::Overrun { blocks, every } => format!("{blocks} overruns, one block in {every}"),
            Self::LostBlock { blocks, every } => {
                format!("{blocks} blocks of samples lost, one in {every}")
            }
            Self::Drift { over_s, .. } => format!("the rig drifts for {over_s} s"),
            Self::Recede {
                mm_per_j,
                mm_per_s,
                for_s,
                ..
            } => format!(
                "the surface recedes by {mm_per_j} mm/J and {mm_per_s} mm/s{}",
                for_so_long(*for_s)
            ),
            Self::StuckDrive { how, for_s } => {
                let how = match how {
                    Stuck::RunsOn => "runs on",
                    Stuck::Powered => "stays powered",
                };
                format!("the drive {how} without enable{}", for_so_long(*for_s))
            }
            Self::Tilt { degrees, over_s } => {
                format!("the rig tilts to {degrees} degrees in {over_s} s")
            }
            Self::CartFriction {
                coulomb_n, for_s, ..
            } => format!(
                "the cart's friction is {} N{}",
                coulomb_n.unwrap_or(0.0),
                for_so_long(*for_s)
            ),
            Self::Reset { cause } => format!("reset: {cause:?}").to_lowercase(),
        }
    }
}
