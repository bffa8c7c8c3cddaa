//! The strongest 1/1 at each gap of a Peterka map: figures 3.26 (wires) and 3.47, 3.49, 3.51 (beams).

use serde::Serialize;

use super::Page;
use crate::pictures;
use files::UserError;
use numerics::map::Map;

/// The strongest 1/1 of a gap.
#[derive(Serialize)]
pub struct StrongestOfGap {
    gap_mm: f64,
    pub gap_ratio: f64,
    frequency_ratio: f64,
    force_ratio: f64,
    /// Highest Ω/ω of the 1/1 it belongs to.
    one_one_to_ratio: f64,
    force_ratio_at_natural_frequency: f64,
}

fn strongest(map: &Map, row: usize) -> Option<StrongestOfGap> {
    let ratios = map.frequency_ratios();
    let columns = ratios.len();
    let is = |j: usize| map.cell(row, j).regime.is(1, 1);
    let force = |j: usize| map.force_ratio(row * columns + j);
    let best = (0..columns)
        .filter(|j| is(*j))
        .max_by(|a, b| force(*a).total_cmp(&force(*b)))?;
    let end = (best..columns).take_while(|j| is(*j)).last()?;
    let natural = (0..columns).min_by(|a, b| {
        let off = |j: usize| (ratios[j] - 1.0).abs();
        off(*a).total_cmp(&off(*b))
    })?;
    Some(StrongestOfGap {
        gap_mm: map.grid.gaps_mm[row],
        gap_ratio: map.gap_ratios()[row],
        frequency_ratio: ratios[best],
        force_ratio: force(best),
        one_one_to_ratio: ratios[end],
        force_ratio_at_natural_frequency: force(natural),
    })
}

/// The strongest 1/1 of every gap that has one.
pub fn strongest_rows(map: &Map) -> Vec<StrongestOfGap> {
    let rows = 0..map.grid.gaps_mm.len();
    rows.filter_map(|row| strongest(map, row)).collect()
}

/// Whether it lies at the upper edge of its 1/1.
pub fn at_edge(map: &Map, row: &StrongestOfGap) -> bool {
    let ratios = map.frequency_ratios();
    let steps = ratios.windows(2).map(|w| w[1] - w[0]);
    let step = steps.fold(0.0, f64::max);
    row.one_one_to_ratio - row.frequency_ratio < 1.5 * step
}

/// The page of a map of 1/1 by its force: figures 3.26, 3.47, 3.49 and 3.51.
pub fn by_force(figure: &'static str, map: &Map, command: &str) -> Result<Page, UserError> {
    let title = format!("{}: Peterka map of 1/1 by its force", map.rig.name);
    let page = Page::new(figure, title, command, &pictures::map::by_force(map))?;
    Ok(page.table("", &strongest_rows(map)))
}
