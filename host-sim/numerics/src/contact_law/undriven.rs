//! A hammer that nothing drives: released, it falls on the surface and bounces.
//!
//! The steps and the location of the switches are the reference's ([`crate::reference`]), and so are the rig and
//! its contact law; only the cart stands still, and errors are weighed by this motion's own size, not by a drive's.

use shared::model::rig::{Mode, Rig};

use crate::reference::flow::Field;
use crate::reference::switching::{Arc, force_peak, locate};
use crate::reference::tableau;
use crate::reference::{Contact, Point, Totals};

/// Errors per step are kept below this share of the motion's size.
const TOLERANCE: f64 = 1e-12;

/// First step after a switch, s.
const FIRST_STEP_S: f64 = 1e-5;

/// Steps after which a motion is given up: one contact takes some fifty.
const MAX_STEPS: usize = 20_000;

/// A smooth piece of the motion.
#[derive(Clone, Copy, Debug)]
pub struct Piece {
    /// When it begins, s since the release.
    pub start_s: f64,
    /// Coordinate and rate within it (quintic).
    pub arc: Arc,
    /// Side of the switch.
    pub mode: Mode,
    /// δ̇⁻, m/s.
    pub approach: f64,
}

impl Piece {
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
            Mode::Flight => 0.0,
            Mode::Contact => {
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
    pub contact: Contact,
    /// Its pieces, in time.
    pub pieces: Vec<Piece>,
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

/// The hammer.
#[derive(Clone, Copy, Debug)]
pub struct Undriven<'a> {
    rig: &'a Rig<f64>,
    point: Point<f64>,
    mode: Mode,
    approach: f64,
    units: (f64, f64),
    max_step: f64,
    next_step: f64,
}

impl<'a> Undriven<'a> {
    /// Released in flight at coordinate `q` and rate `v`; `scale` is the size of coordinate and rate in this
    /// motion, and no step is longer than `max_step` s.
    pub fn new(rig: &'a Rig<f64>, (q, v): (f64, f64), scale: (f64, f64), max_step: f64) -> Self {
        Self {
            rig,
            point: Point::on_course(0.0, q, v),
            mode: Mode::Flight,
            approach: v.max(0.0),
            units: (TOLERANCE * scale.0, TOLERANCE * scale.1),
            max_step,
            next_step: FIRST_STEP_S,
        }
    }

    /// Time since the release (s), coordinate and rate.
    pub fn now(&self) -> Point<f64> {
        self.point
    }

    fn field(&self) -> Field<'a, f64> {
        Field {
            rig: self.rig,
            omega: 0.0,
            drive_acceleration: 0.0,
            mode: self.mode,
            approach: self.approach,
            smoothed: None,
            recoil: None,
        }
    }

    /// The next smooth piece, what was integrated over it, and whether the side of the switch changed at its end.
    /// None where the motion cannot be followed.
    pub fn advance(&mut self) -> Option<(Piece, Totals, bool)> {
        let field = self.field();
        let from = self.point;
        for _ in 0..100 {
            let h = self.next_step.min(self.max_step);
            let mut step = field.step(&from, h, self.units);
            if !step.end.q.is_finite() {
                return None;
            }
            if step.error > 1.0 {
                self.next_step = tableau::shorter(h, step.error);
                continue;
            }
            self.next_step = tableau::next(h, step.error);
            let at = locate(&field, &from, h, &step.end, self.units);
            if let Some(at) = at {
                step = field.step(&from, at, self.units);
                self.next_step = FIRST_STEP_S;
            }
            let triple = |p: &Point<f64>| (p.q, p.v, field.acceleration(p).0);
            let piece = Piece {
                start_s: from.t,
                arc: Arc::new(step.end.t - from.t, triple(&from), triple(&step.end)),
                mode: self.mode,
                approach: self.approach,
            };
            self.point = step.end;
            if at.is_some() {
                self.switch();
            }
            return Some((piece, step.totals, at.is_some()));
        }
        None
    }

    fn switch(&mut self) {
        self.mode = match self.mode {
            Mode::Flight => {
                self.approach = self.rig.kinematics(self.point.q, self.point.v).rate;
                Mode::Contact
            }
            Mode::Contact => Mode::Flight,
        };
    }

    /// Runs to the end of the next contact; `None` if it has not begun by `until_s`, or does not end.
    pub fn next_contact(&mut self, until_s: f64) -> Option<Course> {
        for _ in 0..MAX_STEPS {
            if self.point.t > until_s {
                return None;
            }
            if let (_, _, true) = self.advance()? {
                return self.contact();
            }
        }
        None
    }

    /// The contact that has just begun, to its end.
    fn contact(&mut self) -> Option<Course> {
        let onset = self.point.t;
        let mut contact = Contact {
            onset_s: onset,
            duration_s: 0.0,
            approach_speed_m_per_s: self.approach,
            rebound_speed_m_per_s: 0.0,
            peak_force_n: 0.0,
            peak_at_s: onset,
            impulse_n_s: 0.0,
            energy_lost_j: 0.0,
        };
        let mut pieces = Vec::new();
        for _ in 0..MAX_STEPS {
            let (field, from) = (self.field(), self.point);
            let (piece, totals, ended) = self.advance()?;
            let (at, peak) = force_peak(&field, &from, &self.point, self.units);
            if peak > contact.peak_force_n {
                contact.peak_force_n = peak;
                contact.peak_at_s = at;
            }
            contact.impulse_n_s += totals.impulse;
            contact.energy_lost_j += totals.contact_work;
            pieces.push(piece);
            if ended {
                let end = self.point;
                contact.duration_s = end.t - onset;
                contact.rebound_speed_m_per_s = -self.rig.kinematics(end.q, end.v).rate;
                return Some(Course {
                    contact,
                    pieces,
                    release: (end.q, end.v),
                });
            }
        }
        None
    }
}
