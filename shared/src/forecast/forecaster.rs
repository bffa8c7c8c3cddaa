//! The forecast in slices: the order of the runs, and the use of their results.
//!
//! Rows are worked off by rising frequency: what rest settles to, then the 1/1 orbit, from there or from
//! the rows before. A second pass, downwards, looks for orbits that rest does not lead to, from the row
//! above. Then the strongest stretch of stable 1/1 is followed to its ends, and its strongest orbit found.

use super::march::{ForecastModel, ForecastSection};
use super::refine::{OrbitAtFrequency, Peak, RangeEnd, between, on_line};
use super::settle::{Settle, Settled};
use super::shoot::{Shoot, Shooting, Solution};
use super::stable_range::StableRange;
use super::{Forecast, ForecastRequest, ForecastRow, MAX_ROWS};
use crate::model::regime::Regime;

/// A run that ends this close to a stable 1/1 (in A0 and A0 Ω) is settling on it, however slowly.
const NEAR_THE_ORBIT: f32 = 0.05;

/// The run under way.
#[derive(Clone, Copy, Debug)]
enum Run {
    Nothing,
    /// From rest at a frequency, to be set up in the next slice.
    ToSettle(f32),
    /// Shooting at a frequency from a guess, to be set up in the next slice.
    ToShoot(f32, ForecastSection),
    Settle(Settle),
    Shoot(Shoot, f32),
}

/// The purpose of the run.
#[derive(Clone, Copy, Debug)]
pub(super) enum Stage {
    Done,
    /// From rest at a row.
    Rest(usize),
    /// The orbit of a row, the n-th guess.
    Orbit(usize, u8),
    /// The orbit of a row on the way down, the n-th guess.
    Down(usize, u8),
    /// The upper end of the stable 1/1.
    High(RangeEnd),
    /// The lower end of the stable 1/1.
    Low(RangeEnd),
    /// The strongest orbit of the stable 1/1.
    Peak(Peak),
    /// From rest at the target.
    Entry,
}

/// What remains of a request beside its model.
#[derive(Clone, Copy, Debug)]
struct Asked {
    range_hz: (f32, f32),
    rows: u8,
}

/// Computes a [`Forecast`] in slices of bounded work.
#[derive(Clone, Debug)]
pub struct Forecaster {
    asked: Option<Asked>,
    pub(super) model: Option<ForecastModel>,
    pub(super) forecast: Forecast,
    /// Section points of the rows' orbits, where there is one.
    sections: [ForecastSection; MAX_ROWS],
    settled: Option<Settled>,
    pub(super) stable_range: StableRange,
    pub(super) stage: Stage,
    run: Run,
}

impl Default for Forecaster {
    fn default() -> Self {
        Self::new()
    }
}

impl Forecaster {
    /// A forecaster without a request.
    pub fn new() -> Self {
        Self {
            asked: None,
            model: None,
            forecast: Forecast::default(),
            sections: [[0.0; 4]; MAX_ROWS],
            settled: None,
            stable_range: StableRange::default(),
            stage: Stage::Done,
            run: Run::Nothing,
        }
    }

    /// Starts on `request` and abandons any other. An invalid request (a rig out of range, an empty frequency
    /// range) is answered with no rows and no target.
    pub fn start(&mut self, request: &ForecastRequest) {
        self.asked = Some(Asked {
            range_hz: request.range_hz,
            rows: request.rows,
        });
        self.forecast.id = request.id;
        self.forecast.rows.clear();
        self.forecast.target = None;
        self.stable_range = StableRange::default();
        let (low, high) = request.range_hz;
        let good = low > 0.0 && high > low && high.is_finite();
        self.model = ForecastModel::new(&request.rig).ok();
        if good && self.model.is_some() {
            self.rest(0);
        } else {
            self.finish();
        }
    }

    /// The forecast, if it is done.
    pub fn result(&self) -> Option<&Forecast> {
        let done = matches!(self.stage, Stage::Done) && self.asked.is_some();
        done.then_some(&self.forecast)
    }

    /// One slice of work: one step of the run under way. Returns whether there is more to do.
    pub fn slice(&mut self) -> bool {
        match &mut self.run {
            Run::Nothing => {}
            Run::ToSettle(hz) => {
                let hz = *hz;
                match self.model.as_ref().and_then(|m| Settle::new(m, hz)) {
                    Some(run) => self.run = Run::Settle(run),
                    None => self.finish(),
                }
            }
            Run::ToShoot(hz, guess) => {
                let (hz, guess) = (*hz, *guess);
                match self.model.as_ref().and_then(|m| Shoot::new(m, hz, guess)) {
                    Some(run) => self.run = Run::Shoot(run, hz),
                    None => self.finish(),
                }
            }
            Run::Settle(run) => {
                if let Some(settled) = run.step() {
                    self.settled(settled);
                }
            }
            Run::Shoot(run, hz) => {
                let hz = *hz;
                let progress = match &self.model {
                    Some(model) => run.step(model),
                    None => Shooting::Lost,
                };
                match progress {
                    Shooting::Working => {}
                    Shooting::Found(solution) => self.shot(hz, Some(solution)),
                    Shooting::Lost => self.shot(hz, None),
                }
            }
        }
        !matches!(self.stage, Stage::Done)
    }

    fn rows(&self) -> usize {
        let asked = self.asked.as_ref().map_or(0, |r| usize::from(r.rows));
        asked.clamp(2, MAX_ROWS)
    }

    pub(super) fn row_hz(&self, row: usize) -> f32 {
        let (low, high) = self.asked.as_ref().map_or((0.0, 0.0), |r| r.range_hz);
        let last = self.rows() - 1;
        if row >= last {
            return high;
        }
        low + (high - low) * (row as f32 / last as f32)
    }

    /// The 1/1 of a row.
    pub(super) fn known(&self, row: usize) -> Option<OrbitAtFrequency> {
        let found = self.forecast.rows.get(row)?;
        Some(OrbitAtFrequency {
            hz: found.frequency_hz,
            solution: Solution {
                section: *self.sections.get(row)?,
                onsets: 1,
                orbit: found.orbit?,
            },
        })
    }

    pub(super) fn stable(&self, row: usize) -> Option<OrbitAtFrequency> {
        self.known(row)
            .filter(|known| known.solution.is_stable_one_one())
    }

    /// Runs from rest at a row.
    fn rest(&mut self, row: usize) {
        self.stage = Stage::Rest(row);
        self.settle_at(self.row_hz(row));
    }

    pub(super) fn settle_at(&mut self, hz: f32) {
        self.run = Run::ToSettle(hz);
    }

    pub(super) fn shoot_at(&mut self, hz: f32, guess: ForecastSection) {
        self.run = Run::ToShoot(hz, guess);
    }

    pub(super) fn finish(&mut self) {
        self.stage = Stage::Done;
        self.run = Run::Nothing;
    }

    /// A run from rest has ended.
    fn settled(&mut self, settled: Settled) {
        match self.stage {
            Stage::Rest(row) => {
                let frequency_hz = self.row_hz(row);
                let full = self.forecast.rows.push(ForecastRow {
                    frequency_hz,
                    regime: settled.regime,
                    force_n: settled.force_n,
                    orbit: None,
                });
                if full.is_err() {
                    return self.finish();
                }
                self.settled = Some(settled);
                self.next_guess(row, 0);
            }
            Stage::Entry => self.enter(&settled),
            _ => self.finish(),
        }
    }

    /// Shoots from the next guess there is for a row, or goes on.
    fn next_guess(&mut self, row: usize, from: u8) {
        let hz = self.row_hz(row);
        let guess = (from..3).find_map(|n| Some((n, self.upward_guess(row, n, hz)?)));
        match guess {
            Some((n, guess)) => {
                self.stage = Stage::Orbit(row, n);
                self.shoot_at(hz, guess);
            }
            None if row + 1 < self.rows() => self.rest(row + 1),
            None => self.next_down(row),
        }
    }

    /// The guesses on the way up: what rest settled to if that is 1/1; the rows before; the middle of a
    /// doubled orbit.
    fn upward_guess(&self, row: usize, n: u8, hz: f32) -> Option<ForecastSection> {
        let settled = self.settled?;
        let before = row.checked_sub(1).and_then(|row| self.known(row));
        match n {
            0 => settled.regime.is(1, 1).then_some(settled.section),
            1 => {
                let last = before?;
                let earlier = row.checked_sub(2).and_then(|row| self.known(row));
                Some(match earlier {
                    Some(earlier) => on_line(&earlier, &last, hz),
                    None => last.solution.section,
                })
            }
            _ => {
                let doubled = settled.regime.is(2, 2);
                doubled.then(|| between(settled.before, settled.section, 0.5))
            }
        }
    }

    /// Looks below `row` for the next row without an orbit whose upper neighbour has one.
    fn next_down(&mut self, row: usize) {
        for row in (0..row).rev() {
            let lacks = self.known(row).is_none();
            if lacks && let Some(above) = self.known(row + 1) {
                self.stage = Stage::Down(row, 0);
                let hz = self.row_hz(row);
                let guess = match self.known(row + 2) {
                    Some(higher) => on_line(&higher, &above, hz),
                    None => above.solution.section,
                };
                return self.shoot_at(hz, guess);
            }
        }
        self.begin_stable_range();
    }

    /// A shooting has ended.
    fn shot(&mut self, hz: f32, found: Option<Solution>) {
        match self.stage {
            Stage::Orbit(row, n) => {
                let known = self.enter_orbit(row, found);
                self.next_guess(row, if known { 3 } else { n + 1 });
            }
            Stage::Down(row, n) => {
                if !self.enter_orbit(row, found)
                    && n == 0
                    && let Some(above) = self.known(row + 1)
                {
                    self.stage = Stage::Down(row, 1);
                    return self.shoot_at(hz, above.solution.section);
                }
                self.next_down(row);
            }
            Stage::High(mut edge) => {
                edge.take(hz, found);
                self.follow_high(edge);
            }
            Stage::Low(mut edge) => {
                edge.take(hz, found);
                self.follow_low(edge);
            }
            Stage::Peak(mut peak) => {
                peak.take(hz, found);
                self.follow_peak(peak);
            }
            Stage::Done | Stage::Rest(_) | Stage::Entry => self.finish(),
        }
    }

    /// Enters a row's orbit if it is a 1/1; returns whether it is.
    fn enter_orbit(&mut self, index: usize, found: Option<Solution>) -> bool {
        let Some(solution) = found else { return false };
        let Some(orbit) = solution.one_one() else {
            return false;
        };
        let near = self
            .settled
            .is_some_and(|settled| self.is_near(&settled, &solution, index));
        let upward = matches!(self.stage, Stage::Orbit(..));
        let (Some(row), Some(section)) = (
            self.forecast.rows.get_mut(index),
            self.sections.get_mut(index),
        ) else {
            return false;
        };
        row.orbit = Some(orbit);
        *section = solution.section;
        if upward && near && orbit.is_stable() {
            row.regime = Regime::Periodic {
                impacts: 1,
                periods: 1,
            };
        }
        true
    }

    /// Gives a row without an orbit, or with another, the orbit found beside it.
    pub(super) fn put_orbit(&mut self, index: usize, known: &OrbitAtFrequency) {
        let row = self.forecast.rows.get_mut(index);
        if let (Some(row), Some(section)) = (row, self.sections.get_mut(index)) {
            row.orbit = Some(known.solution.orbit);
            *section = known.solution.section;
        }
    }

    /// Whether a run ended close to an orbit.
    fn is_near(&self, settled: &Settled, solution: &Solution, row: usize) -> bool {
        let Some(model) = &self.model else {
            return false;
        };
        let omega = core::f32::consts::TAU * self.row_hz(row);
        let scale = model.rig.coordinate_scale();
        let ([q0, v0, ..], [q1, v1, ..]) = (settled.section, solution.section);
        libm::fabsf(q1 - q0) < NEAR_THE_ORBIT * scale
            && libm::fabsf(v1 - v0) < NEAR_THE_ORBIT * scale * omega
    }
}
