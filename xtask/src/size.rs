//! How much flash, RAM, stack and how many instructions the images take, against their budgets.

use object::{Object, ObjectSegment, ObjectSymbol, read::elf::ElfFile32};

use crate::{
    JobResult, boards,
    budgets::{BudgetLine, Budgets, enforce},
    command, firmware, qemu,
};

/// Every board has its RAM from here on.
pub const RAM_START: u64 = 0x2000_0000;

/// Bytes an image takes.
#[derive(Debug, Default, PartialEq)]
struct Size {
    /// Code, constants and the variables' first values.
    flash: u64,
    /// Variables, with and without a first value.
    ram: u64,
    /// Reserved for the stack.
    stack: u64,
}

/// Adds up what is loaded into flash and what occupies RAM.
fn measure(elf: &[u8]) -> JobResult<Size> {
    let file: ElfFile32 = ElfFile32::parse(elf)?;
    let mut size = Size::default();
    for segment in file.segments() {
        size.flash += segment.file_range().1;
        if segment.address() >= RAM_START {
            size.ram += segment.size();
        }
    }
    if let (Some(top), Some(bottom)) = (symbol(&file, "_stack_start"), symbol(&file, "_stack_end"))
    {
        size.stack = top.saturating_sub(bottom);
    }
    Ok(size)
}

/// Value of a symbol, an address as a rule; none if the image has no such symbol.
pub fn symbol(file: &ElfFile32, name: &str) -> Option<u64> {
    file.symbols()
        .find(|symbol| symbol.name() == Ok(name))
        .map(|symbol| symbol.address())
}

/// What the app says of itself under QEMU, in bench mode from the start to Hold.
#[derive(Debug, Default, PartialEq)]
struct Run {
    stack: u64,
    median: u64,
    worst: u64,
}

/// Reads the app's last lines.
fn parse(lines: &[String]) -> JobResult<Run> {
    let numbers = |head: &str| -> Option<Vec<u64>> {
        let line = lines.iter().find_map(|line| line.strip_prefix(head))?;
        let words = line.split(|c: char| !c.is_ascii_digit());
        words
            .filter(|w| !w.is_empty())
            .map(|w| w.parse().ok())
            .collect()
    };
    let stack = numbers("stack ").ok_or("the app told no stack")?;
    let instructions = numbers("instructions per tick").ok_or("the app told no instructions")?;
    match (&stack[..], &instructions[..]) {
        (&[stack, _], &[median, worst]) => Ok(Run {
            stack,
            median,
            worst,
        }),
        _ => Err("the app's last lines are not as they were".into()),
    }
}

/// Builds the images, runs the app, prints the table and holds it to the budgets.
pub fn run() -> JobResult {
    let budgets = Budgets::read()?;
    let mut lines = Vec::new();
    // The boards whose stack has what the variables leave.
    let mut left_for_stack = Vec::new();
    for board in &boards::all()? {
        for (name, image) in board.programs.iter().zip(firmware::build(board)?) {
            let size = measure(&std::fs::read(command::root().join(image))?)?;
            lines.push(budgets.line(name, "flash_bytes", size.flash)?);
            lines.push(budgets.line(name, "ram_bytes", size.ram)?);
            if board.flip_link {
                left_for_stack.push((name.clone(), size.stack));
            } else {
                lines.push(budgets.line(name, "stack_reserved_bytes", size.stack)?);
            }
        }
    }
    let run = parse(&qemu::run()?)?;
    lines.push(budgets.line("run", "stack_used_bytes", run.stack)?);
    // The same controller's peak must fit in there.
    lines.extend(left_for_stack.into_iter().map(|(of, budget)| BudgetLine {
        of,
        resource: "stack_of_what_is_left",
        measured: run.stack,
        budget,
    }));
    lines.push(budgets.line("run", "instructions_median", run.median)?);
    lines.push(budgets.line("run", "instructions_worst", run.worst)?);
    enforce(&lines)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A little ELF file: one segment in flash, one of variables whose first
    /// values lie in flash, one of zeros.
    fn image() -> Vec<u8> {
        let segments = [
            (0x0800_0000_u32, 40_u32, 40_u32),
            (0x2000_4000, 8, 8),
            (0x2000_4008, 0, 100),
        ];
        let header: [u16; 2] = [2, 40];
        let mut elf = b"\x7fELF\x01\x01\x01".to_vec();
        elf.resize(16, 0);
        header
            .iter()
            .for_each(|half| elf.extend(half.to_le_bytes()));
        [1_u32, 0x0800_0000, 52, 0, 0]
            .iter()
            .for_each(|word| elf.extend(word.to_le_bytes()));
        [52_u16, 32, segments.len() as u16, 40, 0, 0]
            .iter()
            .for_each(|half| elf.extend(half.to_le_bytes()));
        for (address, in_file, in_memory) in segments {
            let words = [1, 200, address, address, in_file, in_memory, 4, 4];
            words
                .iter()
                .for_each(|word: &u32| elf.extend(word.to_le_bytes()));
        }
        elf.resize(300, 0);
        elf
    }

    #[test]
    fn flash_and_ram_are_added_up() {
        assert_eq!(
            measure(&image()).unwrap(),
            Size {
                flash: 48,
                ram: 108,
                stack: 0
            }
        );
    }

    #[test]
    fn the_apps_own_account_is_read() {
        let lines = [
            "Hold at 3.683 Hz",
            "stack 20204 of 32768",
            "instructions per tick, each block's mean: median 700, worst 4100",
        ];
        let run = Run {
            stack: 20204,
            median: 700,
            worst: 4100,
        };
        assert_eq!(parse(&lines.map(String::from)).unwrap(), run);
        assert!(parse(&["stack 1 of 2".into()]).is_err());
    }

    #[test]
    fn what_is_no_image_is_an_error() {
        assert!(measure(b"not an image").is_err());
    }
}
