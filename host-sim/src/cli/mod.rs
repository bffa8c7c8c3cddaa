//! The command line.

mod basins;
mod bifurcation;
mod choice;
mod common;
mod compare;
mod contact;
mod drive;
mod drop;
mod emit;
mod emulate;
mod figures;
mod identify;
mod link;
mod map;
mod modes;
mod orbits;
mod pick;
mod pil;
mod poincare;
mod replay;
mod rigs;
mod scenarios;
mod simulate;
mod sweep;

use std::io::{ErrorKind, Write};
use std::sync::Mutex;

use clap::{Parser, Subcommand};

use files::UserError;

/// Which frequency to run a vibro-impact hammer at, how hard it will strike, and whether it stays there.
#[derive(Debug, Parser)]
#[command(
    name = "host-sim",
    version,
    subcommand_required = true,
    arg_required_else_help = true
)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Find the frequency to run at: strongest stable 1/1, with band, margins and what the shaker must give
    Pick(pick::Args),
    /// Run at one frequency: time history, phase plane, section, regime and force
    Simulate(simulate::Args),
    /// The force curve over frequency, from rest or carried up or down
    Sweep(sweep::Args),
    /// The Peterka map: what the hammer does over gap and frequency
    Map(map::Args),
    /// Periodic orbits, stable and unstable, followed over frequency or gap, with doublings, folds and grazes
    Orbits(orbits::Args),
    /// Beam springs with more than one bending mode: force, displacement and where the energy goes
    Modes(modes::Args),
    /// Basins of attraction: which starts keep striking, and what they settle on
    Basins(basins::Args),
    /// Bifurcation diagram: displacement and force at the section over frequency, per gap, up, down and from rest
    Bifurcation(bifurcation::Args),
    /// Poincaré section with as many points as chaos needs, Lyapunov exponents, the smoothing method against the switch
    Poincare(poincare::Args),
    /// Run a scenario: the controller on an emulated rig, with verdict, log and picture
    Emulate(emulate::Args),
    /// List the built-in scenarios, or print one as a TOML file to start from
    Scenarios(scenarios::Args),
    /// Run a log through the desktop's controller: same decisions, bit for bit, or the first tick that differs
    Replay(replay::Args),
    /// Talk to a board over its serial port: status, start, stop, settings, recording, a sweep by hand
    Link(link::Args),
    /// The desktop's half of `cargo xtask pil`
    #[command(hide = true)]
    Pil(pil::Args),
    /// Make every figure of the chapter again: pictures, tables and one page to read
    Figures(figures::Args),
    /// One blow of a free mass on a wall under the four contact laws: force, restitution, energy, where each would pull
    Contact(contact::Args),
    /// Make a synthetic drop test: the hammer let go at rest falls back and strikes; noise, ringing, quantisation
    Drop(drop::Args),
    /// Contact parameters from a drop test (CSV), of any of the four laws, and how well the data fix them
    Identify(identify::Args),
    /// Measured displacement or force against simulation: laid over each other, errors printed
    Compare(compare::Args),
    /// List the rigs, or print one as a TOML file to start from
    Rigs(rigs::Args),
}

/// Runs the command line `arguments` (the program's name first) and returns the exit code: 0; 1 when an
/// expectation was not met; or 2 with one line on standard error when the input cannot be used.
pub fn run(arguments: impl IntoIterator<Item = String>) -> i32 {
    let cli = match Cli::try_parse_from(arguments) {
        Ok(cli) => cli,
        Err(error) if error.use_stderr() => {
            // Without a command, the help is the answer; a mistake gets one line.
            match error.kind() {
                clap::error::ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand => {
                    say(error.to_string().trim_end());
                }
                _ => complain(&one_line(&error.to_string())),
            }
            return 2;
        }
        Err(help) => {
            print(&help.to_string());
            return 0;
        }
    };
    let _ = ctrlc::set_handler(|| {
        if let Ok(words) = PARTING.lock()
            && let Some(words) = words.as_deref()
        {
            say(words);
        }
        // Whoever interrupts a run finds no half files.
        files::write::end(130)
    });
    let done = match cli.command {
        Command::Pick(args) => pick::run(&args).map(|()| 0),
        Command::Simulate(args) => simulate::run(&args).map(|()| 0),
        Command::Sweep(args) => sweep::run(&args).map(|()| 0),
        Command::Map(args) => map::run(&args).map(|()| 0),
        Command::Orbits(args) => orbits::run(&args).map(|()| 0),
        Command::Modes(args) => modes::run(&args).map(|()| 0),
        Command::Basins(args) => basins::run(&args).map(|()| 0),
        Command::Bifurcation(args) => bifurcation::run(&args).map(|()| 0),
        Command::Poincare(args) => poincare::run(&args).map(|()| 0),
        Command::Emulate(args) => emulate::run(&args),
        Command::Scenarios(args) => scenarios::run(&args).map(|()| 0),
        Command::Link(args) => link::run(&args).map(|()| 0),
        Command::Replay(args) => replay::run(&args),
        Command::Pil(args) => pil::run(&args),
        Command::Figures(args) => figures::run(&args).map(|()| 0),
        Command::Contact(args) => contact::run(&args).map(|()| 0),
        Command::Drop(args) => drop::run(&args).map(|()| 0),
        Command::Identify(args) => identify::run(&args).map(|()| 0),
        Command::Compare(args) => compare::run(&args).map(|()| 0),
        Command::Rigs(args) => rigs::run(&args).map(|()| 0),
    };
    match done {
        Ok(code) => code,
        Err(error) => {
            complain(&format!("error: {error}"));
            2
        }
    }
}

/// What an interrupted program says.
static PARTING: Mutex<Option<String>> = Mutex::new(None);

fn if_interrupted(words: String) {
    if let Ok(mut parting) = PARTING.lock() {
        *parting = Some(words);
    }
}

/// Writes to standard error; a reader that has gone away is no error.
fn say(text: &str) {
    let _ = writeln!(std::io::stderr().lock(), "{text}");
}

/// One line on standard error, even when a name in it has a line break.
fn complain(line: &str) {
    say(&line.replace(char::is_control, " "));
}

/// The first paragraph of clap's message, on one line, and where to read more.
fn one_line(message: &str) -> String {
    let paragraph = message.lines().take_while(|line| !line.trim().is_empty());
    let words: Vec<_> = paragraph.map(str::trim).collect();
    let tip = message
        .lines()
        .map(str::trim)
        .find(|line| line.starts_with("tip:"));
    let tip = tip.map_or(String::new(), |tip| format!(" ({tip})"));
    format!("{}{tip}; see --help", words.join(" "))
}

/// Writes to standard output; a reader that has gone away is no error.
fn print(text: &str) {
    still_read(text);
}

/// The same, and tells whether somebody still reads.
fn still_read(text: &str) -> bool {
    still_read_bytes(text.as_bytes())
}

fn still_read_bytes(bytes: &[u8]) -> bool {
    let mut out = std::io::stdout().lock();
    match out.write_all(bytes).and_then(|()| out.flush()) {
        Ok(()) => true,
        Err(error) if error.kind() == ErrorKind::BrokenPipe => false,
        Err(error) => {
            complain(&format!("error: cannot write to standard output: {error}"));
            std::process::exit(2);
        }
    }
}

/// Pretty JSON with a final newline.
fn to_json<T: serde::Serialize + ?Sized>(answer: &T) -> Result<String, UserError> {
    let text = serde_json::to_string_pretty(answer);
    text.map(|text| text + "\n")
        .map_err(|e| UserError::new(format!("cannot write JSON: {e}")))
}
