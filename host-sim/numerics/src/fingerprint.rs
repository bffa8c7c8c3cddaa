//! A number that stands for a list of sources. `build.rs` compiles this file, too.

const OFFSET: u64 = 0xcbf2_9ce4_8422_2325;
const PRIME: u64 = 0x0100_0000_01b3;

/// The 64-bit FNV-1a hash of the names and contents of `sources`, in their order. Carriage returns are left out, so that
/// line endings do not count.
pub fn of<'a>(sources: impl IntoIterator<Item = (&'a str, &'a str)>) -> u64 {
    let mut hash = OFFSET;
    for (name, content) in sources {
        let content = content.bytes().filter(|byte| *byte != b'\r');
        // No UTF-8 text has the byte 0xff, so names and contents cannot run into each other.
        let bytes = name.bytes().chain([0xff]).chain(content).chain([0xff]);
        for byte in bytes {
            hash = (hash ^ u64::from(byte)).wrapping_mul(PRIME);
        }
    }
    hash
}

/// The lines of `lock` (a `Cargo.lock`) that say which versions of `packages` are built.
pub fn versions(lock: &str, packages: &[&str]) -> String {
    let lines: Vec<&str> = lock.lines().map(str::trim_end).collect();
    let pairs = lines.windows(2).filter(|pair| {
        let name = pair[0].strip_prefix("name = ");
        name.is_some_and(|name| packages.contains(&name.trim_matches('"')))
    });
    pairs.map(|pair| pair.join(" ") + "\n").collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const SOURCES: [(&str, &str); 2] = [("a.rs", "fn a() {}\n"), ("b.rs", "fn b() {}\n")];

    #[test]
    fn every_byte_of_a_source_counts_and_so_do_names_and_order() {
        let usual = of(SOURCES);
        assert_eq!(of(SOURCES), usual);
        for (i, (name, content)) in SOURCES.into_iter().enumerate() {
            for at in 0..content.len() {
                let mut bytes = content.as_bytes().to_vec();
                bytes[at] ^= 1;
                let changed = String::from_utf8(bytes).unwrap();
                let mut sources = SOURCES;
                sources[i] = (name, &changed);
                assert_ne!(of(sources), usual, "{name}, byte {at}");
            }
        }
        let [a, b] = SOURCES;
        assert_ne!(of([b, a]), usual);
        assert_ne!(of([a]), usual);
        assert_ne!(of([("c.rs", a.1), b]), usual);
        assert_ne!(of([("a.rsf", "n a() {}\n"), b]), usual);
    }

    #[test]
    fn line_endings_do_not_count() {
        let windows = SOURCES.map(|(name, content)| (name, content.replace('\n', "\r\n")));
        let windows = windows
            .iter()
            .map(|(name, content)| (*name, content.as_str()));
        assert_eq!(of(windows), of(SOURCES));
    }

    /// The published value for the eight bits-wide test string "foobar" (the separators hash like any other byte).
    #[test]
    fn it_is_fnv_1a() {
        let foobar = 0x8594_4171_f739_67e8_u64;
        let separated = (foobar ^ 0xff).wrapping_mul(PRIME);
        let twice = (separated ^ 0xff).wrapping_mul(PRIME);
        assert_eq!(of([("foobar", "")]), twice);
    }

    #[test]
    fn versions_of_the_packages_asked_for_are_found() {
        let lock = "[[package]]\nname = \"libm\"\nversion = \"0.2.16\"\n\n[[package]]\nname = \"other\"\nversion = \"1.0.0\"\n";
        let found = versions(lock, &["libm"]);
        assert_eq!(found, "name = \"libm\" version = \"0.2.16\"\n");
    }
}
