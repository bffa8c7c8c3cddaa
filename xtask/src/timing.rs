//! Processor time: of a step and of each crate that is compiled.

use std::{
    env,
    ffi::OsString,
    fs::{self, OpenOptions},
    io::Write,
    path::Path,
    process::{Command, ExitCode},
    time::{Duration, Instant},
};

use crate::JobResult;

/// Processor time of all programs that were started from here, directly or not, and have ended.
#[cfg(unix)]
pub fn of_children() -> Duration {
    use nix::sys::{
        resource::{UsageWho, getrusage},
        time::TimeVal,
    };
    let duration = |time: TimeVal| {
        let seconds = Duration::from_secs(time.tv_sec().try_into().unwrap_or(0));
        seconds + Duration::from_micros(time.tv_usec().try_into().unwrap_or(0))
    };
    getrusage(UsageWho::RUSAGE_CHILDREN).map_or(Duration::ZERO, |usage| {
        duration(usage.user_time()) + duration(usage.system_time())
    })
}

/// Zero: not measured on this system.
#[cfg(not(unix))]
pub fn of_children() -> Duration {
    Duration::ZERO
}

/// Measures time on the wall, and processor time of the programs started and ended since.
pub struct Stopwatch {
    wall: Instant,
    processor: Duration,
}

/// What they show, s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spent {
    /// By the clock on the wall.
    pub wall_s: f64,
    /// By all processors together.
    pub processor_s: f64,
}

impl Stopwatch {
    pub fn start() -> Self {
        Self {
            wall: Instant::now(),
            processor: of_children(),
        }
    }

    /// Times since the start.
    pub fn spent(&self) -> Spent {
        Spent {
            wall_s: self.wall.elapsed().as_secs_f64(),
            processor_s: of_children().saturating_sub(self.processor).as_secs_f64(),
        }
    }
}

/// Names the file to which [`rustc`] appends. Cargo starts this program in the place of rustc while it is set.
const FILE: &str = "XTASK_RUSTC_TIMES";

/// Has a cargo command write each compilation's time to `file`.
pub fn record(cargo: &mut Command, file: &Path) -> JobResult {
    fs::write(file, "")?;
    cargo
        .env("RUSTC_WRAPPER", env::current_exe()?)
        .env(FILE, file);
    Ok(())
}

/// Compiles where cargo has started this program as rustc's wrapper, and appends a line with the crate and its times.
pub fn rustc() -> Option<ExitCode> {
    let file = env::var_os(FILE)?;
    let words: Vec<OsString> = env::args_os().skip(1).collect();
    let (rustc, arguments) = words.split_first()?;
    // `cargo xtask` in a shell where the variable has been left behind.
    if Path::new(rustc).file_stem()? != "rustc" {
        return None;
    }
    let clocks = Stopwatch::start();
    let status = match Command::new(rustc).args(arguments).status() {
        Ok(status) => status,
        Err(error) => {
            eprintln!("error: cannot start {}: {error}", rustc.display());
            return Some(ExitCode::FAILURE);
        }
    };
    let Spent {
        wall_s,
        processor_s,
    } = clocks.spent();
    if let Some(name) = crate_name(arguments) {
        let line = format!("{name} {wall_s:.3} {processor_s:.3}\n");
        let opened = OpenOptions::new().append(true).open(&file);
        if let Err(error) = opened.and_then(|mut file| file.write_all(line.as_bytes())) {
            eprintln!("error: cannot write to {}: {error}", file.display());
            return Some(ExitCode::FAILURE);
        }
    }
    let code = status.code().and_then(|code| u8::try_from(code).ok());
    Some(ExitCode::from(code.unwrap_or(1)))
}

/// The crate that these arguments compile; none where rustc is only asked something.
fn crate_name(arguments: &[OsString]) -> Option<String> {
    let at = arguments.iter().position(|word| word == "--crate-name")?;
    let name = arguments.get(at + 1)?.to_str()?;
    // Cargo asks about the target under this name.
    (name != "___").then(|| name.to_owned())
}

/// A crate and what its compilations took together.
#[derive(Clone, Debug, PartialEq)]
pub struct Crate {
    /// As rustc calls it; a package's build program is `build_script_build`.
    pub name: String,
    /// In all its compilations.
    pub spent: Spent,
    /// How often it was compiled: library, program, tests.
    pub times: usize,
}

/// Sums up the file's lines by crate, the dearest first.
pub fn crates(text: &str) -> JobResult<Vec<Crate>> {
    let mut crates: Vec<Crate> = Vec::new();
    for line in text.lines() {
        let words: Vec<&str> = line.split(' ').collect();
        let &[name, wall_s, processor_s] = &words[..] else {
            return Err(format!("no crate and two times in `{line}`").into());
        };
        let (wall_s, processor_s): (f64, f64) = (wall_s.parse()?, processor_s.parse()?);
        match crates.iter_mut().find(|known| known.name == name) {
            Some(known) => {
                known.spent.wall_s += wall_s;
                known.spent.processor_s += processor_s;
                known.times += 1;
            }
            None => crates.push(Crate {
                name: name.into(),
                spent: Spent {
                    wall_s,
                    processor_s,
                },
                times: 1,
            }),
        }
    }
    crates.sort_by(|a, b| b.spent.processor_s.total_cmp(&a.spent.processor_s));
    Ok(crates)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[cfg(unix)]
    fn the_processor_time_of_a_program_is_counted_when_it_has_ended() {
        let clocks = Stopwatch::start();
        let script = "i=0; while [ $i -lt 200000 ]; do i=$((i+1)); done";
        Command::new("sh").args(["-c", script]).status().unwrap();
        assert!(clocks.spent().processor_s > 0.01);
        assert!(clocks.spent().wall_s > 0.0);
    }

    #[test]
    fn crates_are_summed_up_and_the_dearest_comes_first() {
        let crates = crates("a 1.0 0.5\nb 2.0 3.0\na 1.0 0.25\n").unwrap();
        let found: Vec<_> = crates
            .iter()
            .map(|c| (&*c.name, c.times, c.spent.processor_s))
            .collect();
        assert_eq!(found, [("b", 1, 3.0), ("a", 2, 0.75)]);
        assert!(super::crates("a 1.0").is_err());
        assert!(super::crates("a x y").is_err());
    }

    #[test]
    fn only_compilations_have_a_name() {
        let words = |line: &str| line.split(' ').map(OsString::from).collect::<Vec<_>>();
        assert_eq!(
            crate_name(&words("--crate-name clap --edition=2021")),
            Some("clap".into())
        );
        assert_eq!(crate_name(&words("- --crate-name ___ --print=cfg")), None);
        assert_eq!(crate_name(&words("-vV")), None);
    }
}
