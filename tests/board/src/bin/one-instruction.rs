//! One instruction at a time, for a comparison with another processor (oracle/compare.py).
//!
//! A line in, all in hexadecimal: two half words, r0 to r14, status, s0 to s31, FPSCR, an IT that goes before, or 0. A line out: `ok`, r0 to pc, status,
//! s0 to s31, FPSCR, and the bytes of RAM that changed as address=byte; or `fault` and which.

use std::io::{BufRead, Write};

use board::core::Trap;
use board::image::Image;
use board::machine::Machine;
use board::memory::{FLASH, RAM};
use board::rig::wired;

const AT: u32 = FLASH + 0x200;

/// The RAM's bytes before each instruction.
fn pattern(i: usize) -> u8 {
    (i * 37 + 11) as u8
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let image = Image::of_code(RAM + 0x1_0000, &[], &[0xbf00; 4]);
    let mut machine = Machine::power_up(image.into(), wired(), 1);
    machine.known.fill(1);
    machine.flash.fill(0);
    for (i, byte) in machine.ram.iter_mut().enumerate() {
        *byte = pattern(i);
    }
    machine.enable_float();
    let before = machine.ram.clone();
    let mut out = std::io::stdout().lock();
    for line in std::io::stdin().lock().lines() {
        let line = line?;
        let words = line.split(' ').map(|word| u32::from_str_radix(word, 16));
        let words: Vec<u32> = words.collect::<Result<_, _>>()?;
        let block = words[51] as u16;
        let code = [block, words[0] as u16, words[1] as u16, 0xbf00, 0xbf00];
        let code = if block == 0 { &code[1..] } else { &code[..] };
        machine.place_code(AT, code);
        machine.cpu.r[..15].copy_from_slice(&words[2..17]);
        machine.cpu.set_xpsr(words[17] & 0xf800_0000);
        machine.cpu.s.copy_from_slice(&words[18..50]);
        machine.cpu.fpscr = words[50];
        machine.cpu.control = 4;
        machine.cpu.sleeping = false;
        machine.cpu.pc = AT;
        machine.take_late_fault();
        let mut done = machine.one();
        if block != 0 && done.is_ok() {
            done = machine.one();
        }
        match done {
            Err(Trap::Fault(fault)) => writeln!(out, "fault {fault:?}")?,
            Err(Trap::Stop(why)) => writeln!(out, "stop {why}")?,
            Ok(()) if machine.take_late_fault() => writeln!(out, "fault late")?,
            Ok(()) => {
                write!(out, "ok")?;
                let cpu = &machine.cpu;
                let status = cpu.xpsr() & 0xf800_0000;
                let all = cpu.r[..15]
                    .iter()
                    .chain([&cpu.pc, &status])
                    .chain(&cpu.s)
                    .chain([&cpu.fpscr]);
                for word in all {
                    write!(out, " {word:x}")?;
                }
                for (i, (byte, was)) in machine.ram.iter().zip(before.iter()).enumerate() {
                    if byte != was {
                        write!(out, " {:x}={byte:x}", RAM as usize + i)?;
                    }
                }
                writeln!(out)?;
            }
        }
        machine.ram.copy_from_slice(&before[..]);
    }
    Ok(())
}
