//! Curves of orbits over the diagram that simulations draw, and lines of special points over gap and frequency.

use std::collections::BTreeSet;
use std::f64::consts::TAU;

use shared::model::params::RigParams;
use shared::model::rig::Rig;

use crate::pictures::regimes::regime_color;
use files::UserError;
use numerics::CartModel;
use numerics::continuation::curves::SpecialLine;
use numerics::continuation::family::Node;
use numerics::continuation::table::{motion_at, names, stretches};
use numerics::continuation::{Along, Family, OrbitDiagram, Special};
use numerics::engine::Start;
use numerics::lanes::{self, Cell, CellPlan};
use numerics::orbit::Stability;
use plot::{Axis, Color, Figure, Item, Mark, Panel, Shape, Stroke};

/// Values of simulations at drive phase 0: (parameter, value).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SimulatedPoints {
    /// Displacement at drive phase 0, mm.
    pub displacement_mm: Vec<(f64, f64)>,
    /// Largest contact force of a drive period over m g.
    pub force_ratio: Vec<(f64, f64)>,
}

/// Strobes drawn of each simulation: the last of all cycles, so that no transient is among them.
const PLAN: CellPlan = CellPlan {
    cycles: 400,
    recorded: 60,
    early: false,
    strobes: 60,
};

/// Simulations over the range of `diagram` at `count` values, each from rest and from a push.
///
/// # Errors
/// If a simulation leaves the range that the model describes.
pub fn simulated(diagram: &OrbitDiagram, count: usize) -> Result<SimulatedPoints, UserError> {
    let request = &diagram.request;
    let family = Family::new(&diagram.params, request.along, 1)?;
    let (low, high) = request.limits;
    let mut cells = Vec::new();
    let mut parameters = Vec::new();
    for i in 0..count {
        let parameter = low + (i as f64 + 0.5) / count as f64 * (high - low);
        let (params, frequency_hz) = family.at(parameter);
        let rig = Rig::<f64>::new(&params)?;
        let push = Start::Moving(-6.0 * params.amplitude_m - params.gap_m.abs(), 0.0);
        for start in [Start::Rest, push] {
            parameters.push(parameter);
            cells.push(Cell {
                params,
                frequency_hz,
                start: start.section(&rig, TAU * frequency_hz)?,
                phase: 0.0,
            });
        }
    }
    let outcomes = lanes::run_each(&cells, &PLAN);
    let mut found = SimulatedPoints::default();
    for ((parameter, cell), outcome) in parameters.iter().zip(&cells).zip(outcomes) {
        // One that cannot be followed is not drawn.
        let Some(outcome) = lanes::or_failed(outcome)? else {
            continue;
        };
        let rig = Rig::<f64>::new(&cell.params)?;
        // Of a motion that repeats, one repetition: the strobes before are those on the way there.
        let repeats = outcome.regime.periods().map(usize::from);
        let from = repeats.map_or(0, |n| outcome.strobes.len().saturating_sub(n));
        for strobe in &outcome.strobes[from..] {
            let mm = rig.relative_displacement(strobe.q) * 1e3;
            found.displacement_mm.push((*parameter, mm));
            if strobe.force_n > 0.0 {
                let ratio = strobe.force_n / cell.params.weight_n();
                found.force_ratio.push((*parameter, ratio));
            }
        }
    }
    Ok(found)
}

/// How a special point is marked, and how large: kinds that fall on one place show beside each other.
fn mark(special: Special) -> (Mark, Color, f64) {
    match special {
        Special::PeriodDoubling => (Mark::Diamond, Color::INK, 3.5),
        Special::Fold => (Mark::Square, Color::RED, 4.5),
        Special::GrazingGained => (Mark::Triangle, Color::PURPLE, 5.5),
        Special::GrazingLost => (Mark::Ring, Color(0x5B, 0x2C, 0x83), 8.0),
    }
}

/// Colours of further branches of a regime that has one already: far from those of 1/1, 2/2 and 1/2.
const BRANCHES: [Color; 4] = [
    Color(0x5C, 0x4B, 0x00),
    Color(0xC8, 0x10, 0x2E),
    Color(0xD8, 0x5C, 0xC8),
    Color(0x58, 0x58, 0x58),
];

/// Displacement and force of every curve over the parameter, over the points of simulations.
pub fn figure(rig: &str, diagram: &OrbitDiagram, behind: &SimulatedPoints) -> Figure {
    let (x, place) = match diagram.request.along {
        Along::Frequency => (
            "frequency ratio Ω/ω",
            format!(
                "gap {:?} mm",
                numerics::row::tidy(diagram.params.gap_m * 1e3)
            ),
        ),
        Along::Gap(hz) => (
            "gap over amplitude, gap/A0",
            format!("Ω/ω = {:.4}", hz / diagram.params.natural_frequency_hz()),
        ),
        Along::Rig { knob, .. } => (knob.name(), "one drive frequency".to_owned()),
    };
    let (low, high) = diagram.request.limits;
    let panel = |y: &str| Panel::new(Axis::new(x).fixed(low, high), y);
    let params = &diagram.params;
    let cart = CartModel::of(params).words();
    let weight = params.weight_n();
    let displacement =
        |node: &Node, k: usize| Some(motion_at(params, node, node.orbit.strobes[k]).0);
    let force = |node: &Node, k: usize| {
        let force = node.orbit.period_forces_n[k];
        (force > 0.0).then(|| force / weight)
    };
    let mut panels = [
        panel("displacement at drive phase 0, mm"),
        panel("contact force over weight").without_legend(),
    ];
    let clouds = [&behind.displacement_mm, &behind.force_ratio];
    for (panel, cloud) in panels.iter_mut().zip(clouds) {
        let points = cloud.clone();
        let cloud = Shape::Cloud { points, dot: 1.4 };
        let grey = Color(0xa0, 0xa0, 0xa0);
        panel.items.push(Item::new("simulation", grey, cloud));
    }
    draw(diagram, &mut panels[0], &displacement);
    draw(diagram, &mut panels[1], &force);
    let [top, bottom] = panels;
    Figure::new(format!("{rig}, {place}, {cart}: periodic orbits, stable and unstable"))
        .subtitle(
            "Lines: orbits followed by pseudo-arclength, solid where stable, dashed where not. Dots: simulations from rest and from a push.",
        )
        .size(1100, 900)
        .panel(top)
        .panel(bottom)
}

/// Adds the curves of `diagram` with their special points, as `value` of an orbit and a strobe.
pub fn draw(
    diagram: &OrbitDiagram,
    panel: &mut Panel,
    value: &dyn Fn(&Node, usize) -> Option<f64>,
) {
    let mut named: BTreeSet<String> = BTreeSet::new();
    let mut once = |name: String| {
        if named.insert(name.clone()) {
            name
        } else {
            String::new()
        }
    };
    let mut further = BRANCHES.iter().cycle();
    for (curve, name) in diagram.curves.iter().zip(names(diagram)) {
        let (regime, name) = (curve.regime().to_string(), name.to_string());
        let color = match name == regime {
            true => regime_color(&regime),
            false => *further.next().expect("a cycle has no end"),
        };
        for (nodes, stability) in stretches(&curve.nodes) {
            for k in 0..usize::from(curve.periods()) {
                let at = |n: &Node| (n.parameter(), value(n, k).unwrap_or(f64::NAN));
                let points: Vec<(f64, f64)> = nodes.iter().map(at).collect();
                if points.iter().all(|p| p.1.is_nan()) {
                    continue;
                }
                let (word, stroke, width) = match stability {
                    Stability::Stable => ("stable", Stroke::Solid, 2.2),
                    Stability::Neutral => ("neutral", Stroke::Dotted, 1.4),
                    Stability::Unstable => ("unstable", Stroke::Dashed, 1.4),
                };
                let label = once(format!("{name} {word}"));
                let item = Item::curve(label, color, (stroke, width), points);
                panel.items.push(item);
            }
        }
    }
    for kind in Special::ALL.into_iter().rev() {
        let of = |curve: &numerics::continuation::OrbitCurve| {
            let points = curve.specials().filter(|(_, k)| *k == kind);
            let points = points.flat_map(|(node, _)| {
                let all = 0..node.orbit.strobes.len();
                let at = |k| Some((node.parameter(), value(node, k)?));
                all.filter_map(at).collect::<Vec<_>>()
            });
            points.collect::<Vec<_>>()
        };
        let points: Vec<(f64, f64)> = diagram.curves.iter().flat_map(of).collect();
        if !points.is_empty() {
            let (mark, color, radius) = mark(kind);
            let item = Item::marks(kind.label(), color, (mark, radius), points);
            panel.items.push(item);
        }
    }
}

/// How a line of special points is drawn: by its stroke first, as every colour of the set stands for a regime beneath it.
fn stroke(special: Special) -> (Stroke, Color) {
    match special {
        Special::PeriodDoubling => (Stroke::Solid, Color::INK),
        Special::Fold => (Stroke::Dashed, Color::INK),
        Special::GrazingLost => (Stroke::Dotted, Color::INK),
        Special::GrazingGained => (Stroke::Solid, Color::GREY),
    }
}

/// The lines of special points as items over gap (mm, across) and frequency (Hz, upwards): to be laid over a map.
pub fn line_items(lines: &[SpecialLine]) -> Vec<Item> {
    let mut named: Vec<Special> = Vec::new();
    let mut items = Vec::new();
    // The legend shows a kind by one of its lines, if it has any, rather than by a line of a single point.
    let (long, points): (Vec<&SpecialLine>, Vec<&SpecialLine>) =
        lines.iter().partition(|l| l.nodes.len() > 1);
    for line in long.into_iter().chain(points) {
        let (mark, ..) = mark(line.special);
        let (stroke, color) = stroke(line.special);
        let label = if named.contains(&line.special) {
            String::new()
        } else {
            named.push(line.special);
            line.special.label().to_owned()
        };
        let point = |n: &Node| (n.gap_m * 1e3, n.orbit.frequency_hz);
        let points: Vec<(f64, f64)> = line.nodes.iter().map(point).collect();
        if points.len() > 1 {
            // A light rim keeps the line apart from the areas it crosses.
            let rim = (Stroke::Solid, 4.5);
            items.push(Item::curve("", Color::PAPER, rim, points.clone()));
            items.push(Item::curve(label, color, (stroke, 2.0), points));
        } else {
            items.push(Item::marks(label, color, (mark, 2.5), points));
        }
    }
    items
}

/// The lines on their own.
pub fn lines_figure(rig: &str, params: &RigParams, lines: &[SpecialLine]) -> Figure {
    let mut panel = Panel::new("gap, mm", "drive frequency, Hz");
    panel.items.extend(line_items(lines));
    Figure::new(format!(
        "{rig}, {}: where the 1/1 doubles, folds and grazes",
        CartModel::of(params).words()
    ))
    .subtitle(format!(
        "Special points of the 1/1 orbits, stable or not; natural frequency {:.2} Hz.",
        params.natural_frequency_hz()
    ))
    .size(1000, 720)
    .panel(panel)
}
