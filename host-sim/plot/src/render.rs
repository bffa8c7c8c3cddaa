//! From a figure to the bytes of a file.

use std::cell::RefCell;

use plotters::prelude::*;
use resvg::{tiny_skia, usvg};

use super::canvas::{Canvas, Letters, Rect, UNIT, library, place_images};
use super::data::on_even_axes;
use super::layout::{grid, wrap};
use super::{Color, Figure, PictureError, panel};

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
    let (width, height) = figure.size;
    let allowed = 200..=8000;
    if !allowed.contains(&width) || !allowed.contains(&height) {
        return Err(PictureError::Size { width, height });
    }
    let fine = (width * UNIT as u32, height * UNIT as u32);
    let mut svg = String::new();
    let images = RefCell::new(Vec::new());
    {
        let area = SVGBackend::with_string(&mut svg, fine).into_drawing_area();
        area.fill(&WHITE).map_err(library)?;
        let canvas = Canvas {
            area: &area,
            images: &images,
        };
        draw(&canvas, figure)?;
        area.present().map_err(library)?;
    }
    // The view box stays fine, the picture gets the size that was asked for.
    let drawn = format!("<svg width=\"{}\" height=\"{}\"", fine.0, fine.1);
    let wanted = format!("<svg width=\"{width}\" height=\"{height}\"");
    let svg = svg.replacen(&drawn, &wanted, 1);
    Ok(place_images(&svg, &images.into_inner()))
}

/// Draws `figure` as the bytes of a PNG file, [`PNG_SCALE`] pixels per CSS px.
///
/// # Errors
/// As [`render_svg`].
pub fn render_png(figure: &Figure) -> Result<Vec<u8>, PictureError> {
    let svg = render_svg(figure)?;
    let mut options = usvg::Options {
        font_family: "Noto Sans".to_owned(),
        ..usvg::Options::default()
    };
    let fonts = options.fontdb_mut();
    fonts.load_font_data(notosans::REGULAR_TTF.to_vec());
    fonts.load_font_data(notosans::BOLD_TTF.to_vec());
    fonts.set_sans_serif_family("Noto Sans");
    let tree = usvg::Tree::from_str(&svg, &options).map_err(library)?;
    let (width, height) = figure.size;
    let mut pixels = tiny_skia::Pixmap::new(width * PNG_SCALE, height * PNG_SCALE)
        .ok_or(PictureError::Size { width, height })?;
    let scale = PNG_SCALE as f32;
    let enlarge = tiny_skia::Transform::from_scale(scale, scale);
    resvg::render(&tree, enlarge, &mut pixels.as_mut());
    pixels.encode_png().map_err(library)
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
