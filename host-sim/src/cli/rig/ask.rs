//! The questions of `rig new` on a terminal, for what the options leave open.

use std::io::{BufRead, Write};

use clap::ValueEnum;

use super::answers::{Answers, Support};
use crate::own_rig::reading;
use files::UserError;

/// Asks on `out` for what `answers` leaves open, and reads from `input`. An empty line leaves an answer open.
///
/// # Errors
/// If `input` ends before every needed answer is there, or cannot be read.
pub fn ask(
    answers: &mut Answers,
    input: &mut dyn BufRead,
    out: &mut dyn Write,
) -> Result<(), UserError> {
    let mut dialogue = Dialogue { input, out };
    dialogue.say("A reading is 298, or 298+-1, or several with commas: 298,299,297.5. Enter alone leaves out what is in [brackets].")?;
    if answers.support.is_none() {
        let read = |text: &str| {
            Support::from_str(text, true).map_err(|_| "write wires or beams".to_owned())
        };
        answers.support = dialogue.needed("What does the hammer hang on: wires or beams", read)?;
    }
    let wires = answers.support == Some(Support::Wires);
    if answers.mass_g.is_none() {
        answers.mass_g = dialogue.needed("Weight of the hammer, g", as_reading)?;
    }
    dialogue.frequency(answers, wires)?;
    if !wires
        && [
            &answers.ring_down,
            &answers.decrement,
            &answers.damping_ratio,
        ]
        .iter()
        .all(|a| a.is_none())
    {
        answers.ring_down = dialogue.open("Ringing down freely: swing in mm at first, at last, and full swings between, as 5:3.1:20", as_text)?;
    }
    if answers.stroke_mm.is_none() {
        answers.stroke_mm =
            dialogue.needed("Stroke of the cart from end to end, mm", as_reading)?;
    }
    if answers.cart_mass_kg.is_none() {
        answers.cart_mass_kg =
            dialogue.needed("Weight of the cart without the hammer, kg", as_reading)?;
    }
    if answers.shaker_loop_hz.is_none() {
        answers.shaker_loop_hz = dialogue.open(
            "Natural frequency of the shaker's position loop, Hz",
            as_reading,
        )?;
    }
    if answers.gap_mm.is_none() {
        answers.gap_mm = dialogue.open("Gap at rest, mm", as_reading)?;
    }
    dialogue.contact(answers)
}

fn as_text(text: &str) -> Result<String, String> {
    Ok(text.to_owned())
}

fn as_reading(text: &str) -> Result<String, String> {
    reading::read(text).map(|reading| reading.text)
}

struct Dialogue<'a> {
    input: &'a mut dyn BufRead,
    out: &'a mut dyn Write,
}

impl Dialogue<'_> {
    fn say(&mut self, line: &str) -> Result<(), UserError> {
        let said = writeln!(self.out, "{line}");
        said.map_err(|e| UserError::new(format!("cannot ask on the terminal: {e}")))
    }

    /// The length of the wires or the time of some swings; either will do on wires.
    fn frequency(&mut self, answers: &mut Answers, wires: bool) -> Result<(), UserError> {
        if answers.swings.is_some() || answers.natural_frequency_hz.is_some() {
            return Ok(());
        }
        if wires && answers.wire_length_mm.is_none() {
            answers.wire_length_mm = self.open(
                "Wires, from where they hang to the hammer's centre of mass, mm",
                as_reading,
            )?;
        }
        let count = |text: &str| text.parse().map_err(|_| "write a whole number".to_owned());
        let question = "Full swings timed with the stopwatch, cart held still, without contact";
        answers.swings = if answers.wire_length_mm.is_some() {
            self.open(question, count)?
        } else {
            self.needed(question, count)?
        };
        if answers.swings.is_some() {
            answers.swing_time_s = self.needed("Their time, s", as_reading)?;
        }
        Ok(())
    }

    fn contact(&mut self, answers: &mut Answers) -> Result<(), UserError> {
        if answers.drop_test.is_some() || answers.restitution.is_some() {
            return Ok(());
        }
        let file = self.open("File of a drop test (time_s, force_n)", as_text)?;
        answers.drop_test = file.map(Into::into);
        if answers.drop_test.is_none() {
            answers.restitution = self.open(
                "Restitution: how far it rebounds over how far it was pulled back",
                as_reading,
            )?;
        }
        if answers.restitution.is_some() {
            answers.contact_time_ms = self.open("Time of one contact, ms", as_reading)?;
        }
        Ok(())
    }

    /// An answer that may be left open.
    fn open<T>(
        &mut self,
        question: &str,
        read: impl Fn(&str) -> Result<T, String>,
    ) -> Result<Option<T>, UserError> {
        self.answer(&format!("[{question}]"), read, true)
    }

    /// An answer that there must be.
    fn needed<T>(
        &mut self,
        question: &str,
        read: impl Fn(&str) -> Result<T, String>,
    ) -> Result<Option<T>, UserError> {
        self.answer(question, read, false)
    }

    fn answer<T>(
        &mut self,
        question: &str,
        read: impl Fn(&str) -> Result<T, String>,
        may_be_open: bool,
    ) -> Result<Option<T>, UserError> {
        loop {
            let asked = write!(self.out, "{question}: ").and_then(|()| self.out.flush());
            asked.map_err(|e| UserError::new(format!("cannot ask on the terminal: {e}")))?;
            let mut line = String::new();
            let length = self.input.read_line(&mut line);
            let length =
                length.map_err(|e| UserError::new(format!("cannot read the answer: {e}")))?;
            if length == 0 {
                return Err(UserError::new(
                    "rig new: the answers ended early; nothing was written",
                ));
            }
            match line.trim() {
                "" if may_be_open => return Ok(None),
                "" => self.say("  this one is needed")?,
                text => match read(text) {
                    Ok(answer) => return Ok(Some(answer)),
                    Err(why) => self.say(&format!("  {why}"))?,
                },
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn asked(typed: &str, mut answers: Answers) -> (Result<(), UserError>, Answers, String) {
        let mut out = Vec::new();
        let done = ask(&mut answers, &mut typed.as_bytes(), &mut out);
        (done, answers, String::from_utf8(out).unwrap())
    }

    #[test]
    fn what_is_open_is_asked_and_a_mistake_is_asked_again() {
        let typed =
            "rope\nwires\nheavy\n298\n\n20\n10.99,11.02\n\n1.78\n5.38\n\n\n\n0.32+-0.02\n\n";
        let (done, answers, out) = asked(typed, Answers::default());
        done.unwrap();
        assert_eq!(answers.support, Some(Support::Wires));
        assert_eq!(answers.mass_g.as_deref(), Some("298"));
        assert_eq!((answers.wire_length_mm, answers.swings), (None, Some(20)));
        assert_eq!(answers.stroke_mm.as_deref(), Some("1.78"));
        assert_eq!(answers.restitution.as_deref(), Some("0.32+-0.02"));
        for said in [
            "write wires or beams",
            "'heavy' is no number",
            "this one is needed",
        ] {
            assert!(out.contains(said), "{said}: {out}");
        }
    }

    #[test]
    fn an_end_of_the_answers_is_one_line() {
        let (done, ..) = asked("beams\n", Answers::default());
        assert!(
            done.unwrap_err()
                .to_string()
                .contains("nothing was written")
        );
    }

    #[test]
    fn what_the_options_say_is_not_asked() {
        let given = Answers {
            support: Some(Support::Beams),
            mass_g: Some("298".into()),
            natural_frequency_hz: Some("4.5".into()),
            damping_ratio: Some("0.004".into()),
            stroke_mm: Some("1.78".into()),
            cart_mass_kg: Some("5.38".into()),
            shaker_loop_hz: Some("50".into()),
            gap_mm: Some("0".into()),
            restitution: Some("0.3".into()),
            ..Answers::default()
        };
        let (done, _, out) = asked("", given);
        done.unwrap();
        assert_eq!(out.lines().count(), 1, "{out}");
    }
}
