//! The rig as its own pulses and flights show it to be.

use crate::model::cart::CartDrive;
use crate::model::params::RigParams;
use crate::sense::identification::{Estimates, Identification};
use crate::settings::{DriveKind, Settings};

/// Drive periods between two comparisons of the rig with its estimates,
const COMPARE_PERIODS: u16 = 8;
/// and while a forecast is awaited, which another request would put off: a surface that recedes asks again and again.
const AWAITED_PERIODS: u16 = 128;
/// A natural frequency further off than this needs a new forecast, relative.
const NATURAL_STEP: f64 = 0.01;
/// A gap further off than this needs a new forecast, m.
const GAP_STEP_M: f64 = 3e-5;
/// Largest relative standard error of a natural frequency that is used.
const NATURAL_SIGMA: f32 = 0.003;
/// Largest standard error of a gap that is used, m.
const GAP_SIGMA_M: f32 = 1.5e-5;
/// A gap so many standard errors from the one believed is used, however large they are.
const GAP_MOVED: f32 = 2.0;

/// A gap beyond this many A0 is to be closed by feeding the tool: at 2.7 A0 (2.4 mm on the wires) the best 1/1 lies beside
/// a swing without contact, and a hammer that has lost the surface does not find it again by itself.
const FEED_GAP: f64 = 2.5;
/// So is one that has grown by this many A0 from the gap set.
const FEED_GROWTH: f64 = 1.5;
/// Growth that is never reported, A0: of a large gap that was set.
const NO_GROWTH: f64 = 0.5;

/// The rig that forecasts are made of, and its online identification.
#[derive(Clone, Copy, Debug)]
pub(super) struct RigEstimate {
    pub identification: Identification,
    set: RigParams,
    believed: RigParams,
    periods: u16,
}

impl RigEstimate {
    /// The rig of `settings`, nothing identified yet.
    pub fn new(settings: &Settings) -> Self {
        let mut rig = settings.rig;
        if settings.drive.kind == DriveKind::Motor {
            // A crank holds the cart, not a shaker's loop.
            rig.cart = CartDrive::Prescribed;
        }
        Self {
            identification: Identification::new(settings),
            set: rig,
            believed: rig,
            periods: 0,
        }
    }

    /// The rig that forecasts are made of.
    pub fn rig(&self) -> &RigParams {
        &self.believed
    }

    /// Whether the surface is so far away that the tool is to be fed: the gap has grown beyond what forecasts are made
    /// for, and beyond what was set.
    pub fn is_out_of_reach(&self) -> bool {
        let (a0, set_m) = (self.set.amplitude_m, self.set.gap_m);
        let grown_m = set_m + FEED_GROWTH * a0;
        let reach_m = (FEED_GAP * a0).min(grown_m).max(set_m + NO_GROWTH * a0);
        self.identification
            .gap_m()
            .is_some_and(|gap_m| f64::from(gap_m) > reach_m)
    }

    /// A drive period of the search has ended. Once every [`COMPARE_PERIODS`], the rig if it has changed enough for a new
    /// forecast; later if one is `awaited`.
    pub fn strobe(&mut self, awaited: bool) -> Option<&RigParams> {
        self.periods += 1;
        let patience = if awaited {
            AWAITED_PERIODS
        } else {
            COMPARE_PERIODS
        };
        if self.periods < patience {
            return None;
        }
        self.periods = 0;
        let rig = estimated(&self.set, &self.believed, &self.identification.estimates());
        let natural = rig.natural_frequency_hz() / self.believed.natural_frequency_hz() - 1.0;
        let gap_m = rig.gap_m - self.believed.gap_m;
        let differs = !(-NATURAL_STEP..=NATURAL_STEP).contains(&natural)
            || !(-GAP_STEP_M..=GAP_STEP_M).contains(&gap_m);
        if !differs || rig.check().is_err() {
            return None;
        }
        self.believed = rig;
        Some(&self.believed)
    }
}

/// The rig of the settings with what has been identified surely enough in place of what was set. Contact
/// stiffness and damping stay as set: 20 kHz samples do not identify them well enough
/// ([`crate::sense::identification`]), and they hardly move the target.
fn estimated(set: &RigParams, believed: &RigParams, found: &Estimates) -> RigParams {
    let mut rig = *believed;
    if let Some(natural) = found.natural_hz
        && natural.sigma <= NATURAL_SIGMA * natural.value
    {
        let factor = f64::from(natural.value) / set.natural_frequency_hz();
        rig = set.with_natural_frequency_scaled(factor);
        rig.gap_m = believed.gap_m;
    }
    if let Some(gap) = found.gap_m {
        // Of a surface that recedes the spread is large, and what was believed is further off yet.
        let off_m = libm::fabsf(gap.value - believed.gap_m as f32);
        if gap.sigma <= GAP_SIGMA_M || off_m > GAP_MOVED * gap.sigma {
            rig.gap_m = f64::from(gap.value);
        }
    }
    rig
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::cart::ASSUMED_SHAKER;
    use crate::model::params::WIRES;
    use crate::sense::identification::OnlineEstimate;

    fn found(natural: Option<(f32, f32)>, gap: Option<(f32, f32)>) -> Estimates {
        let estimate = |(value, sigma)| OnlineEstimate {
            value,
            sigma,
            samples: 50,
        };
        Estimates {
            natural_hz: natural.map(estimate),
            gap_m: gap.map(estimate),
            ..Estimates::default()
        }
    }

    #[test]
    fn only_sure_estimates_replace_what_was_set() {
        let natural_hz = WIRES.natural_frequency_hz() as f32;
        let sure = estimated(
            &WIRES,
            &WIRES,
            &found(
                Some((1.05 * natural_hz, 0.002 * natural_hz)),
                Some((2e-4, 14e-6)),
            ),
        );
        let ratio = sure.natural_frequency_hz() / WIRES.natural_frequency_hz();
        assert!((ratio - 1.05).abs() < 1e-6, "{ratio}");
        assert!((sure.gap_m - 2e-4).abs() < 1e-10);
        let unsure = estimated(
            &WIRES,
            &WIRES,
            &found(
                Some((1.05 * natural_hz, 0.004 * natural_hz)),
                Some((3e-5, 16e-6)),
            ),
        );
        assert_eq!(unsure, WIRES);
        // A surface that has moved further than its spread.
        let moved = estimated(&WIRES, &WIRES, &found(None, Some((2e-4, 5e-5))));
        assert!((moved.gap_m - 2e-4).abs() < 1e-10);
    }

    #[test]
    fn a_motor_s_cart_does_not_recoil_and_a_shaker_s_keeps_its_loop() {
        let rig = RigParams {
            cart: CartDrive::Loop(ASSUMED_SHAKER),
            ..WIRES
        };
        let mut settings = Settings::for_rig(&rig);
        assert_eq!(*RigEstimate::new(&settings).rig(), rig);
        let found = found(Some((1.9, 1e-4)), Some((2e-4, 1e-6)));
        assert_eq!(estimated(&rig, &rig, &found).cart, rig.cart);
        settings.drive.kind = DriveKind::Motor;
        assert_eq!(*RigEstimate::new(&settings).rig(), WIRES);
    }

    #[test]
    fn a_rig_as_set_needs_no_new_forecast() {
        let mut estimate = RigEstimate::new(&Settings::for_rig(&WIRES));
        assert!((0..100).all(|_| estimate.strobe(false).is_none()));
        assert_eq!(*estimate.rig(), WIRES);
    }

    #[test]
    fn a_gap_or_natural_frequency_that_has_moved_far_enough_asks_for_a_new_forecast() {
        let after = |gap_m: f32, natural: f64| {
            let mut estimate = RigEstimate::new(&Settings::for_rig(&WIRES));
            for _ in 0..100 {
                estimate.identification.pulse(&crate::sense::Pulse {
                    relative_m: gap_m,
                    ..Default::default()
                });
            }
            let omega = core::f64::consts::TAU * natural * WIRES.natural_frequency_hz();
            let (mut x, mut v, h) = (2e-3, 0.0, crate::settings::TICK_S);
            for k in 0..200_000 {
                let y = 0.9e-3 * libm::sin(17.0 * h * f64::from(k));
                v -= h * omega * omega * (x - y);
                x += h * v;
                let sample = crate::sense::Sample {
                    hammer_m: x as f32,
                    cart_m: y as f32,
                    ..Default::default()
                };
                estimate.identification.flight(&sample, false);
            }
            let early = (1..COMPARE_PERIODS).find_map(|_| estimate.strobe(false).copied());
            assert_eq!(early, None);
            let moved = estimate.strobe(false).copied();
            // What is believed then needs no other forecast.
            let again = (0..2 * COMPARE_PERIODS).find_map(|_| estimate.strobe(false).copied());
            assert_eq!(again, None);
            moved.inspect(|rig| assert_eq!(rig, estimate.rig()))
        };
        assert_eq!(after(2.5e-5, 1.0), None);
        assert_eq!(after(-2.5e-5, 1.0), None);
        let gap = after(3.5e-5, 1.0).unwrap().gap_m;
        assert!((gap - 3.5e-5).abs() < 1e-9, "{gap}");
        assert!(after(-3.5e-5, 1.0).is_some());
        assert_eq!(after(0.0, 1.009), None);
        assert_eq!(after(0.0, 0.991), None);
        for factor in [0.985, 1.015] {
            let hz = after(0.0, factor).unwrap().natural_frequency_hz();
            let wanted = factor * WIRES.natural_frequency_hz();
            assert!((hz / wanted - 1.0).abs() < 1e-3, "{hz} {wanted}");
        }
    }

    #[test]
    fn a_surface_that_has_receded_too_far_asks_for_feed() {
        let a0_m = WIRES.amplitude_m as f32;
        // The gap set and the gap at which the tool is to be fed, in A0.
        for (set, feed) in [(0.0, 1.5), (0.5, 2.0), (1.5, 2.5), (2.7, 3.2)] {
            let settings =
                Settings::for_rig(&WIRES.with_gap_mm(1e3 * set * WIRES.amplitude_m).unwrap());
            let at = |gap: f32| {
                let mut estimate = RigEstimate::new(&settings);
                assert!(!estimate.is_out_of_reach(), "nothing is known");
                for _ in 0..100 {
                    estimate.identification.pulse(&crate::sense::Pulse {
                        relative_m: gap * a0_m,
                        ..Default::default()
                    });
                }
                estimate.is_out_of_reach()
            };
            assert!(!at(feed - 0.02) && at(feed + 0.02), "{set}");
        }
    }
}
