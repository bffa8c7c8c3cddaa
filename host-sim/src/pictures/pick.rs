//! The picture of a pick: force curve, band, doubling and choice.

use crate::pictures::regimes::{OTHER_PERIODIC, regime_points, regime_rings};
use files::words::digits::Digits;
use files::words::pick::{at_stroke, other_cart, why};
use numerics::CartModel;
use numerics::pick::Pick;
use numerics::row::{Outcome, RunRow};
use plot::{Axis, Color, Figure, Item, Panel, Point};
use shared::model::regime::Regime;

const CURVE: Color = Color(0x1f, 0x4e, 0x79);

/// What the marks on the curve are.
pub const MARKS: &str = "Marks: sweep up; rings: sweep down; by regime.";

/// One panel per rig.
pub fn figure(picks: &[Pick]) -> Figure {
    let title = match picks {
        [one] => format!(
            "{}: run at {} Hz (gap {:?} mm)",
            one.answer.rig,
            Digits::of(&one.answer).run_at(&one.answer),
            one.answer.gap_mm
        ),
        _ => "At which frequency to run the hammer".to_owned(),
    };
    let subtitle = match picks {
        [one] => {
            let cart = match one.answer.cart {
                CartModel::Recoil => "The cart recoils",
                CartModel::Prescribed => "The cart is prescribed",
            };
            let why = why(&one.answer);
            let stroke = at_stroke(&one.answer);
            format!("{stroke}{why} {cart}. {MARKS}")
        }
        _ => {
            let over = match picks.iter().any(|pick| pick.answer.uncertainty.is_some()) {
                true => " that holds over the stated uncertainty",
                false => " of the nominal rigs",
            };
            format!("Contact force over drive frequency: the strongest stable 1/1{over}. {MARKS}")
        }
    };
    let columns = if picks.len() > 1 { 2 } else { 1 };
    let size = if picks.len() > 1 {
        (1400, 1000)
    } else {
        (1000, 640)
    };
    let mut figure = Figure::new(title)
        .subtitle(subtitle)
        .columns(columns)
        .size(size.0, size.1);
    for pick in picks {
        let one = panel(pick);
        figure = figure.panel(if picks.len() > 1 {
            let a = &pick.answer;
            one.titled(format!(
                "{}, gap {:?} mm, {}: {} Hz",
                a.rig,
                a.gap_mm,
                a.cart.words(),
                Digits::of(a).run_at(a)
            ))
        } else {
            one
        });
    }
    figure
}

fn panel(pick: &Pick) -> Panel {
    let answer = &pick.answer;
    let digits = Digits::of(answer);
    let (low, high) = (answer.safe_band_hz[0], answer.safe_band_hz[1]);
    let natural = answer.operating_frequency_hz / answer.frequency_ratio;
    let force = "contact force over the hammer's weight, F/(m g)";
    let mut panel =
        Panel::new("drive frequency, Hz", Axis::new(force).with_zero()).item(Item::band_x(
            format!("safe band {} Hz", digits.band([low, high])),
            low,
            high,
        ));
    if !pick.force_range.is_empty() {
        let over = "force over the uncertainty, all rigs in 1/1";
        panel = panel.item(Item::between(over, CURVE, &pick.force_range));
    }
    panel = panel.item(Item::line(
        "stable 1/1, followed as an orbit",
        CURVE,
        pick.curve.clone(),
    ));
    let placed = |row| -> (&RunRow, Point) { (row, (row.frequency_hz, row.force_ratio)) };
    let [up, down] = [&pick.up, &pick.down].map(|rows| rows.iter().map(placed));
    panel.items.extend(by_regime(up, regime_points));
    panel.items.extend(by_regime(down, regime_rings));
    let at_natural = answer.force_ratio_at_natural_frequency;
    panel = panel
        .item(Item::mark_x("natural frequency", natural))
        .item(Item::mark_point(
            format!("{at_natural:.1} at the natural frequency"),
            natural,
            at_natural,
        ));
    panel = match answer.period_doubling_hz {
        Some(hz) => panel.item(Item::mark_x("period doubling", hz)),
        None => panel.item(Item::mark_x(
            "end of stable 1/1",
            answer.stable_one_one_hz[1],
        )),
    };
    if let Some(other) = other_cart(answer) {
        let label = format!("{:.1} {}", other.force_ratio, other.what);
        panel = panel.item(Item::mark_point(label, other.hz, other.force_ratio));
    }
    panel.item(Item::mark_point(
        format!(
            "{} Hz: {:.*} N",
            digits.run_at(answer),
            digits.force_n,
            answer.force_n
        ),
        answer.operating_frequency_hz,
        answer.force_ratio,
    ))
}

/// The name of a regime in a legend. The rarer periodic ones share a name, so that the legend stays short.
fn legend(outcome: Outcome) -> String {
    match outcome {
        Outcome::Regime(Regime::Periodic {
            impacts: 1 | 2,
            periods: 1 | 2,
        }) => outcome.to_string(),
        Outcome::Regime(Regime::Periodic { .. }) => OTHER_PERIODIC.to_owned(),
        _ => outcome.to_string(),
    }
}

/// An `item` for each regime, in order of first appearance, of rows that did not fail and their places.
pub fn by_regime<'a>(
    rows: impl Iterator<Item = (&'a RunRow, Point)>,
    item: fn(&str, Vec<Point>) -> Item,
) -> Vec<Item> {
    let known = rows.filter(|(row, _)| !row.failed);
    grouped(known.map(|(row, point)| (legend(row.outcome), point)), item)
}

/// Points as one item for each label, in the order in which the labels come.
pub fn grouped(
    points: impl Iterator<Item = (String, Point)>,
    item: fn(&str, Vec<Point>) -> Item,
) -> Vec<Item> {
    let mut groups: Vec<(String, Vec<Point>)> = Vec::new();
    for (label, point) in points {
        match groups.iter_mut().find(|(known, _)| *known == label) {
            Some((_, points)) => points.push(point),
            None => groups.push((label, vec![point])),
        }
    }
    let groups = groups.into_iter();
    groups.map(|(label, points)| item(&label, points)).collect()
}
