//! Pictures of Poincaré sections.

use crate::pictures::regimes::regime_color;
use numerics::CartModel;
use numerics::NamedRig;
use numerics::engine::RecordedSample;
use numerics::poincare::against::SectionComparison;
use numerics::poincare::{Portrait, SectionPoint, SectionRequest, TRAJECTORY_PERIODS};
use plot::{Axis, Color, Figure, Item, Panel, Shape};

const DISPLACEMENT: &str = "displacement relative to the cart, mm";
const VELOCITY: &str = "velocity relative to the cart, m/s";
/// Up to so many points are drawn as marks, more as small dots.
const FEW: usize = 64;
/// Points of the section of at most this many contacts per period have a colour of their own.
const COUNTED: u16 = 3;

fn at(p: &SectionPoint) -> (f64, f64) {
    (p.relative_displacement_mm, p.relative_velocity_m_per_s)
}

/// The points of a section, coloured by the contacts of their drive period.
fn by_contacts(points: &[SectionPoint], repeats: Option<u8>, dot: f64) -> Vec<Item> {
    let last = points
        .len()
        .saturating_sub(repeats.map_or(usize::MAX, usize::from));
    let points = &points[last..];
    let mut items = Vec::new();
    for count in 0..=COUNTED {
        let of = |p: &&SectionPoint| p.contacts.min(COUNTED) == count;
        let some: Vec<_> = points.iter().filter(of).map(at).collect();
        let label = match count {
            0 => "no contact in the period".to_owned(),
            1 => "1 contact".to_owned(),
            COUNTED => format!("{COUNTED} or more"),
            n => format!("{n} contacts"),
        };
        let color = [Color::GREY, Color::BLUE, Color::RED, Color::GREEN][usize::from(count)];
        if !some.is_empty() {
            items.push(if points.len() <= FEW {
                Item::points(label, color, some)
            } else {
                Item::new(label, color, Shape::Cloud { points: some, dot })
            });
        }
    }
    items
}

fn line(trajectory: &[RecordedSample]) -> Vec<(f64, f64)> {
    let sample = |s: &RecordedSample| (s.relative_displacement_mm, s.relative_velocity_m_per_s);
    trajectory.iter().map(sample).collect()
}

/// The title and what all panels share.
fn headed(rig: &NamedRig, request: &SectionRequest, portrait: &Portrait) -> Figure {
    let ratio = request.frequency_hz / request.params.natural_frequency_hz();
    Figure::new(format!(
        "{}, gap {:?} mm, {}, {:.4} Hz: Poincaré section",
        rig.name,
        numerics::row::tidy(request.params.gap_m * 1e3),
        CartModel::of(&request.params).words(),
        request.frequency_hz
    ))
    .subtitle(format!(
        "Drive at {ratio:.4} times the natural frequency; regime {} over {} drive periods after {} more.",
        portrait.outcome(), request.points, request.transient
    ))
}

/// The phase plane and every section.
pub fn figure(rig: &NamedRig, request: &SectionRequest, portrait: &Portrait) -> Figure {
    let gap = request.params.gap_m * 1e3;
    let regime = portrait.outcome().to_string();
    let mut figure = headed(rig, request, portrait).columns(2).panel(
        Panel::new(DISPLACEMENT, VELOCITY)
            .titled(format!("Phase plane, {TRAJECTORY_PERIODS} drive periods"))
            .item(Item::line(
                "trajectory",
                regime_color(&regime),
                line(&portrait.trajectory),
            ))
            .item(Item::mark_x("surface", gap)),
    );
    for (phase, section) in request.phases.iter().zip(&portrait.sections) {
        let mut panel = Panel::new(DISPLACEMENT, VELOCITY)
            .titled(format!("Section at drive phase {phase:?} turns"));
        let items = by_contacts(section, portrait.regime.periods(), 1.0);
        panel.items.extend(items);
        figure = figure.panel(panel);
    }
    let rows = (1 + request.phases.len()).div_ceil(2) as u32;
    figure.size(1200, 120 + 460 * rows)
}

/// The hammer over time, and the surface that it strikes, which rides on the cart.
pub fn history(shown: &[(f64, &RecordedSample)], gap_mm: f64, [blue, red]: [Color; 2]) -> Panel {
    let over_time =
        |f: &dyn Fn(&RecordedSample) -> f64| shown.iter().map(|(t, s)| (*t, f(s))).collect();
    let hammer = over_time(&|s| s.displacement_mm);
    let surface = over_time(&|s| s.displacement_mm - s.relative_displacement_mm + gap_mm);
    Panel::new("time, s", "displacement, mm")
        .item(Item::line("hammer, fixed frame", blue, hammer))
        .item(Item::dashed("impact surface", red, surface))
}

/// As the chapter's figures 3.16–3.23: a) displacement over time, b) phase plane with the section's points.
pub fn chapter(rig: &NamedRig, request: &SectionRequest, portrait: &Portrait) -> Figure {
    let shown = &portrait.trajectory;
    let from = shown.first().map_or(0.0, |s| s.time_s);
    let timed: Vec<_> = shown.iter().map(|s| (s.time_s - from, s)).collect();
    let gap = request.params.gap_m * 1e3;
    let mut plane = Panel::new(DISPLACEMENT, VELOCITY)
        .titled("b) Phase plane and section at drive phase 0")
        .item(Item::line("trajectory", Color::SKY, line(shown)));
    let items = by_contacts(&portrait.sections[0], portrait.regime.periods(), 3.0);
    plane.items.extend(items);
    headed(rig, request, portrait)
        .columns(2)
        .size(1200, 520)
        .panel(history(&timed, gap, [Color::BLUE, Color::RED]).titled("a) Displacement"))
        .panel(plane)
}

/// Figure 3.4: the smoothed sections by falling width, and the switch's last, on the same axes.
pub fn against_figure(
    rig: &NamedRig,
    request: &SectionRequest,
    found: &SectionComparison,
) -> Figure {
    let exact: Vec<_> = found.exact.sections[0].iter().map(at).collect();
    let all = || found.smoothed.iter().flat_map(|s| &s.points).chain(&exact);
    let span = |value: fn(&(f64, f64)) -> f64| {
        let low = all().map(value).fold(f64::INFINITY, f64::min);
        let high = all().map(value).fold(f64::NEG_INFINITY, f64::max);
        let margin = 0.04 * (high - low);
        (low - margin, high + margin)
    };
    let (x, y) = (span(|p| p.0), span(|p| p.1));
    let panel = |title: String, points: &[(f64, f64)], repeats: Option<u8>, color| {
        let item = match repeats {
            Some(n) => {
                let last = points.len().saturating_sub(usize::from(n));
                Item::points("section", color, points[last..].to_vec())
            }
            None => Item::cloud("section", color, points.to_vec()),
        };
        Panel::new(
            Axis::new(DISPLACEMENT).fixed(x.0, x.1),
            Axis::new(VELOCITY).fixed(y.0, y.1),
        )
        .titled(title)
        .without_legend()
        .item(item)
    };
    let ratio = request.frequency_hz / request.params.natural_frequency_hz();
    let mut figure = Figure::new(format!(
        "{}, gap {:?} mm, cart prescribed, {ratio:.4} times the natural frequency: smoothing against the switch",
        rig.name,
        numerics::row::tidy(request.params.gap_m * 1e3),
    ))
    .subtitle(format!(
        "Poincaré section at drive phase 0, {} points each, after {} drive periods. Two runs of the switch itself differ by {:.3} A0 and {:.0} % of the boxes.",
        request.points,
        request.transient,
        found.again.carried,
        100.0 * found.again.boxes_not_shared
    ))
    .columns(2)
    .size(1200, 110 + 430 * (found.smoothed.len() as u32 + 1).div_ceil(2));
    for s in &found.smoothed {
        figure = figure.panel(panel(
            format!(
                "smoothed over {:?} µm: {:.3} A0 away, {:.0} steps per period",
                numerics::row::tidy(s.epsilon_m * 1e6),
                s.summary.carried,
                s.summary.steps_per_period
            ),
            &s.points,
            s.summary.section_periods,
            Color::RED,
        ));
    }
    figure.panel(panel(
        format!(
            "switch, located: {:.0} steps per period",
            found.summary.steps_per_period
        ),
        &exact,
        found.summary.section_periods,
        Color::BLUE,
    ))
}
