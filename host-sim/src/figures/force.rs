//! Force over frequency, figures 3.12–3.14 (wires) and 3.40–3.42 (beams): the largest force at each frequency, from
//! rest, and carried up and down, which shows the jumps.

use serde::Serialize;
use shared::model::params::{RigParams, preset};
use shared::model::rig::Rig;

use super::{Effort, Page, stem};
use crate::pictures::drawn;
use crate::progress::Progress;
use files::UserError;
use files::table::to_csv;
use numerics::engine::Start;
use numerics::lanes::{self, Cell, Outcome, Plan};
use numerics::row::regime_as_text;
use numerics::row::{Row, tidy};
use numerics::sweep::{jumps, spread};
use plot::{Axis, Color, Figure, Item, Panel, regime_group};
use shared::model::regime::Regime;

/// Up and down count as different when their forces differ by more than this share.
const JUMP_SHARE: f64 = 0.1;

/// Sweeps of one rig at one gap: from rest, up and down.
struct Curve {
    rig: &'static str,
    params: RigParams,
    rest: Vec<Row>,
    up: Vec<Row>,
    down: Vec<Row>,
}

/// Figures 3.12, 3.13 and 3.14.
///
/// # Errors
/// If a motion cannot be followed or a picture cannot be drawn.
pub fn wires(effort: Effort, progress: &Progress) -> Result<Vec<Page>, UserError> {
    const GAPS_MM: [f64; 3] = [0.0, 1.0, 2.4];
    const SAYS: [&str; 3] = [
        "Measured and computed force agree at 0.0 mm, and the bands seen on the rig can be told from the computed curve. Force at the natural frequency is about 3 times below the largest (said of figure 3.26). No jump.",
        "Measured and computed force agree at 1.0 mm. Gaps other than 0.0 mm are known to jump.",
        "Measured and computed force agree at 2.4 mm. Larger gaps jump.",
    ];
    let curves = curves(&["wires"], &GAPS_MM, (0.6, 5.0), effort, progress)?;
    let figures = ["3.12", "3.13", "3.14"];
    let pages = figures.iter().zip(SAYS).zip(&curves);
    pages
        .map(|((figure, says), curve)| {
            let title = format!(
                "Wires, gap {:?} mm: force over frequency",
                gap_mm(&curve.params)
            );
            let one = std::slice::from_ref(curve);
            let found = format!("{} No measured force is at hand.", found(curve));
            page(figure, title, says, found, one)
        })
        .collect()
}

/// Figures 3.40, 3.41 and 3.42.
///
/// # Errors
/// If a motion cannot be followed or a picture cannot be drawn.
pub fn beams(effort: Effort, progress: &Progress) -> Result<Vec<Page>, UserError> {
    const RIGS: [&str; 3] = ["beam-170", "beam-150", "beam-135"];
    const SAYS: [&str; 3] = [
        "170 mm: the computation meets the largest measured force and, at 3.0 mm, the jump; at 1.0 mm measurement and computation agree less, since the measured force did not lie between those of 0.0 and 3.0 mm as expected.",
        "150 mm: agreement is best at 1.0 mm; at 0.0 mm it is good up to twice the natural frequency; at 3.0 mm the jump is found 10 % off in frequency.",
        "135 mm: agreement is good up to a ratio of 1.7 at 0.0 and 1.0 mm.",
    ];
    let curves = curves(&RIGS, &[0.0, 1.0, 3.0], (0.6, 4.0), effort, progress)?;
    let figures = ["3.40", "3.41", "3.42"];
    let pages = figures.iter().zip(SAYS).zip(curves.chunks(3));
    pages
        .map(|((figure, says), curves)| {
            let title = format!(
                "{}, gaps 0.0, 1.0 and 3.0 mm: force over frequency",
                curves[0].rig
            );
            let mut found: Vec<String> = curves.iter().map(found).collect();
            found.push(between(curves));
            found.push("No measured force is at hand.".to_owned());
            page(figure, title, says, found.join(" "), curves)
        })
        .collect()
}

/// Every rig at every gap, the gaps of a rig together.
fn curves(
    rigs: &[&'static str],
    gaps_mm: &[f64],
    (from, to): (f64, f64),
    effort: Effort,
    progress: &Progress,
) -> Result<Vec<Curve>, UserError> {
    let (count, plan) = match effort {
        Effort::Full => (441, Plan::CHAPTER),
        Effort::Coarse => (
            12,
            Plan {
                cycles: 60,
                recorded: 20,
                ..Plan::CHAPTER
            },
        ),
    };
    let ratios = spread(from, to, count);
    let mut chains = Vec::new();
    for rig in rigs {
        let known = preset(rig).ok_or_else(|| UserError::new(format!("no rig {rig}")))?;
        for gap in gaps_mm {
            chains.push((
                *rig,
                RigParams {
                    gap_m: gap * 1e-3,
                    ..known
                },
            ));
        }
    }
    let rest = from_rest(&chains, &ratios, &plan, progress)?;
    let carried = carried(&chains, &ratios, &plan, progress)?;
    let all = chains.into_iter().zip(rest).zip(carried);
    Ok(all
        .map(|(((rig, params), rest), (up, down))| Curve {
            rig,
            params,
            rest,
            up,
            down,
        })
        .collect())
}

fn cell(params: &RigParams, ratio: f64) -> Result<Cell, UserError> {
    let frequency_hz = ratio * params.natural_frequency_hz();
    let rig = Rig::<f64>::new(params)?;
    Ok(Cell {
        params: *params,
        frequency_hz,
        start: Start::Rest.section(&rig, std::f64::consts::TAU * frequency_hz)?,
        phase: 0.0,
    })
}

fn row(rig: &str, cell: &Cell, seen: &Outcome) -> Row {
    let params = &cell.params;
    Row {
        rig: rig.to_owned(),
        gap_mm: gap_mm(params),
        frequency_hz: tidy(cell.frequency_hz),
        frequency_ratio: tidy(cell.frequency_hz / params.natural_frequency_hz()),
        impacts: seen.regime.impacts(),
        periods: seen.regime.periods(),
        regime: seen.regime,
        force_ratio: seen.force_n / params.weight_n(),
        force_n: seen.force_n,
        approach_speed_m_per_s: None,
        contact_time_ms: None,
    }
}

type Chain = (&'static str, RigParams);

fn from_rest(
    chains: &[Chain],
    ratios: &[f64],
    plan: &Plan,
    progress: &Progress,
) -> Result<Vec<Vec<Row>>, UserError> {
    let mut curves = Vec::new();
    for (rig, params) in chains {
        let cells = ratios.iter().map(|ratio| cell(params, *ratio));
        let cells = cells.collect::<Result<Vec<_>, _>>()?;
        let seen = lanes::run(&cells, plan)?;
        let rows = cells.iter().zip(&seen).map(|(c, s)| row(rig, c, s));
        curves.push(rows.collect());
        progress.inc(ratios.len() as u64);
    }
    Ok(curves)
}

/// Rows of one chain carried up and carried down, both by rising frequency.
type UpAndDown = (Vec<Row>, Vec<Row>);

/// All chains go side by side, up and down at once, each from where it was left at the last frequency.
fn carried(
    chains: &[Chain],
    ratios: &[f64],
    plan: &Plan,
    progress: &Progress,
) -> Result<Vec<UpAndDown>, UserError> {
    let mut found: Vec<UpAndDown> = vec![(Vec::new(), Vec::new()); chains.len()];
    let mut last: Option<Vec<Outcome>> = None;
    for (up, down) in ratios.iter().zip(ratios.iter().rev()) {
        let both = chains
            .iter()
            .flat_map(|(_, params)| [(params, *up), (params, *down)]);
        let cells = both.map(|(params, ratio)| cell(params, ratio));
        let mut cells = cells.collect::<Result<Vec<_>, _>>()?;
        for (cell, left) in cells.iter_mut().zip(last.iter().flatten()) {
            cell.start = left.section;
        }
        let seen = lanes::run(&cells, plan)?;
        for (k, (rig, _)) in chains.iter().enumerate() {
            found[k].0.push(row(rig, &cells[2 * k], &seen[2 * k]));
            found[k]
                .1
                .push(row(rig, &cells[2 * k + 1], &seen[2 * k + 1]));
        }
        last = Some(seen);
        progress.inc(2 * chains.len() as u64);
    }
    for (_, down) in &mut found {
        down.reverse();
    }
    Ok(found)
}

fn gap_mm(params: &RigParams) -> f64 {
    tidy(params.gap_m * 1e3)
}

/// A row, and which sweep it is from.
#[derive(Serialize)]
struct CurveRow<'a> {
    from: &'static str,
    rig: &'a str,
    gap_mm: f64,
    frequency_hz: f64,
    frequency_ratio: f64,
    #[serde(serialize_with = "regime_as_text")]
    regime: Regime,
    force_ratio: f64,
    force_n: f64,
}

fn page(
    figure: &'static str,
    title: String,
    chapter: &'static str,
    found: String,
    curves: &[Curve],
) -> Result<Page, UserError> {
    let picture = curves.iter().fold(
        Figure::new(title.clone())
            .subtitle("Largest contact force over the hammer's weight. Dots: from rest at each frequency, by regime. Lines: the state carried up and down in frequency.")
            .size(1100, if curves.len() > 1 { 1500 } else { 640 }),
        |picture, curve| picture.panel(panel(curve, curves.len() > 1)),
    );
    let mut files = drawn(&stem(figure), &picture)?;
    let ways = |c: &'_ Curve| {
        let rows_of = |from: &'static str, rows: &[Row]| -> Vec<(&'static str, Row)> {
            rows.iter().map(|r| (from, r.clone())).collect()
        };
        [
            rows_of("rest", &c.rest),
            rows_of("up", &c.up),
            rows_of("down", &c.down),
        ]
        .concat()
    };
    let rows: Vec<_> = curves.iter().flat_map(ways).collect();
    let table: Vec<CurveRow> = rows
        .iter()
        .map(|(from, r)| CurveRow {
            from,
            rig: &r.rig,
            gap_mm: r.gap_mm,
            frequency_hz: r.frequency_hz,
            frequency_ratio: r.frequency_ratio,
            regime: r.regime,
            force_ratio: r.force_ratio,
            force_n: r.force_n,
        })
        .collect();
    files.push((format!("{}.csv", stem(figure)), to_csv(&table)));
    Ok(Page {
        figure,
        title,
        chapter,
        found,
        command: format!("host-sim figures --only {figure} --out figures"),
        files,
    })
}

fn panel(curve: &Curve, titled: bool) -> Panel {
    let at = |r: &Row| (r.frequency_ratio, r.force_ratio);
    let line = |rows: &[Row]| rows.iter().map(at).collect::<Vec<_>>();
    let mut panel = Panel::new(
        Axis::new("drive frequency over natural frequency, Ω/ω"),
        Axis::new("force ratio, F/(m g)").with_zero(),
    )
    .item(Item::line(
        "carried up",
        Color(0x55, 0x55, 0x55),
        line(&curve.up),
    ))
    .item(Item::dashed(
        "carried down",
        Color(0x99, 0x33, 0x33),
        line(&curve.down),
    ));
    let mut groups: Vec<(&str, Vec<(f64, f64)>)> = Vec::new();
    for row in &curve.rest {
        let name = regime_group(&row.regime.to_string());
        match groups.iter_mut().find(|(known, _)| *known == name) {
            Some((_, points)) => points.push(at(row)),
            None => groups.push((name, vec![at(row)])),
        }
    }
    for (name, points) in groups {
        panel = panel.item(small(name, points));
    }
    if titled {
        panel = panel.titled(format!("gap {:?} mm", gap_mm(&curve.params)));
    }
    panel
}

/// Dots of a regime, small enough that a curve stays a curve.
fn small(regime: &str, points: Vec<(f64, f64)>) -> Item {
    match Item::regime_points(regime, points) {
        Item::Points {
            points,
            color,
            label,
            mark,
            ..
        } => Item::Points {
            points,
            color,
            label,
            radius: 2.0,
            mark,
        },
        other => other,
    }
}

/// The strongest 1/1.
fn strongest(rows: &[Row]) -> Option<&Row> {
    let of = rows.iter().filter(|r| r.regime.is(1, 1));
    of.max_by(|a, b| a.force_n.total_cmp(&b.force_n))
}

/// What a curve shows, in numbers.
fn found(curve: &Curve) -> String {
    let mut text = format!("Gap {:?} mm:", gap_mm(&curve.params));
    match strongest(&curve.rest) {
        Some(best) => {
            let ends: Vec<f64> = curve
                .rest
                .iter()
                .filter(|r| r.regime.is(1, 1))
                .map(|r| r.frequency_ratio)
                .collect();
            text += &format!(
                " from rest, 1/1 is met from Ω/ω = {:.2} to {:.2}; the largest 1/1 force is {:.1} m g, at {:.2}.",
                ends[0],
                ends[ends.len() - 1],
                best.force_ratio,
                best.frequency_ratio
            );
            let natural = curve.rest.iter().min_by(|a, b| {
                let off = |r: &Row| (r.frequency_ratio - 1.0).abs();
                off(a).total_cmp(&off(b))
            });
            if let Some(at) = natural.filter(|r| r.force_ratio > 0.0) {
                text += &format!(
                    " At Ω/ω = {:.2} it is {:.1} m g, {:.1} times less.",
                    at.frequency_ratio,
                    at.force_ratio,
                    best.force_ratio / at.force_ratio
                );
            }
        }
        None => text += " from rest, no 1/1 is met.",
    }
    let apart: Vec<f64> = jumps(&curve.up, &curve.down, curve.params.weight_n(), JUMP_SHARE);
    let natural = curve.params.natural_frequency_hz();
    match (apart.first(), apart.last()) {
        (Some(low), Some(high)) => {
            text += &format!(
                " Up and down differ by more than {:.0} % of force at {} of {} frequencies, between {:.2} and {:.2}: the hammer jumps.",
                JUMP_SHARE * 100.0,
                apart.len(),
                curve.up.len(),
                low / natural,
                high / natural
            );
        }
        _ => text += " Up and down agree everywhere: no jump.",
    }
    text
}

/// Whether the largest 1/1 force at the middle gap lies between those of the outer ones.
fn between(curves: &[Curve]) -> String {
    let best: Vec<f64> = curves
        .iter()
        .filter_map(|c| strongest(&c.up).map(|r| r.force_ratio))
        .collect();
    let [a, b, c] = best[..] else {
        return "Not every gap has a 1/1 when carried up.".to_owned();
    };
    let lies = if (a.min(c)..=a.max(c)).contains(&b) {
        "lies between"
    } else {
        "does not lie between"
    };
    format!(
        "Carried up, the largest 1/1 force at 1.0 mm ({b:.1} m g) {lies} those at 0.0 mm ({a:.1}) and 3.0 mm ({c:.1})."
    )
}
