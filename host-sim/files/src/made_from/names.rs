//! File names that tell the request.

/// The longest name without its ending. File systems allow 255 bytes.
const LONGEST: usize = 120;

/// `parts`, each as it may stand in a file name, joined by hyphens. A name that would be too long is cut and ends in a
/// check sum of the whole.
pub fn file_name<'a>(parts: impl IntoIterator<Item = &'a str>) -> String {
    let parts = parts.into_iter().map(in_name);
    let parts: Vec<_> = parts.filter(|part| !part.is_empty()).collect();
    let whole = parts.join("-");
    if whole.len() <= LONGEST {
        return whole;
    }
    let mut end = LONGEST - 9;
    while !whole.is_char_boundary(end) {
        end -= 1;
    }
    let sum = crc32fast::hash(whole.as_bytes());
    format!("{}-{sum:08x}", whole[..end].trim_end_matches('-'))
}

/// `text` as it may stand in a file name: letters, digits and `. _ = + -`. The sign of a number becomes a word, so that
/// it is not lost among hyphens.
pub fn in_name(text: &str) -> String {
    let mut name = String::new();
    let mut before = None;
    let mut rest = text.chars().peekable();
    while let Some(c) = rest.next() {
        let at_start = before.is_none_or(|b: char| "=:,x( ".contains(b));
        let digit = rest.peek().is_some_and(|d| d.is_ascii_digit() || *d == '.');
        if c == '-' && at_start && digit {
            name += "minus-";
        } else if c.is_alphanumeric() || "._=+-".contains(c) {
            name.push(c);
        } else if !name.ends_with('-') {
            name.push('-');
        }
        before = Some(c);
    }
    name.trim_matches(['-', '.']).to_owned()
}
