//! The independent watchdog (RM0390, chapter 21), on the LSI. Prescaler and reload take effect some cycles of the LSI after
//! they are written, and the LSI runs once the watchdog is started, or RCC has switched it on; until then it counts from
//! 0xfff, with the prescaler that it had.

use super::{Access, NEVER, UNITS_PER_S, UNITS_PER_US, Write};

/// How long the LSI takes to start (DS10693, 6.3.9).
const LSI_DELAY: u64 = 20 * UNITS_PER_US;
/// Cycles of the LSI until a value has arrived.
const ARRIVAL: u64 = 5;

const PRESCALER: usize = 0;
const RELOAD: usize = 1;

/// The independent watchdog with its registers.
#[derive(Clone, Debug)]
pub struct Watchdog {
    /// Prescaler and reload as they were written, as they are in effect, and when the one becomes the other.
    written: [u32; 2],
    active: [u32; 2],
    arrives_at: [Option<u64>; 2],
    unlocked: bool,
    lsi_runs: bool,
    started: bool,
    /// The count at `since`.
    count: u32,
    since: u64,
    /// The LSI's frequency, Hz: 17 to 47 kHz on a real part.
    pub lsi_hz: u64,
}

impl Watchdog {
    /// The watchdog after a reset, not started, on an LSI of `lsi_hz`.
    pub fn new(lsi_hz: u64) -> Self {
        Self {
            written: [0, 0xfff],
            active: [0, 0xfff],
            arrives_at: [None; 2],
            unlocked: false,
            lsi_runs: false,
            started: false,
            count: 0xfff,
            since: 0,
            lsi_hz,
        }
    }

    /// Cycles of the LSI per count.
    fn divider(&self) -> u64 {
        4 << self.active[PRESCALER].min(6)
    }

    fn ends_at(&self) -> u64 {
        self.since + self.divider() * u64::from(self.count) * UNITS_PER_S / self.lsi_hz
    }

    /// When it resets the board, or its prescaler changes.
    pub fn next(&self) -> u64 {
        if !self.started {
            return NEVER;
        }
        self.ends_at()
            .min(self.arrives_at[PRESCALER].unwrap_or(NEVER))
    }

    /// Goes on to `now`; true if it resets the board.
    pub fn run(&mut self, now: u64) -> bool {
        if let Some(at) = self.arrives_at[PRESCALER].filter(|at| *at <= now) {
            if self.started {
                let counts = (at - self.since) * self.lsi_hz / (self.divider() * UNITS_PER_S);
                self.count = self.count.saturating_sub(counts as u32);
                self.since = at;
            }
            self.arrives_at[PRESCALER] = None;
            self.active[PRESCALER] = self.written[PRESCALER];
        }
        if self.arrives_at[RELOAD].is_some_and(|at| at <= now) {
            self.arrives_at[RELOAD] = None;
            self.active[RELOAD] = self.written[RELOAD];
        }
        self.started && now >= self.ends_at()
    }

    /// The LSI runs from now on: what was written before arrives.
    pub fn run_lsi(&mut self, now: u64) {
        if !self.lsi_runs {
            self.lsi_runs = true;
            let at = now + LSI_DELAY + self.arrival();
            self.arrives_at = self.arrives_at.map(|pending| pending.map(|_| at));
        }
    }

    fn arrival(&self) -> u64 {
        ARRIVAL * UNITS_PER_S / self.lsi_hz
    }

    /// Moves its end by a time that it stood still.
    pub fn freeze(&mut self, by: u64) {
        self.since += by;
    }

    /// Reads the register at `offset`, its flags as they are at `now`.
    pub fn read(&self, offset: u32, now: u64) -> Access<u32> {
        Ok(match offset {
            0x00 => 0,
            0x04 => self.written[PRESCALER],
            0x08 => self.written[RELOAD],
            0x0c => {
                let updating = |i: usize| self.arrives_at[i].is_some_and(|at| now < at);
                u32::from(updating(PRESCALER)) | u32::from(updating(RELOAD)) << 1
            }
            _ => return Err("is not modelled".into()),
        })
    }

    /// Writes the register at `w.offset`.
    pub fn write(&mut self, w: Write) -> Access {
        self.run(w.now);
        match w.offset {
            0x00 => match w.ones() {
                0x5555 => self.unlocked = true,
                0xaaaa => {
                    self.unlocked = false;
                    self.count = self.active[RELOAD];
                    self.since = w.now;
                }
                0xcccc => {
                    self.unlocked = false;
                    if !self.started {
                        self.started = true;
                        self.since = w.now;
                        self.run_lsi(w.now);
                    }
                }
                other => return Err(format!("key {other:#x} is none")),
            },
            0x04 | 0x08 => {
                if !self.unlocked {
                    return Err("is written without the key 0x5555".into());
                }
                let i = w.offset as usize / 4 - 1;
                if self.arrives_at[i].is_some() {
                    return Err("is written while PVU or RVU is set (21.4.4)".into());
                }
                self.written[i] = w.over(self.written[i], [7, 0xfff][i])?;
                self.arrives_at[i] = Some(if self.lsi_runs {
                    w.now + self.arrival()
                } else {
                    NEVER
                });
            }
            _ => return Err("is not modelled".into()),
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn write(dog: &mut Watchdog, offset: u32, value: u32, now: u64) -> Access {
        dog.write(Write {
            offset,
            value,
            mask: !0,
            now,
        })
    }

    #[test]
    fn two_seconds_from_the_last_feeding() {
        let mut dog = Watchdog::new(32_000);
        write(&mut dog, 8, 5, 0).unwrap_err();
        write(&mut dog, 0, 0xcccc, 0).unwrap();
        write(&mut dog, 0, 0x5555, 0).unwrap();
        write(&mut dog, 4, 4, 0).unwrap();
        write(&mut dog, 8, 1000, 10).unwrap();
        write(&mut dog, 8, 1000, 20).unwrap_err();
        assert_eq!(dog.read(0x0c, 20), Ok(3));
        write(&mut dog, 0, 0xaaaa, 2 * UNITS_PER_S / 10).unwrap();
        assert_eq!(dog.next(), 2 * UNITS_PER_S / 10 + 2 * UNITS_PER_S);
    }

    #[test]
    fn set_before_it_is_started_it_counts_from_its_top() {
        let mut dog = Watchdog::new(32_000);
        write(&mut dog, 0, 0x5555, 0).unwrap();
        write(&mut dog, 4, 6, 0).unwrap();
        write(&mut dog, 8, 10, 0).unwrap();
        // Nothing has arrived, so it is not fed with 10.
        write(&mut dog, 0, 0xaaaa, 0).unwrap();
        assert_eq!(dog.read(0x0c, UNITS_PER_S), Ok(3));
        write(&mut dog, 0, 0xcccc, UNITS_PER_S).unwrap();
        let arrival = dog.next();
        assert!(arrival < UNITS_PER_S + UNITS_PER_S / 1000 && !dog.run(arrival));
        // Then 0xfff less one count of 4 cycles, with 256: more than half a minute.
        assert_eq!((dog.next() - arrival) / UNITS_PER_S, 32);
        write(&mut dog, 0, 0xaaaa, 2 * UNITS_PER_S).unwrap();
        assert_eq!(dog.next(), 2 * UNITS_PER_S + 80 * UNITS_PER_S / 1000);
        // The prescaler that it has: 4, until another arrives.
        let mut dog = Watchdog::new(32_000);
        write(&mut dog, 0, 0xcccc, 0).unwrap();
        assert_eq!(dog.next(), 4 * 0xfff * UNITS_PER_S / 32_000);
    }
}
