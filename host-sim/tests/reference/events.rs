//! Switches are located where they are, and a touch within one step is not missed.

use std::f64::consts::TAU;

use numerics::reference::{LocatedContact, Reference, Segment, TrajectoryObserver};
use shared::model::params::{BEAM_150, PRESETS, RigParams, SupportParams};
use shared::model::rig::SwitchMode;

/// A linear oscillator without damping, released from rest: its flight is known in closed form.
fn linear(gap_m: f64) -> RigParams {
    RigParams {
        support: SupportParams::Beams {
            natural_frequency_hz: 5.25,
            damping_ratio: 0.0,
            cubic_stiffness_n_per_m3: Some(0.0),
        },
        gap_m,
        ..BEAM_150
    }
}

/// A flight of [`linear`] in closed form: from Δ = 0 with `pace` m/s at drive phase 0.
#[derive(Clone, Copy, Debug)]
struct Flight {
    frequency_hz: f64,
    pace: f64,
}

impl Flight {
    /// Δ and its rate at `t`.
    fn at(self, t: f64) -> (f64, f64) {
        let (w, drive) = (TAU * 5.25, TAU * self.frequency_hz);
        let scale = BEAM_150.amplitude_m * drive * drive / (w * w - drive * drive);
        let free = self.pace - scale * drive;
        let x = scale * (drive * t).sin() + free / w * (w * t).sin();
        let v = scale * drive * (drive * t).cos() + free * (w * t).cos();
        (x, v)
    }

    /// When and how high its first hump is.
    fn first_hump(self) -> (f64, f64) {
        let mut low = 1e-4;
        while self.at(low + 1e-4).1 > 0.0 {
            low += 1e-4;
        }
        let top = root(low, low + 1e-4, |t| -self.at(t).1);
        (top, self.at(top).0)
    }

    /// The contacts up to `until_s` with the surface at `gap`.
    fn contacts(self, gap: f64, until_s: f64) -> Vec<LocatedContact> {
        let q = -gap;
        let mut hammer =
            Reference::<f64>::new(&linear(gap), self.frequency_hz, q, self.pace).unwrap();
        let mut contacts = Vec::new();
        while hammer.cycle() as f64 * hammer.period_s() < until_s {
            hammer.run_period(&mut contacts);
        }
        contacts
    }
}

/// Flights whose humps fall anywhere in the integrator's steps.
fn flights() -> impl Iterator<Item = Flight> {
    (0..1200).map(|k| Flight {
        frequency_hz: 5.25 * (0.613 + 0.217 * f64::from(k % 12)),
        pace: 1e-4 * f64::from(k / 12),
    })
}

/// Where `f`, negative at `a` and positive at `b`, changes sign.
fn root(mut a: f64, mut b: f64, f: impl Fn(f64) -> f64) -> f64 {
    for _ in 0..80 {
        let middle = 0.5 * (a + b);
        if f(middle) < 0.0 {
            a = middle;
        } else {
            b = middle;
        }
    }
    b
}

#[test]
fn the_first_onset_falls_where_the_closed_form_puts_it() {
    let mut worst = 0.0_f64;
    for flight in flights() {
        let (top_s, top_m) = flight.first_hump();
        for share in [0.1, 0.5, 0.9] {
            let gap = share * top_m;
            let onset_s = root(0.0, top_s, |t| flight.at(t).0 - gap);
            let contacts = flight.contacts(gap, top_s + 0.1);
            worst = worst.max((contacts[0].onset_s - onset_s).abs());
        }
    }
    assert!(worst < 1e-12, "{worst:.1e} s");
}

#[test]
fn a_touch_of_a_nanometre_within_one_step_is_found_and_none_below() {
    for flight in flights() {
        let (top_s, top_m) = flight.first_hump();
        let touches = |below_top_m: f64| {
            let contacts = flight.contacts(top_m - below_top_m, top_s + 1e-3);
            let near_top = contacts.iter().map(|c| c.onset_s - top_s);
            near_top.filter(|t| t.abs() < 1e-3).count()
        };
        assert_eq!(touches(1e-9), 1, "{flight:?}: missed");
        assert_eq!(touches(-1e-9), 0, "{flight:?}: invented");
    }
}

/// Largest |δ|/δ̇ at an onset and largest |F|/|Ḟ| at a release, s.
#[derive(Default)]
struct Residuals {
    last: Option<SwitchMode>,
    onset_s: f64,
    release_s: f64,
    onsets: usize,
}

impl TrajectoryObserver for Residuals {
    fn segment(&mut self, s: &Segment) {
        let at = s.rig.kinematics(s.start.q, s.start.v);
        // F = 0 there, so that the acceleration is the same on both sides.
        let pushing_in = || {
            let (ki, ci) = (5.5e6, 1.2e3);
            let acceleration = s
                .rig
                .penetration_acceleration(&at, s.start.v, s.accelerations()[0]);
            let rate = ki * at.rate + ci * acceleration;
            (s.rig.force(&at, s.approach) / rate).abs()
        };
        if self.last == Some(SwitchMode::Flight) && s.mode == SwitchMode::Contact {
            // Touching while it still lifts off: there contact begins as F, not δ, rises through 0.
            let touching = (at.delta / at.rate).abs();
            let residual = if at.rate > 0.0 {
                touching
            } else {
                pushing_in()
            };
            self.onset_s = self.onset_s.max(residual);
            self.onsets += 1;
        }
        if self.last == Some(SwitchMode::Contact) && s.mode == SwitchMode::Flight {
            self.release_s = self.release_s.max(pushing_in());
        }
        self.last = Some(s.mode);
    }
}

#[test]
fn switches_are_located_to_a_picosecond_on_every_rig() {
    for (name, params) in PRESETS {
        for (gap_mm, ratio) in [(0.0, 0.8), (0.0, 2.7), (1.0, 1.5), (2.4, 1.4), (3.4, 2.2)] {
            let params = RigParams {
                gap_m: gap_mm * 1e-3,
                ..params
            };
            let frequency_hz = ratio * params.natural_frequency_hz();
            let mut hammer = Reference::<f64>::at_rest(&params, frequency_hz).unwrap();
            let mut seen = Residuals::default();
            for _ in 0..60 {
                hammer.run_period(&mut seen);
            }
            let what = format!("{name} {gap_mm} mm, ratio {ratio}");
            assert!(seen.onsets > 10, "{what}");
            assert!(seen.onset_s < 1e-12, "{what}: onset {:.1e} s", seen.onset_s);
            let release = seen.release_s;
            assert!(release < 1e-11, "{what}: release {release:.1e} s");
        }
    }
}
