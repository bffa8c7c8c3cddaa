//! Waiting that is not executed: time goes on to what ends it, and the machine is what it would be if every instruction had
//! been executed.
//!
//! What happens by itself meanwhile (a conversion, a byte, a timer) happens at its time, and is seen at the same instruction
//! as without this. The waiting ends at the first instruction at which an interrupt's line changes, a sampling tick begins
//! or the run ends; the last time round is executed up to it.

use crate::core::Try;
use crate::machine::Machine;
use crate::profile::Profile;
use crate::waiting::Round;

/// Why the waiting ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Ended {
    /// The run's time is over, or what comes now is for the run itself.
    Here,
    /// Something has happened that the program may notice.
    Noticed,
}

/// Where in the loops an instruction is: times round, and its number in the next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Spot {
    rounds: u64,
    instruction: usize,
    /// Cycles since the start.
    cycles: u64,
}

impl Round {
    /// The first instruction that begins at `cycles` since the start or later.
    fn spot(&self, cycles: u64) -> Spot {
        let length = u64::from(self.cycles);
        let (rounds, left) = (cycles / length, cycles % length);
        let executed = &self.executed;
        let instruction = executed.partition_point(|e| u64::from(e.cycles) < left);
        match executed.get(instruction) {
            Some(e) => Spot {
                rounds,
                instruction,
                cycles: rounds * length + u64::from(e.cycles),
            },
            None => Spot {
                rounds: rounds + 1,
                instruction: 0,
                cycles: (rounds + 1) * length,
            },
        }
    }
}

impl Machine {
    /// At the head of a loop: waits there if it is known to be one of waiting.
    ///
    /// # Errors
    /// A rule is broken meanwhile.
    pub(crate) fn at_head(&mut self) -> Try<Ended> {
        let Some(round) = self.known_round() else {
            return Ok(Ended::Noticed);
        };
        let ended = if self.may_wait(&round) {
            self.wait_in(&round)
        } else {
            Ok(Ended::Noticed)
        };
        self.keep_round(round);
        ended
    }

    /// Waits through a loop whose head is the next instruction.
    ///
    /// # Errors
    /// A rule is broken meanwhile.
    fn wait_in(&mut self, round: &Round) -> Try<Ended> {
        let unit = u64::from(self.unit);
        let start = (self.now, self.cycles);
        // What is looked at by instructions, not by events.
        let profile = self.profile.take();
        let mut ended = Ok(Ended::Here);
        let spot = loop {
            let next = self.next_event.min(self.until);
            let spot = round.spot(next.saturating_sub(start.0).div_ceil(unit));
            let at = start.0 + spot.cycles * unit;
            if at >= self.until || !self.is_harmless(at) {
                break spot;
            }
            (self.now, self.cycles) = (at, start.1 + spot.cycles);
            match self.happen() {
                Ok(()) if self.pause || self.attention || self.nvic.changed => {
                    ended = Ok(Ended::Noticed);
                    break spot;
                }
                Ok(()) => {}
                Err(trap) => {
                    ended = Err(trap);
                    break spot;
                }
            }
        };
        self.profile = profile;
        (self.now, self.cycles) = start;
        self.pass(round, spot)?;
        if ended == Ok(Ended::Noticed) {
            self.profile_lines();
        }
        ended
    }

    /// Whether all that happens until then leaves the processor alone.
    fn is_harmless(&self, until: u64) -> bool {
        let p = &self.parts;
        p.watchdog.next().min(p.rcc.next()) > until
    }

    /// Whether the waiting may be left out: nothing is on its way that could touch what the loop touches.
    fn may_wait(&self, round: &Round) -> bool {
        let calm = self.parts.flash.work.is_none()
            && self.tick_due().is_none()
            && self.nvic.most_urgent().is_none()
            && !self.late_fault
            && !self.reset_asked
            && round.cycles > 0;
        let streams = self.parts.dma.iter().flat_map(|dma| &dma.streams);
        calm && streams.filter(|stream| stream.is_on()).all(|stream| {
            let (start, bytes) = stream.whole_buffer();
            !round.touches(start, bytes)
        })
    }

    fn set_word(&mut self, number: u32, value: u32) {
        let at = 4 * number as usize;
        self.ram[at..at + 4].copy_from_slice(&value.to_le_bytes());
    }

    /// The processor goes on to a spot of the loop, with nothing to be looked at on the way.
    fn pass(&mut self, round: &Round, spot: Spot) -> Try {
        let count = round.executed.len() as u64;
        if spot.rounds > 0 {
            if let Some(profile) = &mut self.profile {
                profile.pass(round, self.cycles, spot.rounds);
            }
            if let Some((word, step)) = round.grows {
                let grown = step.wrapping_mul(spot.rounds as u32);
                self.set_word(word, self.word(word).wrapping_add(grown));
            }
            for word in round.words.iter().filter(|word| word.written_first) {
                self.set_word(word.number, word.value);
            }
            self.instructions += count * spot.rounds;
            self.passed += count * spot.rounds;
            let cycles = u64::from(round.cycles) * spot.rounds;
            self.cycles += cycles;
            self.now += cycles * u64::from(self.unit);
        }
        for _ in 0..spot.instruction {
            self.step()?;
        }
        Ok(())
    }
}

impl Profile {
    /// What the fetches and loads of so many times round cost; the first begins at `cycles`.
    fn pass(&mut self, round: &Round, cycles: u64, rounds: u64) {
        let length = u64::from(round.cycles);
        let mut head = cycles;
        for done in 1..=rounds {
            let (standing, extra) = (self.standing(head), self.extra);
            self.once(round, head);
            head += length;
            if self.standing(head) == standing {
                // From here on every time costs the same.
                let each = [0, 1].map(|i| self.extra[i] - extra[i]);
                self.repeat(each, length, rounds - done);
                return;
            }
        }
    }

    fn once(&mut self, round: &Round, head: u64) {
        let mut loads = round.literals.iter().peekable();
        for (i, executed) in round.executed.iter().enumerate() {
            let cycles = head + u64::from(executed.cycles);
            self.fetch(executed.pc, executed.op.len, cycles);
            while let Some((_, at)) = loads.next_if(|(of, _)| *of as usize == i) {
                self.load(*at as usize);
            }
        }
    }
}
