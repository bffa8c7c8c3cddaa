//! Hardware-timed sampling: TIM2 → ADC1 → DMA1 channel 1, without the processor.
//!
//! TIM2 updates at 20 kHz; each update triggers a scan of three inputs (force, hammer, cart), which the
//! DMA writes into a ring of two halves of [`BLOCK_TICKS`] frames. An interrupt comes at the end of each
//! half, once in 500 µs; the half is not written again until the next interrupt.
//!
//! | quantity | value | from |
//! |---|---|---|
//! | ADC clock | 42.5 MHz | the AHB's 170 MHz / 4; one ADC may have 60 MHz |
//! | sampling time | 92.5 cycles, 2.2 µs | settles a 12-bit input behind some 10 kΩ (believed) |
//! | one input | 105 cycles, 2.5 µs | sampling + 12.5 cycles of conversion |
//! | scan | 7.4 µs of the tick's 50 µs | so hammer and cart lag force by 2.5 and 4.9 µs |
//!
//! An overrun of the ADC ends its requests (OVRMOD 0): no sample can slip into another's place, blocks stop coming, and the
//! guard acts.
//!
//! Once a second the part's own reference is read as an injected conversion (15.4 µs), started by the control task when
//! the block's last scan has ended.
//!
//! Not used yet: oversampling. With one trigger for a scan it averages several conversions of an input within the scan and is
//! no filter against what rings at the sampling rate. At 80 kHz it would be one: three of the part's five ADCs,
//! one for each sensor, each triggered four times in a tick (TROVS), so that they sample at the same instant, too.
#![allow(unsafe_code)]

use core::cell::UnsafeCell;

use shared::io::{AdcCode, Frame};
use shared::settings::TICK_RATE_HZ;

use super::{
    clock::SYSCLK_HZ,
    dma::{self, Channel},
    pac,
};
use crate::hardware::tasks::blocks::{Arrived, Half};
use crate::{BLOCK_TICKS, reference};

/// Force, hammer, cart: ADC1's inputs of PA0, PA1 and PB0.
const INPUTS: [u8; 3] = [1, 2, 15];
/// Samples of both halves.
const SAMPLES: u16 = (2 * BLOCK_TICKS * INPUTS.len()) as u16;

/// The ADC's input from the part's own reference.
const REFERENCE: u8 = 18;
/// Blocks between two readings of the reference: a second.
const REFERENCE_BLOCKS: u16 = 2_000;
/// Looks at a reading at the start; one takes 15 µs.
const LOOKS: u32 = 100_000;
/// Where the part has what it read of its reference when it was made, at 3.0 V.
const CALIBRATION: *const u16 = 0x1fff_75aa as *const u16;
/// Cycles for 20 µs at least, at 170 MHz: what the ADC's regulator, and the reference, need to start.
const STARTING: u32 = 3_400;

/// Frames as the DMA writes them.
type Ring = [[[u16; INPUTS.len()]; BLOCK_TICKS]; 2];

/// Memory that the DMA writes to.
struct Shared(UnsafeCell<Ring>);

// SAFETY: the one place that reads it, `Sampler::take`, reads the half that the DMA has left, by volatile
// reads, and there is one `Sampler`.
unsafe impl Sync for Shared {}

static RING: Shared = Shared(UnsafeCell::new([[[0; INPUTS.len()]; BLOCK_TICKS]; 2]));

/// The sampling chain.
pub struct Sampler {
    timer: pac::TIM2,
    adc: pac::ADC1,
    watch: reference::Watch,
    /// Blocks since the last reading of the reference was started.
    since: u16,
}

impl Sampler {
    /// Sets the chain up; it samples from [`Self::start`] on.
    pub(super) fn new(timer: pac::TIM2, adc: pac::ADC1, common: &pac::ADC12_COMMON) -> Self {
        common
            .ccr()
            .modify(|_, w| w.ckmode().sync_div4().vrefen().set_bit());
        wake(&adc);
        configure(&adc);

        Channel::Samples.aim(adc.dr().as_ptr() as u32, RING.0.get() as u32, SAMPLES);
        Channel::Samples.registers().cr().write(|w| {
            w.dir().from_peripheral().minc().enabled().circ().enabled();
            w.psize().bits16().msize().bits16().pl().very_high();
            w.htie().enabled().tcie().enabled().teie().enabled();
            w.en().enabled()
        });

        // The update goes to the ADC and, as a DMA request, to the DAC. The reload takes effect at once, so no update
        // is forced here.
        timer
            .arr()
            .write(|w| w.arr().set(SYSCLK_HZ / TICK_RATE_HZ - 1));
        // SAFETY: 2 is the update.
        timer.cr2().modify(|_, w| unsafe { w.mms().bits(2) });
        timer.dier().modify(|_, w| w.ude().set_bit());
        begin(&adc, |w| w.adstart().set_bit());
        Self {
            timer,
            adc,
            watch: reference::Watch::default(),
            // Past the block in which a reading is fetched.
            since: 1,
        }
    }

    /// Whether VDDA is good at the start, before anything samples.
    pub(super) fn reference_is_good(&mut self) -> bool {
        cortex_m::asm::delay(STARTING);
        self.start_reference();
        let code = (0..LOOKS).find_map(|_| self.take_reference());
        code.is_some_and(|code| reference::is_good(calibration(), code))
    }

    /// Reads the reference now and then; to be called once per block, first of all. Whether it is lost.
    #[inline]
    pub fn reference_is_lost(&mut self) -> bool {
        self.since = self.since.saturating_add(1);
        if self.since >= REFERENCE_BLOCKS {
            self.since = 0;
            self.start_reference();
        }
        if self.since != 1 {
            return false;
        }
        // A block later. A reading that did not come is a bad one.
        let code = self.take_reference().unwrap_or(0);
        self.watch.is_lost(calibration(), code)
    }

    /// Starts an injected conversion.
    fn start_reference(&mut self) {
        begin(&self.adc, |w| w.jadstart().set_bit());
    }

    /// Its result, if it has ended. Reading it clears the flag of the conversion; that of the sequence stays and is not
    /// looked at.
    fn take_reference(&mut self) -> Option<u16> {
        let ended = self.adc.isr().read().jeoc().bit_is_set();
        ended.then(|| self.adc.jdr1().read().bits() as u16 & 0xfff)
    }

    /// Starts ticking. Sampling and playing begin at the same update and stay in step.
    pub fn start(&mut self) {
        self.timer.cr1().modify(|_, w| w.cen().set_bit());
    }

    /// Acknowledges an interrupt; to be called first in it.
    #[inline]
    pub fn arrived(&mut self) -> Arrived {
        let flags = dma::flags();
        let (half, full) = (flags.htif1().bit(), flags.tcif1().bit());
        dma::clear(Channel::Samples);
        Arrived {
            any: half || full,
            // The count of remaining transfers shows which half is being written now; the other is complete.
            half: Half::complete(Channel::Samples.left(), SAMPLES),
            lost: half && full,
            failed: flags.teif1().bit(),
        }
    }

    /// Copies the half out; `emergency` is whether the chain was found open during the block.
    #[inline]
    pub fn take(&mut self, half: Half, emergency: bool) -> [Frame; BLOCK_TICKS] {
        let mut frames = [Frame::default(); BLOCK_TICKS];
        // SAFETY: the half is one of two of the ring, and the DMA writes the other one now.
        let raw = unsafe {
            RING.0
                .get()
                .cast::<[[u16; INPUTS.len()]; BLOCK_TICKS]>()
                .add(half.index())
                .read_volatile()
        };
        for (frame, [force, hammer, cart]) in frames.iter_mut().zip(raw) {
            *frame = Frame {
                force: AdcCode(force),
                hammer: AdcCode(hammer),
                cart: AdcCode(cart),
                emergency,
            };
        }
        frames
    }

    /// Whether the next block is complete already; to be called last in the interrupt.
    #[inline]
    pub fn overrun(&self) -> bool {
        let flags = dma::flags();
        flags.htif1().bit() || flags.tcif1().bit()
    }
}

/// Sets a bit of the control register that starts something. Of those that are set already none may be written back, and
/// zeros change nothing, but for the regulator's bit. (`write` begins with the value after a reset, which is deep sleep.)
fn begin(adc: &pac::ADC1, what: impl FnOnce(&mut pac::adc1::cr::W) -> &mut pac::adc1::cr::W) {
    adc.cr()
        .write(|w| what(w.deeppwd().clear_bit().advregen().set_bit()));
}

/// Out of its deep sleep, its regulator on, calibrated, and on (RM0440, "ADC deep-power-down mode and ADC voltage
/// regulator", "Calibration", "ADC on-off control"). What it waits for takes microseconds; if it never comes, the watchdog
/// does.
fn wake(adc: &pac::ADC1) {
    adc.cr().write(|w| w.deeppwd().clear_bit());
    begin(adc, |w| w);
    cortex_m::asm::delay(STARTING);
    begin(adc, |w| w.adcal().set_bit());
    while adc.cr().read().adcal().bit_is_set() {}
    // Four cycles of the ADC's clock must pass: 16 of the processor's.
    cortex_m::asm::delay(32);
    adc.isr().write(|w| w.adrdy().clear_bit_by_one());
    begin(adc, |w| w.aden().set_bit());
    while adc.isr().read().adrdy().bit_is_clear() {}
}

/// The scan, its trigger and its DMA; and the reference as the one injected conversion, started by the program.
fn configure(adc: &pac::ADC1) {
    let [force, hammer, cart] = INPUTS;
    adc.cfgr().modify(|_, w| {
        w.dmaen().enabled().dmacfg().circular();
        w.exten().rising_edge().extsel().tim2_trgo()
    });
    // SAFETY: inputs that are there.
    unsafe {
        adc.sqr1().write(|w| {
            w.l().set(INPUTS.len() as u8 - 1);
            w.sq1().bits(force).sq2().bits(hammer).sq3().bits(cart)
        });
        adc.jsqr().write(|w| w.jsq1().bits(REFERENCE));
    }
    adc.smpr1()
        .write(|w| w.smp1().cycles92_5().smp2().cycles92_5());
    adc.smpr2()
        .write(|w| w.smp15().cycles92_5().smp18().cycles640_5());
}

/// What the part's reference read when it was made, as it would have been at 3.3 V.
fn calibration() -> u16 {
    // SAFETY: a half word of the part's memory that is always there.
    let at_3_v = u32::from(unsafe { CALIBRATION.read_volatile() });
    ((at_3_v * 30 + 16) / 33) as u16
}
