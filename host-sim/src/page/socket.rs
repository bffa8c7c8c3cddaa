//! The WebSocket of a page: from its mailbox to the browser and back.

use std::io;
use std::net::TcpStream;
use std::time::{Duration, Instant};

use tungstenite::protocol::{Role, WebSocketConfig};
use tungstenite::{Error, Message, WebSocket};

use super::mailbox::{Mailbox, PageMessage};
use crate::link::client::is_patience;

/// How long a read or write of the connection may wait.
const TURN: Duration = Duration::from_millis(4);

/// Time between two messages to a page: what is sent is late by no more.
const PACE: Duration = Duration::from_millis(8);

/// Longest message from a page, bytes: some of the protocol's longest frames.
const MAX_MESSAGE: usize = 4 * 1024;

/// Messages that the browser has not taken yet, at most. Without a bound the system would take megabytes for a page that
/// does not read, and what that page then shows would be old.
const MAX_UNTAKEN: u64 = 4;

/// How often a browser is asked whether it is there, and how long it may not answer.
const PING: Duration = Duration::from_secs(3);
const PATIENCE: Duration = Duration::from_secs(30);

/// Serves the page until one of both ends it. The handshake is done.
pub fn serve(stream: TcpStream, mailbox: &Mailbox) {
    let _ = Socket::new(stream).and_then(|mut socket| socket.talk(mailbox));
    mailbox.leave();
}

struct Socket {
    socket: WebSocket<TcpStream>,
    /// When the page was last heard, and last sent something.
    heard: Instant,
    sent: Instant,
    /// Every message to the page has a ping behind it: how many were sent, and the last that was answered.
    pings: u64,
    answered: u64,
}

impl Socket {
    fn new(stream: TcpStream) -> Result<Self, Error> {
        stream.set_nodelay(true)?;
        stream.set_read_timeout(Some(TURN))?;
        stream.set_write_timeout(Some(TURN))?;
        let config = WebSocketConfig::default()
            .max_message_size(Some(MAX_MESSAGE))
            .max_frame_size(Some(MAX_MESSAGE));
        Ok(Self {
            socket: WebSocket::from_raw_socket(stream, Role::Server, Some(config)),
            heard: Instant::now(),
            sent: Instant::now(),
            pings: 0,
            answered: 0,
        })
    }

    fn talk(&mut self, mailbox: &Mailbox) -> Result<(), Error> {
        while !mailbox.is_dismissed() && self.heard.elapsed() < PATIENCE {
            self.listen(mailbox)?;
            // False: the connection takes nothing more for the moment.
            let flushed = patient(self.socket.flush())?.is_some();
            let room = self.pings - self.answered < MAX_UNTAKEN;
            if flushed && room && self.sent.elapsed() > PACE {
                self.send(mailbox)?;
            }
        }
        patient(self.socket.close(None))?;
        patient(self.socket.flush())?;
        Ok(())
    }

    fn listen(&mut self, mailbox: &Mailbox) -> Result<(), Error> {
        let Some(message) = patient(self.socket.read())? else {
            return Ok(());
        };
        self.heard = Instant::now();
        let room = match message {
            Message::Binary(bytes) => mailbox.receive(PageMessage::Wire(bytes.into())),
            Message::Text(text) => mailbox.receive(PageMessage::Words(text.as_str().to_owned())),
            Message::Pong(number) => {
                if let Ok(number) = number.as_ref().try_into() {
                    self.answered = u64::from_be_bytes(number).min(self.pings);
                }
                true
            }
            // Reading answers a ping, and a close.
            _ => true,
        };
        // A page that sends more than is read sends no more.
        if room {
            Ok(())
        } else {
            Err(Error::Io(io::ErrorKind::QuotaExceeded.into()))
        }
    }

    fn send(&mut self, mailbox: &Mailbox) -> Result<(), Error> {
        let message = match mailbox.take() {
            Some(PageMessage::Wire(bytes)) => Some(Message::Binary(bytes.into())),
            Some(PageMessage::Words(words)) => Some(Message::Text(words.into())),
            None if self.sent.elapsed() > PING => None,
            None => return Ok(()),
        };
        if let Some(message) = message {
            patient(self.socket.write(message))?;
        }
        self.sent = Instant::now();
        self.pings += 1;
        let number = self.pings.to_be_bytes().to_vec();
        patient(self.socket.write(Message::Ping(number.into())))?;
        patient(self.socket.flush())?;
        Ok(())
    }
}

/// None: the connection has nothing, or takes nothing more, for the moment.
fn patient<T>(done: Result<T, Error>) -> Result<Option<T>, Error> {
    match done {
        Ok(value) => Ok(Some(value)),
        Err(Error::Io(e)) if is_patience(&e) => Ok(None),
        Err(e) => Err(e),
    }
}
