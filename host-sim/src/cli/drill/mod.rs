//! `host-sim drill`.

mod published;
mod text;

use serde::Serialize;

use super::arguments::drive::Drives;
use super::arguments::ground::GroundArgs;
use super::arguments::output::OutputArgs;
use super::arguments::rig::{CartArg, RigAtGaps};
use crate::pictures::drawn;
use crate::pictures::drill::{curves, map};
use crate::progress::ProgressLine;
use files::UserError;
use files::ground::{BitWords, FEEDS, feed, feed_name};
use numerics::CartModel;
use numerics::NamedRig;
use numerics::drill::{
    Among, DrillAnswer, DrillPlan, DrillRow, DrillRuns, DrillSetting, Feed, GroundUncertainty, grid,
};
use numerics::sweep::spread;

/// Ω/ω without `--ratio` and `--frequency`.
const USUAL_RATIOS: (f64, f64, usize) = (1.2, 4.0, 141);

/// Compute the rate of penetration on ground that gives way over frequency and gap, its maximum, and the feed
#[derive(Debug, clap::Args)]
#[command(
    after_help = "On two cores each gap takes 3 to 8 s.\n\nExamples:\n  host-sim drill --threshold-n 25\n  host-sim drill --threshold-n 25 --bit-mass-kg 0.1\n  host-sim drill --threshold-n 50 --gap 0:2:0.25 --format csv > drill.csv\n  host-sim drill --published"
)]
#[command(group(clap::ArgGroup::new("drive").args(["ratio", "frequency"])), mut_arg("ratio", |ratio| ratio.help(
    "Drive frequencies over the natural frequency, Ω/ω: FROM:TO:STEP, or one value [default: 1.2:4:0.02]"
)))]
pub struct Args {
    #[command(flatten)]
    drive: Drives,

    #[command(flatten)]
    ground: GroundArgs,

    /// Feed that keeps the gap: cart (each period the cart moves forward by the progress), ground (the ground is moved
    /// back), steady (the mean speed of the last period); or a speed in mm/s, which then determines the gap
    #[arg(long, value_name = "HOW|MM_PER_S", value_parser = parse_feed, default_value = "cart", allow_hyphen_values = true)]
    feed: Feed,

    /// Most drive cycles for a run to settle (a run ends sooner once it repeats)
    #[arg(long, value_name = "N", default_value_t = 300)]
    settle: u32,

    /// Compute, instead of a rig, the published drifting oscillator: a bifurcation diagram over its static force
    #[arg(long, conflicts_with_all = ["threshold_n", "bit_mass_kg", "rig", "gaps", "ratio", "frequency", "cart"])]
    published: bool,

    #[command(flatten)]
    oscillator: published::PublishedOscillator,

    #[command(flatten)]
    rig: RigAtGaps,

    #[command(flatten)]
    cart: CartArg,

    #[command(flatten)]
    pub output: OutputArgs,
}

/// The answer as JSON.
#[derive(Debug, Serialize)]
pub struct DrillReport {
    rig: String,
    cart: CartModel,
    feed: String,
    threshold_n: f64,
    ground_stiffness_n_per_m: f64,
    ground_damping_n_s_per_m: f64,
    bit: Option<BitWords>,
    uncertainty: GroundUncertainty,
    /// The best of each gap with one blow in each drive period (with any motion, where there is no such).
    gaps: Vec<DrillRow>,
    /// More about the best of them.
    advice: DrillAnswer,
    /// The best of each gap whatever the motion.
    gaps_any_regime: Vec<DrillRow>,
    /// The best of all gaps whatever the motion: `advice.best` where nothing is faster.
    fastest_of_all: DrillRow,
    rows: Vec<DrillRow>,
}

pub fn run(args: &Args) -> Result<(), UserError> {
    if args.published {
        return published::run(&args.oscillator, args.settle, &args.output);
    }
    let rig = args.cart.apply(args.rig.name.load()?)?;
    let output = &args.output.about([&rig])?;
    output.doubt_without_uncertainty(&rig);
    let answer = answer(args, &rig, output)?;
    let pictures = || {
        let curves = curves(&answer.rows, &answer.advice, &answer.fastest_of_all);
        let mut files = output.picture(&curves)?;
        if answer.gaps.len() > 1 {
            files.extend(drawn(&output.name("-map"), &map(&answer.rows))?);
        }
        Ok(files)
    };
    output.answer(&answer, &answer.rows, pictures, || text::text(&answer))
}

fn answer(args: &Args, rig: &NamedRig, output: &OutputArgs) -> Result<DrillReport, UserError> {
    let asked = args.ground.asked();
    let ground = asked.ground(rig)?;
    let setting = DrillSetting {
        ground,
        bit: asked.bit(rig, &ground)?,
        feed: args.feed,
    };
    let uncertainty = asked.uncertainty()?;
    let natural_hz = rig.params.natural_frequency_hz();
    let (from, to, count) = USUAL_RATIOS;
    let usual = || spread(from * natural_hz, to * natural_hz, count);
    let frequencies_hz = args.drive.hz(natural_hz)?.unwrap_or_else(usual);
    let own = || vec![numerics::row::tidy(rig.params.gap_m * 1e3)];
    let mut gaps_mm = args.rig.gaps_mm()?.unwrap_or_else(own);
    gaps_mm.sort_by(f64::total_cmp);
    gaps_mm.dedup();
    let plan = DrillPlan {
        settle: args.settle,
        ..DrillPlan::default()
    };
    let runs = (gaps_mm.len() * frequencies_hz.len()) as u64;
    let progress = ProgressLine::new("runs", runs, output.quiet);
    let rows = grid(rig, &setting, &gaps_mm, &frequencies_hz, plan, &progress)?;
    let mut best: Option<(NamedRig, &[DrillRow], DrillRow)> = None;
    let (mut gaps, mut gaps_any_regime) = (Vec::new(), Vec::new());
    for (gap_mm, rows) in gaps_mm.iter().zip(rows.chunks(frequencies_hz.len())) {
        let mut there = rig.clone();
        there.params = rig.params.with_gap_mm(*gap_mm)?;
        // Where nothing gives way, any row says so.
        let any = Among::All.best(rows).unwrap_or(0);
        let runs = DrillRuns {
            rig: &there,
            setting,
            plan,
        };
        let top = runs.refined(rows, Among::OneOne);
        let top = top.unwrap_or_else(|_| rows[any].clone());
        // The refined 1/1 may drill faster than every row between which it lies.
        let rate = |row: &DrillRow| row.rate_of_penetration_um_per_s;
        gaps_any_regime.push(match rate(&top) > rate(&rows[any]) {
            true => top.clone(),
            false => rows[any].clone(),
        });
        let rank = |row: &DrillRow| (row.regime.is(1, 1), row.rate_of_penetration_um_per_s);
        if best.as_ref().is_none_or(|(.., b)| rank(&top) > rank(b)) {
            best = Some((there, rows, top.clone()));
        }
        gaps.push(top);
    }
    let Some((rig, of_gap, _)) = &best else {
        return Err(UserError::new("there is no gap; give one with --gap"));
    };
    let advice = DrillRuns { rig, setting, plan }.advise(of_gap, Some(uncertainty), &progress)?;
    progress.finish();
    let rate = |row: &DrillRow| row.rate_of_penetration_um_per_s;
    // A row of the grid beats the best 1/1, which is refined between rows, only by more than the grid is coarse.
    let fastest_of_all = gaps_any_regime
        .iter()
        .filter(|row| rate(row) > 1.001 * rate(&advice.best))
        .max_by(|a, b| rate(a).total_cmp(&rate(b)))
        .unwrap_or(&advice.best)
        .clone();
    Ok(DrillReport {
        rig: rig.name.clone(),
        cart: advice.cart,
        feed: feed_name(args.feed),
        threshold_n: setting.ground.threshold,
        ground_stiffness_n_per_m: setting.ground.stiffness,
        ground_damping_n_s_per_m: setting.ground.damping,
        bit: setting.bit.map(BitWords::from),
        uncertainty,
        gaps,
        advice,
        gaps_any_regime,
        fastest_of_all,
        rows,
    })
}

fn parse_feed(text: &str) -> Result<Feed, String> {
    feed(text).ok_or_else(|| format!("write {FEEDS}"))
}
