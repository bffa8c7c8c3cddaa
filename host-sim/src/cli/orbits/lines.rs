//! `orbits --curves`: the special points of the 1/1 at many gaps, joined to lines.

use super::{Args, OrbitsAxis, ratios};
use crate::cli::arguments::output::OutputArgs;
use crate::cli::arguments::range::parse_range;
use crate::cli::arguments::rig::at_gap;
use crate::pictures;
use crate::progress::ProgressLine;
use files::UserError;
use numerics::CartModel;
use numerics::NamedRig;
use numerics::continuation::table::{SpecialRow, line_rows};
use numerics::continuation::{Special, curves};
use plot::chart::Chart;

/// Finds the lines.
///
/// # Errors
/// If the request makes no sense, or the work is interrupted.
pub fn run(args: &Args, output: &OutputArgs, rig: &NamedRig) -> Result<(), UserError> {
    if args.along == OrbitsAxis::Gap {
        return Err(UserError::new(
            "--along gap does not go with --curves, which takes many gaps; use --gap FROM:TO:STEP",
        ));
    }
    let gaps = args.gap.as_deref().unwrap_or("0:3.56:0.04");
    let gaps_m = parse_range(gaps).map_err(|e| UserError::new(format!("--gap {gaps}: {e}")))?;
    let gaps_m: Vec<f64> = gaps_m.into_iter().map(|mm| mm * 1e-3).collect();
    for gap_m in [gaps_m.first(), gaps_m.last()].into_iter().flatten() {
        at_gap(&rig.params, gap_m * 1e3, "--gap")?;
    }
    let ratios = ratios(args, rig)?;
    let progress = ProgressLine::new("gaps", gaps_m.len() as u64, output.quiet);
    let starts = usize::from(args.starts);
    let lines = curves::lines(&rig.params, &gaps_m, ratios, starts, &progress)?;
    progress.finish();
    let rows = line_rows(&rig.params, &lines);
    let figure = || pictures::orbits::lines_figure(&rig.name, &rig.params, &lines);
    let picture = || output.picture(&figure());
    output.answer(&rows, &rows, picture, || curves_text(rig, &rows))
}

fn curves_text(rig: &NamedRig, rows: &[SpecialRow]) -> String {
    let mut text = format!(
        "{}, {}: special points of the 1/1\n\n{:<20} {:>6} {:>20} {:>24}\n",
        rig.name,
        CartModel::of(&rig.params).words(),
        "line of the 1/1",
        "points",
        "gaps, mm",
        "frequencies, Hz"
    );
    let mut from = 0;
    while from < rows.len() {
        let name = &rows[from].branch;
        let count = rows[from..]
            .iter()
            .take_while(|r| r.branch == *name)
            .count();
        let line = &rows[from..from + count];
        let (first, last) = (&line[0], &line[count - 1]);
        text += &format!(
            "{:<20} {:>6} {:>20} {:>24}\n",
            name,
            count,
            format!("{:.3} to {:.3}", first.gap_mm, last.gap_mm),
            format!("{:.5} to {:.5}", first.frequency_hz, last.frequency_hz)
        );
        from += count;
    }
    let mut chart = Chart::new("gap, mm", "drive frequency, Hz");
    for kind in Special::ALL {
        let points = rows.iter().filter(|r| r.special == kind);
        let points: Vec<_> = points.map(|r| (r.gap_mm, r.frequency_hz)).collect();
        if !points.is_empty() {
            chart = chart.points(kind.label(), points);
        }
    }
    text.push('\n');
    text += &chart.render();
    text
}
