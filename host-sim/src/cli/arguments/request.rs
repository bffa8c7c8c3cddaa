//! The command line as a value: what answers say they were made from, and what their files are called.

use clap::parser::ValueSource;
use clap::{Arg, ArgAction, ArgMatches};
use files::made_from::{InputFile, MadeFrom};
use serde_json::{Map, Value};

/// Options that only say where and how to answer, and with how many threads: they change no number.
const ASIDE: [&str; 11] = [
    "help", "version", "format", "out", "quiet", "threads", "only", "no_log", "show", "csv",
    "report",
];

/// What a command line asks for.
#[derive(Clone, Debug, Default)]
pub struct CommandRequest {
    /// As answers carry it; the command adds the rigs.
    pub made_from: MadeFrom,
    /// Name of the command, with which the names of its files begin.
    pub command: String,
    /// The options given, by their names, with the values given; a switch has none.
    pub given: Vec<(String, Vec<String>)>,
}

impl CommandRequest {
    /// The request of `matches`, which `command` read.
    pub fn new(command: &clap::Command, matches: &ArgMatches) -> Self {
        let mut request = Self {
            made_from: MadeFrom::this_program(),
            command: command.get_name().to_owned(),
            given: Vec::new(),
        };
        let mut words = vec!["host-sim".to_owned(), request.command.clone()];
        request.read(command, matches, &mut words);
        if let Some((name, given)) = matches.subcommand()
            && let Some(command) = command.find_subcommand(name)
        {
            words.push(name.to_owned());
            request.read(command, given, &mut words);
        }
        request.made_from.command = words.join(" ");
        request.made_from.seed = request
            .made_from
            .options
            .get("seed")
            .and_then(Value::as_u64);
        request
    }

    /// Takes up the options of `matches`, which `command` read, and adds them to the `words` of the command line.
    fn read(&mut self, command: &clap::Command, matches: &ArgMatches, words: &mut Vec<String>) {
        let ours = command.get_arguments().filter(|arg| {
            let id = arg.get_id().as_str();
            !ASIDE.contains(&id)
        });
        for arg in ours {
            let id = arg.get_id().as_str();
            self.made_from.has_cart |= id == "cart";
            let Some(values) = values(matches, id) else {
                continue;
            };
            // `emulate NAME` and `emulate --scenario NAME` are one request.
            let long = arg.get_long().filter(|long| *long != "scenario");
            let id = if id == "scenario" { "name" } else { id };
            let name = long.map_or_else(|| id.replace('_', "-"), str::to_owned);
            let made = &mut self.made_from;
            made.options
                .insert(name.replace('-', "_"), typed(arg, &values));
            if matches.value_source(arg.get_id().as_str()) != Some(ValueSource::CommandLine) {
                continue;
            }
            made.inputs
                .extend(values.iter().filter_map(|v| InputFile::at(v)));
            let switch = matches!(arg.get_action(), ArgAction::SetTrue);
            let long = long.map(|long| format!("--{long}"));
            if switch {
                words.extend(long);
                self.given.push((name, Vec::new()));
                continue;
            }
            for value in &values {
                words.extend(long.clone());
                words.push(quoted(value));
            }
            self.given.push((name, values));
        }
    }
}

/// The values of an option, given or by default, as text; none if it has none.
fn values(matches: &ArgMatches, id: &str) -> Option<Vec<String>> {
    let raw = matches.try_get_raw(id).ok()??;
    let values = raw.map(|value| value.to_string_lossy().into_owned());
    Some(values.collect())
}

/// Values as JSON: numbers and truth as such.
fn typed(arg: &Arg, values: &[String]) -> Value {
    let one = |text: &String| -> Value {
        if let Ok(whole) = text.parse::<i64>() {
            return whole.into();
        }
        match text.parse::<f64>() {
            Ok(x) if x.is_finite() => x.into(),
            _ if text == "true" => true.into(),
            _ if text == "false" => false.into(),
            _ => text.as_str().into(),
        }
    };
    match (arg.get_action(), values) {
        (ArgAction::Append, _) | (_, [_, _, ..]) => values.iter().map(one).collect(),
        (_, [value]) => one(value),
        (_, []) => Value::Null,
    }
}

/// A word as a shell takes it.
fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_alphanumeric() || "-_=.,:/+%@".contains(c);
    if !word.is_empty() && word.chars().all(plain) {
        return word.to_owned();
    }
    format!("'{}'", word.replace('\'', "'\\''"))
}

/// `values` as a JSON object, for the uncertainty of an answer.
pub fn object<const N: usize>(values: [(&str, f64); N]) -> Map<String, Value> {
    let values = values.into_iter();
    values
        .map(|(key, value)| (key.to_owned(), value.into()))
        .collect()
}
