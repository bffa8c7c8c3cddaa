//! The chapter's figures, made again: each area of analysis gives its pages, and `figures` puts them together.

use crate::error::UserError;
use crate::terminal::Progress;

/// One figure of the chapter (or one beyond it), made again.
#[derive(Clone, Debug, PartialEq)]
pub struct Page {
    /// The chapter's number, "3.27"; of what goes beyond it, a short name.
    pub figure: &'static str,
    /// What is shown.
    pub title: String,
    /// What the chapter says or shows.
    pub chapter: &'static str,
    /// What is found here, with the figures of this very run: agrees, differs, how much.
    pub found: String,
    /// How to make it alone: a command line.
    pub command: String,
    /// Pictures (SVG, PNG) and tables (CSV): name and content. Names are unique and begin with `figure-3-27`.
    pub files: Vec<(String, Vec<u8>)>,
}

/// How finely to compute.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effort {
    /// As the chapter, or finer.
    Full,
    /// A coarse grid and few cycles, for a first look and for tests: seconds in all.
    Coarse,
}

/// Makes the pages of one area.
pub type Area = fn(Effort, &Progress) -> Result<Vec<Page>, UserError>;

/// A part of the work that is done at once: its name, the figures it makes, and how. Keep parts small (what shares its
/// runs): one figure asked for alone makes its part, and an interrupted part is begun again.
pub type Part = (&'static str, &'static [&'static str], Area);

/// Every part, in the chapter's order.
pub const AREAS: &[Part] = &[];
