//! Sections, and the smoothing method against the switch: figures 3.4 and 3.16–3.23.

use super::{Effort, Page};
use crate::pictures::poincare::{against_figure, chapter};
use crate::progress::ProgressLine;
use files::UserError;
use numerics::NamedRig;
use numerics::engine::Start;
use numerics::poincare::{self, SectionRequest, against};

/// The preset called `name` at `gap_mm`.
pub(crate) fn rig(name: &str, gap_mm: f64) -> Result<NamedRig, UserError> {
    let NamedRig { name, params, .. } = NamedRig::preset(name)?;
    Ok(NamedRig::new(name, params.with_gap_mm(gap_mm)?))
}

/// The section of `rig` from rest at drive phase 0: `points` after a transient, at the frequency ratio `ratio`.
pub(crate) fn from_rest(rig: &NamedRig, ratio: f64, transient: u32, points: u32) -> SectionRequest {
    SectionRequest {
        params: rig.params,
        frequency_hz: ratio * rig.params.natural_frequency_hz(),
        start: Start::Rest,
        phases: vec![0.0],
        transient,
        points,
    }
}

/// Figure 3.4's point on this rig.
///
/// # Errors
/// If a motion cannot be followed or a picture cannot be drawn; with the presets neither happens.
pub fn smoothing(effort: Effort, progress: &ProgressLine) -> Result<Vec<Page>, UserError> {
    const RATIO: f64 = 2.7;
    let rig = rig("wires", 1.0)?;
    let (points, transient) = effort.of((10_000, 500), (200, 100));
    let request = from_rest(&rig, RATIO, transient, points);
    let found = against::against(&request, &against::WIDTHS_M, progress)?;
    let page = Page::new(
        "3.4",
        "The smoothing method against the switch on one chaotic Poincaré section",
        format!(
            "host-sim poincare --rig wires --gap 1 --ratio {RATIO} --cart prescribed --against smoothed --points {points} --transient {transient}"
        ),
        &against_figure(&rig, &request, &found),
    )?;
    Ok(vec![page.table("", &found.rows())])
}

/// Figure, gap (mm), Ω/ω, the words, and the regime they name (p, n).
pub type ShownSection = (&'static str, f64, f64, &'static str, Option<(u16, u8)>);

/// The motions that section 3.3.5 shows.
pub const SHOWN: [ShownSection; 8] = [
    (
        "3.16",
        0.0,
        2.7,
        "\"after the bifurcation\" (0.0 mm, 2.7)",
        None,
    ),
    (
        "3.17",
        0.0,
        3.8,
        "\"second frequency band (z = 1/2)\" (0.0 mm, 3.8)",
        Some((1, 2)),
    ),
    (
        "3.18",
        1.0,
        1.5,
        "\"first frequency band (z = 1/1)\" (1.0 mm, 1.5)",
        Some((1, 1)),
    ),
    (
        "3.19",
        1.0,
        3.3,
        "\"second frequency band (z = 1/2)\" (1.0 mm, 3.3)",
        Some((1, 2)),
    ),
    (
        "3.20",
        1.0,
        4.7,
        "\"after the bifurcation\" (1.0 mm, 4.7)",
        None,
    ),
    (
        "3.21",
        2.4,
        1.2,
        "\"first frequency band (z = 1/1)\" (2.4 mm, 1.2)",
        Some((1, 1)),
    ),
    (
        "3.22",
        2.4,
        1.4,
        "shown at 2.4 mm, 1.4; no regime named",
        None,
    ),
    (
        "3.23",
        2.4,
        2.7,
        "shown at 2.4 mm, 2.7; no regime named",
        None,
    ),
];

/// Displacement, phase plane and section: figures 3.16 to 3.23.
///
/// # Errors
/// If a motion cannot be followed or a picture cannot be drawn; with the presets neither happens.
pub fn portraits(effort: Effort, progress: &ProgressLine) -> Result<Vec<Page>, UserError> {
    let (points, transient) = effort.of((2000, 600), (60, 200));
    let page = |&(number, gap, ratio, ..): &ShownSection| {
        let rig = rig("wires", gap)?;
        let request = from_rest(&rig, ratio, transient, points);
        let portrait = poincare::portrait(&request, progress)?;
        let page = Page::new(
            number,
            format!("Wires, {gap:?} mm, Ω/ω = {ratio}: displacement, phase plane and Poincaré map"),
            format!(
                "host-sim poincare --rig wires --gap {gap:?} --ratio {ratio} --cart prescribed --points {points} --transient {transient}"
            ),
            &chapter(&rig, &request, &portrait),
        )?;
        Ok(page.table("", &portrait.sections[0]))
    };
    SHOWN.iter().map(page).collect()
}
