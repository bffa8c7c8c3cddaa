//! The board's end of the link: requests in, answers and streams out.

use super::{
    ANSWER_RESERVE, BoardState, ByteQueue, Counters, Decoder, ForecastPage, FromBoard, Hello,
    Identified, LinkAct, LinkAnswer, MAX_FRAME, Packet, RecordedBlock, Recording, Refusal,
    Telemetry, ToBoard, encode,
};
use crate::control::{Command, Mode, Refused, SettingsState, State, Status};
use crate::fault::FaultRecord;
use crate::settings::{Settings, ticks_of};

/// The functions of a board (or the emulator) that the link uses. None may wait.
pub trait Device {
    /// Versions of protocol and firmware, the board's name, and its tick and block.
    fn hello(&mut self) -> Hello;
    /// What the controller is doing.
    fn status(&mut self) -> Status;
    /// Passes a command on.
    ///
    /// # Errors
    /// If the controller refuses it.
    fn command(&mut self, command: Command) -> Result<(), Refused>;
    /// The settings in use.
    fn settings(&mut self) -> Settings;
    /// Takes settings that have been checked into use, as a whole.
    ///
    /// # Errors
    /// If the controller is neither in Idle nor in Fault.
    fn replace_settings(&mut self, settings: &Settings) -> Result<(), Refused>;
    /// Stores the settings in use; called only right after they were taken, so in Idle with the drive off.
    /// A board must make sure that no start comes between.
    ///
    /// # Errors
    /// If the flash fails: [`Refusal::NotStored`].
    fn store_settings(&mut self) -> Result<(), Refusal>;
    /// Sets the part's brown-out reset to the level that its clock needs; called only in Idle or Fault.
    ///
    /// # Errors
    /// If the board has none ([`Refusal::NotAvailable`]), or the flash fails ([`Refusal::NotStored`]).
    fn set_brown_out(&mut self) -> Result<(), Refusal> {
        Err(Refusal::NotAvailable)
    }
    /// A page of the last forecast ([`ForecastPage::of`]).
    fn forecast(&mut self, page: u8) -> ForecastPage;
    /// The present or last fault; it survives a reset.
    fn fault_record(&mut self) -> Option<FaultRecord>;
    /// The identified parameters of the rig.
    fn identified(&mut self) -> Identified;
    /// Starts or ends keeping blocks for [`Device::take_block`].
    ///
    /// # Errors
    /// If the board cannot record: [`Refusal::NotAvailable`].
    fn record(&mut self, on: bool) -> Result<(), Refusal>;
    /// The oldest block kept, if any. What is not taken in time is lost, and shows as a gap in the ticks.
    fn take_block(&mut self) -> Option<RecordedBlock>;
    /// Which boot this is, and what a person has still to do.
    fn boot(&mut self) -> Boot;
}

/// What a device knows of its start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Boot {
    /// Another number after every start.
    pub number: u32,
    /// Where the settings come from.
    pub settings: SettingsState,
    /// An emergency stop must be acknowledged at the board.
    pub awaits_acknowledgement: bool,
}

/// A session is over after a silence of so long, s; or of the settings' link timeout, if that is longer.
pub const SESSION_S: f32 = 2.0;

/// The session of the program that steers.
#[derive(Clone, Copy, Debug)]
struct Steering {
    session: u32,
    /// The boot in which it was granted.
    boot: u32,
    /// Number of the last act.
    last: u32,
    /// When that came, and how long a silence may be, ticks.
    heard: u32,
    patience: u32,
}

impl Steering {
    /// Whether it has not been silent for too long.
    fn is_alive(&self, tick: u32) -> bool {
        tick.wrapping_sub(self.heard) <= self.patience
    }
}

/// The board's end of the link, with a queue of `N` bytes for the wire (at least twice [`MAX_FRAME`]).
///
/// Call [`Session::receive`] with what the port brings, [`Session::poll`] now and then (at least once per
/// block while recording), and send what [`Session::queue`] holds.
#[derive(Debug)]
pub struct Session<const N: usize> {
    decoder: Decoder,
    queue: ByteQueue<N>,
    sequence: u16,
    /// Ticks between telemetry packets; 0: none.
    decimation: u32,
    last_telemetry: u32,
    recording: bool,
    /// Session of the program that steers; none while nobody does.
    steering: Option<Steering>,
    /// Sessions granted so far (wraps).
    granted: u32,
}

impl<const N: usize> Default for Session<N> {
    fn default() -> Self {
        Self::new()
    }
}

impl<const N: usize> Session<N> {
    const ROOM_FOR_AN_ANSWER_AND_MORE: () = assert!(N >= 2 * MAX_FRAME);

    /// A session without a conversation yet.
    pub const fn new() -> Self {
        let () = Self::ROOM_FOR_AN_ANSWER_AND_MORE;
        Self {
            decoder: Decoder::new(),
            queue: ByteQueue::new(),
            sequence: 0,
            decimation: 0,
            last_telemetry: 0,
            recording: false,
            steering: None,
            granted: 0,
        }
    }

    /// Counts of received frames.
    pub fn counters(&self) -> Counters {
        self.decoder.counters()
    }

    /// Bytes for the wire.
    pub fn queue(&mut self) -> &mut ByteQueue<N> {
        &mut self.queue
    }

    /// Whether somebody has the session.
    pub fn is_held(&self) -> bool {
        self.steering.is_some()
    }

    /// Takes one byte from the port; carries out the request that it completes and queues the answer.
    pub fn receive(&mut self, byte: u8, device: &mut impl Device) {
        let Some(packet) = self.decoder.push::<ToBoard>(byte) else {
            return;
        };
        let answer = self.answer(packet.message, device);
        let message = FromBoard::Answer {
            request: packet.sequence,
            answer,
        };
        self.send(message, 0);
    }

    /// Queues telemetry and recordings that are due. What does not fit is dropped and counted.
    pub fn poll(&mut self, device: &mut impl Device) {
        self.end_silent_session(device);
        if self.decimation > 0 {
            let status = device.status();
            if status.tick.wrapping_sub(self.last_telemetry) >= self.decimation {
                self.last_telemetry = status.tick;
                let dropped = self.queue.dropped();
                let telemetry = Telemetry { status, dropped };
                self.send(FromBoard::Telemetry(telemetry), ANSWER_RESERVE);
            }
        }
        // Bounded, so that a device that records as fast as blocks are taken does not hold the task.
        for _ in 0..8 {
            let Some(block) = self.recording.then(|| device.take_block()).flatten() else {
                return;
            };
            let recording = Recording::pack(&block);
            self.send(FromBoard::Recording(recording), ANSWER_RESERVE);
        }
    }

    /// Ends the session of a program that has been silent for too long, or that the board's reset has outlived.
    fn end_silent_session(&mut self, device: &mut impl Device) {
        if let Some(steering) = &self.steering
            && (!steering.is_alive(device.status().tick) || steering.boot != device.boot().number)
        {
            self.steering = None;
        }
    }

    fn send(&mut self, message: FromBoard, reserve: usize) {
        self.sequence = self.sequence.wrapping_add(1);
        let packet = Packet {
            sequence: self.sequence,
            message,
        };
        let mut frame = [0; MAX_FRAME];
        if let Some(frame) = encode(&packet, &mut frame) {
            self.queue.push(frame, reserve);
        }
    }

    fn answer(&mut self, request: ToBoard, device: &mut impl Device) -> LinkAnswer {
        match request {
            ToBoard::Hello => {
                self.decimation = 0;
                if self.recording {
                    self.recording = false;
                    let _ = device.record(false);
                }
                LinkAnswer::Hello(device.hello())
            }
            ToBoard::GetStatus => LinkAnswer::Status(device.status()),
            ToBoard::Command(Command::Stop) => {
                done(device.command(Command::Stop).map_err(Refusal::from))
            }
            ToBoard::Command(_) => LinkAnswer::Refused(Refusal::NoSession),
            ToBoard::GetSettings => LinkAnswer::Settings(device.settings()),
            ToBoard::GetForecast { page } => LinkAnswer::Forecast(device.forecast(page)),
            ToBoard::StreamTelemetry { decimation } => {
                self.decimation = decimation;
                // The first one comes at once.
                self.last_telemetry = device.status().tick.wrapping_sub(decimation);
                LinkAnswer::Done
            }
            ToBoard::StreamFrames { on } => {
                let taken = device.record(on);
                self.recording = on && taken.is_ok();
                done(taken)
            }
            ToBoard::GetFaultRecord => LinkAnswer::FaultRecord(device.fault_record()),
            ToBoard::GetIdentified => LinkAnswer::Identified(device.identified()),
            ToBoard::GetBoard => LinkAnswer::Board(self.board_state(device)),
            ToBoard::OpenSession {
                boot,
                granted,
                take_over,
            } => match self.open(boot, granted, take_over, device) {
                Ok(session) => LinkAnswer::Session(session),
                Err(why) => LinkAnswer::Refused(why),
            },
            ToBoard::Steer {
                session,
                number,
                act,
            } => done(self.steer(session, number, &act, device)),
        }
    }

    fn board_state(&mut self, device: &mut impl Device) -> BoardState {
        self.end_silent_session(device);
        let boot = device.boot();
        BoardState {
            boot: boot.number,
            granted: self.granted,
            held: self.is_held(),
            settings: boot.settings,
            awaits_acknowledgement: boot.awaits_acknowledgement,
        }
    }

    fn open(
        &mut self,
        boot: u32,
        granted: u32,
        take_over: bool,
        device: &mut impl Device,
    ) -> Result<u32, Refusal> {
        self.end_silent_session(device);
        if boot != device.boot().number || granted != self.granted {
            return Err(Refusal::Old);
        }
        if self.is_held() && !take_over {
            return Err(Refusal::SomebodySteers);
        }
        self.granted = granted.wrapping_add(1);
        let session = session_number(boot, self.granted);
        self.steering = Some(Steering {
            session,
            boot,
            last: 0,
            heard: device.status().tick,
            patience: patience(&device.settings()),
        });
        Ok(session)
    }

    fn steer(
        &mut self,
        session: u32,
        number: u32,
        act: &LinkAct,
        device: &mut impl Device,
    ) -> Result<(), Refusal> {
        self.end_silent_session(device);
        let holder = self.steering.as_mut().filter(|s| s.session == session);
        let holder = holder.ok_or(Refusal::NoSession)?;
        if number <= holder.last {
            return Err(Refusal::Old);
        }
        holder.last = number;
        holder.heard = device.status().tick;
        match act {
            LinkAct::Command(command) => give(*command, device),
            LinkAct::SetSettings(settings) => {
                let replaced = replace(settings, device);
                holder.patience = patience(&device.settings());
                // The flash may have held the board up: that was not the program's silence.
                holder.heard = device.status().tick;
                replaced
            }
            LinkAct::Release => {
                self.steering = None;
                Ok(())
            }
            LinkAct::SetBrownOut => {
                let is_off = matches!(device.status().state, State::Idle | State::Fault);
                let set = if is_off {
                    device.set_brown_out()
                } else {
                    Err(Refused::WrongState.into())
                };
                holder.heard = device.status().tick;
                set
            }
        }
    }
}

/// A number that differs from one session to the next and, as boots differ, from one boot to the next.
fn session_number(boot: u32, granted: u32) -> u32 {
    boot ^ granted.wrapping_mul(0x9e37_79b9)
}

/// How long a session may be silent, ticks.
fn patience(settings: &Settings) -> u32 {
    ticks_of(settings.trips.link_timeout_s.max(SESSION_S))
}

fn give(command: Command, device: &mut impl Device) -> Result<(), Refusal> {
    if matches!(command, Command::Acknowledge { .. }) {
        return Err(Refusal::AtTheBoard);
    }
    device.command(command)?;
    match command {
        // Who steers by hand is in command: silence is a fault from now on.
        Command::Start(Mode::Manual) | Command::SetPoint { .. } => {
            Ok(device.command(Command::Alive)?)
        }
        // The copy that was confirmed becomes the newest.
        Command::ConfirmSettings => device.store_settings(),
        _ => Ok(()),
    }
}

fn replace(settings: &Settings, device: &mut impl Device) -> Result<(), Refusal> {
    settings.check().map_err(|_| Refused::BadSettings)?;
    device.replace_settings(settings)?;
    device.store_settings()
}

fn done(result: Result<(), Refusal>) -> LinkAnswer {
    match result {
        Ok(()) => LinkAnswer::Done,
        Err(why) => LinkAnswer::Refused(why),
    }
}
