//! Bifurcation diagrams: figures 3.27–3.35 (wires, whole and in detail) and 3.43–3.45 (beams).

use shared::model::params::RigParams;

use super::section::rig;
use super::{Effort, Page};
use crate::pictures::bifurcation::{Abscissa, VerticalQuantity, View, figure, panel};
use crate::progress::ProgressLine;
use files::UserError;
use numerics::NamedRig;
use numerics::bifurcation::{BifurcationDiagram, DiagramRequest, diagrams, rows};
use numerics::engine::Engine;
use numerics::lanes::CellPlan;
use numerics::lyapunov;
use numerics::row::kind;
use numerics::sweep::{Direction, spread};
use plot::Figure;
use shared::model::regime::Regime;

/// Frequencies of the chapter's range on a rig, Hz: Ω/ω as 1.41 to 7.28 Hz on the wires.
fn range(params: &RigParams, count: usize) -> Vec<f64> {
    let natural = params.natural_frequency_hz();
    spread(1.41 / 1.82 * natural, 7.28 / 1.82 * natural, count)
}

fn plan(effort: Effort) -> CellPlan {
    match effort {
        Effort::Full => CellPlan {
            strobes: 100,
            ..CellPlan::CHAPTER
        },
        Effort::Coarse => CellPlan {
            cycles: 100,
            recorded: 40,
            early: true,
            strobes: 40,
        },
    }
}

fn compute(
    effort: Effort,
    rig: &NamedRig,
    gaps_mm: &[f64],
    frequencies_hz: Vec<f64>,
    directions: &[Direction],
    progress: &ProgressLine,
) -> Result<Vec<BifurcationDiagram>, UserError> {
    let request = DiagramRequest {
        rig: rig.clone(),
        gaps_mm: gaps_mm.to_vec(),
        frequencies_hz,
        directions: directions.to_vec(),
        engine: Engine::Event,
        plan: plan(effort),
        locate: effort == Effort::Full,
    };
    Ok(diagrams(&request, progress)?)
}

/// Lowest and highest Ω/ω of the first unbroken run of `regime` above `from` (Ω/ω) that lasts for at least three
/// frequencies.
fn band(diagram: &BifurcationDiagram, regime: Regime, from: f64) -> Option<(f64, f64)> {
    let runs = diagram
        .stations
        .chunk_by(|a, b| kind(a.row.regime) == kind(b.row.regime));
    let run = runs
        .into_iter()
        .find(|r| r.len() >= 3 && r[0].row.regime == regime && r[0].row.frequency_ratio > from)?;
    Some((
        run[0].row.frequency_ratio,
        run[run.len() - 1].row.frequency_ratio,
    ))
}

/// The detail about the end of the 1/1.
struct Detail {
    diagram: BifurcationDiagram,
    /// Its range of Ω/ω.
    range: (f64, f64),
    /// Distance of two neighbouring frequencies, Ω/ω.
    step: f64,
}

/// Three figures of the wires at a gap: the whole diagram, and details of displacement and force about the end of the 1/1.
///
/// # Errors
/// If a motion cannot be followed or a picture cannot be drawn; with the presets neither happens.
pub fn wires(
    gap_mm: f64,
    numbers: [&'static str; 3],
    effort: Effort,
    progress: &ProgressLine,
) -> Result<Vec<Page>, UserError> {
    let rig = rig("wires", gap_mm)?;
    let count = effort.of(588, 60);
    let whole = compute(
        effort,
        &rig,
        &[gap_mm],
        range(&rig.params, count),
        &[Direction::Rest, Direction::Up, Direction::Down],
        progress,
    )?;
    let of = |impacts, periods| Regime::Periodic { impacts, periods };
    let first = band(&whole[0], of(1, 1), 0.0);
    let second = band(&whole[0], of(1, 2), first.map_or(0.0, |b| b.1));
    let from = first.map_or(1.0, |b| b.1) - 0.1;
    let to = second
        .map_or(from + 0.8, |b| b.0 + 0.15)
        .clamp(from + 0.3, from + 1.4);
    let detail = detail(effort, &rig, gap_mm, (from, to), progress)?;
    wires_pages(gap_mm, numbers, &whole, &detail)
}

fn detail(
    effort: Effort,
    rig: &NamedRig,
    gap_mm: f64,
    (from, to): (f64, f64),
    progress: &ProgressLine,
) -> Result<Detail, UserError> {
    let count = effort.of(400, 30);
    let natural = rig.params.natural_frequency_hz();
    let near = spread(from * natural, to * natural, count);
    let diagrams = compute(effort, rig, &[gap_mm], near, &[Direction::Rest], progress)?;
    let [diagram] = <[BifurcationDiagram; 1]>::try_from(diagrams)
        .map_err(|_| UserError::new("one gap and one direction gave no single diagram"))?;
    Ok(Detail {
        diagram,
        range: (from, to),
        step: (to - from) / (count - 1) as f64,
    })
}

fn wires_pages(
    gap: f64,
    numbers: [&'static str; 3],
    whole: &[BifurcationDiagram],
    detail: &Detail,
) -> Result<Vec<Page>, UserError> {
    let page = |k: usize, title: &str, command: &str, picture: &Figure| {
        let title = format!("Wires, {gap:?} mm: {title}");
        Page::new(numbers[k], title, command, picture)
    };
    let (from, to) = detail.range;
    let command = format!("host-sim bifurcation --rig wires --cart prescribed --gap {gap:?}");
    let zoom_command = format!("{command} --ratio {from:.4}:{to:.4}:{:.5}", detail.step);
    let zoomed = |k: usize, title: &str, quantity| {
        let page = page(k, title, &zoom_command, &zoom(detail, gap, quantity))?;
        let table = rows(std::slice::from_ref(&detail.diagram));
        Ok::<_, UserError>(page.table("", &table))
    };
    let lean: Vec<_> = whole.iter().collect();
    let first = page(
        0,
        "bifurcation diagrams of displacement and force",
        &format!("{command} --direction all"),
        &figure(&lean, Abscissa::Ratio, None),
    )?;
    Ok(vec![
        first.table("", &rows(whole)),
        zoomed(1, "displacement, detail", VerticalQuantity::Displacement)?,
        zoomed(2, "impact force, detail", VerticalQuantity::Force)?,
    ])
}

fn zoom(detail: &Detail, gap: f64, quantity: VerticalQuantity) -> Figure {
    let view = View {
        quantity,
        abscissa: Abscissa::Ratio,
        range: Some(detail.range),
        measured: None,
        marks: quantity == VerticalQuantity::Displacement,
    };
    Figure::new(format!(
        "wires, gap {gap:?} mm: detail about the end of the 1/1"
    ))
    .subtitle("Section at drive phase 0, each frequency from rest.")
    .size(1200, 620)
    .panel(panel(&[&detail.diagram], view))
}

/// Where something does not repeat (Ω/ω), what its exponent says, and the largest exponent per drive period.
pub type Chaos = (f64, &'static str, f64);

/// From rest on the wires: Ω/ω at the end of the first 1/1; and of the motions up to 1.0 above it that do not repeat, the
/// one with the largest exponent of six.
///
/// # Errors
/// If a motion cannot be followed; with the presets none is.
pub fn end_and_chaos(
    gap_mm: f64,
    progress: &ProgressLine,
) -> Result<(f64, Option<Chaos>), UserError> {
    const TRIED: usize = 6;
    let rig = rig("wires", gap_mm)?;
    let hz = range(&rig.params, 588);
    let full = Effort::Full;
    let diagrams = compute(full, &rig, &[gap_mm], hz, &[Direction::Rest], progress)?;
    let diagram = diagrams
        .first()
        .ok_or_else(|| UserError::new("a diagram that was asked for was not made"))?;
    let one_one = Regime::Periodic {
        impacts: 1,
        periods: 1,
    };
    let end = band(diagram, one_one, 0.0).map_or(0.0, |band| band.1);
    let wild = diagram.stations.iter().filter(|s| {
        let above = s.row.frequency_ratio - end;
        (0.0..1.0).contains(&above) && matches!(s.row.regime, Regime::Aperiodic { .. })
    });
    let wild: Vec<_> = wild.collect();
    let mut most: Option<Chaos> = None;
    for station in wild.iter().step_by(wild.len().div_ceil(TRIED).max(1)) {
        let plan = lyapunov::LyapunovSpan {
            transient: 100,
            periods: 1000,
        };
        let hz = station.row.frequency_hz;
        let found = lyapunov::exponents(&diagram.params, hz, station.end, plan)?;
        let exponent = found.largest_per_period;
        if most.is_none_or(|(.., largest)| exponent > largest) {
            most = Some((station.row.frequency_ratio, found.meaning(), exponent));
        }
    }
    Ok((end, most))
}

/// Figures 3.43 to 3.45.
///
/// # Errors
/// If a motion cannot be followed or a picture cannot be drawn; with the presets neither happens.
pub fn beams(effort: Effort, progress: &ProgressLine) -> Result<Vec<Page>, UserError> {
    const GAPS_MM: [f64; 3] = [0.0, 1.0, 3.0];
    let count = effort.of(588, 40);
    let named = [
        ("3.43", "beam-170"),
        ("3.44", "beam-150"),
        ("3.45", "beam-135"),
    ];
    let page = |(number, name): (&'static str, &str)| {
        let rig = rig(name, 0.0)?;
        let hz = range(&rig.params, count);
        let found = compute(effort, &rig, &GAPS_MM, hz, &[Direction::Rest], progress)?;
        let mut figure = Figure::new(format!("{name}: bifurcation diagrams of the displacement"))
            .subtitle("Section at drive phase 0, each frequency from rest. One bending mode.")
            .size(1200, 1180);
        for (letter, diagram) in ["a", "b", "c"].into_iter().zip(&found) {
            let view = View {
                quantity: VerticalQuantity::Displacement,
                abscissa: Abscissa::Ratio,
                range: None,
                measured: None,
                marks: true,
            };
            let title = format!("{letter}) gap {:?} mm", diagram.gap_mm);
            figure = figure.panel(panel(&[diagram], view).without_legend().titled(title));
        }
        let page = Page::new(
            number,
            format!("{name}: bifurcation diagrams of the displacement, gaps 0.0, 1.0 and 3.0 mm"),
            format!("host-sim bifurcation --rig {name} --cart prescribed --gap 0 --gap 1 --gap 3"),
            &figure,
        )?;
        Ok(page.table("", &rows(&found)))
    };
    named.into_iter().map(page).collect()
}
