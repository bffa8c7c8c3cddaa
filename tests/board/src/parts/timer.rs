//! The timers TIM2, TIM3, TIM6 and TIM7 (RM0390, chapters 17 and 20): counting up, prescaler, reload with and without
//! preload, update event as flag, interrupt, DMA request and trigger output, PWM as a duty cycle. Not modelled:
//! capture, other compare modes, one pulse, down and centre counting, slave mode.

use super::{Access, NEVER, Write};

/// A timer with its registers and its count.
#[derive(Clone, Debug)]
pub struct Timer {
    /// Whether its clock is on.
    clocked: bool,
    basic: bool,
    /// The largest count: of 16 or 32 bits.
    top: u32,
    control: [u32; 2],
    dier: u32,
    status: u32,
    modes: [u32; 2],
    outputs: u32,
    prescaler: u32,
    reload: u32,
    compare: [u32; 4],
    /// Those in effect: they take over the ones above at an update.
    active: (u32, u32),
    /// Count at `since`, or where it stands.
    count: u32,
    since: u64,
}

/// What an update of the timer causes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Update {
    /// The DMA is asked for a transfer.
    pub request: bool,
    /// An edge at the trigger output.
    pub trigger: bool,
}

impl Timer {
    /// Basic (TIM6, TIM7) or general, of 16 or 32 bits.
    pub fn new(basic: bool, wide: bool) -> Self {
        let top = if wide { u32::MAX } else { 0xffff };
        Self {
            clocked: false,
            basic,
            top,
            control: [0; 2],
            dier: 0,
            status: 0,
            modes: [0; 2],
            outputs: 0,
            prescaler: 0,
            reload: top,
            compare: [0; 4],
            active: (0, top),
            count: 0,
            since: 0,
        }
    }

    fn runs(&self) -> bool {
        self.clocked && self.control[0] & 1 == 1 && self.active.1 != 0
    }

    /// Units of time per count.
    fn step(&self, clock: u32) -> u64 {
        u64::from(clock) * (u64::from(self.active.0) + 1)
    }

    fn count_now(&self, now: u64, clock: u32) -> u32 {
        if !self.runs() {
            return self.count;
        }
        let steps = now.saturating_sub(self.since) / self.step(clock);
        ((u64::from(self.count) + steps) % (u64::from(self.active.1) + 1)) as u32
    }

    /// When it next overflows.
    pub fn next(&self, clock: u32) -> u64 {
        if !self.runs() {
            return NEVER;
        }
        let left = (u64::from(self.active.1) + 1)
            .saturating_sub(u64::from(self.count))
            .max(1);
        self.since + left * self.step(clock)
    }

    /// To be called when the clock is about to change, and before registers do.
    pub fn settle(&mut self, now: u64, clock: u32) {
        let step = self.step(clock);
        if self.runs() {
            let steps = now.saturating_sub(self.since) / step;
            self.count = self.count_now(now, clock);
            self.since += steps * step;
        } else {
            self.since = now;
        }
    }

    /// Its clock goes on or off: without it the count stands.
    pub fn gate(&mut self, clocked: bool, now: u64, clock: u32) {
        if clocked != self.clocked {
            self.settle(now, clock);
            self.clocked = clocked;
        }
    }

    /// Stands still for a time.
    pub fn freeze(&mut self, by: u64) {
        self.since += by;
    }

    fn update(&mut self, at: u64) -> Update {
        self.count = 0;
        self.since = at;
        self.active = (self.prescaler, self.reload);
        Update {
            request: self.dier & 1 << 8 != 0,
            trigger: self.control[1] >> 4 & 7 == 2,
        }
    }

    /// The count overflows at `at`; what that causes.
    pub fn overflow(&mut self, at: u64) -> Update {
        self.status |= 1;
        self.update(at)
    }

    /// Whether its interrupt's line is high.
    pub fn interrupts(&self) -> bool {
        self.status & self.dier & 0x5f != 0
    }

    /// Duty cycle of channel 1 to 4 in PWM mode 1, 0 to 1; `None` if the channel is off.
    pub fn duty(&self, channel: usize) -> Option<f64> {
        let on = self.outputs >> (4 * (channel - 1)) & 1 == 1 && self.runs();
        let pwm = self.modes[(channel - 1) / 2] >> (8 * ((channel - 1) % 2) + 4) & 7 == 6;
        let share = f64::from(self.compare[channel - 1]) / (f64::from(self.active.1) + 1.0);
        (on && pwm).then_some(share.min(1.0))
    }

    /// Reads the register at `offset`, the count as it is at `now`.
    pub fn read(&self, offset: u32, now: u64, clock: u32) -> Access<u32> {
        let general = !self.basic;
        Ok(match offset {
            0x00 | 0x04 => self.control[offset as usize / 4],
            0x0c => self.dier,
            0x10 => self.status,
            0x18 | 0x1c if general => self.modes[offset as usize / 4 - 6],
            0x20 if general => self.outputs,
            0x24 => self.count_now(now, clock),
            0x28 => self.prescaler,
            0x2c => self.reload,
            0x34..=0x40 if general => self.compare[offset as usize / 4 - 13],
            _ => return Err("is not modelled".into()),
        })
    }

    /// Writes the register at `w.offset`; what an update that this makes causes.
    pub fn write(&mut self, w: Write, clock: u32) -> Access<Update> {
        self.settle(w.now, clock);
        let general = !self.basic;
        match w.offset {
            0x00 => {
                let new = w.over(self.control[0], if general { 0x3ff } else { 0x8f })?;
                if new & 0x78 != 0 {
                    return Err("one pulse, down or centre counting is not modelled".into());
                }
                if new & 1 == 1 && self.control[0] & 1 == 0 {
                    self.since = w.now;
                }
                self.control[0] = new;
            }
            0x04 => self.control[1] = w.over(self.control[1], if general { 0xf8 } else { 0x70 })?,
            0x0c => self.dier = w.over(self.dier, if general { 0x5f5f } else { 0x101 })?,
            0x10 => self.status &= w.value | !w.mask,
            0x14 => {
                let new = w.over(0, if general { 0x5f } else { 1 })?;
                if new & !1 != 0 {
                    return Err("only the update can be generated here".into());
                }
                if new & 1 == 1 {
                    if self.control[0] & 4 == 0 {
                        self.status |= 1;
                    }
                    let mut caused = self.update(w.now);
                    caused.request &= self.control[0] & 4 == 0;
                    return Ok(caused);
                }
            }
            0x18 | 0x1c if general => {
                let slot = &mut self.modes[w.offset as usize / 4 - 6];
                *slot = w.over(*slot, 0xffff)?;
                if *slot & 0x0303 != 0 {
                    return Err("capture is not modelled".into());
                }
            }
            0x20 if general => self.outputs = w.over(self.outputs, 0xbbbb)?,
            0x24 => self.count = w.over(self.count, self.top)?,
            0x28 => self.prescaler = w.over(self.prescaler, 0xffff)?,
            0x2c => {
                self.reload = w.over(self.reload, self.top)?;
                if self.control[0] & 0x80 == 0 {
                    self.active.1 = self.reload;
                }
            }
            0x34..=0x40 if general => {
                let slot = &mut self.compare[w.offset as usize / 4 - 13];
                *slot = w.over(*slot, self.top)?;
            }
            _ => return Err("is not modelled".into()),
        }
        Ok(Update::default())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn write(timer: &mut Timer, offset: u32, value: u32, now: u64) -> Access<Update> {
        timer.write(
            Write {
                offset,
                value,
                mask: !0,
                now,
            },
            8,
        )
    }

    #[test]
    fn it_overflows_at_its_rate() {
        let mut timer = Timer::new(false, true);
        timer.gate(true, 0, 8);
        write(&mut timer, 0x2c, 4499, 0).unwrap();
        write(&mut timer, 0x04, 2 << 4, 0).unwrap();
        write(&mut timer, 0x0c, 1 << 8, 0).unwrap();
        assert_eq!(timer.next(8), NEVER);
        write(&mut timer, 0, 1, 100).unwrap();
        assert_eq!(timer.next(8), 100 + 4500 * 8);
        let caused = timer.overflow(100 + 4500 * 8);
        assert_eq!(
            caused,
            Update {
                request: true,
                trigger: true
            }
        );
        assert_eq!(timer.next(8), 100 + 2 * 4500 * 8);
        assert_eq!(timer.read(0x24, 100 + 4500 * 8 + 80, 8), Ok(10));
        write(&mut timer, 0, 1 << 4, 0).unwrap_err();
    }
}
