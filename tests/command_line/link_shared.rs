//! `host-sim link` with several programs at one port: who holds it, who steers, and whose end switches the drive off.

use std::io::{BufRead, BufReader};
use std::process::{self, Child, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use crate::boards::{Emulator, Toy, still, toy};
use crate::link::refused;
use crate::support::{Folder, finish, wait};
use shared::link::LinkAct;
use shared::model::params::WIRES;
use shared::settings::Settings;

/// A command that runs `host-sim` as a user who is not root: nobody, if these tests run as root.
fn as_ordinary_user(folder: &Folder, port: &str, rest: &[&str]) -> process::Command {
    let words = [&["link", port], rest].concat();
    let command = folder.command(&words);
    let user = process::Command::new("id").arg("-u").output();
    if user.is_ok_and(|id| id.stdout.trim_ascii() != b"0") {
        return command;
    }
    let mut other = process::Command::new("setpriv");
    other
        .args(["--reuid=65534", "--regid=65534", "--clear-groups", "--"])
        .arg(command.get_program())
        .args(command.get_args())
        .stdin(Stdio::null());
    other
}

/// Lets every user use the port of an emulated board.
fn for_everybody(port: &str) {
    use std::os::unix::fs::PermissionsExt;
    std::fs::set_permissions(port, std::fs::Permissions::from_mode(0o666)).expect("it is ours");
}

/// A monitor that has shown its first line.
fn monitor(folder: &Folder, port: &str) -> Child {
    let mut command = as_ordinary_user(folder, port, &["monitor", "--rate", "20"]);
    let mut child = command.stdout(Stdio::piped()).spawn().expect("it starts");
    let out = child.stdout.take().expect("a pipe");
    let mut lines = BufReader::new(out).lines();
    lines.next().expect("a line").expect("UTF-8");
    // Read on, so that the monitor does not end for want of a reader.
    thread::spawn(move || lines.for_each(drop));
    child
}

#[test]
fn whatever_ends_a_monitor_leaves_the_port_free_for_an_ordinary_user() {
    let board = toy(Toy::new());
    let folder = Folder::new();
    for_everybody(&board.path);
    for (signal, code) in [
        ("INT", Some(130)),
        ("TERM", Some(130)),
        ("HUP", Some(130)),
        ("KILL", None),
    ] {
        let child = monitor(&folder, &board.path);
        let mut kill = process::Command::new("kill");
        kill.args([&format!("-{signal}"), &child.id().to_string()]);
        assert_eq!(finish(kill).code, Some(0));
        assert_eq!(wait(child).code(), code, "{signal}");
        let ran = finish(as_ordinary_user(&folder, &board.path, &["status"]));
        assert_eq!(ran.code, Some(0), "after {signal}: {ran:?}");
    }
}

#[test]
fn a_port_in_use_is_refused_to_all_but_stop() {
    let board = toy(Toy::new());
    let folder = Folder::new();
    for_everybody(&board.path);
    let line = board.line("start --manual --frequency 3");
    let words: Vec<_> = line.split_whitespace().collect();
    let mut steering = folder.command(&words);
    let mut steering = steering
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("it starts");
    let mut lines = BufReader::new(steering.stdout.take().expect("a pipe")).lines();
    let mut said = || lines.next().map(|line| line.expect("UTF-8"));
    while !said().expect("a line").contains("manual") {}
    let busy = finish(as_ordinary_user(&folder, &board.path, &["status"]));
    assert_eq!(busy.code, Some(2), "{busy:?}");
    assert!(busy.err.contains("another program uses it"), "{busy:?}");
    let stop = finish(as_ordinary_user(&folder, &board.path, &["stop"])).well();
    assert!(
        stop.out.contains("another program uses the port"),
        "{stop:?}"
    );
    while said().is_some() {}
    let mut complaint = String::new();
    let mut err = steering.stderr.take().expect("a pipe");
    std::io::Read::read_to_string(&mut err, &mut complaint).expect("UTF-8");
    assert!(
        complaint.contains("somebody else has stopped"),
        "{complaint}"
    );
    assert_eq!(wait(steering).code(), Some(2));
}

#[test]
fn a_program_that_steers_is_in_the_way_of_others_until_they_take_over() {
    let board = still();
    let folder = Folder::new();
    let ask = |rest: &str| folder.run(&board.line(rest));
    assert_eq!(ask("status --format json").well().json()["held"], false);
    // One whose session outlives it for long.
    let mut first = board.client();
    first.open_session(false).expect("a session");
    let mut patient = Settings::for_rig(&WIRES);
    patient.trips.link_timeout_s = 3600.0;
    first.steer(LinkAct::SetSettings(patient)).expect("in idle");
    drop(first);
    assert_eq!(ask("status --format json").well().json()["held"], true);
    let steers = ["another program steers", "--take-over"];
    refused(&folder, &board.line("set --rig beam-150"), &steers);
    refused(&folder, &board.line("start"), &steers);
    ask("stop").well();
    ask("set --rig wires --take-over").well();
    // It is over with the command.
    assert_eq!(ask("status --format json").well().json()["held"], false);
    ask("set --rig wires").well();
    refused(&folder, &board.line("confirm"), &["not in this state"]);
}

#[test]
fn a_start_with_a_heartbeat_stays_and_its_end_switches_the_drive_off() {
    let folder = Folder::new();
    let emulator = Emulator::start(&folder, "field");
    let ask = |rest: &str| folder.run(&format!("link {} {rest}", emulator.1));
    ask("set --rig wires").well();
    assert!(ask("get").well().out.contains("heartbeat = true"));
    let mut start = folder.command(&["link", &emulator.1, "start"]);
    let mut start = start.stdout(Stdio::piped()).spawn().expect("it starts");
    let out = start.stdout.take().expect("a pipe");
    // Longer on than the timeout of 2 s.
    let lines = BufReader::new(out).lines().map(|line| line.expect("UTF-8"));
    let drives = |line: &String| ["ramp", "seek", "hold"].iter().any(|s| line.contains(s));
    let driving = lines.filter(drives);
    assert_eq!(driving.take(15).count(), 15);
    start.kill().expect("it is still there");
    wait(start);
    // Whoever looks does not keep it on.
    let began = Instant::now();
    loop {
        let status = ask("status --format json").well().json();
        if status["fault"]["name"] == "link-timeout" {
            break;
        }
        assert!(began.elapsed() < Duration::from_secs(60), "{status}");
    }
}
