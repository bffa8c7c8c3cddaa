//! `host-sim map`.

mod answer;
mod requests;
mod text;
mod written;

use std::ops::Range;
use std::path::PathBuf;

use answer::Answer;
use written::{file_name, write};

use super::arguments::choice::choice;
use super::arguments::drive::{Drives, chapters};
use super::arguments::engine::EngineArgs;
use super::arguments::output::{Format, OutputArgs};
use super::arguments::rig::{CartArg, RigAtGaps};
use super::interrupt;
use super::terminal::print_bytes;
use crate::progress::Progress;
use crate::tiles::Store;
use files::UserError;
use files::made_from::into_json;
use files::words::count;
use numerics::NamedRig;
use numerics::error::{Error, MapError};
use numerics::map::{
    self, Map, MapRequest, Summary, agree, measured, measured::Measured, similarity,
};
use numerics::sweep::Direction;

/// Exit code: 0; 2 the map could not be made; 130 interrupted, and the finished tiles are kept.
#[derive(Clone, Debug, clap::Args)]
#[command(group(clap::ArgGroup::new("drive").args(["ratio", "frequency"])), mut_arg("frequency", chapters))]
pub struct Args {
    #[command(flatten)]
    drive: Drives,

    /// Drive cycles of each cell
    #[arg(long, value_name = "N", default_value_t = 300)]
    cycles: u32,

    /// How many of the last cycles are recorded [default: 100, of fewer than 200 cycles half]
    #[arg(long, value_name = "N")]
    recorded: Option<u32>,

    /// Cells that have not settled run on up to N cycles
    #[arg(long, value_name = "N")]
    settle: Option<u32>,

    /// Each cell from rest, or at each gap the state carried up or down the frequencies
    #[arg(long, alias = "from", value_parser = choice::<Direction>(), default_value = "rest")]
    direction: Direction,

    /// How many of the first cycles are not recorded: the other way to say --recorded
    #[arg(long, value_name = "N", conflicts_with = "recorded")]
    transient: Option<u32>,

    /// Compute every cell alone with the reference, instead of many at once as --engine event does (hours, not seconds)
    #[arg(long)]
    reference: bool,

    /// Compute a second map, and show where it differs from the first
    #[arg(long, value_enum)]
    against: Option<requests::Against>,

    /// Add another rig's map over the same Ω/ω and gap/A0, and say how similar they are; may be given several times
    #[arg(long, value_name = "NAME|FILE.toml")]
    beside: Vec<String>,

    /// The three beams side by side: --rig beam-170 --beside beam-150 --beside beam-135
    #[arg(long, conflicts_with_all = ["rig", "beside"])]
    beams: bool,

    /// Measured points to lay over the map: CSV with the columns gap_mm, frequency_hz and regime
    #[arg(long, value_name = "FILE.csv")]
    measured: Option<PathBuf>,

    /// Run N random cells again with the reference, and report how many agree
    #[arg(long, value_name = "N")]
    audit: Option<usize>,

    /// Seed of the audit's random cells
    #[arg(long, value_name = "N", default_value_t = 1, requires = "audit")]
    seed: u64,

    /// Compute only tiles A to B − 1 (A..B), or the I-th of N equal shares (I/N), and store them in the output folder
    #[arg(long, value_name = "A..B|I/N", value_parser = requests::parse_tiles, conflicts_with_all = ["merge", "audit", "measured"])]
    tiles: Option<requests::Tiles>,

    /// Assemble the map from tiles that are already computed
    #[arg(long)]
    merge: bool,

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
    args.output.check()?;
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
        if let Some(tiles) = args.tiles {
            request.check_tiles(&tiles.range(request.tiles()))?;
        }
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
    if output.out.is_none() && (args.tiles.is_some() || args.merge) {
        return Err(UserError::new(
            "--tiles and --merge need a folder for the tiles; add --out DIR",
        ));
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
    points: Option<&[Measured]>,
) -> Result<(), UserError> {
    let output = &args.output;
    let stores = stores(args, requests)?;
    let progress = progress(args, requests);
    if let Some(tiles) = args.tiles {
        return share(args, tiles, requests, &stores, &progress);
    }
    let maps = match maps(args, requests, &stores, &progress) {
        Ok(maps) => maps,
        Err(error) => {
            stores.into_iter().for_each(Store::remove_if_empty);
            return Err(error);
        }
    };
    let answer = answer(args, requests, &maps, points, &progress)?;
    progress.finish();
    for (map, summary) in maps.iter().zip(&answer.summaries) {
        if summary.failed > 0 {
            output.note(&format!(
                "note: {}: in {} of {} the hammer leaves what the model describes (beyond 1 rad or 1 m) or needs a shorter tick; their rows say failed",
                map.rig.name,
                summary.failed,
                count(summary.cells, "cell")
            ));
        }
    }
    if let Some(dir) = &output.out {
        write(output, dir, &answer, points)?;
    }
    for store in stores {
        store.remove();
    }
    let alone = maps.len() == 1;
    match output.format {
        Format::Json => {
            let json = into_json(answer.to_json()?, output.made_from());
            print_bytes(json.as_bytes());
            Ok(())
        }
        Format::Csv if !alone => Ok(()),
        format => output.emit(&(), &rows(format, &maps[0]), || text::text(&answer, &maps)),
    }
}

fn maps(
    args: &Args,
    requests: &[MapRequest],
    stores: &[Store],
    progress: &Progress,
) -> Result<Vec<Map>, UserError> {
    let one = |(i, request): (usize, &MapRequest)| -> Result<Map, UserError> {
        let store: Option<&Store> = stores.get(i);
        match store {
            Some(store) if args.merge => {
                map::merge(request, store).map_err(|error| merge_error(error, store))
            }
            _ => {
                let tiles = store.map(|store| store as &dyn map::Tiles);
                Ok(map::run(request, tiles, progress)?)
            }
        }
    };
    requests.iter().enumerate().map(one).collect()
}

/// Adds the folder to the error about missing tiles.
fn merge_error(error: Error, store: &Store) -> UserError {
    match error {
        Error::Map(MapError::MissingTiles { .. }) => {
            UserError::from(error).at(store.dir().display())
        }
        other => other.into(),
    }
}

/// The rows that a format needs.
fn rows(format: Format, map: &Map) -> Vec<map::CellRow> {
    match format {
        Format::Csv => map.rows().collect(),
        Format::Text | Format::Json => Vec::new(),
    }
}

/// A folder of tiles in the output folder for each map; none without an output folder.
fn stores(args: &Args, requests: &[MapRequest]) -> Result<Vec<Store>, UserError> {
    let Some(dir) = &args.output.out else {
        return Ok(Vec::new());
    };
    let open = |request: &MapRequest| -> Result<Store, UserError> {
        let dir = dir.join(format!("{}.tiles", file_name(&args.output, request)));
        let (store, another) = Store::open(&dir, request)?;
        match another {
            // Others may have computed them for hours.
            Some(what) if args.tiles.is_some() || args.merge => Err(UserError::new(format!(
                "{what}; finish that one, remove the folder, or choose another --out"
            ))),
            Some(what) => {
                args.output
                    .note(&format!("note: {what}; this map is begun anew"));
                Ok(store)
            }
            None => Ok(store),
        }
    };
    let stores = requests.iter().map(open).collect::<Result<Vec<_>, _>>()?;
    if !args.output.quiet {
        interrupt::say_then(format!(
            "interrupted; the finished tiles are kept in {}: the same command goes on from there",
            dir.display()
        ));
    }
    Ok(stores)
}

fn progress(args: &Args, requests: &[MapRequest]) -> Progress {
    let cells = |request: &MapRequest| match args.tiles {
        Some(tiles) => {
            let tiles = tiles.range(request.tiles());
            tiles.map(|t| request.tile(t).len()).sum::<usize>()
        }
        None => request.grid.len(),
    };
    let total: usize = requests.iter().map(cells).sum();
    let total = total + args.audit.unwrap_or(0);
    Progress::new("cells", total as u64, args.output.quiet)
}

/// Computes some tiles and nothing else.
fn share(
    args: &Args,
    tiles: requests::Tiles,
    requests: &[MapRequest],
    stores: &[Store],
    progress: &Progress,
) -> Result<(), UserError> {
    for (request, store) in requests.iter().zip(stores) {
        let range: Range<usize> = tiles.range(request.tiles());
        if range.is_empty() {
            args.output
                .note("there are more shares than tiles; this share has none");
            continue;
        }
        map::run_tiles(request, range.clone(), store, progress)?;
        args.output.note(&format!(
            "tiles {}..{} of {} are in {}; when all are there, the same command with --merge in place of --tiles writes the map",
            range.start,
            range.end,
            request.tiles(),
            store.dir().display()
        ));
    }
    Ok(())
}

fn answer<'a>(
    args: &Args,
    requests: &'a [MapRequest],
    maps: &'a [Map],
    points: Option<&[Measured]>,
    progress: &Progress,
) -> Result<Answer<'a>, UserError> {
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
    Ok(Answer {
        requests,
        maps,
        summaries: maps.iter().map(Summary::of).collect(),
        audit: audit.transpose()?,
        against: against.map(|other| map::Agreement::of(first.cells.iter().zip(&other.cells))),
        alikeness: alike,
        measured: points.map(|points| measured::hits(points, first)),
    })
}
