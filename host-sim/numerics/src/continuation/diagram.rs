//! Every curve of orbits that simulation at some frequencies (or gaps) finds, and the doubled ones they lead to.

use shared::model::params::RigParams;
use shared::model::regime::Regime;
use shared::model::rig::Rig;

use super::family::{Along, Family, Node, Place, UP, between, dot, minus};
use super::switching::doubled;
use super::{End, Special, Until, march};
use crate::engine::Start;
use crate::error::Error;
use crate::lanes::{self, Cell, CellPlan};
use crate::orbit::on_course;
use crate::progress::{Progress, check, step};

/// What is searched for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OrbitsRequest {
    /// What is varied.
    pub along: Along,
    /// From and to, as Ω/ω or gap/A0.
    pub limits: (f64, f64),
    /// Orbits of up to so many drive periods.
    pub periods: u8,
    /// Orbits of up to so many contacts.
    pub impacts: u16,
    /// Values of the parameter at which simulations search for orbits.
    pub starts: usize,
}

impl OrbitsRequest {
    /// Simulations that search for orbits: the steps of progress that [`diagram`] reports.
    pub fn simulations(&self) -> u64 {
        (STARTS * self.starts) as u64
    }
}

/// Starts at each value of the parameter: from rest, and from two pushes.
const STARTS: usize = 3;

/// Where a curve was found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Origin {
    /// A simulation settled on it.
    Simulation,
    /// It leaves this curve (by index) at a period doubling.
    Doubling(usize),
}

/// A curve of orbits of one kind.
#[derive(Clone, Debug)]
pub struct Curve {
    /// Its orbits, in order along it.
    pub nodes: Vec<Node>,
    /// How it ends, at the first and at the last orbit.
    pub ends: [End; 2],
    /// Where it was found.
    pub origin: Origin,
    family: Family,
}

impl Curve {
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
    fn through(family: Family, seed: Node, limits: (f64, f64), origin: Origin) -> Self {
        let back = seed.clone().turned();
        let ((ahead, high), (behind, low)) = rayon::join(
            || march(&family, &seed, limits, Until::End),
            || march(&family, &back, limits, Until::End),
        );
        let (behind, low) = if high == End::Closed {
            (Vec::new(), End::Closed)
        } else {
            (behind, low)
        };
        let mut nodes: Vec<Node> = behind.into_iter().rev().map(Node::turned).collect();
        nodes.push(seed);
        nodes.extend(ahead);
        Self {
            nodes,
            ends: [low, high],
            origin,
            family,
        }
    }

    /// Whether `node` is one of its orbits, whichever of its section points it starts from.
    fn passes(&self, node: &Node) -> bool {
        /// Orbits are the same when their section points differ by less, in units of a place.
        const SAME: f64 = 1e-6;
        let parameter = node.parameter();
        let strobes = &node.orbit.strobes;
        self.nodes.windows(2).any(|pair| {
            let (a, b) = (&pair[0], &pair[1]);
            let s = (parameter - a.parameter()) / (b.parameter() - a.parameter());
            if !(0.0..=1.0).contains(&s) {
                return false;
            }
            let mut guess = between(a.place, b.place, s);
            guess[2] = parameter;
            let step = minus(b.place, a.place);
            // By the hammer alone: what the cart does follows from it.
            let near = |place: Place, reach: f64| {
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
pub struct Diagram {
    /// The rig; along [`Along::Gap`] its gap is not used.
    pub params: RigParams,
    /// What was searched for.
    pub request: OrbitsRequest,
    /// The curves.
    pub curves: Vec<Curve>,
}

/// How long a simulation may take to settle.
const SETTLE: CellPlan = CellPlan {
    cycles: 400,
    recorded: 64,
    early: true,
    strobes: 0,
};

/// Finds and follows the curves.
///
/// # Errors
/// If a parameter is out of range, if a simulation leaves what the model describes, or if the work is interrupted.
pub fn diagram(
    params: &RigParams,
    request: &OrbitsRequest,
    progress: &dyn Progress,
) -> Result<Diagram, Error> {
    let family = Family::new(params, request.along, 1)?;
    let mut curves: Vec<Curve> = Vec::new();
    let found = seeds(&family, request)?;
    step(progress, request.simulations() - found.len() as u64)?;
    for found in found {
        step(progress, 1)?;
        let family = family.with_periods(found.periods);
        let Some(seed) = family.node_at(found.parameter, on_course(found.section)) else {
            continue;
        };
        let other = seed.orbit.impacts != found.impacts || !seed.orbit.is_stable();
        if other || known(&curves, &seed) {
            continue;
        }
        let origin = Origin::Simulation;
        curves.push(Curve::through(family, seed, request.limits, origin));
        let newest = curves.len() - 1;
        follow_doublings(&mut curves, newest, request, progress)?;
    }
    Ok(Diagram {
        params: *params,
        request: *request,
        curves,
    })
}

fn known(curves: &[Curve], node: &Node) -> bool {
    let alike = |c: &&Curve| c.periods() == node.orbit.periods && c.impacts() == node.orbit.impacts;
    curves.iter().filter(alike).any(|c| c.passes(node))
}

/// Adds the doubled curves that leave the curves from index `from` on.
fn follow_doublings(
    curves: &mut Vec<Curve>,
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
            curves.push(Curve {
                nodes,
                ends: [End::Special(Special::PeriodDoubling), end],
                origin: Origin::Doubling(index),
                family: twice,
            });
        }
        index += 1;
    }
    Ok(())
}

/// What a simulation settled on.
struct Seed {
    parameter: f64,
    section: [f64; 2],
    impacts: u16,
    periods: u8,
}

/// Orbits that simulations settled on, shorter periods first.
fn seeds(family: &Family, request: &OrbitsRequest) -> Result<Vec<Seed>, Error> {
    let (low, high) = request.limits;
    let mut cells = Vec::new();
    let mut parameters = Vec::new();
    for i in 0..request.starts {
        let s = (i as f64 + 0.5) / request.starts as f64;
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
    let outcomes = lanes::run(&cells, &SETTLE)?;
    let mut found = Vec::new();
    for (parameter, outcome) in parameters.into_iter().zip(outcomes) {
        if let Regime::Periodic { impacts, periods } = outcome.regime
            && periods <= request.periods
            && impacts <= request.impacts
        {
            found.push(Seed {
                parameter,
                section: outcome.section,
                impacts,
                periods,
            });
        }
    }
    found.sort_by_key(|seed| (seed.periods, seed.impacts));
    Ok(found)
}
