//! The sweeps behind the pictures of force over frequency: from rest, and carried up and down.

use rayon::prelude::*;
use shared::model::params::RigParams;

use super::Effort;
use crate::progress::ProgressLine;
use files::UserError;
use numerics::NamedRig;
use numerics::bifurcation::{BifurcationDiagram, DiagramRequest, Station, diagrams};
use numerics::engine::Engine;
use numerics::lanes::CellPlan;
use numerics::row::{Outcome, RunRow, tidy};
use numerics::sweep::{Direction, spread};

/// Sweeps of one rig at one gap: from rest, up and down.
pub struct SweepCurves {
    pub rig: &'static str,
    pub params: RigParams,
    pub rest: Vec<RunRow>,
    pub up: Vec<RunRow>,
    pub down: Vec<RunRow>,
}

/// Every rig at every gap, the gaps of a rig together.
pub fn curves(
    rigs: &[&'static str],
    gaps_mm: &[f64],
    (from, to): (f64, f64),
    effort: Effort,
    progress: &ProgressLine,
) -> Result<Vec<SweepCurves>, UserError> {
    let few = CellPlan {
        cycles: 60,
        recorded: 20,
        ..CellPlan::CHAPTER
    };
    let (count, plan) = effort.of((441, CellPlan::CHAPTER), (12, few));
    let ratios = spread(from, to, count);
    let ways = [Direction::Rest, Direction::Up, Direction::Down];
    let sweeps = rigs.iter().flat_map(|rig| ways.map(|way| (*rig, way)));
    let sweeps: Vec<_> = sweeps.collect();
    let found = sweeps.par_iter().map(|(rig, direction)| {
        let rig = NamedRig::preset(rig)?;
        let natural_hz = rig.params.natural_frequency_hz();
        let request = DiagramRequest {
            rig,
            gaps_mm: gaps_mm.to_vec(),
            frequencies_hz: ratios.iter().map(|ratio| ratio * natural_hz).collect(),
            directions: vec![*direction],
            engine: Engine::Event,
            plan,
            locate: false,
        };
        diagrams(&request, progress)
    });
    let found: Vec<Vec<BifurcationDiagram>> = found.collect::<Result<_, _>>()?;
    // The figures name the regime of every run, also of one that still changes.
    let named = |station: &Station| RunRow {
        outcome: Outcome::new(station.row.regime, false, station.row.failed),
        ..station.row.clone()
    };
    let mut curves = Vec::new();
    for (rig, by_way) in rigs.iter().zip(found.chunks(ways.len())) {
        for (gap, from_rest) in by_way[0].iter().enumerate() {
            let [rest, up, down] =
                [0, 1, 2].map(|way| by_way[way][gap].stations.iter().map(named).collect());
            curves.push(SweepCurves {
                rig,
                params: from_rest.params,
                rest,
                up,
                down,
            });
        }
    }
    Ok(curves)
}

/// Clearance at rest of a rig, mm.
pub fn gap_mm(params: &RigParams) -> f64 {
    tidy(params.gap_m * 1e3)
}
