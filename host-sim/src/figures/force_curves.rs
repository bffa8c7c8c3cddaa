//! The sweeps behind the pictures of force over frequency: from rest, and carried up and down.

use shared::model::params::{RigParams, preset};
use shared::model::rig::Rig;

use super::Effort;
use crate::progress::ProgressLine;
use files::UserError;
use numerics::CartModel;
use numerics::engine::Start;
use numerics::lanes::{self, Cell, CellOutcome, CellPlan};
use numerics::row::{RunRow, tidy};
use numerics::sweep::spread;

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
    let (count, plan) = match effort {
        Effort::Full => (441, CellPlan::CHAPTER),
        Effort::Coarse => (
            12,
            CellPlan {
                cycles: 60,
                recorded: 20,
                ..CellPlan::CHAPTER
            },
        ),
    };
    let ratios = spread(from, to, count);
    let mut chains = Vec::new();
    for rig in rigs {
        let known = preset(rig).ok_or_else(|| UserError::new(format!("no rig {rig}")))?;
        for gap in gaps_mm {
            chains.push((
                *rig,
                RigParams {
                    gap_m: gap * 1e-3,
                    ..known
                },
            ));
        }
    }
    let rest = from_rest(&chains, &ratios, &plan, progress)?;
    let carried = carried(&chains, &ratios, &plan, progress)?;
    let all = chains.into_iter().zip(rest).zip(carried);
    Ok(all
        .map(|(((rig, params), rest), (up, down))| SweepCurves {
            rig,
            params,
            rest,
            up,
            down,
        })
        .collect())
}

fn cell(params: &RigParams, ratio: f64) -> Result<Cell, UserError> {
    let frequency_hz = ratio * params.natural_frequency_hz();
    let rig = Rig::<f64>::new(params)?;
    Ok(Cell {
        params: *params,
        frequency_hz,
        start: Start::Rest.section(&rig, std::f64::consts::TAU * frequency_hz)?,
        phase: 0.0,
    })
}

fn row(rig: &str, cell: &Cell, seen: &CellOutcome) -> RunRow {
    let params = &cell.params;
    RunRow {
        rig: rig.to_owned(),
        gap_mm: gap_mm(params),
        cart: CartModel::of(params),
        frequency_hz: tidy(cell.frequency_hz),
        frequency_ratio: tidy(cell.frequency_hz / params.natural_frequency_hz()),
        impacts: seen.regime.impacts(),
        periods: seen.regime.periods(),
        regime: seen.regime,
        force_ratio: seen.force_n / params.weight_n(),
        force_n: seen.force_n,
        approach_speed_m_per_s: None,
        contact_time_ms: None,
        unsettled: false,
        failed: false,
        failure: None,
    }
}

type Chain = (&'static str, RigParams);

fn from_rest(
    chains: &[Chain],
    ratios: &[f64],
    plan: &CellPlan,
    progress: &ProgressLine,
) -> Result<Vec<Vec<RunRow>>, UserError> {
    let mut curves = Vec::new();
    for (rig, params) in chains {
        let cells = ratios.iter().map(|ratio| cell(params, *ratio));
        let cells = cells.collect::<Result<Vec<_>, _>>()?;
        let seen = lanes::run(&cells, plan)?;
        let rows = cells.iter().zip(&seen).map(|(c, s)| row(rig, c, s));
        curves.push(rows.collect());
        progress.inc(ratios.len() as u64);
    }
    Ok(curves)
}

/// Rows of one chain carried up and carried down, both by rising frequency.
type UpAndDown = (Vec<RunRow>, Vec<RunRow>);

/// All chains go side by side, up and down at once, each from where it was left at the last frequency.
fn carried(
    chains: &[Chain],
    ratios: &[f64],
    plan: &CellPlan,
    progress: &ProgressLine,
) -> Result<Vec<UpAndDown>, UserError> {
    let mut found: Vec<UpAndDown> = vec![(Vec::new(), Vec::new()); chains.len()];
    let mut last: Option<Vec<CellOutcome>> = None;
    for (up, down) in ratios.iter().zip(ratios.iter().rev()) {
        let both = chains
            .iter()
            .flat_map(|(_, params)| [(params, *up), (params, *down)]);
        let cells = both.map(|(params, ratio)| cell(params, ratio));
        let mut cells = cells.collect::<Result<Vec<_>, _>>()?;
        for (cell, left) in cells.iter_mut().zip(last.iter().flatten()) {
            cell.start = left.section;
        }
        let seen = lanes::run(&cells, plan)?;
        for (k, (rig, _)) in chains.iter().enumerate() {
            found[k].0.push(row(rig, &cells[2 * k], &seen[2 * k]));
            found[k]
                .1
                .push(row(rig, &cells[2 * k + 1], &seen[2 * k + 1]));
        }
        last = Some(seen);
        progress.inc(2 * chains.len() as u64);
    }
    for (_, down) in &mut found {
        down.reverse();
    }
    Ok(found)
}

/// Clearance at rest of a rig, mm.
pub fn gap_mm(params: &RigParams) -> f64 {
    tidy(params.gap_m * 1e3)
}
