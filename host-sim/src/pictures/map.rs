//! Pictures of maps (figures 3.24–3.26 and 3.46–3.51), over Ω/ω and gap/A0 as the chapter draws them.

use shared::model::regime::Regime;

use crate::pictures::regimes::{regime_color, regime_group, regime_raster};
use files::words::count;
use numerics::CartModel;
use numerics::map::Map;
use numerics::row::Outcome;
use plot::{Bar, Color, Figure, Item, Mark, Panel, Raster, edges};

/// A point drawn over a map: gap (mm), drive frequency (Hz), and the regime seen there.
pub type MeasuredPoint = (f64, f64, Regime);

/// Every regime in its colour (figures 3.24, 3.46a, 3.48a, 3.50a).
pub fn regimes(map: &Map) -> Figure {
    figure(map, "z = p/n over frequency and gap").panel(regime_panel(map))
}

/// The part of a map between two Ω/ω and two gap/A0 (figures 3.46b, 3.48b, 3.50b), with named points ringed.
pub fn detail(
    map: &Map,
    (from, to): (f64, f64),
    (low, high): (f64, f64),
    named: &[(f64, f64, String)],
) -> Figure {
    let mut panel = regime_panel(map);
    panel.x = panel.x.fixed(from, to);
    panel.y = panel.y.fixed(low, high);
    for (ratio, gap, name) in named {
        panel = panel.item(Item::mark_point(name.as_str(), *ratio, *gap));
    }
    figure(map, "z = p/n, detail").panel(panel)
}

/// Only z = 1/1, by its contact force (figures 3.26, 3.47, 3.49, 3.51).
pub fn by_force(map: &Map) -> Figure {
    let ratio = |i: usize| {
        let one_one = map.cells[i].regime.is(1, 1);
        if one_one {
            map.force_ratio(i)
        } else {
            f64::NAN
        }
    };
    let forces: Vec<f64> = (0..map.cells.len()).map(ratio).collect();
    let largest = forces.iter().copied().fold(0.0, f64::max);
    let bar = Bar::new("force ratio of 1/1, F/(m g)", 0.0, largest.max(1.0));
    let (x, y) = frame(map);
    let raster = Raster::values(x, y, map.grid.frequencies_hz.len(), &forces, bar);
    figure(map, "force of z = 1/1").panel(axes().item(Item::raster(raster)))
}

/// The regimes with points of another source over them (figure 3.25), each ringed in black and in its own colour.
pub fn with_points(map: &Map, points: &[MeasuredPoint]) -> Figure {
    let natural_hz = map.rig.params.natural_frequency_hz();
    let amplitude_mm = map.rig.params.amplitude_m * 1e3;
    let at = |p: &MeasuredPoint| (p.1 / natural_hz, p.0 / amplitude_mm);
    let dots = |label: &str, color: Color, radius: f64, points: Vec<(f64, f64)>| {
        Item::marks(label, color, (Mark::Circle, radius), points)
    };
    let all = points.iter().map(at).collect();
    let mut panel = regime_panel(map).item(dots(
        "seen (dot in the colour of what was seen)",
        Color::INK,
        6.0,
        all,
    ));
    for point in points {
        let name = point.2.to_string();
        panel = panel
            .item(dots("", Color::PAPER, 4.6, vec![at(point)]))
            .item(dots("", regime_color(&name), 3.4, vec![at(point)]));
    }
    figure(map, "z = p/n, and what was seen").panel(panel)
}

/// Maps beside one another over the same axes, with a line under the title that says how similar they are.
pub fn side_by_side(maps: &[&Map], alike: &str) -> Figure {
    let figure = Figure::new("Maps of z = p/n side by side, over Ω/ω and gap/A0")
        .subtitle(alike)
        .columns(maps.len().max(1))
        .size(1500, 620);
    maps.iter().fold(figure, |figure, map| {
        figure.panel(regime_panel(map).titled(named(map)))
    })
}

/// How two maps of one grid differ, cell by cell.
const DIFFERENCES: [(&str, Color); 5] = [
    ("same regime, force within 1 %", Color(0xE8, 0xE8, 0xE8)),
    ("same regime, other force", Color::SKY),
    ("both repeat, other p/n", Color::ORANGE),
    ("one repeats", Color::RED),
    ("one strikes, one does not", Color::PURPLE),
];

/// Where `a` and `b` differ, which have the same grid; `other` says what `b` is.
pub fn differences(a: &Map, b: &Map, other: &str) -> Figure {
    let kinds = a.cells.iter().zip(&b.cells).map(|(a, b)| {
        let largest = a.force_n.max(b.force_n);
        // Aperiodic and chattering motions have no count of impacts in their names.
        let same = a.regime.to_string() == b.regime.to_string();
        let kind = match (a.regime, b.regime) {
            _ if a.failed || b.failed => 3,
            (Regime::None, Regime::None) => 0,
            (Regime::None, _) | (_, Regime::None) => 4,
            _ if same && (a.force_n - b.force_n).abs() <= 0.01 * largest => 0,
            _ if same => 1,
            (a, b) if a.periods().is_some() && b.periods().is_some() => 2,
            _ => 3,
        };
        Some(kind)
    });
    let kinds: Vec<_> = kinds.collect();
    let names = DIFFERENCES.map(|(name, color)| (name.to_owned(), color));
    let (x, y) = frame(a);
    let raster = Raster::categories(x, y, a.grid.frequencies_hz.len(), &names, &kinds);
    figure(a, &format!("where {other} differs")).panel(axes().item(Item::raster(raster)))
}

/// Name of the rig and how its cart is moved, for titles.
fn named(map: &Map) -> String {
    let cart = CartModel::of(&map.rig.params).words();
    format!("{}, {cart}", map.rig.name)
}

fn figure(map: &Map, what: &str) -> Figure {
    let hz = &map.grid.frequencies_hz;
    let gaps = &map.grid.gaps_mm;
    let ends = |values: &[f64]| (values.first().copied(), values.last().copied());
    let text = |values: &[f64]| match ends(values) {
        (Some(a), Some(b)) => format!("{a:.2} to {b:.2}"),
        _ => "none".to_owned(),
    };
    Figure::new(format!("{}, {}: {what}", named(map), map.from.words()))
        .subtitle(format!(
            "{} ({} mm) by {} ({} Hz): {}.",
            count(gaps.len(), "gap"),
            text(gaps),
            count(hz.len(), "frequency"),
            text(hz),
            count(map.cells.len(), "simulation")
        ))
        .size(1100, 760)
}

fn axes() -> Panel {
    Panel::new(
        "drive frequency over natural frequency, Ω/ω",
        "gap over cart amplitude, gap/A0",
    )
}

/// Outer edges over Ω/ω and gap/A0.
fn frame(map: &Map) -> ((f64, f64), (f64, f64)) {
    let around = |values: Vec<f64>| match values[..] {
        [first, .., last] => edges(first, last, values.len()),
        [only] => edges(only, only, 1),
        [] => (0.0, 1.0),
    };
    (around(map.frequency_ratios()), around(map.gap_ratios()))
}

fn regime_panel(map: &Map) -> Panel {
    let (x, y) = frame(map);
    // Neighbours are mostly alike: a name is written once for a run of them.
    let mut last: Option<(Outcome, &'static str)> = None;
    let names = map.cells.iter().map(|cell| match (cell.label(), last) {
        (label, Some((before, name))) if before == label => name,
        (label, _) => {
            let name = regime_group(&label.to_string());
            last = Some((label, name));
            name
        }
    });
    let names: Vec<&str> = names.collect();
    let raster = regime_raster(x, y, map.grid.frequencies_hz.len(), names);
    axes().item(Item::raster(raster))
}

#[cfg(test)]
mod tests {
    use super::*;
    use numerics::NamedRig;
    use numerics::map::{Grid, MapCell};
    use numerics::sweep::Direction;
    use plot::render_svg;
    use shared::model::params::WIRES;

    fn map(regimes: &[Regime]) -> Map {
        let cell = |regime: &Regime| MapCell {
            regime: *regime,
            force_n: 30.0,
            failed: false,
            ..MapCell::FAILED
        };
        Map {
            rig: NamedRig::new("wires", WIRES),
            grid: Grid {
                gaps_mm: vec![0.0, 0.89],
                frequencies_hz: vec![1.82, 3.64, 5.46],
            },
            from: Direction::Rest,
            cells: regimes.iter().map(cell).collect(),
        }
    }

    #[test]
    fn axes_are_ratios_and_the_legend_names_what_is_there() {
        let one = Regime::Periodic {
            impacts: 1,
            periods: 1,
        };
        let half = Regime::Periodic {
            impacts: 1,
            periods: 2,
        };
        let map = map(&[one, one, half, one, Regime::None, half]);
        let (x, y) = frame(&map);
        // Three frequencies at 1, 2 and 3 times the natural one, two gaps at 0 and 1 times A0.
        for (found, expected) in [x.0, x.1, y.0, y.1].into_iter().zip([0.5, 3.5, -0.5, 1.5]) {
            assert!((found - expected).abs() < 1e-9, "{found} {expected}");
        }
        let svg = render_svg(&regimes(&map)).unwrap();
        for name in ["1/1", "1/2", "no contact"] {
            assert!(svg.contains(&format!("\n{name}\n")), "{name}");
        }
        assert!(!svg.contains("\n2/2\n"));
        assert!(render_svg(&by_force(&map)).unwrap().contains("F/(m g)"));
        let other = Map {
            cells: map
                .cells
                .iter()
                .map(|c| MapCell {
                    force_n: 31.0,
                    ..*c
                })
                .collect(),
            ..map.clone()
        };
        let svg = render_svg(&differences(&map, &other, "the other")).unwrap();
        assert!(svg.contains("other force") && !svg.contains("one repeats"));
    }
}
