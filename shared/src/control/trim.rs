//! The amplitude loop, and the limits that reduce the amplitude.
//!
//! Limits clamp and are reported; they are no faults. The loop works once per drive period.

use super::limits::ActiveLimits;
use crate::sense::Strobe;
use crate::settings::Settings;

/// Share of the amplitude error corrected per drive period.
const GAIN: f32 = 0.2;
/// How far the loop may move the command from the amplitude wanted, either way.
const RANGE: (f32, f32) = (0.6, 1.6);
/// Drive periods between two reductions: the hammer needs some to respond.
const ANSWER_PERIODS: u8 = 4;
/// Factor by which a reduced amplitude recovers per drive period.
const RELEASE: f32 = 1.01;

/// The amplitude loop.
#[derive(Clone, Copy, Debug)]
pub struct Trim {
    wanted_m: f32,
    largest_m: f32,
    force_n: f32,
    travel_m: f32,
    /// Command over amplitude.
    gain: f32,
    /// Share of the wanted amplitude that the limits allow.
    draw: f32,
    /// Drive periods until the next reduction or recovery.
    wait: u8,
    limits: ActiveLimits,
}

impl Trim {
    /// Holds the rig's amplitude within the limits of `settings`.
    pub fn new(settings: &Settings) -> Self {
        Self {
            wanted_m: settings.rig.amplitude_m as f32,
            largest_m: settings.limits.amplitude_m,
            force_n: settings.limits.force_n,
            travel_m: settings.limits.travel_m,
            gain: 1.0,
            draw: 1.0,
            wait: 0,
            limits: ActiveLimits::NONE,
        }
    }

    /// The amplitude wanted, m (clamped by [`Self::command`]).
    pub fn set_wanted_amplitude(&mut self, amplitude_m: f32) {
        self.wanted_m = amplitude_m.max(0.0);
    }

    /// Takes the force forecast at the wanted amplitude: if it exceeds the force limit, the initial amplitude is
    /// reduced accordingly (the force of a 1/1 at no gap is proportional to the amplitude).
    pub fn expect(&mut self, force_n: f32) {
        if force_n > self.force_n {
            self.draw = (0.9 * self.force_n / force_n).max(0.05);
            self.limits |= ActiveLimits::FORCE;
        }
    }

    /// Limits that clamp.
    pub fn limits(&self) -> ActiveLimits {
        self.limits
    }

    /// A drive period has ended with the amplitude at its command. `closed`: whether the loop may correct
    /// (the drive is a shaker).
    pub fn strobe(&mut self, strobe: &Strobe, closed: bool) {
        let target_m = self.wanted_m * self.draw;
        if closed && target_m > 0.0 {
            let error = (target_m - strobe.amplitude_m) / target_m;
            let gain = self.gain * (1.0 + GAIN * error.clamp(-0.5, 0.5));
            if gain.is_finite() {
                self.gain = gain.clamp(RANGE.0, RANGE.1);
            }
        }
        self.limits -= ActiveLimits::FORCE | ActiveLimits::TRAVEL;
        let over_force = strobe.peak_n / self.force_n;
        let over_travel = strobe.travel_m / self.travel_m;
        let over = over_force.max(over_travel);
        if self.wait > 0 {
            self.wait -= 1;
        } else if over > 1.0 {
            self.draw = (self.draw / over.min(2.0)).max(0.05);
            self.wait = ANSWER_PERIODS;
        } else if over < 0.95 {
            self.draw = (self.draw * RELEASE).min(1.0);
        }
        if self.draw < 1.0 {
            let limit = if over_force >= over_travel {
                ActiveLimits::FORCE
            } else {
                ActiveLimits::TRAVEL
            };
            self.limits |= limit;
        }
    }

    /// The amplitude to command, m.
    pub fn command(&mut self) -> f32 {
        let command = self.wanted_m * self.draw * self.gain;
        if command > self.largest_m {
            self.limits |= ActiveLimits::AMPLITUDE;
            self.largest_m
        } else {
            self.limits -= ActiveLimits::AMPLITUDE;
            command
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::params::WIRES;

    fn run(trim: &mut Trim, periods: usize, plant: impl Fn(f32) -> Strobe) -> f32 {
        for _ in 0..periods {
            let command = trim.command();
            trim.strobe(&plant(command), true);
        }
        trim.command()
    }

    #[test]
    fn a_shaker_that_moves_less_gets_a_larger_command() {
        let mut trim = Trim::new(&Settings::for_rig(&WIRES));
        let command = run(&mut trim, 40, |m| Strobe {
            amplitude_m: 0.8 * m,
            ..Strobe::default()
        });
        assert!((0.8 * command - 0.89e-3).abs() < 1e-6, "{command}");
        assert_eq!(trim.limits(), ActiveLimits::NONE);
    }

    #[test]
    fn a_dead_shaker_does_not_wind_up_beyond_the_limit() {
        let settings = Settings::for_rig(&WIRES);
        let mut trim = Trim::new(&settings);
        let command = run(&mut trim, 100, |_| Strobe::default());
        assert_eq!(command, settings.limits.amplitude_m);
        assert_eq!(trim.limits(), ActiveLimits::AMPLITUDE);
    }

    #[test]
    fn a_force_that_is_forecast_above_the_limit_is_never_reached() {
        let settings = Settings::for_rig(&WIRES);
        let mut trim = Trim::new(&settings);
        trim.expect(1.5 * settings.limits.force_n);
        let command = trim.command();
        assert!((command / 0.89e-3 - 0.6).abs() < 1e-3, "{command}");
        assert_eq!(trim.limits(), ActiveLimits::FORCE);
        trim.expect(0.5 * settings.limits.force_n);
        assert_eq!(
            trim.command(),
            command,
            "a force below the limit changes nothing"
        );
    }

    #[test]
    fn force_above_the_limit_draws_the_amplitude_back_and_lets_it_return() {
        let settings = Settings::for_rig(&WIRES);
        let mut trim = Trim::new(&settings);
        let strong = |m: f32| Strobe {
            amplitude_m: m,
            peak_n: 1.5 * settings.limits.force_n * m / 0.89e-3,
            ..Strobe::default()
        };
        let command = run(&mut trim, 50, strong);
        assert!((0.6..0.69).contains(&(command / 0.89e-3)), "{command}");
        assert_eq!(trim.limits(), ActiveLimits::FORCE);
        let weak = |m: f32| Strobe {
            amplitude_m: m,
            ..Strobe::default()
        };
        let command = run(&mut trim, 100, weak);
        assert!((command / 0.89e-3 - 1.0).abs() < 1e-3, "{command}");
        assert_eq!(trim.limits(), ActiveLimits::NONE);
    }
}
