//! The command line.

mod arguments;
mod basins;
mod bifurcation;
mod chapter;
mod compare;
mod completions;
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
mod man;
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
mod simulate;
mod sweep;
mod terminal;
mod trials;

use std::ffi::OsString;

use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};

use arguments::request::CommandRequest;
use files::{UserError, rigfile};
use shared::model::params::preset;

use terminal::{complain, print, say};

/// Compute the frequency to run a vibro-impact hammer at, the force of its blows, and the stability of that motion.
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

/// The commands, from a list of modules: each has its `Args`, with help and examples, and its `run`. One that `answers` has
/// output options, which must know the request and are checked before it runs; one that `cites` only says in its files what
/// they were made from.
macro_rules! commands {
    ($($name:ident($module:ident) $($request:ident)?,)+) => {
        #[derive(Debug, Subcommand)]
        enum Command {
            $($name($module::Args),)+
        }

        impl Command {
            /// Gives the request to whatever writes the answer.
            fn asked(&mut self, request: CommandRequest) {
                match self {
                    $(Self::$name(_args) => { $(commands!(@$request _args, request);)? })+
                }
            }

            fn run(&self) -> Result<i32, UserError> {
                match self {
                    $(Self::$name(args) => {
                        $(commands!(@check $request args);)?
                        $module::run(args).map(ExitCode::from).map(|code| code.0)
                    })+
                }
            }
        }
    };
    (@check answers $args:ident) => { $args.output.check()? };
    (@check cites $args:ident) => {};
    (@answers $args:ident, $request:ident) => { $args.output.asked($request) };
    (@cites $args:ident, $request:ident) => { $args.made_from = $request.made_from };
}

commands! {
    Pick(pick) answers,
    Simulate(simulate) answers,
    Sweep(sweep) answers,
    Map(map) answers,
    Orbits(orbits) answers,
    Drill(drill) answers,
    Modes(modes) answers,
    Basins(basins) answers,
    Bifurcation(bifurcation) answers,
    Poincare(poincare) answers,
    Emulate(emulate) answers,
    Trials(trials) answers,
    Scenarios(scenarios),
    Replay(replay) cites,
    Link(link) cites,
    Lab(lab),
    Pil(pil),
    Chapter(chapter) answers,
    Figures(figures),
    Contact(contact) answers,
    Drop(drop) answers,
    Identify(identify) answers,
    Compare(compare) answers,
    Rig(rig),
    Rigs(rigs),
    Completions(completions),
    Man(man),
}

/// What a command ends with: 0 where it says nothing else.
struct ExitCode(i32);

impl From<()> for ExitCode {
    fn from((): ()) -> Self {
        Self(0)
    }
}

impl From<i32> for ExitCode {
    fn from(code: i32) -> Self {
        Self(code)
    }
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
        cli.command.asked(CommandRequest::new(command, given));
    }
    Ok(cli)
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
    command.run().unwrap_or_else(|error| {
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
