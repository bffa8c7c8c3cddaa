//! An orbit that touches once without a blow, followed from that touch to itself.
//!
//! The return map has a square root at a graze, and no derivative on one side. But begun at the touch (δ = 0 and δ̇ = 0 at
//! an unknown drive phase) the orbit is smooth in everything: it is followed through the flight from the touch, through
//! its contacts, and through the flight to the touch. In these two flights the surface is moved out of the way, so that
//! an orbit that would touch a little too hard or not at all is followed just the same. It closes where δ and δ̇ are 0
//! again.

use shared::model::params::RigParams;
use shared::model::rig::Rig;

use super::conditions::OrbitConditions;
use crate::continuation::march::ContactMargins;
use crate::flow::Scalar;
use crate::orbit::{Monodromy, OrbitWatch, Section, carried, seeds};
use crate::reference::{LocatedContact, TrajectoryObserver};

/// The flights from and to the touch in which no other contact is near, drive periods.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Windows {
    pub after: f64,
    pub before: f64,
}

impl Default for Windows {
    fn default() -> Self {
        Self {
            after: WIDEST,
            before: WIDEST,
        }
    }
}

/// The longest that is needed.
const WIDEST: f64 = 0.05;

impl Windows {
    /// Half of the flights between the touch at `phase` and the contacts `seen` from then on, in `periods`.
    pub fn between(seen: &[LocatedContact], frequency_hz: f64, phase: f64, periods: u8) -> Self {
        let (Some(first), Some(last)) = (seen.first(), seen.last()) else {
            return Self::default();
        };
        let after = first.onset_s * frequency_hz - phase;
        let released = (last.onset_s + last.duration_s) * frequency_hz;
        let before = phase + f64::from(periods) - released;
        Self {
            after: (0.5 * after).min(WIDEST),
            before: (0.5 * before).min(WIDEST),
        }
    }
}

/// An orbit from its touch on.
#[derive(Clone, Copy, Debug)]
pub struct Graze {
    pub params: RigParams,
    pub frequency_hz: f64,
    pub periods: u8,
    /// Drive phase of the touch, turns.
    pub phase: f64,
    /// Deviation of the cart from its course, m, and its rate, m/s, at the touch.
    pub cart: [f64; 2],
    pub windows: Windows,
}

impl Graze {
    fn rig(&self) -> Option<Rig<f64>> {
        Rig::new(&self.params).ok()
    }

    /// Hammer and cart at the touch.
    fn start(&self, rig: &Rig<f64>) -> Section {
        let [e, w] = self.cart;
        [rig.coordinate_at(self.params.gap_m), 0.0, e, w]
    }

    /// From `start` at the touch to the next touch; what is between the two windows is watched.
    fn around<R: Scalar>(
        &self,
        start: [R; 4],
        watch: &mut impl TrajectoryObserver,
    ) -> Option<[R; 4]> {
        let Windows { after, before } = self.windows;
        let whole = f64::from(self.periods);
        let phase = self.phase.rem_euclid(1.0);
        let left = self.flight(start, phase, after)?;
        let between = whole - after - before;
        let turns = (phase + after, between);
        let struck = carried(&self.params, self.frequency_hz, left, turns, watch)?;
        self.flight(struck, phase + whole - before, before)
    }

    /// [`carried`] of this rig with its surface out of reach.
    fn flight<R: Scalar>(&self, state: [R; 4], from: f64, turns: f64) -> Option<[R; 4]> {
        let open = self.without_surface();
        // Coordinates are counted from the surface.
        let rest = |params: &RigParams| Some(Rig::<f64>::new(params).ok()?.coordinate_at(0.0));
        let shift = R::from_f64(rest(&open)? - rest(&self.params)?);
        let [q, v, e, w] = state;
        let state = [q + shift, v, e, w];
        let [q, v, e, w] = carried(&open, self.frequency_hz, state, (from, turns), &mut ())?;
        Some([q - shift, v, e, w])
    }

    /// The rig with its surface out of reach.
    fn without_surface(&self) -> RigParams {
        let farthest = match self.params.support {
            shared::model::params::SupportParams::Wires { length_m, .. } => 0.4999 * length_m,
            shared::model::params::SupportParams::Beams { .. } => 0.1,
        };
        RigParams {
            gap_m: farthest.min(0.1),
            ..self.params
        }
    }

    /// Penetration and its rate at the end, and how far the cart is from where it was: over A0 and A0 Ω.
    pub fn miss(&self) -> Option<Vec<f64>> {
        let rig = self.rig()?;
        let start = self.start(&rig);
        let end = self.around(start, &mut ())?;
        let at = rig.kinematics(end[0], end[1]);
        let metre = rig.amplitude();
        let speed = metre * std::f64::consts::TAU * self.frequency_hz;
        let mut miss = vec![at.delta / metre, at.rate / speed];
        if self.params.cart.recoils() {
            miss.push((end[2] - start[2]) / metre);
            miss.push((end[3] - start[3]) / speed);
        }
        miss.iter().all(|m| m.is_finite()).then_some(miss)
    }

    /// What the orbit shows, with the derivative of the return map on the side without the touch.
    pub fn found(&self) -> Option<OrbitConditions> {
        if self.params.cart.recoils() {
            self.found_along::<4>()
        } else {
            self.found_along::<2>()
        }
    }

    fn found_along<const N: usize>(&self) -> Option<OrbitConditions> {
        let rig = self.rig()?;
        let start = self.start(&rig);
        let mut seen = OrbitWatch::default();
        let end = self.around(seeds::<N>(start), &mut seen)?;
        let rate = std::f64::consts::TAU * self.frequency_hz;
        let (scale, metre) = (rig.coordinate_scale(), rig.amplitude());
        let units = [scale, scale * rate, metre, metre * rate];
        let period_s = f64::from(self.periods) / self.frequency_hz;
        let hz = self.frequency_hz;
        // Times from the drive phase 0 before the touch.
        let begun = (self.phase.rem_euclid(1.0) + self.windows.after).floor();
        for contact in &mut seen.contacts {
            contact.onset_s += begun / hz;
        }
        Some(OrbitConditions {
            section: self.section(&rig)?,
            impacts: seen.contacts.len() as u16,
            force_n: (seen.contacts.iter()).fold(0.0, |most, c| most.max(c.peak_force_n)),
            monodromy: Monodromy::of_seeds(end, units),
            onsets: (seen.contacts.iter()).map(|c| c.onset_s * hz).collect(),
            margins: ContactMargins::new(&seen, period_s),
            flights: Some(seen.contacts),
            leaving: Some(-self.acceleration(&rig)? / (metre * rate * rate)),
        })
    }

    /// δ̈ at the touch, m/s².
    fn acceleration(&self, rig: &Rig<f64>) -> Option<f64> {
        /// Far shorter than a drive period, and long enough for the difference.
        const TURNS: f64 = 1e-5;
        let phase = self.phase.rem_euclid(1.0);
        let end = self.flight(self.start(rig), phase, TURNS)?;
        let rate = rig.kinematics(end[0], end[1]).rate;
        Some(rate * self.frequency_hz / TURNS)
    }

    /// Hammer at drive phase 0.
    fn section(&self, rig: &Rig<f64>) -> Option<[f64; 2]> {
        let phase = self.phase.rem_euclid(1.0);
        let after = self.windows.after.min(1.0 - phase);
        let left = self.flight(self.start(rig), phase, after)?;
        let rest = 1.0 - phase - after;
        if rest <= 0.0 {
            return Some([left[0], left[1]]);
        }
        let turns = (phase + after, rest);
        let [q, v, ..] = carried(&self.params, self.frequency_hz, left, turns, &mut ())?;
        Some([q, v])
    }
}
