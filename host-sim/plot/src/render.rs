//! From a figure to the bytes of a file.

use std::cell::RefCell;

use plotters::prelude::*;

use super::canvas::{Canvas, Letters, Rect, UNIT, library};
use super::data::on_even_axes;
use super::layout::{grid, wrap};
use super::shape::{DrawnShape, ShapeRecorder};
use super::{Color, Figure, PictureError, panel, pixels, svg};

/// Pixels of a PNG per CSS px of the figure.
pub const PNG_SCALE: u32 = 2;

const MARGIN: f64 = 14.0;
const SUBTITLE_COLOR: Color = Color(0x55, 0x55, 0x55);

/// Draws `figure` as the text of an SVG file.
///
/// Texts stay texts; they ask for Noto Sans and settle for any sans-serif.
///
/// # Errors
/// [`PictureError::Size`] or [`PictureError::Crowded`] when the figure does not
/// fit its size.
pub fn render_svg(figure: &Figure) -> Result<String, PictureError> {
    svg::document(&shapes(figure)?, figure.size, fine(figure))
}

/// Draws `figure` as the bytes of a PNG file, [`PNG_SCALE`] pixels per CSS px.
///
/// # Errors
/// As [`render_svg`].
pub fn render_png(figure: &Figure) -> Result<Vec<u8>, PictureError> {
    pixels::file(&shapes(figure)?, figure.size)
}

/// Width and height of the canvas, in canvas units.
fn fine(figure: &Figure) -> (u32, u32) {
    let (width, height) = figure.size;
    (width * UNIT as u32, height * UNIT as u32)
}

/// What both files show.
pub(super) fn shapes(figure: &Figure) -> Result<Vec<DrawnShape>, PictureError> {
    let (width, height) = figure.size;
    let allowed = 200..=8000;
    if !allowed.contains(&width) || !allowed.contains(&height) {
        return Err(PictureError::Size { width, height });
    }
    let shapes = RefCell::new(Vec::new());
    let recorder = ShapeRecorder {
        size: fine(figure),
        shapes: &shapes,
    };
    let area = recorder.into_drawing_area();
    area.fill(&WHITE).map_err(library)?;
    let canvas = Canvas {
        area: &area,
        shapes: &shapes,
    };
    draw(&canvas, figure)?;
    drop(area);
    Ok(shapes.into_inner())
}

/// Title, subtitle and the grid of panels.
fn draw(canvas: &Canvas, figure: &Figure) -> Result<(), PictureError> {
    let (width, height) = (f64::from(figure.size.0), f64::from(figure.size.1));
    let mut inside = Rect {
        left: MARGIN,
        top: MARGIN,
        right: width - MARGIN,
        bottom: height - MARGIN + 4.0,
    };
    let title = Letters::new(18.0).bold();
    for line in wrap(&figure.title, title, inside.width(), 2) {
        canvas.text(&line, (inside.left, inside.top + 9.0), title)?;
        inside.top += 24.0;
    }
    let subtitle = Letters::new(13.0).color(SUBTITLE_COLOR);
    for line in wrap(&figure.subtitle, subtitle, inside.width(), 3) {
        canvas.text(&line, (inside.left, inside.top + 7.0), subtitle)?;
        inside.top += 18.0;
    }
    inside.top += 8.0;
    let cells = grid(inside, figure.panels.len(), figure.columns);
    // Frames in a column begin at the same place.
    let columns = figure.columns.clamp(1, cells.len().max(1));
    let mut margins = vec![0.0_f64; columns];
    let panels: Vec<_> = figure.panels.iter().map(on_even_axes).collect();
    for (i, (panel, cell)) in panels.iter().zip(&cells).enumerate() {
        let margin = &mut margins[i % columns];
        *margin = margin.max(panel::left_margin(panel, *cell));
    }
    for (i, (panel, cell)) in panels.iter().zip(cells).enumerate() {
        panel::draw(canvas, cell, panel, i + 1, margins[i % columns])?;
    }
    Ok(())
}
