//! The numeric oscillator behind the drive: phase-continuous, with slew-limited frequency and amplitude.

use crate::io::{DAC_REACH, DacCode, Output};
use crate::model::drive::{Drive, DriveError};
use crate::settings::{DriveKind, DriveSettings, TICK_S};

/// A set-point per tick for a shaker's DAC, or a frequency set-point for a motor drive.
///
/// Frequency and amplitude move once per block, so that a tick is one rotation of the phasor.
#[derive(Clone, Copy, Debug)]
pub struct DriveOscillator {
    drive: Drive<f32>,
    settings: DriveSettings,
    codes_per_m: f32,
    frequency_hz: f32,
    frequency_goal_hz: f32,
    amplitude_m: f32,
    amplitude_goal_m: f32,
}

impl DriveOscillator {
    /// At `frequency_hz`, amplitude 0, phase 0.
    ///
    /// # Errors
    /// If the frequency is out of range at the control tick.
    pub fn new(settings: &DriveSettings, frequency_hz: f32) -> Result<Self, DriveError> {
        Ok(Self {
            drive: Drive::new(f64::from(frequency_hz), TICK_S)?,
            settings: *settings,
            codes_per_m: 1.0 / settings.m_per_code,
            frequency_hz,
            frequency_goal_hz: frequency_hz,
            amplitude_m: 0.0,
            amplitude_goal_m: 0.0,
        })
    }

    /// Sets the goal of the frequency; NaN and infinity are ignored.
    pub fn aim(&mut self, frequency_hz: f32) {
        if frequency_hz.is_finite() {
            self.frequency_goal_hz = frequency_hz;
        }
    }

    /// Sets the frequency at once: for a drive that is off.
    pub fn jump(&mut self, frequency_hz: f32) {
        self.aim(frequency_hz);
        self.retune(self.frequency_goal_hz);
    }

    /// Sets the frequency at once, and the phase to 0: for a drive at amplitude 0.
    pub fn restart(&mut self, frequency_hz: f32) {
        if let Ok(drive) = Drive::new(f64::from(frequency_hz), TICK_S) {
            self.drive = drive;
            self.frequency_hz = frequency_hz;
            self.frequency_goal_hz = frequency_hz;
        }
    }

    /// Sets the goal of the amplitude; NaN and infinity are ignored.
    pub fn aim_amplitude(&mut self, amplitude_m: f32) {
        if amplitude_m.is_finite() {
            self.amplitude_goal_m = amplitude_m.max(0.0);
        }
    }

    /// Amplitude 0 at once: the drive is off.
    pub fn silence(&mut self) {
        self.amplitude_m = 0.0;
        self.amplitude_goal_m = 0.0;
    }

    /// Drive frequency now, Hz, on its way to its goal.
    pub fn frequency_hz(&self) -> f32 {
        self.frequency_hz
    }

    /// Commanded cart amplitude now, m, on its way to its goal.
    pub fn amplitude_m(&self) -> f32 {
        self.amplitude_m
    }

    /// Whether the amplitude has reached its goal.
    pub fn amplitude_has_arrived(&self) -> bool {
        self.amplitude_m == self.amplitude_goal_m
    }

    /// Whether the frequency has reached its goal.
    pub fn frequency_has_arrived(&self) -> bool {
        self.frequency_hz == self.frequency_goal_hz
    }

    /// The drive: phase and phasor of the last set-point.
    pub fn drive(&self) -> &Drive<f32> {
        &self.drive
    }

    /// Moves frequency and amplitude by as much as a block of `ticks` allows.
    pub fn slew(&mut self, ticks: usize) {
        let block_s = ticks as f32 * TICK_S as f32;
        let next_m = towards(
            self.amplitude_m,
            self.amplitude_goal_m,
            self.settings.amplitude_slew_m_per_s * block_s,
        );
        self.amplitude_m = next_m;
        if self.frequency_hz != self.frequency_goal_hz {
            let next_hz = towards(
                self.frequency_hz,
                self.frequency_goal_hz,
                self.settings.frequency_slew_hz_per_s * block_s,
            );
            self.retune(next_hz);
        }
    }

    /// The next tick's set-point.
    #[inline]
    pub fn next(&mut self) -> Output {
        self.drive.advance();
        let dac = match self.settings.kind {
            DriveKind::Motor => DacCode::MIDDLE,
            DriveKind::Shaker => {
                let codes = self.amplitude_m * self.drive.sin() * self.codes_per_m;
                let reach = f32::from(DAC_REACH);
                let code = libm::floorf(codes.clamp(-reach, reach) + 2048.5);
                DacCode(code as u16)
            }
        };
        Output {
            dac,
            frequency_hz: self.frequency_hz,
            enable: true,
        }
    }

    fn retune(&mut self, frequency_hz: f32) {
        // Limits are checked with the settings; a frequency that the drive refuses all the same is ignored.
        if self
            .drive
            .set_frequency(f64::from(frequency_hz), TICK_S)
            .is_ok()
        {
            self.frequency_hz = frequency_hz;
        } else {
            self.frequency_goal_hz = self.frequency_hz;
        }
    }
}

/// `from` moved towards `to` by at most `step`.
fn towards(from: f32, to: f32, step: f32) -> f32 {
    if to > from + step {
        from + step
    } else if to < from - step {
        from - step
    } else {
        to
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::params::WIRES;
    use crate::settings::Settings;

    #[test]
    fn the_largest_amplitude_allowed_stays_within_what_the_dac_gives() {
        let mut settings = Settings::for_rig(&WIRES);
        let most_m = f32::from(DAC_REACH) * settings.drive.m_per_code;
        settings.trips.travel_m = settings.limits.travel_m;
        settings.limits.amplitude_m = 0.9999 * most_m;
        settings.trips.cart_m = 1.0001 * most_m;
        assert_eq!(settings.check(), Ok(()));
        settings.limits.amplitude_m = 1.001 * most_m;
        settings.trips.cart_m = 1.002 * most_m;
        assert_eq!(settings.check().unwrap_err().key, "limits.amplitude_m");
        // And whatever is commanded, the codes keep within it.
        let mut oscillator = DriveOscillator::new(&settings.drive, 3.0).unwrap();
        oscillator.aim_amplitude(1.2 * most_m);
        let mut furthest = (2048, 2048);
        for _ in 0..20_000 {
            oscillator.slew(10);
            for _ in 0..10 {
                let code = oscillator.next().dac.0;
                furthest = (furthest.0.min(code), furthest.1.max(code));
            }
        }
        assert_eq!(furthest, (2048 - DAC_REACH, 2048 + DAC_REACH));
    }

    #[test]
    fn set_points_have_no_step_while_frequency_and_amplitude_move() {
        let settings = Settings::for_rig(&WIRES);
        let mut oscillator = DriveOscillator::new(&settings.drive, 2.0).unwrap();
        oscillator.aim(4.0);
        oscillator.aim_amplitude(0.89e-3);
        let mut last = DacCode::MIDDLE;
        let mut largest = 0;
        for _ in 0..60_000 {
            oscillator.slew(10);
            for _ in 0..10 {
                let next = oscillator.next().dac;
                largest = largest.max(next.0.abs_diff(last.0));
                last = next;
            }
        }
        assert!((oscillator.amplitude_has_arrived() && oscillator.frequency_has_arrived()));
        // 0.89 mm at 4 Hz moves 0.92 codes a tick; rounding may make that 2.
        assert!(largest <= 2, "{largest}");
    }

    #[test]
    fn a_motor_gets_a_frequency_and_no_set_point() {
        let mut settings = Settings::for_rig(&WIRES).drive;
        settings.kind = DriveKind::Motor;
        let mut oscillator = DriveOscillator::new(&settings, 3.0).unwrap();
        oscillator.aim_amplitude(1e-3);
        oscillator.slew(10);
        let output = oscillator.next();
        assert_eq!(output.dac, DacCode::MIDDLE);
        assert_eq!(output.frequency_hz, 3.0);
    }

    #[test]
    fn nan_and_infinity_are_ignored() {
        let settings = Settings::for_rig(&WIRES).drive;
        let mut oscillator = DriveOscillator::new(&settings, 3.0).unwrap();
        oscillator.aim(f32::NAN);
        oscillator.aim_amplitude(f32::INFINITY);
        oscillator.slew(10);
        assert!((oscillator.amplitude_has_arrived() && oscillator.frequency_has_arrived()));
        assert_eq!(oscillator.frequency_hz(), 3.0);
    }

    #[test]
    fn frequency_and_amplitude_move_at_their_rates_and_stop_at_their_goals() {
        let settings = Settings::for_rig(&WIRES).drive;
        let mut oscillator = DriveOscillator::new(&settings, 3.0).unwrap();
        let block_s = 40.0 * TICK_S as f32;
        let (hz, m) = (
            settings.frequency_slew_hz_per_s * block_s,
            settings.amplitude_slew_m_per_s * block_s,
        );
        for sign in [1.0, -1.0] {
            let (from_hz, from_m) = (oscillator.frequency_hz(), oscillator.amplitude_m());
            oscillator.aim(from_hz + sign * 2.5 * hz);
            oscillator.aim_amplitude(from_m + sign * 3.5 * m);
            for (blocks, by_hz, by_m) in [(1, 1.0, 1.0), (2, 2.0, 2.0), (3, 2.5, 3.0)] {
                assert!(
                    !(oscillator.amplitude_has_arrived() && oscillator.frequency_has_arrived())
                );
                oscillator.slew(40);
                let moved = (oscillator.frequency_hz() - from_hz) * sign;
                assert!((moved - by_hz * hz).abs() < 1e-6, "{blocks}: {moved}");
                let moved = (oscillator.amplitude_m() - from_m) * sign;
                assert!((moved - by_m * m).abs() < 1e-9, "{blocks}: {moved}");
                assert_eq!(oscillator.frequency_has_arrived(), blocks == 3);
            }
            assert!(!(oscillator.amplitude_has_arrived() && oscillator.frequency_has_arrived()));
            oscillator.slew(40);
            assert!((oscillator.amplitude_has_arrived() && oscillator.frequency_has_arrived()));
            let drive_hz = oscillator.drive().frequency_hz();
            assert!((drive_hz - f64::from(oscillator.frequency_hz())).abs() < 1e-5);
        }
        oscillator.aim_amplitude(1e-3);
        oscillator.slew(40);
        oscillator.silence();
        assert!(
            (oscillator.amplitude_has_arrived() && oscillator.frequency_has_arrived())
                && oscillator.amplitude_m() == 0.0
        );
        oscillator.jump(5.0);
        assert_eq!(oscillator.frequency_hz(), 5.0);
        assert!((oscillator.drive().frequency_hz() - 5.0).abs() < 1e-5);
    }

    #[test]
    fn a_frequency_that_the_drive_refuses_changes_nothing() {
        let settings = Settings::for_rig(&WIRES).drive;
        let mut oscillator = DriveOscillator::new(&settings, 3.0).unwrap();
        oscillator.jump(1e6);
        assert_eq!(oscillator.frequency_hz(), 3.0);
        assert!((oscillator.amplitude_has_arrived() && oscillator.frequency_has_arrived()));
    }

    #[test]
    fn set_points_are_the_sine_in_codes_about_the_middle() {
        let settings = Settings::for_rig(&WIRES).drive;
        let mut oscillator = DriveOscillator::new(&settings, 20.0).unwrap();
        let amplitude_m = 0.5e-3;
        oscillator.aim_amplitude(amplitude_m);
        for _ in 0..200 {
            oscillator.slew(400);
        }
        for tick in 1..2_000 {
            let output = oscillator.next();
            let sin = libm::sin(core::f64::consts::TAU * 20.0 * TICK_S * f64::from(tick));
            let codes = f64::from(amplitude_m) * sin / f64::from(settings.m_per_code);
            let off = f64::from(output.dac.0) - 2048.0 - codes;
            assert!(off.abs() < 0.51, "{tick}: {output:?} {codes}");
            assert!(output.enable && output.frequency_hz == 20.0);
        }
    }
}
