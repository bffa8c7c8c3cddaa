//! Figures 3.36–3.38 and 3.52–3.54: basins of attraction, and the gap advice as a page beyond the chapter.

use super::{Effort, Page, Part};
use crate::pictures::basins::parts;
use crate::pictures::drawn;
use crate::progress::Progress;
use files::UserError;
use files::table::to_csv;
use numerics::basins::chapter::{POINTS, Point};
use numerics::basins::{Basins, BasinsRequest, Summary, cells, explore};
use numerics::engine::Engine;

/// A part for each figure, which shares no runs with the others.
pub const PARTS: [Part; 6] = [
    Part::new("basins 3.36", &["3.36"], 21.0, |effort, progress| {
        page("3.36", effort, progress)
    }),
    Part::new("basins 3.37", &["3.37"], 21.0, |effort, progress| {
        page("3.37", effort, progress)
    }),
    Part::new("basins 3.38", &["3.38"], 31.0, |effort, progress| {
        page("3.38", effort, progress)
    }),
    Part::new("basins 3.52", &["3.52"], 25.0, |effort, progress| {
        page("3.52", effort, progress)
    }),
    Part::new("basins 3.53", &["3.53"], 30.0, |effort, progress| {
        page("3.53", effort, progress)
    }),
    Part::new("basins 3.54", &["3.54"], 60.0, |effort, progress| {
        page("3.54", effort, progress)
    }),
];

/// What the chapter's text says about all six figures.
const CHAPTER: &str = "3.3.6: above a gap of 1.5, between z = 1/1 and z = 1/2, \"various impact conditions\" occur that depend on the start; after a small push impacts end, or they remain. The caption: \"condition of impact (blue) / no impact (red)\".";

/// Every page, in order.
///
/// # Errors
/// As those of [`explore`].
pub fn pages(effort: Effort, progress: &Progress) -> Result<Vec<Page>, UserError> {
    let mut all = Vec::new();
    for part in PARTS {
        all.extend((part.make)(effort, progress)?);
    }
    Ok(all)
}

fn query(point: &Point, effort: Effort) -> Result<BasinsRequest, UserError> {
    match effort {
        Effort::Full => Ok(point.query(500, 500)?),
        Effort::Coarse => Ok(BasinsRequest {
            cycles: 120,
            recorded: 40,
            samples: 20,
            until: 200,
            ..point.query(10, 10)?
        }),
    }
}

fn page(figure: &'static str, effort: Effort, progress: &Progress) -> Result<Vec<Page>, UserError> {
    let points: Vec<&Point> = POINTS.iter().filter(|p| p.figure == figure).collect();
    let mut found = Vec::with_capacity(points.len());
    for point in &points {
        let basins = explore(Engine::Event, &query(point, effort)?, progress)?;
        let summary = basins.summary();
        found.push((*point, basins, summary));
    }
    let name = |point: &Point| {
        format!(
            "{}) Ω/ω = {:.2}, gap/A0 = {:.2}",
            point.part, point.ratio, point.gap_over_amplitude
        )
    };
    let rig = points.first().map_or("", |p| p.rig);
    let shown: Vec<(String, &Basins)> = found.iter().map(|(p, b, _)| (name(p), b)).collect();
    let title = format!("Basins of attraction, {rig}: impact / no impact");
    let picture = parts(format!("Figure {figure}: {title}"), &shown);
    let stem = format!("figure-{}", figure.replace('.', "-"));
    let mut files = drawn(&stem, &picture)?;
    let mut said = Vec::new();
    for (point, basins, summary) in &found {
        files.push((
            format!("{stem}{}.csv", point.part),
            to_csv(&cells::rows(basins)),
        ));
        said.push(format!("{}: {}", name(point), says(summary)));
    }
    let both = found
        .iter()
        .filter(|(_, _, s)| (0.0..1.0).contains(&s.impact_share) && s.impact_share > 0.0);
    let both = both.count();
    let verdict = if both == found.len() {
        "Agrees: at both points it depends on the start."
    } else if both == 0 {
        "Differs: at neither point does it depend on the start."
    } else {
        "Agrees in part: at one of the two points it depends on the start."
    };
    Ok(vec![Page {
        figure,
        title,
        chapter: CHAPTER,
        found: format!(
            "{verdict} {}{}",
            said.join(" "),
            knife_edge(figure, effort, progress)?
        ),
        command: points.first().map_or(String::new(), |p| {
            format!(
                "host-sim basins --rig {rig} --cart prescribed --ratio {} --gap-ratio {} --out DIR",
                p.ratio, p.gap_over_amplitude
            )
        }),
        files,
    }])
}

/// How the share of figure 3.36a changes beside its frequency; nothing for the others.
fn knife_edge(figure: &str, effort: Effort, progress: &Progress) -> Result<String, UserError> {
    let Some(point) = POINTS
        .iter()
        .find(|p| p.figure == figure && figure == "3.36")
    else {
        return Ok(String::new());
    };
    let share = |ratio: f64| -> Result<f64, UserError> {
        let query = query(&Point { ratio, ..*point }, effort)?;
        let query = BasinsRequest {
            samples: 0,
            until: query.cycles,
            ..query
        };
        let basins = explore(Engine::Event, &query, progress)?;
        Ok(100.0 * basins.summary().impact_share)
    };
    Ok(format!(
        " Point a) stands on a knife edge: {:.1} % of the starts strike at Ω/ω = 1.99 and {:.1} % at 2.01.",
        share(1.99)?,
        share(2.01)?
    ))
}

/// What one point shows, in words.
fn says(s: &Summary) -> String {
    let percent = |share: f64| format!("{:.1} %", 100.0 * share);
    let mesh = s
        .impact_share_mesh_error
        .map_or(String::new(), |e| format!(" (mesh ± {:.1})", 100.0 * e));
    let mut text = format!(
        "{}{mesh} of {} by {} starts still strike in the last {} of {} cycles",
        percent(s.impact_share),
        s.grid[0],
        s.grid[1],
        s.recorded,
        s.cycles
    );
    if let Some(share) = s.impact_share_random {
        text += &format!(
            "; {} to {} of {} random starts (95 %)",
            percent(share.low),
            percent(share.high),
            share.of
        );
    }
    if let Some((first, last)) = s.over_cycles.first().zip(s.over_cycles.last()) {
        text += &format!(
            "; looked at after {} cycles it is {}, after {} it is {}",
            first.cycles,
            percent(first.impact.value()),
            last.cycles,
            percent(last.impact.value())
        );
    }
    let largest = s.attractors.iter().take(4);
    let ends: Vec<_> = largest
        .map(|a| format!("{} {}", a.name, percent(a.share)))
        .collect();
    text += &format!("; they end in {}", ends.join(", "));
    if s.attractors.len() > ends.len() {
        text += &format!(" and {} smaller ones", s.attractors.len() - ends.len());
    }
    if let Some(boundary) = s.attractor_entropy.and_then(|e| e.boundary) {
        text += &format!(
            "; boundary basin entropy {boundary:.3}, {} ln 2{}",
            if s.fractal_by_entropy {
                "above"
            } else {
                "below"
            },
            if s.fractal_by_entropy {
                ", so the boundary is fractal"
            } else {
                ""
            }
        );
    }
    text + "."
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_page_has_pictures_tables_and_says_what_it_found() {
        let quiet = Progress::new("", 1, true);
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
        assert!(
            page.found.contains("Ω/ω = 1.80, gap/A0 = 1.60: "),
            "{}",
            page.found
        );
        assert!(page.found.contains("of 10 by 10 starts"), "{}", page.found);
        assert_eq!(POINTS.len(), 2 * PARTS.len());
    }
}
