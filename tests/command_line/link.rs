//! `host-sim link` against emulated boards.

use std::io::{BufRead, BufReader};
use std::process::{self, Child, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use crate::boards::{Emulator, Never, Toy, still, toy};
use crate::support::{Folder, csv_rows, finish, number, wait};
use emulator::log::LogReader;
use serialport::{SerialPort, TTYPort};
use shared::control::State;
use shared::io::AdcCode;
use shared::link::{BAUD, PROTOCOL_VERSION, ToBoard};
use shared::model::params::{BEAM_150, WIRES};
use shared::model::regime::Regime;
use shared::settings::Settings;

/// One line on standard error that contains `words`, exit code 2, nothing on standard output.
pub fn refused(folder: &Folder, line: &str, words: &[&str]) {
    let ran = folder.run(line);
    assert_eq!((ran.code, ran.out.as_str()), (Some(2), ""), "{ran:?}");
    assert_eq!(ran.err.trim_end().lines().count(), 1, "{ran:?}");
    for word in words {
        assert!(ran.err.contains(word), "{word} is not in {ran:?}");
    }
}

#[test]
fn status_settings_and_forecast_of_the_real_controller() {
    let board = still();
    let folder = Folder::new();
    let ask = |rest: &str| folder.run(&board.line(rest));

    let status = ask("status --format json").well().json();
    assert_eq!(
        (&status["state"], &status["board"]),
        (&"idle".into(), &"emulator".into())
    );
    assert!(number(&status, "target_hz") > 3.0, "{status}");
    assert!(ask("status").well().out.contains("idle"));

    // What is got can be sent, and what is sent is got.
    let text = ask("get").well().out;
    assert!(text.contains("[trips]") && text.contains("wire_length_mm"));
    let folder = folder.with(
        "mine.toml",
        text.replace("no_contact_s = 5.0", "no_contact_s = 7.5"),
    );
    let ask = |rest: &str| folder.run(&board.line(rest));
    ask("set mine.toml").well();
    assert!(ask("get").well().out.contains("no_contact_s = 7.5"));
    ask("set --rig beam-150").well();
    assert!(
        ask("get")
            .well()
            .out
            .contains("natural_frequency_hz = 5.25")
    );
    let expected = board.client().ask(ToBoard::GetSettings).expect("an answer");
    let mut beams = Settings::for_rig(&BEAM_150).for_real();
    // An emulated board has no button.
    beams.operator.acknowledge = false;
    assert_eq!(expected, shared::link::LinkAnswer::Settings(beams));

    // The shaker that a rig file tells of is sent, too. (It was left out without a word.)
    let folder = folder.with("own.toml", "preset = \"beam-150\"\nshaker_loop_hz = 40\n");
    let ask = |rest: &str| folder.run(&board.line(rest));
    ask("set --rig own.toml").well();
    assert!(ask("get").well().out.contains("shaker_loop_hz = 40"));
}

#[test]
fn the_forecast_comes_whole_in_every_format() {
    let board = still();
    let folder = Folder::new();
    let rows = csv_rows(&folder.run(&board.line("forecast --format csv")).well().out);
    assert!(rows.len() > 10);
    let rising = rows
        .windows(2)
        .all(|w| number(&w[0], "frequency_hz") < number(&w[1], "frequency_hz"));
    assert!(rising, "{rows:?}");
    let json = folder
        .run(&board.line("forecast --format json"))
        .well()
        .json();
    assert_eq!(json["rows"].as_array().map(Vec::len), Some(rows.len()));
    let command = format!("host-sim link {} forecast", board.path);
    assert_eq!(json["made_from"]["command"], command);
    assert!(
        json["settings"]["rig"]["mass_kg"].as_f64() > Some(0.0),
        "{json}"
    );
    let text = folder.run(&board.line("forecast")).well().out;
    assert_eq!(text.lines().count(), rows.len() + 2);
    assert!(text.contains("target"));
}

/// Records. The board sends in real time and waits for nobody: on a machine with too much to do ticks are lost, which the
/// program must say and leave no file; then it is tried again, once the cart of the recording that was given up stands.
fn record(folder: &Folder, line: &str) {
    for _ in 0..40 {
        let ran = folder.run(line);
        if ran.code == Some(0) {
            return;
        }
        let stopping = ran.err.contains("the controller is in stop");
        assert!(stopping || ran.err.contains("ticks were lost"), "{ran:?}");
        if stopping {
            thread::sleep(Duration::from_millis(500));
        }
        assert!(!folder.path("run.parquet").exists(), "{ran:?}");
    }
    panic!("no recording without a loss");
}

#[test]
fn a_recording_is_a_log_without_a_gap_that_replays() {
    let board = still();
    let folder = Folder::new();
    record(&folder, &board.line("record run.parquet --for 0.5"));
    let mut log = LogReader::open(folder.path("run.parquet")).expect("a log");
    assert_eq!(log.header().source, "emulator");
    assert_eq!(log.header().settings, Settings::for_rig(&WIRES));
    assert!(log.ticks() >= 10_000);
    let mut first = None;
    while let Some(logged) = log.block().expect("a whole log") {
        first = first.or(logged.ticks.first().copied());
    }
    assert_eq!(first.expect("ticks").frame.force, AdcCode(600));
    let replayed = folder.run("replay run.parquet --quiet").well();
    assert!(replayed.out.contains("same decisions"), "{replayed:?}");
    let made = log
        .header()
        .made_from
        .as_deref()
        .expect("what it was made from");
    assert!(made.contains("record --for 0.5"), "{made}");
    let there = "run.parquet exists already, and a measurement is not replaced";
    refused(&folder, &board.line("record run.parquet"), &[there]);
}

/// Interrupts a program as Ctrl-C does.
fn interrupt(child: &Child) {
    let mut kill = process::Command::new("kill");
    kill.args(["-INT", &child.id().to_string()]);
    assert_eq!(finish(kill).code, Some(0));
}

/// The whole way: plant, sensors, controller, session, wire, client, log, replay.
#[test]
fn a_recording_of_an_emulated_rig_that_starts_replays_bit_for_bit() {
    let folder = Folder::new();
    let emulator = Emulator::start(&folder, "field");
    let ask = |rest: &str| folder.run(&format!("link {} {rest}", emulator.1));
    ask("set --rig wires").well();
    // One that is interrupted stops the drive and keeps what was recorded.
    let before = folder.names();
    let line = format!("link {} record cut.parquet --for 60 --start", emulator.1);
    let recording = folder
        .command(&line.split_whitespace().collect::<Vec<_>>())
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts");
    let began = Instant::now();
    while folder.names() == before {
        assert!(
            began.elapsed() < Duration::from_secs(60),
            "nothing is begun"
        );
        thread::sleep(Duration::from_millis(20));
    }
    thread::sleep(Duration::from_secs(2));
    interrupt(&recording);
    let ran = recording.wait_with_output().expect("it ends");
    let said = String::from_utf8_lossy(&ran.stderr);
    assert_eq!(ran.status.code(), Some(130), "{said}");
    assert!(
        said.contains("wrote cut.parquet") && said.contains("of 1200000 ticks"),
        "{said}"
    );
    let replayed = folder.run("replay cut.parquet --quiet").well();
    assert!(replayed.out.contains("same decisions"), "{replayed:?}");
    while ask("status --format json").json()["state"] != "idle" {
        assert!(began.elapsed() < Duration::from_secs(120), "no stop");
    }
    let line = format!("link {} record run.parquet --for 4 --start", emulator.1);
    record(&folder, &line);
    // It is stopped at the end of the recording, and was driving during it.
    let status = ask("status --format json").well().json();
    let state = status["state"].as_str().expect("a state");
    assert!(matches!(state, "stop" | "idle"), "{status}");
    let mut log = LogReader::open(folder.path("run.parquet")).expect("a log");
    let mut driven = false;
    while let Some(logged) = log.block().expect("a whole log") {
        driven |= logged.ticks.iter().any(|tick| tick.output.enable);
    }
    assert!(driven);
    let replayed = folder.run("replay run.parquet --quiet").well();
    assert!(replayed.out.contains("same decisions"), "{replayed:?}");
}

#[test]
fn a_sweep_by_hand_visits_every_frequency_within_the_limits_and_stops() {
    let folder = Folder::new();
    let board = toy(Toy::new());
    let sweep = "sweep --from 4 --to 5.5 --step 0.5 --settle 0.2 --measure 0.3 --out";
    folder.run(&board.line(&format!("{sweep} up.csv"))).well();
    let column = |name: &str, key: &str| -> Vec<f64> {
        let rows = csv_rows(&folder.read(name));
        rows.iter().map(|row| number(row, key)).collect()
    };
    // The limit is 5 Hz: the point asked for beyond it is told as what it was.
    assert_eq!(column("up.csv", "frequency_hz"), [4.0, 4.5, 5.0, 5.0]);
    assert_eq!(column("up.csv", "force_n"), [4.0, 4.5, 5.0, 5.0]);
    assert_eq!(
        board.client().status().expect("an answer").state,
        State::Idle
    );
    folder
        .run(&board.line(&format!("{sweep} down.csv --down")))
        .well();
    assert_eq!(column("down.csv", "frequency_hz"), [5.0, 5.0, 4.5, 4.0]);
    let beside = folder.read("up.json");
    let json: serde_json::Value = serde_json::from_str(&beside).expect("JSON");
    assert_eq!(json["made_from"]["options"]["to_hz"], 5.5);
    assert_eq!(json["points"].as_array().map(Vec::len), Some(4));
    let there = "up.csv exists already, and a measurement is not replaced";
    refused(&folder, &board.line(&format!("{sweep} up.csv")), &[there]);
    // What it wrote is what the other sweep reads.
    let compared = "sweep --frequency 4:5:0.5 --cycles 20 --transient 10 --quiet --measured up.csv";
    let ran = folder.run(compared).well();
    assert!(ran.out.contains("4 points compared"), "{ran:?}");
}

#[test]
fn a_fault_ends_a_sweep_and_leaves_what_was_measured() {
    let folder = Folder::new();
    let board = toy(Toy {
        trips_above_hz: 4.2,
        ..Toy::new()
    });
    let ran =
        folder
            .run(&board.line(
                "sweep --from 4 --to 5 --step 0.5 --settle 0.2 --measure 0.2 --out part.csv",
            ));
    assert_eq!(ran.code, Some(2), "{ran:?}");
    let last = ran.err.trim_end().lines().last().expect("a complaint");
    assert!(
        last.contains("fault 2 (over-force)") && last.contains("clear-fault"),
        "{last}"
    );
    assert_eq!(csv_rows(&folder.read("part.csv")).len(), 1);
}

#[test]
fn an_interrupted_sweep_writes_what_was_measured_and_stops_the_drive() {
    let folder = Folder::new();
    let board = toy(Toy::new());
    let line =
        board.line("sweep --from 4 --to 5 --step 0.01 --settle 0.2 --measure 0.2 --out part.csv");
    let words: Vec<_> = line.split_whitespace().collect();
    let mut sweep = folder
        .command(&words)
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts");
    let mut lines = BufReader::new(sweep.stderr.take().expect("a pipe")).lines();
    let mut said = || lines.next().expect("a line").expect("UTF-8");
    assert!(said().contains("4.0000 Hz"));
    interrupt(&sweep);
    let rest: Vec<String> = std::iter::from_fn(|| Some(said()))
        .take_while(|line| !line.starts_with("interrupted after"))
        .collect();
    assert!(
        rest.iter()
            .any(|line| line == "wrote part.csv and part.json"),
        "{rest:?}"
    );
    assert_eq!(wait(sweep).code(), Some(130));
    assert!(!csv_rows(&folder.read("part.csv")).is_empty());
    let status = board.client().status().expect("an answer");
    assert_eq!(status.state, State::Idle);
}

/// A board that took the stop and does not become idle: the first interrupt ends the program all the same, with what was
/// measured.
#[test]
fn a_sweep_ends_on_the_first_interrupt_whatever_the_board_does() {
    ends_on_the_first_interrupt("--to 5 --step 0.01");
    // All is measured, and the stop is waited for.
    ends_on_the_first_interrupt("--to 4 --step 1");
}

fn ends_on_the_first_interrupt(range: &str) {
    let folder = Folder::new();
    let board = toy(Toy {
        never: Some(Never::Idle),
        ..Toy::new()
    });
    let sweep = format!("sweep --from 4 {range} --settle 0.2 --measure 0.2 --out part.csv");
    let line = board.line(&sweep);
    let words: Vec<_> = line.split_whitespace().collect();
    let sweep = folder
        .command(&words)
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts");
    let began = Instant::now();
    // What was measured is there before the program has ended.
    while !folder.path("part.csv").exists() {
        assert!(began.elapsed() < Duration::from_secs(60), "no point");
        thread::sleep(Duration::from_millis(20));
    }
    thread::sleep(Duration::from_millis(500));
    interrupt(&sweep);
    let began = Instant::now();
    let ran = sweep.wait_with_output().expect("it ends");
    assert!(began.elapsed() < Duration::from_secs(20), "{ran:?}");
    let said = String::from_utf8_lossy(&ran.stderr);
    let last = said.lines().last().expect("a complaint");
    assert_eq!(ran.status.code(), Some(2), "{said}");
    assert!(
        last.contains("does not go idle after it was told to stop and is in stop"),
        "{last}"
    );
    assert!(!csv_rows(&folder.read("part.csv")).is_empty());
}

/// Its controller stands still while its link goes on. `start` with a heartbeat waited for ever.
#[test]
fn a_board_whose_time_stands_still_is_told() {
    let board = toy(Toy {
        never: Some(Never::Ticks),
        ..Toy::new()
    });
    let ran = Folder::new().run(&board.line("start"));
    assert_eq!(ran.code, Some(2), "{ran:?}");
    assert!(
        ran.err.contains("the controller stands still in seek"),
        "{ran:?}"
    );
}

#[test]
fn no_wait_is_for_ever_and_nothing_raw_reaches_the_terminal() {
    let folder = Folder::new();
    let named = toy(Toy {
        name: "a\x1b[2Jb\x07",
        ..Toy::new()
    });
    let ran = folder.run(&named.line("status")).well();
    assert!(ran.out.starts_with("a?[2Jb?, firmware 9.9.9"), "{ran:?}");
    let never = toy(Toy {
        never: Some(Never::OneForecast),
        ..Toy::new()
    });
    refused(
        &folder,
        &never.line("forecast"),
        &["the forecast changes each time"],
    );
    let never = toy(Toy {
        never: Some(Never::Restarts),
        ..Toy::new()
    });
    refused(
        &folder,
        &never.line("record r.parquet"),
        &["does not restart"],
    );
    assert!(!folder.path("r.parquet").exists());
    for (line, words) in [
        ("link /dev/no-such-port monitor --rate 1e-19", "--rate is"),
        ("link /dev/no-such-port monitor --for 300000", "--for is"),
        (
            "link /dev/no-such-port start --manual --for 1e300",
            "--for is",
        ),
        (
            "link /dev/no-such-port record x.parquet --for 1e300",
            "--for is",
        ),
        ("link /dev/no-such-port set-brown-out", "say --yes"),
        ("emulate field --pty --speed 1e-300", "--speed is"),
        (
            "link /dev/no-such-port sweep --from 3 --to 4 --step 1 --settle 1e300 --out x.csv",
            "--settle is",
        ),
    ] {
        let ran = folder.run(line);
        assert_eq!((ran.code, ran.out.as_str()), (Some(2), ""), "{ran:?}");
        assert!(ran.err.contains(words) && ran.err.len() < 200, "{ran:?}");
    }
}

#[test]
fn manual_mode_is_held_and_ended_and_the_monitor_shows_lines() {
    let folder = Folder::new();
    let board = toy(Toy::new());
    let ran = folder
        .run(&board.line("start --manual --frequency 3 --for 2"))
        .well();
    assert!(ran.out.contains("manual"), "{ran:?}");
    let status = board.client().status().expect("an answer");
    assert!((status.frequency_hz - 3.0).abs() < 0.01);
    assert!(matches!(status.state, State::Stop | State::Idle));
    let ran = folder.run(&board.line("monitor --for 3 --rate 10")).well();
    let lines = ran.out.lines().count();
    assert!((30..=32).contains(&lines), "{lines} lines of {ran:?}");
}

#[test]
fn what_goes_wrong_is_told_in_one_line() {
    let folder = Folder::new()
        .with("odd.toml", "[trips]\nforce = 1\n")
        .with("low.toml", "[trips]\nforce_n = 1\n");
    refused(
        &folder,
        "link /dev/no-such-port status",
        &["cannot open /dev/no-such-port"],
    );
    refused(
        &folder,
        "link /dev/no-such-port sweep --from 3 --to 2 --step 1 --out x.csv",
        &["swap them"],
    );
    refused(
        &folder,
        "link /dev/no-such-port start --frequency 3",
        &["--manual"],
    );
    refused(&folder, "link /dev/no-such-port set", &["--rig"]);

    // A pseudo-terminal with nobody behind it.
    let (_silent, far_end) = TTYPort::pair().expect("a pseudo-terminal");
    let path = far_end.name().expect("its name");
    refused(
        &folder,
        &format!("link {path} status"),
        &["no answer within 2.1 s", "powered"],
    );

    for protocol in [PROTOCOL_VERSION - 1, PROTOCOL_VERSION + 1] {
        let other = toy(Toy {
            protocol,
            ..Toy::new()
        });
        let versions = format!("protocol {protocol} and this program {PROTOCOL_VERSION}");
        refused(&folder, &other.line("status"), &[&versions, "9.9.9"]);
    }

    let board = toy(Toy::new());
    refused(&folder, &board.line("clear-fault"), &["not in this state"]);
    refused(&folder, &board.line("start"), &["not in this state"]);
    refused(
        &folder,
        &board.line("set odd.toml"),
        &["odd.toml", "did you mean 'force_n'"],
    );
    refused(
        &folder,
        &board.line("set low.toml"),
        &["low.toml", "trips.force_n is 1"],
    );
    refused(
        &folder,
        &board.line("set --rig wires"),
        &["could not be stored"],
    );
    let used = folder.run(&board.line("get")).well().out;
    assert!(used.contains("\nacknowledge = true "), "{used}");
    refused(&folder, &board.line("forecast"), &["no forecast yet"]);
    refused(
        &folder,
        &board.line("record x.parquet"),
        &["cannot do that"],
    );
    assert_eq!(folder.names(), ["low.toml", "odd.toml"]);
}

#[test]
fn noise_on_the_wire_is_survived() {
    let board = toy(Toy::new());
    let mut port = serialport::new(&board.path, BAUD)
        .timeout(Duration::from_millis(5))
        .open()
        .expect("the pseudo-terminal opens");
    let noise: Vec<u8> = (0..5000_u32)
        .map(|i| (i.wrapping_mul(2_654_435_761) >> 24) as u8)
        .collect();
    std::io::Write::write_all(&mut port, &noise).expect("it is taken");
    drop(port);
    let status = board.client().status().expect("an answer all the same");
    assert_eq!(status.regime, Regime::None);
}
