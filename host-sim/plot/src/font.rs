//! The letters of the bundled font, Noto Sans (SIL Open Font License 1.1): their widths and outlines.

use std::sync::LazyLock;

use tiny_skia::{Path, PathBuilder, Transform};
use ttf_parser::{Face, GlyphId, OutlineBuilder};

/// One weight of the font.
pub(super) struct Font(Face<'static>);

static REGULAR: LazyLock<Font> = LazyLock::new(|| bundled(notosans::REGULAR_TTF));
static BOLD: LazyLock<Font> = LazyLock::new(|| bundled(notosans::BOLD_TTF));

fn bundled(file: &'static [u8]) -> Font {
    Font(Face::parse(file, 0).expect("the font compiled into the program is whole"))
}

/// The glyph of a letter that the font lacks: a box.
const MISSING: GlyphId = GlyphId(0);

impl Font {
    pub fn of(bold: bool) -> &'static Self {
        if bold { &BOLD } else { &REGULAR }
    }

    /// Font units in a font size.
    fn em(&self) -> f64 {
        f64::from(self.0.units_per_em())
    }

    fn glyph(&self, letter: char) -> GlyphId {
        self.0.glyph_index(letter).unwrap_or(MISSING)
    }

    /// How far a glyph moves the next one, font units.
    fn advance(&self, glyph: GlyphId) -> u16 {
        self.0.glyph_hor_advance(glyph).unwrap_or(0)
    }

    /// Width of a text in units of its size.
    pub fn width(&self, text: &str) -> f64 {
        let advance = |letter| u64::from(self.advance(self.glyph(letter)));
        text.chars().map(advance).sum::<u64>() as f64 / self.em()
    }

    /// The outline of a text of size 1 that begins at the origin; y points down. `None`: there is nothing to see.
    pub fn outline(&self, text: &str) -> Option<Path> {
        let mut path = PathBuilder::new();
        let scale = (1.0 / self.em()) as f32;
        let mut left = 0.0;
        for letter in text.chars() {
            let glyph = self.glyph(letter);
            let place = Transform::from_row(scale, 0.0, 0.0, -scale, left, 0.0);
            self.add(&mut path, glyph, place);
            left += f32::from(self.advance(glyph)) * scale;
        }
        path.finish()
    }

    fn add(&self, path: &mut PathBuilder, glyph: GlyphId, place: Transform) {
        let mut pen = Pen(PathBuilder::new());
        // What has no outline, as a space, adds nothing.
        let _ = self.0.outline_glyph(glyph, &mut pen);
        if let Some(outline) = pen.0.finish().and_then(|path| path.transform(place)) {
            path.push_path(&outline);
        }
    }
}

/// Draws a glyph in font units.
struct Pen(PathBuilder);

impl OutlineBuilder for Pen {
    fn move_to(&mut self, x: f32, y: f32) {
        self.0.move_to(x, y);
    }

    fn line_to(&mut self, x: f32, y: f32) {
        self.0.line_to(x, y);
    }

    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        self.0.quad_to(x1, y1, x, y);
    }

    fn curve_to(&mut self, x1: f32, y1: f32, x2: f32, y2: f32, x: f32, y: f32) {
        self.0.cubic_to(x1, y1, x2, y2, x, y);
    }

    fn close(&mut self) {
        self.0.close();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn has(font: &Font, letter: char) -> bool {
        font.0.glyph_index(letter).is_some()
    }

    #[test]
    fn it_has_the_letters_of_physics() {
        for letter in "ωφΔΩµ°²³·×±−–½≤≥…é".chars() {
            assert!(
                has(Font::of(false), letter) && has(Font::of(true), letter),
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
        assert!(!has(font, '\u{5B57}') && font.outline("\u{5B57}").is_some());
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

    /// Each glyph reaches as far as the font says.
    #[test]
    fn every_glyph_is_drawn_whole() {
        for font in [Font::of(false), Font::of(true)] {
            let bounds_of = |glyph: GlyphId| {
                let mut path = PathBuilder::new();
                font.add(&mut path, glyph, Transform::identity());
                path.finish().and_then(|path| path.compute_tight_bounds())
            };
            let mut drawn = 0;
            for k in 0..font.0.number_of_glyphs() {
                let Some(said) = font.0.glyph_bounding_box(GlyphId(k)) else {
                    continue;
                };
                let ends = [said.x_min, said.y_min, said.x_max, said.y_max].map(f32::from);
                let Some(bounds) = bounds_of(GlyphId(k)) else {
                    continue;
                };
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
