//! Every message fits, and a session does what it is asked.

mod steering;

use std::vec::Vec;

use super::*;
use crate::control::{Basin, Command, MAX_BLOCK, Mode, Refused, SettingsState, State, Status};
use crate::fault::{Fault, FaultSet, Origin, Record};
use crate::forecast::{Forecast, Orbit, Row, Target};
use crate::io::{Frame, Output};
use crate::model::params::{LAWS, PRESETS, WIRES};
use crate::model::regime::Regime;
use crate::settings::Settings;

/// Numbers that postcard writes longest.
const LONG: u32 = u32::MAX;

fn longest_status() -> Status {
    Status {
        tick: LONG,
        state: State::Manual,
        fault: Some(longest_record()),
        limits: crate::control::ActiveLimits::ALL,
        regime: Regime::Chatter {
            impacts: u16::MAX,
            periods: Some(u8::MAX),
        },
        basin: Basin::NoImpact,
        reseeks: u16::MAX,
        overruns: LONG,
        ..idle(0)
    }
}

fn longest_record() -> Record {
    Record {
        episode: FaultSet::from_bits(u32::MAX),
        ..Record::new(Fault::NotOff, Origin::Cart, LONG, 1.0, 1.0)
    }
}

fn idle(tick: u32) -> Status {
    Status {
        tick,
        state: State::Idle,
        fault: None,
        limits: crate::control::ActiveLimits::NONE,
        frequency_hz: 0.0,
        amplitude_m: 0.0,
        measured_amplitude_m: 0.0,
        lag_rad: 0.0,
        regime: Regime::None,
        peak_n: 0.0,
        impulse_n_s: 0.0,
        target_hz: 0.0,
        target_n: 0.0,
        basin: Basin::Unknown,
        reseeks: 0,
        overruns: 0,
    }
}

fn forecast(rows: usize) -> Forecast {
    let orbit = Orbit {
        force_n: 96.0,
        impulse_n_s: 0.03,
        approach_m_per_s: 0.08,
        onset_turns: 0.2,
        trace: -0.4,
        determinant: 0.1,
    };
    let row = |i| Row {
        frequency_hz: i as f32,
        regime: longest_status().regime,
        force_n: 96.0,
        orbit: Some(orbit),
    };
    let target = Target {
        frequency_hz: 3.6,
        orbit,
        band_hz: (3.0, 4.0),
        doubling_hz: Some(4.0),
        entry_hz: 3.2,
    };
    Forecast {
        id: LONG,
        rows: (0..rows).map(row).collect(),
        target: Some(target),
    }
}

#[test]
fn the_first_answer_keeps_its_bytes_for_ever() {
    // What a board of any version sends first: sequence 7, kind 0 (an answer), to request 5, answer 0 (hello),
    // and the version before all else. A computer of any version can read that far.
    let name = |text| Name::try_from(text).unwrap();
    let packet = |protocol| Packet {
        sequence: 7,
        message: FromBoard::Answer {
            request: 5,
            answer: Answer::Hello(Hello {
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

fn longest_answers() -> Vec<Answer> {
    let name = || Name::try_from("01234567890123456789012").unwrap();
    let mut answers = std::vec![
        Answer::Hello(Hello {
            protocol: u16::MAX,
            firmware: name(),
            board: name(),
            tick_rate_hz: LONG,
            block_ticks: u8::MAX,
        }),
        Answer::Refused(Refusal::Controller(Refused::SettingsUnknown(
            SettingsState::Model
        ))),
        Answer::Session(LONG),
        Answer::Board(BoardState {
            boot: LONG,
            granted: LONG,
            held: true,
            settings: SettingsState::Model,
            awaits_acknowledgement: true,
        }),
        Answer::Status(longest_status()),
        Answer::Forecast(ForecastPage::of(Some(&forecast(40)), 5)),
        Answer::FaultRecord(Some(longest_record())),
        Answer::Identified(Identified {
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
            let mut rig = crate::model::params::RigParams { contact, ..rig };
            if let crate::model::params::SupportParams::Beams {
                cubic_stiffness_n_per_m3,
                ..
            } = &mut rig.support
            {
                *cubic_stiffness_n_per_m3 = Some(1.0);
            }
            answers.push(Answer::Settings(Settings::for_rig(&rig)));
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
        if let Answer::Settings(settings) = answer {
            round_trip(ToBoard::Steer {
                session: LONG,
                number: LONG,
                act: Act::SetSettings(settings),
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

/// A device that records its calls.
struct Stub {
    status: Status,
    settings: Settings,
    stored: Option<Settings>,
    told: Vec<Command>,
    recorded: bool,
    boot: Boot,
}

impl Stub {
    fn new() -> Self {
        Self {
            status: idle(0),
            settings: Settings::for_rig(&WIRES),
            stored: None,
            told: Vec::new(),
            recorded: false,
            boot: Boot {
                number: 77,
                ..Boot::default()
            },
        }
    }
}

impl Device for Stub {
    fn hello(&mut self) -> Hello {
        Hello {
            protocol: PROTOCOL_VERSION,
            firmware: Name::try_from("0.1.0").unwrap(),
            board: Name::try_from("stub").unwrap(),
            tick_rate_hz: 20_000,
            block_ticks: 10,
        }
    }
    fn status(&mut self) -> Status {
        self.status
    }
    fn command(&mut self, command: Command) -> Result<(), Refused> {
        if matches!(command, Command::Start(_)) && self.status.state != State::Idle {
            return Err(Refused::WrongState);
        }
        if let Command::Start(mode) = command {
            self.status.state = match mode {
                Mode::Automatic => State::SelfTest,
                Mode::Manual => State::Manual,
            };
        }
        self.told.push(command);
        Ok(())
    }
    fn settings(&mut self) -> Settings {
        self.settings
    }
    fn replace_settings(&mut self, settings: &Settings) -> Result<(), Refused> {
        if self.status.state != State::Idle {
            return Err(Refused::WrongState);
        }
        self.settings = *settings;
        Ok(())
    }
    fn store_settings(&mut self) -> Result<(), Refusal> {
        self.stored = Some(self.settings);
        Ok(())
    }
    fn forecast(&mut self, page: u8) -> ForecastPage {
        ForecastPage::of(Some(&forecast(40)), page)
    }
    fn fault_record(&mut self) -> Option<Record> {
        Some(longest_record())
    }
    fn identified(&mut self) -> Identified {
        Identified::default()
    }
    fn record(&mut self, on: bool) -> Result<(), Refusal> {
        self.recorded = on;
        Ok(())
    }
    fn take_block(&mut self) -> Option<RecordedBlock> {
        self.status.tick += 10;
        Some(RecordedBlock {
            tick: self.status.tick,
            ..RecordedBlock::default()
        })
    }
    fn boot(&mut self) -> Boot {
        self.boot
    }
}

/// A session, its device, and the computer's end of the wire.
struct Pair {
    session: Session<1200>,
    device: Stub,
    decoder: Decoder,
    sequence: u16,
}

impl Pair {
    fn new() -> Self {
        Self {
            session: Session::new(),
            device: Stub::new(),
            decoder: Decoder::new(),
            sequence: 0,
        }
    }

    fn send(&mut self, message: ToBoard) {
        self.sequence += 1;
        let mut out = [0; MAX_FRAME];
        let packet = Packet {
            sequence: self.sequence,
            message,
        };
        for byte in encode(&packet, &mut out).unwrap() {
            self.session.receive(*byte, &mut self.device);
        }
    }

    /// Opens a session for a new program.
    fn open(&mut self, take_over: bool) -> Result<Program, Refusal> {
        let Answer::Board(board) = self.ask(ToBoard::GetBoard) else {
            panic!("the board's state was asked for");
        };
        let open = ToBoard::OpenSession {
            boot: board.boot,
            granted: board.granted,
            take_over,
        };
        match self.ask(open) {
            Answer::Session(session) => Ok(Program { session, number: 0 }),
            Answer::Refused(why) => Err(why),
            other => panic!("a session was asked for: {other:?}"),
        }
    }

    fn steer(&mut self, program: &mut Program, act: Act) -> Answer {
        let request = program.request(act);
        self.ask(request)
    }

    fn command(&mut self, program: &mut Program, command: Command) -> Answer {
        self.steer(program, Act::Command(command))
    }

    fn heard(&mut self) -> Vec<Packet<FromBoard>> {
        let mut heard = Vec::new();
        while let Some(byte) = self.session.queue().pop() {
            heard.extend(self.decoder.push(byte));
        }
        heard
    }

    fn ask(&mut self, message: ToBoard) -> Answer {
        self.send(message);
        let heard = self.heard();
        let sent = self.sequence;
        let found = heard.into_iter().find_map(|packet| match packet.message {
            FromBoard::Answer { request, answer } if request == sent => Some(answer),
            _ => None,
        });
        found.expect("every request is answered")
    }
}

/// A program that was granted a session.
#[derive(Clone, Copy, Debug)]
struct Program {
    session: u32,
    number: u32,
}

impl Program {
    fn request(&mut self, act: Act) -> ToBoard {
        self.number += 1;
        ToBoard::Steer {
            session: self.session,
            number: self.number,
            act,
        }
    }
}

#[test]
fn requests_are_carried_out_and_answered() {
    let mut pair = Pair::new();
    assert!(matches!(pair.ask(ToBoard::Hello), Answer::Hello(h) if h.board == "stub"));
    assert_eq!(pair.ask(ToBoard::GetStatus), Answer::Status(idle(0)));
    let record = Answer::FaultRecord(Some(longest_record()));
    assert_eq!(pair.ask(ToBoard::GetFaultRecord), record);
    let mut rows = 0;
    for page in 0.. {
        let Answer::Forecast(part) = pair.ask(ToBoard::GetForecast { page }) else {
            panic!("a page was asked for");
        };
        assert_eq!(part.rows_in_all, 40);
        if part.rows.is_empty() {
            break;
        }
        assert_eq!(part.rows[0].frequency_hz, rows as f32);
        rows += part.rows.len();
    }
    assert_eq!(rows, 40);
    let mut program = pair.open(false).unwrap();
    let start = Command::Start(Mode::Automatic);
    assert_eq!(pair.command(&mut program, start), Answer::Done);
    let refused = Answer::Refused(Refusal::Controller(Refused::WrongState));
    assert_eq!(pair.command(&mut program, start), refused);
}

#[test]
fn settings_are_taken_whole_and_only_if_they_are_good() {
    let mut pair = Pair::new();
    let mut program = pair.open(false).unwrap();
    let mut set = |pair: &mut Pair, new| pair.steer(&mut program, Act::SetSettings(new));
    let old = pair.device.settings;
    let mut new = old;
    new.trips.force_n = f32::NAN;
    let bad = Answer::Refused(Refusal::Controller(Refused::BadSettings));
    assert_eq!(set(&mut pair, new), bad);
    assert_eq!((pair.device.settings, pair.device.stored), (old, None));
    new.trips.force_n = 1.1 * old.trips.force_n;
    assert_eq!(set(&mut pair, new), Answer::Done);
    assert_eq!((pair.device.settings, pair.device.stored), (new, Some(new)));
    pair.device.status.state = State::Hold;
    let wrong = Answer::Refused(Refusal::Controller(Refused::WrongState));
    assert_eq!(set(&mut pair, old), wrong);
    assert_eq!((pair.device.settings, pair.device.stored), (new, Some(new)));
}

#[test]
fn telemetry_comes_at_its_decimation_also_where_ticks_wrap() {
    let mut pair = Pair::new();
    pair.device.status.tick = u32::MAX - 120;
    let stream = ToBoard::StreamTelemetry { decimation: 100 };
    assert_eq!(pair.ask(stream), Answer::Done);
    let mut seen = Vec::new();
    for _ in 0..40 {
        pair.session.poll(&mut pair.device);
        for packet in pair.heard() {
            if let FromBoard::Telemetry(telemetry) = packet.message {
                seen.push(telemetry.status.tick);
            }
        }
        pair.device.status.tick = pair.device.status.tick.wrapping_add(10);
    }
    let start = u32::MAX - 120;
    let expected = [0, 100, 200, 300].map(|ticks| start.wrapping_add(ticks));
    assert_eq!(seen, expected);
    pair.ask(ToBoard::StreamTelemetry { decimation: 0 });
    pair.session.poll(&mut pair.device);
    assert!(pair.heard().is_empty());
}

#[test]
fn a_full_queue_drops_recordings_whole_counts_them_and_still_answers() {
    let mut pair = Pair::new();
    assert_eq!(pair.ask(ToBoard::StreamFrames { on: true }), Answer::Done);
    assert!(pair.device.recorded);
    for _ in 0..100 {
        pair.session.poll(&mut pair.device);
    }
    let dropped = pair.session.queue().dropped();
    assert!(dropped > 0);
    // Nothing was read since, and there is room for an answer.
    pair.send(ToBoard::GetForecast { page: 0 });
    let heard = pair.heard();
    let last = &heard.last().unwrap().message;
    assert!(matches!(last, FromBoard::Answer { .. }), "{last:?}");
    // The numbers show what was lost: the first packet answered the request to stream.
    let missing = heard.last().unwrap().sequence - 1 - heard.len() as u16;
    assert_eq!(u32::from(missing), dropped);
    assert_eq!(pair.session.queue().dropped(), dropped);
    // Who says hello begins a conversation without it.
    pair.ask(ToBoard::Hello);
    pair.session.poll(&mut pair.device);
    assert!(pair.heard().is_empty() && !pair.device.recorded);
}
