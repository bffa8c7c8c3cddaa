//! Doublings, folds and grazes over two parameters.

use std::collections::BTreeSet;

use super::regimes::regime_color;
use numerics::continuation::two::table::CurvesAnswer;
use numerics::continuation::two::{Codimension, Condition, Plane, Scale};
use plot::{Axis, Color, Figure, Item, Mark, Panel, Stroke};

/// The second parameter across, the first upwards.
pub fn figure(rig: &str, plane: &Plane, answer: &CurvesAnswer) -> Figure {
    let axis = |k: usize| {
        let dimension = plane.dimensions[k];
        let axis = Axis::new(dimension.varied.name());
        match dimension.scale {
            Scale::Log(_) => axis.log(),
            Scale::Even(_) => axis.fixed(dimension.range.0, dimension.range.1),
        }
    };
    let mut panel = Panel::new(axis(1), axis(0));
    let mut named = BTreeSet::new();
    for curve in &answer.curves {
        let rows = answer.points.iter().filter(|p| p.curve == curve.curve);
        let points: Vec<(f64, f64)> = rows.map(|p| (p.value_2, p.value_1)).collect();
        let regime = format!("{}/{}", curve.impacts, curve.periods);
        let (label, color) = match (curve.condition, curve.impacts) {
            (Condition::Grazing, 0) => (
                "first touch of a motion without contact".into(),
                Color::GREY,
            ),
            (Condition::Grazing, _) => {
                (format!("{regime} touches once more"), regime_color(&regime))
            }
            (condition, _) => (
                format!("{regime} {}", condition.label()),
                regime_color(&regime),
            ),
        };
        let (stroke, width) = match curve.condition {
            Condition::PeriodDoubling => (Stroke::Solid, 2.2),
            Condition::Fold => (Stroke::Dashed, 2.2),
            Condition::Grazing => (Stroke::Dotted, 1.8),
        };
        let first = named.insert(label.clone());
        let label = if first { label } else { String::new() };
        let item = Item::curve(label, color, (stroke, width), points);
        panel.items.push(item);
    }
    for (kind, mark) in MARKS {
        let rows = answer.codimension_two.iter();
        let rows = rows.filter(|p| p.codimension_two == Some(kind));
        let points: Vec<(f64, f64)> = rows.map(|p| (p.value_2, p.value_1)).collect();
        if !points.is_empty() {
            let item = Item::marks(kind.label(), Color::INK, (mark, 4.0), points);
            panel.items.push(item);
        }
    }
    Figure::new(format!(
        "{rig}, {}: period doublings, folds and grazes over {} and {}",
        answer.cart.words(),
        answer.parameter_1,
        answer.parameter_2
    ))
    .subtitle(
        "Each line is one continuation in both parameters. The orbits on it may be stable or not.",
    )
    .size(1000, 760)
    .panel(panel)
}

const MARKS: [(Codimension, Mark); 7] = [
    (Codimension::Cusp, Mark::Diamond),
    (Codimension::FoldDoubling, Mark::Plus),
    (Codimension::Resonance, Mark::Cross),
    (Codimension::FoldGraze, Mark::Square),
    (Codimension::DoublingGraze, Mark::Triangle),
    (Codimension::DoubleGraze, Mark::Ring),
    (Codimension::PressedGraze, Mark::Circle),
];
