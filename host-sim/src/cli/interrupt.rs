//! What an interrupt (Ctrl-C, SIGQUIT, SIGTERM, SIGHUP) does: it ends the program at once with code 130 and leaves no half
//! files. A command that has something to finish first asks for it with [`finish_first`].

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};

use super::terminal::say;

/// Exit code of an interrupted program.
pub const CODE: i32 = 130;

/// What the program says when it is interrupted.
static PARTING: Mutex<Option<String>> = Mutex::new(None);
/// The command wants to finish something first.
static FINISHES: AtomicBool = AtomicBool::new(false);
/// An interrupt came, and the command is finishing.
static INTERRUPTED: AtomicBool = AtomicBool::new(false);

/// Catches interrupts from now on. Without a handler one still ends the program, only with no clearing up.
#[cfg(unix)]
pub fn install() {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGQUIT, SIGTERM};
    let signals = [SIGHUP, SIGINT, SIGQUIT, SIGTERM];
    if let Ok(mut signals) = signal_hook::iterator::Signals::new(signals) {
        std::thread::spawn(move || signals.forever().for_each(|_| came()));
    }
}

/// Catches Ctrl-C from now on, where a signal can set a flag and no more.
#[cfg(not(unix))]
pub fn install() {
    let flag = std::sync::Arc::new(AtomicBool::new(false));
    let caught = signal_hook::flag::register(signal_hook::consts::SIGINT, flag.clone());
    if caught.is_ok() {
        std::thread::spawn(move || {
            loop {
                std::thread::sleep(std::time::Duration::from_millis(50));
                if flag.swap(false, Ordering::SeqCst) {
                    came();
                }
            }
        });
    }
}

fn came() {
    if FINISHES.load(Ordering::SeqCst) && !INTERRUPTED.swap(true, Ordering::SeqCst) {
        return;
    }
    if let Ok(words) = PARTING.lock()
        && let Some(words) = words.as_deref()
    {
        say(words);
    }
    files::write::end(CODE)
}

/// Has the program say `words` if it is interrupted.
pub fn say_then(words: String) {
    if let Ok(mut parting) = PARTING.lock() {
        *parting = Some(words);
    }
}

/// Leaves the first interrupt to the command, which looks at [`interrupted`]; a second one ends the program at once.
pub fn finish_first() {
    FINISHES.store(true, Ordering::SeqCst);
}

/// Whether an interrupt has come since [`finish_first`].
pub fn interrupted() -> bool {
    INTERRUPTED.load(Ordering::SeqCst)
}
