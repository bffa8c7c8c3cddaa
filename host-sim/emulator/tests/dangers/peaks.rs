//! The contact's true peak, behind a surface that rings or is lossy: limit, force wanted and trip level mean that.

use super::*;

/// A surface that rings by so many per cent at so many kHz, as lines of `[sensors]`.
fn rung((khz, percent): (f64, f64)) -> String {
    let hz = 1e3 * khz;
    format!("ringing_hz = {hz:?}\nringing_percent = {percent:?}\n")
}

/// A force limit, and a trip level 10 % above it.
fn limited(limit_n: f64) -> String {
    let trip_n = 1.1 * limit_n;
    format!("[limits]\nforce_n = {limit_n:?}\n[trips]\nforce_n = {trip_n:?}\n")
}

/// A rig with a force, N, and how its surface rings, kHz and %.
type Ringing<'a> = ((&'a str, f64), (f64, f64));

/// Each rig with each ringing.
fn on_each<'a>(rigs: &[(&'a str, f64)], ringing: &[(f64, f64)]) -> Vec<Ringing<'a>> {
    let of = |rig| ringing.iter().map(move |ringing| (rig, *ringing));
    rigs.iter().flat_map(|rig| of(*rig)).collect()
}

/// Mean of the largest forces of each second from the fortieth on.
fn late_mean_n(truth: &Truth) -> f64 {
    let last = &truth.forces_n[40..];
    last.iter().sum::<f64>() / last.len() as f64
}

#[test]
fn limit_and_force_wanted_are_of_the_true_peak_whatever_the_surface_rings_like() {
    // The largest sample alone made 174 N of a limit of 150 N and 68 N of 60 N wanted, with ringing of 10 to 30 %.
    let rigs = [("wires", 70.0), ("beam-135", 260.0)];
    let ringing = [
        (1.0, 30.0),
        (3.0, 20.0),
        (3.0, 55.0),
        (5.0, 12.0),
        (6.0, 40.0),
    ];
    let cases = some(3, on_each(&rigs, &ringing));
    cases.par_iter().for_each(|((rig, force_n), ringing)| {
        let sensors = rung(*ringing);
        let asked = [limited(*force_n), format!("[aim]\nforce_n = {force_n:?}\n")];
        for (asked, (least, most)) in asked.iter().zip([(0.95, 1.0), (0.98, 1.025)]) {
            let truth = truth_of(rig, 60.0, &format!("{sensors}{asked}{}", start()));
            assert_eq!((faults(&truth), truth.end), (vec![], State::Hold));
            let mean = late_mean_n(&truth) / force_n;
            let largest = truth.force_n / force_n;
            println!("{rig} {ringing:?} {asked}: {mean} {largest}");
            assert!(
                mean > least && largest < most,
                "{rig} {ringing:?} {asked}: {mean} {largest}"
            );
        }
    });
}

/// The force of a lossy surface is largest at the onset, before the sensor's filter has followed: a limit was passed by up to 38 %, a
/// force wanted by up to 42 %, for ever.
#[test]
fn limit_and_force_wanted_are_of_the_true_peak_however_lossy_the_surface() {
    let rigs = [("wires", 77.0), ("beam-135", 274.0)];
    // Added to stiffness and damping, %: restitutions of 0.25, 0.2, 0.17 and 0.13.
    let surfaces = [(0.0, 25.0), (0.0, 50.0), (0.0, 75.0), (-50.0, 50.0)];
    let cases = rigs
        .iter()
        .flat_map(|rig| surfaces.map(|surface| (*rig, surface)));
    let cases = some(3, cases);
    cases
        .par_iter()
        .for_each(|((rig, force_n), (stiffer, lossier))| {
            for asked in ["limits", "aim"] {
                let truth = truth_told(&format!(
                    "duration_s = 45.0\nseed = 7\n[true_rig]\npreset = \"{rig}\"\ncontact_stiffness_percent = {stiffer:?}\n\
                     contact_damping_percent = {lossier:?}\n[sensors]\nnoise_percent = 1.0\n[{asked}]\nforce_n = {force_n:?}\n{}",
                    start()
                ));
                assert_eq!((faults(&truth), truth.end), (vec![], State::Hold));
                for largest_n in &truth.forces_n[25..] {
                    let share = largest_n / force_n;
                    assert!(
                        (0.84..1.02).contains(&share),
                        "{rig} {stiffer} {lossier} {asked}: {share}"
                    );
                }
            }
        });
}

/// At 5 kHz there are four samples to a swing, and what two in a row show of the same blow differs by 17 %: with trip levels 10 %
/// above a limit that acted, blows of 98 % of the limit tripped now and then. Where they fall changes slowly: in hundreds of blows.
#[test]
fn a_limit_that_acts_trips_nothing_wherever_the_samples_fall_in_the_ringing() {
    let cases = [
        ("wires", 77.0, (5.0, 50.0), 0.5, 5),
        ("wires", 77.0, (5.0, 50.0), 0.5, 6),
        ("beam-150", 219.0, (5.0, 40.0), 0.5, 6),
        ("beam-135", 274.0, (5.0, 50.0), 0.5, 9),
        ("beam-135", 274.0, (5.0, 50.0), 1.0, 22),
        ("beam-150", 206.0, (5.39, 52.0), 0.5, 1),
        ("beam-150", 206.0, (5.39, 52.0), 0.5, 3),
        ("beam-135", 308.0, (5.59, 54.0), 0.5, 9),
    ];
    cases
        .par_iter()
        .for_each(|(rig, limit_n, ringing, noise, seed)| {
            let tables = rung(*ringing) + &limited(*limit_n) + &start();
            let truth = truth_noisy(rig, *noise, *seed, 60.0, &tables);
            assert_eq!(
                (faults(&truth), truth.end),
                (vec![], State::Hold),
                "{rig} {seed}"
            );
            assert!(
                truth.force_n < 1.02 * limit_n,
                "{rig} {seed}: {}",
                truth.force_n
            );
        });
}

/// The best drive period of beam-135 is a whole number of samples, and the lock kept to where they fell in the contact: the mean was up to 1 %
/// off for a minute.
#[test]
fn the_force_wanted_does_not_depend_on_where_the_samples_fall() {
    [3, 4, 9].par_iter().for_each(|seed| {
        let tables = format!("ringing_percent = 0.0\n[aim]\nforce_n = 274.0\n{}", start());
        let truth = truth_noisy("beam-135", 0.05, *seed, 60.0, &tables);
        let mean = late_mean_n(&truth) / 274.0;
        assert!((mean - 1.0).abs() < 0.004, "{seed}: {mean}");
    });
}

/// A ringing that decays within half a millisecond is almost gone once the contact is over: what single contacts show of it is noise.
/// (Most such runs ended with over-force.)
#[test]
fn a_ringing_that_is_lost_in_the_noise_trips_nothing_and_passes_no_limit_by_much() {
    let rigs = [
        ("wires", 77.0),
        ("beam-170", 186.0),
        ("beam-150", 219.0),
        ("beam-135", 274.0),
    ];
    let ringing = [
        (1.0, 30.0),
        (1.0, 10.0),
        (2.0, 20.0),
        (3.0, 10.0),
        (5.0, 20.0),
    ];
    let cases = some(3, on_each(&rigs, &ringing));
    cases.par_iter().for_each(|((rig, limit_n), ringing)| {
        let tables = rung(*ringing) + "ringing_decay_ms = 0.5\n" + &limited(*limit_n) + &start();
        let truth = truth_noisy(rig, 1.0, 5, 60.0, &tables);
        let case = format!("{rig} {ringing:?}");
        assert_eq!((faults(&truth), truth.end), (vec![], State::Hold), "{case}");
        let mean = late_mean_n(&truth) / limit_n;
        let largest = truth.force_n / limit_n;
        assert!(mean > 0.86 && largest < 1.04, "{case}: {mean} {largest}");
    });
}

/// The force wanted there: it was 86 to 104 % of what was asked, or 88 % on a surface that rings by 5 % behind 2 % of noise.
#[test]
fn a_ringing_that_is_lost_in_the_noise_takes_little_from_the_force_wanted() {
    let (wires, beam) = (("wires", 77.0), ("beam-135", 274.0));
    let ways = [
        (wires, (1.0, 10.0), 1.0, 0.5),
        (wires, (1.0, 15.0), 2.0, 1.0),
        (wires, (1.0, 5.0), 2.0, 2.0),
        (beam, (1.0, 15.0), 1.0, 0.5),
        (beam, (1.0, 5.0), 2.0, 2.0),
    ];
    ways.par_iter()
        .for_each(|((rig, force_n), ringing, noise, decay_ms)| {
            let tables = format!(
                "{}ringing_decay_ms = {decay_ms:?}\n[aim]\nforce_n = {force_n:?}\n{}",
                rung(*ringing),
                start()
            );
            let truth = truth_noisy(rig, *noise, 5, 80.0, &tables);
            let case = format!("{rig} {ringing:?} {noise} {decay_ms}");
            assert_eq!((faults(&truth), truth.end), (vec![], State::Hold), "{case}");
            let mean = late_mean_n(&truth) / force_n;
            assert!((0.97..1.03).contains(&mean), "{case}: {mean}");
        });
}

/// Something throws the hammer at the surface, once, in Hold: a blow above the level trips, whatever the surface rings like.
#[test]
fn no_single_blow_above_its_trip_level_goes_by_without_a_trip() {
    let rigs = [("wires", 90.0), ("beam-135", 330.0)];
    let ringing = [(1.0, 30.0), (3.0, 20.0), (3.0, 50.0), (5.0, 15.0)];
    let cases = rigs.iter().flat_map(|rig| {
        let surfaces = ringing.iter().map(move |ringing| (rig, ringing));
        surfaces.flat_map(|surface| (0..8).map(move |push| (surface, f64::from(push))))
    });
    let cases: Vec<_> = cases.collect();
    let blows: Vec<_> = cases
        .par_iter()
        .map(|(((rig, trip_n), (khz, percent)), push)| {
            let tables = format!(
                "ringing_hz = {:?}\nringing_percent = {percent:?}\n\
                 [limits]\nforce_n = {:?}\n[trips]\nforce_n = {trip_n:?}\n{}{}",
                1e3 * khz,
                trip_n / 1.1,
                start(),
                event(
                    11.0 + 0.037 * push,
                    &format!("kind = \"push\"\nspeed_m_per_s = {:?}", 0.05 + 0.015 * push)
                ),
            );
            let truth = truth_of(rig, 13.0, &tables);
            let trips = truth.faults.iter().any(|(f, _)| *f == Fault::OverForce);
            (truth.force_n / trip_n, trips)
        })
        .collect();
    // Two samples in a row trip. By the largest alone, a blow 5 % above the level was none; taken half as those before it, one of 15 %.
    // With 1 % noise a reading is up to 3 % high.
    for (share, trips) in &blows {
        let must = if *trips { 0.97 } else { 1.0 };
        assert_eq!(*trips, *share > must, "{share}");
    }
    assert!(blows.iter().filter(|(_, trips)| *trips).count() > 30);
}

/// What ringing may hide was reckoned with twice while it was not known: over-force at 65 to 75 % of the limit.
#[test]
fn a_low_limit_on_a_surface_that_rings_trips_nothing() {
    let ways = [
        ("beam-135", 0.56, 103.378, 1.9, 52, 3316, 0.8, 2),
        ("wires", 0.62, 37.622, 1.8, 58, 4395, 0.9, 3),
        ("wires", 0.64, 31.342, 0.7, 50, 3750, 0.8, 2),
        ("beam-150", 1.18, 106.816, 1.7, 59, 3379, 0.5, 1),
    ];
    ways.par_iter()
        .for_each(|(rig, gap_mm, limit_n, noise, ringing, hz, decay_ms, seed)| {
            let truth = truth_told(&format!(
                "duration_s = 25.0\nseed = {seed}\n[true_rig]\npreset = \"{rig}\"\ngap_mm = {gap_mm:?}\n[limits]\nforce_n = {limit_n:?}\n\
                 [trips]\nforce_n = {:?}\n[sensors]\nnoise_percent = {noise:?}\nringing_percent = {ringing}.0\nringing_hz = {hz}.0\n\
                 ringing_decay_ms = {decay_ms:?}\n{}",
                1.12 * limit_n,
                start(),
            ));
            assert_eq!(faults(&truth), [], "{rig} {gap_mm}");
            assert!(truth.force_n < 1.05 * limit_n, "{rig}: {truth:?}");
        });
}
