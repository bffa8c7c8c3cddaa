//! The events of a run, in words.

use std::fmt;

use super::record::{RunEvent, RunEventKind, RunObserver};

impl fmt::Display for RunEventKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Scenario { text } => write!(f, "scenario: {text}"),
            Self::State { from, to } => write!(f, "{from} -> {to}"),
            Self::Fault {
                fault,
                origin,
                value,
            } => {
                let (code, name) = (fault.code(), fault.name());
                let origin = format!("{origin:?}").to_lowercase();
                write!(f, "fault {code} {name} ({origin}, {value:.4})")
            }
            Self::Drive { on: true } => f.write_str("drive on"),
            Self::Drive { on: false } => f.write_str("drive off"),
            Self::Said { text } => f.write_str(text),
        }
    }
}

/// An observer that keeps every event of a run.
#[derive(Clone, Debug, Default)]
pub struct Timeline {
    /// In the order in which they were reported.
    pub events: Vec<RunEvent>,
}

impl RunObserver for Timeline {
    fn event(&mut self, event: &RunEvent) {
        self.events.push(event.clone());
    }
}

impl fmt::Display for Timeline {
    /// A line per event: time in s, what.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for event in &self.events {
            writeln!(f, "{:>11.4} s  {}", event.time_s, event.what)?;
        }
        Ok(())
    }
}
