//! The maps that a command line asks for.

use clap::ValueEnum;

use super::Args;
use crate::cli::arguments::cycles::usual_recorded;
use crate::cli::arguments::rig::at_gap;
use files::UserError;
use numerics::NamedRig;
use numerics::engine::{Engine, Method, Plan, Precision, Setting};
use numerics::lanes::CellPlan;
use numerics::map::request::{chapter_frequencies_hz, chapter_gaps_mm};
use numerics::map::{Grid, MapRequest, Runner};
use numerics::row::tidy;
use numerics::sweep::Direction;

/// How the second map of a comparison is made.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum SecondMap {
    /// The microcontroller's switch model, f32
    Switch,
    /// The event-located reference
    Reference,
    /// Each cell from rest
    Rest,
    /// The state carried up
    Up,
    /// The state carried down
    Down,
}

/// The maps to make: the rig's, those beside it, and the one to compare with last.
pub fn requests(args: &Args) -> Result<Vec<MapRequest>, UserError> {
    let names: Vec<&str> = if args.beams {
        vec!["beam-170", "beam-150", "beam-135"]
    } else {
        let beside = args.beside.iter().map(String::as_str);
        std::iter::once(args.rig.name.name())
            .chain(beside)
            .collect()
    };
    let rigs = names
        .iter()
        .map(|name| args.cart.apply(args.rig.name.load_named(name)?));
    let rigs: Vec<NamedRig> = rigs.collect::<Result<_, _>>()?;
    for (i, rig) in rigs.iter().enumerate() {
        if rigs[..i].iter().any(|other| other.name == rig.name) {
            return Err(UserError::new(format!(
                "two rigs are called {}, so that their files would have the same names; rename one",
                rig.name
            )));
        }
    }
    let grid = grid(args, &rigs[0])?;
    let runner = runner(args)?;
    let recorded = recorded(args)?;
    let request = |rig: &NamedRig| MapRequest {
        grid: over_same_ratios(&grid, &rigs[0], rig),
        rig: rig.clone(),
        runner,
        plan: CellPlan {
            cycles: args.cycles,
            recorded,
            early: true,
            strobes: 0,
        },
        settle: args.settle,
        from: args.direction,
    };
    let mut requests: Vec<MapRequest> = rigs.iter().map(request).collect();
    if let Some(against) = args.against {
        let other = other(&requests[0], against);
        if other == requests[0] {
            return Err(UserError::new(
                "--against names the engine or direction of the map itself; choose another",
            ));
        }
        requests.push(other);
    }
    Ok(requests)
}

/// Cycles of a cell that are recorded: as asked for, what the transient leaves, or the usual.
fn recorded(args: &Args) -> Result<u32, UserError> {
    match (args.recorded, args.transient) {
        (Some(recorded), _) => Ok(recorded),
        (None, Some(transient)) => {
            Plan::new(args.cycles, transient)?;
            Ok(args.cycles - transient)
        }
        (None, None) => Ok(usual_recorded(args.cycles)),
    }
}

fn runner(args: &Args) -> Result<Runner, UserError> {
    match args.engine.engine(&args.output)? {
        Engine::Switch(_) if args.reference => Err(UserError::new(
            "--reference does not go with --engine switch; leave one of the two out",
        )),
        Engine::Switch(setting) => Ok(Runner::Switch(setting)),
        Engine::Event if args.reference => Ok(Runner::Reference),
        Engine::Event => Ok(Runner::Lanes),
    }
}

/// The request made the other way: by another engine, or from another direction.
fn other(request: &MapRequest, against: SecondMap) -> MapRequest {
    let mut other = request.clone();
    match against {
        SecondMap::Switch => {
            other.runner = Runner::Switch(Setting {
                method: Method::Corrected,
                precision: Precision::F32,
                tick_s: 50e-6,
            });
        }
        SecondMap::Reference => other.runner = Runner::Reference,
        SecondMap::Rest => other.from = Direction::Rest,
        SecondMap::Up => other.from = Direction::Up,
        SecondMap::Down => other.from = Direction::Down,
    }
    other
}

fn grid(args: &Args, rig: &NamedRig) -> Result<Grid, UserError> {
    let given = args.drive.hz(rig.params.natural_frequency_hz())?;
    let frequencies_hz = given.unwrap_or_else(|| chapter_frequencies_hz(&rig.params));
    let gaps_mm = match args.rig.gaps_mm()? {
        Some(gaps) => gaps.into_iter().map(tidy).collect(),
        None => chapter_gaps_mm(&rig.params),
    };
    if let Some(pair) = gaps_mm.windows(2).find(|p| p[0] >= p[1]) {
        return Err(UserError::new(format!(
            "--gap: {:?} mm does not come after {:?} mm; give the gaps in rising order, each once",
            pair[1], pair[0]
        )));
    }
    for gap in [gaps_mm.first(), gaps_mm.last()].into_iter().flatten() {
        at_gap(&rig.params, *gap, "--gap")?;
    }
    Ok(Grid {
        gaps_mm,
        frequencies_hz,
    })
}

/// The grid of `first` for `rig`: the same Ω/ω and gap/A0.
fn over_same_ratios(grid: &Grid, first: &NamedRig, rig: &NamedRig) -> Grid {
    let in_frequency = rig.params.natural_frequency_hz() / first.params.natural_frequency_hz();
    let in_gap = rig.params.amplitude_m / first.params.amplitude_m;
    let scaled = |values: &[f64], by: f64| values.iter().map(|v| tidy(v * by)).collect();
    Grid {
        gaps_mm: scaled(&grid.gaps_mm, in_gap),
        frequencies_hz: scaled(&grid.frequencies_hz, in_frequency),
    }
}

/// The options that the name of a map tells.
pub const IN_ITS_NAME: &[&str] = &["from", "engine", "reference"];

/// How the names of a map's files begin.
pub fn name(request: &MapRequest) -> String {
    let from = match request.from {
        Direction::Rest => "",
        Direction::Up => "-up",
        Direction::Down => "-down",
    };
    let runner = match request.runner {
        Runner::Lanes => "",
        Runner::Reference => "-reference",
        Runner::Switch(_) => "-switch",
    };
    format!(
        "map-{}{from}{runner}",
        files::made_from::in_name(&request.rig.name)
    )
}
