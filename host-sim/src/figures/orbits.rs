//! Beyond the chapter's figures: the periodic orbits behind its bifurcation diagrams, stable and unstable, and where
//! over the Peterka map the 1/1 doubles, folds and grazes.

use shared::model::params::{RigParams, WIRES};
use shared::model::rig::Rig;

use super::{Effort, Page, stem};
use crate::pictures;
use crate::pictures::drawn;
use crate::pictures::regimes::regime_raster;
use crate::progress::Progress;
use files::UserError;
use files::table::to_csv;
use numerics::continuation::curves::Line;
use numerics::continuation::table::{Answer, BranchRow, Name, SpecialRow, line_rows};
use numerics::continuation::{Along, Node, OrbitsRequest, curves, diagram};
use numerics::lanes::{self, Cell, CellPlan};
use numerics::row::tidy;
use plot::{Axis, Figure, Item, Panel, edges};
use shared::model::regime::Regime;

/// A gap of the chapter's diagrams and what it says of it.
struct Diagrammed {
    figure: &'static str,
    gap_mm: f64,
    chapter: &'static str,
    /// Regimes that the chapter names: p, n and the ratio Ω/ω.
    named: &'static [(u16, u8, f64)],
}

const GAPS: [Diagrammed; 3] = [
    Diagrammed {
        figure: "orbits at 0.0 mm",
        gap_mm: 0.0,
        chapter: "3.3.6, figure 3.27: \"pitch-fork bifurcation (for gap 0.0 mm)\". 3.3.5: motion after it at 2.7, z = 1/2 at 3.8.",
        named: &[(1, 2, 3.8)],
    },
    Diagrammed {
        figure: "orbits at 1.0 mm",
        gap_mm: 1.0,
        chapter: "3.3.5: z = 1/1 at 1.5, z = 1/2 at 3.3. 3.3.6, figure 3.30: \"chaotic behavior\".",
        named: &[(1, 1, 1.5), (1, 2, 3.3)],
    },
    Diagrammed {
        figure: "orbits at 2.4 mm",
        gap_mm: 2.4,
        chapter: "3.3.5: z = 1/1 at 1.2. 3.3.6: \"chaotic behavior\"; non-zero gaps \"are known to present nonlinear jumps\".",
        named: &[(1, 1, 1.2)],
    },
];

/// Orbits over the diagrams of the wires at 0.0, 1.0 and 2.4 mm.
///
/// # Errors
/// If a motion cannot be followed or a picture cannot be drawn.
pub fn branches(effort: Effort, progress: &Progress) -> Result<Vec<Page>, UserError> {
    GAPS.iter()
        .map(|gap| {
            let page = branch_page(gap, effort)?;
            progress.inc(1);
            Ok(page)
        })
        .collect()
}

fn branch_page(gap: &Diagrammed, effort: Effort) -> Result<Page, UserError> {
    let params = RigParams {
        gap_m: gap.gap_mm * 1e-3,
        ..WIRES
    };
    let (starts, behind) = match effort {
        Effort::Full => (40, 800),
        Effort::Coarse => (8, 20),
    };
    let request = OrbitsRequest {
        along: Along::Frequency,
        limits: (0.8, 4.0),
        periods: 2,
        impacts: 2,
        starts,
        checks: 0,
    };
    let found = diagram(&params, &request, &Progress::new("", 1, true))?;
    let answer = Answer::new("wires", &found);
    let simulated = pictures::orbits::simulated(&found, behind)?;
    let figure = pictures::orbits::figure("wires", &found, &simulated);
    let name = stem(gap.figure);
    let mut files = drawn(&name, &figure)?;
    files.push((format!("{name}.csv"), to_csv(&answer.orbits)));
    files.push((
        format!("{name}-special.csv"),
        to_csv(&answer.special_points),
    ));
    let claims = gap.named.iter().map(|(impacts, periods, at)| {
        let regime = Regime::Periodic {
            impacts: *impacts,
            periods: *periods,
        };
        claim(&answer, regime, *at)
    });
    let claims: Vec<String> = claims.chain([specials(&answer)]).collect();
    Ok(Page {
        figure: gap.figure,
        title: format!(
            "Wires, gap {:?} mm: periodic orbits, stable and unstable, over the bifurcation diagram",
            gap.gap_mm
        ),
        chapter: gap.chapter,
        found: claims.join(" "),
        command: format!(
            "host-sim orbits --rig wires --gap {:?} --cart prescribed",
            gap.gap_mm
        ),
        files,
    })
}

/// Whether there is a stable orbit of `regime` at the ratio `at`, and from where to where.
fn claim(answer: &Answer, regime: Regime, at: f64) -> String {
    let of = |b: &&BranchRow| {
        regime
            == Regime::Periodic {
                impacts: b.impacts,
                periods: b.periods,
            }
    };
    let branches = answer.branches.iter().filter(of);
    let stretches: Vec<[f64; 2]> = branches.flat_map(|b| b.stable.clone()).collect();
    let here = stretches.iter().find(|s| (s[0]..=s[1]).contains(&at));
    if let Some([from, to]) = here {
        return format!("{regime} at {at}: agrees, stable from {from:.3} to {to:.3}.");
    }
    let away = |s: &&[f64; 2]| (s[0] - at).abs().min((s[1] - at).abs());
    match stretches.iter().min_by(|a, b| away(a).total_cmp(&away(b))) {
        Some([from, to]) => format!(
            "{regime} at {at}: differs, the nearest stable stretch is {from:.3} to {to:.3}."
        ),
        None => format!("{regime} at {at}: no stable one was found."),
    }
}

/// The special points of the 1/1 and 1/2 in one sentence.
fn specials(answer: &Answer) -> String {
    let located: Vec<String> = answer
        .special_points
        .iter()
        .filter(|p| {
            let first = |name| matches!(name, Name::Branch { number: 1, .. });
            first(p.branch) && p.impacts == 1 && p.periods <= 2
        })
        .map(|p| {
            let kind = p.special.label();
            format!("{} {kind} at {:.4}", p.branch, p.frequency_ratio)
        })
        .collect();
    if located.is_empty() {
        return "No special point was found on the 1/1 and the 1/2.".to_owned();
    }
    format!("Located: {}.", located.join("; "))
}

/// The range of the Peterka map, figure 3.24: gap, mm, and drive frequency, Hz.
const MAP_GAPS_MM: (f64, f64) = (0.0, 3.56);
const MAP_FREQUENCIES_HZ: (f64, f64) = (1.41, 7.28);

/// Lines of special points of the 1/1 over the regimes of the Peterka map, wires.
///
/// # Errors
/// If a motion cannot be followed or a picture cannot be drawn.
pub fn over_the_map(effort: Effort, progress: &Progress) -> Result<Vec<Page>, UserError> {
    const FIGURE: &str = "orbits over the map";
    let (gaps, frequencies, lines_at, starts) = match effort {
        Effort::Full => (179, 148, 90, 24),
        Effort::Coarse => (7, 8, 5, 6),
    };
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
    let name = stem(FIGURE);
    let picture = map_figure(&regimes, (gaps, frequencies), &lines);
    let mut files = drawn(&name, &picture)?;
    files.push((format!("{name}.csv"), to_csv(&rows)));
    Ok(vec![Page {
        figure: FIGURE,
        title: "Wires: special points of the 1/1 over the Peterka map".to_owned(),
        chapter: "Figure 3.24 shows the regimes and not what bounds them; figure 3.26 their force.",
        found: lines_found(&rows, &lines),
        command: "host-sim orbits --rig wires --curves --cart prescribed".to_owned(),
        files,
    }])
}

fn map_figure(regimes: &[String], (gaps, frequencies): (usize, usize), lines: &[Line]) -> Figure {
    let x = edges(MAP_GAPS_MM.0, MAP_GAPS_MM.1, gaps);
    let y = edges(MAP_FREQUENCIES_HZ.0, MAP_FREQUENCIES_HZ.1, frequencies);
    let mut panel = Panel::new(
        Axis::new("gap, mm").fixed(x.0, x.1),
        Axis::new("drive frequency, Hz").fixed(y.0, y.1),
    );
    let areas = regime_raster(x, y, gaps, regimes);
    panel.items.push(Item::Raster(areas));
    panel.items.extend(pictures::orbits::line_items(lines));
    Figure::new("Wires: where the 1/1 doubles, folds and grazes, over the Peterka map")
        .subtitle("Areas: what simulations from rest settle on. Lines: special points of the 1/1 orbits, stable or not, followed at each gap.")
        .size(1100, 820)
        .panel(panel)
}

/// The special points at 0.0 mm, and from where to where each line goes.
fn lines_found(rows: &[SpecialRow], lines: &[Line]) -> String {
    let zero = rows.iter().filter(|r| r.gap_mm == 0.0);
    let zero = zero.map(|r| format!("{} at {:.3} Hz", r.special.label(), r.frequency_hz));
    let end = |node: &Node| {
        format!(
            "{:?} mm {:.3} Hz",
            tidy(node.gap_m * 1e3),
            node.orbit.frequency_hz
        )
    };
    let reach = lines.iter().filter(|l| l.nodes.len() > 2).map(|l| {
        let (first, last) = (&l.nodes[0], &l.nodes[l.nodes.len() - 1]);
        format!("{} from {} to {}", l.special.label(), end(first), end(last))
    });
    let list = |items: Vec<String>, separator: &str| match items.as_slice() {
        [] => "none".to_owned(),
        items => items.join(separator),
    };
    format!(
        "At 0.0 mm: {}. Lines: {}.",
        list(zero.collect(), ", "),
        list(reach.collect(), "; ")
    )
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
