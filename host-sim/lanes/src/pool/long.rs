//! Lanes whose cell is in a contact that is computed one at a time.

use std::f64::consts::TAU;

use super::Pool;
use crate::reduce::StrobeRecord;
use crate::sustained::{Sustained, SustainedEvent, SwitchSide};
use crate::width::LaneWidth;

impl<W: LaneWidth> Pool<'_, W> {
    /// A lane leaves its row for a sustained contact, which begins with an onset.
    pub(super) fn enter(&mut self, lane: usize) {
        let rows = &mut *self.rows;
        let recent = rows.recent.each_ref().map(|row| row[lane]);
        let tau = rows.tau[lane];
        self.in_sustained |= 1 << lane;
        let rate = rows.v[lane] + rows.ring[1][lane];
        self.lanes[lane].sustained = Some(Sustained {
            x: 0.0,
            v: rate,
            approach: rate,
            cart: rows.cart.each_ref().map(|row| row[lane]),
            tau,
            side: SwitchSide::Contact,
            peak: rows.peak[lane],
            onsets: rows.onsets[lane] as u32 + 1,
            recent: [tau, recent[0], recent[1]],
            chatter: self.lanes[lane].chatter,
        });
        rows.stand(lane);
    }

    /// Runs a lane's sustained contact to the section, or until the hammer is out and the lane returns to its row.
    #[inline(never)]
    pub(super) fn run_sustained(&mut self, lane: usize) {
        self.work.sustained += 1;
        let held = &mut self.lanes[lane];
        let (Some(mut contact), Some(job)) = (held.sustained.take(), held.job) else {
            return;
        };
        let constants = &self.jobs[job].constants;
        match contact.run(constants) {
            SustainedEvent::Lost => self.give_up(lane),
            SustainedEvent::Section => {
                let record = StrobeRecord {
                    x: contact.x,
                    v: contact.v,
                    force: contact.peak as f32,
                    onsets: u16::try_from(contact.onsets).unwrap_or(u16::MAX),
                    touched: true,
                    chatter: contact.chatter,
                };
                held.carried = contact.side == SwitchSide::Contact;
                contact.tau = 0.0;
                contact.peak = 0.0;
                contact.onsets = 0;
                contact.chatter = false;
                contact.recent = contact.recent.map(|t| t - TAU);
                held.sustained = Some(contact);
                self.record(lane, record);
            }
            SustainedEvent::Out => {
                self.in_sustained &= !(1 << lane);
                held.chatter = contact.chatter;
                let step = self.tuning.step / constants.fastest;
                let rows = &mut *self.rows;
                let ring = constants.recoil.map_or([0.0; 2], |recoil| {
                    recoil.ring([constants.rest, contact.v], contact.cart, contact.tau)
                });
                rows.depart(lane, [0.0, contact.v], ring);
                rows.tau[lane] = contact.tau;
                rows.step[lane] = step;
                rows.per_step[lane] = 1.0 / step;
                rows.peak[lane] = contact.peak;
                rows.onsets[lane] = f64::from(contact.onsets);
                for (row, t) in rows.recent.iter_mut().zip(contact.recent) {
                    row[lane] = t;
                }
            }
        }
    }
}
