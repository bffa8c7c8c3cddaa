//! One drive period of the motion: its pieces, its switches, and what it saw.

use std::f64::consts::TAU;

use super::{FAR, LEAP, LinearMotion, Phase, WHOLE};
use crate::modes::dense::{Square, dot};
use crate::root::halved;

/// Halvings of a step in which a switch is located.
const HALVINGS: u32 = 44;
/// Onsets in a period beyond which an orbit is not sought.
pub(super) const MOST_ONSETS: u32 = 60;

/// What happened in a period.
#[derive(Clone, Debug, Default)]
pub(super) struct PeriodEvents {
    pub onsets: u32,
    /// Largest F/(A0 Ω²), kg, and the approach speed of its contact.
    pub force: f64,
    pub approach: f64,
    /// Phases passed: whether in contact, and for how long; after each but the last a saltation.
    pub pieces: Vec<(bool, f64)>,
    pub saltations: Vec<Square>,
    /// The way there step by step, if it is asked for; there are no saltations then.
    pub path: Option<Vec<LinearLeg>>,
}

/// A step, or what there is of it before a switch.
#[derive(Clone, Debug)]
pub(super) struct LinearLeg {
    pub touching: bool,
    /// How long it lasts, in 1/Ω.
    pub length: f64,
    /// In the middle and at the end.
    pub states: [Vec<f64>; 2],
}
impl LinearMotion {
    /// Runs from drive phase 0 to drive phase 0. `None` if the motion cannot be followed, or has more than `most` onsets.
    pub(super) fn run(
        &self,
        section: &[f64],
        most: u32,
        mut seen: Option<&mut PeriodEvents>,
    ) -> Option<Vec<f64>> {
        let mut z = self.at_phase_zero(section);
        let mut touching = self.pushes(&z);
        let (mut left, mut since, mut onsets) = (TAU, 0.0, 0_u32);
        let mut approach = dot(&self.rate, &z);
        let mut next = z.clone();
        // Penetration and its rate at `z`.
        let mut from = self.free.approach(&self.delta, &z);
        // Base steps until the next look far ahead.
        let mut near = 0;
        let watched = seen.as_ref().is_some_and(|seen| seen.path.is_some());
        loop {
            let phase = self.phase(touching);
            let leap = LEAP as f64 * phase.step;
            if near == 0 && !touching && !watched && left > leap {
                near = LEAP;
                if let Some(to) = phase.stays_below(from, &z) {
                    phase.ladder[WHOLE + FAR].apply(&z, &mut next);
                    std::mem::swap(&mut z, &mut next);
                    (left, since, from, near) = (left - leap, since + leap, to, 0);
                    continue;
                }
            }
            near = near.saturating_sub(1);
            let last = left <= phase.step;
            let h = if last { left } else { phase.step };
            if last {
                next = phase.a.exponential_of(h, &z);
            } else {
                phase.ladder[WHOLE].apply(&z, &mut next);
            }
            let to = self.free.approach(&self.delta, &next);
            let switch = if !touching && stays_below(from, to, h) {
                None
            } else {
                self.switch_within(touching, &z, &next, h)
            };
            from = to;
            let length = switch.unwrap_or(h);
            if let Some(t) = switch {
                next = phase.a.exponential_of(t, &z);
                from = self.free.approach(&self.delta, &next);
            }
            if touching && let Some(seen) = seen.as_deref_mut() {
                let top = self.largest_force(&z, &next, length);
                if top > seen.force {
                    (seen.force, seen.approach) = (top, approach);
                }
            }
            if let Some(path) = seen.as_deref_mut().and_then(|seen| seen.path.as_mut()) {
                let middle = if last || switch.is_some() {
                    phase.a.exponential_of(0.5 * length, &z)
                } else {
                    phase.ladder[WHOLE - 1].of(&z)
                };
                path.push(LinearLeg {
                    touching,
                    length,
                    states: [middle, next.clone()],
                });
            }
            let Some(t) = switch else {
                since += h;
                if last {
                    if let Some(seen) = seen {
                        seen.onsets = onsets;
                        seen.pieces.push((touching, since));
                    }
                    next.truncate(self.section_size());
                    return next.iter().all(|x| x.is_finite()).then_some(next);
                }
                left -= h;
                std::mem::swap(&mut z, &mut next);
                continue;
            };
            std::mem::swap(&mut z, &mut next);
            left -= t;
            if let Some(seen) = seen.as_deref_mut() {
                seen.pieces.push((touching, since + t));
                if seen.path.is_none() {
                    seen.saltations.push(self.saltation(touching, &z)?);
                }
            }
            (touching, since) = (!touching, 0.0);
            if touching {
                approach = dot(&self.rate, &z);
                onsets += 1;
                if onsets > most {
                    return None;
                }
            }
        }
    }

    /// When the hammer switches within a step of length `h` that begins at `z` and ends at `end`, as time since `z`: the
    /// first instant at which it is seen to push (or no more to).
    fn switch_within(&self, touching: bool, z: &[f64], end: &[f64], h: f64) -> Option<f64> {
        let switched = |z: &[f64]| self.pushes(z) != touching;
        // A short contact, or a short hop, inside the step: at the extreme of what is watched.
        let inside_only = !switched(end);
        let by_delta = !touching && dot(&self.delta, z).min(dot(&self.delta, end)) < 0.0;
        let phase = self.phase(touching);
        let slopes = &phase.slopes;
        let slope = if by_delta {
            &slopes.delta
        } else {
            &slopes.force
        };
        if inside_only && !turns(slope, [z, end], touching) {
            return None;
        }
        let series = phase.a.series(z);
        let (delta, force) = (series.seen(&self.delta), series.seen(&self.force));
        let switched_at = |t: f64| (delta.at(t) > 0.0 && force.at(t) > 0.0) != touching;
        let mut high = h;
        if inside_only {
            let watched = if by_delta { &delta } else { &force };
            (_, high) = halved((0.0, h), 30, |t| {
                if touching {
                    watched.slope(t) > 0.0
                } else {
                    watched.slope(t) < 0.0
                }
            });
            if !switched_at(high) {
                return None;
            }
        }
        // Just after a switch the state is on the border and may round to either side.
        if switched(z) && switched_at(1e-6 * h) {
            return Some(1e-6 * h);
        }
        Some(halved((0.0, high), HALVINGS, switched_at).1)
    }

    /// The largest force within `h` from `z` on, in contact, where it is at `end`.
    fn largest_force(&self, z: &[f64], end: &[f64], h: f64) -> f64 {
        let ends = dot(&self.force, z).max(dot(&self.force, end));
        if !turns(&self.pressing.slopes.force, [z, end], false) {
            return ends;
        }
        let force = self.pressing.a.series(z).seen(&self.force);
        let (_, top) = halved((0.0, h), 30, |t| force.slope(t) < 0.0);
        ends.max(force.at(top))
    }

    /// What the switch out of `touching` at `z` makes of a small deviation. `None` where it grazes.
    fn saltation(&self, touching: bool, z: &[f64]) -> Option<Square> {
        let size = z.len();
        let (mut before, mut after) = (vec![0.0; size], vec![0.0; size]);
        self.phase(touching).a.apply(z, &mut before);
        self.phase(!touching).a.apply(z, &mut after);
        // An onset is where the later of the two becomes positive; a release, where the force vanishes.
        let by_force =
            touching || dot(&self.force, z) / self.stiffness_unit() < dot(&self.delta, z);
        let normal = if by_force { &self.force } else { &self.delta };
        let crossing = dot(normal, &before);
        if crossing == 0.0 {
            return None;
        }
        let mut saltation = Square::one(size);
        for i in 0..size {
            let jump = (after[i] - before[i]) / crossing;
            for (k, n) in normal.iter().enumerate() {
                *saltation.at_mut(i, k) += jump * n;
            }
        }
        Some(saltation)
    }

    /// F/(A0 Ω²) per δ/A0, kg.
    fn stiffness_unit(&self) -> f64 {
        self.force[0]
    }
    /// Where `periods` drive periods from rest lead.
    pub fn from_rest(&self, periods: u32) -> Option<Vec<f64>> {
        self.after(&vec![0.0; self.section_size()], periods)
    }

    /// Where `periods` drive periods lead from `section`.
    pub fn after(&self, section: &[f64], periods: u32) -> Option<Vec<f64>> {
        let mut at = section.to_vec();
        for _ in 0..periods {
            at = self.run(&at, MOST_ONSETS, None)?;
        }
        Some(at)
    }
}

impl Phase {
    /// Penetration and its rate at `z`, in the units of the state.
    fn approach(&self, delta: &[f64], z: &[f64]) -> [f64; 2] {
        [dot(delta, z), dot(&self.slopes.delta, z)]
    }

    /// Penetration and its rate [`LEAP`] base steps after `z`, where they are `from`, if the hammer stays off the surface until
    /// then.
    fn stays_below(&self, from: [f64; 2], z: &[f64]) -> Option<[f64; 2]> {
        let mut ahead = [[0.0; 2]; LEAP];
        for (x, column) in z.iter().zip(&self.ahead) {
            for (sum, by) in ahead
                .as_flattened_mut()
                .iter_mut()
                .zip(column.as_flattened())
            {
                *sum += x * by;
            }
        }
        let before = [from].into_iter().chain(ahead);
        let mut pairs = before.zip(ahead);
        pairs
            .all(|(from, to)| stays_below(from, to, self.step))
            .then_some(ahead[LEAP - 1])
    }
}

/// Whether the hammer stays off the surface in a step of length `h`, given penetration and rate at both ends. Where it turns
/// inside, a parabola would rise by an eighth of what is allowed for here.
fn stays_below([from, rate]: [f64; 2], [to, end_rate]: [f64; 2], h: f64) -> bool {
    let turn = if rate > 0.0 && end_rate < 0.0 {
        h * (rate - end_rate)
    } else {
        0.0
    };
    from < 0.0 && to < 0.0 && from.max(to) + turn < 0.0
}

/// Whether what has this `slope` rises at the first of two states and falls at the second, or the other way where a least
/// value is sought.
fn turns(slope: &[f64], states: [&[f64]; 2], least: bool) -> bool {
    let [first, second] = states.map(|z| dot(slope, z));
    if least {
        first < 0.0 && second > 0.0
    } else {
        first > 0.0 && second < 0.0
    }
}
