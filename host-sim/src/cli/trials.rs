//! `host-sim trials`.

mod long;

use super::arguments::output::OutputArgs;
use crate::pictures::trials::figure;
use crate::progress::ProgressLine;
use emulator::trials::{RigTrials, Trials, TrialsRequest};
use files::words::count;
use files::{UserError, rigfile};
use numerics::NamedRig;

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

pub fn run(args: &Args) -> Result<(), UserError> {
    let request = TrialsRequest::new(args.long, args.count, args.seconds, args.seed)?;
    let rigs: Vec<NamedRig> = match &args.rig {
        Some(rig) => vec![rigfile::load(rig, &[])?],
        None => NamedRig::presets(),
    };
    if let Some(number) = args.show {
        super::terminal::print(&request.scenario(number, &rigs));
        return Ok(());
    }
    let output = &args.output.about(&rigs)?;
    let what = format!("trials of {} s", request.seconds);
    let progress = ProgressLine::new(what, u64::from(request.count), output.quiet);
    if args.long {
        let answer = request.run_long(&rigs, &progress)?;
        progress.finish();
        let no_picture = || Ok(Vec::new());
        return output.answer(&answer, &answer.trials, no_picture, || long::text(&answer));
    }
    let answer = request.run(&rigs, &progress)?;
    progress.finish();
    let names: Vec<&str> = rigs.iter().map(|rig| &*rig.name).collect();
    let picture = || output.picture(&figure(&names, &answer.trials, request.seconds));
    output.answer(&answer, &answer.trials, picture, || text(&answer))
}

fn text(answer: &Trials) -> String {
    let mut text = format!(
        "{} of {} s, seed {}: Hold, s after the start, and force from Hold on over the true optimum's\n\n\
         {:<9} {:>6} {:>5} {:>6} {:>5}  {:>7} {:>7} {:>7}  {:>7} {:>7} {:>7}  {:>8} {:>8}\n",
        count(answer.trials.len(), "trial"),
        answer.seconds_s,
        answer.seed,
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
    for RigTrials {
        rig,
        distribution: d,
    } in &answer.distributions
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
