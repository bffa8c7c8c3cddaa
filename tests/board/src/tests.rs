//! Tiny programs in the machine: exceptions, each rule that ends a run, and waiting that is passed over.

use crate::core::nvic::FIRST;
use crate::image::Image;
use crate::machine::{Change, Machine};
use crate::memory::{FLASH, RAM};
use crate::parts::UNITS_PER_US;
use crate::rig::wired;
use crate::stop::Stop;

/// Where the code of a program begins.
const CODE: u32 = FLASH + 0x200;
/// Its stack.
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

/// The same with every instruction executed, and with waiting passed over; how many instructions were.
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
