//! Runs of `emulate` that are broken off, or that are too much for a picture.

use serde_json::Value;

use crate::emulate::STOPPED;
use crate::support::{Folder, assert_svg_shows};
#[cfg(unix)]
use crate::support::{finish, wait};

/// Interrupted, a run leaves neither a log nor a piece of one.
#[cfg(unix)]
#[test]
fn an_interrupted_run_leaves_nothing() {
    for signal in ["-INT", "-QUIT"] {
        interrupted(signal);
    }
}

#[cfg(unix)]
fn interrupted(signal: &str) {
    use std::process::{Command, Stdio};
    use std::time::{Duration, Instant};

    let long = STOPPED.replace("duration_s = 2.0", "duration_s = 20000.0");
    let folder = Folder::new().with("long.toml", long);
    let mut command = folder.command(&["emulate", "long.toml", "--out", "out"]);
    let child = command
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let began = Instant::now();
    while folder.names().len() < 3 {
        assert!(began.elapsed() < Duration::from_secs(60), "no log is begun");
        std::thread::sleep(Duration::from_millis(20));
    }
    let mut interrupt = Command::new("kill");
    interrupt.args([signal, &child.id().to_string()]);
    assert_eq!(finish(interrupt).code, Some(0));
    assert_eq!(wait(child).code(), Some(130));
    assert_eq!(folder.names(), ["long.toml"]);
}

/// A picture that is too much for the drawing library must not cost the verdict.
#[test]
fn ten_thousand_events_have_a_verdict_a_log_and_a_picture() {
    let mut many = STOPPED.to_owned();
    for k in 0..10_000 {
        many += &format!(
            "[[events]]\nat_s = {}\nkind = \"cart-friction\"\ncoulomb_n = 1.0\n",
            0.3 + 1.5e-4 * f64::from(k)
        );
    }
    let folder = Folder::new().with("stopped.toml", many);
    folder.run("emulate stopped.toml --out out").well();
    let verdict: Value = serde_json::from_str(&folder.read("out/stopped.json")).unwrap();
    assert_eq!(verdict["verdict"], "pass");
    assert_svg_shows(&folder.read("out/stopped.svg"), &["more", "amplitude, mm"]);
    folder.run("replay out/stopped.parquet").well();
}
