//! What the lanes hold of their cells, one row of memory per quantity.

use super::number::{Element, Row};
use super::pool::Job;

/// Phase of an onset that never was.
const NEVER: f64 = -1e6;

/// Everything the lanes hold, one row per quantity.
#[derive(Default)]
pub struct Rows<E> {
    pub x: Row<E>,
    pub v: Row<E>,
    pub tau: Row<E>,
    pub step: Row<E>,
    pub per_step: Row<E>,
    pub peak: Row<E>,
    pub onsets: Row<E>,
    pub recent: [Row<E>; 3],
    pub rest: Row<E>,
    pub drive: Row<E>,
    pub bend: Row<E>,
    pub spring: Row<E>,
    pub damping: Row<E>,
    /// The reciprocal of `spring`.
    pub soft: Row<E>,
    /// [`Constants::widest2`](super::constants::Constants::widest2).
    pub widest2: Row<E>,
    pub pull: Row<E>,
    pub contact_spring: Row<E>,
    pub contact_damper: Row<E>,
    pub decay: Row<E>,
    pub pulsation: Row<E>,
    pub short: Row<E>,
    pub rho: Row<E>,
    pub forced_sin: Row<E>,
    pub forced_cos: Row<E>,
    pub forced_mean: Row<E>,
    pub release: [Row<E>; 3],
    pub top: [Row<E>; 3],
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

    /// A lane that stands still below the surface.
    pub fn stand(&mut self, lane: usize) {
        self.x[lane] = E::from_f64(-1.0);
        for row in [
            &mut self.v,
            &mut self.tau,
            &mut self.step,
            &mut self.per_step,
        ] {
            row[lane] = E::default();
        }
    }
}
