//! The controller under test, wherever it runs: in this process, or in a processor that is emulated or real.

use std::f64::consts::TAU;

use serde::{Deserialize, Serialize};
use shared::control::{BootInfo, Command, Event, Mode, Refused, State, Status};
use shared::io::{DacCode, Frame, Output};
use shared::model::regime::Regime;
use shared::settings::{Settings, TICK_S};

/// Why the controller starts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Reset {
    /// Power came on: no record of an earlier fault is left.
    #[default]
    PowerOn,
    /// The watchdog has reset it.
    Watchdog,
    /// The supply voltage dropped below its limit.
    BrownOut,
    /// The reset line was low while it drove.
    WhileDriving,
    /// It panicked or faulted.
    Crash,
    /// Power came on, and the stored settings were found damaged.
    CorruptSettings,
    /// Power came on without the crystal's clock.
    Unfit,
}

/// A controller under test. Every call is a message with plain data either way.
pub trait ControlUnderTest {
    /// A block of frames in, a block of outputs back, then `slices` slices of the forecast.
    fn exchange(&mut self, frames: &[Frame], outputs: &mut [Output], slices: u32);
    /// A block without samples.
    fn exchange_blind(&mut self, outputs: &mut [Output], slices: u32);
    /// A command, obeyed before the next block.
    ///
    /// # Errors
    /// Why it is refused.
    fn command(&mut self, command: Command) -> Result<(), Refused>;
    /// The controller's status after the last block.
    fn status(&mut self) -> Status;
    /// The events it reports, oldest first.
    fn take_event(&mut self) -> Option<Event>;
    /// Its control task overran.
    fn note_overrun(&mut self);
    /// It is reset: made anew with its settings, and with the record that survived. Returns what it found.
    fn reset(&mut self, cause: Reset) -> BootInfo;
    /// The settings it was made with.
    fn settings(&self) -> &Settings;
}

/// One that is lent.
impl<T: ControlUnderTest + ?Sized> ControlUnderTest for &mut T {
    #[inline]
    fn exchange(&mut self, frames: &[Frame], outputs: &mut [Output], slices: u32) {
        (**self).exchange(frames, outputs, slices);
    }
    fn exchange_blind(&mut self, outputs: &mut [Output], slices: u32) {
        (**self).exchange_blind(outputs, slices);
    }
    fn command(&mut self, command: Command) -> Result<(), Refused> {
        (**self).command(command)
    }
    fn status(&mut self) -> Status {
        (**self).status()
    }
    fn take_event(&mut self) -> Option<Event> {
        (**self).take_event()
    }
    fn note_overrun(&mut self) {
        (**self).note_overrun();
    }
    fn reset(&mut self, cause: Reset) -> BootInfo {
        (**self).reset(cause)
    }
    fn settings(&self) -> &Settings {
        (**self).settings()
    }
}

/// The simplest controller there is: the frequency and amplitude of its settings or of a set-point, ramped
/// up over a second, no feedback and no fault but the emergency stop. For tests of the plant and the run around it.
#[derive(Clone, Debug)]
pub struct FixedFrequency {
    settings: Settings,
    start_hz: f64,
    frequency_hz: f64,
    amplitude_m: f64,
    wanted_m: f64,
    phase_turns: f64,
    tick: u32,
    state: State,
}

impl FixedFrequency {
    /// Idle; drives at `frequency_hz` and the believed rig's amplitude once started.
    pub fn new(settings: Settings, frequency_hz: f64) -> Self {
        Self {
            settings,
            start_hz: frequency_hz,
            frequency_hz,
            amplitude_m: 0.0,
            wanted_m: 0.0,
            phase_turns: 0.0,
            tick: 0,
            state: State::Idle,
        }
    }

    fn output(&mut self) -> Output {
        let step = self.settings.rig.amplitude_m * TICK_S;
        let change = self.wanted_m - self.amplitude_m;
        self.amplitude_m += change.clamp(-step, step);
        self.phase_turns = (self.phase_turns + self.frequency_hz * TICK_S).fract();
        let enable = matches!(self.state, State::Manual | State::Stop);
        if self.state == State::Stop && self.amplitude_m == 0.0 {
            self.state = State::Idle;
        }
        if !enable {
            return Output::SAFE;
        }
        let metres = self.amplitude_m * (TAU * self.phase_turns).sin();
        let code = 2048.0 + metres / f64::from(self.settings.drive.m_per_code);
        Output {
            dac: DacCode(code.round().clamp(0.0, 4095.0) as u16),
            frequency_hz: self.frequency_hz as f32,
            enable,
        }
    }
}

impl ControlUnderTest for FixedFrequency {
    fn exchange(&mut self, frames: &[Frame], outputs: &mut [Output], _slices: u32) {
        if frames.iter().any(|frame| frame.emergency) && self.state != State::Idle {
            self.state = State::Fault;
            self.amplitude_m = 0.0;
            self.wanted_m = 0.0;
        }
        for output in outputs {
            self.tick = self.tick.wrapping_add(1);
            *output = self.output();
        }
    }

    fn exchange_blind(&mut self, outputs: &mut [Output], slices: u32) {
        self.exchange(&[], outputs, slices);
    }

    fn command(&mut self, command: Command) -> Result<(), Refused> {
        match (command, self.state) {
            (Command::Start(Mode::Automatic | Mode::Manual), State::Idle) => {
                self.state = State::Manual;
                self.wanted_m = self.settings.rig.amplitude_m;
            }
            (Command::Stop, State::Manual) => {
                self.state = State::Stop;
                self.wanted_m = 0.0;
            }
            (Command::ClearFault, State::Fault) => self.state = State::Idle,
            (
                Command::SetPoint {
                    frequency_hz,
                    amplitude_m,
                },
                _,
            ) => {
                self.frequency_hz = f64::from(frequency_hz);
                self.wanted_m = f64::from(amplitude_m);
            }
            (Command::Alive, _) => {}
            _ => return Err(Refused::WrongState),
        }
        Ok(())
    }

    fn status(&mut self) -> Status {
        Status {
            tick: self.tick,
            state: self.state,
            fault: None,
            limits: shared::control::ActiveLimits::NONE,
            frequency_hz: self.frequency_hz as f32,
            amplitude_m: self.amplitude_m as f32,
            measured_amplitude_m: 0.0,
            lag_rad: 0.0,
            regime: Regime::None,
            peak_n: 0.0,
            impulse_n_s: 0.0,
            target_hz: 0.0,
            target_n: 0.0,
            basin: shared::control::Basin::Unknown,
            reseeks: 0,
            overruns: 0,
            events_dropped: 0,
        }
    }

    fn take_event(&mut self) -> Option<Event> {
        None
    }

    fn note_overrun(&mut self) {}

    fn reset(&mut self, _cause: Reset) -> BootInfo {
        *self = Self::new(self.settings, self.start_hz);
        BootInfo::STORED
    }

    fn settings(&self) -> &Settings {
        &self.settings
    }
}
