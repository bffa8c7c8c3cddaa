//! One panel: title, legend, marker names, axes, and the data in its frame.

use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter};
use plotters::prelude::*;
use plotters::style::Color as _;
use plotters::style::text_anchor::HPos;

use super::canvas::{Canvas, Letters, Rect, library, printable, px, rgb, spot, units};
use super::data::{self, along, band, window};
use super::layout::fit;
use super::names::{MARKER_ROW, legend, marked_points, markers};
use super::series::DataWindow;
use super::ticks::Ticks;
use super::{Axis, Color, Panel, PictureError, Shape, Stroke, colorbar};

const TICK: f64 = 4.0;
const TICK_TEXT: f64 = 12.0;
const AXIS_TEXT: f64 = 13.0;
const TITLE_ROW: f64 = 22.0;
const BOTTOM: f64 = 42.0;
const FRAME: Color = Color(0x55, 0x55, 0x55);
const GRID: Color = Color(0xE4, 0xE4, 0xE4);

/// What the axis label and the tick labels need left of the frame, px.
pub(super) fn left_margin(panel: &Panel, cell: Rect) -> f64 {
    let (window, _) = window(panel);
    widest(&y_ticks(panel, window, cell)) + 2.0 * TICK + 26.0
}

/// Draws `panel`, the `number`-th counted from 1, inside `cell` with its frame
/// `left_margin` px from the cell's edge.
pub(super) fn draw(
    canvas: &Canvas,
    cell: Rect,
    panel: &Panel,
    number: usize,
    left_margin: f64,
) -> Result<(), PictureError> {
    let crowded = PictureError::Crowded { panel: number };
    let (window, has_data) = window(panel);

    // Sideways: the tick labels decide the margins.
    let y_ticks = y_ticks(panel, window, cell);
    let bar = colorbar::bar(panel);
    let bar_room = bar.map_or(0.0, |bar| colorbar::room(bar, cell.height() - 90.0));
    let room = cell.width() - left_margin - bar_room;
    if room < 60.0 {
        return Err(crowded);
    }
    let x_ticks = (2..=tick_count(room, 36.0))
        .rev()
        .map(|most| ticks(&panel.x, window.x, most))
        .find(|t| t.values.len() as f64 * (widest(t) + 16.0) <= room)
        .unwrap_or_else(|| ticks(&panel.x, window.x, 2));
    let mut frame = Rect {
        left: cell.left + left_margin,
        top: cell.top,
        right: cell.right - (widest(&x_ticks) / 2.0).max(8.0).max(bar_room),
        bottom: cell.bottom - BOTTOM,
    };

    // Downwards: title, legend, marker names, plot.
    if !panel.title.is_empty() {
        let letters = Letters::new(14.0).bold();
        let title = fit(&panel.title, letters, frame.width());
        canvas.text(&title, (frame.left, frame.top + 9.0), letters)?;
        frame.top += TITLE_ROW;
    }
    if panel.legend {
        frame.top = legend(canvas, frame, &panel.items)?;
    }
    let markers = markers(panel, window, frame);
    let named = markers.iter().filter(|m| m.is_named());
    let rows = named.map(|m| m.slot.row + 1).max().unwrap_or(0);
    frame.top += rows as f64 * MARKER_ROW + 4.0;
    if frame.height() < 40.0 || frame.width() < 40.0 {
        return Err(crowded);
    }

    let axis_label = |axis: &Axis, ticks: &Ticks, room: f64| {
        let text = printable(&format!("{}{}", axis.label, ticks.factor()));
        fit(&text, Letters::new(AXIS_TEXT), room)
    };
    let x_label = axis_label(&panel.x, &x_ticks, frame.width());
    let y_label = axis_label(&panel.y, &y_ticks, frame.height());

    // The axes are the drawing library's; it also maps data to the canvas.
    let (cell_left, cell_top) = spot((cell.left, frame.top));
    let (frame_left, frame_bottom) = spot((frame.left, frame.bottom));
    let (frame_right, cell_bottom) = spot((frame.right, cell.bottom));
    let area = canvas.area.clone().shrink(
        (cell_left, cell_top),
        (frame_right - cell_left, cell_bottom - cell_top),
    );
    let mut chart = ChartBuilder::on(&area)
        .set_label_area_size(LabelAreaPosition::Left, frame_left - cell_left)
        .set_label_area_size(LabelAreaPosition::Bottom, cell_bottom - frame_bottom)
        .build_cartesian_2d(
            Scale {
                ends: window.x,
                ticks: x_ticks,
            },
            Scale {
                ends: window.y,
                ticks: y_ticks,
            },
        )
        .map_err(library)?;
    for item in &panel.items {
        if let Shape::BandX { from, to } = item.shape
            && let Some((from, to)) = band(from, to, window)
        {
            let (left, _) = px(chart.backend_coord(&(from, window.y.0)));
            let (right, _) = px(chart.backend_coord(&(to, window.y.0)));
            canvas.fill(
                Rect {
                    left,
                    right,
                    ..frame
                },
                item.color,
                0.14,
            )?;
        }
    }
    chart
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .bold_line_style(rgb(GRID).stroke_width(units(0.75) as u32))
        .axis_style(rgb(FRAME).stroke_width(units(1.0) as u32))
        .set_all_tick_mark_size(units(TICK))
        .label_style(Letters::new(TICK_TEXT).style())
        .axis_desc_style(Letters::new(AXIS_TEXT).style())
        .x_desc(x_label)
        .y_desc(y_label)
        .draw()
        .map_err(library)?;
    let to_spot = |point: (f64, f64)| chart.backend_coord(&point);

    let mut dots = Vec::new();
    for item in &panel.items {
        dots.extend(data::draw(canvas, item, (window, frame), to_spot)?);
    }
    let closing = [
        (frame.left, frame.bottom),
        (frame.left, frame.top),
        (frame.right, frame.top),
        (frame.right, frame.bottom),
        (frame.left, frame.bottom),
    ];
    canvas.path(closing.map(spot).to_vec(), FRAME, 1.0, Stroke::Solid)?;
    if let Some(bar) = bar {
        colorbar::draw(canvas, bar, frame)?;
    }
    if !has_data {
        let middle = (
            (frame.left + frame.right) / 2.0,
            (frame.top + frame.bottom) / 2.0,
        );
        let letters = Letters::new(15.0).color(Color::GREY).side(HPos::Center);
        canvas.fill(Rect::about(middle, 35.0, 9.0), Color::PAPER, 1.0)?;
        canvas.text("no data", middle, letters)?;
    }
    for marker in &markers {
        let ends = [(marker.x, frame.top), (marker.x, frame.bottom)];
        dots.extend(along(&ends.map(spot)));
        marker.draw(canvas, frame)?;
    }
    marked_points(canvas, panel, window, frame, &dots, to_spot)
}

/// An even axis with its own round numbers, as the drawing library wants it.
struct Scale {
    ends: (f64, f64),
    ticks: Ticks,
}

impl Ranged for Scale {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, (first, last): (i32, i32)) -> i32 {
        let share = (value - self.ends.0) / (self.ends.1 - self.ends.0);
        first + (share * f64::from(last - first)).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, hint: Hint) -> Vec<f64> {
        if hint.weight().allow_light_points() {
            Vec::new()
        } else {
            self.ticks.values.clone()
        }
    }

    fn range(&self) -> std::ops::Range<f64> {
        self.ends.0..self.ends.1
    }
}

impl ValueFormatter<f64> for Scale {
    fn format_ext(&self, value: &f64) -> String {
        self.ticks.label(*value)
    }
}

fn y_ticks(panel: &Panel, window: DataWindow, cell: Rect) -> Ticks {
    ticks(&panel.y, window.y, tick_count(cell.height() - 90.0, 32.0))
}

/// Ticks between two ends as the axis wants them.
fn ticks(axis: &Axis, (lo, hi): (f64, f64), most: usize) -> Ticks {
    if axis.log {
        Ticks::logarithmic(lo, hi, most)
    } else {
        let wholes = if axis.whole {
            (hi - lo).ceil() as usize
        } else {
            most
        };
        Ticks::new(lo, hi, most.min(wholes))
    }
}

/// Width of the widest label, px.
pub(super) fn widest(ticks: &Ticks) -> f64 {
    let letters = Letters::new(TICK_TEXT);
    let widths = ticks.values.iter().map(|v| letters.width(&ticks.label(*v)));
    widths.fold(0.0, f64::max)
}

/// About how many labels of `each` px fit on `length` px.
fn tick_count(length: f64, each: f64) -> usize {
    ((length / each) as usize).clamp(2, 10)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The axis ends a little beyond its data.
    #[test]
    fn an_axis_that_counts_writes_every_whole_number() {
        let axis = Axis::new("bending modes").whole();
        assert_eq!(ticks(&axis, (0.92, 3.08), 10).values, [1.0, 2.0, 3.0]);
        assert_eq!(ticks(&axis, (1.0, 3.0), 10).values, [1.0, 2.0, 3.0]);
    }
}
