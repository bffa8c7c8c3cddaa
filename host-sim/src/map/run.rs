//! Making a map, tile by tile.

use std::ops::Range;

use rayon::prelude::*;

use super::compute;
use super::request::Request;
use super::store::Store;
use super::{Map, MapCell};
use crate::error::UserError;
use crate::progress::Progress;

/// Makes the map of `request`. Tiles that `store` has are taken from it, the others are computed and kept there.
/// The same map comes out whatever was there before, and for any number of threads.
///
/// # Errors
/// A request that cannot be run; a disk that refuses.
pub fn run(
    request: &Request,
    store: Option<&Store>,
    progress: &Progress,
) -> Result<Map, UserError> {
    request.check()?;
    let tiles = tiles(request, 0..request.tiles(), store, progress)?;
    Ok(assemble(request, tiles))
}

/// Computes the tiles of `range` that `store` lacks, and keeps them there: a share of a map.
///
/// # Errors
/// As [`run`]; also a range beyond the last tile.
pub fn run_tiles(
    request: &Request,
    range: Range<usize>,
    store: &Store,
    progress: &Progress,
) -> Result<(), UserError> {
    request.check()?;
    request.check_tiles(&range)?;
    tiles(request, range, Some(store), progress).map(drop)
}

/// Puts the tiles in `store` together and computes nothing.
///
/// # Errors
/// One line that names the tiles that are missing or damaged.
pub fn merge(request: &Request, store: &Store) -> Result<Map, UserError> {
    request.check()?;
    let read = |index: usize| store.read(index, request.tile(index).len());
    let tiles: Vec<_> = (0..request.tiles()).into_par_iter().map(read).collect();
    let missing: Vec<usize> = (0..tiles.len()).filter(|i| tiles[*i].is_none()).collect();
    if missing.is_empty() {
        return Ok(assemble(request, tiles.into_iter().flatten().collect()));
    }
    Err(UserError::new(format!(
        "{} of {} tiles missing in {}: {}; run these with --tiles, or leave --merge out",
        missing.len(),
        tiles.len(),
        store.dir().display(),
        ranges(&missing)
    )))
}

fn tiles(
    request: &Request,
    range: Range<usize>,
    store: Option<&Store>,
    progress: &Progress,
) -> Result<Vec<Vec<MapCell>>, UserError> {
    if let Some(store) = store {
        store.begin()?;
    }
    let one = |index: usize| {
        let expected = request.tile(index).len();
        let cells = match store.and_then(|s| s.read(index, expected)) {
            Some(cells) => cells,
            None => {
                let cells = compute::tile(request, index)?;
                if let Some(store) = store {
                    store.write(index, &cells)?;
                }
                cells
            }
        };
        progress.inc(cells.len() as u64);
        Ok(cells)
    };
    range.into_par_iter().map(one).collect()
}

fn assemble(request: &Request, tiles: Vec<Vec<MapCell>>) -> Map {
    let mut cells = Vec::with_capacity(request.grid.len());
    for tile in tiles {
        cells.extend(tile);
    }
    Map {
        rig: request.rig.clone(),
        grid: request.grid.clone(),
        cells,
    }
}

/// "0..3, 7..8" of rising numbers; the first few.
fn ranges(numbers: &[usize]) -> String {
    const MOST: usize = 5;
    let mut found: Vec<Range<usize>> = Vec::new();
    for n in numbers {
        match found.last_mut() {
            Some(last) if last.end == *n => last.end += 1,
            _ => found.push(*n..n + 1),
        }
    }
    let told: Vec<_> = found.iter().take(MOST).map(|r| format!("{r:?}")).collect();
    let more = if found.len() > MOST { ", ..." } else { "" };
    told.join(", ") + more
}
