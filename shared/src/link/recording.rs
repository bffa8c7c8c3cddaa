//! A block of control as it happened, and its compact form for the wire.

use heapless::Vec;
use serde::{Deserialize, Serialize};

use crate::control::{Command, MAX_BLOCK, Refused, State};
use crate::io::{AdcCode, DacCode, Frame, Output};

/// Commands recorded before a block at most; a board keeps a further one for the next block.
pub const MAX_GIVEN: usize = 2;

/// A command given before a block, and whether it was refused.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct GivenCommand {
    /// The command as it was given.
    pub command: Command,
    /// Why it was refused; `None`: it was carried out.
    pub refused: Option<Refused>,
}

/// The inputs of a block besides the frames, and the state after it: with frames and settings, all that a replay
/// needs.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct BlockNotes {
    /// Commands given before the block.
    pub given: Vec<GivenCommand, MAX_GIVEN>,
    /// The settings were replaced just before the block.
    pub restarted: bool,
    /// A finished forecast was handed to the controller before the block.
    pub forecast_delivered: bool,
    /// An overrun was reported to the controller.
    pub overrun: bool,
    /// The block's samples did not arrive and the controller ran without; its frames mean nothing.
    pub stale: bool,
    /// The state after the block.
    pub state: State,
}

/// A block of control as it happened.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RecordedBlock {
    /// Control tick of the first frame (wraps).
    pub tick: u32,
    /// Samples of the block, a frame per tick.
    pub frames: Vec<Frame, MAX_BLOCK>,
    /// The set-points, as many.
    pub outputs: Vec<Output, MAX_BLOCK>,
    /// The other inputs, and the state.
    pub notes: BlockNotes,
}

/// Bytes of a tick: three 12-bit ADC codes and a 12-bit DAC code.
const TICK_BYTES: usize = 6;

/// One bit of a mask per tick.
const _: () = assert!(MAX_BLOCK <= u32::BITS as usize);

/// An [`RecordedBlock`] for the wire: 12 bits per code, a bit per tick and switch, and frequency set-points as the
/// first and, if they are not all the same, the steps from each to the next. Nothing is lost but what an
/// f32 or a code of 12 bits cannot hold.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Recording {
    /// Control tick of the first frame (wraps).
    pub tick: u32,
    /// The inputs besides the frames, and the state after the block.
    pub notes: BlockNotes,
    /// Frequency set-point of the block's first tick, Hz.
    frequency_hz: f32,
    /// From each set-point to the next, as the difference of their bits: small in a slew. Empty: all the same.
    steps: Vec<i32, MAX_BLOCK>,
    /// Bit i: the emergency-stop chain was open in tick i.
    emergency: u32,
    /// Bit i: the drive was enabled by tick i's output.
    enable: u32,
    /// Six bytes per tick: force, hammer, cart, DAC.
    codes: Vec<u8, { MAX_BLOCK * TICK_BYTES }>,
}

impl Recording {
    /// Packs a block. Codes above 4095, which no converter gives, keep their low 12 bits.
    pub fn pack(block: &RecordedBlock) -> Self {
        let mut codes = Vec::new();
        let (mut emergency, mut enable) = (0, 0);
        let mut bit = 1_u32;
        for (frame, output) in block.frames.iter().zip(&block.outputs) {
            let [a, b, c] = pair(frame.force.0, frame.hammer.0);
            let [d, e, f] = pair(frame.cart.0, output.dac.0);
            // As large as the largest block.
            let _ = codes.extend_from_slice(&[a, b, c, d, e, f]);
            emergency |= if frame.emergency { bit } else { 0 };
            enable |= if output.enable { bit } else { 0 };
            bit <<= 1;
        }
        Self {
            tick: block.tick,
            notes: block.notes.clone(),
            frequency_hz: block.outputs.first().map_or(0.0, |o| o.frequency_hz),
            steps: steps(&block.outputs),
            emergency,
            enable,
            codes,
        }
    }

    /// The block. A last tick that is cut off is left out.
    pub fn unpack(&self) -> RecordedBlock {
        let mut block = RecordedBlock {
            tick: self.tick,
            notes: self.notes.clone(),
            ..RecordedBlock::default()
        };
        let mut bit = 1_u32;
        let mut frequency = self.frequency_hz.to_bits();
        let mut steps = self.steps.iter();
        for tick in self.codes.chunks_exact(TICK_BYTES) {
            let &[a, b, c, d, e, f] = tick else {
                break;
            };
            let [force, hammer] = unpair([a, b, c]);
            let [cart, dac] = unpair([d, e, f]);
            let frame = Frame {
                force: AdcCode(force),
                hammer: AdcCode(hammer),
                cart: AdcCode(cart),
                emergency: self.emergency & bit != 0,
            };
            let output = Output {
                dac: DacCode(dac),
                frequency_hz: f32::from_bits(frequency),
                enable: self.enable & bit != 0,
            };
            // As many as codes, and those are bounded.
            let _ = (block.frames.push(frame), block.outputs.push(output));
            bit <<= 1;
            frequency = frequency.wrapping_add_signed(steps.next().copied().unwrap_or(0));
        }
        block
    }
}

fn steps(outputs: &[Output]) -> Vec<i32, MAX_BLOCK> {
    let bits = |output: &Output| output.frequency_hz.to_bits();
    let pairs = outputs.iter().zip(outputs.iter().skip(1));
    let mut steps = Vec::new();
    for (a, b) in pairs {
        // One fewer than outputs, which fit. (Collecting would panic if it did not.)
        let _ = steps.push(bits(b).wrapping_sub(bits(a)) as i32);
    }
    if steps.iter().all(|step| *step == 0) {
        return Vec::new();
    }
    steps
}

/// Two 12-bit codes in three bytes, little-endian.
fn pair(low: u16, high: u16) -> [u8; 3] {
    let [a, b, c, _] = (u32::from(low & 0xfff) | u32::from(high & 0xfff) << 12).to_le_bytes();
    [a, b, c]
}

fn unpair([a, b, c]: [u8; 3]) -> [u16; 2] {
    let both = u32::from_le_bytes([a, b, c, 0]);
    [(both & 0xfff) as u16, (both >> 12) as u16]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::link::{FromBoard, MAX_FRAME, Packet, encode};
    use proptest::prelude::*;

    fn block(ticks: usize, seed: u32) -> RecordedBlock {
        let mut state = seed;
        let mut random = |below: u32| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 12) % below
        };
        let mut block = RecordedBlock {
            tick: random(u32::MAX),
            ..RecordedBlock::default()
        };
        for _ in 0..ticks {
            let mut code = || AdcCode(random(4096) as u16);
            let frame = Frame {
                force: code(),
                hammer: code(),
                cart: code(),
                emergency: random(2) == 1,
            };
            let output = Output {
                dac: DacCode(random(4096) as u16),
                frequency_hz: if seed.is_multiple_of(3) {
                    3.5
                } else {
                    f32::from_bits(random(255 << 23))
                },
                enable: random(2) == 1,
            };
            block.frames.push(frame).unwrap();
            block.outputs.push(output).unwrap();
        }
        block
    }

    proptest! {
        #[test]
        fn what_is_packed_is_unpacked(ticks in 0..=MAX_BLOCK, seed: u32, flags: [bool; 4]) {
            let mut block = block(ticks, seed);
            block.notes = BlockNotes {
                given: Vec::from_slice(&[GivenCommand { command: Command::Alive, refused: None }]).unwrap(),
                restarted: flags[0],
                forecast_delivered: flags[1],
                overrun: flags[2],
                stale: flags[3],
                state: State::Seek,
            };
            prop_assert_eq!(Recording::pack(&block).unpack(), block);
        }
    }

    #[test]
    fn a_recording_of_every_tick_fits_through_the_port() {
        // The worst numbers a packet can have, codes as they come; blocks of 10 ticks.
        let mut block = block(10, 7);
        block.tick = u32::MAX;
        let mut bytes = |slew_hz_per_tick: f32| {
            let mut frequency_hz = 3.66;
            for (frame, output) in block.frames.iter_mut().zip(&mut block.outputs) {
                (frame.emergency, output.enable) = (false, true);
                output.frequency_hz = frequency_hz;
                frequency_hz += slew_hz_per_tick;
            }
            let packet = Packet {
                sequence: u16::MAX,
                message: FromBoard::Recording(Recording::pack(&block)),
            };
            let mut out = [0; MAX_FRAME];
            encode(&packet, &mut out).unwrap().len() as u32
        };
        // A frequency that stays, and one that slews as fast as by default on the wires.
        assert_eq!((bytes(0.0), bytes(0.182 / 20_000.0)), (90, 99));
        // Ten bits on the wire per byte.
        let bits_per_s = |bytes: u32| bytes * 10 * crate::settings::TICK_RATE_HZ / 10;
        assert!(bits_per_s(99) < crate::link::BAUD);
    }
}
