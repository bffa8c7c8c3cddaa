//! The computer's side of the link: requests to a board, and the messages it streams.

use std::collections::VecDeque;
use std::io::{self, ErrorKind, Read, Write};
use std::time::{Duration, Instant, SystemTime};

use serialport::{ClearBuffer, SerialPort};
use shared::control::{Command, Refused, Status};
use shared::link::{
    Answer, Decoder, FromBoard, Hello, MAX_FRAME, PROTOCOL_VERSION, Packet, Refusal, ToBoard,
    encode,
};

use files::UserError;

/// How long an answer may take. The board answers within milliseconds; a computer's serial driver may not.
const PATIENCE: Duration = Duration::from_millis(700);

/// Settings are stored in flash before the answer: erasing takes up to 0.8 s on an STM32F446.
const PATIENCE_FOR_FLASH: Duration = Duration::from_secs(3);

/// How often a request is sent before the board counts as silent.
const ATTEMPTS: u32 = 3;

/// Longest time a read waits, so that [`PATIENCE`] is not exceeded.
const READ_WAIT: Duration = Duration::from_millis(5);

/// Streamed messages stored while waiting for an answer: a second of recording at 2000 blocks a second.
const KEPT: usize = 2000;

/// A conversation with a board over `P`, whose reads must not wait long (or at all).
#[derive(Debug)]
pub struct Client<P> {
    port: P,
    name: String,
    decoder: Decoder,
    sequence: u16,
    streamed: VecDeque<FromBoard>,
    last_heard: Option<u16>,
    lost: u64,
}

/// Opens the serial port (or pseudo-terminal) `name` and makes sure that a board of our protocol answers.
///
/// # Errors
/// If the port does not exist or is in use, or no board of this protocol answers.
pub fn open(name: &str, baud: u32) -> Result<(Client<Box<dyn SerialPort>>, Hello), UserError> {
    let port = serialport::new(name, baud).timeout(READ_WAIT).open();
    let port =
        port.map_err(|e| UserError::new(format!("cannot open {name}: {e}; {}", mend(&e))))?;
    // Leftovers of an earlier conversation.
    let _ = port.clear(ClearBuffer::Input);
    let mut client = Client::new(port, name);
    let hello = client.hello()?;
    Ok((client, hello))
}

fn mend(error: &serialport::Error) -> String {
    let busy = "another program uses it; close that and try again";
    match error.kind() {
        // What the lock's failure comes as.
        serialport::ErrorKind::NoDevice if error.description.contains("lock") => busy.to_owned(),
        serialport::ErrorKind::Io(ErrorKind::ResourceBusy) => busy.to_owned(),
        serialport::ErrorKind::NoDevice | serialport::ErrorKind::Io(ErrorKind::NotFound) => {
            ports_here()
        }
        serialport::ErrorKind::Io(ErrorKind::PermissionDenied) => {
            "you may not use it: join its group (often dialout) and log in anew".to_owned()
        }
        _ => format!("it is not a serial port; {}", ports_here()),
    }
}

fn ports_here() -> String {
    let ports = serialport::available_ports().unwrap_or_default();
    let names: Vec<_> = ports.into_iter().map(|port| port.port_name).collect();
    if names.is_empty() {
        "this computer has none now: plug the board in".to_owned()
    } else {
        format!("ports here: {}", names.join(", "))
    }
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
            decoder: Decoder::new(),
            sequence,
            streamed: VecDeque::new(),
            last_heard: None,
            lost: 0,
        }
    }

    /// The port's name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Packets of the board that did not arrive.
    pub fn lost(&self) -> u64 {
        self.lost
    }

    /// Asks for name and protocol of the board. This also ends every stream.
    ///
    /// # Errors
    /// If the board does not answer, or has another protocol.
    pub fn hello(&mut self) -> Result<Hello, UserError> {
        // Ends whatever half frame the board may be in.
        self.write(&[0])?;
        let hello = match self.ask(ToBoard::Hello)? {
            Answer::Hello(hello) => hello,
            other => return Err(self.odd(&other)),
        };
        if hello.protocol != PROTOCOL_VERSION {
            return Err(self.complaint(format!(
                "the board speaks protocol {} and this program {PROTOCOL_VERSION}; use the host-sim of its firmware ({}), or flash the firmware of this one",
                hello.protocol, hello.firmware
            )));
        }
        self.streamed.clear();
        self.lost = 0;
        Ok(hello)
    }

    /// Sends a request and waits for its answer; messages streamed meanwhile are stored. Without an answer, a request
    /// that does no harm when it comes twice is sent again.
    ///
    /// # Errors
    /// If the port fails, or the board does not answer.
    pub fn ask(&mut self, request: ToBoard) -> Result<Answer, UserError> {
        let patience = match request {
            ToBoard::SetSettings(_) => PATIENCE_FOR_FLASH,
            _ => PATIENCE,
        };
        let once = matches!(
            request,
            ToBoard::Command(Command::Start(_) | Command::ClearFault)
        );
        let attempts = if once { 1 } else { ATTEMPTS };
        for _ in 0..attempts {
            self.sequence = self.sequence.wrapping_add(1);
            let packet = Packet {
                sequence: self.sequence,
                message: request,
            };
            let mut frame = [0; MAX_FRAME];
            let frame = encode(&packet, &mut frame).ok_or_else(|| self.complaint("too long"))?;
            self.write(frame)?;
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
            Answer::Done => Ok(()),
            Answer::Refused(refusal) => Err(self.complaint(reason(refusal))),
            other => Err(self.odd(&other)),
        }
    }

    /// What the controller is doing.
    ///
    /// # Errors
    /// As those of [`Client::ask`].
    pub fn status(&mut self) -> Result<Status, UserError> {
        match self.ask(ToBoard::GetStatus)? {
            Answer::Status(status) => Ok(status),
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
    pub fn odd(&self, answer: &Answer) -> UserError {
        self.complaint(format!(
            "the board answered something else ({answer:?}); reset it and try again"
        ))
    }

    fn await_answer(&mut self, patience: Duration) -> Result<Option<Answer>, UserError> {
        let until = Instant::now() + patience;
        while Instant::now() < until {
            if let Some(answer) = self.listen()? {
                return Ok(Some(answer));
            }
        }
        Ok(None)
    }

    /// Reads once and returns the answer to the last request, if it came. Streamed messages are stored.
    fn listen(&mut self) -> Result<Option<Answer>, UserError> {
        let mut bytes = [0; 4096];
        let count = match self.port.read(&mut bytes) {
            Ok(count) => count,
            Err(e) if is_patience(&e) => return Ok(None),
            Err(e) => return Err(self.broken(&e)),
        };
        let mut found = None;
        for byte in &bytes[..count] {
            let Some(packet) = self.decoder.push::<FromBoard>(*byte) else {
                continue;
            };
            if let Some(last) = self.last_heard {
                self.lost += u64::from(packet.sequence.wrapping_sub(last).wrapping_sub(1));
            }
            self.last_heard = Some(packet.sequence);
            match packet.message {
                FromBoard::Answer { request, answer } if request == self.sequence => {
                    found = Some(answer);
                }
                // A late answer to a request that was given up.
                FromBoard::Answer { .. } => {}
                streamed => {
                    if self.streamed.len() >= KEPT {
                        self.streamed.pop_front();
                        self.lost += 1;
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
pub(super) fn is_patience(error: &io::Error) -> bool {
    matches!(
        error.kind(),
        ErrorKind::TimedOut | ErrorKind::WouldBlock | ErrorKind::Interrupted
    )
}

fn reason(refusal: Refusal) -> &'static str {
    match refusal {
        Refusal::Controller(Refused::WrongState) => {
            "refused: not in this state; `host-sim link PORT status` shows the state"
        }
        Refusal::Controller(Refused::NotANumber) => "refused: a number in it is not finite",
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
        Refusal::NotAvailable => "refused: this board cannot do that",
    }
}
