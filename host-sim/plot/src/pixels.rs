//! Shapes as the pixels of a PNG file.

use plotters::style::text_anchor::{HPos, VPos};
use tiny_skia::{
    FillRule, FilterQuality, Paint, Path, PathBuilder, Pattern, Pixmap, Rect, SpreadMode, Stroke,
    Transform,
};

use super::PictureError;
use super::canvas::{UNIT, library};
use super::font::Font;
use super::raster::Image;
use super::render::PNG_SCALE;
use super::shape::{Ink, Shape, Spot, Text};

/// The bytes of the file: `shapes` on a canvas shown `width` by `height` px, [`PNG_SCALE`] pixels each.
///
/// # Errors
/// If the picture is too large to hold or cannot be encoded.
pub(super) fn file(shapes: &[Shape], (width, height): (u32, u32)) -> Result<Vec<u8>, PictureError> {
    let pixels = Pixmap::new(width * PNG_SCALE, height * PNG_SCALE);
    let scale = PNG_SCALE as f32 / UNIT as f32;
    let mut painter = Painter {
        pixels: pixels.ok_or(PictureError::Size { width, height })?,
        enlarge: Transform::from_scale(scale, scale),
    };
    for shape in shapes {
        // A shape without extent has no outline, and nothing to show.
        let _ = painter.draw(shape);
    }
    painter.pixels.encode_png().map_err(library)
}

struct Painter {
    pixels: Pixmap,
    /// From canvas units to pixels.
    enlarge: Transform,
}

impl Painter {
    fn draw(&mut self, shape: &Shape) -> Option<()> {
        match shape {
            Shape::Line { ends, width, ink } => self.stroke(&joined(ends, false)?, *width, *ink),
            Shape::Polyline { spots, width, ink } => {
                self.stroke(&joined(spots, false)?, *width, *ink);
            }
            Shape::Polygon { corners, ink } => self.fill(&joined(corners, true)?, *ink),
            Shape::Rectangle { corners, ink } => {
                self.fill(&PathBuilder::from_rect(rectangle(*corners)?), *ink);
            }
            Shape::Circle {
                middle: (x, y),
                radius,
                outline,
                ink,
            } => {
                let circle = PathBuilder::from_circle(*x as f32, *y as f32, *radius as f32)?;
                match outline {
                    Some(width) => self.stroke(&circle, *width, *ink),
                    None => self.fill(&circle, *ink),
                }
            }
            Shape::Text(text) => self.text(text)?,
            Shape::Image {
                pixels,
                corners,
                frame,
            } => self.image(pixels, rectangle(*corners)?, rectangle(*frame)?)?,
        }
        Some(())
    }

    fn fill(&mut self, path: &Path, ink: Ink) {
        self.pixels
            .fill_path(path, &paint(ink), FillRule::Winding, self.enlarge, None);
    }

    fn stroke(&mut self, path: &Path, width: u32, ink: Ink) {
        let stroke = Stroke {
            width: width as f32,
            ..Stroke::default()
        };
        self.pixels
            .stroke_path(path, &paint(ink), &stroke, self.enlarge, None);
    }

    /// Letters as a browser places them by the SVG's attributes: spaces at the ends and repeated ones do not count, an
    /// `ex` is half a font size.
    fn text(&mut self, text: &Text) -> Option<()> {
        let words: Vec<&str> = text.letters.split(' ').filter(|w| !w.is_empty()).collect();
        let letters = words.join(" ");
        let font = Font::of(text.bold);
        let left = match text.anchor.h_pos {
            HPos::Left => 0.0,
            HPos::Center => -0.5 * font.width(&letters),
            HPos::Right => -font.width(&letters),
        };
        let down = match text.anchor.v_pos {
            VPos::Top => 0.76,
            VPos::Center => 0.25,
            VPos::Bottom => -0.25,
        };
        let (x, y) = text.at;
        let place = Transform::from_translate(x as f32, y as f32)
            .pre_rotate(f32::from(text.turn))
            .pre_scale(text.size as f32, text.size as f32)
            .pre_translate(left as f32, down);
        let outline = font.outline(&letters)?.transform(place)?;
        self.fill(&outline, text.ink);
        Some(())
    }

    /// Even cells of colour with crisp edges.
    fn image(&mut self, image: &Image, place: Rect, frame: Rect) -> Option<()> {
        let pixels = image.pixels();
        let (across, down) = (pixels.width() as f32, pixels.height() as f32);
        let (width, height) = (place.width() / across, place.height() / down);
        let spread = Transform::from_row(width, 0.0, 0.0, height, place.left(), place.top());
        let paint = Paint {
            shader: Pattern::new(
                pixels.as_ref(),
                SpreadMode::Pad,
                FilterQuality::Nearest,
                1.0,
                spread,
            ),
            ..Paint::default()
        };
        let seen = PathBuilder::from_rect(place.intersect(&frame)?);
        self.pixels
            .fill_path(&seen, &paint, FillRule::Winding, self.enlarge, None);
        Some(())
    }
}

fn paint(ink: Ink) -> Paint<'static> {
    let mut paint = Paint::default();
    let alpha = (ink.alpha * 255.0).round() as u8;
    paint.set_color_rgba8(ink.color.0, ink.color.1, ink.color.2, alpha);
    paint
}

fn joined(spots: &[Spot], closed: bool) -> Option<Path> {
    let mut path = PathBuilder::new();
    for (k, (x, y)) in spots.iter().enumerate() {
        let (x, y) = (*x as f32, *y as f32);
        if k == 0 {
            path.move_to(x, y);
        } else {
            path.line_to(x, y);
        }
    }
    if closed {
        path.close();
    }
    path.finish()
}

fn rectangle([(left, top), (right, bottom)]: [Spot; 2]) -> Option<Rect> {
    Rect::from_ltrb(left as f32, top as f32, right as f32, bottom as f32)
}
