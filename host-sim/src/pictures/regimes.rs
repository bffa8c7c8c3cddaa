//! How regimes look in pictures: a colour, a shape of points and a break of lines for each.

use plot::{Color, Item, Mark, Point, Raster, Stroke, Style};

/// The regimes that have a look of their own, in the order of a legend: `1/1` and what it doubles to, `1/2` and what
/// it doubles to, fewer and more contacts per period, and last what is no periodic contact.
///
/// Neighbours on a map (a regime and its doubling) differ in lightness as well as in hue, and no two regimes that are
/// common on maps share a hue: 1/1 alone is blue, 1/2 alone orange.
pub const REGIMES: [(&str, Style); 15] = [
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
        look(Color(0x88, 0x22, 0x55), Mark::Circle, Stroke::Dashed),
    ),
    (
        "3/1",
        look(Color(0xB8, 0x5C, 0xC0), Mark::Circle, Stroke::Dotted),
    ),
    (
        "3/2",
        look(Color(0x33, 0x22, 0x88), Mark::Plus, Stroke::Dashed),
    ),
    (
        OTHER_PERIODIC,
        look(Color(0xC9, 0xB8, 0xF0), Mark::Ring, Stroke::Dashed),
    ),
    (
        "aperiodic",
        look(Color(0x38, 0x38, 0x38), Mark::Cross, Stroke::Dotted),
    ),
    (
        "unsettled",
        look(Color(0x90, 0x50, 0x10), Mark::Cross, Stroke::Dashed),
    ),
    ("chatter", look(Color::PURPLE, Mark::Plus, Stroke::Dotted)),
    ("none", look(Color::GREY, Mark::Ring, Stroke::Dotted)),
];

const fn look(color: Color, mark: Mark, stroke: Stroke) -> Style {
    Style {
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
pub fn regime_style(regime: &str) -> Style {
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

/// Points of a regime as rings that leave room for a mark inside: those of a second sweep.
pub fn regime_rings(regime: &str, points: Vec<Point>) -> Item {
    Item::marks(regime, regime_color(regime), (Mark::Ring, 6.0), points)
}

/// Points of one regime in its own colour and shape ([`regime_style`]), named by the regime.
pub fn regime_points(regime: &str, points: Vec<Point>) -> Item {
    Item::styled_points(regime, regime_style(regime), points)
}

/// Cells of regimes by name (`1/1`, `none`...), in their colours ([`regime_fill`]); see [`Raster::categories`].
pub fn regime_raster<S: AsRef<str>>(
    x: (f64, f64),
    y: (f64, f64),
    columns: usize,
    regimes: impl IntoIterator<Item = S>,
) -> Raster {
    let named = |name: &str| if name == "none" { "no contact" } else { name }.to_owned();
    let names = REGIMES.map(|(name, _)| (named(name), regime_fill(name)));
    let index = |regime: S| {
        let group = regime_group(regime.as_ref());
        REGIMES.iter().position(|(name, _)| *name == group)
    };
    let cells: Vec<_> = regimes.into_iter().map(index).collect();
    Raster::categories(x, y, columns, &names, &cells)
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

    #[test]
    fn the_page_has_the_same_colours() {
        let page = include_str!("../../../web/page/common/colours.js");
        let hex = |Color(r, g, b): Color| format!("#{r:02X}{g:02X}{b:02X}");
        let lines =
            REGIMES.map(|(name, _)| format!("  [\"{name}\", \"{}\"],", hex(regime_fill(name))));
        assert!(page.contains(&lines.join("\n")), "{}", lines.join("\n"));
        let series: Vec<_> = (0..6)
            .map(|i| format!("\"{}\"", hex(Color::series(i))))
            .collect();
        let series = format!("export const SERIES = [{}];", series.join(", "));
        assert!(page.contains(&series), "{series}");
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
