//! Sensors that lie, and wires and rails that come and go.

use super::*;

#[test]
fn a_cart_s_sensor_that_reads_less_does_not_make_the_loop_drive_harder() {
    // Row 1: with 0.64 it was 130 N, and no fault.
    for times in [0.64, 0.8, 0.4] {
        let truth = truth(40.0, &(start() + &gain(25.0, "cart", times)));
        assert_eq!(faults(&truth), [Fault::SensorOutOfFamily], "{times}");
        assert!(truth.faults[0].1 < 27.0, "{:?}", truth.faults);
        assert!(truth.force_n < 110.0 && truth.cart_mm < 1.1);
    }
    // A step of 0.85 trips.
    let twin = truth(40.0, &(start() + &gain(25.0, "cart", 0.89)));
    assert_eq!(faults(&twin), []);
    assert!(twin.force_n < 115.0);
}

#[test]
fn sensors_of_reversed_polarity_are_found() {
    // Row 6: both were held without a fault.
    for sensor in ["hammer", "cart", "force"] {
        let truth = truth(30.0, &(start() + &gain(0.1, sensor, -1.0)));
        assert_eq!(faults(&truth), [Fault::SensorOutOfFamily], "{sensor}");
        assert!(truth.faults[0].1 < 12.0, "{:?}", truth.faults);
    }
}

/// Hard contacts of a hammer that seems to stand still are not weak ones. (Taken for weak, it was found after 20 s.)
#[test]
fn a_hammer_s_sensor_that_dies_in_hold_is_found_within_three_seconds() {
    let truth = truth(30.0, &(start() + &gain(20.0, "hammer", 0.0)));
    assert_eq!(faults(&truth), [Fault::SensorOutOfFamily]);
    assert!(truth.faults[0].1 < 23.0, "{:?}", truth.faults);
}

#[test]
fn gains_of_force_and_hammer_that_are_far_off_are_found_and_moderate_ones_are_not() {
    for (sensor, times, found) in [
        ("force", 0.6, true),
        ("force", 1.6, true),
        ("hammer", 0.5, true),
        ("hammer", 1.6, true),
        ("force", 0.79, false),
        ("force", 1.25, false),
    ] {
        let truth = truth(40.0, &(start() + &gain(20.0, sensor, times)));
        let expected = if found {
            vec![Fault::SensorOutOfFamily]
        } else {
            vec![]
        };
        assert_eq!(faults(&truth), expected, "{sensor} {times}");
    }
}

#[test]
fn two_sensors_that_lie_alike_are_found() {
    // Row 7, and what the impulse alone does not show.
    for (pair, times, found) in [
        (["force", "hammer"], 0.5, true),
        (["force", "hammer"], 0.75, true),
        (["force", "hammer"], 1.35, true),
        (["hammer", "cart"], 0.5, true),
        (["force", "cart"], 0.75, true),
        (["force", "hammer"], 0.88, false),
        (["force", "hammer"], 1.15, false),
    ] {
        let lies = pair.map(|sensor| gain(0.1, sensor, times)).concat();
        let truth = truth(40.0, &(start() + &lies));
        let expected = if found {
            vec![Fault::SensorOutOfFamily]
        } else {
            vec![]
        };
        assert_eq!(faults(&truth), expected, "{pair:?} {times}");
        assert!(truth.force_n < 1.1 * 120.0 && truth.cart_mm < 1.1 * 1.335);
    }
}

#[test]
fn sensors_that_are_off_by_five_percent_trip_nothing() {
    // Either sign for each sensor, every rig, gaps to 1 mm, natural frequencies 8 % off, 2 % noise.
    let rigs = ["wires", "beam-170", "beam-150", "beam-135"];
    let cases = (0..4).flat_map(|rig| (0..8).map(move |k| (rig, k)));
    let cases: Vec<(usize, u32)> = some(3, cases);
    let wrong: Vec<String> = cases
        .par_iter()
        .filter_map(|&(rig, k)| {
            let sign = |bit: u32| if k >> bit & 1 == 1 { 5.0 } else { -5.0 };
            let text = format!(
                "duration_s = 60.0\nseed = {k}\n[true_rig]\npreset = \"{}\"\ngap_mm = {:?}\nnatural_frequency_percent = {:?}\n[sensors]\nnoise_percent = 2.0\nforce_gain_percent = {:?}\nhammer_gain_percent = {:?}\ncart_gain_percent = {:?}\n{}",
                rigs[rig],
                f64::from(k % 3) * 0.5,
                f64::from(k % 5) * 4.0 - 8.0,
                sign(0),
                sign(1),
                sign(2),
                start()
            );
            let truth = truth_told(&text);
            (!truth.faults.is_empty()).then(|| format!("{} {k}: {:?}", rigs[rig], truth.faults))
        })
        .collect();
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn a_zero_of_the_force_that_drifts_is_found_before_it_matters() {
    for n_per_s in [-1.0, 1.0] {
        let drift = lie(
            20.0,
            "force",
            &format!("fault = \"offset-drift\"\ndrift_n_per_s = {n_per_s:?}"),
        );
        let found = truth(60.0, &(start() + &drift));
        assert_eq!(faults(&found), [Fault::SensorOutOfFamily]);
        // 12 N trip.
        assert!(
            (30.0..36.0).contains(&found.faults[0].1),
            "{:?}",
            found.faults
        );
    }
    let twin = lie(20.0, "force", "fault = \"offset\"\noffset_n = -3.0");
    assert_eq!(faults(&truth(40.0, &(start() + &twin))), []);
}

#[test]
fn wires_and_rails_that_come_and_go_are_found() {
    // Rows 14 and 18.
    let comes_and_goes = |ticks: u32, of: u32, at: &str| {
        format!("fault = \"intermittent\"\nticks = {ticks}\nof = {of}\nat = \"{at}\"")
    };
    for (sensor, ticks, of, at, fault) in [
        ("cart", 2, 3, "open", Fault::SensorOpen),
        ("force", 2, 9, "open", Fault::SensorOpen),
        ("force", 19, 20, "low", Fault::SensorSaturated),
    ] {
        let truth = truth(
            25.0,
            &(start() + &lie(20.0, sensor, &comes_and_goes(ticks, of, at))),
        );
        assert_eq!(truth.faults[0].0, fault, "{sensor} {ticks} {of}");
        assert!(truth.faults[0].1 < 20.01, "{:?}", truth.faults);
    }
    let twin = lie(20.0, "cart", &comes_and_goes(1, 5, "open"));
    assert_eq!(faults(&truth(25.0, &(start() + &twin))), []);
}

#[test]
fn a_dead_force_sensor_is_found_by_hand_as_well() {
    // Row 5: 130 N for ever.
    let dead = |times: f64| by_hand() + &set_point(4.0, 3.66, 0.89) + &gain(20.0, "force", times);
    let found = truth(40.0, &dead(0.0));
    assert_eq!(faults(&found), [Fault::NoContact]);
    assert!(found.faults[0].1 < 26.0, "{:?}", found.faults);
    assert_eq!(faults(&truth(40.0, &dead(1.0))), []);
}

/// By hand the contacts may be too weak, or too few, to tell that a hammer's sensor is dead; its standing still tells it. (Not found,
/// the reduced amplitude came back, and the travel was 125 % of its limit to the end.)
#[test]
fn a_dead_hammers_sensor_is_found_by_hand_before_what_a_travel_limit_took_returns() {
    let cases = [
        ("wires", 2.562, 1.6),
        ("wires", 5.49, 3.214),
        ("beam-135", 8.82, 1.514),
    ];
    cases.par_iter().for_each(|(rig, hz, limit_mm)| {
        let tables = format!(
            "[limits]\ntravel_mm = {limit_mm:?}\n[trips]\ntravel_mm = {:?}\n{}{}{}",
            1.3 * limit_mm,
            by_hand(),
            set_point(4.0, *hz, 0.89),
            lie(20.0, "hammer", "fault = \"dead\"")
        );
        let truth = truth_of(rig, 60.0, &tables);
        let [(Fault::SensorOutOfFamily, at_s)] = truth.faults[..] else {
            panic!("{rig} {hz}: {truth:?}");
        };
        assert!((20.0..26.0).contains(&at_s), "{rig} {hz}: {at_s}");
        assert!(truth.travel_mm < 1.1 * limit_mm, "{rig} {hz}: {truth:?}");
    });
}

/// Contacts too weak to be seen hide in the flights between the blows: the hammer's sensor seemed to read 0.63 to 0.74 of the cart's, and the
/// drive was switched off.
#[test]
fn contacts_too_weak_to_be_seen_name_no_sensor_by_hand() {
    let ways = [
        ("beam-135", (19.3, 23.4), 321.0, 0.07, 155),
        ("beam-135", (7.1, 15.8), 184.0, 0.85, 207),
        ("beam-170", (13.1, 7.16), 170.0, 0.08, 61),
        ("beam-150", (16.7, 13.1), 207.0, 0.58, 90),
        ("wires", (4.1, 5.51), 82.0, 0.0, 108),
        ("beam-135", (13.0, 11.0), 330.0, -0.3, 7),
        ("beam-150", (10.0, 14.0), 270.0, -0.3, 9),
    ];
    ways.par_iter()
        .for_each(|(rig, (from_hz, to_hz), limit_n, gap_mm, seed)| {
            let truth = truth_told(&format!(
                "duration_s = 70.0\nseed = {seed}\n[true_rig]\npreset = \"{rig}\"\ngap_mm = {gap_mm:?}\n\
                 [sensors]\nnoise_percent = 1.0\n[limits]\nforce_n = {limit_n:?}\n{}{}{}",
                by_hand(),
                set_point(4.0, *from_hz, 0.89),
                set_point(25.0, *to_hz, 0.89)
            ));
            assert_eq!(faults(&truth), [], "{rig} {from_hz} {to_hz}");
            assert!(truth.force_n < 1.05 * limit_n, "{rig}: {truth:?}");
        });
}

/// Where the hammer strikes every second period, nothing tells whether contacts hide in the flights: a hammer's sensor that reads less
/// narrows the travel limit, and is not named. (Without that the travel was 123 and 125 % of its limit.)
#[test]
fn a_hammer_that_reads_less_between_rare_blows_passes_no_travel_limit() {
    [0.75, 0.5].par_iter().for_each(|times| {
        let limits = "[limits]\ntravel_mm = 3.214\n[trips]\ntravel_mm = 4.18\n".to_owned();
        let run = by_hand() + &set_point(4.0, 5.49, 0.89) + &gain(20.0, "hammer", *times);
        let truth = truth(60.0, &(limits + &run));
        assert!(truth.travel_mm < 1.1 * 3.214, "{times}: {truth:?}");
    });
}

/// A cart that reads 50 ms late is later than the rig's own loop makes it. (Not found, the travel was 125 % of its limit.)
#[test]
fn a_cart_s_sensor_that_is_late_is_found_before_a_limit_is_passed() {
    let limits = "[limits]\nforce_n = 65.0\namplitude_mm = 0.89\ntravel_mm = 3.4\n";
    for (at_s, ms) in [(0.1, 50.0), (20.0, 35.0), (20.0, 50.0)] {
        let late = lie(
            at_s,
            "cart",
            &format!("fault = \"delayed\"\ndelay_ms = {ms:?}"),
        );
        let truth = truth(60.0, &(limits.to_owned() + &start() + &late));
        assert_eq!(faults(&truth), [Fault::SensorOutOfFamily], "{at_s} {ms}");
        assert!(truth.travel_mm < 1.1 * 3.4, "{at_s} {ms}: {truth:?}");
        assert!(truth.force_n < 1.1 * 65.0 && truth.cart_mm < 1.1 * 0.89);
    }
}

/// A zero that drifts as slowly as a surface recedes is followed as one: meanwhile the hammer swings farther to the other side than it
/// reads. (The travel was up to 141 % of its limit, and mostly no sensor was named.)
#[test]
fn a_zero_that_drifts_moves_no_travel_beyond_its_limit() {
    let ways = [
        ("beam-170", 2.8, "hammer", 181.5),
        ("beam-135", 2.8, "hammer", 160.5),
        ("beam-150", 2.78, "hammer", 29.0),
        ("beam-170", 3.72, "hammer", 66.0),
        ("beam-150", 2.49, "cart", -53.0),
        ("wires", 2.7, "hammer", 100.0),
        ("wires", 3.1, "cart", -80.0),
    ];
    ways.par_iter()
        .for_each(|(rig, limit_mm, sensor, um_per_s)| {
            let limits = format!("[limits]\ntravel_mm = {limit_mm:?}\n");
            let how = format!("fault = \"offset-drift\"\ndrift_um_per_s = {um_per_s:?}");
            let tables = limits + &start() + &lie(20.0, sensor, &how);
            let share = truth_of(rig, 60.0, &tables).travel_mm / limit_mm;
            println!("{rig} {limit_mm} {sensor} {um_per_s}: {share}");
            assert!(share < 1.06, "{rig} {sensor} {um_per_s}: {share}");
        });
}

/// The zero of the hammer's sensor drifts: surface and rest position seem to move alike, which is no gap. (Followed as one, the
/// force was 111 % of its limit.)
#[test]
fn a_zero_of_the_hammer_that_drifts_moves_no_force_beyond_its_limit() {
    for at_s in [0.1, 20.0] {
        for um_per_s in [200.0, -200.0] {
            let limits = "[limits]\nforce_n = 65.0\namplitude_mm = 0.89\n";
            let how = format!("fault = \"offset-drift\"\ndrift_um_per_s = {um_per_s:?}");
            let drift = lie(at_s, "hammer", &how);
            let truth = truth(60.0, &(limits.to_owned() + &start() + &drift));
            assert_eq!(faults(&truth), [Fault::SensorOutOfFamily]);
            let share = truth.force_n / 65.0;
            assert!(
                share < 1.06,
                "{at_s} {um_per_s}: {share} {:.0?}",
                truth.forces_n
            );
        }
    }
}
