//! The force that is wanted: the amplitude that makes it.
//!
//! In 1/1 the force grows with the amplitude, in proportion at no gap. The lock keeps the frequency at the best for any
//! amplitude, so the two do not disturb each other: this loop waits for the hammer to have answered, compares the mean
//! peak with what is wanted, and moves the amplitude by the share that is missing. Limits and the amplitude loop
//! ([`super::trim`]) stand behind it and have the last word.

use crate::settings::Settings;

/// Drive periods left out after each move: the hammer needs some to respond.
const SETTLE_PERIODS: u8 = 6;
/// Drive periods in a mean.
const MEAN_PERIODS: u8 = 10;
/// Share of what is missing that a move makes good, as a power of the ratio.
const GAIN: f32 = 0.8;
/// Farthest move at once, as a factor.
const FARTHEST: f32 = 1.25;
/// Least amplitude, as a share of the rig's.
const LEAST: f32 = 0.1;
/// Share of the force wanted at which it begins, where the forecast has more: the belief may be off.
const BEGIN: f32 = 0.9;

/// The loop from peak force to amplitude.
#[derive(Clone, Copy, Debug)]
pub struct ForceLoop {
    /// Force wanted, N; 0: as it comes.
    wanted_n: f32,
    /// Largest amplitude over the rig's.
    largest: f32,
    /// Amplitude over the rig's.
    factor: f32,
    periods: u8,
    sum_n: f32,
}

impl ForceLoop {
    /// A loop for a mean peak force of `wanted_n`, N (0: as it comes), with an amplitude of at most `largest` times the
    /// rig's.
    pub fn new(wanted_n: f32, largest: f32) -> Self {
        Self {
            wanted_n,
            largest,
            factor: 1.0,
            periods: 0,
            sum_n: 0.0,
        }
    }

    /// The loop of `settings`.
    pub fn of(settings: &Settings) -> Self {
        let rig_m = settings.rig.amplitude_m as f32;
        Self::new(settings.aim.force_n, settings.limits.amplitude_m / rig_m)
    }

    /// Amplitude over the rig's.
    pub fn factor(&self) -> f32 {
        self.factor
    }

    /// Begins no harder than asked, by the forecast of `force_n` at the rig's amplitude. More than the rig's amplitude
    /// waits for the hammer to strike.
    pub fn expect(&mut self, force_n: f32) {
        if self.wanted_n > 0.0 && force_n > BEGIN * self.wanted_n {
            self.move_to(BEGIN * self.wanted_n / force_n);
        }
    }

    /// A drive period of 1/1 with a peak force of `peak_n` has ended; `clamped`: a limit holds the amplitude. Whether the
    /// amplitude moves.
    pub fn strobe(&mut self, peak_n: f32, clamped: bool) -> bool {
        if self.wanted_n <= 0.0 {
            return false;
        }
        self.periods += 1;
        if self.periods > SETTLE_PERIODS {
            self.sum_n += peak_n;
        }
        if self.periods < SETTLE_PERIODS + MEAN_PERIODS {
            return false;
        }
        let mean_n = self.sum_n / f32::from(MEAN_PERIODS);
        self.periods = 0;
        self.sum_n = 0.0;
        let ratio = (self.wanted_n / mean_n).clamp(1.0 / FARTHEST, FARTHEST);
        if clamped && ratio > 1.0 {
            return false;
        }
        self.move_to(self.factor * (1.0 + GAIN * (ratio - 1.0)));
        true
    }

    /// The contacts were interrupted: the mean begins anew.
    pub fn interrupt(&mut self) {
        self.periods = 0;
        self.sum_n = 0.0;
    }

    fn move_to(&mut self, factor: f32) {
        if factor.is_finite() {
            self.factor = factor.max(LEAST).min(self.largest);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Runs the loop on a hammer that makes `force` of the amplitude, for so many drive periods; the largest force on the
    /// way and the last one.
    fn run(mut force_loop: ForceLoop, periods: usize, force: impl Fn(f32) -> f32) -> (f32, f32) {
        let mut largest = 0.0_f32;
        for _ in 0..periods {
            let peak_n = force(force_loop.factor());
            largest = largest.max(peak_n);
            force_loop.strobe(peak_n, false);
        }
        (largest, force(force_loop.factor()))
    }

    #[test]
    fn a_force_in_reach_is_made_from_below_and_never_passed() {
        for wanted_n in [30.0, 60.0, 96.0, 130.0] {
            for (true_n, power) in [(96.0, 1.0), (115.0, 1.0), (70.0, 0.8), (96.0, 1.3)] {
                let mut force_loop = ForceLoop::new(wanted_n, 3.0);
                force_loop.expect(96.0);
                let force = |factor: f32| true_n * libm::powf(factor, power);
                let (largest, last) = run(force_loop, 400, force);
                assert!((last / wanted_n - 1.0).abs() < 0.01, "{wanted_n}: {last}");
                let begin = if wanted_n < 96.0 / BEGIN {
                    BEGIN * true_n / 96.0
                } else {
                    true_n / wanted_n
                };
                assert!(
                    largest < wanted_n * 1.001 * begin.max(1.06),
                    "{wanted_n}: {largest}"
                );
            }
        }
    }

    #[test]
    fn as_it_comes_moves_nothing_and_a_limit_stops_the_rise() {
        let mut off = ForceLoop::new(0.0, 1.5);
        off.expect(500.0);
        assert!((0..100).all(|_| !off.strobe(50.0, false)));
        assert_eq!(off.factor(), 1.0);
        let mut held = ForceLoop::new(200.0, 1.5);
        assert!((0..100).all(|_| !held.strobe(50.0, true)));
        assert_eq!(held.factor(), 1.0);
        let (_, last) = run(ForceLoop::new(200.0, 1.5), 400, |factor| 96.0 * factor);
        assert_eq!(last, 1.5 * 96.0);
        let (_, last) = run(ForceLoop::new(200.0, 1.5), 400, |_| f32::NAN);
        assert!(last.is_nan());
    }

    #[test]
    fn the_force_begins_at_nine_tenths_and_the_amplitude_ends_at_its_limit() {
        let mut settings = Settings::for_rig(&crate::model::params::WIRES);
        settings.aim.force_n = 60.0;
        let mut force_loop = ForceLoop::of(&settings);
        // The forecast has 96 N at the rig's amplitude.
        force_loop.expect(96.0);
        assert!((96.0 * force_loop.factor() - 54.0).abs() < 1e-4);
        settings.aim.force_n = 500.0;
        settings.limits.amplitude_m = 1.7 * settings.rig.amplitude_m as f32;
        let (_, last) = run(ForceLoop::of(&settings), 400, |factor| 96.0 * factor);
        assert!((last / 96.0 - 1.7).abs() < 1e-5, "{last}");
    }

    #[test]
    fn a_mean_is_of_contacts_without_an_interruption() {
        let mut force_loop = ForceLoop::new(60.0, 1.5);
        let all = usize::from(SETTLE_PERIODS + MEAN_PERIODS);
        assert!((1..all).all(|_| !force_loop.strobe(600.0, false)));
        force_loop.interrupt();
        assert!((1..all).all(|_| !force_loop.strobe(60.0, false)));
        assert!(force_loop.strobe(60.0, false));
        // What was before it is forgotten: the force is as wanted.
        assert_eq!(force_loop.factor(), 1.0);
    }
}
