use rayon::prelude::*;

use super::*;
use crate::drop_test::{DropTest, record};
use shared::model::contact::LAWS;
use shared::model::params::WIRES;

const SETTINGS: SearchSettings = SearchSettings {
    impacts: 4,
    ..SearchSettings::DEFAULT
};

fn with(law: Law<f64>) -> RigParams {
    RigParams {
        contact: law,
        ..WIRES
    }
}

fn measured(law: Law<f64>, test: DropTest) -> MeasuredImpacts {
    let rows = record(&with(law), &test).unwrap();
    let signal = Signal {
        name: "made up".into(),
        time_s: rows.iter().map(|r| r.time_s).collect(),
        force_n: Some(rows.iter().map(|r| r.force_n).collect()),
        ..Signal::default()
    };
    measure(&signal, &SETTINGS).unwrap()
}

/// How many records, of as many as there are with `LONG_CHECKS`.
fn records(all: usize) -> usize {
    let long = std::env::var_os("LONG_CHECKS").is_some();
    if long { all } else { all.div_ceil(3) }
}

/// Value of the `i`-th parameter over what the record was made with.
fn off(fit: &IdentifiedFit, truth: &[f64]) -> Vec<f64> {
    let pairs = fit.parameters.iter().zip(truth);
    pairs.map(|(p, t)| p.value / t - 1.0).collect()
}

fn truth(mut law: Law<f64>) -> Vec<f64> {
    let sought = law.kind().without_exponent();
    sought.map(|n| *law.number_mut(n.key).unwrap()).collect()
}

/// Every law, both misfits (in turns without `LONG_CHECKS`), from a clean record: within 1 %. The peaks' misfit knows the force at 20 µs only.
#[test]
fn a_clean_record_gives_back_the_law_it_was_made_with() {
    for (n, (family, (name, law))) in LawKind::all().zip(LAWS).enumerate() {
        assert_eq!(family.name(), name);
        // A restitution of 0 is at the edge of what is searched; 0.5 is not.
        let law = match law {
            Law::LankaraniNikravesh {
                stiffness,
                exponent,
                ..
            } => Law::LankaraniNikravesh {
                stiffness,
                exponent,
                restitution: 0.5,
            },
            law => law,
        };
        let data = measured(law, DropTest::default());
        let misfits = [Misfit::Force, Misfit::Peaks];
        for misfit in misfits.into_iter().cycle().skip(n % 2).take(records(2)) {
            // Started from a wrong contact: the rig's own does not help.
            // Gain and release are exact here, and stated so.
            let exact = SearchSettings {
                gain_percent: 0.0,
                release_height_percent: 0.0,
                ..SETTINGS
            };
            let found = fit(&data, &WIRES, family, misfit, &exact).unwrap();
            let off = off(&found, &truth(law));
            println!(
                "{name} {misfit:?} {off:?} {} simulations",
                found.simulations
            );
            assert!(
                off.iter().all(|x| x.abs() < 0.01),
                "{name} {misfit:?}: {off:?}"
            );
        }
    }
}

/// Of 24 records with noise the 95 % interval misses the truth in some 1.2 on average, and in more than 4 with a
/// chance below 1 %, for each parameter; of 8, in more than 2 with 0.6 %.
#[test]
fn the_intervals_hold_the_truth_as_often_as_they_say() {
    let seeds = records(24);
    let truth = truth(LAWS[0].1);
    for (misfit, noise_n) in [(Misfit::Force, 0.5), (Misfit::Peaks, 0.3)] {
        let held: Vec<Vec<bool>> = (0..seeds as u64)
            .into_par_iter()
            .map(|seed| {
                let test = DropTest {
                    noise_n,
                    seed,
                    impacts: 3,
                    ..DropTest::default()
                };
                let data = measured(LAWS[0].1, test);
                let found = fit(&data, &WIRES, LawKind::SpringDashpot, misfit, &SETTINGS).unwrap();
                let inside = |(p, t): (&ProfileEstimate, &f64)| {
                    p.low.is_some_and(|low| low <= *t) && p.high.is_some_and(|high| high >= *t)
                };
                found.parameters.iter().zip(&truth).map(inside).collect()
            })
            .collect();
        for i in 0..2 {
            let hits = held.iter().filter(|h| h[i]).count();
            println!("{misfit:?} parameter {i}: {hits} of {seeds}");
            let enough = hits + seeds.div_ceil(6) >= seeds;
            assert!(enough, "{misfit:?} parameter {i}: {hits} of {seeds}");
        }
    }
}

#[test]
fn one_peak_does_not_fix_two_parameters_and_an_unknown_release_leaves_peaks_undecided() {
    let test = DropTest {
        noise_n: 0.2,
        ..DropTest::default()
    };
    let one = SearchSettings {
        impacts: 1,
        ..SETTINGS
    };
    let rows = record(&WIRES, &test).unwrap();
    let signal = Signal {
        name: "made up".into(),
        time_s: rows.iter().map(|r| r.time_s).collect(),
        force_n: Some(rows.iter().map(|r| r.force_n).collect()),
        ..Signal::default()
    };
    let data = measure(&signal, &one).unwrap();
    let found = fit(&data, &WIRES, LawKind::SpringDashpot, Misfit::Peaks, &one).unwrap();
    let few = Warning::FewerPeaks {
        peaks: 1,
        parameters: 2,
    };
    assert_eq!(found.warnings[0], few);
    let warns = |fit: &IdentifiedFit, of: fn(&Warning) -> bool| fit.warnings.iter().any(of);
    let unbounded = |w: &Warning| matches!(w, Warning::Unbounded { .. });
    assert!(warns(&found, unbounded), "{:?}", found.warnings);
    // On wires at gap 0 the hammer is back after half a swing however far out it was let go: peaks alone cannot
    // distinguish a longer fall from a stiffer contact, the shape of the force can.
    let unknown = SearchSettings {
        seek_release: true,
        ..SETTINGS
    };
    let data = measure(&signal, &SETTINGS).unwrap();
    let peaks = fit(
        &data,
        &WIRES,
        LawKind::SpringDashpot,
        Misfit::Peaks,
        &unknown,
    )
    .unwrap();
    assert!(
        warns(&peaks, unbounded) || warns(&peaks, |w| matches!(w, Warning::Correlated { .. })),
        "{:?}",
        peaks.warnings
    );
    let force = fit(
        &data,
        &WIRES,
        LawKind::SpringDashpot,
        Misfit::Force,
        &unknown,
    )
    .unwrap();
    let off = off(&force, &[5.5e6, 1.2e3, -3.0]);
    assert!(off.iter().all(|x| x.abs() < 0.05), "{off:?}");
}

#[test]
fn ringing_is_reported_with_its_pitch_and_decay() {
    let test = DropTest {
        noise_n: 0.1,
        ringing_share: 0.5,
        ..DropTest::default()
    };
    let data = measured(LAWS[0].1, test);
    let found = fit(
        &data,
        &WIRES,
        LawKind::SpringDashpot,
        Misfit::Force,
        &SETTINGS,
    )
    .unwrap();
    let seen = found.ring.unwrap();
    println!("{seen:?} {:?}", found.parameters);
    assert!((seen.frequency_hz / 3000.0 - 1.0).abs() < 0.01, "{seen:?}");
    assert!((seen.decay_ms / 2.0 - 1.0).abs() < 0.05, "{seen:?}");
    let clean = measured(
        LAWS[0].1,
        DropTest {
            noise_n: 0.1,
            ..DropTest::default()
        },
    );
    let found = fit(
        &clean,
        &WIRES,
        LawKind::SpringDashpot,
        Misfit::Force,
        &SETTINGS,
    )
    .unwrap();
    assert_eq!(found.ring, None);
}

/// Of two independent standard Gaussians the larger is 1/√π on average, with variance 1 − 1/π.
#[test]
fn the_mean_of_the_largest_sample_is_the_textbooks() {
    let pi = std::f64::consts::PI;
    let (mean, variance) = peaks::largest_of(&[0.0, 0.0], 1.0);
    assert!((mean - 1.0 / pi.sqrt()).abs() < 1e-4, "{mean}");
    assert!((variance - (1.0 - 1.0 / pi)).abs() < 1e-4, "{variance}");
    let (mean, variance) = peaks::largest_of(&[7.0, -50.0], 2.0);
    assert!((mean - 7.0).abs() < 1e-3 && (variance - 4.0).abs() < 1e-2);
    assert_eq!(peaks::largest_of(&[1.0, 3.0], 0.0), (3.0, 0.0));
}

/// The noise between the impacts, drift and rounding taken off: before, a share of 2 % of the peak was read as 0.66 of it.
#[test]
fn the_noise_is_measured_whatever_its_size_with_drift_and_rounding() {
    for noise_n in [0.05, 0.4, 0.8, 2.0] {
        let test = DropTest {
            noise_n,
            offset_n: 1.0,
            drift_n_per_s: 0.5,
            ..DropTest::default()
        };
        let data = measured(LAWS[0].1, test);
        // Of some 40,000 samples the deviation is known to 0.4 %.
        assert!(
            (data.noise_n / noise_n - 1.0).abs() < 0.02,
            "{noise_n}: {}",
            data.noise_n
        );
        assert!(
            (data.offset_n - 1.0).abs() < 0.1 * noise_n,
            "{}",
            data.offset_n
        );
        assert!(
            (data.drift_n_per_s - 0.5).abs() < 0.2 * noise_n,
            "{}",
            data.drift_n_per_s
        );
        assert!(data.colour < 1.1, "{}", data.colour);
        let rounded = measured(LAWS[0].1, DropTest { bits: 10, ..test });
        let step = 200.0 / 1024.0;
        let whole = (noise_n.powi(2) + step * step / 12.0).sqrt();
        assert!(
            (rounded.noise_n / whole - 1.0).abs() < 0.03,
            "{noise_n}: {}",
            rounded.noise_n
        );
        assert!(
            (rounded.step_n / step - 1.0).abs() < 1e-9,
            "{}",
            rounded.step_n
        );
    }
}

/// The one-line example of what went wrong: stiffness −43 %, with an interval from −53 to −33 %.
#[test]
fn two_percent_of_noise_do_not_mislead_the_interval() {
    let test = DropTest {
        noise_n: 1.0,
        seed: 1008,
        ..DropTest::default()
    };
    let data = measured(LAWS[0].1, test);
    assert!((data.noise_n - 1.0).abs() < 0.02, "{}", data.noise_n);
    let found = fit(
        &data,
        &WIRES,
        LawKind::SpringDashpot,
        Misfit::Force,
        &SearchSettings::DEFAULT,
    )
    .unwrap();
    let stiffness = &found.parameters[0];
    let (low, high) = (stiffness.low.unwrap(), stiffness.high.unwrap());
    println!("{low} {} {high}", stiffness.value);
    assert!(low < 5.5e6 && 5.5e6 < high, "{low} to {high}");
    assert!(high - low < 0.2 * 5.5e6, "{low} to {high}");
}

/// Drop tests of a case by both misfits: of the answers on its two parameters at most two are wrong in three tests, with
/// `LONG_CHECKS`, and one in one. The chance of more is 2 % and 1 % at 95 % coverage; the seeds are fixed.
fn covered(name: &str) {
    let cases = coverage::cases();
    let case: Vec<_> = cases.into_iter().filter(|c| c.name == name).collect();
    let rows = coverage::table(&case, &[Misfit::Force, Misfit::Peaks], records(3), 1, &()).unwrap();
    let right: usize = rows.iter().map(|r| r.right).sum();
    for row in &rows {
        println!("{row:?}");
    }
    assert_eq!(rows.len(), 4);
    let all = 4 * records(3);
    assert!(right + records(2) >= all, "{name}: {right} of {all}");
}

#[test]
fn a_gain_two_percent_off_is_covered() {
    covered("gain-2-percent");
}

#[test]
fn ringing_of_half_the_peak_is_covered() {
    covered("ringing-3-khz");
}

#[test]
fn ten_bits_are_covered() {
    covered("bits-10");
}

#[test]
fn a_filter_of_10_khz_is_covered() {
    covered("filter-10-khz");
}

#[test]
fn a_filter_of_3_khz_is_covered() {
    covered("filter-3-khz");
}

#[test]
fn a_release_one_percent_wrong_is_covered() {
    covered("release-1-percent");
}

#[test]
fn a_drift_is_covered() {
    covered("drift");
}

/// Drop tests behind each converter, with a clock that is off and a zero that steps, by the whole force: before, the
/// law was refused in most of them or the interval missed the truth.
#[test]
fn converters_clocks_and_zeros_as_people_have_them_are_covered() {
    let names = [
        "digital-filter",
        "linear-phase-filter",
        "mean-of-three",
        "delta-sigma",
        "clock-1-percent",
        "steps",
    ];
    let cases = coverage::cases();
    let cases: Vec<_> = cases
        .into_iter()
        .filter(|c| names.contains(&c.name))
        .collect();
    assert_eq!(cases.len(), names.len());
    for pair in coverage::table(&cases, &[Misfit::Force], records(3), 1, &())
        .unwrap()
        .chunks(2)
    {
        let right: usize = pair.iter().map(|row| row.right).sum();
        assert!(right + records(3) / 3 >= 2 * records(3), "{pair:?}");
    }
}

/// A force sensor that is not straight: 0.5 N in 40 are less than what refuses a law, and several times the noise.
#[test]
fn more_than_twice_the_noise_leaves_no_interval() {
    let test = DropTest {
        noise_n: 0.03,
        ..DropTest::default()
    };
    let rows = record(&WIRES, &test).unwrap();
    let bent = |f: f64| f + 0.3 * (f / 5.0).sin();
    let signal = Signal {
        name: "bent".into(),
        time_s: rows.iter().map(|r| r.time_s).collect(),
        force_n: Some(rows.iter().map(|r| bent(r.force_n)).collect()),
        ..Signal::default()
    };
    let data = measure(&signal, &SETTINGS).unwrap();
    for misfit in [Misfit::Force, Misfit::Peaks] {
        let found = fit(&data, &WIRES, LawKind::SpringDashpot, misfit, &SETTINGS).unwrap();
        assert!(!found.refused && !found.intervals, "{}", found.times_noise);
        assert!(found.parameters.iter().all(|p| p.low.is_none()));
        let says = |w: &Warning| matches!(w, Warning::BeyondNoise { factor } if *factor > 2.0);
        assert!(found.warnings.iter().any(says), "{:?}", found.warnings);
    }
}

#[test]
fn noise_of_two_percent_is_covered() {
    covered("noise-2-percent");
}

#[test]
fn a_law_that_is_not_the_records_is_refused_and_the_right_one_is_not() {
    covered("hunt-crossley-as-dashpot");
    covered("hunt-crossley");
}
