//! Images inside a picture: grids of cells and clouds of dots, as PNG in the SVG.

use base64::Engine as _;
use base64::prelude::BASE64_STANDARD;
use plotters::style::colors::colormaps::ViridisRGB;
use tiny_skia::{ColorU8, Pixmap};

use super::canvas::library;
use super::{Color, PictureError};

/// The scale of a raster of numbers: shown as a bar at the right of the panel.
#[derive(Debug, Clone, PartialEq)]
pub struct Bar {
    /// The quantity and its unit, written beside the bar.
    pub label: String,
    /// Value of the darkest colour; what is below looks like it.
    pub from: f64,
    /// Value of the lightest colour; what is above looks like it.
    pub to: f64,
}

impl Bar {
    /// A scale from one value to another, from dark blue over green to yellow (viridis: even in lightness, and read
    /// the same with every kind of colour blindness).
    pub fn new(label: impl Into<String>, from: f64, to: f64) -> Self {
        Self {
            label: label.into(),
            from,
            to,
        }
    }

    /// The colour of `value`; none for what is not a number.
    pub fn color(&self, value: f64) -> Option<Color> {
        let share = (value - self.from) / (self.to - self.from);
        let flat = self.from == self.to && value.is_finite();
        let share = if flat { 0.5 } else { share.clamp(0.0, 1.0) };
        (!share.is_nan()).then(|| {
            let color = ViridisRGB::get_color(share);
            Color(color.0, color.1, color.2)
        })
    }
}

/// A grid of even cells over a rectangle of the plane.
#[derive(Debug, Clone, PartialEq)]
pub struct Raster {
    /// Outer edges in x, rising.
    pub(super) x: (f64, f64),
    /// Outer edges in y, rising.
    pub(super) y: (f64, f64),
    columns: usize,
    /// Row by row from the lowest y; none is left clear.
    cells: Vec<Option<Color>>,
    /// What the colours mean, for the legend.
    pub(super) names: Vec<(String, Color)>,
    /// What the colours measure, for a bar.
    pub(super) bar: Option<Bar>,
}

/// The outer edges of `count` even cells whose first and last centres are given; a single cell is 1 wide.
pub fn edges(first: f64, last: f64, count: usize) -> (f64, f64) {
    let half = if count > 1 {
        0.5 * (last - first) / (count - 1) as f64
    } else {
        0.5
    };
    (first - half, last + half)
}

impl Raster {
    /// Cells of the kinds `names`: each is an index into them, or none for a clear cell. Row by row from the lowest y,
    /// `columns` in each; what is missing in the last row is clear. The legend names the kinds that occur.
    pub fn categories(
        x: (f64, f64),
        y: (f64, f64),
        columns: usize,
        names: &[(String, Color)],
        cells: &[Option<usize>],
    ) -> Self {
        let occurs = |k: &usize| cells.contains(&Some(*k));
        let named = (0..names.len()).filter(occurs).map(|k| names[k].clone());
        let color = |k: &Option<usize>| k.and_then(|k| names.get(k)).map(|n| n.1);
        Self {
            x,
            y,
            columns: columns.max(1),
            cells: cells.iter().map(color).collect(),
            names: named.collect(),
            bar: None,
        }
    }

    /// Cells of numbers on the scale of `bar`; what is not a number is left clear. See [`Raster::categories`].
    pub fn values(x: (f64, f64), y: (f64, f64), columns: usize, values: &[f64], bar: Bar) -> Self {
        Self {
            x,
            y,
            columns: columns.max(1),
            cells: values.iter().map(|v| bar.color(*v)).collect(),
            names: Vec::new(),
            bar: Some(bar),
        }
    }

    /// The cells as a picture, a pixel each, the lowest row at the bottom.
    pub(super) fn image(&self) -> Result<PixelImage, PictureError> {
        let rows = self.cells.len().div_ceil(self.columns).max(1);
        let mut image = PixelImage::new(self.columns, rows)?;
        for (i, color) in self.cells.iter().enumerate() {
            if let Some(color) = color {
                image.set(i % self.columns, rows - 1 - i / self.columns, *color);
            }
        }
        Ok(image)
    }
}

/// Pixels that are clear until set.
#[derive(Clone)]
pub(super) struct PixelImage(Pixmap);

impl PixelImage {
    pub fn new(width: usize, height: usize) -> Result<Self, PictureError> {
        let size = |n: usize| u32::try_from(n).unwrap_or(u32::MAX);
        let pixels = Pixmap::new(size(width), size(height));
        pixels.map(Self).ok_or(PictureError::Size {
            width: size(width),
            height: size(height),
        })
    }

    /// Colours the pixel `x` from the left and `y` from the top, if it is in the picture.
    pub fn set(&mut self, x: usize, y: usize, Color(r, g, b): Color) {
        let (width, height) = (self.0.width() as usize, self.0.height() as usize);
        if x < width && y < height {
            self.0.pixels_mut()[y * width + x] = ColorU8::from_rgba(r, g, b, 255).premultiply();
        }
    }

    pub fn pixels(&self) -> &Pixmap {
        &self.0
    }

    /// The bytes of a PNG file, a pixel each, written in Base64.
    pub fn base64(&self) -> Result<String, PictureError> {
        let file = self.0.encode_png().map_err(library)?;
        Ok(BASE64_STANDARD.encode(file))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edges_lie_half_a_cell_outside() {
        assert_eq!(edges(1.0, 2.0, 3), (0.75, 2.25));
        assert_eq!(edges(4.0, 4.0, 1), (3.5, 4.5));
    }

    #[test]
    fn the_first_cell_is_at_the_lower_left() {
        let kinds = [("a".to_owned(), Color::RED), ("b".to_owned(), Color::BLUE)];
        let cells = [Some(0), None, Some(1), Some(1), Some(7)];
        let raster = Raster::categories((0.0, 2.0), (0.0, 3.0), 2, &kinds, &cells);
        let image = raster.image().unwrap().0;
        assert_eq!((image.width(), image.height()), (2, 3));
        let at = |x, y| image.pixel(x, y).map(|p| (p.red(), p.alpha()));
        assert_eq!(at(0, 2), Some((0xD5, 255)));
        assert_eq!(at(1, 2), Some((0, 0)));
        assert_eq!(at(0, 1), Some((0, 255)));
        // An unknown kind and a missing cell are clear.
        assert_eq!(at(0, 0), Some((0, 0)));
        assert_eq!(at(1, 0), Some((0, 0)));
        assert_eq!(raster.names, kinds);
    }

    #[test]
    fn a_scale_is_dark_below_and_light_above_and_clear_for_no_number() {
        let bar = Bar::new("", 1.0, 3.0);
        let light = |v: f64| bar.color(v).map(|Color(r, g, b)| [r, g, b].map(u32::from));
        let sum = |v: f64| light(v).unwrap().iter().sum::<u32>();
        assert!(sum(1.0) < sum(2.0) && sum(2.0) < sum(3.0));
        assert_eq!(light(0.0), light(1.0));
        assert_eq!(light(f64::INFINITY), light(3.0));
        assert_eq!(light(f64::NAN), None);
        assert!(Bar::new("", 2.0, 2.0).color(2.0).is_some());
    }
}
