//! What the lanes hold of their cells, one row of memory per quantity.

use super::cart::{Joint, Ringing};
use super::job::Job;
use super::width::{Element, LaneNumbers};

/// Phase of an onset that never was.
const NEVER: f64 = -1e6;

/// Everything the lanes hold, one row per quantity.
#[derive(Default)]
pub struct Rows<E> {
    pub x: LaneNumbers<E>,
    pub v: LaneNumbers<E>,
    pub tau: LaneNumbers<E>,
    pub step: LaneNumbers<E>,
    pub per_step: LaneNumbers<E>,
    pub peak: LaneNumbers<E>,
    pub onsets: LaneNumbers<E>,
    pub recent: [LaneNumbers<E>; 3],
    pub rest: LaneNumbers<E>,
    pub drive: LaneNumbers<E>,
    pub bend: LaneNumbers<E>,
    pub spring: LaneNumbers<E>,
    pub damping: LaneNumbers<E>,
    /// The reciprocal of `spring`.
    pub soft: LaneNumbers<E>,
    /// [`Constants::widest2`](super::constants::Constants::widest2).
    pub widest2: LaneNumbers<E>,
    pub pull: LaneNumbers<E>,
    pub contact_spring: LaneNumbers<E>,
    pub contact_damper: LaneNumbers<E>,
    pub decay: LaneNumbers<E>,
    pub pulsation: LaneNumbers<E>,
    pub short: LaneNumbers<E>,
    pub rho: LaneNumbers<E>,
    pub forced_sin: LaneNumbers<E>,
    pub forced_cos: LaneNumbers<E>,
    pub forced_mean: LaneNumbers<E>,
    pub release: [LaneNumbers<E>; 3],
    pub top: [LaneNumbers<E>; 3],
    /// A cart that recoils: its ring and the ring's rate; x and v are then those of the slow part.
    pub ring: [LaneNumbers<E>; 2],
    /// Where it and its rate are while the lane touches.
    pub cart: [LaneNumbers<E>; 2],
    pub ringing: Ringing<LaneNumbers<E>>,
    pub joint: Joint<LaneNumbers<E>>,
}

impl<E: Element> Rows<E> {
    /// Puts a cell at its start into a lane, to take steps of `step` (drive phase, rad).
    pub fn fill(&mut self, lane: usize, job: &Job, step: f64) {
        let c = &job.constants;
        let e = E::from_f64;
        for (row, value) in [
            (&mut self.x, job.x),
            (&mut self.v, job.v),
            (&mut self.tau, job.tau),
            (&mut self.step, step),
            (&mut self.per_step, 1.0 / step),
            (&mut self.peak, 0.0),
            (&mut self.onsets, 0.0),
            (&mut self.rest, c.rest),
            (&mut self.drive, c.drive),
            (&mut self.bend, c.bend),
            (&mut self.spring, c.spring),
            (&mut self.damping, c.damping),
            (&mut self.soft, 1.0 / c.spring),
            (&mut self.widest2, c.widest2()),
            (&mut self.pull, c.pull),
            (&mut self.contact_spring, c.contact_spring),
            (&mut self.contact_damper, c.contact_damper),
            (&mut self.decay, c.decay),
            (&mut self.pulsation, c.pulsation),
            (&mut self.short, 1.0 / c.pulsation),
            (&mut self.rho, c.decay / c.pulsation),
            (&mut self.forced_sin, c.forced_sin),
            (&mut self.forced_cos, c.forced_cos),
            (&mut self.forced_mean, c.forced_mean),
        ] {
            row[lane] = e(value);
        }
        for row in &mut self.recent {
            row[lane] = e(NEVER);
        }
        for row in self.ring.iter_mut().chain(&mut self.cart) {
            row[lane] = e(0.0);
        }
        if let Some(recoil) = &c.recoil {
            let put = |row: &mut LaneNumbers<E>, value| row[lane] = e(value);
            self.ringing.put(&recoil.ringing, put);
            self.joint.put(&recoil.joint, put);
            let ring = recoil.ring([c.rest + job.x, job.v], [0.0; 2], job.tau);
            self.depart(lane, [job.x, job.v], ring);
        }
        for (rows, phase) in [
            (&mut self.release, c.release_phase),
            (&mut self.top, c.peak_phase),
        ] {
            let left = libm::exp(-c.decay / c.pulsation * phase);
            let (sin, cos) = libm::sincos(phase);
            for (row, value) in rows.iter_mut().zip([phase, left * cos, left * sin]) {
                row[lane] = e(value);
            }
        }
    }

    /// The hammer of a lane at `x`, `v` with a cart that rings.
    pub fn depart(&mut self, lane: usize, [x, v]: [f64; 2], [z, w]: [f64; 2]) {
        let e = E::from_f64;
        // In the lane's precision, so that a hammer on the surface is on it.
        let z = e(z);
        self.x[lane] = e(x - z.to_f64());
        self.v[lane] = e(v - w);
        self.ring[0][lane] = z;
        self.ring[1][lane] = e(w);
    }

    /// A lane that stands still below the surface.
    pub fn stand(&mut self, lane: usize) {
        self.x[lane] = E::from_f64(-1.0);
        for row in [
            &mut self.v,
            &mut self.tau,
            &mut self.step,
            &mut self.per_step,
        ]
        .into_iter()
        .chain(&mut self.ring)
        {
            row[lane] = E::default();
        }
    }
}
