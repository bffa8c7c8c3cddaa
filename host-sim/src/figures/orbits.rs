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
use numerics::continuation::table::{Answer, BranchRow, Name, line_rows};
use numerics::continuation::{Along, OrbitsRequest, curves, diagram};
use numerics::lanes::{self, Cell, CellPlan};
use numerics::row::tidy;
use plot::{Axis, Figure, Item, Panel, edges};

/// A gap of the chapter's diagrams and what it says of it.
struct Diagrammed {
    figure: &'static str,
    gap_mm: f64,
    chapter: &'static str,
    /// Regimes the chapter names at ratios Ω/ω.
    named: &'static [(&'static str, f64)],
}

const GAPS: [Diagrammed; 3] = [
    Diagrammed {
        figure: "orbits at 0.0 mm",
        gap_mm: 0.0,
        chapter: "Figure 3.27: several contacts per cycle below a ratio of about 1.16, then 1/1, whose bifurcation (called a pitchfork) is seen at 2.7, then 1/2, seen at 3.8.",
        named: &[("1/1", 1.5), ("2/2", 2.7), ("1/2", 3.8)],
    },
    Diagrammed {
        figure: "orbits at 1.0 mm",
        gap_mm: 1.0,
        chapter: "Figure 3.30: 1/1 at 1.5, 1/2 at 3.3; chaos between the bands.",
        named: &[("1/1", 1.5), ("1/2", 3.3)],
    },
    Diagrammed {
        figure: "orbits at 2.4 mm",
        gap_mm: 2.4,
        chapter: "Figure 3.33: 1/1 at 1.2 and 1.4, 1/2 at 2.7; larger gaps jump.",
        named: &[("1/1", 1.2), ("1/1", 1.4), ("1/2", 2.7)],
    },
];

/// Orbits over the diagrams of the wires at 0.0, 1.0 and 2.4 mm.
///
/// # Errors
/// As the engine's.
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
    let claims = gap
        .named
        .iter()
        .map(|(regime, at)| claim(&answer, regime, *at));
    let claims: Vec<String> = claims.chain([specials(&answer)]).collect();
    Ok(Page {
        figure: gap.figure,
        title: format!(
            "Wires, gap {:?} mm: periodic orbits, stable and unstable, over the bifurcation diagram",
            gap.gap_mm
        ),
        chapter: gap.chapter,
        found: claims.join(" "),
        command: format!("host-sim orbits --rig wires --gap {:?}", gap.gap_mm),
        files,
    })
}

/// Whether there is a stable orbit of `regime` at the ratio `at`, and from where to where.
fn claim(answer: &Answer, regime: &str, at: f64) -> String {
    let of = |b: &&BranchRow| format!("{}/{}", b.impacts, b.periods) == regime;
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
    let told: Vec<String> = answer
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
    if told.is_empty() {
        return "No special point was found on the 1/1 and the 1/2.".to_owned();
    }
    format!("Located: {}.", told.join("; "))
}

/// Lines of special points of the 1/1 over the regimes of the Peterka map, wires.
///
/// # Errors
/// As the engine's.
pub fn over_the_map(effort: Effort, progress: &Progress) -> Result<Vec<Page>, UserError> {
    const FIGURE: &str = "orbits over the map";
    let (gaps, frequencies, lines_at, starts) = match effort {
        Effort::Full => (179, 148, 90, 24),
        Effort::Coarse => (7, 8, 5, 6),
    };
    let (gap_mm, hz) = ((0.0, 3.56), (1.41, 7.28));
    let along = |(from, to): (f64, f64), count: usize| numerics::sweep::spread(from, to, count);
    let (columns, rows) = (along(gap_mm, gaps), along(hz, frequencies));
    let regimes = regimes(&columns, &rows)?;
    progress.inc(1);
    let natural_hz = WIRES.natural_frequency_hz();
    let gaps_m: Vec<f64> = along(gap_mm, lines_at).iter().map(|mm| mm * 1e-3).collect();
    let ratios = (hz.0 / natural_hz, hz.1 / natural_hz);
    let quiet = Progress::new("", 1, true);
    let lines = curves::lines(&WIRES, &gaps_m, ratios, starts, &quiet)?;
    progress.inc(1);
    let told = line_rows(&WIRES, &lines);

    let x = edges(gap_mm.0, gap_mm.1, gaps);
    let y = edges(hz.0, hz.1, frequencies);
    let mut panel = Panel::new(
        Axis::new("gap, mm").fixed(x.0, x.1),
        Axis::new("drive frequency, Hz").fixed(y.0, y.1),
    );
    panel
        .items
        .push(Item::Raster(regime_raster(x, y, gaps, regimes)));
    panel.items.extend(pictures::orbits::line_items(&lines));
    let figure = Figure::new("Wires: where the 1/1 doubles, folds and grazes, over the Peterka map")
        .subtitle("Areas: what simulations from rest settle on. Lines: special points of the 1/1 orbits, stable or not, followed at each gap.")
        .size(1100, 820)
        .panel(panel);
    let name = stem(FIGURE);
    let mut files = drawn(&name, &figure)?;
    files.push((format!("{name}.csv"), to_csv(&told)));
    let zero = told.iter().filter(|r| r.gap_mm == 0.0);
    let zero: Vec<String> = zero
        .map(|r| format!("{} at {:.3} Hz", r.special.label(), r.frequency_hz))
        .collect();
    let reach: Vec<String> = lines
        .iter()
        .filter(|l| l.nodes.len() > 2)
        .map(|l| {
            let end = |n: &numerics::continuation::Node| {
                format!(
                    "{:?} mm {:.3} Hz",
                    tidy(n.gap_m * 1e3),
                    n.orbit.frequency_hz
                )
            };
            let (first, last) = (&l.nodes[0], &l.nodes[l.nodes.len() - 1]);
            format!("{} from {} to {}", l.special.label(), end(first), end(last))
        })
        .collect();
    Ok(vec![Page {
        figure: FIGURE,
        title: "Wires: special points of the 1/1 over the Peterka map".to_owned(),
        chapter: "Figure 3.24 shows the regimes and not what bounds them; figure 3.26 their force.",
        found: format!(
            "At 0.0 mm: {}. Lines: {}.",
            if zero.is_empty() {
                "none".to_owned()
            } else {
                zero.join(", ")
            },
            if reach.is_empty() {
                "none".to_owned()
            } else {
                reach.join("; ")
            }
        ),
        command: "host-sim orbits --rig wires --curves".to_owned(),
        files,
    }])
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
