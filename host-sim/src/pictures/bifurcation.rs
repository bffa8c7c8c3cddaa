//! Pictures of bifurcation diagrams.

use numerics::CartModel;
use numerics::bifurcation::measured::MeasuredDiagram;
use numerics::bifurcation::{BifurcationDiagram, ChangeKind, DiagramPoint};
use numerics::sweep::Direction;
use plot::{Axis, Color, Figure, Item, Mark, Panel, Shape};

/// The quantity on the vertical axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VerticalQuantity {
    /// Displacement at drive phase 0, mm.
    Displacement,
    /// Largest contact force per drive period over m g.
    Force,
}

/// The quantity on the horizontal axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Abscissa {
    /// Drive frequency over the natural frequency, Ω/ω.
    Ratio,
    /// Drive frequency, Hz.
    Frequency,
}

impl Abscissa {
    fn label(self) -> &'static str {
        match self {
            Self::Ratio => "drive frequency over natural frequency, Ω/ω",
            Self::Frequency => "drive frequency, Hz",
        }
    }
}

/// How a panel is drawn.
#[derive(Clone, Copy, Debug)]
pub struct View<'a> {
    /// The quantity on the vertical axis.
    pub quantity: VerticalQuantity,
    /// The quantity on the horizontal axis.
    pub abscissa: Abscissa,
    /// The part of the horizontal axis shown, in its unit; none: all.
    pub range: Option<(f64, f64)>,
    /// Measured points, drawn over the diagram.
    pub measured: Option<&'a MeasuredDiagram>,
    /// Whether lasting changes are named above the plot.
    pub marks: bool,
}

/// More names than this above a plot would overlap; the changes beyond are marked without a name.
const MOST_NAMES: usize = 8;

/// Side of a dot, px: later diagrams in smaller dots, so that those below show; larger where frequencies are few.
fn dot(diagram: &BifurcationDiagram, k: usize, alone: bool) -> f64 {
    let few = if diagram.stations.len() < 150 {
        2.6
    } else {
        1.5
    };
    few * match k {
        0 if alone => 1.25,
        0 => 2.5,
        1 => 1.75,
        _ => 1.0,
    }
}

fn color(direction: Direction) -> Color {
    match direction {
        Direction::Rest => Color::SKY,
        Direction::Up => Color::RED,
        Direction::Down => Color::INK,
    }
}

fn way(direction: Direction) -> &'static str {
    match direction {
        Direction::Rest => "from rest",
        Direction::Up => "carried up",
        Direction::Down => "carried down",
    }
}

/// One panel over `diagrams` of one gap, the first at the bottom. One alone is dark blue.
pub fn panel(diagrams: &[&BifurcationDiagram], view: View) -> Panel {
    let label = match view.quantity {
        VerticalQuantity::Displacement => "displacement, mm",
        VerticalQuantity::Force => "force over weight, F/(m g)",
    };
    let mut x = Axis::new(view.abscissa.label());
    if let Some((from, to)) = view.range {
        x = x.fixed(from, to);
    }
    let mut y = Axis::new(label);
    // Where a motion has periods without contact, the axis leaves room below them.
    let silent = |d: &&BifurcationDiagram| {
        d.stations
            .iter()
            .flat_map(|s| &s.points)
            .any(|p| p.force_n == 0.0)
    };
    if view.quantity == VerticalQuantity::Force && !diagrams.iter().any(silent) {
        y = y.with_zero();
    }
    let mut panel = Panel::new(x, y);
    for (k, diagram) in diagrams.iter().enumerate() {
        let label = way(diagram.direction);
        let color = match diagrams.len() {
            1 => Color::BLUE,
            _ => color(diagram.direction),
        };
        let cloud = Shape::Cloud {
            points: points(diagram, view),
            dot: dot(diagram, k, diagrams.len() == 1),
        };
        panel = panel.item(Item::new(label, color, cloud));
    }
    if let (Some(measured), Some(first)) = (view.measured, diagrams.first()) {
        panel = panel.item(measured_points(measured, first, view));
    }
    if view.marks {
        for (x, words) in marks(diagrams, view) {
            panel = panel.item(Item::mark_x(words, x));
        }
    }
    panel
}

/// The points of a diagram inside the shown range, so that the other axis fits them.
fn points(diagram: &BifurcationDiagram, view: View) -> Vec<(f64, f64)> {
    let weight = diagram.params.weight_n();
    let y = |p: &DiagramPoint| match view.quantity {
        VerticalQuantity::Displacement => p.displacement_mm,
        VerticalQuantity::Force => p.force_n / weight,
    };
    let mut points = Vec::new();
    for station in &diagram.stations {
        let x = match view.abscissa {
            Abscissa::Ratio => station.row.frequency_ratio,
            Abscissa::Frequency => station.row.frequency_hz,
        };
        if view.range.is_none_or(|(a, b)| (a..=b).contains(&x)) {
            points.extend(station.points.iter().map(|p| (x, y(p))));
        }
    }
    points
}

fn measured_points(measured: &MeasuredDiagram, diagram: &BifurcationDiagram, view: View) -> Item {
    let natural = diagram.params.natural_frequency_hz();
    let weight = diagram.params.weight_n();
    let (from, scale) = match view.quantity {
        VerticalQuantity::Displacement => (&measured.displacement_mm, 1.0),
        VerticalQuantity::Force => (&measured.force_n, weight),
    };
    let unit = match view.abscissa {
        Abscissa::Ratio => natural,
        Abscissa::Frequency => 1.0,
    };
    let points = from.iter().map(|(hz, y)| (hz / unit, y / scale)).collect();
    let label = if from.is_empty() { "" } else { "measured" };
    Item::marks(label, Color::INK, (Mark::Ring, 2.0), points)
}

/// Place and name of the lasting changes of the first diagram.
fn marks(diagrams: &[&BifurcationDiagram], view: View) -> Vec<(f64, String)> {
    let Some(diagram) = diagrams.first() else {
        return Vec::new();
    };
    let lasting = diagram.changes.iter().filter(|c| c.lasting);
    let place = lasting.map(|c| {
        let x = match view.abscissa {
            Abscissa::Ratio => c.frequency_ratio,
            Abscissa::Frequency => c.frequency_hz,
        };
        match c.kind {
            ChangeKind::Jump => (x, format!("{} jumps", c.below)),
            _ => (x, format!("{} to {}", c.below, c.above)),
        }
    });
    let shown = place.filter(|(x, _)| view.range.is_none_or(|(a, b)| (a..=b).contains(x)));
    let named = |(i, (x, name)): (usize, (f64, String))| match i {
        0..MOST_NAMES => (x, name),
        _ => (x, String::new()),
    };
    shown.enumerate().map(named).collect()
}

/// Displacement over force for one gap, with all its directions.
pub fn figure(
    diagrams: &[&BifurcationDiagram],
    abscissa: Abscissa,
    measured: Option<&MeasuredDiagram>,
) -> Figure {
    let view = |quantity| View {
        quantity,
        abscissa,
        range: None,
        measured,
        marks: quantity == VerticalQuantity::Displacement,
    };
    let title = diagrams.first().map_or(String::new(), |d| {
        let rig = d.stations.first().map_or("", |s| s.row.rig.as_str());
        let cart = CartModel::of(&d.params).words();
        format!("{rig}, gap {:?} mm, {cart}: bifurcation diagram", d.gap_mm)
    });
    let ways: Vec<_> = diagrams.iter().map(|d| way(d.direction)).collect();
    let marked = ways.first().copied().unwrap_or_default();
    let cart = diagrams.first().map(|d| CartModel::of(&d.params));
    let displacement = match cart {
        Some(CartModel::Recoil) => "displacement relative to the cart",
        _ => "where the displacement in the fixed frame is that relative to the cart",
    };
    Figure::new(title)
        .subtitle(format!(
            "Section at drive phase 0, {displacement}; largest contact force of each drive period. Each frequency {}. Dashed lines: the regime changes and stays changed ({marked}). A band of displacements without force is the hammer swinging free of the surface.",
            ways.join(", ")
        ))
        .size(1200, 980)
        .panel(panel(diagrams, view(VerticalQuantity::Displacement)).titled("Displacement"))
        .panel(panel(diagrams, view(VerticalQuantity::Force)).titled("Contact force"))
}
