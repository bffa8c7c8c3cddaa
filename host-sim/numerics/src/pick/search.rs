//! The rigs of the uncertainty beside the nominal one: their orbits, and what they spread over.

use shared::model::params::RigParams;

use super::case::{OrbitNumbers, PickCase};
use crate::branch::Branch;
use crate::orbit::{Orbit, shoot_at};
use crate::parallel;
use crate::uncertainty::Member;

/// The 1/1 orbit of `member` at `frequency_hz`, followed from the nominal `orbit` there while the
/// deviations grow from none to all.
pub fn follow_member(
    nominal: &RigParams,
    member: &Member,
    orbit: &Orbit,
    frequency_hz: f64,
) -> Option<Orbit> {
    let full = member.apply(nominal, 1.0);
    let direct = shoot_at(&full, frequency_hz, orbit.at(), 1);
    if let Some(found) = direct.filter(Orbit::is_stable_one_one) {
        return Some(found);
    }
    const STEPS: u32 = 8;
    let mut section = orbit.at();
    let mut found = None;
    for step in 1..=STEPS {
        let rig = member.apply(nominal, f64::from(step) / f64::from(STEPS));
        let next = shoot_at(&rig, frequency_hz, section, 1)?;
        section = next.at();
        found = Some(next);
    }
    found
}

/// The stable 1/1 of `member`, within `limits_hz`. `None` if it has none near the nominal branch.
pub fn own_branch(
    nominal: &RigParams,
    member: &Member,
    branch: &Branch,
    start_hz: f64,
    limits_hz: (f64, f64),
) -> Option<Branch> {
    let rig = member.apply(nominal, 1.0);
    // The orbit scales with the natural frequency; try there first, then where the nominal one is, and at last within limits
    // that may be far from both.
    let scaled = start_hz * member.natural_frequency_factor();
    let middle = 0.5 * (limits_hz.0 + limits_hz.1);
    let seed = [scaled, start_hz, 0.9 * start_hz, 1.1 * start_hz, middle]
        .into_iter()
        .find_map(|hz| {
            let hz = hz.clamp(limits_hz.0, limits_hz.1);
            let orbit = branch.at(hz)?;
            follow_member(nominal, member, &orbit, hz).filter(Orbit::is_stable_one_one)
        })?;
    Some(Branch::follow(&rig, seed, limits_hz))
}

/// What the nominal `orbit` and every member at its frequency are worth. `None` if a member has no stable 1/1 there.
pub fn spread_of_members<C: PickCase>(
    nominal: &C,
    members: &[C::Followed],
    orbit: &C::Orbit,
) -> Option<Spread> {
    let own = Spread::of(&C::numbers_of(orbit), None);
    let of_member = |member: &C::Followed| Some(C::numbers_of(&nominal.stable_at(member, orbit)?));
    let followed = parallel::map_all(members, of_member)?;
    let spreads = followed.iter().enumerate();
    Some(spreads.fold(own, |all, (i, orbit)| all.with(Spread::of(orbit, Some(i)))))
}

/// Smallest and largest values over members.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spread {
    /// Smallest of what is made largest: contact force, N, or rate of penetration, m/s.
    pub least: f64,
    /// Largest of what is made largest: contact force, N, or rate of penetration, m/s.
    pub most: f64,
    /// Smallest contact force, N.
    pub weakest_n: f64,
    /// Largest contact force, N.
    pub strongest_n: f64,
    /// The member that has it; none if it is the nominal rig.
    pub strongest: Option<usize>,
    /// Largest modulus of a multiplier.
    pub multiplier: f64,
}

impl Spread {
    fn of(orbit: &OrbitNumbers, member: Option<usize>) -> Self {
        Self {
            least: orbit.worth,
            most: orbit.worth,
            weakest_n: orbit.force_n,
            strongest_n: orbit.force_n,
            strongest: member,
            multiplier: orbit.multiplier,
        }
    }

    fn with(self, other: Self) -> Self {
        // By force, then by index: the same whatever the order of threads.
        let key = |s: &Self| (s.strongest_n, std::cmp::Reverse(s.strongest));
        let stronger = if key(&other) > key(&self) {
            other
        } else {
            self
        };
        Self {
            least: self.least.min(other.least),
            most: self.most.max(other.most),
            weakest_n: self.weakest_n.min(other.weakest_n),
            strongest_n: stronger.strongest_n,
            strongest: stronger.strongest,
            multiplier: self.multiplier.max(other.multiplier),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::branch::one_one_branches;
    use crate::orbit::shoot;
    use crate::pick::follow::Followed;
    use crate::uncertainty::Uncertainty;
    use shared::model::params::WIRES;

    #[test]
    fn the_maximum_is_found_inside_at_an_edge_and_against_a_limit() {
        let branch = &one_one_branches(&WIRES, (1.0, 3.0))[0];
        // A made-up value with its top at 3.0 Hz.
        let value = |hz: f64| Some((-(hz - 3.0).powi(2), hz));
        let at = |range, value: &dyn Fn(f64) -> Option<(f64, f64)>| {
            branch.largest(range, value).map(|(hz, _)| hz)
        };
        assert!((at((2.2, 4.5), &value).unwrap() - 3.0).abs() < 1e-6);
        assert!((at((3.3, 4.5), &value).unwrap() - 3.3).abs() < 1e-6);
        let limited = |hz: f64| (hz < 2.71).then(|| value(hz)).flatten();
        assert!((at((2.2, 4.5), &limited).unwrap() - 2.71).abs() < 1e-6);
        let above = |hz: f64| (hz > 3.29).then(|| value(hz)).flatten();
        assert!((at((2.2, 4.5), &above).unwrap() - 3.29).abs() < 1e-6);
        assert_eq!(at((2.2, 4.5), &|_| None), None);
    }

    #[test]
    fn an_interval_ends_where_its_condition_does() {
        let branch = &one_one_branches(&WIRES, (1.0, 3.0))[0];
        let (low, high) = branch.stretch(3.0, (2.2, 4.0), |hz| hz > 2.6);
        assert!((low - 2.6).abs() < 1e-6, "{low}");
        assert_eq!(high, 4.0);
    }

    fn stable_interval(
        nominal: &RigParams,
        member: &Member,
        branch: &Branch,
        start_hz: f64,
        limits_hz: (f64, f64),
    ) -> Option<(f64, f64)> {
        let own = own_branch(nominal, member, branch, start_hz, limits_hz)?;
        Some((own.low.frequency_hz, own.high.frequency_hz))
    }

    /// ±5 % of amplitude: the second of the two members has a larger force than the first.
    fn by_amplitude() -> Vec<Member> {
        let uncertainty = Uncertainty {
            natural_frequency_percent: 0.0,
            amplitude_percent: 5.0,
            contact_stiffness_percent: 0.0,
            contact_damping_percent: 0.0,
            gap_mm: 0.0,
            samples: 0,
            ..Uncertainty::default()
        };
        uncertainty.members()
    }

    fn by_natural_frequency(percent: f64) -> Vec<Member> {
        let uncertainty = Uncertainty {
            natural_frequency_percent: percent,
            amplitude_percent: 0.0,
            contact_stiffness_percent: 0.0,
            contact_damping_percent: 0.0,
            gap_mm: 0.0,
            samples: 0,
            ..Uncertainty::default()
        };
        uncertainty.members()
    }

    #[test]
    fn the_strongest_of_two_is_the_same_in_either_order_and_the_first_of_equals() {
        let of = |force: f64, strongest| Spread {
            least: force,
            most: force,
            weakest_n: force,
            strongest_n: force,
            strongest,
            multiplier: 1.0 / force,
        };
        let (soft, hard) = (of(2.0, Some(0)), of(4.0, Some(1)));
        for both in [soft.with(hard), hard.with(soft)] {
            let expected = Spread {
                least: 2.0,
                most: 4.0,
                weakest_n: 2.0,
                strongest_n: 4.0,
                strongest: Some(1),
                multiplier: 0.5,
            };
            assert_eq!(both, expected);
        }
        let (nominal, second) = (of(4.0, None), of(4.0, Some(2)));
        for (a, b) in [(hard, second), (second, hard)] {
            assert_eq!(a.with(b).strongest, Some(1));
            assert_eq!(a.with(nominal).strongest, None);
            assert_eq!(nominal.with(b).strongest, None);
        }
    }

    #[test]
    fn the_spread_has_the_forces_of_every_member() {
        let branch = &one_one_branches(&WIRES, (1.0, 3.0))[0];
        let orbit = branch.at(3.0).unwrap();
        let alone = spread_of_members(&WIRES, &[], &orbit).unwrap();
        assert_eq!(alone, Spread::of(&RigParams::numbers_of(&orbit), None));
        let members = by_amplitude();
        let unfollowed: Vec<_> = members.iter().map(|m| Followed::from(*m)).collect();
        let spread = spread_of_members(&WIRES, &unfollowed, &orbit).unwrap();
        let forces = [0, 1].map(|i| {
            let found = follow_member(&WIRES, &members[i], &orbit, 3.0).unwrap();
            assert!(found.is_stable_one_one());
            assert_eq!(found.frequency_hz, 3.0);
            found.force_n
        });
        assert!(forces[0] < orbit.force_n && orbit.force_n < forces[1]);
        assert_eq!((spread.weakest_n, spread.strongest_n), forces.into());
        assert_eq!(spread.strongest, Some(1));
        let far = by_natural_frequency(60.0);
        let far: Vec<_> = far.into_iter().map(Followed::from).collect();
        assert_eq!(spread_of_members(&WIRES, &far, &orbit), None);
    }

    /// Just below the frequency at which the nominal 1/1 ends, the orbit of a rig that swings 2 % slower is unstable: it is
    /// followed in steps, to all of the deviation and not to a part of it or back to none.
    #[test]
    fn a_member_followed_in_steps_arrives_at_its_own_orbit() {
        let branch = &one_one_branches(&WIRES, (1.0, 3.0))[0];
        let hz = 0.995 * branch.high.frequency_hz;
        let nominal = branch.at(hz).unwrap();
        assert!(nominal.is_stable_one_one());
        let slower = &by_natural_frequency(2.0)[0];
        let found = follow_member(&WIRES, slower, &nominal, hz).unwrap();
        assert!(!found.is_stable_one_one(), "{found:?}");
        let own = shoot(&slower.apply(&WIRES, 1.0), hz, found.section).unwrap();
        assert!((found.force_n / own.force_n - 1.0).abs() < 1e-9);
        assert!((found.force_n / nominal.force_n - 1.0).abs() > 1e-3);
    }

    /// Wires shortened so that they swing 2 % faster are stable up to a frequency about 2 % higher.
    #[test]
    fn a_member_s_stable_range_moves_with_its_natural_frequency_and_keeps_to_the_limits() {
        let branch = &one_one_branches(&WIRES, (1.0, 3.0))[0];
        let members = by_natural_frequency(2.0);
        let wide = (
            0.5 * branch.low.frequency_hz,
            1.5 * branch.high.frequency_hz,
        );
        for (member, factor) in members.iter().zip([0.98, 1.02]) {
            let start = 0.5 * (branch.low.frequency_hz + branch.high.frequency_hz);
            let found = stable_interval(&WIRES, member, branch, start, wide).unwrap();
            let moved = found.1 / branch.high.frequency_hz;
            assert!((moved - factor).abs() < 0.005, "{moved} for {factor}");
            let narrow = (0.9 * start, 1.1 * start);
            let found = stable_interval(&WIRES, member, branch, start, narrow).unwrap();
            let off = (found.0 - narrow.0).abs().max((found.1 - narrow.1).abs());
            assert!(off < 1e-6, "{found:?} for {narrow:?}");
        }
        let far = by_natural_frequency(60.0);
        let narrow = (2.9, 3.1);
        assert_eq!(stable_interval(&WIRES, &far[1], branch, 3.0, narrow), None);
    }

    #[test]
    fn an_interval_is_not_searched_beyond_its_limits() {
        let branch = &one_one_branches(&WIRES, (1.0, 3.0))[0];
        let orbits = &branch.orbits;
        let between = |i: usize| 0.5 * (orbits[i].frequency_hz + orbits[i + 1].frequency_hz);
        let limits = (between(1), between(orbits.len() - 3));
        let middle = 0.5 * (limits.0 + limits.1);
        let inside = |hz: f64| limits.0 <= hz && hz <= limits.1;
        assert_eq!(branch.stretch(middle, limits, inside), limits);
    }

    #[test]
    fn a_narrow_maximum_at_an_orbit_of_the_branch_is_not_passed_over_and_the_first_of_equals_counts()
     {
        let branch = &one_one_branches(&WIRES, (1.0, 3.0))[0];
        let orbits = &branch.orbits;
        let (low, high) = (branch.low.frequency_hz, branch.high.frequency_hz);
        let (first, last) = (1, orbits.len() - 2);
        assert!(first < last);
        for node in [first, last].map(|i| orbits[i].frequency_hz) {
            let value = |hz: f64| {
                let off = (hz - node).abs();
                let narrow = off < 1e-3;
                Some((
                    if narrow {
                        1.0 - off
                    } else {
                        -(hz - 0.5 * (low + high)).powi(2)
                    },
                    (),
                ))
            };
            let (found, ()) = branch.largest((low, high), value).unwrap();
            assert!((found - node).abs() < 1e-6, "{found} for {node}");
        }
        let (found, ()) = branch.largest((low, high), |_| Some((1.0, ()))).unwrap();
        assert_eq!(found, low);
    }

    #[test]
    fn a_start_beyond_the_branch_is_tried_a_tenth_lower_and_higher() {
        let branch = &one_one_branches(&WIRES, (1.0, 3.0))[0];
        let member = &by_amplitude()[0];
        let (low, high) = (branch.low.frequency_hz, branch.high.frequency_hz);
        let wide = (0.5 * low, 1.5 * high);
        let usual = stable_interval(&WIRES, member, branch, 3.0, wide).unwrap();
        for start in [0.95 * low, 1.05 * high] {
            let found = stable_interval(&WIRES, member, branch, start, wide).unwrap();
            let off = (found.0 - usual.0).abs().max((found.1 - usual.1).abs());
            assert!(off < 1e-5, "{found:?} for {usual:?}");
        }
    }

    #[test]
    fn an_interval_ends_above_where_its_condition_does() {
        let branch = &one_one_branches(&WIRES, (1.0, 3.0))[0];
        let (low, high) = branch.stretch(3.0, (2.2, 4.0), |hz| hz < 3.4);
        assert_eq!(low, 2.2);
        assert!((high - 3.4).abs() < 1e-6, "{high}");
    }
}
