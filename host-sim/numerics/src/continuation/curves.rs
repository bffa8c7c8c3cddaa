//! Where over gap and frequency the 1/1 doubles, folds and grazes: its special points at many gaps, joined to lines.

use shared::model::params::RigParams;

use super::diagram::{OrbitsRequest, diagram};
use super::family::{CurvePlace, Node, ahead, dot, minus};
use super::{Along, Special};
use crate::error::Error;
use crate::parallel;
use crate::progress::{Progress, WithinStep, step};

/// A line of special points of one kind, by rising gap.
#[derive(Clone, Debug, PartialEq)]
pub struct SpecialLine {
    /// Kind of all its special points.
    pub special: Special,
    /// The orbits at which it happens.
    pub nodes: Vec<Node>,
}

/// Special points of neighbouring gaps belong to one line when their orbits are nearer than this plus what the line
/// moved in the step before, in units of [`super::family::CurvePlace`].
const NEAR: f64 = 0.35;

/// The lines of special points of the 1/1 at `gaps_m` (rising), between two ratios Ω/ω. At each gap, simulations at
/// `starts` frequencies search for 1/1.
///
/// # Errors
/// As [`diagram`].
pub fn lines(
    params: &RigParams,
    gaps_m: &[f64],
    ratios: (f64, f64),
    starts: usize,
    progress: &dyn Progress,
) -> Result<Vec<SpecialLine>, Error> {
    let request = OrbitsRequest {
        along: Along::Frequency,
        limits: ratios,
        periods: 1,
        impacts: 1,
        starts,
        checks: 0,
    };
    let found: Vec<Vec<Node>> = parallel::try_map(gaps_m, |gap_m| {
        let params = RigParams {
            gap_m: *gap_m,
            ..*params
        };
        let curves = diagram(&params, &request, &WithinStep(progress))?.curves;
        step(progress, 1)?;
        let specials = curves.iter().flat_map(|c| c.specials());
        Ok(specials.map(|(node, _)| node.clone()).collect())
    })?;
    Ok(joined(&found))
}

/// Joins special points of one gap to those of the next.
fn joined(gaps: &[Vec<Node>]) -> Vec<SpecialLine> {
    let mut open: Vec<SpecialLine> = Vec::new();
    let mut done: Vec<SpecialLine> = Vec::new();
    for nodes in gaps {
        let mut free: Vec<Option<&Node>> = nodes.iter().map(Some).collect();
        let mut pairs: Vec<(f64, usize, usize)> = Vec::new();
        for (i, line) in open.iter().enumerate() {
            for (j, node) in nodes.iter().enumerate() {
                let (off, reach) = line.apart(node);
                if node.special == Some(line.special) && off < reach {
                    pairs.push((off, i, j));
                }
            }
        }
        pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut taken = vec![false; open.len()];
        for (_, i, j) in pairs {
            if !taken[i]
                && let Some(node) = free[j].take()
            {
                taken[i] = true;
                open[i].nodes.push(node.clone());
            }
        }
        // What found no continuation ends; what belongs to no line begins one.
        let mut going = Vec::new();
        for (line, taken) in open.into_iter().zip(taken) {
            if taken {
                going.push(line);
            } else {
                done.push(line);
            }
        }
        let new = free.into_iter().flatten().filter_map(|node| {
            Some(SpecialLine {
                special: node.special?,
                nodes: vec![node.clone()],
            })
        });
        going.extend(new);
        open = going;
    }
    done.extend(open);
    done.sort_by_key(|line| line.special.name());
    done
}

impl SpecialLine {
    /// How far `node` is from where the line is heading, and how far it may be.
    fn apart(&self, node: &Node) -> (f64, f64) {
        let n = self.nodes.len();
        let last = self.nodes[n - 1].place;
        let before = self.nodes[n.saturating_sub(2)].place;
        let moved = minus(last, before);
        let expected = ahead(last, 1.0, moved);
        let length = |d: CurvePlace| dot(d, d).sqrt();
        let off = length(minus(node.place, expected)).min(length(minus(node.place, last)));
        (off, NEAR + length(moved))
    }
}
