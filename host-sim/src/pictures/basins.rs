//! Pictures of basins: impact / no impact in the chapter's colours, and by attractor.

use crate::pictures::regimes::regime_color;
use numerics::CartModel;
use numerics::basins::{AttractorKind, Basins, Fate, ImpactAfter};
use plot::{Axis, Bar, Color, Figure, Item, Panel, Raster};

/// Colours of starts with and without impact, as the chapter has them.
const IMPACT: Color = Color::BLUE;
const NO_IMPACT: Color = Color::RED;
/// Colour of the attractor without contact.
const STILL: Color = Color(0xD9, 0xD9, 0xD9);
/// Attractors that are named; the smaller ones share a colour.
const NAMED: usize = 9;
/// Attractors with less of the grid than this are not named.
const SMALLEST: f64 = 1e-3;
/// Colours of attractors whose regime has none of its own, or whose regime's is taken.
const MORE: [Color; 8] = [
    Color::SKY,
    Color(0xF0, 0xE4, 0x42),
    Color(0x00, 0x3F, 0x5C),
    Color(0x8A, 0x5F, 0x00),
    Color(0x00, 0x5F, 0x46),
    Color(0x7B, 0x3F, 0x61),
    Color(0x9A, 0xD4, 0xB8),
    Color(0xF4, 0xB8, 0x9A),
];

/// The name and colour of every attractor of `basins`: those that are small share one.
fn styles(basins: &Basins) -> Vec<(String, Color)> {
    let mut more = MORE.into_iter();
    let mut taken = Vec::new();
    let mut named = 0;
    let all = (0_u16..).zip(&basins.attractors);
    all.map(|(number, attractor)| {
        let (share, _) = basins.grid_share(|_, which| which == number);
        if named >= NAMED || share < SMALLEST {
            return ("other".to_owned(), Color::INK);
        }
        named += 1;
        let own = match attractor.name.kind {
            AttractorKind::Failed => Some(Color::PAPER),
            AttractorKind::NoImpact => Some(STILL),
            AttractorKind::Unsettled => Some(regime_color("unsettled")),
            AttractorKind::Aperiodic => Some(regime_color("aperiodic")),
            AttractorKind::Chatter { .. } => Some(regime_color("chatter")),
            AttractorKind::Periodic { impacts, periods } => {
                let styled = matches!((impacts, periods), (1, 1) | (1, 2) | (2, 2));
                styled.then(|| regime_color(&format!("{impacts}/{periods}")))
            }
        };
        let free = own.filter(|color| !taken.contains(color));
        let color = free.or_else(|| more.next()).unwrap_or(Color::INK);
        taken.push(color);
        (format!("{}: {:.1} %", attractor.name, 100.0 * share), color)
    })
    .collect()
}

fn panel(basins: &Basins, title: String, names: &[(String, Color)], cells: &[usize]) -> Panel {
    let cells: Vec<_> = cells.iter().map(|k| Some(*k)).collect();
    let raster = |x, v, columns| Raster::categories(x, v, columns, names, &cells);
    over_starts(basins, raster).titled(title)
}

/// What `raster` makes of the ends of displacement (mm) and velocity (m/s) and the number of columns.
fn over_starts(
    basins: &Basins,
    raster: impl FnOnce((f64, f64), (f64, f64), usize) -> Raster,
) -> Panel {
    let window = &basins.query.window;
    let [x0, x1] = window.displacement_m.map(|x| x * 1e3);
    let [v0, v1] = window.velocity_m_per_s;
    Panel::new(
        Axis::new("displacement at the start, mm").fixed(x0, x1),
        Axis::new("velocity at the start, m/s").fixed(v0, v1),
    )
    .item(Item::raster(raster((x0, x1), (v0, v1), window.columns)))
}

/// Impact in blue, no impact in red.
pub fn impact_panel(basins: &Basins, title: impl Into<String>) -> Panel {
    let (share, _) = basins.grid_share(|fate, _| fate.impacts());
    let names = [
        (
            format!("no impact: {:.1} %", 100.0 * (1.0 - share)),
            NO_IMPACT,
        ),
        (format!("impact: {:.1} %", 100.0 * share), IMPACT),
    ];
    let cells: Vec<_> = basins
        .grid
        .iter()
        .map(|f| usize::from(f.impacts()))
        .collect();
    panel(basins, title.into(), &names, &cells)
}

/// By attractor, with their shares of the grid.
pub fn attractor_panel(basins: &Basins, title: impl Into<String>) -> Panel {
    let styles = styles(basins);
    let mut names: Vec<(String, Color)> = Vec::new();
    for style in &styles {
        if !names.contains(style) {
            names.push(style.clone());
        }
    }
    let kind = |which: &u16| {
        let style = &styles[usize::from(*which)];
        names.iter().position(|name| name == style).unwrap_or(0)
    };
    let cells: Vec<_> = basins.which.iter().map(kind).collect();
    panel(basins, title.into(), &names, &cells)
}

/// Rig, drive and start phase in a line.
pub fn caption(basins: &Basins) -> String {
    let s = &basins.query;
    let params = &s.rig.params;
    let cart = CartModel::of(params).words();
    format!(
        "{}, {cart}: Ω/ω = {:.3} ({:.4} Hz), gap = {:.3} A0 ({:.3} mm), released at drive phase {} turns",
        s.rig.name,
        s.frequency_hz / params.natural_frequency_hz(),
        s.frequency_hz,
        params.gap_m / params.amplitude_m,
        params.gap_m * 1e3,
        s.phase
    )
}

/// The drive cycle of the last contact of each start. It shows how the share of impact depends on the number of cycles.
fn last_contact_panel(basins: &Basins) -> Panel {
    let cycles = basins.query.cycles;
    // Those that have settled on contacts go on for ever, wherever their run was stopped.
    let last = basins.grid.iter().map(|fate| {
        let cut = if fate.touches_after(cycles) {
            cycles
        } else {
            fate.last_contact.unwrap_or(0)
        };
        f64::from(cut)
    });
    let bar = Bar::new("cycle of the last contact", 0.0, f64::from(cycles));
    cycle_panel(basins, &last.collect::<Vec<_>>(), bar).titled("how long it strikes")
}

/// The drive cycle from which the motion of each start repeats; empty where it does not.
fn settling_panel(basins: &Basins) -> Panel {
    let settled = |fate: &Fate| fate.settled_after.map_or(f64::NAN, f64::from);
    let values: Vec<f64> = basins.grid.iter().map(settled).collect();
    let latest = values.iter().copied().fold(1.0, f64::max);
    let bar = Bar::new("cycle from which it repeats", 0.0, latest);
    cycle_panel(basins, &values, bar).titled("every start strikes to the end: how soon it repeats")
}

/// A number of drive cycles for each start.
fn cycle_panel(basins: &Basins, values: &[f64], bar: Bar) -> Panel {
    over_starts(basins, |x, v, columns| {
        Raster::values(x, v, columns, values, bar)
    })
}

/// Share of impact among the random starts over the number of cycles.
fn looks_panel(basins: &Basins) -> Panel {
    let over_cycles = &basins.over_cycles;
    let line = |value: fn(&ImpactAfter) -> f64| {
        let points = over_cycles.iter();
        points
            .map(|l| (f64::from(l.cycles), 100.0 * value(l)))
            .collect::<Vec<_>>()
    };
    let of = over_cycles.first().map_or(0, |l| l.impact.of);
    Panel::new(
        Axis::new("drive cycles since the start").with_zero(),
        Axis::new("impact, % of the random starts").fixed(0.0, 105.0),
    )
    .titled(format!("{of} random starts, run on"))
    .item(Item::line("impact", IMPACT, line(|l| l.impact.value())))
    .item(Item::dashed("95 %", Color::GREY, line(|l| l.impact.low)))
    .item(Item::dashed("", Color::GREY, line(|l| l.impact.high)))
}

/// Both pictures side by side; below, the cycle of the last contact of each start (how soon each repeats, if all strike to
/// the end), and the share of impact over the number of cycles.
pub fn figure(basins: &Basins) -> Figure {
    let query = &basins.query;
    let strikes_on = |fate: &Fate| fate.touches_after(query.cycles);
    let below = if basins.grid.iter().all(strikes_on) {
        settling_panel(basins)
    } else {
        last_contact_panel(basins)
    };
    let figure = Figure::new(format!("Basins of attraction, {}", query.rig.name))
        .subtitle(format!(
            "{}. Impact: a contact in the last {} of {} drive cycles. {} by {} starts.",
            caption(basins),
            query.recorded,
            query.cycles,
            query.window.columns,
            query.window.rows
        ))
        .columns(2)
        .size(1400, 1300)
        .panel(impact_panel(basins, "impact / no impact"))
        .panel(attractor_panel(basins, "by attractor"))
        .panel(below);
    if basins.over_cycles.is_empty() {
        figure
    } else {
        figure.panel(looks_panel(basins))
    }
}

/// A page's picture: for every one of `parts` impact / no impact, and below it by attractor.
pub fn parts(title: impl Into<String>, parts: &[(String, Basins)]) -> Figure {
    let mut figure = Figure::new(title)
        .columns(parts.len().max(1))
        .size(1400, 1300);
    if let Some((_, first)) = parts.first() {
        let query = &first.query;
        figure = figure.subtitle(format!(
            "Above: impact (a contact in the last {} of {} drive cycles) or none, as the chapter; below: by attractor. {} by {} starts each, released at drive phase {} turns.",
            query.recorded, query.cycles, query.window.columns, query.window.rows, query.phase
        ));
    }
    for (name, basins) in parts {
        figure = figure.panel(impact_panel(basins, name.clone()));
    }
    for (name, basins) in parts {
        figure = figure.panel(attractor_panel(basins, format!("{name}, by attractor")));
    }
    figure
}
