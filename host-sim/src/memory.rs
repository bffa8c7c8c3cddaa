//! Memory that the system refuses: one line and exit code 2, and no half-written file stays.
//!
//! This needs `unsafe`. Without it a program out of memory is aborted by the standard library, with its temporary files left
//! behind; the stable standard library offers no safe way to change that.
#![allow(unsafe_code)]

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::io::Write;
use std::sync::atomic::{AtomicBool, Ordering};

/// The system's memory; the program ends when there is none left.
struct Memory;

#[global_allocator]
static MEMORY: Memory = Memory;

// SAFETY: every call goes to `System` as it came, and what `System` returns is returned unless it is null; so the
// promises of `System` are kept. `found` neither unwinds nor returns a null pointer.
unsafe impl GlobalAlloc for Memory {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the caller keeps the promises of `GlobalAlloc::alloc`.
        found(unsafe { System.alloc(layout) })
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the caller keeps the promises of `GlobalAlloc::alloc_zeroed`.
        found(unsafe { System.alloc_zeroed(layout) })
    }

    unsafe fn realloc(&self, old: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        // SAFETY: the caller keeps the promises of `GlobalAlloc::realloc`.
        found(unsafe { System.realloc(old, layout, size) })
    }

    unsafe fn dealloc(&self, old: *mut u8, layout: Layout) {
        // SAFETY: the caller keeps the promises of `GlobalAlloc::dealloc`.
        unsafe { System.dealloc(old, layout) }
    }
}

#[inline]
fn found(memory: *mut u8) -> *mut u8 {
    if memory.is_null() {
        no_memory()
    }
    memory
}

thread_local! {
    /// Whether this thread already ends the program.
    static ENDING: Cell<bool> = const { Cell::new(false) };
}

/// One line, written without memory; temporary files go; the program ends.
#[cold]
fn no_memory() -> ! {
    static ENDED: AtomicBool = AtomicBool::new(false);
    if ENDING.replace(true) {
        // Even ending takes memory that is not there.
        exit_now()
    }
    if ENDED.swap(true, Ordering::SeqCst) {
        // Another thread ends the program.
        loop {
            std::thread::park();
        }
    }
    let line = b"error: not enough memory; ask for less at a time, or raise the memory limit (ulimit -v)\n";
    let _ = std::io::stderr().write_all(line);
    files::write::abandon();
    exit_now()
}

#[cfg(unix)]
fn exit_now() -> ! {
    // SAFETY: `_exit` takes any code, and touches no memory of the program.
    unsafe { libc::_exit(2) }
}

#[cfg(not(unix))]
fn exit_now() -> ! {
    std::process::exit(2)
}
