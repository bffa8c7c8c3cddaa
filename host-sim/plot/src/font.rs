//! The letters of the bundled font, Noto Sans (SIL Open Font License 1.1): their widths and outlines.

use std::collections::HashMap;
use std::io::Cursor;
use std::sync::LazyLock;

use tiny_skia::{Path, PathBuilder, Point, Transform};
use truetype::GlyphID;
use truetype::tables::glyph_data::{Arguments, Component, Description, Options, SimpleDescription};
use truetype::tables::{
    CharacterMapping, FontHeader, GlyphData, GlyphMapping, HorizontalHeader, HorizontalMetrics,
    MaximumProfile, Offsets, character_mapping::Encoding,
};
use truetype::tape::Read as _;
use truetype::{Error, Result, value, walue};

/// One weight of the font.
pub(super) struct Font {
    /// Font units in a font size.
    em: f64,
    letters: HashMap<u32, GlyphID>,
    metrics: HorizontalMetrics,
    outlines: GlyphData,
}

static REGULAR: LazyLock<Font> = LazyLock::new(|| bundled(notosans::REGULAR_TTF));
static BOLD: LazyLock<Font> = LazyLock::new(|| bundled(notosans::BOLD_TTF));

fn bundled(file: &[u8]) -> Font {
    Font::read(file).expect("the font compiled into the program is whole")
}

/// What stands for a letter the font lacks: an empty box.
const MISSING: GlyphID = 0;

impl Font {
    /// The regular or the bold weight.
    pub fn of(bold: bool) -> &'static Self {
        if bold { &BOLD } else { &REGULAR }
    }

    /// Reads the tables of a TrueType file.
    fn read(file: &[u8]) -> Result<Self> {
        let mut file = Tables {
            places: Cursor::new(file).take()?,
            file,
        };
        let header: FontHeader = file.table(b"head")?;
        let sizes: MaximumProfile = file.table(b"maxp")?;
        let columns: HorizontalHeader = file.table(b"hhea")?;
        let places: GlyphMapping = file.table_given(b"loca", (&header, &sizes))?;
        let mapping: CharacterMapping = file.table(b"cmap")?;
        let letters = mapping
            .encodings
            .iter()
            .find_map(|encoding| match encoding {
                Encoding::Format4(encoding) => Some(encoding.mapping()),
                Encoding::Format12(encoding) => Some(encoding.mapping()),
                _ => None,
            });
        Ok(Self {
            em: f64::from(header.units_per_em),
            letters: letters.ok_or_else(|| Error::other("no letters of Unicode"))?,
            metrics: file.table_given(b"hmtx", (&columns, &sizes))?,
            outlines: file.table_given(b"glyf", &places)?,
        })
    }

    /// Whether the font has a shape for `letter`.
    #[cfg(test)]
    pub fn has(&self, letter: char) -> bool {
        self.letters.contains_key(&u32::from(letter))
    }

    fn glyph(&self, letter: char) -> GlyphID {
        let found = self.letters.get(&u32::from(letter));
        found.copied().unwrap_or(MISSING)
    }

    /// Width of `text` in font sizes.
    pub fn width(&self, text: &str) -> f64 {
        let advance = |letter| u64::from(self.metrics.get(self.glyph(letter)).0);
        text.chars().map(advance).sum::<u64>() as f64 / self.em
    }

    /// Outline of `text` in font sizes, from the left end of its base line, y downwards; none for blank text.
    pub fn outline(&self, text: &str) -> Option<Path> {
        let mut path = PathBuilder::new();
        let scale = (1.0 / self.em) as f32;
        let mut left = 0.0;
        for letter in text.chars() {
            let glyph = self.glyph(letter);
            let place = Transform::from_row(scale, 0.0, 0.0, -scale, left, 0.0);
            self.add(&mut path, glyph, place, 0);
            left += f32::from(self.metrics.get(glyph).0) * scale;
        }
        path.finish()
    }

    /// Adds a glyph's contours, and those of the glyphs it is made of, `depth` deep within others.
    fn add(&self, path: &mut PathBuilder, glyph: GlyphID, place: Transform, depth: usize) {
        const DEEPEST: usize = 8;
        let Some(Some(glyph)) = self.outlines.get(usize::from(glyph)) else {
            return;
        };
        match &glyph.description {
            Description::Simple(shape) => add_contours(path, shape, place),
            Description::Composite(parts) if depth < DEEPEST => {
                for part in &parts.components {
                    let place = place.pre_concat(placed(part));
                    self.add(path, part.glyph_id, place, depth + 1);
                }
            }
            Description::Composite(_) => {}
        }
    }
}

/// A font file and where its tables are.
struct Tables<'a> {
    file: &'a [u8],
    places: Offsets,
}

impl<'a> Tables<'a> {
    /// The file from the start of the table called `name`.
    fn at(&self, name: &[u8; 4]) -> Result<Cursor<&'a [u8]>> {
        let found = self.places.records.iter().find(|r| &r.tag.0 == name);
        let from = found.and_then(|record| self.file.get(record.offset as usize..));
        from.map(Cursor::new)
            .ok_or_else(|| Error::other("a table is missing"))
    }

    fn table<T: value::Read>(&mut self, name: &[u8; 4]) -> Result<T> {
        self.at(name)?.take()
    }

    fn table_given<'l, T: walue::Read<'l>>(
        &mut self,
        name: &[u8; 4],
        parameter: T::Parameter,
    ) -> Result<T> {
        self.at(name)?.take_given(parameter)
    }
}

/// How a glyph lies within the one it is a part of.
fn placed(part: &Component) -> Transform {
    let (x, y) = match part.arguments {
        Arguments::Offsets(x, y) => (f32::from(x), f32::from(y)),
        // Placed by matching points; the bundled font has none (see the tests).
        Arguments::Indices(..) => (0.0, 0.0),
    };
    let (xx, xy, yx, yy) = match part.options {
        Options::None => (1.0, 0.0, 0.0, 1.0),
        Options::Scalar(s) => (s.into(), 0.0, 0.0, s.into()),
        Options::Vector(x, y) => (x.into(), 0.0, 0.0, y.into()),
        Options::Matrix(xx, xy, yx, yy) => (xx.into(), xy.into(), yx.into(), yy.into()),
    };
    Transform::from_row(xx, xy, yx, yy, x, y)
}

fn add_contours(path: &mut PathBuilder, shape: &SimpleDescription, place: Transform) {
    let (mut x, mut y) = (0.0, 0.0);
    let steps = shape.x.iter().zip(&shape.y).zip(&shape.flags);
    let mut points: Vec<(Point, bool)> = steps
        .map(|((dx, dy), flags)| {
            x += f32::from(*dx);
            y += f32::from(*dy);
            (Point::from_xy(x, y), flags.is_on_curve())
        })
        .collect();
    for (point, _) in &mut points {
        place.map_point(point);
    }
    let mut from = 0;
    for end in &shape.end_points {
        let until = (usize::from(*end) + 1).min(points.len());
        add_contour(path, &points[from.min(until)..until]);
        from = until;
    }
}

/// Adds a closed contour of points on the curve and control points of quadratic arcs. Between two control points the
/// middle is on the curve.
fn add_contour(path: &mut PathBuilder, points: &[(Point, bool)]) {
    let middle = |a: Point, b: Point| Point::from_xy((a.x + b.x) / 2.0, (a.y + b.y) / 2.0);
    let (Some(first), Some(last)) = (points.first(), points.last()) else {
        return;
    };
    let start = match (first.1, last.1) {
        (true, _) => first.0,
        (false, true) => last.0,
        (false, false) => middle(first.0, last.0),
    };
    path.move_to(start.x, start.y);
    let mut control: Option<Point> = None;
    for (to, on_curve) in points.iter().copied().chain([(start, true)]) {
        match (control, on_curve) {
            (None, true) => path.line_to(to.x, to.y),
            (Some(by), true) => path.quad_to(by.x, by.y, to.x, to.y),
            (Some(by), false) => {
                let between = middle(by, to);
                path.quad_to(by.x, by.y, between.x, between.y);
            }
            (None, false) => {}
        }
        control = (!on_curve).then_some(to);
    }
    path.close();
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_has_the_letters_of_physics() {
        for letter in "ωφΔΩµ°²³·×±−–½≤≥…é".chars() {
            assert!(
                Font::of(false).has(letter) && Font::of(true).has(letter),
                "{letter}"
            );
        }
    }

    #[test]
    fn a_letter_is_as_wide_as_the_font_says_and_one_it_lacks_is_a_box() {
        let font = Font::of(false);
        // Widths of the font's own table: n 1266, missing 1229 of 2048.
        assert_eq!(font.width("n"), 1266.0 / 2048.0);
        assert_eq!(font.width("\u{5B57}"), 1229.0 / 2048.0);
        assert_eq!(font.width("n\u{5B57}"), 2495.0 / 2048.0);
        assert!(!font.has('\u{5B57}') && font.outline("\u{5B57}").is_some());
        assert!(font.outline(" ").is_none());
    }

    /// An accented letter is its parts, each where the font puts it.
    #[test]
    fn an_accent_stands_above_its_letter() {
        for bold in [false, true] {
            let font = Font::of(bold);
            let bounds = |text: &str| font.outline(text).unwrap().bounds();
            let (plain, accented) = (bounds("e"), bounds("é"));
            assert!((accented.bottom() - plain.bottom()).abs() < 0.01);
            assert!(accented.top() < plain.top() - 0.15, "{accented:?}");
            assert!((accented.left() - plain.left()).abs() < 0.01);
            assert!((accented.right() - plain.right()).abs() < 0.01);
        }
    }

    /// Fails if a part of a glyph is placed by matching points, or parts go deeper than is followed.
    #[test]
    fn every_glyph_is_drawn_whole() {
        for font in [Font::of(false), Font::of(true)] {
            let bounds_of = |glyph: usize| {
                let mut path = PathBuilder::new();
                font.add(&mut path, glyph as GlyphID, Transform::identity(), 0);
                path.finish().and_then(|path| path.compute_tight_bounds())
            };
            let mut drawn = 0;
            for (k, glyph) in font.outlines.iter().enumerate() {
                let Some(glyph) = glyph else { continue };
                if let Description::Composite(parts) = &glyph.description {
                    let matched = |p: &Component| matches!(p.arguments, Arguments::Indices(..));
                    assert!(!parts.components.iter().any(matched), "{k}");
                }
                let ends = [glyph.min_x, glyph.min_y, glyph.max_x, glyph.max_y].map(f32::from);
                let Some(bounds) = bounds_of(k) else { continue };
                let found = [bounds.left(), bounds.top(), bounds.right(), bounds.bottom()];
                for (end, found) in ends.iter().zip(found) {
                    // The file's own bounds are whole numbers.
                    assert!((end - found).abs() <= 1.0, "{k}: {ends:?} {found}");
                }
                drawn += 1;
            }
            assert!(drawn > 2000, "{drawn}");
        }
    }
}
