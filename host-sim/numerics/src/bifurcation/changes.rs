//! Where a diagram changes: the number of its branches, or a branch that breaks off; and where two directions differ.

use serde::Serialize;

use shared::model::regime::Regime;

use super::{BifurcationDiagram, Station};
use crate::error::Error;
use crate::lanes::{Cell, CellOutcome};
use crate::row::{Outcome as Ended, kind, regime_as_text};

/// What happens between two neighbouring frequencies, read by rising frequency.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ChangeKind {
    /// n and p become twice as many.
    Doubling,
    /// n and p become half as many.
    Halving,
    /// From a motion without contact to one with contact.
    ContactBegins,
    /// From a motion with contact to one without.
    ContactEnds,
    /// A motion that repeats is followed by one that does not within 16 periods.
    LosesPeriod,
    /// A motion that does not repeat within 16 periods is followed by one that does.
    FindsPeriod,
    /// As many periods, another number of contacts: a contact grazes in or out.
    Contacts,
    /// Another p/n that is none of these.
    Other,
    /// p/n stays as it is, but the points of the section leap.
    Jump,
}

impl ChangeKind {
    /// What happens, in a few words for a person, such as "period doubles".
    pub fn words(self) -> &'static str {
        match self {
            Self::Doubling => "period doubles",
            Self::Halving => "period halves",
            Self::ContactBegins => "contact begins",
            Self::ContactEnds => "contact ends",
            Self::LosesPeriod => "no longer repeats",
            Self::FindsPeriod => "repeats again",
            Self::Contacts => "another number of contacts",
            Self::Other => "another p/n",
            Self::Jump => "jump",
        }
    }
}

/// A change between two neighbouring frequencies.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RegimeChange {
    /// What kind of change it is.
    pub kind: ChangeKind,
    /// Regime at the lower of the two frequencies.
    #[serde(serialize_with = "regime_as_text")]
    pub below: Regime,
    /// Regime at the higher of the two frequencies.
    #[serde(serialize_with = "regime_as_text")]
    pub above: Regime,
    /// Where, Hz: the middle of what it was narrowed down to.
    pub frequency_hz: f64,
    /// Frequency of the change over the natural frequency, Ω/ω.
    pub frequency_ratio: f64,
    /// Half the width of what it was narrowed down to, Hz.
    pub within_hz: f64,
    /// Branches (points of the section) below and above; none where the motion does not repeat.
    pub branches: [Option<u8>; 2],
    /// Whether both sides last for three frequencies at least, or one is a periodic motion that lasts for ten: a lasting
    /// change, not one of the many within chaos.
    pub lasting: bool,
    /// Stations it lies between.
    #[serde(skip)]
    span: std::ops::Range<usize>,
}

/// A range of frequencies over which two directions end differently.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Twofold {
    /// Clearance at rest, mm.
    pub gap_mm: f64,
    /// First frequency of the range, Hz, inclusive.
    pub from_hz: f64,
    /// Last frequency of the range, Hz, inclusive.
    pub to_hz: f64,
    /// Regime carried up, at the first.
    pub up: Ended,
    /// Regime carried down, at the first.
    pub down: Ended,
}

/// Frequencies a regime must last for to count as lasting.
const LASTING: usize = 3;
/// Frequencies after which the end of a periodic motion counts as lasting whatever stands beside it: at 2.4 mm the 1/1
/// ends in a strip of chaos two frequencies wide.
const LONG: usize = 10;
/// A jump moves the points by more than this share of A0, and by [`LEAP`] times what their neighbours move.
const JUMP_SHARE: f64 = 0.1;
const LEAP: f64 = 6.0;
/// Motions of more periods than this have too many points to follow each of them.
const MOST_FOLLOWED: u8 = 4;
/// Times the interval with a change in it is halved.
const HALVINGS: usize = 10;

/// Every change between neighbouring stations, not narrowed down.
///
/// Beside a doubling transients are long: a few stations there may not have settled. Where they alone part a motion from
/// the same one doubled or halved, that is one change. Of stations none of which has settled nothing is known: there is no
/// change to or from them.
pub fn find(diagram: &BifurcationDiagram) -> Vec<RegimeChange> {
    let stations = &diagram.stations;
    let mut runs: Vec<std::ops::Range<usize>> = Vec::new();
    for k in 0..stations.len() {
        match runs.last_mut() {
            Some(run) if alike(&stations[run.start], &stations[k]) => run.end = k + 1,
            _ => runs.push(k..k + 1),
        }
    }
    let known =
        |run: &std::ops::Range<usize>| !stations[run.clone()].iter().all(|s| s.row.unsettled());
    let few = |run: &std::ops::Range<usize>| {
        let first = &stations[run.start];
        run.len() < LASTING && !first.row.failed && label(first) == APERIODIC
    };
    let mut changes = Vec::new();
    let mut at = 0;
    while at < runs.len() {
        let run = runs[at].clone();
        let amplitude_mm = diagram.params.amplitude_m * 1e3;
        let leaping = (run.start + 1..run.end).filter(|k| leaps(stations, *k, amplitude_mm));
        changes.extend(
            leaping.map(|k| change(diagram, k - 1..k, ChangeKind::Jump, run.len() > LASTING)),
        );
        let next = |ahead: usize| runs.get(at + ahead);
        let over = next(1).filter(|r| few(r)).and_then(|_| next(2));
        let ahead = match over.map(|r| between(&stations[run.end - 1], &stations[r.start])) {
            Some(Some(ChangeKind::Doubling | ChangeKind::Halving)) => 2,
            Some(_) if next(1).is_some_and(|r| !known(r)) => 2,
            _ => 1,
        };
        if let Some(other) = next(ahead).filter(|other| known(&run) && known(other)) {
            let span = run.end - 1..other.start;
            if let Some(kind) = between(&stations[span.start], &stations[span.end]) {
                let long = |run: &[Station]| run.len() >= LONG && run[0].row.periods.is_some();
                let both = run.len() >= LASTING && other.len() >= LASTING;
                let lasting =
                    both || long(&stations[run.clone()]) || long(&stations[other.clone()]);
                changes.push(change(diagram, span, kind, lasting));
            }
        }
        at += ahead;
    }
    changes
}

/// The change between the stations at both ends of `span`.
fn change(
    diagram: &BifurcationDiagram,
    span: std::ops::Range<usize>,
    kind: ChangeKind,
    lasting: bool,
) -> RegimeChange {
    let (a, b) = (&diagram.stations[span.start], &diagram.stations[span.end]);
    let (low, high) = (a.row.frequency_hz, b.row.frequency_hz);
    let frequency_hz = 0.5 * (low + high);
    RegimeChange {
        kind,
        below: label(a),
        above: label(b),
        frequency_hz,
        frequency_ratio: frequency_hz / diagram.params.natural_frequency_hz(),
        within_hz: 0.5 * (high - low),
        branches: [a, b].map(|s| label(s).periods()),
        lasting,
        span,
    }
}

/// What counts as the same motion: p/n; all that does not repeat is one. Where an alternation dies out, it is half of p/n.
fn label(station: &Station) -> Regime {
    let dies = station.row.unsettled() && !station.grows;
    match station.row.regime {
        Regime::Periodic { impacts, periods } if dies => Regime::Periodic {
            impacts: impacts / 2,
            periods: periods / 2,
        },
        regime if regime.periods().is_none() && regime != Regime::None => APERIODIC,
        regime => kind(regime),
    }
}

/// Whether two stations show the same motion, or both failed.
fn alike(a: &Station, b: &Station) -> bool {
    a.row.failed == b.row.failed && label(a) == label(b)
}

const APERIODIC: Regime = Regime::Aperiodic { impacts: 0 };

/// What lies between two motions; none if they have the same name, or if one of them is not known.
fn between(a: &Station, b: &Station) -> Option<ChangeKind> {
    if a.row.failed || b.row.failed {
        return None;
    }
    between_labels(label(a), label(b))
}

fn between_labels(a: Regime, b: Regime) -> Option<ChangeKind> {
    if a == b {
        return None;
    }
    Some(match (a.periods(), b.periods()) {
        _ if a == Regime::None => ChangeKind::ContactBegins,
        _ if b == Regime::None => ChangeKind::ContactEnds,
        (Some(_), None) => ChangeKind::LosesPeriod,
        (None, Some(_)) => ChangeKind::FindsPeriod,
        (None, None) => ChangeKind::Other,
        (Some(n), Some(m)) => {
            let (p, q) = (u32::from(a.impacts()), u32::from(b.impacts()));
            let (n, m) = (u32::from(n), u32::from(m));
            if m == 2 * n && q == 2 * p {
                ChangeKind::Doubling
            } else if n == 2 * m && p == 2 * q {
                ChangeKind::Halving
            } else if n == m && p != q {
                ChangeKind::Contacts
            } else {
                ChangeKind::Other
            }
        }
    })
}

/// Whether the points of a motion that repeats leap between stations k − 1 and k, though its name stays.
fn leaps(stations: &[Station], k: usize, amplitude_mm: f64) -> bool {
    let here = moved(&stations[k - 1], &stations[k]);
    let beside = |a: usize, b: usize| match (stations.get(a), stations.get(b)) {
        (Some(a), Some(b)) if label(a) == label(b) => moved(a, b),
        _ => None,
    };
    let before = k.checked_sub(2).and_then(|a| beside(a, k - 1));
    let after = beside(k, k + 1);
    let usual = before.into_iter().chain(after).reduce(f64::max);
    let usual = usual.unwrap_or(0.0);
    here.is_some_and(|d| d > JUMP_SHARE * amplitude_mm && d > LEAP * usual)
}

/// How far the points of two motions of the same n lie apart, mm: the largest distance, in order of size.
fn moved(a: &Station, b: &Station) -> Option<f64> {
    let sorted = |s: &Station| {
        let n = usize::from(s.row.periods.filter(|n| *n <= MOST_FOLLOWED)?);
        let last = s.points.len().checked_sub(n)?;
        let mut x: Vec<f64> = s.points[last..].iter().map(|p| p.displacement_mm).collect();
        x.sort_by(f64::total_cmp);
        Some(x)
    };
    let (x, y) = (sorted(a)?, sorted(b)?);
    let apart = x.iter().zip(&y).map(|(a, b)| (a - b).abs());
    (x.len() == y.len()).then(|| apart.fold(0.0, f64::max))
}

/// Narrows the lasting changes of a diagram down by halving the interval between the two frequencies, each run
/// beginning where the frequency on the side one comes from began. Where that finds a third motion beside the change, the change is
/// from or to that one.
pub fn locate(
    diagram: &mut BifurcationDiagram,
    run: &impl Fn(&[Cell]) -> Result<Vec<Option<CellOutcome>>, Error>,
) -> Result<(), Error> {
    let down = diagram.direction == crate::sweep::Direction::Down;
    let natural = diagram.params.natural_frequency_hz();
    let mut open: Vec<OpenChange> = Vec::new();
    for (i, change) in diagram.changes.iter().enumerate() {
        if change.lasting && change.kind != ChangeKind::Jump {
            let (a, b) = (
                &diagram.stations[change.span.start],
                &diagram.stations[change.span.end],
            );
            open.push(OpenChange {
                index: i,
                hz: [a.row.frequency_hz, b.row.frequency_hz],
                start: if down { a.start } else { b.start },
                motions: [change.below, change.above],
            });
        }
    }
    for _ in 0..HALVINGS {
        let cells = open.iter().map(|change| Cell {
            params: diagram.params,
            frequency_hz: change.middle_hz(),
            start: change.start,
            phase: 0.0,
        });
        let cells: Vec<_> = cells.collect();
        let outcomes = run(&cells)?;
        for (inside, (cell, outcome)) in open.iter_mut().zip(cells.iter().zip(outcomes)) {
            // A run that failed tells nothing: the change stays where it is.
            let Some(outcome) = outcome else {
                continue;
            };
            let found = super::station("", cell, &outcome)?;
            let change = &diagram.changes[inside.index];
            let below = label(&diagram.stations[change.span.start]) == label(&found);
            let above = label(&diagram.stations[change.span.end]) == label(&found);
            // Something else in between belongs to the side that does not repeat, or to what is come to.
            let is_below = below || (!above && (is_chaos(change.below) || down));
            let side = usize::from(!is_below);
            inside.hz[side] = cell.frequency_hz;
            // What alternates beside a doubling has not settled.
            if !found.row.unsettled() {
                inside.motions[side] = label(&found);
            }
        }
    }
    for inside in open {
        let change = &mut diagram.changes[inside.index];
        let [below, above] = inside.motions;
        if let Some(kind) = between_labels(below, above) {
            (change.kind, change.below, change.above) = (kind, below, above);
            change.branches = inside.motions.map(Regime::periods);
        }
        change.frequency_hz = inside.middle_hz();
        change.frequency_ratio = change.frequency_hz / natural;
        change.within_hz = 0.5 * (inside.hz[1] - inside.hz[0]);
    }
    Ok(())
}

/// A change that is being narrowed down.
struct OpenChange {
    /// Its place in the list of changes.
    index: usize,
    /// The interval it lies in, Hz, and the motions at both ends of it.
    hz: [f64; 2],
    motions: [Regime; 2],
    /// The state to begin from.
    start: [f64; 2],
}

impl OpenChange {
    fn middle_hz(&self) -> f64 {
        0.5 * (self.hz[0] + self.hz[1])
    }
}

fn is_chaos(regime: Regime) -> bool {
    matches!(regime, Regime::Aperiodic { .. } | Regime::Chatter { .. })
}

/// Where the diagrams up and down differ: [`crate::sweep::jumps`] of their forces at a fifth, as ranges.
pub fn twofold(up: &BifurcationDiagram, down: &BifurcationDiagram) -> Vec<Twofold> {
    const SHARE: f64 = 0.2;
    let rows =
        |d: &BifurcationDiagram| d.stations.iter().map(|s| s.row.clone()).collect::<Vec<_>>();
    let (up_rows, down_rows) = (rows(up), rows(down));
    let weight = up.params.weight_n();
    let differing = crate::sweep::jumps(&up_rows, &down_rows, weight, SHARE);
    let index = |hz: f64| up_rows.iter().position(|r| r.frequency_hz == hz);
    let indices: Vec<usize> = differing.into_iter().filter_map(index).collect();
    let ranges = indices.chunk_by(|a, b| b - a == 1);
    let range = |r: &[usize]| Twofold {
        gap_mm: up.gap_mm,
        from_hz: up_rows[r[0]].frequency_hz,
        to_hz: up_rows[r[r.len() - 1]].frequency_hz,
        up: up_rows[r[0]].outcome,
        down: down_rows[r[0]].outcome,
    };
    ranges.map(range).collect()
}
