//! What is asked of curves over two parameters, and the way to the answer.

use super::starts::{SpecialPoints, seeds};
use super::table::CurvesAnswer;
use super::{Dimension, Plane, followed};
use crate::continuation::{Along, OrbitsRequest};
use crate::error::{Error, PlaneError};
use crate::progress::Progress;
use crate::range::within;
use crate::row::tidy;

/// Curves over a plane of two parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CurvesRequest {
    /// The two parameters.
    pub plane: Plane,
    /// How orbits are searched for, at each of `searches` values of the second parameter; what it varies and its limits
    /// are the plane's.
    pub search: OrbitsRequest,
    /// Values of the second parameter at which the search begins.
    pub searches: usize,
}

impl CurvesRequest {
    /// A search for orbits of up to so many `periods` and `impacts`.
    pub fn search(periods: u8, impacts: u16, starts: usize, checks: usize) -> OrbitsRequest {
        OrbitsRequest {
            along: Along::Frequency,
            limits: (0.0, 0.0),
            periods,
            impacts,
            starts,
            checks,
        }
    }

    /// Whether there is a rig at every corner of the plane.
    ///
    /// # Errors
    /// If there is none, the two parameters are one, or a number of the search is out of its range.
    pub fn check(&self) -> Result<(), Error> {
        self.search.check()?;
        within([("searches", self.searches as f64, 1.0, 200.0)])?;
        let [first, second] = self.plane.dimensions;
        if first.varied == second.varied {
            return Err(PlaneError::Same(second.varied.name()).into());
        }
        let ends = |d: Dimension| [d.range.0, d.range.1];
        for a in ends(first) {
            for b in ends(second) {
                let Some((params, _)) = self.plane.at([a, b]) else {
                    let names = [first, second].map(|d| d.varied.name()).join(" and ");
                    return Err(PlaneError::NotOfRig(names).into());
                };
                params.check().map_err(PlaneError::Parameter)?;
            }
        }
        Ok(())
    }

    /// The values of the second parameter at which orbits are searched for.
    fn searched_at(&self) -> Vec<f64> {
        self.plane.dimensions[1].spread(self.searches)
    }

    /// Steps of progress of [`Self::seeds`].
    pub fn simulations(&self) -> u64 {
        self.search.simulations() * self.searched_at().len() as u64
    }

    /// The special points from which the curves begin.
    ///
    /// # Errors
    /// As [`seeds`].
    pub fn seeds(&self, progress: &dyn Progress) -> Result<SpecialPoints, Error> {
        seeds(&self.plane, &self.searched_at(), &self.search, progress)
    }

    /// The curves of the rig called `name` from these special points, each of which is a step of progress.
    ///
    /// # Errors
    /// As [`followed`].
    pub fn curves(
        &self,
        name: &str,
        from: &SpecialPoints,
        progress: &dyn Progress,
    ) -> Result<CurvesAnswer, Error> {
        let curves = followed(&from.seeds, progress)?;
        Ok(CurvesAnswer {
            searched_at: self.searched_at().into_iter().map(tidy).collect(),
            not_followed: from.refused,
            simulations: from.simulations,
            failed_simulations: from.failed,
            ..CurvesAnswer::new(name, &self.plane, &curves)
        })
    }
}
