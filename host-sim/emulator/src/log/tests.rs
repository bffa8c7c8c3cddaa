mod foxglove;

use std::collections::BTreeMap;
use std::fs;

use shared::control::{
    ActiveLimits, Basin, BootInfo, Command, Mode, ResetCause, SettingsState, State, Status, Unfit,
};
use shared::fault::{Fault, FaultRecord, Origin};
use shared::io::{AdcCode, DacCode, Frame, Output};
use shared::model::params::PRESETS;
use shared::model::regime::Regime;
use shared::settings::Settings;

use super::*;
use crate::names::state_name;
use crate::record::TrueContact;
use files::UserError;

const BLOCK: usize = 10;

fn header() -> Header {
    let (_, rig) = PRESETS[0];
    let mut settings = Settings::for_rig(&rig);
    settings.rig.mass_kg = 0.1 + 0.2; // not a short decimal
    Header {
        source: "emulator".into(),
        settings,
        birth: BootInfo {
            reset: ResetCause::Watchdog,
            record: status(21).fault,
            settings: SettingsState::Damaged,
            unfit: Unfit::REFERENCE,
        },
        block_ticks: BLOCK as u32,
        scenario: Some("name = \"a test\"\n".into()),
        made_from: Some("{}".into()),
    }
}

fn status(k: usize) -> Status {
    Status {
        tick: (k * BLOCK) as u32,
        state: if k < 7 { State::Idle } else { State::Hold },
        fault: (k > 20).then(|| {
            let first = FaultRecord::new(Fault::OverForce, Origin::Force, 77, 401.5, 3.5);
            let then = FaultRecord::new(Fault::SensorOpen, Origin::Cart, 90, 0.0, 3.5);
            then.after(Some(first))
        }),
        limits: ActiveLimits::FORCE | ActiveLimits::TRAVEL,
        frequency_hz: 3.0 + 0.1 * k as f32,
        amplitude_m: -0.0,
        measured_amplitude_m: f32::NAN,
        lag_rad: 0.25,
        regime: Regime::None,
        peak_n: 96.5,
        impulse_n_s: 0.1,
        target_hz: 3.66,
        target_n: 96.0,
        basin: Basin::Impact,
        reseeks: 2,
        overruns: u32::MAX,
        events_dropped: u16::MAX,
    }
}

/// A block whose every value depends on `k`; a spike of force in one tick of block 13.
fn block(k: usize) -> LogBlock {
    let tick = |i: usize| {
        let n = k * BLOCK + i;
        let spike = k == 13 && i == 4;
        LogTick {
            frame: Frame {
                force: AdcCode(if spike { 3000 } else { 600 + (n % 7) as u16 }),
                hammer: AdcCode((n * 31 % 4096) as u16),
                cart: AdcCode((n * 17 % 4096) as u16),
                emergency: n % 97 == 96,
            },
            output: Output {
                dac: DacCode((n * 13 % 4096) as u16),
                frequency_hz: 3.0 + n as f32 * 1e-3,
                enable: n.is_multiple_of(2),
            },
            truth: Some(Truth {
                force_n: if spike { 96.0 } else { 0.0 },
                hammer_m: f64::from(n as f32 * 0.5) * 1e-3,
                cart_m: 0.0,
            }),
        }
    };
    LogBlock {
        inputs: match k {
            0 => vec![LogInput::Command(Command::Start(Mode::Automatic))],
            3 => vec![LogInput::Overrun, LogInput::Settings(header().settings)],
            4 => vec![LogInput::Born(header().settings, BootInfo::STORED)],
            _ => Vec::new(),
        },
        samples: match k {
            5 => Samples::Lost,
            6 => Samples::Blind,
            _ => Samples::Came,
        },
        forecast: (k != 6).then_some(k == 8),
        slices: Some(4),
        ticks: (0..BLOCK).map(tick).collect(),
        status: (k != 9).then(|| status(k)),
        state: (k == 9).then_some(State::Ramp),
    }
}

fn as_logged(k: usize) -> Logged {
    let block = block(k);
    Logged {
        first_tick: (k * BLOCK) as u64,
        inputs: block.inputs,
        samples: block.samples,
        forecast: block.forecast,
        slices: block.slices,
        ticks: block.ticks,
        state: block
            .status
            .map(|status| status.state)
            .or(block.state)
            .map(|state| state_name(state).to_owned()),
        status: block.status.as_ref().map(|s| cells(s).to_vec()),
    }
}

fn write(path: &std::path::Path, blocks: usize) {
    let mut writer = LogWriter::create(path, &header()).unwrap();
    for k in 0..blocks {
        writer.block(&block(k)).unwrap();
    }
    writer.finish().unwrap();
}

#[test]
fn what_is_written_is_read_bit_for_bit() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("run.parquet");
    // More than one row group.
    let blocks = 20_500;
    write(&path, blocks);
    let mut reader = LogReader::open(&path).unwrap();
    assert_eq!(reader.header(), &header());
    assert_eq!(reader.ticks(), (blocks * BLOCK) as u64);
    for k in 0..blocks {
        assert_eq!(reader.block().unwrap().unwrap(), as_logged(k), "block {k}");
    }
    assert_eq!(reader.block().unwrap(), None);
}

#[test]
fn the_episode_names_all_its_faults() {
    let at = names().iter().position(|name| *name == "episode").unwrap();
    let episode = |k: usize| cells(&status(k))[at].clone();
    assert_eq!(episode(20), StatusCell::Null);
    let both = StatusCell::Text("over-force sensor-open".into());
    assert_eq!(episode(21), both);
    // Lost events come after it.
    assert_eq!(names().last(), Some(&"events_dropped"));
    assert_eq!(cells(&status(21)).last(), Some(&StatusCell::Int(65_535)));
}

#[test]
fn a_recording_has_no_truth() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("board.parquet");
    let mut writer = LogWriter::create(&path, &header()).unwrap();
    let mut recorded = block(1);
    recorded.ticks.truncate(3);
    for tick in &mut recorded.ticks {
        tick.truth = None;
    }
    recorded.status = None;
    recorded.state = None;
    recorded.slices = None;
    writer.block(&recorded).unwrap();
    writer.finish().unwrap();
    let read = LogReader::open(&path).unwrap().block().unwrap().unwrap();
    assert_eq!(read.ticks, recorded.ticks);
    assert_eq!((read.status, read.state, read.slices), (None, None, None));
}

#[test]
fn a_log_broken_off_leaves_nothing() {
    let dir = tempfile::tempdir().unwrap();
    let mut writer = LogWriter::create(dir.path().join("a.parquet"), &header()).unwrap();
    writer.block(&block(0)).unwrap();
    drop(writer);
    let mut writer = mcap::McapWriter::create(dir.path().join("a.mcap"), &header()).unwrap();
    writer.block(&block(0)).unwrap();
    drop(writer);
    assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 0);
}

/// Opens and reads to the end.
fn read_all(path: &std::path::Path) -> Result<(), UserError> {
    let mut reader = LogReader::open(path)?;
    while reader.block()?.is_some() {}
    Ok(())
}

#[test]
fn cut_or_foreign_files_get_one_line() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("run.parquet");
    write(&path, 40);
    read_all(&path).unwrap();
    let whole = fs::read(&path).unwrap();
    let bad = dir.path().join("bad.parquet");
    for length in [0, 3, 4, 100, whole.len() / 2, whole.len() - 1] {
        fs::write(&bad, &whole[..length]).unwrap();
        let line = read_all(&bad).unwrap_err().to_string();
        assert!(line.contains("bad.parquet"), "{line}");
        assert!(line.contains("again"), "{line}");
        assert_eq!(line.lines().count(), 1, "{line}");
    }
    fs::write(&bad, b"frequency_hz,force_n\n1,2\n").unwrap();
    assert!(read_all(&bad).is_err());
    assert!(read_all(&dir.path().join("none")).is_err());
    assert!(read_all(dir.path()).is_err());
}

#[test]
fn a_flipped_bit_anywhere_is_refused() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("run.parquet");
    write(&path, 40);
    let whole = fs::read(&path).unwrap();
    let bad = dir.path().join("bad.parquet");
    let name = whole
        .windows(17)
        .rposition(|w| w == b"vibro-impact run ")
        .unwrap()
        + 17;
    let every_bit_of_the_version = (name..name + 1).flat_map(|at| (0..8).map(move |bit| (at, bit)));
    let one_bit_of_every_third = (0..whole.len()).step_by(3).map(|at| (at, at % 8));
    for (at, bit) in one_bit_of_every_third.chain(every_bit_of_the_version) {
        let mut damaged = whole.clone();
        damaged[at] ^= 1 << bit;
        fs::write(&bad, &damaged).unwrap();
        let line = read_all(&bad).map(|()| at).unwrap_err().to_string();
        assert!(
            line.contains("bad.parquet") && line.contains("again"),
            "{line}"
        );
    }
}

#[test]
fn the_damaged_part_is_named_and_what_comes_before_it_is_read() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("run.parquet");
    write(&path, 40_500);
    let mut bytes = fs::read(&path).unwrap();
    // The footer is short: half of the file is in the second of three parts.
    let middle = bytes.len() / 2;
    bytes[middle] ^= 4;
    fs::write(&path, &bytes).unwrap();
    let mut reader = LogReader::open(&path).unwrap();
    for k in 0..20_000 {
        assert_eq!(reader.block().unwrap().unwrap(), as_logged(k), "block {k}");
    }
    let line = reader.block().unwrap_err().to_string();
    assert!(
        line.contains("part 2 of 3, ticks 200000 to 399999"),
        "{line}"
    );
}

/// A log of some version: the columns of that version with the values of today's log at `path`.
fn as_version(version: u32, columns: u32, path: &std::path::Path) -> std::path::PathBuf {
    use files::columns::{ParquetReader, ParquetWriter};
    let file = ParquetReader::open(fs::File::open(path).unwrap()).unwrap();
    let pairs = file.pairs().map(|(key, value)| {
        let format = format!("vibro-impact run {version}");
        let value = if key == "format" { &format } else { value };
        (key.to_owned(), value.to_owned())
    });
    let fields = columns::fields(columns::VERSION);
    let groups = (0..file.groups()).map(|i| file.group(i, &fields).unwrap());
    let named = columns::fields(columns);
    let mut writer = ParquetWriter::new(Vec::new(), "run", &named, pairs.collect()).unwrap();
    groups.for_each(|group| writer.group(&group).unwrap());
    let other = path.with_file_name("other.parquet");
    fs::write(&other, writer.finish().unwrap()).unwrap();
    other
}

#[test]
fn a_log_of_the_first_version_is_read_with_its_own_name_of_the_impulse() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("run.parquet");
    write(&path, 40);
    let bytes = fs::read(as_version(1, 1, &path)).unwrap();
    let has = |name: &[u8]| bytes.windows(name.len()).any(|there| there == name);
    assert!(has(b"impulse_ns") && !has(b"impulse_n_s"));
    let mut reader = LogReader::open(dir.path().join("other.parquet")).unwrap();
    for k in 0..40 {
        let mut logged = as_logged(k);
        // Its status is that of today but for the episode and the events that were dropped.
        if let Some(cells) = &mut logged.status {
            cells.truncate(cells.len() - 2);
        }
        assert_eq!(reader.block().unwrap().unwrap(), logged, "block {k}");
    }
    // Neither version takes the other's columns.
    for (version, columns) in [(1, 2), (2, 1), (3, 4), (4, 3), (4, 5), (5, 4)] {
        let line = read_all(&as_version(version, columns, &path)).unwrap_err();
        assert!(line.to_string().contains("its columns"), "{line}");
    }
}

#[test]
fn another_version_is_named() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("run.parquet");
    write(&path, 4);
    for version in [0, 6, u32::MAX] {
        let line = read_all(&as_version(version, 2, &path))
            .unwrap_err()
            .to_string();
        let named = format!("a log of version {version}, written by host-sim ");
        assert!(line.contains(&named), "{line}");
        assert!(line.contains("reads versions 1 to 5"), "{line}");
    }
}
