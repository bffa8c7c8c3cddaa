//! How the true rig changed over a run, and the best it could do on average meanwhile.

use shared::model::params::RigParams;

use super::optimum::Optimum;

/// The rig is kept this often while it changes, s.
const KEPT_EVERY_S: f64 = 1.0;

/// At most this many rigs of a run are searched for their optimum; between them it is interpolated.
const SEARCHED: usize = 5;

/// The rig from a time on, and how long it counted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moment {
    /// The true rig in this stretch of time.
    pub rig: RigParams,
    /// Since when, s of rig time.
    pub since_s: f64,
    /// How long it counted for the share from the start, s.
    pub asked_s: f64,
    /// How long it counted for the share from Hold on, s.
    pub held_s: f64,
}

/// The rig over a run; by default there is none.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RigPath {
    moments: Vec<Moment>,
}

impl RigPath {
    /// A rig that has not changed yet.
    pub fn new(rig: &RigParams) -> Self {
        Self {
            moments: vec![moment(rig, 0.0)],
        }
    }

    /// The rig is now this one.
    pub fn is(&mut self, rig: &RigParams, time_s: f64) {
        let changed = self.moments.len() > 1;
        let Some(last) = self.moments.last_mut() else {
            return;
        };
        if last.rig == *rig {
            return;
        }
        let recent = changed && time_s - last.since_s < KEPT_EVERY_S;
        if recent {
            last.rig = *rig;
        } else {
            self.moments.push(moment(rig, time_s));
        }
    }

    /// The rig counted for so long.
    pub fn counted(&mut self, asked_s: f64, held_s: f64) {
        if let Some(last) = self.moments.last_mut() {
            last.asked_s += asked_s;
            last.held_s += held_s;
        }
    }

    /// The mean optimum over the time that `counts`, by `optimum` of a moment; of the end if no time counts.
    pub fn mean(
        &self,
        counts: fn(&Moment) -> f64,
        optimum: impl Fn(&Moment) -> Option<Optimum>,
    ) -> Option<Optimum> {
        let last = self.moments.len().checked_sub(1)?;
        let total_s: f64 = self.moments.iter().map(counts).sum();
        if last == 0 || total_s <= 0.0 {
            return optimum(&self.moments[last]);
        }
        let counted: Vec<usize> = (0..=last)
            .filter(|i| counts(&self.moments[*i]) > 0.0)
            .collect();
        let (from, to) = (counted[0], counted[counted.len() - 1]);
        let knots = (to - from + 1).min(SEARCHED);
        let steps = (knots - 1).max(1);
        let mut known: Vec<(usize, Optimum)> = Vec::new();
        for k in 0..knots {
            let at = from + k * (to - from) / steps;
            known.push((at, optimum(&self.moments[at])?));
        }
        let (mut frequency, mut force) = (0.0, 0.0);
        for i in counted {
            let at = known.partition_point(|(at, _)| *at <= i);
            let (below, above) = (known[at - 1], known[at.min(known.len() - 1)]);
            let width = (above.0 - below.0).max(1) as f64;
            let share = (i - below.0) as f64 / width;
            let between = |a: f64, b: f64| a + share * (b - a);
            let weight = counts(&self.moments[i]) / total_s;
            frequency += weight * between(below.1.frequency_hz, above.1.frequency_hz);
            force += weight * between(below.1.force_n, above.1.force_n);
        }
        Some(Optimum {
            frequency_hz: frequency,
            force_n: force,
        })
    }
}

fn moment(rig: &RigParams, since_s: f64) -> Moment {
    Moment {
        rig: *rig,
        since_s,
        asked_s: 0.0,
        held_s: 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use shared::model::params::WIRES;

    fn at_gap(gap_m: f64) -> RigParams {
        RigParams { gap_m, ..WIRES }
    }

    /// Linear in the gap, so that its mean over time is known.
    fn linear(moment: &Moment) -> Option<Optimum> {
        Some(Optimum {
            frequency_hz: 4.0,
            force_n: 100.0 - 1e4 * moment.rig.gap_m,
        })
    }

    #[test]
    fn the_mean_of_a_linear_drift_is_its_middle_and_of_a_still_rig_itself() {
        let mut path = RigPath::new(&at_gap(0.0));
        path.counted(5.0, 0.0);
        assert_eq!(path.mean(|m| m.held_s, linear).unwrap().force_n, 100.0);
        for block in 0..200_000 {
            path.is(
                &at_gap(1e-3 * f64::from(block) / 2e5),
                f64::from(block) * 5e-4,
            );
            path.counted(5e-4, 5e-4);
        }
        assert!(path.moments.len() < 120, "{}", path.moments.len());
        let held = path.mean(|m| m.held_s, linear).unwrap().force_n;
        assert!((held - 95.0).abs() < 0.1, "{held}");
        // Five seconds before, of a hundred and five in all, at 100 N.
        let asked = path.mean(|m| m.asked_s, linear).unwrap().force_n;
        assert!((asked - (500.0 + 9500.0) / 105.0).abs() < 0.1, "{asked}");
    }

    #[test]
    fn a_sudden_change_weighs_both_rigs_by_their_time() {
        let mut path = RigPath::new(&at_gap(0.0));
        path.counted(3.0, 3.0);
        path.is(&at_gap(1e-3), 3.0);
        path.counted(1.0, 1.0);
        let mean = path.mean(|m| m.held_s, linear).unwrap().force_n;
        assert!((mean - (3.0 * 100.0 + 90.0) / 4.0).abs() < 1e-9, "{mean}");
    }
}
