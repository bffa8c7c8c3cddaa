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

/// What the chapter says of a section that it shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Said {
    /// It lies after a band's bifurcation.
    AfterTheBifurcation,
    /// It lies in the band of 1/1.
    FirstBand,
    /// It lies in the band of 1/2.
    SecondBand,
    /// No regime.
    Nothing,
}

impl Said {
    /// Contacts and drive periods of the regime that it names.
    pub fn regime(self) -> Option<(u16, u8)> {
        match self {
            Self::FirstBand => Some((1, 1)),
            Self::SecondBand => Some((1, 2)),
            Self::AfterTheBifurcation | Self::Nothing => None,
        }
    }

    /// The chapter's words of a section at this gap and Ω/ω.
    pub fn words(self, gap_mm: f64, ratio: f64) -> String {
        let words = match self {
            Self::AfterTheBifurcation => "after the bifurcation",
            Self::FirstBand => "first frequency band (z = 1/1)",
            Self::SecondBand => "second frequency band (z = 1/2)",
            Self::Nothing => return format!("shown at {gap_mm:?} mm, {ratio}; no regime named"),
        };
        format!("\"{words}\" ({gap_mm:?} mm, {ratio})")
    }
}

/// A section that the chapter shows: its figure, gap in mm, Ω/ω, and what is said of it.
pub type ShownSection = (&'static str, f64, f64, Said);

/// The motions that section 3.3.5 shows.
pub const SHOWN: [ShownSection; 8] = [
    ("3.16", 0.0, 2.7, Said::AfterTheBifurcation),
    ("3.17", 0.0, 3.8, Said::SecondBand),
    ("3.18", 1.0, 1.5, Said::FirstBand),
    ("3.19", 1.0, 3.3, Said::SecondBand),
    ("3.20", 1.0, 4.7, Said::AfterTheBifurcation),
    ("3.21", 2.4, 1.2, Said::FirstBand),
    ("3.22", 2.4, 1.4, Said::Nothing),
    ("3.23", 2.4, 2.7, Said::Nothing),
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
