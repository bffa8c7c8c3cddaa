//! The computer's side of the link: requests to a board, and the messages it streams.

use std::collections::VecDeque;
use std::io::{self, ErrorKind, Read, Write};
use std::time::{Duration, Instant, SystemTime};

use serialport::SerialPort;
use shared::control::{Command, Refused, SettingsState, Status};
use shared::link::{
    BoardState, FromBoard, Hello, LinkAct, LinkAnswer, MAX_FRAME, PROTOCOL_VERSION, Packet, RATES,
    Refusal, SESSION_S, ToBoard, encode,
};
use shared::settings::Settings;
use wire::Caller;

use files::UserError;

use super::port;

/// How long an answer may take. The board answers within milliseconds; a computer's serial driver may not.
const PATIENCE: Duration = Duration::from_millis(700);

/// Settings are stored in flash before the answer: erasing takes up to 0.8 s on an STM32F446.
const PATIENCE_FOR_FLASH: Duration = Duration::from_secs(3);

/// How often a request is sent before the board counts as silent.
const ATTEMPTS: u32 = 3;

/// Streamed messages stored while waiting for an answer: a second of recording at 2000 blocks a second.
const KEPT: usize = 2000;

/// A conversation with a board over `P`, whose reads must not wait long (or at all).
#[derive(Debug)]
pub struct Client<P> {
    port: P,
    name: String,
    caller: Caller,
    streamed: VecDeque<FromBoard>,
}

/// Opens the serial port (or pseudo-terminal) `name` and makes sure that a board of our protocol answers: at the rate
/// `baud`, or
/// without one at the first of the board's own at which it does.
///
/// # Errors
/// If the port does not exist or is in use, or no board of this protocol answers.
pub fn open(name: &str, baud: Option<u32>) -> Result<Opened, UserError> {
    at_a_rate(baud, |baud| {
        let port = port::open_alone(name, baud)?;
        let mut client = Client::new(port, name);
        let hello = client.hello()?;
        Ok(Opened {
            client,
            hello,
            baud,
        })
    })
}

/// A port at which a board answers.
#[derive(Debug)]
pub struct Opened {
    /// The conversation with the board over that port.
    pub client: Client<Box<dyn SerialPort>>,
    /// Versions and names that the board answered with.
    pub hello: Hello,
    /// The rate, bits per second.
    pub baud: u32,
}

/// What `open` gives at the rate `baud`, or without one at the first of a board's rates at which it gives something.
///
/// # Errors
/// That of the first attempt.
fn at_a_rate<T>(
    baud: Option<u32>,
    mut open: impl FnMut(u32) -> Result<T, UserError>,
) -> Result<T, UserError> {
    let [usual, slower] = RATES;
    match baud {
        Some(baud) => open(baud),
        None => open(usual).or_else(|why| open(slower).map_err(|_| why)),
    }
}

/// Sends a stop to the port `name` if another program uses it, as often as an unanswered one would be sent. The answers go
/// to that program, so nothing says whether it came through. False, and nothing is sent, if nobody uses the port.
///
/// # Errors
/// If the port may not be used, or breaks.
pub fn stop_beside_another(name: &str) -> Result<bool, UserError> {
    let mut frame = [0; MAX_FRAME];
    let packet = Packet {
        sequence: 0,
        message: ToBoard::Command(Command::Stop),
    };
    let stop = encode(&packet, &mut frame)
        .ok_or_else(|| UserError::new("too long").at(name))?
        .repeat(ATTEMPTS as usize);
    // The zero ends whatever half frame the other program has sent.
    port::write_beside_another(name, &[&[0], stop.as_slice()].concat())
}

impl<P: Read + Write> Client<P> {
    /// A conversation over an open port called `name`.
    pub fn new(port: P, name: &str) -> Self {
        // Anything but the number an earlier program used last: late answers to it must not be taken for ours.
        let now = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH);
        let sequence = now.map_or(0, |now| now.subsec_micros() as u16);
        Self {
            port,
            name: name.to_owned(),
            caller: Caller::new(sequence),
            streamed: VecDeque::new(),
        }
    }

    /// Numbers packets from `sequence` on, so that two conversations can be the same, byte by byte.
    #[must_use]
    pub fn numbered_from(mut self, sequence: u16) -> Self {
        self.caller = Caller::new(sequence);
        self
    }

    /// The port, to talk to it beside the conversation.
    pub fn port(&mut self) -> &mut P {
        &mut self.port
    }

    /// The port, and the number of the last request.
    pub fn into_parts(self) -> (P, u16) {
        (self.port, self.caller.sequence())
    }

    /// Name of the port, as it was opened.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Packets of the board that did not arrive.
    pub fn lost(&self) -> u64 {
        self.caller.lost()
    }

    /// Asks for name and protocol of the board. This also ends every stream.
    ///
    /// # Errors
    /// If the board does not answer, or has another protocol.
    pub fn hello(&mut self) -> Result<Hello, UserError> {
        // Ends whatever half frame the board may be in.
        self.write(&[0])?;
        let mut hello = match self.ask(ToBoard::Hello)? {
            LinkAnswer::Hello(hello) => hello,
            other => return Err(self.odd(&other)),
        };
        // Whatever is on the wire, a name is shown on a terminal: no escape sequence gets there.
        for name in [&mut hello.board, &mut hello.firmware] {
            *name = name
                .chars()
                .map(|c| {
                    if c.is_ascii_graphic() || c == ' ' {
                        c
                    } else {
                        '?'
                    }
                })
                .collect();
        }
        if hello.protocol != PROTOCOL_VERSION {
            return Err(self.complaint(format!(
                "the board speaks protocol {} and this program {PROTOCOL_VERSION}; use the host-sim of its firmware ({}), or flash the firmware of this one",
                hello.protocol, hello.firmware
            )));
        }
        self.streamed.clear();
        self.caller.count_anew();
        Ok(hello)
    }

    /// Sends a request and waits for its answer; messages streamed meanwhile are stored. Without an answer, a request
    /// that does no harm when it comes twice is sent again.
    ///
    /// # Errors
    /// If the port fails, or the board does not answer.
    pub fn ask(&mut self, request: ToBoard) -> Result<LinkAnswer, UserError> {
        let (patience, attempts) = match request {
            ToBoard::Steer { act, .. } => patience_for(&act),
            // A second one would name a number that is no longer the board's.
            ToBoard::OpenSession { .. } => (PATIENCE * ATTEMPTS, 1),
            _ => (PATIENCE, ATTEMPTS),
        };
        for _ in 0..attempts {
            let frame = self.caller.frame(request);
            let frame = frame.ok_or_else(|| self.complaint("too long"))?;
            self.write(&frame)?;
            if let Some(answer) = self.await_answer(patience)? {
                return Ok(answer);
            }
        }
        Err(self.complaint(format!(
            "no answer within {:.1} s; is the board powered and flashed, and is this its port?",
            (patience * attempts).as_secs_f64()
        )))
    }

    /// As [`Client::ask`], for requests whose answer is that they are done.
    ///
    /// # Errors
    /// If the port fails, or the board does not answer or refuses the request.
    pub fn tell(&mut self, request: ToBoard) -> Result<(), UserError> {
        match self.ask(request)? {
            LinkAnswer::Done => Ok(()),
            LinkAnswer::Refused(refusal) => Err(self.complaint(reason(refusal))),
            other => Err(self.odd(&other)),
        }
    }

    /// Its settings.
    ///
    /// # Errors
    /// If it does not answer, or gives something else.
    pub fn settings(&mut self) -> Result<Settings, UserError> {
        match self.ask(ToBoard::GetSettings)? {
            LinkAnswer::Settings(settings) => Ok(settings),
            other => Err(self.odd(&other)),
        }
    }

    /// What must be known before steering.
    ///
    /// # Errors
    /// As those of [`Client::ask`].
    pub fn board(&mut self) -> Result<BoardState, UserError> {
        match self.ask(ToBoard::GetBoard)? {
            LinkAnswer::Board(board) => Ok(board),
            other => Err(self.odd(&other)),
        }
    }

    /// Opens the session, which is needed to steer; `take_over`: from another program, if one has it. Without that, a
    /// session that is held is waited for, as long as one can outlive its program.
    ///
    /// # Errors
    /// As those of [`Client::tell`].
    pub fn open_session(&mut self, take_over: bool) -> Result<(), UserError> {
        let until = Instant::now() + Duration::from_secs_f32(1.5 * SESSION_S);
        loop {
            let board = self.board()?;
            if board.held && !take_over && Instant::now() < until {
                std::thread::sleep(Duration::from_millis(100));
                continue;
            }
            let request = ToBoard::OpenSession {
                boot: board.boot,
                granted: board.granted,
                take_over,
            };
            return match self.ask(request)? {
                LinkAnswer::Session(session) => {
                    self.caller.granted(session);
                    Ok(())
                }
                LinkAnswer::Refused(refusal) => Err(self.complaint(reason(refusal))),
                other => Err(self.odd(&other)),
            };
        }
    }

    /// Steers, in the session that was opened.
    ///
    /// # Errors
    /// As those of [`Client::tell`].
    pub fn steer(&mut self, act: LinkAct) -> Result<(), UserError> {
        let request = self.caller.steer(act);
        // Each attempt gets a number of its own.
        self.tell(request.map_err(|why| self.complaint(reason(why)))?)
    }

    /// Gives a command; a stop needs no session.
    ///
    /// # Errors
    /// As those of [`Client::tell`].
    pub fn command(&mut self, command: Command) -> Result<(), UserError> {
        match command {
            Command::Stop => self.tell(ToBoard::Command(Command::Stop)),
            _ => self.steer(LinkAct::Command(command)),
        }
    }

    /// What the controller is doing.
    ///
    /// # Errors
    /// As those of [`Client::ask`].
    pub fn status(&mut self) -> Result<Status, UserError> {
        match self.ask(ToBoard::GetStatus)? {
            LinkAnswer::Status(status) => Ok(status),
            other => Err(self.odd(&other)),
        }
    }

    /// The next streamed message; none if there is none within `patience`.
    ///
    /// # Errors
    /// If the port fails.
    pub fn streamed(&mut self, patience: Duration) -> Result<Option<FromBoard>, UserError> {
        if self.streamed.is_empty() {
            let until = Instant::now() + patience;
            while self.streamed.is_empty() && Instant::now() < until {
                self.listen()?;
            }
        }
        Ok(self.streamed.pop_front())
    }

    /// An error about this port.
    pub fn complaint(&self, text: impl Into<String>) -> UserError {
        UserError::new(text).at(&self.name)
    }

    /// The error of an answer of the wrong kind.
    pub fn odd(&self, answer: &LinkAnswer) -> UserError {
        self.complaint(format!(
            "the board gave an unexpected answer ({answer:?}); reset it and try again"
        ))
    }

    fn await_answer(&mut self, patience: Duration) -> Result<Option<LinkAnswer>, UserError> {
        let until = Instant::now() + patience;
        while Instant::now() < until {
            if let Some(answer) = self.listen()? {
                return Ok(Some(answer));
            }
        }
        Ok(None)
    }

    /// Reads once and returns the answer to the last request, if it came. Streamed messages are stored.
    fn listen(&mut self) -> Result<Option<LinkAnswer>, UserError> {
        let mut bytes = [0; 4096];
        let count = match self.port.read(&mut bytes) {
            Ok(count) => count,
            Err(e) if is_patience(&e) => return Ok(None),
            Err(e) => return Err(self.broken(&e)),
        };
        let mut found = None;
        for byte in &bytes[..count] {
            let Some(message) = self.caller.hear(*byte) else {
                continue;
            };
            match message {
                FromBoard::Answer { request, answer } if request == self.caller.sequence() => {
                    found = Some(answer);
                }
                // A late answer to a request that was given up.
                FromBoard::Answer { .. } => {}
                streamed => {
                    if self.streamed.len() >= KEPT {
                        self.streamed.pop_front();
                        self.caller.lose(1);
                    }
                    self.streamed.push_back(streamed);
                }
            }
        }
        Ok(found)
    }

    fn write(&mut self, bytes: &[u8]) -> Result<(), UserError> {
        let until = Instant::now() + PATIENCE;
        let mut left = bytes;
        while !left.is_empty() {
            match self.port.write(left) {
                Ok(0) => return Err(self.broken(&io::ErrorKind::WriteZero.into())),
                Ok(count) => left = &left[count..],
                Err(e) if is_patience(&e) && Instant::now() < until => {}
                Err(e) => return Err(self.broken(&e)),
            }
        }
        Ok(())
    }

    fn broken(&self, error: &io::Error) -> UserError {
        self.complaint(format!(
            "the connection broke: {error}; check the cable and try again"
        ))
    }
}

/// Whether a read or write only timed out.
pub(crate) fn is_patience(error: &io::Error) -> bool {
    matches!(
        error.kind(),
        ErrorKind::TimedOut | ErrorKind::WouldBlock | ErrorKind::Interrupted
    )
}

/// How long to wait for the answer to an act, and how often to send it.
fn patience_for(act: &LinkAct) -> (Duration, u32) {
    match act {
        LinkAct::SetSettings(_)
        | LinkAct::SetBrownOut
        | LinkAct::Command(Command::ConfirmSettings) => (PATIENCE_FOR_FLASH, ATTEMPTS),
        // Sent twice, the second would be refused though the first was obeyed.
        LinkAct::Command(Command::Start(_) | Command::ClearFault) | LinkAct::Release => {
            (PATIENCE * ATTEMPTS, 1)
        }
        _ => (PATIENCE, ATTEMPTS),
    }
}

fn reason(refusal: Refusal) -> &'static str {
    match refusal {
        Refusal::Controller(Refused::WrongState) => {
            "refused: not in this state; `host-sim link PORT status` shows the state"
        }
        Refusal::Controller(Refused::NotANumber) => "refused: a number in it is not finite",
        Refusal::Controller(Refused::NoMotion) => {
            "refused: a frequency is positive, and an amplitude is not negative"
        }
        Refusal::Controller(Refused::StillFaulty) => {
            "refused: the fault's cause is still there; remove it and clear again"
        }
        Refusal::Controller(Refused::BadSettings) => "refused: the settings are out of range",
        Refusal::Controller(Refused::ByHandOnly) => {
            "refused: drive.kind is motor, whose amplitude no limit can reduce; start it by hand"
        }
        Refusal::NotStored => {
            "the settings are in use but could not be stored in flash; send them again, they are lost at the next reset"
        }
        Refusal::Controller(Refused::SettingsUnknown(SettingsState::OlderCopy)) => {
            "refused: the newest settings are damaged and an older copy is in use; read it (`get`), then `confirm` it or send others (`set`)"
        }
        Refusal::Controller(Refused::SettingsUnknown(SettingsState::Damaged)) => {
            "refused: the stored settings are damaged; send those of this rig (`set`)"
        }
        Refusal::Controller(Refused::SettingsUnknown(_)) => {
            "refused: this board has no settings yet; send those of this rig (`set`)"
        }
        Refusal::Controller(Refused::NotAcknowledged) => {
            "refused: the emergency stop must be acknowledged at the board: close the chain, press the button, then clear"
        }
        Refusal::Controller(Refused::ChainNotTried) => {
            "refused: operator.acknowledge is set, so try the emergency stop before each start: press it, release it, press the board's button, then `clear-fault`"
        }
        Refusal::NotAvailable => "refused: this board cannot do that",
        Refusal::NoSession => {
            "refused: this program no longer steers; another has taken over, the board was reset, or this one was silent for too long"
        }
        Refusal::SomebodySteers => {
            "refused: another program steers; end it, or take over with --take-over (`stop` works nevertheless)"
        }
        Refusal::Old => "refused: the message is older than the last; try again",
        Refusal::AtTheBoard => "refused: only the board's button does this",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_slower_rate_is_tried_where_the_usual_one_has_no_answer() {
        let at = |baud, answers: u32| {
            let mut tried = Vec::new();
            let opened = at_a_rate(baud, |rate| {
                tried.push(rate);
                let answer = (rate == answers).then_some(rate);
                answer.ok_or_else(|| UserError::new(format!("no answer at {rate}")))
            });
            (opened.map_err(|why| why.to_string()), tried)
        };
        let [usual, slower] = RATES;
        assert_eq!(at(None, usual), (Ok(usual), vec![usual]));
        assert_eq!(at(None, slower), (Ok(slower), vec![usual, slower]));
        let silent = at(None, 0);
        assert_eq!(silent.1, [usual, slower]);
        assert!(silent.0.unwrap_err().contains(&usual.to_string()));
        // A rate that is asked for is the only one.
        assert_eq!(at(Some(slower), usual).1, [slower]);
    }
}
