//! Figures 3.9 and 3.10, and what they are derived from: force of the first impacts, peaks over impact number, and the
//! misfit over each parameter.

use numerics::identify::{IdentifiedFit, MeasuredImpacts, beside};
use plot::{Axis, Color, Figure, Item, Panel, Shape};
use shared::model::contact::LawKind;

/// Impacts whose force is drawn.
const DRAWN: usize = 2;

/// The 95 % point of χ² with one degree of freedom, drawn as the level at which an interval ends.
const LEVEL: f64 = 3.841;

/// Measured against model of `fits` (the first is drawn in full, of the others the peaks).
pub fn figure(
    title: String,
    subtitle: String,
    measured: &MeasuredImpacts,
    fits: &[IdentifiedFit],
) -> Figure {
    let mut figure = Figure::new(title).subtitle(subtitle).columns(2);
    let Some(first) = fits.first() else {
        return figure;
    };
    let profiles = (0..first.profiles.len()).filter_map(|i| profile(first, i));
    figure.panels.extend(forces(measured, first));
    figure.panels.push(peaks(fits));
    figure.panels.extend(profiles);
    let rows = figure.panels.len().div_ceil(2) as u32;
    figure.size(1200, 130 + 390 * rows)
}

/// The force of the first impacts.
pub fn forces(measured: &MeasuredImpacts, fit: &IdentifiedFit) -> Vec<Panel> {
    let all = beside(measured, fit);
    let panel = |(i, samples): (usize, &Vec<[f64; 3]>)| {
        let column = |k: usize| samples.iter().map(|s| (s[0] * 1e3, s[k])).collect();
        Panel::new("time, ms", Axis::new("contact force, N").with_zero())
            .titled(format!("Impact {}", i + 1))
            .item(Item::points("measured", Color::RED, column(1)))
            .item(Item::line(
                format!("model: {}, by {}", fit.law.name(), fit.misfit.name()),
                Color::BLUE,
                column(2),
            ))
    };
    all.iter().enumerate().take(DRAWN).map(panel).collect()
}

/// Peaks over impact number.
pub fn peaks(fits: &[IdentifiedFit]) -> Panel {
    let mut panel = Panel::new(
        Axis::new("impact").whole(),
        Axis::new("force peak, N").with_zero(),
    )
    .titled("Force peaks");
    for (i, fit) in fits.iter().enumerate() {
        let model = fit
            .impacts
            .iter()
            .map(|r| (r.impact as f64, r.model_peak_n));
        let label = format!("{}, by {}", fit.law.name(), fit.misfit.name());
        let (color, points) = (Color::series(2 * i), model.collect());
        // Fits that agree lie on each other: a dashed one leaves the one below it to be seen.
        panel = panel.item(if i == 0 {
            Item::line(label, color, points)
        } else {
            Item::dashed(label, color, points)
        });
    }
    if let Some(fit) = fits.first() {
        let seen = fit
            .impacts
            .iter()
            .map(|r| (r.impact as f64, r.measured_peak_n));
        let large = (plot::Mark::Circle, 4.0);
        panel = panel.item(Item::marks("measured", Color::RED, large, seen.collect()));
    }
    panel
}

/// The rise of χ² over one parameter, all others at their best.
fn profile(fit: &IdentifiedFit, i: usize) -> Option<Panel> {
    let profile = fit.profiles.get(i)?;
    if profile.points.len() < 3 {
        return None;
    }
    let estimate = &profile.estimate;
    let (label, scale) = unit(estimate.key, fit.law);
    let points: Vec<_> = profile
        .points
        .iter()
        .filter(|p| p.1 < 4.0 * LEVEL)
        .map(|p| (p.0 * scale, p.1))
        .collect();
    let ends = (points.first()?.0, points.last()?.0);
    let mut panel = Panel::new(label, Axis::new("rise of χ²").fixed(0.0, 4.0 * LEVEL))
        .titled(format!(
            "Profile likelihood: {}",
            label.split(',').next().unwrap_or(label)
        ))
        .dotted("all others at their best", Color::BLUE, points)
        .item(Item::dashed(
            "95 %",
            Color::INK,
            vec![(ends.0, LEVEL), (ends.1, LEVEL)],
        ))
        .item(Item::mark_x("found", estimate.value * scale));
    for end in [estimate.low, estimate.high].into_iter().flatten() {
        let mark = Shape::MarkX {
            x: end * scale,
            stroke: plot::Stroke::Dotted,
        };
        panel = panel.item(Item::new("", Color::GREY, mark));
    }
    Some(panel)
}

/// The label of a parameter's axis, and the factor of its values.
fn unit(key: &str, law: LawKind) -> (&str, f64) {
    match key {
        "contact_stiffness_n_per_m" if law == LawKind::SpringDashpot => ("ki, 10⁶ N/m", 1e-6),
        "contact_stiffness_n_per_m" => ("ki, 10⁶ N/mⁿ", 1e-6),
        "contact_damping_n_s_per_m" => ("ci, N·s/m", 1.0),
        "contact_damping_ratio_s_per_m" => ("λ, s/m", 1.0),
        "contact_restitution" => ("e", 1.0),
        "contact_exponent" => ("n", 1.0),
        "release_mm" => ("release, mm", 1.0),
        other => (other, 1.0),
    }
}
