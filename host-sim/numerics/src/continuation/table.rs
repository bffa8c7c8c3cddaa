//! Curves of orbits as tables: a row per orbit and strobe, one per special point, one per curve.

use std::fmt;

use serde::{Serialize, Serializer};
use shared::model::params::RigParams;
use shared::model::rig::Rig;

use super::curves::SpecialLine;
use super::family::Node;
use super::{Along, CurveEnd, CurveOrigin, OrbitCurve, OrbitDiagram, SettledRegime, Special};
use crate::orbit::Stability;
use crate::row::CartModel;
use crate::row::{extent, number, tidy};

/// What a curve or a line is called. As text: "1/1", from the second curve of a regime on "1/1 b", and "fold 1".
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CurveName {
    /// A curve of orbits.
    Branch {
        /// Contacts of each of its orbits, p.
        impacts: u16,
        /// Drive periods of each of its orbits, n.
        periods: u8,
        /// Which of the curves of this regime, from 1.
        number: usize,
    },
    /// A line of special points over gap and frequency.
    Line {
        /// Kind of its special points.
        special: Special,
        /// Which of the lines of this kind, from 1.
        number: usize,
    },
}

impl fmt::Display for CurveName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let text = match *self {
            Self::Branch {
                impacts,
                periods,
                number,
            } => match number {
                1 => format!("{impacts}/{periods}"),
                2..=26 => {
                    let letter = char::from(b'a' + (number - 1) as u8);
                    format!("{impacts}/{periods} {letter}")
                }
                _ => format!("{impacts}/{periods} {number}"),
            },
            Self::Line { special, number } => format!("{} {number}", special.name()),
        };
        f.pad(&text)
    }
}

impl Serialize for CurveName {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

/// One strobe of an orbit. Units are in the names.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct OrbitRow {
    /// Name of the curve.
    pub branch: CurveName,
    /// Which orbit of the curve, in order along it, from 1.
    pub orbit: usize,
    /// Which of its drive phases 0, from 1.
    pub strobe: u8,
    /// Drive frequency, Hz.
    pub frequency_hz: f64,
    /// Drive frequency over the natural frequency, Ω/ω.
    pub frequency_ratio: f64,
    /// Clearance at rest, mm.
    pub gap_mm: f64,
    /// Displacement relative to the cart at the strobe (prescribed: in the fixed frame, too), mm.
    pub displacement_mm: f64,
    /// Velocity relative to the cart at the strobe, m/s.
    pub velocity_m_per_s: f64,
    /// p: contacts of the orbit.
    pub impacts: u16,
    /// n: drive periods of the orbit.
    pub periods: u8,
    /// Largest contact force of the orbit over m g.
    pub force_ratio: f64,
    /// Largest contact force in the drive period that begins with this strobe, over m g.
    pub period_force_ratio: f64,
    /// First multiplier, real part.
    pub multiplier_1_re: f64,
    /// First multiplier, imaginary part.
    pub multiplier_1_im: f64,
    /// Second multiplier, real part.
    pub multiplier_2_re: f64,
    /// Second multiplier, imaginary part.
    pub multiplier_2_im: f64,
    /// The larger modulus of the two multipliers.
    pub multiplier_modulus: f64,
    /// Whether both lie inside the unit circle.
    pub stable: bool,
    /// What is special about the orbit.
    pub special: Option<Special>,
    /// Stable, neutral (multipliers on the unit circle: nothing takes energy) or unstable.
    pub stability: Stability,
}

/// A special point of a curve of orbits, or of a line over gap and frequency.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SpecialRow {
    /// Name of the curve or of the line.
    pub branch: CurveName,
    /// Kind of the special point.
    pub special: Special,
    /// Drive frequency, Hz.
    pub frequency_hz: f64,
    /// Drive frequency over the natural frequency, Ω/ω.
    pub frequency_ratio: f64,
    /// Clearance at rest, mm.
    pub gap_mm: f64,
    /// Displacement at drive phase 0, mm.
    pub displacement_mm: f64,
    /// Velocity relative to the cart at drive phase 0, m/s.
    pub velocity_m_per_s: f64,
    /// Contacts of the orbit, p.
    pub impacts: u16,
    /// Drive periods of the orbit, n.
    pub periods: u8,
    /// Largest contact force over m g.
    pub force_ratio: f64,
    /// The larger modulus of the multipliers.
    pub multiplier_modulus: f64,
}

/// A curve as a whole.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BranchRow {
    /// Name of the curve.
    pub branch: CurveName,
    /// Contacts of each of its orbits, p.
    pub impacts: u16,
    /// Drive periods of each of its orbits, n.
    pub periods: u8,
    /// Number of orbits found along the curve.
    pub orbits: usize,
    /// Smallest and largest parameter on it: Ω/ω, gap/A0, or a number of the rig over its unit.
    pub range: [f64; 2],
    /// Stretches of the parameter that are stable.
    pub stable: Vec<[f64; 2]>,
    /// Largest force on a stable stretch, over m g; none if there is no stable orbit.
    pub largest_stable_force_ratio: Option<f64>,
    /// How it ends on either side.
    pub ends: [CurveEnd; 2],
    /// The curve it leaves at a period doubling; none: a simulation settled on it.
    pub doubled_from: Option<CurveName>,
    /// Stretches of the parameter that are neutral: multipliers on the unit circle, since nothing takes energy.
    pub neutral: Vec<[f64; 2]>,
}

/// A regime that simulations settled on and that lies on none of the curves.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SeenRow {
    /// Contacts per repetition, p.
    pub impacts: u16,
    /// Drive periods per repetition, n.
    pub periods: u8,
    /// How many simulations settled on it.
    pub simulations: usize,
    /// Smallest and largest parameter at which they did: Ω/ω, gap/A0, or a number of the rig over its unit.
    pub range: [f64; 2],
}

/// A diagram as tables.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct OrbitsAnswer {
    /// Name of the rig.
    pub rig: String,
    /// How the cart is moved.
    pub cart: CartModel,
    /// Parameter that is varied: "frequency", "gap", or the name of a number of the rig.
    pub along: &'static str,
    /// The curves, one row each.
    pub branches: Vec<BranchRow>,
    /// Special points of the curves, curve by curve.
    pub special_points: Vec<SpecialRow>,
    /// Every orbit of every curve, one row for each strobe.
    pub orbits: Vec<OrbitRow>,
    /// Regimes that simulations settled on and that lie on none of the branches.
    pub seen_elsewhere: Vec<SeenRow>,
    /// Simulations that searched for orbits.
    pub simulations: usize,
    /// How many of them left what the model describes.
    pub failed_simulations: usize,
}

impl OrbitsAnswer {
    /// Of a diagram of the rig called `name`.
    pub fn new(name: &str, diagram: &OrbitDiagram) -> Self {
        let names = names(diagram);
        let curves = || diagram.curves.iter().zip(&names);
        let branches = curves().map(|(curve, name)| branch_row(curve, *name, &names, diagram));
        let specials = curves().flat_map(|(curve, name)| {
            let row = |(node, kind)| special_at(&diagram.params, node, kind, *name);
            curve.specials().map(row).collect::<Vec<_>>()
        });
        let orbits = curves().flat_map(|(curve, name)| {
            let rows = |(i, node)| orbit_rows(diagram, node, i + 1, *name);
            curve
                .nodes
                .iter()
                .enumerate()
                .flat_map(rows)
                .collect::<Vec<_>>()
        });
        Self {
            rig: name.to_owned(),
            cart: CartModel::of(&diagram.params),
            along: match diagram.request.along {
                Along::Frequency => "frequency",
                Along::Gap(_) => "gap",
                Along::Rig { knob, .. } => knob.name(),
            },
            branches: branches.collect(),
            special_points: specials.collect(),
            orbits: orbits.collect(),
            seen_elsewhere: seen_rows(&diagram.elsewhere),
            simulations: diagram.simulations,
            failed_simulations: diagram.failed,
        }
    }
}

/// One row for each regime, in the order of p and n.
fn seen_rows(seen: &[SettledRegime]) -> Vec<SeenRow> {
    let mut rows: Vec<SeenRow> = Vec::new();
    for one in seen {
        let at = tidy(one.parameter);
        let same = |r: &&mut SeenRow| (r.impacts, r.periods) == (one.impacts, one.periods);
        match rows.iter_mut().find(same) {
            Some(row) => {
                row.simulations += 1;
                row.range = [row.range[0].min(at), row.range[1].max(at)];
            }
            None => rows.push(SeenRow {
                impacts: one.impacts,
                periods: one.periods,
                simulations: 1,
                range: [at; 2],
            }),
        }
    }
    rows.sort_by_key(|row| (row.periods, row.impacts));
    rows
}

/// Names of the curves of `diagram`, in their order.
pub fn names(diagram: &OrbitDiagram) -> Vec<CurveName> {
    let curves = &diagram.curves;
    let name = |(i, curve): (usize, &OrbitCurve)| CurveName::Branch {
        impacts: curve.impacts(),
        periods: curve.periods(),
        number: number(curves, i, OrbitCurve::regime),
    };
    curves.iter().enumerate().map(name).collect()
}

/// Rows of the special points on lines over gap and frequency, named by kind and number.
pub fn line_rows(params: &RigParams, lines: &[SpecialLine]) -> Vec<SpecialRow> {
    let rows = lines.iter().enumerate().flat_map(|(i, line)| {
        let name = CurveName::Line {
            special: line.special,
            number: number(lines, i, |line| line.special),
        };
        let row = move |node: &Node| special_at(params, node, line.special, name);
        line.nodes.iter().map(row).collect::<Vec<_>>()
    });
    rows.collect()
}

fn branch_row(
    curve: &OrbitCurve,
    name: CurveName,
    names: &[CurveName],
    diagram: &OrbitDiagram,
) -> BranchRow {
    let ranges = |wanted: Stability| {
        stretches(&curve.nodes)
            .into_iter()
            .filter(|(_, of)| *of == wanted)
            .map(|(nodes, _)| {
                let ends = [nodes[0].parameter(), nodes[nodes.len() - 1].parameter()];
                [ends[0].min(ends[1]), ends[0].max(ends[1])].map(tidy)
            })
            .collect::<Vec<_>>()
    };
    let forces = curve.nodes.iter().filter(|n| n.orbit.is_stable());
    let largest = forces
        .map(|n| n.orbit.force_n / diagram.params.weight_n())
        .reduce(f64::max);
    BranchRow {
        branch: name,
        impacts: curve.impacts(),
        periods: curve.periods(),
        orbits: curve.nodes.len(),
        range: extent(curve.nodes.iter().map(Node::parameter)).map(tidy),
        stable: ranges(Stability::Stable),
        largest_stable_force_ratio: largest,
        ends: curve.ends,
        doubled_from: match curve.origin {
            CurveOrigin::Simulation => None,
            CurveOrigin::Doubling(from) => Some(names[from]),
        },
        neutral: ranges(Stability::Neutral),
    }
}

/// The curve cut where stability changes, which is at special points: neighbours share the orbit at the cut.
pub fn stretches(nodes: &[Node]) -> Vec<(&[Node], Stability)> {
    // A special orbit lies between stable and unstable ones; the other end of the piece decides.
    let of = |pair: &[Node]| {
        let deciding = if pair[0].special.is_some() {
            &pair[1]
        } else {
            &pair[0]
        };
        deciding.orbit.stability()
    };
    let mut found = Vec::new();
    let mut from = 0;
    for (i, pair) in nodes.windows(2).enumerate() {
        let next = nodes.get(i + 1..i + 3);
        if next.is_none_or(|next| of(next) != of(pair)) {
            found.push((&nodes[from..i + 2], of(pair)));
            from = i + 1;
        }
    }
    found
}

fn special_at(params: &RigParams, node: &Node, kind: Special, name: CurveName) -> SpecialRow {
    let orbit = &node.orbit;
    let (displacement_mm, velocity_m_per_s) = motion_at(params, node, orbit.section);
    SpecialRow {
        branch: name,
        special: kind,
        frequency_hz: tidy(orbit.frequency_hz),
        frequency_ratio: tidy(orbit.frequency_hz / params.natural_frequency_hz()),
        gap_mm: tidy(node.gap_m * 1e3),
        displacement_mm,
        velocity_m_per_s,
        impacts: orbit.impacts,
        periods: orbit.periods,
        force_ratio: orbit.force_n / params.weight_n(),
        multiplier_modulus: orbit.multipliers().modulus(),
    }
}

fn orbit_rows(
    diagram: &OrbitDiagram,
    node: &Node,
    number: usize,
    name: CurveName,
) -> Vec<OrbitRow> {
    let (params, orbit) = (&diagram.params, &node.orbit);
    let [(a_re, a_im), (b_re, b_im)] = orbit.eigenvalues();
    let row = |(k, section): (usize, &[f64; 2])| {
        let (displacement_mm, velocity_m_per_s) = motion_at(params, node, *section);
        OrbitRow {
            branch: name,
            orbit: number,
            strobe: k as u8 + 1,
            frequency_hz: tidy(orbit.frequency_hz),
            frequency_ratio: tidy(orbit.frequency_hz / params.natural_frequency_hz()),
            gap_mm: tidy(node.gap_m * 1e3),
            displacement_mm,
            velocity_m_per_s,
            impacts: orbit.impacts,
            periods: orbit.periods,
            force_ratio: orbit.force_n / params.weight_n(),
            period_force_ratio: orbit.period_forces_n[k] / params.weight_n(),
            multiplier_1_re: a_re,
            multiplier_1_im: a_im,
            multiplier_2_re: b_re,
            multiplier_2_im: b_im,
            multiplier_modulus: orbit.multipliers().modulus(),
            stable: orbit.is_stable(),
            special: node.special,
            stability: orbit.stability(),
        }
    };
    orbit.strobes.iter().enumerate().map(row).collect()
}

/// Displacement (mm) and velocity relative to the cart (m/s) of a section point of `node`.
pub fn motion_at(params: &RigParams, node: &Node, section: [f64; 2]) -> (f64, f64) {
    let gap_m = node.gap_m;
    motion_of(&RigParams { gap_m, ..*params }, section)
}

/// Displacement (mm) and velocity relative to the cart (m/s) of a section point of this very rig.
pub(super) fn motion_of(params: &RigParams, section: [f64; 2]) -> (f64, f64) {
    let Ok(rig) = Rig::<f64>::new(params) else {
        return (f64::NAN, f64::NAN);
    };
    let rate = rig.kinematics(section[0], section[1]).rate;
    (rig.relative_displacement(section[0]) * 1e3, rate)
}
