//! Beyond the chapter's figures: the periodic orbits behind its bifurcation diagrams, stable and unstable, and where
//! over the Peterka map the 1/1 doubles, folds and grazes.

use shared::model::params::{RigParams, WIRES};
use shared::model::rig::Rig;

use super::{Effort, Page};
use crate::pictures;
use crate::pictures::regimes::regime_raster;
use crate::progress::ProgressLine;
use files::UserError;
use numerics::continuation::curves::SpecialLine;
use numerics::continuation::table::{OrbitsAnswer, line_rows};
use numerics::continuation::{Along, OrbitsRequest, curves, diagram};
use numerics::lanes::{self, Cell, CellPlan};
use plot::{Axis, Figure, Item, Panel, edges};

/// A figure and its gap, mm.
const GAPS: [(&str, f64); 3] = [
    ("orbits at 0.0 mm", 0.0),
    ("orbits at 1.0 mm", 1.0),
    ("orbits at 2.4 mm", 2.4),
];

/// Orbits over the diagrams of the wires at 0.0, 1.0 and 2.4 mm.
///
/// # Errors
/// If a motion cannot be followed or a picture cannot be drawn.
pub fn branches(effort: Effort, progress: &ProgressLine) -> Result<Vec<Page>, UserError> {
    GAPS.iter()
        .map(|(figure, gap_mm)| {
            let page = branch_page(figure, *gap_mm, effort)?;
            progress.inc(1);
            Ok(page)
        })
        .collect()
}

fn branch_page(figure: &'static str, gap_mm: f64, effort: Effort) -> Result<Page, UserError> {
    let params = RigParams {
        gap_m: gap_mm * 1e-3,
        ..WIRES
    };
    let (starts, behind) = effort.of((40, 800), (8, 20));
    let request = OrbitsRequest {
        along: Along::Frequency,
        limits: (0.8, 4.0),
        periods: 2,
        impacts: 2,
        starts,
        checks: 0,
    };
    let found = diagram(&params, &request, &ProgressLine::new("", 1, true))?;
    let answer = OrbitsAnswer::new("wires", &found);
    let simulated = pictures::orbits::simulated(&found, behind)?;
    let picture = pictures::orbits::figure("wires", &found, &simulated);
    let page = Page::new(
        figure,
        format!(
            "Wires, gap {gap_mm:?} mm: periodic orbits, stable and unstable, over the bifurcation diagram"
        ),
        format!("host-sim orbits --rig wires --gap {gap_mm:?} --cart prescribed"),
        &picture,
    )?;
    let page = page.table("", &answer.orbits);
    Ok(page.table("-special", &answer.special_points))
}

/// The range of the Peterka map, figure 3.24: gap, mm, and drive frequency, Hz.
const MAP_GAPS_MM: (f64, f64) = (0.0, 3.56);
const MAP_FREQUENCIES_HZ: (f64, f64) = (1.41, 7.28);

/// Lines of special points of the 1/1 over the regimes of the Peterka map, wires.
///
/// # Errors
/// If a motion cannot be followed or a picture cannot be drawn.
pub fn over_the_map(effort: Effort, progress: &ProgressLine) -> Result<Vec<Page>, UserError> {
    let (gaps, frequencies, lines_at, starts) = effort.of((179, 148, 90, 24), (7, 8, 5, 6));
    let along = |(from, to): (f64, f64), count: usize| numerics::sweep::spread(from, to, count);
    let (columns, rows) = (
        along(MAP_GAPS_MM, gaps),
        along(MAP_FREQUENCIES_HZ, frequencies),
    );
    let regimes = regimes(&columns, &rows)?;
    progress.inc(1);
    let natural_hz = WIRES.natural_frequency_hz();
    let gaps_m = along(MAP_GAPS_MM, lines_at);
    let gaps_m: Vec<f64> = gaps_m.iter().map(|mm| mm * 1e-3).collect();
    let (low_hz, high_hz) = MAP_FREQUENCIES_HZ;
    let ratios = (low_hz / natural_hz, high_hz / natural_hz);
    let lines = curves::lines(&WIRES, &gaps_m, ratios, starts, &())?;
    progress.inc(1);
    let rows = line_rows(&WIRES, &lines);
    let page = Page::new(
        "orbits over the map",
        "Wires: special points of the 1/1 over the Peterka map",
        "host-sim orbits --rig wires --curves --cart prescribed",
        &map_figure(&regimes, (gaps, frequencies), &lines),
    )?;
    Ok(vec![page.table("", &rows)])
}

fn map_figure(
    regimes: &[String],
    (gaps, frequencies): (usize, usize),
    lines: &[SpecialLine],
) -> Figure {
    let x = edges(MAP_GAPS_MM.0, MAP_GAPS_MM.1, gaps);
    let y = edges(MAP_FREQUENCIES_HZ.0, MAP_FREQUENCIES_HZ.1, frequencies);
    let mut panel = Panel::new(
        Axis::new("gap, mm").fixed(x.0, x.1),
        Axis::new("drive frequency, Hz").fixed(y.0, y.1),
    );
    let areas = regime_raster(x, y, gaps, regimes);
    panel.items.push(Item::raster(areas));
    panel.items.extend(pictures::orbits::line_items(lines));
    Figure::new("Wires: where the 1/1 doubles, folds and grazes, over the Peterka map")
        .subtitle("Areas: what simulations from rest settle on. Lines: special points of the 1/1 orbits, stable or not, followed at each gap.")
        .size(1100, 820)
        .panel(panel)
}

/// Regimes from rest, row by row of rising frequency, in each row by rising gap.
fn regimes(gaps_mm: &[f64], frequencies_hz: &[f64]) -> Result<Vec<String>, UserError> {
    let mut cells = Vec::new();
    for frequency_hz in frequencies_hz {
        for gap_mm in gaps_mm {
            let params = RigParams {
                gap_m: gap_mm * 1e-3,
                ..WIRES
            };
            let rest = Rig::<f64>::new(&params)?.rest();
            cells.push(Cell {
                params,
                frequency_hz: *frequency_hz,
                start: [rest, 0.0],
                phase: 0.0,
            });
        }
    }
    let outcomes = lanes::run(&cells, &CellPlan::CHAPTER)?;
    Ok(outcomes.iter().map(|o| o.regime.to_string()).collect())
}
