//! What is seen along an orbit: its contacts, its near misses, and whether the contact law was obeyed.

use shared::model::rig::Mode;

use crate::reference::{Contact, Observer, Segment};

/// What happened along a trajectory.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Watch {
    /// Finished contacts, in order.
    pub contacts: Vec<Contact>,
    /// The smallest clearance at which the hammer turned back in flight without touching, m; none: it never did.
    pub near_miss_m: Option<f64>,
    /// The largest value of the contact force inside a contact below zero, N: 0 where it only pushed.
    pub largest_pull_n: f64,
    /// The deepest penetration in flight towards the surface, m: 0 where no contact was overlooked.
    pub deepest_flight_m: f64,
}

impl Observer for Watch {
    fn segment(&mut self, segment: &Segment) {
        match segment.mode {
            Mode::Flight => self.flight(segment),
            Mode::Contact => {
                for point in [segment.start, segment.end] {
                    let at = segment.rig.kinematics(point.q, point.v);
                    let pull = -segment.rig.force(&at, segment.approach);
                    self.largest_pull_n = self.largest_pull_n.max(pull);
                }
            }
        }
    }

    fn contact(&mut self, contact: &Contact) {
        self.contacts.push(*contact);
    }
}

impl Watch {
    fn flight(&mut self, segment: &Segment) {
        let at = |q: f64, v: f64| segment.rig.kinematics(q, v);
        for point in [segment.start, segment.end] {
            let here = at(point.q, point.v);
            if here.rate > 0.0 {
                self.deepest_flight_m = self.deepest_flight_m.max(here.delta);
            }
        }
        let rises = at(segment.start.q, segment.start.v).rate > 0.0;
        let falls = at(segment.end.q, segment.end.v).rate <= 0.0;
        if !(rises && falls) {
            return;
        }
        // The top of the flight within this piece, where δ̇ passes 0.
        let (mut before, mut after) = (segment.start.t, segment.end.t);
        for _ in 0..50 {
            let middle = 0.5 * (before + after);
            let (q, v) = segment.at(middle);
            if at(q, v).rate > 0.0 {
                before = middle;
            } else {
                after = middle;
            }
        }
        let (q, v) = segment.at(before);
        let clearance = -at(q, v).delta;
        self.near_miss_m = Some(self.near_miss_m.map_or(clearance, |m| m.min(clearance)));
    }
}
