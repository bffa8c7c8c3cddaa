//! What of a panel is visible, and its lines, points and images drawn.

use std::borrow::Cow;

use super::canvas::{Canvas, Rect, UNIT, px, spot};
use super::raster::PixelImage;
use super::render::PNG_SCALE;
use super::series::{DataWindow, stretches, thin};
use super::shape::Spot;
use super::ticks::{axis_range, is_drawable};
use super::{Color, Item, Mark, Panel, PictureError, Range, Shape};

/// The panel with every position on a logarithmic axis as its decimal logarithm.
pub(super) fn on_even_axes(panel: &Panel) -> Cow<'_, Panel> {
    if !panel.x.log && !panel.y.log {
        return Cow::Borrowed(panel);
    }
    let even = |log: bool, v: f64| match (log, v > 0.0) {
        (true, true) => v.log10(),
        (true, false) => f64::NAN,
        (false, _) => v,
    };
    let (on_x, on_y) = (|v| even(panel.x.log, v), |v| even(panel.y.log, v));
    let mut panel = panel.clone();
    for (axis, even) in [
        (&mut panel.x, &on_x as &dyn Fn(f64) -> f64),
        (&mut panel.y, &on_y),
    ] {
        axis.range = match axis.range {
            Range::Fixed(a, b) => Range::Fixed(even(a), even(b)),
            Range::WithZero if axis.log => Range::Auto,
            other => other,
        };
    }
    for item in &mut panel.items {
        match &mut item.shape {
            Shape::Line { points, .. }
            | Shape::Points { points, .. }
            | Shape::Area(points)
            | Shape::Cloud { points, .. } => {
                for point in points {
                    *point = (on_x(point.0), on_y(point.1));
                }
            }
            Shape::Raster(raster) => {
                raster.x = (on_x(raster.x.0), on_x(raster.x.1));
                raster.y = (on_y(raster.y.0), on_y(raster.y.1));
            }
            Shape::BandX { from, to } => (*from, *to) = (on_x(*from), on_x(*to)),
            Shape::MarkX { x, .. } => *x = on_x(*x),
            Shape::MarkPoint(at) => *at = (on_x(at.0), on_y(at.1)),
        }
    }
    Cow::Owned(panel)
}

/// The visible part of the plane, and whether anything finite is in the items.
pub(super) fn window(panel: &Panel) -> (DataWindow, bool) {
    let mut points: Vec<(f64, f64)> = Vec::new();
    // Cells fill the frame; curves keep a little off it.
    let mut margins = (0.02, 0.06);
    let (mut marked_x, mut band_x) = (Vec::new(), Vec::new());
    for item in &panel.items {
        match &item.shape {
            Shape::Line { points: p, .. }
            | Shape::Points { points: p, .. }
            | Shape::Area(p)
            | Shape::Cloud { points: p, .. } => points.extend(p),
            Shape::Raster(raster) => {
                points.extend([(raster.x.0, raster.y.0), (raster.x.1, raster.y.1)]);
                margins = (0.0, 0.0);
            }
            Shape::MarkPoint(at) => points.push(*at),
            Shape::MarkX { x, .. } => marked_x.push(*x),
            Shape::BandX { from, to } => band_x.extend([*from, *to]),
        }
    }
    points.retain(|(x, y)| is_drawable(*x) && is_drawable(*y));
    // A band may reach far beyond the data, so it sets the range only alone.
    let beside_data = if points.is_empty() { &band_x[..] } else { &[] };
    let xs = points.iter().map(|p| p.0).chain(marked_x);
    let xs = xs.chain(beside_data.iter().copied());
    let window = DataWindow {
        x: axis_range(panel.x.range, xs, margins.0),
        y: axis_range(panel.y.range, points.iter().map(|p| p.1), margins.1),
    };
    (window, !points.is_empty())
}

/// The visible part of a band.
pub(super) fn band(a: f64, b: f64, window: DataWindow) -> Option<(f64, f64)> {
    let from = a.min(b).max(window.x.0);
    let to = a.max(b).min(window.x.1);
    (from < to).then_some((from, to))
}

/// Places every few px along a line, px.
pub(super) fn along(line: &[Spot]) -> Vec<(f64, f64)> {
    const EVERY: f64 = 5.0;
    let mut places: Vec<_> = line.iter().take(1).map(|s| px(*s)).collect();
    for pair in line.windows(2) {
        let (from, to) = (px(pair[0]), px(pair[1]));
        let (dx, dy) = (to.0 - from.0, to.1 - from.1);
        let count = (dx.hypot(dy) / EVERY).ceil().max(1.0);
        let place = |k: usize| {
            let share = k as f64 / count;
            (from.0 + share * dx, from.1 + share * dy)
        };
        places.extend((1..=count as usize).map(place));
    }
    places
}

/// Draws lines and points; returns where they are, in px.
pub(super) fn draw(
    canvas: &Canvas,
    item: &Item,
    (window, frame): (DataWindow, Rect),
    to_spot: impl Fn((f64, f64)) -> Spot,
) -> Result<Vec<(f64, f64)>, PictureError> {
    let mut dots = Vec::new();
    let color = item.color;
    match &item.shape {
        Shape::Line {
            points,
            width,
            stroke,
        } => {
            for stretch in stretches(points, window) {
                let spots = thin(stretch.into_iter().map(&to_spot).collect());
                dots.extend(along(&spots));
                if let [only] = spots[..] {
                    canvas.mark(only, Mark::Circle, width.max(2.5), color)?;
                } else {
                    canvas.path(spots, color, *width, *stroke)?;
                }
            }
        }
        Shape::Points {
            points,
            radius,
            mark,
        } => {
            let inside = points.iter().copied().filter(|p| window.contains(*p));
            let mut spots: Vec<Spot> = inside.map(&to_spot).collect();
            // Marks in the same place look like one.
            spots.sort_unstable();
            spots.dedup();
            for at in spots {
                canvas.mark(at, *mark, *radius, color)?;
                dots.push(px(at));
            }
        }
        Shape::Cloud { points, dot } => {
            let inside = points.iter().copied().filter(|p| window.contains(*p));
            let spots: Vec<Spot> = inside.map(&to_spot).collect();
            cloud(canvas, &spots, (color, *dot), frame)?;
            let every = spots.len() / 2000 + 1;
            dots.extend(spots.iter().step_by(every).map(|s| px(*s)));
        }
        Shape::Area(points) => {
            let finite = points
                .iter()
                .filter(|(x, y)| x.is_finite() && y.is_finite());
            let inside = |(x, y): &(f64, f64)| {
                let x = x.clamp(window.x.0, window.x.1);
                (x, y.clamp(window.y.0, window.y.1))
            };
            canvas.fill_outline(finite.map(inside).map(&to_spot).collect(), color, 0.18)?;
        }
        Shape::Raster(raster) => {
            let corners = [
                to_spot((raster.x.0, raster.y.1)),
                to_spot((raster.x.1, raster.y.0)),
            ];
            let frame = [(frame.left, frame.top), (frame.right, frame.bottom)];
            canvas.image(raster.image()?, corners, frame.map(spot));
        }
        Shape::BandX { .. } | Shape::MarkX { .. } | Shape::MarkPoint(_) => {}
    }
    Ok(dots)
}

/// Draws dots of one colour as an image over the frame, a pixel of it a pixel of the PNG.
fn cloud(
    canvas: &Canvas,
    spots: &[Spot],
    (color, dot): (Color, f64),
    frame: Rect,
) -> Result<(), PictureError> {
    let fine = UNIT as i32 / PNG_SCALE as i32;
    let corners = [(frame.left, frame.top), (frame.right, frame.bottom)].map(spot);
    // The image begins on a whole pixel of the PNG.
    let (left, top) = (
        corners[0].0.div_euclid(fine) * fine,
        corners[0].1.div_euclid(fine) * fine,
    );
    let width = (corners[1].0 - left) / fine + 1;
    let height = (corners[1].1 - top) / fine + 1;
    let mut image = PixelImage::new(width.max(1) as usize, height.max(1) as usize)?;
    let side = (dot * f64::from(PNG_SCALE)).round().max(1.0) as i32;
    for (x, y) in spots {
        let corner = |v: i32, from: i32| (v - from).div_euclid(fine) - (side - 1) / 2;
        let (x, y) = (corner(*x, left), corner(*y, top));
        for (dx, dy) in (0..side).flat_map(|dy| (0..side).map(move |dx| (dx, dy))) {
            if let (Ok(x), Ok(y)) = (usize::try_from(x + dx), usize::try_from(y + dy)) {
                image.set(x, y, color);
            }
        }
    }
    let at = [(left, top), (left + width * fine, top + height * fine)];
    canvas.image(image, at, corners);
    Ok(())
}
