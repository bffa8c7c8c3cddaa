//! The program: what is flashed, its names, and where in the source an instruction comes from.

use std::ops::Range;
use std::path::Path;

use addr2line::Context;
use gimli::{EndianRcSlice, RunTimeEndian};
use object::{Object, ObjectSection, ObjectSymbol};

use crate::memory::{FLASH, RAM, RAM_SIZE};

type Slice = EndianRcSlice<RunTimeEndian>;

/// A program in an ELF file.
pub struct Image {
    segments: Vec<(u32, Vec<u8>)>,
    /// Objects in RAM: first byte, size, name.
    objects: Vec<(u32, u32, String)>,
    /// Where RAM may be read that was never written: what outlives a reset.
    pub random: Vec<Range<u32>>,
    lines: Option<Context<Slice>>,
    symbols: Vec<(u32, String)>,
}

impl Image {
    /// Reads an ELF file.
    ///
    /// # Errors
    /// It cannot be read, or is none.
    pub fn read(path: &Path) -> Result<Self, String> {
        let data =
            std::fs::read(path).map_err(|e| format!("cannot read {}: {e}", path.display()))?;
        Self::parse(&data)
            .map_err(|e| format!("{} is no program for the board: {e}", path.display()))
    }

    fn parse(data: &[u8]) -> Result<Self, object::Error> {
        let file = object::File::parse(data)?;
        let mut segments = Vec::new();
        // Where it is loaded is in the program headers, not among the sections.
        if let object::File::Elf32(elf) = &file {
            use object::read::elf::ProgramHeader;
            for header in elf.elf_program_headers() {
                let bytes = header.data(elf.endian(), data).unwrap_or(&[]);
                if !bytes.is_empty() && header.p_type(elf.endian()) == object::elf::PT_LOAD {
                    segments.push((header.p_paddr(elf.endian()), bytes.to_vec()));
                }
            }
        }
        let mut random = Vec::new();
        for section in file.sections() {
            if section.name().is_ok_and(|name| name.starts_with(".uninit")) {
                let start = section.address() as u32;
                random.push(start..start + section.size() as u32);
            }
        }
        let in_ram =
            |address: u64| (u64::from(RAM)..u64::from(RAM) + RAM_SIZE as u64).contains(&address);
        let mut objects = Vec::new();
        let mut symbols = Vec::new();
        for symbol in file.symbols() {
            let name = symbol.name().unwrap_or_default().to_owned();
            if symbol.size() > 0 && in_ram(symbol.address()) {
                objects.push((symbol.address() as u32, symbol.size() as u32, name.clone()));
            }
            symbols.push((symbol.address() as u32, name));
        }
        let load = |id: gimli::SectionId| -> Result<Slice, gimli::Error> {
            let section = file.section_by_name(id.name());
            let bytes = section
                .and_then(|s| s.uncompressed_data().ok())
                .unwrap_or_default();
            Ok(Slice::new(
                std::rc::Rc::from(&*bytes),
                RunTimeEndian::Little,
            ))
        };
        let lines = gimli::Dwarf::load(load)
            .ok()
            .and_then(|dwarf| Context::from_dwarf(dwarf).ok());
        Ok(Self {
            segments,
            objects,
            random,
            lines,
            symbols,
        })
    }

    /// A program of half words at the start of flash, for tests: the stack at `stack`, code from 0x100 on.
    pub fn of_code(stack: u32, vectors: &[(usize, u32)], code: &[u16]) -> Self {
        let mut bytes = vec![0; 0x200];
        let mut put =
            |at: usize, value: u32| bytes[at..at + 4].copy_from_slice(&value.to_le_bytes());
        put(0, stack);
        put(4, FLASH + 0x201);
        for (number, address) in vectors {
            put(4 * number, *address | 1);
        }
        bytes.extend(code.iter().flat_map(|half| half.to_le_bytes()));
        Self {
            segments: vec![(FLASH, bytes)],
            objects: Vec::new(),
            random: Vec::new(),
            lines: None,
            symbols: Vec::new(),
        }
    }

    /// Lays it into the flash's bytes.
    pub fn place(&self, flash: &mut [u8]) {
        for (address, bytes) in &self.segments {
            let at = address.wrapping_sub(FLASH) as usize;
            if let Some(slot) = flash.get_mut(at..at + bytes.len()) {
                slot.copy_from_slice(bytes);
            }
        }
    }

    /// The address of a name.
    pub fn symbol(&self, name: &str) -> Option<u32> {
        self.symbols
            .iter()
            .find(|(_, own)| own == name)
            .map(|(address, _)| *address)
    }

    /// The address of the first name that has this in it, as the linker has it.
    pub fn symbol_of(&self, part: &str) -> Option<u32> {
        self.symbols
            .iter()
            .find(|(_, own)| own.contains(part))
            .map(|(address, _)| *address)
    }

    /// Address and size of the object in RAM whose name has this in it.
    pub fn object(&self, part: &str) -> Option<(u32, u32)> {
        self.objects
            .iter()
            .find(|(_, _, own)| own.contains(part))
            .map(|(start, size, _)| (*start, *size))
    }

    /// An error if a buffer is not within one object of the program.
    ///
    /// # Errors
    /// It reaches over an object's end, or is none.
    pub fn check_buffer(&self, start: u32, size: u32) -> Result<(), String> {
        let within =
            |(at, length, _): &&(u32, u32, String)| start >= *at && start + size <= at + length;
        if self.objects.is_empty() || self.objects.iter().any(|object| within(&object)) {
            return Ok(());
        }
        Err(format!(
            "a buffer of {size} bytes at {start:#010x} is not within one object of the program"
        ))
    }

    /// Source file and line of an instruction, the innermost function first.
    pub fn place_of(&self, address: u32) -> String {
        let found = self.lines.as_ref().and_then(|lines| {
            let mut frames = lines
                .find_frames(u64::from(address))
                .skip_all_loads()
                .ok()?;
            let mut text = Vec::new();
            while let Ok(Some(frame)) = frames.next() {
                let name = frame
                    .function
                    .as_ref()
                    .and_then(|f| f.demangle().ok().map(|n| n.into_owned()));
                let place = frame
                    .location
                    .map(|l| format!("{}:{}", l.file.unwrap_or("?"), l.line.unwrap_or(0)));
                text.push(format!(
                    "{} ({})",
                    name.unwrap_or_default(),
                    place.unwrap_or_default()
                ));
                if text.len() == 4 {
                    break;
                }
            }
            (!text.is_empty()).then(|| text.join("\n     "))
        });
        found.unwrap_or_else(|| "unknown".into())
    }
}
