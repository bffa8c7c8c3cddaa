//! The computer's end of the serial link: numbers requests, finds their answers, counts what was lost, and keeps the
//! session's numbers. It reads and writes nothing itself and knows no clock: the command line gives it a port's bytes, the
//! page in a browser those of a WebSocket or of Web Serial.

use shared::link::{Decoder, FromBoard, LinkAct, MAX_FRAME, Packet, Refusal, ToBoard, encode};

/// The computer's end of one conversation.
#[derive(Debug)]
pub struct Caller {
    decoder: Decoder,
    /// Number of the last request.
    sequence: u16,
    /// Number of the board's last packet.
    heard: Option<u16>,
    lost: u64,
    /// The session, once it is granted, and the number of the last act in it.
    session: Option<u32>,
    act: u32,
}

impl Caller {
    /// A conversation whose requests are numbered after `sequence`: any number but the one an earlier program used last, so that
    /// late answers to that one are not taken for this one's.
    pub fn new(sequence: u16) -> Self {
        Self {
            decoder: Decoder::new(),
            sequence,
            heard: None,
            lost: 0,
            session: None,
            act: 0,
        }
    }

    /// The number of the last request.
    pub fn sequence(&self) -> u16 {
        self.sequence
    }

    /// Packets of the board that did not arrive.
    pub fn lost(&self) -> u64 {
        self.lost
    }

    /// A new count of what is lost begins.
    pub fn count_anew(&mut self) {
        self.lost = 0;
    }

    /// More is lost, after it arrived.
    pub fn lose(&mut self, packets: u64) {
        self.lost += packets;
    }

    /// The frame of a request, under a new number. An act of a session gets a number of its own, each time it is sent.
    pub fn frame(&mut self, mut request: ToBoard) -> Option<Vec<u8>> {
        if let ToBoard::Steer { number, .. } = &mut request {
            self.act += 1;
            *number = self.act;
        }
        self.sequence = self.sequence.wrapping_add(1);
        let packet = Packet {
            sequence: self.sequence,
            message: request,
        };
        let mut frame = [0; MAX_FRAME];
        encode(&packet, &mut frame).map(<[u8]>::to_vec)
    }

    /// Takes a byte of the board; the message that it completes.
    pub fn hear(&mut self, byte: u8) -> Option<FromBoard> {
        let packet = self.decoder.push::<FromBoard>(byte)?;
        if let Some(last) = self.heard {
            self.lost += u64::from(packet.sequence.wrapping_sub(last).wrapping_sub(1));
        }
        self.heard = Some(packet.sequence);
        Some(packet.message)
    }

    /// The session was granted.
    pub fn granted(&mut self, session: u32) {
        (self.session, self.act) = (Some(session), 0);
    }

    /// The request for an act, in the session that was granted.
    ///
    /// # Errors
    /// There is none.
    pub fn steer(&self, act: LinkAct) -> Result<ToBoard, Refusal> {
        let session = self.session.ok_or(Refusal::NoSession)?;
        // Numbered when it is sent.
        Ok(ToBoard::Steer {
            session,
            number: 0,
            act,
        })
    }
}

#[cfg(test)]
mod tests {
    use shared::control::Command;
    use shared::link::LinkAnswer;

    use super::*;

    fn packet(sequence: u16, request: u16) -> Vec<u8> {
        let message = FromBoard::Answer {
            request,
            answer: LinkAnswer::Done,
        };
        let mut out = [0; MAX_FRAME];
        encode(&Packet { sequence, message }, &mut out)
            .expect("it fits")
            .to_vec()
    }

    #[test]
    fn what_is_missing_in_the_boards_numbers_is_counted() {
        let mut caller = Caller::new(0);
        let mut hear = |sequence| {
            let bytes = packet(sequence, 7);
            bytes
                .into_iter()
                .filter_map(|byte| caller.hear(byte))
                .count()
        };
        assert_eq!((hear(65_534), hear(65_535), hear(2), hear(3)), (1, 1, 1, 1));
        assert_eq!(caller.lost(), 2);
    }

    #[test]
    fn each_sending_of_an_act_has_a_number_of_its_own() {
        let mut caller = Caller::new(9);
        let alive = LinkAct::Command(Command::Alive);
        assert_eq!(caller.steer(alive), Err(Refusal::NoSession));
        caller.granted(5);
        let steer = caller.steer(alive).expect("a session");
        let mut numbers = Vec::new();
        for _ in 0..2 {
            let frame = caller.frame(steer).expect("it fits");
            let mut decoder = Decoder::new();
            let read = frame.iter().find_map(|b| decoder.push::<ToBoard>(*b));
            let read = read.expect("a packet");
            let ToBoard::Steer {
                session, number, ..
            } = read.message
            else {
                panic!("{read:?}");
            };
            numbers.push((read.sequence, session, number));
        }
        assert_eq!(numbers, [(10, 5, 1), (11, 5, 2)]);
        assert_eq!(caller.sequence(), 11);
    }
}
