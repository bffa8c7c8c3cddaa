//! How much flash and RAM the images take.

use object::{Object, ObjectSegment, ObjectSymbol, read::elf::ElfFile32};

use crate::{
    Outcome, command,
    firmware::{self, Board},
};

/// Both boards have their RAM from here on.
const RAM_START: u64 = 0x2000_0000;

/// Bytes an image takes.
#[derive(Debug, Default, PartialEq)]
struct Size {
    /// Code, constants and the variables' first values.
    flash: u64,
    /// Variables.
    ram: u64,
    /// Reserved for the stack.
    stack: u64,
}

/// Adds up what is loaded into flash and what occupies RAM.
fn measure(elf: &[u8]) -> Outcome<Size> {
    let file: ElfFile32 = ElfFile32::parse(elf)?;
    let mut size = Size::default();
    for segment in file.segments() {
        size.flash += segment.file_range().1;
        if segment.address() >= RAM_START {
            size.ram += segment.size();
        }
    }
    let symbol = |name| {
        file.symbols()
            .find(|symbol| symbol.name() == Ok(name))
            .map(|symbol| symbol.address())
    };
    if let (Some(top), Some(bottom)) = (symbol("_stack_start"), symbol("_stack_end")) {
        size.stack = top.saturating_sub(bottom);
    }
    Ok(size)
}

/// Builds the images and prints the table.
pub fn run() -> Outcome {
    let mut rows = Vec::new();
    for board in Board::ALL {
        for image in firmware::build(board)? {
            let size = measure(&std::fs::read(command::root().join(&image))?)?;
            let name = image
                .file_name()
                .unwrap_or_default()
                .to_string_lossy()
                .into_owned();
            rows.push((board.name(), name, size));
        }
    }
    println!(
        "\n{:<8} {:<8} {:>9} {:>9} {:>9}",
        "board", "program", "flash", "variables", "stack"
    );
    for (board, program, size) in rows {
        println!(
            "{board:<8} {program:<8} {:>7} B {:>7} B {:>7} B",
            size.flash, size.ram, size.stack
        );
    }
    Ok(())
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
    fn what_is_no_image_is_an_error() {
        assert!(measure(b"not an image").is_err());
    }
}
