//! A log through the desktop's controller: the same decisions, bit for bit, or the first tick that differs.
//!
//! The controller starts as the log says and gets the recorded inputs and samples.
//! Every set-point and every logged part of its status must come out again. In lock-step the forecast runs
//! as many slices as it did; of a real board only the blocks before which a forecast was finished are known,
//! so here it is run to its end for exactly those.

use shared::control::{BootInfo, Lockstep};
use shared::io::Output;
use shared::settings::Settings;

use crate::progress::ProgressLine;
use emulator::log::{LogInput, LogReader, Logged, Samples, StatusCell, cells, names};
use files::UserError;

/// What a replay came to.
#[derive(Clone, Debug, PartialEq)]
pub struct Replayed {
    /// Ticks replayed, up to and with the one that differs.
    pub ticks: u64,
    /// The first difference from the log; none: every decision is the same.
    pub difference: Option<ReplayDifference>,
}

/// The first difference between a log and its replay.
#[derive(Clone, Debug, PartialEq)]
pub struct ReplayDifference {
    /// Ticks since the log's start; for a part of the status, the last tick of its block.
    pub tick: u64,
    /// What differs, as the log's column is called.
    pub what: &'static str,
    /// The value in the log.
    pub recorded: String,
    /// As it is here.
    pub here: String,
}

/// Replays a log to its end or to the first difference.
///
/// # Errors
/// One line when the log is damaged, or no controller can be made with its settings.
pub fn replay(log: &mut LogReader, progress: &ProgressLine) -> Result<Replayed, UserError> {
    let header = log.header().clone();
    let mut twin = started(&header.settings, &header.birth)?;
    let mut next = log.block()?;
    let mut ticks = 0;
    while let Some(block) = next {
        next = log.block()?;
        // A forecast that is delivered before the next block is finished after this one.
        let then = next.as_ref().and_then(|block| block.forecast);
        let slices = match (block.slices, then) {
            (Some(slices), _) => slices,
            (None, Some(true)) => u32::MAX,
            (None, _) => 0,
        };
        give(&mut twin, &block.inputs)?;
        let outputs = run(&mut twin, &block, slices);
        progress.inc(block.ticks.len() as u64);
        if let Some(difference) = differs(&block, outputs.as_deref(), &twin) {
            return Ok(Replayed {
                ticks: difference.tick + 1,
                difference: Some(difference),
            });
        }
        ticks = block.first_tick + block.ticks.len() as u64;
    }
    Ok(Replayed {
        ticks,
        difference: None,
    })
}

fn started(settings: &Settings, birth: &BootInfo) -> Result<Lockstep, UserError> {
    Lockstep::new(settings, birth).map_err(|e| UserError::from(e).at("the log's settings"))
}

fn give(twin: &mut Lockstep, inputs: &[LogInput]) -> Result<(), UserError> {
    for input in inputs {
        // What was refused then is refused again.
        match input {
            LogInput::Command(command) => drop(twin.controller.command(*command)),
            LogInput::Settings(settings) => drop(twin.controller.replace_settings(settings)),
            LogInput::Overrun => twin.controller.note_overrun(),
            LogInput::Born(settings, birth) => *twin = started(settings, birth)?,
        }
    }
    Ok(())
}

/// The outputs for a block; none where the controller did not run.
fn run(twin: &mut Lockstep, block: &Logged, slices: u32) -> Option<Vec<Output>> {
    let mut outputs = vec![Output::SAFE; block.ticks.len()];
    match block.samples {
        Samples::Came => {
            let frames: Vec<_> = block.ticks.iter().map(|tick| tick.frame).collect();
            twin.exchange(&frames, &mut outputs, slices);
        }
        Samples::Blind => {
            twin.exchange_blind(&mut outputs, slices);
        }
        Samples::Lost => return None,
    }
    Some(outputs)
}

fn differs(
    block: &Logged,
    outputs: Option<&[Output]>,
    twin: &Lockstep,
) -> Option<ReplayDifference> {
    for (i, (tick, here)) in block.ticks.iter().zip(outputs?).enumerate() {
        let recorded = &tick.output;
        let different = |what, recorded: StatusCell, here: StatusCell| {
            (recorded != here).then(|| ReplayDifference {
                tick: block.first_tick + i as u64,
                what,
                recorded: recorded.to_string(),
                here: here.to_string(),
            })
        };
        let code = |output: &Output| StatusCell::Int(i64::from(output.dac.0));
        let enable = |output: &Output| StatusCell::Int(i64::from(output.enable));
        let hertz = |output: &Output| StatusCell::Float(output.frequency_hz);
        let found = different("enable", enable(recorded), enable(here))
            .or_else(|| different("dac_code", code(recorded), code(here)))
            .or_else(|| different("frequency_set_hz", hertz(recorded), hertz(here)));
        if found.is_some() {
            return found;
        }
    }
    let here = cells(&twin.controller.status());
    let recorded = match (&block.status, &block.state) {
        (Some(recorded), _) => recorded.clone(),
        // The state is the first of the cells.
        (None, Some(state)) => vec![StatusCell::Text(state.clone().into())],
        (None, None) => return None,
    };
    // How many events were lost depends on who took them when, and decides nothing.
    let compared = |(what, _): &(&str, _)| *what != "events_dropped";
    let mut all = names()
        .into_iter()
        .zip(recorded.iter().zip(&here))
        .filter(compared);
    let (what, (recorded, here)) = all.find(|(_, (recorded, here))| recorded != here)?;
    Some(ReplayDifference {
        tick: block.first_tick + block.ticks.len() as u64 - 1,
        what,
        recorded: recorded.to_string(),
        here: here.to_string(),
    })
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use shared::control::{Command, Mode, ResetCause, SettingsState, Unfit};
    use shared::io::{AdcCode, Frame};
    use shared::model::params::PRESETS;

    use super::*;
    use emulator::log::{Header, LogBlock, LogTick, LogWriter};

    const BLOCK: usize = 10;

    fn header() -> Header {
        let (_, rig) = PRESETS[0];
        Header {
            source: "test".into(),
            settings: Settings::for_rig(&rig),
            birth: BootInfo::STORED,
            block_ticks: BLOCK as u32,
            scenario: None,
            made_from: None,
        }
    }

    /// Sensors at their zeros with a little noise, so that the self test passes; from a second on a
    /// swinging cart and hammer that follow no drive.
    fn frame(n: usize) -> Frame {
        let noise = (n * 7919 % 5) as f64 - 2.0;
        let swing = if n > 20_000 {
            300.0 * (n as f64 * 1e-3).sin()
        } else {
            0.0
        };
        let code = |zero: f64| AdcCode((zero + noise + swing).round() as u16);
        Frame {
            force: code(600.0),
            hammer: code(2048.0),
            cart: code(2048.0),
            emergency: false,
        }
    }

    /// Runs a controller in lock-step over `blocks` and logs it; `slices` as a recording has them.
    fn record(path: &Path, blocks: usize, board: bool, spoil: impl Fn(usize, &mut LogBlock)) {
        let header = header();
        let mut twin = started(&header.settings, &header.birth).unwrap();
        let mut writer = LogWriter::create(path, &header).unwrap();
        let mut states = Vec::new();
        for k in 0..blocks {
            let inputs = match k {
                10 | 2600 => vec![LogInput::Command(Command::Start(Mode::Automatic))],
                1500 => vec![LogInput::Command(Command::Stop), LogInput::Overrun],
                2500 => vec![LogInput::Born(
                    header.settings,
                    BootInfo {
                        reset: ResetCause::Watchdog,
                        record: None,
                        settings: SettingsState::Stored,
                        unfit: Unfit::NONE,
                    },
                )],
                2550 => vec![LogInput::Command(Command::ClearFault)],
                _ => Vec::new(),
            };
            give(&mut twin, &inputs).unwrap();
            let frames: Vec<_> = (0..BLOCK).map(|i| frame(k * BLOCK + i)).collect();
            let mut outputs = vec![Output::SAFE; BLOCK];
            let blind = k == 700;
            let exchanged = if blind {
                twin.exchange_blind(&mut outputs, 3)
            } else {
                twin.exchange(&frames, &mut outputs, 3)
            };
            let status = twin.controller.status();
            states.push(status.state);
            let ticks = frames.into_iter().zip(outputs);
            let ticks = ticks.map(|(frame, output)| LogTick {
                frame,
                output,
                truth: None,
            });
            let mut block = LogBlock {
                inputs,
                samples: if blind { Samples::Blind } else { Samples::Came },
                forecast: board.then_some(exchanged.delivered),
                slices: (!board).then_some(3),
                ticks: ticks.collect(),
                status: (!board).then_some(status),
                state: board.then_some(status.state),
            };
            spoil(k, &mut block);
            writer.block(&block).unwrap();
        }
        states.dedup();
        assert!(
            states.len() > 4,
            "the run must decide something: {states:?}"
        );
        writer.finish().unwrap();
    }

    fn replayed(path: &Path) -> Replayed {
        let mut log = LogReader::open(path).unwrap();
        replay(&mut log, &ProgressLine::new("", 0, true)).unwrap()
    }

    #[test]
    fn an_untouched_log_is_the_same_in_lock_step_and_from_a_board() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("run.parquet");
        for board in [false, true] {
            record(&path, 4000, board, |_, _| ());
            let same = Replayed {
                ticks: 40_000,
                difference: None,
            };
            assert_eq!(replayed(&path), same);
        }
    }

    #[test]
    fn the_first_tick_that_differs_is_named_with_both_values() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("run.parquet");
        record(&path, 3000, false, |k, block| {
            if k == 300 {
                block.ticks[4].output.dac.0 ^= 1;
            }
            if k == 301 {
                block.ticks[0].output.enable ^= true;
            }
        });
        let found = replayed(&path).difference.unwrap();
        assert_eq!((found.tick, found.what), (3004, "dac_code"));
        assert_eq!(
            (found.recorded.as_str(), found.here.as_str()),
            ("2049", "2048")
        );

        // One bit in one number of the status.
        record(&path, 3000, false, |k, block| {
            let status = block.status.as_mut().unwrap();
            if k == 40 {
                status.frequency_hz = f32::from_bits(status.frequency_hz.to_bits() ^ 1);
            }
        });
        let found = replayed(&path).difference.unwrap();
        assert_eq!((found.tick, found.what), (409, "frequency_hz"));

        // A sample that the controller did not see: what it decides from it differs later.
        record(&path, 3000, false, |k, block| {
            if k == 800 {
                for tick in &mut block.ticks {
                    tick.frame.emergency = true;
                }
            }
        });
        let found = replayed(&path).difference.unwrap();
        assert!((8000..8010).contains(&found.tick), "{found:?}");
    }
}
