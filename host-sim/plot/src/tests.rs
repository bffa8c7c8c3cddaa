//! Whole figures: what the SVG says and what the PNG shows.

use std::f64::consts::TAU;

use super::*;

/// A resonance curve with all that a force plot has.
fn force_figure() -> Figure {
    let force = |f: f64| 180.0 + 900.0 / (1.0 + ((f - 44.0) / 6.0).powi(2)) + 2.0 * f;
    let sweep = |from: u32, to: u32| -> Vec<Point> {
        let hz = (from..=to).map(|k| f64::from(k) / 4.0);
        hz.map(|f| (f, force(f))).collect()
    };
    let mut panel = Panel::new(
        "drive frequency, Hz",
        Axis::new("peak impact force, N").with_zero(),
    )
    .item(Item::band_x("safe operating band", 33.0, 39.5));
    for (label, from, to, color, mark, stroke) in [
        ("1/1", 80, 168, Color::BLUE, Mark::Circle, Stroke::Solid),
        (
            "1/2",
            168,
            190,
            Color::ORANGE,
            Mark::Triangle,
            Stroke::Dashed,
        ),
        ("2/2", 190, 205, Color::GREEN, Mark::Square, Stroke::Dashed),
        ("3/4", 205, 215, Color::SKY, Mark::Diamond, Stroke::Dashed),
        (
            "aperiodic",
            215,
            240,
            Color::RED,
            Mark::Cross,
            Stroke::Dotted,
        ),
        (
            "chatter",
            240,
            262,
            Color::PURPLE,
            Mark::Plus,
            Stroke::Dotted,
        ),
        ("none", 262, 280, Color::GREY, Mark::Ring, Stroke::Dotted),
    ] {
        let style = Style {
            color,
            mark,
            stroke,
        };
        panel = panel
            .item(Item::curve(label, color, (stroke, 1.6), sweep(from, to)))
            .item(Item::styled_points(
                label,
                style,
                sweep(from, to).into_iter().step_by(3).collect(),
            ));
    }
    let panel = panel
        .item(Item::mark_x("period doubling, 42.0 Hz", 42.0))
        .item(Item::mark_x("grazing, 43.1 Hz", 43.1))
        .item(Item::mark_x("period doubling, 47.5 Hz", 47.5))
        .item(Item::mark_point(
            "chosen: 36.0 Hz, 573 N",
            36.0,
            force(36.0),
        ));
    Figure::new("Peak impact force over drive frequency")
        .subtitle("spring 61.7 kN/m, mass 1.31 kg, gap 0.8 mm, restitution 0.62; 800 periods, the first 600 left out")
        .panel(panel)
}

/// Time history, phase plane, Poincaré map and a spectrum.
fn four_panels() -> Figure {
    let wave = |k: u32| {
        let t = f64::from(k) / 2000.0;
        (
            t,
            1.2 * (TAU * 20.0 * t).sin() + 0.4 * (TAU * 47.0 * t).cos(),
        )
    };
    let speed = |k: u32| (wave(k + 1).1 - wave(k).1) * 2.0;
    let history: Vec<Point> = (0..1200).map(wave).collect();
    let phase = (0..1200).map(|k| (wave(k).1, speed(k))).collect();
    let map: Vec<Point> = (0..400).map(|k| (wave(k * 53).1, speed(k * 53))).collect();
    let lines = (1..60).map(|k| (f64::from(k), 1e-6 / f64::from(k)));
    Figure::new("One operating point: 47.5 Hz, aperiodic")
        .columns(2)
        .size(1000, 760)
        .panel(
            Panel::new("time, s", "position, mm")
                .titled("Time history")
                .item(Item::line("hammer", Color::BLUE, history))
                .item(Item::dashed(
                    "anvil",
                    Color::RED,
                    vec![(0.0, -1.0), (0.6, -1.0)],
                )),
        )
        .panel(
            Panel::new("position, mm", "velocity, m/s")
                .titled("Phase plane")
                .item(Item::line("", Color::BLUE, phase)),
        )
        .panel(
            Panel::new("position, mm", "velocity, m/s")
                .titled("Poincaré map")
                .item(Item::points("once a period", Color::RED, map)),
        )
        .panel(
            Panel::new("frequency, Hz", "power, mm²/Hz")
                .titled("Spectrum")
                .item(Item::line("", Color::PURPLE, lines.collect())),
        )
}

fn one(item: Item) -> Figure {
    Figure::new("")
        .size(400, 300)
        .panel(Panel::new("x, s", "y, m").without_legend().item(item))
}

fn lines_of(svg: &str, color: &str) -> usize {
    svg.lines()
        .filter(|l| l.starts_with("<polyline") && l.contains(&format!("stroke=\"{color}\"")))
        .count()
}

fn decode(png: &[u8]) -> tiny_skia::Pixmap {
    tiny_skia::Pixmap::decode_png(png).unwrap()
}

fn pixels_of(png: &[u8], Color(r, g, b): Color) -> usize {
    let near = |a: u8, b: u8| a.abs_diff(b) < 8;
    decode(png)
        .pixels()
        .iter()
        .filter(|p| near(p.red(), r) && near(p.green(), g) && near(p.blue(), b))
        .count()
}

#[test]
fn svg_names_axes_items_and_markers() {
    let svg = render_svg(&force_figure()).unwrap();
    for text in [
        "Peak impact force over drive frequency",
        "drive frequency, Hz",
        "peak impact force, N",
        "safe operating band",
        "aperiodic",
        "grazing, 43.1 Hz",
        "chosen: 36.0 Hz, 573 N",
        "800 periods",
    ] {
        assert!(svg.contains(text), "{text}");
    }
    assert!(svg.starts_with("<svg width=\"960\" height=\"600\" viewBox=\"0 0 3840 2400\""));
}

#[test]
fn a_gap_makes_two_polylines_and_one_point_a_dot() {
    let gap = (f64::NAN, f64::NAN);
    let points = vec![
        (0.0, 0.0),
        (1.0, 1.0),
        gap,
        (2.0, 0.5),
        (3.0, 2.0),
        gap,
        (4.0, 1.0),
    ];
    let svg = render_svg(&one(Item::line("", Color::BLUE, points))).unwrap();
    assert_eq!(lines_of(&svg, "#0072B2"), 2);
    assert_eq!(svg.matches("<circle").count(), 1);
}

#[test]
fn a_point_name_keeps_off_a_line_with_few_points() {
    let line = Item::line("", Color::BLUE, vec![(0.0, 0.0), (100.0, 100.0)]);
    let mut figure = one(line);
    let plain = pixels_of(&render_png(&figure).unwrap(), Color::BLUE);
    let mark = Item::mark_point("a rather long name", 50.0, 50.0);
    figure.panels[0].items.push(mark);
    let named = pixels_of(&render_png(&figure).unwrap(), Color::BLUE);
    // The ring hides some of the line; the name would hide much more.
    assert!(named > plain - 120, "{named} of {plain}");
}

#[test]
fn text_cannot_break_the_file() {
    let mut figure = one(Item::mark_x("a < b & \"c\"\u{0}\n", 0.5));
    figure.title = "<script>&\u{1}".to_owned();
    figure.panels[0].x.label = "ω, rad/s \u{2}".to_owned();
    assert!(render_svg(&figure).unwrap().contains("&lt;script&gt;&amp;"));
    assert!(render_png(&figure).is_ok());
}

#[test]
fn png_has_the_size_and_shows_the_line_and_letters() {
    let line = Item::line("", Color::RED, vec![(0.0, 0.0), (1.0, 1.0)]);
    let png = render_png(&one(line)).unwrap();
    let image = decode(&png);
    assert_eq!((image.width(), image.height()), (800, 600));
    // A diagonal of about 650 px, 3 px thick.
    assert!(pixels_of(&png, Color::RED) > 900);
    let blank = render_png(&one(Item::line("", Color::RED, Vec::new()))).unwrap();
    assert_eq!(pixels_of(&blank, Color::RED), 0);
    // Without a font there would be no dark letters.
    assert!(pixels_of(&blank, Color::INK) > 100);
}

#[test]
fn same_figure_same_bytes() {
    let figure = four_panels();
    assert_eq!(render_svg(&figure), render_svg(&figure));
    assert_eq!(render_png(&figure).unwrap(), render_png(&figure).unwrap());
}

#[test]
fn degenerate_data_still_gives_a_picture() {
    let cases = [
        vec![],
        vec![(f64::NAN, 1.0)],
        vec![(3.0, 7.0)],
        vec![(0.0, 0.0); 3],
        vec![(0.0, 5.0), (1.0, 5.0), (2.0, 5.0)],
        vec![(1.0, f64::INFINITY), (2.0, 1.0), (f64::MAX, f64::MIN)],
        vec![(-1e299, 1e-280), (1e299, 2e-280)],
        vec![(0.0, f64::MIN_POSITIVE), (1.0, 5e-324)],
        vec![(1e9, 0.0), (1e9 + 1e-6, 1.0)],
    ];
    for points in cases {
        for item in [
            Item::line("line", Color::BLUE, points.clone()),
            Item::dashed("dashes", Color::BLUE, points.clone()),
            Item::points("points", Color::BLUE, points.clone()),
        ] {
            let svg = render_svg(&one(item)).unwrap_or_else(|e| panic!("{points:?}: {e}"));
            assert!(!svg.contains("NaN") && !svg.contains("inf"), "{points:?}");
        }
    }
    let empty = render_svg(&one(Item::points("", Color::BLUE, Vec::new()))).unwrap();
    assert!(empty.contains("no data"));
    assert!(render_svg(&Figure::new("nothing")).is_ok());
    for item in [
        Item::mark_x("nowhere", f64::NAN),
        Item::mark_point("nowhere", f64::INFINITY, 0.0),
        Item::band_x("nowhere", f64::NAN, 1.0),
    ] {
        assert!(render_svg(&one(item)).is_ok());
    }
}

#[test]
fn a_long_record_stays_a_small_file() {
    let noisy = (0..300_000).map(|k: u32| (f64::from(k), f64::from(k % 1009 * 7919 % 1000)));
    let svg = render_svg(&one(Item::line("", Color::BLUE, noisy.collect()))).unwrap();
    assert!(svg.len() < 200_000, "{}", svg.len());
}

#[test]
fn impossible_sizes_are_refused() {
    let size = |w, h| render_svg(&force_figure().size(w, h));
    assert_eq!(
        size(10, 600),
        Err(PictureError::Size {
            width: 10,
            height: 600
        })
    );
    assert_eq!(size(220, 200), Err(PictureError::Crowded { panel: 1 }));
}

#[test]
fn a_raster_fills_its_part_of_the_frame_with_even_cells() {
    let kinds = [
        ("one".to_owned(), Color::RED),
        ("two".to_owned(), Color::BLUE),
        ("never".to_owned(), Color::GREEN),
    ];
    let cells = [Some(0), Some(0), Some(1), None];
    let raster = Raster::categories((0.0, 2.0), (0.0, 2.0), 2, &kinds, &cells);
    let png = render_png(&one(Item::raster(raster.clone()))).unwrap();
    let (red, blue) = (pixels_of(&png, Color::RED), pixels_of(&png, Color::BLUE));
    // Two cells against one, less half the frame's line on two sides.
    assert!(
        blue > 50_000 && (red as f64 / blue as f64 - 2.0).abs() < 0.02,
        "{red} {blue}"
    );
    // Seen from 1 to 2 in x, only the red cell below is left.
    let mut figure = one(Item::raster(raster));
    figure.panels[0].legend = true;
    let svg = render_svg(&figure).unwrap();
    assert!(svg.contains("two") && !svg.contains("never"));
    figure.panels[0].x = Axis::new("x").fixed(1.0, 2.0);
    figure.panels[0].legend = false;
    let png = render_png(&figure).unwrap();
    assert!(pixels_of(&png, Color::RED) > 100_000 && pixels_of(&png, Color::BLUE) == 0);
}

#[test]
fn a_scale_gets_a_bar_with_its_label() {
    let bar = Bar::new("force ratio, F/(m g)", 0.0, 40.0);
    let values = [0.0, 20.0, f64::NAN, 40.0];
    let raster = Raster::values((0.0, 2.0), (0.0, 2.0), 2, &values, bar);
    let svg = render_svg(&one(Item::raster(raster))).unwrap();
    assert!(svg.contains("force ratio, F/(m g)") && svg.contains("rotate(270"));
}

#[test]
fn a_million_points_stay_a_small_file_and_none_is_lost() {
    let wide = |k: u32| f64::from(k.wrapping_mul(2_654_435_761) >> 8) / 16_777_216.0;
    let points: Vec<Point> = (0..1_000_000)
        .map(|k| (wide(k), wide(k + 7_777_777)))
        .collect();
    let svg = render_svg(&one(Item::cloud("", Color::BLUE, points))).unwrap();
    assert!(
        svg.len() < 300_000 && svg.matches("<circle").count() == 0,
        "{}",
        svg.len()
    );
    // 25 dots of 1 px: four pixels of the PNG each.
    let few = (0..25)
        .map(|k| (f64::from(k % 5), f64::from(k / 5)))
        .collect();
    let png = render_png(&one(Item::cloud("", Color::BLUE, few))).unwrap();
    assert_eq!(pixels_of(&png, Color::BLUE), 100);
}

#[test]
fn a_power_law_is_straight_on_logarithmic_axes() {
    let law = (0..7).map(|k| 10f64.powi(k - 5)).map(|x| (x, 3.0 * x * x));
    let points = law.chain([(0.0, 1.0), (-1.0, 1.0), (1.0, 0.0)]).collect();
    let mut figure = one(Item::points("", Color::BLUE, points));
    figure.panels[0].x = Axis::new("step, s").log();
    figure.panels[0].y = Axis::new("error, m").log();
    let svg = render_svg(&figure).unwrap();
    let number = |line: &str, name: &str| -> f64 {
        let rest = line.split(&format!(" {name}=\"")).nth(1).unwrap();
        rest.split('"').next().unwrap().parse().unwrap()
    };
    let circles = svg.lines().filter(|l| l.starts_with("<circle"));
    let at: Vec<_> = circles
        .map(|l| (number(l, "cx"), number(l, "cy")))
        .collect();
    assert_eq!(at.len(), 7);
    for pair in at.windows(2) {
        // Whole canvas units.
        assert!((pair[1].0 - pair[0].0 - (at[1].0 - at[0].0)).abs() <= 2.0);
        assert!((pair[1].1 - pair[0].1 - (at[1].1 - at[0].1)).abs() <= 2.0);
    }
    assert!(svg.contains("1e−4") && svg.contains("0.01"));
}
