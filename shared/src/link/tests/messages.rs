//! Every message fits, and the first answer can be read by every version.

use super::*;
use crate::model::cart::{ASSUMED_SHAKER, CartDrive};

#[test]
fn the_first_answer_keeps_its_bytes_for_ever() {
    // What a board of any version sends first: sequence 7, kind 0 (an answer), to request 5, answer 0 (hello),
    // and the version before all else. A computer of any version can read that far.
    let name = |text| LinkName::try_from(text).unwrap();
    let packet = |protocol| Packet {
        sequence: 7,
        message: FromBoard::Answer {
            request: 5,
            answer: LinkAnswer::Hello(Hello {
                protocol,
                firmware: name("a"),
                board: name("b"),
                tick_rate_hz: 20_000,
                block_ticks: 10,
            }),
        },
    };
    let mut buffer = [0; MAX_PACKET];
    for version in [1, PROTOCOL_VERSION] {
        let bytes = postcard::to_slice(&packet(version), &mut buffer).unwrap();
        let rest = [1, b'a', 1, b'b', 0xa0, 0x9c, 0x01, 10];
        assert_eq!(bytes[..5], [7, 0, 5, 0, version as u8]);
        assert_eq!(bytes[5..], rest);
    }
}

fn longest_answers() -> Vec<LinkAnswer> {
    let name = || LinkName::try_from("01234567890123456789012").unwrap();
    let mut answers = std::vec![
        LinkAnswer::Hello(Hello {
            protocol: u16::MAX,
            firmware: name(),
            board: name(),
            tick_rate_hz: LONG,
            block_ticks: u8::MAX,
        }),
        LinkAnswer::Refused(Refusal::Controller(Refused::SettingsUnknown(
            SettingsState::Model
        ))),
        LinkAnswer::Session(LONG),
        LinkAnswer::Board(BoardState {
            boot: LONG,
            granted: LONG,
            held: true,
            settings: SettingsState::Model,
            awaits_acknowledgement: true,
        }),
        LinkAnswer::Status(longest_status()),
        LinkAnswer::Forecast(ForecastPage::of(Some(&forecast(40)), 5)),
        LinkAnswer::FaultRecord(Some(longest_record())),
        LinkAnswer::Identified(Identified {
            stiffness_n_per_m: Some(1.0),
            damping_n_s_per_m: Some(1.0),
            natural_frequency_hz: Some(1.0),
            gap_m: Some(1.0),
            contacts: LONG,
            refused: LONG,
        }),
    ];
    for (_, rig) in PRESETS {
        for (_, contact) in LAWS {
            let mut rig = crate::model::params::RigParams {
                contact,
                cart: CartDrive::Loop(ASSUMED_SHAKER),
                ..rig
            };
            if let crate::model::params::SupportParams::Beams {
                cubic_stiffness_n_per_m3,
                ..
            } = &mut rig.support
            {
                *cubic_stiffness_n_per_m3 = Some(1.0);
            }
            answers.push(LinkAnswer::Settings(Settings::for_rig(&rig)));
        }
    }
    answers
}

fn round_trip<M>(message: M) -> usize
where
    M: Clone + PartialEq + core::fmt::Debug + serde::Serialize + serde::de::DeserializeOwned,
{
    let mut out = [0; MAX_FRAME];
    let packet = Packet {
        sequence: u16::MAX,
        message,
    };
    let frame = encode(&packet, &mut out).expect("every message fits");
    let mut decoder = Decoder::new();
    let mut got = frame.iter().filter_map(|b| decoder.push(*b));
    assert_eq!(got.next(), Some(packet.clone()));
    frame.len()
}

#[test]
fn every_message_fits_at_its_longest_and_comes_back() {
    let mut longest = 0;
    for answer in longest_answers() {
        let message = FromBoard::Answer {
            request: u16::MAX,
            answer: answer.clone(),
        };
        longest = longest.max(round_trip(message));
        if let LinkAnswer::Settings(settings) = answer {
            round_trip(ToBoard::Steer {
                session: LONG,
                number: LONG,
                act: LinkAct::SetSettings(settings),
            });
        }
    }
    let telemetry = Telemetry {
        status: longest_status(),
        dropped: LONG,
    };
    longest = longest.max(round_trip(FromBoard::Telemetry(telemetry)));
    let given = GivenCommand {
        command: Command::SetPoint {
            frequency_hz: 1.0,
            amplitude_m: 1.0,
        },
        refused: Some(Refused::BadSettings),
    };
    let block = RecordedBlock {
        tick: LONG,
        frames: [Frame {
            emergency: true,
            ..Frame::default()
        }; MAX_BLOCK]
            .into_iter()
            .collect(),
        // Frequencies whose bits are far apart.
        outputs: (0..MAX_BLOCK)
            .map(|i| Output {
                enable: true,
                frequency_hz: if i % 2 == 0 { 0.0 } else { f32::MAX },
                ..Output::SAFE
            })
            .collect(),
        notes: BlockNotes {
            given: [given; MAX_GIVEN].into_iter().collect(),
            ..BlockNotes::default()
        },
    };
    let recording = Recording::pack(&block);
    longest = longest.max(round_trip(FromBoard::Recording(recording)));
    // The bound is not far too large either.
    assert!(longest > MAX_FRAME - 40, "{longest} of {MAX_FRAME}");
}
