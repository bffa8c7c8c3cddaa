//! What the chapter says, statement by statement: its words, what is computed here, and whether they are the same.
//!
//! Statements about measurements cannot be judged, as the measurements are not public. Figures come from the program;
//! only sections and the few words quoted are written down here.

mod beams;
mod contact;
mod maps;
mod wires;

use serde::Serialize;

use crate::figures::Effort;
use crate::progress::Progress;
use files::UserError;

/// Whether what is computed is what the chapter says.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// It is.
    Same,
    /// It is not.
    Differs,
    /// Nothing here can tell: it needs the chapter's measurements, or the chapter names no figure.
    CannotBeTold,
}

impl Verdict {
    /// In words.
    pub fn words(self) -> &'static str {
        match self {
            Self::Same => "same",
            Self::Differs => "differs",
            Self::CannotBeTold => "cannot be told",
        }
    }

    fn of(same: bool) -> Self {
        if same { Self::Same } else { Self::Differs }
    }
}

/// A statement of the chapter.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Statement {
    /// Its number in this list.
    pub number: usize,
    /// Where it stands: a section, with figure, table or equation.
    pub section: &'static str,
    /// Its words, shortened.
    pub words: &'static str,
    /// What is computed here.
    pub ours: String,
    /// Whether they are the same.
    pub verdict: Verdict,
}

impl Statement {
    fn new(section: &'static str, words: &'static str, ours: String, verdict: Verdict) -> Self {
        Self {
            number: 0,
            section,
            words,
            ours,
            verdict,
        }
    }

    /// One that needs the chapter's measurements.
    fn measured(section: &'static str, words: &'static str, ours: impl Into<String>) -> Self {
        Self::new(section, words, ours.into(), Verdict::CannotBeTold)
    }
}

/// Every statement, in the chapter's order. With [`Effort::Coarse`] grids are coarser; the verdicts are the same.
///
/// # Errors
/// If a motion cannot be followed; with the presets none is.
pub fn statements(effort: Effort, progress: &Progress) -> Result<Vec<Statement>, UserError> {
    let areas = [
        contact::statements,
        wires::statements,
        maps::wires,
        beams::statements,
        maps::beams,
        wires::conclusion,
    ];
    let mut all = Vec::new();
    for area in areas {
        all.extend(area(effort, progress)?);
        progress.inc(1);
    }
    all.sort_by_key(|statement| statement.section.split([' ', ',']).next());
    for (i, statement) in all.iter_mut().enumerate() {
        statement.number = i + 1;
    }
    Ok(all)
}

/// How many areas [`statements`] works through.
pub const AREAS: u64 = 6;

/// The share of `part` in `whole`, %.
fn percent(part: usize, whole: usize) -> f64 {
    100.0 * part as f64 / whole.max(1) as f64
}
