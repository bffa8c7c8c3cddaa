//! Check sums over every byte of a Parquet file, so that a flipped bit is found and its place told.
//!
//! The pages of Parquet have none that the library writes. Here the bytes of each row group have a CRC-32, and so has the
//! rest of the file; all of them stand in the footer under the key [`KEY`] as `END:CRC END:CRC ... tail=CRC` in
//! hexadecimal, where END is the byte after the group. For the sum of the rest its own eight digits count as zeros.

use std::io::{self, Write};

use crc32fast::Hasher;

/// The key in the footer.
pub(super) const KEY: &str = "checks";

/// Comes before the digits of the last sum.
const TAIL: &[u8] = b"tail=";
const NONE_YET: &[u8] = b"00000000";

/// A sink that keeps sums of what goes through it.
pub(super) struct Summed<W> {
    sink: W,
    hasher: Hasher,
    written: u64,
    groups: Vec<(u64, u32)>,
    /// What follows the last group, once that is so.
    tail: Option<Vec<u8>>,
}

impl<W: Write> Summed<W> {
    pub(super) fn new(sink: W) -> Self {
        Self {
            sink,
            hasher: Hasher::new(),
            written: 0,
            groups: Vec::new(),
            tail: None,
        }
    }

    /// A row group ends here.
    pub(super) fn cut(&mut self) {
        let hasher = std::mem::replace(&mut self.hasher, Hasher::new());
        self.groups.push((self.written, hasher.finalize()));
    }

    /// No group follows: the value of [`KEY`], with zeros for the last sum.
    pub(super) fn hold_the_tail(&mut self) -> String {
        // A file without groups begins with its tail, of which the first bytes are through.
        if self.groups.is_empty() {
            self.cut();
        }
        self.tail = Some(Vec::new());
        let mut text = String::new();
        for (end, sum) in &self.groups {
            text += &format!("{end:x}:{sum:08x} ");
        }
        text + "tail=00000000"
    }

    /// Writes the tail with its sum.
    pub(super) fn finish(mut self) -> io::Result<W> {
        if let Some(mut tail) = self.tail.take() {
            let digits = digits_in(&tail).filter(|at| tail[at.clone()] == *NONE_YET);
            let digits = digits.ok_or_else(|| io::Error::other("the footer lost its check"))?;
            let sum = format!("{:08x}", crc32fast::hash(&tail));
            tail[digits].copy_from_slice(sum.as_bytes());
            self.sink.write_all(&tail)?;
        }
        self.sink.flush()?;
        Ok(self.sink)
    }
}

impl<W: Write> Write for Summed<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if let Some(tail) = &mut self.tail {
            tail.extend_from_slice(bytes);
            return Ok(bytes.len());
        }
        let count = self.sink.write(bytes)?;
        self.hasher.update(&bytes[..count]);
        self.written += count as u64;
        Ok(count)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.sink.flush()
    }
}

/// Where the digits of the last sum stand in the tail.
fn digits_in(tail: &[u8]) -> Option<std::ops::Range<usize>> {
    let found = tail
        .windows(TAIL.len())
        .rposition(|window| window == TAIL)?;
    let from = found + TAIL.len();
    let digits = from..from + NONE_YET.len();
    (digits.end <= tail.len()).then_some(digits)
}

/// The sums of a file.
#[derive(Debug)]
pub(super) struct Checks {
    /// First byte, byte after the end, and sum of each group.
    groups: Vec<(u64, u64, u32)>,
}

impl Checks {
    /// From the value of [`KEY`].
    pub(super) fn parse(text: &str) -> Option<Self> {
        let (groups, _) = text.split_once("tail=")?;
        let mut from = 0;
        let mut all = Vec::new();
        for group in groups.split_ascii_whitespace() {
            let (end, sum) = group.split_once(':')?;
            let end = u64::from_str_radix(end, 16).ok()?;
            let sum = u32::from_str_radix(sum, 16).ok()?;
            if end < from {
                return None;
            }
            all.push((from, end, sum));
            from = end;
        }
        (!all.is_empty()).then_some(Self { groups: all })
    }

    /// First byte of the tail.
    pub(super) fn tail_from(&self) -> u64 {
        self.groups.last().map_or(0, |(_, end, _)| *end)
    }

    /// Whether the bytes of the tail are what they were.
    pub(super) fn tail_is_whole(mut tail: Vec<u8>) -> bool {
        let Some(digits) = digits_in(&tail) else {
            return false;
        };
        let text = String::from_utf8_lossy(&tail[digits.clone()]).into_owned();
        let Ok(sum) = u32::from_str_radix(&text, 16) else {
            return false;
        };
        // Capital letters would be another way to write the same.
        if text != format!("{sum:08x}") {
            return false;
        }
        tail[digits].copy_from_slice(NONE_YET);
        crc32fast::hash(&tail) == sum
    }

    /// First byte, byte after the end, and sum of a group.
    pub(super) fn group(&self, index: usize) -> Option<(u64, u64, u32)> {
        self.groups.get(index).copied()
    }
}
