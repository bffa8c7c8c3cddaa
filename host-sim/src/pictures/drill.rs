//! Pictures of drilling: rate of penetration, force and energy over frequency; progress over gap and frequency; the
//! published oscillator's bifurcation diagram.

use numerics::CartModel;
use numerics::drill::published::DriftingRow;
use numerics::drill::{DrillAnswer, DrillRow};
use plot::{Axis, Bar, Color, Figure, Item, Panel, Raster, Stroke, edges};

/// Gaps drawn as curves at most; more are thinned out evenly.
const MOST_CURVES: usize = 6;

/// Rate of penetration, peak force and energy per blow over frequency, a curve for each gap; where the motion recommended
/// drills fastest, and where the fastest of all does.
pub fn curves(rows: &[DrillRow], advice: &DrillAnswer, fastest: &DrillRow) -> Figure {
    let gaps: Vec<&[DrillRow]> = rows.chunk_by(|a, b| a.gap_mm == b.gap_mm).collect();
    let every = gaps.len().div_ceil(MOST_CURVES).max(1);
    let shown = |gap: &&&[DrillRow]| gap[0].gap_mm == advice.gap_mm;
    let mut drawn: Vec<&[DrillRow]> = gaps.iter().step_by(every).copied().collect();
    if !drawn.iter().any(|g| shown(&g)) {
        drawn.extend(gaps.iter().filter(shown));
    }
    let best = &advice.best;
    // `under`: how much thicker each line is than the next, so that it is seen under it where both are the same.
    let panel = |label: &str, under: f64, value: fn(&DrillRow) -> f64| {
        let mut panel = Panel::new("Ω/ω", Axis::new(label).with_zero());
        for (i, gap) in drawn.iter().enumerate() {
            let points = gap.iter().map(|r| (r.frequency_ratio, value(r)));
            let name = format!("gap {:?} mm", gap[0].gap_mm);
            let solid = (Stroke::Solid, 1.6 + under * (drawn.len() - 1 - i) as f64);
            panel = panel.item(Item::curve(name, Color::series(i), solid, points.collect()));
        }
        let panel = if fastest == best {
            panel.item(Item::mark_x("fastest of all", best.frequency_ratio))
        } else {
            let name = format!("fastest {}", best.regime);
            let panel = panel.item(Item::mark_x(name, best.frequency_ratio));
            panel.item(Item::mark_x("fastest of all", fastest.frequency_ratio))
        };
        match advice.rigid_frequency_ratio {
            Some(ratio) => panel.item(Item::mark_x("hardest on a surface that stays", ratio)),
            None => panel,
        }
    };
    let of_all = match fastest == best {
        true => String::new(),
        false => format!(
            "; of all: {:.1} µm/s ({}) at Ω/ω {:.3}, gap {:?} mm",
            fastest.rate_of_penetration_um_per_s,
            fastest.regime,
            fastest.frequency_ratio,
            fastest.gap_mm
        ),
    };
    // A curve that is the threshold throughout shows nothing.
    let differs = |r: &DrillRow| (r.force_n / r.threshold_n - 1.0).abs() > 1e-3;
    let forces = drawn.iter().any(|gap| gap.iter().any(differs));
    let peak = match forces {
        true => "",
        false => " Every blow reaches the threshold and no more.",
    };
    let figure = Figure::new(format!(
        "{}: rate of penetration, ground that gives way at {:?} N",
        best.rig, best.threshold_n
    ))
    .subtitle(format!(
        "Ground {:e} N/m, {:?} N·s/m{}; the feed restores the gap, the cart {}. Fastest {}: {:.1} µm/s at Ω/ω {:.3}, gap {:?} mm{}.{peak}",
        best.ground_stiffness_n_per_m,
        best.ground_damping_n_s_per_m,
        bit(best),
        moves(best),
        best.regime,
        best.rate_of_penetration_um_per_s,
        best.frequency_ratio,
        best.gap_mm,
        of_all
    ))
    .size(1000, if forces { 1150 } else { 800 })
    .panel(panel("rate of penetration, µm/s", 0.0, |r| r.rate_of_penetration_um_per_s));
    let figure = match forces {
        true => figure.panel(
            panel("peak contact force, N", 1.4, |r| r.force_n)
                .titled(format!(
                    "The ground gives way at {:?} N, and no force passes it; where it is less, nothing is drilled",
                    best.threshold_n
                ))
                .without_legend(),
        ),
        false => figure,
    };
    figure.panel(
        panel("energy per blow, mJ", 0.0, |r| {
            r.energy_per_blow_mj.unwrap_or(f64::NAN)
        })
        .without_legend(),
    )
}

/// The bit, if there is one.
fn bit(row: &DrillRow) -> String {
    row.bit_mass_kg
        .map_or(String::new(), |kg| format!(", a bit of {kg:?} kg"))
}

/// What the cart does.
fn moves(row: &DrillRow) -> &'static str {
    match row.cart {
        CartModel::Recoil => "recoils",
        CartModel::Prescribed => "moves as prescribed",
    }
}

/// Progress per cycle over frequency and gap.
pub fn map(rows: &[DrillRow]) -> Figure {
    let gaps: Vec<f64> = rows
        .chunk_by(|a, b| a.gap_mm == b.gap_mm)
        .map(|g| g[0].gap_mm)
        .collect();
    let columns = rows.len() / gaps.len().max(1);
    let ends = |first: Option<f64>, last: Option<f64>, count| {
        edges(first.unwrap_or(0.0), last.unwrap_or(1.0), count)
    };
    let ratio = |row: Option<&DrillRow>| row.map(|r| r.frequency_ratio);
    let x = ends(ratio(rows.first()), ratio(rows.last()), columns);
    let y = ends(gaps.first().copied(), gaps.last().copied(), gaps.len());
    let values: Vec<f64> = rows.iter().map(|r| r.progress_per_cycle_um).collect();
    let largest = values.iter().copied().fold(0.0, f64::max);
    let bar = Bar::new("progress per cycle, µm", 0.0, largest.max(1e-3));
    let raster = Raster::values(x, y, columns, &values, bar);
    let title = rows.first().map_or(String::new(), |r| {
        format!(
            "{}: progress per cycle, ground that gives way at {:?} N",
            r.rig, r.threshold_n
        )
    });
    Figure::new(title)
        .subtitle(format!(
            "Each cell from rest{}; the feed restores the gap, the cart {}.",
            rows.first().map_or(String::new(), bit),
            rows.first().map_or("moves", moves)
        ))
        .size(1000, 640)
        .panel(Panel::new("Ω/ω", "gap, mm").item(Item::raster(raster)))
}

/// The published oscillator over its static force: section and progress.
pub fn drifting(rows: &[DriftingRow]) -> Figure {
    let subtitle = rows.first().map_or(String::new(), |row| {
        let p = row;
        format!("a {:?}, ξ {:?}, ω {:?}; each from rest", p.a, p.xi, p.omega)
    });
    let points = |value: fn(&(f64, f64)) -> f64| {
        let all = rows.iter().flat_map(|r| {
            let b = r.b;
            r.section.iter().map(move |p| (b, value(p)))
        });
        all.collect::<Vec<_>>()
    };
    let b = || Axis::new("static force b");
    let rate = rows.iter().map(|r| (r.b, r.progress_per_period));
    Figure::new("Published drifting oscillator: bifurcation diagram over the static force")
        .subtitle(subtitle)
        .size(1000, 1150)
        .panel(Panel::new(b(), "p = x − v at ωτ = 0").item(Item::points(
            "",
            Color::BLUE,
            points(|p| p.0),
        )))
        .panel(Panel::new(b(), "rate of p at ωτ = 0").item(Item::points(
            "",
            Color::BLUE,
            points(|p| p.1),
        )))
        .panel(
            Panel::new(b(), Axis::new("progress per period").with_zero()).item(Item::line(
                "",
                Color::RED,
                rate.collect(),
            )),
        )
}
