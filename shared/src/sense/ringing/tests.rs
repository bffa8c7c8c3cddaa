//! The true peak behind a ringing that is made up, through a filter that is integrated.

use super::*;
use crate::model::contact::LawKind;
use crate::model::params::{BEAM_150, WIRES};
use crate::sense::pulse::PulseDetector;
use crate::settings::Settings;
use std::vec::Vec;

/// Frequency in Hz, and shares of the peak by which it rings at it and at 1.7 times of it.
type Rung = [f64; 3];

/// Integration steps in a tick.
const INNER: usize = 50;

/// The force of a contact at the speed of a strong 1/1, N, every fiftieth of a tick, and where its largest is.
fn contact() -> (Vec<f64>, usize) {
    let (h, mut x, mut v) = (1e-6, 0.0_f64, 0.08_f64);
    let mut forces = Vec::new();
    loop {
        let force_n = 5.5e6 * x + 1.2e3 * v;
        if force_n < 0.0 {
            break;
        }
        forces.push(force_n);
        v -= h * force_n / 0.298;
        x += h * v;
    }
    let top = (0..forces.len()).max_by(|a, b| forces[*a].total_cmp(&forces[*b]));
    (forces, top.unwrap())
}

/// What the filter makes of the contact, which rings by `share` at `hz`, and by `second` at 1.7 times that, and decays within `decay_s`;
/// starts `late` of [`INNER`] into a tick.
fn samples([hz, share, second]: Rung, decay_s: f64, late: usize) -> Vec<f32> {
    let (forces, top) = contact();
    let before = 4 * INNER + late;
    let (h, corner) = (1e-6, core::f64::consts::TAU * 6_000.0);
    let (mut y, mut rate) = (0.0, 0.0);
    let mut seen = Vec::new();
    for k in 0..140 * INNER {
        let force = k.checked_sub(before).and_then(|i| forces.get(i));
        let t = k.saturating_sub(before + top) as f64 * h;
        let turned = core::f64::consts::TAU * hz * t;
        let swing = share * turned.sin() + second * (1.7 * turned).sin();
        let signal = force.unwrap_or(&0.0) - forces[top] * (-t / decay_s).exp() * swing;
        rate += h * corner * (corner * (signal - y) - core::f64::consts::SQRT_2 * rate);
        y += h * rate;
        if k % INNER == 0 {
            seen.push(y as f32);
        }
    }
    seen
}

/// Peak and sum as found of so many contacts of one ringing (Hz, share) after another, over the true ones, each at another place in a
/// tick; and the peak as a limit takes it.
fn contacts<const N: usize>(
    rung: [(usize, Rung); N],
    decay_s: f64,
    noise: f32,
) -> Vec<(f32, f32, f32)> {
    let settings = Settings::for_rig(&WIRES);
    let (forces, top) = contact();
    let peak_n = forces[top] as f32;
    let impulse_n_s = 1e-6 * forces.iter().sum::<f64>() as f32;
    let mut detector = PulseDetector::new(&settings.detection, 5e-5);
    let mut ringing = Ringing::new(&settings, 5e-5);
    let (mut found, mut random) = (Vec::new(), 12_345_u32);
    let each = rung
        .iter()
        .flat_map(|(count, how)| core::iter::repeat_n(how, *count));
    for (i, how) in each.enumerate() {
        for sample in samples(*how, decay_s, 17 * i % INNER) {
            // The sum of four even ones.
            let wave: f32 = core::iter::repeat_with(|| {
                random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                random as f32 / 4_294_967_296.0 - 0.5
            })
            .take(4)
            .sum();
            let force_n = sample + noise * peak_n * 1.732 * wave;
            let over = ringing.tick(force_n, &detector.tick(force_n));
            found.extend(over.map(|c| {
                let peak = c.peak_n / peak_n;
                (
                    peak,
                    5e-5 * c.sum_n / impulse_n_s,
                    peak * ringing.limit_doubt(),
                )
            }));
        }
    }
    assert_eq!(ringing.doubt(), 1.0);
    found
}

/// Mean peak and impulse of 40 contacts, and mean peak as a limit takes it, over the true ones; those before them only show how it
/// rings.
fn found(how: Rung, decay_s: f64, noise: f32) -> (f32, f32, f32) {
    let all = contacts([(72, how)], decay_s, noise);
    let last = &all[32..];
    let mean =
        |of: fn(&(f32, f32, f32)) -> f32| last.iter().map(of).sum::<f32>() / last.len() as f32;
    (mean(|c| c.0), mean(|c| c.1), mean(|c| c.2))
}

#[test]
fn peak_and_impulse_are_those_of_the_contact_without_its_ringing() {
    for (noise, within) in [
        (0.0, (0.003, 0.002)),
        (0.005, (0.007, 0.003)),
        (0.02, (0.025, 0.05)),
    ] {
        let plain = found([3e3, 0.0, 0.0], 2e-3, noise);
        assert!((plain.0 - 1.0).abs() < 0.025, "{plain:?}");
        assert!((plain.1 - 1.0).abs() < 0.01, "{plain:?}");
        for decay_s in [1e-3, 2e-3] {
            for hz in [1e3, 2e3, 3e3, 4e3, 5e3, 6e3] {
                for share in [0.05, 0.1, 0.2, 0.3, 0.45, 0.6] {
                    let rung = found([hz, share, 0.0], decay_s, noise);
                    let off = (rung.0 / plain.0 - 1.0, rung.1 / plain.1 - 1.0);
                    let is_within = off.0.abs() < within.0 && off.1.abs() < within.1;
                    assert!(is_within, "{noise} {decay_s} {hz} {share}: {off:?}");
                }
            }
        }
    }
}

/// Of a ringing that decays soon little is left after the contact. What cannot be known is on the safe side: the peak may be read
/// higher than it is, hardly lower.
#[test]
fn a_ringing_that_is_lost_in_the_noise_hides_little_of_the_peak() {
    for (noise, decay_s, believed, least_limited) in [
        (0.01, 5e-4, 0.98..1.03, 1.01),
        (0.01, 3e-4, 0.93..1.15, 0.985),
        (0.02, 1e-3, 0.985..1.03, 1.01),
    ] {
        for hz in [1e3, 2e3, 3e3, 5e3] {
            for share in [0.05, 0.1, 0.2, 0.3, 0.5] {
                let (peak, _, limited) = found([hz, share, 0.0], decay_s, noise);
                assert!(
                    limited > least_limited,
                    "{noise} {decay_s} {hz} {share}: {limited}"
                );
                assert!(
                    believed.contains(&peak),
                    "{noise} {decay_s} {hz} {share}: {peak}"
                );
            }
        }
    }
}

/// A force that grows after the samples were collected, and one that goes on: nothing of it is lost.
#[test]
fn a_contact_that_goes_on_keeps_its_later_peak_and_its_whole_impulse() {
    let settings = Settings::for_rig(&WIRES);
    let mut detector = PulseDetector::new(&settings.detection, 5e-5);
    let mut ringing = Ringing::new(&settings, 5e-5);
    let mut seen = Vec::new();
    for k in 0..400 {
        let force_n = match k {
            10..25 => 60.0,
            25..100 => 20.0,
            100..120 => 90.0,
            _ => 0.0,
        };
        seen.extend(ringing.tick(force_n, &detector.tick(force_n)));
    }
    let whole = 15.0 * 60.0 + 75.0 * 20.0 + 20.0 * 90.0;
    let [contact] = seen[..] else {
        panic!("{seen:?}");
    };
    assert_eq!((contact.peak_n, contact.sum_n), (90.0, whole));
}

/// One ringing does not explain two: the peak is off by no more than docs/controller.md says. (It was read 19 % too low.)
#[test]
fn a_surface_that_rings_in_two_modes_hides_no_more_than_stated() {
    for (noise, decay_s) in [(0.005, 2e-3), (0.01, 1e-3), (0.02, 2e-3)] {
        for hz in [1e3, 2e3, 3e3] {
            for share in [0.1, 0.3, 0.5] {
                for second in [0.2, 0.5] {
                    let how = [hz, share * (1.0 - second), share * second];
                    let (peak, _, limited) = found(how, decay_s, noise);
                    assert!(limited > 0.94, "{noise} {how:?}: {limited}");
                    assert!((0.87..1.16).contains(&peak), "{noise} {how:?}: {peak}");
                }
            }
        }
    }
}

/// Drilled on, a surface may ring at another pitch: what was learnt of it is forgotten. (While it was not, the peak was read 17 % too low
/// for hundreds of contacts.)
#[test]
fn a_surface_that_rings_otherwise_from_now_on_is_learnt_anew() {
    for (from, to) in [
        ((3e3, 0.5), (2e3, 0.5)),
        ((2e3, 0.3), (5e3, 0.5)),
        ((3e3, 0.5), (1e3, 0.2)),
        ((3e3, 0.0), (3e3, 0.5)),
        ((3e3, 0.5), (3e3, 0.0)),
        ((1e3, 0.5), (1.3e3, 0.5)),
    ] {
        let all = contacts(
            [(150, [from.0, from.1, 0.0]), (70, [to.0, to.1, 0.0])],
            2e-3,
            0.005,
        );
        let mean = |of: core::ops::Range<usize>| all[of].iter().map(|c| c.0).sum::<f32>() / 10.0;
        let soon = mean(150..160);
        assert!((0.96..1.1).contains(&soon), "{from:?} {to:?}: {soon}");
        for k in [160, 180, 210] {
            let later = mean(k..k + 10);
            assert!(
                (0.99..1.16).contains(&later),
                "{from:?} {to:?} {k}: {later}"
            );
        }
    }
}

/// The force of Hunt–Crossley's law is largest soon after the onset, before the filter has followed: a limit was passed by 8 % for ever.
#[test]
fn the_filter_hides_a_part_of_a_force_that_is_largest_at_once() {
    for (law, least, most) in [
        ("spring-dashpot", 0.0, 0.0),
        ("hertz", 0.0, 0.01),
        ("hunt-crossley", 0.1, 0.2),
        ("flores", 0.05, 0.15),
    ] {
        let contact = LawKind::named(law).unwrap().preset();
        let rig = RigParams {
            contact,
            ..BEAM_150
        };
        let shape = Shape::of(&rig, 5e-5).unwrap();
        // At 500 N, about the force of its strongest 1/1.
        let hidden = 500.0 * shape.filtered_per_n;
        assert!((least..=most).contains(&hidden), "{law}: {hidden}");
    }
}
