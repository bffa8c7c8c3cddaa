//! The chapter's figures, made again: a module for each area of analysis, and the list of all parts.

pub mod basins;
pub mod bifurcation;
pub mod conclusion;
pub mod contact;
pub mod force;
pub(crate) mod force_curves;
pub mod map;
pub(crate) mod map_force;
pub mod modes;
pub mod orbits;
pub mod section;
pub mod switch;

use serde::Serialize;

use crate::pictures::drawn;
use crate::progress::ProgressLine;
use files::UserError;
use files::made_from::MadeFrom;
use files::table::to_csv;
use numerics::NamedRig;
use plot::Figure;

/// One figure of the chapter (or one beyond it), made again.
#[derive(Clone, Debug, PartialEq)]
pub struct Page {
    /// The chapter's number, "3.27"; of what goes beyond it, a short name.
    pub figure: &'static str,
    /// What the figure shows, its heading.
    pub title: String,
    /// What the picture does not say, of what the statements of the chapter do not judge; empty if nothing.
    pub note: String,
    /// A command that makes the like of it for other rigs, gaps and ranges; empty if there is none.
    pub command: String,
    /// Pictures (SVG, PNG) and tables (CSV): name and content. Names are unique and begin with `figure-3-27`.
    pub files: Vec<(String, Vec<u8>)>,
}

impl Page {
    /// A page with its picture.
    fn new(
        figure: &'static str,
        title: impl Into<String>,
        command: impl Into<String>,
        picture: &Figure,
    ) -> Result<Self, UserError> {
        Ok(Self {
            figure,
            title: title.into(),
            note: String::new(),
            command: command.into(),
            files: drawn(&stem(figure), picture)?,
        })
    }

    /// Adds a table. `end` stands behind the name of the figure in that of the file, as in `figure-3-24-cells.csv`.
    fn table<T: Serialize>(mut self, end: &str, rows: &[T]) -> Self {
        let name = format!("{}{end}.csv", stem(self.figure));
        self.files.push((name, to_csv(rows)));
        self
    }

    /// Says what the picture does not.
    fn noted(self, note: String) -> Self {
        Self { note, ..self }
    }
}

/// How finely to compute.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effort {
    /// As the chapter, or finer.
    Full,
    /// A coarse grid and few cycles, for a first look and for tests: seconds in all.
    Coarse,
}

impl Effort {
    /// What goes with it: `full` or `coarse`.
    pub fn of<T>(self, full: T, coarse: T) -> T {
        match self {
            Self::Full => full,
            Self::Coarse => coarse,
        }
    }
}

/// Makes the pages of one area.
pub type PageMaker = fn(Effort, &ProgressLine) -> Result<Vec<Page>, UserError>;

/// What a part makes.
#[derive(Clone, Copy, Debug)]
pub enum Make {
    /// Pages, by this function.
    Pages(PageMaker),
    /// What the chapter says, statement by statement, with verdicts.
    Statements,
}

/// Figures that are made together because they share their runs. Keep parts small: one figure asked for alone makes its
/// whole part, and an interrupted part begins again.
#[derive(Clone, Copy, Debug)]
pub struct FiguresPart {
    /// Name of the part, under which its record is kept.
    pub name: &'static str,
    /// The figures it makes.
    pub figures: &'static [&'static str],
    /// How long it takes with [`Effort::Full`], s, on two cores. The time left is estimated from them.
    pub seconds: f64,
    /// What it makes, and how.
    pub make: Make,
}

impl FiguresPart {
    /// A part from its fields.
    pub const fn new(
        name: &'static str,
        figures: &'static [&'static str],
        seconds: f64,
        make: PageMaker,
    ) -> Self {
        Self {
            name,
            figures,
            seconds,
            make: Make::Pages(make),
        }
    }
}

/// Every part, in the chapter's order.
pub const AREAS: &[FiguresPart] = &[
    FiguresPart::new(
        "contact laws",
        &["3.2", "3.3", "contact laws"],
        0.3,
        contact::law_pages,
    ),
    FiguresPart::new("conclusion", &["conclusion"], 10.6, conclusion::pages),
    FiguresPart::new(
        "smoothing against the switch",
        &["3.4"],
        13.3,
        section::smoothing,
    ),
    FiguresPart::new("switch model", &["3.5", "3.6"], 0.9, switch::pages),
    FiguresPart::new(
        "drop tests",
        &["3.8", "3.9", "3.10"],
        11.3,
        contact::drop_pages,
    ),
    FiguresPart::new("force, wires", &["3.12", "3.13", "3.14"], 0.3, force::wires),
    FiguresPart::new(
        "sections, wires",
        &[
            "3.16", "3.17", "3.18", "3.19", "3.20", "3.21", "3.22", "3.23",
        ],
        0.7,
        section::portraits,
    ),
    FiguresPart::new("maps, wires", &["3.24", "3.25", "3.26"], 7.4, map::wires),
    FiguresPart::new(
        "bifurcation, wires 0.0 mm",
        &["3.27", "3.28", "3.29"],
        0.5,
        |effort, progress| bifurcation::wires(0.0, ["3.27", "3.28", "3.29"], effort, progress),
    ),
    FiguresPart::new(
        "bifurcation, wires 1.0 mm",
        &["3.30", "3.31", "3.32"],
        0.5,
        |effort, progress| bifurcation::wires(1.0, ["3.30", "3.31", "3.32"], effort, progress),
    ),
    FiguresPart::new(
        "bifurcation, wires 2.4 mm",
        &["3.33", "3.34", "3.35"],
        0.6,
        |effort, progress| bifurcation::wires(2.4, ["3.33", "3.34", "3.35"], effort, progress),
    ),
    basins::PARTS[0],
    basins::PARTS[1],
    basins::PARTS[2],
    FiguresPart::new("force, beams", &["3.40", "3.41", "3.42"], 0.9, force::beams),
    FiguresPart::new(
        "bifurcation, beams",
        &["3.43", "3.44", "3.45"],
        0.6,
        bifurcation::beams,
    ),
    basins::PARTS[3],
    basins::PARTS[4],
    basins::PARTS[5],
    FiguresPart::new(
        "orbits",
        &["orbits at 0.0 mm", "orbits at 1.0 mm", "orbits at 2.4 mm"],
        4.2,
        orbits::branches,
    ),
    FiguresPart::new(
        "orbits over the map",
        &["orbits over the map"],
        7.8,
        orbits::over_the_map,
    ),
    FiguresPart::new(
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
        32.0,
        map::beams,
    ),
    FiguresPart::new(
        "map by the switch model",
        &["switch-map"],
        20.0,
        map::switch_model,
    ),
    FiguresPart::new(
        "modes of the beams",
        &["modes 170", "modes 150", "modes 135"],
        2.1,
        modes::beams,
    ),
    FiguresPart::new("mass of the beams", &["modes mass"], 6.2, modes::mass),
    FiguresPart {
        name: "statements",
        figures: &[],
        seconds: 19.0,
        make: Make::Statements,
    },
];

/// Figures of the chapter that are no computations, and what they are.
pub const DRAWINGS: [(&str, &str); 5] = [
    ("3.1", "a drawing: where the energy of an impact goes"),
    (
        "3.7",
        "a photograph: the steel hammer made for the identification",
    ),
    ("3.11", "a drawing: the hammer on wires"),
    ("3.15", "a drawing: what a Poincaré map is"),
    ("3.39", "a drawing: the hammer on beam springs"),
];

/// The command that makes the figure alone: the same bytes.
pub fn alone(figure: &str, effort: Effort) -> String {
    let name = match figure.contains(' ') {
        true => format!("'{figure}'"),
        false => figure.to_owned(),
    };
    let coarse = effort.of("", " --coarse");
    format!("host-sim figures --only {name}{coarse}")
}

/// What the files of a figure are made from.
pub fn made_from(figure: &str, effort: Effort) -> MadeFrom {
    let rigs = rigs(figure);
    let rigs = rigs.iter().filter_map(|(name, gap_mm)| {
        let rig = NamedRig::preset(name).ok()?;
        let params = rig.params.with_gap_mm(gap_mm.unwrap_or(0.0)).ok()?;
        Some((NamedRig { params, ..rig }, gap_mm.is_some()))
    });
    let rigs: Vec<(NamedRig, bool)> = rigs.collect();
    let mut made = MadeFrom::this_program().with_rigs(rigs.iter().map(|(rig, _)| rig));
    for (used, (_, one_gap)) in made.rigs.iter_mut().zip(&rigs) {
        // The others show several gaps, which their titles name.
        if !one_gap {
            used.parameters.remove("gap_mm");
        }
    }
    made.command = alone(figure, effort);
    made.options = serde_json::Map::from_iter([
        ("only".to_owned(), figure.into()),
        ("coarse".to_owned(), (effort == Effort::Coarse).into()),
    ]);
    made
}

/// The rigs of a figure, with the gap (mm) where it shows one.
fn rigs(figure: &str) -> Vec<(&'static str, Option<f64>)> {
    let number = figure
        .strip_prefix("3.")
        .and_then(|n| n.parse::<u32>().ok());
    let beams = ["beam-170", "beam-150", "beam-135"];
    let beam = |i: u32| vec![(beams[(i % 3) as usize], None)];
    match (number, figure) {
        (Some(3), _) => Vec::new(),
        (Some(4 | 13 | 18..=20 | 30..=32), _) => vec![("wires", Some(1.0))],
        (Some(14 | 21..=23 | 33..=35), _) => vec![("wires", Some(2.4))],
        (Some(2 | 5 | 6 | 8 | 9 | 10 | 12 | 16 | 17 | 27..=29), _) => vec![("wires", Some(0.0))],
        (Some(n @ 40..=45), _) => beam(n - 40),
        (Some(n @ 46..=51), _) => beam((n - 46) / 2),
        (Some(n @ 52..=54), _) => beam(n - 52),
        (_, "conclusion") => ["wires"]
            .iter()
            .chain(&beams)
            .map(|rig| (*rig, None))
            .collect(),
        (_, "beams-alike") => beams.map(|rig| (rig, None)).to_vec(),
        (_, "modes 170" | "modes mass") => beam(0),
        (_, "modes 150") => beam(1),
        (_, "modes 135") => beam(2),
        _ => vec![("wires", None)],
    }
}

/// How the files of a figure begin: `figure-3-27` for "3.27".
pub fn stem(figure: &str) -> String {
    format!("figure-{}", figure.replace(['.', ' '], "-"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_part_has_a_measured_time() {
        for part in AREAS {
            assert!(part.seconds > 0.0 && part.seconds < 1e4, "{}", part.name);
        }
    }

    #[test]
    fn every_figure_is_made_by_one_part_or_is_no_computation() {
        let made: Vec<&str> = AREAS
            .iter()
            .flat_map(|part| part.figures)
            .copied()
            .collect();
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
