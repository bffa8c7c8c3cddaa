//! What the scope of the page shows: the last seconds of every tick, blow by blow, and their spectra.

mod blows;
mod fft;

use shared::io::{AdcCode, Channel};
use shared::link::RecordedBlock;
use shared::model::params::WIRES;
use shared::settings::{Settings, TICK_RATE_HZ, TICK_S};

use blows::Blows;
pub use blows::MeasuredBlow;

/// Ticks kept: 13 s.
const KEPT: usize = 1 << 18;

/// Ticks in a spectrum: 3.3 s.
const WINDOW: usize = 1 << 16;

/// Signals: contact force in N, hammer and cart in mm.
const SIGNALS: usize = 3;

/// The last seconds of a board's signals.
#[derive(Debug)]
pub struct Scope {
    channels: [Channel; SIGNALS],
    /// Each signal, tick t at t modulo [`KEPT`]; what did not come is not a number.
    kept: [Vec<f32>; SIGNALS],
    /// The first tick of the board's that came, and how many ticks have passed since.
    first: Option<u32>,
    passed: u64,
    gaps: u32,
    lost: u64,
    blows: Blows,
}

impl Default for Scope {
    fn default() -> Self {
        Self::new()
    }
}

impl Scope {
    /// Nothing has come yet.
    pub fn new() -> Self {
        let settings = Settings::for_rig(&WIRES);
        Self {
            channels: [settings.force, settings.hammer, settings.cart],
            kept: [(); SIGNALS].map(|()| vec![f32::NAN; KEPT]),
            first: None,
            passed: 0,
            gaps: 0,
            lost: 0,
            blows: Blows::new(&settings.detection),
        }
    }

    /// The calibration of what comes.
    pub fn calibrate(&mut self, settings: &Settings) {
        self.channels = [settings.force, settings.hammer, settings.cart];
        self.blows = Blows::new(&settings.detection);
    }

    /// Gaps in the ticks so far.
    pub fn gaps(&self) -> u32 {
        self.gaps
    }

    /// Ticks missing in the gaps so far.
    pub fn lost_ticks(&self) -> u64 {
        self.lost
    }

    /// The last blows, oldest first.
    pub fn blows(&self) -> impl Iterator<Item = &MeasuredBlow> {
        self.blows.last()
    }

    /// Takes a block; ticks between it and the one before are a gap.
    pub fn feed(&mut self, block: &RecordedBlock) {
        let first = *self.first.get_or_insert(block.tick);
        let expected = first.wrapping_add(self.passed as u32);
        let missing = block.tick.wrapping_sub(expected);
        if missing > u32::MAX / 2 {
            // The board counts anew.
            self.first = Some(block.tick.wrapping_sub(self.passed as u32));
        } else if missing > 0 {
            self.gaps += 1;
            self.lost += u64::from(missing);
            self.blows.interrupt();
            for _ in 0..(missing as usize).min(KEPT) {
                self.keep([f32::NAN; SIGNALS]);
            }
            self.passed += u64::from(missing).saturating_sub(KEPT as u64);
        }
        for (frame, output) in block.frames.iter().zip(&block.outputs) {
            let value = |signal: usize, code: AdcCode| self.channels[signal].value(code);
            let values = [
                value(0, frame.force),
                1e3 * value(1, frame.hammer),
                1e3 * value(2, frame.cart),
            ];
            let time_s = self.board_s(self.passed as i64);
            let hz = if output.enable {
                output.frequency_hz
            } else {
                0.0
            };
            self.blows.tick(time_s, values[0], values[2], hz);
            self.keep(if block.notes.stale {
                [f32::NAN; SIGNALS]
            } else {
                values
            });
        }
    }

    fn keep(&mut self, values: [f32; SIGNALS]) {
        let at = self.passed as usize % KEPT;
        for (kept, value) in self.kept.iter_mut().zip(values) {
            kept[at] = value;
        }
        self.passed += 1;
    }

    /// The board's time, as its status and its events have it, `passed` ticks after the first that came, s.
    fn board_s(&self, passed: i64) -> f64 {
        let newest = self.first.unwrap_or(0).wrapping_add(self.passed as u32);
        (f64::from(newest) - (self.passed as i64 - passed) as f64) * TICK_S
    }

    /// The last `seconds` in `columns`: first the board's time at the left and the right edge, s, then for each column the
    /// least and the largest force (N), hammer (mm) and cart (mm) in it; not numbers where nothing came.
    pub fn trace(&self, seconds: f64, columns: usize) -> Vec<f32> {
        let columns = columns.clamp(1, 4096);
        let ticks = (seconds * f64::from(TICK_RATE_HZ)).clamp(1.0, KEPT as f64) as u64;
        let end = self.passed as i64;
        let begin = end - ticks as i64;
        let second = |tick: i64| self.board_s(tick) as f32;
        let mut out = vec![second(begin), second(end)];
        for column in 0..columns as i64 {
            let edge = |at: i64| begin + at * ticks as i64 / columns as i64;
            let (from, to) = (edge(column), edge(column + 1).max(edge(column) + 1));
            for kept in &self.kept {
                let [mut least, mut largest] = [f32::NAN; 2];
                for tick in from.max(0)..to.min(end) {
                    let value = kept[tick as usize % KEPT];
                    least = least.min(value);
                    largest = largest.max(value);
                }
                out.extend([least, largest]);
            }
        }
        out
    }

    /// The amplitude of a signal over frequency, from the last 3.3 s under a Hann window: first the step of frequency, Hz,
    /// then the amplitude at 0, 1, 2 … steps up to `max_hz`. Only the step where not so much has come without a gap.
    pub fn spectrum(&self, signal: usize, max_hz: f64) -> Vec<f32> {
        let step = f64::from(TICK_RATE_HZ) / WINDOW as f64;
        let mut out = vec![step as f32];
        let Some(kept) = self.kept.get(signal) else {
            return out;
        };
        let Some(begin) = self.passed.checked_sub(WINDOW as u64) else {
            return out;
        };
        let values: Vec<f64> = (begin..self.passed)
            .map(|tick| f64::from(kept[tick as usize % KEPT]))
            .collect();
        if values.iter().any(|value| value.is_nan()) {
            return out;
        }
        let most = ((max_hz / step) as usize + 1).min(WINDOW / 2);
        out.extend(fft::amplitudes(&values).take(most).map(|a| a as f32));
        out
    }
}

#[cfg(test)]
mod tests;
