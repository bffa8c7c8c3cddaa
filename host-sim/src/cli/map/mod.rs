//! `host-sim map`.

mod answer;
mod requests;
mod text;
mod written;

use std::path::PathBuf;

use answer::MapAnswer;
use written::{file_name, write};

use super::arguments::choice::choice;
use super::arguments::drive::{Drives, chapters};
use super::arguments::engine::EngineArgs;
use super::arguments::output::{Format, OutputArgs};
use super::arguments::rig::{CartArg, RigAtGaps};
use super::terminal::print;
use crate::progress::ProgressLine;
use files::UserError;
use files::made_from::into_json;
use files::words::count;
use numerics::NamedRig;
use numerics::map::{
    self, Map, MapRequest, MapSummary, agree, measured, measured::MeasuredRegime, similarity,
};
use numerics::sweep::Direction;

/// Compute the Peterka map: the hammer's regime over gap and frequency
#[derive(Clone, Debug, clap::Args)]
#[command(
    after_help = "On two cores the chapter's 209,916 cells take 3 to 8 s.\n\nExamples:\n  host-sim map --gap 0:3:0.5 --ratio 1:4:0.25\n  host-sim map --direction up --cycles 300 --transient 200 --out out"
)]
#[command(group(clap::ArgGroup::new("drive").args(["ratio", "frequency"])), mut_arg("frequency", chapters))]
pub struct Args {
    #[command(flatten)]
    drive: Drives,

    /// Drive cycles of each cell
    #[arg(long, value_name = "N", default_value_t = 300)]
    cycles: u32,

    /// Cycles at the end that are recorded [default: 100, of fewer than 200 cycles half]
    #[arg(long, value_name = "N")]
    recorded: Option<u32>,

    /// Cells that have not settled are computed again with up to N cycles
    #[arg(long, value_name = "N")]
    settle: Option<u32>,

    /// Start each cell from rest, or at each gap carry the state up or down the frequencies
    #[arg(long, alias = "from", value_parser = choice::<Direction>(), default_value = "rest")]
    direction: Direction,

    /// Cycles at the beginning that are not recorded, instead of --recorded
    #[arg(long, value_name = "N", conflicts_with = "recorded")]
    transient: Option<u32>,

    /// Compute every cell with the reference instead of the fast engine (hours, not seconds)
    #[arg(long)]
    reference: bool,

    /// Compute a second map, and show where it differs from the first
    #[arg(long, value_enum)]
    against: Option<requests::SecondMap>,

    /// Add another rig's map over the same Ω/ω and gap/A0, and compare them; may be given several times
    #[arg(long, value_name = "NAME|FILE.toml")]
    beside: Vec<String>,

    /// The three beams side by side: --rig beam-170 --beside beam-150 --beside beam-135
    #[arg(long, conflicts_with_all = ["rig", "beside"])]
    beams: bool,

    /// Measured points to draw over the map: CSV with the columns gap_mm, frequency_hz and regime
    #[arg(long, value_name = "FILE.csv")]
    measured: Option<PathBuf>,

    /// Compute N random cells again with the reference, and report how many agree
    #[arg(long, value_name = "N")]
    audit: Option<usize>,

    /// Seed of the audit's random cells
    #[arg(long, value_name = "N", default_value_t = 1, requires = "audit")]
    seed: u64,

    /// Threads [default: one for each processor]
    #[arg(long, value_name = "N")]
    threads: Option<usize>,

    #[command(flatten)]
    rig: RigAtGaps,

    #[command(flatten)]
    cart: CartArg,

    #[command(flatten)]
    engine: EngineArgs,

    #[command(flatten)]
    pub output: OutputArgs,
}

pub fn run(args: &Args) -> Result<(), UserError> {
    let requests = requests::requests(args)?;
    check(args, &requests)?;
    let stem = file_name(&args.output, &requests[0]);
    let args = &Args {
        output: args.output.named(stem, rigs(&requests))?,
        ..args.clone()
    };
    for rig in rigs(&requests) {
        args.output.doubt_without_uncertainty(rig);
    }
    let points = args
        .measured
        .as_deref()
        .map(|file| crate::measured::regimes(file, |line| args.output.note(line)))
        .transpose()?;
    let work = || make(args, &requests, points.as_deref());
    match args.threads {
        None => work(),
        Some(threads) => {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            let pool = pool.map_err(|e| UserError::new(format!("--threads {threads}: {e}")))?;
            pool.install(work)
        }
    }
}

/// The rigs of the maps, each once.
fn rigs(requests: &[MapRequest]) -> Vec<&NamedRig> {
    let mut rigs: Vec<&NamedRig> = Vec::new();
    for request in requests {
        if !rigs.iter().any(|rig| rig.name == request.rig.name) {
            rigs.push(&request.rig);
        }
    }
    rigs
}

/// Refuses options that do not go together, before any work is done.
fn check(args: &Args, requests: &[MapRequest]) -> Result<(), UserError> {
    let output = &args.output;
    for request in requests {
        request.check()?;
    }
    if args.audit.is_some() {
        agree::check_audit(&requests[0])?;
    }
    let cells = requests[0].grid.len();
    if let Some(audit) = args.audit
        && !(1..=cells).contains(&audit)
    {
        return Err(UserError::new(format!(
            "--audit is {audit}, must be from 1 to {cells}: the map has {}",
            count(cells, "cell")
        )));
    }
    if args.threads.is_some_and(|n| !(1..=1024).contains(&n)) {
        return Err(UserError::new("--threads must be from 1 to 1024"));
    }
    if output.format == Format::Csv && requests.len() > 1 && output.out.is_none() {
        return Err(UserError::new(
            "several maps do not fit into one table; add --out DIR for a table each, or use --format json",
        ));
    }
    Ok(())
}

fn make(
    args: &Args,
    requests: &[MapRequest],
    points: Option<&[MeasuredRegime]>,
) -> Result<(), UserError> {
    let output = &args.output;
    let progress = progress(args, requests);
    let maps = requests.iter().map(|request| map::run(request, &progress));
    let maps: Vec<Map> = maps.collect::<Result<_, _>>()?;
    let answer = answer(args, requests, &maps, points, &progress)?;
    progress.finish();
    for (map, summary) in maps.iter().zip(&answer.summaries) {
        if summary.failed > 0 {
            output.note(&format!(
                "note: {}: in {} of {} the hammer leaves the model's range (1 rad or 1 m) or needs a shorter tick; their rows say failed",
                map.rig.name,
                summary.failed,
                count(summary.cells, "cell")
            ));
        }
    }
    if let Some(dir) = &output.out {
        write(output, dir, &answer, points)?;
    }
    match output.format {
        Format::Text => print(&text::text(&answer, &maps)),
        Format::Json => print(&into_json(answer.to_json()?, output.made_from())),
        Format::Csv if maps.len() > 1 => {}
        Format::Csv => {
            let rows: Vec<_> = maps[0].rows().collect();
            output.emit(&(), &rows, String::new)?;
        }
    }
    Ok(())
}

fn progress(args: &Args, requests: &[MapRequest]) -> ProgressLine {
    let total: usize = requests.iter().map(|request| request.grid.len()).sum();
    let total = total + args.audit.unwrap_or(0);
    ProgressLine::new("cells", total as u64, args.output.quiet)
}

fn answer<'a>(
    args: &Args,
    requests: &'a [MapRequest],
    maps: &'a [Map],
    points: Option<&[MeasuredRegime]>,
    progress: &ProgressLine,
) -> Result<MapAnswer<'a>, UserError> {
    let first = &maps[0];
    let audit = args.audit.map(|count| {
        let drawn = (count, args.seed);
        agree::audit(&requests[0], first, drawn, progress)
    });
    // The map to compare with comes last.
    let (beside, against) = match args.against {
        Some(_) => (&maps[..maps.len() - 1], maps.last()),
        None => (maps, None),
    };
    let mut alike = Vec::new();
    for (i, a) in beside.iter().enumerate() {
        alike.extend(beside[i + 1..].iter().map(|b| similarity(a, b)));
    }
    Ok(MapAnswer {
        requests,
        maps,
        summaries: maps.iter().map(MapSummary::of).collect(),
        audit: audit.transpose()?,
        against: against.map(|other| map::Agreement::of(first.cells.iter().zip(&other.cells))),
        alikeness: alike,
        measured: points.map(|points| measured::hits(points, first)),
    })
}
