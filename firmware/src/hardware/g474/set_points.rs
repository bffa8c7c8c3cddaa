//! Hardware-timed set-points: TIM2's update → DMA1 channel 2 → DAC1 output 1 on PA4, a code per tick; and a
//! motor drive's frequency as a duty cycle on PC7, once per block.
//!
//! As on the NUCLEO-F446RE, codes worked out from half h of the samples are played when h is sampled again. One thing is
//! different: this DMA has no store of its own, and fetches each code with the update that plays it. So a block's
//! set-points must be there when the next tick begins, 492 µs after its interrupt.
//!
//! The DAC's buffer is on: 0.2 V to 3.1 V into 5 kΩ or more ([`shared::io::DAC_REACH`]). Its registers take whole words, so
//! the DMA widens each code to one.
//!
//! Duty cycle: 0 to 100 % stands for 0 to [`FULL_SCALE_HZ`], at 5 kHz in 34,000 steps.
#![allow(unsafe_code)]

use core::cell::UnsafeCell;

use shared::io::{DacCode, Output};

use super::{clock::SYSCLK_HZ, dma::Channel, pac};
use crate::{BLOCK_TICKS, hardware::tasks::blocks::Half, ramp::Ramp};

/// Frequency set-point at a duty cycle of 100 %, Hz.
const FULL_SCALE_HZ: f32 = 50.0;
/// Counts of the duty cycle's period.
const PERIOD: u32 = SYSCLK_HZ / 5_000;
/// Cycles for the 8 µs that the DAC needs to start, at 170 MHz.
const STARTING: u32 = 1_360;

/// Codes as the DMA reads them.
type Ring = [[u16; BLOCK_TICKS]; 2];

/// Memory that the DMA reads.
struct Shared(UnsafeCell<Ring>);

// SAFETY: the one place that writes it is `SetPoints::play`, by volatile writes, and there is one.
unsafe impl Sync for Shared {}

static RING: Shared = Shared(UnsafeCell::new([[DacCode::MIDDLE.0; BLOCK_TICKS]; 2]));

/// Set-points in the hardware's hands.
pub struct SetPoints {
    timer: pac::TIM3,
    ramp: Ramp,
}

impl SetPoints {
    /// In the middle and 0 Hz. Plays once the sampling timer runs.
    pub(super) fn new(dac: pac::DAC1, timer: pac::TIM3) -> Self {
        dac.mcr()
            .modify(|_, w| w.hfsel().more160mhz().mode1().normal_pin_buffer());
        dac.dhr12r1().write(|w| w.daccdhr().set(DacCode::MIDDLE.0));
        // Untriggered: a code written is out some cycles later.
        dac.cr().modify(|_, w| w.en1().set_bit());
        cortex_m::asm::delay(STARTING);

        Channel::SetPoints.aim(
            dac.dhr12r1().as_ptr() as u32,
            RING.0.get() as u32,
            2 * BLOCK_TICKS as u16,
        );
        Channel::SetPoints.registers().cr().write(|w| {
            w.dir().from_memory().minc().enabled().circ().enabled();
            w.psize().bits32().msize().bits16().pl().very_high();
            w.en().enabled()
        });

        // SAFETY: a reload of 16 bits. (The field alone would leave ones in the bits above, as they are after a reset.)
        timer.arr().write(|w| unsafe { w.bits(PERIOD - 1) });
        timer
            .ccmr1_output()
            .write(|w| w.oc2m().pwm_mode1().oc2pe().set_bit());
        timer.egr().write(|w| w.ug().set_bit());
        timer.ccer().write(|w| w.cc2e().set_bit());
        timer.cr1().write(|w| w.arpe().set_bit().cen().set_bit());
        Self {
            timer,
            ramp: Ramp::default(),
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
        self.timer
            .ccr2()
            .write(|w| w.ccr().set((share * PERIOD as f32) as u32));

        // The count of codes still to be played, of both halves: within a half, its first has been fetched.
        let left = Channel::SetPoints.left() as usize;
        let begun = match half.index() {
            0 => BLOCK_TICKS + 1..2 * BLOCK_TICKS,
            _ => 1..BLOCK_TICKS,
        };
        !begun.contains(&left)
    }
}

/// Stops the DMA, sets the DAC to the middle and the duty cycle to 0, from anywhere.
///
/// Before [`SetPoints::new`] the peripherals have no clock and the writes do nothing; then the pins float.
pub fn make_safe() {
    Channel::SetPoints.registers().cr().reset();
    // SAFETY: single stores whose order does not matter, to peripherals nobody goes on using afterwards.
    unsafe {
        (*pac::DAC1::ptr())
            .dhr12r1()
            .write(|w| w.daccdhr().set(DacCode::MIDDLE.0));
        (*pac::TIM3::ptr()).ccr2().reset();
    }
}
