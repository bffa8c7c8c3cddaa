//! Figures 3.36–3.38 and 3.52–3.54: basins of attraction.

use super::{Effort, FiguresPart, Page};
use crate::pictures::basins::parts;
use crate::progress::ProgressLine;
use files::UserError;
use numerics::basins::chapter::{ChapterBasin, POINTS};
use numerics::basins::{Basins, BasinsRequest, cells, explore};
use numerics::engine::Engine;

/// A part for each figure, which shares no runs with the others.
pub const PARTS: [FiguresPart; 6] = [
    FiguresPart::new("basins 3.36", &["3.36"], 9.8, |effort, progress| {
        page("3.36", effort, progress)
    }),
    FiguresPart::new("basins 3.37", &["3.37"], 10.1, |effort, progress| {
        page("3.37", effort, progress)
    }),
    FiguresPart::new("basins 3.38", &["3.38"], 10.3, |effort, progress| {
        page("3.38", effort, progress)
    }),
    FiguresPart::new("basins 3.52", &["3.52"], 6.3, |effort, progress| {
        page("3.52", effort, progress)
    }),
    FiguresPart::new("basins 3.53", &["3.53"], 8.6, |effort, progress| {
        page("3.53", effort, progress)
    }),
    FiguresPart::new("basins 3.54", &["3.54"], 10.2, |effort, progress| {
        page("3.54", effort, progress)
    }),
];

fn query(point: &ChapterBasin, effort: Effort) -> Result<BasinsRequest, UserError> {
    // The picture is of the starts on the grid alone.
    match effort {
        Effort::Full => Ok(BasinsRequest {
            samples: 0,
            ..point.query(250, 250)?
        }),
        Effort::Coarse => Ok(BasinsRequest {
            cycles: 120,
            recorded: 40,
            samples: 0,
            until: 200,
            ..point.query(10, 10)?
        }),
    }
}

fn page(
    figure: &'static str,
    effort: Effort,
    progress: &ProgressLine,
) -> Result<Vec<Page>, UserError> {
    let points: Vec<&ChapterBasin> = POINTS.iter().filter(|p| p.figure == figure).collect();
    let name = |point: &ChapterBasin| {
        format!(
            "{}) Ω/ω = {:.2}, gap/A0 = {:.2}",
            point.part, point.ratio, point.gap_over_amplitude
        )
    };
    let explored = |point: &&ChapterBasin| {
        let basins = explore(Engine::Event, &query(point, effort)?, progress)?;
        Ok((name(point), basins))
    };
    let found = points.iter().map(explored);
    let found: Vec<(String, Basins)> = found.collect::<Result<_, UserError>>()?;
    let rig = points.first().map_or("", |p| p.rig);
    let title = format!("Basins of attraction, {rig}: impact / no impact");
    let picture = parts(format!("Figure {figure}: {title}"), &found);
    let command = points.first().map_or(String::new(), |p| {
        format!(
            "host-sim basins --rig {rig} --cart prescribed --ratio {} --gap-ratio {} --out DIR",
            p.ratio, p.gap_over_amplitude
        )
    });
    let mut page = Page::new(figure, title, command, &picture)?;
    for (point, (_, basins)) in points.iter().zip(&found) {
        page = page.table(point.part, &cells::rows(basins));
    }
    Ok(vec![page])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_page_has_pictures_and_tables() {
        let quiet = ProgressLine::new("", 1, true);
        let all = page("3.52", Effort::Coarse, &quiet).unwrap();
        let [page] = all.as_slice() else {
            panic!("one page")
        };
        let names: Vec<_> = page.files.iter().map(|(name, _)| name.as_str()).collect();
        assert_eq!(
            names,
            [
                "figure-3-52.svg",
                "figure-3-52.png",
                "figure-3-52a.csv",
                "figure-3-52b.csv"
            ]
        );
        assert_eq!(POINTS.len(), 2 * PARTS.len());
    }
}
