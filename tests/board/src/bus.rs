//! The peripherals on their buses: addresses, clocks, interrupt lines, DMA requests, and what happens by itself.

use crate::core::{Trap, Try};
use crate::machine::{Change, Machine};
use crate::parts::capture::Input;
use crate::parts::{Access, Write, adc, interrupt};

/// A peripheral whose registers the program can reach.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Part {
    Tim(usize),
    Tim11,
    Iwdg,
    Usart2,
    Pwr,
    Dac,
    Adc,
    Syscfg,
    Exti,
    Gpio(usize),
    Rcc,
    Flash,
    Dma(usize),
}

impl Part {
    /// The part at an address, and the first address of its registers.
    fn at(address: u32) -> Option<(Self, u32)> {
        let base = address & !0x3ff;
        let part = match base {
            0x4000_0000 => Self::Tim(0),
            0x4000_0400 => Self::Tim(1),
            0x4000_1000 => Self::Tim(2),
            0x4000_1400 => Self::Tim(3),
            0x4001_4800 => Self::Tim11,
            0x4000_3000 => Self::Iwdg,
            0x4000_4400 => Self::Usart2,
            0x4000_7000 => Self::Pwr,
            0x4000_7400 => Self::Dac,
            0x4001_2000 => Self::Adc,
            0x4001_3800 => Self::Syscfg,
            0x4001_3c00 => Self::Exti,
            0x4002_0000..=0x4002_1c00 => Self::Gpio(((base - 0x4002_0000) / 0x400) as usize),
            0x4002_3800 => Self::Rcc,
            0x4002_3c00 => Self::Flash,
            0x4002_6000 => Self::Dma(0),
            0x4002_6400 => Self::Dma(1),
            _ => return None,
        };
        Some((part, base))
    }

    /// Bus and bit of its clock; `None`: always on.
    fn clock(self) -> Option<(usize, u32)> {
        Some(match self {
            Self::Tim(i) => (3, [0, 1, 4, 5][i]),
            Self::Tim11 => (4, 18),
            Self::Usart2 => (3, 17),
            Self::Pwr => (3, 28),
            Self::Dac => (3, 29),
            Self::Adc => (4, 8),
            Self::Syscfg => (4, 14),
            Self::Gpio(port) => (0, port as u32),
            Self::Dma(i) => (0, 21 + i as u32),
            Self::Iwdg | Self::Exti | Self::Rcc | Self::Flash => return None,
        })
    }
}

impl Machine {
    fn part_at(&self, address: u32) -> Try<(Part, u32)> {
        let Some((part, base)) = Part::at(address) else {
            return Err(Trap::stop(format!(
                "no peripheral is modelled at {address:#010x}"
            )));
        };
        if let Some((bus, bit)) = part.clock() {
            if !self.parts.rcc.is_enabled(bus, bit) {
                return Err(Trap::stop(format!(
                    "{part:?} at {address:#010x} has no clock"
                )));
            }
            if self.parts.rcc.is_held(bus, bit) {
                return Err(Trap::stop(format!(
                    "{part:?} at {address:#010x} is held in reset"
                )));
            }
        }
        Ok((part, address - base))
    }

    /// An error if the part at an address has no clock.
    pub(crate) fn check_clock(&self, address: u32) -> Access {
        let found = self.part_at(address);
        found.map(|_| ()).map_err(|trap| format!("{trap:?}"))
    }

    /// Reads a word of a peripheral.
    pub(crate) fn read_part(&mut self, address: u32) -> Try<u32> {
        let (part, offset) = self.part_at(address)?;
        if let Some(profile) = &mut self.profile {
            profile.register(address);
        }
        let now = self.now;
        let p = &mut self.parts;
        let read = match part {
            Part::Tim(i) => p.tim[i].read(offset, now, p.clocks.timclk1),
            Part::Tim11 => {
                let clocks = p.clocks;
                // Twice PCLK2, unless that is HCLK.
                let half = if clocks.pclk2 == clocks.hclk { 1 } else { 2 };
                let input = Input {
                    now,
                    cycle: clocks.pclk2 / half,
                    period: p.rcc.hse_rtc(now),
                };
                p.capture.read(offset, input)
            }
            Part::Iwdg => p.watchdog.read(offset, now),
            Part::Usart2 => p.usart.read(offset),
            Part::Pwr => p.pwr.read(offset, now),
            Part::Dac => p.dac.read(offset),
            Part::Adc => p.adc.read(offset),
            Part::Syscfg => p.exti.read_syscfg(offset),
            Part::Exti => p.exti.read(offset),
            Part::Gpio(port) => p.gpio[port].read(offset),
            Part::Rcc => p.rcc.read(offset, now),
            Part::Flash => p.flash.read(offset),
            Part::Dma(i) => p.dma[i].read(offset),
        };
        let value = read.map_err(|why| {
            Trap::stop(format!(
                "{part:?} register {offset:#x} ({address:#010x}) {why}"
            ))
        })?;
        if matches!(part, Part::Usart2 | Part::Adc) {
            self.settle_lines();
        }
        Ok(value)
    }

    /// Writes the bits of `mask` of a word of a peripheral.
    ///
    /// From NMI and HardFault a part without a clock may be written, as outputs are made safe at any time: nothing happens.
    pub(crate) fn write_part(&mut self, address: u32, value: u32, mask: u32) -> Try {
        let clock = Part::at(address).and_then(|(part, _)| part.clock());
        let clocked = clock.is_none_or(|clock| self.parts.rcc.works(clock));
        if matches!(self.cpu.ipsr, 2 | 3) && !clocked {
            return Ok(());
        }
        let (part, offset) = self.part_at(address)?;
        if let Some(profile) = &mut self.profile {
            profile.register(address);
        }
        let value = self.around.patch.changed(address, value);
        let w = Write {
            offset,
            value,
            mask,
            now: self.now,
        };
        self.dispatch(part, w).map_err(|why| {
            Trap::stop(format!(
                "{part:?} register {offset:#x} ({address:#010x}), {value:#010x} written: {why}"
            ))
        })?;
        self.settle_lines();
        self.reschedule();
        self.attend();
        Ok(())
    }

    fn dispatch(&mut self, part: Part, w: Write) -> Access {
        let p = &mut self.parts;
        match part {
            Part::Tim(i) => {
                let caused = p.tim[i].write(w, p.clocks.timclk1)?;
                if i == 1 {
                    self.note_duty();
                }
                if caused.trigger || caused.request {
                    self.timer_acts(i, caused.trigger, caused.request, w.now)?;
                }
                Ok(())
            }
            Part::Tim11 => p.capture.write(w),
            Part::Iwdg => p.watchdog.write(w),
            Part::Usart2 => {
                p.usart.write(w, p.clocks.pclk1)?;
                self.check_pins()
            }
            Part::Pwr => {
                p.pwr.write(w, p.rcc.running())?;
                self.settle_pins();
                self.check_power()
            }
            Part::Dac => {
                p.dac.write(w, p.clocks.pclk1)?;
                self.check_pins()
            }
            Part::Adc => {
                p.adc.write(w, &p.clocks.clone())?;
                self.check_pins()
            }
            Part::Syscfg => p.exti.write_syscfg(w).map(|()| self.settle_pins()),
            Part::Exti => p.exti.write(w),
            Part::Gpio(port) => {
                p.gpio[port].write(w)?;
                self.settle_pins();
                self.note_duty();
                self.check_pins()
            }
            Part::Rcc => {
                let reset = p.rcc.write(w)?;
                if let Some((bus, bits)) = reset {
                    self.reset_parts(bus, bits);
                }
                self.gate_parts();
                self.clocks_changed()?;
                self.check_power()?;
                self.check_pins()
            }
            Part::Flash => {
                p.flash.write(w)?;
                p.flash.check(p.rcc.hclk_hz()?)
            }
            Part::Dma(i) => {
                if let Some(stream) = p.dma[i].write(w)? {
                    self.stream_begins(i, stream)?;
                }
                Ok(())
            }
        }
    }

    /// Follows a change of the clocks, if there was one; checks what depends on them.
    pub(crate) fn clocks_changed(&mut self) -> Access {
        let p = &mut self.parts;
        let hz = p.rcc.hclk_hz()?;
        let mut clocks = p.rcc.clocks()?;
        if p.rcc.is_stalled(self.now) {
            // A dead oscillator leaves the PLL at the bottom of its range: some 9 MHz instead of 180.
            let slow = |cycle: u32| cycle * 20;
            clocks = crate::parts::Clocks {
                hclk: slow(clocks.hclk),
                pclk1: slow(clocks.pclk1),
                pclk2: slow(clocks.pclk2),
                timclk1: slow(clocks.timclk1),
            };
        }
        if clocks == p.clocks {
            return Ok(());
        }
        p.flash.check(hz)?;
        for timer in &mut p.tim {
            timer.settle(self.now, p.clocks.timclk1);
        }
        p.clocks = clocks;
        self.unit = clocks.hclk;
        self.check_power()
    }

    /// Clock and power must fit together.
    fn check_power(&self) -> Access {
        let p = &self.parts;
        let hz = p.rcc.hclk_hz()?;
        if hz > p.pwr.limit_hz(self.now) {
            return Err(format!(
                "HCLK {hz} Hz is above what scale and over-drive allow (5.1.4)"
            ));
        }
        p.pwr.check_switching(self.now, p.rcc.running())
    }

    /// The pins of what is at work must be set to it.
    pub(crate) fn check_pins(&self) -> Access {
        let p = &self.parts;
        let analogue = |name: char, pin: usize, who: &str| {
            let port = name as usize - 'A' as usize;
            if p.gpio[port].mode(pin) == 3 {
                return Ok(());
            }
            Err(format!(
                "P{name}{pin} is not analogue, and is {who} (7.3.12)"
            ))
        };
        for (channel, pin) in [(0, 4), (1, 5)] {
            if p.dac.code(channel).is_some() {
                analogue('A', pin, "the DAC's output")?;
                if !p.dac.is_buffered(channel) {
                    // 15 kΩ, and the bias of docs/wiring.md loads PA4 with 12 kΩ.
                    return Err(format!(
                        "the DAC's buffer is off, and PA{pin} has a load (DS10693, 6.3.25)"
                    ));
                }
            }
        }
        for channel in p.adc.channels() {
            match channel {
                0..8 => analogue('A', channel, "an input of the ADC")?,
                8..10 => analogue('B', channel - 8, "an input of the ADC")?,
                10..16 => analogue('C', channel - 10, "an input of the ADC")?,
                _ => {}
            }
        }
        let (sends, receives) = p.usart.uses_pins();
        for (used, pin) in [(sends, 2), (receives, 3)] {
            if used && (p.gpio[0].mode(pin), p.gpio[0].function(pin)) != (2, 7) {
                return Err(format!(
                    "PA{pin} is not in alternate function 7, and USART2 is at work (7.3.2)"
                ));
            }
        }
        Ok(())
    }

    /// Parts without a clock, or in reset, stand still.
    fn gate_parts(&mut self) {
        let p = &mut self.parts;
        let works = |part: Part| part.clock().is_none_or(|clock| p.rcc.works(clock));
        for (i, timer) in p.tim.iter_mut().enumerate() {
            timer.gate(works(Part::Tim(i)), self.now, p.clocks.timclk1);
        }
        for (i, dma) in p.dma.iter_mut().enumerate() {
            dma.clocked = works(Part::Dma(i));
        }
        p.adc.clocked = works(Part::Adc);
        p.dac.clocked = works(Part::Dac);
        p.usart.clocked = works(Part::Usart2);
        if p.rcc.lsi_is_on() {
            p.watchdog.run_lsi(self.now);
        }
        self.note_duty();
    }

    fn reset_parts(&mut self, bus: usize, bits: u32) {
        let p = &mut self.parts;
        if bus == 3 && bits >> 28 & 1 == 1 {
            p.pwr = crate::parts::pwr::Pwr::new(p.pwr.supply_v);
        }
        for (i, bit) in [0, 1, 4, 5].into_iter().enumerate() {
            if bus == 3 && bits >> bit & 1 == 1 {
                p.tim[i] = crate::parts::timer::Timer::new(i > 1, i == 0);
            }
        }
        if bus == 3 && bits >> 17 & 1 == 1 {
            p.usart = crate::parts::usart::Usart::new(p.usart.far_baud);
        }
        if bus == 3 && bits >> 29 & 1 == 1 {
            p.dac = crate::parts::dac::Dac::default();
        }
        if bus == 4 && bits >> 8 & 1 == 1 {
            p.adc = adc::Adc::default();
        }
        if bus == 4 && bits >> 18 & 1 == 1 {
            p.capture = crate::parts::capture::Capture::default();
        }
        for i in 0..2 {
            if bus == 0 && bits >> (21 + i) & 1 == 1 {
                p.dma[i] = crate::parts::dma::Dma::new(i + 1);
            }
        }
        for port in (0..8).filter(|port| bus == 0 && bits >> port & 1 == 1) {
            p.gpio[port] = crate::parts::gpio::Gpio::new(port, p.gpio[port].outside);
        }
    }

    /// The interrupt lines as the peripherals have them now.
    pub(crate) fn settle_lines(&mut self) {
        let p = &self.parts;
        let lines = [
            interrupt::TIM2,
            interrupt::TIM3,
            interrupt::TIM6,
            interrupt::TIM7,
        ];
        for (timer, line) in p.tim.iter().zip(lines) {
            self.nvic.set_line(line, timer.interrupts());
        }
        self.nvic.set_line(interrupt::ADC, p.adc.interrupts());
        self.nvic.set_line(interrupt::USART2, p.usart.interrupts());
        for (dma, lines) in p.dma.iter().zip([interrupt::DMA1, interrupt::DMA2]) {
            for (stream, line) in dma.streams.iter().zip(lines) {
                self.nvic.set_line(line, stream.interrupts());
            }
        }
        for (line, high) in p.exti.interrupts() {
            self.nvic.set_line(line, high);
        }
        if p.rcc.security_event && !self.nvic.pending[2] && !self.nvic.active.contains(&2) {
            self.nvic.pend(2);
        }
        if self.nvic.changed {
            self.attend();
        }
        if self.profile.is_some() {
            self.profile_lines();
        }
    }

    /// The pins as they are now: to the external interrupts and to whoever watches.
    pub(crate) fn settle_pins(&mut self) {
        for line in 0..16 {
            let port = self.parts.exti.port(line);
            let high = self
                .parts
                .gpio
                .get(port)
                .is_some_and(|gpio| gpio.level(line));
            self.parts.exti.level(line, high);
        }
        self.parts.exti.level(16, self.parts.pwr.is_low());
        self.note(Change::Enable(self.parts.gpio[0].driven(8)));
        self.note(Change::Led(self.parts.gpio[0].driven(5)));
    }

    /// The duty cycle at PC7, which is TIM3's in alternate function 2.
    pub fn duty(&self) -> Option<f64> {
        let routed = self.parts.gpio[2].mode(7) == 2 && self.parts.gpio[2].function(7) == 2;
        self.parts.tim[1].duty(2).filter(|_| routed)
    }

    fn note_duty(&mut self) {
        self.note(Change::Duty(self.duty()));
    }
}
