//! The controller itself.

use super::basin::BasinTracker;
use super::block_health::BlockHealth;
use super::event::{Event, EventKind};
use super::force::ForceLoop;
use super::forecast_cache::ForecastCache;
use super::guard::{SampleGuard, Trip};
use super::lifetime::{Faults, Lifetime};
use super::limits::LimitReport;
use super::off_watch::OffWatch;
use super::oscillator::DriveOscillator;
use super::phase::Phase;
use super::plausibility::Plausibility;
use super::rig_estimate::RigEstimate;
use super::trim::Trim;
use super::{BootInfo, Command, Refused, SettingsState, State, Status};
use crate::fault::{Fault, FaultRecord, Persisted};
use crate::forecast::{Forecast, ForecastRequest};
use crate::io::{Frame, Output};
use crate::model::drive::Drive;
use crate::model::params::{ParamError, RigParams};
use crate::model::regime::Regime;
use crate::sense::identification::Identification;
use crate::sense::{Sense, Strobe};
use crate::settings::Settings;

/// The controller: what runs at control priority, a block of samples at a time.
#[derive(Clone, Debug)]
pub struct Controller {
    /// What outlives a replacement of the settings; all below is made from them.
    pub(super) life: Lifetime,
    pub(super) settings: Settings,
    pub(super) oscillator: DriveOscillator,
    /// The drive as it was when the block that is now sampled was put out.
    pub(super) sensed_drive: Drive<f32>,
    pub(super) sense: Sense,
    pub(super) guard: SampleGuard,
    pub(super) plausibility: Plausibility,
    pub(super) trim: Trim,
    pub(super) force: ForceLoop,
    pub(super) rig: RigEstimate,
    pub(super) forecast: ForecastCache,
    pub(super) blocks: BlockHealth,
    pub(super) seen: LastSamples,
    pub(super) limits: LimitReport,
    pub(super) off_watch: OffWatch,
}

/// What the samples have shown last.
#[derive(Clone, Copy, Debug)]
pub(super) struct LastSamples {
    pub strobe: Option<Strobe>,
    pub regime: Regime,
    pub basin: BasinTracker,
    /// Whether a contact was under way in the last tick.
    pub in_contact: bool,
    /// Ticks since the last contact in which the hammer had to strike.
    pub ticks_without_contact: u32,
    /// Whether the frequency stood at its goal at the last strobe.
    pub arrived: bool,
    /// Drive phase of the last onset, turns.
    pub onset_turns: f32,
    /// Whether the last contact seemed stronger than the trip level.
    pub too_strong: bool,
    /// Command at the last strobe, m.
    pub command_m: f32,
    /// Furthest the cart was from its middle in this half of the drive period, m.
    pub cart_peak_m: f32,
    /// Sum and number of the force's samples outside contacts in this drive period, N.
    pub free_force: (f32, u32),
    /// Which half that is.
    pub half: u32,
    /// Drive periods in a row with a motor drive beyond a limit.
    pub beyond: u8,
    /// Drive periods in a row with one contact each.
    pub clean: u8,
}

impl LastSamples {
    const NOTHING: Self = Self {
        strobe: None,
        regime: Regime::None,
        basin: BasinTracker::NEW,
        in_contact: false,
        ticks_without_contact: 0,
        arrived: false,
        onset_turns: 0.0,
        too_strong: false,
        command_m: 0.0,
        cart_peak_m: 0.0,
        free_force: (0.0, 0),
        half: 0,
        beyond: 0,
        clean: 0,
    };
}

impl Controller {
    /// A controller with `settings`, drive off.
    ///
    /// # Errors
    /// If a setting is out of range: the first such.
    pub fn new(settings: &Settings, boot: &BootInfo) -> Result<Self, ParamError> {
        let oscillator = oscillator_of(settings)?;
        let mut controller = Self::with(settings, oscillator, Lifetime::default());
        controller.life.faults = Faults::at_boot(boot);
        controller.life.operator.settings = boot.settings;
        controller.request_forecast();
        controller.report_boot(boot);
        Ok(controller)
    }

    /// A controller with settings that were checked, nothing requested.
    fn with(settings: &Settings, oscillator: DriveOscillator, life: Lifetime) -> Self {
        Self {
            life,
            settings: *settings,
            sensed_drive: *oscillator.drive(),
            oscillator,
            sense: Sense::new(settings),
            guard: SampleGuard::new(settings),
            plausibility: Plausibility::new(settings),
            trim: Trim::new(settings),
            force: ForceLoop::of(settings),
            rig: RigEstimate::new(settings),
            forecast: ForecastCache::default(),
            blocks: BlockHealth::default(),
            seen: LastSamples::NOTHING,
            limits: LimitReport::default(),
            off_watch: OffWatch::new(settings),
        }
    }

    /// Adds the fault that the start itself is to the episode that was before it, or reports that episode.
    fn report_boot(&mut self, boot: &BootInfo) {
        // An emergency stop that was not acknowledged before the reset must be after it.
        if boot
            .record
            .is_some_and(|record| record.episode.contains(Fault::EmergencyStop))
        {
            let required = self.settings.operator.acknowledge;
            self.life.operator.emergency(self.life.tick, required);
        }
        if let Some(fault) = Faults::of_boot(boot) {
            // An episode that does not latch has ended with the reset.
            if !boot.record.is_some_and(|record| record.latches()) {
                self.life.faults.clear();
            }
            self.note(Trip::system(fault, 0.0));
        } else if let Some(record) = boot.record {
            self.life.push(EventKind::Fault(record));
        }
        if !boot.unfit.is_none() {
            let value = f32::from(boot.unfit.bits());
            self.note(Trip::system(Fault::BoardUnfit, value));
        }
        if self.life.faults.record.is_some_and(|r| r.latches()) {
            self.change(Phase::Fault);
        }
    }

    /// A block of samples, in ticks' order, against the set-points of the next block. Frames and outputs are
    /// paired; of unequal numbers the shorter counts. Whatever trips in a sample of this block, every
    /// set-point of the next is safe.
    pub fn block(&mut self, frames: &[Frame], outputs: &mut [Output]) {
        self.blocks.samples_arrived();
        self.life.faults.block_begins();
        for (frame, _) in frames.iter().zip(outputs.iter()) {
            self.pass_tick();
            self.sample(frame);
        }
        // What moved with the drive off has gone only once it was seen to stand still, through a reset and new settings.
        let moved = (self.life.faults.record).is_some_and(|r| r.episode.contains(Fault::NotOff));
        let still = self.off_watch.is_still() || !(moved || self.off_watch.is_moving());
        self.life.faults.block_ends(self.guard.is_quiet() && still);
        self.supervise(outputs.len());
        self.put_out(outputs);
    }

    /// A block whose samples did not arrive: the set-points go on until that trips.
    pub fn blind_block(&mut self, outputs: &mut [Output]) {
        self.life.faults.block_begins();
        self.life.faults.block_was_blind();
        for _ in outputs.iter() {
            self.pass_tick();
        }
        if let Some(count) = self.blocks.samples_missing() {
            self.trip(Trip::system(Fault::StaleSamples, f32::from(count)));
        }
        self.supervise(outputs.len());
        self.put_out(outputs);
    }

    /// The control task ended after the next block was due.
    pub fn note_overrun(&mut self) {
        self.life.overruns = self.life.overruns.saturating_add(1);
        if self.blocks.overran() {
            self.trip(Trip::system(Fault::Overrun, self.life.overruns as f32));
        }
    }

    fn pass_tick(&mut self) {
        self.life.tick = self.life.tick.wrapping_add(1);
        self.sensed_drive.advance();
    }

    /// Carries out a command.
    ///
    /// # Errors
    /// If the command is refused in this state, or has a number that is not finite ([`Refused`]).
    pub fn command(&mut self, command: Command) -> Result<(), Refused> {
        match command {
            Command::Start(mode) => self.start(mode),
            Command::Stop => self.stop(),
            Command::ClearFault => self.clear_fault(),
            Command::SetPoint {
                frequency_hz,
                amplitude_m,
            } => self.set_point(frequency_hz, amplitude_m),
            Command::Alive => {
                self.alive();
                Ok(())
            }
            Command::Acknowledge { opened } => {
                self.life.operator.acknowledge(self.life.tick, opened)
            }
            Command::ConfirmSettings => self.confirm_settings(),
        }
    }

    /// Replaces the settings as a whole, in Idle (or after a fault, which stays). Everything made from the old ones
    /// is lost; time, events, counts, the link and the fault go on. After damaged settings, only this lets the
    /// fault be cleared.
    ///
    /// # Errors
    /// If the controller is in any other state, or a setting is out of range.
    pub fn replace_settings(&mut self, settings: &Settings) -> Result<(), Refused> {
        if !matches!(self.state(), State::Idle | State::Fault) {
            return Err(Refused::WrongState);
        }
        let oscillator = oscillator_of(settings).map_err(|_| Refused::BadSettings)?;
        let life = core::mem::take(&mut self.life);
        *self = Self::with(settings, oscillator, life);
        self.settings_came();
        self.request_forecast();
        Ok(())
    }

    /// The settings in force.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// The rig that forecasts are made of.
    pub fn believed(&self) -> &RigParams {
        self.rig.rig()
    }

    /// The online identification: what contacts and flights have shown of the rig so far.
    pub fn identified(&self) -> &Identification {
        &self.rig.identification
    }

    /// The forecast request, if one waits; each is given once.
    pub fn forecast_request(&mut self) -> Option<ForecastRequest> {
        self.forecast.take_request()
    }

    /// Takes in a forecast; one that was not requested last is ignored.
    pub fn deliver(&mut self, forecast: &Forecast) {
        if !self.forecast.take_in(forecast, self.rig.rig()) {
            return;
        }
        let (target_hz, force_n) = self.forecast.target_point();
        self.life.push(EventKind::Forecast { target_hz, force_n });
        let range_hz = self.range_hz();
        if let (Some(search), Some(target)) =
            (self.life.phase.search_mut(), self.forecast.entered_target())
        {
            search.retarget(&target, range_hz);
            self.oscillator.aim(search.goal_hz());
        }
    }

    /// The present or last fault.
    #[inline]
    pub fn fault(&self) -> Option<&FaultRecord> {
        self.life.faults.record.as_ref()
    }

    /// Where the settings come from.
    pub fn settings_state(&self) -> SettingsState {
        self.life.operator.settings
    }

    /// Whether an emergency stop must be acknowledged at the board before the fault can be cleared.
    pub fn awaits_acknowledgement(&self) -> bool {
        self.life.operator.is_awaited()
    }

    /// The state as reported.
    pub fn status(&self) -> Status {
        let last = self.seen.strobe.unwrap_or_default();
        let (target_hz, target_n) = self.forecast.target_point();
        Status {
            tick: self.life.tick,
            state: self.state(),
            fault: self.life.faults.record,
            limits: self.limits.active,
            frequency_hz: self.oscillator.frequency_hz(),
            amplitude_m: self.oscillator.amplitude_m(),
            measured_amplitude_m: last.amplitude_m,
            lag_rad: last.lag_rad,
            regime: self.seen.regime,
            peak_n: last.peak_n,
            impulse_n_s: last.impulse_n_s,
            target_hz,
            target_n,
            basin: self.seen.basin.basin(),
            reseeks: self.life.reseeks,
            overruns: self.life.overruns,
            events_dropped: self.life.events.dropped(),
        }
    }

    /// What the controller is doing.
    pub fn state(&self) -> State {
        self.life.phase.state()
    }

    /// The fault record as it is to lie in memory that survives a reset.
    pub fn persisted(&self) -> Persisted {
        let record = self.life.faults.record;
        record.map_or(Persisted::EMPTY, |record| Persisted::new(&record))
    }

    /// The oldest event not yet taken.
    pub fn take_event(&mut self) -> Option<Event> {
        self.life.events.take()
    }

    pub(super) fn put_out(&mut self, outputs: &mut [Output]) {
        self.oscillator.slew(outputs.len());
        self.sensed_drive = *self.oscillator.drive();
        let driving = self.life.phase.is_driving();
        for output in outputs {
            let next = self.oscillator.next();
            *output = if driving { next } else { Output::SAFE };
        }
    }

    pub(super) fn wanted_amplitude_m(&self) -> f32 {
        self.settings.rig.amplitude_m as f32
    }

    /// The amplitude that the present motion is to reach, m.
    pub(super) fn full_amplitude_m(&self) -> f32 {
        match &self.life.phase {
            Phase::Prove(proof) => proof.amplitude_m(),
            _ => self.wanted_amplitude_m(),
        }
    }

    pub(super) fn range_hz(&self) -> (f32, f32) {
        let limits = &self.settings.limits;
        (limits.min_frequency_hz, limits.max_frequency_hz)
    }

    /// Requests a forecast of the believed rig.
    pub(super) fn request_forecast(&mut self) {
        let id = self.life.forecast_id();
        self.forecast.request(id, self.rig.rig(), self.range_hz());
    }
}

/// The oscillator of settings, which are checked.
fn oscillator_of(settings: &Settings) -> Result<DriveOscillator, ParamError> {
    settings.check()?;
    DriveOscillator::new(&settings.drive, start_frequency(settings)).map_err(|_| ParamError {
        key: "limits.max_frequency_hz",
        value: f64::from(settings.limits.max_frequency_hz),
        must_be: "a frequency the control tick can make",
    })
}

/// Where the frequency stands before there is a forecast: at the natural frequency, within the limits.
pub(super) fn start_frequency(settings: &Settings) -> f32 {
    let limits = &settings.limits;
    (settings.rig.natural_frequency_hz() as f32)
        .max(limits.min_frequency_hz)
        .min(limits.max_frequency_hz)
}

#[cfg(test)]
mod tests;
