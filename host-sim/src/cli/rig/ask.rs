//! The questions of `rig new` on a terminal, for what the options leave open.

use std::io::{BufRead, Write};
use std::path::PathBuf;

use clap::ValueEnum;

use super::answers::{Answers, RingDown, Support, ring_down};
use super::describe::{check_frequency, known_hz, natural_frequency, possible_gap, swung};
use crate::own_rig::contact::{ratios, times};
use crate::own_rig::reading::{
    CONTACT_TIME, FORCE, FREQUENCY, GAP, MASS, OwnReading, RESTITUTION, STROKE, SWING_TIME,
    WIRE_LENGTH,
};
use crate::own_rig::surface::{SURFACES, SurfaceChoice};
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
    let refused = |why: String, option: &str| UserError::new(why).at(option);
    if let Some(Err(why)) = answers.restitution.as_ref().map(ratios) {
        return Err(refused(why, "--restitution"));
    }
    if let Some(Err(why)) = answers.contact_time.as_ref().map(times) {
        return Err(refused(why, "--contact-time"));
    }
    let mut dialogue = Dialogue { input, out };
    dialogue.say("A reading is 298g, or 298+-1g, or several: 298 299 297.5 g. Enter alone leaves out what is in [brackets].")?;
    let support = match answers.support {
        Some(support) => support,
        None => {
            let read = |text: &str| {
                Support::from_str(text, true).map_err(|_| "write wires or beams".to_owned())
            };
            dialogue.needed(
                "What does the hammer hang on: wires or beams",
                "wires",
                read,
            )?
        }
    };
    answers.support = Some(support);
    check_frequency(answers, support)?;
    if answers.mass.is_none() {
        let question = "Weight of the hammer, g or kg";
        answers.mass = Some(dialogue.measured(question, "298g", |text| MASS.read(text))?);
    }
    dialogue.frequency(answers, support)?;
    if support == Support::Beams && answers.ring_down.is_none() && answers.damping_ratio.is_none() {
        let question = "Ringing down freely: swing in mm at first, at last, and full swings between, as 5:3.1:20";
        answers.ring_down = dialogue.open::<RingDown>(question, ring_down)?;
    }
    if answers.stroke.is_none() {
        let question = "Stroke of the cart from end to end, mm";
        answers.stroke =
            Some(dialogue.measured(question, "1.8mm", |text| STROKE.read_in("mm", text))?);
    }
    if answers.cart_mass.is_none() {
        let question = "Weight of the cart without the hammer, g or kg";
        answers.cart_mass = Some(dialogue.measured(question, "5.4kg", |text| MASS.read(text))?);
    }
    if answers.shaker_loop.is_none() {
        let question = "Natural frequency of the shaker's position loop, Hz";
        answers.shaker_loop = dialogue.perhaps(question, |text| FREQUENCY.read_in("Hz", text))?;
    }
    if answers.shaker_loop.is_some() && answers.shaker_force.is_none() {
        let question = "Largest force that the shaker can give, N";
        answers.shaker_force = dialogue.perhaps(question, |text| FORCE.read_in("N", text))?;
    }
    let hz = known_hz(answers);
    let fits = |gap: &OwnReading| hz.map_or(Ok(()), |hz| possible_gap(support, hz, gap));
    if let Some(Err(why)) = answers.gap.as_ref().map(fits) {
        dialogue.say(&format!("  --gap {why}"))?;
        answers.gap = None;
    }
    if answers.gap.is_none() {
        answers.gap = dialogue.perhaps("Gap at rest, mm", |text| {
            let gap = GAP.read_in("mm", text)?;
            fits(&gap).map(|()| gap)
        })?;
    }
    dialogue.contact(answers)
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
    fn frequency(&mut self, answers: &mut Answers, support: Support) -> Result<(), UserError> {
        if answers.swings.is_some() || answers.natural_frequency.is_some() {
            return Ok(());
        }
        if support == Support::Wires && answers.wire_length.is_none() {
            let question = "Wires, from their suspension to the hammer's centre of mass, mm";
            answers.wire_length = self.perhaps(question, |text| WIRE_LENGTH.read_in("mm", text))?;
        }
        let count = |text: &str| match text.parse() {
            Ok(swings @ 1..=100_000) => Ok(swings),
            _ => Err("write a whole number from 1 to 100000".to_owned()),
        };
        let question =
            "Number of full swings timed with the stopwatch, cart held still, without contact";
        answers.swings = if answers.wire_length.is_some() {
            self.open(question, count)?
        } else {
            Some(self.needed(question, "20", count)?)
        };
        if let Some(swings) = answers.swings {
            let time = |text: &str| {
                let time = SWING_TIME.read_in("s", text)?;
                natural_frequency(support, swung(swings, &time))?;
                Ok(time)
            };
            answers.swing_time = Some(self.measured("Their time, s", "10.99s", time)?);
        }
        Ok(())
    }

    fn contact(&mut self, answers: &mut Answers) -> Result<(), UserError> {
        if answers.drop_test.is_some() {
            return Ok(());
        }
        if answers.surface.is_none()
            && answers.restitution.is_none()
            && answers.contact_time.is_none()
        {
            let record = |text: &str| match crate::record::read(text.as_ref(), |_| (), |_| ()) {
                Ok(_) => Ok(PathBuf::from(text)),
                Err(why) => Err(why.to_string()),
            };
            answers.drop_test = self.open("File of a drop test (time_s, force_n)", record)?;
            if answers.drop_test.is_some() {
                return Ok(());
            }
        }
        if answers.contact_time.is_none() && answers.surface.is_none() {
            let question = "Time of one contact, ms";
            answers.contact_time = self.perhaps(question, |text| {
                let time = CONTACT_TIME.read_in("ms", text)?;
                times(&time).map(|_| time)
            })?;
        }
        if answers.restitution.is_none() {
            let question =
                "Restitution: the hammer's rebound over the distance that you pulled it back";
            answers.restitution = self.perhaps(question, |text| {
                let restitution = RESTITUTION.read(text)?;
                ratios(&restitution).map(|_| restitution)
            })?;
        }
        let measured = answers.contact_time.is_some() && answers.restitution.is_some();
        if !measured && answers.surface.is_none() {
            let names = SURFACES.each_ref().map(|surface| surface.name()).join(", ");
            let read = |text: &str| {
                SurfaceChoice::meant(text).ok_or_else(|| format!("write one of {names}"))
            };
            let question = format!("What does the hammer strike: {names}");
            answers.surface = Some(self.needed(&question, SURFACES[0].name(), read)?);
        }
        Ok(())
    }

    /// A reading that there must be.
    fn measured(
        &mut self,
        question: &str,
        example: &str,
        read: impl Fn(&str) -> Result<OwnReading, String>,
    ) -> Result<OwnReading, UserError> {
        let reading = self.needed(question, example, &read)?;
        self.doubted(reading, read)
    }

    /// A reading that may be left open.
    fn perhaps(
        &mut self,
        question: &str,
        read: impl Fn(&str) -> Result<OwnReading, String>,
    ) -> Result<Option<OwnReading>, UserError> {
        match self.open(question, &read)? {
            Some(reading) => self.doubted(reading, read).map(Some),
            None => Ok(None),
        }
    }

    /// `reading`, or what is written in its place if it is doubtful.
    fn doubted(
        &mut self,
        reading: OwnReading,
        read: impl Fn(&str) -> Result<OwnReading, String>,
    ) -> Result<OwnReading, UserError> {
        let Some(doubt) = &reading.doubt else {
            return Ok(reading);
        };
        self.say(&format!("  {doubt}"))?;
        let again = self.open("again, or Enter to keep it", read)?;
        Ok(again.unwrap_or(reading))
    }

    /// An answer that may be left open.
    fn open<T>(
        &mut self,
        question: &str,
        read: impl Fn(&str) -> Result<T, String>,
    ) -> Result<Option<T>, UserError> {
        loop {
            match self.line(&format!("[{question}]"))?.trim() {
                "" => return Ok(None),
                text => match read(text) {
                    Ok(answer) => return Ok(Some(answer)),
                    Err(why) => self.say(&format!("  {why}"))?,
                },
            }
        }
    }

    /// An answer that there must be.
    fn needed<T>(
        &mut self,
        question: &str,
        example: &str,
        read: impl Fn(&str) -> Result<T, String>,
    ) -> Result<T, UserError> {
        loop {
            match self.line(question)?.trim() {
                "" => self.say(&format!("  this one is needed; for example {example}"))?,
                text => match read(text) {
                    Ok(answer) => return Ok(answer),
                    Err(why) => self.say(&format!("  {why}"))?,
                },
            }
        }
    }

    /// The line that answers `question`.
    fn line(&mut self, question: &str) -> Result<String, UserError> {
        let asked = write!(self.out, "{question}: ").and_then(|()| self.out.flush());
        asked.map_err(|e| UserError::new(format!("cannot ask on the terminal: {e}")))?;
        let mut line = String::new();
        match self.input.read_line(&mut line) {
            Ok(0) => Err(UserError::new(
                "rig new: the answers ended early; nothing was written",
            )),
            Ok(_) => Ok(line),
            Err(e) => Err(UserError::new(format!("cannot read the answer: {e}"))),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::own_rig::reading::{DAMPING_RATIO, ReadingQuantity};

    fn asked(typed: &str, mut answers: Answers) -> (Result<(), UserError>, Answers, String) {
        let mut out = Vec::new();
        let done = ask(&mut answers, &mut typed.as_bytes(), &mut out);
        (done, answers, String::from_utf8(out).unwrap())
    }

    /// Each mistake is answered at its own question, and what was answered before stays.
    #[test]
    fn what_is_open_is_asked_and_a_mistake_is_asked_again() {
        let typed = "rope\nwires\nheavy\n1,7kg\n298\n298g\n0.04mm\n\n20\n0.2s\n10.99s 20s\n10.99 11.02 s\n\
                     1800mm\n1.78mm\n\n5.38kg\n50Hz\n60N\n\nmissing.csv\n\n\n0.32+-0.02\nrope\nRubber\n";
        let (done, answers, out) = asked(typed, Answers::default());
        done.unwrap();
        let text = |reading: &Option<OwnReading>| reading.clone().map(|reading| reading.text);
        assert_eq!(answers.support, Some(Support::Wires));
        assert_eq!(text(&answers.mass).as_deref(), Some("298g"));
        assert_eq!(
            (text(&answers.wire_length), answers.swings),
            (None, Some(20))
        );
        assert_eq!(text(&answers.swing_time).as_deref(), Some("10.99 11.02 s"));
        assert_eq!(text(&answers.stroke).as_deref(), Some("1.78mm"));
        assert_eq!(text(&answers.shaker_force).as_deref(), Some("60N"));
        assert_eq!(text(&answers.restitution).as_deref(), Some("0.32+-0.02"));
        assert_eq!(answers.surface.map(|s| s.0.name()), Some("hard-rubber"));
        for said in [
            "write wires or beams",
            "'heavy' is no number",
            "write 1.7 with a point",
            "298 has no unit; write g or kg",
            "0.04mm is out of range: write 1 mm to 100 m",
            "20 swings in 0.2s are 100.0000 Hz",
            "the readings differ by 82 %",
            "1800mm is out of range",
            "this one is needed; for example 5.4kg",
            "missing.csv",
            "write one of steel, hardened-steel",
        ] {
            assert!(out.contains(said), "{said}: {out}");
        }
    }

    /// What contradicts an earlier answer, or makes no contact, is asked again at once; a plain number has the unit asked
    /// for.
    #[test]
    fn what_cannot_be_is_asked_again_where_it_was_answered() {
        let typed =
            "wires\n298g\n50\n\n1.78\n5.38kg\n30\n60\n40\n0.5\n\n2+-2\n0.57+-0.05\n0.14\n0.32\n";
        let (done, answers, out) = asked(typed, Answers::default());
        done.unwrap();
        for said in [
            "40 mm is more than half the wires' length (50.0 mm)",
            "2+-2 ms reaches down to 0 ms; a contact time must stay above 0",
            "0.14 reaches from 0.1350 to 0.1450",
        ] {
            assert!(out.contains(said), "{said}: {out}");
        }
        let text =
            |reading: &Option<OwnReading>| reading.clone().map(|r| r.text).unwrap_or_default();
        assert_eq!(text(&answers.wire_length), "50 mm");
        assert_eq!(text(&answers.stroke), "1.78 mm");
        assert_eq!(text(&answers.shaker_loop), "30 Hz");
        assert_eq!(text(&answers.shaker_force), "60 N");
        assert_eq!(text(&answers.gap), "0.5 mm");
        assert_eq!(text(&answers.contact_time), "0.57+-0.05 ms");
        assert_eq!(text(&answers.restitution), "0.32");
        crate::cli::rig::describe::describe(&answers).unwrap();
    }

    /// An option cannot be answered better: it is refused before the first question, or asked where an answer contradicts
    /// it.
    #[test]
    fn options_that_cannot_be_lose_no_answer() {
        let given = Answers {
            restitution: Some(RESTITUTION.read("0.14").unwrap()),
            ..Answers::default()
        };
        let (done, _, out) = asked("", given);
        let why = done.unwrap_err().to_string();
        assert!(
            why.starts_with("--restitution: 0.14 reaches") && out.is_empty(),
            "{why}"
        );
        let given = Answers {
            gap: Some(GAP.read("40mm").unwrap()),
            ..Answers::default()
        };
        let typed = "wires\n298g\n50\n\n1.78\n5.38kg\n\n0.5\n\n\n\nsteel\n";
        let (done, answers, out) = asked(typed, given);
        done.unwrap();
        assert!(out.contains("--gap 40mm is more than half"), "{out}");
        assert_eq!(answers.gap.map(|gap| gap.text).as_deref(), Some("0.5 mm"));
    }

    /// What no answer can make right is told before the next question, not after the last.
    #[test]
    fn options_that_do_not_fit_the_support_are_refused_at_once() {
        let long = Answers {
            wire_length: Some(WIRE_LENGTH.read("300mm").unwrap()),
            ..Answers::default()
        };
        let fast = Answers {
            natural_frequency: Some(FREQUENCY.read("300Hz").unwrap()),
            ..Answers::default()
        };
        for (typed, answers, option) in [
            ("beams\n", long, "--wire-length"),
            ("wires\n", fast, "--natural-frequency"),
        ] {
            let (done, _, out) = asked(typed, answers);
            assert!(done.unwrap_err().to_string().starts_with(option));
            assert!(!out.contains("Weight"), "{out}");
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
        let read = |quantity: &ReadingQuantity, text: &str| Some(quantity.read(text).unwrap());
        let given = Answers {
            support: Some(Support::Beams),
            mass: read(&MASS, "298g"),
            natural_frequency: read(&FREQUENCY, "4.5Hz"),
            damping_ratio: read(&DAMPING_RATIO, "0.004"),
            stroke: read(&STROKE, "1.78mm"),
            cart_mass: read(&MASS, "5.38kg"),
            shaker_loop: read(&FREQUENCY, "50Hz"),
            shaker_force: read(&FORCE, "60N"),
            gap: read(&GAP, "0"),
            contact_time: read(&CONTACT_TIME, "0.57ms"),
            restitution: read(&RESTITUTION, "0.3"),
            ..Answers::default()
        };
        let (done, _, out) = asked("", given);
        done.unwrap();
        assert_eq!(out.lines().count(), 1, "{out}");
    }
}
