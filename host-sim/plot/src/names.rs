//! What explains a panel: its legend, named vertical markers, named points.

use super::canvas::{Canvas, Letters, Rect, px, spot};
use super::layout::{Slot, beside, fit, stagger};
use super::series::DataWindow;
use super::shape::Spot;
use super::{Color, Item, Mark, Panel, PictureError, Shape, Stroke};

const NAME_TEXT: f64 = 12.0;
const LEGEND_ROW: f64 = 18.0;
/// Height of a row of marker names, px.
pub(super) const MARKER_ROW: f64 = 16.0;

/// Draws the names of labelled items in rows; returns where the plot may begin.
pub(super) fn legend(canvas: &Canvas, frame: Rect, items: &[Item]) -> Result<f64, PictureError> {
    let letters = Letters::new(NAME_TEXT);
    let entries = entries(items);
    let (mut x, mut y) = (frame.left, frame.top + LEGEND_ROW / 2.0);
    for (name, samples) in &entries {
        let small = |s: &Sample| match s {
            Sample::Item(item) => {
                matches!(item.shape, Shape::Points { .. } | Shape::Cloud { .. })
            }
            Sample::Cell(_) => true,
        };
        let only_points = samples.iter().all(small);
        let sample = if only_points { 8.0 } else { 24.0 };
        let name = fit(name, letters, frame.width() - sample - 6.0);
        let width = sample + 6.0 + letters.width(&name);
        if x > frame.left && x + width > frame.right {
            (x, y) = (frame.left, y + LEGEND_ROW);
        }
        for shown in samples {
            shown.draw(canvas, (x, y), sample)?;
        }
        canvas.text(&name, (x + sample + 6.0, y), letters)?;
        x += width + 18.0;
    }
    let rows_end = y + LEGEND_ROW / 2.0;
    Ok(if entries.is_empty() {
        frame.top
    } else {
        rows_end
    })
}

/// What stands before a name in the legend.
enum Sample<'a> {
    Item(&'a Item),
    Cell(Color),
}

/// Names and what they stand for; items of the same name share an entry.
fn entries(items: &[Item]) -> Vec<(&str, Vec<Sample<'_>>)> {
    let mut entries: Vec<(&str, Vec<Sample>)> = Vec::new();
    for item in items {
        let named = match &item.shape {
            Shape::MarkX { .. } | Shape::MarkPoint(_) => Vec::new(),
            Shape::Raster(raster) => {
                let names = raster.names.iter();
                names.map(|n| (&n.0, Sample::Cell(n.1))).collect()
            }
            _ => vec![(&item.label, Sample::Item(item))],
        };
        for (label, sample) in named {
            match entries.iter_mut().find(|(name, _)| name == label) {
                Some((_, same)) => same.push(sample),
                None if !label.is_empty() => entries.push((label, vec![sample])),
                None => {}
            }
        }
    }
    entries
}

impl Sample<'_> {
    /// Draws the sample `width` px wide from `(x, y)`, its left end at middle height.
    fn draw(&self, canvas: &Canvas, (x, y): (f64, f64), width: f64) -> Result<(), PictureError> {
        let middle = (x + width / 2.0, y);
        let square = |half: f64| Rect::about(middle, half, half);
        let item = match self {
            Self::Cell(color) => {
                let outline = Color(0x80, 0x80, 0x80);
                canvas.fill(square(5.5), outline, 1.0)?;
                return canvas.fill(square(4.75), *color, 1.0);
            }
            Self::Item(item) => item,
        };
        match &item.shape {
            Shape::Line {
                width: thick,
                stroke,
                ..
            } => {
                let ends = [(x, y), (x + width, y)];
                canvas.line(ends, item.color, thick.max(1.2), *stroke)
            }
            Shape::Points { radius, mark, .. } => {
                canvas.mark(spot(middle), *mark, radius.max(2.5), item.color)
            }
            Shape::Cloud { .. } => canvas.mark(spot(middle), Mark::Circle, 2.5, item.color),
            Shape::BandX { .. } | Shape::Area(_) => {
                let swatch = Rect::about(middle, width / 2.0, 6.0);
                canvas.fill(swatch, item.color, 0.25)
            }
            Shape::Raster(_) | Shape::MarkX { .. } | Shape::MarkPoint(_) => Ok(()),
        }
    }
}

/// A vertical marker line and its name above the plot.
pub(super) struct Marker {
    pub x: f64,
    pub slot: Slot,
    name: String,
    width: f64,
    color: Color,
    stroke: Stroke,
}

/// The markers inside the window, their names arranged above `frame`.
pub(super) fn markers(panel: &Panel, window: DataWindow, frame: Rect) -> Vec<Marker> {
    let letters = Letters::new(NAME_TEXT);
    let mut markers: Vec<Marker> = Vec::new();
    for item in &panel.items {
        let Shape::MarkX { x, stroke } = &item.shape else {
            continue;
        };
        if !(window.x.0..=window.x.1).contains(x) {
            continue;
        }
        let share = (x - window.x.0) / (window.x.1 - window.x.0);
        let name = fit(&item.label, letters, frame.width() * 0.95);
        markers.push(Marker {
            x: frame.left + share * frame.width(),
            slot: Slot { row: 0, left: 0.0 },
            width: letters.width(&name),
            name,
            color: item.color,
            stroke: *stroke,
        });
    }
    let mut named: Vec<_> = markers.iter_mut().filter(|m| m.is_named()).collect();
    let sizes: Vec<_> = named.iter().map(|m| (m.x, m.width)).collect();
    let slots = stagger(&sizes, frame.left, frame.right);
    for (marker, slot) in named.iter_mut().zip(slots) {
        marker.slot = slot;
    }
    markers
}

impl Marker {
    /// Whether it needs room above the plot.
    pub fn is_named(&self) -> bool {
        !self.name.is_empty()
    }

    pub fn draw(&self, canvas: &Canvas, frame: Rect) -> Result<(), PictureError> {
        if !self.is_named() {
            let ends = [(self.x, frame.bottom), (self.x, frame.top)];
            return canvas.line(ends, self.color, 1.2, self.stroke);
        }
        let floor = frame.top - 4.0 - self.slot.row as f64 * MARKER_ROW;
        let beneath = (self.slot.left..=self.slot.left + self.width).contains(&self.x);
        let top = if beneath {
            floor
        } else {
            floor - MARKER_ROW + 4.0
        };
        let ends = [(self.x, frame.bottom), (self.x, top)];
        canvas.line(ends, self.color, 1.2, self.stroke)?;
        let at = (self.slot.left, floor - MARKER_ROW / 2.0);
        canvas.text(&self.name, at, Letters::new(NAME_TEXT).color(self.color))
    }
}

/// Draws ringed points and finds room for their names.
pub(super) fn marked_points(
    canvas: &Canvas,
    panel: &Panel,
    window: DataWindow,
    frame: Rect,
    dots: &[(f64, f64)],
    to_spot: impl Fn((f64, f64)) -> Spot,
) -> Result<(), PictureError> {
    let letters = Letters::new(NAME_TEXT);
    // A name must not hide the frame.
    let inside = Rect {
        left: frame.left + 2.0,
        top: frame.top + 2.0,
        right: frame.right - 2.0,
        bottom: frame.bottom - 2.0,
    };
    let marked: Vec<_> = panel
        .items
        .iter()
        .filter_map(|item| match item.shape {
            Shape::MarkPoint(at) if window.contains(at) => {
                Some((to_spot(at), &item.label, item.color))
            }
            _ => None,
        })
        .collect();
    // The rings themselves must stay readable.
    let rings = marked.iter().map(|(at, ..)| Rect::about(px(*at), 7.0, 7.0));
    let mut taken: Vec<Rect> = rings.collect();
    for (at, label, color) in marked {
        canvas.ring(at, 5.5, Color::PAPER, 4.5)?;
        canvas.ring(at, 5.5, color, 2.0)?;
        let name = fit(label, letters, frame.width() * 0.9);
        if name.is_empty() {
            continue;
        }
        let size = (letters.width(&name) + 6.0, NAME_TEXT + 5.0);
        let (x, y) = px(at);
        let place = beside((x, y), size, inside, &taken, dots);
        let (nx, ny) = (
            x.clamp(place.left, place.right),
            y.clamp(place.top, place.bottom),
        );
        let away = (nx - x).hypot(ny - y);
        if away > 15.0 {
            let rim = (x + (nx - x) * 6.5 / away, y + (ny - y) * 6.5 / away);
            canvas.line([rim, (nx, ny)], color, 0.8, Stroke::Solid)?;
        }
        canvas.fill(place, Color::PAPER, 0.6)?;
        let middle = (place.top + place.bottom) / 2.0;
        canvas.text(&name, (place.left + 3.0, middle), letters.color(color))?;
        taken.push(place);
    }
    Ok(())
}
