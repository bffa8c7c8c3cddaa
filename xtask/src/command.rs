//! Starting other programs, and saying so.

use std::{
    ffi::OsStr,
    io::{BufRead, BufReader},
    path::PathBuf,
    process::{Child, Command, Stdio},
    thread,
    time::{Duration, Instant},
};

use crate::Outcome;

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
    let name = std::path::Path::new(command.get_program()).file_name();
    name.unwrap_or(command.get_program())
        .to_string_lossy()
        .into_owned()
}

fn spawn(command: &mut Command) -> Outcome<Child> {
    let program = program(command);
    command
        .spawn()
        .map_err(|e| format!("cannot start {program}: {e}").into())
}

/// Runs to the end; a non-zero exit is an error.
pub fn run(command: &mut Command) -> Outcome {
    announce(command);
    let status = spawn(command)?.wait()?;
    if status.success() {
        Ok(())
    } else {
        Err(format!("{} ended with {status}", program(command)).into())
    }
}

/// Runs like [`run`], passes the standard output on line by line, and returns it.
///
/// A program that has not ended when `limit` is over is killed, which is an error.
pub fn run_tee(command: &mut Command, limit: Duration, echo: bool) -> Outcome<Vec<String>> {
    announce(command);
    let name = program(command);
    let mut child = spawn(command.stdin(Stdio::null()).stdout(Stdio::piped()))?;
    let output = child.stdout.take().ok_or("no pipe to the program")?;
    let reader = thread::spawn(move || {
        let mut lines = Vec::new();
        for line in BufReader::new(output).split(b'\n').map_while(Result::ok) {
            let line = String::from_utf8_lossy(&line).trim_end().to_owned();
            if echo {
                println!("{line}");
            }
            lines.push(line);
        }
        lines
    });
    let deadline = Instant::now() + limit;
    let status = loop {
        if let Some(status) = child.try_wait()? {
            break status;
        }
        if Instant::now() >= deadline {
            child.kill()?;
            child.wait()?;
            return Err(format!("{name} had not ended after {} s", limit.as_secs()).into());
        }
        thread::sleep(Duration::from_millis(20));
    };
    let lines = reader
        .join()
        .map_err(|_| "the reader of the program's output failed")?;
    if status.success() {
        Ok(lines)
    } else {
        if !echo {
            lines.iter().for_each(|line| println!("{line}"));
        }
        Err(format!("{name} ended with {status}").into())
    }
}

/// A program's standard output, trimmed; `None` if it is not there or fails.
pub fn ask(command: &mut Command) -> Option<String> {
    let output = command
        .stdin(Stdio::null())
        .stderr(Stdio::null())
        .output()
        .ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    output.status.success().then(|| text.trim().to_owned())
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
    use super::*;

    #[test]
    fn the_root_holds_the_workspace() {
        assert!(root().join("xtask/Cargo.toml").is_file());
    }

    #[test]
    fn output_is_returned_and_failure_is_an_error() {
        let long = Duration::from_secs(20);
        let lines = run_tee(
            Command::new("sh").args(["-c", "echo one; echo two"]),
            long,
            false,
        );
        assert_eq!(lines.unwrap(), ["one", "two"]);
        assert!(run_tee(Command::new("sh").args(["-c", "exit 3"]), long, false).is_err());
    }

    #[test]
    fn what_does_not_end_is_ended() {
        let start = Instant::now();
        let error = run_tee(
            Command::new("sleep").arg("30"),
            Duration::from_millis(100),
            false,
        );
        assert!(
            error
                .unwrap_err()
                .to_string()
                .contains("sleep had not ended")
        );
        assert!(start.elapsed() < Duration::from_secs(10));
    }
}
