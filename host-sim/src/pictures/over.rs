//! The picture of the operating point over a parameter: force, frequency, stability and power.

use crate::words::over::{OverRow, of_rig, summary};
use plot::{Axis, Color, Figure, Item, Mark, Panel};

/// What the picture of an operating point over a parameter shows.
pub struct OverPicture<'a> {
    /// The rows, in the order of their values.
    pub rows: &'a [OverRow],
    /// The parameter's value in the rig itself, if it has one.
    pub own: Option<f64>,
    /// Whether the values are spaced by factors.
    pub log: bool,
}

impl OverPicture<'_> {
    /// Four panels over the parameter.
    pub fn figure(&self) -> Figure {
        let first = self.rows.first();
        let title = first.map_or(String::new(), |row| {
            format!(
                "{}: where to run, over {}",
                of_rig(self.rows),
                row.parameter
            )
        });
        Figure::new(title)
            .subtitle(summary(self.rows))
            .columns(2)
            .size(1300, 1000)
            .panel(self.force())
            .panel(self.frequency())
            .panel(self.multiplier())
            .panel(self.power())
    }

    fn points(&self, value: impl Fn(&OverRow) -> Option<f64>) -> Vec<(f64, f64)> {
        // A value without a pick interrupts the line.
        let rows = self.rows.iter();
        rows.map(|row| (row.value, value(row).unwrap_or(f64::NAN)))
            .collect()
    }

    fn panel(&self, label: &str, title: &str) -> Panel {
        let key = self.rows.first().map_or("", |row| row.parameter.as_str());
        let x = Axis::new(axis_label(key));
        let x = if self.log { x.log() } else { x };
        let panel = Panel::new(x, Axis::new(label).with_zero()).titled(title);
        let ends = self.rows.iter().map(|row| row.value);
        let low = ends.clone().fold(f64::INFINITY, f64::min);
        let high = ends.fold(f64::NEG_INFINITY, f64::max);
        match self.own.filter(|own| (low..=high).contains(own)) {
            Some(own) => panel.item(Item::mark_x("this rig", own)),
            None => panel,
        }
    }

    fn force(&self) -> Panel {
        let panel = self.panel("contact force, N", "force");
        let panel = if self.rows.iter().any(is_uncertain) {
            let edge = |label: &str, value: fn(&OverRow) -> Option<f64>| {
                Item::dashed(label, Color::GREY, self.points(value))
            };
            panel
                .item(edge("over the uncertainty", |r| {
                    newtons(r, r.force_ratio_worst)
                }))
                .item(edge("", |r| newtons(r, r.force_ratio_largest)))
        } else {
            panel
        };
        let jumping = |row: &OverRow| row.force_n.filter(|_| row.jumps == Some(true));
        let panel = panel.dotted("at the pick", Color::BLUE, self.points(|r| r.force_n));
        if !self.rows.iter().any(|row| jumping(row).is_some()) {
            return panel;
        }
        panel.item(jumps(self.points(jumping)))
    }

    fn frequency(&self) -> Panel {
        let label = "drive frequency, Hz";
        let mut panel = self.panel(label, "frequency and safe band");
        let edges = self.rows.iter();
        let edges = edges.flat_map(|r| [r.safe_band_low_hz, r.safe_band_high_hz]);
        panel.y = around(label, edges.flatten()).unwrap_or(panel.y);
        let edge = |label: &str, value: fn(&OverRow) -> Option<f64>| {
            Item::dashed(label, Color::GREEN, self.points(value))
        };
        let pick = self.points(|r| r.operating_frequency_hz);
        panel
            .item(edge("safe band", |r| r.safe_band_low_hz))
            .item(edge("", |r| r.safe_band_high_hz))
            .dotted("pick", Color::BLUE, pick)
    }

    fn multiplier(&self) -> Panel {
        let limit = self.rows.iter().map(|row| (row.value, 1.0)).collect();
        self.panel("largest modulus of a multiplier", "stability at the pick")
            .dotted("orbit picked", Color::BLUE, self.points(|r| r.multiplier))
            .item(Item::dashed("limit of stability", Color::INK, limit))
    }

    fn power(&self) -> Panel {
        let power = self.points(|r| r.impact_power_w);
        self.panel("impact power, W", "power of the blows").dotted(
            "at the pick",
            Color::BLUE,
            power,
        )
    }
}

/// The axis `label` over the ends of the safe bands with a margin; none where there is no band.
pub fn around(label: &str, ends: impl Iterator<Item = f64> + Clone) -> Option<Axis> {
    let low = ends.clone().fold(f64::INFINITY, f64::min);
    let high = ends.fold(0.0, f64::max);
    let margin = 0.1 * (high - low);
    (low < high).then(|| Axis::new(label).fixed(low - margin, high + margin))
}

/// Orange diamonds where the hammer jumps.
pub fn jumps(points: Vec<(f64, f64)>) -> Item {
    Item::marks(
        "the hammer jumps",
        Color::ORANGE,
        (Mark::Diamond, 5.0),
        points,
    )
}

/// A force over the weight of `row` in N.
fn newtons(row: &OverRow, force_ratio: Option<f64>) -> Option<f64> {
    Some(force_ratio? * row.force_n? / row.force_ratio?)
}

/// A key of rig files as the label of an axis: "contact_stiffness_n_per_m" is "contact stiffness, N/m".
pub fn axis_label(key: &str) -> String {
    const UNITS: [(&str, &str); 9] = [
        ("_n_per_m3", "N/m³"),
        ("_n_s_per_m", "N·s/m"),
        ("_n_per_m", "N/m"),
        ("_m_per_s2", "m/s²"),
        ("_s_per_m", "s/m"),
        ("_kg", "kg"),
        ("_mm", "mm"),
        ("_hz", "Hz"),
        ("_n", "N"),
    ];
    let found = UNITS
        .iter()
        .find_map(|(end, unit)| Some((key.strip_suffix(end)?, unit)));
    match found {
        Some((name, unit)) => format!("{}, {unit}", name.replace('_', " ")),
        None => key.replace('_', " "),
    }
}

/// Whether the force has a range.
fn is_uncertain(row: &OverRow) -> bool {
    row.force_ratio_worst != row.force_ratio_largest
}
