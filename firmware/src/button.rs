//! The one button: start, stop, acknowledge an emergency stop, clear a fault.
//!
//! Everything but a start is at once. A start wants the button held for two seconds and let go: neither a short press nor a
//! wire that is shorted for good starts a machine.

use shared::control::{Command, Mode, State};

/// A level must stay this many steps (of 10 ms) to count.
const STEADY: u8 = 3;
/// A start wants the button held so many steps: 2 s.
const HELD: u8 = 200;

/// The button, debounced, and a press that may yet become a start.
#[derive(Clone, Copy, Debug, Default)]
pub struct Button {
    pressed: bool,
    /// Steps at the other level.
    steps: u8,
    /// Steps since a press that may yet become a start, [`HELD`] at most.
    held: Option<u8>,
}

impl Button {
    /// A button that is `pressed` already: held at reset, that press has been used already.
    pub fn new(pressed: bool) -> Self {
        Self {
            pressed,
            ..Self::default()
        }
    }

    /// Takes the level once in 10 ms, in this state; `acknowledge`: what acknowledges an emergency stop, if that is awaited. The
    /// command, in the step in which it is sure.
    pub fn step(
        &mut self,
        pressed: bool,
        state: State,
        acknowledge: Option<Command>,
    ) -> Option<Command> {
        let held = self.held.filter(|_| state == State::Idle);
        if pressed == self.pressed {
            self.steps = 0;
            self.held = held.map(|steps| HELD.min(steps + 1));
            return None;
        }
        self.steps += 1;
        if self.steps < STEADY {
            return None;
        }
        *self = Self::new(pressed);
        if !pressed {
            let start = Command::Start(Mode::Automatic);
            return held.filter(|steps| *steps == HELD).map(|_| start);
        }
        let command = meaning(state, acknowledge);
        if command.is_none() {
            self.held = Some(0);
        }
        command
    }
}

/// What a press does at once: acknowledge an emergency stop where that is awaited, clear a fault, stop whatever drives. In Idle
/// nothing. So after such a stop a fault is cleared by the second press, or over the link.
fn meaning(state: State, acknowledge: Option<Command>) -> Option<Command> {
    match state {
        State::Idle => None,
        State::Fault => Some(acknowledge.unwrap_or(Command::ClearFault)),
        _ => Some(Command::Stop),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    /// The commands while the level is `pressed` for so many steps.
    fn during(button: &mut Button, pressed: bool, steps: usize, state: State) -> Vec<Command> {
        let each = (0..steps).filter_map(|_| button.step(pressed, state, None));
        each.collect()
    }

    #[test]
    fn a_bouncing_press_counts_once() {
        let mut button = Button::default();
        let levels = [1, 0, 1, 1, 0, 1, 1, 1, 1, 1, 0, 1, 0, 0, 0, 0, 0];
        let press = |level: &i32| button.step(*level == 1, State::Hold, None);
        assert_eq!(levels.iter().filter_map(press).count(), 1);
        assert_eq!(during(&mut button, true, 3, State::Hold), [Command::Stop]);
    }

    #[test]
    fn a_start_wants_two_seconds_without_a_break() {
        let start = [Command::Start(Mode::Automatic)];
        let mut button = Button::default();
        assert_eq!(during(&mut button, true, 200, State::Idle), []);
        assert_eq!(during(&mut button, false, 10, State::Idle), []);
        // Twice a second and a half is no three seconds.
        for _ in 0..2 {
            assert_eq!(during(&mut button, true, 150, State::Idle), []);
            assert_eq!(during(&mut button, false, 10, State::Idle), []);
        }
        assert_eq!(during(&mut button, true, 210, State::Idle), []);
        assert_eq!(during(&mut button, false, 10, State::Idle), start);
        // Shorted for good it starts nothing; nor does a press that another state interrupted.
        assert_eq!(during(&mut button, true, 1000, State::Idle), []);
        assert_eq!(during(&mut button, true, 1, State::Fault), []);
        assert_eq!(during(&mut button, false, 10, State::Idle), []);
    }

    #[test]
    fn a_press_that_stopped_the_drive_does_not_start_it_again() {
        let mut button = Button::default();
        assert_eq!(during(&mut button, true, 50, State::Hold), [Command::Stop]);
        assert_eq!(during(&mut button, true, 500, State::Idle), []);
        let mut button = Button::default();
        let cleared = during(&mut button, true, 50, State::Fault);
        assert_eq!(cleared, [Command::ClearFault]);
        assert_eq!(during(&mut button, true, 500, State::Idle), []);
    }

    #[test]
    fn an_emergency_stop_is_acknowledged_before_its_fault_is_cleared() {
        let awaited = Some(Command::Acknowledge { opened: true });
        assert_eq!(meaning(State::Fault, awaited), awaited);
        assert_eq!(meaning(State::Fault, None), Some(Command::ClearFault));
        assert_eq!(meaning(State::Hold, awaited), Some(Command::Stop));
    }

    #[test]
    fn held_at_reset_is_no_press() {
        let mut button = Button::new(true);
        assert_eq!(during(&mut button, true, 500, State::Idle), []);
        assert_eq!(during(&mut button, false, 10, State::Idle), []);
        assert_eq!(during(&mut button, true, 300, State::Idle), []);
        assert_eq!(during(&mut button, false, 10, State::Idle).len(), 1);
    }
}
