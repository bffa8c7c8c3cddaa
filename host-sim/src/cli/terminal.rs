//! What the program writes on standard output and standard error. Nothing else in the program prints, except the
//! progress bar.

use std::io::{ErrorKind, Write};

use super::closed;

/// Writes a line on standard error; a reader that has gone away is no error.
pub fn say(text: &str) {
    let _ = writeln!(std::io::stderr().lock(), "{text}");
}

/// Writes one line on standard error, even when a name in it has a line break.
pub fn complain(line: &str) {
    say(&line.replace(char::is_control, " "));
}

/// Writes on standard output; a reader that has gone away is no error. Ends the program with code 2 if standard output
/// takes nothing for any other reason.
pub fn print(text: &str) {
    print_bytes(text.as_bytes());
}

/// As [`print`].
pub fn print_bytes(bytes: &[u8]) {
    is_read(bytes);
}

/// As [`print`]; whether somebody still reads.
pub fn print_if_read(text: &str) -> bool {
    is_read(text.as_bytes())
}

fn is_read(bytes: &[u8]) -> bool {
    if closed::standard_output() {
        complain("error: standard output is closed; redirect it to a file, or to /dev/null");
        files::write::end(2);
    }
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
