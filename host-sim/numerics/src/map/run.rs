//! Making a map, tile by tile.

use std::ops::Range;

use rayon::prelude::*;

use super::compute;
use super::request::MapRequest;
use super::{Map, MapCell};
use crate::error::{Error, MapError};
use crate::progress::{Progress, check, step};

/// Keeps the tiles of an unfinished map, so that an interrupted run can continue, and several runs can share one map.
pub trait Tiles: Sync {
    /// Makes the place for tiles ready.
    ///
    /// # Errors
    /// If it cannot be made.
    fn begin(&self) -> Result<(), Error>;

    /// The cells of tile `index`; `None` if the tile is missing, damaged, or does not have `cells` of them.
    fn read(&self, index: usize, cells: usize) -> Option<Vec<MapCell>>;

    /// Keeps the cells of tile `index`.
    ///
    /// # Errors
    /// If they cannot be kept.
    fn write(&self, index: usize, cells: &[MapCell]) -> Result<(), Error>;
}

/// Makes the map of `request`. Tiles that `store` has are taken from it, the others are computed and kept there.
/// The map is the same whatever `store` had, and for any number of threads.
///
/// # Errors
/// If the request cannot be run ([`MapRequest::check`]), if the tiles cannot be kept, or if the work is interrupted.
pub fn run(
    request: &MapRequest,
    store: Option<&dyn Tiles>,
    progress: &dyn Progress,
) -> Result<Map, Error> {
    request.check()?;
    let tiles = tiles(request, 0..request.tiles(), store, progress)?;
    Ok(assemble(request, tiles))
}

/// Computes the tiles of `range` that `store` lacks, and keeps them there: a share of a map.
///
/// # Errors
/// As [`run`]; also if the range ends beyond the last tile.
pub fn run_tiles(
    request: &MapRequest,
    range: Range<usize>,
    store: &dyn Tiles,
    progress: &dyn Progress,
) -> Result<(), Error> {
    request.check()?;
    request.check_tiles(&range)?;
    tiles(request, range, Some(store), progress).map(drop)
}

/// Puts the tiles in `store` together and computes nothing.
///
/// # Errors
/// If tiles are missing or damaged: their numbers.
pub fn merge(request: &MapRequest, store: &dyn Tiles) -> Result<Map, Error> {
    request.check()?;
    let read = |index: usize| store.read(index, request.tile(index).len());
    let tiles: Vec<_> = (0..request.tiles()).into_par_iter().map(read).collect();
    let missing: Vec<usize> = (0..tiles.len()).filter(|i| tiles[*i].is_none()).collect();
    if missing.is_empty() {
        return Ok(assemble(request, tiles.into_iter().flatten().collect()));
    }
    Err(MapError::MissingTiles {
        missing,
        count: tiles.len(),
    }
    .into())
}

fn tiles(
    request: &MapRequest,
    range: Range<usize>,
    store: Option<&dyn Tiles>,
    progress: &dyn Progress,
) -> Result<Vec<Vec<MapCell>>, Error> {
    if let Some(store) = store {
        store.begin()?;
    }
    let one = |index: usize| {
        check(progress)?;
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
        step(progress, cells.len() as u64)?;
        Ok(cells)
    };
    range.into_par_iter().map(one).collect()
}

fn assemble(request: &MapRequest, tiles: Vec<Vec<MapCell>>) -> Map {
    let mut cells = Vec::with_capacity(request.grid.len());
    for tile in tiles {
        cells.extend(tile);
    }
    Map {
        rig: request.rig.clone(),
        grid: request.grid.clone(),
        from: request.from,
        cells,
    }
}
