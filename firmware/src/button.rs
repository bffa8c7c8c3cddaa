//! The one button: start, stop, acknowledge an emergency stop, clear a fault.

use shared::control::{Command, Mode, State};

/// A level must stay this many steps (of 10 ms) to count.
const STEADY: u8 = 3;

/// The button, debounced.
#[derive(Clone, Copy, Debug, Default)]
pub struct Button {
    pressed: bool,
    steps: u8,
}

impl Button {
    /// A button that is `pressed` already: held at reset, that press has been used already.
    pub fn new(pressed: bool) -> Self {
        Self { pressed, steps: 0 }
    }

    /// Takes the level once in 10 ms; true in the step in which a press is sure.
    pub fn step(&mut self, pressed: bool) -> bool {
        if pressed == self.pressed {
            self.steps = 0;
            return false;
        }
        self.steps += 1;
        if self.steps < STEADY {
            return false;
        }
        *self = Self { pressed, steps: 0 };
        pressed
    }
}

/// The command of a press: start from Idle, acknowledge an emergency stop that must be (`awaited`), clear a fault, stop
/// anything else. So after such a stop a fault is cleared by the second press, or over the link.
pub fn meaning(state: State, awaited: bool) -> Command {
    match state {
        State::Idle => Command::Start(Mode::Automatic),
        State::Fault if awaited => Command::Acknowledge,
        State::Fault => Command::ClearFault,
        _ => Command::Stop,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bouncing_press_counts_once() {
        let mut button = Button::default();
        let levels = [1, 0, 1, 1, 0, 1, 1, 1, 1, 1, 0, 1, 0, 0, 0, 0, 0];
        let presses = levels.iter().filter(|level| button.step(**level == 1));
        assert_eq!(presses.count(), 1);
        let again = [1, 1, 1].iter().filter(|level| button.step(**level == 1));
        assert_eq!(again.count(), 1);
    }

    #[test]
    fn an_emergency_stop_is_acknowledged_before_its_fault_is_cleared() {
        assert_eq!(meaning(State::Fault, true), Command::Acknowledge);
        assert_eq!(meaning(State::Fault, false), Command::ClearFault);
        assert_eq!(meaning(State::Hold, true), Command::Stop);
    }

    #[test]
    fn held_at_reset_is_no_press() {
        let mut button = Button::new(true);
        assert!(!(0..10).any(|_| button.step(true)));
        assert!(!(0..10).any(|_| button.step(false)));
        assert!((0..10).any(|_| button.step(true)));
    }
}
