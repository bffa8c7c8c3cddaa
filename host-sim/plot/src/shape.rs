//! What a picture is made of: shapes in drawing order, from which SVG and PNG are written.

use std::cell::RefCell;
use std::convert::Infallible;

use plotters::style::FontTransform;
use plotters::style::text_anchor::Pos;
use plotters_backend::{
    BackendColor, BackendStyle, BackendTextStyle, DrawingBackend, DrawingErrorKind, FontStyle,
};

use super::Color;
use super::raster::PixelImage;

/// A place on the canvas, in canvas units.
pub(super) type Spot = (i32, i32);

/// A colour and how much it covers, from 0 (unseen) to 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Ink {
    pub color: Color,
    pub alpha: f64,
}

/// One thing drawn; all lengths are in canvas units.
pub(super) enum DrawnShape {
    Line {
        ends: [Spot; 2],
        width: u32,
        ink: Ink,
    },
    Polyline {
        spots: Vec<Spot>,
        width: u32,
        ink: Ink,
    },
    /// A polygon filled with its ink.
    Polygon {
        corners: Vec<Spot>,
        ink: Ink,
    },
    /// An upright rectangle filled with its ink, by two opposite corners.
    Rectangle {
        corners: [Spot; 2],
        ink: Ink,
    },
    Circle {
        middle: Spot,
        radius: u32,
        outline: Option<u32>,
        ink: Ink,
    },
    Text(Text),
    /// Pixels between two corners, cut to those of `frame`.
    Image {
        pixels: PixelImage,
        corners: [Spot; 2],
        frame: [Spot; 2],
    },
}

/// A line of letters.
pub(super) struct Text {
    pub letters: String,
    pub at: Spot,
    /// Font size in canvas units.
    pub size: f64,
    pub bold: bool,
    pub ink: Ink,
    /// Which part of the text is at `at`.
    pub anchor: Pos,
    /// Turn about `at`, clockwise degrees.
    pub turn: u16,
}

/// Collects what the drawing library draws.
pub(super) struct ShapeRecorder<'a> {
    /// Width and height of the canvas.
    pub size: (u32, u32),
    pub shapes: &'a RefCell<Vec<DrawnShape>>,
}

type Recorded = Result<(), DrawingErrorKind<Infallible>>;

impl ShapeRecorder<'_> {
    /// Keeps the shape made of `color`, unless it cannot be seen.
    fn keep(&self, color: BackendColor, shape: impl FnOnce(Ink) -> DrawnShape) -> Recorded {
        let (r, g, b) = color.rgb;
        let ink = Ink {
            color: Color(r, g, b),
            alpha: color.alpha,
        };
        if ink.alpha != 0.0 {
            self.shapes.borrow_mut().push(shape(ink));
        }
        Ok(())
    }
}

impl DrawingBackend for ShapeRecorder<'_> {
    type ErrorType = Infallible;

    fn get_size(&self) -> (u32, u32) {
        self.size
    }

    fn ensure_prepared(&mut self) -> Recorded {
        Ok(())
    }

    fn present(&mut self) -> Recorded {
        Ok(())
    }

    fn draw_pixel(&mut self, (x, y): Spot, color: BackendColor) -> Recorded {
        let corners = [(x, y), (x + 1, y + 1)];
        self.keep(color, |ink| DrawnShape::Rectangle { corners, ink })
    }

    fn draw_line<S: BackendStyle>(&mut self, from: Spot, to: Spot, style: &S) -> Recorded {
        self.keep(style.color(), |ink| DrawnShape::Line {
            ends: [from, to],
            width: style.stroke_width(),
            ink,
        })
    }

    fn draw_rect<S: BackendStyle>(
        &mut self,
        (left, top): Spot,
        (right, bottom): Spot,
        style: &S,
        fill: bool,
    ) -> Recorded {
        if !fill {
            let corners = [(right, top), (right, bottom), (left, bottom)];
            let outline = [(left, top)].into_iter().chain(corners);
            return self.draw_path(outline.chain([(left, top)]), style);
        }
        let corners = [(left, top), (right, bottom)];
        self.keep(style.color(), |ink| DrawnShape::Rectangle { corners, ink })
    }

    fn draw_path<S: BackendStyle, I: IntoIterator<Item = Spot>>(
        &mut self,
        path: I,
        style: &S,
    ) -> Recorded {
        self.keep(style.color(), |ink| DrawnShape::Polyline {
            spots: path.into_iter().collect(),
            width: style.stroke_width(),
            ink,
        })
    }

    fn fill_polygon<S: BackendStyle, I: IntoIterator<Item = Spot>>(
        &mut self,
        path: I,
        style: &S,
    ) -> Recorded {
        self.keep(style.color(), |ink| DrawnShape::Polygon {
            corners: path.into_iter().collect(),
            ink,
        })
    }

    fn draw_circle<S: BackendStyle>(
        &mut self,
        middle: Spot,
        radius: u32,
        style: &S,
        fill: bool,
    ) -> Recorded {
        self.keep(style.color(), |ink| DrawnShape::Circle {
            middle,
            radius,
            outline: (!fill).then(|| style.stroke_width()),
            ink,
        })
    }

    fn draw_text<S: BackendTextStyle>(&mut self, text: &str, style: &S, at: Spot) -> Recorded {
        self.keep(style.color(), |ink| {
            DrawnShape::Text(Text {
                letters: text.to_owned(),
                at,
                size: style.size() / super::canvas::LIBRARY_FONT_SIZE,
                bold: matches!(style.style(), FontStyle::Bold),
                ink,
                anchor: style.anchor(),
                turn: match style.transform() {
                    FontTransform::Rotate90 => 90,
                    FontTransform::Rotate180 => 180,
                    FontTransform::Rotate270 => 270,
                    _ => 0,
                },
            })
        })
    }
}
