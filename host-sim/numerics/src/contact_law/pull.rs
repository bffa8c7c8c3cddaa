//! What a law would do if nothing kept it from pulling.

use shared::model::rig::{Rig, SwitchMode};

use super::undriven::Course;
use crate::flow::reached;
use crate::reference::FlowPoint;
use crate::reference::flow::HammerFlow;
use crate::root::halved;

/// A contact that lasts to δ = 0 instead of ending at F = 0.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Pull {
    /// Share of that longer contact in which F < 0.
    pub share: f64,
    /// Largest pull −F, N; 0 where the law does not pull.
    pub force_n: f64,
    /// Speed at δ = 0 over the approach speed.
    pub restitution: f64,
    /// Its end: (time since onset in s, δ in m, δ̇ in m/s, F in N), from F = 0 to δ = 0.
    pub tail: Vec<[f64; 4]>,
}

/// Steps from release to δ = 0 if there were as many as the contact's duration holds.
const STEPS: f64 = 400.0;

/// Below this share of its length in one step's travel, δ is zero at release already.
const NOTHING_LEFT: f64 = 1e-3;

/// Continues from the release of `contact` with the contact's own equation of motion until δ = 0. None if it does not
/// come back within ten times the contact's duration.
pub fn unclamped(rig: &Rig<f64>, course: &Course) -> Option<Pull> {
    let contact = &course.contact;
    let approach = contact.approach_speed_m_per_s;
    let mut pull = Pull {
        restitution: contact.rebound_speed_m_per_s / approach,
        ..Pull::default()
    };
    let flow = HammerFlow {
        rig,
        plain: (rig, None),
        omega: 0.0,
        drive_acceleration: 0.0,
        mode: SwitchMode::Contact,
        approach,
        smoothed: None,
        recoil: None,
        units: (1.0, 1.0),
    };
    let h = contact.duration_s / STEPS;
    let (q, v) = course.release;
    let mut point = FlowPoint::on_course(0.0, q, v);
    if rig.kinematics(q, v).delta <= NOTHING_LEFT * h * approach {
        return Some(pull);
    }
    let delta = |p: &FlowPoint<f64>| rig.kinematics(p.q, p.v).delta;
    let enter = |pull: &mut Pull, p: &FlowPoint<f64>| {
        let at = rig.kinematics(p.q, p.v);
        let force = rig.force(&at, approach);
        pull.force_n = pull.force_n.max(-force);
        let time = contact.duration_s + p.t;
        pull.tail.push([time, at.delta, at.rate, force]);
    };
    enter(&mut pull, &point);
    for _ in 0..10 * STEPS as usize {
        let end = reached(&flow, &point, h);
        if delta(&end) > 0.0 {
            point = end;
            enter(&mut pull, &point);
            continue;
        }
        let left = |s| delta(&reached(&flow, &point, s)) <= 0.0;
        let (last, _) = halved((0.0, h), 60, left);
        point = reached(&flow, &point, last);
        enter(&mut pull, &point);
        pull.share = point.t / (contact.duration_s + point.t);
        pull.restitution = -rig.kinematics(point.q, point.v).rate / approach;
        return Some(pull);
    }
    None
}
