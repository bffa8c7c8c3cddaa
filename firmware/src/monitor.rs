//! What is made of the control task's reports, below control priority.

use shared::regime::{Detector, Regime};

use crate::control::{Control, RIG, Report};

/// Drive periods per window. A regime is told afresh for every window, so a
/// change shows after two of them; 32 periods show repetitions of up to 16.
pub const WINDOW_PERIODS: u32 = 32;

/// What a window of drive periods amounted to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Window {
    /// The impact regime.
    pub regime: Regime,
    /// Contacts begun.
    pub contacts: u32,
    /// Largest contact force over the hammer's weight.
    pub force_ratio: f32,
    /// Reports lost since the start. A window with a loss in it is begun anew.
    pub lost: u32,
}

/// Gathers reports into windows.
#[derive(Clone, Copy, Debug)]
pub struct Monitor {
    fresh: Detector<f32>,
    detector: Detector<f32>,
    weight_n: f32,
    expected: u32,
    contacts: u32,
    peak_force_n: f32,
    lost: u32,
}

impl Monitor {
    /// A monitor of that controller, before its first tick.
    pub fn new(control: &Control) -> Self {
        let fresh = control.twin().detector();
        Self {
            fresh,
            detector: fresh,
            weight_n: RIG.weight_n() as f32,
            expected: 0,
            contacts: 0,
            peak_force_n: 0.0,
            lost: 0,
        }
    }

    /// Takes in a report; returns the window if it ends with this one.
    pub fn take(&mut self, report: &Report) -> Option<Window> {
        let missing = report.sequence.wrapping_sub(self.expected);
        self.expected = report.sequence.wrapping_add(1);
        if missing != 0 {
            self.lost = self.lost.saturating_add(missing);
            self.restart();
        }

        let opens = self.detector == self.fresh;
        let strobe = &report.strobe;
        self.detector.push(strobe.q, strobe.v, &strobe.period);
        if !opens {
            self.contacts += u32::from(strobe.period.onsets);
            self.peak_force_n = self.peak_force_n.max(strobe.period.peak_force);
        }
        if self.detector.periods_seen() < WINDOW_PERIODS {
            return None;
        }

        let window = Window {
            regime: self.detector.regime(),
            contacts: self.contacts,
            force_ratio: self.peak_force_n / self.weight_n,
            lost: self.lost,
        };
        self.restart();
        // The strobe that ends a window opens the next.
        self.detector.push(strobe.q, strobe.v, &strobe.period);
        Some(window)
    }

    fn restart(&mut self) {
        self.detector = self.fresh;
        self.contacts = 0;
        self.peak_force_n = 0.0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Runs the controller and gives the monitor every report that `passes`.
    fn windows(count: usize, passes: impl Fn(u32) -> bool) -> [Option<Window>; 4] {
        let mut control = Control::new().unwrap();
        let mut monitor = Monitor::new(&control);
        let mut found = [None; 4];
        let mut next = 0;
        while next < count {
            let report = control.tick().filter(|report| passes(report.sequence));
            if let Some(window) = report.and_then(|report| monitor.take(&report)) {
                found[next] = Some(window);
                next += 1;
            }
        }
        found
    }

    #[test]
    fn the_rig_settles_to_one_impact_per_period() {
        let last = windows(3, |_| true)[2].unwrap();
        assert!(last.regime.is(1, 1), "{last:?}");
        assert_eq!(last.contacts, WINDOW_PERIODS);
        assert!(last.force_ratio > 1.0, "{last:?}");
        assert_eq!(last.lost, 0);
    }

    #[test]
    fn a_lost_report_is_counted_and_not_bridged() {
        // Report 80 would fall in the third window; what is left of it is dropped.
        let last = windows(3, |sequence| sequence != 80)[2].unwrap();
        assert_eq!(last.lost, 1);
        assert!(last.regime.is(1, 1), "{last:?}");
        assert_eq!(last.contacts, WINDOW_PERIODS);
    }
}
