//! The controller in this process.

use shared::control::{
    BootInfo, Command, Event, Lockstep, Refused, ResetCause, SettingsState, Status, Unfit,
};
use shared::fault::{FaultRecord, Persisted};
use shared::io::{Frame, Output};
use shared::model::params::ParamError;
use shared::settings::Settings;

use super::under_test::{ControlUnderTest, Reset};

/// `shared`'s controller and forecast in lock-step, with the memory that survives a reset.
#[derive(Clone, Debug)]
pub struct Local {
    settings: Settings,
    lockstep: Lockstep,
}

impl Local {
    /// After power-on.
    ///
    /// # Errors
    /// The first setting out of range.
    pub fn new(settings: &Settings) -> Result<Self, ParamError> {
        Ok(Self {
            settings: *settings,
            lockstep: Lockstep::new(settings, &BootInfo::STORED)?,
        })
    }

    /// Controller and forecast, which advance together block by block.
    pub fn lockstep(&self) -> &Lockstep {
        &self.lockstep
    }
}

/// What a controller finds when it starts after `cause`, given the `memory` that survives resets but not power-on.
pub fn birth(cause: Reset, memory: &Persisted) -> BootInfo {
    let power_on = matches!(
        cause,
        Reset::PowerOn | Reset::CorruptSettings | Reset::Unfit
    );
    // A crash writes its record itself, before the program starts anew.
    let left = memory.record().filter(|_| !power_on);
    let record = if cause == Reset::Crash {
        Some(FaultRecord::CRASH.after(left))
    } else {
        left
    };
    BootInfo {
        reset: match cause {
            Reset::PowerOn | Reset::CorruptSettings | Reset::Unfit => ResetCause::PowerOn,
            Reset::Watchdog => ResetCause::Watchdog,
            Reset::BrownOut => ResetCause::BrownOut,
            Reset::WhileDriving => ResetCause::WhileDriving,
            Reset::Crash => ResetCause::Software,
        },
        record,
        settings: if cause == Reset::CorruptSettings {
            SettingsState::Damaged
        } else {
            SettingsState::Stored
        },
        unfit: Unfit::CLOCK.when(cause == Reset::Unfit),
    }
}

impl ControlUnderTest for Local {
    #[inline]
    fn exchange(&mut self, frames: &[Frame], outputs: &mut [Output], slices: u32) {
        self.lockstep.exchange(frames, outputs, slices);
    }

    fn exchange_blind(&mut self, outputs: &mut [Output], slices: u32) {
        self.lockstep.exchange_blind(outputs, slices);
    }

    fn command(&mut self, command: Command) -> Result<(), Refused> {
        self.lockstep.controller.command(command)
    }

    fn status(&mut self) -> Status {
        self.lockstep.controller.status()
    }

    fn take_event(&mut self) -> Option<Event> {
        self.lockstep.controller.take_event()
    }

    fn note_overrun(&mut self) {
        self.lockstep.controller.note_overrun();
    }

    fn reset(&mut self, cause: Reset) -> BootInfo {
        let birth = birth(cause, &self.lockstep.controller.persisted());
        // The settings were good at the first birth.
        if let Ok(anew) = Lockstep::new(&self.settings, &birth) {
            self.lockstep = anew;
        }
        birth
    }

    fn settings(&self) -> &Settings {
        &self.settings
    }
}
