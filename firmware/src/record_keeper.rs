//! The fault's record goes to memory that survives a reset in the block that trips.

use shared::fault::FaultRecord;

/// Notices that the record has changed.
#[derive(Clone, Copy, Debug, Default)]
pub struct RecordKeeper {
    kept: Option<FaultRecord>,
}

impl RecordKeeper {
    /// A keeper for memory that holds `kept`.
    pub fn new(kept: Option<FaultRecord>) -> Self {
        Self { kept }
    }

    /// To be called after each block, with the drive off if the block has tripped: has `keep` write the record if it is
    /// another than was written last.
    #[inline]
    pub fn after_block(
        &mut self,
        record: Option<&FaultRecord>,
        keep: impl FnOnce(Option<&FaultRecord>),
    ) {
        if self.kept.as_ref() != record {
            keep(record);
            self.kept = record.copied();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::BLOCK_TICKS;
    use crate::recorder::ControlRecorder;
    use shared::control::{BootInfo, Command, Controller, State};
    use shared::fault::{Fault, Persisted};
    use shared::io::{AdcCode, Frame, Output};
    use shared::model::params::WIRES;
    use shared::settings::Settings;

    /// The board's memory that survives, and what is sampled.
    struct Board {
        recorder: ControlRecorder,
        keeper: RecordKeeper,
        memory: Persisted,
        writes: u32,
    }

    impl Board {
        fn started(memory: Persisted) -> Self {
            let boot = BootInfo {
                record: memory.record(),
                ..BootInfo::STORED
            };
            let controller = Controller::new(&Settings::for_rig(&WIRES), &boot).unwrap();
            Self {
                recorder: ControlRecorder::new(controller),
                keeper: RecordKeeper::new(memory.record()),
                memory,
                writes: 0,
            }
        }

        /// A block as the control task runs it.
        fn block(&mut self, emergency: bool) {
            let frame = Frame {
                force: AdcCode(600),
                hammer: AdcCode(2048),
                cart: AdcCode(2048),
                emergency,
            };
            let mut outputs = [Output::SAFE; BLOCK_TICKS];
            self.recorder
                .block(Some(&[frame; BLOCK_TICKS]), &mut outputs);
            let record = self.recorder.controller().fault();
            let (memory, writes) = (&mut self.memory, &mut self.writes);
            self.keeper.after_block(record, |record| {
                *memory = record.map_or(Persisted::EMPTY, Persisted::new);
                *writes += 1;
            });
        }
    }

    #[test]
    fn a_reset_right_after_the_block_that_trips_finds_the_fault() {
        let mut board = Board::started(Persisted::EMPTY);
        board.block(false);
        board.block(true);
        // The reset comes before the next block.
        let record = board.memory.record().expect("a record");
        assert_eq!(record.fault, Fault::EmergencyStop);
        let mut again = Board::started(board.memory);
        assert_eq!(again.recorder.controller().state(), State::Fault);
        // What is there already is not written again; what is cleared is gone with the next block.
        again.block(false);
        assert_eq!((again.writes, again.memory), (0, board.memory));
        assert_eq!(again.recorder.command(Command::ClearFault), Ok(()));
        again.block(false);
        assert_eq!((again.writes, again.memory.record()), (1, None));
    }
}
