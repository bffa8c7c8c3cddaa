//! Sections, and the smoothing method against the switch: figures 3.4 and 3.16–3.23.

use serde::Serialize;

use super::{Effort, Page, stem};
use crate::pictures::drawn;
use crate::progress::Progress;
use files::UserError;
use files::table::to_csv;
use numerics::NamedRig;
use numerics::engine::Start;
use numerics::poincare::{self, against};
use plot::Figure;

/// The preset called `name` at `gap_mm`.
pub(crate) fn rig(name: &str, gap_mm: f64) -> Result<NamedRig, UserError> {
    let NamedRig { name, params, .. } = NamedRig::preset(name)?;
    Ok(NamedRig::new(name, params.with_gap_mm(gap_mm)?))
}

/// The files of a figure: picture and table.
pub(super) fn files<T: Serialize>(
    number: &str,
    figure: &Figure,
    table: &[T],
) -> Result<Vec<(String, Vec<u8>)>, UserError> {
    let name = stem(number);
    let mut files = drawn(&name, figure)?;
    files.push((format!("{name}.csv"), to_csv(table)));
    Ok(files)
}

/// Figure 3.4's point on this rig.
///
/// # Errors
/// If a motion cannot be followed or a picture cannot be drawn; with the presets neither happens.
pub fn smoothing(effort: Effort, progress: &Progress) -> Result<Vec<Page>, UserError> {
    const RATIO: f64 = 2.7;
    let rig = rig("wires", 1.0)?;
    let (points, transient) = match effort {
        Effort::Full => (10_000, 500),
        Effort::Coarse => (200, 100),
    };
    let request = poincare::SectionRequest {
        params: rig.params,
        frequency_hz: RATIO * rig.params.natural_frequency_hz(),
        start: Start::Rest,
        phases: vec![0.0],
        transient,
        points,
    };
    let found = against::against(&request, &against::WIDTHS_M, progress)?;
    let words = found.smoothed.iter().map(|s| {
        format!(
            "{:?} µm: {}, {:.3} A0 away, {:.0} % of the boxes not shared, {:.0} steps per drive period",
            numerics::row::tidy(s.epsilon_m * 1e6),
            match s.summary.section_periods {
                Some(n) => format!("repeats after {n}"),
                None => "does not repeat".to_owned(),
            },
            s.summary.carried,
            100.0 * s.summary.boxes_not_shared,
            s.summary.steps_per_period
        )
    });
    let words = words.collect::<Vec<_>>().join("; ");
    let changed = found
        .smoothed
        .iter()
        .any(|s| s.summary.carried > 10.0 * found.again.carried);
    Ok(vec![Page {
        figure: "3.4",
        title: "The smoothing method against the switch on one chaotic Poincaré section".to_owned(),
        chapter: "3.2.2: with chaos \"the results using the smoothing method will probably be incorrect\"; it \"yields stiff differential equations\". The figure shows the Poincaré map at three smoothing parameters (a, b, c) and of the discontinuous system (d).",
        found: format!(
            "{}: wires, 1.0 mm, Ω/ω = {RATIO}. By width of the smoothing: {words}. The switch needs {:.0} steps per drive period; two of its own runs are {:.4} A0 and {:.1} % of the boxes apart.",
            if changed { "Agrees" } else { "Differs" },
            found.summary.steps_per_period,
            found.again.carried,
            100.0 * found.again.boxes_not_shared
        ),
        command: format!(
            "host-sim poincare --rig wires --gap 1 --ratio {RATIO} --cart prescribed --against smoothed --points {points} --transient {transient}"
        ),
        files: files(
            "3.4",
            &crate::pictures::poincare::against_figure(&rig, &request, &found),
            &found.rows(),
        )?,
    }])
}

/// Contacts in drive periods: p and n.
type Z = (u16, u8);

/// Figure, gap (mm), Ω/ω, what the chapter calls it, and the p/n that stands for.
const SECTIONS: [(&str, f64, f64, &str, Option<Z>); 8] = [
    (
        "3.16",
        0.0,
        2.7,
        "3.3.5: \"the comparison after the bifurcation\".",
        None,
    ),
    (
        "3.17",
        0.0,
        3.8,
        "3.3.5: \"second frequency band (z = 1/2)\".",
        Some((1, 2)),
    ),
    (
        "3.18",
        1.0,
        1.5,
        "3.3.5: \"first frequency band (z = 1/1)\".",
        Some((1, 1)),
    ),
    (
        "3.19",
        1.0,
        3.3,
        "3.3.5: \"second frequency band (z = 1/2)\".",
        Some((1, 2)),
    ),
    (
        "3.20",
        1.0,
        4.7,
        "3.3.5: \"the comparison after the bifurcation\".",
        None,
    ),
    (
        "3.21",
        2.4,
        1.2,
        "3.3.5: \"first frequency band (z = 1/1)\".",
        Some((1, 1)),
    ),
    (
        "3.22",
        2.4,
        1.4,
        "3.3.5 shows it (2.4 mm, 1.4) and names no regime.",
        None,
    ),
    (
        "3.23",
        2.4,
        2.7,
        "3.3.5 shows it (2.4 mm, 2.7) and names no regime.",
        None,
    ),
];

/// Displacement, phase plane and section: figures 3.16 to 3.23.
///
/// # Errors
/// If a motion cannot be followed or a picture cannot be drawn; with the presets neither happens.
pub fn portraits(effort: Effort, progress: &Progress) -> Result<Vec<Page>, UserError> {
    let (points, transient) = match effort {
        Effort::Full => (2000, 600),
        Effort::Coarse => (60, 200),
    };
    let page = |(number, gap, ratio, chapter, expected): (_, f64, f64, &'static str, Option<Z>)| {
        let rig = rig("wires", gap)?;
        let request = poincare::SectionRequest {
            params: rig.params,
            frequency_hz: ratio * rig.params.natural_frequency_hz(),
            start: Start::Rest,
            phases: vec![0.0],
            transient,
            points,
        };
        let portrait = poincare::portrait(&request, progress)?;
        let verdict = match expected {
            Some((p, n)) if portrait.regime.is(p, n) => "Agrees",
            Some(_) => "Differs",
            // After a band's bifurcation neither band's motion is left.
            None if chapter.contains("after the bifurcation") => {
                match portrait.regime.is(1, 1) || portrait.regime.is(1, 2) {
                    false => "Agrees: neither 1/1 nor 1/2 is left",
                    true => "Differs",
                }
            }
            None => "Cannot be told: the chapter names no regime",
        };
        let found = format!(
            "{verdict}: from rest z = {} over {points} drive periods, largest force {:.2} times the weight. The chapter's measured curves are not available as numbers.",
            portrait.regime,
            portrait.force_n / rig.params.weight_n()
        );
        Ok(Page {
            figure: number,
            title: format!(
                "Wires, {gap:?} mm, Ω/ω = {ratio}: displacement, phase plane and Poincaré map"
            ),
            chapter,
            found,
            command: format!(
                "host-sim poincare --rig wires --gap {gap:?} --ratio {ratio} --cart prescribed --points {points} --transient {transient}"
            ),
            files: files(
                number,
                &crate::pictures::poincare::chapter(&rig, &request, &portrait),
                &portrait.sections[0],
            )?,
        })
    };
    SECTIONS.into_iter().map(page).collect()
}
