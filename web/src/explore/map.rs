//! Cells of the Peterka map.

use numerics::lanes::CellPlan;
use numerics::map::{Grid, MapRequest, Runner, run};
use numerics::sweep::Direction;
use serde::Deserialize;

use super::rig;
use crate::{bytes, json};

#[derive(Deserialize)]
struct Asked {
    rig: rig::Asked,
    /// Clearances over the cart's amplitude.
    gap_ratios: Vec<f64>,
    /// Ω/ω.
    frequency_ratios: Vec<f64>,
    /// Drive cycles of a cell.
    cycles: u32,
    /// How many of the last are recorded.
    recorded: u32,
}

/// The cells of a rectangle of the map, row by row from the first gap, packed ([`bytes::cells`]): the command `map` with the
/// fast engine, from rest.
pub fn map(argument: &[u8]) -> Result<Vec<u8>, String> {
    let asked: Asked = json::read(argument)?;
    let rig = asked.rig.rig()?;
    let amplitude_mm = rig.params.amplitude_m * 1e3;
    let natural_hz = rig.params.natural_frequency_hz();
    let request = MapRequest {
        grid: Grid {
            gaps_mm: asked.gap_ratios.iter().map(|r| r * amplitude_mm).collect(),
            frequencies_hz: asked
                .frequency_ratios
                .iter()
                .map(|r| r * natural_hz)
                .collect(),
        },
        rig,
        runner: Runner::Lanes,
        plan: CellPlan {
            cycles: asked.cycles,
            recorded: asked.recorded,
            ..CellPlan::CHAPTER
        },
        settle: None,
        from: Direction::Rest,
    };
    let map = run(&request, None, &()).map_err(|e| files::UserError::from(e).to_string())?;
    Ok(bytes::cells(&map.cells))
}
