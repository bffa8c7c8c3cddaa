//! Force over frequency, figures 3.12–3.14 (wires) and 3.40–3.42 (beams): the largest force at each frequency, from
//! rest, and carried up and down, which shows the jumps.

use serde::Serialize;

use super::force_curves::{Curve, curves, gap_mm};
use super::{Effort, Page, stem};
use crate::pictures::drawn;
use crate::pictures::regimes::{regime_group, regime_points};
use crate::progress::Progress;
use files::UserError;
use files::table::to_csv;
use numerics::row::Row;
use numerics::row::regime_as_text;
use numerics::sweep::jumps;
use plot::{Axis, Color, Figure, Item, Panel};
use shared::model::regime::Regime;

/// Up and down count as different when their forces differ by more than this share.
const JUMP_SHARE: f64 = 0.1;

/// Figures 3.12, 3.13 and 3.14.
///
/// # Errors
/// If a motion cannot be followed or a picture cannot be drawn.
pub fn wires(effort: Effort, progress: &Progress) -> Result<Vec<Page>, UserError> {
    const GAPS_MM: [f64; 3] = [0.0, 1.0, 2.4];
    const SAYS: [&str; 3] = [
        "3.3.4: the computed curve identifies \"the frequency bands observed in the test rig\". 3.3.5: \"satisfactory agreement\". 3.3.6 (figure 3.26): at the natural frequency 3 times smaller than the maximum. 3.5: no jump at 0.0 mm.",
        "3.3.5: \"satisfactory agreement\" with the measurement. 3.3.6: non-zero gaps \"are known to present nonlinear jumps\".",
        "3.3.5: \"satisfactory agreement\" with the measurement. 3.3.6: non-zero gaps \"are known to present nonlinear jumps\".",
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
        "3.4.2, 170 mm: the computation meets the largest measured force and, at 3.0 mm, the jump; at 1.0 mm measurement and computation agree less, since the measured force did not lie between those of 0.0 and 3.0 mm as expected.",
        "3.4.2, 150 mm: agreement is best at 1.0 mm; at 0.0 mm it is good up to twice the natural frequency; at 3.0 mm the jump is found 10 % off in frequency.",
        "3.4.2, 135 mm: agreement is good up to a ratio of 1.7 at 0.0 and 1.0 mm.",
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
        command: format!(
            "host-sim sweep --rig {} --gap {:?} --ratio 0.6:4:0.01 --direction up --cart prescribed",
            curves[0].rig,
            gap_mm(&curves[0].params)
        ),
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
    match regime_points(regime, points) {
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
pub(crate) fn strongest(rows: &[Row]) -> Option<&Row> {
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
