//! The processor in the loop: the firmware's image under QEMU against the emulator's plant on the desktop.
//!
//! Two pipes join them. The desktop's half (`host-sim pil`) runs the plant and a controller of its own, and
//! compares; QEMU runs the image. What either has to say is printed as it comes.

use std::{
    path::{Path, PathBuf},
    process::{Child, Command, Stdio},
    thread,
    time::Duration,
};

use clap::Args;

use crate::{
    JobResult, boards,
    command::{self, announce},
    desktop::{self, Build},
    firmware,
    liveness::{self, ProgramWatch},
    qemu,
};

/// How long one side may do nothing after the other has ended.
const AFTER: Duration = Duration::from_secs(20);

/// Which scenario is run with the processor in the loop, and how often.
#[derive(Args, Clone, Debug, PartialEq)]
pub struct PilPlan {
    /// Scenario, by name or file
    #[arg(long, default_value = "field")]
    pub scenario: String,
    /// Rig time of each run, s; the scenario's if left out
    #[arg(long)]
    pub seconds: Option<String>,
    /// Runs, each with the next seed
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..))]
    pub runs: u32,
}

impl PilPlan {
    /// What every change is checked with: half of the field scenario, to Hold and on (90 s), a crash with the reset and
    /// the record after it (30 s), and ten runs of 10 s of a beam rig, each with its own noise.
    pub fn checks() -> [Self; 3] {
        let plan = |scenario: &str, seconds: Option<&str>, runs| Self {
            scenario: scenario.into(),
            seconds: seconds.map(Into::into),
            runs,
        };
        [
            plan("field", Some("90"), 1),
            plan("crash", None, 1),
            plan("held-beam-135", Some("10"), 10),
        ]
    }

    fn options(&self, pipes: &Pipes) -> Vec<String> {
        let mut words: Vec<String> = ["pil", "--scenario", &self.scenario]
            .map(String::from)
            .into();
        words.extend(["--runs".into(), self.runs.to_string()]);
        if let Some(seconds) = &self.seconds {
            words.extend(["--seconds".into(), seconds.clone()]);
        }
        words.extend(["--requests".into(), text(&pipes.requests)]);
        words.extend(["--replies".into(), text(&pipes.replies)]);
        words
    }
}

fn text(path: &Path) -> String {
    path.display().to_string()
}

/// Two named pipes in a folder of their own, removed in the end.
struct Pipes {
    folder: PathBuf,
    requests: PathBuf,
    replies: PathBuf,
}

impl Pipes {
    fn new() -> JobResult<Self> {
        let folder = std::env::temp_dir().join(format!("vibro-pil-{}", std::process::id()));
        std::fs::create_dir_all(&folder)?;
        let pipes = Self {
            requests: folder.join("requests"),
            replies: folder.join("replies"),
            folder,
        };
        for pipe in [&pipes.requests, &pipes.replies] {
            command::run(Command::new("mkfifo").arg(pipe)).map_err(|e| {
                format!("{e}; pipes with names are needed, as Linux and macOS have")
            })?;
        }
        Ok(pipes)
    }
}

impl Drop for Pipes {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.folder);
    }
}

/// Builds both halves and runs them.
pub fn run(plan: &PilPlan, build: &Build) -> JobResult {
    firmware::build_named(boards::QEMU)?;
    let program = desktop::program("host-sim", build)?;
    let pipes = Pipes::new()?;
    let arguments = format!(
        "enable=on,target=native,arg=pil,arg={},arg={}",
        text(&pipes.requests),
        text(&pipes.replies)
    );
    let mut image = qemu::command("pil", &arguments)?;
    let mut desktop = Command::new(program);
    desktop.current_dir(command::root());
    desktop.args(plan.options(&pipes));
    announce(&image);
    announce(&desktop);
    let start = |command: &mut Command| {
        let child = command.stdin(Stdio::null()).spawn();
        child.map_err(|e| format!("cannot start {}: {e}", command.get_program().display()))
    };
    let mut image = start(&mut image)?;
    let mut desktop = match start(&mut desktop) {
        Ok(desktop) => desktop,
        Err(error) => {
            image.kill()?;
            return Err(error.into());
        }
    };
    both(&mut image, &mut desktop)
}

/// Waits for both; sides that do nothing any more, or one that goes on without the other, are ended.
fn both(image: &mut Child, desktop: &mut Child) -> JobResult {
    let mut watches = [
        (
            ProgramWatch::new()?.working_at_most(2 * qemu::MOST_WORK),
            "QEMU",
            image.id(),
        ),
        (ProgramWatch::new()?, "the desktop", desktop.id()),
    ];
    let mut left_alone = false;
    loop {
        let (image_ended, desktop_ended) = (image.try_wait()?, desktop.try_wait()?);
        if let (Some(image), Some(desktop)) = (image_ended, desktop_ended) {
            return match (desktop.success(), image.success()) {
                (true, true) => Ok(()),
                (false, _) => Err("the processor in the loop differs or broke off".into()),
                (true, false) => Err(format!("QEMU ended with {image}").into()),
            };
        }
        if !left_alone && (image_ended.is_some() || desktop_ended.is_some()) {
            // What is left to do is to see the closed pipe, and to print.
            left_alone = true;
            for (watch, ..) in &mut watches {
                *watch = ProgramWatch::with(AFTER, None).working_at_most(2 * qemu::MOST_WORK);
            }
        }
        let running = [image_ended.is_none(), desktop_ended.is_none()];
        for ((watch, name, process), _) in watches.iter_mut().zip(running).filter(|(_, on)| *on) {
            if let Err(reason) = watch.look(*process, 0) {
                liveness::end(image);
                liveness::end(desktop);
                return Err(format!("{name} {reason}").into());
            }
        }
        thread::sleep(Duration::from_millis(100));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(clap::Parser)]
    struct Asked {
        #[command(flatten)]
        plan: PilPlan,
    }

    fn plan(words: &[&str]) -> Result<PilPlan, String> {
        let asked = <Asked as clap::Parser>::try_parse_from(["pil"].iter().chain(words));
        asked.map(|asked| asked.plan).map_err(|e| e.to_string())
    }

    #[test]
    fn options_are_read_and_passed_on() {
        let whole = plan(&["--scenario", "field", "--seconds", "2.5", "--runs", "3"]).unwrap();
        assert_eq!(whole.runs, 3);
        let pipes = Pipes {
            folder: PathBuf::from("nowhere"),
            requests: "a".into(),
            replies: "b".into(),
        };
        let words = whole.options(&pipes).join(" ");
        assert_eq!(
            words,
            "pil --scenario field --runs 3 --seconds 2.5 --requests a --replies b"
        );
        let usual = plan(&[]).unwrap();
        assert_eq!(
            (&*usual.scenario, usual.seconds, usual.runs),
            ("field", None, 1)
        );
        let none = plan(&["--runs", "0"]).unwrap_err();
        assert!(none.contains("--runs") && none.contains('0'), "{none}");
        assert!(plan(&["--runs"]).is_err());
        assert!(plan(&["--speed", "9"]).unwrap_err().contains("--speed"));
    }
}
