//! Every curve of orbits that simulation at some frequencies (or gaps) finds, and the doubled ones they lead to.

use shared::model::contact::Law;
use shared::model::params::RigParams;
use shared::model::regime::Regime;
use shared::model::rig::Rig;

use super::family::{Along, CurvePlace, Family, Node, UP, between, dot, minus};
use super::march::both_ways;
use super::switching::doubled;
use super::{CurveEnd, Special, Until, march};
use crate::engine::Start;
use crate::error::Error;
use crate::lanes::{self, Cell, CellPlan};
use crate::orbit::{Stability, on_course};
use crate::progress::{Progress, check, step};
use crate::range::within;

/// What is searched for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OrbitsRequest {
    /// Parameter that is varied along the curves.
    pub along: Along,
    /// From and to, as values of the parameter: Ω/ω, gap/A0, or a number of the rig over its unit.
    pub limits: (f64, f64),
    /// Orbits of up to so many drive periods.
    pub periods: u8,
    /// Orbits of up to so many contacts.
    pub impacts: u16,
    /// Values of the parameter at which simulations search for orbits.
    pub starts: usize,
    /// Values of the parameter at which simulations check afterwards whether an orbit was missed.
    pub checks: usize,
}

impl OrbitsRequest {
    /// Refuses a search that would be too long, or for orbits too intricate to find.
    ///
    /// # Errors
    /// If a number is out of its range.
    pub fn check(&self) -> Result<(), Error> {
        within([
            ("periods", f64::from(self.periods), 1.0, 8.0),
            ("impacts", f64::from(self.impacts), 1.0, 16.0),
            ("starts", self.starts as f64, 1.0, 2000.0),
        ])
    }

    /// Checks where nobody says how many: forty times the starts; twice with a nonlinear law, whose simulations take longer.
    pub fn usual_checks(params: &RigParams, starts: usize) -> usize {
        let fast = matches!(params.contact, Law::SpringDashpot { .. });
        starts * if fast { 40 } else { 2 }
    }

    /// Simulations that search for orbits: the steps of progress that [`diagram`] reports.
    pub fn simulations(&self) -> u64 {
        (STARTS * (self.starts + self.checks)) as u64
    }
}

/// Starts at each value of the parameter: from rest, and from two pushes.
const STARTS: usize = 3;

/// Where a curve was found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CurveOrigin {
    /// A simulation settled on it.
    Simulation,
    /// It leaves this curve (by index) at a period doubling.
    Doubling(usize),
}

/// A curve of orbits of one kind.
#[derive(Clone, Debug)]
pub struct OrbitCurve {
    /// Its orbits, in order along it.
    pub nodes: Vec<Node>,
    /// How it ends, at the first and at the last orbit.
    pub ends: [CurveEnd; 2],
    /// Where it was found.
    pub origin: CurveOrigin,
    family: Family,
}

impl OrbitCurve {
    /// Drive periods of its orbits.
    pub fn periods(&self) -> u8 {
        self.family.periods()
    }

    /// Contacts of its orbits.
    pub fn impacts(&self) -> u16 {
        self.nodes.first().map_or(0, |n| n.orbit.impacts)
    }

    /// z = p/n of its orbits.
    pub fn regime(&self) -> Regime {
        Regime::Periodic {
            impacts: self.impacts(),
            periods: self.periods(),
        }
    }

    /// The special points along it.
    pub fn specials(&self) -> impl Iterator<Item = (&Node, Special)> {
        self.nodes.iter().filter_map(|n| Some((n, n.special?)))
    }

    /// The curve through `seed`, followed both ways.
    fn through(family: Family, seed: Node, limits: (f64, f64), origin: CurveOrigin) -> Self {
        let march = |from: &Node| march(&family, from, limits, Until::End);
        let (nodes, ends) = both_ways(seed, Node::turned, march);
        Self {
            nodes,
            ends,
            origin,
            family,
        }
    }

    /// Neighbouring orbits between which the parameter is, and how far from the first to the second.
    fn pairs_at(&self, parameter: f64) -> impl Iterator<Item = (&Node, &Node, f64)> {
        let pairs = self.nodes.windows(2).map(move |pair| {
            let (a, b) = (&pair[0], &pair[1]);
            (
                a,
                b,
                (parameter - a.parameter()) / (b.parameter() - a.parameter()),
            )
        });
        pairs.filter(|(.., s)| (0.0..=1.0).contains(s))
    }

    /// Whether one of its orbits at the parameter of `place` has a section point there, as the chord between two
    /// orbits tells.
    fn is_near(&self, place: CurvePlace) -> bool {
        self.pairs_at(place[2]).any(|(a, b, s)| {
            let mut strobes = a.orbit.strobes.iter().zip(&b.orbit.strobes);
            let alike = a.orbit.strobes.len() == b.orbit.strobes.len();
            alike
                && strobes.any(|(x, y)| {
                    let from = self.family.place(on_course(*x), a.parameter());
                    let to = self.family.place(on_course(*y), b.parameter());
                    let step = minus(to, from);
                    let off = minus(place, between(from, to, s));
                    let [q, v, ..] = off;
                    // A curve that turns by 18° per step leaves its chord by a twenty-fifth of it.
                    q.hypot(v) < 1e-4 + 0.1 * dot(step, step).sqrt()
                })
        })
    }

    /// Whether `node` is one of its orbits, whichever of its section points it starts from.
    fn passes(&self, node: &Node) -> bool {
        /// Orbits are the same when their section points differ by less, in units of a place.
        const SAME: f64 = 1e-6;
        let parameter = node.parameter();
        let strobes = &node.orbit.strobes;
        self.pairs_at(parameter).any(|(a, b, s)| {
            let mut guess = between(a.place, b.place, s);
            guess[2] = parameter;
            let step = minus(b.place, a.place);
            // By the hammer alone: what the cart does follows from it.
            let near = |place: CurvePlace, reach: f64| {
                strobes.iter().any(|x| {
                    let there = self.family.place(on_course(*x), parameter);
                    let [q, v, parameter, ..] = minus(place, there);
                    let off = [q, v, parameter, 0.0, 0.0];
                    dot(off, off).sqrt() < reach
                })
            };
            near(guess, 0.01 + dot(step, step).sqrt())
                && self
                    .family
                    .correct(guess, UP)
                    .is_some_and(|own| near(own.place, SAME))
        })
    }
}

/// All the curves of one rig over one parameter.
#[derive(Clone, Debug)]
pub struct OrbitDiagram {
    /// The rig; along [`Along::Gap`] its gap is not used.
    pub params: RigParams,
    /// What was searched for.
    pub request: OrbitsRequest,
    /// The curves, in the order in which they were found.
    pub curves: Vec<OrbitCurve>,
    /// Regimes that simulations settled on and that lie on none of the curves.
    pub elsewhere: Vec<SettledRegime>,
    /// Simulations that searched and checked.
    pub simulations: usize,
    /// How many of them left what the model describes.
    pub failed: usize,
}

/// A regime that a simulation settled on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SettledRegime {
    /// Value of the parameter: Ω/ω, gap/A0, or a number of the rig over its unit.
    pub parameter: f64,
    /// Contacts per repetition, p.
    pub impacts: u16,
    /// Drive periods per repetition, n.
    pub periods: u8,
}

/// How long a simulation may take to settle.
const SETTLE: CellPlan = CellPlan {
    cycles: 400,
    recorded: 64,
    early: true,
    strobes: 0,
};

/// Finds and follows the curves: those on which simulations at `starts` values of the parameter settle, what they lead
/// to, and then those on which simulations at `checks` values settle and that were missed.
///
/// # Errors
/// If a parameter is out of range, or if the work is interrupted.
pub fn diagram(
    params: &RigParams,
    request: &OrbitsRequest,
    progress: &dyn Progress,
) -> Result<OrbitDiagram, Error> {
    let family = Family::new(params, request.along, 1)?;
    let mut diagram = OrbitDiagram {
        params: *params,
        request: *request,
        curves: Vec::new(),
        elsewhere: Vec::new(),
        simulations: 0,
        failed: 0,
    };
    for (values, checking) in [(request.starts, false), (request.checks, true)] {
        let (found, failed) = seeds(&family, request, values)?;
        let simulations = STARTS * values;
        diagram.simulations += simulations;
        diagram.failed += failed;
        step(progress, (simulations - found.len()) as u64)?;
        for seed in found {
            step(progress, 1)?;
            if !(checking && diagram.has(&family, &seed)) {
                diagram.take(&family, &seed, progress)?;
            }
        }
    }
    Ok(diagram)
}

impl OrbitDiagram {
    /// Follows the curve on which a simulation settled, if it is a new one.
    fn take(&mut self, family: &Family, seed: &Seed, progress: &dyn Progress) -> Result<(), Error> {
        let family = family.with_periods(seed.at.periods);
        let node = family.node_at(seed.at.parameter, on_course(seed.section));
        let own = node.filter(|node| {
            node.orbit.impacts == seed.at.impacts && node.orbit.stability() != Stability::Unstable
        });
        let Some(node) = own else {
            self.elsewhere.push(seed.at);
            return Ok(());
        };
        if let Some(shorter) = shorter(&family, &node, seed) {
            return self.take(&family, &shorter, progress);
        }
        if known(&self.curves, &node) {
            return Ok(());
        }
        let origin = CurveOrigin::Simulation;
        let limits = self.request.limits;
        let curve = OrbitCurve::through(family, node, limits, origin);
        // Between a doubling and the first orbit of the doubled curve lie orbits of that curve.
        let middle = &curve.nodes[curve.nodes.len() / 2];
        if curve.ends.contains(&CurveEnd::Halved) && known(&self.curves, middle) {
            return Ok(());
        }
        self.curves.push(curve);
        let newest = self.curves.len() - 1;
        follow_doublings(&mut self.curves, newest, &self.request, progress)
    }

    /// Whether a simulation settled on one of the curves, judged by its section alone.
    fn has(&self, family: &Family, seed: &Seed) -> bool {
        let place = family.place(on_course(seed.section), seed.at.parameter);
        let alike =
            |c: &&OrbitCurve| c.periods() == seed.at.periods && c.impacts() == seed.at.impacts;
        (self.curves.iter().filter(alike)).any(|c| c.is_near(place))
    }
}

/// The seed of an orbit that repeats sooner than the simulation did: close to a period doubling a run settles so slowly
/// that the halves of its section differ.
fn shorter(family: &Family, node: &Node, seed: &Seed) -> Option<Seed> {
    /// Section points closer than this, in units of a place, are one.
    const SAME: f64 = 1e-6;
    let periods = seed.at.periods;
    let factor = (2..=periods).rev().find(|factor| {
        let apart = family.place(on_course(node.orbit.asymmetry(*factor, [1.0; 2])), 0.0);
        periods.is_multiple_of(*factor)
            && seed.at.impacts.is_multiple_of(u16::from(*factor))
            && dot(apart, apart).sqrt() < SAME
    })?;
    let at = SettledRegime {
        impacts: seed.at.impacts / u16::from(factor),
        periods: periods / factor,
        ..seed.at
    };
    let section = node.orbit.section;
    Some(Seed { at, section })
}

fn known(curves: &[OrbitCurve], node: &Node) -> bool {
    let alike =
        |c: &&OrbitCurve| c.periods() == node.orbit.periods && c.impacts() == node.orbit.impacts;
    curves.iter().filter(alike).any(|c| c.passes(node))
}

/// Adds the doubled curves that leave the curves from index `from` on.
fn follow_doublings(
    curves: &mut Vec<OrbitCurve>,
    from: usize,
    request: &OrbitsRequest,
    progress: &dyn Progress,
) -> Result<(), Error> {
    let mut index = from;
    while index < curves.len() {
        let family = curves[index].family;
        let doublings: Vec<Node> = curves[index]
            .specials()
            .filter(|(_, kind)| *kind == Special::PeriodDoubling)
            .map(|(node, _)| node.clone())
            .collect();
        for node in doublings {
            check(progress)?;
            let enough =
                2 * family.periods() > request.periods || 2 * node.orbit.impacts > request.impacts;
            let start = (!enough).then(|| doubled(&family, &node)).flatten();
            let Some((twice, start)) = start.filter(|(_, start)| !known(curves, start)) else {
                continue;
            };
            let (ahead, end) = march(&twice, &start, request.limits, Until::End);
            let mut nodes = vec![start];
            nodes.extend(ahead);
            curves.push(OrbitCurve {
                nodes,
                ends: [CurveEnd::Special(Special::PeriodDoubling), end],
                origin: CurveOrigin::Doubling(index),
                family: twice,
            });
        }
        index += 1;
    }
    Ok(())
}

/// What a simulation settled on, and the section at its end.
struct Seed {
    at: SettledRegime,
    section: [f64; 2],
}

/// Orbits on which simulations at so many values of the parameter settled, shorter periods first; and how many of the
/// simulations left what the model describes.
fn seeds(
    family: &Family,
    request: &OrbitsRequest,
    values: usize,
) -> Result<(Vec<Seed>, usize), Error> {
    let (low, high) = request.limits;
    let mut cells = Vec::new();
    let mut parameters = Vec::new();
    for i in 0..values {
        let s = (i as f64 + 0.5) / values as f64;
        let parameter = low + s * (high - low);
        let (params, frequency_hz) = family.at(parameter);
        let rig = Rig::<f64>::new(&params)?;
        let a0 = params.amplitude_m;
        let away = |amplitudes: f64| Start::Moving(-amplitudes * a0 - params.gap_m.abs(), 0.0);
        let starts: [Start; STARTS] = [Start::Rest, away(3.0), away(9.0)];
        for start in starts {
            parameters.push(parameter);
            cells.push(Cell {
                params,
                frequency_hz,
                start: start.section(&rig, std::f64::consts::TAU * frequency_hz)?,
                phase: 0.0,
            });
        }
    }
    let outcomes = lanes::run_each(&cells, &SETTLE);
    let mut found = Vec::new();
    let mut failed = 0;
    for (parameter, outcome) in parameters.into_iter().zip(outcomes) {
        let Some(outcome) = lanes::or_failed(outcome)? else {
            failed += 1;
            continue;
        };
        if let Regime::Periodic { impacts, periods } = outcome.regime
            && periods <= request.periods
            && impacts <= request.impacts
        {
            let at = SettledRegime {
                parameter,
                impacts,
                periods,
            };
            let section = outcome.section;
            found.push(Seed { at, section });
        }
    }
    found.sort_by_key(|seed| (seed.at.periods, seed.at.impacts));
    Ok((found, failed))
}
