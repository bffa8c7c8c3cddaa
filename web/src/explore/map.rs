//! Cells of the Peterka map.

use numerics::lanes::CellPlan;
use numerics::map::{Grid, MapCell, MapRequest, Runner, run};
use numerics::sweep::Direction;
use serde::Deserialize;

use super::rig;
use crate::{bytes, json};

#[derive(Deserialize)]
struct Asked {
    rig: rig::RigAsked,
    /// Clearances over the cart's amplitude.
    gap_ratios: Vec<f64>,
    /// Drive frequencies over the natural frequency, Ω/ω.
    frequency_ratios: Vec<f64>,
    /// Drive cycles of a cell.
    cycles: u32,
    /// How many of the last are recorded.
    recorded: u32,
}

/// The cells of a rectangle of the map, row by row from the first gap, packed ([`bytes::cells`]): the command `map` with the
/// fast engine, from rest. A gap that this rig cannot have (wires of half its length, say) is a row of failed cells.
pub fn map(argument: &[u8]) -> Result<Vec<u8>, String> {
    let asked: Asked = json::read(argument)?;
    let rig = asked.rig.rig()?;
    let amplitude_mm = rig.params.amplitude_m * 1e3;
    let natural_hz = rig.params.natural_frequency_hz();
    let gaps_mm: Vec<f64> = asked.gap_ratios.iter().map(|r| r * amplitude_mm).collect();
    let hangs = |gap_mm: &f64| rig.params.with_gap_mm(*gap_mm).is_ok();
    let possible: Vec<bool> = gaps_mm.iter().map(hangs).collect();
    let columns = asked.frequency_ratios.len();
    if !possible.contains(&true) {
        let failed = vec![MapCell::FAILED; gaps_mm.len() * columns];
        return Ok(bytes::cells(&failed));
    }
    let request = MapRequest {
        grid: Grid {
            gaps_mm: gaps_mm.iter().copied().filter(hangs).collect(),
            frequencies_hz: asked
                .frequency_ratios
                .iter()
                .map(|r| r * natural_hz)
                .collect(),
        },
        rig: rig.clone(),
        runner: Runner::Lanes,
        plan: CellPlan {
            cycles: asked.cycles,
            recorded: asked.recorded,
            ..CellPlan::CHAPTER
        },
        settle: None,
        from: Direction::Rest,
    };
    let map = run(&request, &()).map_err(|e| files::UserError::from(e).to_string())?;
    let mut rows = map.cells.chunks(columns);
    let row = |possible: bool| match possible.then(|| rows.next()).flatten() {
        Some(row) => row.to_vec(),
        None => vec![MapCell::FAILED; columns],
    };
    let cells: Vec<MapCell> = possible.into_iter().flat_map(row).collect();
    Ok(bytes::cells(&cells))
}
