//! Bifurcation diagrams (figures 3.27–3.35 and 3.43–3.45): the section's points over the drive frequency.
//!
//! The section is taken at drive phase 0, where the cart passes its middle: there the displacement in the fixed frame,
//! x = l sin θ + A0 sin Ωt or x = Δ + A0 sin Ωt, is the displacement relative to the cart (of a cart that recoils: but
//! for its deviation from its course). A state that is carried on is the hammer's: a cart that recoils begins each run on
//! its course.

pub mod answer;
pub mod changes;
pub mod measured;

use serde::Serialize;
use shared::model::params::RigParams;
use shared::model::rig::Rig;

use crate::engine::{Engine, check_recorded};
use crate::error::Error;
use crate::lanes::{self, Cell, CellOutcome, CellPlan, LaneStrobe};
use crate::progress::{Progress, check, step};
use crate::row::CartModel;
use crate::row::NamedRig;
use crate::row::{Outcome as Ended, RunRow, tidy};
use crate::sweep::Direction;

pub use changes::{ChangeKind, RegimeChange, Twofold};

/// One point of a diagram, as a table shows it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SectionPointRow {
    /// Clearance at rest, mm.
    pub gap_mm: f64,
    /// "rest", "up" or "down".
    pub direction: &'static str,
    /// Drive frequency, Hz.
    pub frequency_hz: f64,
    /// Drive frequency over the natural frequency, Ω/ω.
    pub frequency_ratio: f64,
    /// Regime over the recorded periods; "unsettled" and "failed" as in a sweep, the latter in the one row of a run that could not be followed.
    pub regime: Ended,
    /// Displacement at drive phase 0 relative to the cart (prescribed: in the fixed frame, too), mm.
    pub displacement_mm: Option<f64>,
    /// Its rate relative to the cart, m/s.
    pub relative_velocity_m_per_s: Option<f64>,
    /// Largest contact force in the drive period that ended there, N.
    pub force_n: Option<f64>,
    /// Largest contact force in the drive period that ended there, over m g.
    pub force_ratio: Option<f64>,
    /// Contacts that began in that period.
    pub contacts: Option<u16>,
    /// How the cart is moved.
    pub cart: CartModel,
}

/// A point of the section in a station.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DiagramPoint {
    /// Displacement relative to the cart at drive phase 0, mm.
    pub displacement_mm: f64,
    /// Velocity relative to the cart at drive phase 0, m/s.
    pub velocity_m_per_s: f64,
    /// Largest contact force of the period that ended there, N.
    pub force_n: f64,
    /// Contacts that began in it.
    pub contacts: u16,
}

/// What one frequency of a diagram showed.
#[derive(Clone, Debug, PartialEq)]
pub struct Station {
    /// Regime and force, as in a [`mod@crate::sweep`].
    pub row: RunRow,
    /// Points of the section, oldest first: as many as the motion has periods; if it does not repeat, all recorded.
    pub points: Vec<DiagramPoint>,
    /// Whether the two halves of its repetition move apart over what is recorded.
    pub grows: bool,
    /// Coordinate and rate it began from.
    pub start: [f64; 2],
    /// Coordinate and rate at the end.
    pub end: [f64; 2],
}

/// The diagram of one gap and direction.
#[derive(Clone, Debug, PartialEq)]
pub struct BifurcationDiagram {
    /// The rig, with the gap.
    pub params: RigParams,
    /// Clearance at rest, mm.
    pub gap_mm: f64,
    /// How the frequencies were visited.
    pub direction: Direction,
    /// By rising frequency, whatever the direction.
    pub stations: Vec<Station>,
    /// Where the number of branches changes, or a branch breaks off.
    pub changes: Vec<RegimeChange>,
}

/// Which diagrams to compute: one for each gap and direction.
#[derive(Clone, Debug)]
pub struct DiagramRequest {
    /// The rig; its own gap is not used.
    pub rig: NamedRig,
    /// Clearances at rest, mm.
    pub gaps_mm: Vec<f64>,
    /// Drive frequencies of each diagram, Hz, rising.
    pub frequencies_hz: Vec<f64>,
    /// Orders in which the frequencies are visited.
    pub directions: Vec<Direction>,
    /// What integrates: the event engine runs through [`lanes`].
    pub engine: Engine,
    /// Cycles of each simulation; its strobes are the points.
    pub plan: CellPlan,
    /// Whether changes are located by bisection between two frequencies.
    pub locate: bool,
}

impl DiagramRequest {
    /// Refuses what cannot be run, before any work.
    ///
    /// # Errors
    /// As [`check_recorded`].
    pub fn check(&self) -> Result<(), Error> {
        check_recorded(self.plan.recorded, self.plan.cycles)
    }

    /// Simulations in all, location apart.
    pub fn simulations(&self) -> u64 {
        (self.gaps_mm.len() * self.frequencies_hz.len() * self.directions.len()) as u64
    }

    fn run(&self, cells: &[Cell]) -> Vec<Result<CellOutcome, Error>> {
        match self.engine {
            Engine::Event => lanes::run_each(cells, &self.plan),
            Engine::Switch(_) => lanes::each_by_engine(self.engine, cells, &self.plan),
        }
    }
}

/// A chain: one gap in one direction.
struct Chain {
    params: RigParams,
    gap_mm: f64,
    direction: Direction,
    rest: [f64; 2],
}

/// Computes every diagram, gap by gap and within a gap direction by direction.
///
/// From rest, every frequency is a cell of its own. Carried up or down, all chains go on together from frequency to
/// frequency, each from where it was.
///
/// A hammer that leaves what the model describes is a station that failed, without points; carried on, the next begins
/// from rest.
///
/// # Errors
/// If a parameter or a frequency is out of range, if every run fails, or if the work is interrupted.
pub fn diagrams(
    request: &DiagramRequest,
    progress: &dyn Progress,
) -> Result<Vec<BifurcationDiagram>, Error> {
    let mut chains = Vec::new();
    for gap_mm in &request.gaps_mm {
        let params = request.rig.params.with_gap_mm(*gap_mm)?;
        let rest = [Rig::<f64>::new(&params)?.rest(), 0.0];
        chains.extend(request.directions.iter().map(|direction| Chain {
            params,
            gap_mm: tidy(*gap_mm),
            direction: *direction,
            rest,
        }));
    }
    let mut stations: Vec<Vec<Station>> = Vec::new();
    for chain in &chains {
        stations.push(match chain.direction {
            Direction::Rest => from_rest(request, chain, progress)?,
            Direction::Up | Direction::Down => Vec::new(),
        });
    }
    for direction in [Direction::Up, Direction::Down] {
        carry(request, &chains, direction, &mut stations, progress)?;
    }
    if let Some(error) = all_failed(request, &stations) {
        return Err(error);
    }
    let mut diagrams = Vec::with_capacity(chains.len());
    for (chain, stations) in chains.into_iter().zip(stations) {
        let mut diagram = BifurcationDiagram {
            params: chain.params,
            gap_mm: chain.gap_mm,
            direction: chain.direction,
            stations,
            changes: Vec::new(),
        };
        diagram.changes = changes::find(&diagram);
        if request.locate {
            changes::locate(&mut diagram, &|cells| {
                check(progress)?;
                let outcomes = request.run(cells);
                outcomes.into_iter().map(lanes::or_failed).collect()
            })?;
        }
        diagrams.push(diagram);
    }
    Ok(diagrams)
}

/// Why, if every run failed.
fn all_failed(request: &DiagramRequest, stations: &[Vec<Station>]) -> Option<Error> {
    let first = stations.iter().flatten().next()?;
    if !stations.iter().flatten().all(|s| s.row.failed) {
        return None;
    }
    let params = request.rig.params.with_gap_mm(first.row.gap_mm).ok()?;
    let again = Cell {
        params,
        frequency_hz: first.row.frequency_hz,
        start: first.start,
        phase: 0.0,
    };
    request.run(&[again]).pop()?.err()
}

/// Simulations handed over at once, so that progress shows.
const BATCH: usize = 256;

fn from_rest(
    request: &DiagramRequest,
    chain: &Chain,
    progress: &dyn Progress,
) -> Result<Vec<Station>, Error> {
    let mut stations = Vec::with_capacity(request.frequencies_hz.len());
    for some in request.frequencies_hz.chunks(BATCH) {
        let cells: Vec<_> = some.iter().map(|hz| cell(chain, *hz, chain.rest)).collect();
        let outcomes = request.run(&cells);
        for (cell, outcome) in cells.iter().zip(outcomes) {
            stations.push(ended(&request.rig.name, chain, cell, outcome)?);
        }
        step(progress, some.len() as u64)?;
    }
    Ok(stations)
}

fn carry(
    request: &DiagramRequest,
    chains: &[Chain],
    direction: Direction,
    stations: &mut [Vec<Station>],
    progress: &dyn Progress,
) -> Result<(), Error> {
    let going: Vec<usize> = (0..chains.len())
        .filter(|i| chains[*i].direction == direction)
        .collect();
    let mut order = request.frequencies_hz.clone();
    if direction == Direction::Down {
        order.reverse();
    }
    for hz in order {
        let start = |i: &usize| stations[*i].last().map_or(chains[*i].rest, |s| s.end);
        let cells: Vec<_> = going
            .iter()
            .map(|i| cell(&chains[*i], hz, start(i)))
            .collect();
        let outcomes = request.run(&cells);
        for ((i, cell), outcome) in going.iter().zip(&cells).zip(outcomes) {
            stations[*i].push(ended(&request.rig.name, &chains[*i], cell, outcome)?);
        }
        step(progress, going.len() as u64)?;
    }
    if direction == Direction::Down {
        going.iter().for_each(|i| stations[*i].reverse());
    }
    Ok(())
}

fn cell(chain: &Chain, frequency_hz: f64, start: [f64; 2]) -> Cell {
    Cell {
        params: chain.params,
        frequency_hz,
        start,
        phase: 0.0,
    }
}

/// The station of a cell that ended so or failed; behind one that failed the next begins from rest.
fn ended(
    rig_name: &str,
    chain: &Chain,
    cell: &Cell,
    outcome: Result<CellOutcome, Error>,
) -> Result<Station, Error> {
    match lanes::or_failed(outcome)? {
        Some(outcome) => station(rig_name, cell, &outcome),
        None => Ok(Station {
            row: RunRow::failed(rig_name, &cell.params, cell.frequency_hz),
            points: Vec::new(),
            grows: false,
            start: cell.start,
            end: chain.rest,
        }),
    }
}

/// What a cell's outcome is in a diagram.
fn station(rig_name: &str, cell: &Cell, outcome: &CellOutcome) -> Result<Station, Error> {
    let params = &cell.params;
    let rig = Rig::<f64>::new(params)?;
    let point = |s: &LaneStrobe| DiagramPoint {
        displacement_mm: rig.relative_displacement(s.q) * 1e3,
        velocity_m_per_s: rig.kinematics(s.q, s.v).rate,
        force_n: s.force_n,
        contacts: s.onsets,
    };
    let repeats = outcome.regime.periods().map_or(usize::MAX, usize::from);
    let from = outcome.strobes.len().saturating_sub(repeats);
    let alternation = |strobes: &[LaneStrobe]| (strobes[0].q - strobes[repeats / 2].q).abs();
    let grows = (2..=outcome.strobes.len()).contains(&repeats)
        && alternation(&outcome.strobes[from..]) > alternation(&outcome.strobes);
    Ok(Station {
        row: RunRow::of_cell(rig_name, params, cell.frequency_hz, outcome),
        points: outcome.strobes[from..].iter().map(point).collect(),
        grows,
        start: cell.start,
        end: outcome.section,
    })
}

/// Every point of every diagram, in their order.
pub fn rows(diagrams: &[BifurcationDiagram]) -> Vec<SectionPointRow> {
    let mut rows = Vec::new();
    for diagram in diagrams {
        let weight = diagram.params.weight_n();
        let cart = CartModel::of(&diagram.params);
        for station in &diagram.stations {
            let row = |p: Option<&DiagramPoint>| SectionPointRow {
                gap_mm: diagram.gap_mm,
                direction: diagram.direction.name(),
                frequency_hz: station.row.frequency_hz,
                frequency_ratio: station.row.frequency_ratio,
                regime: station.row.outcome,
                displacement_mm: p.map(|p| p.displacement_mm),
                relative_velocity_m_per_s: p.map(|p| p.velocity_m_per_s),
                force_n: p.map(|p| p.force_n),
                force_ratio: p.map(|p| p.force_n / weight),
                contacts: p.map(|p| p.contacts),
                cart,
            };
            rows.extend(station.points.iter().map(|p| row(Some(p))));
            if station.row.failed {
                rows.push(row(None));
            }
        }
    }
    rows
}
