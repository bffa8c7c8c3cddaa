//! The controller itself.

use super::event::{Event, EventKind, Events};
use super::forecast_cache::ForecastCache;
use super::free::FreeSwing;
use super::guard::{Guard, Trip};
use super::oscillator::Oscillator;
use super::plausibility::Plausibility;
use super::search::Search;
use super::self_test::SelfTest;
use super::trim::Trim;
use super::{ActiveLimits, Basin, BootInfo, Command, Mode, Refused, ResetCause, State, Status};
use crate::fault::{Fault, Persisted, Record};
use crate::forecast::{Forecast, ForecastRequest, MAX_ROWS, Row};
use crate::io::{Frame, Output};
use crate::model::drive::Drive;
use crate::model::params::{ParamError, RigParams};
use crate::model::regime::Regime;
use crate::sense::identification::Identification;
use crate::sense::{Sense, Strobe};
use crate::settings::{Settings, TICK_RATE_HZ};

/// Range of a forecast in natural frequencies: from below where 1/1 begins to above where it doubles, at
/// every gap of the chapter's map.
const FORECAST_RANGE: (f32, f32) = (0.8, 3.0);
/// A spoilt block (overrun, missing samples) adds this to its count; a good one takes one off.
const SPOILT_WEIGHT: u8 = 4;
/// At this many the fault trips: three in a row, or more than one in five.
const SPOILT_AT: u8 = 10;

/// The controller: what runs at control priority, a block of samples at a time.
#[derive(Clone, Debug)]
pub struct Controller {
    pub(super) settings: Settings,
    /// The rig as the pulses and swings say it is; what forecasts are made of.
    pub(super) believed: RigParams,
    pub(super) tick: u32,
    pub(super) state: State,
    pub(super) mode: Mode,
    pub(super) oscillator: Oscillator,
    /// The drive as it was when the block that is now sampled was put out.
    pub(super) sensed_drive: Drive<f32>,
    pub(super) sense: Sense,
    pub(super) identification: Identification,
    pub(super) guard: Guard,
    pub(super) plausibility: Plausibility,
    pub(super) trim: Trim,
    pub(super) self_test: SelfTest,
    pub(super) search: Option<Search>,
    pub(super) forecast: ForecastCache,
    pub(super) timers: Timers,
    pub(super) record: Option<Record>,
    /// Damaged settings were found, and none have been sent since: defaults stand in, fit for no rig.
    pub(super) settings_corrupt: bool,
    /// A condition that trips was there in the last block.
    pub(super) condition: Option<Fault>,
    pub(super) events: Events,
    pub(super) last: Option<Strobe>,
    /// Whether the contact under way has been noted.
    pub(super) touched: bool,
    pub(super) arrived: bool,
    /// The regime last told.
    pub(super) regime: Regime,
    pub(super) basin: Basin,
    pub(super) striking: u8,
    pub(super) silent: u8,
    pub(super) limits: ActiveLimits,
    /// Limits as last told in an event.
    pub(super) told_limits: ActiveLimits,
    pub(super) reseeks: u16,
    pub(super) overruns: u32,
}

/// Ticks since something last happened, and leaky counts.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Timers {
    pub since_contact: u32,
    pub since_one_one: u32,
    pub since_alive: u32,
    pub remote: bool,
    pub overruns: u8,
    pub stale: u8,
    pub good_periods: u8,
    pub in_state: u32,
    pub identification: u16,
}

pub(super) fn ticks_of(seconds: f32) -> u32 {
    (seconds * TICK_RATE_HZ as f32) as u32
}

impl Controller {
    /// A controller with `settings`, drive off.
    ///
    /// # Errors
    /// The first setting out of range.
    pub fn new(settings: &Settings, boot: &BootInfo) -> Result<Self, ParamError> {
        settings.check()?;
        let start_hz = start_frequency(settings);
        let oscillator = Oscillator::new(&settings.drive, start_hz).map_err(|_| ParamError {
            key: "limits.max_frequency_hz",
            value: f64::from(settings.limits.max_frequency_hz),
            must_be: "a frequency the control tick can make",
        })?;
        let mut controller = Self {
            settings: *settings,
            believed: settings.rig,
            tick: 0,
            state: State::Idle,
            mode: Mode::Automatic,
            sensed_drive: *oscillator.drive(),
            oscillator,
            sense: Sense::new(settings),
            identification: Identification::new(settings),
            guard: Guard::new(settings),
            plausibility: Plausibility::new(settings),
            trim: Trim::new(settings),
            self_test: SelfTest::new(settings),
            search: None,
            forecast: ForecastCache::default(),
            timers: Timers::default(),
            record: boot.record,
            settings_corrupt: boot.settings_corrupt,
            condition: None,
            events: Events::default(),
            last: None,
            touched: false,
            arrived: false,
            regime: Regime::None,
            basin: Basin::Unknown,
            striking: 0,
            silent: 0,
            limits: ActiveLimits::NONE,
            told_limits: ActiveLimits::NONE,
            reseeks: 0,
            overruns: 0,
        };
        controller.request_forecast();
        controller.take_boot_info(boot);
        Ok(controller)
    }

    /// Takes account of why the board started.
    fn take_boot_info(&mut self, boot: &BootInfo) {
        let found = match boot.reset {
            _ if boot.settings_corrupt => Some(Fault::CorruptSettings),
            ResetCause::Watchdog => Some(Fault::WatchdogReset),
            ResetCause::BrownOut => Some(Fault::BrownOut),
            _ => None,
        };
        if let Some(fault) = found {
            let before = boot.record.map_or(0, |record| record.fault.code());
            self.note(Trip::system(fault, f32::from(before)));
        } else if let Some(record) = boot.record {
            self.events.push(0, EventKind::Fault(record));
        }
        if self.record.is_some_and(|record| record.fault.latches()) {
            self.change(State::Fault);
        }
    }

    /// A block of samples, in ticks' order, against the set-points of the next block. Frames and outputs are
    /// paired; of unequal numbers the shorter counts. Whatever trips in a sample of this block, every
    /// set-point of the next is safe.
    pub fn block(&mut self, frames: &[Frame], outputs: &mut [Output]) {
        self.timers.stale = self.timers.stale.saturating_sub(1);
        self.condition = None;
        for (frame, _) in frames.iter().zip(outputs.iter()) {
            self.tick = self.tick.wrapping_add(1);
            self.sensed_drive.advance();
            self.sample(frame);
        }
        self.supervise(outputs.len());
        self.put_out(outputs);
    }

    /// A block whose samples did not arrive: the set-points go on, until it is too long.
    pub fn blind_block(&mut self, outputs: &mut [Output]) {
        for _ in outputs.iter() {
            self.tick = self.tick.wrapping_add(1);
            self.sensed_drive.advance();
        }
        self.timers.stale = self.timers.stale.saturating_add(SPOILT_WEIGHT);
        if self.timers.stale >= SPOILT_AT {
            self.trip(Trip::system(
                Fault::StaleSamples,
                f32::from(self.timers.stale),
            ));
        }
        self.supervise(outputs.len());
        self.put_out(outputs);
    }

    /// The control task ended after the next was due.
    pub fn note_overrun(&mut self) {
        self.overruns = self.overruns.saturating_add(1);
        self.timers.overruns = self.timers.overruns.saturating_add(SPOILT_WEIGHT + 1);
        if self.timers.overruns >= SPOILT_AT + 2 {
            self.trip(Trip::system(Fault::Overrun, self.overruns as f32));
        }
    }

    /// Obeys a command, or says why not.
    ///
    /// # Errors
    /// See [`Refused`].
    pub fn command(&mut self, command: Command) -> Result<(), Refused> {
        match command {
            Command::Start(mode) => {
                if self.state != State::Idle {
                    return Err(Refused::WrongState);
                }
                self.start(mode);
            }
            Command::Stop => {
                self.timers.remote = false;
                match self.state {
                    State::Fault => return Err(Refused::WrongState),
                    State::Idle | State::Stop => {}
                    State::SelfTest => self.change(State::Idle),
                    _ => self.stop(),
                }
            }
            Command::ClearFault => {
                if self.state != State::Fault {
                    return Err(Refused::WrongState);
                }
                if self.condition.is_some() || self.settings_corrupt {
                    return Err(Refused::StillFaulty);
                }
                self.clear();
            }
            Command::SetPoint {
                frequency_hz,
                amplitude_m,
            } => self.set_point(frequency_hz, amplitude_m)?,
            Command::Alive => self.alive(),
        }
        Ok(())
    }

    /// Swaps the settings as a whole, in Idle (or after a fault, which stays); what was in force is lost. After
    /// damaged settings, only this lets the fault be cleared.
    ///
    /// # Errors
    /// In any other state; settings out of range.
    pub fn replace_settings(&mut self, settings: &Settings) -> Result<(), Refused> {
        if !matches!(self.state, State::Idle | State::Fault) {
            return Err(Refused::WrongState);
        }
        let fresh = Self::new(settings, &BootInfo::default()).map_err(|_| Refused::BadSettings)?;
        let next_id = self.forecast.next_id;
        let kept = (
            self.tick,
            self.state,
            self.record,
            self.reseeks,
            self.overruns,
            self.timers.remote,
        );
        let events = core::mem::take(&mut self.events);
        *self = fresh;
        (
            self.tick,
            self.state,
            self.record,
            self.reseeks,
            self.overruns,
            self.timers.remote,
        ) = kept;
        self.events = events;
        self.forecast.next_id = next_id;
        self.request_forecast();
        Ok(())
    }

    /// The settings in force.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// The rig as it is believed to be by now.
    pub fn believed(&self) -> &RigParams {
        &self.believed
    }

    /// What the rig's own pulses and swings have told.
    pub fn identified(&self) -> &Identification {
        &self.identification
    }

    /// A forecast that is wanted; each is given once.
    pub fn forecast_request(&mut self) -> Option<ForecastRequest> {
        self.forecast.wanted.take()
    }

    /// Takes in a forecast; one that was not asked for last is ignored.
    pub fn deliver(&mut self, forecast: &Forecast) {
        if self.forecast.awaited != Some(forecast.id) {
            return;
        }
        self.forecast.awaited = None;
        self.forecast.come = true;
        self.forecast.target = forecast.target;
        self.forecast.strikes.clear();
        for row in &forecast.rows {
            let Row {
                frequency_hz,
                regime,
                ..
            } = *row;
            // As many rows as fit: both have room for the same number.
            let _ = self
                .forecast
                .strikes
                .push((frequency_hz, regime != Regime::None));
        }
        let (target_hz, force_n) = forecast
            .target
            .map_or((0.0, 0.0), |t| (t.frequency_hz, t.orbit.force_n));
        self.events
            .push(self.tick, EventKind::Forecast { target_hz, force_n });
        let range_hz = self.range_hz();
        self.forecast.free = FreeSwing::new(&self.believed);
        if let (Some(search), Some(target)) = (&mut self.search, &forecast.target) {
            search.retarget(&self.forecast.entered(target), range_hz);
            self.oscillator.aim(search.goal_hz());
        }
    }

    /// Everything worth reporting.
    pub fn status(&self) -> Status {
        let last = self.last.unwrap_or_default();
        let target = self.forecast.target;
        Status {
            tick: self.tick,
            state: self.state,
            fault: self.record,
            limits: self.limits,
            frequency_hz: self.oscillator.frequency_hz(),
            amplitude_m: self.oscillator.amplitude_m(),
            measured_amplitude_m: last.amplitude_m,
            lag_rad: last.lag_rad,
            regime: self.regime,
            peak_n: last.peak_n,
            impulse_n_s: last.impulse_n_s,
            target_hz: target.map_or(0.0, |t| t.frequency_hz),
            target_n: target.map_or(0.0, |t| t.orbit.force_n),
            basin: self.basin,
            reseeks: self.reseeks,
            overruns: self.overruns,
        }
    }

    /// What the controller is doing.
    pub fn state(&self) -> State {
        self.state
    }

    /// The fault record as it is to lie in memory that survives a reset.
    pub fn persisted(&self) -> Persisted {
        self.record
            .map_or(Persisted::EMPTY, |record| Persisted::new(&record))
    }

    /// The oldest event not yet taken.
    pub fn take_event(&mut self) -> Option<Event> {
        self.events.take()
    }

    pub(super) fn put_out(&mut self, outputs: &mut [Output]) {
        self.oscillator.slew(outputs.len());
        self.sensed_drive = *self.oscillator.drive();
        let driving = self.is_driving();
        for output in outputs {
            let next = self.oscillator.next();
            *output = if driving { next } else { Output::SAFE };
        }
    }

    /// Whether the drive is enabled in the state.
    pub(super) fn is_driving(&self) -> bool {
        matches!(
            self.state,
            State::Ramp | State::Seek | State::Hold | State::Stop | State::Manual
        )
    }

    pub(super) fn wanted_amplitude_m(&self) -> f32 {
        self.settings.rig.amplitude_m as f32
    }

    pub(super) fn range_hz(&self) -> (f32, f32) {
        let limits = &self.settings.limits;
        (limits.min_frequency_hz, limits.max_frequency_hz)
    }

    /// Wants a forecast of the rig as it is believed to be.
    pub(super) fn request_forecast(&mut self) {
        let natural_hz = self.believed.natural_frequency_hz() as f32;
        let (low, high) = self.range_hz();
        let from = (FORECAST_RANGE.0 * natural_hz).max(low);
        let to = (FORECAST_RANGE.1 * natural_hz).min(high).max(from);
        let id = self.forecast.next_id;
        self.forecast.next_id = id.wrapping_add(1);
        self.forecast.awaited = Some(id);
        self.forecast.wanted = Some(ForecastRequest {
            id,
            rig: self.believed,
            range_hz: (from, to),
            rows: MAX_ROWS as u8,
        });
    }
}

/// Where the frequency stands before there is a forecast: at the natural frequency, within the limits.
fn start_frequency(settings: &Settings) -> f32 {
    let limits = &settings.limits;
    (settings.rig.natural_frequency_hz() as f32)
        .max(limits.min_frequency_hz)
        .min(limits.max_frequency_hz)
}
