//! Complaints about a scenario, in one line each.

use files::UserError;
use files::rigfile::nearest;

/// The message of the TOML reader as one line, with the nearest known word in place of an unknown one.
pub fn not_understood(message: &str) -> UserError {
    let line = message.lines().next().unwrap_or("not TOML");
    let mut quoted = line.split('`').skip(1).step_by(2);
    let (unknown, missing) = (
        line.starts_with("unknown"),
        line.starts_with("missing field"),
    );
    match quoted.next() {
        Some("true_rig") if missing => UserError::new(
            "there is no rig to emulate; write a line [true_rig] and under it preset = \"wires\", or the keys of a rig file",
        ),
        Some(key) if missing => UserError::new(format!("{key} is missing; write {key} = …")),
        Some(word) if unknown => {
            let known: Vec<&str> = quoted.collect();
            let hint = nearest(word, known.iter().copied());
            let hint = match known.as_slice() {
                _ if !hint.is_empty() => hint,
                [] => "; it takes none".to_owned(),
                some => format!("; there are {}", some.join(", ")),
            };
            let what = if line.starts_with("unknown variant") {
                "word"
            } else {
                "key"
            };
            UserError::new(format!("there is no {what} '{word}' here{hint}"))
        }
        _ => {
            let mut line = line.replace('`', "'");
            for (machine, person) in [
                ("u64", "a whole number from 0"),
                ("u32", "a whole number from 0"),
                ("usize", "a whole number from 0"),
                ("f64", "a number"),
            ] {
                line = line.replace(
                    &format!("expected {machine}"),
                    &format!("expected {person}"),
                );
            }
            UserError::new(line)
        }
    }
}

/// The value of `key` is out of its range.
pub fn out_of_range(key: &str, value: f64, must_be: &str) -> UserError {
    UserError::new(format!("{key} is {value}, must be {must_be}"))
}
