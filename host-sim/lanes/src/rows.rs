//! What the lanes hold of their cells, one row of memory per quantity.

use super::cart::{Joint, Ringing};
use super::job::Job;
use super::width::LaneNumbers;

/// Phase of an onset that never was.
const NEVER: f64 = -1e6;

/// Everything the lanes hold, one row per quantity.
#[derive(Default)]
pub struct Rows {
    pub x: LaneNumbers,
    pub v: LaneNumbers,
    pub tau: LaneNumbers,
    pub step: LaneNumbers,
    pub per_step: LaneNumbers,
    pub peak: LaneNumbers,
    pub onsets: LaneNumbers,
    pub recent: [LaneNumbers; 3],
    pub rest: LaneNumbers,
    pub drive: LaneNumbers,
    pub bend: LaneNumbers,
    pub spring: LaneNumbers,
    pub damping: LaneNumbers,
    /// The reciprocal of `spring`.
    pub soft: LaneNumbers,
    /// The square of the widest swing about rest that lanes follow.
    pub widest2: LaneNumbers,
    pub pull: LaneNumbers,
    pub contact_spring: LaneNumbers,
    pub contact_damper: LaneNumbers,
    pub decay: LaneNumbers,
    pub pulsation: LaneNumbers,
    pub short: LaneNumbers,
    pub rho: LaneNumbers,
    pub forced_sin: LaneNumbers,
    pub forced_cos: LaneNumbers,
    pub forced_mean: LaneNumbers,
    pub release: [LaneNumbers; 3],
    pub top: [LaneNumbers; 3],
    /// A cart that recoils: its ring and the ring's rate; x and v are then those of the slow part.
    pub ring: [LaneNumbers; 2],
    /// Where it and its rate are while the lane touches.
    pub cart: [LaneNumbers; 2],
    pub ringing: Ringing<LaneNumbers>,
    pub joint: Joint<LaneNumbers>,
}

impl Rows {
    /// Puts a cell at its start into a lane, to take steps of `step` (drive phase, rad).
    pub fn fill(&mut self, lane: usize, job: &Job, step: f64) {
        let c = &job.constants;
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
            row[lane] = value;
        }
        for row in &mut self.recent {
            row[lane] = NEVER;
        }
        for row in self.ring.iter_mut().chain(&mut self.cart) {
            row[lane] = 0.0;
        }
        if let Some(recoil) = &c.recoil {
            let put = |row: &mut LaneNumbers, value| row[lane] = value;
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
                row[lane] = value;
            }
        }
    }

    /// The hammer of a lane at `x`, `v` with a cart that rings.
    pub fn depart(&mut self, lane: usize, [x, v]: [f64; 2], [z, w]: [f64; 2]) {
        self.x[lane] = x - z;
        self.v[lane] = v - w;
        self.ring[0][lane] = z;
        self.ring[1][lane] = w;
    }

    /// A lane that stands still below the surface.
    pub fn stand(&mut self, lane: usize) {
        self.x[lane] = -1.0;
        for row in [
            &mut self.v,
            &mut self.tau,
            &mut self.step,
            &mut self.per_step,
        ]
        .into_iter()
        .chain(&mut self.ring)
        {
            row[lane] = 0.0;
        }
    }
}
