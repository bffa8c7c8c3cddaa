//! Memory that outlives a reset: a few words of RAM that the start-up code does not initialise.
//!
//! | retained | for |
//! |---|---|
//! | the last fault's record | the report after the reset |
//! | where the program crashed | the log after the reset |
//! | whether the drive was enabled | a reset or a drop of the supply in the midst of driving |
//!
//! After power-up the words are random; each entry is validated when it is read.
#![allow(unsafe_code)]

use core::{cell::UnsafeCell, mem::MaybeUninit};

use shared::control::Unfit;
use shared::fault::{FaultRecord, Persisted};

/// The drive was enabled.
const DRIVING: u32 = 0x5ad7_1e31;
/// A crash is noted.
const CRASHED: u32 = 0xc0a5_4ed1;

/// Where and how the program crashed.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct Crash {
    mark: u32,
    /// Instruction; 0: not known.
    pub address: u32,
    /// CFSR; 0 for a panic.
    pub status: u32,
}

#[repr(C)]
struct Words {
    record: Persisted,
    crash: Crash,
    drive: u32,
}

struct Retained(UnsafeCell<MaybeUninit<Words>>);

// SAFETY: plain words, touched by single volatile accesses only; an entry torn by a reset fails its check.
unsafe impl Sync for Retained {}

#[unsafe(link_section = ".uninit.retained")]
static RETAINED: Retained = Retained(UnsafeCell::new(MaybeUninit::uninit()));

fn words() -> *mut Words {
    RETAINED.0.get().cast()
}

/// What the last run left. To be read once, before anything new is written.
pub struct LastRun {
    /// The record of its last fault; `None` if there is none, or none that is whole.
    pub record: Option<FaultRecord>,
    /// Where and how it crashed; `None` if it did not.
    pub crash: Option<Crash>,
    /// Whether the drive was enabled when it ended.
    pub driving: bool,
}

/// Reads what the last run left, and forgets the crash. The drive is forgotten once what it means is recorded
/// ([`note_drive`]): the next reset may come before that.
pub fn take() -> LastRun {
    // SAFETY: the place is valid for reads, and every bit pattern is a value of these plain words.
    let (record, crash, drive) = unsafe {
        (
            (&raw const (*words()).record).read_volatile(),
            (&raw const (*words()).crash).read_volatile(),
            (&raw const (*words()).drive).read_volatile(),
        )
    };
    // SAFETY: as above.
    unsafe { (&raw mut (*words()).crash.mark).write_volatile(0) };
    LastRun {
        record: record.record(),
        crash: (crash.mark == CRASHED).then_some(crash),
        driving: drive == DRIVING,
    }
}

/// Retains a record, or that there is none.
pub fn keep(record: Option<&FaultRecord>) {
    let record = record.map_or(Persisted::EMPTY, Persisted::new);
    // SAFETY: the place is valid for writes.
    unsafe { (&raw mut (*words()).record).write_volatile(record) };
}

/// Retains whether the drive is enabled.
#[inline]
pub fn note_drive(on: bool) {
    // SAFETY: the place is valid for writes.
    unsafe { (&raw mut (*words()).drive).write_volatile(if on { DRIVING } else { 0 }) };
}

/// Retains where the program crashed.
pub fn note_crash(address: Option<u32>, status: u32) {
    end_with(&FaultRecord::CRASH);
    let crash = Crash {
        mark: CRASHED,
        address: address.unwrap_or(0),
        status,
    };
    // SAFETY: the place is valid for writes.
    unsafe { (&raw mut (*words()).crash).write_volatile(crash) };
}

/// Retains why the board is not fit to drive.
pub fn note_unfit(why: Unfit) {
    end_with(&FaultRecord::unfit(why));
}

/// The run ends with this fault, its drive off; the faults before it stay in the episode.
fn end_with(record: &FaultRecord) {
    // SAFETY: the place is valid for reads, and every bit pattern is a value of these plain words.
    let before = unsafe { (&raw const (*words()).record).read_volatile() };
    keep(Some(&record.after(before.record())));
    note_drive(false);
}
