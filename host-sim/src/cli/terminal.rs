//! What the program writes on standard output and standard error. Nothing else in the program prints, except the
//! progress bar.

use std::io::{ErrorKind, Write};

/// Writes a line on standard error; a reader that has gone away is no error.
pub fn say(text: &str) {
    let _ = writeln!(std::io::stderr().lock(), "{text}");
}

/// Writes one line on standard error, even when a name in it has a line break, and no longer than a person reads.
pub fn complain(line: &str) {
    say(&in_short(&line.replace(char::is_control, " ")));
}

/// `line` with numbers of more than 20 digits as powers of ten, and the middle of what is very long left out.
fn in_short(line: &str) -> String {
    const MOST_DIGITS: usize = 20;
    const MOST: usize = 2000;
    let short = |word: &str| -> String {
        let number = word.trim_matches(|c: char| !c.is_ascii_digit() && c != '-');
        // Not a part of a name.
        let digits = |c: char| c.is_ascii_digit() || !(c.is_alphanumeric() || c == '/');
        match number.parse::<f64>() {
            Ok(x) if number.len() > MOST_DIGITS && word.chars().all(digits) => {
                let six: f64 = format!("{x:.5e}").parse().unwrap_or(x);
                word.replace(number, &format!("{six:e}"))
            }
            _ => without_middle(word, 300),
        }
    };
    let words: Vec<_> = line.split(' ').map(short).collect();
    without_middle(&words.join(" "), MOST)
}

/// `text` with at most `most` characters, the first and the last of it.
fn without_middle(text: &str, most: usize) -> String {
    let count = text.chars().count();
    if count <= most {
        return text.to_owned();
    }
    let half = most / 2;
    let first: String = text.chars().take(half).collect();
    let last: String = text.chars().skip(count - half).collect();
    format!("{first}…{last}")
}

/// Writes on standard output; a reader that has gone away is no error. Ends the program with code 2 if standard output
/// takes nothing for any other reason.
pub fn print(text: &str) {
    print_bytes(text.as_bytes());
}

/// Writes bytes on standard output, with errors as [`print`] has them.
pub fn print_bytes(bytes: &[u8]) {
    is_read(bytes);
}

/// As [`print`]; whether somebody still reads.
pub fn print_if_read(text: &str) -> bool {
    is_read(text.as_bytes())
}

fn is_read(bytes: &[u8]) -> bool {
    let mut out = std::io::stdout().lock();
    match out.write_all(bytes).and_then(|()| out.flush()) {
        Ok(()) => true,
        Err(error) if error.kind() == ErrorKind::BrokenPipe => false,
        Err(error) => {
            complain(&format!("error: cannot write to standard output: {error}"));
            files::write::end(2)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_as_long_as_a_person_reads() {
        let whole = format!(
            "--gap is {} (-{}), {}",
            1e308, 1e-300, 5.494505494505495e-10
        );
        assert_eq!(in_short(&whole), "--gap is 1e308 (-1e-300), 5.49451e-10");
        for plain in ["0.1, 1e300", "2026112312345678901234567.csv: no", "-3"] {
            assert_eq!(in_short(plain), plain);
        }
        let key = in_short(&format!("unknown key '{}'; see", "ä".repeat(100_000)));
        assert!(
            key.chars().count() < 330 && key.ends_with("ä'; see"),
            "{key}"
        );
        let words = in_short(&"so many ".repeat(100_000));
        assert!(words.chars().count() < 2010, "{words}");
    }
}
