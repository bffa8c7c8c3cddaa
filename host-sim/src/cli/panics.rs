//! A panic is a bug in the program. The user gets one line about it and exit code 2, like for any other failure.

use std::any::Any;
use std::panic::{self, AssertUnwindSafe};
use std::sync::Mutex;

use super::terminal::complain;

/// Where the latest panic was.
static PLACE: Mutex<Option<String>> = Mutex::new(None);

/// Keeps panics from printing; [`guard`] reports those that nothing else catches.
pub fn silence() {
    panic::set_hook(Box::new(|info| {
        let place = info.location().map(ToString::to_string);
        if let Ok(mut latest) = PLACE.lock() {
            *latest = place;
        }
    }));
}

/// Runs `work` and returns its exit code. If it panics, on this thread or on one that it waits for, the code is 2,
/// after one line on standard error.
pub fn guard(work: impl FnOnce() -> i32) -> i32 {
    panic::catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|payload| {
        let place = PLACE.lock().ok().and_then(|mut place| place.take());
        complain(&report(payload.as_ref(), place.as_deref()));
        2
    })
}

fn report(payload: &(dyn Any + Send), place: Option<&str>) -> String {
    let text = payload.downcast_ref::<String>().map(String::as_str);
    let text = text.or(payload.downcast_ref::<&str>().copied());
    let at = place.map_or(String::new(), |place| format!(" at {place}"));
    format!(
        "error: a bug in host-sim{at}: {}; please report this line and the command",
        text.unwrap_or("no message")
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_on_any_thread_is_exit_code_2() {
        assert_eq!(guard(|| 1), 1);
        assert_eq!(guard(|| panic!("here")), 2);
        let in_a_pool = || {
            rayon::join(|| panic!("on a thread"), || ());
            0
        };
        assert_eq!(guard(in_a_pool), 2);
    }

    #[test]
    fn the_report_says_what_and_where() {
        let payload = panic::catch_unwind(|| panic!("index {} of 3", 7)).unwrap_err();
        assert_eq!(
            report(payload.as_ref(), Some("src/map.rs:7:1")),
            "error: a bug in host-sim at src/map.rs:7:1: index 7 of 3; please report this line and the command"
        );
    }
}
