//! A hammer that nothing drives: released, it falls on the surface and bounces.
//!
//! It is the reference ([`crate::reference`]) in a cart that stands still, a step at a time, and errors are weighed by this
//! motion's own size, not by a drive's.

use shared::model::rig::{Rig, SwitchMode};

use crate::flow::StepEnded;
use crate::reference::switching::Arc;
use crate::reference::{FlowPoint, LocatedContact, Reference, Segment, TrajectoryObserver};

/// Errors per step are kept below this share of the motion's size.
const TOLERANCE: f64 = 1e-12;

/// Steps after which a motion is given up: one contact takes some fifty.
const MAX_STEPS: usize = 20_000;

/// A smooth piece of the motion.
#[derive(Clone, Copy, Debug)]
pub struct MotionPiece {
    /// When it begins, s since the release.
    pub start_s: f64,
    /// Coordinate and rate within it (quintic).
    pub arc: Arc,
    /// Side of the switch.
    pub mode: SwitchMode,
    /// Approach speed δ̇⁻ at the onset of the contact, m/s; not used in flight.
    pub approach: f64,
}

impl From<&Segment<'_>> for MotionPiece {
    fn from(segment: &Segment) -> Self {
        Self {
            start_s: segment.start.t,
            arc: segment.arc(),
            mode: segment.mode,
            approach: segment.approach,
        }
    }
}

impl MotionPiece {
    /// When it ends, s.
    pub fn end_s(&self) -> f64 {
        self.start_s + self.arc.length
    }

    /// Coordinate and rate at `time_s`.
    pub fn at(&self, time_s: f64) -> (f64, f64) {
        self.arc.at((time_s - self.start_s) / self.arc.length)
    }

    /// Contact force at `time_s`, N.
    pub fn force(&self, rig: &Rig<f64>, time_s: f64) -> f64 {
        match self.mode {
            SwitchMode::Flight => 0.0,
            SwitchMode::Contact => {
                let (q, v) = self.at(time_s);
                rig.force(&rig.kinematics(q, v), self.approach).max(0.0)
            }
        }
    }
}

/// One contact, with the motion in it.
#[derive(Clone, Debug)]
pub struct Course {
    /// Its figures; times are seconds since the release.
    pub contact: LocatedContact,
    /// Its pieces, in time.
    pub pieces: Vec<MotionPiece>,
    /// Coordinate and rate at its end.
    pub release: (f64, f64),
}

impl Course {
    /// Contact force `since_onset_s` after the onset, N; 0 outside the contact.
    pub fn force(&self, rig: &Rig<f64>, since_onset_s: f64) -> f64 {
        let time_s = self.contact.onset_s + since_onset_s;
        if !(0.0..=self.contact.duration_s).contains(&since_onset_s) {
            return 0.0;
        }
        let after = self.pieces.partition_point(|p| p.end_s() < time_s);
        let piece = self.pieces.get(after).or(self.pieces.last());
        piece.map_or(0.0, |p| p.force(rig, time_s))
    }
}

/// What an undriven motion was seen to do.
#[derive(Clone, Debug, Default)]
pub struct Track {
    /// Its pieces, in time.
    pub pieces: Vec<MotionPiece>,
    /// The last contact that ended.
    contact: Option<LocatedContact>,
}

impl TrajectoryObserver for Track {
    fn segment(&mut self, segment: &Segment) {
        self.pieces.push(segment.into());
    }
    fn contact(&mut self, contact: &LocatedContact) {
        self.contact = Some(*contact);
    }
}

/// A hammer in a cart that stands still.
#[derive(Clone, Copy, Debug)]
pub struct Undriven {
    hammer: Reference<f64>,
}

impl Undriven {
    /// Released in flight at coordinate `q` and rate `v`; `scale` is the size of coordinate and rate in this
    /// motion, and no step is longer than `max_step` s.
    pub fn new(rig: &Rig<f64>, section: [f64; 2], scale: (f64, f64), max_step: f64) -> Self {
        let units = (TOLERANCE * scale.0, TOLERANCE * scale.1);
        Self {
            hammer: Reference::undriven(rig, section, units, max_step),
        }
    }

    /// Time since the release (s), coordinate and rate.
    pub fn now(&self) -> FlowPoint<f64> {
        self.hammer.point()
    }

    /// To the end of the next smooth piece; whether the side of the switch changed there. None where the motion cannot be
    /// followed.
    pub fn advance(&mut self, observer: &mut impl TrajectoryObserver) -> Option<bool> {
        let ended = self.hammer.step_on(observer)?;
        let followed = self.now().q.is_finite();
        followed.then_some(ended == StepEnded::Switched(()))
    }

    /// Runs to the end of the next contact; `None` if it has not begun by `until_s`, or does not end.
    pub fn next_contact(&mut self, until_s: f64) -> Option<Course> {
        for _ in 0..MAX_STEPS {
            if self.now().t > until_s {
                return None;
            }
            if self.advance(&mut ())? {
                return self.contact();
            }
        }
        None
    }

    /// The contact that has just begun, to its end.
    fn contact(&mut self) -> Option<Course> {
        let (onset, mut track) = (self.now().t, Track::default());
        for _ in 0..MAX_STEPS {
            if self.advance(&mut track)? {
                let end = self.now();
                return Some(Course {
                    contact: LocatedContact {
                        duration_s: end.t - onset,
                        ..track.contact?
                    },
                    pieces: track.pieces,
                    release: (end.q, end.v),
                });
            }
        }
        None
    }
}
