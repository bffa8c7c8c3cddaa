//! Whose a file is that stands where one is to be written.

use std::path::Path;

use super::KEY;
use crate::UserError;
use crate::read::read_bytes;

/// An answer has some megabytes; a file larger than this is none.
const MOST_BYTES: u64 = 1 << 30;

/// Whether the JSON, SVG, PNG or HTML file at `path` says what it was made from.
pub fn says(path: &Path) -> bool {
    let bytes = read_bytes(path, MOST_BYTES).unwrap_or_default();
    let ways = ["\"KEY\":", "id=\"KEY\"", "KEY\0"];
    let ways = ways.map(|way| way.replace("KEY", KEY));
    let has = |way: &String| bytes.windows(way.len()).any(|w| w == way.as_bytes());
    ways.iter().any(has)
}

/// Checks that what stands in `dir` under `names` are answers of this program, which another may replace. JSON and
/// pictures say so; the JSON among them says it for the others. A link is nobody's answer and no loss.
///
/// # Errors
/// The first that is something else.
pub fn refuse_others<'a>(
    dir: &Path,
    names: impl IntoIterator<Item = &'a str> + Clone,
) -> Result<(), UserError> {
    let mut jsons = names.clone().into_iter().filter(|n| n.ends_with(".json"));
    let ours = jsons.any(|name| says(&dir.join(name)));
    for name in names {
        let path = dir.join(name);
        let Ok(there) = path.symlink_metadata() else {
            continue;
        };
        let told = [".json", ".svg", ".png"].iter().any(|e| name.ends_with(e));
        let what = match told {
            _ if there.is_symlink() => continue,
            _ if there.is_dir() => "is a folder",
            _ if !there.is_file() => "is not an ordinary file",
            true if says(&path) => continue,
            false if ours => continue,
            _ => "is no answer of this program",
        };
        return Err(UserError::new(format!(
            "{} {what}; move it away, or give --out another folder",
            path.display()
        )));
    }
    Ok(())
}
