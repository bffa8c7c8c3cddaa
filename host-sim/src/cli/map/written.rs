//! The files of a map: its pictures and its tables.

use std::path::Path;

use rayon::prelude::*;

use super::answer::MapAnswer;
use super::requests;
use crate::cli::arguments::output::{Contents, OutputArgs};
use crate::pictures;
use crate::pictures::drawn;
use crate::words;
use files::UserError;
use files::table::to_csv;
use numerics::map::MapRequest;
use numerics::map::measured::{self, MeasuredRegime};
use plot::Figure;

/// Writes pictures and tables of `answer` to `dir`.
pub fn write(
    output: &OutputArgs,
    dir: &Path,
    answer: &MapAnswer,
    points: Option<&[MeasuredRegime]>,
) -> Result<(), UserError> {
    let (drawn, tabled) = rayon::join(|| draw(output, answer, points), || tabled(output, answer));
    let mut contents = drawn?;
    contents.extend(tabled?);
    output.write(dir, contents)
}

fn draw(
    output: &OutputArgs,
    answer: &MapAnswer,
    points: Option<&[MeasuredRegime]>,
) -> Result<Contents, UserError> {
    let figures = figures(output, answer, points);
    let drawn = figures.par_iter().map(|(name, figure)| drawn(name, figure));
    let drawn: Vec<_> = drawn.collect::<Result<_, _>>()?;
    Ok(drawn.into_iter().flatten().collect())
}

/// How the names of a map's files begin: its own name, and the options that this does not tell.
pub fn file_name(output: &OutputArgs, request: &MapRequest) -> String {
    let options = output.options(requests::IN_ITS_NAME);
    files::made_from::file_name([requests::name(request).as_str(), options.as_str()])
}

/// A table for each map, and one JSON.
fn tabled(output: &OutputArgs, answer: &MapAnswer) -> Result<Contents, UserError> {
    let mut files = Vec::new();
    for (request, map) in answer.requests.iter().zip(answer.maps) {
        let name = file_name(output, request);
        let rows: Vec<_> = map.rows().collect();
        files.push((format!("{name}.csv"), to_csv(&rows)));
    }
    let first = file_name(output, &answer.requests[0]);
    files.push((format!("{first}.json"), answer.to_json()?.into_bytes()));
    Ok(files)
}

/// The pictures and their names: of each map the regimes and the force of 1/1; how maps compare.
fn figures(
    output: &OutputArgs,
    answer: &MapAnswer,
    points: Option<&[MeasuredRegime]>,
) -> Vec<(String, Figure)> {
    let first = file_name(output, &answer.requests[0]);
    let mut figures = Vec::new();
    for (i, (request, map)) in answer.requests.iter().zip(answer.maps).enumerate() {
        let name = file_name(output, request);
        let regimes = match points {
            Some(points) if i == 0 => {
                let seen = measured::on_map(points, map).into_iter();
                let seen = seen.map(|(p, _)| (p.gap_mm, p.frequency_hz, p.regime));
                pictures::map::with_points(map, &seen.collect::<Vec<_>>())
            }
            _ => pictures::map::regimes(map),
        };
        figures.push((format!("{name}-force"), pictures::map::by_force(map)));
        figures.push((name, regimes));
    }
    if let (Some(_), [map, .., other]) = (&answer.against, answer.maps) {
        let request = answer.requests.last();
        let what = request.map_or(String::new(), |r| {
            let from = r.from.name();
            format!("engine {}, from {from}", r.runner.name())
        });
        let figure = pictures::map::differences(map, other, &what);
        figures.push((format!("{first}-against"), figure));
    }
    if !answer.alikeness.is_empty() {
        let beside = answer.maps.len() - usize::from(answer.against.is_some());
        let maps: Vec<_> = answer.maps[..beside].iter().collect();
        let lines: Vec<_> = answer
            .alikeness
            .iter()
            .map(words::map::similarity)
            .collect();
        let figure = pictures::map::side_by_side(&maps, &lines.join(". "));
        figures.push((format!("{first}-beside"), figure));
    }
    figures
}
