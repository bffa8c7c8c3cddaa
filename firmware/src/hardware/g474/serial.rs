//! The link's wire: USART2, which the on-board debugger passes on as a virtual serial port, by DMA either way. (The
//! debugger's pins are also those of LPUART1, which ST's examples use; its kernel clock would have to divide otherwise.)
//!
//! | quantity | value | why |
//! |---|---|---|
//! | rate | 2.25 Mbaud, or 921,600 | [`crate::wire`]: the one that the computer uses |
//! | rate's error | −0.6 %, or 0.2 % | 170 MHz / 76, or / 184; a byte bears some 3 % |
//! | sent at once | [`CHUNK`], 1024 bytes | 4.6 ms of the wire ([`crate::wire`]) |
//! | receive ring | 1024 bytes | 4.5 ms of the wire; the link task looks every millisecond |
//!
//! What arrives while the ring is full overwrites what was not read; the frame's check then fails and the loss is
//! counted. While the wire is busy nothing is sent: nothing waits here.
#![allow(unsafe_code)]

use core::cell::UnsafeCell;

use super::{
    clock::SYSCLK_HZ,
    dma::{self, Channel},
    pac,
};
use crate::wire::{CHUNK, RATES};

/// Bytes of the receive ring.
const RECEIVE: usize = 1024;

/// Bytes the DMA touches.
struct Shared<const N: usize>(UnsafeCell<[u8; N]>);

// SAFETY: both are touched by the one `Serial` alone, by volatile accesses: the receive ring is read only where
// the DMA has passed, the send buffer written only while the DMA is not sending.
unsafe impl<const N: usize> Sync for Shared<N> {}

static RECEIVED: Shared<RECEIVE> = Shared(UnsafeCell::new([0; RECEIVE]));
static SENDING: Shared<CHUNK> = Shared(UnsafeCell::new([0; CHUNK]));

/// The wire.
pub struct Serial {
    usart: pac::USART2,
    read: usize,
    /// The DMA was told to send, and has not been seen to end.
    sending: bool,
}

impl Serial {
    /// Receives from now on.
    pub(super) fn new(usart: pac::USART2) -> Self {
        const { assert!(RECEIVE.is_power_of_two()) };
        usart.brr().write(|w| w.brr().set(divider(RATES[0])));
        Channel::Receive.aim(
            usart.rdr().as_ptr() as u32,
            RECEIVED.0.get() as u32,
            RECEIVE as u16,
        );
        Channel::Receive.registers().cr().write(|w| {
            w.dir().from_peripheral().minc().enabled().circ().enabled();
            w.psize().bits8().msize().bits8().pl().medium();
            w.en().enabled()
        });
        Channel::Send.aim(usart.tdr().as_ptr() as u32, SENDING.0.get() as u32, 0);
        usart.cr3().write(|w| w.dmar().set_bit().dmat().set_bit());
        usart
            .cr1()
            .write(|w| w.ue().set_bit().re().set_bit().te().set_bit());
        Self {
            usart,
            read: 0,
            sending: false,
        }
    }

    /// The next byte that has come in.
    #[inline]
    pub fn read(&mut self) -> Option<u8> {
        let left = usize::from(Channel::Receive.left());
        let written = RECEIVE.wrapping_sub(left) % RECEIVE;
        if self.read == written {
            return None;
        }
        // SAFETY: an index within the ring, by the remainder.
        let byte = unsafe { RECEIVED.0.get().cast::<u8>().add(self.read).read_volatile() };
        self.read = (self.read + 1) % RECEIVE;
        Some(byte)
    }

    /// Whether the wire takes something to send. This DMA does not switch a channel off when it has done.
    fn is_ready(&mut self) -> bool {
        let flags = dma::flags();
        self.sending &= !(flags.tcif4().bit() || flags.teif4().bit());
        !self.sending
    }

    /// Whether bytes have come since the last call that were none: no stop bit where one must be, or noise.
    pub fn take_errors(&mut self) -> bool {
        let flags = self.usart.isr().read();
        let failed = flags.fe().bit() || flags.nf().bit() || flags.ore().bit();
        if failed {
            self.usart.icr().write(|w| {
                w.fecf().clear_bit_by_one();
                w.ncf().clear_bit_by_one().orecf().clear_bit_by_one()
            });
        }
        failed
    }

    /// Goes on at another rate. What is on the wire is lost.
    pub fn set_rate(&mut self, baud: u32) {
        self.usart.cr1().modify(|_, w| w.ue().clear_bit());
        self.usart.brr().write(|w| w.brr().set(divider(baud)));
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
        let channel = Channel::Send.registers();
        // The count can be written only while the channel is off.
        channel.cr().write(|w| {
            w.dir().from_memory().minc().enabled();
            w.psize().bits8().msize().bits8().pl().low()
        });
        dma::clear(Channel::Send);
        channel.ndtr().write(|w| w.ndt().set(count as u16));
        cortex_m::asm::dmb();
        channel.cr().modify(|_, w| w.en().enabled());
        self.sending = true;
    }
}

/// Divider of the clock for a rate, rounded.
fn divider(baud: u32) -> u16 {
    ((SYSCLK_HZ + baud / 2) / baud) as u16
}
