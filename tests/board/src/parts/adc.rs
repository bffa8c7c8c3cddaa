//! ADC1 (RM0390, chapter 13): regular sequences of up to 16, started by software or by a timer's edge, with DMA.
//! One injected conversion by software, which interrupts a regular one or
//! delays it. Not modelled: more injected ones, the analogue watchdog, discontinuous and dual modes, interrupts but the line of
//! EOC and overrun, anything analogue.

use super::{Access, Clocks, NEVER, UNITS_PER_US, Write};

const EOC: u32 = 1 << 1;
const JEOC: u32 = 1 << 2;
const JSTRT: u32 = 1 << 3;
const STRT: u32 = 1 << 4;
const OVR: u32 = 1 << 5;
/// Of ADC_CR2: DMA, and its requests going on after the last transfer.
const DMA: u32 = 1 << 8;
const DDS: u32 = 1 << 9;
/// Of ADC_CCR: the part's own reference and temperature.
const TSVREFE: u32 = 1 << 23;
const REFERENCE: usize = 17;
const TEMPERATURE: usize = 18;
const STABILISING: u64 = 3 * UNITS_PER_US;
/// What the reference needs to start, and to be sampled.
const REFERENCE_TIME: u64 = 10 * UNITS_PER_US;
/// What an input needs to be sampled from another channel's voltage to half a code of 12 bits: ln 2^14 times 4 pF and 6.1 kΩ,
/// the switch's largest and the conditioner's (DS10693, 6.3.20; docs/wiring.md), 0.24 µs, and half a cycle.
const SETTLING: u64 = 24 * UNITS_PER_US / 100;
/// A code that nobody should use.
const GARBAGE: u16 = 0x0aa;

/// ADC1 with its registers, and the conversion under way.
#[derive(Clone, Debug, Default)]
pub struct Adc {
    /// Whether its clock is on: without it nothing is converted.
    pub clocked: bool,
    status: u32,
    control: [u32; 2],
    sampling: [u32; 2],
    sequence: [u32; 3],
    common: u32,
    injected_sequence: u32,
    injected_data: u32,
    /// When the injected conversion under way ends.
    injected: Option<u64>,
    data: u32,
    unread: bool,
    on_at: u64,
    /// When the part's own reference was switched on.
    reference_at: u64,
    /// The DMA has made its last transfer, and DDS is 0: no more requests (13.8.1).
    requests_over: bool,
    /// The place in the sequence under way, and when its conversion ends.
    step: Option<(usize, u64)>,
    /// Conversions that gave nothing to be used.
    pub unusable: u32,
    /// Triggers that found a sequence still under way.
    pub missed: u32,
}

/// The sources of a regular conversion (13.13.3): TIM2's trigger output is number 6.
pub const TIM2_TRGO: u32 = 6;

impl Adc {
    fn length(&self) -> usize {
        if self.control[0] & 1 << 8 == 0 {
            1
        } else {
            (self.sequence[0] >> 20 & 15) as usize + 1
        }
    }

    fn channel(&self, place: usize) -> usize {
        (self.sequence[2 - place / 6] >> (5 * (place % 6)) & 31) as usize
    }

    fn sampling_cycles(&self, channel: usize) -> u64 {
        let (register, place) = if channel < 10 {
            (1, channel)
        } else {
            (0, channel - 10)
        };
        [3, 15, 28, 56, 84, 112, 144, 480][(self.sampling[register] >> (3 * place) & 7) as usize]
    }

    /// Units of time of one conversion.
    fn duration(&self, channel: usize, clocks: &Clocks) -> u64 {
        let bits = [12, 10, 8, 6][(self.control[0] >> 24 & 3) as usize];
        (self.sampling_cycles(channel) + bits) * self.cycle(clocks)
    }

    fn cycle(&self, clocks: &Clocks) -> u64 {
        u64::from(clocks.pclk2) * 2 * (u64::from(self.common >> 16 & 3) + 1)
    }

    fn start(&mut self, now: u64, clocks: &Clocks) -> Access {
        if self.control[1] & 1 == 0 {
            return Ok(());
        }
        // 36 MHz at most (DS10693, 6.3.20): 20 units.
        if self.cycle(clocks) < 20 {
            return Err("the ADC's clock is above 36 MHz".into());
        }
        if self.step.is_some() {
            self.missed += 1;
            return Ok(());
        }
        self.status |= STRT;
        // Behind an injected conversion under way.
        let from = self.injected.map_or(now, |end| end.max(now));
        self.step = Some((0, from + self.duration(self.channel(0), clocks)));
        Ok(())
    }

    /// The one injected conversion, which goes before a regular one.
    fn inject(&mut self, now: u64, clocks: &Clocks) -> Access {
        if self.injected_sequence >> 20 & 3 != 0 {
            return Err("more than one injected conversion is not modelled".into());
        }
        if self.injected.is_some() {
            return Err("an injected conversion is started while one is under way".into());
        }
        if self.control[1] & 1 == 0 {
            return Ok(());
        }
        let time = self.duration(self.injected_channel(), clocks);
        self.status |= JSTRT;
        self.injected = Some(now + time);
        if let Some((place, _)) = self.step {
            // The regular conversion is broken off and made anew (13.3.9).
            self.step = Some((
                place,
                now + time + self.duration(self.channel(place), clocks),
            ));
        }
        Ok(())
    }

    fn injected_channel(&self) -> usize {
        (self.injected_sequence >> 15 & 31) as usize
    }

    /// A timer's edge; true if a sequence begins.
    ///
    /// # Errors
    /// A rule of the converter is broken.
    pub fn trigger(&mut self, source: u32, now: u64, clocks: &Clocks) -> Access<bool> {
        let listens = self.control[1] >> 28 & 1 == 1 && self.control[1] >> 24 & 15 == source;
        if !self.clocked || !listens || self.control[1] & 1 == 0 || self.status & OVR != 0 {
            return Ok(false);
        }
        let before = self.step.is_some();
        self.start(now, clocks)?;
        Ok(!before)
    }

    /// Channels of the sequence under way.
    pub fn channels(&self) -> impl Iterator<Item = usize> {
        let count = if self.step.is_some() {
            self.length()
        } else {
            0
        };
        (0..count).map(|place| self.channel(place))
    }

    /// The DMA's stream has made the last transfer that it was told.
    pub fn dma_ends(&mut self) {
        self.requests_over |= self.control[1] & DDS == 0;
    }

    /// What a conversion of a channel that ended now gives: nothing to be used within 3 µs of ADON (13.3.6) or sampled too briefly,
    /// nor of the part's own reference without TSVREFE, within 10 µs of it, or sampled for less than 10 µs (DS10693, 6.3.24).
    fn converted(&mut self, channel: usize, now: u64, clocks: &Clocks, code: u16) -> u16 {
        let began = now.saturating_sub(self.duration(channel, clocks));
        let internal = channel == REFERENCE || channel == TEMPERATURE;
        let sampled = self.sampling_cycles(channel) * self.cycle(clocks);
        let settled = if internal {
            self.common & TSVREFE != 0
                && began >= self.reference_at + REFERENCE_TIME
                && sampled >= REFERENCE_TIME
        } else {
            sampled >= SETTLING + self.cycle(clocks) / 2
        };
        let usable = began >= self.on_at + STABILISING && settled;
        if usable {
            return code >> (2 * (self.control[0] >> 24 & 3));
        }
        self.unusable += 1;
        GARBAGE
    }

    /// When the conversion under way ends.
    pub fn next(&self) -> u64 {
        if !self.clocked {
            return NEVER;
        }
        let regular = self.step.map_or(NEVER, |(_, at)| at);
        regular.min(self.injected.unwrap_or(NEVER))
    }

    /// Ends it: `code` is what is measured at a channel. True if a DMA request is made.
    pub fn run(&mut self, now: u64, clocks: &Clocks, code: impl Fn(usize) -> u16) -> bool {
        if self.injected.is_some_and(|at| at <= now) {
            self.injected = None;
            let channel = self.injected_channel();
            self.injected_data = u32::from(self.converted(channel, now, clocks, code(channel)));
            self.status |= JEOC;
        }
        let Some((place, _)) = self.step.filter(|(_, at)| *at <= now) else {
            return false;
        };
        let dma = self.control[1] & DMA != 0 && !self.requests_over;
        if self.unread && (dma || self.control[1] & 1 << 10 != 0) {
            self.status |= OVR;
            self.step = None;
            return false;
        }
        let channel = self.channel(place);
        self.data = u32::from(self.converted(channel, now, clocks, code(channel)));
        if self.control[1] & 1 << 11 != 0 {
            self.data <<= 4;
        }
        self.unread = true;
        let last = place + 1 == self.length();
        if last || self.control[1] & 1 << 10 != 0 {
            self.status |= EOC;
        }
        self.step = if last {
            (self.control[1] & 2 != 0).then(|| (0, now + self.duration(self.channel(0), clocks)))
        } else {
            Some((
                place + 1,
                now + self.duration(self.channel(place + 1), clocks),
            ))
        };
        dma
    }

    /// Whether the interrupt's line is high.
    pub fn interrupts(&self) -> bool {
        self.status & EOC != 0 && self.control[0] & 1 << 5 != 0
            || self.status & OVR != 0 && self.control[0] & 1 << 26 != 0
    }

    /// Whether an overrun has stopped the DMA.
    pub fn overran(&self) -> bool {
        self.status & OVR != 0
    }

    /// The data register, read by the processor or the DMA.
    pub fn take(&mut self) -> u32 {
        self.unread = false;
        self.status &= !EOC;
        self.data
    }

    /// Reads the register at `offset`; that of the data counts as taken then.
    pub fn read(&mut self, offset: u32) -> Access<u32> {
        Ok(match offset {
            0x00 => self.status,
            0x04 | 0x08 => self.control[offset as usize / 4 - 1],
            0x0c | 0x10 => self.sampling[offset as usize / 4 - 3],
            0x2c..=0x34 => self.sequence[offset as usize / 4 - 11],
            0x38 => self.injected_sequence,
            0x3c => self.injected_data,
            0x4c => self.take(),
            0x300 => self.status,
            0x304 => self.common,
            _ => return Err("is not modelled".into()),
        })
    }

    /// Writes the register at `w.offset`, and starts what that starts.
    pub fn write(&mut self, w: Write, clocks: &Clocks) -> Access {
        match w.offset {
            0x00 => self.status &= w.value | !w.mask,
            0x04 => {
                self.control[0] = w.over(self.control[0], 0x07c0_ffff)?;
                if self.control[0] & 0x00c0_fe80 & !0x20 != 0 {
                    return Err(
                        "ADC_CR1: injected, watchdog or discontinuous modes are not modelled"
                            .into(),
                    );
                }
            }
            0x08 => {
                let new = w.over(self.control[1], 0x7f7f_0f03)?;
                if new & 0x003f_0000 != 0 {
                    return Err(
                        "ADC_CR2: injected conversions by a trigger are not modelled".into(),
                    );
                }
                if new & !self.control[1] & 1 == 1 {
                    self.on_at = w.now;
                }
                self.requests_over &= new & DMA != 0;
                self.control[1] = new & !(1 << 30 | 1 << 22);
                if new & 1 == 0 {
                    self.step = None;
                    self.injected = None;
                }
                if new >> 22 & 1 == 1 {
                    self.inject(w.now, clocks)?;
                }
                if new >> 30 & 1 == 1 {
                    self.start(w.now, clocks)?;
                }
            }
            0x0c => self.sampling[0] = w.over(self.sampling[0], 0x07ff_ffff)?,
            0x10 => self.sampling[1] = w.over(self.sampling[1], 0x3fff_ffff)?,
            0x2c => self.sequence[0] = w.over(self.sequence[0], 0x00ff_ffff)?,
            0x30 | 0x34 => {
                let slot = &mut self.sequence[w.offset as usize / 4 - 11];
                *slot = w.over(*slot, 0x3fff_ffff)?;
            }
            0x38 => self.injected_sequence = w.over(self.injected_sequence, 0x003f_ffff)?,
            0x304 => {
                let new = w.over(self.common, 0x00c3_ef1f)?;
                if new & !self.common & TSVREFE != 0 {
                    self.reference_at = w.now;
                }
                self.common = new;
            }
            _ => return Err("is not modelled".into()),
        }
        Ok(())
    }
}
