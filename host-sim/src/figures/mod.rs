//! The chapter's figures, made again: each area of analysis gives its pages, and `figures` puts them together.

pub mod basins;
pub mod bifurcation;
pub mod conclusion;
pub mod contact;
pub mod force;
pub mod gap;
pub mod map;
pub mod modes;
pub mod orbits;
pub mod section;
pub mod switch;

use crate::progress::Progress;
use files::UserError;

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
pub const AREAS: &[Part] = &[
    ("contact laws", &["3.3", "contact laws"], contact::law_pages),
    ("conclusion", &["conclusion"], conclusion::pages),
    ("smoothing against the switch", &["3.4"], section::smoothing),
    ("switch model", &["3.5", "3.6"], switch::pages),
    ("drop tests", &["3.9", "3.10"], contact::drop_pages),
    ("force, wires", &["3.12", "3.13", "3.14"], force::wires),
    (
        "sections, wires",
        &[
            "3.16", "3.17", "3.18", "3.19", "3.20", "3.21", "3.22", "3.23",
        ],
        section::portraits,
    ),
    ("maps, wires", &["3.24", "3.25", "3.26"], map::wires),
    (
        "bifurcation, wires 0.0 mm",
        &["3.27", "3.28", "3.29"],
        bifurcation::wires_0,
    ),
    (
        "bifurcation, wires 1.0 mm",
        &["3.30", "3.31", "3.32"],
        bifurcation::wires_1,
    ),
    (
        "bifurcation, wires 2.4 mm",
        &["3.33", "3.34", "3.35"],
        bifurcation::wires_2,
    ),
    basins::PARTS[0],
    basins::PARTS[1],
    basins::PARTS[2],
    ("force, beams", &["3.40", "3.41", "3.42"], force::beams),
    (
        "bifurcation, beams",
        &["3.43", "3.44", "3.45"],
        bifurcation::beams,
    ),
    basins::PARTS[3],
    basins::PARTS[4],
    basins::PARTS[5],
    (
        "orbits",
        &["orbits at 0.0 mm", "orbits at 1.0 mm", "orbits at 2.4 mm"],
        orbits::branches,
    ),
    (
        "orbits over the map",
        &["orbits over the map"],
        orbits::over_the_map,
    ),
    (
        "maps, beams",
        &[
            "3.46",
            "3.47",
            "3.48",
            "3.49",
            "3.50",
            "3.51",
            "beams-alike",
        ],
        map::beams,
    ),
    (
        "map by the switch model",
        &["switch-map"],
        map::switch_model,
    ),
    (
        "modes of the beams",
        &["modes 170", "modes 150", "modes 135"],
        modes::beams,
    ),
    ("mass of the beams", &["modes mass"], modes::mass),
    gap::PARTS[0],
];

/// Figures of the chapter that are no computations, and what they are.
pub const DRAWINGS: [(&str, &str); 7] = [
    ("3.1", "a drawing: where the energy of an impact goes"),
    (
        "3.2",
        "a drawing: the force of the spring-dashpot over an impact",
    ),
    (
        "3.7",
        "a photograph: the steel hammer made for the identification",
    ),
    (
        "3.8",
        "a measurement: force and acceleration of a first impact",
    ),
    ("3.11", "a drawing: the hammer on wires"),
    ("3.15", "a drawing: what a Poincaré map is"),
    ("3.39", "a drawing: the hammer on beam springs"),
];

/// How the files of a figure begin: `figure-3-27` for "3.27".
pub fn stem(figure: &str) -> String {
    format!("figure-{}", figure.replace(['.', ' '], "-"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_figure_is_made_by_one_part_or_is_no_computation() {
        let made: Vec<&str> = AREAS.iter().flat_map(|part| part.1).copied().collect();
        for (i, figure) in made.iter().enumerate() {
            assert!(!made[i + 1..].contains(figure), "{figure} is made twice");
            assert!(DRAWINGS.iter().all(|d| d.0 != *figure), "{figure}");
        }
        let absent: Vec<String> = (1..=54)
            .map(|n| format!("3.{n}"))
            .filter(|n| !made.contains(&n.as_str()) && DRAWINGS.iter().all(|d| d.0 != n))
            .collect();
        assert!(absent.is_empty(), "nothing makes {absent:?}");
    }
}
