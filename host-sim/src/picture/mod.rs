//! Scientific figures: a small description, drawn as SVG or PNG.
//!
//! A [`Figure`] holds [`Panel`]s in a grid; a panel holds two [`Axis`] and
//! a list of [`Item`]s. Nothing here reads the disk or the system: the letters
//! of the PNG come from a font compiled into the program (Noto Sans, SIL Open
//! Font License 1.1), and the same figure always gives the same bytes.
//!
//! ```
//! use host_sim::picture::{Axis, Figure, Item, Panel, regime_color, render_svg};
//!
//! let curve = (0..50).map(|i| (20.0 + f64::from(i), 300.0 + 5.0 * f64::from(i))).collect();
//! let figure = Figure::new("Impact force over drive frequency").panel(
//!     Panel::new(Axis::new("frequency, Hz"), Axis::new("peak force, N"))
//!         .item(Item::line("1/1", regime_color("1/1"), curve))
//!         .item(Item::mark_x("period doubling", 52.0)),
//! );
//! let svg = render_svg(&figure)?;
//! assert!(svg.contains("peak force, N"));
//! # Ok::<(), host_sim::picture::PictureError>(())
//! ```

mod canvas;
mod layout;
mod names;
mod palette;
mod panel;
mod render;
mod series;
#[cfg(test)]
mod tests;
pub(crate) mod ticks;

pub use palette::{Color, Mark, OTHER_PERIODIC, RegimeStyle, Stroke, regime_color, regime_style};
pub use render::{PNG_SCALE, render_png, render_svg};

/// A point in data coordinates: `(x, y)` in the units of the two axes.
pub type Point = (f64, f64);

/// Why a figure could not be drawn.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum PictureError {
    /// The figure's width or height is outside what can be drawn.
    #[error(
        "a picture of {width} x {height} px cannot be drawn; choose between 200 and 8000 px a side"
    )]
    Size {
        /// Width asked for, px.
        width: u32,
        /// Height asked for, px.
        height: u32,
    },
    /// No room is left for the curves beside titles, legend and labels.
    #[error("no room is left to draw panel {panel}; make the picture larger or the legend shorter")]
    Crowded {
        /// Which panel, counted from 1.
        panel: usize,
    },
    /// A drawing library refused; this is a fault of the program.
    #[error("the drawing library failed: {0}; please report this as a bug")]
    Library(String),
}

/// A whole picture: title, explanation and a grid of panels.
#[derive(Debug, Clone, PartialEq)]
pub struct Figure {
    /// Bold first line.
    pub title: String,
    /// Smaller text under the title (rig, seed, method); wrapped; may be empty.
    pub subtitle: String,
    /// The panels, filled row by row.
    pub panels: Vec<Panel>,
    /// Panels beside one another; 1 stacks them all.
    pub columns: usize,
    /// Width and height in CSS px (a PNG has [`PNG_SCALE`] times as many pixels).
    pub size: (u32, u32),
}

impl Figure {
    /// An empty figure of 960 x 600 px with one column.
    pub fn new(title: impl Into<String>) -> Self {
        Self {
            title: title.into(),
            subtitle: String::new(),
            panels: Vec::new(),
            columns: 1,
            size: (960, 600),
        }
    }

    /// Sets the explanation under the title.
    pub fn subtitle(mut self, text: impl Into<String>) -> Self {
        self.subtitle = text.into();
        self
    }

    /// Sets how many panels stand beside one another.
    pub fn columns(mut self, columns: usize) -> Self {
        self.columns = columns;
        self
    }

    /// Sets width and height in CSS px.
    pub fn size(mut self, width: u32, height: u32) -> Self {
        self.size = (width, height);
        self
    }

    /// Adds a panel.
    pub fn panel(mut self, panel: Panel) -> Self {
        self.panels.push(panel);
        self
    }
}

/// One coordinate system with its curves.
#[derive(Debug, Clone, PartialEq)]
pub struct Panel {
    /// Bold line over the panel; may be empty.
    pub title: String,
    /// Horizontal axis.
    pub x: Axis,
    /// Vertical axis.
    pub y: Axis,
    /// What is drawn, first at the bottom (bands always lie beneath).
    pub items: Vec<Item>,
    /// Whether labelled lines, points and bands are named above the plot.
    pub legend: bool,
}

impl Panel {
    /// An empty panel with a legend.
    pub fn new(x: Axis, y: Axis) -> Self {
        Self {
            title: String::new(),
            x,
            y,
            items: Vec::new(),
            legend: true,
        }
    }

    /// Sets the line over the panel.
    pub fn titled(mut self, title: impl Into<String>) -> Self {
        self.title = title.into();
        self
    }

    /// Adds something to draw.
    pub fn item(mut self, item: Item) -> Self {
        self.items.push(item);
        self
    }

    /// Leaves the legend out.
    pub fn without_legend(mut self) -> Self {
        self.legend = false;
        self
    }
}

/// A linear axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    /// Quantity and unit, e.g. `"impact force, N"`.
    pub label: String,
    /// What part of the number line it shows.
    pub range: Range,
}

impl Axis {
    /// An axis that shows all its data.
    pub fn new(label: impl Into<String>) -> Self {
        Self {
            label: label.into(),
            range: Range::Auto,
        }
    }

    /// Shows exactly `from..to`; what lies outside is cut off.
    pub fn fixed(mut self, from: f64, to: f64) -> Self {
        self.range = Range::Fixed(from, to);
        self
    }

    /// Shows all its data and zero.
    pub fn with_zero(mut self) -> Self {
        self.range = Range::WithZero;
        self
    }
}

/// What part of the number line an axis shows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Range {
    /// All finite data with a small margin.
    Auto,
    /// All finite data and zero, with a small margin away from zero.
    WithZero,
    /// Exactly these ends. Ends that are equal or not finite fall back to `Auto`.
    Fixed(f64, f64),
}

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
        /// Thickness, px.
        width: f64,
        /// Solid, dashed or dotted.
        stroke: Stroke,
    },
    /// Separate points; those not finite are left out.
    Points {
        /// The points.
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
    /// A solid line, 1.6 px thick.
    pub fn line(label: impl Into<String>, color: Color, points: Vec<Point>) -> Self {
        Self::Line {
            points,
            color,
            label: label.into(),
            width: 1.6,
            stroke: Stroke::Solid,
        }
    }

    /// A dashed line, 1.6 px thick.
    pub fn dashed(label: impl Into<String>, color: Color, points: Vec<Point>) -> Self {
        Self::Line {
            points,
            color,
            label: label.into(),
            width: 1.6,
            stroke: Stroke::Dashed,
        }
    }

    /// Round points of 2.5 px radius.
    pub fn points(label: impl Into<String>, color: Color, points: Vec<Point>) -> Self {
        Self::Points {
            points,
            color,
            label: label.into(),
            radius: 2.5,
            mark: Mark::Circle,
        }
    }

    /// Points of one regime in its own colour and shape ([`regime_style`]),
    /// named by the regime.
    pub fn regime_points(regime: &str, points: Vec<Point>) -> Self {
        let style = regime_style(regime);
        Self::Points {
            points,
            color: style.color,
            label: regime.to_owned(),
            radius: 3.0,
            mark: style.mark,
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
