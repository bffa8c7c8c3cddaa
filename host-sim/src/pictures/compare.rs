//! Simulation (blue) and measurement (red) in the same panels, as the chapter draws them.

use numerics::compare::{ComparedSample, Comparison, MeasuredFrame, SimulatedInstant};
use plot::{Axis, Color, Figure, Item, Panel};

/// Drive periods shown of the time histories.
const PERIODS: f64 = 6.0;

/// Time history, force, phase plane with section.
pub fn figure(title: String, comparison: &Comparison, frame: MeasuredFrame) -> Figure {
    let errors = &comparison.errors;
    let shown: Vec<&ComparedSample> = {
        let begin = comparison.rows.first().map_or(0.0, |r| r.time_s);
        let end = begin + PERIODS / errors.frequency_hz;
        comparison
            .rows
            .iter()
            .take_while(|r| r.time_s <= end)
            .collect()
    };
    let mut figure = Figure::new(title).columns(2);
    let begin = shown.first().map_or(0.0, |r| r.time_s);
    let time = || Axis::new(format!("time from {begin:.4} s of the record, s"));
    let at = |r: &ComparedSample| r.time_s - begin;
    if shown.iter().any(|r| r.measured_displacement_mm.is_some()) {
        let label = match frame {
            MeasuredFrame::Fixed => "displacement, mm",
            MeasuredFrame::Relative => "displacement relative to the cart, mm",
        };
        let model = modelled(comparison, &shown, frame, |s, at| {
            (s - begin, at.displacement_mm)
        });
        figure = figure.panel(
            both(
                Panel::new(time(), label),
                measured(&shown, |r| Some((at(r), r.measured_displacement_mm?))),
                model,
            )
            .titled("Displacement"),
        );
        figure = figure.panel(plane(comparison, &shown, label, frame));
    }
    if shown.iter().any(|r| r.measured_force_n.is_some()) {
        let model = modelled(comparison, &shown, frame, |s, at| (s - begin, at.force_n));
        let force = || Axis::new("contact force, N").with_zero();
        figure = figure.panel(
            both(
                Panel::new(time(), force()),
                measured(&shown, |r| Some((at(r), r.measured_force_n?))),
                model,
            )
            .titled("Contact force"),
        );
        if let Some(near) = strongest(&comparison.rows) {
            let begin = near.first().map_or(0.0, |r| r.time_s);
            let at = |r: &ComparedSample| (r.time_s - begin) * 1e3;
            let model = modelled(comparison, &near, frame, |s, at| {
                ((s - begin) * 1e3, at.force_n)
            });
            let time = Axis::new(format!("time from {begin:.4} s of the record, ms"));
            figure = figure.panel(
                both(
                    Panel::new(time, force()),
                    measured(&near, |r| Some((at(r), r.measured_force_n?))),
                    model,
                )
                .titled("Strongest measured contact"),
            );
        }
    }
    let rows = figure.panels.len().div_ceil(2).max(1) as u32;
    figure
        .subtitle(subtitle(comparison))
        .size(1200, 130 + 400 * rows)
}

fn subtitle(comparison: &Comparison) -> String {
    let errors = &comparison.errors;
    let mut text = format!(
        "Drive {:.4} Hz ({}), {:.3} times the natural frequency; simulation: regime {}.",
        errors.frequency_hz,
        errors.frequency_from.name(),
        errors.frequency_ratio,
        errors.regime
    );
    if let (Some(rms), Some(percent)) =
        (errors.displacement_rms_mm, errors.displacement_rms_percent)
    {
        text += &format!(" Displacement apart by {rms:.4} mm rms, {percent:.2} % of its travel.");
    }
    if let (Some(measured), Some(percent)) = (errors.measured_force_n, errors.force_peak_percent) {
        text += &format!(
            " Largest force {:.2} N simulated, {measured:.2} N measured ({percent:+.2} %).",
            errors.simulated_force_n
        );
    }
    text
}

/// The simulation over the time of `rows`, at its own instants: `point` of each and of the record's time, s.
fn modelled(
    comparison: &Comparison,
    rows: &[&ComparedSample],
    frame: MeasuredFrame,
    point: impl Fn(f64, &SimulatedInstant) -> (f64, f64),
) -> Vec<(f64, f64)> {
    let shift_s = comparison.errors.shift_s;
    let ends = |row: Option<&&ComparedSample>| row.map_or(0.0, |row| row.time_s + shift_s);
    let between = (ends(rows.first()), ends(rows.last()));
    let motion = comparison.simulated.between(between, frame);
    motion
        .iter()
        .map(|(time_s, at)| point(time_s - shift_s, at))
        .collect()
}

fn measured(
    rows: &[&ComparedSample],
    f: impl Fn(&ComparedSample) -> Option<(f64, f64)>,
) -> Vec<(f64, f64)> {
    rows.iter().filter_map(|r| f(r)).collect()
}

/// The curve that was measured and the simulated one, in one panel.
fn both(panel: Panel, measured: Vec<(f64, f64)>, model: Vec<(f64, f64)>) -> Panel {
    panel
        .item(Item::line("measured", Color::RED, measured))
        .item(Item::dashed("simulation", Color::BLUE, model))
}

fn plane(
    comparison: &Comparison,
    shown: &[&ComparedSample],
    label: &str,
    frame: MeasuredFrame,
) -> Panel {
    let model = modelled(comparison, shown, frame, |_, at| {
        (at.displacement_mm, at.velocity_m_per_s)
    });
    let seen = measured(shown, |r| {
        Some((r.measured_displacement_mm?, r.measured_velocity_m_per_s?))
    });
    both(Panel::new(label, "velocity, m/s"), seen, model)
        .titled("Phase plane; dots: drive phase 0")
        .item(Item::points(
            "section, measured",
            Color::ORANGE,
            section(&comparison.rows),
        ))
        .item(Item::points(
            "section, simulation",
            Color::INK,
            comparison.simulated.section(frame),
        ))
}

/// The measured motion at each drive phase 0, interpolated between samples.
pub fn section(rows: &[ComparedSample]) -> Vec<(f64, f64)> {
    let crossing = |pair: &[ComparedSample]| {
        let (a, b) = (&pair[0], &pair[1]);
        let step = (b.drive_phase - a.drive_phase).rem_euclid(1.0);
        if b.drive_phase >= a.drive_phase || step == 0.0 || step > 0.5 {
            return None;
        }
        let share = (1.0 - a.drive_phase) / step;
        let mix = |x: f64, y: f64| x + share * (y - x);
        Some((
            mix(a.measured_displacement_mm?, b.measured_displacement_mm?),
            mix(a.measured_velocity_m_per_s?, b.measured_velocity_m_per_s?),
        ))
    };
    rows.windows(2).filter_map(crossing).collect()
}

/// The rows within 2 ms of the largest measured force.
fn strongest(rows: &[ComparedSample]) -> Option<Vec<&ComparedSample>> {
    let force = |r: &ComparedSample| r.measured_force_n.unwrap_or(f64::NEG_INFINITY);
    let top = rows.iter().max_by(|a, b| force(a).total_cmp(&force(b)))?;
    let near = |r: &&ComparedSample| (r.time_s - top.time_s).abs() < 2e-3;
    Some(rows.iter().filter(near).collect())
}
