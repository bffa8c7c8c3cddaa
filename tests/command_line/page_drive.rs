//! Whatever becomes of the page that commands, the drive goes off: by the truth in the plant, within the time that
//! docs/page.md states.

use std::thread;
use std::time::{Duration, Instant};

use shared::control::{Command, State};
use shared::link::ToBoard;

use crate::page_rig::{Rig, Served};
use crate::support::Folder;
use files::UserError;

/// The controller lets the amplitude fall to nothing within a second (`drive.amplitude_slew_m_per_s`).
const RAMP_S: f64 = 1.0;

/// For a busy machine between a page that goes and the board's next block: without load it is some hundredths.
const BUSY_S: f64 = 2.0;

/// A watch of the board's over the link that does not come first.
const LONG_S: f32 = 60.0;

/// The server stops the drive at once, and not only the board its own watch.
#[test]
fn a_page_that_vanishes_while_it_drives_takes_the_drive_with_it() {
    let (folder, rig) = (Folder::new(), Rig::start(LONG_S));
    let served = Served::start(&folder, &rig.path);
    let mut watcher = served.page();
    let mut page = served.page();
    page.drive(&rig.truth);
    let since = rig.truth.tick();
    drop(page);
    let off = rig.truth.off_after(since);
    assert!(off < RAMP_S + BUSY_S, "off after {off} s");
    let seat = watcher.told("seat", |seat| seat["commander"].is_null());
    assert_eq!(seat["pages"], 1, "{seat}");
    println!("vanished: off after {off:.3} s");
}

/// Its connection stands, and its script does nothing more.
#[test]
fn a_page_that_falls_silent_while_it_drives_takes_the_drive_with_it() {
    let (folder, rig) = (Folder::new(), Rig::start(LONG_S));
    let served = Served::start(&folder, &rig.path);
    let mut page = served.page();
    page.drive(&rig.truth);
    let since = rig.truth.tick();
    let off = rig.truth.off_after(since);
    assert!(off < 1.0 + RAMP_S + BUSY_S, "off after {off} s");
    assert!(
        off > 1.0,
        "a second's silence is allowed: off after {off} s"
    );
    page.told("seat", |seat| seat["commander"].is_null());
    // What it sends now is refused: it no longer commands.
    let late = page.client.command(Command::Alive);
    let why = late.expect_err("it commands no longer").to_string();
    assert!(why.contains("no longer steers"), "{why}");
    println!("silent: off after {off:.3} s");
}

/// Nobody renews the board's watch then.
#[test]
fn a_server_that_is_killed_takes_the_drive_with_it() {
    let (folder, rig) = (Folder::new(), Rig::start(2.0));
    let mut served = Served::start(&folder, &rig.path);
    let mut page = served.page();
    page.drive(&rig.truth);
    let since = rig.truth.tick();
    assert_eq!(served.kill("-KILL"), None);
    let off = rig.truth.off_after(since);
    assert!(off < 2.0 + BUSY_S, "off after {off} s");
    println!("killed: off after {off:.3} s");
}

#[test]
fn a_server_that_is_interrupted_stops_the_drive_first() {
    let (folder, rig) = (Folder::new(), Rig::start(LONG_S));
    let mut served = Served::start(&folder, &rig.path);
    let mut page = served.page();
    page.drive(&rig.truth);
    let since = rig.truth.tick();
    assert_eq!(served.kill("-INT"), Some(130));
    let off = rig.truth.off_after(since);
    assert!(off < RAMP_S + BUSY_S, "off after {off} s");
    println!("interrupted: off after {off:.3} s");
}

/// The drive goes on under who has taken over; a watcher's stop ends it.
#[test]
fn a_drive_survives_a_take_over_and_any_page_may_stop_it() {
    let (folder, rig) = (Folder::new(), Rig::start(LONG_S));
    let served = Served::start(&folder, &rig.path);
    let mut first = served.page();
    let mut second = served.page();
    let mut watcher = served.page();
    first.drive(&rig.truth);
    second.command("take-over");
    let number = second.number();
    let told = first.told("seat", |seat| seat["commander"] == number);
    let why = told["why"].as_str().expect("words");
    assert!(why.contains("took the command from page"), "{why}");
    let point = Command::SetPoint {
        frequency_hz: 3.0,
        amplitude_m: 1e-4,
    };
    let refused = first.client.command(point).expect_err("it lost the seat");
    assert!(
        refused.to_string().contains("another program steers"),
        "{refused}"
    );
    drop(first);
    // Longer than a silence may last: nothing of the first one's end stops the second.
    let began = Instant::now();
    while began.elapsed() < Duration::from_millis(1500) {
        second.client.command(Command::Alive).expect("it is heard");
        thread::sleep(Duration::from_millis(50));
    }
    assert!(rig.truth.is_powered());
    let since = rig.truth.tick();
    watcher.client.command(Command::Stop).expect("anybody may");
    let off = rig.truth.off_after(since);
    assert!(off < RAMP_S + BUSY_S, "off after {off} s");
    assert_eq!(second.client.status().expect("a status").state, State::Idle);
}

/// A page with a script that hangs holds up neither the board nor the page that drives.
#[test]
fn a_page_that_does_not_read_delays_nobody() {
    // Every tick goes through program, pseudo-terminal and emulator in real time; a machine with too much to do is late
    // there, and then it is tried again.
    for _ in 0..5 {
        match beside_one_that_does_not_read() {
            Ok(()) => return,
            Err(why) => println!("late: {why}"),
        }
    }
    panic!("late five times");
}

fn beside_one_that_does_not_read() -> Result<(), UserError> {
    let (folder, rig) = (Folder::new(), Rig::start(LONG_S));
    let served = Served::start(&folder, &rig.path);
    let mut slow = served.page();
    let every = ToBoard::StreamTelemetry { decimation: 200 };
    for request in [every, ToBoard::StreamFrames { on: true }] {
        slow.client.tell(request).expect("it streams");
    }
    slow.reads.store(false, std::sync::atomic::Ordering::SeqCst);
    let mut page = served.page();
    page.client.tell(every).expect("it streams");
    page.try_drive(&rig.truth)?;
    let (mut longest, mut dropped, mut packets) = (Duration::ZERO, 0, 0);
    let began = Instant::now();
    // Until more has come than the server keeps and the system's buffers take.
    while began.elapsed() < Duration::from_secs(5) {
        let asked = Instant::now();
        page.client.command(Command::Alive)?;
        longest = longest.max(asked.elapsed());
        while let Some(message) = page.client.streamed(Duration::ZERO).expect("it streams") {
            if let shared::link::FromBoard::Telemetry(telemetry) = message {
                packets += 1;
                dropped = telemetry.dropped;
            }
        }
        thread::sleep(Duration::from_millis(10));
    }
    assert_eq!(
        (dropped, page.client.lost()),
        (0, 0),
        "of the board and of the page"
    );
    assert!(packets > 300, "{packets} in five seconds");
    // Else the drive would have been stopped for its page's silence.
    assert!(longest < Duration::from_secs(1), "{longest:?}");
    assert!(rig.truth.is_powered());
    println!("longest answer beside a page that does not read: {longest:?}");
    // It reads again: what is lost is told, and shows as a gap.
    slow.reads.store(true, std::sync::atomic::Ordering::SeqCst);
    let lost = slow.told("lost", |_| true)["frames"]
        .as_u64()
        .expect("a number");
    assert!(lost > 0);
    slow.client.status().expect("it is still let in");
    let gap = slow.client.lost();
    assert!(gap >= lost, "{gap} of {lost}");
    Ok(())
}
