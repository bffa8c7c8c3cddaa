//! Shapes as the text of an SVG file.

use std::fmt::Write as _;

use plotters::style::text_anchor::{HPos, VPos};

use super::PictureError;
use super::shape::{Ink, Shape, Spot, Text};

/// Fonts asked for. The first is the one the PNG is drawn with and texts are measured by; the others are its common
/// stand-ins.
pub(super) const FAMILY: &str =
    "Noto Sans, DejaVu Sans, Verdana, Segoe UI, Helvetica Neue, Arial, sans-serif";

/// The file: `shapes` on a canvas `fine` units wide and high, shown `size` px wide and high.
///
/// # Errors
/// If an image inside cannot be encoded.
pub(super) fn document(
    shapes: &[Shape],
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

fn element(shape: &Shape) -> Result<String, PictureError> {
    Ok(match shape {
        Shape::Line {
            ends: [(x1, y1), (x2, y2)],
            width,
            ink,
        } => {
            let stroke = stroke(*ink, *width);
            format!("<line {stroke} x1=\"{x1}\" y1=\"{y1}\" x2=\"{x2}\" y2=\"{y2}\"/>")
        }
        Shape::Polyline { spots, width, ink } => format!(
            "<polyline fill=\"none\" {} points=\"{}\"/>",
            stroke(*ink, *width),
            places(spots)
        ),
        Shape::Polygon { corners, ink } => format!(
            "<polygon opacity=\"{}\" fill=\"{}\" points=\"{}\"/>",
            ink.alpha,
            hex(*ink),
            places(corners)
        ),
        Shape::Rectangle { corners, ink } => format!(
            "<rect {} opacity=\"{}\" fill=\"{}\" stroke=\"none\"/>",
            extent(*corners),
            ink.alpha,
            hex(*ink)
        ),
        Shape::Circle {
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
        Shape::Text(text) => letters(text),
        Shape::Image {
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
