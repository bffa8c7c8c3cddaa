//! The pattern of the one LED: the controller's state, and a fault's number.
//!
//! | state | LED |
//! |---|---|
//! | Idle | one short flash in 2 s; two in bench mode |
//! | SelfTest | even blinking, 1 Hz |
//! | Prove, Ramp, Seek | even blinking, 4 Hz |
//! | Hold | on |
//! | Manual | on, with a short gap in every second |
//! | Stop | even blinking, 2 Hz |
//! | Fault | as many flashes as the fault's number (docs/controller.md), then 2 s dark |

use shared::control::State;

/// Steps of the pattern per second.
pub const RATE_HZ: u32 = 100;

/// A fault's flash, on and off, steps.
const FLASH: (u32, u32) = (20, 20);
/// The pause after a fault's flashes, steps.
const PAUSE: u32 = 2 * RATE_HZ;

/// What the LED shows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LedShown {
    /// What the controller is doing.
    pub state: State,
    /// Number of the present or last fault, which is flashed in Fault; 0 for none.
    pub fault: u8,
    /// Bench mode: the model takes the place of the rig.
    pub bench: bool,
}

/// The LED's pattern: what it shows, and how far it has come.
#[derive(Clone, Copy, Debug, Default)]
pub struct LedPattern {
    shown: LedShown,
    step: u32,
}

impl LedPattern {
    /// Whether the LED is lit in the next hundredth of a second. A new state starts its pattern from the beginning.
    pub fn step(&mut self, shown: LedShown) -> bool {
        if shown != self.shown {
            *self = Self { shown, step: 0 };
        }
        let step = self.step;
        self.step = step.wrapping_add(1);
        let even = |period: u32| step % period < period / 2;
        match shown.state {
            State::Idle => match step % (2 * RATE_HZ) {
                0..=5 => true,
                25..=30 => shown.bench,
                _ => false,
            },
            State::SelfTest => even(RATE_HZ),
            State::Prove | State::Ramp | State::Seek => even(RATE_HZ / 4),
            State::Hold => true,
            State::Manual => step % RATE_HZ < RATE_HZ - 10,
            State::Stop => even(RATE_HZ / 2),
            State::Fault => {
                let flash = FLASH.0 + FLASH.1;
                let flashes = u32::from(shown.fault) * flash;
                let within = step % (flashes + PAUSE);
                within < flashes && within % flash < FLASH.0
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Times the LED comes on in `seconds`.
    fn flashes(shown: LedShown, seconds: u32) -> usize {
        let mut pattern = LedPattern::default();
        let lit: [bool; 3000] = core::array::from_fn(|_| pattern.step(shown));
        let end = (seconds * RATE_HZ) as usize;
        let begins = usize::from(lit[0]);
        begins + lit[..end].windows(2).filter(|w| !w[0] && w[1]).count()
    }

    fn in_state(state: State) -> LedShown {
        LedShown {
            state,
            ..LedShown::default()
        }
    }

    #[test]
    fn each_state_has_its_own_pattern() {
        let mut bench = in_state(State::Idle);
        assert_eq!(flashes(bench, 10), 5);
        bench.bench = true;
        assert_eq!(flashes(bench, 10), 10);
        assert_eq!(flashes(in_state(State::SelfTest), 10), 10);
        assert_eq!(flashes(in_state(State::Stop), 10), 20);
        assert_eq!(flashes(in_state(State::Seek), 10), 40);
        assert_eq!(flashes(in_state(State::Hold), 10), 1);
        assert_eq!(flashes(in_state(State::Manual), 10), 10);
    }

    #[test]
    fn a_faults_number_can_be_counted() {
        for fault in [1, 7, 16] {
            let shown = LedShown {
                fault,
                ..in_state(State::Fault)
            };
            let mut pattern = LedPattern::default();
            let round = u32::from(fault) * 40 + 200;
            let lit: std::vec::Vec<_> = (0..2 * round).map(|_| pattern.step(shown)).collect();
            let rises = lit.windows(2).filter(|w| !w[0] && w[1]).count();
            assert_eq!(rises, 2 * usize::from(fault) - 1);
            let dark = lit.iter().rev().take_while(|lit| !**lit).count();
            assert!(dark >= 200, "{fault}");
        }
    }
}
