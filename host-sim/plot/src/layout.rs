//! Where things go: grid cells, wrapped text, labels that keep clear of one another.

use super::canvas::{Letters, Rect};

/// The cells of a grid of `count` panels with `columns` beside one another.
pub(super) fn grid(inside: Rect, count: usize, columns: usize) -> Vec<Rect> {
    const GAP: f64 = 14.0;
    let columns = columns.clamp(1, count.max(1));
    let rows = count.div_ceil(columns).max(1);
    let width = (inside.width() - GAP * (columns - 1) as f64) / columns as f64;
    let height = (inside.height() - GAP * (rows - 1) as f64) / rows as f64;
    let cell = |i: usize| {
        let left = inside.left + (width + GAP) * (i % columns) as f64;
        let top = inside.top + (height + GAP) * (i / columns) as f64;
        Rect {
            left,
            top,
            right: left + width,
            bottom: top + height,
        }
    };
    (0..count).map(cell).collect()
}

/// `text`, cut with an ellipsis when wider than `width` px.
pub(super) fn fit(text: &str, letters: Letters, width: f64) -> String {
    if letters.width(text) <= width {
        return text.to_owned();
    }
    let mut kept: Vec<char> = text.chars().collect();
    while kept.pop().is_some() {
        let short: String = kept.iter().chain(&['…']).collect();
        if letters.width(&short) <= width {
            return short;
        }
    }
    String::new()
}

/// `text` in at most `most` lines no wider than `width` px; the last is cut if need be.
pub(super) fn wrap(text: &str, letters: Letters, width: f64, most: usize) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        let full = lines.len() >= most;
        match lines.last_mut() {
            Some(line) if full || letters.width(&format!("{line} {word}")) <= width => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines.iter().map(|line| fit(line, letters, width)).collect()
}

/// Where the name of a vertical marker stands above the plot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Slot {
    /// Row above the plot, 0 nearest to it.
    pub row: usize,
    /// Left end of the name, px.
    pub left: f64,
}

const BESIDE: f64 = 4.0;

/// Gives every marker (`x` and width of its name, px) a slot such that names
/// never overlap one another nor leave `left..right`, and, where there is room,
/// no marker line runs through a name.
pub(super) fn stagger(marks: &[(f64, f64)], left: f64, right: f64) -> Vec<Slot> {
    let mut rising: Vec<usize> = (0..marks.len()).collect();
    rising.sort_by(|a, b| marks[*a].0.total_cmp(&marks[*b].0));
    let middle = (left + right) / 2.0;
    let split = rising.partition_point(|i| marks[*i].0 < middle);
    let (near, far) = rising.split_at(split);
    let turned = |order: &[usize]| order.iter().rev().copied().collect::<Vec<_>>();
    // Names to the right, beginning at the right; the mirror image of that;
    // both, beginning at the sides with names outwards, or in the middle with
    // names inwards.
    let plans = [
        place(marks, left, right, &turned(&rising), |_| true),
        place(marks, left, right, &rising, |_| false),
        place(marks, left, right, &[near, &turned(far)].concat(), |x| {
            x >= middle
        }),
        place(marks, left, right, &[&turned(near), far].concat(), |x| {
            x < middle
        }),
    ];
    let best = plans.into_iter().min_by_key(|(cost, _)| *cost);
    best.map(|(_, slots)| slots).unwrap_or_default()
}

/// Places markers in `order`; the cost is (lines through names, highest row).
fn place(
    marks: &[(f64, f64)],
    left: f64,
    right: f64,
    order: &[usize],
    to_the_right: impl Fn(f64) -> bool,
) -> ((usize, usize), Vec<Slot>) {
    let mut slots = vec![Slot { row: 0, left }; marks.len()];
    let mut placed: Vec<usize> = Vec::new();
    let mut crossings = 0;
    for &i in order {
        let (x, width) = marks[i];
        let mut sides = [x + BESIDE, x - BESIDE - width];
        if !to_the_right(x) {
            sides.reverse();
        }
        let fits = |start: &f64| *start >= left && start + width <= right;
        let squeezed = (right - width).min(x - width / 2.0).max(left);
        let start = sides.into_iter().find(fits).unwrap_or(squeezed);
        // (overlaps, lines through names) of a slot against those placed.
        let trouble = |slot: Slot| {
            placed.iter().fold((0, 0), |(over, through), &j| {
                let (other_x, other_width) = marks[j];
                let other = slots[j];
                let overlap = slot.row == other.row
                    && slot.left < other.left + other_width + BESIDE
                    && other.left < slot.left + width + BESIDE;
                let is_in = |x: f64, start: f64, w: f64| start - 2.0 < x && x < start + w + 2.0;
                let mine = slot.row >= other.row && is_in(x, other.left, other_width);
                let theirs = other.row >= slot.row && is_in(other_x, slot.left, width);
                (
                    over + usize::from(overlap),
                    through + usize::from(mine) + usize::from(theirs),
                )
            })
        };
        let choices = (0..=placed.len()).map(|row| Slot { row, left: start });
        let best = choices.min_by_key(|slot| (trouble(*slot), slot.row));
        if let Some(slot) = best {
            crossings += trouble(slot).1;
            slots[i] = slot;
        }
        placed.push(i);
    }
    let rows = slots.iter().map(|s| s.row).max().unwrap_or(0);
    ((crossings, rows), slots)
}

/// A place for a `width` x `height` px name beside the point `at`: inside
/// `frame`, clear of `taken`, and over as few of `dots` as can be.
pub(super) fn beside(
    at: (f64, f64),
    (width, height): (f64, f64),
    frame: Rect,
    taken: &[Rect],
    dots: &[(f64, f64)],
) -> Rect {
    let box_at = |cx: f64, cy: f64| {
        let left = (cx - width / 2.0).min(frame.right - width).max(frame.left);
        let top = (cy - height / 2.0)
            .min(frame.bottom - height)
            .max(frame.top);
        Rect {
            left,
            top,
            right: left + width,
            bottom: top + height,
        }
    };
    let (side, up) = (width / 2.0 + 9.0, height / 2.0 + 9.0);
    let near = [
        (1.0, -1.0),
        (-1.0, -1.0),
        (1.0, 1.0),
        (-1.0, 1.0),
        (0.0, -1.0),
        (0.0, 1.0),
    ];
    let offsets = [1.0, 1.8, 3.0, 4.5]
        .into_iter()
        .flat_map(|far| near.map(|(sx, sy)| (sx * side, sy * up * far, far)));
    offsets
        .map(|(dx, dy, far)| (box_at(at.0 + dx, at.1 + dy), far))
        .min_by_key(|(candidate, far)| {
            let overlaps = taken.iter().filter(|r| r.overlaps(candidate)).count();
            let hides = usize::from(candidate.contains(at));
            let covered = dots.iter().filter(|dot| candidate.contains(**dot)).count();
            (overlaps + hides, covered + (far * 3.0) as usize)
        })
        .map_or_else(|| box_at(at.0, at.1), |(place, _)| place)
}

#[cfg(test)]
mod tests {
    use super::*;

    const LETTERS: fn() -> Letters = || Letters::new(12.0);

    fn names_overlap(marks: &[(f64, f64)], slots: &[Slot]) -> bool {
        (0..marks.len()).any(|i| {
            (0..i).any(|j| {
                slots[i].row == slots[j].row
                    && slots[i].left < slots[j].left + marks[j].1
                    && slots[j].left < slots[i].left + marks[i].1
            })
        })
    }

    #[test]
    fn crowded_marker_names_stay_apart_and_in_frame() {
        let crowds: [&[(f64, f64)]; 5] = [
            &[(100.0, 80.0), (110.0, 80.0), (120.0, 80.0)],
            &[(490.0, 90.0), (495.0, 60.0), (499.0, 120.0)],
            &[(0.0, 100.0), (2.0, 100.0), (500.0, 100.0)],
            &[(50.0, 300.0), (60.0, 300.0), (440.0, 300.0), (450.0, 300.0)],
            &[(250.0, 499.0), (250.0, 499.0)],
        ];
        for marks in crowds {
            let slots = stagger(marks, 0.0, 500.0);
            assert!(!names_overlap(marks, &slots), "{marks:?} {slots:?}");
            for (slot, (_, width)) in slots.iter().zip(marks) {
                assert!(slot.left >= 0.0 && slot.left + width <= 500.0, "{marks:?}");
            }
        }
        assert!(stagger(&[], 0.0, 500.0).is_empty());
    }

    #[test]
    fn marker_lines_keep_clear_of_names() {
        let marks = [(457.0, 150.0), (475.0, 110.0), (548.0, 150.0)];
        let slots = stagger(&marks, 75.0, 940.0);
        for (slot, (_, width)) in slots.iter().zip(marks) {
            for (other, (x, _)) in slots.iter().zip(marks) {
                let reaches = other.row >= slot.row;
                let crosses = (slot.left..slot.left + width).contains(&x);
                assert!(!(reaches && crosses), "{slots:?}");
            }
        }
        assert!(slots.iter().all(|slot| slot.row < 2), "{slots:?}");
    }

    #[test]
    fn lone_markers_share_the_lowest_row() {
        let slots = stagger(&[(50.0, 60.0), (200.0, 60.0), (400.0, 60.0)], 0.0, 500.0);
        assert!(slots.iter().all(|slot| slot.row == 0), "{slots:?}");
    }

    #[test]
    fn long_text_is_wrapped_and_cut() {
        let lines = wrap("one two three four five six seven", LETTERS(), 60.0, 2);
        assert_eq!(lines.len(), 2);
        assert!(
            lines.iter().all(|l| LETTERS().width(l) <= 60.0),
            "{lines:?}"
        );
        assert!(lines[1].ends_with('…'));
        assert!(wrap("", LETTERS(), 60.0, 2).is_empty());
        assert_eq!(fit("abc", LETTERS(), 0.0), "");
    }

    #[test]
    fn a_point_name_keeps_off_the_data_and_other_names() {
        let frame = Rect {
            left: 0.0,
            top: 0.0,
            right: 200.0,
            bottom: 200.0,
        };
        let dots: Vec<_> = (0..200)
            .map(|i| (f64::from(i), 100.0 - f64::from(i) / 4.0))
            .collect();
        let first = beside((100.0, 75.0), (60.0, 14.0), frame, &[], &dots);
        assert!(dots.iter().all(|d| !first.contains(*d)), "{first:?}");
        let second = beside((104.0, 75.0), (60.0, 14.0), frame, &[first], &dots);
        assert!(!second.overlaps(&first));
        let corner = beside((200.0, 0.0), (60.0, 14.0), frame, &[], &[]);
        assert!(corner.right <= 200.0 && corner.top >= 0.0);
    }

    #[test]
    fn a_grid_fills_its_rectangle() {
        let inside = Rect {
            left: 10.0,
            top: 20.0,
            right: 410.0,
            bottom: 320.0,
        };
        let cells = grid(inside, 3, 2);
        assert_eq!(cells.len(), 3);
        assert_eq!(cells[1].right, 410.0);
        assert_eq!(cells[2].bottom, 320.0);
        assert!(!cells[0].overlaps(&cells[1]) && !cells[0].overlaps(&cells[2]));
        assert!(grid(inside, 0, 0).is_empty());
    }
}
