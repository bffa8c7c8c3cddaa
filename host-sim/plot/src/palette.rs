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

/// How one kind of thing looks wherever it is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Style {
    /// Colour of its points and lines.
    pub color: Color,
    /// Shape of its points.
    pub mark: Mark,
    /// Break of its lines.
    pub stroke: Stroke,
}
