//! `pick --over`: how the operating point moves over a parameter of the rig.

use super::{Args, load};
use crate::cli::arguments::output::{OutputArgs, no_json};
use crate::cli::arguments::over::OverOption;
use crate::cli::interrupt;
use crate::kept::Kept;
use crate::pictures;
use crate::progress::ProgressLine;
use crate::words::over::{OverRow, of_rig, summary};
use crate::words::{number, some_of};
use files::words::digits::{decimals, significant};
use files::{UserError, rigfile};
use numerics::PickLimits;
use numerics::Uncertainty;
use numerics::pick::{Springs, pick_on, steps};
use numerics::{Error, NamedRig};
use plot::chart::Chart;

pub fn run(
    args: &Args,
    asked: &OverOption,
    springs: Springs,
    limits: PickLimits,
) -> Result<(), UserError> {
    asked.check(&args.rig.at_one())?;
    let name = args.rig.name.name();
    let (base, own_gap_m) = load(args, name, &[])?;
    let output = &args.output;
    if own_gap_m.is_some() {
        output.note("note: picking at a gap of 0.0 mm (set --gap to choose another)");
    }
    output.doubt(&base);
    let uncertainty = args.uncertainty.of(&base)?;
    let output = &output
        .about([&base])?
        .with_uncertainty(uncertainty.map(super::stated));
    let rigs = asked.values.list.iter();
    let rigs = rigs.map(|value| load(args, name, &asked.setting(*value)).map(|(rig, _)| rig));
    let rigs: Vec<NamedRig> = rigs
        .collect::<Result<_, UserError>>()
        .map_err(|error| asked.at(error))?;
    for rig in &rigs {
        rig.params.check().map_err(|error| asked.at(error.into()))?;
    }
    let rows = rows(args, asked, output, (&base, &rigs), (springs, limits))?;
    let picture = || {
        let over = pictures::over::OverPicture {
            rows: &rows,
            own: rigfile::number(&base.params, &asked.key),
            log: asked.values.log,
        };
        output.picture(&over.figure())
    };
    output.answer(&rows, &rows, picture, || text(asked, &rows, uncertainty))
}

/// A row for each rig; those that an earlier run of the same request has done are taken over.
fn rows(
    args: &Args,
    asked: &OverOption,
    output: &OutputArgs,
    (base, rigs): (&NamedRig, &[NamedRig]),
    (springs, limits): (Springs, PickLimits),
) -> Result<Vec<OverRow>, UserError> {
    let request = serde_json::to_string(output.made_from()).map_err(no_json)?;
    let dir = output.out.as_ref();
    let path = dir.map(|dir| dir.join(output.name(".unfinished")));
    let mut kept = Kept::open(path.clone(), &request)?;
    if let Some(path) = path.filter(|_| !output.quiet) {
        interrupt::say_then(format!(
            "interrupted; the finished values are kept in {}: the same command goes on from there",
            path.display()
        ));
    }
    let widths = rigs.iter().map(|rig| args.uncertainty.of(rig));
    let widths: Vec<_> = widths.collect::<Result<_, _>>()?;
    let work = widths.iter().map(|width| steps(*width));
    let progress = ProgressLine::new("rigs tried", work.clone().sum(), output.quiet);
    progress.inc(work.take(kept.rows().len()).sum());
    let left = rigs.iter().zip(&asked.values.list).zip(&widths);
    for ((rig, value), width) in left.skip(kept.rows().len()) {
        let found = match pick_on(rig, springs, *width, limits, &progress) {
            Err(Error::Interrupted) => return Err(Error::Interrupted.into()),
            found => found,
        };
        let answer = found.as_ref().map(|pick| &pick.answer);
        let row = OverRow::new((&asked.key, *value), (&base.name, rig), answer);
        kept.push(row)?;
    }
    progress.finish();
    Ok(kept.finish())
}

fn text(asked: &OverOption, rows: &[OverRow], uncertainty: Option<Uncertainty>) -> String {
    let mut text = format!(
        "{}: {}\n\n{:>26}  run at, Hz  ratio  force/weight (uncertainty)  safe band, Hz     multiplier  jumps  from rest\n",
        of_rig(rows),
        summary(rows),
        asked.key
    );
    let (shown, left_out) = some_of(rows);
    for row in shown {
        text += &line(row, uncertainty);
    }
    text += &left_out;
    let curve = |value: fn(&OverRow) -> Option<f64>| {
        let points = rows
            .iter()
            .filter_map(|r| Some((asked.along(r.value), value(r)?)));
        points.collect::<Vec<_>>()
    };
    let chart = |label: &str, value| {
        Chart::new(asked.axis(), label)
            .size(72, 10)
            .series(label, curve(value))
            .render()
    };
    text.push('\n');
    text += &chart("run at, Hz", |r| r.operating_frequency_hz);
    text.push('\n');
    text + &chart("force over weight", |r| r.force_ratio)
}

fn line(row: &OverRow, uncertainty: Option<Uncertainty>) -> String {
    let value = significant(row.value, 6);
    if let Some(why) = &row.no_pick {
        return format!("{value:>26}  no pick: {why}\n");
    }
    // Frequency and force as far as the uncertainty leaves them open.
    let half = uncertainty.zip(row.operating_frequency_hz);
    let half = half.map_or(0.0, |(u, hz)| hz * u.natural_frequency_percent / 100.0);
    let hz = decimals(half, 4);
    let open = row.force_ratio_largest.zip(row.force_ratio_worst);
    let force = decimals(
        open.map_or(0.0, |(largest, worst)| 0.5 * (largest - worst)),
        2,
    );
    let range = match uncertainty {
        Some(_) => format!(
            "({} to {})",
            number(row.force_ratio_worst, force),
            number(row.force_ratio_largest, force)
        ),
        None => String::new(),
    };
    let decided = row.decided_by.as_ref();
    let decided = decided.map_or(String::new(), |by| format!("  decided by {by}"));
    format!(
        "{value:>26}  {:>10}  {:>5}  {:>12} {range:<13}  {:>6} to {:<7} {:>11}  {:<5}  {}{decided}\n",
        number(row.operating_frequency_hz, hz),
        number(row.frequency_ratio, 2),
        number(row.force_ratio, force),
        number(row.safe_band_low_hz, hz.min(3)),
        number(row.safe_band_high_hz, hz.min(3)),
        number(row.multiplier, 3),
        if row.jumps == Some(true) { "yes" } else { "no" },
        row.from_rest.as_deref().unwrap_or("-")
    )
}
