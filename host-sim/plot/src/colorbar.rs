//! The bar that tells a raster's scale.

use plotters::style::FontTransform;
use plotters::style::text_anchor::HPos;

use super::canvas::{Canvas, Letters, Rect, printable, spot};
use super::layout::fit;
use super::panel::widest;
use super::ticks::Ticks;
use super::{Bar, Color, Panel, PictureError, Shape, Stroke};

const GAP: f64 = 14.0;
const WIDTH: f64 = 14.0;
const TICK: f64 = 4.0;
const TICK_TEXT: f64 = 12.0;
const LABEL_TEXT: f64 = 13.0;
const STEPS: usize = 128;

/// The scale of `panel`'s first raster that has one.
pub(super) fn bar(panel: &Panel) -> Option<&Bar> {
    panel.items.iter().find_map(|item| match &item.shape {
        Shape::Raster(raster) => raster.bar.as_ref(),
        _ => None,
    })
}

fn ticks(bar: &Bar, height: f64) -> Ticks {
    let (low, high) = (bar.from.min(bar.to), bar.from.max(bar.to));
    let high = if high > low { high } else { low + 1.0 };
    Ticks::new(low, high, ((height / 32.0) as usize).clamp(2, 10))
}

/// Room the bar needs right of the frame, px.
pub(super) fn room(bar: &Bar, height: f64) -> f64 {
    GAP + WIDTH + TICK + 3.0 + widest(&ticks(bar, height)) + LABEL_TEXT + 10.0
}

/// Draws `bar` right of `frame`.
pub(super) fn draw(canvas: &Canvas, bar: &Bar, frame: Rect) -> Result<(), PictureError> {
    let ticks = ticks(bar, frame.height());
    let place = Rect {
        left: frame.right + GAP,
        right: frame.right + GAP + WIDTH,
        ..frame
    };
    let level = |share: f64| place.bottom - share * place.height();
    for step in 0..STEPS {
        let share = step as f64 / STEPS as f64;
        let value = bar.from + (share + 0.5 / STEPS as f64) * (bar.to - bar.from);
        let Some(color) = bar.color(value) else {
            continue;
        };
        // Down to the bar's end, under the steps that follow: no seam can show between two.
        let slice = Rect {
            top: level(1.0),
            bottom: level(share),
            ..place
        };
        canvas.fill(slice, color, 1.0)?;
    }
    let corners = [
        (place.left, place.top),
        (place.right, place.top),
        (place.right, place.bottom),
        (place.left, place.bottom),
        (place.left, place.top),
    ];
    let ink = Color(0x55, 0x55, 0x55);
    canvas.path(corners.map(spot).to_vec(), ink, 1.0, Stroke::Solid)?;
    for value in &ticks.values {
        let y = level((value - bar.from) / (bar.to - bar.from));
        let ends = [(place.right, y), (place.right + TICK, y)];
        canvas.line(ends, ink, 1.0, Stroke::Solid)?;
        let at = (place.right + TICK + 3.0, y);
        canvas.text(&ticks.label(*value), at, Letters::new(TICK_TEXT))?;
    }
    let letters = Letters::new(LABEL_TEXT).side(HPos::Center);
    let text = printable(&format!("{}{}", bar.label, ticks.factor()));
    let text = fit(&text, letters, place.height());
    let x = place.right + TICK + 3.0 + widest(&ticks) + 4.0 + LABEL_TEXT / 2.0;
    let middle = (x, (place.top + place.bottom) / 2.0);
    canvas.turned_text(&text, middle, letters, FontTransform::Rotate270)
}
