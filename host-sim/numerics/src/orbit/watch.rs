//! What is seen along an orbit: its contacts, its near misses, and whether the contact law was obeyed.

use shared::model::rig::SwitchMode;

use crate::reference::{LocatedContact, Segment, TrajectoryObserver};
use crate::root::halved;

/// What happened along a trajectory.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct OrbitWatch {
    /// Finished contacts, in order.
    pub contacts: Vec<LocatedContact>,
    /// The smallest clearance at which the hammer turned back in flight without touching, m; none: it never did.
    pub near_miss_m: Option<f64>,
    /// When that was, drive periods since the start.
    pub near_miss_at: Option<f64>,
    /// The largest value of the contact force inside a contact below zero, N: 0 where it only pushed.
    pub largest_pull_n: f64,
    /// The deepest penetration in flight towards the surface, m: 0 where no contact was overlooked.
    pub deepest_flight_m: f64,
    /// Mass of the hammer, kg; 0 before the first piece.
    mass_kg: f64,
}

impl TrajectoryObserver for OrbitWatch {
    fn segment(&mut self, segment: &Segment) {
        self.mass_kg = segment.rig.mass();
        match segment.mode {
            SwitchMode::Flight => self.flight(segment),
            SwitchMode::Contact => {
                for point in [segment.start, segment.end] {
                    let at = segment.rig.kinematics(point.q, point.v);
                    let pull = -segment.rig.force(&at, segment.approach);
                    self.largest_pull_n = self.largest_pull_n.max(pull);
                }
            }
        }
    }

    fn contact(&mut self, contact: &LocatedContact) {
        self.contacts.push(*contact);
    }
}

impl OrbitWatch {
    /// The contacts that can graze: those that are missed when their approach speed passes 0.
    pub fn grazing_contacts(&self) -> impl Iterator<Item = &LocatedContact> {
        self.contacts.iter().filter(|c| self.can_graze(c))
    }

    /// Whether what acts on the hammer besides the surface draws it away during the contact: the surface then gives it
    /// less than its change of momentum. A contact into which it is pressed is not missed when its approach speed
    /// passes 0: it then begins inside the surface, where the damper lets go of it and F comes back to 0.
    fn can_graze(&self, contact: &LocatedContact) -> bool {
        let change = contact.approach_speed_m_per_s + contact.rebound_speed_m_per_s;
        contact.impulse_n_s < self.mass_kg * change
    }

    /// The shortest flight from one contact to the next, as a share of the shorter of the two, on an orbit of `period_s`;
    /// none with fewer than two contacts.
    pub fn shortest_flight(&self, period_s: f64) -> Option<f64> {
        let (first, last) = (self.contacts.first()?, self.contacts.last()?);
        let again = LocatedContact {
            onset_s: first.onset_s + period_s,
            ..*first
        };
        let pairs = self.contacts.windows(2).map(|pair| (pair[0], pair[1]));
        let around = (self.contacts.len() > 1).then_some((*last, again));
        let flights = pairs.chain(around).map(|(a, b)| {
            let flight = b.onset_s - a.onset_s - a.duration_s;
            flight / a.duration_s.min(b.duration_s)
        });
        flights.reduce(f64::min)
    }

    fn flight(&mut self, segment: &Segment) {
        let at = |q: f64, v: f64| segment.rig.kinematics(q, v);
        let ends = [segment.start, segment.end].map(|p| at(p.q, p.v));
        for here in ends {
            if here.rate > 0.0 {
                self.deepest_flight_m = self.deepest_flight_m.max(here.delta);
            }
        }
        if !(ends[0].rate > 0.0 && ends[1].rate <= 0.0) {
            return;
        }
        // The top of the flight within this piece, where δ̇ passes 0.
        let falls = |t| {
            let (q, v) = segment.at(t);
            at(q, v).rate <= 0.0
        };
        let (before, _) = halved((segment.start.t, segment.end.t), 50, falls);
        let (q, v) = segment.at(before);
        let clearance = -at(q, v).delta;
        if self.near_miss_m.is_none_or(|m| clearance < m) {
            self.near_miss_m = Some(clearance);
            self.near_miss_at = Some(segment.cycle as f64 + before / segment.period_s);
        }
    }
}
