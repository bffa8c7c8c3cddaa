//! The contacts of the plant: when they begin and end, and what each step adds to them.

use shared::model::rig::SwitchMode;

use super::{Plant, PlantBlow, bisect};
use crate::bodies::{BodiesState, PlantTotals};
use crate::record::TrueContact;
use crate::shaker::SetPointPath;

impl Plant {
    /// Keeps what a step of contact adds to the contact's record.
    pub(super) fn keep(&mut self, before: &BodiesState, s: f64, h: f64, totals: &PlantTotals) {
        self.touched = true;
        let (f0, r0) = self.bodies.force_and_rate(before, s);
        let (f1, r1) = self.bodies.force_and_rate(&self.state, s + h);
        let (at, peak) = if r0 > 0.0 && r1 < 0.0 {
            largest(h, (f0, r0), (f1, r1))
        } else if f0 > f1 {
            (0.0, f0)
        } else {
            (h, f1)
        };
        if self.rising && r1 < 0.0 {
            self.rising = false;
            self.blows.push(PlantBlow {
                at_s: s + at,
                peak_n: peak,
            });
        }
        let started = self.ticks as f64 * self.tick_s;
        if let Some(open) = &mut self.open {
            if peak > open.peak_force_n {
                open.peak_force_n = peak;
                open.peak_at_s = started + s + at;
            }
            open.duration_s += h;
            open.impulse_n_s += totals.impulse;
            open.energy_lost_j += totals.contact_work;
        }
    }

    /// Crosses the switch `s` seconds into the tick: a contact begins or ends.
    pub(super) fn switch(&mut self, s: f64) {
        match self.bodies.mode {
            SwitchMode::Flight => self.begin_contact(s),
            SwitchMode::Contact => {
                let at = self.bodies.kinematics(&self.state);
                let front = self.state.front;
                if let Some(ground) = &mut self.bodies.ground
                    && ground.goes_on(&at, front)
                {
                    return;
                }
                self.bodies.mode = SwitchMode::Flight;
                if let Some(mut contact) = self.open.take() {
                    contact.rebound_speed_m_per_s = -self.bodies.kinematics(&self.state).rate;
                    self.finished.push(contact);
                }
            }
        }
    }

    /// Begins a contact `s` seconds into the tick.
    pub(super) fn begin_contact(&mut self, s: f64) {
        let at = self.bodies.kinematics(&self.state);
        let (approach, front) = (at.rate, self.state.front);
        if let Some(ground) = &mut self.bodies.ground {
            ground.begin(&at, front);
        }
        let onset_s = self.time_s() + s;
        self.bodies.mode = SwitchMode::Contact;
        self.bodies.approach = approach;
        self.rising = true;
        self.touched = true;
        self.open = Some(TrueContact {
            onset_s,
            approach_speed_m_per_s: approach,
            peak_at_s: onset_s,
            ..TrueContact::default()
        });
    }
}

/// Where (s into the step) and how large a cubic through value and slope at both ends is at its largest,
/// given that it rises at the start and falls at the end.
fn largest(h: f64, (f0, r0): (f64, f64), (f1, r1): (f64, f64)) -> (f64, f64) {
    let path = SetPointPath::new(h, (f0, r0), (f1, r1));
    let top = bisect(h, |s| path.at(s).1 < 0.0);
    (top, path.at(top).0)
}
