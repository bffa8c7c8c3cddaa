//! A step by the power series of the motion, looked at piece by piece.

use shared::model::contacts::Period;
use shared::model::rig::SwitchMode;

use super::observer::{TrajectoryObserver, Within};
use super::series::Equations;
use super::{Reference, switching};
use crate::flow::{Scalar, StepEnded};

/// Pieces of what a power series reaches in which a switch is looked for: at least, and in contact.
const IN_FLIGHT: f64 = 4.0;
const IN_CONTACT: f64 = 2.0;

impl<R: Scalar> Reference<R> {
    /// [`Self::advance`] where the equations of motion are analytic: as far as a power series reaches.
    pub(super) fn advance_in_series(
        &mut self,
        equations: &Equations,
        end_s: f64,
        most: u64,
        period: &mut Period<f64>,
        observer: &mut impl TrajectoryObserver,
    ) -> Option<StepEnded<()>> {
        if self.pace.tried >= most {
            return None;
        }
        self.pace.tried += 1;
        let before = *self;
        let flow = before.flow();
        let series = equations.series(&before.rig, self.mode, &before.point);
        let (values, plain) = (series.in_values(), flow.in_values());
        let reach = series.reach(
            self.tolerance,
            flow.units,
            flow.recoil.map(|(_, units)| units),
        );
        let mut start = before.point.in_values();
        let to_go = end_s - start.t;
        let whole = reach.min(to_go);
        let pieces = match self.mode {
            SwitchMode::Flight => (whole / self.max_step).ceil().max(IN_FLIGHT),
            SwitchMode::Contact => IN_CONTACT,
        };
        let piece = whole / pieces;
        // A reach that is no number leaves none.
        let (mut switched, mut was) = (None, values.penetration(0.0));
        for k in 0..pieces as u32 {
            let after = f64::from(k) * piece;
            let mut end = values.point(after + piece);
            let near = values.penetration(after + piece);
            if self.mode == SwitchMode::Contact || !switching::out_of_reach(was, piece, near) {
                let ends = (&start, &end);
                let left = switching::locate_in(&plain, &values, ends, (after, piece));
                switched = left.map(|at| after + at);
            }
            was = near;
            if let Some(at) = switched {
                end = values.point(at);
            }
            let peak = (self.mode == SwitchMode::Contact)
                .then(|| switching::force_peak((start.t, end.t), |tau| values.force(after + tau)));
            self.tell(
                (start, end),
                Within::Series(&values),
                peak,
                period,
                observer,
            );
            if switched.is_some() {
                break;
            }
            start = end;
        }
        let (length, ended) = if let Some(at) = switched {
            let at = switching::instant(&flow, |tau| series.point(tau), at);
            (at, StepEnded::Switched(()))
        } else if to_go <= reach {
            (R::from_f64(end_s) - before.point.t, StepEnded::AtStop)
        } else {
            (R::from_f64(whole), StepEnded::Within)
        };
        self.enter(
            &values.totals(length.to_f64()),
            series.point(length),
            period,
        );
        if switched.is_some() {
            self.switch(period, observer);
        }
        Some(ended)
    }
}
