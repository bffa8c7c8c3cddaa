//! Starting other programs, and saying so.

use std::{
    ffi::OsStr,
    io::{BufRead, BufReader},
    path::{Path, PathBuf},
    process::{Child, Command, ExitStatus, Stdio},
    sync::{
        Arc,
        atomic::{AtomicUsize, Ordering},
    },
    thread,
    time::Duration,
};

use crate::{
    JobResult,
    liveness::{self, ProgramWatch},
};

/// The root of the project.
pub fn root() -> PathBuf {
    let own =
        std::env::var_os("CARGO_MANIFEST_DIR").unwrap_or_else(|| env!("CARGO_MANIFEST_DIR").into());
    let mut root = PathBuf::from(own);
    root.pop();
    root
}

/// The cargo that started us (or the one in the path), to be run in the root.
pub fn cargo() -> Command {
    let mut command = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    command.current_dir(root());
    command
}

/// Prints the command as a person would type it.
pub fn announce(command: &Command) {
    let quote = |word: &OsStr| {
        let word = word.to_string_lossy();
        if word.contains(' ') {
            format!("'{word}'")
        } else {
            word.into_owned()
        }
    };
    let mut line = String::from("$");
    for (name, value) in command.get_envs() {
        if let Some(value) = value {
            line += &format!(" {}={}", name.to_string_lossy(), quote(value));
        }
    }
    for word in std::iter::once(command.get_program()).chain(command.get_args()) {
        line.push(' ');
        line += &quote(word);
    }
    println!("{line}");
}

/// The program's file name, for messages.
fn program(command: &Command) -> String {
    let name = Path::new(command.get_program()).file_name();
    name.unwrap_or(command.get_program())
        .to_string_lossy()
        .into_owned()
}

fn spawn(command: &mut Command) -> JobResult<Child> {
    let program = program(command);
    command
        .spawn()
        .map_err(|e| format!("cannot start {program}: {e}").into())
}

/// How often a running program is looked at.
const LOOK: Duration = Duration::from_millis(20);

/// Runs to the end; a non-zero exit is an error, and so is one that does nothing any more.
pub fn run(command: &mut Command) -> JobResult {
    announce(command);
    let mut watch = watch(command)?;
    let mut child = spawn(command)?;
    let status = wait(&mut child, &program(command), &mut watch, || 0)?;
    passed(command, status)
}

/// Runs to the end, however long a person leaves it alone.
pub fn run_attended(command: &mut Command) -> JobResult {
    announce(command);
    let status = spawn(command)?.wait()?;
    passed(command, status)
}

fn passed(command: &Command, status: ExitStatus) -> JobResult {
    if status.success() {
        Ok(())
    } else {
        Err(format!("{} ended with {status}", program(command)).into())
    }
}

/// Runs like [`run`], passes the standard output on line by line, and returns it.
pub fn run_tee(command: &mut Command, echo: bool) -> JobResult<Vec<String>> {
    tee(command, watch(command)?, echo)
}

/// The usual watch; cargo may wait for another cargo.
fn watch(command: &Command) -> Result<ProgramWatch, String> {
    let watch = ProgramWatch::new()?;
    Ok(if program(command).starts_with("cargo") {
        watch.waiting_alone()
    } else {
        watch
    })
}

/// Runs like [`run_tee`], but gives the program up when `watch` says so.
pub fn tee(command: &mut Command, mut watch: ProgramWatch, echo: bool) -> JobResult<Vec<String>> {
    announce(command);
    let name = program(command);
    let mut child = spawn(command.stdin(Stdio::null()).stdout(Stdio::piped()))?;
    let output = child.stdout.take().ok_or("no pipe to the program")?;
    let count = Arc::new(AtomicUsize::new(0));
    let counted = Arc::clone(&count);
    let reader = thread::spawn(move || {
        let mut lines = Vec::new();
        for line in BufReader::new(output).split(b'\n').map_while(Result::ok) {
            let line = String::from_utf8_lossy(&line).trim_end().to_owned();
            if echo {
                println!("{line}");
            }
            lines.push(line);
            counted.store(lines.len(), Ordering::Relaxed);
        }
        lines
    });
    let status = wait(&mut child, &name, &mut watch, || {
        count.load(Ordering::Relaxed)
    })?;
    let lines = reader
        .join()
        .map_err(|_| "the reader of the program's output failed")?;
    if !status.success() && !echo {
        lines.iter().for_each(|line| println!("{line}"));
    }
    passed(command, status)?;
    Ok(lines)
}

/// Waits for the end; a program the watch gives up is ended, with all it has started.
fn wait(
    child: &mut Child,
    name: &str,
    watch: &mut ProgramWatch,
    lines: impl Fn() -> usize,
) -> JobResult<ExitStatus> {
    let mut looks: u32 = 0;
    loop {
        if let Some(status) = child.try_wait()? {
            return Ok(status);
        }
        // Reading the process table takes longer than asking for the end.
        looks = looks.wrapping_add(1);
        if looks.is_multiple_of(25)
            && let Err(reason) = watch.look(child.id(), lines())
        {
            liveness::end(child);
            return Err(format!("{name} {reason}").into());
        }
        thread::sleep(LOOK);
    }
}

/// A program's standard output; on failure the last line it wrote, an error of apt's rather than a warning.
pub fn output(command: &mut Command) -> JobResult<String> {
    let program = program(command);
    let output = command
        .stdin(Stdio::null())
        .output()
        .map_err(|e| format!("cannot start {program}: {e}"))?;
    if output.status.success() {
        return Ok(String::from_utf8_lossy(&output.stdout).into_owned());
    }
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    let mut lines = said.lines().map(str::trim).rev();
    let reason = lines.find(|line| !line.is_empty());
    let ended = || format!("{program} ended with {}", output.status);
    Err(reason.map_or_else(ended, str::to_owned).into())
}

/// A program's standard output, trimmed; `None` if it is not there or fails.
pub fn ask(command: &mut Command) -> Option<String> {
    output(command).ok().map(|text| text.trim().to_owned())
}

/// Removes a folder with all that is in it, if it is there.
pub fn remove_folder(folder: &Path) -> JobResult {
    if folder.exists() {
        std::fs::remove_dir_all(folder)?;
    }
    Ok(())
}

/// Finds a program in the path.
pub fn find(program: &str) -> Option<PathBuf> {
    let path = std::env::var_os("PATH")?;
    std::env::split_paths(&path)
        .map(|folder| folder.join(program))
        .find(|file| file.is_file())
}

#[cfg(test)]
mod tests {
    use std::time::Instant;

    use super::*;

    #[test]
    fn the_root_holds_the_workspace() {
        assert!(root().join("xtask/Cargo.toml").is_file());
    }

    #[test]
    fn a_failure_is_told_by_the_last_line_of_what_went_wrong() {
        let script = "echo 'slow' >&2; echo 'no such package' >&2; echo >&2; exit 100";
        let error = output(Command::new("sh").args(["-c", script])).unwrap_err();
        assert_eq!(error.to_string(), "no such package");
    }

    const SECOND: Duration = Duration::from_secs(1);

    fn shell(script: &str, patience: Duration, limit: Option<Duration>) -> JobResult<Vec<String>> {
        let watch = ProgramWatch::with(patience, limit);
        tee(Command::new("sh").args(["-c", script]), watch, false)
    }

    #[test]
    fn output_is_returned_and_failure_is_an_error() {
        let lines = run_tee(Command::new("sh").args(["-c", "echo one; echo two"]), false);
        assert_eq!(lines.unwrap(), ["one", "two"]);
        assert!(run_tee(Command::new("sh").args(["-c", "exit 3"]), false).is_err());
    }

    #[test]
    fn what_is_silent_and_idle_is_ended_with_all_it_started() {
        // The inner shell would write the file after it has been left alone for long enough.
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("survived");
        let script = format!("(sleep 4; echo > '{}') & sleep 600", file.display());
        let start = Instant::now();
        let error = shell(&script, SECOND, None).unwrap_err().to_string();
        assert!(error.starts_with("sh was given up: no output"), "{error}");
        thread::sleep((6 * SECOND).saturating_sub(start.elapsed()));
        assert_eq!(file.exists(), cfg!(not(target_os = "linux")));
    }

    /// Another process in the tree is what makes the difference.
    #[test]
    #[cfg(target_os = "linux")]
    fn what_may_wait_alone_is_ended_only_with_company() {
        let ends = |script: &str| {
            let watch = ProgramWatch::with(SECOND, None).waiting_alone();
            let ended = tee(Command::new("sh").args(["-c", script]), watch, false);
            ended.map_err(|error| error.to_string())
        };
        assert_eq!(ends("exec sleep 4"), Ok(Vec::new()));
        assert!(ends("sleep 600; :").unwrap_err().contains("was given up"));
    }

    /// Only Linux tells here what a process tree has used.
    #[test]
    #[cfg(target_os = "linux")]
    fn what_is_silent_and_busy_goes_on() {
        let busy =
            "end=$(($(date +%s) + 6)); while [ $(date +%s) -lt $end ]; do :; done; echo done";
        assert_eq!(shell(busy, 3 * SECOND, None).unwrap(), ["done"]);
    }

    #[test]
    fn what_writes_goes_on() {
        let writes = "for i in 1 2 3 4 5 6 7 8 9 10; do echo $i; sleep 0.5; done";
        assert_eq!(shell(writes, 3 * SECOND, None).unwrap().len(), 10);
    }

    #[test]
    fn a_limit_ends_what_is_busy() {
        let error = shell("while :; do :; done", 60 * SECOND, Some(SECOND));
        let error = error.unwrap_err().to_string();
        assert!(error.contains("had not ended after 1 s"), "{error}");
    }
}
