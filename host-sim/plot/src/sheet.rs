//! A page of text with pictures, as PDF: A4, one page, whatever there is to say.

use std::collections::BTreeMap;

use pdf_writer::{Content, Finish, Name, Pdf, Rect, Ref, Str, TextStr};
use plotters::style::text_anchor::{HPos, VPos};
use tiny_skia::{Path, PathBuilder, PathSegment, Transform};

use super::canvas::UNIT;
use super::font::Font;
use super::raster::Image;
use super::render::shapes;
use super::shape::{Ink, Shape, Spot, Text};
use super::{Figure, PictureError};

/// A piece of a page.
#[derive(Debug, Clone, PartialEq)]
pub enum Block {
    /// A heading.
    Heading(String),
    /// A paragraph.
    Paragraph(String),
    /// A name and what is said of it.
    Row(String, String),
    /// A picture.
    Picture(Figure),
}

/// A4, points.
const PAGE: (f32, f32) = (595.0, 842.0);
const MARGIN: f32 = 42.0;
const TITLE_SIZE: f32 = 15.0;
const HEADING_SIZE: f32 = 10.5;
const TEXT_SIZE: f32 = 8.5;
/// Height of a line over the size of its letters.
const LEADING: f32 = 1.32;
/// Width of the names of rows.
const NAMES: f32 = 146.0;
/// Space before a heading, and round a picture.
const GAP: f32 = 7.0;

const REGULAR: Name = Name(b"R");
const BOLD: Name = Name(b"B");

/// The page as the bytes of a PDF file: what is too long for one page is made smaller. Its texts are texts, in Helvetica,
/// which every reader has; the letters of pictures are shapes. A letter that the encoding of PDF's own fonts lacks is
/// written in Latin letters.
///
/// # Errors
/// As [`super::render_svg`], for a picture in it.
pub fn render_pdf(title: &str, blocks: &[Block]) -> Result<Vec<u8>, PictureError> {
    let mut sheet = Sheet {
        content: Content::new(),
        top: 0.0,
        alphas: BTreeMap::new(),
    };
    let height = height(title, blocks);
    let room = (PAGE.0 - 2.0 * MARGIN, PAGE.1 - 2.0 * MARGIN);
    let shrink = (room.1 / height).min(1.0);
    let left = MARGIN + 0.5 * room.0 * (1.0 - shrink);
    // From here on y goes down, as on the screen.
    sheet
        .content
        .transform([shrink, 0.0, 0.0, -shrink, left, PAGE.1 - MARGIN]);
    sheet.lines(title, TITLE_SIZE, true, 0.0, room.0);
    for block in blocks {
        sheet.block(block, room.0)?;
    }
    Ok(file(title, sheet))
}

/// Height of all of it, points.
fn height(title: &str, blocks: &[Block]) -> f32 {
    let width = PAGE.0 - 2.0 * MARGIN;
    let lines = |text: &str, size: f32, bold: bool, width: f32| {
        wrapped(text, size, bold, width).len() as f32 * size * LEADING
    };
    let of = |block: &Block| match block {
        Block::Heading(text) => GAP + lines(text, HEADING_SIZE, true, width),
        Block::Paragraph(text) => lines(text, TEXT_SIZE, false, width),
        Block::Row(name, text) => {
            lines(text, TEXT_SIZE, false, width - NAMES).max(lines(name, TEXT_SIZE, true, NAMES))
        }
        Block::Picture(figure) => 2.0 * GAP + width * figure.size.1 as f32 / figure.size.0 as f32,
    };
    lines(title, TITLE_SIZE, true, width) + blocks.iter().map(of).sum::<f32>()
}

/// `text` in lines of at most `width` points. Noto Sans is a little wider than Helvetica, so its measures will do.
fn wrapped(text: &str, size: f32, bold: bool, width: f32) -> Vec<String> {
    let font = Font::of(bold);
    let fits = |line: &str| font.width(line) as f32 * size <= width;
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(line) if fits(&format!("{line} {word}")) => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}

struct Sheet {
    content: Content,
    /// Where the next block begins.
    top: f32,
    /// The states of each opacity used, by thousandths.
    alphas: BTreeMap<u16, String>,
}

impl Sheet {
    fn block(&mut self, block: &Block, width: f32) -> Result<(), PictureError> {
        match block {
            Block::Heading(text) => {
                self.top += GAP;
                self.lines(text, HEADING_SIZE, true, 0.0, width);
            }
            Block::Paragraph(text) => self.lines(text, TEXT_SIZE, false, 0.0, width),
            Block::Row(name, text) => {
                let top = self.top;
                self.lines(name, TEXT_SIZE, true, 0.0, NAMES);
                let below = std::mem::replace(&mut self.top, top);
                self.lines(text, TEXT_SIZE, false, NAMES, width - NAMES);
                self.top = self.top.max(below);
            }
            Block::Picture(figure) => {
                let scale = width / (figure.size.0 as f32 * UNIT as f32);
                self.top += GAP;
                self.content.save_state();
                self.content
                    .transform([scale, 0.0, 0.0, scale, 0.0, self.top]);
                for shape in shapes(figure)? {
                    self.draw(&shape);
                }
                self.content.restore_state();
                self.top += GAP + figure.size.1 as f32 * UNIT as f32 * scale;
            }
        }
        Ok(())
    }

    fn lines(&mut self, text: &str, size: f32, bold: bool, left: f32, width: f32) {
        for line in wrapped(text, size, bold, width) {
            let base = self.top + size;
            let letters: Vec<u8> = line.chars().flat_map(encoded).collect();
            self.content.begin_text();
            self.content
                .set_font(if bold { BOLD } else { REGULAR }, size);
            self.content
                .set_text_matrix([1.0, 0.0, 0.0, -1.0, left, base]);
            self.content.show(Str(&letters));
            self.content.end_text();
            self.top += size * LEADING;
        }
    }

    fn draw(&mut self, shape: &Shape) {
        match shape {
            Shape::Line { ends, width, ink } => self.stroke_spots(ends, *width, *ink),
            Shape::Polyline { spots, width, ink } => self.stroke_spots(spots, *width, *ink),
            Shape::Polygon { corners, ink } => {
                self.ink(*ink);
                self.spots(corners);
                self.content.close_path().fill_nonzero();
            }
            Shape::Rectangle {
                corners: [(left, top), (right, bottom)],
                ink,
            } => {
                self.ink(*ink);
                let (width, height) = ((right - left) as f32, (bottom - top) as f32);
                self.content
                    .rect(*left as f32, *top as f32, width, height)
                    .fill_nonzero();
            }
            Shape::Circle {
                middle: (x, y),
                radius,
                outline,
                ink,
            } => {
                let circle = PathBuilder::from_circle(*x as f32, *y as f32, *radius as f32);
                self.ink(*ink);
                if let Some(circle) = circle {
                    self.path(&circle);
                    match outline {
                        Some(width) => self.content.set_line_width(*width as f32).stroke(),
                        None => self.content.fill_nonzero(),
                    };
                }
            }
            Shape::Text(text) => self.letters(text),
            Shape::Image {
                pixels,
                corners,
                frame,
            } => self.image(pixels, *corners, *frame),
        }
    }

    fn stroke_spots(&mut self, spots: &[Spot], width: u32, ink: Ink) {
        self.ink(ink);
        self.content.set_line_width(width as f32);
        self.spots(spots);
        self.content.stroke();
    }

    fn spots(&mut self, spots: &[Spot]) {
        for (k, (x, y)) in spots.iter().enumerate() {
            let (x, y) = (*x as f32, *y as f32);
            if k == 0 {
                self.content.move_to(x, y);
            } else {
                self.content.line_to(x, y);
            }
        }
    }

    fn path(&mut self, path: &Path) {
        let (mut x, mut y) = (0.0, 0.0);
        for segment in path.segments() {
            match segment {
                PathSegment::MoveTo(p) => {
                    self.content.move_to(p.x, p.y);
                    (x, y) = (p.x, p.y);
                }
                PathSegment::LineTo(p) => {
                    self.content.line_to(p.x, p.y);
                    (x, y) = (p.x, p.y);
                }
                // PDF has cubic curves only.
                PathSegment::QuadTo(c, p) => {
                    let third = |from: f32, to: f32| from + 2.0 / 3.0 * (to - from);
                    self.content.cubic_to(
                        third(x, c.x),
                        third(y, c.y),
                        third(p.x, c.x),
                        third(p.y, c.y),
                        p.x,
                        p.y,
                    );
                    (x, y) = (p.x, p.y);
                }
                PathSegment::CubicTo(a, b, p) => {
                    self.content.cubic_to(a.x, a.y, b.x, b.y, p.x, p.y);
                    (x, y) = (p.x, p.y);
                }
                PathSegment::Close => {
                    self.content.close_path();
                }
            }
        }
    }

    /// Letters as outlines, placed as in the PNG.
    fn letters(&mut self, text: &Text) {
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
        let outline = font
            .outline(&letters)
            .and_then(|path| path.transform(place));
        if let Some(outline) = outline {
            self.ink(text.ink);
            self.path(&outline);
            self.content.fill_nonzero();
        }
    }

    /// Cells of one colour beside one another in a row as one rectangle.
    fn image(&mut self, image: &Image, corners: [Spot; 2], frame: [Spot; 2]) {
        let pixels = image.pixels();
        let (across, down) = (pixels.width() as usize, pixels.height() as usize);
        let [(left, top), (right, bottom)] = corners;
        let width = (right - left) as f32 / across as f32;
        let height = (bottom - top) as f32 / down as f32;
        let [(x, y), (x_end, y_end)] = frame;
        self.content.save_state();
        self.content
            .rect(x as f32, y as f32, (x_end - x) as f32, (y_end - y) as f32)
            .clip_nonzero()
            .end_path();
        for (row, cells) in pixels.pixels().chunks(across.max(1)).enumerate() {
            let mut first = 0;
            for run in cells.chunk_by(|a, b| a == b) {
                let color = run[0].demultiply();
                if color.alpha() > 0 {
                    let ink = Ink {
                        color: super::Color(color.red(), color.green(), color.blue()),
                        alpha: f64::from(color.alpha()) / 255.0,
                    };
                    self.ink(ink);
                    self.content
                        .rect(
                            left as f32 + first as f32 * width,
                            top as f32 + row as f32 * height,
                            run.len() as f32 * width,
                            height,
                        )
                        .fill_nonzero();
                }
                first += run.len();
            }
        }
        self.content.restore_state();
    }

    /// What follows is filled or drawn with `ink`.
    fn ink(&mut self, ink: Ink) {
        let alpha = (ink.alpha.clamp(0.0, 1.0) * 1000.0).round() as u16;
        let state = self.alphas.entry(alpha);
        let state = state.or_insert_with(|| format!("A{alpha}"));
        self.content.set_parameters(Name(state.as_bytes()));
        let [r, g, b] = [ink.color.0, ink.color.1, ink.color.2].map(|part| f32::from(part) / 255.0);
        self.content.set_fill_rgb(r, g, b).set_stroke_rgb(r, g, b);
    }
}

/// The file with this one page.
fn file(title: &str, sheet: Sheet) -> Vec<u8> {
    let [catalog, tree, page_id, content, regular, bold, info] =
        [1, 2, 3, 4, 5, 6, 7].map(Ref::new);
    let states: Vec<(u16, String, Ref)> = (8..)
        .zip(sheet.alphas)
        .map(|(id, (alpha, name))| (alpha, name, Ref::new(id)))
        .collect();
    let mut pdf = Pdf::new();
    pdf.catalog(catalog).pages(tree);
    pdf.pages(tree).kids([page_id]).count(1);
    let mut page = pdf.page(page_id);
    page.parent(tree)
        .media_box(Rect::new(0.0, 0.0, PAGE.0, PAGE.1))
        .contents(content);
    let mut resources = page.resources();
    resources.fonts().pair(REGULAR, regular).pair(BOLD, bold);
    let mut dictionary = resources.ext_g_states();
    for (_, name, id) in &states {
        dictionary.pair(Name(name.as_bytes()), *id);
    }
    dictionary.finish();
    resources.finish();
    page.finish();
    for (id, name) in [(regular, "Helvetica"), (bold, "Helvetica-Bold")] {
        pdf.type1_font(id)
            .base_font(Name(name.as_bytes()))
            .encoding_predefined(Name(b"WinAnsiEncoding"));
    }
    for (alpha, _, id) in &states {
        let alpha = f32::from(*alpha) / 1000.0;
        pdf.ext_graphics(*id)
            .stroking_alpha(alpha)
            .non_stroking_alpha(alpha);
    }
    pdf.stream(content, &sheet.content.finish());
    pdf.document_info(info).title(TextStr(title));
    pdf.finish()
}

/// `letter` in the encoding of PDF's own fonts, or in Latin letters.
fn encoded(letter: char) -> Vec<u8> {
    match letter {
        ' '..='~' => vec![letter as u8],
        '\u{a0}'..='\u{ff}' => vec![letter as u32 as u8],
        '–' => vec![0x96],
        '’' => vec![0x92],
        '−' => vec![b'-'],
        'Ω' => b"Omega".to_vec(),
        'ω' => b"omega".to_vec(),
        'λ' => b"lambda".to_vec(),
        '≤' => b"<=".to_vec(),
        '≥' => b">=".to_vec(),
        _ => vec![b'?'],
    }
}

#[cfg(test)]
mod tests;
