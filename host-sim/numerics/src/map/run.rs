//! Making a map, tile by tile.

use super::Map;
use super::compute;
use super::request::MapRequest;
use crate::error::Error;
use crate::parallel;
use crate::progress::{Progress, check, step};

/// Makes the map of `request`. It is the same for any number of threads.
///
/// # Errors
/// If the request cannot be run ([`MapRequest::check`]), or if the work is interrupted.
pub fn run(request: &MapRequest, progress: &dyn Progress) -> Result<Map, Error> {
    request.check()?;
    let numbers: Vec<usize> = (0..request.tiles()).collect();
    let tiles = parallel::try_map(&numbers, |index| {
        check(progress)?;
        let cells = compute::tile(request, *index)?;
        step(progress, cells.len() as u64)?;
        Ok(cells)
    })?;
    Ok(Map {
        rig: request.rig.clone(),
        grid: request.grid.clone(),
        from: request.from,
        cells: tiles.concat(),
    })
}
