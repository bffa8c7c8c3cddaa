//! `host-sim trials`.

use serde::Serialize;

use super::arguments::output::OutputArgs;
use crate::pictures::drawn;
use crate::pictures::trials::figure;
use crate::progress::Progress;
use emulator::trials::{Believed, Distribution, Outcome, RIGS, Row, Trial, run_all};
use files::words::count;
use files::{UserError, rigfile};
use numerics::NamedRig;

/// Rig time of a trial, s: from 20 s, in which every trial should hold, to an hour.
const DURATION_S: (f64, f64) = (20.0, 3600.0);
/// Most trials.
const MOST: u32 = 100_000;

#[derive(Debug, clap::Args)]
pub struct Args {
    /// How many trials, on the rigs in turn
    #[arg(long, value_name = "N", default_value_t = 200)]
    count: u32,

    /// Rig time of each, s
    #[arg(long, value_name = "S", default_value_t = 60.0)]
    seconds: f64,

    /// Seed of what is drawn
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,

    /// Only this rig: a preset or a rig file [default: the four presets]
    #[arg(long, value_name = "NAME|FILE.toml")]
    rig: Option<String>,

    /// Print one trial as a scenario file, for `host-sim emulate`, and run none
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

/// The answer as JSON.
#[derive(Serialize)]
struct Answer<'a> {
    seed: u64,
    seconds_s: f64,
    distributions: &'a [Line],
    trials: &'a [Row],
}

pub fn run(args: &Args) -> Result<(), UserError> {
    let output = &args.output;
    output.check()?;
    let (least, most) = DURATION_S;
    if !(least..=most).contains(&args.seconds) {
        let got = args.seconds;
        return Err(UserError::new(format!(
            "--seconds is {got}, must be from {least} to {most}"
        )));
    }
    if args.count == 0 || args.count > MOST {
        let got = args.count;
        return Err(UserError::new(format!(
            "--count is {got}, must be from 1 to {MOST}"
        )));
    }
    let rigs: Vec<NamedRig> = match &args.rig {
        Some(rig) => vec![rigfile::load(rig, &[])?],
        None => named()?,
    };
    let believed: Vec<Believed> = rigs.iter().map(Believed::new).collect();
    if let Some(number) = args.show {
        let trial = Trial::draw(args.seed, number, &believed);
        super::terminal::print(&trial.to_toml(args.seconds));
        return Ok(());
    }
    let output = &output.about(&rigs)?;
    let progress = Progress::new("trials", u64::from(args.count), output.quiet);
    let outcomes = run_all(args.seed, args.count, &believed, args.seconds, &progress)?;
    progress.finish();
    let names: Vec<&str> = rigs.iter().map(|rig| &*rig.name).collect();
    let lines = lines(&names, &outcomes);
    let rows: Vec<Row> = outcomes.iter().map(Row::from).collect();
    let answer = Answer {
        seed: args.seed,
        seconds_s: args.seconds,
        distributions: &lines,
        trials: &rows,
    };
    if let Some(dir) = &output.out {
        let mut contents = drawn(&output.name(""), &figure(&names, &outcomes, args.seconds))?;
        contents.extend(output.tables(&output.name(""), &answer, &rows)?);
        output.write(dir, contents)?;
    }
    output.emit(&answer, &rows, || text(args, &lines))
}

/// The presets, around which the trials are drawn.
fn named() -> Result<Vec<NamedRig>, UserError> {
    RIGS.iter().map(|rig| Ok(NamedRig::preset(rig)?)).collect()
}

/// Each rig that was tried, then all of them.
fn lines(rigs: &[&str], outcomes: &[Outcome]) -> Vec<Line> {
    let of = |rig: &str| {
        let these = outcomes.iter().filter(|o| o.trial.rig.name == rig);
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

fn text(args: &Args, lines: &[Line]) -> String {
    let mut text = format!(
        "{} of {} s, seed {}: Hold, s after the start, and force from Hold on over the true optimum's\n\n\
         {:<9} {:>6} {:>5} {:>6} {:>5}  {:>7} {:>7} {:>7}  {:>7} {:>7} {:>7}  {:>8} {:>8}\n",
        count(args.count as usize, "trial"),
        args.seconds,
        args.seed,
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
    text + "\nThe shares are of the optimum at the amplitude that the cart's sensor makes of A0; the last two columns, at A0\n\
            itself: a controller cannot know that the cart's gain is wrong.\n"
}
