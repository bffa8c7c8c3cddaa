//! The strongest 1/1 at each gap of a Peterka map: figures 3.26 (wires) and 3.47, 3.49, 3.51 (beams).

use serde::Serialize;

use super::{Page, stem};
use crate::pictures;
use crate::pictures::drawn;
use files::UserError;
use files::table::to_csv;
use numerics::map::Map;

/// The strongest 1/1 of a gap.
#[derive(Serialize)]
struct Strongest {
    gap_mm: f64,
    gap_ratio: f64,
    frequency_ratio: f64,
    force_ratio: f64,
    /// Highest Ω/ω of the 1/1 it belongs to.
    one_one_to_ratio: f64,
    force_ratio_at_natural_frequency: f64,
}

fn strongest(map: &Map, row: usize) -> Option<Strongest> {
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
    Some(Strongest {
        gap_mm: map.grid.gaps_mm[row],
        gap_ratio: map.gap_ratios()[row],
        frequency_ratio: ratios[best],
        force_ratio: force(best),
        one_one_to_ratio: ratios[end],
        force_ratio_at_natural_frequency: force(natural),
    })
}

/// The page of a map of 1/1 by its force: figures 3.26, 3.47, 3.49 and 3.51.
pub fn by_force(figure: &'static str, map: &Map, command: &str) -> Result<Page, UserError> {
    let rows: Vec<Strongest> = (0..map.grid.gaps_mm.len())
        .filter_map(|row| strongest(map, row))
        .collect();
    let step = map
        .frequency_ratios()
        .windows(2)
        .map(|w| w[1] - w[0])
        .fold(0.0, f64::max);
    let at_edge = |r: &&Strongest| r.one_one_to_ratio - r.frequency_ratio < 1.5 * step;
    let edge: Vec<&Strongest> = rows.iter().filter(at_edge).collect();
    let forces = || rows.iter().map(|r| r.force_ratio);
    let (least, most) = (
        forces().fold(f64::INFINITY, f64::min),
        forces().fold(0.0, f64::max),
    );
    let mut found = format!(
        "The largest 1/1 force lies between {least:.1} and {most:.1} m g over {} gaps.",
        rows.len()
    );
    if let Some(zero) = rows.first() {
        let natural = zero.force_ratio_at_natural_frequency;
        found += &format!(
            " At {:?} mm it is {:.1} m g, {:.1} times the {natural:.1} at the natural frequency.",
            zero.gap_mm,
            zero.force_ratio,
            zero.force_ratio / natural
        );
    }
    found += &match edge.first() {
        Some(first) => format!(
            " It is met at the upper edge of 1/1 at {} of these gaps, the smallest of them {:.2} A0; at the others inside.",
            edge.len(),
            first.gap_ratio
        ),
        None => " At no gap is it met at the upper edge of 1/1.".to_owned(),
    };
    let stem = stem(figure);
    let mut files = drawn(&stem, &pictures::map::by_force(map))?;
    files.push((format!("{stem}.csv"), to_csv(&rows)));
    Ok(Page {
        figure,
        title: format!("{}: Peterka map of 1/1 by its force", map.rig.name),
        chapter: "At the natural frequency the force is about 3 times below the largest. The largest force at a gap is not at the edge of 1/1, except at large gaps. At 0.0 mm it is about as large as at other gaps.",
        found,
        command: command.to_owned(),
        files,
    })
}
