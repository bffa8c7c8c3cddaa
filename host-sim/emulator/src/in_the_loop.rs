//! The controller twice: in another processor behind two pipes, and in this one, bit for bit compared.
//!
//! The other processor closes the loop: its set-points move the plant. Whatever is asked of it is asked of the
//! desktop's controller, too, and each pair of replies ([`shared::link::in_the_loop`]) is compared as bytes. As long as
//! all are equal, the desktop alone would have made the same run.

use std::collections::VecDeque;
use std::io::{Read, Write};

use shared::control::{BootInfo, Command, Event, Lockstep, Refused, Status};
use shared::io::{Frame, Output};
use shared::link::in_the_loop::{
    ExchangeReply, ExchangeRequest, LENGTH, MAX_EVENTS, MAX_MESSAGE, decode, encode, length,
};
use shared::settings::Settings;

use super::local::birth;
use super::under_test::{ControlUnderTest, Reset};
use files::UserError;

/// The first difference between the two.
#[derive(Clone, Debug, PartialEq)]
pub struct LoopDifference {
    /// Control tick after the block, on the desktop.
    pub tick: u32,
    /// What was said there and here.
    pub text: String,
}

/// The controller in both places.
pub struct InTheLoop<R, W> {
    replies: R,
    requests: W,
    settings: Settings,
    desktop: Lockstep,
    status: Status,
    events: VecDeque<Event>,
    difference: Option<LoopDifference>,
    broken: Option<String>,
    /// Instructions of each block at control priority, and its ticks.
    blocks: Vec<(u32, u32)>,
}

impl<R: Read, W: Write> InTheLoop<R, W> {
    /// Makes both controllers anew.
    ///
    /// # Errors
    /// The settings are invalid, or a pipe fails.
    pub fn begin(requests: W, replies: R, settings: &Settings) -> Result<Self, UserError> {
        let desktop = Lockstep::new(settings, &BootInfo::STORED)?;
        let status = desktop.controller.status();
        let mut both = Self {
            replies,
            requests,
            settings: *settings,
            desktop,
            status,
            events: VecDeque::new(),
            difference: None,
            broken: None,
            blocks: Vec::new(),
        };
        both.born(&BootInfo::STORED);
        match both.broken.take() {
            Some(why) => Err(UserError::new(why)),
            None => Ok(both),
        }
    }

    /// The pipes, for another run.
    pub fn release(self) -> (W, R) {
        (self.requests, self.replies)
    }

    /// Where the two first differed; none: nowhere.
    pub fn difference(&self) -> Option<&LoopDifference> {
        self.difference.as_ref()
    }

    /// Why the other processor stopped answering, if it did.
    pub fn broken(&self) -> Option<&str> {
        self.broken.as_deref()
    }

    /// Ticks of all blocks that both have done.
    pub fn ticks(&self) -> u64 {
        self.blocks.iter().map(|(_, ticks)| u64::from(*ticks)).sum()
    }

    /// Instructions per tick at control priority, each block's mean over its ticks, in rising order.
    pub fn instructions_per_tick(&self) -> Vec<u32> {
        let mut all: Vec<_> = self
            .blocks
            .iter()
            .map(|(instructions, ticks)| instructions.div_ceil((*ticks).max(1)))
            .collect();
        all.sort_unstable();
        all
    }

    fn born(&mut self, birth: &BootInfo) {
        let begin = ExchangeRequest::Begin {
            settings: self.settings,
            boot: *birth,
        };
        self.ask(&begin, ExchangeReply::Begun(true));
    }

    /// Asks the other processor and compares its reply with what the desktop says.
    fn ask(&mut self, request: &ExchangeRequest, here: ExchangeReply) -> Option<ExchangeReply> {
        if self.broken.is_some() {
            return None;
        }
        let there = match self.converse(request) {
            Ok(there) => there,
            Err(why) => {
                self.broken = Some(format!("the other processor is gone: {why}"));
                return None;
            }
        };
        let mut bare = there.clone();
        if let ExchangeReply::Block { instructions, .. } = &mut bare {
            *instructions = 0;
        }
        if self.difference.is_none() && bytes(&bare) != bytes(&here) {
            self.difference = Some(LoopDifference {
                tick: self.desktop.controller.status().tick,
                text: format!("there {bare:?}\nhere  {here:?}"),
            });
        }
        Some(there)
    }

    fn converse(&mut self, request: &ExchangeRequest) -> std::io::Result<ExchangeReply> {
        let invalid = |what| std::io::Error::new(std::io::ErrorKind::InvalidData, what);
        let mut buffer = [0; LENGTH + MAX_MESSAGE];
        let message = encode(request, &mut buffer).ok_or_else(|| invalid("request too long"))?;
        self.requests.write_all(message)?;
        self.requests.flush()?;
        let mut head = [0; LENGTH];
        self.replies.read_exact(&mut head)?;
        let mut body = vec![0; length(head).ok_or_else(|| invalid("reply too long"))?];
        self.replies.read_exact(&mut body)?;
        decode(&body).ok_or_else(|| invalid("a reply that is none"))
    }

    fn block(&mut self, frames: &[Frame], outputs: &mut [Output], blind: bool, slices: u32) {
        let slices = u16::try_from(slices).unwrap_or(u16::MAX);
        let exchanged = if blind {
            self.desktop.blind_block(outputs)
        } else {
            self.desktop.block(frames, outputs)
        };
        self.desktop.idle(u32::from(slices));
        let events = std::iter::from_fn(|| self.desktop.controller.take_event());
        let events = events.take(MAX_EVENTS).collect();
        let request = ExchangeRequest::Block {
            frames: frames.iter().copied().collect(),
            blind,
            slices,
        };
        let here = ExchangeReply::Block {
            outputs: outputs.iter().copied().collect(),
            status: self.desktop.controller.status(),
            events,
            delivered: exchanged.delivered,
            instructions: 0,
        };
        let reply = match self.ask(&request, here.clone()) {
            Some(there @ ExchangeReply::Block { .. }) => there,
            _ => here,
        };
        if let ExchangeReply::Block {
            outputs: said,
            status,
            events,
            instructions,
            ..
        } = reply
        {
            for (output, said) in outputs.iter_mut().zip(&said) {
                *output = *said;
            }
            self.status = status;
            self.events.extend(events);
            if self.broken.is_none() {
                self.blocks.push((instructions, outputs.len() as u32));
            }
        }
    }
}

fn bytes(reply: &ExchangeReply) -> Vec<u8> {
    let mut buffer = [0; LENGTH + MAX_MESSAGE];
    encode(reply, &mut buffer)
        .map(<[u8]>::to_vec)
        .unwrap_or_default()
}

impl<R: Read, W: Write> ControlUnderTest for InTheLoop<R, W> {
    fn exchange(&mut self, frames: &[Frame], outputs: &mut [Output], slices: u32) {
        self.block(frames, outputs, false, slices);
    }

    fn exchange_blind(&mut self, outputs: &mut [Output], slices: u32) {
        let frames = vec![Frame::default(); outputs.len()];
        self.block(&frames, outputs, true, slices);
    }

    fn command(&mut self, command: Command) -> Result<(), Refused> {
        let here = self.desktop.controller.command(command);
        match self.ask(
            &ExchangeRequest::Command(command),
            ExchangeReply::Command(here),
        ) {
            Some(ExchangeReply::Command(there)) => there,
            _ => here,
        }
    }

    fn status(&mut self) -> Status {
        self.status
    }

    fn take_event(&mut self) -> Option<Event> {
        self.events.pop_front()
    }

    fn note_overrun(&mut self) {
        self.desktop.controller.note_overrun();
        self.ask(&ExchangeRequest::Overrun, ExchangeReply::Noted);
    }

    fn reset(&mut self, cause: Reset) -> BootInfo {
        let memory = self.desktop.controller.persisted();
        let birth = birth(cause, &memory);
        if let Ok(anew) = Lockstep::new(&self.settings, &birth) {
            self.desktop = anew;
            self.status = self.desktop.controller.status();
            self.born(&birth);
        }
        birth
    }

    fn settings(&self) -> &Settings {
        &self.settings
    }
}

/// Tells the other processor that the last run is over.
///
/// # Errors
/// The pipe fails.
pub fn end(requests: &mut impl Write) -> Result<(), UserError> {
    let mut buffer = [0; LENGTH + MAX_MESSAGE];
    let message = encode(&ExchangeRequest::End, &mut buffer).unwrap_or(&[]);
    let sent = requests.write_all(message).and_then(|()| requests.flush());
    sent.map_err(|e| UserError::new(format!("the other processor is gone: {e}")))
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use shared::control::Mode;
    use shared::model::params::WIRES;
    use std::os::unix::net::UnixStream;

    /// Answers requests as the firmware does; `spoil` may change a set-point.
    fn answer(mut stream: UnixStream, spoil: impl Fn(u32, &mut Output)) {
        let mut lockstep = None::<Lockstep>;
        let mut buffer = [0; LENGTH + MAX_MESSAGE];
        loop {
            let mut head = [0; LENGTH];
            stream.read_exact(&mut head).unwrap();
            let mut body = vec![0; length(head).unwrap()];
            stream.read_exact(&mut body).unwrap();
            let reply = match (decode(&body).unwrap(), &mut lockstep) {
                (ExchangeRequest::End, _) => return,
                (
                    ExchangeRequest::Begin {
                        settings,
                        boot: birth,
                    },
                    slot,
                ) => {
                    *slot = Lockstep::new(&settings, &birth).ok();
                    ExchangeReply::Begun(slot.is_some())
                }
                (ExchangeRequest::Command(command), Some(l)) => {
                    ExchangeReply::Command(l.controller.command(command))
                }
                (ExchangeRequest::Block { frames, slices, .. }, Some(l)) => {
                    let mut outputs = [Output::SAFE; 10];
                    let delivered = l.block(&frames, &mut outputs).delivered;
                    l.idle(u32::from(slices));
                    let status = l.controller.status();
                    spoil(status.tick, &mut outputs[3]);
                    let events = std::iter::from_fn(|| l.controller.take_event()).take(4);
                    ExchangeReply::Block {
                        events: events.collect(),
                        outputs: outputs.into_iter().collect(),
                        status,
                        delivered,
                        instructions: 12_345,
                    }
                }
                _ => ExchangeReply::Noted,
            };
            stream
                .write_all(encode(&reply, &mut buffer).unwrap())
                .unwrap();
        }
    }

    fn run(spoil: impl Fn(u32, &mut Output) + Send + 'static) -> (u64, Option<LoopDifference>) {
        let (near, far) = UnixStream::pair().unwrap();
        let other = std::thread::spawn(move || answer(far, spoil));
        let settings = Settings::for_rig(&WIRES);
        let requests = near.try_clone().unwrap();
        let mut both = InTheLoop::begin(requests, near, &settings).unwrap();
        assert_eq!(both.command(Command::Start(Mode::Automatic)), Ok(()));
        let mut outputs = [Output::SAFE; 10];
        for _ in 0..50 {
            both.exchange(&[Frame::default(); 10], &mut outputs, 2);
        }
        let found = (both.ticks(), both.difference().cloned());
        assert_eq!(both.instructions_per_tick()[0], 1235);
        end(&mut both.release().0).unwrap();
        other.join().unwrap();
        found
    }

    #[test]
    fn equal_runs_are_equal_and_one_bit_is_found() {
        assert_eq!(run(|_, _| ()), (500, None));
        let (ticks, difference) = run(|tick, output| {
            if tick == 250 {
                output.frequency_hz = f32::from_bits(output.frequency_hz.to_bits() ^ 1);
            }
        });
        assert_eq!(ticks, 500);
        assert_eq!(difference.unwrap().tick, 250);
    }
}
