//! A block as a board records it, as a block of a log.

use shared::link::RecordedBlock;

use super::{LogBlock, LogInput, LogTick, Samples};

impl From<&RecordedBlock> for LogBlock {
    fn from(exchange: &RecordedBlock) -> Self {
        let notes = &exchange.notes;
        // A command that was refused changed nothing.
        let obeyed = notes.given.iter().filter(|given| given.refused.is_none());
        let commands = obeyed.map(|given| LogInput::Command(given.command));
        let overrun = notes.overrun.then_some(LogInput::Overrun);
        let pairs = exchange.frames.iter().zip(&exchange.outputs);
        Self {
            inputs: commands.chain(overrun).collect(),
            samples: if notes.stale {
                Samples::Blind
            } else {
                Samples::Came
            },
            forecast: Some(notes.forecast_delivered),
            slices: None,
            ticks: pairs
                .map(|(frame, output)| LogTick {
                    frame: *frame,
                    output: *output,
                    truth: None,
                })
                .collect(),
            status: None,
            state: Some(notes.state),
        }
    }
}
