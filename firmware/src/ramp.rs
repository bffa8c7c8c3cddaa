//! The set-point after a trip: back to the middle at a steady speed, not in a step.
//!
//! The enable is gone at once. But a power stage may follow its set-point for the milliseconds until its own relay has
//! opened, and a step of the set-point is the hardest motion that it can be told to make.

use shared::io::{DacCode, Output};

/// Fastest change with the drive off, codes per tick: 49 mm/s on a shaker of 2.5 mm (twice the cart's largest speed on the
/// wires), and 45 ms from the furthest code.
const STEP: i32 = 2;

/// The set-point that is played.
#[derive(Clone, Copy, Debug)]
pub struct Ramp {
    code: i32,
}

impl Default for Ramp {
    fn default() -> Self {
        Self {
            code: i32::from(DacCode::MIDDLE.0),
        }
    }
}

impl Ramp {
    /// The code of a tick: the controller's with the drive on, else one on the way to its (the middle).
    #[inline]
    pub fn step(&mut self, output: &Output) -> u16 {
        let wanted = i32::from(output.dac.0.min(4095));
        self.code = if output.enable {
            wanted
        } else {
            // `clamp` would panic if the bounds were the wrong way round; to the compiler they could be.
            wanted.max(self.code - STEP).min(self.code + STEP)
        };
        self.code as u16
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn with_the_drive_on_the_code_is_the_controllers_and_after_a_trip_there_is_no_step() {
        let mut ramp = Ramp::default();
        assert_eq!(ramp.step(&Output::SAFE), 2048);
        let driving = |code| Output {
            dac: DacCode(code),
            enable: true,
            ..Output::SAFE
        };
        for code in [2048, 258, 3838] {
            assert_eq!(ramp.step(&driving(code)), code);
        }
        let codes: std::vec::Vec<_> = (0..1_000).map(|_| ramp.step(&Output::SAFE)).collect();
        assert!(codes[0] == 3836 && codes.windows(2).all(|w| w[0].abs_diff(w[1]) <= 2));
        assert_eq!(codes.iter().position(|code| *code == 2048), Some(894));
        assert_eq!(codes[999], 2048);
    }
}
