//! Hardware-timed set-points: TIM2's update → DMA1 stream 1 → DAC channel 1 on PA4, a code per tick; and a
//! motor drive's frequency as a duty cycle on PC7, once per block.
//!
//! The codes lie in a ring of two halves like the samples', filled and played in step with it: codes worked
//! out from half h while the other half is being sampled are played when h is sampled again. From a sample
//! to its set-point it is 20 ticks: 10 to gather the block, 10 to work on it. The DMA writes the
//! DAC's register some 0.1 µs after the update, whatever the processor does. It fetches each code one update ahead: the
//! first of a half with the last update of the other half, 491 µs after the interrupt that asks for it (the block's last
//! scan took 9 µs).
//!
//! The DAC's second output would be PA5, which drives the board's LED; so there is one. Its buffer is on:
//! 0.2 V to 3.1 V into 5 kΩ or more; the controller keeps within ([`shared::io::DAC_REACH`]). With the drive off the
//! code goes to the middle at a steady speed ([`crate::ramp`]).
//!
//! Duty cycle: 0 to 100 % stands for 0 to [`FULL_SCALE_HZ`], at 5 kHz in 18,000 steps of 0.003 Hz. A
//! low-pass of 50 Hz makes a voltage of it.
//!
//! Sources: RM0390, "DMA request mapping" (DMA1 stream 1, channel 3: TIM2_UP; the DAC's own request would
//! need stream 5, which the link receives on).
#![allow(unsafe_code)]

use core::cell::UnsafeCell;

use shared::io::{DacCode, Output};
use stm32f4xx_hal::{
    gpio::{Analog, PA4, PC7},
    pac,
    prelude::*,
    rcc::{Enable, Rcc, Reset},
    timer::{PwmChannel, PwmHzManager},
};

use crate::{BLOCK_TICKS, hardware::tasks::blocks::Half, ramp::Ramp};

/// Frequency set-point at a duty cycle of 100 %, Hz.
pub const FULL_SCALE_HZ: f32 = 50.0;

/// Codes as the DMA reads them.
type Ring = [[u16; BLOCK_TICKS]; 2];

/// Memory that the DMA reads.
struct Shared(UnsafeCell<Ring>);

// SAFETY: the one place that writes it is `SetPoints::play`, by volatile writes, and there is one.
unsafe impl Sync for Shared {}

static RING: Shared = Shared(UnsafeCell::new([[DacCode::MIDDLE.0; BLOCK_TICKS]; 2]));

/// Set-points in the hardware's hands.
pub struct SetPoints {
    _pin: PA4<Analog>,
    _pwm: PwmHzManager<pac::TIM3>,
    frequency: PwmChannel<pac::TIM3, 1>,
    full_duty: f32,
    ramp: Ramp,
}

impl SetPoints {
    /// In the middle and 0 Hz. Plays once the sampling timer runs.
    pub fn new(
        dac: pac::DAC,
        dma: &pac::DMA1,
        timer: pac::TIM3,
        (pin, motor): (PA4<Analog>, PC7),
        rcc: &mut Rcc,
    ) -> Self {
        pac::DAC::enable(rcc);
        pac::DAC::reset(rcc);
        pac::DMA1::enable(rcc);

        // SAFETY: a 12-bit code.
        dac.dhr12r1()
            .write(|w| unsafe { w.bits(u32::from(DacCode::MIDDLE.0)) });
        // Untriggered: a code written is out one APB1 cycle later.
        dac.cr().modify(|_, w| w.en1().enabled());

        let stream = dma.st(1);
        let to = dac.dhr12r1().as_ptr() as u32;
        let from = RING.0.get() as u32;
        // SAFETY: addresses of the DAC's register and of a static buffer of that many half words.
        unsafe {
            stream.par().write(|w| w.bits(to));
            stream.m0ar().write(|w| w.bits(from));
            stream.ndtr().write(|w| w.bits((2 * BLOCK_TICKS) as u32));
            stream.cr().write(|w| {
                w.chsel().bits(3);
                w.dir()
                    .memory_to_peripheral()
                    .minc()
                    .incremented()
                    .circ()
                    .enabled();
                w.psize().bits16().msize().bits16().pl().very_high()
            });
        }
        stream.cr().modify(|_, w| w.en().enabled());

        let (pwm, (_, frequency, ..)) = timer.pwm_hz(5.kHz(), rcc);
        let mut frequency = frequency.with(motor);
        frequency.set_duty(0);
        frequency.enable();
        Self {
            _pin: pin,
            _pwm: pwm,
            full_duty: f32::from(frequency.get_max_duty()),
            ramp: Ramp::default(),
            frequency,
        }
    }

    /// Lays a block's set-points into the half that is played next. Whether that was in time: if not, the DMA has begun with
    /// that half and played some of the old codes.
    #[inline]
    pub fn play(&mut self, half: Half, outputs: &[Output; BLOCK_TICKS]) -> bool {
        let mut codes = [0; BLOCK_TICKS];
        for (code, output) in codes.iter_mut().zip(outputs) {
            *code = self.ramp.step(output);
        }
        // SAFETY: one of the ring's two halves; the DMA reads the other one now.
        unsafe {
            RING.0
                .get()
                .cast::<[u16; BLOCK_TICKS]>()
                .add(half.index())
                .write_volatile(codes);
        }
        let frequency_hz = outputs.last().map_or(0.0, |output| output.frequency_hz);
        let share = (frequency_hz / FULL_SCALE_HZ).clamp(0.0, 1.0);
        self.frequency.set_duty((share * self.full_duty) as u16);

        // The count of codes still to be played, of both halves; it begins anew with the last.
        // SAFETY: a read without side effect.
        let left = unsafe { (*pac::DMA1::ptr()).st(1).ndtr().read().bits() } as usize;
        let in_first = left > BLOCK_TICKS || left == 0;
        in_first != (half.index() == 0)
    }
}

/// Stops the DMA, sets the DAC to the middle and the duty cycle to 0, from anywhere.
///
/// Before [`SetPoints::new`] the peripherals have no clock and the writes do nothing; then the pins float.
pub fn make_safe() {
    // SAFETY: single stores whose order does not matter, to peripherals nobody goes on using afterwards.
    unsafe {
        (*pac::DMA1::ptr()).st(1).cr().write(|w| w.en().disabled());
        (*pac::DAC::ptr())
            .dhr12r1()
            .write(|w| w.bits(u32::from(DacCode::MIDDLE.0)));
        (*pac::TIM3::ptr()).ccr2().write(|w| w.bits(0));
    }
}
