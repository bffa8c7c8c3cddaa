//! `host-sim trials`.

mod long;

use serde::Serialize;
use serde_json::json;

use super::arguments::output::OutputArgs;
use crate::pictures::trials::figure;
use crate::progress::ProgressLine;
use emulator::trials::long::LongTrial;
use emulator::trials::{Believed, Distribution, Trial, TrialOutcome, run_all};
use files::range::within;
use files::words::count;
use files::{UserError, rigfile};
use numerics::NamedRig;

/// Rig time of a trial, s: from 20 s, in which every trial should hold, to an hour.
const DURATION_S: (f64, f64) = (20.0, 3600.0);
/// Most trials of one command.
const MOST: u32 = 100_000;

/// Run the controller on many rigs that differ at random from its settings: time to Hold, and force
#[derive(Debug, clap::Args)]
#[command(
    after_help = "On two cores 200 rigs take a minute and a half, --long two minutes.\n\nExamples:\n  host-sim trials --count 20\n  host-sim trials --long"
)]
pub struct Args {
    /// Number of trials, on the rigs in turn [default: 200; with --long 40]
    #[arg(long, value_name = "N")]
    count: Option<u32>,

    /// Rig time of each trial, s; with --long, after the start [default: 60; with --long 600]
    #[arg(long, value_name = "S")]
    seconds: Option<f64>,

    /// Long trials: during each, the natural frequency drifts by 5 %, the delay of the hammer's or the cart's sensor or of
    /// both grows to 1 ms, and each sensor's gain drifts by 1 % per minute
    #[arg(long)]
    long: bool,

    /// Seed of the random numbers
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,

    /// Only this rig: a preset or a rig file [default: the four presets]
    #[arg(long, value_name = "NAME|FILE.toml")]
    rig: Option<String>,

    /// Print this trial as a scenario file for `host-sim emulate`, and run none
    #[arg(long, value_name = "NUMBER")]
    show: Option<u32>,

    #[command(flatten)]
    pub output: OutputArgs,
}

/// All trials of a rig, or of all.
#[derive(Serialize)]
struct Line {
    rig: String,
    #[serde(flatten)]
    distribution: Distribution,
}

pub fn run(args: &Args) -> Result<(), UserError> {
    let (usual, usual_s) = if args.long { (40, 600.0) } else { (200, 60.0) };
    let (trials, seconds) = (args.count.unwrap_or(usual), args.seconds.unwrap_or(usual_s));
    let (least, most) = DURATION_S;
    within("--seconds", seconds, least, most)?;
    within("--count", trials, 1, MOST)?;
    let rigs: Vec<NamedRig> = match &args.rig {
        Some(rig) => vec![rigfile::load(rig, &[])?],
        None => NamedRig::presets(),
    };
    let believed: Vec<Believed> = rigs.iter().map(Believed::new).collect();
    if let Some(number) = args.show {
        let text = if args.long {
            LongTrial::draw(args.seed, number, &believed).to_toml(seconds)
        } else {
            Trial::draw(args.seed, number, &believed).to_toml(seconds)
        };
        super::terminal::print(&text);
        return Ok(());
    }
    let output = &args.output.about(&rigs)?;
    let what = format!("trials of {seconds} s");
    let progress = ProgressLine::new(what, u64::from(trials), output.quiet);
    if args.long {
        return long::run(args.seed, trials, seconds, &believed, output, &progress);
    }
    let outcomes = run_all(args.seed, trials, &believed, seconds, &progress)?;
    progress.finish();
    let names: Vec<&str> = rigs.iter().map(|rig| &*rig.name).collect();
    let lines = lines(&names, &outcomes);
    let answer = json!({
        "seed": args.seed,
        "seconds_s": seconds,
        "distributions": lines,
        "trials": outcomes,
    });
    let picture = || output.picture(&figure(&names, &outcomes, seconds));
    output.answer(&answer, &outcomes, picture, || {
        text(outcomes.len(), seconds, args.seed, &lines)
    })
}

/// Each rig that was tried, then all of them.
fn lines(rigs: &[&str], outcomes: &[TrialOutcome]) -> Vec<Line> {
    let of = |rig: &str| {
        let these = outcomes.iter().filter(|o| o.rig == rig);
        Line {
            rig: rig.to_owned(),
            distribution: Distribution::of(&these.cloned().collect::<Vec<_>>()),
        }
    };
    let mut lines: Vec<Line> = rigs.iter().map(|rig| of(rig)).collect();
    if rigs.len() > 1 {
        lines.push(Line {
            rig: "all".into(),
            distribution: Distribution::of(outcomes),
        });
    }
    lines
}

fn text(trials: usize, seconds: f64, seed: u64, lines: &[Line]) -> String {
    let mut text = format!(
        "{} of {} s, seed {}: Hold, s after the start, and force from Hold on over the true optimum's\n\n\
         {:<9} {:>6} {:>5} {:>6} {:>5}  {:>7} {:>7} {:>7}  {:>7} {:>7} {:>7}  {:>8} {:>8}\n",
        count(trials, "trial"),
        seconds,
        seed,
        "rig",
        "trials",
        "held",
        "faults",
        "lost",
        "median",
        "95 %",
        "last",
        "median",
        "5 %",
        "worst",
        "A0: med.",
        "worst",
    );
    let number = |value: Option<f64>, digits: usize| {
        value.map_or("never".to_owned(), |value| format!("{value:.digits$}"))
    };
    for Line {
        rig,
        distribution: d,
    } in lines
    {
        text += &format!(
            "{rig:<9} {:>6} {:>5} {:>6} {:>5}  {:>7} {:>7} {:>7}  {:>7} {:>7} {:>7}  {:>8} {:>8}\n",
            d.trials,
            d.held,
            d.faults,
            d.lost,
            number(d.hold_median_s, 1),
            number(d.hold_95_s, 1),
            number(d.hold_last_s, 1),
            number(d.share_median, 4),
            number(d.share_5, 4),
            number(d.share_worst, 4),
            number(d.share_at_a0_median, 4),
            number(d.share_at_a0_worst, 4),
        );
    }
    text + "\nThe shares are of the optimum at the true amplitude, which differs from A0 if the cart's sensor has a wrong gain. The last\n\
            two columns are of the optimum at A0 itself: a controller cannot detect such a gain.\n"
}
