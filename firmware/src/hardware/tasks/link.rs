//! The link task: bytes from and to the wire.

use core::sync::atomic::{AtomicU32, Ordering};

use cortex_m::peripheral::DWT;
use rtic::Mutex;
use shared::{forecast::Forecast, link::Session};

use crate::{hardware::board, link_device::BoardLink, recorder::ControlRecorder, wire::RateFinder};

/// Bytes waiting for the wire at most.
const QUEUE: usize = 4096;

/// Requests served in a turn at most, and bytes looked at: a computer that floods the wire loses requests, and no task its
/// time. One that waits for its answers has one request on the way.
const REQUESTS: u32 = 4;
const BYTES: usize = 512;

/// Turns of the task (wraps).
static TURNS: AtomicU32 = AtomicU32::new(0);

/// Turns since the start (wraps).
pub fn turns() -> u32 {
    TURNS.load(Ordering::Relaxed)
}

/// What the task owns.
pub struct Link {
    serial: board::Serial,
    rate: RateFinder,
    timer: board::LinkTimer,
    session: Session<QUEUE>,
    store: board::FlashStore,
    turns: u32,
    boot: u32,
}

impl Link {
    /// The link's state at the start: no session, nothing sent yet.
    pub(super) fn new(
        serial: board::Serial,
        timer: board::LinkTimer,
        store: board::FlashStore,
    ) -> Self {
        Self {
            serial,
            rate: RateFinder::default(),
            timer,
            session: Session::new(),
            store,
            turns: 0,
            boot: 0,
        }
    }

    /// Serves the link. Whether it is time for the supervisor: every tenth turn.
    #[inline]
    pub fn turn(
        &mut self,
        recorder: &mut impl Mutex<T = ControlRecorder>,
        forecast: &mut impl Mutex<T = Forecast>,
    ) -> bool {
        self.timer.acknowledge();
        let before = self.session.counters().good;
        for _ in 0..BYTES {
            let served = self.session.counters().good.wrapping_sub(before);
            if served >= REQUESTS || !recorder.lock(|recorder| recorder.takes_commands()) {
                break;
            }
            let Some(byte) = self.serial.read() else {
                break;
            };
            if self.boot == 0 {
                // Processor cycles until a program on a computer first sent something: never the same twice.
                self.boot = DWT::cycle_count() | 1;
            }
            let mut device = BoardLink {
                recorder: &mut *recorder,
                forecast: &mut *forecast,
                settings_store: &mut self.store,
                board: board::NAME,
                boot: self.boot,
            };
            self.session.receive(byte, &mut device);
        }
        let mut device = BoardLink {
            recorder,
            forecast,
            settings_store: &mut self.store,
            board: board::NAME,
            boot: self.boot,
        };
        self.session.poll(&mut device);
        self.serial.send(|bytes| self.session.queue().drain(bytes));
        let good = self.session.counters().good;
        if let Some(baud) = self.rate.turn(self.serial.take_errors(), good) {
            self.serial.set_rate(baud);
        }
        TURNS.fetch_add(1, Ordering::Relaxed);
        self.turns = self.turns.wrapping_add(1);
        self.turns.is_multiple_of(10)
    }
}
