//! Basins as a table: a line per start.

use serde::Serialize;

use super::{AttractorName, Basins};
use crate::row::CartModel;
use crate::row::Outcome;

/// One start of the grid and what became of it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StartRow {
    /// Displacement relative to the cart at the start, mm.
    pub displacement_mm: f64,
    /// Velocity relative to the cart at the start, m/s.
    pub velocity_m_per_s: f64,
    /// Drive phase at the start, turns.
    pub phase_turns: f64,
    /// Whether it has a contact in the recorded cycles.
    pub impact: bool,
    /// "p/n", "none", "aperiodic", "chatter", "unsettled" or "failed".
    pub regime: Outcome,
    /// p; none if the run failed.
    pub impacts: Option<u16>,
    /// n, if the section repeats.
    pub periods: Option<u8>,
    /// Which of the attractors, by name.
    pub attractor: AttractorName,
    /// Largest contact force of the recorded cycles over m g; none if the run failed.
    pub force_ratio: Option<f64>,
    /// Cycle after which the section had settled.
    pub settled_after_cycles: Option<u32>,
    /// Cycle of the last contact, counted from 1.
    pub last_contact_cycle: Option<u32>,
    /// Whether the fast engine handed the cell to the reference.
    pub uncertain: bool,
    /// How the cart is moved.
    pub cart: CartModel,
}

/// The grid, rows by rising velocity, within a row by rising displacement.
pub fn rows(basins: &Basins) -> Vec<StartRow> {
    let weight = basins.query.rig.params.weight_n();
    let cart = CartModel::of(&basins.query.rig.params);
    let cells = basins.grid.iter().zip(&basins.which);
    cells
        .map(|(fate, which)| StartRow {
            displacement_mm: fate.start[0] * 1e3,
            velocity_m_per_s: fate.start[1],
            phase_turns: basins.query.phase,
            impact: fate.impacts(),
            regime: Outcome::new(fate.regime, fate.unsettled, fate.failed),
            impacts: (!fate.failed).then(|| fate.regime.impacts()),
            periods: fate.regime.periods(),
            attractor: basins.attractors[usize::from(*which)].name,
            force_ratio: (!fate.failed).then_some(fate.force_n / weight),
            settled_after_cycles: fate.settled_after,
            last_contact_cycle: fate.last_contact,
            uncertain: fate.uncertain,
            cart,
        })
        .collect()
}
