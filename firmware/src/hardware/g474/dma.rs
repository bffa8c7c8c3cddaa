//! DMA1's channels, and which request starts each (RM0440, "DMAMUX request mapping"; the numbers were compared with those of
//! stm32g4xx-hal 0.1.0).
//!
//! | channel | request | what |
//! |---|---|---|
//! | 1 | 5, ADC1 | samples |
//! | 2 | 60, TIM2_UP | set-points |
//! | 3 | 26, USART2_RX | the link's bytes in |
//! | 4 | 27, USART2_TX | and out |
#![allow(unsafe_code)]

use super::pac;

/// A channel, and the request that starts it.
#[derive(Clone, Copy)]
pub enum Channel {
    /// From the ADC.
    Samples,
    /// To the DAC.
    SetPoints,
    /// From the wire.
    Receive,
    /// To the wire.
    Send,
}

impl Channel {
    /// Its place among DMA1's and DMAMUX's channels, from 0, and its request.
    const fn place(self) -> (usize, u8) {
        match self {
            Self::Samples => (0, 5),
            Self::SetPoints => (1, 60),
            Self::Receive => (2, 26),
            Self::Send => (3, 27),
        }
    }

    /// Its registers. Each channel has one owner, that of its buffer.
    pub fn registers(self) -> &'static pac::dma1::CH {
        // SAFETY: a channel's registers are touched by its owner alone, by single loads and stores, and by the one that makes
        // the outputs safe.
        unsafe { (*pac::DMA1::ptr()).ch(self.place().0) }
    }

    /// Joins it to its request and tells it where from or to; it rests.
    pub fn aim(self, peripheral: u32, memory: u32, count: u16) {
        let (place, request) = self.place();
        // SAFETY: a request that the part has; the callers give a data register and a static buffer of `count` items.
        unsafe {
            (*pac::DMAMUX::ptr())
                .ccr(place)
                .write(|w| w.dmareq_id().bits(request));
            let registers = self.registers();
            registers.par().write(|w| w.bits(peripheral));
            registers.mar().write(|w| w.bits(memory));
            registers.ndtr().write(|w| w.bits(u32::from(count)));
        }
    }

    /// Items still to be moved, of all.
    #[inline]
    pub fn left(self) -> u16 {
        self.registers().ndtr().read().bits() as u16
    }
}

/// All channels' flags.
#[inline]
pub fn flags() -> pac::dma1::isr::R {
    // SAFETY: a read without side effect.
    unsafe { (*pac::DMA1::ptr()).isr().read() }
}

/// Clears the four flags of a channel.
#[inline]
pub fn clear(channel: Channel) {
    let bits = 0b1111 << (4 * channel.place().0);
    // SAFETY: ones clear these flags and nothing else.
    unsafe { (*pac::DMA1::ptr()).ifcr().write(|w| w.bits(bits)) };
}
