//! Boards for `host-sim link` that are not there: sessions behind pseudo-terminals.

use std::io::{BufRead, BufReader};
use std::process::{Child, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use crate::support::Folder;
use host_sim::link::{BoardSession, EmulatedBoard, client};
use serialport::{SerialPort, TTYPort};
use shared::control::{BootInfo, Command, Controller, Mode, Refused, State, Status};
use shared::fault::{Fault, FaultRecord, Origin};
use shared::forecast::ForecastRow;
use shared::io::{AdcCode, Frame, Output};
use shared::link::{
    BAUD, Boot, Device, ForecastPage, Hello, Identified, LinkName, PROTOCOL_VERSION, RecordedBlock,
    Refusal,
};
use shared::model::params::WIRES;
use shared::model::regime::Regime;
use shared::settings::Settings;

/// A device behind a pseudo-terminal until it is dropped.
pub struct Behind {
    pub path: String,
    over: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Behind {
    /// Runs `device`; `turn` lets its time go on between two looks at the wire.
    fn run<D: Device + Send + 'static>(mut device: D, turn: fn(&mut D)) -> Self {
        let (mut wire, far_end) = TTYPort::pair().expect("a pseudo-terminal");
        wire.set_timeout(Duration::from_millis(1))
            .expect("a timeout");
        let path = far_end.name().expect("its name");
        let over = Arc::new(AtomicBool::new(false));
        let stop = Arc::clone(&over);
        let thread = thread::spawn(move || {
            // Held open: without an opener at the far end, the wire reads as broken.
            let _far_end = far_end;
            let mut server = BoardSession::new();
            while !stop.load(Ordering::Relaxed) {
                turn(&mut device);
                server
                    .step(&mut device, &mut wire)
                    .expect("a wire that works");
            }
        });
        Self {
            path,
            over,
            thread: Some(thread),
        }
    }

    /// The command line of `link` to it.
    pub fn line(&self, rest: &str) -> String {
        format!("link {} {rest}", self.path)
    }

    /// A client of its own.
    pub fn client(&self) -> client::Client<Box<dyn SerialPort>> {
        client::open(&self.path, Some(BAUD))
            .expect("a board")
            .client
    }
}

impl Drop for Behind {
    fn drop(&mut self) {
        self.over.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            thread.join().expect("the device ran well");
        }
    }
}

/// The real controller at a rig that stands still.
pub fn still() -> Behind {
    let mut board = EmulatedBoard::new(&Settings::for_rig(&WIRES), 10).expect("good settings");
    // A forecast takes a while; it is there before the first question.
    while board
        .lockstep()
        .forecast()
        .is_none_or(|f| f.rows.is_empty())
    {
        quiet_block(&mut board);
    }
    Behind::run(board, quiet_block)
}

pub fn quiet_block(board: &mut EmulatedBoard) {
    let settings = board.settings();
    let code = |zero: f32| AdcCode(zero as u16);
    let frame = Frame {
        force: code(settings.force.zero_code),
        hammer: code(settings.hammer.zero_code),
        cart: code(settings.cart.zero_code),
        emergency: false,
    };
    board.exchange(&[frame; 10], &mut [Output::SAFE; 10], 20);
}

/// A board whose force is its frequency, whose limits are 1 and 5 Hz, and whose time runs fast.
pub struct Toy {
    pub status: Status,
    pub settings: Settings,
    pub aim_hz: f32,
    pub protocol: u16,
    pub trips_above_hz: f32,
    /// What it calls itself.
    pub name: &'static str,
    /// What it never does.
    pub never: Option<Never>,
    /// Whether it has a block to send.
    pub streams: bool,
}

/// What a broken board may not do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Never {
    /// Become idle, after it took the stop.
    Idle,
    /// Give two pages of one forecast.
    OneForecast,
    /// Begin anew with its settings, while it streams.
    Restarts,
    /// Let its time go on.
    Ticks,
}

impl Toy {
    /// A toy at rest, with the settings of wires, that breaks no rule.
    pub fn new() -> Self {
        let mut settings = Settings::for_rig(&WIRES);
        settings.operator.heartbeat = true;
        let controller = Controller::new(&settings, &BootInfo::STORED).expect("good settings");
        Self {
            status: controller.status(),
            settings,
            aim_hz: 2.0,
            protocol: PROTOCOL_VERSION,
            trips_above_hz: f32::INFINITY,
            name: "toy",
            never: None,
            streams: false,
        }
    }

    /// 5 ms, at 2 Hz/s.
    fn turn(&mut self) {
        self.streams |= self.never == Some(Never::Restarts);
        let status = &mut self.status;
        if self.never != Some(Never::Ticks) {
            status.tick = status.tick.wrapping_add(100);
        }
        match status.state {
            State::SelfTest => status.state = State::Manual,
            State::Stop if self.never != Some(Never::Idle) => status.state = State::Idle,
            _ => {}
        }
        let step = (self.aim_hz - status.frequency_hz).clamp(-0.01, 0.01);
        status.frequency_hz += step;
        status.peak_n = status.frequency_hz;
        if status.state == State::Manual && status.frequency_hz > self.trips_above_hz {
            status.state = State::Fault;
            status.fault = Some(FaultRecord::new(
                Fault::OverForce,
                Origin::Force,
                status.tick,
                500.0,
                status.frequency_hz,
            ));
        }
    }
}

impl Device for Toy {
    fn hello(&mut self) -> Hello {
        Hello {
            protocol: self.protocol,
            firmware: LinkName::try_from("9.9.9").expect("short"),
            board: LinkName::try_from(self.name).expect("short"),
            tick_rate_hz: 20_000,
            block_ticks: 10,
        }
    }
    fn status(&mut self) -> Status {
        self.status
    }
    fn command(&mut self, command: Command) -> Result<(), Refused> {
        match (command, self.status.state) {
            (Command::Start(Mode::Automatic), State::Idle) if self.never == Some(Never::Ticks) => {
                self.status.state = State::Seek;
            }
            (Command::Start(Mode::Manual), State::Idle) => self.status.state = State::SelfTest,
            (Command::Stop, State::Manual) => self.status.state = State::Stop,
            (Command::SetPoint { frequency_hz, .. }, State::Manual) => {
                self.aim_hz = frequency_hz.clamp(1.0, 5.0);
            }
            (Command::Alive, _) => {}
            _ => return Err(Refused::WrongState),
        }
        Ok(())
    }
    fn settings(&mut self) -> Settings {
        self.settings
    }
    fn replace_settings(&mut self, settings: &Settings) -> Result<(), Refused> {
        self.settings = *settings;
        Ok(())
    }
    fn store_settings(&mut self) -> Result<(), Refusal> {
        match self.never {
            Some(Never::Restarts) => Ok(()),
            _ => Err(Refusal::NotStored),
        }
    }
    fn forecast(&mut self, page: u8) -> ForecastPage {
        let mut one = ForecastPage::of(None, page);
        if self.never == Some(Never::OneForecast) {
            one.id = self.status.tick;
            one.rows_in_all = 40;
            let row = ForecastRow {
                frequency_hz: 3.0,
                regime: Regime::None,
                force_n: 1.0,
                orbit: None,
            };
            one.rows = [row].into_iter().collect();
        }
        one
    }
    fn fault_record(&mut self) -> Option<FaultRecord> {
        self.status.fault
    }
    fn identified(&mut self) -> Identified {
        Identified::default()
    }
    fn record(&mut self, on: bool) -> Result<(), Refusal> {
        match self.never {
            Some(Never::Restarts) => {
                self.streams = on;
                Ok(())
            }
            _ => Err(Refusal::NotAvailable),
        }
    }
    fn take_block(&mut self) -> Option<RecordedBlock> {
        std::mem::take(&mut self.streams).then(RecordedBlock::default)
    }
    fn boot(&mut self) -> Boot {
        Boot::default()
    }
}

pub fn toy(toy: Toy) -> Behind {
    Behind::run(toy, Toy::turn)
}

/// `host-sim emulate --pty`, ended when dropped.
pub struct Emulator(Child, pub String);

impl Emulator {
    /// Starts it and waits for its path.
    pub fn start(folder: &Folder, scenario: &str) -> Self {
        let mut command = folder.command(&["emulate", scenario, "--pty"]);
        let mut child = command.stdout(Stdio::piped()).spawn().expect("it starts");
        let out = child.stdout.take().expect("it is piped");
        let mut path = String::new();
        BufReader::new(out).read_line(&mut path).expect("a path");
        Self(child, path.trim().to_owned())
    }
}

impl Drop for Emulator {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}
