//! The link's wire: USART2, which the on-board debugger passes on as a virtual serial port, by DMA either way.
//!
//! | quantity | value | why |
//! |---|---|---|
//! | rate | [`BAUD`], 2.25 Mbaud | carries a recording of every tick ([`shared::link::BAUD`]) |
//! | rate's error | none | 45 MHz / 20; the debugger's side divides evenly, too |
//! | receive ring | 1024 bytes | 4.5 ms of the wire; the link task looks every millisecond |
//!
//! What arrives while the ring is full overwrites what was not read; the frame's check then fails and the loss is
//! counted. A send while the wire is busy is refused: nothing waits here.
//!
//! Sources: RM0390, "DMA request mapping" (DMA1 channel 4: stream 5 USART2_RX, stream 6 USART2_TX).
#![allow(unsafe_code)]

use core::cell::UnsafeCell;

use shared::link::BAUD;
use stm32f4xx_hal::{
    gpio::{Alternate, PA2, PA3},
    pac,
    rcc::{Enable, Rcc, Reset},
};

/// Bytes of the receive ring.
const RECEIVE: usize = 1024;
/// Bytes sent at once at most.
pub const SEND: usize = 1024;

/// Bytes the DMA touches.
struct Shared<const N: usize>(UnsafeCell<[u8; N]>);

// SAFETY: both are touched by the one `Serial` alone, by volatile accesses: the receive ring is read only where
// the DMA has passed, the send buffer written only while the DMA is not sending.
unsafe impl<const N: usize> Sync for Shared<N> {}

static RECEIVED: Shared<RECEIVE> = Shared(UnsafeCell::new([0; RECEIVE]));
static SENDING: Shared<SEND> = Shared(UnsafeCell::new([0; SEND]));

/// The wire.
pub struct Serial {
    _usart: pac::USART2,
    dma: pac::DMA1,
    read: usize,
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

        let divider = (rcc.clocks.pclk1().raw() + BAUD / 2) / BAUD;
        let data = usart.dr().as_ptr() as u32;
        // SAFETY: a divider of 16 bits; the address of the data register and of static buffers of that many bytes.
        unsafe {
            usart.brr().write(|w| w.bits(divider as u16));
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
            _usart: usart,
            dma,
            read: 0,
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

    /// Sends bytes (at most [`SEND`]); `false`, and nothing sent, if the wire is busy or they are too many.
    pub fn send(&mut self, bytes: &[u8]) -> bool {
        if !self.is_ready() || bytes.len() > SEND {
            return false;
        }
        if bytes.is_empty() {
            return true;
        }
        for (i, byte) in bytes.iter().enumerate() {
            // SAFETY: within the buffer, and the DMA is not sending.
            unsafe { SENDING.0.get().cast::<u8>().add(i).write_volatile(*byte) };
        }
        // The flags of the last sending must be clear before the next.
        self.dma.hifcr().write(|w| {
            w.ctcif6().clear().chtif6().clear().cteif6().clear();
            w.cdmeif6().clear().cfeif6().clear()
        });
        let stream = self.dma.st(6);
        // SAFETY: a count within the buffer.
        stream
            .ndtr()
            .write(|w| unsafe { w.bits(bytes.len() as u32) });
        cortex_m::asm::dmb();
        stream.cr().modify(|_, w| w.en().enabled());
        true
    }
}
