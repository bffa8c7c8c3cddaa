//! Opening a serial port so that whatever ends the program leaves it free.
//!
//! The exclusive flag of a terminal (TIOCEXCL) outlives the program that set it where somebody else keeps the terminal
//! open, as the emulator does with its pseudo-terminal: after an interrupt every ordinary user would find it busy. So it
//! is not set. A lock on the open file (flock) says who uses the port; the system drops it with the program.

#[cfg(unix)]
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{self, ErrorKind, Write};
#[cfg(unix)]
use std::os::unix::fs::OpenOptionsExt;
use std::time::Duration;

use serialport::{ClearBuffer, SerialPort};

use files::UserError;

/// Longest time a read waits, so that no patience is exceeded.
const READ_WAIT: Duration = Duration::from_millis(5);

/// Opens the serial port (or pseudo-terminal) `name` for this program alone.
///
/// # Errors
/// If the port does not exist, may not be used or is in use.
pub fn open_alone(name: &str, baud: u32) -> Result<Box<dyn SerialPort>, UserError> {
    if is_used(name) {
        return Err(UserError::new(format!("cannot open {name}: {IN_USE}")));
    }
    let port = open(name, baud)?;
    // Leftovers of an earlier conversation.
    let _ = port.clear(ClearBuffer::Input);
    Ok(port)
}

/// Writes `bytes` to the port `name` as another program that uses it has set it up (its rate, above all); the answers are that
/// program's. False, and nothing is written, if nobody uses it.
///
/// # Errors
/// If the port may not be used, or breaks.
pub fn write_beside_another(name: &str, bytes: &[u8]) -> Result<bool, UserError> {
    if !is_used(name) {
        return Ok(false);
    }
    let broken =
        |e: io::Error| UserError::new(format!("cannot write to {name}: {e}; check the cable"));
    // It holds the port alone by a lock that says nothing about writing.
    raw(name, bytes).map_err(broken)?;
    Ok(true)
}

const IN_USE: &str =
    "another program uses it; close that and try again (`link PORT stop` works nevertheless)";

fn open(name: &str, baud: u32) -> Result<Box<dyn SerialPort>, UserError> {
    let port = serialport::new(name, baud)
        .timeout(READ_WAIT)
        .exclusive(false)
        .open();
    port.map_err(|e| UserError::new(format!("cannot open {name}: {e}; {}", mend(&e))))
}

/// Whether another program holds a lock on the port. False, too, if that cannot be found out: opening it says why.
#[cfg(unix)]
fn is_used(name: &str) -> bool {
    let Ok(file) = unlocked(name) else {
        return false;
    };
    // Dropped again with the file: the port's own lock, which others may share, is taken when it is opened.
    matches!(file.try_lock(), Err(TryLockError::WouldBlock))
}

/// The system lets one program at a time open a port.
#[cfg(not(unix))]
fn is_used(_name: &str) -> bool {
    false
}

#[cfg(unix)]
fn unlocked(name: &str) -> io::Result<File> {
    OpenOptions::new()
        .read(true)
        .write(true)
        .custom_flags(libc::O_NOCTTY | libc::O_NONBLOCK)
        .open(name)
}

#[cfg(unix)]
fn raw(name: &str, bytes: &[u8]) -> io::Result<()> {
    unlocked(name)?.write_all(bytes)
}

#[cfg(not(unix))]
fn raw(_name: &str, _bytes: &[u8]) -> io::Result<()> {
    Err(ErrorKind::ResourceBusy.into())
}

fn mend(error: &serialport::Error) -> String {
    match error.kind() {
        // What the lock's failure comes as.
        serialport::ErrorKind::NoDevice if error.description.contains("lock") => IN_USE.to_owned(),
        serialport::ErrorKind::Io(ErrorKind::ResourceBusy) => IN_USE.to_owned(),
        serialport::ErrorKind::NoDevice | serialport::ErrorKind::Io(ErrorKind::NotFound) => {
            ports_here()
        }
        serialport::ErrorKind::Io(ErrorKind::PermissionDenied) => {
            "you may not use it: join its group (often dialout) and log in anew".to_owned()
        }
        _ => format!("it is not a serial port; {}", ports_here()),
    }
}

fn ports_here() -> String {
    let ports = serialport::available_ports().unwrap_or_default();
    let names: Vec<_> = ports.into_iter().map(|port| port.port_name).collect();
    if names.is_empty() {
        "this computer has none now: plug the board in".to_owned()
    } else {
        format!("ports here: {}", names.join(", "))
    }
}
