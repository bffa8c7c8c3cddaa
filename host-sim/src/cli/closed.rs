//! Whether standard output was closed when the program was started (`>&-` in a shell).
//!
//! The standard library opens `/dev/null` in place of a closed standard stream before `main`, so that an answer would
//! vanish and the program would report success. Therefore the loader calls [`note_if_closed`] before that.

use std::sync::atomic::{AtomicBool, Ordering};

static CLOSED: AtomicBool = AtomicBool::new(false);

/// Whether standard output was closed at the start. On systems other than Linux this is not known, and false.
pub fn standard_output() -> bool {
    CLOSED.load(Ordering::Relaxed)
}

/// Runs before the standard library is ready: it only makes a system call and stores a flag.
#[cfg(target_os = "linux")]
extern "C" fn note_if_closed() {
    use std::os::fd::AsFd;
    if std::io::stdout().as_fd().try_clone_to_owned().is_err() {
        CLOSED.store(true, Ordering::Relaxed);
    }
}

// Sound: the loader calls each entry of this section once, on the only thread, and `note_if_closed` needs nothing that is set up
// later.
#[cfg(target_os = "linux")]
#[allow(unsafe_code)]
#[used]
#[unsafe(link_section = ".init_array")]
static NOTE_IF_CLOSED: extern "C" fn() = note_if_closed;
