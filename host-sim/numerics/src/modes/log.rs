//! The contacts of a run from drive phase 0 to drive phase 0.

use shared::model::contacts::{Contact, ContactPiece, Ledger, Period};
use shared::model::drive::{Stamp, TURN};

/// What a period saw, and the strongest contact since it was last asked for.
#[derive(Clone, Debug, Default)]
pub struct Log {
    cycle: u32,
    ledger: Ledger<f64>,
    strongest: Option<Contact<f64>>,
}

impl Log {
    /// Contact begins, or ends, at drive phase `turns` (0 to 1) at the hammer's rate `rate` (m/s).
    pub fn switch(&mut self, touching: bool, turns: f64, rate: f64) {
        let at = Stamp {
            cycle: self.cycle,
            phase: (turns * TURN) as u32,
        };
        if touching {
            self.ledger.onset(at, rate);
            return;
        }
        self.ledger.release(at, rate);
        let finished = self.ledger.take_finished();
        let force = |c: &Option<Contact<f64>>| c.map_or(-1.0, |c| c.peak_force);
        if force(&finished) > force(&self.strongest) {
            self.strongest = finished;
        }
    }

    /// Enters a piece of the contact under way.
    pub fn add(&mut self, piece: &ContactPiece<f64>) {
        self.ledger.add(piece);
    }

    /// What happened in the period that ends now.
    pub fn close_period(&mut self) -> Period<f64> {
        self.cycle = self.cycle.wrapping_add(1);
        self.ledger.close_period()
    }

    /// The contact with the largest force since this was last asked.
    pub fn take_strongest(&mut self) -> Option<Contact<f64>> {
        self.strongest.take()
    }
}
