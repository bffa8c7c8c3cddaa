//! Requests to the board: numbered, and who asked remembered until the answer comes.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

use shared::link::{MAX_FRAME, Packet, ToBoard, encode};

/// Requests of one page that wait for their answer at most, and how long one is waited for.
const MAX_ASKED: usize = 32;
const ANSWER_WITHIN: Duration = Duration::from_secs(5);

/// Frames that wait for the board's port at most; then a page's requests are dropped, and it asks again.
const MAX_OUT: usize = 64;

/// Who asked the board, and so gets its answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Asker {
    /// A page, under its own number for the request.
    Page(u32, u16),
    /// The hub wants to know whether its stop was heard.
    Stop,
    /// The hub, which does not look at the answer.
    Hub,
}

#[derive(Clone, Copy, Debug)]
struct Asked {
    sequence: u16,
    asker: Asker,
    at: Instant,
}

/// What was asked, and what waits to be sent.
#[derive(Debug, Default)]
pub struct Requests {
    /// Number of the last one.
    sequence: u16,
    asked: VecDeque<Asked>,
    out: VecDeque<Vec<u8>>,
}

impl Requests {
    /// No request yet; the first is numbered after `sequence`.
    pub fn after(sequence: u16) -> Self {
        Self {
            sequence,
            ..Self::default()
        }
    }

    /// Queues a message for the board, and remembers who asked it.
    pub fn ask(&mut self, message: ToBoard, asker: Asker, now: Instant) {
        self.sequence = self.sequence.wrapping_add(1);
        let packet = Packet {
            sequence: self.sequence,
            message,
        };
        let mut frame = [0; MAX_FRAME];
        if let Some(frame) = encode(&packet, &mut frame) {
            self.out.push_back(frame.to_vec());
            self.asked.push_back(Asked {
                sequence: self.sequence,
                asker,
                at: now,
            });
        }
    }

    /// Whether a page may ask now: it does not wait for too much, and the port takes what it is given.
    pub fn has_room(&self, page: u32) -> bool {
        let of_page = |asked: &&Asked| matches!(asked.asker, Asker::Page(p, _) if p == page);
        self.out.len() < MAX_OUT && self.asked.iter().filter(of_page).count() < MAX_ASKED
    }

    /// The next frame for the board.
    pub fn next_out(&mut self) -> Option<Vec<u8>> {
        self.out.pop_front()
    }

    /// Nothing that waits is sent.
    pub fn drop_unsent(&mut self) {
        self.out.clear();
    }

    /// Nothing is sent, and no answer is waited for.
    pub fn forget(&mut self) {
        self.out.clear();
        self.asked.clear();
    }

    /// Answers that are late will not come.
    pub fn forget_late(&mut self, now: Instant) {
        self.asked
            .retain(|asked| now.duration_since(asked.at) < ANSWER_WITHIN);
    }

    /// Who asked what is now answered.
    pub fn answered(&mut self, sequence: u16) -> Option<Asker> {
        let at = self.asked.iter().position(|a| a.sequence == sequence)?;
        // The board answers in order: what was asked before is lost.
        self.asked.drain(..=at).next_back().map(|a| a.asker)
    }
}
