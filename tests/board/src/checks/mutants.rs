//! Mutants: the image with one mistake in its set-up, which the model makes by changing what the image writes to one field
//! of one register. Each must fail in a check, as it would on the bench; one that passes shows where the model is lenient.

use std::rc::Rc;
use std::sync::atomic::{AtomicUsize, Ordering};

use host_sim::progress::ProgressLine;

use super::{ALL, Check, Found, Setup};
use crate::image::Image;
use crate::machine::Patch;

/// Name, register, bits, and what they are instead of what the image writes.
type Mutant = (&'static str, u32, u32, u32);

const PORT_A: u32 = 0x4002_0000;
const PORT_B: u32 = 0x4002_0400;
const PORT_C: u32 = 0x4002_0800;
const MODER: u32 = 0x00;
const OTYPER: u32 = 0x04;
const PUPDR: u32 = 0x0c;
const AFRL: u32 = 0x20;
const RCC: u32 = 0x4002_3800;
const RCC_CR: u32 = RCC;
const PLLCFGR: u32 = RCC + 0x04;
const CFGR: u32 = RCC + 0x08;
const AHB1ENR: u32 = RCC + 0x30;
const APB1ENR: u32 = RCC + 0x40;
const APB2ENR: u32 = RCC + 0x44;
const FLASH_ACR: u32 = 0x4002_3c00;
const PWR_CR: u32 = 0x4000_7000;
const EXTICR2: u32 = 0x4001_380c;
const EXTI_IMR: u32 = 0x4001_3c00;
const EXTI_RTSR: u32 = 0x4001_3c08;
const TIM2: u32 = 0x4000_0000;
const TIM3: u32 = 0x4000_0400;
const TIM6: u32 = 0x4000_1000;
const TIM7: u32 = 0x4000_1400;
const TIM_CR1: u32 = 0x00;
const TIM_CR2: u32 = 0x04;
const TIM_DIER: u32 = 0x0c;
const TIM_CCMR1: u32 = 0x18;
const TIM_CCER: u32 = 0x20;
const TIM_PSC: u32 = 0x28;
const TIM_ARR: u32 = 0x2c;
const TIM11: u32 = 0x4001_4800;
const TIM11_OR: u32 = TIM11 + 0x50;
const ADC_CR1: u32 = 0x4001_2004;
const ADC_CR2: u32 = 0x4001_2008;
const ADC_SMPR1: u32 = 0x4001_200c;
const ADC_SMPR2: u32 = 0x4001_2010;
const ADC_SQR1: u32 = 0x4001_202c;
const ADC_SQR3: u32 = 0x4001_2034;
const ADC_JSQR: u32 = 0x4001_2038;
const ADC_CCR: u32 = 0x4001_2304;
const DAC_CR: u32 = 0x4000_7400;
/// The samples' stream (DMA2, 0), the set-points' (DMA1, 1), the link's in and out (DMA1, 5 and 6): control register; then
/// count, and the addresses of peripheral and memory.
const SAMPLES: u32 = 0x4002_6410;
const CODES: u32 = 0x4002_6028;
const LINK_IN: u32 = 0x4002_6088;
const LINK_OUT: u32 = 0x4002_60a0;
const NDTR: u32 = 4;
const PAR: u32 = 8;
const M0AR: u32 = 12;
const CHSEL: u32 = 7 << 25;
const CIRC: u32 = 1 << 8;
const MINC: u32 = 1 << 10;
const DIR: u32 = 3 << 6;
const SIZES: u32 = 0xf << 11;
const BRR: u32 = 0x4000_4408;
const USART_CR1: u32 = 0x4000_440c;
const USART_CR3: u32 = 0x4000_4414;
const IWDG_PR: u32 = 0x4000_3004;
const IWDG_RLR: u32 = 0x4000_3008;
const DBGMCU_APB1_FZ: u32 = 0xe004_2008;
const ISER: u32 = 0xe000_e100;
const IPR: u32 = 0xe000_e400;
const CPACR: u32 = 0xe000_ed88;

/// Those that some check must fail for.
#[rustfmt::skip]
const MUTANTS: &[Mutant] = &[
    ("PA0 not analogue", PORT_A + MODER, 3, 0),
    ("PA1 not analogue", PORT_A + MODER, 3 << 2, 0),
    ("PB0 not analogue", PORT_B + MODER, 3, 0),
    ("PA4 an output", PORT_A + MODER, 3 << 8, 1 << 8),
    ("PA2 an input", PORT_A + MODER, 3 << 4, 0),
    ("PA3 an input", PORT_A + MODER, 3 << 6, 0),
    ("PA2 in function 8", PORT_A + AFRL, 15 << 8, 8 << 8),
    ("PA3 in function 0", PORT_A + AFRL, 15 << 12, 0),
    ("PA8 an input", PORT_A + MODER, 3 << 16, 0),
    ("PA8 open drain", PORT_A + OTYPER, 1 << 8, 1 << 8),
    ("PC7 an input", PORT_C + MODER, 3 << 14, 0),
    ("PC7 in function 3", PORT_C + AFRL, 15 << 28, 3 << 28),
    ("PC13 an output", PORT_C + MODER, 3 << 26, 1 << 26),
    ("PB5 without its pull-up", PORT_B + PUPDR, 3 << 10, 0),
    ("PA9 without its pull-up", PORT_A + PUPDR, 3 << 18, 0),
    ("PB10 without its pull-up", PORT_B + PUPDR, 3 << 20, 0),
    ("GPIOA without a clock", AHB1ENR, 1, 0),
    ("GPIOB without a clock", AHB1ENR, 2, 0),
    ("GPIOC without a clock", AHB1ENR, 4, 0),
    ("DMA1 without a clock", AHB1ENR, 1 << 21, 0),
    ("DMA2 without a clock", AHB1ENR, 1 << 22, 0),
    ("TIM2 without a clock", APB1ENR, 1, 0),
    ("TIM3 without a clock", APB1ENR, 2, 0),
    ("TIM6 without a clock", APB1ENR, 1 << 4, 0),
    ("TIM7 without a clock", APB1ENR, 1 << 5, 0),
    ("USART2 without a clock", APB1ENR, 1 << 17, 0),
    ("PWR without a clock", APB1ENR, 1 << 28, 0),
    ("DAC without a clock", APB1ENR, 1 << 29, 0),
    ("ADC1 without a clock", APB2ENR, 1 << 8, 0),
    ("SYSCFG without a clock", APB2ENR, 1 << 14, 0),
    ("the over-drive switched with GPIOA clocked", AHB1ENR, 1, 1),
    ("TIM11 without a clock", APB2ENR, 1 << 18, 0),
    ("TIM11 at its pin", TIM11_OR, 3, 0),
    ("TIM11 captures each edge", TIM11 + TIM_CCMR1, 3 << 2, 0),
    ("HSE_RTC by 16", CFGR, 31 << 16, 16 << 16),
    ("HSE without bypass", RCC_CR, 1 << 18, 0),
    ("no clock security", RCC_CR, 1 << 19, 0),
    ("PLL from HSI", PLLCFGR, 1 << 22, 0),
    ("PLL's N 144", PLLCFGR, 0x1ff << 6, 144 << 6),
    ("PLL's P 4", PLLCFGR, 3 << 16, 1 << 16),
    ("AHB by 2", CFGR, 15 << 4, 8 << 4),
    ("APB1 by 2", CFGR, 7 << 10, 4 << 10),
    ("APB1 by 8", CFGR, 7 << 10, 6 << 10),
    ("APB2 by 1", CFGR, 7 << 13, 0),
    ("4 wait states", FLASH_ACR, 15, 4),
    ("scale 2", PWR_CR, 3 << 14, 2 << 14),
    ("scale 3", PWR_CR, 3 << 14, 1 << 14),
    ("no over-drive", PWR_CR, 1 << 16, 0),
    ("over-drive not switched", PWR_CR, 1 << 17, 0),
    ("no voltage detector", PWR_CR, 1 << 4, 0),
    ("voltage detector at its lowest level", PWR_CR, 7 << 5, 0),
    ("line 5 from port A", EXTICR2, 15 << 4, 0),
    ("line 5 masked", EXTI_IMR, 1 << 5, 0),
    ("line 5 without the rising edge", EXTI_RTSR, 1 << 5, 0),
    ("line 16 masked", EXTI_IMR, 1 << 16, 0),
    ("line 16 without the rising edge", EXTI_RTSR, 1 << 16, 0),
    ("TIM2 at 18 kHz", TIM2 + TIM_ARR, 0xffff, 4999),
    ("TIM2 without its trigger output", TIM2 + TIM_CR2, 7 << 4, 0),
    ("TIM2 without its DMA request", TIM2 + TIM_DIER, 1 << 8, 0),
    ("TIM2 off", TIM2 + TIM_CR1, 1, 0),
    ("TIM3 in PWM 2", TIM3 + TIM_CCMR1, 7 << 12, 7 << 12),
    ("TIM3 without its output", TIM3 + TIM_CCER, 1 << 4, 0),
    ("TIM3 off", TIM3 + TIM_CR1, 1, 0),
    ("TIM6 at half its rate", TIM6 + TIM_PSC, 0xffff, 3),
    ("TIM6 without its interrupt", TIM6 + TIM_DIER, 1, 0),
    ("TIM7 without its interrupt", TIM7 + TIM_DIER, 1, 0),
    ("TIM7 off", TIM7 + TIM_CR1, 1, 0),
    ("ADC off", ADC_CR2, 1, 0),
    ("ADC without scan", ADC_CR1, 1 << 8, 0),
    ("ADC of 10 bits", ADC_CR1, 3 << 24, 1 << 24),
    ("ADC aligned to the left", ADC_CR2, 1 << 11, 1 << 11),
    ("ADC continuous", ADC_CR2, 2, 2),
    ("ADC without DMA", ADC_CR2, 1 << 8, 0),
    ("ADC with DDS 0", ADC_CR2, 1 << 9, 0),
    ("ADC without a trigger's edge", ADC_CR2, 3 << 28, 0),
    ("ADC at another trigger", ADC_CR2, 15 << 24, 7 << 24),
    ("ADC at 45 MHz", ADC_CCR, 3 << 16, 0),
    ("ADC with two channels", ADC_SQR1, 15 << 20, 1 << 20),
    ("ADC with channel 0 twice", ADC_SQR3, 31 << 5, 0),
    ("ADC with hammer and cart exchanged", ADC_SQR3, 0x3ff << 5, 8 << 5 | 1 << 10),
    ("ADC with 480 cycles a channel", ADC_SMPR2, 7 | 7 << 3 | 7 << 24, 7 | 7 << 3 | 7 << 24),
    ("no TSVREFE", ADC_CCR, 1 << 23, 0),
    ("force sampled for 3 cycles", ADC_SMPR2, 7, 0),
    ("DAC without its buffer", DAC_CR, 2, 2),
    ("the reference sampled for 3 cycles", ADC_SMPR1, 7 << 21, 0),
    ("the reference sampled for 144 cycles", ADC_SMPR1, 7 << 21, 6 << 21),
    ("channel 16 as the reference", ADC_JSQR, 31 << 15, 16 << 15),
    ("DAC off", DAC_CR, 1, 0),
    ("DAC with a trigger", DAC_CR, 1 << 2, 1 << 2),
    ("samples: channel 1", SAMPLES, CHSEL, 1 << 25),
    ("samples: not circular", SAMPLES, CIRC, 0),
    ("samples: one place", SAMPLES, MINC, 0),
    ("samples: from memory", SAMPLES, DIR, 1 << 6),
    ("samples: bytes", SAMPLES, SIZES, 0),
    ("samples: words", SAMPLES, SIZES, 0xa << 11),
    ("samples: no interrupt at the half", SAMPLES, 1 << 3, 0),
    ("samples: no interrupt at the end", SAMPLES, 1 << 4, 0),
    ("samples: 30 of 60", SAMPLES + NDTR, 0xffff, 30),
    ("samples: 66 of 60", SAMPLES + NDTR, 0xffff, 66),
    ("samples: from the status", SAMPLES + PAR, 0xff, 0),
    ("samples: to the next half word", SAMPLES + M0AR, 3, 2),
    ("set-points: channel 7", CODES, CHSEL, 7 << 25),
    ("set-points: not circular", CODES, CIRC, 0),
    ("set-points: one place", CODES, MINC, 0),
    ("set-points: to memory", CODES, DIR, 0),
    ("set-points: bytes", CODES, SIZES, 0),
    ("set-points: 10 of 20", CODES + NDTR, 0xffff, 10),
    ("set-points: to the second output", CODES + PAR, 0xff, 0x14),
    ("link in: channel 3", LINK_IN, CHSEL, 3 << 25),
    ("link in: not circular", LINK_IN, CIRC, 0),
    ("link in: one place", LINK_IN, MINC, 0),
    ("link in: 512 of 1024", LINK_IN + NDTR, 0xffff, 512),
    ("link out: channel 3", LINK_OUT, CHSEL, 3 << 25),
    ("link out: circular", LINK_OUT, CIRC, CIRC),
    ("link out: one place", LINK_OUT, MINC, 0),
    ("link out: to memory", LINK_OUT, DIR, 0),
    ("USART2 at half its rate", BRR, 0xffff, 40),
    ("USART2 5 % too fast", BRR, 0xffff, 19),
    ("USART2 oversampled by 8", USART_CR1, 1 << 15, 1 << 15),
    ("USART2 with 9 bits", USART_CR1, 1 << 12, 1 << 12),
    ("USART2 does not send", USART_CR1, 1 << 3, 0),
    ("USART2 does not receive", USART_CR1, 1 << 2, 0),
    ("USART2 off", USART_CR1, 1 << 13, 0),
    ("USART2 without DMA in", USART_CR3, 1 << 6, 0),
    ("USART2 without DMA out", USART_CR3, 1 << 7, 0),
    ("watchdog of 32 s", IWDG_PR, 7, 6),
    ("watchdog of 0.5 s", IWDG_RLR, 0xfff, 999),
    ("watchdog of 31 ms", IWDG_RLR, 0xfff, 62),
    ("watchdog stands with the processor", DBGMCU_APB1_FZ, 1 << 12, 1 << 12),
    ("set-points go on without the processor", DBGMCU_APB1_FZ, 1, 0),
    ("EXTI9_5 off", ISER, 1 << 23, 0),
    ("PVD off", ISER, 1 << 1, 0),
    ("DMA2_STREAM0 off", ISER + 4, 1 << 24, 0),
    ("TIM7's interrupt off", ISER + 4, 1 << 23, 0),
    ("TIM6's interrupt off", ISER + 4, 1 << 22, 0),
    ("TIM7 below the control task", IPR + 52, 0xff << 24, 0xe0 << 24),
    ("EXTI9_5 below the control task", IPR + 20, 0xff << 24, 0xe0 << 24),
    ("PVD below the control task", IPR, 0xff << 8, 0xe0 << 8),
    ("APB2 by 4", CFGR, 7 << 13, 5 << 13),
    ("no floating point", CPACR, 15 << 20, 0),
];

/// Those that pass, each with why it may.
#[rustfmt::skip]
const HARMLESS: &[(Mutant, &str)] = &[
    (("PA5 an input", PORT_A + MODER, 3 << 10, 0), "it is the LED alone"),
    (("PA10 without its pull-up", PORT_A + PUPDR, 3 << 20, 0), "bench mode is refused where sensors are wired"),
    (("ADC at 11.25 MHz", ADC_CCR, 3 << 16, 3 << 16), "a scan takes 18 of the 50 µs that there are"),
    (("no prefetch", FLASH_ACR, 1 << 8, 0), "slower, and the deadline holds with nothing but misses"),
    (("no instruction cache", FLASH_ACR, 1 << 9, 0), "slower, and the deadline holds with nothing but misses"),
    (("no data cache", FLASH_ACR, 1 << 10, 0), "slower, and the deadline holds with nothing but misses"),
    (("samples: lowest priority", SAMPLES, 3 << 16, 0), "transfers take no time on the bus here"),
    (("samples: no interrupt at an error", SAMPLES, 1 << 2, 0), "then no samples come, which the block monitor finds"),
    (("set-points: lowest priority", CODES, 3 << 16, 0), "transfers take no time on the bus here"),
];

/// The ten that are part of the ordinary checks.
const SAMPLE: [&str; 10] = [
    "PA0 not analogue",
    "PA3 in function 0",
    "ADC with DDS 0",
    "TIM2 without a clock",
    "scale 3",
    "the over-drive switched with GPIOA clocked",
    "no TSVREFE",
    "samples: not circular",
    "set-points: channel 7",
    "PVD off",
];

/// What a mutant is run through, until one fails.
const SESSION: [&str; 14] = [
    "cold boot",
    "closed loop",
    "the emergency chain opens",
    "the supply sags",
    "the clock dies",
    "the processor is halted",
    "the program hangs",
    "the control task is starved",
    "boot without the crystal's clock",
    "a save on the slowest flash",
    "reports that agree",
    "a report that contradicts",
    "the measuring reference is off",
    "boot with the button held",
];

/// Rig time of the closed loop, s.
const SECONDS: f64 = 2.0;

fn patch((_, register, mask, value): Mutant) -> Patch {
    Patch {
        register,
        mask,
        value,
    }
}

/// The check that finds a mutant, and the first line of what it says; `None`: it passes.
fn caught(image: Rc<Image>, mutant: Mutant) -> Option<(&'static str, String)> {
    let setup = Setup::patched(image, patch(mutant), SECONDS);
    let checks = SESSION
        .iter()
        .filter_map(|name| ALL.iter().find(|(own, _)| own == name));
    first_failure(&setup, checks)
}

fn first_failure<'a>(
    setup: &Setup,
    mut checks: impl Iterator<Item = &'a Check>,
) -> Option<(&'static str, String)> {
    checks.find_map(|(name, check)| {
        let error = check(setup).err()?.to_string();
        Some((*name, error.lines().next().unwrap_or_default().to_owned()))
    })
}

/// Ten mutants, each of which must be caught.
pub fn sample(setup: &Setup) -> Found {
    let mut by = Vec::new();
    for name in SAMPLE {
        let mutant = MUTANTS.iter().find(|(own, ..)| *own == name);
        let mutant = *mutant.ok_or("no such mutant")?;
        let (check, _) = caught(setup.image()?, mutant).ok_or_else(|| format!("{name}: passes"))?;
        by.push(check);
    }
    by.sort_unstable();
    by.dedup();
    let text = format!("all {} caught, by `{}`", SAMPLE.len(), by.join("`, `"));
    Ok((text, 0))
}

/// Every mutant, or those with `wanted` in their name; says how many pass that should not.
pub fn run(setup: &Setup, wanted: &str) -> Result<usize, String> {
    // The image itself passes, or nothing follows from a failure.
    let whole = Setup::patched(setup.image()?, Patch::NONE, SECONDS);
    let checks = SESSION
        .iter()
        .filter_map(|name| ALL.iter().find(|(own, _)| own == name));
    if let Some((check, why)) = first_failure(&whole, checks) {
        return Err(format!("the image itself fails in {check}: {why}"));
    }
    let harmless = HARMLESS
        .iter()
        .map(|(mutant, because)| (*mutant, Some(*because)));
    let all: Vec<_> = MUTANTS
        .iter()
        .map(|mutant| (*mutant, None))
        .chain(harmless)
        .filter(|((name, ..), _)| name.contains(wanted))
        .collect();
    let (next, passed) = (AtomicUsize::new(0), AtomicUsize::new(0));
    let progress = ProgressLine::new("mutants", all.len() as u64, false);
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let elf = setup.elf.as_path();
    let work = || -> Result<(), String> {
        let image = Rc::new(Image::read(elf)?);
        loop {
            let i = next.fetch_add(1, Ordering::Relaxed);
            let Some((mutant, because)) = all.get(i) else {
                return Ok(());
            };
            let line = match (caught(image.clone(), *mutant), because) {
                (Some((check, why)), None) => format!("caught  {}: {check}: {why}", mutant.0),
                (Some((check, why)), Some(_)) => {
                    format!(
                        "caught, though listed as harmless  {}: {check}: {why}",
                        mutant.0
                    )
                }
                (None, Some(because)) => {
                    format!("passed  {}: harmless, because {because}", mutant.0)
                }
                (None, None) => {
                    passed.fetch_add(1, Ordering::Relaxed);
                    format!("PASSED  {}", mutant.0)
                }
            };
            println!("{line}");
            progress.inc(1);
        }
    };
    let done: Result<(), String> = std::thread::scope(|scope| {
        let threads: Vec<_> = (0..threads)
            .map(|_| std::thread::Builder::new().spawn_scoped(scope, work))
            .collect();
        threads.into_iter().try_for_each(|thread| {
            let thread = thread.map_err(|e| e.to_string())?;
            thread.join().map_err(|_| "a thread has panicked")?
        })
    });
    progress.finish();
    done?;
    let passed = passed.into_inner();
    println!(
        "{} mutants, {} of them listed as harmless; {passed} passed that should be caught",
        all.len(),
        all.iter().filter(|(_, because)| because.is_some()).count()
    );
    Ok(passed)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_used_once_and_the_lists_name_what_is_there() {
        let harmless = HARMLESS.iter().map(|(mutant, _)| mutant.0);
        let mut names: Vec<_> = MUTANTS.iter().map(|m| m.0).chain(harmless).collect();
        assert!(SAMPLE.iter().all(|name| names.contains(name)));
        let count = names.len();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), count);
        for name in SESSION {
            assert!(ALL.iter().any(|(own, _)| *own == name), "{name}");
        }
        for (name, register, mask, value) in MUTANTS {
            assert!(register % 4 == 0 && value & !mask == 0, "{name}");
        }
    }
}
