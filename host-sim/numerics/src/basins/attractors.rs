//! Attractors are distinguished by regime, and two of the same p/n by where their section lies.

use std::collections::HashMap;
use std::fmt;

use serde::{Serialize, Serializer};
use shared::model::regime::Regime;

use super::start::Fate;

/// Two orbits of the same p/n are one attractor when a chain of orbits leads from one to the other whose sections' middles
/// lie no farther apart than about this, in A0 and A0 Ω. A run that counts as periodic may still be some
/// [`shared::model::regime::SECTION_TOLERANCE`] per cycle away from where it is going, so this is much wider.
const NEAR: f64 = 0.05;

/// The kind of motion of an attractor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AttractorKind {
    /// None: the hammer could not be followed.
    Failed,
    /// No contact in the recorded drive cycles.
    NoImpact,
    /// None yet: nothing repeats, and the motion still changes.
    Unsettled,
    /// Nothing repeats, whatever the number of contacts and whether or not there was chatter.
    Aperiodic,
    /// z = p/n with chatter.
    Chatter {
        /// Contacts per repetition, p.
        impacts: u16,
        /// Drive periods per repetition, n.
        periods: u8,
    },
    /// z = p/n without chatter: p contacts in n drive periods, after which the section repeats.
    Periodic {
        /// Contacts per repetition, p.
        impacts: u16,
        /// Drive periods per repetition, n.
        periods: u8,
    },
}

impl From<Regime> for AttractorKind {
    fn from(regime: Regime) -> Self {
        match regime {
            Regime::None => Self::NoImpact,
            Regime::Aperiodic { .. } | Regime::Chatter { periods: None, .. } => Self::Aperiodic,
            Regime::Chatter {
                impacts,
                periods: Some(periods),
            } => Self::Chatter { impacts, periods },
            Regime::Periodic { impacts, periods } => Self::Periodic { impacts, periods },
        }
    }
}

/// What an attractor is called: "p/n", "chatter p/n", "no impact", "aperiodic" or "unsettled", with a letter if several are of one kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AttractorName {
    /// The kind of motion.
    pub kind: AttractorKind,
    /// Which of its kind, from 0, the one with the most starts first; `None` if there is no other.
    pub number: Option<usize>,
}

impl fmt::Display for AttractorKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Failed => f.write_str("failed"),
            Self::NoImpact => f.write_str("no impact"),
            Self::Unsettled => f.write_str("unsettled"),
            Self::Aperiodic => f.write_str("aperiodic"),
            Self::Chatter { impacts, periods } => write!(f, "chatter {impacts}/{periods}"),
            Self::Periodic { impacts, periods } => write!(f, "{impacts}/{periods}"),
        }
    }
}

impl fmt::Display for AttractorName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.number {
            Some(number) => f.pad(&format!("{} {}", self.kind, letters(number))),
            None => f.pad(&self.kind.to_string()),
        }
    }
}

impl Serialize for AttractorName {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

/// One way in which hammers end.
#[derive(Clone, Debug, PartialEq)]
pub struct Attractor {
    /// Name: kind of motion, with a letter where several attractors are of one kind.
    pub name: AttractorName,
    /// The regime of the first start that ends here.
    pub regime: Regime,
    /// Middle of its section, in A0 and A0 Ω of the rig's coordinate, if it repeats: of the start that settled first.
    pub middle: Option<[f64; 2]>,
    /// Largest contact force of any start that ends here, N.
    pub force_n: f64,
    /// Starts that end here.
    pub count: usize,
}

/// The attractors that `fates` end in, largest first, and which one each ends in.
///
/// All motions without contact are one attractor: without damping they go on as they began. All motions that do not
/// repeat are one, too: after a few hundred cycles nothing distinguishes two of them.
pub fn tell_apart(fates: &[Fate]) -> (Vec<Attractor>, Vec<u16>) {
    let mut by_kind: Vec<(AttractorKind, Vec<usize>)> = Vec::new();
    for (i, fate) in fates.iter().enumerate() {
        let kind = match AttractorKind::from(fate.regime) {
            _ if fate.failed => AttractorKind::Failed,
            _ if fate.unsettled => AttractorKind::Unsettled,
            kind => kind,
        };
        match by_kind.iter_mut().find(|(other, _)| *other == kind) {
            Some((_, members)) => members.push(i),
            None => by_kind.push((kind, vec![i])),
        }
    }
    let mut groups: Vec<(AttractorName, Vec<usize>)> = Vec::new();
    for (kind, members) in by_kind {
        let mut clusters = near_together(fates, members);
        clusters.sort_by_key(|members| (std::cmp::Reverse(members.len()), members[0]));
        let several = clusters.len() > 1;
        groups.extend(clusters.into_iter().enumerate().map(|(k, members)| {
            let number = several.then_some(k);
            (AttractorName { kind, number }, members)
        }));
    }
    groups.sort_by_key(|(_, members)| (std::cmp::Reverse(members.len()), members[0]));
    let mut which = vec![0; fates.len()];
    let mut attractors = Vec::with_capacity(groups.len());
    for (number, (name, members)) in (0_u16..).zip(groups) {
        for i in &members {
            which[*i] = number;
        }
        // Who settled first has had the most time since.
        let first = members
            .iter()
            .min_by_key(|i| fates[**i].settled_after.unwrap_or(u32::MAX));
        attractors.push(Attractor {
            name,
            regime: fates[members[0]].regime,
            middle: first.and_then(|i| fates[*i].middle),
            force_n: members
                .iter()
                .map(|i| fates[*i].force_n)
                .fold(0.0, f64::max),
            count: members.len(),
        });
    }
    (attractors, which)
}

/// a, b, … z, aa, ab, …
fn letters(k: usize) -> String {
    let letter = char::from(b'a' + (k % 26) as u8);
    match k / 26 {
        0 => letter.to_string(),
        more => format!("{}{letter}", letters(more - 1)),
    }
}

/// `members` split into those whose sections lie near together. Middles are put into bins [`NEAR`] wide; bins that touch
/// belong together.
fn near_together(fates: &[Fate], members: Vec<usize>) -> Vec<Vec<usize>> {
    let bin = |i: usize| {
        let middle = fates[i].middle.unwrap_or_default();
        middle.map(|x| (x / NEAR).floor() as i64)
    };
    let mut bins: HashMap<[i64; 2], Vec<usize>> = HashMap::new();
    let mut order = Vec::new();
    for i in members {
        let bin = bin(i);
        bins.entry(bin).or_insert_with(|| {
            order.push(bin);
            Vec::new()
        });
        bins.get_mut(&bin).expect("just made").push(i);
    }
    let mut clusters = Vec::new();
    for seed in order {
        let Some(mut cluster) = bins.remove(&seed) else {
            continue;
        };
        let mut open = vec![seed];
        while let Some([x, y]) = open.pop() {
            for (dx, dy) in (-1..=1).flat_map(|dx| (-1..=1).map(move |dy| (dx, dy))) {
                let beside = [x + dx, y + dy];
                if let Some(more) = bins.remove(&beside) {
                    cluster.extend(more);
                    open.push(beside);
                }
            }
        }
        cluster.sort_unstable();
        clusters.push(cluster);
    }
    clusters
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fate(regime: Regime, middle: Option<[f64; 2]>) -> Fate {
        Fate {
            start: [0.0; 2],
            regime,
            middle,
            force_n: 1.0,
            settled_after: middle.map(|_| 10),
            last_contact: None,
            uncertain: false,
            unsettled: false,
            failed: false,
        }
    }

    const ONE: Regime = Regime::Periodic {
        impacts: 1,
        periods: 1,
    };

    #[test]
    fn orbits_of_the_same_p_n_far_apart_are_two_and_near_are_one() {
        let at = |x: f64, y: f64| fate(ONE, Some([x, y]));
        let fates = [at(0.0, 0.0), at(1.0, 1.0), at(0.01, -0.01), at(0.0, 0.02)];
        let (attractors, which) = tell_apart(&fates);
        let names: Vec<_> = attractors
            .iter()
            .map(|a| (a.name.to_string(), a.count))
            .collect();
        assert_eq!(names, [("1/1 a".into(), 3), ("1/1 b".into(), 1)]);
        assert_eq!(which, [0, 1, 0, 0]);
        assert_eq!(tell_apart(&fates[2..]).0[0].name.to_string(), "1/1");
    }

    #[test]
    fn what_still_changes_is_not_aperiodic() {
        let changes = |unsettled| Fate {
            unsettled,
            ..fate(Regime::Aperiodic { impacts: 3 }, None)
        };
        let (attractors, which) = tell_apart(&[changes(false), changes(true), changes(true)]);
        let names: Vec<_> = attractors.iter().map(|a| a.name.to_string()).collect();
        assert_eq!(names, ["unsettled", "aperiodic"]);
        assert_eq!(which, [1, 0, 0]);
    }

    #[test]
    fn what_never_repeats_is_one_whatever_its_contacts() {
        let fates = [
            fate(Regime::Aperiodic { impacts: 3 }, None),
            fate(Regime::None, None),
            fate(
                Regime::Chatter {
                    impacts: 9,
                    periods: None,
                },
                None,
            ),
            fate(
                Regime::Periodic {
                    impacts: 1,
                    periods: 2,
                },
                Some([0.0; 2]),
            ),
        ];
        let (attractors, which) = tell_apart(&fates);
        let names: Vec<_> = attractors.iter().map(|a| a.name.to_string()).collect();
        assert_eq!(names, ["aperiodic", "no impact", "1/2"]);
        assert_eq!(which, [0, 1, 0, 2]);
    }

    #[test]
    fn letters_go_on_after_z() {
        assert_eq!([0, 25, 26, 27].map(letters), ["a", "z", "aa", "ab"]);
    }
}
