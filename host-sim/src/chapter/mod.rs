//! What the chapter says, statement by statement: its words, what is computed here, and whether they are the same.
//!
//! Statements about measurements cannot be judged, as the measurements are not public. Figures come from the program;
//! only sections and the few words quoted are written down here.

mod beams;
mod contact;
mod maps;
mod wires;

use serde::{Deserialize, Serialize};

use crate::figures::Effort;
use crate::progress::ProgressLine;
use files::UserError;

/// Whether what is computed is what the chapter says.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ChapterVerdict {
    /// What is computed here is what the chapter says.
    Same,
    /// What is computed here contradicts the chapter.
    Differs,
    /// Nothing here can tell: it needs the chapter's measurements, or the chapter names no figure.
    CannotBeTold,
}

impl ChapterVerdict {
    /// The verdict as tables and pages show it.
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
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Statement {
    /// Its number in this list.
    pub number: usize,
    /// Where it stands: a section, with figure, table or equation.
    pub section: String,
    /// What the chapter says, shortened.
    pub words: String,
    /// What is computed here.
    pub ours: String,
    /// Whether they are the same.
    pub verdict: ChapterVerdict,
    /// The figures of `host-sim figures` that show it, with commas.
    pub figures: String,
}

impl Statement {
    fn new(section: impl Into<String>, words: &str, ours: String, verdict: ChapterVerdict) -> Self {
        let section = section.into();
        Self {
            number: 0,
            figures: figures_in(&section).join(", "),
            section,
            words: words.to_owned(),
            ours,
            verdict,
        }
    }

    /// One that needs the chapter's measurements.
    fn measured(section: &str, words: &str, ours: impl Into<String>) -> Self {
        Self::new(section, words, ours.into(), ChapterVerdict::CannotBeTold)
    }

    /// Names the figures that show the statement, separated by `, `.
    fn shown_by(mut self, figures: &str) -> Self {
        figures.clone_into(&mut self.figures);
        self
    }

    /// Whether this figure shows it.
    pub fn is_shown_by(&self, figure: &str) -> bool {
        self.figures.split(", ").any(|shown| shown == figure)
    }
}

/// The chapter's figures that a section names: of "3.4.2, figures 3.41 and 3.42" these two, of "figures 3.12 to 3.14" three.
fn figures_in(section: &str) -> Vec<String> {
    let (_, named) = section.split_once("figure").unwrap_or_default();
    let mut numbers: Vec<u32> = Vec::new();
    let mut from = None;
    for word in named.split([' ', ',', '(']) {
        let digits = word.strip_prefix("3.").unwrap_or_default();
        let digits = digits.trim_end_matches(char::is_alphabetic);
        if let Ok(number) = digits.parse() {
            numbers.extend(from.take().unwrap_or(number)..=number);
        }
        if word == "to" {
            from = numbers.last().map(|last| last + 1);
        }
    }
    numbers.iter().map(|number| format!("3.{number}")).collect()
}

/// Every statement, in the chapter's order. With [`Effort::Coarse`] grids are coarser; the verdicts are the same.
///
/// # Errors
/// If a motion cannot be followed; with the presets none is.
pub fn statements(effort: Effort, progress: &ProgressLine) -> Result<Vec<Statement>, UserError> {
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
    all.sort_by_cached_key(|s: &Statement| s.section.split([' ', ',']).next().map(str::to_owned));
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

#[cfg(test)]
mod tests {
    use super::figures_in;

    #[test]
    fn the_figures_of_a_section_are_found() {
        for (section, figures) in [
            ("3.3.3, Table 3.2", &[][..]),
            ("3.1.2, figure 3.2, point A", &["3.2"]),
            ("3.3.6, figure 2.20", &[]),
            ("3.3.4, figures 3.12 to 3.14", &["3.12", "3.13", "3.14"]),
            ("3.4.2, figures 3.41 and 3.42", &["3.41", "3.42"]),
            (
                "3.4.3, figures 3.46(b), 3.48(b), 3.50(b)",
                &["3.46", "3.48", "3.50"],
            ),
            ("3.4.2, figure 3.40c", &["3.40"]),
        ] {
            assert_eq!(figures_in(section), figures, "{section}");
        }
    }
}
