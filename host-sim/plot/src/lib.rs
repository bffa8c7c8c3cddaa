//! Scientific figures: a small description, drawn as SVG or PNG.
//!
//! A [`Figure`] holds [`Panel`]s in a grid; a panel holds two [`Axis`] and
//! a list of [`Item`]s. Nothing here reads the disk or the system: the letters
//! of the PNG come from a font compiled into the program (Noto Sans, SIL Open
//! Font License 1.1), and the same figure always gives the same bytes.
//!
//! ```
//! use plot::{Axis, Color, Figure, Item, Panel, render_svg};
//!
//! let curve = (0..50).map(|i| (20.0 + f64::from(i), 300.0 + 5.0 * f64::from(i))).collect();
//! let figure = Figure::new("Impact force over drive frequency").panel(
//!     Panel::new(Axis::new("frequency, Hz"), Axis::new("peak force, N"))
//!         .item(Item::line("one impact a period", Color::BLUE, curve))
//!         .item(Item::mark_x("period doubling", 52.0)),
//! );
//! let svg = render_svg(&figure)?;
//! assert!(svg.contains("peak force, N"));
//! # Ok::<(), plot::PictureError>(())
//! ```
//!
//! # Maps and clouds of points
//!
//! What has too many parts to be drawn one by one is put into the picture as a small PNG, with crisp pixels, in the
//! SVG as well:
//!
//! - [`Item::raster`]: a grid of cells. [`Raster::categories`] for kinds, each with a name and a colour,
//!   [`Raster::values`] for a number per cell with a colour bar. Cells come row by row from the lowest y, in each row by
//!   rising x; [`edges`] gives the outer edges from the first and last centre.
//! - [`Item::cloud`]: up to millions of points, a dot each: bifurcation diagrams, sections.
//!
//! ```
//! use plot::{Axis, Bar, Color, Figure, Item, Panel, Raster, edges, render_svg};
//!
//! // Three frequencies by two gaps.
//! let x = edges(1.0, 2.0, 3);
//! let y = edges(0.0, 0.1, 2);
//! let kinds = [("impact".to_owned(), Color::BLUE), ("no impact".to_owned(), Color::GREY)];
//! let map = Raster::categories(x, y, 3, &kinds, &[Some(0), Some(0), None, Some(0), Some(1), Some(1)]);
//! let force = [1.0, 2.0, f64::NAN, 1.5, f64::NAN, f64::NAN];
//! let by_force = Raster::values(x, y, 3, &force, Bar::new("force ratio", 0.0, 2.0));
//! let hz = || Axis::new("frequency, Hz");
//! let dots = (0..50_000).map(|i| (1.0 + f64::from(i % 100) / 100.0, f64::from(i) * 2e-6));
//! let figure = Figure::new("Two maps")
//!     .columns(2)
//!     .panel(Panel::new(hz(), Axis::new("gap, mm")).item(Item::raster(map)))
//!     .panel(
//!         Panel::new(hz(), Axis::new("gap, mm"))
//!             .item(Item::raster(by_force))
//!             .item(Item::cloud("", Color::INK, dots.collect())),
//!     );
//! assert_eq!(render_svg(&figure)?.matches("<image").count(), 3);
//! # Ok::<(), plot::PictureError>(())
//! ```

mod canvas;
pub mod chart;
mod colorbar;
mod data;
mod font;
mod item;
mod layout;
mod names;
mod palette;
mod panel;
mod pixels;
mod raster;
mod render;
mod series;
mod shape;
mod svg;
#[cfg(test)]
mod tests;
mod ticks;

pub use item::{Item, Shape};
pub use palette::{Color, Mark, Stroke, Style};
pub use raster::{Bar, Raster, edges};
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
    /// Title of the picture: its first line, in bold.
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

    /// Adds a panel after those before it, row by row.
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
    /// An empty panel with a legend. The label alone makes an axis that shows all its data.
    pub fn new(x: impl Into<Axis>, y: impl Into<Axis>) -> Self {
        Self {
            title: String::new(),
            x: x.into(),
            y: y.into(),
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

    /// Adds a line with a dot at each of its points; the legend has the line.
    pub fn dotted(self, label: impl Into<String>, color: Color, points: Vec<Point>) -> Self {
        self.item(Item::line(label, color, points.clone()))
            .item(Item::points("", color, points))
    }

    /// Leaves the legend out.
    pub fn without_legend(mut self) -> Self {
        self.legend = false;
        self
    }
}

/// An axis, even or logarithmic.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    /// Quantity and unit, e.g. `"impact force, N"`.
    pub label: String,
    /// What part of the number line it shows.
    pub range: Range,
    /// Whether equal lengths are equal factors. What is not positive is left out then.
    pub log: bool,
    /// Whether only whole numbers are written at it: it counts something.
    pub whole: bool,
}

impl Axis {
    /// An axis that shows all its data.
    pub fn new(label: impl Into<String>) -> Self {
        Self {
            label: label.into(),
            range: Range::Auto,
            log: false,
            whole: false,
        }
    }

    /// Writes whole numbers only.
    pub fn whole(mut self) -> Self {
        self.whole = true;
        self
    }

    /// Makes the axis logarithmic.
    pub fn log(mut self) -> Self {
        self.log = true;
        self
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

impl From<&str> for Axis {
    fn from(label: &str) -> Self {
        Self::new(label)
    }
}

impl From<String> for Axis {
    fn from(label: String) -> Self {
        Self::new(label)
    }
}

/// What part of the number line an axis shows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Range {
    /// All finite data with a small margin (none around a raster).
    Auto,
    /// All finite data and zero, with a small margin away from zero.
    WithZero,
    /// Exactly these ends. Ends that are equal or not finite fall back to `Auto`.
    Fixed(f64, f64),
}
