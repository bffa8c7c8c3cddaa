//! The drawing surface: lines, shapes and letters in CSS px on an SVG.
//!
//! The SVG backend knows whole numbers only, so the canvas is [`UNIT`] times
//! finer than the picture; the SVG's view box scales it back. It knows no images either: where one goes a text is
//! written that no other can be, and the element is put in its place when the SVG is whole.

use std::cell::RefCell;

use ab_glyph::{Font, FontRef};
use plotters::coord::Shift;
use plotters::element::DashedPathElement;
use plotters::prelude::*;
use plotters::style::Color as _;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::{Color, Mark, PictureError, Stroke};

/// Canvas units in one CSS px.
pub(super) const UNIT: f64 = 4.0;

/// Fonts asked for in the SVG. The first is the one the PNG is drawn with and
/// texts are measured by; the others are its common stand-ins.
const FAMILY: &str = "Noto Sans, DejaVu Sans, Verdana, Segoe UI, Helvetica Neue, Arial, sans-serif";

/// Plotters gives a font the size `1 / 1.24` of what it is asked for.
const FONT_SIZE: f64 = 1.24 * UNIT;

/// The drawing area behind the canvas.
pub(super) type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// A place on the canvas, in canvas units.
pub(super) type Spot = (i32, i32);

/// A rectangle in CSS px.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Rect {
    pub left: f64,
    pub top: f64,
    pub right: f64,
    pub bottom: f64,
}

impl Rect {
    pub fn width(&self) -> f64 {
        self.right - self.left
    }

    pub fn height(&self) -> f64 {
        self.bottom - self.top
    }

    pub fn overlaps(&self, other: &Rect) -> bool {
        self.left < other.right
            && other.left < self.right
            && self.top < other.bottom
            && other.top < self.bottom
    }

    pub fn contains(&self, (x, y): (f64, f64)) -> bool {
        (self.left..=self.right).contains(&x) && (self.top..=self.bottom).contains(&y)
    }
}

/// Size, weight and side of a text; it is centred on its height.
#[derive(Clone, Copy)]
pub(super) struct Letters {
    /// Font size, CSS px.
    pub size: f64,
    pub bold: bool,
    pub color: Color,
    pub side: HPos,
}

impl Letters {
    pub fn new(size: f64) -> Self {
        Self {
            size,
            bold: false,
            color: Color::INK,
            side: HPos::Left,
        }
    }

    pub fn bold(mut self) -> Self {
        self.bold = true;
        self
    }

    pub fn color(mut self, color: Color) -> Self {
        self.color = color;
        self
    }

    pub fn side(mut self, side: HPos) -> Self {
        self.side = side;
        self
    }

    /// The style as the drawing library wants it.
    pub fn style(&self) -> TextStyle<'static> {
        let weight = if self.bold {
            FontStyle::Bold
        } else {
            FontStyle::Normal
        };
        (FAMILY, self.size * FONT_SIZE, weight)
            .into_font()
            .color(&rgb(self.color))
            .pos(Pos::new(self.side, VPos::Center))
    }

    /// Width of `text` in CSS px.
    pub fn width(&self, text: &str) -> f64 {
        let bytes = if self.bold {
            notosans::BOLD_TTF
        } else {
            notosans::REGULAR_TTF
        };
        let crude = 0.6 * self.size * text.chars().count() as f64;
        let Ok(font) = FontRef::try_from_slice(bytes) else {
            return crude;
        };
        let Some(em) = font.units_per_em() else {
            return crude;
        };
        let advance: f32 = text
            .chars()
            .map(|c| font.h_advance_unscaled(font.glyph_id(c)))
            .sum();
        f64::from(advance / em) * self.size
    }
}

/// Draws on an area in CSS px.
pub(super) struct Canvas<'a, 'b> {
    pub area: &'b Area<'a>,
    /// Elements of images, in the order of their markers.
    pub images: &'b RefCell<Vec<String>>,
}

/// Stands around the number of an image in the text that is written in its place; never in another text.
const MARKER: char = '\u{E000}';

/// Puts `images` where their markers stand in `svg`.
pub(super) fn place_images(svg: &str, images: &[String]) -> String {
    let mut out = String::with_capacity(svg.len() + images.iter().map(String::len).sum::<usize>());
    let mut rest = svg;
    for (k, image) in images.iter().enumerate() {
        let marker = format!("{MARKER}{k}{MARKER}");
        let Some((before, after)) = rest.split_once(&marker) else {
            continue;
        };
        out += before.rsplit_once("<text").map_or(before, |b| b.0);
        out += image;
        rest = after.split_once("</text>").map_or(after, |a| a.1);
    }
    out + rest
}

impl Canvas<'_, '_> {
    /// Writes `text` with its middle height at `at`.
    pub fn text(&self, text: &str, at: (f64, f64), letters: Letters) -> Result<(), PictureError> {
        if text.is_empty() {
            return Ok(());
        }
        let drawn = self
            .area
            .draw_text(&printable(text), &letters.style(), spot(at));
        drawn.map_err(library)
    }

    /// Writes `text` turned, with its middle at `at`.
    pub fn turned_text(
        &self,
        text: &str,
        at: (f64, f64),
        letters: Letters,
        turn: FontTransform,
    ) -> Result<(), PictureError> {
        let style = letters.style().transform(turn);
        self.area.draw_text(text, &style, spot(at)).map_err(library)
    }

    /// Shows an image's `element` over what is drawn so far.
    pub fn image(&self, element: String) -> Result<(), PictureError> {
        let mut images = self.images.borrow_mut();
        let marker = format!("{MARKER}{}{MARKER}", images.len());
        images.push(element);
        let written = self
            .area
            .draw_text(&marker, &Letters::new(1.0).style(), (0, 0));
        written.map_err(library)
    }

    /// Joins spots; `width` in CSS px.
    pub fn path(
        &self,
        spots: Vec<Spot>,
        color: Color,
        width: f64,
        stroke: Stroke,
    ) -> Result<(), PictureError> {
        let style = rgb(color).stroke_width(units(width).max(1) as u32);
        let (dash, gap) = match stroke {
            Stroke::Solid => {
                return self
                    .area
                    .draw(&PathElement::new(spots, style))
                    .map_err(library);
            }
            Stroke::Dashed => (units(6.0), units(4.0)),
            Stroke::Dotted => (units(width.max(1.0) * 1.2), units(width.max(1.0) * 2.2)),
        };
        let element = DashedPathElement::new(spots, dash, gap, style);
        self.area.draw(&element).map_err(library)
    }

    /// A straight line between places in CSS px.
    pub fn line(
        &self,
        ends: [(f64, f64); 2],
        color: Color,
        width: f64,
        stroke: Stroke,
    ) -> Result<(), PictureError> {
        self.path(ends.map(spot).to_vec(), color, width, stroke)
    }

    /// A filled rectangle; `alpha` from 0 (unseen) to 1.
    pub fn fill(&self, rect: Rect, color: Color, alpha: f64) -> Result<(), PictureError> {
        let corners = [spot((rect.left, rect.top)), spot((rect.right, rect.bottom))];
        let element = Rectangle::new(corners, rgb(color).mix(alpha).filled());
        self.area.draw(&element).map_err(library)
    }

    /// A circle outline, e.g. around a chosen point.
    pub fn ring(
        &self,
        at: Spot,
        radius: f64,
        color: Color,
        width: f64,
    ) -> Result<(), PictureError> {
        let style = rgb(color).stroke_width(units(width).max(1) as u32);
        let element = Circle::new(at, units(radius), style);
        self.area.draw(&element).map_err(library)
    }

    /// A point of half size `radius`, CSS px; shapes are weighed to look alike in size.
    pub fn mark(
        &self,
        (x, y): Spot,
        mark: Mark,
        radius: f64,
        color: Color,
    ) -> Result<(), PictureError> {
        let ink = rgb(color);
        let shape = |corners: &[(f64, f64)]| -> Vec<Spot> {
            let place = |(dx, dy): &(f64, f64)| (x + units(dx * radius), y + units(dy * radius));
            corners.iter().map(place).collect()
        };
        let polygon = |corners: &[(f64, f64)]| {
            let element = Polygon::new(shape(corners), ink.filled());
            self.area.draw(&element).map_err(library)
        };
        let bars = |ends: [[(f64, f64); 2]; 2]| {
            ends.iter().try_for_each(|bar| {
                self.path(shape(bar), color, (radius * 0.55).max(0.8), Stroke::Solid)
            })
        };
        match mark {
            Mark::Circle => {
                let element = Circle::new((x, y), units(radius), ink.filled());
                self.area.draw(&element).map_err(library)
            }
            Mark::Ring => self.ring((x, y), radius * 0.9, color, (radius * 0.45).max(0.8)),
            Mark::Square => polygon(&[(-0.9, -0.9), (0.9, -0.9), (0.9, 0.9), (-0.9, 0.9)]),
            Mark::Triangle => polygon(&[(0.0, -1.25), (1.15, 0.8), (-1.15, 0.8)]),
            Mark::Diamond => polygon(&[(0.0, -1.3), (1.1, 0.0), (0.0, 1.3), (-1.1, 0.0)]),
            Mark::Plus => bars([[(-1.2, 0.0), (1.2, 0.0)], [(0.0, -1.2), (0.0, 1.2)]]),
            Mark::Cross => bars([[(-1.0, -1.0), (1.0, 1.0)], [(-1.0, 1.0), (1.0, -1.0)]]),
        }
    }
}

/// CSS px to canvas units.
pub(super) fn units(px: f64) -> i32 {
    (px * UNIT).round() as i32
}

/// A place in CSS px as a place on the canvas.
pub(super) fn spot((x, y): (f64, f64)) -> Spot {
    (units(x), units(y))
}

/// A place on the canvas in CSS px.
pub(super) fn px((x, y): Spot) -> (f64, f64) {
    (f64::from(x) / UNIT, f64::from(y) / UNIT)
}

/// A colour as the drawing library wants it.
pub(super) fn rgb(color: Color) -> RGBColor {
    RGBColor(color.0, color.1, color.2)
}

/// Wraps a failure of the drawing library.
pub(super) fn library(error: impl std::fmt::Display) -> PictureError {
    PictureError::Library(error.to_string())
}

/// Control characters have no place in an SVG; they become spaces.
pub(super) fn printable(text: &str) -> String {
    let swap = |c: char| {
        if c.is_control() || matches!(c, MARKER | '\u{FFFE}' | '\u{FFFF}') {
            ' '
        } else {
            c
        }
    };
    text.chars().map(swap).collect()
}
