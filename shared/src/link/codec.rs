//! Messages to frames and back: postcard, CRC-32, COBS.

use cobs::{DecodeResult, DecoderState, EncoderState, PushResult};
use crc::Digest;
use postcard::ser_flavors::Flavor;
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::{MAX_PACKET, Packet};
use crate::crc_32::CRC_32;

const CRC_BYTES: usize = 4;

/// Writes a packet as one frame, with its final 0, into `out` and returns it. `None` if it does not fit
/// ([`super::MAX_FRAME`] bytes hold every message).
pub fn encode<'a, M: Serialize>(packet: &Packet<M>, out: &'a mut [u8]) -> Option<&'a [u8]> {
    let framing = Framing::new(out)?;
    let length = postcard::serialize_with_flavor(packet, framing).ok()?;
    out.get(..length)
}

/// Takes postcard's bytes one at a time, through the CRC and COBS, into a slice.
struct Framing<'a> {
    out: &'a mut [u8],
    length: usize,
    stuffing: EncoderState,
    digest: Digest<'static, u32>,
}

impl<'a> Framing<'a> {
    fn new(out: &'a mut [u8]) -> Option<Self> {
        // COBS fills in its first byte later.
        *out.first_mut()? = 0;
        Some(Self {
            out,
            length: 1,
            stuffing: EncoderState::default(),
            digest: CRC_32.digest(),
        })
    }

    fn put(&mut self, at: usize, byte: u8) -> postcard::Result<()> {
        let place = self.out.get_mut(at);
        *place.ok_or(postcard::Error::SerializeBufferFull)? = byte;
        Ok(())
    }

    fn append(&mut self, byte: u8) -> postcard::Result<()> {
        self.put(self.length, byte)?;
        self.length = self.length.saturating_add(1);
        Ok(())
    }

    fn stuff(&mut self, byte: u8) -> postcard::Result<()> {
        match self.stuffing.push(byte) {
            PushResult::AddSingle(byte) => self.append(byte),
            PushResult::ModifyFromStartAndSkip((at, code)) => {
                self.put(at, code)?;
                self.append(0)
            }
            PushResult::ModifyFromStartAndPushAndSkip((at, code, byte)) => {
                self.put(at, code)?;
                self.append(byte)?;
                self.append(0)
            }
        }
    }
}

impl Flavor for Framing<'_> {
    type Output = usize;

    fn try_push(&mut self, byte: u8) -> postcard::Result<()> {
        self.digest.update(&[byte]);
        self.stuff(byte)
    }

    fn finalize(mut self) -> postcard::Result<usize> {
        let check = self.digest.clone().finalize();
        for byte in check.to_le_bytes() {
            self.stuff(byte)?;
        }
        let (at, code) = self.stuffing.clone().finalize();
        self.put(at, code)?;
        self.append(0)?;
        Ok(self.length)
    }
}

/// Counts of received frames. They saturate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counters {
    /// Frames that gave a message.
    pub good: u32,
    /// Frames with a good CRC and an unknown message: from a peer of another version.
    pub unknown: u32,
    /// Frames longer than any message.
    pub oversized: u32,
    /// Frames whose COBS or CRC is wrong, or too short to have one.
    pub damaged: u32,
}

impl Counters {
    /// Every frame that was dropped.
    pub fn dropped(&self) -> u32 {
        let some = self.unknown.saturating_add(self.oversized);
        some.saturating_add(self.damaged)
    }
}

/// Finds frames in a stream of bytes, in bounded space and time per byte (at a frame's end: per frame).
#[derive(Debug)]
pub struct Decoder {
    stuffing: DecoderState,
    /// Packet and CRC, without COBS.
    bytes: heapless::Vec<u8, { MAX_PACKET + CRC_BYTES }>,
    overflown: bool,
    /// Whether anything came since the last 0.
    begun: bool,
    counters: Counters,
}

impl Default for Decoder {
    fn default() -> Self {
        Self::new()
    }
}

impl Decoder {
    /// A decoder between frames.
    pub const fn new() -> Self {
        Self {
            stuffing: DecoderState::Idle,
            bytes: heapless::Vec::new(),
            overflown: false,
            begun: false,
            counters: Counters {
                good: 0,
                unknown: 0,
                oversized: 0,
                damaged: 0,
            },
        }
    }

    /// Counts of the frames received so far.
    pub fn counters(&self) -> Counters {
        self.counters
    }

    /// Takes one byte; gives the packet that it completes. Zeros between frames are ignored.
    pub fn push<M: DeserializeOwned>(&mut self, byte: u8) -> Option<Packet<M>> {
        if byte != 0 {
            self.begun = true;
            if let Ok(DecodeResult::DataContinue(byte)) = self.stuffing.feed(byte) {
                self.overflown |= self.bytes.push(byte).is_err();
            }
            return None;
        }
        let whole = matches!(self.stuffing.feed(0), Ok(DecodeResult::DataComplete));
        let packet = self.begun.then(|| self.finish(whole)).flatten();
        self.stuffing = DecoderState::Idle;
        self.bytes.clear();
        self.overflown = false;
        self.begun = false;
        packet
    }

    fn finish<M: DeserializeOwned>(&mut self, whole: bool) -> Option<Packet<M>> {
        let counters = &mut self.counters;
        let count = |counter: &mut u32| *counter = counter.saturating_add(1);
        if self.overflown {
            count(&mut counters.oversized);
            return None;
        }
        let Some(packet) = checked(&self.bytes).filter(|_| whole) else {
            count(&mut counters.damaged);
            return None;
        };
        match postcard::take_from_bytes::<Packet<M>>(packet) {
            Ok((packet, [])) => {
                count(&mut counters.good);
                Some(packet)
            }
            _ => {
                count(&mut counters.unknown);
                None
            }
        }
    }
}

/// The bytes before the CRC, if the CRC is right.
fn checked(bytes: &[u8]) -> Option<&[u8]> {
    let (packet, check) = bytes.split_last_chunk::<CRC_BYTES>()?;
    (CRC_32.checksum(packet) == u32::from_le_bytes(*check)).then_some(packet)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::Command;
    use crate::link::{MAX_FRAME, ToBoard};
    use std::vec::Vec;

    fn frame<M: Serialize>(sequence: u16, message: M) -> Vec<u8> {
        let mut out = [0; MAX_FRAME];
        let packet = Packet { sequence, message };
        encode(&packet, &mut out).unwrap().to_vec()
    }

    fn decode(decoder: &mut Decoder, bytes: &[u8]) -> Vec<Packet<ToBoard>> {
        bytes.iter().filter_map(|b| decoder.push(*b)).collect()
    }

    #[test]
    fn the_first_message_keeps_its_bytes_for_ever() {
        // By hand: postcard writes sequence 5 and message 0; zlib's CRC-32 of that; COBS codes at 0 and at
        // the zero.
        let [a, b, c, d] = [0xba, 0xe6, 0xae, 0x3c];
        assert_eq!(frame(5, ToBoard::Hello), [2, 5, 5, a, b, c, d, 0]);
        // The published check value of CRC-32/ISO-HDLC.
        assert_eq!(CRC_32.checksum(b"123456789"), 0xcbf4_3926);
    }

    #[test]
    fn a_reader_finds_its_place_at_the_next_zero() {
        let stop = frame(1, ToBoard::Command(Command::Stop));
        let mut decoder = Decoder::new();
        let mut stream = stop[2..].to_vec();
        stream.extend([0, 0]);
        stream.extend(&stop);
        assert_eq!(decode(&mut decoder, &stream).len(), 1);
        let expected = Counters {
            good: 1,
            damaged: 1,
            ..Counters::default()
        };
        assert_eq!(decoder.counters(), expected);
    }

    #[test]
    fn every_flipped_bit_and_every_cut_is_found() {
        let point = Command::SetPoint {
            frequency_hz: 3.66,
            amplitude_m: 0.89e-3,
        };
        let good = frame(700, ToBoard::Command(point));
        for bit in 0..8 * good.len() {
            let mut bad = good.clone();
            bad[bit / 8] ^= 1 << (bit % 8);
            let mut decoder = Decoder::new();
            assert!(decode(&mut decoder, &bad).is_empty(), "bit {bit}");
            assert_eq!(decoder.counters().good, 0);
            // A flip in the last byte swallows the frame's end: it takes the next frame with it, no more.
            decode(&mut decoder, &good);
            assert_eq!(decode(&mut decoder, &good).len(), 1, "bit {bit}");
        }
        for length in 0..good.len() - 1 {
            let mut cut = good[..length].to_vec();
            cut.push(0);
            assert!(decode(&mut Decoder::new(), &cut).is_empty(), "{length}");
        }
    }

    #[test]
    fn too_long_and_unknown_frames_are_counted_apart() {
        let mut decoder = Decoder::new();
        let mut endless = std::vec![1; 5000];
        endless.push(0);
        assert!(decode(&mut decoder, &endless).is_empty());
        assert_eq!(decoder.counters().oversized, 1);
        // A message of a later version, and one that goes on after its end.
        assert!(decode(&mut decoder, &frame(1, 200_u8)).is_empty());
        assert!(decode(&mut decoder, &frame(1, (ToBoard::Hello, 7_u8))).is_empty());
        assert_eq!(decoder.counters().unknown, 2);
        assert_eq!(decode(&mut decoder, &frame(1, ToBoard::Hello)).len(), 1);
        assert_eq!(decoder.counters().dropped(), 3);
    }

    #[test]
    fn runs_around_254_bytes_survive_the_stuffing() {
        for length in 240..=300_usize {
            let filled: heapless::Vec<u8, 300> = (0..length).map(|_| 0xa5).collect();
            let bytes = frame(9, &filled);
            assert_eq!(bytes.iter().filter(|b| **b == 0).count(), 1);
            let mut decoder = Decoder::new();
            let mut packets = bytes.iter().filter_map(|b| decoder.push(*b));
            let packet: Packet<heapless::Vec<u8, 300>> = packets.next().unwrap();
            assert_eq!((packet.sequence, packet.message), (9, filled));
        }
    }

    #[test]
    fn what_does_not_fit_is_not_written() {
        let packet = Packet {
            sequence: 1,
            message: ToBoard::Hello,
        };
        for length in 0..8 {
            assert!(encode(&packet, &mut [0; 8][..length]).is_none());
        }
        assert!(encode(&packet, &mut [0; 8]).is_some());
    }
}
