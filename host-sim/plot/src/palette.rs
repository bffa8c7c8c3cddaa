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

/// The regimes that have a look of their own, in the order of a legend: `1/1` and what it doubles to, `1/2` and what
/// it doubles to, fewer and more contacts per period, and last what is no periodic contact.
///
/// Neighbours on a map (a regime and its doubling) differ in lightness as well as in hue.
pub const REGIMES: [(&str, RegimeStyle); 14] = [
    ("1/1", look(Color::BLUE, Mark::Circle, Stroke::Solid)),
    ("2/2", look(Color::GREEN, Mark::Square, Stroke::Dashed)),
    (
        "4/4",
        look(Color(0x9A, 0xE0, 0xC4), Mark::Square, Stroke::Dotted),
    ),
    ("1/2", look(Color::ORANGE, Mark::Triangle, Stroke::Dashed)),
    (
        "2/4",
        look(Color(0xFB, 0xE0, 0xA0), Mark::Triangle, Stroke::Dotted),
    ),
    (
        "1/3",
        look(Color(0xF0, 0xE4, 0x42), Mark::Diamond, Stroke::Dashed),
    ),
    (
        "1/4",
        look(Color(0xA8, 0xA2, 0x1E), Mark::Diamond, Stroke::Dotted),
    ),
    (
        "2/1",
        look(Color(0x33, 0x22, 0x88), Mark::Circle, Stroke::Dashed),
    ),
    (
        "3/1",
        look(Color(0x8C, 0x7A, 0xD6), Mark::Circle, Stroke::Dotted),
    ),
    (
        "3/2",
        look(Color(0x7A, 0x1F, 0x4B), Mark::Plus, Stroke::Dashed),
    ),
    (OTHER_PERIODIC, look(Color::SKY, Mark::Ring, Stroke::Dashed)),
    ("aperiodic", look(Color::RED, Mark::Cross, Stroke::Dotted)),
    ("chatter", look(Color::PURPLE, Mark::Plus, Stroke::Dotted)),
    ("none", look(Color::GREY, Mark::Ring, Stroke::Dotted)),
];

const fn look(color: Color, mark: Mark, stroke: Stroke) -> RegimeStyle {
    RegimeStyle {
        color,
        mark,
        stroke,
    }
}

/// Under which name of [`REGIMES`] a regime stands: its own, [`OTHER_PERIODIC`] for any other pair of whole numbers
/// `p/n`, `none` for anything else.
pub fn regime_group(regime: &str) -> &'static str {
    let name = if is_ratio(regime) {
        OTHER_PERIODIC
    } else {
        "none"
    };
    let own = REGIMES.iter().find(|(own, _)| *own == regime);
    own.map_or(name, |(own, _)| own)
}

/// Colour, point shape and line break of a regime; see [`regime_group`] for the names.
pub fn regime_style(regime: &str) -> RegimeStyle {
    let group = regime_group(regime);
    let found = REGIMES.iter().find(|(name, _)| *name == group);
    found.map_or(REGIMES[REGIMES.len() - 1].1, |(_, style)| *style)
}

/// The colour of a regime; see [`regime_style`].
pub fn regime_color(regime: &str) -> Color {
    regime_style(regime).color
}

/// The colour of a regime where it fills an area: as [`regime_color`], but `none` is a light ground.
pub fn regime_fill(regime: &str) -> Color {
    match regime_group(regime) {
        "none" => Color(0xE8, 0xE8, 0xE8),
        group => regime_color(group),
    }
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
    fn named_regimes_differ_in_colour_and_in_mark_or_stroke() {
        for (i, (name, a)) in REGIMES.iter().enumerate() {
            assert_eq!(regime_style(name), *a);
            for (other, b) in &REGIMES[i + 1..] {
                assert_ne!(a.color, b.color, "{name} {other}");
                assert!((a.mark, a.stroke) != (b.mark, b.stroke), "{name} {other}");
            }
        }
        assert_eq!(regime_color("7/3"), regime_color("1/5"));
        assert_eq!(regime_color("7/3"), regime_color(OTHER_PERIODIC));
        assert_eq!(regime_color("who knows"), regime_color("none"));
        assert_eq!(regime_group("12/1"), OTHER_PERIODIC);
    }

    /// As a reader without green cones sees a colour, linear RGB (Viénot, Brettel and Mollon 1999, deuteranopia:
    /// <https://doi.org/10.1002/(SICI)1520-6378(199908)24:4%3C243::AID-COL5%3E3.0.CO;2-3>).
    fn deuteranope(Color(r, g, b): Color) -> [f64; 3] {
        let linear = |c: u8| (f64::from(c) / 255.0).powf(2.2);
        let (r, g, b) = (linear(r), linear(g), linear(b));
        let both = 0.292_75 * r + 0.707_25 * g;
        [both, both, -0.022_34 * r + 0.022_34 * g + b]
    }

    #[test]
    fn neighbours_on_a_map_stay_apart_for_a_reader_who_does_not_see_green() {
        // Seen brightness, 0 to 1 each: a tenth apart is told at a glance on areas.
        let names = REGIMES.map(|(name, _)| name);
        for (i, a) in names.iter().enumerate() {
            for b in &names[i + 1..] {
                let seen =
                    [a, b].map(|n| deuteranope(regime_fill(n)).map(|c| c.max(0.0).powf(0.45)));
                let apart: f64 = (0..3).map(|k| (seen[0][k] - seen[1][k]).powi(2)).sum();
                assert!(apart > 0.01, "{a} {b}: {apart:.4}");
            }
        }
    }
}
