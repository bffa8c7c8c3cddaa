//! Shapes as the pixels of a PNG file.

use plotters::style::text_anchor::{HPos, VPos};
use tiny_skia::{
    FillRule, FilterQuality, Paint, Path, PathBuilder, Pattern, Pixmap, Rect, SpreadMode, Stroke,
    Transform,
};

use super::PictureError;
use super::canvas::{UNIT, library};
use super::font::Font;
use super::raster::PixelImage;
use super::render::PNG_SCALE;
use super::shape::{DrawnShape, Ink, Spot, Text};

/// The bytes of the file: `shapes` on a canvas shown `width` by `height` px, [`PNG_SCALE`] pixels each.
///
/// # Errors
/// If the picture is too large to hold or cannot be encoded.
pub(super) fn file(shapes: &[DrawnShape], size: (u32, u32)) -> Result<Vec<u8>, PictureError> {
    encoded(&painted(shapes, size)?).map_err(library)
}

fn painted(shapes: &[DrawnShape], (width, height): (u32, u32)) -> Result<Pixmap, PictureError> {
    let pixels = Pixmap::new(width * PNG_SCALE, height * PNG_SCALE);
    let scale = PNG_SCALE as f32 / UNIT as f32;
    let mut painter = Painter {
        pixels: pixels.ok_or(PictureError::Size { width, height })?,
        enlarge: Transform::from_scale(scale, scale),
    };
    for shape in shapes {
        // A shape without extent has no outline, and nothing to show.
        let _ = painter.draw(shape);
    }
    Ok(painter.pixels)
}

/// The bytes of a PNG file of `pixels`, all of which are opaque: without their opacity, and compressed fast, which takes up to twice
/// the space. (The usual compression took half the processor time of a short answer.)
fn encoded(pixels: &Pixmap) -> Result<Vec<u8>, png::EncodingError> {
    let (quads, _) = pixels.data().as_chunks::<4>();
    let colours: Vec<[u8; 3]> = quads.iter().map(|[r, g, b, _]| [*r, *g, *b]).collect();
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, pixels.width(), pixels.height());
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_compression(png::Compression::Fast);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(colours.as_flattened())?;
    writer.finish()?;
    Ok(bytes)
}

struct Painter {
    pixels: Pixmap,
    /// From canvas units to pixels.
    enlarge: Transform,
}

impl Painter {
    fn draw(&mut self, shape: &DrawnShape) -> Option<()> {
        match shape {
            DrawnShape::Line { ends, width, ink } => {
                self.stroke(&joined(ends, false)?, *width, *ink)
            }
            DrawnShape::Polyline { spots, width, ink } => {
                self.stroke(&joined(spots, false)?, *width, *ink);
            }
            DrawnShape::Polygon { corners, ink } => self.fill(&joined(corners, true)?, *ink),
            DrawnShape::Rectangle { corners, ink } => {
                self.fill(&PathBuilder::from_rect(rectangle(*corners)?), *ink);
            }
            DrawnShape::Circle {
                middle: (x, y),
                radius,
                outline,
                ink,
            } => {
                let circle = PathBuilder::from_circle(*x as f32, *y as f32, *radius as f32)?;
                match outline {
                    Some(width) => self.stroke(&circle, *width, *ink),
                    None => self.fill(&circle, *ink),
                }
            }
            DrawnShape::Text(text) => self.text(text)?,
            DrawnShape::Image {
                pixels,
                corners,
                frame,
            } => self.image(pixels, rectangle(*corners)?, rectangle(*frame)?)?,
        }
        Some(())
    }

    fn fill(&mut self, path: &Path, ink: Ink) {
        self.pixels
            .fill_path(path, &paint(ink), FillRule::Winding, self.enlarge, None);
    }

    fn stroke(&mut self, path: &Path, width: u32, ink: Ink) {
        let stroke = Stroke {
            width: width as f32,
            ..Stroke::default()
        };
        self.pixels
            .stroke_path(path, &paint(ink), &stroke, self.enlarge, None);
    }

    /// Letters as a browser places them by the SVG's attributes: spaces at the ends and repeated ones do not count, an
    /// `ex` is half a font size.
    fn text(&mut self, text: &Text) -> Option<()> {
        let words: Vec<&str> = text.letters.split(' ').filter(|w| !w.is_empty()).collect();
        let letters = words.join(" ");
        let font = Font::of(text.bold);
        let left = match text.anchor.h_pos {
            HPos::Left => 0.0,
            HPos::Center => -0.5 * font.width(&letters),
            HPos::Right => -font.width(&letters),
        };
        let down = match text.anchor.v_pos {
            VPos::Top => 0.76,
            VPos::Center => 0.25,
            VPos::Bottom => -0.25,
        };
        let (x, y) = text.at;
        let place = Transform::from_translate(x as f32, y as f32)
            .pre_rotate(f32::from(text.turn))
            .pre_scale(text.size as f32, text.size as f32)
            .pre_translate(left as f32, down);
        let outline = font.outline(&letters)?.transform(place)?;
        self.fill(&outline, text.ink);
        Some(())
    }

    /// Even cells of colour with crisp edges.
    fn image(&mut self, image: &PixelImage, place: Rect, frame: Rect) -> Option<()> {
        let pixels = image.pixels();
        let (across, down) = (pixels.width() as f32, pixels.height() as f32);
        let (width, height) = (place.width() / across, place.height() / down);
        let spread = Transform::from_row(width, 0.0, 0.0, height, place.left(), place.top());
        let paint = Paint {
            shader: Pattern::new(
                pixels.as_ref(),
                SpreadMode::Pad,
                FilterQuality::Nearest,
                1.0,
                spread,
            ),
            ..Paint::default()
        };
        let seen = PathBuilder::from_rect(place.intersect(&frame)?);
        self.pixels
            .fill_path(&seen, &paint, FillRule::Winding, self.enlarge, None);
        Some(())
    }
}

fn paint(ink: Ink) -> Paint<'static> {
    let mut paint = Paint::default();
    let alpha = (ink.alpha * 255.0).round() as u8;
    paint.set_color_rgba8(ink.color.0, ink.color.1, ink.color.2, alpha);
    paint
}

fn joined(spots: &[Spot], closed: bool) -> Option<Path> {
    let mut path = PathBuilder::new();
    for (k, (x, y)) in spots.iter().enumerate() {
        let (x, y) = (*x as f32, *y as f32);
        if k == 0 {
            path.move_to(x, y);
        } else {
            path.line_to(x, y);
        }
    }
    if closed {
        path.close();
    }
    path.finish()
}

fn rectangle([(left, top), (right, bottom)]: [Spot; 2]) -> Option<Rect> {
    Rect::from_ltrb(left as f32, top as f32, right as f32, bottom as f32)
}

#[cfg(test)]
mod tests {
    use plotters::style::text_anchor::Pos;

    use super::*;
    use crate::Color;

    const RED: Ink = Ink {
        color: Color::RED,
        alpha: 1.0,
    };

    /// First and last column and row touched, pixels, of a picture of 200 by 100 px.
    fn extent(shape: DrawnShape) -> [usize; 4] {
        let image = painted(&[shape], (200, 100)).unwrap();
        let width = image.width() as usize;
        let touched = image.pixels().iter().enumerate();
        let touched = touched.filter(|(_, p)| p.alpha() > 0);
        let places = touched.map(|(k, _)| (k % width, k / width));
        places.fold([usize::MAX, 0, usize::MAX, 0], |[a, b, c, d], (x, y)| {
            [a.min(x), b.max(x), c.min(y), d.max(y)]
        })
    }

    /// A text of 16 px with its anchor at 100, 50 px: pixel 200, 100.
    fn word(letters: &str, side: HPos, height: VPos, turn: u16) -> [usize; 4] {
        extent(DrawnShape::Text(Text {
            letters: letters.to_owned(),
            at: (100 * UNIT as i32, 50 * UNIT as i32),
            size: 16.0 * UNIT,
            bold: false,
            ink: RED,
            anchor: Pos::new(side, height),
            turn,
        }))
    }

    #[test]
    fn letters_stand_at_the_side_of_their_place() {
        let width = Font::of(false).width("HH") * 16.0 * f64::from(PNG_SCALE);
        let near = |a: usize, b: f64| (a as f64 - b).abs() <= 4.0;
        // H has room of a tenth of its size left and right.
        let [left, right, ..] = word("HH", HPos::Left, VPos::Center, 0);
        assert!(
            near(left, 203.0) && near(right, 197.0 + width),
            "{left} {right}"
        );
        let [left, right, ..] = word("HH", HPos::Right, VPos::Center, 0);
        assert!(
            near(left, 203.0 - width) && near(right, 197.0),
            "{left} {right}"
        );
        let [left, right, top, bottom] = word("HH", HPos::Center, VPos::Center, 0);
        assert!(left + right >= 398 && left + right <= 401, "{left} {right}");
        // Its base line is a quarter of the size below, and a capital 0.714 high.
        assert!(
            near(bottom, 107.0) && near(top, 108.0 - 0.714 * 32.0),
            "{top} {bottom}"
        );
        let [_, _, top, _] = word("HH", HPos::Center, VPos::Top, 0);
        assert!(near(top, 101.0), "{top}");
        let [_, _, _, bottom] = word("HH", HPos::Center, VPos::Bottom, 0);
        assert!(near(bottom, 91.0), "{bottom}");
    }

    #[test]
    fn a_quarter_turn_swaps_width_and_height_and_spaces_at_the_ends_do_not_count() {
        let [left, right, top, bottom] = word("HHH", HPos::Left, VPos::Center, 0);
        let turned = word("HHH", HPos::Left, VPos::Center, 270);
        // Reads upwards: what lay to the right is above.
        assert_eq!(turned, [top + 100, bottom + 100, 299 - right, 299 - left]);
        assert_eq!(
            word(" HHH  ", HPos::Left, VPos::Center, 0),
            [left, right, top, bottom]
        );
        assert_eq!(word(" ", HPos::Left, VPos::Center, 0), extent_of_nothing());
    }

    fn extent_of_nothing() -> [usize; 4] {
        [usize::MAX, 0, usize::MAX, 0]
    }

    #[test]
    fn an_image_is_cut_to_its_frame_and_its_cells_stay_crisp() {
        let mut pixels = PixelImage::new(2, 1).unwrap();
        pixels.set(0, 0, Color::RED);
        pixels.set(1, 0, Color::BLUE);
        let px = |x: i32, y: i32| (x * UNIT as i32, y * UNIT as i32);
        let image = |frame| DrawnShape::Image {
            pixels: pixels.clone(),
            corners: [px(10, 10), px(50, 30)],
            frame,
        };
        assert_eq!(extent(image([px(0, 0), px(100, 100)])), [20, 99, 20, 59]);
        assert_eq!(extent(image([px(20, 0), px(40, 20)])), [40, 79, 20, 39]);
        assert_eq!(extent(image([px(60, 0), px(70, 20)])), extent_of_nothing());
        let whole = painted(&[image([px(0, 0), px(100, 100)])], (200, 100)).unwrap();
        let red = |x: u32| whole.pixel(x, 40).map(|p| p.red());
        assert_eq!(
            [red(20), red(59), red(60), red(99)],
            [0xD5, 0xD5, 0, 0].map(Some)
        );
    }

    #[test]
    fn shapes_without_extent_leave_the_picture_clear() {
        for shape in [
            DrawnShape::Polyline {
                spots: Vec::new(),
                width: 4,
                ink: RED,
            },
            DrawnShape::Polyline {
                spots: vec![(5, 5)],
                width: 4,
                ink: RED,
            },
            DrawnShape::Polygon {
                corners: vec![(5, 5)],
                ink: RED,
            },
            DrawnShape::Rectangle {
                corners: [(5, 5), (5, 50)],
                ink: RED,
            },
            DrawnShape::Circle {
                middle: (5, 5),
                radius: 0,
                outline: None,
                ink: RED,
            },
        ] {
            assert_eq!(extent(shape), extent_of_nothing());
        }
    }
}
