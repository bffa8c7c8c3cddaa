//! Whether the measuring reference (VDDA) has its value: every code of a sensor is a share of it.
//!
//! The part has a voltage reference of its own and the code that it gave at 3.3 V when the part was made (RM0390, "Reading
//! the internal reference voltage"): VDDA = 3.3 V · calibration / code.

/// Calibrations that a part can have: 1.16 to 1.26 V of 3.3 V (DS10693 says 1.18 to 1.24 V), 12 bits. A blank or broken one
/// is outside.
const POSSIBLE: core::ops::RangeInclusive<u16> = 1440..=1564;
/// VDDA may be off by one part in so many: 2 %.
const PART: u32 = 50;
/// Readings in a row that must be bad while the drive runs: one may be disturbed.
const BAD: u8 = 3;

/// Whether VDDA is within 2 % of 3.3 V, by the `code` of the part's own reference.
pub fn is_good(calibration: u16, code: u16) -> bool {
    let (wanted, found) = (u32::from(calibration), u32::from(code));
    // VDDA/3.3 V − 1 = (calibration − code)/code.
    POSSIBLE.contains(&calibration) && wanted.abs_diff(found) * PART <= found
}

/// The readings of a run.
#[derive(Clone, Copy, Debug, Default)]
pub struct RunReadings {
    bad: u8,
}

impl RunReadings {
    /// Takes a reading; whether the reference is lost.
    pub fn is_lost(&mut self, calibration: u16, code: u16) -> bool {
        self.bad = if is_good(calibration, code) {
            0
        } else {
            self.bad.saturating_add(1)
        };
        self.bad >= BAD
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_per_cent_either_side_are_good() {
        // 1.21 V at a VDDA that is off by so much.
        let code = |percent: f64| (1502.0 / (1.0 + percent / 100.0)).round() as u16;
        for percent in [0.0, 1.9, -1.9] {
            assert!(is_good(1502, code(percent)), "{percent}");
        }
        for percent in [2.1, -2.1, 9.0, -9.0] {
            assert!(!is_good(1502, code(percent)), "{percent}");
        }
        // No calibration, or no reading.
        assert!(!is_good(0xffff, 0xffff) && !is_good(0, 0) && !is_good(1502, 0));
    }

    #[test]
    fn one_bad_reading_loses_nothing_and_three_in_a_row_do() {
        let mut watch = RunReadings::default();
        let readings = [1400, 1400, 1502, 1400, 1400, 1400];
        let lost = readings.map(|code| watch.is_lost(1502, code));
        assert_eq!(lost, [false, false, false, false, false, true]);
    }
}
