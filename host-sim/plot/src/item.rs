//! What can be drawn in a panel.

use super::{Color, Mark, Point, Raster, Stroke, Style};

/// Something drawn in a panel.
#[derive(Debug, Clone, PartialEq)]
pub struct Item {
    /// Name in the legend, above a vertical line or beside a ringed point; an empty one is left out. Cells have names of
    /// their own.
    pub label: String,
    /// Its colour. Areas and bands are drawn thin enough to read curves over them; cells have colours of their own.
    pub color: Color,
    /// What is drawn.
    pub shape: Shape,
}

/// What an item draws.
#[derive(Debug, Clone, PartialEq)]
pub enum Shape {
    /// Joined points; a point that is not finite interrupts the line.
    Line {
        /// The points in drawing order.
        points: Vec<Point>,
        /// Thickness of the line, px.
        width: f64,
        /// Solid, dashed or dotted.
        stroke: Stroke,
    },
    /// Separate points; those not finite are left out.
    Points {
        /// The points; a later one covers an earlier one.
        points: Vec<Point>,
        /// Half the size of a mark, px.
        radius: f64,
        /// Shape of a mark.
        mark: Mark,
    },
    /// Any number of points, a dot each, drawn as one image.
    Cloud {
        /// The points; those not finite are left out.
        points: Vec<Point>,
        /// Side of a dot, px; at least one pixel of the PNG.
        dot: f64,
    },
    /// A shaded area, e.g. between the smallest and the largest of something: its outline, finite points in order.
    Area(Vec<Point>),
    /// Cells of colour, drawn as one image.
    Raster(Raster),
    /// A shaded vertical band, e.g. the safe operating band.
    BandX {
        /// One edge, in x units.
        from: f64,
        /// The other edge, in x units.
        to: f64,
    },
    /// A vertical line with its name above the plot, e.g. a period doubling.
    MarkX {
        /// Where, in x units.
        x: f64,
        /// Solid, dashed or dotted.
        stroke: Stroke,
    },
    /// A ringed point with its name beside it, e.g. the chosen operating point; where, in x and y units.
    MarkPoint(Point),
}

impl Item {
    /// An item from its parts.
    pub fn new(label: impl Into<String>, color: Color, shape: Shape) -> Self {
        Self {
            label: label.into(),
            color,
            shape,
        }
    }

    /// A line of this stroke and thickness, px.
    pub fn curve(
        label: impl Into<String>,
        color: Color,
        (stroke, width): (Stroke, f64),
        points: Vec<Point>,
    ) -> Self {
        let shape = Shape::Line {
            points,
            width,
            stroke,
        };
        Self::new(label, color, shape)
    }

    /// A solid line, 1.6 px thick.
    pub fn line(label: impl Into<String>, color: Color, points: Vec<Point>) -> Self {
        Self::curve(label, color, (Stroke::Solid, 1.6), points)
    }

    /// A dashed line, 1.6 px thick.
    pub fn dashed(label: impl Into<String>, color: Color, points: Vec<Point>) -> Self {
        Self::curve(label, color, (Stroke::Dashed, 1.6), points)
    }

    /// Points of this shape and radius, px.
    pub fn marks(
        label: impl Into<String>,
        color: Color,
        (mark, radius): (Mark, f64),
        points: Vec<Point>,
    ) -> Self {
        let shape = Shape::Points {
            points,
            radius,
            mark,
        };
        Self::new(label, color, shape)
    }

    /// Round points of 2.5 px radius.
    pub fn points(label: impl Into<String>, color: Color, points: Vec<Point>) -> Self {
        Self::marks(label, color, (Mark::Circle, 2.5), points)
    }

    /// Any number of points: dots of 1 px up to 50,000 of them, of half a px beyond.
    pub fn cloud(label: impl Into<String>, color: Color, points: Vec<Point>) -> Self {
        let dot = if points.len() > 50_000 { 0.5 } else { 1.0 };
        Self::new(label, color, Shape::Cloud { points, dot })
    }

    /// Cells of colour.
    pub fn raster(raster: Raster) -> Self {
        Self::new("", Color::INK, Shape::Raster(raster))
    }

    /// Points of 3 px radius in the colour and shape of `style`.
    pub fn styled_points(label: impl Into<String>, style: Style, points: Vec<Point>) -> Self {
        Self::marks(label, style.color, (style.mark, 3.0), points)
    }

    /// The area between a lower and an upper value at each x: (x, lower, upper).
    pub fn between(label: impl Into<String>, color: Color, values: &[[f64; 3]]) -> Self {
        let lower = values.iter().map(|[x, lower, _]| (*x, *lower));
        let upper = values.iter().rev().map(|[x, _, upper]| (*x, *upper));
        Self::new(label, color, Shape::Area(lower.chain(upper).collect()))
    }

    /// A green band from one x to another.
    pub fn band_x(label: impl Into<String>, from: f64, to: f64) -> Self {
        Self::new(label, Color::GREEN, Shape::BandX { from, to })
    }

    /// A dashed dark vertical line at `x`.
    pub fn mark_x(label: impl Into<String>, x: f64) -> Self {
        let stroke = Stroke::Dashed;
        Self::new(label, Color::INK, Shape::MarkX { x, stroke })
    }

    /// A dark ring around `(x, y)`.
    pub fn mark_point(label: impl Into<String>, x: f64, y: f64) -> Self {
        Self::new(label, Color::INK, Shape::MarkPoint((x, y)))
    }
}
