//! What happens by itself: DMA transfers, timers, conversions, bytes, the flash's work, the watchdog.

use crate::core::Trap;
use crate::core::Try;
use crate::machine::{Change, Machine};
use crate::parts::dma::Request;
use crate::parts::flash::{SECTORS, Work};
use crate::parts::rcc::cause;
use crate::parts::{Access, NEVER, Write, adc};

impl Machine {
    /// A stream begins: its buffer must be one object of the program, its peripheral the one it is asked by.
    pub(crate) fn stream_begins(&mut self, controller: usize, stream: usize) -> Access {
        let own = &self.parts.dma[controller].streams[stream];
        let (start, size) = own.buffer();
        self.image.check_buffer(start, size)?;
        let transfer = own.transfer();
        let expected = match (controller, stream) {
            (1, _) => 0x4001_204c,
            (0, 5 | 6) => 0x4000_4404,
            _ => 0x4000_7408,
        };
        if transfer.peripheral != expected {
            return Err(format!(
                "stream {stream} goes to {:#010x}, not to {expected:#010x}",
                transfer.peripheral
            ));
        }
        if transfer.out {
            self.read_ahead(controller, stream)?;
        }
        self.serve_serial()
    }

    fn read_ahead(&mut self, controller: usize, stream: usize) -> Access {
        if let Some(next) = self.parts.dma[controller].streams[stream].next_ahead() {
            let value = self.dma_load(next.memory, next.width)?;
            self.parts.dma[controller].streams[stream].set_ahead(value);
        }
        Ok(())
    }

    fn dma_load(&mut self, address: u32, width: u32) -> Access<u32> {
        let loaded = match width {
            1 => self.load::<1>(address),
            2 => self.load::<2>(address),
            _ => self.load::<4>(address),
        };
        loaded.map_err(|trap| format!("DMA from {address:#010x}: {trap:?}"))
    }

    /// A request: the stream that serves it, if one does, makes one transfer.
    pub(crate) fn request(&mut self, request: Request) -> Access {
        for controller in 0..2 {
            let Some(stream) = self.parts.dma[controller].serves(request) else {
                continue;
            };
            if let Some(profile) = &mut self.profile {
                profile.transfer();
            }
            let transfer = self.parts.dma[controller].streams[stream].transfer();
            if transfer.out {
                let value = match self.parts.dma[controller].streams[stream].take_ahead() {
                    Some(value) => value,
                    None => self.dma_load(transfer.memory, transfer.width)?,
                };
                self.dma_write(transfer.peripheral, value)?;
                self.parts.dma[controller].streams[stream].count();
                self.read_ahead(controller, stream)?;
            } else {
                let value = match transfer.peripheral {
                    0x4001_204c => self.parts.adc.take(),
                    _ => self.parts.usart.read(4)?,
                };
                let stored = match transfer.width {
                    1 => self.store::<1>(transfer.memory, value),
                    _ => self.store::<2>(transfer.memory, value),
                };
                stored.map_err(|trap| format!("DMA to {:#010x}: {trap:?}", transfer.memory))?;
                let last = self.parts.dma[controller].streams[stream].count();
                if last && request == Request::Adc1 {
                    self.parts.adc.dma_ends();
                }
            }
        }
        Ok(())
    }

    fn dma_write(&mut self, address: u32, value: u32) -> Access {
        let w = Write {
            offset: address & 0x3ff,
            value,
            mask: u32::MAX,
            now: self.now,
        };
        self.check_clock(address)?;
        let p = &mut self.parts;
        match address {
            0x4000_7408 => p.dac.write(w, p.clocks.pclk1),
            _ => p.usart.write(w, p.clocks.pclk1),
        }
    }

    /// The link's requests as long as there are any.
    pub(crate) fn serve_serial(&mut self) -> Access {
        loop {
            let (receive, send) = self.parts.usart.requests();
            let served = |machine: &Self, request| machine.parts.dma[0].serves(request).is_some();
            if receive && served(self, Request::Usart2Receive) {
                self.request(Request::Usart2Receive)?;
            } else if send && served(self, Request::Usart2Send) {
                self.request(Request::Usart2Send)?;
            } else {
                return Ok(());
            }
        }
    }

    pub(crate) fn timer_acts(
        &mut self,
        timer: usize,
        trigger: bool,
        request: bool,
        now: u64,
    ) -> Access {
        if timer != 0 {
            return Ok(());
        }
        if request {
            self.request(Request::Tim2Update)?;
        }
        let clocks = self.parts.clocks;
        if trigger && self.parts.adc.trigger(adc::TIM2_TRGO, now, &clocks)? {
            self.check_pins()?;
            self.ticks += 1;
            self.pause = true;
            self.attend();
        }
        Ok(())
    }

    /// When the next thing happens by itself.
    pub(crate) fn reschedule(&mut self) {
        let p = &self.parts;
        let timers = p.tim.iter().map(|timer| timer.next(p.clocks.timclk1));
        let tick = self.tick_due().map_or(NEVER, |cycle| {
            self.now + cycle.saturating_sub(self.cycles) * u64::from(self.unit)
        });
        let others = [
            p.adc.next(),
            p.usart.next(),
            p.dac.next(),
            p.watchdog.next(),
            p.rcc.next(),
            p.flash.work.as_ref().map_or(NEVER, |(_, until)| *until),
            tick,
        ];
        self.next_event = timers.chain(others).min().unwrap_or(NEVER);
        self.settle_horizon();
    }

    /// Lets happen what is due at `self.now`, in its order.
    pub(crate) fn happen(&mut self) -> Try {
        let end = self.now;
        while self.next_event <= end {
            let at = self.next_event;
            self.now = at;
            self.happen_at(at).map_err(Trap::stop)?;
            self.reschedule();
        }
        self.now = end;
        self.settle_lines();
        Ok(())
    }

    fn happen_at(&mut self, at: u64) -> Access {
        if self.parts.rcc.next() <= at {
            self.parts.rcc.run(at);
            self.clocks_changed()?;
        }
        for i in 0..self.parts.tim.len() {
            if self.parts.tim[i].next(self.parts.clocks.timclk1) <= at {
                let caused = self.parts.tim[i].overflow(at);
                self.timer_acts(i, caused.trigger, caused.request, at)?;
            }
        }
        if self.parts.adc.next() <= at {
            let (clocks, codes) = (self.parts.clocks, self.codes);
            if self.parts.adc.run(at, &clocks, |channel| codes[channel]) {
                self.request(Request::Adc1)?;
            }
        }
        if self.parts.dac.next() <= at {
            self.parts.dac.run();
            let code = self.parts.dac.code(0);
            self.note(Change::Dac(code));
        }
        if self.parts.usart.next() <= at {
            let cycle = self.parts.clocks.pclk1;
            self.parts.usart.run(at, cycle);
            self.serve_serial()?;
        }
        if self
            .parts
            .flash
            .work
            .as_ref()
            .is_some_and(|(_, until)| *until <= at)
        {
            let work = self.parts.flash.end();
            self.flash_done(work);
        }
        if self.parts.watchdog.next() <= at && self.parts.watchdog.run(at) {
            self.reset(cause::WATCHDOG | cause::PIN);
            return Ok(());
        }
        if self.tick_due().is_some_and(|cycle| cycle <= self.cycles) {
            self.nvic.pend(15);
        }
        Ok(())
    }

    pub(crate) fn flash_done(&mut self, work: Option<Work>) {
        if self.cuts.is_some() {
            let whole = self.flash.clone();
            self.break_off(work.clone());
            let broken = std::mem::replace(&mut self.flash, whole);
            self.cuts
                .iter_mut()
                .for_each(|cuts| cuts.push(broken.clone()));
        }
        let range = match work {
            Some(Work::Program(at, bytes)) => {
                // Zeros can be written, ones not.
                for (i, byte) in bytes.iter().enumerate() {
                    self.flash[at as usize + i] &= byte;
                }
                at as usize..at as usize + bytes.len()
            }
            Some(Work::Erase(sector)) => {
                let range = SECTORS[sector] as usize..SECTORS[sector + 1] as usize;
                self.flash[range.clone()].fill(0xff);
                range
            }
            Some(Work::Options(options)) => {
                self.around.options = options;
                return;
            }
            None => return,
        };
        self.forget(range);
    }
}
