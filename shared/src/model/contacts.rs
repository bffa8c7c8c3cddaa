//! The record of contacts: each finished contact, and the contacts of a drive period.

use crate::model::drive::Stamp;
use crate::model::scalar::Real;

/// A sustained contact: one longer than this, s. After three onsets within one period it is chatter.
pub const SUSTAINED_CONTACT_S: f64 = 5e-3;

/// One finished contact: a stay in Γ+.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact<R> {
    /// Instant at which the contact began.
    pub onset: Stamp,
    /// Instant at which it ended.
    pub release: Stamp,
    /// How long it lasted, s.
    pub duration_s: R,
    /// δ̇ at onset, m/s.
    pub approach_speed: R,
    /// −δ̇ at release, m/s.
    pub rebound_speed: R,
    /// Largest force, N, interpolated between the integrator's points.
    pub peak_force: R,
    /// Impulse ∫F dt of the contact, N·s.
    pub impulse: R,
    /// Energy the contact took from the hammer, J: the work of the force (or torque) really applied.
    pub energy_lost: R,
}

/// What happened in one drive period, strobe to strobe.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Period<R> {
    /// Contacts that began in the period.
    pub onsets: u16,
    /// Whether the hammer touched the surface at all.
    pub touched: bool,
    /// Whether three or more onsets ended in a sustained contact ([`SUSTAINED_CONTACT_S`]).
    pub chatter: bool,
    /// Largest contact force, N.
    pub peak_force: R,
}

/// A piece of a step spent in contact: what the ledger needs of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactPiece<R> {
    /// Length of the piece, s.
    pub span_s: R,
    /// Force at its two ends, N.
    pub force: (R, R),
    /// Rate of the force at its two ends, N/s.
    pub force_rate: (R, R),
    /// ∫F dt over it, N·s.
    pub impulse: R,
    /// Work done on the surface over it, J.
    pub work: R,
}

/// The contact record: the open contact, and the period so far.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Ledger<R> {
    open: Option<Open<R>>,
    period: Period<R>,
    /// Onsets of this contact and the two before it, latest first.
    recent: [Option<Stamp>; 3],
    finished: Option<Contact<R>>,
    /// ∫F dt since it was last taken, N·s.
    pressed: R,
    /// The longest tick that would have been short enough everywhere so far, s; 0: this one is.
    tick_needed: R,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Open<R> {
    onset: Stamp,
    duration: R,
    approach: R,
    peak: R,
    impulse: R,
    work: R,
}

impl<R: Real> Ledger<R> {
    /// A contact begins at `at` with penetration rate `approach`, m/s.
    #[inline]
    pub fn onset(&mut self, at: Stamp, approach: R) {
        let [last, before, _] = self.recent;
        self.recent = [Some(at), last, before];
        self.period.onsets = self.period.onsets.saturating_add(1);
        self.resume(at, approach);
    }

    /// A run starts at `at` within a contact: the contact is recorded, but not counted as an onset.
    #[inline]
    pub fn resume(&mut self, at: Stamp, approach: R) {
        self.period.touched = true;
        self.open = Some(Open {
            onset: at,
            duration: R::ZERO,
            approach,
            peak: R::ZERO,
            impulse: R::ZERO,
            work: R::ZERO,
        });
    }

    /// Time passes in contact.
    #[inline]
    pub fn add(&mut self, piece: &ContactPiece<R>) {
        let Some(open) = &mut self.open else {
            return;
        };
        let peak = piece.peak();
        open.duration += piece.span_s;
        open.impulse += piece.impulse;
        self.pressed += piece.impulse;
        open.work += piece.work;
        open.peak = open.peak.max(peak);
        self.period.touched = true;
        self.period.peak_force = self.period.peak_force.max(peak);
        if open.duration > R::from_f64(SUSTAINED_CONTACT_S)
            && let [Some(last), _, Some(third)] = self.recent
            && last.within_a_turn_of(third)
        {
            self.period.chatter = true;
        }
    }

    /// The contact ends at `at` with penetration rate `rate` (negative: moving away), m/s.
    #[inline]
    pub fn release(&mut self, at: Stamp, rate: R) {
        let Some(open) = self.open.take() else {
            return;
        };
        self.finished = Some(Contact {
            onset: open.onset,
            release: at,
            duration_s: open.duration,
            approach_speed: open.approach,
            rebound_speed: -rate,
            peak_force: open.peak,
            impulse: open.impulse,
            energy_lost: open.work,
        });
    }

    /// The contact finished since the last call, if any; the last one, where two ended within one tick.
    #[inline]
    pub fn take_finished(&mut self) -> Option<Contact<R>> {
        self.finished.take()
    }

    /// ∫F dt since the last call, N·s.
    #[inline]
    pub fn take_impulse(&mut self) -> R {
        core::mem::take(&mut self.pressed)
    }

    /// Notes that a part of a tick was too long for its contact: pieces short enough reached only `span_s` of it.
    #[inline]
    pub fn note_tick_needed(&mut self, span_s: R) {
        if self.tick_needed == R::ZERO || span_s < self.tick_needed {
            self.tick_needed = span_s;
        }
    }

    /// The tick that would have been short enough for every contact so far, s, if this one is not: under the
    /// nonlinear laws a very hard contact needs more pieces than a tick has.
    #[inline]
    pub fn tick_needed(&self) -> Option<R> {
        (self.tick_needed > R::ZERO).then_some(self.tick_needed)
    }

    /// Closes the period at a strobe.
    #[inline]
    pub fn close_period(&mut self) -> Period<R> {
        let fresh = Period {
            touched: self.open.is_some(),
            ..Period::default()
        };
        core::mem::replace(&mut self.period, fresh)
    }
}

impl<R: Real> ContactPiece<R> {
    /// Largest force in the piece, N: at an end, or at the interior maximum of the cubic through both
    /// ends' values and slopes.
    #[inline]
    fn peak(&self) -> R {
        let (f0, f1) = self.force;
        let ends = f0.max(f1);
        let (d0, d1) = (
            self.force_rate.0 * self.span_s,
            self.force_rate.1 * self.span_s,
        );
        if !(d0 > R::ZERO && d1 < R::ZERO) {
            return ends;
        }
        // Slope of the cubic: c + b s + a s², falling from d0 > 0 to d1 < 0; its one root in (0, 1).
        let three = R::ONE + R::TWO;
        let rise = f1 - f0;
        let a = three * (d0 + d1 - R::TWO * rise);
        let b = R::TWO * (three * rise - R::TWO * d0 - d1);
        let discriminant = (b * b - R::TWO * R::TWO * a * d0).max(R::ZERO);
        let s = R::TWO * d0 / (discriminant.sqrt() - b);
        // Horner of f0 + d0 s + b/2 s² + a/3 s³.
        let top = f0 + s * (d0 + s * (R::HALF * b + s * (a / three)));
        ends.max(top)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_peak_between_two_points_is_found() {
        // F = 100 sin(t) from t = 1.4 to 1.7: the top is 100.
        let (t0, t1) = (1.4_f64, 1.7_f64);
        let piece = ContactPiece {
            span_s: t1 - t0,
            force: (100.0 * t0.sin(), 100.0 * t1.sin()),
            force_rate: (100.0 * t0.cos(), 100.0 * t1.cos()),
            impulse: 0.0,
            work: 0.0,
        };
        assert!((piece.peak() - 100.0).abs() < 3e-3, "{}", piece.peak());
    }

    #[test]
    fn three_onsets_and_a_long_stay_are_chatter_and_two_are_not() {
        for onsets in [2, 3] {
            let mut ledger = Ledger::<f32>::default();
            for i in 0..onsets {
                let at = Stamp {
                    cycle: 7,
                    phase: i << 26,
                };
                ledger.onset(at, 0.01);
                if i + 1 < onsets {
                    ledger.release(at, -0.005);
                }
            }
            let stay = ContactPiece {
                span_s: 1e-3,
                force: (1.0, 1.0),
                force_rate: (0.0, 0.0),
                impulse: 1e-3,
                work: 0.0,
            };
            for _ in 0..6 {
                ledger.add(&stay);
            }
            let period = ledger.close_period();
            assert_eq!(period.onsets, onsets as u16);
            assert_eq!(period.chatter, onsets == 3);
            assert!(ledger.close_period().touched, "still in contact");
        }
    }
}
