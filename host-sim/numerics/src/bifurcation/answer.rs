//! Diagrams as one answer: what is in each, and where the sweeps up and down differ.

use serde::Serialize;

use super::changes;
use super::measured::{Distance, MeasuredDiagram};
use super::{BifurcationDiagram, DiagramRequest, RegimeChange, Twofold};
use crate::row::CartModel;
use crate::sweep::Direction;

/// The answer as JSON.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BifurcationAnswer {
    /// Name of the rig.
    pub rig: String,
    /// Where the section is taken.
    pub section: &'static str,
    /// Drive cycles at each frequency.
    pub cycles: u32,
    /// How many of the last were recorded.
    pub recorded: u32,
    /// Simulations, without those that locate changes.
    pub simulations: u64,
    /// Each gap and direction.
    pub diagrams: Vec<DiagramAnswer>,
    /// Where the sweeps up and down differ.
    pub twofold: Vec<Twofold>,
    /// How the cart is moved.
    pub cart: CartModel,
}

/// What the answer says of the diagram of one gap and direction.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DiagramAnswer {
    /// Clearance at rest, mm.
    pub gap_mm: f64,
    /// "rest", "up" or "down".
    pub direction: &'static str,
    /// Number of drive frequencies in the diagram.
    pub frequencies: usize,
    /// Frequencies at which nothing repeated and the motion still changed.
    pub not_settled: usize,
    /// Where the number of branches changes, or one breaks off.
    pub changes: Vec<RegimeChange>,
    /// How far measured displacements lie from it, mm.
    pub measured_displacement_mm: Option<Distance>,
    /// How far measured forces lie from it, N.
    pub measured_force_n: Option<Distance>,
    /// Frequencies at which the hammer could not be followed.
    pub failed: usize,
}

impl BifurcationAnswer {
    /// Of the `diagrams` made for `request`, with measured points beside them.
    pub fn new(
        request: &DiagramRequest,
        diagrams: &[BifurcationDiagram],
        measured: Option<&MeasuredDiagram>,
    ) -> Self {
        let one = |d: &BifurcationDiagram| DiagramAnswer {
            gap_mm: d.gap_mm,
            direction: d.direction.name(),
            frequencies: d.stations.len(),
            not_settled: d.stations.iter().filter(|s| s.row.unsettled()).count(),
            changes: d.changes.clone(),
            measured_displacement_mm: measured
                .filter(|m| !m.displacement_mm.is_empty())
                .map(|m| m.displacement_distance(d)),
            measured_force_n: measured
                .filter(|m| !m.force_n.is_empty())
                .map(|m| m.force_distance(d)),
            failed: d.stations.iter().filter(|s| s.row.failed).count(),
        };
        let of = |gap: f64, direction| {
            diagrams
                .iter()
                .find(|d| d.gap_mm == gap && d.direction == direction)
        };
        let mut twofold = Vec::new();
        for same in diagrams.chunk_by(|a, b| a.gap_mm == b.gap_mm) {
            let gap = same[0].gap_mm;
            if let (Some(up), Some(down)) = (of(gap, Direction::Up), of(gap, Direction::Down)) {
                twofold.extend(changes::twofold(up, down));
            }
        }
        let cart = CartModel::of(&request.rig.params);
        Self {
            rig: request.rig.name.clone(),
            section: match cart {
                CartModel::Prescribed => {
                    "drive phase 0; displacement in the fixed frame and relative to the cart alike"
                }
                CartModel::Recoil => {
                    "drive phase 0; displacement relative to the cart, which recoils"
                }
            },
            cycles: request.plan.cycles,
            recorded: request.plan.recorded,
            simulations: request.simulations(),
            diagrams: diagrams.iter().map(one).collect(),
            twofold,
            cart,
        }
    }
}
