//! Running code that may panic on damaged input, without its words on the terminal.

use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind, set_hook, take_hook};
use std::sync::Once;

thread_local! {
    /// Whether a panic of this thread is caught by [`catch`].
    static CAUGHT: Cell<bool> = const { Cell::new(false) };
}

static HOOK: Once = Once::new();

/// What `run` returns; none if it panics, and then nothing is printed. The panics of other threads are printed
/// as before. A program that sets a panic hook of its own sets it before the first call.
pub fn catch<T>(run: impl FnOnce() -> T) -> Option<T> {
    HOOK.call_once(|| {
        let shown = take_hook();
        set_hook(Box::new(move |panic| {
            if !CAUGHT.get() {
                shown(panic);
            }
        }));
    });
    let outer = CAUGHT.replace(true);
    let done = catch_unwind(AssertUnwindSafe(run));
    CAUGHT.set(outer);
    done.ok()
}
