//! What the set-up has written and nothing else writes: read again once a second, a register that has changed by itself, or by
//! a stray store, is found before its effect is.
#![allow(unsafe_code)]

use stm32f4xx_hal::pac;

/// Clocks: HSEON, HSEBYP, CSSON, PLLON of RCC_CR; SW and the prescalers of RCC_CFGR; ADON, DDS, DMA and trigger of ADC1_CR2
/// (without the start bits). The rest as it is.
const RCC_CR: u32 = 0x010d_0000;
const RCC_CFGR: u32 = 0xfcf3;
const ADC_CR2: u32 = 0x3f00_0f03;

/// Values of the registers that the set-up alone writes; of RCC_CR, RCC_CFGR and ADC1_CR2 certain bits.
pub type Registers = [u32; 48];

/// Reads these registers, without side effect.
pub fn read() -> Registers {
    // SAFETY: reads without side effect.
    unsafe {
        let (rcc, flash, pwr) = (&*pac::RCC::ptr(), &*pac::FLASH::ptr(), &*pac::PWR::ptr());
        let (a, b, c) = (
            &*pac::GPIOA::ptr(),
            &*pac::GPIOB::ptr(),
            &*pac::GPIOC::ptr(),
        );
        let (ticks, motor) = (&*pac::TIM2::ptr(), &*pac::TIM3::ptr());
        let (link, guard) = (&*pac::TIM6::ptr(), &*pac::TIM7::ptr());
        let (adc, dac) = (&*pac::ADC1::ptr(), &*pac::DAC::ptr());
        let (dma1, dma2) = (&*pac::DMA1::ptr(), &*pac::DMA2::ptr());
        let (exti, syscfg) = (&*pac::EXTI::ptr(), &*pac::SYSCFG::ptr());
        let (usart, watchdog) = (&*pac::USART2::ptr(), &*pac::IWDG::ptr());
        [
            rcc.cr().read().bits() & RCC_CR,
            rcc.cfgr().read().bits() & RCC_CFGR,
            rcc.pllcfgr().read().bits(),
            rcc.ahb1enr().read().bits(),
            rcc.apb1enr().read().bits(),
            rcc.apb2enr().read().bits(),
            flash.acr().read().bits(),
            pwr.cr().read().bits(),
            a.moder().read().bits(),
            a.afrl().read().bits(),
            a.pupdr().read().bits(),
            b.moder().read().bits(),
            b.pupdr().read().bits(),
            c.moder().read().bits(),
            c.afrl().read().bits(),
            ticks.cr1().read().bits(),
            ticks.cr2().read().bits(),
            ticks.dier().read().bits(),
            ticks.psc().read().bits(),
            ticks.arr().read().bits(),
            motor.cr1().read().bits(),
            motor.psc().read().bits(),
            motor.arr().read().bits(),
            motor.ccer().read().bits(),
            link.cr1().read().bits(),
            link.psc().read().bits(),
            link.arr().read().bits(),
            guard.cr1().read().bits(),
            guard.dier().read().bits(),
            guard.psc().read().bits(),
            guard.arr().read().bits(),
            adc.cr1().read().bits(),
            adc.cr2().read().bits() & ADC_CR2,
            adc.smpr2().read().bits(),
            adc.sqr1().read().bits(),
            adc.sqr3().read().bits(),
            dac.cr().read().bits(),
            dma2.st(0).cr().read().bits(),
            dma2.st(0).par().read().bits(),
            dma2.st(0).m0ar().read().bits(),
            dma1.st(1).cr().read().bits(),
            dma1.st(1).par().read().bits(),
            dma1.st(1).m0ar().read().bits(),
            exti.imr().read().bits(),
            exti.rtsr().read().bits(),
            syscfg.exticr2().read().bits(),
            usart.cr3().read().bits().into(),
            watchdog.rlr().read().bits().into(),
        ]
    }
}
