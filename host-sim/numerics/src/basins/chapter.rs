//! The twelve points whose basins the chapter shows.

use shared::model::params::preset;

use super::BasinsRequest;
use crate::error::Error;
use crate::row::NamedRig;

/// One point: its figure, part, preset, Ω/ω and gap/A0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChapterBasin {
    /// The chapter's number of the figure.
    pub figure: &'static str,
    /// Part of the figure, "a" or "b".
    pub part: &'static str,
    /// Preset of the rig.
    pub rig: &'static str,
    /// Drive frequency over the natural frequency, Ω/ω.
    pub ratio: f64,
    /// Clearance at rest over the cart's amplitude, gap/A0.
    pub gap_over_amplitude: f64,
}

const fn point(
    figure: &'static str,
    part: &'static str,
    rig: &'static str,
    ratio: f64,
    gap_over_amplitude: f64,
) -> ChapterBasin {
    ChapterBasin {
        figure,
        part,
        rig,
        ratio,
        gap_over_amplitude,
    }
}

/// Figures 3.36–3.38 and 3.52–3.54, as their captions give them.
pub const POINTS: [ChapterBasin; 12] = [
    point("3.36", "a", "wires", 2.00, 2.00),
    point("3.36", "b", "wires", 2.00, 1.50),
    point("3.37", "a", "wires", 1.75, 2.50),
    point("3.37", "b", "wires", 1.75, 3.50),
    point("3.38", "a", "wires", 2.15, 1.60),
    point("3.38", "b", "wires", 2.25, 1.50),
    point("3.52", "a", "beam-170", 1.80, 1.60),
    point("3.52", "b", "beam-170", 2.20, 1.50),
    point("3.53", "a", "beam-150", 1.80, 1.74),
    point("3.53", "b", "beam-150", 2.10, 1.40),
    point("3.54", "a", "beam-135", 2.15, 1.60),
    point("3.54", "b", "beam-135", 2.25, 1.50),
];

impl ChapterBasin {
    /// The question the figure answers, on a grid of `columns` by `rows`.
    ///
    /// # Errors
    /// If there is no such preset, which no point of [`POINTS`] names.
    pub fn query(&self, columns: usize, rows: usize) -> Result<BasinsRequest, Error> {
        let params = preset(self.rig).ok_or_else(|| Error::Preset(self.rig.to_owned()))?;
        let mut rig = NamedRig::new(self.rig.to_owned(), params);
        rig.params.gap_m = self.gap_over_amplitude * params.amplitude_m;
        let frequency_hz = self.ratio * params.natural_frequency_hz();
        Ok(BasinsRequest::usual(rig, frequency_hz, columns, rows))
    }
}
