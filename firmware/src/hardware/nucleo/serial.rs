//! The link's wire: USART2, which the on-board debugger passes on as a virtual serial port, by DMA either way.
//!
//! | quantity | value | why |
//! |---|---|---|
//! | rate | 2.25 Mbaud, or 921,600 | [`crate::wire`]: the one that the computer uses |
//! | rate's error | none, or 0.4 % | 45 MHz / 20, or / 49 |
//! | sent at once | [`CHUNK`], 1024 bytes | 4.6 ms of the wire ([`crate::wire`]) |
//! | receive ring | 1024 bytes | 4.5 ms of the wire; the link task looks every millisecond |
//!
//! What arrives while the ring is full overwrites what was not read; the frame's check then fails and the loss is
//! counted. While the wire is busy nothing is sent: nothing waits here.
//!
//! Sources: RM0390, "DMA request mapping" (DMA1 channel 4: stream 5 USART2_RX, stream 6 USART2_TX).
#![allow(unsafe_code)]

use core::cell::UnsafeCell;

use crate::wire::CHUNK;
use shared::link::RATES;
use stm32f4xx_hal::{
    gpio::{Alternate, PA2, PA3},
    pac,
    rcc::{Enable, Rcc, Reset},
};

/// Bytes of the receive ring.
const RECEIVE: usize = 1024;

/// Bytes the DMA touches.
struct Shared<const N: usize>(UnsafeCell<[u8; N]>);

// SAFETY: both are touched by the one `Serial` alone, by volatile accesses: the receive ring is read only where
// the DMA has passed, the send buffer written only while the DMA is not sending.
unsafe impl<const N: usize> Sync for Shared<N> {}

static RECEIVED: Shared<RECEIVE> = Shared(UnsafeCell::new([0; RECEIVE]));
static SENDING: Shared<CHUNK> = Shared(UnsafeCell::new([0; CHUNK]));

/// The link's wire: USART2, with DMA either way.
pub struct Serial {
    usart: pac::USART2,
    dma: pac::DMA1,
    read: usize,
    /// What the rates divide, Hz.
    clock_hz: u32,
}

/// Both pins of the wire.
pub type Pins = (PA2<Alternate<7>>, PA3<Alternate<7>>);

impl Serial {
    /// Receives from now on.
    pub fn new(usart: pac::USART2, dma: pac::DMA1, _pins: Pins, rcc: &mut Rcc) -> Self {
        const { assert!(RECEIVE.is_power_of_two()) };
        pac::USART2::enable(rcc);
        pac::USART2::reset(rcc);
        pac::DMA1::enable(rcc);

        let clock_hz = rcc.clocks.pclk1().raw();
        let data = usart.dr().as_ptr() as u32;
        // SAFETY: a divider of 16 bits; the address of the data register and of static buffers of that many bytes.
        unsafe {
            usart.brr().write(|w| w.bits(divider(clock_hz, RATES[0])));
            let receive = dma.st(5);
            receive.par().write(|w| w.bits(data));
            receive.m0ar().write(|w| w.bits(RECEIVED.0.get() as u32));
            receive.ndtr().write(|w| w.bits(RECEIVE as u32));
            receive.cr().write(|w| {
                w.chsel().bits(4);
                w.dir()
                    .peripheral_to_memory()
                    .minc()
                    .incremented()
                    .circ()
                    .enabled();
                w.psize().bits8().msize().bits8().pl().medium()
            });
            let send = dma.st(6);
            send.par().write(|w| w.bits(data));
            send.m0ar().write(|w| w.bits(SENDING.0.get() as u32));
            send.cr().write(|w| {
                w.chsel().bits(4);
                w.dir().memory_to_peripheral().minc().incremented();
                w.psize().bits8().msize().bits8().pl().low()
            });
        }
        dma.st(5).cr().modify(|_, w| w.en().enabled());
        usart.cr3().write(|w| w.dmar().set_bit().dmat().set_bit());
        usart
            .cr1()
            .write(|w| w.ue().set_bit().re().set_bit().te().set_bit());
        Self {
            usart,
            dma,
            read: 0,
            clock_hz,
        }
    }

    /// The next byte that has come in.
    #[inline]
    pub fn read(&mut self) -> Option<u8> {
        let left = self.dma.st(5).ndtr().read().bits() as usize;
        let written = RECEIVE.wrapping_sub(left) % RECEIVE;
        if self.read == written {
            return None;
        }
        // SAFETY: an index within the ring, by the remainder.
        let byte = unsafe { RECEIVED.0.get().cast::<u8>().add(self.read).read_volatile() };
        self.read = (self.read + 1) % RECEIVE;
        Some(byte)
    }

    /// Whether the wire takes something to send.
    #[inline]
    pub fn is_ready(&self) -> bool {
        self.dma.st(6).cr().read().en().is_disabled()
    }

    /// Whether bytes have come since the last call that were none: no stop bit where one must be, or noise.
    pub fn take_errors(&mut self) -> bool {
        let flags = self.usart.sr().read();
        let failed = flags.fe().bit() || flags.nf().bit() || flags.ore().bit();
        if failed {
            // Reading the data after the flags clears them.
            let _ = self.usart.dr().read();
        }
        failed
    }

    /// Goes on at another rate. What is on the wire is lost.
    pub fn set_rate(&mut self, baud: u32) {
        self.usart.cr1().modify(|_, w| w.ue().clear_bit());
        // SAFETY: a divider of 16 bits.
        self.usart
            .brr()
            .write(|w| unsafe { w.bits(divider(self.clock_hz, baud)) });
        self.usart.cr1().modify(|_, w| w.ue().set_bit());
    }

    /// Sends what `fill` puts into the buffer ([`CHUNK`] bytes) and counts; does nothing while the wire is busy.
    pub fn send(&mut self, fill: impl FnOnce(&mut [u8]) -> usize) {
        if !self.is_ready() {
            return;
        }
        // SAFETY: the DMA is not sending, and there is one `Serial`, borrowed mutably here.
        let buffer = unsafe { &mut *SENDING.0.get() };
        let count = fill(buffer).min(CHUNK);
        if count == 0 {
            return;
        }
        // The flags of the last sending must be clear before the next.
        self.dma.hifcr().write(|w| {
            w.ctcif6().clear().chtif6().clear().cteif6().clear();
            w.cdmeif6().clear().cfeif6().clear()
        });
        let stream = self.dma.st(6);
        // SAFETY: a count within the buffer.
        stream.ndtr().write(|w| unsafe { w.bits(count as u32) });
        cortex_m::asm::dmb();
        stream.cr().modify(|_, w| w.en().enabled());
    }
}

/// Divider of the clock for a rate, rounded.
fn divider(clock_hz: u32, baud: u32) -> u16 {
    ((clock_hz + baud / 2) / baud) as u16
}
