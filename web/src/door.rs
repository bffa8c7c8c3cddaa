//! How the page's scripts call in. A script asks for room ([`room`]), writes a function's name and its argument into it,
//! calls ([`call`]), and reads the answer where [`answer`] says. `web/page/common/engine.js` is the other side.
//!
//! The names below are the module's exports, which Rust counts as unsafe: two of the same name would be one too many.
#![allow(
    unsafe_code,
    reason = "an exported name is an unsafe attribute; nothing else here is"
)]

use std::cell::RefCell;
use std::sync::{Mutex, Once, PoisonError};

thread_local! {
    static ROOM: RefCell<Vec<u8>> = const { RefCell::new(Vec::new()) };
    static ANSWER: RefCell<Vec<u8>> = const { RefCell::new(Vec::new()) };
}

/// Where the program broke off, if it did.
static BROKE: Mutex<Vec<u8>> = Mutex::new(Vec::new());
static HOOK: Once = Once::new();

/// Room for `bytes` bytes: a name and the argument after it.
#[unsafe(no_mangle)]
pub extern "C" fn room(bytes: usize) -> *mut u8 {
    HOOK.call_once(|| {
        std::panic::set_hook(Box::new(|panic| {
            let mut broke = BROKE.lock().unwrap_or_else(PoisonError::into_inner);
            *broke = panic.to_string().into_bytes();
        }));
    });
    ROOM.with_borrow_mut(|room| {
        room.clear();
        room.resize(bytes, 0);
        room.as_mut_ptr()
    })
}

/// Calls the function whose name is the first `name` bytes of the room, with the rest as its argument. 1 if the answer is
/// one, 0 if it is a line that says what is wrong.
#[unsafe(no_mangle)]
pub extern "C" fn call(name: usize) -> u32 {
    let given = ROOM.take();
    let (name, argument) = given.split_at_checked(name).unwrap_or_default();
    let (good, answer) = match std::str::from_utf8(name) {
        Ok(name) => match crate::call(name, argument) {
            Ok(answer) => (1, answer),
            Err(line) => (0, line.into_bytes()),
        },
        Err(_) => (0, b"the name of the function is no text".to_vec()),
    };
    ANSWER.set(answer);
    good
}

/// Where the answer begins.
#[unsafe(no_mangle)]
pub extern "C" fn answer() -> *const u8 {
    ANSWER.with_borrow(|answer| answer.as_ptr())
}

/// How long it is.
#[unsafe(no_mangle)]
pub extern "C" fn answer_bytes() -> usize {
    ANSWER.with_borrow(Vec::len)
}

/// Where the line begins that says where the program broke off: for a script whose call was trapped.
#[unsafe(no_mangle)]
pub extern "C" fn broke() -> *const u8 {
    BROKE
        .lock()
        .unwrap_or_else(PoisonError::into_inner)
        .as_ptr()
}

/// How long it is.
#[unsafe(no_mangle)]
pub extern "C" fn broke_bytes() -> usize {
    BROKE.lock().unwrap_or_else(PoisonError::into_inner).len()
}
