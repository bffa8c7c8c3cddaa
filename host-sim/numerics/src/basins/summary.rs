//! What basins come to, in numbers.

use serde::Serialize;

use super::entropy::{self, Entropy, StartUncertainty};
use super::{AttractorName, Basins, ImpactAfter, SampledShare};
use crate::row::CartModel;

/// What the basins come to, with units in the names. Shares are from 0 to 1.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BasinsSummary {
    /// Name of the rig.
    pub rig: String,
    /// Clearance at rest, mm.
    pub gap_mm: f64,
    /// Clearance at rest over the cart's amplitude, gap/A0.
    pub gap_over_amplitude: f64,
    /// Drive frequency, Hz.
    pub frequency_hz: f64,
    /// Drive frequency over the natural frequency, Ω/ω.
    pub frequency_ratio: f64,
    /// Drive phase at the start, turns.
    pub phase_turns: f64,
    /// Displacements of the window, mm.
    pub displacement_mm: [f64; 2],
    /// Velocities of the window, m/s.
    pub velocity_m_per_s: [f64; 2],
    /// Columns and rows of the grid.
    pub grid: [usize; 2],
    /// Cycles of each start.
    pub cycles: u32,
    /// How many of the last were recorded.
    pub recorded: u32,
    /// Share of the grid that has a contact in the recorded cycles.
    pub impact_share: f64,
    /// The mesh's error of it; `None` if the grid is too small.
    pub impact_share_mesh_error: Option<f64>,
    /// Share of the random starts with a contact in the recorded cycles; none without random starts.
    pub impact_share_random: Option<SampledShare>,
    /// Entropy of the picture impact / no impact, nats.
    pub impact_entropy: Option<Entropy>,
    /// Entropy of the picture by attractor, nats.
    pub attractor_entropy: Option<Entropy>,
    /// How the boundary of impact / no impact fills the plane.
    pub impact_uncertainty: Option<StartUncertainty>,
    /// Whether the attractors' boundary basin entropy is above ln 2.
    pub fractal_by_entropy: bool,
    /// The attractors with their shares, those with most starts (grid and random) first.
    pub attractors: Vec<AttractorShare>,
    /// Share of impact over the number of cycles.
    pub over_cycles: Vec<ImpactAfter>,
    /// Starts (of the grid) an engine was uncertain of.
    pub uncertain: usize,
    /// Starts of the grid whose hammer could not be followed: they are among the attractors, as "failed", and count as no
    /// impact.
    pub failed: usize,
    /// How the cart is moved. One that recoils is on its course at the start.
    pub cart: CartModel,
}

/// One attractor of the basins with its shares of the starts.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AttractorShare {
    /// Name of the attractor: kind of motion, with a letter where several are of one kind.
    pub name: AttractorName,
    /// Contacts per repetition, p; where nothing repeats, in the last 16 recorded periods of its first start.
    pub impacts: u16,
    /// n, if it repeats.
    pub periods: Option<u8>,
    /// Largest contact force over m g.
    pub force_ratio: f64,
    /// Middle of its section, in A0 and A0 Ω of the rig's coordinate (from the contact configuration).
    pub section_middle: Option<[f64; 2]>,
    /// Share of the grid.
    pub share: f64,
    /// The mesh's error of it.
    pub share_mesh_error: Option<f64>,
    /// Share of the random starts.
    pub share_random: Option<SampledShare>,
}

impl BasinsSummary {
    pub(super) fn new(basins: &Basins) -> Self {
        let query = &basins.query;
        let params = &query.rig.params;
        let window = &query.window;
        let tidy = crate::row::tidy;
        let sampled = |share: SampledShare| (share.of > 0).then_some(share);
        let (impact_share, impact_share_mesh_error) = basins.grid_share(|f, _| f.impacts());
        let picture = basins.impact_picture();
        let attractor_entropy = entropy::entropy(&basins.which, window.columns);
        let boundary = attractor_entropy.and_then(|e| e.boundary);
        let attractors = (0_u16..).zip(&basins.attractors).map(|(number, a)| {
            let (share, share_mesh_error) = basins.grid_share(|_, which| which == number);
            AttractorShare {
                name: a.name,
                impacts: a.regime.impacts(),
                periods: a.regime.periods(),
                force_ratio: a.force_n / params.weight_n(),
                section_middle: a.middle,
                share,
                share_mesh_error,
                share_random: sampled(basins.random_share(|_, which| which == number)),
            }
        });
        Self {
            rig: query.rig.name.clone(),
            gap_mm: tidy(params.gap_m * 1e3),
            gap_over_amplitude: tidy(params.gap_m / params.amplitude_m),
            frequency_hz: tidy(query.frequency_hz),
            frequency_ratio: tidy(query.frequency_hz / params.natural_frequency_hz()),
            phase_turns: query.phase,
            displacement_mm: window.displacement_m.map(|x| tidy(x * 1e3)),
            velocity_m_per_s: window.velocity_m_per_s,
            grid: [window.columns, window.rows],
            cycles: query.cycles,
            recorded: query.recorded,
            impact_share,
            impact_share_mesh_error,
            impact_share_random: sampled(basins.random_share(|f, _| f.impacts())),
            impact_entropy: entropy::entropy(&picture, window.columns),
            attractor_entropy,
            impact_uncertainty: entropy::uncertainty(&picture, window.columns),
            fractal_by_entropy: boundary.is_some_and(|s| s > entropy::FRACTAL_ABOVE),
            attractors: attractors.collect(),
            over_cycles: basins.over_cycles.clone(),
            uncertain: basins.grid.iter().filter(|f| f.uncertain).count(),
            failed: basins.grid.iter().filter(|f| f.failed).count(),
            cart: CartModel::of(params),
        }
    }
}
