//! What a drive does that no longer obeys its enable line and runs on: the motion that it had.

use std::f64::consts::TAU;

/// The motion of a drive, as its set-points were.
#[derive(Clone, Copy, Debug, Default)]
pub struct Habit {
    hz: f64,
    /// Largest set-point of this turn and of the last, m.
    largest: (f64, f64),
    turns: f64,
    last_m: f64,
    /// Since the set-point last rose through the middle, turns.
    phase: f64,
}

impl Habit {
    /// A set-point that was obeyed.
    #[inline]
    pub fn sees(&mut self, metres: f64, hz: f64, tick_s: f64) {
        self.hz = hz;
        self.phase += hz * tick_s;
        if self.last_m < 0.0 && metres >= 0.0 {
            self.phase = 0.0;
        }
        self.last_m = metres;
        self.largest.0 = self.largest.0.max(metres.abs());
        self.turns += hz * tick_s;
        if self.turns >= 1.0 {
            self.turns -= 1.0;
            self.largest = (0.0, self.largest.0);
        }
    }

    /// The next set-point of the same motion, m, and its frequency, Hz.
    pub fn goes_on(&mut self, tick_s: f64) -> (f64, f64) {
        self.phase = (self.phase + self.hz * tick_s).fract();
        let amplitude = self.largest.0.max(self.largest.1);
        (amplitude * (TAU * self.phase).sin(), self.hz)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sine_goes_on_as_itself() {
        let tick_s = 5e-5;
        let wave = |k: u32| 1e-3 * (TAU * 3.7 * f64::from(k) * tick_s).sin();
        let mut habit = Habit::default();
        for k in 1..=17_777 {
            habit.sees(wave(k), 3.7, tick_s);
        }
        for k in 17_778..40_000 {
            let (metres, hz) = habit.goes_on(tick_s);
            assert_eq!(hz, 3.7);
            // Within a tick of phase.
            assert!((metres - wave(k)).abs() < 2e-6, "{k}");
        }
    }
}
