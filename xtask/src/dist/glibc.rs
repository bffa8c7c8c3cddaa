//! The oldest C library a program starts with, read from the program itself, and the systems that have it.

use object::{
    Endianness,
    elf::{FileHeader64, VER_FLG_WEAK},
    read::elf::FileHeader,
};

use crate::JobResult;

/// A version of the GNU C library, as 2.31 is (2, 31).
pub type Version = (u32, u32);

/// Systems by their C library, oldest first.
const SYSTEMS: &[(Version, &str)] = &[
    ((2, 17), "CentOS 7"),
    ((2, 28), "Debian 10, RHEL 8"),
    ((2, 31), "Debian 11, Ubuntu 20.04"),
    ((2, 34), "RHEL 9"),
    ((2, 35), "Ubuntu 22.04"),
    ((2, 36), "Debian 12"),
    ((2, 39), "Ubuntu 24.04"),
    ((2, 41), "Debian 13"),
];

/// The newest version that the program asks of the C library; none if it asks for none.
pub fn needed(program: &[u8]) -> JobResult<Option<Version>> {
    let header = FileHeader64::<Endianness>::parse(program)?;
    let endian = header.endian()?;
    let sections = header.sections(endian, program)?;
    let Some((mut files, link)) = sections.gnu_verneed(endian, program)? else {
        return Ok(None);
    };
    let names = sections.strings(endian, program, link)?;
    let mut newest = None;
    while let Some((_, mut versions)) = files.next()? {
        while let Some(version) = versions.next()? {
            // A program starts without what is only weakly asked for.
            if !version.vna_flags.get(endian).contains(VER_FLG_WEAK) {
                let name = std::str::from_utf8(version.name(endian, names)?)?;
                newest = newest.max(version_of(name));
            }
        }
    }
    Ok(newest)
}

/// `GLIBC_2.31`, and `GLIBC_2.2.5` as 2.2.
fn version_of(name: &str) -> Option<Version> {
    let mut parts = name.strip_prefix("GLIBC_")?.split('.');
    Some((parts.next()?.parse().ok()?, parts.next()?.parse().ok()?))
}

/// Says which systems a program serves that needs this version.
pub fn words(needed: Version) -> String {
    let (major, minor) = needed;
    let oldest = SYSTEMS.iter().find(|(version, _)| *version >= needed);
    let which = oldest.map_or_else(
        || "newer than that of every system known here".into(),
        |(_, names)| format!("that of {names}, or newer"),
    );
    format!("needs glibc {major}.{minor} or newer ({which})")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[cfg(all(target_os = "linux", target_env = "gnu", target_pointer_width = "64"))]
    fn this_very_program_needs_a_c_library_no_newer_than_the_one_it_runs_on() {
        let own = std::fs::read(std::env::current_exe().unwrap()).unwrap();
        let needed = needed(&own).unwrap().unwrap();
        let mut ask = std::process::Command::new("getconf");
        let here = crate::command::ask(ask.arg("GNU_LIBC_VERSION")).unwrap();
        let here = version_of(&here.replace("glibc ", "GLIBC_")).unwrap();
        assert!(needed >= (2, 2) && needed <= here, "{needed:?} {here:?}");
    }

    #[test]
    fn systems_are_named_by_the_oldest_that_has_it() {
        assert_eq!(version_of("GLIBC_2.2.5"), Some((2, 2)));
        assert_eq!(version_of("GCC_4.3"), None);
        assert!(words((2, 29)).contains("2.29 or newer (that of Debian 11"));
        assert!(words((2, 99)).contains("newer than that of every system"));
    }

    #[test]
    fn what_is_no_program_is_an_error() {
        assert!(needed(b"not a program").is_err());
    }
}
