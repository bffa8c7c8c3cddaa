//! The command line.

mod arguments;
mod basins;
mod bifurcation;
mod chapter;
mod compare;
mod contact;
mod coverage;
mod drill;
mod drop;
mod emulate;
mod figures;
mod identify;
mod interrupt;
mod lab;
mod link;
mod map;
mod modes;
mod orbits;
#[cfg(test)]
mod pages;
mod panics;
mod pick;
mod pil;
mod poincare;
mod replay;
mod rig;
mod rigs;
mod scenarios;
mod shell;
mod simulate;
mod sweep;
mod terminal;
mod trials;

use std::ffi::OsString;

use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};

use arguments::output::OutputArgs;
use arguments::request::Request;
use files::rigfile;
use shared::model::params::preset;

use terminal::{complain, print, say};

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
    #[command(
        after_help = "Examples:\n  host-sim pick\n  host-sim pick --rig mine.toml --report mine.html\n  host-sim pick --max-force-n 70 --max-frequency-hz 3.5\n  host-sim pick --beside wires,amplitude_mm=1.2\n  host-sim pick --gap 0:2.4:0.4\n  host-sim pick --over contact_stiffness_n_per_m=1e6:1e7:log5\n  host-sim pick --objective rop --threshold-n 50"
    )]
    Pick(pick::Args),
    /// Run at one frequency: time history, phase plane, section, regime and force
    #[command(
        after_help = "Examples:\n  host-sim simulate --ratio 2 --out out\n  host-sim simulate --gap 2.4 --frequency 4.9 --initial -2,0"
    )]
    Simulate(simulate::Args),
    /// The force curve over frequency, from rest or carried up or down
    #[command(
        after_help = "Examples:\n  host-sim sweep --ratio 0.8:4.5:0.01 --direction up --out out\n  host-sim sweep --ratio 2 --over contact_stiffness_n_per_m=1e5:1e7:log20"
    )]
    Sweep(sweep::Args),
    /// The Peterka map: what the hammer does over gap and frequency
    #[command(
        after_help = "Examples:\n  host-sim map --gap 0:3:0.5 --ratio 1:4:0.25\n  host-sim map --direction up --cycles 300 --transient 200 --out out"
    )]
    Map(map::Args),
    /// Periodic orbits, stable and unstable, followed over frequency or gap, with doublings, folds and grazes
    #[command(
        after_help = "Examples:\n  host-sim orbits --gap 1 --ratio 1:2.5\n  host-sim orbits --curves --gap 0:1:0.5 --ratio 1:3\n  host-sim orbits --curve gap_mm=0:3 --periods 1 --impacts 1 --out out\n  host-sim orbits --curve contact_stiffness_n_per_m=1e6:1e8:log --ratio 1:3"
    )]
    Orbits(orbits::Args),
    /// Ground that gives way: rate of penetration over frequency and gap, where it is largest, and the feed it needs
    #[command(
        after_help = "Examples:\n  host-sim drill --threshold-n 25\n  host-sim drill --threshold-n 25 --bit-mass-kg 0.1\n  host-sim drill --threshold-n 50 --gap 0:2:0.25 --format csv > drill.csv\n  host-sim drill --published"
    )]
    Drill(drill::Args),
    /// Beam springs with more than one bending mode: force, displacement and where the energy goes
    #[command(
        after_help = "Examples:\n  host-sim modes --rig beam-170 --ratio 1.6:2.4:0.05 --modes 1,3"
    )]
    Modes(modes::Args),
    /// Basins of attraction: which initial conditions lead to impact, and what they settle on
    #[command(
        after_help = "Examples:\n  host-sim basins --ratio 2 --gap-ratio 2 --grid 100 --out out\n  host-sim basins --chapter --out out"
    )]
    Basins(basins::Args),
    /// Bifurcation diagram: displacement and force at the section over frequency, per gap, up, down and from rest
    #[command(
        after_help = "Examples:\n  host-sim bifurcation --gap 1 --ratio 1.4:4:0.01 --direction all --out out"
    )]
    Bifurcation(bifurcation::Args),
    /// Poincaré section with thousands of points, Lyapunov exponents, the smoothing method compared with the switch
    #[command(
        after_help = "Examples:\n  host-sim poincare --gap 2.4 --ratio 2.7 --points 2000 --out out"
    )]
    Poincare(poincare::Args),
    /// Run a scenario: the controller on an emulated rig, with verdict, log and picture
    #[command(after_help = "Examples:\n  host-sim emulate\n  host-sim emulate field --out out")]
    Emulate(emulate::Args),
    /// Run the controller on many rigs that differ at random from what it believes: how soon it holds, how hard it strikes
    #[command(after_help = "Examples:\n  host-sim trials --count 20\n  host-sim trials --long")]
    Trials(trials::Args),
    /// List the built-in scenarios, or print one as a TOML file to start from
    #[command(
        after_help = "Examples:\n  host-sim scenarios\n  host-sim scenarios field > mine.toml"
    )]
    Scenarios(scenarios::Args),
    /// Run a log through the controller again: the same decisions, bit for bit, or the first tick that differs
    #[command(after_help = "Examples:\n  host-sim replay out/field.parquet")]
    Replay(replay::Args),
    /// Talk to a board over its serial port: status, start, stop, settings, recording, a sweep by hand
    #[command(
        after_help = "Examples:\n  host-sim link /dev/ttyACM0 status\n  host-sim link /dev/ttyACM0 --page\n  host-sim link /dev/ttyACM0 sweep --from-hz 3 --to-hz 4 --step-hz 0.1 --csv curve.csv"
    )]
    Link(link::Args),
    /// Open the page in a browser: explore a rig, run an emulated one, watch a board
    #[command(
        after_help = "Examples:\n  host-sim lab\n  host-sim lab --port 8420 --no-open\n\nThe page of a board: host-sim link PORT --page"
    )]
    Lab(lab::Args),
    /// The desktop's half of `cargo xtask pil`
    #[command(hide = true)]
    Pil(pil::Args),
    /// What the chapter says, statement by statement: its words, the figure computed here, same or different
    #[command(
        after_help = "Examples:\n  host-sim chapter\n  host-sim chapter --coarse --format csv > chapter.csv"
    )]
    Chapter(chapter::Args),
    /// Make every figure of the chapter again: pictures, tables and one page to read
    #[command(
        after_help = "Examples:\n  host-sim figures --coarse --out out/figures\n  host-sim figures --only 3.24 --out out/figures"
    )]
    Figures(figures::Args),
    /// One impact of a free mass on a wall under each contact law: force, restitution, energy, where a law would pull
    #[command(
        after_help = "Examples:\n  host-sim contact --speed 0.1\n  host-sim contact --figure-3-3"
    )]
    Contact(contact::Args),
    /// Make a synthetic drop test: the released hammer falls back and strikes; with noise, ringing, quantisation
    #[command(after_help = "Examples:\n  host-sim drop --noise-n 0.2 --format csv > drop.csv")]
    Drop(drop::Args),
    /// Identify the contact parameters of any contact law from a drop test (CSV), with 95 % intervals
    #[command(after_help = "Examples:\n  host-sim identify drop.csv --misfit force --out out")]
    Identify(identify::Args),
    /// Compare measured displacement or force with a simulation: both curves, and the errors
    #[command(
        after_help = "Examples:\n  host-sim compare record.csv --from-s 2 --to-s 10 --out out"
    )]
    Compare(compare::Args),
    /// Write the file of a rig of one's own from what can be measured: weights, lengths, times
    #[command(
        after_help = "Examples:\n  host-sim rig new mine.toml\n  host-sim rig new mine.toml --support wires --mass 298g --swings 20 --swing-time 10.99s --stroke 1.8mm --cart-mass 5.4kg --surface steel"
    )]
    Rig(rig::Args),
    /// List the rigs, or print one as a TOML file to start from
    #[command(after_help = "Examples:\n  host-sim rigs\n  host-sim rigs wires > mine.toml")]
    Rigs(rigs::Args),
    /// Print what a shell needs to complete commands and options
    #[command(
        after_help = "Examples:\n  host-sim completions bash > ~/.local/share/bash-completion/completions/host-sim"
    )]
    Completions(shell::CompletionsArgs),
    /// Write the manual as pages for `man`
    #[command(after_help = "Examples:\n  host-sim man ~/.local/share/man/man1")]
    Man(shell::ManArgs),
}

/// Runs the command line `arguments` (the program's name first) and returns the exit code: 0; 1 when a run did not
/// come out as expected; 2, with one line on standard error, when it failed; 130 when it was interrupted.
pub fn run(arguments: impl IntoIterator<Item = OsString>) -> i32 {
    panics::silence();
    #[cfg(unix)]
    file_size_limit_is_an_error();
    let arguments: Vec<OsString> = arguments.into_iter().collect();
    panics::guard(|| match parsed(&arguments) {
        Ok(cli) => {
            interrupt::install();
            execute(&cli.command)
        }
        Err(error) => without_command(&error, &arguments),
    })
}

/// The parser. A negative number is a value everywhere, so that its refusal names the option.
fn parser() -> clap::Command {
    fn with_negative_numbers(command: clap::Command) -> clap::Command {
        command
            .mut_args(|arg| {
                let takes_values = arg.get_action().takes_values();
                arg.allow_negative_numbers(takes_values)
            })
            .mut_subcommands(with_negative_numbers)
    }
    with_negative_numbers(Cli::command())
}

/// The command line, with the request as a whole in the output options of its command.
fn parsed(arguments: &[OsString]) -> Result<Cli, clap::Error> {
    let mut parser = parser();
    let matches = parser.try_get_matches_from_mut(arguments)?;
    let mut cli = Cli::from_arg_matches(&matches).map_err(|e| e.format(&mut parser))?;
    if let Some((name, given)) = matches.subcommand()
        && let Some(command) = parser.find_subcommand(name)
    {
        cli.command.asked(Request::new(command, given));
    }
    Ok(cli)
}

impl Command {
    /// Gives the request to whatever writes the answer.
    fn asked(&mut self, request: Request) {
        match self.output() {
            Some(output) => output.asked(request),
            None => match self {
                Self::Replay(args) => args.made_from = request.made_from,
                Self::Link(args) => args.made_from = request.made_from,
                _ => {}
            },
        }
    }

    /// Where the answer goes; none where a command makes no files of its own name.
    fn output(&mut self) -> Option<&mut OutputArgs> {
        match self {
            Self::Pick(args) => Some(&mut args.output),
            Self::Simulate(args) => Some(&mut args.output),
            Self::Sweep(args) => Some(&mut args.output),
            Self::Map(args) => Some(&mut args.output),
            Self::Orbits(args) => Some(&mut args.output),
            Self::Drill(args) => Some(&mut args.output),
            Self::Modes(args) => Some(&mut args.output),
            Self::Basins(args) => Some(&mut args.output),
            Self::Bifurcation(args) => Some(&mut args.output),
            Self::Poincare(args) => Some(&mut args.output),
            Self::Trials(args) => Some(&mut args.output),
            Self::Chapter(args) => Some(&mut args.output),
            Self::Contact(args) => Some(&mut args.output),
            Self::Drop(args) => Some(&mut args.output),
            Self::Identify(args) => Some(&mut args.output),
            Self::Compare(args) => Some(&mut args.output),
            Self::Emulate(args) => Some(&mut args.output),
            Self::Scenarios(_)
            | Self::Replay(_)
            | Self::Link(_)
            | Self::Lab(_)
            | Self::Pil(_)
            | Self::Figures(_)
            | Self::Rig(_)
            | Self::Rigs(_)
            | Self::Completions(_)
            | Self::Man(_) => None,
        }
    }
}

/// Beyond a limit on the size of files (`ulimit -f`) a write then fails, where the signal would end the program without
/// a word.
#[cfg(unix)]
fn file_size_limit_is_an_error() {
    use signal_hook::{consts::SIGXFSZ, flag};
    let came = std::sync::Arc::default();
    // Without it, the limit still holds.
    let _ = flag::register(SIGXFSZ, came);
}

fn execute(command: &Command) -> i32 {
    let done = match command {
        Command::Pick(args) => pick::run(args).map(|()| 0),
        Command::Simulate(args) => simulate::run(args).map(|()| 0),
        Command::Sweep(args) => sweep::run(args).map(|()| 0),
        Command::Map(args) => map::run(args).map(|()| 0),
        Command::Orbits(args) => orbits::run(args).map(|()| 0),
        Command::Drill(args) => drill::run(args).map(|()| 0),
        Command::Modes(args) => modes::run(args).map(|()| 0),
        Command::Basins(args) => basins::run(args).map(|()| 0),
        Command::Bifurcation(args) => bifurcation::run(args).map(|()| 0),
        Command::Poincare(args) => poincare::run(args).map(|()| 0),
        Command::Emulate(args) => emulate::run(args),
        Command::Trials(args) => trials::run(args).map(|()| 0),
        Command::Scenarios(args) => scenarios::run(args).map(|()| 0),
        Command::Link(args) => link::run(args),
        Command::Lab(args) => lab::run(args),
        Command::Replay(args) => replay::run(args),
        Command::Pil(args) => pil::run(args),
        Command::Chapter(args) => chapter::run(args).map(|()| 0),
        Command::Figures(args) => figures::run(args).map(|()| 0),
        Command::Contact(args) => contact::run(args).map(|()| 0),
        Command::Drop(args) => drop::run(args).map(|()| 0),
        Command::Identify(args) => identify::run(args).map(|()| 0),
        Command::Compare(args) => compare::run(args).map(|()| 0),
        Command::Rig(args) => rig::run(args).map(|()| 0),
        Command::Rigs(args) => rigs::run(args).map(|()| 0),
        Command::Completions(args) => {
            shell::completions(args, Cli::command());
            Ok(0)
        }
        Command::Man(args) => shell::man(args, Cli::command()).map(|()| 0),
    };
    done.unwrap_or_else(|error| {
        complain(&format!("error: {error}"));
        2
    })
}

/// Help and version are answers; a mistake gets one line.
fn without_command(error: &clap::Error, arguments: &[OsString]) -> i32 {
    if !error.use_stderr() {
        print(&error.to_string());
        return 0;
    }
    match error.kind() {
        ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand => say(error.to_string().trim_end()),
        _ => complain(&one_line(error, arguments)),
    }
    2
}

/// How to write a value that has a decimal comma, unless the message says so.
fn comma(error: &clap::Error) -> Option<String> {
    let Some(ContextValue::String(value)) = error.get(ContextKind::InvalidValue) else {
        return None;
    };
    files::decimal::comma(value).filter(|_| !error.to_string().contains(" with a point"))
}

/// The first paragraph of clap's message, on one line, what may have been meant, and where to read more.
fn one_line(error: &clap::Error, arguments: &[OsString]) -> String {
    let parser = Cli::command();
    let (name, command) = asked_for(&parser, arguments);
    let message = error.to_string();
    let paragraph = message.lines().take_while(|line| !line.trim().is_empty());
    let words: Vec<_> = paragraph.map(str::trim).collect();
    // What the parsers of numbers say of themselves.
    let words = (words.join(" "))
        .replace("invalid float literal", "write a number, such as 3.5")
        .replace("invalid digit found in string", "write a whole number")
        .replace("is not in 0..=", "must be a whole number from 0 to ");
    let tip = || {
        let tips = message.lines().map(str::trim);
        let tip = tips.clone().find(|line| line.starts_with("tip:"));
        let tip = tip.map(str::to_owned).or_else(|| comma(error));
        tip.map_or(String::new(), |tip| format!(" ({tip})"))
    };
    let word = |kind| match error.get(kind) {
        Some(ContextValue::String(word)) => word.as_str(),
        _ => "",
    };
    let tip = match error.kind() {
        ErrorKind::InvalidSubcommand => {
            meant_command(command, word(ContextKind::InvalidSubcommand))
        }
        ErrorKind::UnknownArgument => meant_option(command, word(ContextKind::InvalidArg)),
        _ => tip(),
    };
    format!("{words}{tip}; see {name} --help")
}

/// The command that `arguments` name, and how it is called.
fn asked_for<'a>(parser: &'a clap::Command, arguments: &[OsString]) -> (String, &'a clap::Command) {
    let (mut name, mut command) = ("host-sim".to_owned(), parser);
    for word in arguments.iter().skip(1).filter_map(|word| word.to_str()) {
        if let Some(found) = command.find_subcommand(word) {
            name = format!("{name} {word}");
            command = found;
        }
    }
    (name, command)
}

/// The command that `word` may have meant.
fn meant_command(command: &clap::Command, word: &str) -> String {
    let shown = command.get_subcommands().filter(|c| !c.is_hide_set());
    rigfile::nearest(word, shown.map(clap::Command::get_name))
}

/// The option that `word` may have meant; a word that is none may be a rig.
fn meant_option(command: &clap::Command, word: &str) -> String {
    let shown = command.get_arguments().filter(|arg| !arg.is_hide_set());
    let options: Vec<String> = shown
        .filter_map(|arg| Some(format!("--{}", arg.get_long()?)))
        .collect();
    let is_rig = preset(word).is_some() || word.ends_with(".toml");
    if is_rig && options.iter().any(|option| option == "--rig") {
        return format!(" (a rig is given with --rig {word})");
    }
    rigfile::nearest(word, options.iter().map(String::as_str))
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    use super::*;

    #[test]
    fn every_command_has_examples_and_they_can_be_read() {
        for command in Cli::command()
            .get_subcommands()
            .filter(|c| !c.is_hide_set())
        {
            let name = command.get_name();
            let help = command.get_after_help().map(ToString::to_string);
            let help = help.unwrap_or_default();
            let mut examples = help
                .lines()
                .filter_map(|line| line.strip_prefix("  host-sim "))
                .peekable();
            assert!(examples.peek().is_some(), "{name}");
            for example in examples {
                let words = example.split(" > ").next().unwrap_or(example);
                assert!(words.starts_with(name), "{example}");
                let line = std::iter::once("host-sim").chain(words.split_whitespace());
                if let Err(error) = Cli::try_parse_from(line) {
                    panic!("{example}: {error}");
                }
            }
        }
    }

    /// Names that are no longer shown are still read.
    #[test]
    fn old_names_of_options_are_read() {
        for line in [
            "map --gap 0 --ratio 2 --from up",
            "compare record.csv --from 2 --to 3",
            "link port sweep --from 3 --to 4 --step 0.1 --out curve.csv",
        ] {
            let words = std::iter::once("host-sim").chain(line.split_whitespace());
            assert!(Cli::try_parse_from(words).is_ok(), "{line}");
        }
    }
}
