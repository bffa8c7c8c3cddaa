//! A page as the hub sees it: its own count of packets, and the streams it wants.

use std::sync::Arc;

use shared::link::{Decoder, FromBoard, LinkAnswer, MAX_FRAME, Packet, encode};

use super::mailbox::Mailbox;

/// A page in the hub.
#[derive(Debug)]
pub struct Guest {
    /// What waits for it, and comes from it.
    pub mailbox: Arc<Mailbox>,
    /// Finds its requests in its bytes.
    pub decoder: Decoder,
    /// Number of the last packet for it.
    sequence: u16,
    /// It wants status messages.
    pub telemetry: bool,
    /// It wants every tick.
    pub frames: bool,
}

impl Guest {
    /// A page that wants nothing yet.
    pub fn new(mailbox: Arc<Mailbox>) -> Self {
        Self {
            mailbox,
            decoder: Decoder::new(),
            sequence: 0,
            telemetry: false,
            frames: false,
        }
    }

    /// Number of the page, from 1 in the order in which pages came.
    pub fn page(&self) -> u32 {
        self.mailbox.page
    }

    /// Packets that the board has meant to send are lost.
    pub fn miss(&mut self, packets: u16) {
        self.sequence = self.sequence.wrapping_add(packets);
    }

    /// A message of the board, under this page's count.
    pub fn send(&mut self, message: FromBoard) {
        let streamed = !matches!(message, FromBoard::Answer { .. });
        self.sequence = self.sequence.wrapping_add(1);
        let packet = Packet {
            sequence: self.sequence,
            message,
        };
        let mut frame = [0; MAX_FRAME];
        // Every message of the board fits.
        let Some(frame) = encode(&packet, &mut frame) else {
            return;
        };
        if streamed {
            self.mailbox.stream(frame);
        } else {
            self.mailbox.answer(frame);
        }
    }

    /// An answer to its request of this number.
    pub fn answer(&mut self, request: u16, answer: LinkAnswer) {
        self.send(FromBoard::Answer { request, answer });
    }
}
