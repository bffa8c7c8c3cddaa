//! A recording in the page: the log that `host-sim link PORT record` writes, in memory.

use std::path::PathBuf;

use emulator::log::{Header, LogBlock, WriterTo};
use shared::control::BootInfo;
use shared::link::{Hello, RecordedBlock};
use shared::settings::{Settings, TICK_RATE_HZ};

/// Writes what a board streams, from the controller's next restart on: from there a replay can begin.
pub struct StreamRecorder {
    log: Option<WriterTo<Vec<u8>>>,
    /// Tick of the next block; none: the restart has not come yet.
    next: Option<u32>,
    ticks: u64,
    broke: Option<String>,
}

impl StreamRecorder {
    /// Nothing is recorded yet. `made_from` is what it was made from, as JSON.
    ///
    /// # Errors
    /// The log cannot be begun: a fault of the program.
    pub fn new(hello: &Hello, settings: &Settings, made_from: &str) -> Result<Self, String> {
        let header = Header {
            source: hello.board.to_string(),
            settings: *settings,
            birth: BootInfo::STORED,
            block_ticks: u32::from(hello.block_ticks),
            scenario: None,
            made_from: Some(made_from.to_owned()),
        };
        let target = PathBuf::from("the recording");
        let log = WriterTo::over(Vec::new(), target, &header).map_err(|e| e.to_string())?;
        Ok(Self {
            log: Some(log),
            next: None,
            ticks: 0,
            broke: None,
        })
    }

    /// Takes a block. A gap ends the recording where it is: what is behind it could not be replayed.
    pub fn block(&mut self, block: &RecordedBlock) {
        if self.broke.is_some() || (self.next.is_none() && !block.notes.restarted) {
            return;
        }
        let next = self.next.unwrap_or(block.tick);
        if block.tick != next {
            let missing = block.tick.wrapping_sub(next);
            let seconds = self.seconds();
            self.broke = Some(format!(
                "{missing} ticks were lost after {seconds:.1} s, and the recording ends there; it replays up to there"
            ));
            return;
        }
        let count = block.frames.len() as u32;
        if let Some(log) = &mut self.log
            && let Err(error) = log.block(&LogBlock::from(block))
        {
            self.broke = Some(error.to_string());
            return;
        }
        self.next = Some(next.wrapping_add(count));
        self.ticks += u64::from(count);
    }

    /// Length of the recording, s.
    pub fn seconds(&self) -> f64 {
        self.ticks as f64 / f64::from(TICK_RATE_HZ)
    }

    /// Why it goes no further.
    pub fn broke(&self) -> Option<String> {
        self.broke.clone()
    }

    /// The file.
    ///
    /// # Errors
    /// Nothing was recorded, or the log cannot be written.
    pub fn finish(mut self) -> Result<Vec<u8>, String> {
        if self.ticks == 0 {
            return Err(
                "nothing was recorded: the controller has not restarted since; is it in Idle?"
                    .into(),
            );
        }
        let log = self.log.take().ok_or("the recording has ended already")?;
        log.close().map_err(|e| e.to_string())
    }
}
