//! The equations of a curve: an orbit, and what holds of it.

use nalgebra::DVector;
use shared::model::params::{ParamError, RigParams};

use super::graze::{Graze, Windows};
use super::plane::Plane;
use super::{Codimension, Condition, TwoParameterPoint};
use crate::continuation::family::units;
use crate::continuation::march::{ContactMargins, onsets};
use crate::orbit::{Exactness, Monodromy, Orbit, ReturnMapImage, Section};
use crate::reference::LocatedContact;

/// The equations of one curve. Its unknowns are those of the orbit and the places of both parameters.
#[derive(Clone, Copy, Debug)]
pub struct System {
    pub plane: Plane,
    pub condition: Condition,
    pub periods: u8,
    /// Units of a section point, as along curves of orbits.
    pub units: Section,
    /// On a graze: the flights before and after it that are free of other contacts.
    pub windows: Windows,
}

/// What an orbit shows, once its equations hold.
pub struct OrbitConditions {
    pub section: [f64; 2],
    pub impacts: u16,
    pub force_n: f64,
    pub monodromy: Monodromy,
    pub onsets: Vec<f64>,
    pub margins: ContactMargins,
    pub leaving: Option<f64>,
    pub flights: Option<Vec<LocatedContact>>,
}

impl System {
    /// # Errors
    /// If a parameter is out of range: the first of them.
    pub fn new(
        plane: Plane,
        params: &RigParams,
        condition: Condition,
        periods: u8,
    ) -> Result<Self, ParamError> {
        Ok(Self {
            plane,
            condition,
            periods,
            units: units(params)?,
            windows: Windows::default(),
        })
    }

    /// Whether the cart recoils: its deviation is unknown, too.
    pub fn recoils(&self) -> bool {
        self.plane.params.cart.recoils()
    }

    /// The unknowns of the orbit at a section point.
    pub fn section_unknowns(&self, at: Section) -> Vec<f64> {
        let count = if self.recoils() { 4 } else { 2 };
        (0..count).map(|i| at[i] / self.units[i]).collect()
    }

    fn section(&self, x: &[f64]) -> Section {
        let count = x.len() - 2;
        [0, 1, 2, 3].map(|i| if i < count { x[i] * self.units[i] } else { 0.0 })
    }

    /// The graze whose unknowns begin with `x`.
    fn graze(&self, x: &[f64], params: RigParams, frequency_hz: f64) -> Graze {
        let cart = match x {
            [_, e, w, ..] if self.recoils() => [e * self.units[2], w * self.units[3]],
            _ => [0.0; 2],
        };
        Graze {
            params,
            frequency_hz,
            periods: self.periods,
            phase: x[0],
            cart,
            windows: self.windows,
        }
    }

    /// What the equations miss at `x`: one less than there are unknowns. None where the motion cannot be followed.
    pub fn miss(&self, x: &[f64]) -> Option<Vec<f64>> {
        let n = x.len();
        let (_, params, hz) = self.plane.at_places([x[n - 2], x[n - 1]])?;
        if self.condition == Condition::Grazing {
            return self.graze(x, params, hz).miss();
        }
        let section = self.section(x);
        let image = ReturnMapImage::of(Exactness::FULL, &params, hz, section, self.periods)?;
        let mut miss = image.miss(section)[..n - 2].to_vec();
        let monodromy = image.monodromy;
        miss.push(match self.condition {
            Condition::Fold => monodromy.fold_test(),
            _ => monodromy.doubling_test(),
        });
        miss.iter().all(|m| m.is_finite()).then_some(miss)
    }

    /// The point at `x`, where the equations hold. None if there is no such orbit after all.
    pub fn point(&self, x: DVector<f64>, tangent: DVector<f64>) -> Option<TwoParameterPoint> {
        let n = x.len();
        let (values, params, frequency_hz) = self.plane.at_places([x[n - 2], x[n - 1]])?;
        let found = if self.condition == Condition::Grazing {
            self.graze(x.as_slice(), params, frequency_hz).found()?
        } else {
            let section = self.section(x.as_slice());
            let image = ReturnMapImage::of(
                Exactness::FULL,
                &params,
                frequency_hz,
                section,
                self.periods,
            )?;
            of_orbit(&image.orbit(frequency_hz, section)?)
        };
        let tests = [
            found.monodromy.doubling_test(),
            found.monodromy.fold_test(),
            found.monodromy.slope_at_one(),
        ];
        Some(TwoParameterPoint {
            params,
            frequency_hz,
            values,
            section: found.section,
            impacts: found.impacts,
            force_n: found.force_n,
            multipliers: found.monodromy.leading(),
            mark: None,
            x,
            tangent,
            tests,
            leaving: found.leaving,
            onsets: found.onsets,
            flights: found.flights,
            margins: found.margins,
        })
    }

    /// What a graze at the end of this curve makes of it.
    pub fn with_graze(&self) -> Codimension {
        match self.condition {
            Condition::PeriodDoubling => Codimension::DoublingGraze,
            Condition::Fold => Codimension::FoldGraze,
            Condition::Grazing => Codimension::DoubleGraze,
        }
    }
}

fn of_orbit(orbit: &Orbit) -> OrbitConditions {
    OrbitConditions {
        section: orbit.section,
        impacts: orbit.impacts,
        force_n: orbit.force_n,
        monodromy: orbit.monodromy,
        onsets: onsets(orbit),
        margins: ContactMargins::of(orbit),
        leaving: None,
        flights: None,
    }
}
