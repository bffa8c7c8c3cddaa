//! What the tests of the link share: a device that records its calls, and the computer's end of the wire.

mod messages;
mod requests;
mod steering;

use std::vec::Vec;

use super::*;
use crate::control::{Basin, Command, MAX_BLOCK, Mode, Refused, SettingsState, State, Status};
use crate::fault::{Fault, FaultRecord, FaultSet, Origin};
use crate::forecast::{Forecast, ForecastOrbit, ForecastRow, Target};
use crate::io::{Frame, Output};
use crate::model::contact::LAWS;
use crate::model::params::{PRESETS, WIRES};
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
        events_dropped: u16::MAX,
        ..idle(0)
    }
}

fn longest_record() -> FaultRecord {
    FaultRecord {
        episode: FaultSet::from_bits(u32::MAX),
        ..FaultRecord::new(Fault::NotOff, Origin::Cart, LONG, 1.0, 1.0)
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
        events_dropped: 0,
    }
}

fn forecast(rows: usize) -> Forecast {
    let orbit = ForecastOrbit {
        force_n: 96.0,
        impulse_n_s: 0.03,
        approach_m_per_s: 0.08,
        onset_turns: 0.2,
        multiplier: 0.3,
        doubling_test: 0.9,
    };
    let row = |i| ForecastRow {
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
            firmware: LinkName::try_from("0.1.0").unwrap(),
            board: LinkName::try_from("stub").unwrap(),
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
    fn fault_record(&mut self) -> Option<FaultRecord> {
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
        let LinkAnswer::Board(board) = self.ask(ToBoard::GetBoard) else {
            panic!("the board's state was asked for");
        };
        let open = ToBoard::OpenSession {
            boot: board.boot,
            granted: board.granted,
            take_over,
        };
        match self.ask(open) {
            LinkAnswer::Session(session) => Ok(Program { session, number: 0 }),
            LinkAnswer::Refused(why) => Err(why),
            other => panic!("a session was asked for: {other:?}"),
        }
    }

    fn steer(&mut self, program: &mut Program, act: LinkAct) -> LinkAnswer {
        let request = program.request(act);
        self.ask(request)
    }

    fn command(&mut self, program: &mut Program, command: Command) -> LinkAnswer {
        self.steer(program, LinkAct::Command(command))
    }

    fn heard(&mut self) -> Vec<Packet<FromBoard>> {
        let mut heard = Vec::new();
        while let Some(byte) = self.session.queue().pop() {
            heard.extend(self.decoder.push(byte));
        }
        heard
    }

    fn ask(&mut self, message: ToBoard) -> LinkAnswer {
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
    fn request(&mut self, act: LinkAct) -> ToBoard {
        self.number += 1;
        ToBoard::Steer {
            session: self.session,
            number: self.number,
            act,
        }
    }
}
