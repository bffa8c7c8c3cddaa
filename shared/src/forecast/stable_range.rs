//! The second half of the forecast: the strongest stretch of stable 1/1, its ends, its strongest orbit, and
//! where to enter it.

use super::Target;
use super::forecaster::{Forecaster, Stage};
use super::refine::{OrbitAtFrequency, Peak, RangeEnd, is_neighbour};
use super::settle::Settled;
use crate::model::regime::Regime;

/// The stretch of stable 1/1 that holds the target.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct StableRange {
    /// First, strongest and last row.
    rows: (usize, usize, usize),
    low: Option<OrbitAtFrequency>,
    high: Option<OrbitAtFrequency>,
    doubling_hz: Option<f32>,
}

impl Forecaster {
    /// Chooses the strongest stable row and the stretch around it, and goes for its upper end.
    pub(super) fn begin_stable_range(&mut self) {
        let rows = self.forecast.rows.len();
        let force = |known: &OrbitAtFrequency| known.solution.orbit.force_n;
        let mut top: Option<(usize, f32)> = None;
        for row in 0..rows {
            let Some(known) = self.stable(row) else {
                continue;
            };
            if top.is_none_or(|(_, strongest)| force(&known) > strongest) {
                top = Some((row, force(&known)));
            }
        }
        let Some((top, _)) = top else {
            return self.finish();
        };
        let (mut first, mut last) = (top, top);
        while first > 0 && self.joined(first - 1) {
            first -= 1;
        }
        while last + 1 < rows && self.joined(last) {
            last += 1;
        }
        self.stable_range = StableRange {
            rows: (first, top, last),
            ..StableRange::default()
        };
        match self.high_edge() {
            Some(edge) => self.follow_high(edge),
            None => {
                self.stable_range.high = self.known(last);
                self.begin_low();
            }
        }
    }

    /// The search for the upper end, from the last row of the stretch towards the next; none at the last row of all.
    fn high_edge(&self) -> Option<RangeEnd> {
        let (first, _, last) = self.stable_range.rows;
        let inside = self.known(last)?;
        if last + 1 >= self.forecast.rows.len() {
            return None;
        }
        let behind = last.checked_sub(1).filter(|row| *row >= first);
        let behind = behind.and_then(|row| self.known(row));
        let beyond = self.known(last + 1).map(|known| known.solution);
        let beyond = beyond.filter(|b| is_neighbour(b, &inside.solution));
        let hz = self.row_hz(last + 1);
        Some(RangeEnd::new(inside, behind, hz, beyond))
    }

    /// The search for the lower end, from the first row of the stretch down to the next; none at the first row of all.
    fn low_edge(&self) -> Option<RangeEnd> {
        let (first, _, last) = self.stable_range.rows;
        let inside = self.known(first)?;
        let before = first.checked_sub(1)?;
        let behind = (first < last).then(|| self.known(first + 1)).flatten();
        let beyond = self.known(before).map(|known| known.solution);
        let beyond = beyond.filter(|b| is_neighbour(b, &inside.solution));
        let hz = self.row_hz(before);
        Some(RangeEnd::new(inside, behind, hz, beyond))
    }

    /// Whether a row and the next are of one stable range.
    fn joined(&self, row: usize) -> bool {
        self.stable(row)
            .zip(self.stable(row + 1))
            .is_some_and(|(a, b)| is_neighbour(&a.solution, &b.solution))
    }

    pub(super) fn follow_high(&mut self, mut edge: RangeEnd) {
        loop {
            if let Some(hz) = edge.wanted() {
                self.stage = Stage::High(edge);
                return self.shoot_at(hz, edge.guess(hz));
            }
            // No end before the next row, whose own orbit was not found: the stretch goes on there.
            let (first, top, last) = self.stable_range.rows;
            if !edge.reaches(self.row_hz(last + 1)) {
                break;
            }
            self.put_orbit(last + 1, &edge.inside());
            let mut last = last + 1;
            while last + 1 < self.forecast.rows.len() && self.joined(last) {
                last += 1;
            }
            self.stable_range.rows = (first, top, last);
            match self.high_edge() {
                Some(next) => edge = next,
                // The last row of all.
                None => {
                    self.stable_range.high = self.known(last);
                    return self.begin_low();
                }
            }
        }
        self.stable_range.high = Some(edge.inside());
        self.stable_range.doubling_hz = edge.doubling_hz();
        self.begin_low();
    }

    fn begin_low(&mut self) {
        let (first, _, _) = self.stable_range.rows;
        match self.low_edge() {
            Some(edge) => self.follow_low(edge),
            None => {
                self.stable_range.low = self.known(first);
                self.begin_peak();
            }
        }
    }

    pub(super) fn follow_low(&mut self, mut edge: RangeEnd) {
        loop {
            if let Some(hz) = edge.wanted() {
                self.stage = Stage::Low(edge);
                return self.shoot_at(hz, edge.guess(hz));
            }
            let (first, top, last) = self.stable_range.rows;
            let before = first.checked_sub(1);
            let Some(before) = before.filter(|row| edge.reaches(self.row_hz(*row))) else {
                break;
            };
            self.put_orbit(before, &edge.inside());
            let mut first = before;
            while first > 0 && self.joined(first - 1) {
                first -= 1;
            }
            self.stable_range.rows = (first, top, last);
            match self.low_edge() {
                Some(next) => edge = next,
                // The first row of all: the stretch begins there or lower.
                None => {
                    self.stable_range.low = self.known(first);
                    return self.begin_peak();
                }
            }
        }
        self.stable_range.low = Some(edge.inside());
        self.begin_peak();
    }

    fn begin_peak(&mut self) {
        let (first, top, last) = self.stable_range.rows;
        let low = if top > first {
            self.known(top - 1)
        } else {
            self.stable_range.low
        };
        let high = if top < last {
            self.known(top + 1)
        } else {
            self.stable_range.high
        };
        match (low, self.known(top), high) {
            (Some(low), Some(top), Some(high)) => self.follow_peak(Peak::new(low, top, high)),
            _ => self.finish(),
        }
    }

    pub(super) fn follow_peak(&mut self, peak: Peak) {
        if let Some(hz) = peak.wanted() {
            self.stage = Stage::Peak(peak);
            return self.shoot_at(hz, peak.guess(hz));
        }
        let best = peak.best();
        let (low, high) = (self.stable_range.low, self.stable_range.high);
        self.forecast.target = Some(Target {
            frequency_hz: best.hz,
            orbit: best.solution.orbit,
            band_hz: (
                low.map_or(best.hz, |known| known.hz),
                high.map_or(best.hz, |known| known.hz),
            ),
            doubling_hz: self.stable_range.doubling_hz,
            entry_hz: best.hz,
        });
        self.stage = Stage::Entry;
        self.settle_at(best.hz);
    }

    /// The run from rest at the target has ended: enter there, or at the nearest row of the stretch that
    /// rest leads to 1/1, or at least to strike.
    pub(super) fn enter(&mut self, settled: &Settled) {
        let (first, top, last) = self.stable_range.rows;
        if !settled.regime.is(1, 1) {
            let nearest = |wanted: &dyn Fn(Regime) -> bool| {
                let rows = self.forecast.rows.iter().enumerate();
                rows.filter(|(i, row)| (first..=last).contains(i) && wanted(row.regime))
                    .min_by_key(|(i, _)| i.abs_diff(top))
                    .map(|(_, row)| row.frequency_hz)
            };
            let entry = nearest(&|regime| regime.is(1, 1))
                .or_else(|| nearest(&|regime| regime != Regime::None));
            if let (Some(hz), Some(target)) = (entry, &mut self.forecast.target) {
                target.entry_hz = hz;
            }
        }
        self.finish();
    }
}
