//! The drawing surface: lines, shapes and letters in CSS px.
//!
//! The drawing library knows whole numbers only, so the canvas is [`UNIT`] times finer than the picture.

use std::cell::RefCell;

use plotters::coord::Shift;
use plotters::element::DashedPathElement;
use plotters::prelude::*;
use plotters::style::Color as _;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::font::Font;
use super::raster::PixelImage;
use super::shape::{DrawnShape, ShapeRecorder, Spot};
use super::svg::FAMILY;
use super::{Color, Mark, PictureError, Stroke};

/// Canvas units in one CSS px.
pub(super) const UNIT: f64 = 4.0;

/// What the drawing library calls size, in font sizes.
pub(super) const LIBRARY_FONT_SIZE: f64 = 1.24;

/// The drawing area behind the canvas.
pub(super) type PictureArea<'a> = DrawingArea<ShapeRecorder<'a>, Shift>;

/// A rectangle in CSS px.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Rect {
    pub left: f64,
    pub top: f64,
    pub right: f64,
    pub bottom: f64,
}

impl Rect {
    /// From `across` left of `(x, y)` to as much right of it, and from `up` above to as much below.
    pub fn about((x, y): (f64, f64), across: f64, up: f64) -> Self {
        Self {
            left: x - across,
            top: y - up,
            right: x + across,
            bottom: y + up,
        }
    }

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
        (FAMILY, self.size * (LIBRARY_FONT_SIZE * UNIT), weight)
            .into_font()
            .color(&rgb(self.color))
            .pos(Pos::new(self.side, VPos::Center))
    }

    /// Width of `text` in CSS px.
    pub fn width(&self, text: &str) -> f64 {
        Font::of(self.bold).width(text) * self.size
    }
}

/// Draws on an area in CSS px.
pub(super) struct Canvas<'a, 'b> {
    pub area: &'b PictureArea<'a>,
    /// What is drawn so far.
    pub shapes: &'b RefCell<Vec<DrawnShape>>,
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

    /// Shows `pixels` between two corners, cut to those of `frame`.
    pub fn image(&self, pixels: PixelImage, corners: [Spot; 2], frame: [Spot; 2]) {
        self.shapes.borrow_mut().push(DrawnShape::Image {
            pixels,
            corners,
            frame,
        });
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

    /// The filled inside of an outline; `alpha` from 0 (unseen) to 1.
    pub fn fill_outline(
        &self,
        outline: Vec<Spot>,
        color: Color,
        alpha: f64,
    ) -> Result<(), PictureError> {
        let element = Polygon::new(outline, rgb(color).mix(alpha).filled());
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
        if c.is_control() || matches!(c, '\u{FFFE}' | '\u{FFFF}') {
            ' '
        } else {
            c
        }
    };
    text.chars().map(swap).collect()
}
