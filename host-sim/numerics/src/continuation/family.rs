//! The equations of a curve of orbits: the section repeats, and one step along the curve has been taken.

use std::f64::consts::TAU;

use shared::model::params::RigParams;
use shared::model::rig::Rig;

use crate::orbit::{CLOSURE, Image, Orbit, after_periods};

/// What is varied along a curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Along {
    /// The drive frequency; the gap is the rig's. The parameter is Ω/ω.
    Frequency,
    /// The gap at this drive frequency, Hz. The parameter is gap/A0.
    Gap(f64),
}

/// A place on a curve: coordinate over 5 A0 and rate over 5 A0 ω (as a displacement and a velocity), and the
/// parameter. In these units the curves of a hammer that rebounds by some ten A0 are of order one in every direction.
pub type Place = [f64; 3];

/// A0 (or A0 ω) per unit of [`Place`].
const AMPLITUDES: f64 = 5.0;

/// Newton steps of one correction.
const ITERATIONS: usize = 9;

/// An orbit is also found when Newton's step is shorter than this, in units of [`Place`] ...
const STILL: f64 = 2e-11;

/// ... and the return map moves it by less than this, in A0 and A0 Ω.
const LOOSE: f64 = 1e-7;

/// The longest correction to a guess that is believed, in units of [`Place`].
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
    units: [f64; 2],
}

/// An orbit on a curve.
#[derive(Clone, Debug, PartialEq)]
pub struct Node {
    /// The orbit.
    pub orbit: Orbit,
    /// The rig's gap, m.
    pub gap_m: f64,
    /// Where on the curve.
    pub place: Place,
    /// The curve's direction there, of length 1.
    pub tangent: Place,
    /// What is special about it.
    pub special: Option<super::Special>,
}

impl Node {
    /// Ω/ω or gap/A0.
    pub fn parameter(&self) -> f64 {
        self.place[2]
    }

    /// The same node, followed the other way.
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
    pub fn new(
        params: &RigParams,
        along: Along,
        periods: u8,
    ) -> Result<Self, shared::model::params::ParamError> {
        let rig = Rig::<f64>::new(params)?;
        let scale = AMPLITUDES * rig.coordinate_scale();
        Ok(Self {
            params: *params,
            along,
            periods,
            units: [scale, scale * TAU * params.natural_frequency_hz()],
        })
    }

    /// The same rig and parameter, orbits of other length.
    #[must_use]
    pub fn with_periods(mut self, periods: u8) -> Self {
        self.periods = periods;
        self
    }

    /// Drive periods of its orbits.
    pub fn periods(&self) -> u8 {
        self.periods
    }

    /// What is varied.
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
        }
    }

    /// The section point of a place, in the rig's coordinate.
    fn section(&self, place: &Place) -> [f64; 2] {
        [0, 1].map(|i| place[i] * self.units[i])
    }

    /// The place of a section point at a value of the parameter.
    pub fn place(&self, section: [f64; 2], parameter: f64) -> Place {
        [
            section[0] / self.units[0],
            section[1] / self.units[1],
            parameter,
        ]
    }

    /// A direction in the section plane, given in units of A0 and A0 Ω at a node, as a direction in places.
    pub fn direction(&self, node: &Node, plane: [f64; 2]) -> Place {
        let share = node.orbit.frequency_hz / self.params.natural_frequency_hz();
        normalised([plane[0], plane[1] * share, 0.0])
    }

    /// The orbit at a value of the parameter near a section point, with the curve's direction there towards larger
    /// values of the parameter.
    pub fn node_at(&self, parameter: f64, section: [f64; 2]) -> Option<Node> {
        self.correct(self.place(section, parameter), [0.0, 0.0, 1.0])
    }

    /// The orbit in the plane through `guess` normal to `direction`; its tangent points along `direction`.
    pub fn correct(&self, guess: Place, direction: Place) -> Option<Node> {
        let mut place = guess;
        for _ in 0..ITERATIONS {
            let (params, frequency_hz) = self.at(place[2]);
            if frequency_hz <= 0.0 {
                return None;
            }
            let section = self.section(&place);
            let image = Image::of(&params, frequency_hz, section, self.periods)?;
            let miss = image.miss(section);
            if !(miss[0].is_finite() && miss[1].is_finite()) {
                return None;
            }
            let rows = self.rows(&image, &place)?;
            let off = dot(direction, minus(place, guess));
            let step = solve([rows[0], rows[1], direction], [-miss[0], -miss[1], -off]);
            let closed = miss[0].abs().max(miss[1].abs());
            // A nearly grazing contact magnifies the grain of the map a thousandfold, and not that of the orbit.
            let at_rest = step.is_some_and(|s| dot(s, s).sqrt() < STILL);
            if closed < CLOSURE || (closed < LOOSE && at_rest) {
                let mut tangent = normalised(cross(rows[0], rows[1]));
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
            for i in 0..3 {
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
    fn rows(&self, image: &Image, place: &Place) -> Option<[Place; 2]> {
        let monodromy = image.monodromy();
        let section = self.section(place);
        let ahead = place[2] + DIFFERENCE;
        let (params, frequency_hz) = self.at(ahead);
        let there = after_periods(&params, frequency_hz, section, self.periods)?;
        let miss = image.miss(section);
        Some([0, 1].map(|i| {
            let by = |j: usize| {
                let own = if i == j { 1.0 } else { 0.0 };
                (monodromy[i][j] - own) * self.units[j] / image.units[j]
            };
            let moved = (there[i] - section[i]) / image.units[i];
            [by(0), by(1), (moved - miss[i]) / DIFFERENCE]
        }))
    }
}

/// Scalar product.
pub fn dot(a: Place, b: Place) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// a − b.
pub fn minus(a: Place, b: Place) -> Place {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// The place the fraction `s` of the way from a to b.
pub fn between(a: Place, b: Place, s: f64) -> Place {
    [0, 1, 2].map(|i| a[i] + s * (b[i] - a[i]))
}

/// `a` made of length 1.
pub fn normalised(a: Place) -> Place {
    let length = dot(a, a).sqrt();
    a.map(|x| x / length)
}

fn cross(a: Place, b: Place) -> Place {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

/// Solves three linear equations, given their rows, by Cramer's rule.
fn solve(rows: [Place; 3], right: Place) -> Option<Place> {
    let [a, b, c] = rows;
    let (bc, ca, ab) = (cross(b, c), cross(c, a), cross(a, b));
    let determinant = dot(a, bc);
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
        let found = solve(rows, rows.map(|row| dot(row, x))).unwrap();
        for i in 0..3 {
            assert!((found[i] - x[i]).abs() < 1e-14);
        }
        assert_eq!(solve([[1.0; 3]; 3], x), None);
    }
}
