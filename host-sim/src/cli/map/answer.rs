//! The answer of `map` for programs.

use serde::Serialize;

use super::requests;
use crate::cli::arguments::output::no_json;
use files::UserError;
use numerics::CartModel;
use numerics::map::measured::Hits;
use numerics::map::{Agreement, Map, MapCell, MapRequest, MapSummary, Similarity};

/// Everything that was found.
pub struct MapAnswer<'a> {
    pub requests: &'a [MapRequest],
    pub maps: &'a [Map],
    pub summaries: Vec<MapSummary>,
    pub audit: Option<Agreement>,
    pub against: Option<Agreement>,
    pub alikeness: Vec<Similarity>,
    pub measured: Option<Hits>,
}

#[derive(Serialize)]
struct Json<'a> {
    maps: Vec<MapJson<'a>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    audit: Option<Agreement>,
    #[serde(skip_serializing_if = "Option::is_none")]
    against: Option<Agreement>,
    #[serde(skip_serializing_if = "<[_]>::is_empty")]
    alikeness: &'a [Similarity],
    #[serde(skip_serializing_if = "Option::is_none")]
    measured: Option<Hits>,
}

/// A map: axes, and layers with the cells row by row (all frequencies of the first gap first).
#[derive(Serialize)]
struct MapJson<'a> {
    name: String,
    rig: &'a str,
    cart: CartModel,
    engine: &'static str,
    from: &'static str,
    cycles: u32,
    recorded: u32,
    settle: Option<u32>,
    summary: &'a MapSummary,
    gaps_mm: &'a [f64],
    gap_ratios: Vec<f64>,
    frequencies_hz: &'a [f64],
    frequency_ratios: Vec<f64>,
    layers: Layers,
}

#[derive(Serialize)]
struct Layers {
    regime: Vec<String>,
    impacts: Vec<u16>,
    periods: Vec<Option<u8>>,
    force_ratio: Vec<f64>,
    settling_cycles: Vec<Option<u32>>,
    largest_period_searched: Vec<u8>,
    uncertain: Vec<bool>,
    failed: Vec<bool>,
}

impl MapAnswer<'_> {
    /// On one line: layers have hundreds of thousands of numbers.
    pub fn to_json(&self) -> Result<String, UserError> {
        let maps = self.requests.iter().zip(self.maps).zip(&self.summaries);
        let json = Json {
            maps: maps.map(|((r, m), s)| map(r, m, s)).collect(),
            audit: self.audit,
            against: self.against,
            alikeness: &self.alikeness,
            measured: self.measured,
        };
        Ok(serde_json::to_string(&json).map_err(no_json)? + "\n")
    }
}

fn map<'a>(request: &'a MapRequest, map: &'a Map, summary: &'a MapSummary) -> MapJson<'a> {
    MapJson {
        name: requests::name(request),
        rig: &map.rig.name,
        cart: CartModel::of(&map.rig.params),
        engine: request.runner.name(),
        from: request.from.name(),
        cycles: request.plan.cycles,
        recorded: request.plan.recorded,
        settle: request.settle,
        summary,
        gaps_mm: &map.grid.gaps_mm,
        gap_ratios: map.gap_ratios(),
        frequencies_hz: &map.grid.frequencies_hz,
        frequency_ratios: map.frequency_ratios(),
        layers: Layers {
            regime: layer(map, |c| c.label().to_string()),
            impacts: layer(map, |c| c.regime.impacts()),
            periods: layer(map, |c| c.regime.periods()),
            force_ratio: (0..map.cells.len()).map(|i| map.force_ratio(i)).collect(),
            settling_cycles: layer(map, |c| c.settled_after),
            largest_period_searched: layer(map, |c| c.searched),
            uncertain: layer(map, |c| c.uncertain),
            failed: layer(map, |c| c.failed),
        },
    }
}

fn layer<T>(map: &Map, of: impl Fn(&MapCell) -> T) -> Vec<T> {
    map.cells.iter().map(of).collect()
}
