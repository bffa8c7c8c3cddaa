//! What happens at a switch, and what each step adds to the blow under way.

use shared::model::contacts::{Period, SUSTAINED_CONTACT_S};
use shared::model::slider::Touch;

use super::blow::GroundBlow;
use super::exits::Exit;
use super::flow::{DrillPoint, DrillStep};
use super::march::Drill;
use crate::flow::{Scalar, reached};
use crate::root::maximum;

/// A hammer that strikes the bit again this soon after they parted still strikes the same blow, s: the bit comes back from
/// the ground to a hammer that has hardly moved.
pub const SAME_BLOW_S: f64 = 5e-3;

impl<R: Scalar> Drill<R> {
    pub(super) fn accept(&mut self, step: &DrillStep<R>, period: &mut Period<f64>) {
        let (dug, energies) = self.flow().gained(&self.point, step);
        let ground = match self.open {
            Some(_) => self.peak_on_ground(step),
            None => 0.0,
        };
        if self.hammer_touches() {
            let peak = match self.bit {
                Some(_) => self.peak(step),
                None => ground,
            };
            if let Some(open) = &mut self.open {
                open.peak_force_n = open.peak_force_n.max(peak);
                open.duration_s += (step.end.t - self.point.t).to_f64();
                open.energy_lost_j += energies.contact;
                open.impulse_n_s += energies.impulse;
                let third = self.onsets[2];
                period.chatter |=
                    open.duration_s > SUSTAINED_CONTACT_S && open.onset_s - third < self.period_s;
            }
            period.touched = true;
            period.peak_force = period.peak_force.max(peak);
        }
        if let Some(open) = &mut self.open {
            open.progress_m += dug.to_f64();
            open.ground_force_n = open.ground_force_n.max(ground);
        }
        self.watch_loop(step);
        self.energies.add(&energies, 1.0);
        self.drift += dug.to_f64();
        self.dug += dug;
        self.point = step.end;
    }

    /// The largest force between hammer and bit in a step, N.
    fn peak(&self, step: &DrillStep<R>) -> f64 {
        let flow = self.flow();
        let force = |p: &DrillPoint<R>| flow.acting(p).force.to_f64();
        let rises = |p: &DrillPoint<R>| flow.struck_force_rate(p) > 0.0;
        self.largest(step, force, rises, f64::INFINITY)
    }

    /// The largest force on the ground in a step, N.
    fn peak_on_ground(&self, step: &DrillStep<R>) -> f64 {
        let flow = self.flow();
        let force = |p: &DrillPoint<R>| flow.acting(p).ground.to_f64();
        let rises = |p: &DrillPoint<R>| self.touch == Touch::Held && flow.held_force_rate(p) > 0.0;
        let most = self.slider.threshold.to_f64();
        self.largest(step, force, rises, most)
    }

    /// The largest `force` in a step, which cannot pass `most`: at an end, or within where it rises at first and falls at
    /// last.
    fn largest(
        &self,
        step: &DrillStep<R>,
        force: impl Fn(&DrillPoint<R>) -> f64,
        rises: impl Fn(&DrillPoint<R>) -> bool,
        most: f64,
    ) -> f64 {
        let ends = force(&self.point).max(force(&step.end));
        if !rises(&self.point) || rises(&step.end) {
            return ends;
        }
        let flow = self.flow();
        let h = (step.end.t - self.point.t).to_f64();
        let within = |s: f64| force(&reached(&flow, &self.point, R::from_f64(s * h)));
        let top = within(maximum(within, (0.0, 1.0), 1e-4, 0.5));
        top.max(ends).min(most)
    }

    pub(super) fn switch(
        &mut self,
        exit: Exit,
        period: &mut Period<f64>,
        blows: &mut Vec<GroundBlow>,
    ) {
        match exit {
            Exit::Meets => {
                self.meet();
                if self.bit.is_none() {
                    period.onsets = period.onsets.saturating_add(1);
                    period.touched = true;
                }
            }
            Exit::Leaves => {
                self.touch = Touch::Apart;
                if self.bit.is_none() {
                    blows.extend(self.open.take());
                }
            }
            Exit::GivesWay => self.touch = Touch::Slipping,
            Exit::Holds => self.touch = Touch::Held,
            Exit::Strikes => {
                self.close_blow(blows);
                if self.open.is_none() {
                    period.onsets = period.onsets.saturating_add(1);
                }
                period.touched = true;
                self.strike();
            }
            Exit::Parts => self.part(),
        }
    }

    /// Hammer, or bit, meets the ground.
    pub(super) fn meet(&mut self) {
        let p = &self.point;
        let speed = self.flow().speed(p);
        self.touch = self.slider.at_onset(p.e, speed);
        if self.bit.is_none() {
            self.open_blow(speed);
        }
    }

    /// Hammer meets bit: a blow begins, or the one under way has one contact more.
    pub(super) fn strike(&mut self) {
        let [_, speed] = self.flow().into_bit(&self.point);
        self.struck = true;
        match &mut self.open {
            Some(open) => open.contacts += 1,
            None => self.open_blow(speed),
        }
    }

    fn open_blow(&mut self, speed: R) {
        let onset_s = self.now_s();
        self.open = Some(GroundBlow {
            onset_s,
            approach_speed_m_per_s: speed.to_f64(),
            contacts: 1,
            ..GroundBlow::default()
        });
        self.onsets = [onset_s, self.onsets[0], self.onsets[1]];
    }

    /// Hammer and bit part. What is left in the contact between them is lost.
    fn part(&mut self) {
        if let Some(bit) = &self.bit {
            let [x, _] = self.flow().into_bit(&self.point);
            self.energies.bit_heat += bit.stored_energy(x).to_f64();
        }
        self.struck = false;
        self.parted_s = self.now_s();
    }

    /// A blow on a bit is over when they have been apart for long enough.
    pub(super) fn close_blow(&mut self, blows: &mut Vec<GroundBlow>) {
        let apart = self.now_s() - self.parted_s > SAME_BLOW_S;
        if self.bit.is_some() && !self.struck && apart {
            blows.extend(self.open.take());
        }
    }
}
