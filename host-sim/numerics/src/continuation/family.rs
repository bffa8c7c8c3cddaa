//! The equations of a curve of orbits: the section repeats, and one step along the curve has been taken.

use std::f64::consts::TAU;

use nalgebra::{Matrix5, Vector5};
use shared::model::params::{ParamError, RigParams};
use shared::model::rig::Rig;

use crate::knob::Knob;
use crate::orbit::{CLOSURE, Exactness, Orbit, ReturnMapImage, Section, carried, largest};

/// What is varied along a curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Along {
    /// The drive frequency; the gap is the rig's. The parameter is Ω/ω.
    Frequency,
    /// The gap at this drive frequency, Hz. The parameter is gap/A0.
    Gap(f64),
    /// A number of the rig. The parameter is its value over `unit`.
    Rig {
        /// Number of the rig that is varied.
        knob: Knob,
        /// One of the parameter, in the unit of the knob's name.
        unit: f64,
        /// Drive frequency while that number varies.
        drive: FamilyDrive,
    },
}

/// The drive frequency of a rig whose numbers vary.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FamilyDrive {
    /// This frequency whatever the rig, Hz.
    Hz(f64),
    /// This many times the rig's natural frequency, Ω/ω.
    Ratio(f64),
}

impl FamilyDrive {
    /// The frequency of a rig, Hz.
    pub fn hz(self, params: &RigParams) -> f64 {
        match self {
            Self::Hz(hz) => hz,
            Self::Ratio(ratio) => ratio * params.natural_frequency_hz(),
        }
    }
}

/// A place on a curve: coordinate over 5 A0 and rate over 5 A0 ω (as a displacement and a velocity), the parameter, and
/// deviation and rate of the cart in the same units as the hammer's (0 with a prescribed cart). In these units the curves
/// of a hammer that rebounds by some ten A0 are of order one in every direction.
pub type CurvePlace = [f64; 5];

/// Where the parameter stands in a [`CurvePlace`], and the place of each coordinate of the section.
const PARAMETER: usize = 2;
const COORDINATES: [usize; 4] = [0, 1, 3, 4];

/// The direction in which only the parameter grows.
pub const UP: CurvePlace = [0.0, 0.0, 1.0, 0.0, 0.0];

/// A0 (or A0 ω) per unit of [`CurvePlace`].
const AMPLITUDES: f64 = 5.0;

/// Newton steps of one correction.
const ITERATIONS: usize = 9;

/// An orbit is also found when Newton's step is shorter than this, in units of [`CurvePlace`] ...
const STILL: f64 = 2e-11;

/// ... and the return map moves it by less than this, in A0 and A0 Ω.
const LOOSE: f64 = 1e-7;

/// The longest correction to a guess that is believed, in units of [`CurvePlace`].
const FARTHEST: f64 = 0.5;

/// Difference of the parameter from which the derivative by it is taken. Near a graze the map bends within some 1e-7.
/// The map is good to some 1e-12, so the derivative is to 1e-4: that sets the direction of a step and how fast Newton's
/// iteration converges, and not where it ends.
const DIFFERENCE: f64 = 1e-8;

/// The orbits of one rig that repeat after some periods, over one parameter.
#[derive(Clone, Copy, Debug)]
pub struct Family {
    params: RigParams,
    along: Along,
    periods: u8,
    units: Section,
}

/// An orbit on a curve.
#[derive(Clone, Debug, PartialEq)]
pub struct Node {
    /// The periodic orbit at this place.
    pub orbit: Orbit,
    /// The rig's gap, m.
    pub gap_m: f64,
    /// Where on the curve.
    pub place: CurvePlace,
    /// The curve's direction there, of length 1.
    pub tangent: CurvePlace,
    /// What is special about it.
    pub special: Option<super::Special>,
}

impl Node {
    /// Value of the parameter: Ω/ω, gap/A0, or a number of the rig over its unit.
    pub fn parameter(&self) -> f64 {
        self.place[PARAMETER]
    }

    /// This node with its tangent reversed, to follow the curve the other way.
    #[must_use]
    pub fn turned(mut self) -> Self {
        self.tangent = self.tangent.map(|t| -t);
        self
    }
}

impl Family {
    /// Orbits of `periods` drive periods.
    ///
    /// # Errors
    /// If a parameter is out of range: the first of them.
    pub fn new(params: &RigParams, along: Along, periods: u8) -> Result<Self, ParamError> {
        Ok(Self {
            params: *params,
            along,
            periods,
            units: units(params)?,
        })
    }

    /// The family of orbits of `periods` drive periods, for this rig and parameter.
    #[must_use]
    pub fn with_periods(mut self, periods: u8) -> Self {
        self.periods = periods;
        self
    }

    /// Drive periods of its orbits.
    pub fn periods(&self) -> u8 {
        self.periods
    }

    /// Parameter that is varied along the curves.
    pub fn along(&self) -> Along {
        self.along
    }

    /// The rig and drive frequency (Hz) at a value of the parameter.
    pub fn at(&self, parameter: f64) -> (RigParams, f64) {
        match self.along {
            Along::Frequency => (self.params, parameter * self.params.natural_frequency_hz()),
            Along::Gap(frequency_hz) => {
                let gap_m = parameter * self.params.amplitude_m;
                let params = RigParams {
                    gap_m,
                    ..self.params
                };
                (params, frequency_hz)
            }
            Along::Rig { knob, unit, drive } => {
                // A rig without this number stays as it is; the caller has asked for one that has it.
                let params = knob.set(&self.params, parameter * unit);
                let params = params.unwrap_or(self.params);
                (params, drive.hz(&params))
            }
        }
    }

    /// Coordinates of the section that vary: 2, or 4 with a cart that recoils.
    fn dimensions(&self) -> usize {
        if self.params.cart.recoils() { 4 } else { 2 }
    }

    /// The section point of a place, in the rig's coordinate.
    fn section(&self, place: &CurvePlace) -> Section {
        [0, 1, 2, 3].map(|i| place[COORDINATES[i]] * self.units[i])
    }

    /// The place of a section point at a value of the parameter.
    pub fn place(&self, section: Section, parameter: f64) -> CurvePlace {
        let [q, v, e, w] = [0, 1, 2, 3].map(|i| section[i] / self.units[i]);
        [q, v, parameter, e, w]
    }

    /// A direction in the section, given in units of A0 and A0 Ω at a node, as a direction in places.
    pub fn direction(&self, node: &Node, plane: Section) -> CurvePlace {
        let share = node.orbit.frequency_hz / self.params.natural_frequency_hz();
        let [q, v, e, w] = plane;
        normalised([q, v * share, 0.0, e, w * share])
    }

    /// The orbit at a value of the parameter near a section point, with the curve's direction there towards larger
    /// values of the parameter.
    pub fn node_at(&self, parameter: f64, section: Section) -> Option<Node> {
        self.correct(self.place(section, parameter), UP)
    }

    /// The orbit in the plane through `guess` normal to `direction`; its tangent points along `direction`.
    pub fn correct(&self, guess: CurvePlace, direction: CurvePlace) -> Option<Node> {
        let mut place = guess;
        for _ in 0..ITERATIONS {
            let (params, frequency_hz) = self.at(place[PARAMETER]);
            if frequency_hz <= 0.0 {
                return None;
            }
            let section = self.section(&place);
            let image = ReturnMapImage::of(
                Exactness::FULL,
                &params,
                frequency_hz,
                section,
                self.periods,
            )?;
            let miss = image.miss(section);
            if !largest(miss).is_finite() {
                return None;
            }
            let rows = self.rows(&image, &place)?;
            let off = dot(direction, minus(place, guess));
            let step = self.solve(&rows, &direction, miss.map(|m| -m), -off);
            let closed = largest(miss);
            // A nearly grazing contact magnifies the grain of the map a thousandfold, and not that of the orbit.
            let at_rest = step.is_some_and(|s| dot(s, s).sqrt() < STILL);
            if closed < CLOSURE || (closed < LOOSE && at_rest) {
                let mut tangent = self.tangent(&rows, &direction)?;
                if dot(tangent, direction) < 0.0 {
                    tangent = tangent.map(|t| -t);
                }
                return Some(Node {
                    orbit: image.orbit(frequency_hz, section)?,
                    gap_m: params.gap_m,
                    place,
                    tangent,
                    special: None,
                });
            }
            let step = step?;
            for i in 0..5 {
                place[i] += step[i];
            }
            let moved = minus(place, guess);
            let far = dot(moved, moved).sqrt();
            if far.is_nan() || far > FARTHEST {
                return None;
            }
        }
        None
    }

    /// The derivatives of the miss (in units of A0 and A0 Ω) by the place.
    fn rows(&self, image: &ReturnMapImage, place: &CurvePlace) -> Option<[CurvePlace; 4]> {
        let monodromy = image.monodromy;
        let section = self.section(place);
        let turns = (0.0, f64::from(self.periods));
        let ahead = place[PARAMETER] + DIFFERENCE;
        let (params, frequency_hz) = self.at(ahead);
        let there = carried(&params, frequency_hz, section, turns, &mut ())?;
        let miss = image.miss(section);
        Some([0, 1, 2, 3].map(|i| {
            let by = |j: usize| {
                let own = if i == j { 1.0 } else { 0.0 };
                (monodromy.entry(i, j) - own) * self.units[j] / image.units[j]
            };
            let moved = (there[i] - section[i]) / image.units[i];
            [by(0), by(1), (moved - miss[i]) / DIFFERENCE, by(2), by(3)]
        }))
    }

    /// The step with which the rows give `right` and that goes `along` in `direction`.
    fn solve(
        &self,
        rows: &[CurvePlace; 4],
        direction: &CurvePlace,
        right: Section,
        along: f64,
    ) -> Option<CurvePlace> {
        if self.dimensions() == 2 {
            let three = |row: &CurvePlace| [row[0], row[1], row[PARAMETER]];
            let system = [three(&rows[0]), three(&rows[1]), three(direction)];
            let [q, v, parameter] = solve3(system, [right[0], right[1], along])?;
            return Some([q, v, parameter, 0.0, 0.0]);
        }
        let mut matrix = Matrix5::zeros();
        for (i, row) in rows.iter().chain([direction]).enumerate() {
            matrix.set_row(i, &(*row).into());
        }
        let [a, b, c, d] = right;
        let step = matrix.lu().solve(&Vector5::from([a, b, c, d, along]))?;
        step.iter().all(|x| x.is_finite()).then(|| step.into())
    }

    /// The curve's direction, of length 1: along it the rows give nothing.
    fn tangent(&self, rows: &[CurvePlace; 4], direction: &CurvePlace) -> Option<CurvePlace> {
        if self.dimensions() == 2 {
            let three = |row: &CurvePlace| [row[0], row[1], row[PARAMETER]];
            let [q, v, parameter] = cross(three(&rows[0]), three(&rows[1]));
            return Some(normalised([q, v, parameter, 0.0, 0.0]));
        }
        let along = self.solve(rows, direction, [0.0; 4], 1.0)?;
        Some(normalised(along))
    }
}

/// What a section point is measured in along a curve: in so many A0 (and A0 ω).
///
/// # Errors
/// If a parameter is out of range: the first of them.
pub(super) fn units(params: &RigParams) -> Result<Section, ParamError> {
    let scale = AMPLITUDES * Rig::<f64>::new(params)?.coordinate_scale();
    let metres = AMPLITUDES * params.amplitude_m;
    let rate = |unit: f64| unit * (TAU * params.natural_frequency_hz());
    Ok([scale, rate(scale), metres, rate(metres)])
}

/// Scalar product of two places or directions.
pub fn dot(a: CurvePlace, b: CurvePlace) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + (a[3] * b[3] + a[4] * b[4])
}

/// The difference a − b of two places.
pub fn minus(a: CurvePlace, b: CurvePlace) -> CurvePlace {
    [0, 1, 2, 3, 4].map(|i| a[i] - b[i])
}

/// The place `step` from `from` along `direction`.
pub fn ahead(from: CurvePlace, step: f64, direction: CurvePlace) -> CurvePlace {
    [0, 1, 2, 3, 4].map(|i| from[i] + step * direction[i])
}

/// The place the fraction `s` of the way from a to b.
pub fn between(a: CurvePlace, b: CurvePlace, s: f64) -> CurvePlace {
    [0, 1, 2, 3, 4].map(|i| a[i] + s * (b[i] - a[i]))
}

/// `a` made of length 1.
pub fn normalised(a: CurvePlace) -> CurvePlace {
    let length = dot(a, a).sqrt();
    a.map(|x| x / length)
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

/// Solves three linear equations, given their rows, by Cramer's rule.
fn solve3(rows: [[f64; 3]; 3], right: [f64; 3]) -> Option<[f64; 3]> {
    let [a, b, c] = rows;
    let (bc, ca, ab) = (cross(b, c), cross(c, a), cross(a, b));
    let determinant = a[0] * bc[0] + a[1] * bc[1] + a[2] * bc[2];
    let x =
        [0, 1, 2].map(|i| (right[0] * bc[i] + right[1] * ca[i] + right[2] * ab[i]) / determinant);
    x.iter().all(|x| x.is_finite()).then_some(x)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn three_equations_are_solved() {
        let rows = [[2.0, -1.0, 0.5], [0.0, 3.0, 1.0], [1.0, 1.0, -4.0]];
        let x = [0.3, -2.0, 1.5];
        let found = solve3(
            rows,
            rows.map(|row: [f64; 3]| (0..3).map(|i| row[i] * x[i]).sum()),
        )
        .unwrap();
        for i in 0..3 {
            assert!((found[i] - x[i]).abs() < 1e-14);
        }
        assert_eq!(solve3([[1.0; 3]; 3], x), None);
    }
}
