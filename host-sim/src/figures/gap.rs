//! A page beyond the chapter's figures: numbers for its recommendation of a gap of 0.0 mm.

use super::{Effort, Page, Part};
use crate::pictures::drawn;
use crate::pictures::gaps::figure;
use crate::progress::Progress;
use crate::words::gaps::GapTable;
use files::UserError;
use files::rigfile;
use files::table::to_csv;
use numerics::CartModel;
use numerics::Limits;
use numerics::Uncertainty;
use numerics::pick::Springs;
use numerics::pick::gaps::advise;

/// The one part.
pub const PART: Part = Part::new("gap advice", &["gap advice"], 325.0, pages);

/// The pick over gaps on the wires.
///
/// # Errors
/// As those of [`advise`].
pub fn pages(effort: Effort, progress: &Progress) -> Result<Vec<Page>, UserError> {
    let rig = rigfile::load("wires", &[])?;
    let (gaps_mm, uncertainty, starts): (Vec<f64>, _, u32) = match effort {
        Effort::Full => (
            (0..=7).map(|i| 0.5 * f64::from(i)).collect(),
            Some(Uncertainty::default()),
            400,
        ),
        Effort::Coarse => (vec![0.0, 2.4], None, 20),
    };
    let limits = Limits::default();
    let advice = advise(
        &rig,
        &gaps_mm,
        (uncertainty, Springs::default()),
        limits,
        (starts, 1),
        progress,
    )?;
    let advice = GapTable::from(&advice);
    let picture = figure(&advice, CartModel::Prescribed.words());
    let mut files = drawn("figure-gap-advice", &picture)?;
    files.push(("figure-gap-advice.csv".to_owned(), to_csv(&advice.gaps)));
    Ok(vec![Page {
        figure: "gap advice",
        title: "Why 0.0 mm: the pick over gaps, wires".to_owned(),
        chapter: "3.5: \"it is recommended to operate with 0.0 mm gap\": forces are \"in the same range\" as at higher gaps, where nonlinear jumps occur, and near the maximum \"for a wider frequency range\".",
        found: found(&advice),
        command: "host-sim pick --gaps 0:3.5:0.5 --out DIR".to_owned(),
        files,
    }])
}

fn found(advice: &GapTable) -> String {
    let verdict = match advice.advised_gap_mm {
        Some(0.0) => "Agrees.",
        Some(_) => "Differs.",
        None => "No answer.",
    };
    format!("{verdict} {}", advice.why)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_page_agrees_with_the_chapter_from_numbers() {
        let quiet = Progress::new("", 1, true);
        let all = pages(Effort::Coarse, &quiet).unwrap();
        assert!(
            all[0].found.starts_with("Agrees. Run at a gap of 0.0 mm"),
            "{}",
            all[0].found
        );
        assert_eq!(all[0].files.len(), 3);
    }
}
