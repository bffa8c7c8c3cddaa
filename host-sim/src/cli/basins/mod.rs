//! `host-sim basins`.

mod text;

use serde::Serialize;

use super::arguments::cycles::usual_recorded;
use super::arguments::drive::OneFrequency;
use super::arguments::engine::EngineArgs;
use super::arguments::output::{Contents, OutputArgs};
use super::arguments::range::rising;
use super::arguments::rig::{CartArg, RigArgs, at_gap};
use crate::pictures::basins::figure;
use crate::pictures::drawn;
use crate::progress::ProgressLine;
use files::UserError;
use numerics::NamedRig;
use numerics::basins::chapter::{ChapterBasin, POINTS};
use numerics::basins::{Basins, BasinsRequest, BasinsSummary, StartWindow, cells, explore};

/// Compute basins of attraction: the initial conditions that lead to impact, and the motions that they settle on
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  host-sim basins --ratio 2 --gap-ratio 2 --grid 100 --out out\n  host-sim basins --chapter --out out"
)]
#[command(group(clap::ArgGroup::new("where").required(true).args(["ratio", "frequency", "chapter"])))]
pub struct Args {
    #[command(flatten)]
    drive: OneFrequency,

    /// The twelve operating points that the chapter shows
    #[arg(long, conflicts_with_all = ["rig", "set", "gap", "gap_ratio", "cart"])]
    chapter: bool,

    /// Clearance at rest over the cart's amplitude, gap/A0
    #[arg(long, value_name = "G", conflicts_with = "gap")]
    gap_ratio: Option<f64>,

    /// Drive phase at the start, turns from 0 to below 1
    #[arg(long, value_name = "TURNS", default_value_t = 0.0)]
    phase: f64,

    /// Starts along displacement and velocity: COLUMNSxROWS, or one number for both
    #[arg(long, value_name = "N|CxR", value_parser = parse_grid, default_value = "500")]
    grid: (usize, usize),

    /// Displacements at the start relative to the cart, mm [default: -6 to the gap]
    #[arg(long, value_name = "FROM:TO", value_parser = parse_ends, allow_hyphen_values = true)]
    displacement: Option<[f64; 2]>,

    /// Velocities at the start relative to the cart, m/s [default: -0.15 to 0.15]
    #[arg(long, value_name = "FROM:TO", value_parser = parse_ends, allow_hyphen_values = true)]
    velocity: Option<[f64; 2]>,

    /// Drive cycles of each start
    #[arg(long, value_name = "N", default_value_t = 300)]
    cycles: u32,

    /// Cycles at the end that are recorded; a contact in them counts as impact [default: 100, of fewer than 200 cycles
    /// half]
    #[arg(long, value_name = "N")]
    recorded: Option<u32>,

    /// Random starts in addition to the grid, for shares with confidence intervals and the table over cycles; 0: none
    #[arg(long, value_name = "N", default_value_t = 2000)]
    samples: u32,

    /// Seed of the random starts
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,

    /// Drive cycles of the random starts, for the table over cycles [default: 1000, or --cycles if more]
    #[arg(long, value_name = "N")]
    until: Option<u32>,

    #[command(flatten)]
    rig: RigArgs,

    #[command(flatten)]
    cart: CartArg,

    #[command(flatten)]
    engine: EngineArgs,

    #[command(flatten)]
    pub output: OutputArgs,
}

/// One point and what was found.
struct Found {
    /// Its figure and part, if it is the chapter's.
    point: Option<ChapterBasin>,
    basins: Basins,
    summary: BasinsSummary,
}

pub fn run(args: &Args) -> Result<(), UserError> {
    let engine = args.engine.engine(&args.output)?;
    let queries = queries(args)?;
    // The chapter's points name their figures.
    let mut rigs: Vec<&NamedRig> = Vec::new();
    for (_, query) in &queries {
        if !rigs.contains(&&query.rig) {
            rigs.push(&query.rig);
        }
    }
    let output = &args.output.about(rigs)?;
    let total = queries.iter().map(|(_, query)| query.runs()).sum();
    let progress = ProgressLine::new("starts", total, output.quiet);
    let mut found = Vec::with_capacity(queries.len());
    for (point, query) in queries {
        let basins = explore(engine, &query, &progress)?;
        found.push(Found {
            point,
            summary: basins.summary(),
            basins,
        });
    }
    progress.finish();
    let failed: usize = found.iter().map(|one| one.summary.failed).sum();
    if failed > 0 {
        output.note(&format!(
            "note: from {failed} starts of the grid the hammer leaves the model's range (1 rad or 1 m) or needs a shorter tick; their rows say failed, and they count as no impact"
        ));
    }
    if let [
        Found {
            point: None,
            basins,
            summary,
        },
    ] = &found[..]
    {
        let picture = || output.picture(&figure(basins));
        let rows = cells::rows(basins);
        return output.answer(summary, &rows, picture, || text::one(basins, summary));
    }
    let summaries: Vec<&BasinsSummary> = found.iter().map(|one| &one.summary).collect();
    let lines = lines(&found);
    let files = || files_of_each(output, &found);
    output.answer(&summaries, &lines, files, || text::several(&lines))
}

fn queries(args: &Args) -> Result<Vec<(Option<ChapterBasin>, BasinsRequest)>, UserError> {
    let (columns, rows) = args.grid;
    let points = if args.chapter {
        let all = POINTS.into_iter();
        all.map(|point| Ok((Some(point), point.query(columns, rows)?)))
            .collect::<Result<Vec<_>, UserError>>()?
    } else {
        vec![(None, own(args)?)]
    };
    let points = points.into_iter().map(|(point, mut query)| {
        query.phase = args.phase;
        query.cycles = args.cycles;
        query.recorded = args.recorded.unwrap_or(usual_recorded(args.cycles));
        query.samples = args.samples;
        query.seed = args.seed;
        query.until = args.until.unwrap_or(args.cycles.max(1000));
        if let Some(ends) = args.displacement {
            query.window.displacement_m = ends.map(|mm| mm * 1e-3);
        }
        if let Some(ends) = args.velocity {
            query.window.velocity_m_per_s = ends;
        }
        query.check()?;
        Ok((point, query))
    });
    points.collect()
}

/// The operating point that the command line names.
fn own(args: &Args) -> Result<BasinsRequest, UserError> {
    let mut rig = args.cart.apply(args.rig.load()?)?;
    args.output.doubt_without_uncertainty(&rig);
    if let Some(ratio) = args.gap_ratio {
        let gap_mm = ratio * rig.params.amplitude_m * 1e3;
        rig.params = at_gap(&rig.params, gap_mm, format!("--gap-ratio {ratio}"))?;
    }
    let natural_hz = rig.params.natural_frequency_hz();
    let hz = args.drive.needed_hz(natural_hz)?;
    let (columns, rows) = args.grid;
    let query = BasinsRequest::usual(rig, hz, columns, rows);
    let window = StartWindow::usual(&query.rig.params, columns, rows);
    Ok(BasinsRequest { window, ..query })
}

/// The pictures and tables of each of the chapter's points.
fn files_of_each(output: &OutputArgs, found: &[Found]) -> Result<Contents, UserError> {
    let mut contents = Vec::new();
    for one in found {
        let of_figure = |point: ChapterBasin| {
            let figure = point.figure.replace('.', "-");
            output.name(&format!("-{figure}{}", point.part))
        };
        let name = one.point.map_or(output.name(""), of_figure);
        contents.extend(drawn(&name, &figure(&one.basins))?);
        let rows = cells::rows(&one.basins);
        contents.extend(output.tables(&name, &one.summary, &rows)?);
    }
    Ok(contents)
}

/// A point of the chapter as one line of a table. Shares are from 0 to 1.
#[derive(Serialize)]
struct Line<'a> {
    figure: String,
    rig: &'a str,
    frequency_ratio: f64,
    gap_over_amplitude: f64,
    impact_share: f64,
    impact_share_mesh_error: Option<f64>,
    impact_share_random: Option<f64>,
    impact_share_random_low: Option<f64>,
    impact_share_random_high: Option<f64>,
    impact_share_first_look: Option<f64>,
    impact_share_last_look: Option<f64>,
    attractors: usize,
    largest_attractor: String,
    basin_entropy: Option<f64>,
    boundary_basin_entropy: Option<f64>,
    uncertainty_exponent: Option<f64>,
}

fn lines(found: &[Found]) -> Vec<Line<'_>> {
    let line = |one| {
        let Found { point, summary, .. }: &Found = one;
        let random = summary.impact_share_random;
        let share = |look: Option<&numerics::basins::ImpactAfter>| look.map(|l| l.impact.value());
        Line {
            figure: point.map_or(String::new(), |p| format!("{} {}", p.figure, p.part)),
            rig: &summary.rig,
            frequency_ratio: summary.frequency_ratio,
            gap_over_amplitude: summary.gap_over_amplitude,
            impact_share: summary.impact_share,
            impact_share_mesh_error: summary.impact_share_mesh_error,
            impact_share_random: random.map(|s| s.value()),
            impact_share_random_low: random.map(|s| s.low),
            impact_share_random_high: random.map(|s| s.high),
            impact_share_first_look: share(summary.over_cycles.first()),
            impact_share_last_look: share(summary.over_cycles.last()),
            attractors: summary.attractors.len(),
            largest_attractor: summary
                .attractors
                .first()
                .map_or(String::new(), |a| a.name.to_string()),
            basin_entropy: summary.attractor_entropy.map(|e| e.basin),
            boundary_basin_entropy: summary.attractor_entropy.and_then(|e| e.boundary),
            uncertainty_exponent: summary.impact_uncertainty.map(|u| u.exponent),
        }
    };
    found.iter().map(line).collect()
}

/// Columns and rows from `COLUMNSxROWS`, or from one number for both.
fn parse_grid(text: &str) -> Result<(usize, usize), String> {
    let count = |t: &str| t.trim().parse::<usize>().ok().filter(|n| *n > 0);
    let found = match text.split_once('x') {
        Some((columns, rows)) => count(columns).zip(count(rows)),
        None => count(text).map(|n| (n, n)),
    };
    found
        .ok_or_else(|| "write COLUMNSxROWS, for example 500x300, or one number for both".to_owned())
}

/// Both ends of `FROM:TO`, of which FROM must be below TO.
fn parse_ends(text: &str) -> Result<[f64; 2], String> {
    let number = |t: &str| t.trim().parse::<f64>().ok().filter(|x| x.is_finite());
    let ends = text
        .split_once(':')
        .and_then(|(a, b)| number(a).zip(number(b)));
    let (from, to) = ends.ok_or("write FROM:TO, for example -6:1.5")?;
    rising(from, to).map(|()| [from, to])
}
