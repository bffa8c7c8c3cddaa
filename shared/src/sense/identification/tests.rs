//! Identification on made-up flights and contacts.

use super::statistics::SCATTER;
use super::*;
use crate::model::cart::{ASSUMED_SHAKER, CartDrive};
use crate::model::params::WIRES;

/// The hammer swinging freely in a cart that moves as it likes.
fn swing(identification: &mut Identification, natural_hz: f64, seconds: f64) {
    swing_about(identification, natural_hz, seconds, 1e-4);
}

/// The hammer swinging freely, with a displacement sensor that is off by `offset_m`.
fn swing_about(identification: &mut Identification, natural_hz: f64, seconds: f64, offset_m: f64) {
    Swing::new(2e-3).go_on(identification, natural_hz, seconds, || offset_m);
}

/// A hammer that swings freely.
struct Swing {
    x: f64,
    v: f64,
    tick: u32,
}

impl Swing {
    fn new(x: f64) -> Self {
        Self { x, v: 0.0, tick: 0 }
    }

    /// Swings on; `off` is what the displacement's sensor adds.
    fn go_on(
        &mut self,
        identification: &mut Identification,
        natural_hz: f64,
        seconds: f64,
        mut off: impl FnMut() -> f64,
    ) {
        let omega = std::f64::consts::TAU * natural_hz;
        let h = TICK_S;
        for _ in 0..(seconds / h) as u32 {
            let t = f64::from(self.tick) * h;
            self.tick += 1;
            let y = 0.9e-3 * (17.0 * t).sin() + 0.2e-3 * (41.0 * t).cos();
            self.v -= h * omega * omega * (self.x - y);
            self.x += h * self.v;
            let sample = Sample {
                force_n: 0.0,
                hammer_m: (self.x + off()) as f32,
                cart_m: y as f32,
            };
            identification.flight(&sample, false);
        }
    }
}

/// Normal noise: the sum of twelve even numbers (xorshift).
struct Noise(u64);

impl Noise {
    fn next(&mut self, sigma: f64) -> f64 {
        let mut sum = -6.0;
        for _ in 0..12 {
            self.0 ^= self.0 << 13;
            self.0 ^= self.0 >> 7;
            self.0 ^= self.0 << 17;
            sum += (self.0 >> 11) as f64 / (1_u64 << 53) as f64;
        }
        sigma * sum
    }
}

#[test]
fn natural_frequency_ten_percent_off_is_found_whatever_the_cart_does() {
    let settings = Settings::for_rig(&WIRES);
    for factor in [0.9, 1.0, 1.1] {
        let mut identification = Identification::new(&settings);
        swing(&mut identification, factor * 1.82, 10.0);
        let found = identification.estimates().natural_hz.unwrap();
        // The integrator above is of first order: 5e-5 relative at this step.
        let off = f64::from(found.value) / (factor * 1.82) - 1.0;
        assert!(off.abs() < 1e-3, "{factor}: {found:?}");
        assert_eq!(identification.refused(), 0);
    }
}

#[test]
fn a_rig_that_changes_is_followed_and_an_implausible_one_is_not_reported() {
    let settings = Settings::for_rig(&WIRES);
    let mut identification = Identification::new(&settings);
    swing(&mut identification, 1.82, 10.0);
    swing(&mut identification, 2.0, 60.0);
    let found = identification.estimates().natural_hz.unwrap();
    assert!((found.value - 2.0).abs() < 0.01, "{found:?}");
    assert!(identification.refused() > 0);
    let mut identification = Identification::new(&settings);
    swing(&mut identification, 2.6, 10.0);
    assert_eq!(identification.estimates().natural_hz, None);
}

/// Displacements with 2 % noise; the natural frequency jumps. Whatever is given as sure is the old or the new one, and
/// after 9 s the new one.
#[test]
fn a_natural_frequency_that_jumps_is_not_mixed_with_the_one_before() {
    let settings = Settings::for_rig(&WIRES);
    let mut noise = Noise(1);
    for factor in [0.74, 0.9, 0.97, 1.05, 1.1, 1.26] {
        let mut identification = Identification::new(&settings);
        let mut swing = Swing::new(2e-3);
        swing.go_on(&mut identification, 1.82, 20.0, || noise.next(18e-6));
        for half_seconds in 1..=40 {
            swing.go_on(&mut identification, factor * 1.82, 0.5, || {
                noise.next(18e-6)
            });
            let Some(found) = identification.estimates().natural_hz else {
                continue;
            };
            let near = |hz: f64| (f64::from(found.value) / hz - 1.0).abs() < 0.012;
            let sure = found.sigma < 3e-3 * found.value;
            let after_s = 0.5 * f64::from(half_seconds);
            let old = after_s < 9.0 && near(1.82);
            assert!(
                !sure || old || near(factor * 1.82),
                "{factor}, {after_s} s after: {found:?}"
            );
        }
        let found = identification.estimates().natural_hz.unwrap();
        close(found.value, factor * 1.82, 6e-3);
    }
}

/// Of a rig that stays as it is, nothing is forgotten, whatever the noise.
#[test]
fn noise_alone_begins_no_new_line() {
    let mut noise = Noise(2);
    for noise_m in [0.0, 9e-6, 18e-6, 36e-6] {
        let mut identification = Identification::new(&Settings::for_rig(&WIRES));
        let mut swing = Swing::new(2e-3);
        swing.go_on(&mut identification, 1.82, 200.0, || noise.next(noise_m));
        let windows = (200.0 / TICK_S) as u32 / identification.window_ticks;
        let found = identification.line.count;
        assert!(found + 4 >= windows, "{noise_m}: {found} of {windows}");
    }
}

#[test]
fn implausible_contacts_are_refused_and_counted() {
    let settings = Settings::for_rig(&WIRES);
    let mut identification = Identification::new(&settings);
    let good = Pulse {
        peak_n: 96.0,
        approach_m_per_s: 0.08,
        rebound_m_per_s: 0.025,
        duration_s: 520e-6,
        relative_m: 1e-5,
        ..Pulse::default()
    };
    for _ in 0..10 {
        identification.pulse(&good);
    }
    let before = identification.estimates();
    assert!(before.stiffness.is_some() && before.damping.is_some());
    assert_eq!(identification.refused(), 0);
    for bad in [
        Pulse {
            relative_m: -5e-3,
            ..good
        },
        Pulse {
            rebound_m_per_s: 0.2,
            ..good
        },
        Pulse {
            duration_s: 0.0,
            ..good
        },
        Pulse {
            relative_m: f32::NAN,
            ..good
        },
        Pulse {
            rebound_m_per_s: f32::NAN,
            ..good
        },
    ] {
        identification.pulse(&bad);
    }
    assert_eq!(identification.refused(), 5);
    assert_eq!(identification.estimates().stiffness, before.stiffness);
}

/// A contact of Table 3.1 at `approach` m/s as the sensors see it: the closed form, less the end below the threshold, plus
/// the excess that was measured.
fn measured(stiffness: f64, damping: f64, mass: f64, approach: f64, on_n: f64) -> Pulse {
    let omega = (stiffness / mass).sqrt();
    let zeta = 0.5 * damping / (stiffness * mass).sqrt();
    let psi = zeta.acos();
    let restitution = (-2.0 * psi / psi.tan()).exp();
    let q = on_n / (mass * omega * restitution * approach);
    let early = ((1.0 + 4.0 * zeta * q).sqrt() - 1.0) / (2.0 * zeta);
    let share = on_n / (2.0 * zeta * mass * omega * approach);
    let late = f64::from(LATE_S.0) - f64::from(LATE_S.1) * share;
    let duration = (2.0 * psi / psi.sin() - early) / omega + late;
    Pulse {
        peak_n: 96.0,
        approach_m_per_s: approach as f32,
        rebound_m_per_s: (restitution * approach) as f32,
        duration_s: duration as f32,
        relative_m: 2e-5,
        ..Pulse::default()
    }
}

#[track_caller]
fn close(found: f32, wanted: f64, share: f64) {
    let off = f64::from(found) / wanted - 1.0;
    assert!(off.abs() <= share, "{found}, {wanted}");
}

#[test]
fn stiffness_and_damping_of_a_contact_come_out_whatever_was_believed() {
    let settings = Settings::for_rig(&WIRES);
    let on_n = f64::from(settings.detection.on_n);
    for (stiffness, damping) in [(5.5e6, 1.2e3), (3.0e6, 0.7e3), (9.0e6, 2.0e3)] {
        let pulse = measured(stiffness, damping, WIRES.mass_kg, 0.08, on_n);
        let mut identification = Identification::new(&settings);
        for count in 0..FEWEST_CONTACTS {
            let early = identification.estimates();
            assert_eq!((early.stiffness, early.damping), (None, None), "{count}");
            assert_eq!(early.gap_m, None, "{count}");
            identification.pulse(&pulse);
        }
        let found = identification.estimates();
        let (k, c, gap) = (
            found.stiffness.unwrap(),
            found.damping.unwrap(),
            found.gap_m.unwrap(),
        );
        close(k.value, stiffness, 2e-3);
        close(c.value, damping, 2e-3);
        // Equal contacts leave the systematic part alone.
        close(k.sigma / k.value, f64::from(SYSTEMATIC), 1e-3);
        close(c.sigma / c.value, 0.5 * f64::from(SYSTEMATIC), 1e-3);
        close(gap.value, 2e-5, 1e-5);
        assert!(gap.sigma < 1e-10);
        for samples in [k.samples, c.samples, gap.samples] {
            assert_eq!(samples, FEWEST_CONTACTS);
        }
        identification.reset();
        let nothing = identification.estimates();
        assert_eq!(nothing, Estimates::default());
    }
}

#[test]
fn scatter_of_durations_and_speeds_widens_the_spread() {
    let settings = Settings::for_rig(&WIRES);
    let on_n = f64::from(settings.detection.on_n);
    let mean = measured(5.5e6, 1.2e3, WIRES.mass_kg, 0.08, on_n);
    let spread = |duration: f32, rebound: f32| {
        let mut identification = Identification::new(&settings);
        for k in 0..100 {
            let sign = if k % 2 == 0 { 1.0 } else { -1.0 };
            identification.pulse(&Pulse {
                duration_s: mean.duration_s * (1.0 + sign * duration),
                rebound_m_per_s: mean.rebound_m_per_s * (1.0 + sign * rebound),
                ..mean
            });
        }
        let found = identification.estimates();
        let (k, c) = (found.stiffness.unwrap(), found.damping.unwrap());
        (
            f64::from(k.sigma / k.value) - f64::from(SYSTEMATIC),
            f64::from(c.sigma / c.value) - 0.5 * f64::from(SYSTEMATIC),
        )
    };
    // A standard error of 10 %/√99; stiffness goes with the square of the duration, damping with the first power.
    let error = 0.1 / 99_f64.sqrt();
    let (k, c) = spread(0.1, 0.0);
    assert!((k / (2.0 * error) - 1.0).abs() < 0.01, "{k}");
    assert!((c / error - 1.0).abs() < 0.01, "{c}");
    let (k, c) = spread(0.0, 0.1);
    assert!((k / error - 1.0).abs() < 0.01, "{k}");
    assert!((c / error - 1.0).abs() < 0.01, "{c}");
}

#[test]
fn a_contact_beyond_its_range_is_not_reported() {
    let detection = Settings::for_rig(&WIRES).detection;
    let pulse = measured(5.5e6, 1.2e3, WIRES.mass_kg, 0.08, f64::from(detection.on_n));
    let reported = |by_stiffness: f64, by_damping: f64| {
        let mut rig = WIRES;
        rig.contact = Law::SpringDashpot {
            stiffness: 5.5e6 * by_stiffness,
            damping: 1.2e3 * by_damping,
        };
        let mut settings = Settings::for_rig(&rig);
        settings.detection = detection;
        let mut identification = Identification::new(&settings);
        for _ in 0..FEWEST_CONTACTS {
            identification.pulse(&pulse);
        }
        let found = identification.estimates();
        (found.stiffness.is_some(), found.damping.is_some())
    };
    let range = f64::from(CONTACT_RANGE);
    assert_eq!(reported(0.95 * range, 0.95 * range), (true, true));
    assert_eq!(reported(1.05 / range, 1.05 / range), (true, true));
    assert_eq!(reported(1.05 * range, 1.0), (false, true));
    assert_eq!(reported(0.95 / range, 1.0), (false, true));
    assert_eq!(reported(1.0, 1.05 * range), (true, false));
    assert_eq!(reported(1.0, 0.95 / range), (true, false));
    let mut hertz = WIRES;
    hertz.contact = crate::model::contact::LAWS[1].1;
    let mut identification = Identification::new(&Settings::for_rig(&hertz));
    for _ in 0..FEWEST_CONTACTS {
        identification.pulse(&pulse);
    }
    let found = identification.estimates();
    assert_eq!((found.stiffness, found.damping), (None, None));
    assert!(found.gap_m.is_some());
}

#[test]
fn what_is_no_contact_of_this_hammer_does_not_count() {
    let settings = Settings::for_rig(&WIRES.with_gap_mm(2.0).unwrap());
    let on_n = settings.detection.on_n;
    let good = Pulse {
        relative_m: 2e-3,
        ..measured(5.5e6, 1.2e3, WIRES.mass_kg, 0.08, f64::from(on_n))
    };
    let (speed, reach) = (0.08_f32, GAP_RANGE * WIRES.amplitude_m as f32);
    let taken = |pulse: Pulse| {
        let mut identification = Identification::new(&settings);
        for _ in 0..FEWEST_CONTACTS {
            identification.pulse(&pulse);
        }
        assert!([0, FEWEST_CONTACTS].contains(&identification.refused()));
        (
            identification.restitution.count == FEWEST_CONTACTS,
            identification.refused() == 0,
        )
    };
    let (yes, no) = ((true, true), (false, false));
    let rebounds = |share: f32| Pulse {
        rebound_m_per_s: share * speed,
        ..good
    };
    let lasts = |duration_s: f32| Pulse { duration_s, ..good };
    let lies = |off_m: f32| Pulse {
        relative_m: 2e-3 + off_m,
        ..good
    };
    let peaks = |peak_n: f32| Pulse { peak_n, ..good };
    for (pulse, expected) in [
        (rebounds(1.19), yes),
        (rebounds(1.21), no),
        (rebounds(-0.19), yes),
        (rebounds(-0.21), no),
        // The next contact came before the rebound was known.
        (rebounds(0.0), no),
        (lasts(9.9e-3), yes),
        (lasts(1.01e-2), no),
        (lasts(5.1e-5), yes),
        (lasts(4.9e-5), no),
        (lies(0.99 * reach), yes),
        (lies(1.01 * reach), no),
        (lies(-0.99 * reach), yes),
        (lies(-1.01 * reach), no),
        (peaks(on_n), yes),
        (peaks(0.99 * on_n), no),
    ] {
        assert_eq!(taken(pulse), expected, "{pulse:?}");
    }
    // Slow contacts give the gap and nothing else: half of A0 ω is the least.
    let least = 0.5 * 0.89e-3 * core::f32::consts::TAU * 1.82;
    let at = |approach_m_per_s: f32| Pulse {
        approach_m_per_s,
        rebound_m_per_s: 0.3 * approach_m_per_s,
        ..good
    };
    assert_eq!(taken(at(1.01 * least)), yes);
    assert_eq!(taken(at(0.99 * least)), (false, true));
}

#[test]
fn a_lossy_surface_hides_some_of_the_peak_once_a_few_contacts_have_shown_it() {
    // Restitutions of 0.32 (Table 3.1), 0.25 and 0.14.
    for (damping, range) in [(1.2e3, 1.0..1.001), (1.5e3, 1.1..1.15), (2.4e3, 1.35..1.42)] {
        let mut identification = Identification::new(&Settings::for_rig(&WIRES));
        let pulse = measured(5.5e6, damping, WIRES.mass_kg, 0.08, 14.0);
        for count in 0..FEW_CONTACTS {
            assert_eq!(identification.hidden_peak(), 1.0, "{count}");
            identification.pulse(&pulse);
        }
        let hidden = identification.hidden_peak();
        assert!(range.contains(&hidden), "{damping}: {hidden}");
    }
    // A cart that recoils: the hammer leaves the slower for it, and no surface is lossy.
    let mut rig = WIRES;
    rig.cart = CartDrive::Loop(ASSUMED_SHAKER);
    let mut identification = Identification::new(&Settings::for_rig(&rig));
    let mut pulse = measured(5.5e6, 1.2e3, WIRES.mass_kg, 0.08, 14.0);
    let left = (0.08 + pulse.rebound_m_per_s) / (1.0 + (WIRES.mass_kg / WIRES.cart_mass_kg) as f32);
    pulse.rebound_m_per_s = left - 0.08;
    for _ in 0..FEWEST_CONTACTS {
        identification.pulse(&pulse);
    }
    assert_eq!(identification.hidden_peak(), 1.0);
    close(
        identification.estimates().damping.unwrap().value,
        1.2e3,
        0.03,
    );
}

/// A hammer on beams with strong damping, driven by a cart that moves as it likes; `noise_m` either way on its displacement;
/// a contact is said to be under way for one tick in `every`.
fn beams(noise_m: f64, every: u32, seconds: f64) -> Identification {
    let mut rig = crate::model::params::BEAM_170;
    rig.support = SupportParams::Beams {
        natural_frequency_hz: 4.5,
        damping_ratio: 0.1,
        cubic_stiffness_n_per_m3: Some(0.0),
    };
    let mut identification = Identification::new(&Settings::for_rig(&rig));
    let omega = std::f64::consts::TAU * 4.5;
    let (mut x, mut v) = (2e-3_f64, 0.0_f64);
    for k in 0..(seconds / TICK_S) as u32 {
        let cart = |t: f64| 0.9e-3 * (41.0 * t).sin() + 0.5e-3 * (17.0 * t).cos();
        let t = f64::from(k) * TICK_S;
        let (y, y_rate) = (cart(t), (cart(t + 1e-6) - cart(t - 1e-6)) / 2e-6);
        v -= TICK_S * (omega * omega * (x - y) + 2.0 * 0.1 * omega * (v - y_rate));
        x += TICK_S * v;
        // A sign at random.
        let hash = k
            .wrapping_mul(2_654_435_761)
            .rotate_left(13)
            .wrapping_mul(2_246_822_519);
        let noise = if hash >> 31 == 0 { noise_m } else { -noise_m };
        let sample = Sample {
            force_n: 0.0,
            hammer_m: (x + noise) as f32,
            cart_m: y as f32,
        };
        identification.flight(&sample, every != 0 && k % every == 0);
    }
    identification
}

#[test]
fn damping_does_not_shift_the_natural_frequency_and_every_window_counts() {
    let found = beams(0.0, 0, 20.0).estimates().natural_hz.unwrap();
    assert!((found.value / 4.5 - 1.0).abs() < 1e-3, "{found:?}");
    // Windows of a sixth of a period, the first after 2 ms.
    let window = 1.0 / (6.0 * 4.5 * TICK_S);
    let windows = ((20.0 / TICK_S - f64::from(SETTLE)) / window.floor()) as u32;
    assert_eq!(found.samples, windows);
    assert!(found.sigma < 1e-3, "{found:?}");
}

#[test]
fn noise_shows_in_the_spread_of_the_natural_frequency() {
    let found = beams(0.05e-3, 0, 60.0).estimates().natural_hz.unwrap();
    let off = f64::from(found.value) - 4.5;
    assert!(off.abs() < 4.0 * f64::from(found.sigma), "{found:?}");
    assert!((0.009..0.018).contains(&found.sigma), "{found:?}");
}

#[test]
fn where_the_points_lie_on_no_line_there_is_no_natural_frequency() {
    let scattered = beams(0.5e-3, 0, 20.0);
    let (slope, square) = scattered.line.fit().unwrap();
    let hz = libm::sqrtf(slope) / core::f32::consts::TAU;
    assert!((hz / 4.5 - 1.0).abs() < 0.9 * NATURAL_RANGE, "{hz}");
    assert!(square > SCATTER * scattered.line.yy);
    assert_eq!(scattered.estimates().natural_hz, None);
}

#[test]
fn a_window_with_a_contact_in_it_is_dropped() {
    let window = (1.0 / (6.0 * 4.5 * TICK_S)) as u32;
    // Just long enough for a window after what has to settle, and one tick too short.
    let fits = beams(0.0, window + SETTLE + 1, 20.0).estimates();
    assert!(fits.natural_hz.is_some());
    let cut = beams(0.0, window + SETTLE, 20.0);
    assert_eq!(cut.estimates().natural_hz, None);
    assert_eq!(cut.line, FadingLine::default());
}

#[test]
fn one_window_that_does_not_fit_is_refused_and_changes_nothing() {
    let mut identification = Identification::new(&Settings::for_rig(&WIRES));
    swing(&mut identification, 1.82, 20.0);
    let before = identification.estimates();
    assert_eq!(identification.refused(), 0);
    identification.flight(&Sample::default(), true);
    for k in 0..SETTLE + identification.window_ticks {
        let sample = Sample {
            hammer_m: 0.01 * libm::sinf(1e-2 * k as f32),
            ..Sample::default()
        };
        identification.flight(&sample, false);
    }
    assert_eq!(identification.refused(), 1);
    assert_eq!(identification.estimates(), before);
}

#[test]
fn when_no_window_fits_any_more_a_new_line_is_begun() {
    let mut identification = Identification::new(&Settings::for_rig(&WIRES));
    swing(&mut identification, 1.82, 10.0);
    // The displacement sensor has slipped by 5 mm: the slope is the same and no point lies on the old line.
    swing_about(&mut identification, 1.82, 10.0, 5e-3);
    // All of them until the newest lie on one line.
    let refused = identification.refused();
    assert!(
        (FEWEST_WINDOWS..2 * FEWEST_WINDOWS).contains(&refused),
        "{refused}"
    );
    let after = identification.estimates().natural_hz.unwrap();
    assert!((after.value / 1.82 - 1.0).abs() < 1e-3, "{after:?}");
    let windows = (10.0 / TICK_S) as u32 / identification.window_ticks;
    let left = windows - (refused - FEWEST_WINDOWS);
    assert!((left..=left + 1).contains(&after.samples), "{after:?}");
}

/// A hammer that swings and strikes every 0.27 s for 25 s; after `after_s` its displacement is read off by `off`, m, and the
/// surface is found off by `surface`. The largest gap told, m, after more than `late_s` of that.
fn largest_gap(off: impl Fn(f64) -> f64, surface: impl Fn(f64) -> f64, late_s: f64) -> (f32, f32) {
    const AFTER_S: f64 = 10.0;
    let mut identification = Identification::new(&Settings::for_rig(&WIRES));
    let (mut swing, mut t) = (Swing::new(2e-3), 0.0);
    let (mut least, mut most) = (f32::INFINITY, f32::NEG_INFINITY);
    while t < AFTER_S + 15.0 {
        swing.go_on(&mut identification, 1.82, 0.27, || {
            t += TICK_S;
            off((t - AFTER_S).max(0.0))
        });
        identification.pulse(&Pulse {
            relative_m: surface((t - AFTER_S).max(0.0)) as f32,
            ..Pulse::default()
        });
        // Without noise, a surface that moves is another one again and again, and none for some contacts.
        if t > AFTER_S + late_s
            && let Some(gap_m) = identification.gap_m()
        {
            (least, most) = (least.min(gap_m), most.max(gap_m));
        }
    }
    (least, most)
}

/// The zero of the hammer's sensor drifts by 200 µm/s: surface and rest move alike. (1 mm was told.)
#[test]
fn a_zero_that_drifts_is_no_gap() {
    for m_per_s in [2e-4, -2e-4] {
        let drifts = |t: f64| m_per_s * t;
        let (least, most) = largest_gap(drifts, drifts, 0.0);
        assert!(
            -2.5e-4 < least && most < 2.5e-4,
            "{m_per_s}: {least} {most}"
        );
    }
}

/// A rig that tilts at once: the surface stays, and the hammer rests elsewhere.
#[test]
fn a_rest_that_jumps_is_known_within_two_seconds() {
    for rest_m in [2e-3, -2e-3] {
        let jumps = |t: f64| if t > 0.0 { rest_m } else { 0.0 };
        let (least, most) = largest_gap(jumps, |_| 0.0, 2.0);
        let gap_m = -rest_m as f32;
        assert!((least - gap_m).abs() < 1e-4, "{rest_m}: {least}");
        assert!((most - gap_m).abs() < 1e-4, "{rest_m}: {most}");
    }
}
