//! What the charts and the progress count show.

use super::*;

fn chart() -> Chart {
    Chart::new("frequency, Hz", "force, N")
        .size(60, 12)
        .color(false)
}

/// Column of the first letter other than blank and frame in the top plot row.
fn top_column(text: &str) -> usize {
    let row = text.lines().find(|l| l.contains('┤')).unwrap();
    let plot = row.split_once('┤').unwrap().1;
    plot.chars().position(|c| c != ' ').unwrap()
}

#[test]
fn the_maximum_stands_in_its_column() {
    for peak in [0.0, 30.0, 77.0, 100.0] {
        let curve = (0..=1000).map(|i| f64::from(i) / 10.0);
        let points = curve
            .map(|x| (x, 500.0 / (1.0 + (x - peak).powi(2))))
            .collect();
        let text = chart().series("force", points).render();
        let columns = 60 - "500".len() - 2;
        let wanted = (peak / 100.0 * columns as f64) as usize;
        let found = top_column(&text);
        assert!(
            found.abs_diff(wanted.min(columns - 1)) <= 2,
            "{peak}: {found}\n{text}"
        );
    }
}

#[test]
fn axes_are_labelled_and_no_line_is_too_wide() {
    let points = vec![(20.0, 35.0), (60.0, 812.0)];
    let text = chart().series("", points).marker("doubling", 42.3).render();
    for part in [
        "frequency, Hz",
        "force, N",
        "20",
        "60",
        "812",
        "35",
        "a: doubling, 42.3",
    ] {
        assert!(text.contains(part), "{part}\n{text}");
    }
    assert!(text.lines().all(|l| l.chars().count() <= 60), "{text}");
    assert_eq!(
        text.matches('┊').count(),
        11,
        "one cell holds the curve\n{text}"
    );
}

#[test]
fn series_have_marks_of_their_own() {
    let text = chart()
        .series("one", vec![(0.0, 0.0), (1.0, 1.0)])
        .points("two", vec![(0.0, 1.0), (1.0, 0.0)])
        .render();
    assert!(text.contains("● one") && text.contains("× two"), "{text}");
    assert_eq!(text.matches('×').count(), 3, "{text}");
    assert!(text.matches('●').count() > 12, "{text}");
}

#[test]
fn colours_only_when_wanted() {
    let two = chart()
        .points("a", vec![(0.0, 0.0)])
        .points("b", vec![(1.0, 1.0)]);
    assert!(!two.render().contains('\u{1b}'));
    assert!(two.color(true).render().contains("\u{1b}[31m×\u{1b}[0m"));
}

#[test]
fn neighbouring_markers_both_show() {
    let line = vec![(0.0, 0.0), (100.0, 1.0)];
    let text = chart()
        .series("", line)
        .marker("one", 50.0)
        .marker("two", 50.1)
        .marker("end", 100.0)
        .render();
    let letters = text.lines().nth(1).unwrap();
    assert!(letters.contains("ab") && letters.ends_with('c'), "{text}");
}

#[test]
fn odd_data_gives_a_chart_too() {
    assert!(chart().render().contains("no data"));
    assert!(
        chart()
            .points("", vec![(f64::NAN, 1.0)])
            .render()
            .contains("no data")
    );
    for points in [
        vec![(3.0, 3.0)],
        vec![(0.0, 5.0), (9.0, 5.0)],
        vec![(1e-9, 1e12), (2e-9, -1e12)],
    ] {
        let text = chart().series("s", points.clone()).render();
        assert_eq!(text.lines().count(), 16, "{text}");
        assert!(text.lines().all(|l| l.chars().count() <= 60), "{text}");
    }
    let gap = vec![(0.0, 0.0), (f64::NAN, 0.0), (1.0, 1.0)];
    let text = chart().series("", gap).render();
    let dots = text
        .chars()
        .filter(|c| ('\u{2801}'..='\u{28FF}').contains(c));
    assert_eq!(dots.count(), 2, "{text}");
}

#[test]
fn numbers_are_short() {
    let texts = [42.3, 0.0, -0.5, 1234.5678, 250_000.0, 1e-7, 2e9].map(rounded);
    assert_eq!(
        texts,
        [
            "42.3",
            "0",
            "-0.5",
            "1234.6",
            "250000",
            "1.0000e-7",
            "2.0000e9"
        ]
    );
}
