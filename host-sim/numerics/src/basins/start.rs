//! Where hammers start, and what each ends in.

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use shared::model::params::RigParams;
use shared::model::regime::{MAX_PERIODS, Regime};
use shared::model::rig::Rig;

use crate::engine::{Engine, Start};
use crate::error::Error;
use crate::lanes::{self, Cell, CellOutcome, CellPlan};
use crate::progress::{Progress, step};

/// Displacement at which the usual window begins, m.
const USUAL_LOW_M: f64 = -6e-3;
/// Velocity to which the usual window reaches either way, m/s.
const USUAL_SPEED_M_PER_S: f64 = 0.15;
/// Cells run at a time by the lanes: memory is bounded by this and by what is kept of each.
const CHUNK: usize = 4096;
/// The switch model is slower: so many fewer cells are run at a time, so that an interruption is soon seen.
const SLOWER: usize = 16;

/// Cells that `engine` runs at a time, if only their last cycles are kept.
fn chunk(engine: Engine) -> usize {
    match engine {
        Engine::Event => CHUNK,
        Engine::Switch(_) => CHUNK / SLOWER,
    }
}

/// A rectangle of starts, cut into cells: a cell's start is its middle. Displacement and velocity are relative to the
/// cart (l sin θ or Δ, and its rate).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StartWindow {
    /// From and to, m.
    pub displacement_m: [f64; 2],
    /// From and to, m/s.
    pub velocity_m_per_s: [f64; 2],
    /// Into how many cells the range of displacement is cut.
    pub columns: usize,
    /// Into how many cells the range of velocity is cut.
    pub rows: usize,
}

impl StartWindow {
    /// From 6 mm out to where the surface begins, at up to 0.15 m/s either way.
    pub fn usual(params: &RigParams, columns: usize, rows: usize) -> Self {
        Self {
            displacement_m: [USUAL_LOW_M, params.gap_m],
            velocity_m_per_s: [-USUAL_SPEED_M_PER_S, USUAL_SPEED_M_PER_S],
            columns,
            rows,
        }
    }

    /// Displacement (m) and velocity (m/s) at these shares (0 to 1) of the window's width and height.
    fn at(&self, across: f64, up: f64) -> [f64; 2] {
        let between = |[from, to]: [f64; 2], share: f64| from + share * (to - from);
        [
            between(self.displacement_m, across),
            between(self.velocity_m_per_s, up),
        ]
    }

    /// The middle of every cell: rows by rising velocity, within a row by rising displacement; m and m/s.
    pub fn starts(&self) -> Vec<[f64; 2]> {
        let middle = |i: usize, of: usize| (i as f64 + 0.5) / of as f64;
        let rows = (0..self.rows).map(|row| middle(row, self.rows));
        rows.flat_map(|up| {
            (0..self.columns).map(move |column| self.at(middle(column, self.columns), up))
        })
        .collect()
    }

    /// `count` starts drawn evenly from the window, the same for the same seed; m and m/s.
    pub fn sample(&self, count: u32, seed: u64) -> Vec<[f64; 2]> {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut share = || random.random_range(0.0..1.0);
        (0..count).map(|_| self.at(share(), share())).collect()
    }
}

/// The rig, its drive and the drive phase at the start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BasinDrive {
    /// The rig, with its gap.
    pub params: RigParams,
    /// Drive frequency, Hz.
    pub frequency_hz: f64,
    /// Drive phase at the start, turns from 0 to below 1.
    pub phase: f64,
}

/// What one start ended in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fate {
    /// Displacement (m) and velocity (m/s) at the start.
    pub start: [f64; 2],
    /// The regime of the recorded cycles.
    pub regime: Regime,
    /// Mean of the section's points over one repetition, in units of A0 and A0 Ω of the rig's coordinate; none where
    /// nothing repeats.
    pub middle: Option<[f64; 2]>,
    /// Largest contact force of the recorded cycles, N.
    pub force_n: f64,
    /// Cycle after which the section had settled.
    pub settled_after: Option<u32>,
    /// Cycle of the last contact, counted from 1.
    pub last_contact: Option<u32>,
    /// Whether the fast engine handed the cell to the reference.
    pub uncertain: bool,
    /// Whether nothing repeats and the motion still changes at the end.
    pub unsettled: bool,
    /// Whether the hammer could not be followed: nothing else is then known.
    pub failed: bool,
}

impl Fate {
    fn new(start: [f64; 2], outcome: &CellOutcome, units: [f64; 2]) -> Self {
        let periods = outcome.regime.periods().map(usize::from);
        let middle = periods.and_then(|n| {
            let first = outcome.strobes.len().checked_sub(n)?;
            let points = &outcome.strobes[first..];
            let mean = |sum: f64, unit: f64| sum / (n as f64 * unit);
            Some([
                mean(points.iter().map(|s| s.q).sum(), units[0]),
                mean(points.iter().map(|s| s.v).sum(), units[1]),
            ])
        });
        Self {
            start,
            regime: outcome.regime,
            middle,
            force_n: outcome.force_n,
            settled_after: outcome.settled_after,
            last_contact: outcome.last_contact,
            uncertain: outcome.uncertain,
            unsettled: outcome.unsettled && periods.is_none(),
            failed: false,
        }
    }

    fn failed(start: [f64; 2]) -> Self {
        Self {
            start,
            regime: Regime::None,
            middle: None,
            force_n: 0.0,
            settled_after: None,
            last_contact: None,
            uncertain: false,
            unsettled: false,
            failed: true,
        }
    }

    /// Whether it still touches in the recorded cycles: the chapter's blue.
    pub fn impacts(&self) -> bool {
        self.regime != Regime::None
    }

    /// Whether it touches after `cycle`. What has settled on an orbit with contacts goes on for ever, however early its
    /// run was stopped.
    pub fn touches_after(&self, cycle: u32) -> bool {
        let for_ever = self.settled_after.is_some() && self.impacts();
        for_ever || self.last_contact.is_some_and(|last| last > cycle)
    }
}

/// What hammers released at `starts` (m and m/s, relative to the cart) end in, in order.
///
/// # Errors
/// If a start is out of the rig's reach or deep inside the surface, if a parameter, the frequency or the phase is out
/// of range, if every hammer leaves what the model describes, or if the work is interrupted.
pub fn fates(
    engine: Engine,
    drive: &BasinDrive,
    starts: &[[f64; 2]],
    cycles: u32,
    recorded: u32,
    progress: &dyn Progress,
) -> Result<Vec<Fate>, Error> {
    let plan = CellPlan {
        cycles,
        recorded,
        early: true,
        strobes: MAX_PERIODS as u32,
    };
    let scale = Rig::<f64>::new(&drive.params)?.coordinate_scale();
    let units = [scale, scale * std::f64::consts::TAU * drive.frequency_hz];
    let mut fates = Vec::with_capacity(starts.len());
    let mut why = None;
    for chunk in starts.chunks(chunk(engine)) {
        let outcomes = outcomes(engine, drive, chunk, &plan)?;
        for (start, outcome) in chunk.iter().zip(outcomes) {
            fates.push(match outcome {
                Ok(outcome) => Fate::new(*start, &outcome, units),
                Err(error @ Error::Motion(_)) => {
                    why.get_or_insert(error);
                    Fate::failed(*start)
                }
                Err(error) => return Err(error),
            });
        }
        step(progress, chunk.len() as u64)?;
    }
    if let Some(error) = why
        && fates.iter().all(|fate| fate.failed)
    {
        return Err(error);
    }
    Ok(fates)
}

/// How many of `starts` have a contact in the last `recorded` of `cycles` drive cycles, for each of several `cycles`
/// (rising), from one run each to the last of them.
///
/// # Errors
/// As [`fates`].
pub fn touching(
    engine: Engine,
    drive: &BasinDrive,
    starts: &[[f64; 2]],
    cycles: &[u32],
    recorded: u32,
    progress: &dyn Progress,
) -> Result<Vec<u64>, Error> {
    let until = cycles.last().copied().unwrap_or(0);
    let plan = CellPlan {
        cycles: until,
        recorded,
        early: true,
        strobes: until,
    };
    let mut counts = vec![0; cycles.len()];
    // Every cycle of every start is kept: few starts at a time.
    for chunk in starts.chunks(chunk(engine) / 8) {
        for outcome in outcomes(engine, drive, chunk, &plan)? {
            // One that failed touches nothing that is known.
            let Some(outcome) = lanes::or_failed(outcome)? else {
                continue;
            };
            for (count, cycle) in counts.iter_mut().zip(cycles) {
                *count += u64::from(touched(&outcome, *cycle, recorded));
            }
        }
        step(progress, chunk.len() as u64)?;
    }
    Ok(counts)
}

/// Whether `outcome`, all of whose cycles are kept, has a contact in the `recorded` cycles up to `cycle`. What was stopped
/// early goes on as it was then.
fn touched(outcome: &CellOutcome, cycle: u32, recorded: u32) -> bool {
    if cycle > outcome.cycles && outcome.regime != Regime::None {
        return true;
    }
    let range = cycle.saturating_sub(recorded) as usize..cycle as usize;
    let kept = outcome.strobes.iter().enumerate();
    let mut inside = kept.filter(|(k, _)| range.contains(k));
    inside.any(|(_, strobe)| strobe.onsets > 0 || strobe.force_n > 0.0)
}

fn outcomes(
    engine: Engine,
    drive: &BasinDrive,
    starts: &[[f64; 2]],
    plan: &CellPlan,
) -> Result<Vec<Result<CellOutcome, Error>>, Error> {
    let rig = Rig::<f64>::new(&drive.params)?;
    let omega = std::f64::consts::TAU * drive.frequency_hz;
    let cell = |start: &[f64; 2]| {
        Ok(Cell {
            params: drive.params,
            frequency_hz: drive.frequency_hz,
            start: Start::Moving(start[0], start[1]).section(&rig, omega)?,
            phase: drive.phase,
        })
    };
    let cells: Vec<Cell> = starts.iter().map(cell).collect::<Result<_, Error>>()?;
    Ok(match engine {
        Engine::Event => lanes::run_each(&cells, plan),
        Engine::Switch(_) => lanes::each_by_engine(engine, &cells, plan),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use shared::model::params::WIRES;

    #[test]
    fn cells_fill_the_window_and_start_in_their_middles() {
        let params = RigParams {
            gap_m: 2e-3,
            ..WIRES
        };
        let starts = StartWindow::usual(&params, 4, 3).starts();
        assert_eq!(starts.len(), 12);
        let close = |a: [f64; 2], b: [f64; 2]| (0..2).all(|i| (a[i] - b[i]).abs() < 1e-15);
        assert!(close(starts[0], [-5e-3, -0.1]), "{:?}", starts[0]);
        assert!(close(starts[1], [-3e-3, -0.1]));
        assert!(close(starts[4], [-5e-3, 0.0]));
        assert!(close(starts[11], [1e-3, 0.1]));
    }

    #[test]
    fn samples_lie_in_the_window_evenly_and_come_again_with_their_seed() {
        let window = StartWindow::usual(&WIRES, 1, 1);
        let sample = window.sample(4000, 3);
        assert_eq!(sample, window.sample(4000, 3));
        assert_ne!(sample, window.sample(4000, 4));
        for (i, [from, to]) in [window.displacement_m, window.velocity_m_per_s]
            .into_iter()
            .enumerate()
        {
            assert!(sample.iter().all(|s| (from..to).contains(&s[i])));
            let below = sample.iter().filter(|s| s[i] < 0.5 * (from + to)).count();
            // Five standard deviations of a binomial of 4000.
            assert!((below as f64 - 2000.0).abs() < 5.0 * 1000_f64.sqrt());
        }
    }
}
