//! Shapes as the text of an SVG file.

use std::fmt::Write as _;

use plotters::style::text_anchor::{HPos, VPos};

use super::PictureError;
use super::shape::{DrawnShape, Ink, Spot, Text};

/// Fonts asked for. The first is the one the PNG is drawn with and texts are measured by; the others are its common
/// stand-ins.
pub(super) const FAMILY: &str =
    "Noto Sans, DejaVu Sans, Verdana, Segoe UI, Helvetica Neue, Arial, sans-serif";

/// The file: `shapes` on a canvas `fine` units wide and high, shown `size` px wide and high.
///
/// # Errors
/// If an image inside cannot be encoded.
pub(super) fn document(
    shapes: &[DrawnShape],
    size: (u32, u32),
    fine: (u32, u32),
) -> Result<String, PictureError> {
    let mut svg = format!(
        "<svg width=\"{}\" height=\"{}\" viewBox=\"0 0 {} {}\" xmlns=\"http://www.w3.org/2000/svg\">\n",
        size.0, size.1, fine.0, fine.1
    );
    for shape in shapes {
        svg += &element(shape)?;
        svg.push('\n');
    }
    Ok(svg + "</svg>\n")
}

fn element(shape: &DrawnShape) -> Result<String, PictureError> {
    Ok(match shape {
        DrawnShape::Line {
            ends: [(x1, y1), (x2, y2)],
            width,
            ink,
        } => {
            let stroke = stroke(*ink, *width);
            format!("<line {stroke} x1=\"{x1}\" y1=\"{y1}\" x2=\"{x2}\" y2=\"{y2}\"/>")
        }
        DrawnShape::Polyline { spots, width, ink } => format!(
            "<polyline fill=\"none\" {} points=\"{}\"/>",
            stroke(*ink, *width),
            places(spots)
        ),
        DrawnShape::Polygon { corners, ink } => format!(
            "<polygon opacity=\"{}\" fill=\"{}\" points=\"{}\"/>",
            ink.alpha,
            hex(*ink),
            places(corners)
        ),
        DrawnShape::Rectangle { corners, ink } => format!(
            "<rect {} opacity=\"{}\" fill=\"{}\" stroke=\"none\"/>",
            extent(*corners),
            ink.alpha,
            hex(*ink)
        ),
        DrawnShape::Circle {
            middle: (x, y),
            radius,
            outline,
            ink,
        } => {
            let (fill, stroke) = match outline {
                None => (hex(*ink), "none".to_owned()),
                Some(_) => ("none".to_owned(), hex(*ink)),
            };
            format!(
                "<circle cx=\"{x}\" cy=\"{y}\" r=\"{radius}\" opacity=\"{}\" fill=\"{fill}\" stroke=\"{stroke}\" stroke-width=\"{}\"/>",
                ink.alpha,
                outline.unwrap_or(1)
            )
        }
        DrawnShape::Text(text) => letters(text),
        DrawnShape::Image {
            pixels,
            corners,
            frame,
        } => {
            let [(left, top), (right, bottom)] = frame;
            format!(
                "<svg {} viewBox=\"{left} {top} {} {}\"><image {} preserveAspectRatio=\"none\" style=\"image-rendering:pixelated\" href=\"data:image/png;base64,{}\"/></svg>",
                extent(*frame),
                right - left,
                bottom - top,
                extent(*corners),
                pixels.base64()?
            )
        }
    })
}

fn letters(text: &Text) -> String {
    let (x, y) = text.at;
    let side = match text.anchor.h_pos {
        HPos::Left => "start",
        HPos::Right => "end",
        HPos::Center => "middle",
    };
    let down = match text.anchor.v_pos {
        VPos::Top => "0.76em",
        VPos::Center => "0.5ex",
        VPos::Bottom => "-0.5ex",
    };
    let weight = if text.bold {
        " font-weight=\"bold\""
    } else {
        ""
    };
    let turn = match text.turn {
        0 => String::new(),
        degrees => format!(" transform=\"rotate({degrees}, {x}, {y})\""),
    };
    format!(
        "<text x=\"{x}\" y=\"{y}\" dy=\"{down}\" text-anchor=\"{side}\" font-family=\"{FAMILY}\" font-size=\"{}\" opacity=\"{}\" fill=\"{}\"{weight}{turn}>\n{}\n</text>",
        text.size,
        text.ink.alpha,
        hex(text.ink),
        escaped(&text.letters)
    )
}

fn stroke(ink: Ink, width: u32) -> String {
    format!(
        "opacity=\"{}\" stroke=\"{}\" stroke-width=\"{width}\"",
        ink.alpha,
        hex(ink)
    )
}

fn hex(ink: Ink) -> String {
    format!("#{:02X}{:02X}{:02X}", ink.color.0, ink.color.1, ink.color.2)
}

fn extent([(left, top), (right, bottom)]: [Spot; 2]) -> String {
    let (width, height) = (right - left, bottom - top);
    format!("x=\"{left}\" y=\"{top}\" width=\"{width}\" height=\"{height}\"")
}

fn places(spots: &[Spot]) -> String {
    spots.iter().fold(String::new(), |mut out, (x, y)| {
        // Writing to a string cannot fail.
        let _ = write!(out, "{x},{y} ");
        out
    })
}

fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for letter in text.chars() {
        match letter {
            '<' => out += "&lt;",
            '>' => out += "&gt;",
            '&' => out += "&amp;",
            '"' => out += "&quot;",
            '\'' => out += "&apos;",
            other => out.push(other),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use plotters::style::text_anchor::Pos;

    use super::*;
    use crate::Color;
    use crate::raster::PixelImage;

    const RED: Ink = Ink {
        color: Color::RED,
        alpha: 1.0,
    };

    #[test]
    fn every_shape_is_an_element() {
        let mut pixels = PixelImage::new(1, 1).unwrap();
        pixels.set(0, 0, Color::BLUE);
        let thin = Ink { alpha: 0.5, ..RED };
        let circle = |outline| DrawnShape::Circle {
            middle: (4, 5),
            radius: 6,
            outline,
            ink: RED,
        };
        let cases = [
            (
                DrawnShape::Line {
                    ends: [(1, 2), (3, 4)],
                    width: 5,
                    ink: thin,
                },
                r##"<line opacity="0.5" stroke="#D55E00" stroke-width="5" x1="1" y1="2" x2="3" y2="4"/>"##,
            ),
            (
                DrawnShape::Polyline {
                    spots: vec![(1, 2), (-3, 4)],
                    width: 5,
                    ink: RED,
                },
                r##"<polyline fill="none" opacity="1" stroke="#D55E00" stroke-width="5" points="1,2 -3,4 "/>"##,
            ),
            (
                DrawnShape::Polygon {
                    corners: vec![(1, 2), (3, 4), (5, 0)],
                    ink: RED,
                },
                r##"<polygon opacity="1" fill="#D55E00" points="1,2 3,4 5,0 "/>"##,
            ),
            (
                DrawnShape::Rectangle {
                    corners: [(1, 2), (11, 22)],
                    ink: RED,
                },
                r##"<rect x="1" y="2" width="10" height="20" opacity="1" fill="#D55E00" stroke="none"/>"##,
            ),
            (
                circle(None),
                r##"<circle cx="4" cy="5" r="6" opacity="1" fill="#D55E00" stroke="none" stroke-width="1"/>"##,
            ),
            (
                circle(Some(3)),
                r##"<circle cx="4" cy="5" r="6" opacity="1" fill="none" stroke="#D55E00" stroke-width="3"/>"##,
            ),
        ];
        for (shape, expected) in cases {
            assert_eq!(element(&shape).unwrap(), expected);
        }
        let image = DrawnShape::Image {
            pixels,
            corners: [(0, 0), (30, 40)],
            frame: [(10, 20), (20, 40)],
        };
        let image = element(&image).unwrap();
        let start = r#"<svg x="10" y="20" width="10" height="20" viewBox="10 20 10 20"><image x="0" y="0" width="30" height="40" preserveAspectRatio="none" style="image-rendering:pixelated" href="data:image/png;base64,"#;
        assert!(
            image.starts_with(start) && image.ends_with("\"/></svg>"),
            "{image}"
        );
    }

    #[test]
    fn letters_keep_their_size_place_and_turn() {
        let text = DrawnShape::Text(Text {
            letters: "a < b & 'c'".to_owned(),
            at: (7, 8),
            size: 48.0,
            bold: true,
            ink: RED,
            anchor: Pos::new(HPos::Center, VPos::Top),
            turn: 270,
        });
        let expected = format!(
            "<text x=\"7\" y=\"8\" dy=\"0.76em\" text-anchor=\"middle\" font-family=\"{FAMILY}\" font-size=\"48\" opacity=\"1\" fill=\"#D55E00\" font-weight=\"bold\" transform=\"rotate(270, 7, 8)\">\na &lt; b &amp; &apos;c&apos;\n</text>"
        );
        assert_eq!(element(&text).unwrap(), expected);
    }
}
