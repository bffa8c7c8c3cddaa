//! `host-sim pick --gap FROM:TO:STEP`.

use crate::cli::arguments::output::OutputArgs;
use crate::cli::arguments::rig::at_gap;
use crate::pictures::gaps::figure;
use crate::progress::ProgressLine;
use crate::words::gaps::{GapRow, GapTable};
use crate::words::number;
use files::UserError;
use files::range::at_most;
use files::words::digits::decimals;
use numerics::CartModel;
use numerics::NamedRig;
use numerics::PickLimits;
use numerics::Uncertainty;
use numerics::pick::Springs;
use numerics::pick::gaps::{advise, gap_steps};
use numerics::row::tidy;
use plot::chart::Chart;

/// Gaps tried at most.
const MOST_GAPS: usize = 1000;
/// Random starts per gap at most.
const MOST_STARTS: u32 = 1_000_000;

/// The gaps, mm, and what they need besides.
pub struct Gaps {
    pub mm: Vec<f64>,
    pub springs: Springs,
    pub starts: u32,
    pub seed: u64,
}

pub fn run(
    rig: &NamedRig,
    output: &OutputArgs,
    gaps: &Gaps,
    uncertainty: Option<Uncertainty>,
    limits: PickLimits,
) -> Result<(), UserError> {
    let list = &gaps.mm;
    if list.len() > MOST_GAPS {
        return Err(UserError::new(format!(
            "--gap: that is {} gaps, more than {MOST_GAPS}; use a larger STEP",
            list.len()
        )));
    }
    at_most("--starts", gaps.starts, MOST_STARTS)?;
    let total = gap_steps(list.len(), uncertainty, gaps.starts);
    let progress = ProgressLine::new("rigs and starts tried", total, output.quiet);
    let starts = (gaps.starts, gaps.seed);
    for gap_mm in list {
        at_gap(&rig.params, tidy(*gap_mm), "--gap")?;
    }
    let advice = advise(
        rig,
        list,
        (uncertainty, gaps.springs),
        limits,
        starts,
        &progress,
    )?;
    let advice = GapTable::from(&advice);
    let cart = CartModel::of(&rig.params).words();
    progress.finish();
    let picture = || output.picture(&figure(&advice, cart));
    output.answer(&advice, &advice.gaps, picture, || {
        format!("{}, {cart}: {}", rig.name, describe(&advice, uncertainty))
    })
}

fn describe(advice: &GapTable, uncertainty: Option<Uncertainty>) -> String {
    let mut text = format!("{}\n\n", advice.why);
    text += "  gap, mm  run at, Hz  ratio  force/weight (largest)  safe band, Hz        band, %  multiplier  jumps, Hz        from rest  basin, % (95 %)\n";
    for row in &advice.gaps {
        text += &line(row, uncertainty);
    }
    let basin = advice.gaps.iter();
    let basin = basin.filter_map(|r| Some((r.gap_mm, 100.0 * r.basin_share?)));
    text += &format!(
        "\nbasin: share of {} starts from {:?} mm to the gap, at {} to {} m/s, that end on the orbit picked\n\n",
        advice.starts,
        advice.from_displacement_mm,
        advice.velocity_m_per_s[0],
        advice.velocity_m_per_s[1]
    );
    if advice.starts == 0 {
        return text;
    }
    text + &Chart::new("gap, mm", "basin of the orbit picked, %")
        .size(72, 10)
        .series("basin", basin.collect())
        .render()
}

fn line(row: &GapRow, uncertainty: Option<Uncertainty>) -> String {
    if let Some(why) = &row.no_pick {
        return format!("  {:>7.3}  no pick: {why}\n", row.gap_mm);
    }
    // The natural frequency leaves the best frequency open in proportion.
    let half = uncertainty.zip(row.operating_frequency_hz);
    let half = half.map_or(0.0, |(u, hz)| hz * u.natural_frequency_percent / 100.0);
    let hz = decimals(half, 4);
    let few = if uncertainty.is_some() { 2 } else { 3 };
    let percent = |x: Option<f64>| number(x.map(|x| 100.0 * x), 1);
    let jumps = match (row.jump_low_hz, row.jump_high_hz) {
        (Some(low), Some(high)) if high - low < 5e-4 => format!("{high:.3}"),
        (Some(low), Some(high)) => format!("{low:.3} to {high:.3}"),
        _ => "none".to_owned(),
    };
    format!(
        "  {:>7.3}  {:>10} {:>6}  {:>12} {:>9}  {:>8} to {:<8} {:>8} {:>11}  {:<16} {:<9}  {} ({} to {})\n",
        row.gap_mm,
        number(row.operating_frequency_hz, hz),
        number(row.frequency_ratio, few),
        number(row.force_ratio, 2),
        format!("({})", number(row.largest_force_ratio, 2)),
        number(row.safe_band_low_hz, hz.min(3)),
        number(row.safe_band_high_hz, hz.min(3)),
        number(row.safe_band_percent, 1),
        number(row.multiplier, 3),
        jumps,
        row.from_rest.as_deref().unwrap_or("-"),
        percent(row.basin_share),
        percent(row.basin_share_low),
        percent(row.basin_share_high)
    )
}
