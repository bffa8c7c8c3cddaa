//! The choice on the robust range, within the limits asked for.

use shared::model::params::RigParams;

use super::answer::drive_force;
use super::case::PickCase;
use super::robust::with_reserve;
use super::search::{Spread, spread_of_members};
use crate::branch::Branch;
use crate::error::{Error, PickError};
use crate::limits::{LimitUse, PickLimits};
use crate::progress::{Progress, check};
use crate::row::NamedRig;

/// The operating point chosen: its orbit, and what bounds it.
pub struct ChosenOrbit<C: PickCase = RigParams> {
    /// Orbit of the nominal rig there.
    pub orbit: C::Orbit,
    /// What it is worth over the uncertainty.
    pub spread: Spread,
    /// The part of the robust range about it that the limits allow, Hz.
    pub allowed: (f64, f64),
    /// Limits, and which decide.
    pub limits: Vec<LimitUse>,
}

/// What is chosen from: the nominal branch, and the rigs the real one may be.
pub struct PickField<'a, C: PickCase = RigParams> {
    /// The nominal rig.
    pub rig: &'a NamedRig,
    /// Branch of its stable 1/1.
    pub branch: &'a Branch<C>,
    /// The rigs of the uncertainty; none if the parameters are exact.
    pub members: &'a [C::Followed],
    /// Who can end the search.
    pub progress: &'a dyn Progress,
}

impl<'a, C: PickCase> PickField<'a, C> {
    /// Of the nominal rig alone.
    pub fn nominal(rig: &'a NamedRig, branch: &'a Branch<C>, progress: &'a dyn Progress) -> Self {
        Self {
            rig,
            branch,
            members: &[],
            progress,
        }
    }

    /// This field with `members` in place of its own.
    pub fn asking<'b>(&self, members: &'b [C::Followed]) -> PickField<'b, C>
    where
        'a: 'b,
    {
        let (rig, branch, progress) = (self.rig, self.branch, self.progress);
        PickField {
            rig,
            branch,
            members,
            progress,
        }
    }

    /// The highest frequency allowed by the limits that need no orbit, Hz.
    fn top(&self, limits: PickLimits) -> f64 {
        let by_frequency = limits.max_frequency_hz.unwrap_or(f64::INFINITY);
        let params = &self.rig.params;
        if params.cart.recoils() {
            return by_frequency;
        }
        let at_one = drive_force(params, 1.0);
        let by_shaker = limits
            .shaker_force_n(params)
            .map(|max| (max / at_one).sqrt());
        by_shaker.map_or(by_frequency, |hz| hz.min(by_frequency))
    }

    /// The orbit at `hz`, if its force and that of every member is within the limit. None, too, once the search should
    /// stop.
    fn within_force(&self, hz: f64, max_force_n: Option<f64>) -> Option<C::Orbit> {
        check(self.progress).ok()?;
        let orbit = self.branch.at(hz)?;
        if let Some(max) = max_force_n {
            let spread = spread_of_members(&self.branch.case, self.members, &orbit)?;
            if spread.strongest_n > max {
                return None;
            }
        }
        Some(orbit)
    }

    /// [`Self::within_force`], if the force of the shaker is within its limit, too.
    fn within(&self, hz: f64, limits: PickLimits) -> Option<C::Orbit> {
        let orbit = self.within_force(hz, limits.max_force_n)?;
        let params = &self.rig.params;
        // With a prescribed cart it bounds the frequency.
        let most = limits
            .shaker_force_n(params)
            .filter(|_| params.cart.recoils());
        let keeps = most.is_none_or(|most| self.branch.case.shaker_force_n(&orbit) <= most);
        keeps.then_some(orbit)
    }

    /// The orbit worth most in `range_hz` within `limits`. Both flanks of the force curve may reach a force
    /// limit; the lower one is taken, which needs less of the shaker and is farther from the doubling.
    pub fn best(&self, range_hz: (f64, f64), limits: PickLimits) -> Option<C::Orbit> {
        let range_hz = (range_hz.0, self.top(limits).min(range_hz.1));
        if range_hz.1 < range_hz.0 {
            return None;
        }
        let within = |hz: f64| self.within(hz, limits);
        let (best_hz, orbit) = self.branch.largest(range_hz, |hz| {
            let orbit = within(hz)?;
            Some((C::numbers_of(&orbit).worth, orbit))
        })?;
        if limits.max_force_n.is_none() || within(range_hz.0).is_none() {
            return Some(orbit);
        }
        let rising = (range_hz.0, best_hz);
        let (_, edge) = self
            .branch
            .stretch(range_hz.0, rising, |hz| within(hz).is_some());
        let lower = within(edge)?;
        let worth = |orbit| C::numbers_of(orbit).worth;
        let equal = worth(&lower) >= worth(&orbit) * (1.0 - 1e-5);
        Some(if equal { lower } else { orbit })
    }

    /// The part of `range_hz` about `from_hz` that `limits` allow.
    fn allowed(&self, from_hz: f64, range_hz: (f64, f64), limits: PickLimits) -> (f64, f64) {
        let range_hz = (range_hz.0, range_hz.1.min(self.top(limits)));
        let by_shaker = limits.shaker_force_n(&self.rig.params).is_some();
        if limits.max_force_n.is_none() && !by_shaker {
            return range_hz;
        }
        self.branch
            .stretch(from_hz, range_hz, |hz| self.within(hz, limits).is_some())
    }

    /// The best orbit that uncertainty and limits allow, and which of them decide.
    ///
    /// It keeps the reserve from the ends of `robust`, where every member has a stable 1/1. What the limits allow about it goes
    /// up to them.
    ///
    /// A force limit holds for every member, but only a few of them ever reach it. The search asks those
    /// known to (at first none), then all at what it found, and takes in whoever breaks the limit there.
    ///
    /// # Errors
    /// If no orbit is within the limits, if a member has no stable 1/1 at one, or if the work is interrupted.
    pub fn choose(&self, robust: (f64, f64), limits: PickLimits) -> Result<ChosenOrbit<C>, Error> {
        let kept = with_reserve(robust, !self.members.is_empty());
        let mut strong: Vec<C::Followed> = Vec::new();
        loop {
            let search = self.asking(&strong);
            let best = search.best(kept, limits);
            check(self.progress)?;
            let orbit = best.ok_or_else(|| self.nothing(kept, limits))?;
            let allowed = search.allowed(C::numbers_of(&orbit).frequency_hz, robust, limits);
            check(self.progress)?;
            let spread = self.spread(&orbit)?;
            let mut breaker = self.breaks(&spread, &strong, limits);
            if limits.max_force_n.is_some() {
                for end in [allowed.0, allowed.1] {
                    let there = self.branch.at(end);
                    let there = there.map(|orbit| self.spread(&orbit)).transpose()?;
                    let found = there.and_then(|spread| self.breaks(&spread, &strong, limits));
                    breaker = breaker.or(found);
                }
            }
            let Some(member) = breaker else {
                let mut limits = search.which_decide(&orbit, (robust, kept), limits);
                check(self.progress)?;
                limits.retain(|l| l.limit.is_some() || !self.members.is_empty());
                return Ok(ChosenOrbit {
                    orbit,
                    spread,
                    allowed,
                    limits,
                });
            };
            strong.push(member);
        }
    }

    /// The strongest member, if it breaks the force limit and is not among those known to.
    fn breaks(
        &self,
        spread: &Spread,
        known: &[C::Followed],
        limits: PickLimits,
    ) -> Option<C::Followed> {
        let max = limits.max_force_n?;
        let member = &self.members[spread.strongest?];
        (spread.strongest_n > max && !known.contains(member)).then(|| member.clone())
    }

    /// What is spread over the uncertainty at `hz`. None if a member has no stable 1/1 there.
    pub fn spread_at(&self, hz: f64) -> Option<Spread> {
        let orbit = self.branch.at(hz)?;
        spread_of_members(&self.branch.case, self.members, &orbit)
    }

    /// What `orbit` and every member at its frequency are worth.
    ///
    /// # Errors
    /// If a member has no stable 1/1 there.
    pub fn spread(&self, orbit: &C::Orbit) -> Result<Spread, Error> {
        spread_of_members(&self.branch.case, self.members, orbit).ok_or_else(|| {
            self.rig.no_pick(PickError::MemberLost {
                frequency_hz: C::numbers_of(orbit).frequency_hz,
            })
        })
    }

    /// The error that says that nothing in `robust` keeps `limits`.
    pub fn nothing(&self, robust: (f64, f64), limits: PickLimits) -> Error {
        // The shaker's own limit is named only where it matters.
        let asked = PickLimits {
            rig_shaker_force_n: None,
            ..limits
        };
        let limits = if self.best(robust, asked).is_none() {
            asked
        } else {
            limits
        };
        self.rig.no_pick(PickError::Limits {
            range_hz: robust,
            limits,
            feasible: Box::new(self.feasible(robust, limits)),
        })
    }

    /// The smallest limits that leave something of `robust`, for those of `limits` that leave nothing: of frequency and drive
    /// force by themselves, of the other forces on what these two leave.
    fn feasible(&self, robust: (f64, f64), limits: PickLimits) -> PickLimits {
        let params = &self.rig.params;
        let top = self.top(limits);
        let open = if top >= robust.0 {
            (robust.0, robust.1.min(top))
        } else {
            robust
        };
        let strongest = |hz: f64| Some((-self.spread_at(hz)?.strongest_n, ()));
        let softest_n = || {
            let (hz, ()) = self.branch.largest(open, strongest)?;
            strongest(hz).map(|(minus, ())| -minus)
        };
        let held = |hz: f64| {
            let orbit = self.branch.at(hz)?;
            Some((-self.branch.case.shaker_force_n(&orbit), ()))
        };
        let least_held_n = || {
            // Of a prescribed cart it rises with the frequency.
            let open = if params.cart.recoils() { open } else { robust };
            let (hz, ()) = self.branch.largest(open, held)?;
            held(hz).map(|(minus, ())| -minus)
        };
        let shaker =
            |most: Option<f64>| most.and_then(|most| least_held_n().filter(|least| most < *least));
        let beyond = |limit: Option<f64>, least: f64| limit.filter(|x| *x < least).map(|_| least);
        PickLimits {
            max_force_n: limits
                .max_force_n
                .and_then(|max| softest_n().filter(|least| max < *least)),
            max_frequency_hz: beyond(limits.max_frequency_hz, robust.0),
            max_shaker_force_n: shaker(limits.max_shaker_force_n),
            rig_shaker_force_n: shaker(limits.rig_shaker_force_n),
        }
    }

    /// What decides: without it there is more.
    fn which_decide(
        &self,
        orbit: &C::Orbit,
        (robust, kept): ((f64, f64), (f64, f64)),
        limits: PickLimits,
    ) -> Vec<LimitUse> {
        let worth = C::numbers_of(orbit).worth;
        let more = |found: Option<C::Orbit>| {
            found.is_some_and(|other| C::numbers_of(&other).worth > worth * (1.0 + 1e-6))
        };
        let (certain, free) = (self.asking(&[]), self.branch.range());
        let mut uses = vec![LimitUse {
            name: "the uncertainty",
            binds: more(certain.best(free, limits)),
            ..LimitUse::default()
        }];
        if more(self.best(robust, limits)) {
            uses.push(LimitUse::reserve(kept));
        }
        uses.extend(limits.which_decide(|others| more(self.best(kept, others))));
        for shaker in uses.iter_mut().filter(|l| l.name == "shaker_max_force_n") {
            shaker.assumed = !self.rig.shaker_force_told;
        }
        uses
    }
}

#[cfg(test)]
mod tests;
