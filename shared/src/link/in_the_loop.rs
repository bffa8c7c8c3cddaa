//! The messages of the processor in the loop. Plant and controller wait for each other: the desktop on one side, the firmware's
//! image under QEMU on the other.
//!
//! On the wire a message is its length (two bytes, little-endian) and its postcard encoding. There is no check:
//! what carries it (a pipe) loses nothing. A reply holds everything visible of the controller, so that two
//! runs are the same if the bytes of their replies are, instruction counts apart.

use heapless::Vec;
use serde::{Deserialize, Serialize, de::DeserializeOwned};

use crate::control::{BootInfo, Command, Event, MAX_BLOCK, Refused, Status};
use crate::io::{Frame, Output};
use crate::settings::Settings;

/// Longest message, bytes, without its length.
pub const MAX_MESSAGE: usize = 1024;
/// Bytes of the length.
pub const LENGTH: usize = 2;
/// Events in a reply at most; more are given with the next.
pub const MAX_EVENTS: usize = 4;

/// A request of the plant.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[allow(
    clippy::large_enum_variant,
    reason = "there is no heap, and one lives at a time"
)]
pub enum ExchangeRequest {
    /// Makes a new controller.
    Begin {
        /// Settings of the new controller.
        settings: Settings,
        /// Why and with what it starts.
        boot: BootInfo,
    },
    /// A block, then slices of the forecast.
    Block {
        /// The samples; for a blind block as many frames, which are ignored.
        frames: Vec<Frame, MAX_BLOCK>,
        /// The samples did not arrive.
        blind: bool,
        /// Slices of the forecast after it.
        slices: u16,
    },
    /// A command, carried out before the next block.
    Command(Command),
    /// The control task ended too late.
    Overrun,
    /// The run is over.
    End,
}

/// An answer of the controller.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[allow(
    clippy::large_enum_variant,
    reason = "there is no heap, and one lives at a time"
)]
pub enum ExchangeReply {
    /// Whether the settings were taken.
    Begun(bool),
    /// A block was done.
    Block {
        /// Set-points, as many as there were frames.
        outputs: Vec<Output, MAX_BLOCK>,
        /// The state after the block and the slices.
        status: Status,
        /// The events, oldest first.
        events: Vec<Event, MAX_EVENTS>,
        /// Whether a forecast was delivered before the block.
        delivered: bool,
        /// Instructions of the block at control priority; 0 where they are not counted.
        instructions: u32,
    },
    /// Whether a command was carried out.
    Command(Result<(), Refused>),
    /// The request was noted.
    Noted,
}

/// Writes a message with its length into `out`; `None` if it does not fit.
pub fn encode<'a, M: Serialize>(message: &M, out: &'a mut [u8]) -> Option<&'a [u8]> {
    let (head, rest) = out.split_at_mut_checked(LENGTH)?;
    let length = postcard::to_slice(message, rest).ok()?.len();
    for (place, byte) in head
        .iter_mut()
        .zip(u16::try_from(length).ok()?.to_le_bytes())
    {
        *place = byte;
    }
    out.get(..LENGTH + length)
}

/// The length in the first two bytes of a message; `None` if above [`MAX_MESSAGE`].
pub fn length(head: [u8; LENGTH]) -> Option<usize> {
    let length = usize::from(u16::from_le_bytes(head));
    (length <= MAX_MESSAGE).then_some(length)
}

/// The message in `bytes` (without its length); `None` if malformed.
pub fn decode<M: DeserializeOwned>(bytes: &[u8]) -> Option<M> {
    postcard::from_bytes(bytes).ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::State;
    use crate::fault::{Fault, FaultRecord, Origin};
    use crate::io::{AdcCode, DacCode};
    use crate::model::cart::{ASSUMED_SHAKER, CartDrive};
    use crate::model::params::{PRESETS, RigParams};
    use crate::model::regime::Regime;

    fn there_and_back<M: Serialize + DeserializeOwned + PartialEq + core::fmt::Debug>(
        message: &M,
    ) -> usize {
        let mut buffer = [0; LENGTH + MAX_MESSAGE];
        let bytes = encode(message, &mut buffer).unwrap();
        let (head, body) = bytes.split_at(LENGTH);
        assert_eq!(length(head.try_into().unwrap()), Some(body.len()));
        assert_eq!(decode::<M>(body).as_ref(), Some(message));
        body.len()
    }

    #[test]
    fn the_longest_messages_fit() {
        for (_, rig) in PRESETS {
            there_and_back(&ExchangeRequest::Begin {
                settings: Settings::for_rig(&RigParams {
                    cart: CartDrive::Loop(ASSUMED_SHAKER),
                    ..rig
                }),
                boot: BootInfo::STORED,
            });
        }
        let frame = Frame {
            force: AdcCode(4095),
            hammer: AdcCode(4095),
            cart: AdcCode(4095),
            emergency: true,
        };
        let block = ExchangeRequest::Block {
            frames: core::iter::repeat_n(frame, MAX_BLOCK).collect(),
            blind: true,
            slices: u16::MAX,
        };
        assert!(there_and_back(&block) < MAX_MESSAGE / 2);
        let output = Output {
            dac: DacCode(4095),
            frequency_hz: 3.3,
            enable: true,
        };
        let record = FaultRecord::new(Fault::OverForce, Origin::Force, u32::MAX, 1.0, 1.0);
        let event = Event {
            tick: u32::MAX,
            kind: crate::control::EventKind::Fault(record),
        };
        let reply = ExchangeReply::Block {
            outputs: core::iter::repeat_n(output, MAX_BLOCK).collect(),
            status: Status {
                tick: u32::MAX,
                state: State::Hold,
                fault: Some(record),
                limits: crate::control::ActiveLimits::ALL,
                frequency_hz: 1.0,
                amplitude_m: 1.0,
                measured_amplitude_m: 1.0,
                lag_rad: 1.0,
                regime: Regime::None,
                peak_n: 1.0,
                impulse_n_s: 1.0,
                target_hz: 1.0,
                target_n: 1.0,
                basin: crate::control::Basin::Impact,
                reseeks: u16::MAX,
                overruns: u32::MAX,
                events_dropped: u16::MAX,
            },
            events: core::iter::repeat_n(event, MAX_EVENTS).collect(),
            delivered: true,
            instructions: u32::MAX,
        };
        assert!(there_and_back(&reply) < MAX_MESSAGE - 100);
    }

    #[test]
    fn rubbish_is_no_message() {
        assert_eq!(length([0xff, 0xff]), None);
        assert_eq!(decode::<ExchangeRequest>(&[0xff; 40]), None);
        assert_eq!(encode(&ExchangeReply::Noted, &mut [0; 1]), None);
    }
}
