//! Hardware-timed sampling: TIM2 → ADC1 → DMA2 stream 0, without the processor.
//!
//! TIM2 updates at 20 kHz; each update triggers a scan of three channels (force, hammer, cart), which the
//! DMA writes into a ring of two halves of [`BLOCK_TICKS`] frames. An interrupt comes at the end of each
//! half, once in 500 µs; the half is not written again until the next interrupt.
//!
//! | quantity | value | from |
//! |---|---|---|
//! | ADC clock | 22.5 MHz | APB2's 90 MHz / 4; the part allows 36 MHz |
//! | sampling time | 56 cycles, 2.5 µs | settles a 12-bit input behind up to some 10 kΩ |
//! | one channel | 68 cycles, 3.0 µs | sampling + 12 cycles of conversion |
//! | scan | 9.1 µs of the tick's 50 µs | so hammer and cart lag force by 3.0 and 6.0 µs |
//!
//! Once a second the part's own reference is read as an injected conversion (21.9 µs), started by the control task when
//! the block's last scan has ended: it ends before the next scan begins, or delays that one scan by so much.
//!
//! Why not at 80 kHz, with a decimating filter: docs/wiring.md.
//!
//! Sources: RM0390, "Analog-to-digital converter" and "DMA request mapping" (stream 0, channel 0: ADC1).
#![allow(unsafe_code)]

use core::cell::UnsafeCell;

use shared::io::{AdcCode, Frame};
use shared::settings::TICK_RATE_HZ;
use stm32f4xx_hal::{
    adc::{
        Adc,
        config::{AdcConfig, Clock, Dma, ExternalTrigger, SampleTime, Scan, Sequence, TriggerMode},
    },
    gpio::{Analog, PA0, PA1, PB0},
    pac,
    rcc::{Enable, Rcc},
    signature::VrefCal,
};

use crate::hardware::tasks::blocks::{Arrived, Half};
use crate::{BLOCK_TICKS, reference};

/// Channels of a scan: force, hammer, cart.
const CHANNELS: usize = 3;
/// Samples of both halves.
const SAMPLES: u16 = (2 * BLOCK_TICKS * CHANNELS) as u16;

/// The ADC's input from the part's own reference, and its sampling time: 480 cycles are 21 µs where it needs 10.
const REFERENCE: (u8, u8) = (17, 7);
/// JEOC and JSTRT of ADC_SR.
const INJECTED: u32 = 0b1100;
/// Blocks between two readings of the reference: a second.
const REFERENCE_BLOCKS: u16 = 2_000;
/// Looks at a reading at the start; one takes 22 µs.
const LOOKS: u32 = 100_000;

/// Frames as the DMA writes them.
type Ring = [[[u16; CHANNELS]; BLOCK_TICKS]; 2];

/// Memory that the DMA writes to.
struct Shared(UnsafeCell<Ring>);

// SAFETY: the one place that reads it, `AdcSampler::take`, reads the half that the DMA has left, by volatile
// reads, and there is one `AdcSampler` (it owns the DMA's stream).
unsafe impl Sync for Shared {}

static RING: Shared = Shared(UnsafeCell::new([[[0; CHANNELS]; BLOCK_TICKS]; 2]));

/// Pins of the three sensors.
pub type SensorPins = (PA0<Analog>, PA1<Analog>, PB0<Analog>);

/// The sampling chain: TIM2, ADC1 and DMA2, and the watch over the reference.
pub struct AdcSampler {
    timer: pac::TIM2,
    dma: pac::DMA2,
    _adc: Adc<pac::ADC1>,
    watch: reference::RunReadings,
    /// Blocks since the last reading of the reference was started.
    since: u16,
}

impl AdcSampler {
    /// Sets the chain up; nothing runs until [`Self::start`].
    pub fn new(
        timer: pac::TIM2,
        adc: pac::ADC1,
        dma: pac::DMA2,
        pins: &SensorPins,
        rcc: &mut Rcc,
    ) -> Self {
        pac::TIM2::enable(rcc);
        pac::DMA2::enable(rcc);

        let config = AdcConfig::default()
            .clock(Clock::Pclk2_div_4)
            .scan(Scan::Enabled)
            .external_trigger(TriggerMode::RisingEdge, ExternalTrigger::Tim_2_trgo)
            .dma(Dma::Continuous);
        let mut adc = Adc::new(adc, true, config, rcc);
        adc.configure_channel(&pins.0, Sequence::One, SampleTime::Cycles_56);
        adc.configure_channel(&pins.1, Sequence::Two, SampleTime::Cycles_56);
        adc.configure_channel(&pins.2, Sequence::Three, SampleTime::Cycles_56);

        adc.enable_temperature_and_vref();
        let (channel, sampling) = REFERENCE;
        // SAFETY: the pointer to registers that `adc` owns, which is here.
        let registers = unsafe { &*pac::ADC1::ptr() };
        // SAFETY: a sampling time of three bits, and a channel that is there; one injected conversion, the fourth place's.
        unsafe {
            registers.smpr1().modify(|_, w| w.smp17().bits(sampling));
            registers
                .jsqr()
                .write(|w| w.jl().bits(0).jsq4().bits(channel));
        }

        let stream = dma.st(0);
        let from = adc.data_register_address();
        let to = RING.0.get() as u32;
        // SAFETY: addresses of the ADC's data register and of a static buffer of SAMPLES half words.
        unsafe {
            stream.par().write(|w| w.bits(from));
            stream.m0ar().write(|w| w.bits(to));
            stream.ndtr().write(|w| w.bits(u32::from(SAMPLES)));
            // Channel 0.
            stream.cr().write(|w| {
                w.chsel().bits(0);
                w.dir()
                    .peripheral_to_memory()
                    .minc()
                    .incremented()
                    .circ()
                    .enabled();
                w.psize().bits16().msize().bits16().pl().very_high();
                w.htie().enabled().tcie().enabled().teie().enabled()
            });
        }
        stream.cr().modify(|_, w| w.en().enabled());

        // Without the prescaler TIM2 counts at 90 MHz, twice APB1's clock; its update goes to the ADC and,
        // as a DMA request, to the DAC. The reload takes effect at once, so no update is forced here.
        let counts = rcc.clocks.timclk1().raw() / TICK_RATE_HZ;
        // SAFETY: any value of the reload register is a valid one.
        timer.arr().write(|w| unsafe { w.bits(counts - 1) });
        timer.cr2().modify(|_, w| w.mms().update());
        timer.dier().modify(|_, w| w.ude().set_bit());
        Self {
            timer,
            dma,
            _adc: adc,
            watch: reference::RunReadings::default(),
            // Past the block in which a reading is fetched.
            since: 1,
        }
    }

    /// Whether VDDA is good at the start, before anything samples.
    pub fn reference_is_good(&mut self) -> bool {
        // The reference has had its 12 µs to start since `new`.
        cortex_m::asm::delay(18_000);
        start_reference();
        let code = (0..LOOKS).find_map(|_| take_reference());
        code.is_some_and(|code| reference::is_good(VrefCal::get().read(), code))
    }

    /// Reads the reference now and then; to be called once per block, first of all. Whether it is lost.
    #[inline]
    pub fn reference_is_lost(&mut self) -> bool {
        self.since = self.since.saturating_add(1);
        if self.since >= REFERENCE_BLOCKS {
            self.since = 0;
            start_reference();
        }
        if self.since != 1 {
            return false;
        }
        // A block later. A reading that did not come is a bad one.
        let code = take_reference().unwrap_or(0);
        self.watch.is_lost(VrefCal::get().read(), code)
    }

    /// Starts ticking. Sampling and playing begin at the same update and stay in step.
    pub fn start(&mut self) {
        self.timer.cr1().modify(|_, w| w.cen().set_bit());
    }

    /// Acknowledges an interrupt; to be called first in it.
    #[inline]
    pub fn arrived(&mut self) -> Arrived {
        let flags = self.dma.lisr().read();
        let (half, full) = (flags.htif0().bit(), flags.tcif0().bit());
        let failed = flags.teif0().bit() || flags.dmeif0().bit();
        self.dma.lifcr().write(|w| {
            w.chtif0().clear().ctcif0().clear();
            w.cteif0().clear().cdmeif0().clear()
        });
        // The count of remaining transfers shows which half is being written now; the other is complete.
        let left = self.dma.st(0).ndtr().read().bits() as u16;
        Arrived {
            any: half || full,
            half: Half::complete(left, SAMPLES),
            lost: half && full,
            failed,
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
                .cast::<[[u16; CHANNELS]; BLOCK_TICKS]>()
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
        let flags = self.dma.lisr().read();
        flags.htif0().bit() || flags.tcif0().bit()
    }
}

/// Starts an injected conversion of the part's own reference.
fn start_reference() {
    // SAFETY: sets one bit; the control task alone changes this register once the sampling runs.
    let adc = unsafe { &*pac::ADC1::ptr() };
    adc.cr2().modify(|_, w| w.jswstart().set_bit());
}

/// Its result, if it has ended.
fn take_reference() -> Option<u16> {
    // SAFETY: reads, and a store of ones that changes nothing but the two flags of the injected conversion.
    unsafe {
        let adc = &*pac::ADC1::ptr();
        let ended = adc.sr().read().jeoc().bit();
        if !ended {
            return None;
        }
        adc.sr().write(|w| w.bits(0x3f & !INJECTED));
        Some(adc.jdr1().read().bits() as u16 & 0xfff)
    }
}
