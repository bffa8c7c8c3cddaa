//! The answer of `map` for a person.

use std::fmt::Write;

use shared::model::regime::Regime;

use super::answer::MapAnswer;
use crate::words;
use crate::words::map::percent;
use files::words::count;
use numerics::CartModel;
use numerics::map::{Map, MapRequest, MapSummary, StrongestCell};
use numerics::row::Outcome;
use plot::chart::terminal_width;

/// Regimes named one by one.
const NAMED: usize = 8;

pub fn text(answer: &MapAnswer, maps: &[Map]) -> String {
    let mut text = String::new();
    let parts = answer.requests.iter().zip(maps).zip(&answer.summaries);
    for ((request, map), summary) in parts {
        text += &one(request, map, summary);
        text.push('\n');
    }
    if let Some(against) = &answer.against {
        let _ = writeln!(text, "against    {}", words::map::agreement(against));
    }
    for alike in &answer.alikeness {
        let _ = writeln!(text, "alike      {}", words::map::similarity(alike));
    }
    if let Some(hits) = &answer.measured {
        let _ = writeln!(
            text,
            "measured   {} of {} points have the regime of the cell they lie on ({} outside the map)",
            hits.same, hits.points, hits.outside
        );
    }
    if let Some(audit) = &answer.audit {
        let _ = writeln!(
            text,
            "audit      {} again by the reference: {}",
            count(audit.cells, "cell"),
            words::map::agreement(audit)
        );
    }
    text
}

fn one(request: &MapRequest, map: &Map, summary: &MapSummary) -> String {
    let MapRequest { plan, settle, .. } = request;
    let ends = |values: &[f64], unit: &str| match values {
        [first, .., last] => format!("{:?} to {:?} {unit}", rounded(*first), rounded(*last)),
        [one] => format!("{:?} {unit}", rounded(*one)),
        [] => String::new(),
    };
    let run_on = settle.is_none() && summary.unsettled > 0;
    let settle = settle.map_or(String::new(), |n| format!(" (unsettled: {n})"));
    let mut text = format!(
        "{}, {}: {} ({}) by {} ({}), {}\n{}, engine {}, {}{settle}, last {} recorded\n\n",
        map.rig.name,
        CartModel::of(&map.rig.params).words(),
        count(map.grid.gaps_mm.len(), "gap"),
        ends(&map.grid.gaps_mm, "mm"),
        count(map.grid.frequencies_hz.len(), "frequency"),
        ends(&map.grid.frequencies_hz, "Hz"),
        count(summary.cells, "cell"),
        match request.from {
            numerics::sweep::Direction::Rest => "from rest".to_owned(),
            other => format!("carried {}", other.name()),
        },
        request.runner.name(),
        count(plan.cycles as usize, "cycle"),
        plan.recorded,
    );
    text += &chart(map);
    text.push('\n');
    let shares = summary.regimes.iter().take(NAMED);
    let shares: Vec<_> = shares
        .map(|s| format!("{} {}", s.regime, percent(s.cells, summary.cells)))
        .collect();
    let more = summary.regimes.len().saturating_sub(NAMED);
    let more = if more > 0 {
        format!(", and {more} more")
    } else {
        String::new()
    };
    let _ = writeln!(text, "regimes    {}{more}", shares.join(", "));
    let strongest = summary.strongest_one_one.iter();
    let others = summary.strongest_of_all.iter();
    for best in strongest.chain(others.filter(|of_all| !is_one_one(of_all))) {
        text += &strongest_line(best, summary);
    }
    let _ = writeln!(
        text,
        "periodic   {}; unsettled (still changing, regime not known) {}; flagged and run again {}",
        percent(summary.settled, summary.cells),
        percent(summary.unsettled, summary.cells),
        percent(summary.uncertain, summary.cells),
    );
    if run_on {
        text += "           (--settle 5000 computes these cells for longer)\n";
    }
    if summary.failed > 0 {
        let _ = writeln!(
            text,
            "failed     {}: the hammer leaves the model's range; these cells have no regime",
            count(summary.failed, "cell")
        );
    }
    text
}

/// To four decimals.
fn rounded(x: f64) -> f64 {
    (x * 1e4).round() / 1e4
}

fn is_one_one(cell: &StrongestCell) -> bool {
    matches!(cell.regime, Outcome::Regime(regime) if regime.is(1, 1))
}

/// A cell with the largest force: of 1/1, of all regimes, or of both.
fn strongest_line(best: &StrongestCell, summary: &MapSummary) -> String {
    let of_all = summary.strongest_of_all.as_ref() == Some(best);
    let what = match (is_one_one(best), of_all) {
        (true, true) => "strongest of all: 1/1 with".to_owned(),
        (true, false) => "strongest 1/1:".to_owned(),
        (false, _) => format!("strongest of all: {} with", best.regime),
    };
    format!(
        "{what} {:.2} N, {:.2} times the weight, at a gap of {:?} mm and {:?} Hz (Ω/ω {:.3})\n",
        best.force_n,
        best.force_ratio,
        best.gap_mm,
        rounded(best.frequency_hz),
        best.frequency_ratio
    )
}

/// The map in letters, the largest gap on top: each letter shows the cell in the middle of what it covers.
fn chart(map: &Map) -> String {
    const ROWS: usize = 18;
    const GUTTER: usize = 8;
    let (gaps, frequencies) = (&map.grid.gaps_mm, &map.grid.frequencies_hz);
    let rows = gaps.len().min(ROWS);
    let columns = frequencies.len().min(terminal_width() - GUTTER - 1);
    let middle = |i: usize, of: usize, all: usize| (2 * i + 1) * all / (2 * of);
    let mut text = format!("{:>GUTTER$}\n", "gap, mm");
    for row in (0..rows).rev() {
        let at = middle(row, rows, gaps.len());
        let letters: String = (0..columns)
            .map(|column| {
                letter(
                    map.cell(at, middle(column, columns, frequencies.len()))
                        .label(),
                )
            })
            .collect();
        let _ = writeln!(text, "{:>GUTTER$.2} {letters}", gaps[at]);
    }
    let first = frequencies
        .first()
        .map_or(String::new(), |f| format!("{f:.2}"));
    let last = frequencies
        .last()
        .map_or(String::new(), |f| format!("{f:.2} Hz"));
    let space = columns.saturating_sub(first.len()).max(last.len() + 1);
    let _ = writeln!(text, "{:GUTTER$} {first}{last:>space$}", "");
    text + "1: 1/1   2: 1/2   3: 1/3   d: 2/2   p: other p/n   ~: aperiodic   c: chatter   .: no contact   ?: unsettled   x: failed\n"
}

fn letter(cell: Outcome) -> char {
    let regime = match cell {
        Outcome::Regime(regime) => regime,
        Outcome::Unsettled => return '?',
        Outcome::Failed => return 'x',
    };
    match regime {
        Regime::None => '.',
        Regime::Periodic {
            impacts: 1,
            periods: 1,
        } => '1',
        Regime::Periodic {
            impacts: 1,
            periods: 2,
        } => '2',
        Regime::Periodic {
            impacts: 1,
            periods: 3,
        } => '3',
        Regime::Periodic {
            impacts: 2,
            periods: 2,
        } => 'd',
        Regime::Periodic { .. } => 'p',
        Regime::Aperiodic { .. } => '~',
        Regime::Chatter { .. } => 'c',
    }
}
