//! The Peterka maps, figures 3.24–3.26 (wires) and 3.46–3.51 (beams), how similar those of the beams are, and where the
//! switch model differs.

use std::sync::{Arc, Mutex, PoisonError};

use serde::Serialize;
use shared::model::regime::Regime;

use super::map_force::by_force;
use super::section::SHOWN;
use super::{Effort, Page, stem};
use crate::pictures;
use crate::pictures::drawn;
use crate::progress::ProgressLine;
use crate::words;
use files::UserError;
use numerics::NamedRig;
use numerics::engine::Setting;
use numerics::lanes::CellPlan;
use numerics::map::request::{chapter_frequencies_hz, chapter_gaps_mm};
use numerics::map::{
    Agreement, Grid, Map, MapRequest, MapSummary, RegimeShare, Runner, run, similarity,
};
use numerics::row::Outcome;
use numerics::sweep::{Direction, spread};

/// The region the chapter calls unstable: Ω/ω and gap/A0 of the details.
const DETAIL: ((f64, f64), (f64, f64)) = ((1.5, 2.6), (1.2, 4.0));

/// Figures 3.24, 3.25 and 3.26.
///
/// # Errors
/// If a motion cannot be followed or a picture cannot be drawn.
pub fn wires(effort: Effort, progress: &ProgressLine) -> Result<Vec<Page>, UserError> {
    let map = effort_map("wires", effort, progress)?;
    let command = "host-sim map --rig wires --cart prescribed --out out";
    Ok(vec![
        with_cells("3.24", "Wires: Peterka map".to_owned(), command, &map)?,
        measured(&map)?,
        by_force("3.26", &map, command)?,
    ])
}

/// Figures of a beam rig's map, the rig, and the two points (Ω/ω, gap/A0) whose basins the chapter shows.
type BeamMap = (&'static str, &'static str, &'static str, [(f64, f64); 2]);

/// Figures 3.46 to 3.51, and how similar the three maps are.
///
/// # Errors
/// If a motion cannot be followed or a picture cannot be drawn.
pub fn beams(effort: Effort, progress: &ProgressLine) -> Result<Vec<Page>, UserError> {
    const FIGURES: [BeamMap; 3] = [
        ("3.46", "3.47", "beam-170", [(1.80, 1.60), (2.20, 1.50)]),
        ("3.48", "3.49", "beam-150", [(1.80, 1.74), (2.10, 1.40)]),
        ("3.50", "3.51", "beam-135", [(2.15, 1.60), (2.25, 1.50)]),
    ];
    let (mut pages, mut maps) = (Vec::new(), Vec::new());
    for (regimes, force, rig, basins) in FIGURES {
        let map = effort_map(rig, effort, progress)?;
        let fine = detail_map(rig, effort, progress)?;
        let named = basins.map(|(ratio, gap)| (ratio, gap, format!("basin {ratio:.2}, {gap:.2}")));
        let detail = pictures::map::detail(&fine, DETAIL.0, DETAIL.1, &named);
        let command = format!("host-sim map --rig {rig} --cart prescribed --out out");
        let title = format!("{rig}: Peterka map, and its detail between 1/1 and 1/2");
        let mut page = with_cells(regimes, title, &command, &map)?;
        let name = format!("{}-detail", stem(regimes));
        page.files.extend(drawn(&name, &detail)?);
        pages.push(page);
        pages.push(by_force(force, &map, &command)?);
        maps.push(map);
    }
    pages.push(alike(&maps)?);
    Ok(pages)
}

/// The page "map by the switch model".
///
/// # Errors
/// If a motion cannot be followed or a picture cannot be drawn.
pub fn switch_model(effort: Effort, progress: &ProgressLine) -> Result<Vec<Page>, UserError> {
    let (rows, columns, cycles) = effort.of((16, 28, 100), (3, 4, 30));
    let plan = CellPlan {
        cycles,
        recorded: cycles / 3,
        early: false,
        strobes: 0,
    };
    let rig = NamedRig::preset("wires")?;
    let ends = |values: Vec<f64>, count: usize| spread(values[0], values[values.len() - 1], count);
    let grid = Grid {
        gaps_mm: ends(chapter_gaps_mm(&rig.params), rows),
        frequencies_hz: ends(chapter_frequencies_hz(&rig.params), columns),
    };
    let by = |runner| {
        let request = request(rig.clone(), grid.clone(), plan, runner);
        run(&request, progress)
    };
    let exact = by(Runner::Reference)?;
    let switch = by(Runner::Switch(Setting::corrected_f32(5e-5)))?;
    let agreement = Agreement::of(exact.cells.iter().zip(&switch.cells));
    let page = Page::new(
        "switch-map",
        "Where the switch model (f32, 50 µs, as on the microcontroller) and the reference disagree",
        "host-sim map --rig wires --cart prescribed --against switch --out out",
        &pictures::map::differences(&exact, &switch, "the switch model (f32, 50 µs)"),
    )?;
    let note = format!(
        "Wires, {} cells of {cycles} cycles: {}.",
        exact.cells.len(),
        words::map::agreement(&agreement)
    );
    let page = page.table("-exact", &exact.rows().collect::<Vec<_>>());
    let page = page.table("-switch", &switch.rows().collect::<Vec<_>>());
    Ok(vec![page.noted(note)])
}

fn request(rig: NamedRig, grid: Grid, plan: CellPlan, runner: Runner) -> MapRequest {
    MapRequest {
        rig,
        grid,
        runner,
        plan,
        settle: None,
        from: Direction::Rest,
    }
}

const COARSE: CellPlan = CellPlan {
    cycles: 60,
    recorded: 30,
    ..CellPlan::CHAPTER
};

/// The chapter's map of a rig, of every `step`-th gap and frequency.
///
/// # Errors
/// If a motion cannot be followed.
pub fn chapter_map(
    name: &str,
    step: usize,
    progress: &ProgressLine,
) -> Result<Arc<Map>, UserError> {
    map_of(name, step, CellPlan::CHAPTER, progress)
}

fn effort_map(name: &str, effort: Effort, progress: &ProgressLine) -> Result<Arc<Map>, UserError> {
    let (step, plan) = effort.of((1, CellPlan::CHAPTER), (24, COARSE));
    map_of(name, step, plan, progress)
}

/// The maps that were made: pages and statements ask for the same ones.
static MADE: Mutex<Vec<(MapRequest, Arc<Map>)>> = Mutex::new(Vec::new());

fn map_of(
    name: &str,
    step: usize,
    plan: CellPlan,
    progress: &ProgressLine,
) -> Result<Arc<Map>, UserError> {
    let rig = NamedRig::preset(name)?;
    let (gaps, hz) = (
        chapter_gaps_mm(&rig.params),
        chapter_frequencies_hz(&rig.params),
    );
    let grid = Grid {
        gaps_mm: gaps.into_iter().step_by(step).collect(),
        frequencies_hz: hz.into_iter().step_by(step).collect(),
    };
    let request = request(rig, grid, plan, Runner::Lanes);
    let made = || MADE.lock().unwrap_or_else(PoisonError::into_inner);
    let known = made().iter().find(|(r, _)| *r == request).cloned();
    if let Some((_, map)) = known {
        return Ok(map);
    }
    let map = Arc::new(run(&request, progress)?);
    made().push((request, Arc::clone(&map)));
    Ok(map)
}

fn detail_map(name: &str, effort: Effort, progress: &ProgressLine) -> Result<Map, UserError> {
    let rig = NamedRig::preset(name)?;
    let ((from, to), (low, high)) = DETAIL;
    let (columns, rows, plan) = effort.of((441, 281, CellPlan::CHAPTER), (12, 8, COARSE));
    let natural_hz = rig.params.natural_frequency_hz();
    let amplitude_mm = rig.params.amplitude_m * 1e3;
    let grid = Grid {
        gaps_mm: spread(low * amplitude_mm, high * amplitude_mm, rows),
        frequencies_hz: spread(from * natural_hz, to * natural_hz, columns),
    };
    Ok(run(&request(rig, grid, plan, Runner::Lanes), progress)?)
}

/// How many cells show a regime.
#[derive(Serialize)]
struct Count {
    regime: Outcome,
    cells: usize,
    share_percent: f64,
}

fn counts(map: &Map) -> Vec<Count> {
    let shares = MapSummary::of(map).regimes.into_iter();
    let count = |share: RegimeShare| Count {
        regime: share.regime,
        cells: share.cells,
        share_percent: 100.0 * share.cells as f64 / map.cells.len() as f64,
    };
    shares.map(count).collect()
}

/// The page of a map by its regimes: the picture, the number of cells of each regime, and every cell.
fn with_cells(
    figure: &'static str,
    title: String,
    command: &str,
    map: &Map,
) -> Result<Page, UserError> {
    let page = Page::new(figure, title, command, &pictures::map::regimes(map))?;
    let rows: Vec<_> = map.rows().collect();
    Ok(page.table("-regimes", &counts(map)).table("-cells", &rows))
}

/// Of the cells above 1.5 A0 between the upper end of 1/1 and Ω/ω = 2 (the chapter's "instability region"), those that
/// end without contact, %.
pub fn silent_after_one_one(map: &Map) -> f64 {
    let (ratios, gaps) = (map.frequency_ratios(), map.gap_ratios());
    let up_to = ratios.partition_point(|ratio| *ratio < 2.0);
    let (mut silent, mut cells) = (0u32, 0u32);
    for row in (0..gaps.len()).filter(|i| gaps[*i] > 1.5) {
        let last = (0..up_to).rfind(|j| map.cell(row, *j).regime.is(1, 1));
        for j in last.map_or(up_to, |j| j + 1)..up_to {
            cells += 1;
            silent += u32::from(map.cell(row, j).regime == Regime::None);
        }
    }
    100.0 * f64::from(silent) / f64::from(cells.max(1))
}

/// How often neighbours in frequency differ in regime between 1/1 and 1/2, %: above and below 1.5 A0.
pub fn unrest_shares(map: &Map) -> [f64; 2] {
    let (ratios, gaps) = (map.frequency_ratios(), map.gap_ratios());
    let ((from, to), _) = DETAIL;
    [true, false].map(|above| {
        let (mut differ, mut pairs) = (0u32, 0u32);
        for row in (0..gaps.len()).filter(|i| (gaps[*i] > 1.5) == above) {
            for j in (1..ratios.len()).filter(|j| (from..=to).contains(&ratios[*j])) {
                let [a, b] = [j - 1, j].map(|j| map.cell(row, j).regime);
                pairs += 1;
                differ += u32::from(!numerics::map::agree::same_label(a, b));
            }
        }
        100.0 * f64::from(differ) / f64::from(pairs.max(1))
    })
}

/// Figure 3.25, with the points that the chapter names.
fn measured(map: &Map) -> Result<Page, UserError> {
    let natural_hz = map.rig.params.natural_frequency_hz();
    let named = SHOWN.iter().filter_map(|(_, gap_mm, ratio, said)| {
        let (impacts, periods) = said.regime()?;
        let regime = Regime::Periodic { impacts, periods };
        Some((*gap_mm, ratio * natural_hz, regime))
    });
    let seen: Vec<_> = named.collect();
    let mut page = Page::new(
        "3.25",
        "Wires: Peterka map with the chapter's measured operating points",
        "host-sim map --rig wires --cart prescribed --measured figure-3-25.csv --out out",
        &pictures::map::with_points(map, &seen),
    )?;
    let mut table = String::from("gap_mm,frequency_hz,regime\n");
    for (gap, hz, regime) in seen {
        table += &format!("{gap},{hz},{regime}\n");
    }
    let name = format!("{}.csv", stem("3.25"));
    page.files.push((name, table.into_bytes()));
    Ok(page.noted("No table of measured points is public. Drawn are the points whose regime the chapter's text names (figures 3.17, 3.18, 3.19 and 3.21). Your own: --measured FILE.csv.".to_owned()))
}

/// The three beams side by side.
fn alike(maps: &[Arc<Map>]) -> Result<Page, UserError> {
    let mut found = Vec::new();
    for (i, a) in maps.iter().enumerate() {
        found.extend(maps[i + 1..].iter().map(|b| similarity(a, b)));
    }
    let lines: Vec<String> = found.iter().map(words::map::similarity).collect();
    let text = format!("{}.", lines.join("; "));
    let maps: Vec<&Map> = maps.iter().map(Arc::as_ref).collect();
    let mut page = Page::new(
        "beams-alike",
        "The three beams' maps side by side, over Ω/ω and gap/A0",
        "host-sim map --beams --cart prescribed --out out",
        &pictures::map::side_by_side(&maps, &text),
    )?;
    page.files.push((
        format!("{}.json", stem("beams-alike")),
        serde_json::to_vec_pretty(&found).unwrap_or_default(),
    ));
    Ok(page.noted(text))
}
