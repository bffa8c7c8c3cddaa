//! `emulate`, `scenarios` and `replay`: a run, its verdict and files, and its log through the controller again.

use std::fs;

use emulator::log::{LogBlock, LogReader, LogWriter};
use serde_json::Value;

use crate::support::{Folder, assert_refused, assert_svg_shows, csv_rows, keys, number, png_size};

/// Two seconds: start, and an emergency stop that must trip and switch off.
pub const STOPPED: &str = r#"
description = "The chain opens while the amplitude rises."
duration_s = 2.0
slices_per_block = 1000

[true_rig]
preset = "wires"

[[events]]
at_s = 0.1
kind = "start"

[[events]]
at_s = 1.5
kind = "emergency-stop"

[expect]
final_state = "fault"
faults = ["emergency-stop"]
drive_off_within_ticks = 40
"#;

const TICKS: usize = 40_000;

#[test]
fn a_shaker_whose_loop_the_settings_do_not_take_is_said() {
    let fast = STOPPED.replace(
        "[[events]]\nat_s = 0.1",
        "[shaker]\nloop_hz = 400.0\nloop_damping_ratio = 2.0\n\n[[events]]\nat_s = 0.1",
    );
    let folder = Folder::new()
        .with("stopped.toml", STOPPED)
        .with("fast.toml", &fast);
    let run = |line: &str| folder.run(line).well().out;
    let said = "shaker loop    not in the controller's settings";
    assert!(run("emulate fast.toml --no-log --quiet").contains(said));
    assert!(!run("emulate stopped.toml --no-log --quiet").contains(said));
    let json: Value =
        serde_json::from_str(&run("emulate fast.toml --format json --quiet")).unwrap();
    let why = json["loop_left_out"].as_str().unwrap();
    assert!(why.starts_with("shaker_loop_hz is 400"), "{why}");
}

#[test]
fn a_run_leaves_verdict_log_and_picture_and_its_log_replays() {
    let folder = Folder::new().with("stopped.toml", STOPPED);
    let ran = folder.run("emulate stopped.toml --out out").well();
    for line in [
        "stopped: The chain opens",
        "scenario: start",
        "fault 1 emergency-stop",
        "drive off",
        "verdict        pass",
        "final state    fault",
    ] {
        assert!(ran.out.contains(line), "{line} is not in: {}", ran.out);
    }
    assert!(ran.err.contains("wrote"), "{}", ran.err);
    let names = folder.names();
    let expected = [
        "out/stopped-timeline.csv",
        "out/stopped.json",
        "out/stopped.mcap",
        "out/stopped.parquet",
        "out/stopped.png",
        "out/stopped.svg",
        "stopped.toml",
    ];
    assert_eq!(names, expected);

    let verdict: Value = serde_json::from_str(&folder.read("out/stopped.json")).unwrap();
    for key in [
        "verdict",
        "final_state",
        "time_to_hold_s",
        "frequency_hz",
        "force_ratio_mean",
        "optimum_frequency_hz",
        "optimum_force_ratio",
        "force_share",
        "share_from_start",
        "largest_force_n",
        "largest_cart_mm",
        "driven_with_fault_s",
        "faults",
        "overruns",
    ] {
        assert!(keys(&verdict).contains(&key), "{key} is not in {verdict}");
    }
    let fault = &verdict["faults"][0];
    assert_eq!(
        (&fault["code"], &fault["name"]),
        (&1.into(), &"emergency-stop".into())
    );
    assert!(number(fault, "drive_off_after_ticks") <= 40.0);

    let timeline = csv_rows(&folder.read("out/stopped-timeline.csv"));
    let what = |row: &Value| row["what"].as_str().unwrap().to_owned();
    let started = timeline
        .iter()
        .position(|row| what(row) == "scenario: start");
    let stopped = timeline
        .iter()
        .position(|row| what(row).starts_with("fault 1 "));
    assert!(started.unwrap() < stopped.unwrap());

    assert_eq!(
        png_size(&fs::read(folder.path("out/stopped.png")).unwrap()),
        (2200, 1960)
    );
    assert_svg_shows(
        &folder.read("out/stopped.svg"),
        &[
            "stopped",
            "frequency, Hz",
            "F/(m g)",
            "amplitude, mm",
            "prove",
            "emergency-stop",
        ],
    );

    let same = folder.run("replay out/stopped.parquet").well();
    assert_eq!(
        same.out,
        format!("same decisions over {TICKS} ticks (2.000 s)\n")
    );
    let same = folder
        .run("replay out/stopped.parquet --format json")
        .well()
        .json();
    assert_eq!(
        (&same["same"], &same["source"]),
        (&true.into(), &"emulator".into())
    );
}

/// Everything a log must tell a replay beside samples.
const TROUBLED: &str = r#"
duration_s = 6.0
slices_per_block = 1000
block_ticks = 7

[true_rig]
preset = "beam-150"

[sensors]
noise_percent = 1.0

[[events]]
at_s = 0.1
kind = "start"

[[events]]
at_s = 1.6
kind = "lost-block"
blocks = 2
every = 20

[[events]]
at_s = 1.7
kind = "overrun"
blocks = 2
every = 50

[[events]]
at_s = 2.0
kind = "clear-fault" # before the reset: must not clear what the reset brings

[[events]]
at_s = 2.0
kind = "reset"
cause = "watchdog"

[[events]]
at_s = 2.2
kind = "clear-fault"

[[events]]
at_s = 2.3
kind = "start"
mode = "manual"

[[events]]
at_s = 3.7
kind = "set-point"
frequency_hz = 9.0
amplitude_mm = 0.5

[expect]
final_state = "manual"
faults = ["watchdog-reset"]
"#;

#[test]
fn a_reset_a_lost_block_and_commands_are_replayed() {
    let folder = Folder::new().with("troubled.toml", TROUBLED);
    let ran = folder.run("emulate troubled.toml --out .").well();
    for line in ["reset: watchdog", "2 overruns", "2 blocks of samples lost"] {
        assert!(ran.out.contains(line), "{line} is not in: {}", ran.out);
    }
    let same = folder.run("replay troubled.parquet").well();
    assert!(
        same.out.starts_with("same decisions over 12"),
        "{}",
        same.out
    );
}

#[test]
fn the_same_scenario_is_the_same_run() {
    let folder = Folder::new().with("stopped.toml", STOPPED);
    let first = folder
        .run("emulate --scenario stopped.toml --out a --format json")
        .well();
    let second = folder
        .run("emulate stopped.toml --out b --format json --quiet")
        .well();
    assert_eq!(second.err, "");
    assert_eq!(first.json(), second.json());
    for name in ["parquet", "mcap", "svg", "json"] {
        let bytes = |dir| fs::read(folder.path(&format!("{dir}/stopped.{name}"))).unwrap();
        assert!(bytes("a") == bytes("b"), "{name} differs");
    }
}

#[test]
fn what_was_expected_and_did_not_come_is_exit_code_1() {
    let other = STOPPED.replace("[\"emergency-stop\"]", "[]");
    let folder = Folder::new().with("other.toml", other);
    let ran = folder.run("emulate other.toml --format json");
    assert_eq!((ran.code, ran.err.as_str()), (Some(1), ""));
    assert_eq!(folder.names(), ["other.toml"]);
    let verdict = ran.json();
    assert_eq!(verdict["verdict"], "fail");
    assert!(
        verdict["why"][0]
            .as_str()
            .unwrap()
            .contains("emergency-stop")
    );
}

#[test]
fn no_log_leaves_the_picture() {
    let folder = Folder::new().with("stopped.toml", STOPPED);
    folder.run("emulate stopped.toml --out out --no-log").well();
    let names = folder.names();
    assert!(names.contains(&"out/stopped.png".to_owned()), "{names:?}");
    assert!(
        !names
            .iter()
            .any(|n| n.ends_with("parquet") || n.ends_with("mcap")),
        "{names:?}"
    );
}

#[test]
fn scenarios_are_listed_and_printed_as_files_to_start_from() {
    let folder = Folder::new();
    let list = folder.run("scenarios").well().out;
    assert!(
        list.lines().any(|line| line.starts_with("field ")),
        "{list}"
    );
    let text = folder.run("scenarios field").well().out;
    assert!(
        text.contains("[true_rig]") && text.contains("[expect]"),
        "{text}"
    );
    let ran = folder.run("scenarios feild");
    assert_eq!(ran.code, Some(2));
    assert!(ran.err.contains("did you mean 'field'"), "{}", ran.err);
}

#[test]
fn input_that_cannot_be_used_gets_one_line() {
    let folder = Folder::new()
        .with("key.toml", STOPPED.replace("duration_s", "duration"))
        .with("late.toml", STOPPED.replace("at_s = 1.5", "at_s = 15"))
        .with("rigless.toml", "duration_s = 5\n")
        .with("taken", "")
        .with(
            "notes.parquet",
            "not a log at all, but some text of a length",
        );
    assert_refused(
        &folder,
        [
            ("emulate key.toml", "key.toml"),
            ("emulate late.toml", "late.toml"),
            ("emulate rigless.toml", "write a line [true_rig]"),
            ("emulate nowhere", "nowhere"),
            ("emulate nowhere.toml", "nowhere.toml"),
            ("emulate field --out taken", "taken"),
            ("emulate field --scenario field", "--scenario"),
            ("replay nowhere.parquet", "nowhere.parquet"),
            ("replay notes.parquet", "notes.parquet"),
            ("replay .", "."),
        ],
    );
}

#[test]
fn a_log_that_is_cut_short_is_refused_and_one_that_differs_is_exit_code_1() {
    let folder = Folder::new().with("stopped.toml", STOPPED);
    folder.run("emulate stopped.toml --out out").well();
    let log = folder.path("out/stopped.parquet");
    let whole = fs::read(&log).unwrap();
    fs::write(&log, &whole[..whole.len() / 2]).unwrap();
    let ran = folder.run("replay out/stopped.parquet");
    assert_eq!((ran.code, ran.out.as_str()), (Some(2), ""));
    assert!(
        ran.err.contains("stopped.parquet") && ran.err.contains("cut short"),
        "{}",
        ran.err
    );

    // A bit of a sample.
    let mut flipped = whole.clone();
    flipped[whole.len() / 3] ^= 1;
    fs::write(&log, &flipped).unwrap();
    for command in ["replay out/stopped.parquet", "compare out/stopped.parquet"] {
        let ran = folder.run(command);
        assert_eq!((ran.code, ran.out.as_str()), (Some(2), ""), "{ran:?}");
        assert!(ran.err.contains("part 1 of 1, ticks 0 to"), "{}", ran.err);
    }

    // Another amplitude in the settings the log was made with: other decisions.
    fs::write(&log, &whole).unwrap();
    let mut reader = LogReader::open(&log).unwrap();
    let mut header = reader.header().clone();
    header.settings.rig.amplitude_m *= 1.01;
    let mut writer = LogWriter::create(folder.path("out/other.parquet"), &header).unwrap();
    while let Some(logged) = reader.block().unwrap() {
        let block = LogBlock {
            inputs: logged.inputs,
            samples: logged.samples,
            forecast: logged.forecast,
            slices: logged.slices,
            ticks: logged.ticks,
            status: None,
            state: None,
        };
        writer.block(&block).unwrap();
    }
    writer.finish().unwrap();
    fs::rename(folder.path("out/other.parquet"), &log).unwrap();
    let ran = folder.run("replay out/stopped.parquet");
    assert_eq!(ran.code, Some(1), "{ran:?}");
    assert!(
        ran.out.starts_with("first difference at tick "),
        "{}",
        ran.out
    );
    let ran = folder.run("replay out/stopped.parquet --format json");
    let answer = ran.json();
    assert_eq!((ran.code, &answer["same"]), (Some(1), &false.into()));
    assert_ne!(answer["recorded"], answer["here"]);
}
