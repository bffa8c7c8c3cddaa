//! What an observer of a trajectory sees: smooth pieces and finished contacts.

use serde::Serialize;
use shared::model::rig::{Rig, SwitchMode};

use super::FlowPoint;
use super::series::Series;
use super::switching::Arc;

/// One finished contact, times in seconds since the start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct LocatedContact {
    /// When it began, s.
    pub onset_s: f64,
    /// How long it lasted, s.
    pub duration_s: f64,
    /// δ̇ at onset, m/s.
    pub approach_speed_m_per_s: f64,
    /// −δ̇ at release, m/s.
    pub rebound_speed_m_per_s: f64,
    /// Largest contact force, N.
    pub peak_force_n: f64,
    /// When the force was largest, s.
    pub peak_at_s: f64,
    /// Impulse of the contact force, ∫F dt, N·s.
    pub impulse_n_s: f64,
    /// Energy the contact took from the hammer, J.
    pub energy_lost_j: f64,
}

/// What is known of the motion within a piece.
#[derive(Clone, Copy, Debug)]
pub enum Within<'a> {
    /// The accelerations of the hammer's coordinate at both ends, through which a quintic goes.
    Ends([f64; 2]),
    /// All of it.
    Series(&'a Series<f64>),
}

/// A smooth piece of the trajectory, as an observer sees it.
#[derive(Clone, Copy, Debug)]
pub struct Segment<'a> {
    /// The rig that moves, in plain numbers.
    pub rig: &'a Rig<f64>,
    /// Whole drive periods before this one.
    pub cycle: u64,
    /// Drive period, s.
    pub period_s: f64,
    /// Side of the switch.
    pub mode: SwitchMode,
    /// δ̇⁻ of the contact, m/s.
    pub approach: f64,
    /// Where the piece starts.
    pub start: FlowPoint<f64>,
    /// Where the piece ends.
    pub end: FlowPoint<f64>,
    /// The motion in between.
    pub within: Within<'a>,
}

impl Segment<'_> {
    /// The quintic through both ends.
    pub fn arc(&self) -> Arc {
        let [from, to] = self.accelerations();
        Arc::new(
            self.end.t - self.start.t,
            (self.start.q, self.start.v, from),
            (self.end.q, self.end.v, to),
        )
    }

    /// The accelerations of the hammer's coordinate at both ends.
    pub fn accelerations(&self) -> [f64; 2] {
        match self.within {
            Within::Ends(known) => known,
            Within::Series(series) => {
                [self.start, self.end].map(|p| series.acceleration(p.t - series.starts()))
            }
        }
    }

    /// Coordinate and rate at `t` (s since drive phase 0, within the segment).
    pub fn at(&self, t: f64) -> (f64, f64) {
        if let Within::Series(series) = self.within {
            return series.at(t - series.starts());
        }
        let arc = self.arc();
        arc.at((t - self.start.t) / arc.length)
    }

    /// Deviation of the cart from its course (m) and its rate (m/s) at `t`: on the cubic through both ends where no more is
    /// known.
    pub fn cart(&self, t: f64) -> [f64; 2] {
        if let Within::Series(series) = self.within {
            return series.point(t - series.starts()).cart;
        }
        let length = self.end.t - self.start.t;
        let ([e0, w0], [e1, w1]) = (self.start.cart, self.end.cart);
        let s = if length > 0.0 {
            (t - self.start.t) / length
        } else {
            0.0
        };
        let (rise, w0, w1) = (e1 - e0, w0 * length, w1 * length);
        let (bend, jerk) = (3.0 * rise - 2.0 * w0 - w1, w0 + w1 - 2.0 * rise);
        let e = e0 + s * (w0 + s * (bend + s * jerk));
        let rate = w0 + s * (2.0 * bend + s * (3.0 * jerk));
        [
            e,
            if length > 0.0 {
                rate / length
            } else {
                self.start.cart[1]
            },
        ]
    }

    /// Contact force, N, at a coordinate and rate of this segment.
    pub fn force(&self, q: f64, v: f64) -> f64 {
        match self.mode {
            SwitchMode::Flight => 0.0,
            SwitchMode::Contact => {
                let at = self.rig.kinematics(q, v);
                self.rig.force(&at, self.approach).max(0.0)
            }
        }
    }
}

/// Is told of every smooth piece and every finished contact of a trajectory while it is integrated.
pub trait TrajectoryObserver {
    /// A smooth piece was integrated.
    fn segment(&mut self, _segment: &Segment) {}
    /// A contact ended.
    fn contact(&mut self, _contact: &LocatedContact) {}
}

/// For runs that nobody watches.
impl TrajectoryObserver for () {}

/// Keeps every finished contact, in time.
impl TrajectoryObserver for Vec<LocatedContact> {
    fn contact(&mut self, contact: &LocatedContact) {
        self.push(*contact);
    }
}
