//! The 1/1 of each rig of the uncertainty, found beside the nominal one: a rig lies near the nominal one, and the difference
//! changes slowly with the frequency. Near an end of its 1/1 it is followed closely.

use shared::model::params::RigParams;

use super::search::{follow_member, own_branch};
use crate::branch::{Branch, BranchEnd};
use crate::interpolation::{around, polynomial};
use crate::orbit::{Exactness, Orbit, Section, shoot_at, shoot_to, stable_of_many};
use crate::parallel;
use crate::sweep::spread;
use crate::uncertainty::Member;

/// A rig of the uncertainty and what is known of its stable 1/1.
#[derive(Clone, Debug, PartialEq)]
pub struct Followed {
    /// How far its parameters are off the nominal ones.
    pub member: Member,
    /// Its orbits by rising frequency; empty where it has not been followed.
    pub orbits: Vec<KnownOrbit>,
}

/// An orbit of a rig of the uncertainty, to what a picture shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KnownOrbit {
    /// Drive frequency, Hz.
    pub frequency_hz: f64,
    /// Its contact force, N.
    pub force_n: f64,
    /// Where it lies on the section beside the nominal orbit.
    pub beside: Section,
}

impl KnownOrbit {
    /// Of an orbit and the nominal one at the same frequency.
    pub fn of(orbit: &Orbit, nominal: &Orbit) -> Self {
        let (a, b) = (orbit.at(), nominal.at());
        Self {
            frequency_hz: orbit.frequency_hz,
            force_n: orbit.force_n,
            beside: [0, 1, 2, 3].map(|i| a[i] - b[i]),
        }
    }

    /// Its force and where it lies.
    fn numbers(&self) -> [f64; 5] {
        let [a, b, c, d] = self.beside;
        [self.force_n, a, b, c, d]
    }
}

impl From<Member> for Followed {
    /// One that has not been followed.
    fn from(member: Member) -> Self {
        let orbits = Vec::new();
        Self { member, orbits }
    }
}

impl Followed {
    /// What is known at `frequency_hz`, from the two orbits on either side. None beyond the orbits.
    pub fn known_at(&self, frequency_hz: f64) -> Option<KnownOrbit> {
        let (first, last) = (self.orbits.first()?, self.orbits.last()?);
        if frequency_hz <= first.frequency_hz || frequency_hz > last.frequency_hz {
            return None;
        }
        let near = around(&self.orbits, frequency_hz, 2, |o| o.frequency_hz).iter();
        let near: Vec<_> = near.map(|o| (o.frequency_hz, o.numbers())).collect();
        let [force_n, beside @ ..] = polynomial(&near, frequency_hz);
        Some(KnownOrbit {
            frequency_hz,
            force_n,
            beside,
        })
    }

    /// Its 1/1 at the frequency of the nominal `orbit`, if that is stable.
    pub(super) fn stable_at(&self, nominal: &RigParams, orbit: &Orbit) -> Option<Orbit> {
        let hz = orbit.frequency_hz;
        let known = self.known_at(hz).and_then(|known| {
            let own = self.member.apply(nominal, 1.0);
            let at = orbit.at();
            let guess = [0, 1, 2, 3].map(|i| at[i] + known.beside[i]);
            stable_of_many(&own, hz, guess)
        });
        let followed = || follow_member(nominal, &self.member, orbit, hz);
        known.or_else(followed).filter(Orbit::is_stable_one_one)
    }
}

/// Where a member's 1/1 is stable, Hz, and what is known of it.
pub(super) type Own = ((f64, f64), Followed);

/// A member whose branch has to be looked for.
pub(super) fn along(
    params: &RigParams,
    member: &Member,
    branch: &Branch,
    nominal: &Orbit,
    limits_hz: (f64, f64),
) -> Option<Own> {
    let own = own_branch(params, member, branch, nominal.frequency_hz, limits_hz)?;
    let known = own.orbits.iter().filter_map(|orbit| {
        let nominal = branch.at(orbit.frequency_hz)?;
        Some(KnownOrbit::of(orbit, &nominal))
    });
    let mut orbits: Vec<_> = known.collect();
    orbits.dedup_by(|a, b| a.frequency_hz == b.frequency_hz);
    let member = *member;
    Some((own.range(), Followed { member, orbits }))
}

/// How far apart the frequencies are at which members are followed, as a share of the natural frequency.
const SPACING: f64 = 0.1;

/// Nominal orbits at both ends of a range and between them. None without those at the ends.
pub(super) fn nodes(
    params: &RigParams,
    branch: &Branch,
    (low, high): (f64, f64),
) -> Option<Vec<Orbit>> {
    let steps = ((high - low) / (SPACING * params.natural_frequency_hz())).ceil();
    let hz = spread(low, high, steps.max(2.0) as usize + 1);
    let inside = &hz[1..hz.len() - 1];
    let at = |hz: f64| branch.at(hz);
    let inside = parallel::map(inside, |hz| at(*hz));
    let mut nodes = vec![at(low)?];
    nodes.extend(inside.into_iter().flatten());
    nodes.push(at(high)?);
    Some(nodes)
}

/// A member whose 1/1 is found beside that of the nominal `nodes`, from their middle both ways. None if it has no stable one
/// at the middle.
pub(super) fn across(
    params: &RigParams,
    member: &Member,
    branch: &Branch,
    nodes: &[Orbit],
) -> Option<Own> {
    let rig = member.apply(params, 1.0);
    let (below, above) = nodes.split_at(nodes.len() / 2);
    let (middle, above) = above.split_first()?;
    let hz = middle.frequency_hz;
    let start = surely_stable(&rig, hz, middle.at())
        .or_else(|| follow_member(params, member, middle, hz).filter(Orbit::is_stable_one_one))?;
    let nominal = |hz| branch.at(hz);
    let (mut orbits, low) = one_way(&rig, (&start, middle), below.iter().rev(), nominal);
    let (up, high) = one_way(&rig, (&start, middle), above.iter(), nominal);
    orbits.reverse();
    // Both begin with the middle.
    orbits.extend(&up[1..]);
    let member = *member;
    Some(((low, high), Followed { member, orbits }))
}

/// Orbits of `rig` at the frequencies of the nominal `nodes`, `start` first, which lies beside the nominal `middle`, and the
/// frequency at which its 1/1 ends: that of the last node at most.
fn one_way<'a>(
    rig: &RigParams,
    (start, middle): (&Orbit, &Orbit),
    nodes: impl Iterator<Item = &'a Orbit>,
    nominal: impl Fn(f64) -> Option<Orbit>,
) -> (Vec<KnownOrbit>, f64) {
    let mut last = start.clone();
    let mut orbits = vec![KnownOrbit::of(start, middle)];
    for node in nodes {
        let guess = guess(node, &orbits);
        let sure = surely_stable(rig, node.frequency_hz, guess).map(|next| (next, true));
        let (next, goes_on) = sure.unwrap_or_else(|| to_the_end(rig, &last, node.frequency_hz));
        if !goes_on {
            let known = nominal(next.frequency_hz).map(|nominal| KnownOrbit::of(&next, &nominal));
            orbits.extend(known.filter(|_| next.frequency_hz != last.frequency_hz));
            return (orbits, next.frequency_hz);
        }
        orbits.push(KnownOrbit::of(&next, node));
        last = next;
    }
    (orbits, last.frequency_hz)
}

/// The stable 1/1 of `rig` at `to_hz`, followed from `last`, or its last orbit before, and whether it goes on there.
fn to_the_end(rig: &RigParams, last: &Orbit, to_hz: f64) -> (Orbit, bool) {
    let (from_hz, up) = (last.frequency_hz, to_hz > last.frequency_hz);
    let mut near = Branch::follow(rig, last.clone(), (from_hz.min(to_hz), from_hz.max(to_hz)));
    let edge = if up { near.high } else { near.low };
    if !up {
        near.orbits.reverse();
    }
    let end = near.orbits.pop().unwrap_or_else(|| last.clone());
    (end, edge.end == BranchEnd::SearchLimit)
}

/// Where the orbit beside `node` is sought: on the parabola through the last three.
fn guess(node: &Orbit, orbits: &[KnownOrbit]) -> Section {
    let last = orbits.iter().rev().take(3);
    let last: Vec<_> = last.map(|o| (o.frequency_hz, o.beside)).collect();
    let (at, beside) = (node.at(), polynomial(&last, node.frequency_hz));
    [0, 1, 2, 3].map(|i| at[i] + beside[i])
}

/// The 1/1 of `rig` near `guess`, if it is stable: to what a picture shows where it is far from unstable and from another
/// contact, else exactly.
fn surely_stable(rig: &RigParams, hz: f64, guess: Section) -> Option<Orbit> {
    /// The largest modulus of a multiplier that is far from 1, where it was computed at a guess and not on the orbit.
    const CALM: f64 = 0.8;
    /// A near miss that is none, as a share of A0.
    const CLEAR: f64 = 0.01;
    let drawn = shoot_to(Exactness::DRAWN, rig, hz, guess, 1)?;
    let near_miss_m = drawn.seen.near_miss_m;
    let calm = drawn.multipliers().modulus() < CALM
        && near_miss_m.is_none_or(|m| m > CLEAR * rig.amplitude_m);
    if calm && drawn.is_stable_one_one() {
        return Some(drawn);
    }
    shoot_at(rig, hz, drawn.at(), 1).filter(Orbit::is_stable_one_one)
}
