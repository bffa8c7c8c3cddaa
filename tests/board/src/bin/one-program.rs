//! A program for a comparison with another processor (oracle/exceptions.py): `one-program IMAGE END`. It runs until it is at END,
//! hexadecimal; the log that it leaves in RAM goes to the standard output.

use std::io::Write;

use board::image::Image;
use board::machine::Machine;
use board::memory::RAM;
use board::parts::UNITS_PER_S;
use board::rig::wired;

/// Where the log begins; its end is in the first word of RAM.
const LOG: u32 = RAM + 0x4000;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let words: Vec<String> = std::env::args().collect();
    let [_, path, end] = &words[..] else {
        return Err("one-program IMAGE END".into());
    };
    let end = u32::from_str_radix(end, 16)?;
    let mut machine = Machine::power_up(Image::of_code(RAM, &[], &[]).into(), wired(), 1);
    let mut flash = std::fs::read(path)?;
    flash.resize(machine.flash.len(), 0xff);
    machine.set_flash(&flash);
    machine.known.fill(1);
    machine.ram.fill(0);
    while machine.cpu.pc != end {
        if machine.now > UNITS_PER_S || machine.is_halted() {
            return Err(format!("at {:#010x} after a second", machine.cpu.pc).into());
        }
        machine
            .run_until(machine.now + UNITS_PER_S / 1000)
            .map_err(|stop| stop.to_string())?;
    }
    let ends = u32::from_le_bytes([0, 1, 2, 3].map(|i| machine.ram[i]));
    let log = machine
        .ram
        .get((LOG - RAM) as usize..ends.wrapping_sub(RAM) as usize);
    std::io::stdout().write_all(log.ok_or("no log")?)?;
    Ok(())
}
