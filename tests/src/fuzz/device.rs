//! A board without a controller behind it.

use shared::control::{BootInfo, Command, Controller, Refused, Status};
use shared::fault::FaultRecord;
use shared::forecast::{Forecast, ForecastRow};
use shared::link::{
    Boot, Device, ForecastPage, Hello, Identified, LinkName, PROTOCOL_VERSION, RecordedBlock,
    Refusal,
};
use shared::model::params::WIRES;
use shared::model::regime::Regime;
use shared::settings::Settings;

/// Obeys everything and remembers the settings.
#[derive(Debug)]
pub struct Bench {
    status: Status,
    settings: Settings,
    recording: bool,
}

impl Bench {
    /// A board just started.
    pub fn new() -> Self {
        let settings = Settings::for_rig(&WIRES);
        let controller = Controller::new(&settings, &BootInfo::STORED);
        Self {
            status: controller.expect("good settings").status(),
            settings,
            recording: false,
        }
    }
}

impl Device for Bench {
    fn hello(&mut self) -> Hello {
        Hello {
            protocol: PROTOCOL_VERSION,
            firmware: LinkName::new(),
            board: LinkName::new(),
            tick_rate_hz: 20_000,
            block_ticks: 10,
        }
    }
    fn status(&mut self) -> Status {
        // Each look is a block.
        self.status.tick = self.status.tick.wrapping_add(10);
        self.status
    }
    fn command(&mut self, _command: Command) -> Result<(), Refused> {
        Ok(())
    }
    fn settings(&mut self) -> Settings {
        self.settings
    }
    fn replace_settings(&mut self, settings: &Settings) -> Result<(), Refused> {
        assert!(settings.check().is_ok(), "unchecked settings got through");
        self.settings = *settings;
        Ok(())
    }
    fn store_settings(&mut self) -> Result<(), Refusal> {
        Ok(())
    }
    fn forecast(&mut self, page: u8) -> ForecastPage {
        let row = ForecastRow {
            frequency_hz: 3.0,
            regime: Regime::None,
            force_n: 0.0,
            orbit: None,
        };
        let forecast = Forecast {
            id: 1,
            rows: [row; 40].into_iter().collect(),
            target: None,
        };
        ForecastPage::of(Some(&forecast), page)
    }
    fn fault_record(&mut self) -> Option<FaultRecord> {
        None
    }
    fn identified(&mut self) -> Identified {
        Identified::default()
    }
    fn record(&mut self, on: bool) -> Result<(), Refusal> {
        self.recording = on;
        Ok(())
    }
    fn take_block(&mut self) -> Option<RecordedBlock> {
        assert!(self.recording, "blocks are taken only while recording");
        Some(RecordedBlock::default())
    }
    fn boot(&mut self) -> Boot {
        Boot::default()
    }
}
