//! Climbing on measured force: three frequencies, a parabola through their mean impulse, its top.
//!
//! The impulse of a contact is climbed on and not its peak: the surface's ringing adds to the peak and
//! averages out of the impulse, and both grow with the approach speed.

/// Drive periods left out after each change of frequency: what is left of the change is the largest
/// multiplier to this power (0.317 at the wires' optimum: 1e-4; 0.7: 6 %).
pub const SETTLE_PERIODS: u16 = 8;

/// Step, averaging and reach of a climb.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Probe {
    /// Distance of the outer frequencies from the middle one, relative.
    pub step: f32,
    /// Drive periods averaged at each.
    pub periods: u16,
    /// Longest move of the middle, in steps.
    pub reach: f32,
}

impl Probe {
    /// While seeking: wide steps, few periods. At 3 % the force of the presets' 1/1 falls by about 1 %.
    pub const SEEK: Self = Self {
        step: 0.03,
        periods: 12,
        reach: 2.0,
    };
    /// While holding: narrow steps, many periods.
    pub const HOLD: Self = Self {
        step: 0.02,
        periods: 32,
        reach: 1.0,
    };
}

/// The effect of a strobe on the climb.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Advice {
    /// Nothing to change.
    Stay,
    /// Go to this frequency, Hz.
    Go(f32),
    /// All three points are measured: the new middle, and how far it moved in steps.
    Top {
        /// The best frequency, Hz.
        frequency_hz: f32,
        /// The move, in steps.
        moved: f32,
        /// Mean impulse of the best point measured, N·s.
        impulse_n_s: f32,
    },
}

/// A climb about a middle frequency.
#[derive(Clone, Copy, Debug)]
pub struct Climb {
    probe: Probe,
    middle_hz: f32,
    /// Which of the three points is measured, lowest first.
    point: u8,
    settle: u16,
    count: u16,
    sum: f32,
    means: [f32; 3],
}

impl Climb {
    /// A climb about `middle_hz`; the first point to go to is [`Self::frequency_hz`].
    pub fn new(probe: Probe, middle_hz: f32) -> Self {
        Self {
            probe,
            middle_hz,
            point: 0,
            settle: SETTLE_PERIODS,
            count: 0,
            sum: 0.0,
            means: [0.0; 3],
        }
    }

    /// The frequency of the point that is measured, Hz.
    pub fn frequency_hz(&self) -> f32 {
        let offset = f32::from(self.point) - 1.0;
        self.middle_hz * (1.0 + offset * self.probe.step)
    }

    /// A drive period with one contact of `impulse_n_s` has ended at [`Self::frequency_hz`].
    pub fn strobe(&mut self, impulse_n_s: f32) -> Advice {
        if self.settle > 0 {
            self.settle -= 1;
            return Advice::Stay;
        }
        self.sum += impulse_n_s;
        self.count += 1;
        if self.count < self.probe.periods {
            return Advice::Stay;
        }
        let mean = self.sum / f32::from(self.count);
        if let Some(slot) = self.means.get_mut(usize::from(self.point)) {
            *slot = mean;
        }
        self.sum = 0.0;
        self.count = 0;
        self.settle = SETTLE_PERIODS;
        if self.point < 2 {
            self.point += 1;
            return Advice::Go(self.frequency_hz());
        }
        let moved = self.top();
        let [low, middle, high] = self.means;
        Advice::Top {
            frequency_hz: self.middle_hz * (1.0 + moved * self.probe.step),
            moved,
            impulse_n_s: low.max(middle).max(high),
        }
    }

    /// Where the parabola's top lies, in steps from the middle; towards the higher side if it has no top.
    fn top(&self) -> f32 {
        let [low, middle, high] = self.means;
        let rise = high - low;
        let bend = 2.0 * middle - low - high;
        let reach = self.probe.reach;
        if bend > 0.0 {
            let top = 0.5 * rise / bend;
            if top.is_finite() {
                return top.max(-reach).min(reach);
            }
        }
        if rise > 0.0 {
            reach
        } else if rise < 0.0 {
            -reach
        } else {
            0.0
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Climbs `impulse(frequency)` from `start_hz` for `cycles` cycles.
    fn climb(start_hz: f32, cycles: usize, impulse: impl Fn(f32) -> f32) -> f32 {
        let mut best = start_hz;
        for _ in 0..cycles {
            let mut climb = Climb::new(Probe::SEEK, best);
            loop {
                let at = climb.frequency_hz();
                if let Advice::Top { frequency_hz, .. } = climb.strobe(impulse(at)) {
                    best = frequency_hz;
                    break;
                }
            }
        }
        best
    }

    #[test]
    fn a_hill_is_climbed_from_either_side() {
        let hill = |hz: f32| 1.0 - (hz - 3.664) * (hz - 3.664);
        for start in [3.3, 3.664, 4.0] {
            let top = climb(start, 3, hill);
            assert!((top - 3.664).abs() < 2e-3, "{start} led to {top}");
        }
    }

    #[test]
    fn a_slope_without_a_top_is_climbed_as_far_as_the_reach() {
        let top = climb(3.0, 1, |hz| hz * hz);
        assert!((top - 3.0 * 1.06).abs() < 1e-5, "{top}");
        assert_eq!(climb(3.0, 1, |_| 1.0), 3.0, "a plain is stayed on");
        assert!(climb(3.0, 2, |_| f32::NAN).is_finite());
    }

    #[test]
    fn the_top_of_a_parabola_is_found_from_periods_that_have_settled() {
        let (top_hz, probe) = (3.65_f32, Probe::SEEK);
        let mut climb = Climb::new(probe, 3.6);
        let mut advice = std::vec::Vec::new();
        let mut since = 0;
        for period in 1.. {
            let hz = climb.frequency_hz();
            // What is left of the change before is worth nothing.
            let settled = since >= SETTLE_PERIODS;
            let impulse = 0.04 - 0.02 * (hz - top_hz) * (hz - top_hz);
            since += 1;
            match climb.strobe(if settled { impulse } else { 9.0 }) {
                Advice::Stay => {}
                Advice::Go(hz) => {
                    since = 0;
                    advice.push((period, hz));
                }
                Advice::Top {
                    frequency_hz,
                    moved,
                    impulse_n_s,
                } => {
                    assert!((frequency_hz - top_hz).abs() < 1e-3, "{frequency_hz}");
                    assert!(
                        (moved * 0.03 * 3.6 - (top_hz - 3.6)).abs() < 1e-3,
                        "{moved}"
                    );
                    // The best of the three points is the middle one.
                    assert!((impulse_n_s - (0.04 - 0.02 * 0.0025)).abs() < 1e-6);
                    assert_eq!(period, 3 * (8 + 12));
                    break;
                }
            }
        }
        let [(first, middle), (second, high)] = advice[..] else {
            panic!("{advice:?}");
        };
        assert_eq!((first, second), (20, 40));
        assert!((middle - 3.6).abs() < 1e-6 && (high - 3.6 * 1.03).abs() < 1e-6);
    }

    #[test]
    fn no_move_is_longer_than_the_reach_on_a_slope_or_in_a_valley() {
        let moved = |means: [f32; 3]| {
            let mut climb = Climb::new(Probe::HOLD, 3.0);
            climb.means = means;
            climb.top()
        };
        for (means, expected) in [
            ([1.0, 2.0, 3.0], 1.0),
            ([3.0, 2.0, 1.0], -1.0),
            ([1.0, 2.0, 2.9], 1.0),
            ([2.9, 2.0, 1.0], -1.0),
            ([2.0, 1.0, 3.0], 1.0),
            ([3.0, 1.0, 2.0], -1.0),
            ([2.0, 1.0, 2.0], 0.0),
            ([1.0, 2.0, 1.0], 0.0),
        ] {
            assert_eq!(moved(means), expected, "{means:?}");
        }
        // y = −x² + x/2: 3/4 of a step is the top of −(x − 3/4)².
        let at = |x: f32| -(x - 0.75) * (x - 0.75);
        assert!((moved([at(-1.0), at(0.0), at(1.0)]) - 0.75).abs() < 1e-6);
    }
}
