//! What the frequency is chosen from, and which limit decides.

use super::super::orbit::DrillOrbit;
use super::members::Crowd;
use super::observe;
use crate::limits::LimitUse;
use crate::limits::PickLimits;
use crate::pick::answer::drive_force;

/// What is chosen from.
pub struct DrillField<'a> {
    /// The nominal branch and the members.
    pub crowd: Crowd<'a>,
    /// What must be kept.
    pub limits: PickLimits,
}

impl DrillField<'_> {
    /// Whether the limits allow the nominal orbit at `hz`.
    pub fn allows(&self, hz: f64) -> bool {
        self.crowd
            .branch
            .at(hz)
            .is_some_and(|o| self.allowed(&o, self.limits))
    }

    fn allowed(&self, orbit: &DrillOrbit, limits: PickLimits) -> bool {
        let (params, hz) = (&self.crowd.case.params, orbit.frequency_hz);
        // What is at a limit to the last digits keeps it.
        let keeps =
            |value: f64, limit: Option<f64>| limit.is_none_or(|most| value <= most * (1.0 + 1e-9));
        keeps(hz, limits.max_frequency_hz)
            && limits.shaker_force_n(params).is_none_or(|most| {
                observe::shaker_force_n(self.crowd.case, orbit) <= most * (1.0 + 1e-9)
            })
            && limits.max_force_n.is_none_or(|most| {
                let spread = self.crowd.spread(hz);
                spread.is_some_and(|s| s.strongest_n <= most)
            })
    }

    /// The orbit with the largest rate in `range_hz` within the limits.
    pub fn best(&self, range_hz: (f64, f64)) -> Option<DrillOrbit> {
        self.best_within(range_hz, self.limits)
    }

    fn best_within(&self, range_hz: (f64, f64), limits: PickLimits) -> Option<DrillOrbit> {
        let params = &self.crowd.case.params;
        let prescribed = !params.cart.recoils();
        let most = limits.shaker_force_n(params).filter(|_| prescribed);
        let by_shaker = most.map(|most| (most / drive_force(params, 1.0)).sqrt());
        let tops = [limits.max_frequency_hz, by_shaker].into_iter().flatten();
        let top = tops.fold(range_hz.1, f64::min);
        self.crowd.branch.best((range_hz.0, top), |o| {
            self.allowed(o, limits).then(|| o.rate_m_per_s())
        })
    }

    /// What decides: without it there is more. The choice is from `kept` of `robust`.
    pub fn which_decide(
        &self,
        chosen: &DrillOrbit,
        (robust, kept): ((f64, f64), (f64, f64)),
        uncertain: bool,
    ) -> Vec<LimitUse> {
        let limits = self.limits;
        let more = |found: Option<DrillOrbit>| {
            found.is_some_and(|o| o.rate_m_per_s() > chosen.rate_m_per_s() * (1.0 + 1e-6))
        };
        let mut uses = Vec::new();
        if uncertain {
            let certain = DrillField {
                crowd: Crowd {
                    members: &[],
                    ..self.crowd
                },
                limits,
            };
            uses.push(LimitUse {
                name: "the uncertainty",
                limit: None,
                binds: more(certain.best(self.crowd.branch.range())),
                together: false,
                assumed: false,
            });
        }
        if more(self.best(robust)) {
            uses.push(LimitUse::reserve(kept));
        }
        uses.extend(limits.which_decide(|others| more(self.best_within(kept, others))));
        uses
    }
}
