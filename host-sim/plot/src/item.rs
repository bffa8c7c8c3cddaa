//! What can be drawn in a panel.

use super::{Color, Mark, Point, Raster, Stroke, Style};

/// Something drawn in a panel. An empty label keeps it out of the legend.
#[derive(Debug, Clone, PartialEq)]
pub enum Item {
    /// Joined points; a point that is not finite interrupts the line.
    Line {
        /// The points in drawing order.
        points: Vec<Point>,
        /// Colour of the line.
        color: Color,
        /// Name in the legend.
        label: String,
        /// Thickness of the line, px.
        width: f64,
        /// Solid, dashed or dotted.
        stroke: Stroke,
    },
    /// Separate points; those not finite are left out.
    Points {
        /// The points; a later one covers an earlier one.
        points: Vec<Point>,
        /// Colour of the marks.
        color: Color,
        /// Name in the legend.
        label: String,
        /// Half the size of a mark, px.
        radius: f64,
        /// Shape of a mark.
        mark: Mark,
    },
    /// Any number of points, a dot each, drawn as one image.
    Cloud {
        /// The points; those not finite are left out.
        points: Vec<Point>,
        /// Colour of the dots.
        color: Color,
        /// Name in the legend.
        label: String,
        /// Side of a dot, px; at least one pixel of the PNG.
        dot: f64,
    },
    /// A shaded area, e.g. between the smallest and the largest of something.
    Area {
        /// Its outline, finite points in order.
        points: Vec<Point>,
        /// Colour, drawn thin enough to read curves over it.
        color: Color,
        /// Name in the legend.
        label: String,
    },
    /// Cells of colour, drawn as one image.
    Raster(Raster),
    /// A shaded vertical band, e.g. the safe operating band.
    BandX {
        /// One edge, in x units.
        from: f64,
        /// The other edge, in x units.
        to: f64,
        /// Colour, drawn thin enough to read curves over it.
        color: Color,
        /// Name in the legend.
        label: String,
    },
    /// A vertical line with its name above the plot, e.g. a period doubling.
    MarkX {
        /// Where, in x units.
        x: f64,
        /// Name above the plot.
        label: String,
        /// Colour of line and name.
        color: Color,
        /// Solid, dashed or dotted.
        stroke: Stroke,
    },
    /// A ringed point with its name beside it, e.g. the chosen operating point.
    MarkPoint {
        /// Where, in x units.
        x: f64,
        /// Where, in y units.
        y: f64,
        /// Name beside the point.
        label: String,
        /// Colour of ring and name.
        color: Color,
    },
}

impl Item {
    /// A line of this stroke and thickness, px.
    pub fn curve(
        label: impl Into<String>,
        color: Color,
        (stroke, width): (Stroke, f64),
        points: Vec<Point>,
    ) -> Self {
        Self::Line {
            points,
            color,
            label: label.into(),
            width,
            stroke,
        }
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
        Self::Points {
            points,
            color,
            label: label.into(),
            radius,
            mark,
        }
    }

    /// Round points of 2.5 px radius.
    pub fn points(label: impl Into<String>, color: Color, points: Vec<Point>) -> Self {
        Self::marks(label, color, (Mark::Circle, 2.5), points)
    }

    /// Any number of points: dots of 1 px up to 50,000 of them, of half a px beyond.
    pub fn cloud(label: impl Into<String>, color: Color, points: Vec<Point>) -> Self {
        Self::Cloud {
            dot: if points.len() > 50_000 { 0.5 } else { 1.0 },
            points,
            color,
            label: label.into(),
        }
    }

    /// Points of 3 px radius in the colour and shape of `style`.
    pub fn styled_points(label: impl Into<String>, style: Style, points: Vec<Point>) -> Self {
        Self::marks(label, style.color, (style.mark, 3.0), points)
    }

    /// The area between a lower and an upper value at each x: (x, lower, upper).
    pub fn between(label: impl Into<String>, color: Color, values: &[[f64; 3]]) -> Self {
        let lower = values.iter().map(|[x, lower, _]| (*x, *lower));
        let upper = values.iter().rev().map(|[x, _, upper]| (*x, *upper));
        Self::Area {
            points: lower.chain(upper).collect(),
            color,
            label: label.into(),
        }
    }

    /// A green band from one x to another.
    pub fn band_x(label: impl Into<String>, from: f64, to: f64) -> Self {
        Self::BandX {
            from,
            to,
            color: Color::GREEN,
            label: label.into(),
        }
    }

    /// A dashed dark vertical line at `x`.
    pub fn mark_x(label: impl Into<String>, x: f64) -> Self {
        Self::MarkX {
            x,
            label: label.into(),
            color: Color::INK,
            stroke: Stroke::Dashed,
        }
    }

    /// A dark ring around `(x, y)`.
    pub fn mark_point(label: impl Into<String>, x: f64, y: f64) -> Self {
        Self::MarkPoint {
            x,
            y,
            label: label.into(),
            color: Color::INK,
        }
    }
}
