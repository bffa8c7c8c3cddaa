//! Tiny programs in the machine: exceptions, each rule that ends a run, set-ups that must not work, and waiting that is
//! passed over.

use crate::core::nvic::FIRST;
use crate::image::Image;
use crate::machine::{Change, Machine};
use crate::memory::{FLASH, RAM};
use crate::parts::UNITS_PER_US;
use crate::parts::rcc::External;
use crate::rig::wired;
use crate::stop::Stop;

/// Where the code of a program begins.
const CODE: u32 = FLASH + 0x200;
/// Where the stack of a program begins.
const STACK: u32 = RAM + 0x1000;
/// `b .`, `bx lr`, `nop`.
const HANG: u16 = 0xe7fe;
const RETURN: u16 = 0x4770;
const NOP: u16 = 0xbf00;

fn machine(vectors: &[(usize, u32)], code: &[u16]) -> Machine {
    let image = Image::of_code(STACK, vectors, code);
    Machine::power_up(image.into(), wired(), 1)
}

fn run(machine: &mut Machine, us: u64) -> Result<(), Stop> {
    let end = machine.now + us * UNITS_PER_US;
    while machine.now < end {
        machine.run_until(end)?;
    }
    Ok(())
}

/// `ldr r0, =address; ldr r1, =value; str r1, [r0]; b .`
fn store(address: u32, value: u32) -> Vec<u16> {
    let [a, v] = [address, value].map(|word| [word as u16, (word >> 16) as u16]);
    vec![0x4801, 0x4902, 0x6001, HANG, a[0], a[1], v[0], v[1]]
}

/// What ends the run of a store.
fn stops(address: u32, value: u32) -> String {
    let mut machine = machine(&[], &store(address, value));
    let stop = run(&mut machine, 20).expect_err("the store is allowed");
    assert_eq!(stop.address, CODE + 4, "{stop}");
    stop.why
}

#[test]
fn every_rule_ends_the_run_with_the_instruction() {
    assert!(stops(0x4002_0000, 0).contains("has no clock"), "GPIOA");
    assert!(
        stops(0x4001_0000, 0).contains("no peripheral is modelled"),
        "TIM1"
    );
    assert!(stops(0x4002_3878, 0).contains("is not modelled"), "RCC");
    assert!(
        stops(0x4002_3830, 1 << 31).contains("reserved bits"),
        "AHB1ENR"
    );
    assert!(stops(0x4002_3808, 2).contains("not ready"), "PLL as clock");
    assert!(stops(0x4002_3c10, 1).contains("locked"), "FLASH_CR");
    assert!(stops(0x4000_3004, 1).contains("0x5555"), "IWDG_PR");
    assert!(stops(0xe000_ed90, 0).contains("not modelled"), "MPU");
}

#[test]
fn ram_that_was_never_written_is_not_read() {
    // ldr r0, [sp, #-…]: `ldr r0, =RAM; ldr r1, [r0]`.
    let mut code = store(RAM + 0x40, 0);
    code[1] = 0x6801;
    let mut machine = machine(&[], &code);
    let stop = run(&mut machine, 20).expect_err("random RAM was read");
    assert!(stop.why.contains("never written"), "{stop}");
    assert_eq!(stop.address, CODE + 2);
}

/// A program that hangs in a loop of `nop`, with handlers for exceptions 14 (PendSV) and the first interrupts.
fn with_handlers(handlers: &[(usize, &[u16])]) -> Machine {
    let mut code = vec![NOP, NOP, 0xe7fc];
    let mut vectors = Vec::new();
    for (number, handler) in handlers {
        while code.len() % 2 != 0 {
            code.push(NOP);
        }
        vectors.push((*number, CODE + 2 * code.len() as u32));
        code.extend_from_slice(handler);
    }
    machine(&vectors, &code)
}

#[test]
fn a_handler_gets_a_frame_and_gives_everything_back() {
    // movs r0, #7; movs r1, #8; cmp r0, #7; bx lr
    let mut machine = with_handlers(&[(FIRST, &[0x2007, 0x2108, 0x2807, RETURN])]);
    machine.nvic.enabled[FIRST] = true;
    machine.cpu.r[0] = 0x1234_5678;
    machine.cpu.n = true;
    run(&mut machine, 5).unwrap();
    machine.nvic.pend(FIRST);
    machine.attend();
    run(&mut machine, 5).unwrap();
    assert_eq!(machine.entered[FIRST], 1);
    assert_eq!((machine.cpu.r[0], machine.cpu.r[13]), (0x1234_5678, STACK));
    assert!(machine.cpu.n && !machine.cpu.z && machine.cpu.ipsr == 0);
    assert_eq!(machine.lowest_stack, STACK - 0x20);
}

#[test]
fn a_more_urgent_one_nests_and_an_equal_one_follows_without_a_frame() {
    let hang = [NOP, NOP, 0xe7fc];
    let mut machine = with_handlers(&[
        (FIRST, &hang),
        (FIRST + 1, &[RETURN, NOP]),
        (FIRST + 2, &[RETURN, NOP]),
    ]);
    for i in 0..3 {
        machine.nvic.enabled[FIRST + i] = true;
    }
    machine.nvic.priority[FIRST] = 0x40;
    machine.nvic.priority[FIRST + 1] = 0x20;
    machine.nvic.priority[FIRST + 2] = 0x40;
    let pend = |machine: &mut Machine, i: usize| {
        machine.nvic.pend(FIRST + i);
        machine.attend();
        run(machine, 5).unwrap();
    };
    pend(&mut machine, 0);
    pend(&mut machine, 2);
    assert_eq!(machine.entered[FIRST + 2], 0, "equal priority must wait");
    pend(&mut machine, 1);
    assert_eq!(machine.entered[FIRST + 1], 1);
    assert_eq!(machine.lowest_stack, STACK - 0x40, "two frames");
    // BASEPRI holds everything from its level on.
    machine.cpu.basepri = 0x20;
    pend(&mut machine, 1);
    assert_eq!(machine.entered[FIRST + 1], 1);
}

#[test]
fn a_call_that_may_not_be_taken_is_a_hard_fault_behind_it() {
    // svc #0, masked by PRIMASK; b .; the handler
    let code = [0xdf00, HANG, RETURN, NOP];
    let mut machine = machine(&[(3, CODE + 4), (11, CODE)], &code);
    machine.cpu.primask = true;
    run(&mut machine, 1).unwrap();
    assert_eq!((machine.entered[3], machine.entered[11]), (1, 0));
    assert_eq!(machine.system.hard_status, 1 << 30, "FORCED");
}

#[test]
fn floating_point_is_stacked_only_where_a_handler_uses_it() {
    // vadd.f32 s0, s0, s0; bx lr
    let uses: &[u16] = &[0xee30, 0x0a00, RETURN, NOP];
    let mut machine = with_handlers(&[(FIRST, uses), (FIRST + 1, &[RETURN, NOP])]);
    machine.enable_float();
    machine.nvic.enabled[FIRST] = true;
    machine.nvic.enabled[FIRST + 1] = true;
    machine.cpu.control = 4;
    machine.cpu.s[0] = 1.5f32.to_bits();
    let room = STACK - 0x68 + 0x20;
    machine.ram[(room - RAM) as usize..][..4].fill(0xee);
    for (i, stored) in [(1, 0xeeee_eeee), (0, 1.5f32.to_bits())] {
        machine.nvic.pend(FIRST + i);
        machine.attend();
        run(&mut machine, 10).unwrap();
        let word = &machine.ram[(room - RAM) as usize..][..4];
        assert_eq!(word, u32::to_le_bytes(stored));
        assert_eq!(
            (machine.cpu.s[0], machine.cpu.control),
            (1.5f32.to_bits(), 4)
        );
    }
    assert_eq!(machine.lowest_stack, STACK - 0x68);
}

#[test]
fn a_fault_is_a_hard_fault_and_a_second_one_locks_up() {
    // ldr r1, [r0] at an address where nothing is; the HardFault's handler does the same.
    let mut code = store(0x6000_0000, 0);
    code[2] = 0x6801;
    code.extend_from_slice(&[0x6801, HANG]);
    let mut machine = machine(&[(3, CODE + 16)], &code);
    run(&mut machine, 50).unwrap();
    assert_eq!(machine.entered[3], 1);
    assert_eq!(machine.system.fault_status & 0x8200, 0x8200);
    assert_eq!(machine.system.bus_address, 0x6000_0000);
    assert!(
        machine
            .changes
            .iter()
            .any(|(_, change)| *change == Change::LockUp)
    );
}

#[test]
fn a_stack_that_leaves_ram_ends_in_the_hard_fault() {
    let mut machine = with_handlers(&[(3, &[HANG, NOP]), (FIRST, &[RETURN, NOP])]);
    machine.nvic.enabled[FIRST] = true;
    run(&mut machine, 5).unwrap();
    machine.cpu.r[13] = RAM + 8;
    machine.nvic.pend(FIRST);
    machine.attend();
    run(&mut machine, 5).unwrap();
    assert_eq!(machine.entered[3], 1);
    assert!(machine.system.fault_status & 1 << 12 != 0, "STKERR");
}

#[test]
fn a_hard_fault_without_room_for_its_frame_runs_all_the_same() {
    let mut machine = with_handlers(&[(3, &[HANG, NOP])]);
    run(&mut machine, 5).unwrap();
    machine.cpu.r[13] = RAM + 8;
    machine.cpu.pc = 0x0900_0000;
    run(&mut machine, 5).unwrap();
    assert_eq!(machine.entered[3], 1);
    assert!(machine.system.fault_status & 1 << 12 != 0, "STKERR");
    assert!(!machine.is_halted(), "locked up");
}

/// A program that writes 0 to the first words of RAM, and then goes round in `round`, in which r2 is RAM's address and r3 is
/// 0; TIM6 interrupts it every 10 µs, and its handler counts in the second word.
fn going_round(round: &[u16]) -> Machine {
    // ldr r2, =RAM; movs r3, #0; str r3, [r2]; str r3, [r2, #4]; the round; b round
    let mut code = vec![0x4a00, 0x2300, 0x6013, 0x6053];
    code.extend_from_slice(round);
    code.push(0xe000 | 0x7ff & (-(round.len() as i16) - 2) as u16);
    if code.len() % 2 != 0 {
        code.push(NOP);
    }
    // The first constant: as many words on as there are after the first instruction's.
    code[0] |= (code.len() / 2 - 1) as u16;
    code.extend([RAM as u16, (RAM >> 16) as u16]);
    let handler = CODE + 2 * code.len() as u32;
    // ldr r0, =TIM6_SR; movs r1, #0; str r1, [r0]; ldr r0, =RAM; ldr r1, [r0, #4]; adds r1, #1; str r1, [r0, #4]; bx lr
    code.extend([
        0x4803, 0x2100, 0x6001, 0x4803, 0x6841, 0x3101, 0x6041, RETURN,
    ]);
    code.extend([0x1010, 0x4000, RAM as u16, (RAM >> 16) as u16]);
    let number = FIRST + crate::parts::interrupt::TIM6;
    let mut machine = machine(&[(number, handler)], &code);
    machine.nvic.enabled[number] = true;
    for (register, value) in [
        (0x4002_3840, 1 << 4),
        (0x4000_102c, 159),
        (0x4000_100c, 1),
        (0x4000_1000, 1),
    ] {
        machine.poke(register, value).unwrap();
    }
    machine
}

/// How many instructions are not executed where waiting is passed over; all else must be as if they were.
fn passed_over(round: &[u16]) -> u64 {
    let [executed, passed] = [false, true].map(|skips| {
        let mut machine = going_round(round);
        machine.skips = skips;
        machine.start_profile();
        // Ends at odd times, too.
        for us in [3, 100, 7, 211, 1] {
            run(&mut machine, us).unwrap();
        }
        let mut fingerprint = crate::fingerprint::Fingerprint::default();
        fingerprint.add_machine(&machine);
        (
            fingerprint,
            format!("{:?}", machine.profile),
            machine.passed,
        )
    });
    assert_eq!((executed.0, &executed.1), (passed.0, &passed.1));
    assert_eq!(executed.2, 0);
    passed.2
}

#[test]
fn waiting_is_passed_over_and_changes_nothing() {
    // A word is counted up, another read.
    // ldr r0, [r2]; adds r0, #1; str r0, [r2]; ldr r1, [r2, #4]; movs r0, #0; cmp r3, #1
    let counting = [0x6810, 0x3001, 0x6010, 0x6851, 0x2000, 0x2b01];
    assert!(passed_over(&counting) > 1_000);
    // Nothing at all.
    assert!(passed_over(&[NOP]) > 1_000);
}

#[test]
fn what_depends_on_its_own_count_is_executed() {
    // ldr r0, [r2]; adds r0, #1; str r0, [r2]; lsrs r0, r0, #6; strb r0, [r2, #8]; movs r0, #0; cmp r3, #1
    assert_eq!(
        passed_over(&[0x6810, 0x3001, 0x6010, 0x0980, 0x7210, 0x2000, 0x2b01]),
        0
    );
    // ldr r0, [r2]; adds r0, #1; str r0, [r2]; it ne; movne r3, #0; movs r0, #0; cmp r3, #1
    assert_eq!(
        passed_over(&[0x6810, 0x3001, 0x6010, 0xbf18, 0x2300, 0x2000, 0x2b01]),
        0
    );
    // A register is counted up: adds r4, #1
    assert_eq!(passed_over(&[0x3401]), 0);
    // A peripheral is read, through r5 = 0x40000000 + 0x1000 (TIM6): movs r5, #4; lsls r5, #28; movs r4, #1; lsls r4, #12;
    // adds r5, r5, r4; ldr r4, [r5]
    assert_eq!(
        passed_over(&[0x2504, 0x072d, 0x2401, 0x0324, 0x192d, 0x682c]),
        0
    );
}

/// Registers, written from outside into a program that does nothing.
fn set(machine: &mut Machine, registers: &[(u32, u32)]) -> Result<(), Stop> {
    registers
        .iter()
        .try_for_each(|(address, value)| machine.poke(*address, *value))
}

/// The last of these writes must be refused.
fn refused(registers: &[(u32, u32)]) -> String {
    let mut machine = with_handlers(&[]);
    let (last, before) = registers.split_last().unwrap();
    set(&mut machine, before).unwrap();
    machine.poke(last.0, last.1).unwrap_err().why
}

const AHB1ENR: u32 = 0x4002_3830;
const APB1ENR: u32 = 0x4002_3840;
const APB2ENR: u32 = 0x4002_3844;
const APB1RSTR: u32 = 0x4002_3820;
const PORT_A: u32 = 0x4002_0000;
const ADC_CR2: u32 = 0x4001_2008;
const DMA: u32 = 1 << 8;
const DDS: u32 = 1 << 9;

#[test]
fn a_part_at_work_wants_its_pins_and_keeps_them() {
    let clocks = [
        (AHB1ENR, 1),
        (APB1ENR, 1 << 17 | 1 << 29),
        (APB2ENR, 1 << 8),
    ];
    let after = |registers: &[(u32, u32)]| refused(&[&clocks, registers].concat());
    // As after the reset: PA0, PA4, PA2 and PA3 are inputs.
    assert!(after(&[(ADC_CR2, 1), (ADC_CR2, 1 | 1 << 30)]).contains("PA0 is not analogue"));
    assert!(after(&[(0x4000_7400, 1)]).contains("PA4 is not analogue"));
    assert!(after(&[(0x4000_440c, 1 << 13 | 1 << 3)]).contains("PA2"));
    assert!(after(&[(0x4000_440c, 1 << 13 | 1 << 2)]).contains("PA3"));
    // Another function, and one that is taken away again.
    let other = [(PORT_A, 0xa800_0020), (PORT_A + 0x20, 0x100)];
    assert!(after(&[&other[..], &[(0x4000_440c, 1 << 13 | 1 << 3)]].concat()).contains("PA2"));
    let away = [
        (PORT_A, 0xa800_0300),
        (0x4000_7400, 1),
        (PORT_A, 0xa800_0100),
    ];
    assert!(after(&away).contains("PA4"));
}

/// Where the samples go, and where the codes come from.
const SAMPLES: u32 = RAM + 0x2000;
const CODES: u32 = RAM + 0x2010;

/// TIM2 at 20 kHz on HSI: PA0 by ADC1 and DMA2 into a ring of two samples, a ring of two codes by DMA1 to PA4.
fn sampling(cr2: u32) -> Machine {
    let mut machine = with_handlers(&[]);
    machine.know(CODES, 4);
    machine.ram[(CODES - RAM) as usize..][..4].copy_from_slice(&[1, 0, 2, 0]);
    let ring = 1 << 8 | 1 << 10 | 1 << 11 | 1 << 13;
    let registers = [
        (AHB1ENR, 1 | 3 << 21),
        (APB1ENR, 1 | 1 << 29),
        (APB2ENR, 1 << 8),
        (PORT_A, 0xa800_0303),
        (ADC_CR2, 1 | DMA | cr2 | 6 << 24 | 1 << 28),
        (0x4002_6414, 2),
        (0x4002_6418, 0x4001_204c),
        (0x4002_641c, SAMPLES),
        (0x4002_6410, ring | 1),
        (0x4000_7400, 1),
        (0x4002_602c, 2),
        (0x4002_6030, 0x4000_7408),
        (0x4002_6034, CODES),
        (0x4002_6028, ring | 3 << 25 | 1 << 6 | 1),
        (0x4000_002c, 799),
        (0x4000_0004, 2 << 4),
        (0x4000_000c, 1 << 8),
        (0x4000_0000, 1),
    ];
    set(&mut machine, &registers).unwrap();
    machine
}

/// Whether triggers, samples and codes still come.
fn goes_on(machine: &mut Machine) -> [bool; 3] {
    let sample = |machine: &Machine| machine.ram[(SAMPLES - RAM) as usize];
    machine.codes[0] = u16::from(sample(machine)) + 1;
    let (ticks, before) = (machine.ticks, sample(machine));
    let changes = machine.changes.len();
    run(machine, 200).unwrap();
    [
        machine.ticks > ticks,
        sample(machine) != before,
        machine.changes.len() > changes,
    ]
}

#[test]
fn without_dds_the_samples_stop_after_the_first_ring() {
    for (cr2, expected) in [(DDS, true), (0, false)] {
        let mut machine = sampling(cr2);
        run(&mut machine, 80).unwrap();
        assert!(goes_on(&mut machine)[0], "the first ring");
        assert_eq!(goes_on(&mut machine), [true, expected, true]);
    }
}

#[test]
fn a_part_without_a_clock_or_in_reset_stands() {
    let apb1 = 1 | 1 << 29;
    for (register, value, expected) in [
        (AHB1ENR, 1 | 3 << 21, [true; 3]),
        (APB1ENR, 1 << 29, [false; 3]),
        (APB1RSTR, 1, [false; 3]),
        (APB2ENR, 0, [false, false, true]),
        (AHB1ENR, 1 | 1 << 22, [true, true, false]),
        // An overrun: the ADC takes no more triggers.
        (AHB1ENR, 1 | 1 << 21, [false, false, true]),
    ] {
        let mut machine = sampling(DDS);
        run(&mut machine, 500).unwrap();
        assert_eq!(goes_on(&mut machine), [true; 3]);
        set(&mut machine, &[(register, value)]).unwrap();
        run(&mut machine, 100).unwrap();
        assert_eq!(goes_on(&mut machine), expected, "{register:#x}");
    }
    // The DMA's write to a DAC without a clock goes nowhere.
    let mut machine = sampling(DDS);
    set(&mut machine, &[(APB1ENR, apb1 & 1)]).unwrap();
    let stop = run(&mut machine, 200).unwrap_err();
    assert!(
        stop.why.contains("Dac at 0x40007408 has no clock"),
        "{stop}"
    );
}

/// To 180 MHz from HSI, with the regulator at this scale, and over-drive or not.
fn faster(scale: u32, over_drive: bool, ports: u32) -> (Machine, Result<(), Stop>) {
    let mut machine = with_handlers(&[]);
    let power = scale << 14;
    let mut steps = vec![
        (0x4002_3c00, 5),
        (AHB1ENR, ports),
        (APB1ENR, 1 << 28),
        (0x4000_7000, power),
        (0x4002_3804, 0x2200_0000 | 180 << 6 | 8),
        (0x4002_3800, 1 << 24 | 0x81),
    ];
    if over_drive {
        steps.push((0x4000_7000, power | 1 << 16));
        steps.push((0x4000_7000, power | 3 << 16));
    }
    steps.push((0x4002_3808, 4 << 13 | 5 << 10 | 2));
    let done = steps.iter().try_for_each(|step| {
        set(&mut machine, &[*step])?;
        run(&mut machine, 200)
    });
    (machine, done)
}

#[test]
fn the_fastest_clock_wants_scale_1_and_over_drive_and_keeps_them() {
    let (mut machine, done) = faster(3, true, 0);
    done.unwrap();
    for without in [1 << 14 | 3 << 16, 3 << 14 | 1 << 16, 3 << 14] {
        let mut machine = machine.clone();
        machine.poke(0x4000_7000, without).unwrap_err();
    }
    // PWR in reset is as after a reset.
    machine.poke(APB1RSTR, 1 << 28).unwrap_err();
    for (scale, over_drive) in [(3, false), (2, true), (1, true)] {
        let why = faster(scale, over_drive, 0).1.unwrap_err().why;
        assert!(why.contains("scale and over-drive"), "{why}");
    }
}

const RCC_CR: u32 = 0x4002_3800;
/// HSI and HSE on, the latter bypassed; its and the PLL's flag.
const BOTH_ON: u32 = 5 << 16 | 0x81;
const HSERDY: u32 = 1 << 17;
const PLLRDY: u32 = 1 << 25;

#[test]
fn a_clock_that_pauses_is_noticed_if_the_pause_is_long_and_it_is_watched() {
    for (watched, us, acts) in [(1 << 19, 1, false), (1 << 19, 3, true), (0, 50, false)] {
        let mut machine = with_handlers(&[(2, &[HANG, NOP])]);
        machine.poke(RCC_CR, BOTH_ON).unwrap();
        run(&mut machine, 50).unwrap();
        machine.poke(RCC_CR, BOTH_ON | watched).unwrap();
        machine.set_hse(External::Missing).unwrap();
        run(&mut machine, us).unwrap();
        assert_eq!(machine.entered[2] == 1, acts);
        machine.set_hse(External::RUNNING).unwrap();
        run(&mut machine, 50).unwrap();
        assert_eq!(machine.entered[2] == 1, acts);
        assert_eq!(machine.peek(RCC_CR).unwrap() & HSERDY == 0, acts);
    }
}

#[test]
fn a_dead_clock_seems_ready_and_the_pll_does_not_lock_on_it() {
    let mut machine = with_handlers(&[]);
    machine.poke(RCC_CR, BOTH_ON).unwrap();
    run(&mut machine, 50).unwrap();
    machine.set_hse(External::Missing).unwrap();
    set(
        &mut machine,
        &[
            (0x4002_3804, 0x2240_0000 | 180 << 6 | 4),
            (RCC_CR, BOTH_ON | 1 << 24),
        ],
    )
    .unwrap();
    run(&mut machine, 400).unwrap();
    assert_eq!(machine.peek(RCC_CR).unwrap() & (HSERDY | PLLRDY), HSERDY);
    // It comes back, and goes again: what has locked seems to stay so.
    machine.set_hse(External::RUNNING).unwrap();
    run(&mut machine, 400).unwrap();
    machine.set_hse(External::Missing).unwrap();
    assert_eq!(machine.peek(RCC_CR).unwrap() & PLLRDY, PLLRDY);
}

#[test]
fn the_over_drive_is_not_switched_with_peripherals_clocked() {
    let why = faster(3, true, 1).1.unwrap_err().why;
    assert!(why.contains("a peripheral has a clock"), "{why}");
    // Nor is a peripheral's clock switched on meanwhile.
    let mut machine = with_handlers(&[]);
    set(
        &mut machine,
        &[(APB1ENR, 1 << 28), (0x4000_7000, 3 << 14 | 1 << 16)],
    )
    .unwrap();
    run(&mut machine, 200).unwrap();
    machine.poke(0x4000_7000, 3 << 14 | 3 << 16).unwrap();
    let why = machine.poke(AHB1ENR, 1).unwrap_err().why;
    assert!(why.contains("a peripheral has a clock"), "{why}");
}

#[test]
fn the_reference_wants_to_be_switched_on_and_time() {
    let reference = |ccr: u32, sampling: u32, wait_us: u64| {
        let mut machine = with_handlers(&[]);
        machine.codes[17] = 1500;
        let before = [
            (APB2ENR, 1 << 8),
            (0x4001_200c, sampling << 21),
            (0x4001_2038, 17 << 15),
            (ADC_CR2, 1),
        ];
        set(&mut machine, &before).unwrap();
        run(&mut machine, 100).unwrap();
        set(&mut machine, &[(0x4001_2304, ccr)]).unwrap();
        run(&mut machine, wait_us).unwrap();
        set(&mut machine, &[(ADC_CR2, 1 | 1 << 22)]).unwrap();
        run(&mut machine, 100).unwrap();
        machine.peek(0x4001_203c).unwrap() == 1500
    };
    // 480 cycles of 8 MHz are 60 µs, 56 are 7 µs.
    assert!(reference(1 << 23, 7, 12));
    assert!(!reference(0, 7, 12));
    assert!(!reference(1 << 23, 3, 12));
    assert!(!reference(1 << 23, 7, 5));
}

#[test]
fn what_does_not_exist_or_has_a_bit_in_brackets_set_is_refused() {
    use crate::core::{decode16, decode32, op::Kind};
    let wide = |a, b| decode32::decode(CODE, a, b).kind == Kind::Undefined;
    for (good, bad) in [
        // vldr d0 and d16; vmov d0[0], r0 and d16[0].
        ((0xed90, 0x0b00), (0xedd0, 0x0b00)),
        ((0xee00, 0x0b10), (0xee00, 0x0b90)),
        // vmov s0, r0; vmov.f32 s0, #2.0; vcmp.f32 s0, #0; vmrs r0, fpscr
        ((0xee00, 0x0a10), (0xee00, 0x0a11)),
        ((0xeeb0, 0x0a00), (0xeeb0, 0x0a20)),
        ((0xeeb5, 0x0a40), (0xeeb5, 0x0a41)),
        ((0xeef1, 0x0a10), (0xeef1, 0x0a30)),
        // mov.w r0, r1; ldm.w r0, {r1, r2}; stmdb sp!, {r4, lr}; tbb [r0, r1]; ldrex r0, [r1]
        ((0xea4f, 0x0001), (0xea4f, 0x8001)),
        ((0xe890, 0x0006), (0xe890, 0x2006)),
        ((0xe92d, 0x4010), (0xe92d, 0x8010)),
        ((0xe8d0, 0xf001), (0xe8d0, 0x0001)),
        ((0xe851, 0x0f00), (0xe851, 0x0e00)),
        // ubfx r0, r1, #0, #8; msr basepri, r0; mrs r0, basepri; dsb; uxtb.w r0, r1; udiv r0, r1, r2
        ((0xf3c1, 0x0007), (0xf3c1, 0x0027)),
        ((0xf380, 0x8811), (0xf380, 0x8911)),
        ((0xf3ef, 0x8011), (0xf3ef, 0xa011)),
        ((0xf3bf, 0x8f4f), (0xf3bf, 0x8e4f)),
        ((0xfa5f, 0xf081), (0xfa5f, 0xf0c1)),
        ((0xfbb1, 0xf0f2), (0xfbb1, 0x00f2)),
    ] {
        assert!(!wide(good.0, good.1), "{good:04x?}");
        assert!(wide(bad.0, bad.1), "{bad:04x?}");
    }
    let narrow = |h| decode16::decode(CODE, h).kind == Kind::Undefined;
    assert!(!narrow(0x4770) && narrow(0x4771), "bx lr");
    assert!(!narrow(0xb672) && narrow(0xb676), "cpsid i");
}
