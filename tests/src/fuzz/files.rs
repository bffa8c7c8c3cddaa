//! Files that a person gives: logs, rigs, scenarios, tables, records.

use std::io::Write;
use std::path::Path;
use std::sync::OnceLock;

use emulator::log::{Header, LogBlock, LogInput, LogReader, LogTick, LogWriter};
use emulator::scenario;
use files::{Measurements, UserError, rigfile};
use numerics::NamedRig;
use shared::control::{BootInfo, Command, State};
use shared::model::params::WIRES;
use shared::settings::Settings;

/// Every line to a person is one line and says something.
fn one_line(error: &UserError) {
    let line = error.to_string();
    assert!(!line.trim().is_empty());
}

/// A rig file: what is read is a rig that can be, and printed it reads back the same.
pub fn rig(data: &[u8]) {
    let text = String::from_utf8_lossy(data);
    match rigfile::parse(&text, "fuzz.toml") {
        Err(error) => one_line(&error),
        Ok(params) => {
            assert!(params.check().is_ok(), "{params:?}");
            let named = NamedRig::new("fuzz", params);
            let printed = rigfile::to_toml(&named);
            let back = rigfile::parse(&printed, "printed.toml");
            let back = back.unwrap_or_else(|e| panic!("{e}\n{printed}"));
            let close = |key: &str| {
                let [a, b] = [&params, &back].map(|rig| rigfile::number(rig, key));
                a == b || (a.zip(b)).is_some_and(|(a, b)| (a - b).abs() <= 1e-9 * a.abs())
            };
            let differs = rigfile::KEYS.iter().find(|(key, _)| !close(key));
            assert_eq!(differs, None, "{params:?}\n{back:?}");
        }
    }
}

/// A scenario: what is read can be run.
pub fn scenario(data: &[u8]) {
    let text = String::from_utf8_lossy(data);
    match scenario::parse("fuzz", &text, "fuzz.toml") {
        Err(error) => one_line(&error),
        Ok(scenario) => {
            assert!(scenario.true_rig.check().is_ok(), "{scenario:?}");
            assert!(scenario.settings.check().is_ok(), "{scenario:?}");
            assert!(scenario.blocks() > 0 && scenario.tick_s() > 0.0);
            assert!(scenario.events.is_sorted_by(|a, b| a.at_s <= b.at_s));
        }
    }
}

/// A table of measurements: numbers of lines rise and are those of lines that are there.
pub fn table(data: &[u8]) {
    let text = String::from_utf8_lossy(data).into_owned();
    let lines: Result<Vec<_>, _> = Measurements::new("fuzz.csv", text.clone())
        .and_then(|table| table.lines(&["frequency_hz", "force_n"])?.collect());
    match lines {
        Err(error) => one_line(&error),
        Ok(lines) => {
            assert!(lines.is_sorted_by(|a, b| a.number < b.number));
            let last = text.matches(['\r', '\n']).count() + 1;
            for line in &lines {
                assert!((1..=last).contains(&line.number));
                if let Ok(force_n) = line.number("force_n") {
                    assert!(force_n.is_finite());
                }
            }
        }
    }
}

/// A sensor's record: times rise and every column is as long.
pub fn signal(data: &[u8]) {
    let text = String::from_utf8_lossy(data).into_owned();
    let plain = files::table::plain("fuzz.csv", text);
    match plain.and_then(|plain| host_sim::record::parse("fuzz.csv", &plain.text, |_| ())) {
        Err(error) => one_line(&error),
        Ok(signal) => {
            assert!(signal.time_s.is_sorted_by(|a, b| a < b));
            let columns = [&signal.force_n, &signal.displacement_mm, &signal.cart_mm];
            for column in columns.into_iter().flatten() {
                assert_eq!(column.len(), signal.time_s.len());
                assert!(column.iter().all(|x| x.is_finite()));
            }
        }
    }
}

/// A log (Parquet). If the first byte is below 128, the rest is changes of a good log: three bytes each, where (two
/// bytes, cut to the log's length) and what is added there. Else the rest is the file.
pub fn log(data: &[u8]) {
    let Some((mode, rest)) = data.split_first() else {
        return;
    };
    let bytes = if *mode < 128 {
        let mut bytes = good_log().to_vec();
        for change in rest.chunks_exact(3) {
            let at = usize::from(u16::from_le_bytes([change[0], change[1]])) % bytes.len();
            bytes[at] = bytes[at].wrapping_add(change[2]);
        }
        bytes
    } else {
        rest.to_vec()
    };
    let mut file = tempfile::NamedTempFile::new().expect("room for a file");
    file.write_all(&bytes).expect("room for a file");
    match read(file.path()) {
        Err(error) => one_line(&error),
        Ok(ticks) => assert!(ticks < 1 << 24, "{ticks} ticks in {} bytes", bytes.len()),
    }
}

fn read(path: &Path) -> Result<usize, UserError> {
    let mut log = LogReader::open(path)?;
    let mut ticks = 0;
    while let Some(block) = log.block()? {
        assert!(!block.ticks.is_empty());
        ticks += block.ticks.len();
    }
    Ok(ticks)
}

/// Four blocks with inputs and states.
fn good_log() -> &'static [u8] {
    static LOG: OnceLock<Vec<u8>> = OnceLock::new();
    LOG.get_or_init(|| {
        let folder = tempfile::tempdir().expect("room for a folder");
        let path = folder.path().join("run.parquet");
        let header = Header {
            source: "test".into(),
            settings: Settings::for_rig(&WIRES),
            birth: BootInfo::STORED,
            block_ticks: 10,
            scenario: None,
            made_from: None,
        };
        let mut writer = LogWriter::create(&path, &header).expect("room for a log");
        for k in 0..4 {
            let block = LogBlock {
                inputs: vec![LogInput::Command(Command::Stop); k % 2],
                slices: Some(20),
                ticks: vec![LogTick::default(); 10],
                state: Some(State::Idle),
                ..LogBlock::default()
            };
            writer.block(&block).expect("room for a block");
        }
        writer.finish().expect("room for a log");
        assert_eq!(read(&path).ok(), Some(40), "a good log is read");
        std::fs::read(&path).expect("it was just written")
    })
}
