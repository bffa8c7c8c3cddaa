//! Many pages, one board: who commands, whose answer is whose, and who gets which stream.
//!
//! To a page the hub looks like the board: the same frames, numbered for this page alone, so that a gap in the numbers is
//! what this page has not got. To the board it looks like one program: it numbers the requests of all pages anew and
//! gives each answer to the page that asked.
//!
//! A page that wants to steer takes the *seat*. While it has it, the hub lets its acts through; everybody else's are
//! refused here. A stop goes through from every page.

use std::sync::Arc;
use std::time::{Duration, Instant};

use shared::control::Command;
use shared::link::{Decoder, FromBoard, Hello, LinkAnswer, Packet, ToBoard};

use super::guest::Guest;
use super::mailbox::{Mailbox, Notice, PageMessage};
use super::requests::{Asker, Requests};
use super::rules::{self, PageAct};

/// The page that commands must be heard this often; after that the drive is stopped.
pub const SILENCE: Duration = Duration::from_secs(1);

/// A board that streams a hundred messages a second is silent after so long.
const BOARD_SILENCE: Duration = Duration::from_secs(2);

/// How often a stop is sent until the board answers it, and for how long.
const STOP_AGAIN: Duration = Duration::from_millis(100);
const STOP_FOR: Duration = Duration::from_secs(5);

/// Control ticks between two status messages: 100 a second.
const TELEMETRY_TICKS: u32 = 200;

/// A stream that is wanted and has not come for so long is asked for again: the board may have been reset.
const STREAM_AGAIN: Duration = Duration::from_secs(1);

/// The page that commands.
#[derive(Clone, Copy, Debug)]
struct Seat {
    page: u32,
    heard: Instant,
}

/// A stop that the board has not answered yet.
#[derive(Clone, Copy, Debug)]
struct Stop {
    since: Instant,
    sent: Instant,
}

/// One board shared by many pages, of which one at most commands.
#[derive(Debug)]
pub struct Hub {
    board: String,
    hello: Hello,
    guests: Vec<Guest>,
    seat: Option<Seat>,
    stop: Option<Stop>,
    /// The board was lost while a page commanded it.
    lost_in_command: bool,
    requests: Requests,
    decoder: Decoder,
    /// Number of the board's last packet, when it came, and whether none has come for long.
    heard: Option<u16>,
    heard_at: Instant,
    silent: bool,
    /// When each stream was last seen or asked for.
    telemetry_at: Option<Instant>,
    frames_at: Instant,
}

impl Hub {
    /// A hub at the port `board`, which has answered `hello`; requests are numbered after `sequence`.
    pub fn new(board: &str, hello: Hello, sequence: u16, now: Instant) -> Self {
        Self {
            board: board.to_owned(),
            hello,
            guests: Vec::new(),
            seat: None,
            stop: None,
            lost_in_command: false,
            requests: Requests::after(sequence),
            decoder: Decoder::new(),
            heard: None,
            heard_at: now,
            silent: false,
            telemetry_at: None,
            frames_at: now,
        }
    }

    /// The next frame for the board.
    pub fn next_out(&mut self) -> Option<Vec<u8>> {
        self.requests.next_out()
    }

    /// Whether a page commands.
    pub fn is_commanded(&self) -> bool {
        self.seat.is_some()
    }

    /// Whether a stop has not been answered yet.
    pub fn is_stopping(&self) -> bool {
        self.stop.is_some()
    }

    /// A page has come.
    pub fn join(&mut self, mailbox: Arc<Mailbox>) {
        let page = mailbox.page;
        let board = &self.board;
        mailbox.tell(&Notice::Welcome { page, board });
        let up = !self.silent;
        mailbox.tell(&Notice::Board { up, why: "" });
        self.guests.push(Guest::new(mailbox));
        self.tell_seat(&format!("page {page} has come"));
    }

    /// Takes in what the pages have sent, and lets those go that have gone.
    pub fn serve(&mut self, now: Instant) {
        let mut left = Vec::new();
        for at in 0..self.guests.len() {
            let mailbox = Arc::clone(&self.guests[at].mailbox);
            // Before its messages: what it sent before it went is still among them.
            let gone = mailbox.is_gone();
            for message in mailbox.received() {
                self.is_heard(mailbox.page, now);
                match message {
                    PageMessage::Wire(bytes) => self.bytes(at, &bytes, now),
                    PageMessage::Words(words) => self.words(at, &words, now),
                }
            }
            if gone {
                left.push(mailbox.page);
                self.leaves_seat(mailbox.page, "its page has gone", now);
            }
        }
        let recorded = self.records();
        self.guests.retain(|guest| !left.contains(&guest.page()));
        if !left.is_empty() {
            self.end_recording(recorded, now);
            self.tell_seat("a page has gone");
        }
    }

    /// What is due by the clock.
    pub fn tick(&mut self, now: Instant) {
        if let Some(seat) = self.seat
            && now.duration_since(seat.heard) > SILENCE
        {
            self.leaves_seat(seat.page, "its page was silent for a second", now);
        }
        self.stop_again(now);
        if !self.silent && now.duration_since(self.heard_at) > BOARD_SILENCE {
            self.silent = true;
            let why = "the board is silent; is it powered, and not held in a debugger?";
            self.tell_board(false, why);
        }
        self.requests.forget_late(now);
        let due = |last: Instant| now.duration_since(last) > STREAM_AGAIN;
        if self.telemetry_at.is_none_or(due) {
            self.telemetry_at = Some(now);
            let decimation = TELEMETRY_TICKS;
            self.requests
                .ask(ToBoard::StreamTelemetry { decimation }, Asker::Hub, now);
        }
        if self.records() && due(self.frames_at) {
            self.frames_at = now;
            self.requests
                .ask(ToBoard::StreamFrames { on: true }, Asker::Hub, now);
        }
    }

    /// Takes in bytes of the board.
    pub fn hear(&mut self, bytes: &[u8], now: Instant) {
        for byte in bytes {
            if let Some(packet) = self.decoder.push::<FromBoard>(*byte) {
                self.packet(packet, now);
            }
        }
    }

    /// Stops the drive; nothing that waits goes before it.
    pub fn stop_drive(&mut self, now: Instant) {
        self.requests.drop_unsent();
        self.stop = Some(Stop {
            since: now,
            sent: now,
        });
        self.requests
            .ask(ToBoard::Command(Command::Stop), Asker::Stop, now);
    }

    /// The board is not heard any more: nobody commands, and nothing is waited for.
    pub fn board_lost(&mut self, why: &str) {
        self.lost_in_command |= self.seat.take().is_some() || self.stop.take().is_some();
        self.requests.forget();
        self.tell_board(false, why);
        self.tell_seat("the board is not heard");
    }

    /// The board is heard again. If a page commanded it before, nobody does now, and it is stopped.
    pub fn board_back(&mut self, hello: Hello, now: Instant) {
        self.hello = hello;
        self.decoder = Decoder::new();
        (self.heard, self.heard_at, self.silent) = (None, now, false);
        self.telemetry_at = None;
        self.frames_at = now.checked_sub(2 * STREAM_AGAIN).unwrap_or(now);
        self.tell_board(true, "");
        if std::mem::take(&mut self.lost_in_command) {
            self.stop_drive(now);
        }
    }

    fn is_heard(&mut self, page: u32, now: Instant) {
        if let Some(seat) = &mut self.seat
            && seat.page == page
        {
            seat.heard = now;
        }
    }

    fn has_seat(&self, page: u32) -> bool {
        self.seat.is_some_and(|seat| seat.page == page)
    }

    fn words(&mut self, at: usize, words: &str, now: Instant) {
        let page = self.guests[at].page();
        let Ok(act) = serde_json::from_str::<PageAct>(words) else {
            return;
        };
        match (act, self.seat) {
            (PageAct::Here, _) => {}
            (PageAct::Leave, _) => self.leaves_seat(page, "it has left the command", now),
            (PageAct::Take | PageAct::TakeOver, None) => self.sits(page, "took the command", now),
            (PageAct::TakeOver, Some(seat)) if seat.page != page => {
                let why = format!("took the command from page {}", seat.page);
                self.sits(page, &why, now);
            }
            // The seat is taken, or is its own: it is told who has it.
            (PageAct::Take | PageAct::TakeOver, Some(_)) => self.tell_seat(""),
        }
    }

    fn sits(&mut self, page: u32, why: &str, now: Instant) {
        self.seat = Some(Seat { page, heard: now });
        self.tell_seat(&format!("page {page} {why}"));
    }

    /// Without the page that commands there is no drive.
    fn leaves_seat(&mut self, page: u32, why: &str, now: Instant) {
        if self.has_seat(page) {
            self.seat = None;
            self.stop_drive(now);
            self.tell_seat(&format!(
                "page {page} commands no longer, {why}: the drive is stopped"
            ));
        }
    }

    fn tell_board(&self, up: bool, why: &str) {
        for guest in &self.guests {
            guest.mailbox.tell(&Notice::Board { up, why });
        }
    }

    fn tell_seat(&self, why: &str) {
        let notice = Notice::Seat {
            commander: self.seat.map(|seat| seat.page),
            pages: self.guests.len(),
            why,
        };
        for guest in &self.guests {
            guest.mailbox.tell(&notice);
        }
    }

    fn bytes(&mut self, at: usize, bytes: &[u8], now: Instant) {
        for byte in bytes {
            if let Some(packet) = self.guests[at].decoder.push::<ToBoard>(*byte) {
                self.request(at, &packet, now);
            }
        }
    }

    /// A page's request: answered here, refused here, or passed on.
    fn request(&mut self, at: usize, packet: &Packet<ToBoard>, now: Instant) {
        let recorded = self.records();
        let page = self.guests[at].page();
        let commands = self.has_seat(page);
        let nobody = self.seat.is_none();
        let guest = &mut self.guests[at];
        let number = packet.sequence;
        let answer = match packet.message {
            ToBoard::Hello => {
                (guest.telemetry, guest.frames) = (false, false);
                Some(LinkAnswer::Hello(self.hello.clone()))
            }
            ToBoard::StreamTelemetry { decimation } => {
                guest.telemetry = decimation > 0;
                Some(LinkAnswer::Done)
            }
            ToBoard::StreamFrames { on } => {
                guest.frames = on;
                // The board's own answer says whether it can.
                (recorded || !on).then_some(LinkAnswer::Done)
            }
            ref other => rules::refusal(other, commands, nobody).map(LinkAnswer::Refused),
        };
        match answer {
            Some(answer) => guest.answer(number, answer),
            None => {
                if matches!(packet.message, ToBoard::StreamFrames { .. }) {
                    self.frames_at = now;
                }
                self.pass_on(page, packet, now);
            }
        }
        self.end_recording(recorded, now);
    }

    fn pass_on(&mut self, page: u32, packet: &Packet<ToBoard>, now: Instant) {
        let stops = packet.message == ToBoard::Command(Command::Stop);
        if stops || self.requests.has_room(page) {
            let asker = Asker::Page(page, packet.sequence);
            self.requests.ask(packet.message, asker, now);
        }
    }

    /// Whether a page records.
    fn records(&self) -> bool {
        self.guests.iter().any(|guest| guest.frames)
    }

    /// Ends the board's recording if the last page that `recorded` does so no longer.
    fn end_recording(&mut self, recorded: bool, now: Instant) {
        if recorded && !self.records() {
            self.requests
                .ask(ToBoard::StreamFrames { on: false }, Asker::Hub, now);
        }
    }

    fn stop_again(&mut self, now: Instant) {
        let Some(stop) = &mut self.stop else {
            return;
        };
        if now.duration_since(stop.since) > STOP_FOR {
            self.stop = None;
        } else if now.duration_since(stop.sent) > STOP_AGAIN {
            stop.sent = now;
            self.requests
                .ask(ToBoard::Command(Command::Stop), Asker::Stop, now);
        }
    }

    fn packet(&mut self, packet: Packet<FromBoard>, now: Instant) {
        // What the board has dropped, every page has lost. A larger step is a board that began to count anew.
        let gap = self.heard.map_or(0, |heard| {
            packet.sequence.wrapping_sub(heard).wrapping_sub(1)
        });
        if gap < 1 << 15 {
            for guest in &mut self.guests {
                guest.miss(gap);
            }
        }
        (self.heard, self.heard_at) = (Some(packet.sequence), now);
        if std::mem::take(&mut self.silent) {
            self.tell_board(true, "");
        }
        match packet.message {
            FromBoard::Answer { request, answer } => self.answered(request, answer),
            FromBoard::Telemetry(_) => {
                self.telemetry_at = Some(now);
                let wanting = self.guests.iter_mut().filter(|guest| guest.telemetry);
                wanting.for_each(|guest| guest.send(packet.message.clone()));
            }
            FromBoard::Recording(_) => {
                self.frames_at = now;
                let wanting = self.guests.iter_mut().filter(|guest| guest.frames);
                wanting.for_each(|guest| guest.send(packet.message.clone()));
            }
        }
    }

    fn answered(&mut self, request: u16, answer: LinkAnswer) {
        match self.requests.answered(request) {
            Some(Asker::Page(page, number)) => {
                let guest = self.guests.iter_mut().find(|g| g.page() == page);
                if let Some(guest) = guest {
                    guest.answer(number, answer);
                }
            }
            // Done, or refused in Fault, where it has stopped already.
            Some(Asker::Stop) => self.stop = None,
            Some(Asker::Hub) | None => {}
        }
    }
}
