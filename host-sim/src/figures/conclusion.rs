//! The chapter's conclusion: why a gap of 0.0 mm in the field. `pick` over gaps for every rig, at the gaps that the chapter measures.

use super::{Effort, Page, stem};
use crate::pictures::drawn;
use crate::pictures::gaps::figure;
use crate::progress::ProgressLine;
use crate::words::gaps::{GapRow, GapTable};
use files::UserError;
use files::rigfile;
use files::table::to_csv;
use numerics::pick::Springs;
use numerics::pick::gaps::advise;
use numerics::{CartModel, PickLimits, Uncertainty};

/// Every rig, and the gaps the chapter measures it at, mm.
const RIGS: [(&str, [f64; 3]); 4] = [
    ("wires", [0.0, 1.0, 2.4]),
    ("beam-170", [0.0, 1.0, 3.0]),
    ("beam-150", [0.0, 1.0, 3.0]),
    ("beam-135", [0.0, 1.0, 3.0]),
];

/// The page "conclusion".
///
/// # Errors
/// As those of [`advise`].
pub fn pages(effort: Effort, progress: &ProgressLine) -> Result<Vec<Page>, UserError> {
    let (samples, starts, rigs) = effort.of((64, 400, &RIGS[..]), (0, 20, &RIGS[..1]));
    let uncertainty = (samples > 0).then(|| Uncertainty {
        samples,
        ..Uncertainty::default()
    });
    let (mut tables, mut files) = (Vec::new(), Vec::new());
    for (name, gaps_mm) in rigs {
        let rig = rigfile::load(name, &[])?;
        let on = (uncertainty, Springs::default());
        let advice = advise(
            &rig,
            gaps_mm,
            on,
            PickLimits::default(),
            (starts, 1),
            progress,
        )?;
        let table = GapTable::from(&advice);
        let picture = figure(&table, CartModel::Prescribed.words());
        files.extend(drawn(&stem(&format!("conclusion-{name}")), &picture)?);
        tables.push(table);
    }
    let rows: Vec<&GapRow> = tables.iter().flat_map(|table| &table.gaps).collect();
    files.push((format!("{}.csv", stem("conclusion")), to_csv(&rows)));
    Ok(vec![Page {
        figure: "conclusion",
        title: "Why 0.0 mm: the pick at the chapter's gaps".to_owned(),
        note: note(&tables),
        command: "host-sim pick --gap 0:3.5:0.5 --cart prescribed".to_owned(),
        files,
    }])
}

/// The advice for each rig.
fn note(tables: &[GapTable]) -> String {
    let advice = tables
        .iter()
        .filter_map(|table| Some(format!("{}: {}", table.gaps.first()?.rig, table.why)));
    advice.collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_page_gives_the_advice_for_each_rig() {
        let quiet = ProgressLine::new("", 1, true);
        let [page] = &pages(Effort::Coarse, &quiet).unwrap()[..] else {
            panic!("one page");
        };
        assert!(
            page.note.starts_with("wires: Run at a gap of 0.0 mm"),
            "{}",
            page.note
        );
        assert_eq!(page.files.len(), 3);
    }
}
