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
pub struct Strongest {
    gap_mm: f64,
    pub gap_ratio: f64,
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

/// The strongest 1/1 of every gap that has one.
pub fn strongest_rows(map: &Map) -> Vec<Strongest> {
    let rows = 0..map.grid.gaps_mm.len();
    rows.filter_map(|row| strongest(map, row)).collect()
}

/// Whether it lies at the upper edge of its 1/1.
pub fn at_edge(map: &Map, row: &Strongest) -> bool {
    let ratios = map.frequency_ratios();
    let steps = ratios.windows(2).map(|w| w[1] - w[0]);
    let step = steps.fold(0.0, f64::max);
    row.one_one_to_ratio - row.frequency_ratio < 1.5 * step
}

/// The page of a map of 1/1 by its force: figures 3.26, 3.47, 3.49 and 3.51.
pub fn by_force(figure: &'static str, map: &Map, command: &str) -> Result<Page, UserError> {
    let rows = strongest_rows(map);
    let edge: Vec<&Strongest> = rows.iter().filter(|row| at_edge(map, row)).collect();
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
        chapter: match figure {
            "3.26" => {
                "3.3.6: at the natural frequency forces \"3 times smaller in magnitude than the maximum force\"; the largest force \"does not occur at the z = 1/1 boundary, except for high values of gap\"; at 0.0 mm it is as large as at higher gaps."
            }
            "3.51" => {
                "3.4.3: \"the same observations stated for the hammer supported by wires\" (figure 3.26). The caption says 150 mm, as that of 3.49 does; by its place after 3.50 it is the 135 mm rig's."
            }
            _ => {
                "3.4.3: \"the same observations stated for the hammer supported by wires\" (figure 3.26)."
            }
        },
        found,
        command: command.to_owned(),
        files,
    })
}
