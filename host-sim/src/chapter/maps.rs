//! Sections 3.3.6 and 3.4.3: Peterka maps and basins of attraction.

use std::sync::Arc;

use super::{ChapterVerdict, Statement, percent};
use crate::figures::Effort;
use crate::figures::map::{chapter_map, silent_after_one_one, unrest_shares};
use crate::figures::map_force::{at_edge, strongest_rows};
use crate::progress::ProgressLine;
use files::UserError;
use numerics::basins::chapter::{ChapterBasin, POINTS};
use numerics::basins::explore;
use numerics::engine::Engine;
use numerics::map::request::{chapter_frequencies_hz, chapter_gaps_mm};
use numerics::map::{Map, similarity};
use shared::model::params::WIRES;

/// Every sixth gap and frequency.
const EVERY: usize = 6;

fn map(name: &str, effort: Effort, progress: &ProgressLine) -> Result<Arc<Map>, UserError> {
    chapter_map(name, effort.of(1, EVERY), progress)
}

pub fn wires(effort: Effort, progress: &ProgressLine) -> Result<Vec<Statement>, UserError> {
    let map = map("wires", effort, progress)?;
    let cells = chapter_gaps_mm(&WIRES).len() * chapter_frequencies_hz(&WIRES).len();
    let share = |p, n| {
        let of = map.cells.iter().filter(|c| c.regime.is(p, n)).count();
        percent(of, map.cells.len())
    };
    let others = |p: u16, n: u8| p != 1 || n > 2;
    let third = (1..=4u16)
        .flat_map(|p| (1..=4u8).map(move |n| (p, n)))
        .filter(|(p, n)| others(*p, *n))
        .map(|(p, n)| share(p, n))
        .fold(0.0, f64::max);
    let mut all = vec![
        Statement::new(
            "3.3.6, figure 3.24",
            "steps of \"0.01 mm in gap and 0.01 Hz in frequency, generating 209916 points\"",
            format!("the same grid: {cells} cells"),
            ChapterVerdict::of(cells == 209_916),
        ),
        Statement::measured(
            "3.3.6, figure 3.24",
            "\"around 120 hours\" on a PC",
            format!(
                "{:.2} s a simulation there; seconds for all here, on other machines (docs/performance.md)",
                120.0 * 3600.0 / 209_916.0
            ),
        ),
        Statement::new(
            "3.3.6, figure 3.24",
            "\"the areas where the two frequencies bands occur\", z = 1/1 and z = 1/2",
            format!(
                "1/1 in {:.1} % of the cells, 1/2 in {:.1} %; the next regime up to 4/4 in {third:.1} %",
                share(1, 1),
                share(1, 2)
            ),
            ChapterVerdict::of(share(1, 1).min(share(1, 2)) > third),
        ),
        Statement::measured(
            "3.3.6, figure 3.25",
            "measured points over the map",
            "they are not public; the text names the regimes of four (figures 3.17, 3.18, 3.19, 3.21)",
        ),
        edge(
            "3.3.6, figure 3.26",
            "the largest force \"does not occur at the z = 1/1 boundary, except for high values of gap\"",
            &map,
        ),
        unrest(
            "3.3.6, figure 3.24",
            "\"for a gap condition higher than 1.5\" various motions between 1/1 and 1/2",
            &map,
        ),
    ];
    for point in POINTS.iter().filter(|p| p.rig == "wires") {
        all.push(basin(point, effort, progress)?);
    }
    all.push(
        Statement::new(
            "3.3.6, figure 2.20",
            "a small push: impacts that end, or that \"remain in this state\"",
            "both fates occur at the points of figures 3.36 to 3.38, above".into(),
            ChapterVerdict::of(
                all.iter()
                    .rev()
                    .take(6)
                    .all(|s| s.verdict == ChapterVerdict::Same),
            ),
        )
        .shown_by("3.36, 3.37, 3.38"),
    );
    Ok(all)
}

fn edge(section: &str, words: &str, map: &Map) -> Statement {
    let rows = strongest_rows(map);
    let edge: Vec<f64> = rows
        .iter()
        .filter(|row| at_edge(map, row))
        .map(|row| row.gap_ratio)
        .collect();
    let low = edge.iter().filter(|gap| **gap < 1.0).count();
    let ours = format!(
        "at {} of {} gaps it lies at the upper edge of 1/1, {}; {low} of them are below 1 A0",
        edge.len(),
        rows.len(),
        match edge.first() {
            Some(first) => format!("the smallest of them {first:.2} A0"),
            None => "so nowhere".to_owned(),
        }
    );
    Statement::new(
        section,
        words,
        ours,
        ChapterVerdict::of(low == 0 && !edge.is_empty()),
    )
}

/// Whether the beams do after 1/1 what the wires do there.
fn instability(wires: &Map, beams: &[Arc<Map>]) -> Statement {
    let on_wires = silent_after_one_one(wires);
    let on_beams = beams.iter().map(|map| silent_after_one_one(map));
    let least = on_beams.fold(f64::INFINITY, f64::min);
    Statement::new(
        "3.4.3, figures 3.46(b), 3.48(b), 3.50(b)",
        "similar to wires, \"even the instability region after the z = 1/1 region\" above 1.5",
        format!(
            "of the cells after 1/1 above 1.5 A0, up to Ω/ω = 2 and from rest, {on_wires:.1} % end without contact on wires, at least {least:.1} % on each beam"
        ),
        ChapterVerdict::of((least - on_wires).abs() < 50.0),
    )
}

fn unrest(section: &str, words: &str, map: &Map) -> Statement {
    let [above, below] = unrest_shares(map);
    Statement::new(
        section,
        words,
        format!(
            "between Ω/ω 1.5 and 2.6 neighbours in frequency differ in regime in {above:.1} % of pairs above 1.5 A0 and in {below:.1} % below"
        ),
        ChapterVerdict::of(above > 1.2 * below),
    )
}

fn basin(
    point: &ChapterBasin,
    effort: Effort,
    progress: &ProgressLine,
) -> Result<Statement, UserError> {
    let side = effort.of(100, 60);
    let share = |point: &ChapterBasin| -> Result<f64, UserError> {
        let mut query = point.query(side, side)?;
        query.samples = 0;
        query.until = query.cycles;
        Ok(explore(Engine::Event, &query, progress)?
            .summary()
            .impact_share)
    };
    let here = share(point)?;
    let mut ours = format!(
        "Ω/ω = {:.2}, gap/A0 = {:.2}: {:.1} % of {side} by {side} starts still strike after 300 cycles",
        point.ratio,
        point.gap_over_amplitude,
        100.0 * here
    );
    if (point.figure, point.part) == ("3.36", "a") {
        let near = [1.99, 2.01].map(|ratio| share(&ChapterBasin { ratio, ..*point }));
        let [below, above] = near;
        ours += &format!(
            "; {:.0} % at 1.99, {:.0} % at 2.01: a knife edge",
            100.0 * below?,
            100.0 * above?
        );
    }
    Ok(Statement::new(
        format!(
            "{}, figure {}{}",
            if point.rig == "wires" {
                "3.3.6"
            } else {
                "3.4.3"
            },
            point.figure,
            point.part
        ),
        "\"condition of impact (blue) / no impact (red)\": both",
        ours,
        ChapterVerdict::of(here > 0.0 && here < 1.0),
    ))
}

pub fn beams(effort: Effort, progress: &ProgressLine) -> Result<Vec<Statement>, UserError> {
    let wires = map("wires", effort, progress)?;
    let names = ["beam-170", "beam-150", "beam-135"];
    let maps = names.map(|name| map(name, effort, progress));
    let [a, b, c] = maps;
    let maps = [a?, b?, c?];
    let orderly = |a: &Map, b: &Map| {
        let s = similarity(a, b);
        let rest = percent(s.same - s.same_orderly, s.cells - s.orderly);
        (
            percent(s.same_orderly, s.orderly),
            percent(s.same, s.cells),
            rest,
        )
    };
    let like_wires = maps.each_ref().map(|map| orderly(&wires, map));
    let pairs = [(0, 1), (0, 2), (1, 2)].map(|(i, j)| orderly(&maps[i], &maps[j]));
    let least = |of: &[(f64, f64, f64)], k: usize| {
        let of = of.iter().map(|t| [t.0, t.1, t.2][k]);
        of.fold(f64::INFINITY, f64::min)
    };
    let mut all = vec![
        Statement::new(
            "3.4.3, figures 3.46, 3.48, 3.50",
            "\"similar characteristics to the Peterka map supported by wires\"",
            format!(
                "over Ω/ω and gap/A0 the same regime in {:.1} % of the cells at least, in {:.1} % of those where both repeat in one or two periods. Wires have no damping: where they do not settle, beams do",
                least(&like_wires, 1),
                least(&like_wires, 0)
            ),
            ChapterVerdict::of(least(&like_wires, 0) > 90.0),
        ),
        instability(&wires, &maps),
        Statement::new(
            "3.4.3 and 3.5",
            "the beams' maps \"are identical in all cases, except for the chaotic region\"",
            format!(
                "the three by pairs: the same in {:.1} % of the cells at least; in {:.1} % where both repeat in one or two periods",
                least(&pairs, 1),
                least(&pairs, 0)
            ),
            ChapterVerdict::of(least(&pairs, 0) > 97.0),
        )
        .shown_by("beams-alike"),
        Statement::new(
            "3.4.3",
            "the non-dimensional gap \"takes into consideration the hammer's first natural bending vibration frequency\"",
            "the captions' gap/A0 has no frequency in it; the frequency is in Ω/ω".into(),
            ChapterVerdict::Differs,
        ),
        Statement::new(
            "3.4.3, figure 3.51",
            "caption: \"couplings distance 150 mm\"",
            "by its place after 3.50 it is the 135 mm rig's; 3.49 has the same caption".into(),
            ChapterVerdict::Differs,
        ),
    ];
    for (map, section) in maps.iter().zip([
        "3.4.3, figure 3.46(b)",
        "3.4.3, figure 3.48(b)",
        "3.4.3, figure 3.50(b)",
    ]) {
        all.push(unrest(
            section,
            "\"the instability region after the z = 1/1 region in values of non-dimensional gap higher than 1.5\"",
            map,
        ));
    }
    for (map, section) in maps.iter().zip([
        "3.4.3, figure 3.47",
        "3.4.3, figure 3.49",
        "3.4.3, figure 3.51",
    ]) {
        all.push(edge(
            section,
            "\"the same observations stated for the hammer supported by wires\", figure 3.26: where the largest force lies",
            map,
        ));
    }
    for point in POINTS.iter().filter(|p| p.rig != "wires") {
        all.push(basin(point, effort, progress)?);
    }
    Ok(all)
}
