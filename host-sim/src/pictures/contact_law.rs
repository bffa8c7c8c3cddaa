//! Figure 3.3 and similar ones: phase plane and force of single impacts, restitution over speed.

use shared::model::contact::Law;
use shared::model::rig::Rig;

use files::UserError;
use numerics::contact_law::{ContactFigures, free_mass, motion, one_contact, unclamped};
use plot::{Axis, Color, Figure, Item, Panel, Stroke};

/// Instants drawn per contact.
const POINTS: usize = 300;

/// An impact to draw: name, law, approach speed in m/s.
pub type Drawn = (String, Law<f64>, f64);

/// Phase plane (indentation and its rate) and force over time of several impacts of a mass.
///
/// # Errors
/// If a parameter is out of range, or a contact does not end.
pub fn blows(mass_kg: f64, drawn: &[Drawn]) -> Result<[Panel; 2], UserError> {
    let mut plane = Panel::new("indentation, µm", "rate of indentation, m/s").titled("Phase plane");
    let mut force = Panel::new(
        "time since onset, ms",
        Axis::new("contact force, N").with_zero(),
    )
    .titled("Contact force");
    for (i, (name, law, speed)) in drawn.iter().enumerate() {
        let rig = Rig::new(&free_mass(mass_kg, *law))?;
        let done = one_contact(&rig, *speed).and_then(|b| unclamped(&rig, &b).map(|p| (b, p)));
        let (course, pull) = done.ok_or_else(|| {
            UserError::new(format!("{name}: the contact does not end at {speed} m/s"))
        })?;
        let color = Color::series(i);
        let seen = motion(&rig, &course, POINTS);
        let by = |f: fn(&numerics::contact_law::Instant) -> (f64, f64)| {
            seen.iter().map(f).collect::<Vec<_>>()
        };
        let path = by(|p| (p.penetration_m * 1e6, p.rate_m_per_s));
        let mut forces = by(|p| (p.time_s * 1e3, p.force_n));
        forces.insert(0, (0.0, 0.0));
        let laws_differ = drawn.iter().any(|(_, other, _)| other != law);
        let line = |points| match laws_differ {
            true => over_another(name, i, points),
            false => Item::line(name, color, points),
        };
        plane = plane.item(line(path));
        force = force.item(line(forces));
        if pull.share > 0.0 {
            let tail = |f: fn(&[f64; 4]) -> (f64, f64)| pull.tail.iter().map(f).collect();
            let label = format!("{name}, if it could pull");
            plane = plane.item(Item::dashed(&label, color, tail(|p| (p[1] * 1e6, p[2]))));
            force = force.item(Item::dashed(&label, color, tail(|p| (p[0] * 1e3, p[3]))));
        }
    }
    Ok([plane, force])
}

/// The curve of the `i`-th law. Two laws may give the same: the later is drawn narrower over the earlier, so that both show.
fn over_another(name: &str, i: usize, points: Vec<(f64, f64)>) -> Item {
    let width = (5.0 - i as f64).max(1.4);
    Item::curve(name, Color::series(i), (Stroke::Solid, width), points)
}

/// Restitution and contact time over approach speed, a curve per law.
pub fn over_speed(rows: &[ContactFigures]) -> [Panel; 2] {
    let curve = |f: fn(&ContactFigures) -> f64, law: &[ContactFigures]| {
        law.iter()
            .map(|r| (r.approach_speed_m_per_s, f(r)))
            .collect::<Vec<_>>()
    };
    let speed = || Axis::new("approach speed, m/s").with_zero();
    let mut restitution = Panel::new(speed(), Axis::new("restitution").fixed(0.0, 1.05))
        .titled("Rebound over approach speed");
    let mut duration =
        Panel::new(speed(), Axis::new("contact time, ms").with_zero()).titled("Onset to release");
    for (i, law) in rows.chunk_by(|a, b| a.law == b.law).enumerate() {
        let drawn = |points| over_another(&law[0].law, i, points);
        restitution = restitution.item(drawn(curve(|r| r.restitution, law)));
        duration = duration.item(drawn(curve(|r| r.contact_time_ms, law)));
    }
    [restitution, duration]
}

/// Panels in a grid of two columns.
pub fn grid(title: String, subtitle: String, panels: impl IntoIterator<Item = Panel>) -> Figure {
    let mut figure = Figure::new(title).subtitle(subtitle).columns(2);
    figure.panels.extend(panels);
    let rows = figure.panels.len().div_ceil(2) as u32;
    figure.size(1200, 120 + 400 * rows)
}
