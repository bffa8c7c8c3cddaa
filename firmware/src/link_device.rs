//! The link's functions on a board: it reaches the controller by short locks, stores settings and reads the
//! forecast.

use rtic::Mutex;
use shared::control::{Command, Refused, Status};
use shared::fault::FaultRecord;
use shared::forecast::Forecast;
use shared::link::{
    Boot, Device, ForecastPage, Hello, Identified, LinkName, PROTOCOL_VERSION, RecordedBlock,
    Refusal,
};
use shared::settings::{Settings, TICK_RATE_HZ};

use crate::BLOCK_TICKS;
use crate::recorder::ControlRecorder;

/// Storage of settings that outlives a reset.
pub trait SettingsStore {
    /// Stores them; returns whether that worked. May block for as long as the flash takes.
    fn store(&mut self, settings: &Settings) -> bool;

    /// Sets the part's brown-out reset to the level that its clock needs; returns whether that worked. May block likewise.
    fn set_brown_out(&mut self) -> bool;
}

/// The board as the link sees it.
pub struct BoardLink<'a, D, F, K> {
    /// The controller with its recording, behind a lock.
    pub recorder: &'a mut D,
    /// The last forecast that is complete.
    pub forecast: &'a mut F,
    /// The storage of the settings.
    pub settings_store: &'a mut K,
    /// The board's name, as the link gives it.
    pub board: &'static str,
    /// A number that no other start is likely to have.
    pub boot: u32,
}

impl<D, F, K> Device for BoardLink<'_, D, F, K>
where
    D: Mutex<T = ControlRecorder>,
    F: Mutex<T = Forecast>,
    K: SettingsStore,
{
    fn hello(&mut self) -> Hello {
        let name = |text| LinkName::try_from(text).unwrap_or_default();
        Hello {
            protocol: PROTOCOL_VERSION,
            firmware: name(env!("CARGO_PKG_VERSION")),
            board: name(self.board),
            tick_rate_hz: TICK_RATE_HZ,
            block_ticks: BLOCK_TICKS as u8,
        }
    }

    fn status(&mut self) -> Status {
        self.recorder
            .lock(|recorder| recorder.controller().status())
    }

    fn command(&mut self, command: Command) -> Result<(), Refused> {
        self.recorder.lock(|recorder| recorder.command(command))
    }

    fn settings(&mut self) -> Settings {
        self.recorder
            .lock(|recorder| *recorder.controller().settings())
    }

    fn replace_settings(&mut self, settings: &Settings) -> Result<(), Refused> {
        self.recorder
            .lock(|recorder| recorder.replace_settings(settings))
    }

    fn store_settings(&mut self) -> Result<(), Refusal> {
        let settings = self.settings();
        if self.settings_store.store(&settings) {
            Ok(())
        } else {
            Err(Refusal::NotStored)
        }
    }

    fn set_brown_out(&mut self) -> Result<(), Refusal> {
        if self.settings_store.set_brown_out() {
            Ok(())
        } else {
            Err(Refusal::NotStored)
        }
    }

    fn forecast(&mut self, page: u8) -> ForecastPage {
        self.forecast
            .lock(|forecast| ForecastPage::of(Some(&*forecast), page))
    }

    fn fault_record(&mut self) -> Option<FaultRecord> {
        self.status().fault
    }

    fn identified(&mut self) -> Identified {
        self.recorder
            .lock(|recorder| Identified::of(recorder.controller().identified()))
    }

    fn record(&mut self, on: bool) -> Result<(), Refusal> {
        self.recorder.lock(|recorder| recorder.record(on));
        Ok(())
    }

    fn take_block(&mut self) -> Option<RecordedBlock> {
        self.recorder.lock(ControlRecorder::take_block)
    }

    fn boot(&mut self) -> Boot {
        let number = self.boot;
        self.recorder.lock(|recorder| Boot {
            number,
            settings: recorder.controller().settings_state(),
            awaits_acknowledgement: recorder.controller().awaits_acknowledgement(),
        })
    }
}
