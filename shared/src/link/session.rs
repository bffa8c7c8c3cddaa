//! The board's end of the link: requests in, answers and streams out.

use super::{
    ANSWER_RESERVE, Answer, ByteQueue, Counters, Decoder, ForecastPage, FromBoard, Hello,
    Identified, MAX_FRAME, Packet, RecordedBlock, Recording, Refusal, Telemetry, ToBoard, encode,
};
use crate::control::{Command, Mode, Refused, State, Status};
use crate::fault::{Fault, Record};
use crate::settings::Settings;

/// The functions of a board (or the emulator) that the link uses. None may wait.
pub trait Device {
    /// Versions and names.
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
    /// A page of the last forecast ([`ForecastPage::of`]).
    fn forecast(&mut self, page: u8) -> ForecastPage;
    /// The present or last fault; it survives a reset.
    fn fault_record(&mut self) -> Option<Record>;
    /// The identified parameters of the rig.
    fn identified(&mut self) -> Identified;
    /// Starts or ends keeping blocks for [`Device::take_block`].
    ///
    /// # Errors
    /// If the board cannot record: [`Refusal::NotAvailable`].
    fn record(&mut self, on: bool) -> Result<(), Refusal>;
    /// The oldest block kept, if any. What is not taken in time is lost, and shows as a gap in the ticks.
    fn take_block(&mut self) -> Option<RecordedBlock>;
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
    /// The computer steers: its silence is a fault.
    in_command: bool,
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
            in_command: false,
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

    /// Whether the computer steers. It does once it has started in manual mode, given a set-point or sent
    /// [`Command::Alive`], until a stop, a hello or a fault other than the link's own. While it steers, each of its
    /// packets reaches the controller as [`Command::Alive`].
    pub fn is_in_command(&self) -> bool {
        self.in_command
    }

    /// Takes one byte from the port; carries out the request that it completes and queues the answer.
    pub fn receive(&mut self, byte: u8, device: &mut impl Device) {
        let Some(packet) = self.decoder.push::<ToBoard>(byte) else {
            return;
        };
        let answer = self.answer(packet.message, device);
        self.keep_alive(device);
        let message = FromBoard::Answer {
            request: packet.sequence,
            answer,
        };
        self.send(message, 0);
    }

    /// Queues telemetry and recordings that are due. What does not fit is dropped and counted.
    pub fn poll(&mut self, device: &mut impl Device) {
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

    /// A packet is a sign of life of the computer that steers. It ends a link timeout; any other fault ends the
    /// computer's command.
    fn keep_alive(&mut self, device: &mut impl Device) {
        let status = device.status();
        let fault = status.fault.map(|record| record.fault);
        if status.state == State::Fault && fault != Some(Fault::LinkTimeout) {
            self.in_command = false;
        }
        if self.in_command {
            // Never refused.
            let _ = device.command(Command::Alive);
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

    fn answer(&mut self, request: ToBoard, device: &mut impl Device) -> Answer {
        match request {
            ToBoard::Hello => {
                // The computer must take command anew; the fault of a link timeout before it stays visible.
                self.in_command = false;
                self.decimation = 0;
                if self.recording {
                    self.recording = false;
                    let _ = device.record(false);
                }
                Answer::Hello(device.hello())
            }
            ToBoard::GetStatus => Answer::Status(device.status()),
            ToBoard::Command(command) => done(self.command(command, device).map_err(Refusal::from)),
            ToBoard::GetSettings => Answer::Settings(device.settings()),
            ToBoard::SetSettings(settings) => done(replace(&settings, device)),
            ToBoard::GetForecast { page } => Answer::Forecast(device.forecast(page)),
            ToBoard::StreamTelemetry { decimation } => {
                self.decimation = decimation;
                // The first one comes at once.
                self.last_telemetry = device.status().tick.wrapping_sub(decimation);
                Answer::Done
            }
            ToBoard::StreamFrames { on } => {
                let taken = device.record(on);
                self.recording = on && taken.is_ok();
                done(taken)
            }
            ToBoard::GetFaultRecord => Answer::FaultRecord(device.fault_record()),
            ToBoard::GetIdentified => Answer::Identified(device.identified()),
        }
    }

    fn command(&mut self, command: Command, device: &mut impl Device) -> Result<(), Refused> {
        device.command(command)?;
        self.in_command = match command {
            Command::Start(Mode::Manual) | Command::SetPoint { .. } | Command::Alive => true,
            Command::Start(Mode::Automatic) | Command::Stop => false,
            Command::ClearFault => self.in_command,
        };
        Ok(())
    }
}

fn replace(settings: &Settings, device: &mut impl Device) -> Result<(), Refusal> {
    settings.check().map_err(|_| Refused::BadSettings)?;
    device.replace_settings(settings)?;
    device.store_settings()
}

fn done(result: Result<(), Refusal>) -> Answer {
    match result {
        Ok(()) => Answer::Done,
        Err(why) => Answer::Refused(why),
    }
}
