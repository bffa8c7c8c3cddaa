//! The choice on wires at no gap, whose force rises to a maximum inside the stable 1/1 and falls again.

use super::*;

use crate::branch::one_one_branches;
use crate::orbit::Orbit;
use crate::pick::follow::Followed;
use crate::uncertainty::Uncertainty;
use shared::model::params::WIRES;

struct Made {
    rig: NamedRig,
    branch: Branch,
    members: Vec<Followed>,
}

impl Made {
    /// With the members whose natural frequency and amplitude differ by so many % either way.
    fn new(natural_frequency_percent: f64, amplitude_percent: f64) -> Self {
        let uncertainty = Uncertainty {
            natural_frequency_percent,
            amplitude_percent,
            contact_stiffness_percent: 0.0,
            contact_damping_percent: 0.0,
            gap_mm: 0.0,
            samples: 0,
            ..Uncertainty::default()
        };
        Self {
            rig: NamedRig::new("wires", WIRES),
            branch: one_one_branches(&WIRES, (1.0, 3.0)).swap_remove(0),
            members: (uncertainty.members().into_iter().map(Followed::from)).collect(),
        }
    }

    fn field(&self) -> PickField<'_> {
        PickField {
            rig: &self.rig,
            branch: &self.branch,
            members: &self.members,
            progress: &(),
        }
    }

    fn range(&self) -> (f64, f64) {
        (self.branch.low.frequency_hz, self.branch.high.frequency_hz)
    }

    fn force_at(&self, hz: f64) -> f64 {
        self.branch.at(hz).unwrap().force_n
    }

    /// The strongest orbit without uncertainty and limits, and a force limit that both flanks of the curve reach.
    fn optimum(&self) -> (Orbit, f64) {
        let best = self
            .field()
            .best(self.range(), PickLimits::default())
            .unwrap();
        let (low, high) = self.range();
        assert!(low < best.frequency_hz && best.frequency_hz < high);
        let ends = self.force_at(low).max(self.force_at(high));
        assert!(ends < 0.99 * best.force_n);
        let limit = 0.5 * (ends + best.force_n);
        (best, limit)
    }
}

fn force(max: f64) -> PickLimits {
    PickLimits {
        max_force_n: Some(max),
        ..PickLimits::default()
    }
}

fn frequency(max: f64) -> PickLimits {
    PickLimits {
        max_frequency_hz: Some(max),
        ..PickLimits::default()
    }
}

fn drive(max: f64) -> PickLimits {
    PickLimits {
        max_shaker_force_n: Some(max),
        ..PickLimits::default()
    }
}

fn near(a: f64, b: f64) -> bool {
    (a / b - 1.0).abs() < 1e-5
}

#[test]
fn the_lower_of_the_frequencies_that_the_shaker_allows_counts() {
    let made = Made::new(0.0, 0.0);
    let field = made.field();
    let at_three = drive_force(&WIRES, 3.0);
    assert_eq!(field.top(PickLimits::default()), f64::INFINITY);
    assert_eq!(field.top(frequency(2.5)), 2.5);
    assert!((field.top(drive(at_three)) - 3.0).abs() < 1e-12);
    for (hz, expected) in [(2.5, 2.5), (3.5, 3.0)] {
        let both = PickLimits {
            max_shaker_force_n: Some(at_three),
            ..frequency(hz)
        };
        assert!((field.top(both) - expected).abs() < 1e-12);
    }
}

#[test]
fn a_force_is_within_the_limit_if_that_of_every_member_is() {
    let alone = Made::new(0.0, 0.0);
    let force_n = alone.force_at(3.0);
    let within = |made: &Made, max| made.field().within_force(3.0, max).is_some();
    assert!(within(&alone, None));
    assert!(within(&alone, Some(force_n)));
    assert!(!within(&alone, Some(force_n * (1.0 - 1e-9))));
    let made = Made::new(0.0, 5.0);
    let orbit = made.branch.at(3.0).unwrap();
    let strongest = made.field().spread(&orbit).unwrap().strongest_n;
    assert!(strongest > 1.01 * force_n);
    assert!(within(&made, Some(strongest)));
    assert!(!within(&made, Some(0.999 * strongest)));
}

#[test]
fn the_best_orbit_is_the_maximum_or_lies_at_a_limit() {
    let made = Made::new(0.0, 0.0);
    let (optimum, limit) = made.optimum();
    let best = |range, limits| made.field().best(range, limits);
    for orbit in &made.branch.orbits {
        assert!(orbit.force_n <= optimum.force_n * (1.0 + 1e-9));
    }
    let range = made.range();
    let capped = 0.9 * optimum.frequency_hz;
    assert!(near(
        best(range, frequency(capped)).unwrap().frequency_hz,
        capped
    ));
    let by_drive = drive(drive_force(&WIRES, capped));
    assert!(near(best(range, by_drive).unwrap().frequency_hz, capped));
    assert!(best(range, frequency(0.999 * range.0)).is_none());
    assert!(near(
        best(range, frequency(range.0)).unwrap().frequency_hz,
        range.0
    ));
    // Both flanks reach the limit: the lower one is taken.
    let low = best(range, force(limit)).unwrap();
    assert!(near(low.force_n, limit) && low.force_n <= limit);
    assert!(low.frequency_hz < optimum.frequency_hz);
    // Only the upper flank is within the range.
    let high = best((optimum.frequency_hz, range.1), force(limit)).unwrap();
    assert!(near(high.force_n, limit) && high.force_n <= limit);
    assert!(high.frequency_hz > optimum.frequency_hz);
    // A limit that no orbit reaches changes nothing.
    let free = best(range, force(2.0 * optimum.force_n)).unwrap();
    assert!(near(free.frequency_hz, optimum.frequency_hz));
    assert!(best(range, force(1.0)).is_none());
}

/// Where the upper flank alone reaches the limit, the lower flank being weaker throughout.
#[test]
fn the_stronger_flank_is_taken_if_the_lower_one_does_not_reach_the_limit() {
    let made = Made::new(0.0, 0.0);
    let (optimum, _) = made.optimum();
    let range = made.range();
    // The limit forbids a gap about the optimum; the search is kept off most of the lower flank.
    let limit = made.force_at(range.1).max(0.98 * optimum.force_n);
    let found = made.field().best(range, force(limit)).unwrap();
    assert!(found.force_n <= limit && near(found.force_n, limit));
}

#[test]
fn the_allowed_range_ends_where_a_limit_does() {
    let made = Made::new(0.0, 0.0);
    let (optimum, limit) = made.optimum();
    let range = made.range();
    let allowed = |from, limits| made.field().allowed(from, range, limits);
    assert_eq!(allowed(3.0, PickLimits::default()), range);
    let capped = 0.9 * optimum.frequency_hz;
    assert_eq!(
        allowed(0.5 * (range.0 + capped), frequency(capped)),
        (range.0, capped)
    );
    let low = made.field().best(range, force(limit)).unwrap().frequency_hz;
    let (from, to) = allowed(low, force(limit));
    assert_eq!(from, range.0);
    assert!(near(to, low), "{to} {low}");
    let (from, to) = allowed(range.1, force(limit));
    assert!(from > optimum.frequency_hz && near(made.force_at(from), limit));
    assert_eq!(to, range.1);
}

#[test]
fn a_force_limit_holds_for_every_member_at_the_choice_and_where_it_is_allowed() {
    let made = Made::new(0.0, 5.0);
    let (_, limit) = made.optimum();
    // Every member has a stable 1/1 from here on.
    let range = (2.2, made.range().1);
    let choice = made.field().choose(range, force(limit)).unwrap();
    let strongest = choice.spread.strongest_n;
    assert!(strongest <= limit && near(strongest, limit), "{strongest}");
    assert!(choice.orbit.force_n < 0.99 * limit);
    for hz in [choice.allowed.0, choice.allowed.1] {
        let orbit = made.branch.at(hz).unwrap();
        let there = made.field().spread(&orbit).unwrap().strongest_n;
        assert!(there <= limit * (1.0 + 1e-9), "{hz} Hz: {there}");
    }
    let uses: Vec<_> = choice
        .limits
        .iter()
        .map(|l| (l.name, l.limit, l.binds))
        .collect();
    let expected = [
        ("the uncertainty", None, true),
        ("max_force_n", Some(limit), true),
    ];
    assert_eq!(uses, expected);
}

#[test]
fn a_limit_binds_if_dropping_it_gives_more() {
    let made = Made::new(0.0, 0.0);
    let (optimum, limit) = made.optimum();
    let binding = |limits| {
        let choice = made.field().choose(made.range(), limits).unwrap();
        let uses = choice.limits.into_iter();
        uses.map(|l| (l.name, l.binds)).collect::<Vec<_>>()
    };
    assert_eq!(binding(PickLimits::default()), []);
    let below = 0.9 * optimum.frequency_hz;
    let above = 1.01 * optimum.frequency_hz;
    assert_eq!(binding(frequency(below)), [("max_frequency_hz", true)]);
    assert_eq!(binding(frequency(above)), [("max_frequency_hz", false)]);
    let by_drive = drive(drive_force(&WIRES, below));
    assert_eq!(binding(by_drive), [("max_shaker_force_n", true)]);
    assert_eq!(binding(force(limit)), [("max_force_n", true)]);
    assert_eq!(
        binding(force(2.0 * optimum.force_n)),
        [("max_force_n", false)]
    );
    // However little it gives away.
    let barely = force(0.9995 * optimum.force_n);
    assert_eq!(binding(barely), [("max_force_n", true)]);
    // Two limits at the same place: only without both there is more.
    let both = PickLimits {
        max_shaker_force_n: by_drive.max_shaker_force_n,
        ..frequency(below)
    };
    let two = [("max_frequency_hz", true), ("max_shaker_force_n", true)];
    assert_eq!(binding(both), two);
    // The uncertainty is listed with members alone, and binds where it narrows the range.
    let made = Made::new(0.0, 5.0);
    let of = |range| {
        made.field()
            .choose(range, PickLimits::default())
            .unwrap()
            .limits
    };
    let whole = of(made.range());
    assert_eq!((whole.len(), whole[0].binds), (1, false));
    assert!(of((made.range().0, below))[0].binds);
}

#[test]
fn what_has_no_choice_says_why() {
    let made = Made::new(0.0, 0.0);
    let (range_hz, limits) = (made.range(), force(1.0));
    let none = made.field().choose(range_hz, limits).err().unwrap();
    let Error::Pick {
        what: PickError::Limits { feasible, .. },
        ..
    } = &none
    else {
        panic!("{none:?}");
    };
    let feasible = **feasible;
    let what = PickError::Limits {
        range_hz,
        limits,
        feasible: Box::new(feasible),
    };
    assert_eq!(none, made.rig.no_pick(what));
    // What is said to be the nearest limit can be kept, and a little less cannot.
    let least = feasible.max_force_n.unwrap();
    let with = |max: f64| made.field().choose(range_hz, force(max));
    assert!(with(1.0001 * least).is_ok() && with(0.999 * least).is_err());
    let slow = PickLimits {
        max_frequency_hz: Some(0.5 * range_hz.0),
        ..PickLimits::default()
    };
    let feasible = made.field().feasible(range_hz, slow);
    assert_eq!(feasible.max_frequency_hz, Some(range_hz.0));
    assert_eq!(feasible.max_force_n, None);
    // A rig with 60 % more natural frequency has no 1/1 where the nominal one has.
    let far = Made::new(60.0, 0.0);
    let lost = far
        .field()
        .choose(range_hz, PickLimits::default())
        .err()
        .unwrap();
    let (optimum, _) = made.optimum();
    let Error::Pick {
        what: PickError::MemberLost { frequency_hz },
        ..
    } = lost
    else {
        panic!("{lost:?}");
    };
    assert!(near(frequency_hz, optimum.frequency_hz));
}

#[test]
fn the_member_that_breaks_a_limit_is_the_strongest_unless_it_is_known_to() {
    let made = Made::new(0.0, 5.0);
    let field = made.field();
    let spread = Spread {
        least: 1.0,
        most: 10.0,
        weakest_n: 1.0,
        strongest_n: 10.0,
        strongest: Some(1),
        multiplier: 0.5,
    };
    let nominal = Spread {
        strongest: None,
        ..spread
    };
    let [other, strongest] = [0, 1].map(|i| made.members[i..=i].to_vec());
    assert_eq!(
        field.breaks(&spread, &other, force(9.0)),
        strongest.first().cloned()
    );
    assert_eq!(field.breaks(&spread, &strongest, force(9.0)), None);
    assert_eq!(field.breaks(&spread, &[], force(10.0)), None);
    assert_eq!(field.breaks(&nominal, &[], force(9.0)), None);
    assert_eq!(field.breaks(&spread, &[], PickLimits::default()), None);
}

/// Neither alone gives more when it ends, both together do: both decide.
#[test]
fn two_limits_can_decide_together() {
    let limits = PickLimits {
        max_force_n: Some(50.0),
        max_frequency_hz: Some(2.0),
        max_shaker_force_n: Some(900.0),
        rig_shaker_force_n: None,
    };
    let free = |left: PickLimits| left.max_force_n.is_none() && left.max_frequency_hz.is_none();
    let binding = |more: &dyn Fn(PickLimits) -> bool| -> Vec<&str> {
        let uses = limits.which_decide(more).into_iter();
        uses.filter(|l| l.binds).map(|l| l.name).collect()
    };
    let together = |more: &dyn Fn(PickLimits) -> bool| {
        let uses = limits.which_decide(more).into_iter();
        uses.map(|l| l.together).collect::<Vec<_>>()
    };
    assert_eq!(binding(&free), ["max_force_n", "max_frequency_hz"]);
    assert_eq!(together(&free), [true, true, false]);
    let alone = |left: PickLimits| left.max_force_n.is_none();
    assert_eq!(binding(&alone), ["max_force_n"]);
    assert_eq!(together(&alone), [false; 3]);
    assert!(binding(&|_| false).is_empty());
}
