//! Colours and shapes that stay apart for colour-blind readers and in grey.

/// A colour: red, green, blue, each 0 to 255.
///
/// The named ones are the eight-colour set of Okabe and Ito, made to stay
/// apart under the common kinds of colour blindness.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Color(pub u8, pub u8, pub u8);

impl Color {
    /// White, the ground of every picture.
    pub const PAPER: Self = Self(0xFF, 0xFF, 0xFF);
    /// Near black, for markers and reference lines.
    pub const INK: Self = Self(0x22, 0x22, 0x22);
    /// Blue.
    pub const BLUE: Self = Self(0x00, 0x72, 0xB2);
    /// Orange.
    pub const ORANGE: Self = Self(0xE6, 0x9F, 0x00);
    /// Bluish green.
    pub const GREEN: Self = Self(0x00, 0x9E, 0x73);
    /// Sky blue.
    pub const SKY: Self = Self(0x56, 0xB4, 0xE9);
    /// Vermilion.
    pub const RED: Self = Self(0xD5, 0x5E, 0x00);
    /// Reddish purple.
    pub const PURPLE: Self = Self(0xCC, 0x79, 0xA7);
    /// Middle grey.
    pub const GREY: Self = Self(0x8C, 0x8C, 0x8C);

    /// The `index`-th colour for series without a meaning of their own; repeats.
    pub fn series(index: usize) -> Self {
        const CYCLE: [Color; 6] = [
            Color::BLUE,
            Color::RED,
            Color::GREEN,
            Color::PURPLE,
            Color::ORANGE,
            Color::SKY,
        ];
        CYCLE[index % CYCLE.len()]
    }
}

/// How a line is broken.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stroke {
    /// Unbroken.
    Solid,
    /// Long dashes.
    Dashed,
    /// Short dots.
    Dotted,
}

/// The shape of a point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mark {
    /// Filled circle.
    Circle,
    /// Circle outline.
    Ring,
    /// Filled square.
    Square,
    /// Filled triangle, point up.
    Triangle,
    /// Filled square on its corner.
    Diamond,
    /// Upright cross.
    Plus,
    /// Slanted cross.
    Cross,
}

/// How one kind of motion looks wherever it is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RegimeStyle {
    /// Colour.
    pub color: Color,
    /// Shape of its points.
    pub mark: Mark,
    /// Break of its lines.
    pub stroke: Stroke,
}

/// Colour, point shape and line break of a regime.
///
/// Known names: `1/1`, `1/2`, `2/2`, `aperiodic`, `chatter`, `none`. Any other
/// pair of whole numbers `n/m` is "other periodic"; anything else looks like `none`.
pub fn regime_style(regime: &str) -> RegimeStyle {
    let (color, mark, stroke) = match regime {
        "1/1" => (Color::BLUE, Mark::Circle, Stroke::Solid),
        "1/2" => (Color::ORANGE, Mark::Triangle, Stroke::Dashed),
        "2/2" => (Color::GREEN, Mark::Square, Stroke::Dashed),
        "aperiodic" => (Color::RED, Mark::Cross, Stroke::Dotted),
        "chatter" => (Color::PURPLE, Mark::Plus, Stroke::Dotted),
        other if other == OTHER_PERIODIC || is_ratio(other) => {
            (Color::SKY, Mark::Diamond, Stroke::Dashed)
        }
        _ => (Color::GREY, Mark::Ring, Stroke::Dotted),
    };
    RegimeStyle {
        color,
        mark,
        stroke,
    }
}

/// The colour of a regime; see [`regime_style`] for the names.
pub fn regime_color(regime: &str) -> Color {
    regime_style(regime).color
}

/// What periodic regimes without a style of their own are called together.
pub const OTHER_PERIODIC: &str = "other p/n";

fn is_ratio(text: &str) -> bool {
    text.split_once('/')
        .is_some_and(|(n, m)| n.parse::<u32>().is_ok() && m.parse::<u32>().is_ok())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn named_regimes_differ_in_colour_and_in_shape() {
        let names = ["1/1", "1/2", "2/2", "3/4", "aperiodic", "chatter", "none"];
        for (i, a) in names.iter().enumerate() {
            for b in &names[i + 1..] {
                let (a, b) = (regime_style(a), regime_style(b));
                assert_ne!(a.color, b.color);
                assert_ne!(a.mark, b.mark);
            }
        }
        assert_eq!(regime_color("7/3"), regime_color("1/5"));
        assert_eq!(regime_color("7/3"), regime_color(OTHER_PERIODIC));
        assert_eq!(regime_color("who knows"), regime_color("none"));
    }
}
