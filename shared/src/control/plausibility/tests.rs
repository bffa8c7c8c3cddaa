use super::*;
use crate::model::cart::{ASSUMED_SHAKER, CartDrive, LoopParams};
use crate::model::params::{RigParams, WIRES};

fn plausibility() -> Plausibility {
    Plausibility::new(&Settings::for_rig(&WIRES))
}

fn trips_after(mut one: impl FnMut(&mut Plausibility) -> Option<Trip>) -> Option<usize> {
    let mut plausibility = plausibility();
    (1..100).find(|_| one(&mut plausibility).is_some())
}

const MASS_KG: f32 = WIRES.mass_kg as f32;

#[test]
fn contacts_no_contact_can_make_trip_and_possible_ones_do_not() {
    let pulse = |ratio: f32| Pulse {
        approach_m_per_s: 0.08,
        rebound_m_per_s: 0.025,
        impulse_n_s: ratio * MASS_KG * 0.105,
        ..Pulse::default()
    };
    let (low, high) = MOMENTUM_RANGE;
    for (ratio, expected) in [
        (1.02 * high, Some(16)),
        (0.98 * high, None),
        (1.0, None),
        (1.02 * low, None),
        (0.98 * low, Some(16)),
    ] {
        assert_eq!(trips_after(|p| p.pulse(&pulse(ratio))), expected, "{ratio}");
    }
    let at = |relative_m: f32| Pulse {
        relative_m,
        ..pulse(1.0)
    };
    assert_eq!(trips_after(|p| p.pulse(&at(-1.6e-3))), Some(3));
    assert_eq!(trips_after(|p| p.pulse(&at(-1.4e-3))), None);
}

#[test]
fn impulse_over_momentum_may_be_off_by_what_a_late_sensor_is_worth() {
    for (hz, ratio, expected) in [
        (3.66, 0.749, Some(16)),
        (3.66, 0.752, None),
        (3.66, 1.342, None),
        (3.66, 1.345, Some(16)),
        (13.0, 0.726, Some(16)),
        (13.0, 0.729, None),
        (13.0, 1.400, None),
        (13.0, 1.403, Some(16)),
    ] {
        let tripped = trips_after(|p| {
            assert_eq!(p.ratio(None, true, hz), None);
            p.pulse(&contact(ratio))
        });
        assert_eq!(tripped, expected, "{hz} {ratio}");
    }
}

#[test]
fn a_zero_of_the_force_that_moves_trips() {
    let limit_n = Settings::for_rig(&WIRES).limits.force_n;
    for (share, expected) in [(0.052, Some(4)), (-0.052, Some(4)), (0.048, None)] {
        let sum = (share * limit_n * 5000.0, 5000);
        assert_eq!(trips_after(|p| p.free_force(sum)), expected, "{share}");
    }
    assert_eq!(trips_after(|p| p.free_force((0.0, 0))), None);
}

#[test]
fn a_hammer_that_reads_more_or_less_than_the_cart_trips() {
    // At 13 Hz a sensor that is 0.4 ms late is worth 3.3 %.
    for (hz, ratio, windows, expected) in [
        (3.66, 0.799, 48, Some(16)),
        (3.66, 0.802, 48, None),
        (3.66, 1.198, 48, None),
        (3.66, 1.201, 48, Some(16)),
        (13.0, 0.776, 48, Some(16)),
        (13.0, 0.779, 48, None),
        (13.0, 1.221, 48, None),
        (13.0, 1.224, 48, Some(16)),
        (3.66, -1.0, 48, Some(16)),
        (3.66, f32::NAN, 48, Some(16)),
        (3.66, -1.0, 47, None),
    ] {
        let tripped = trips_after(|p| p.ratio(Some((ratio, windows)), true, hz));
        assert_eq!(tripped, expected, "{hz} {ratio} {windows}");
    }
    assert_eq!(trips_after(|p| p.ratio(None, true, 3.66)), None);
}

#[test]
fn a_hammer_that_flies_from_the_surface_into_it_trips() {
    let reversed = Pulse {
        approach_m_per_s: -0.08,
        rebound_m_per_s: -0.025,
        impulse_n_s: MASS_KG * 0.105,
        ..Pulse::default()
    };
    assert_eq!(trips_after(|p| p.pulse(&reversed)), Some(6));
}

#[test]
fn one_contact_in_three_that_was_misread_trips_nothing() {
    let mut plausibility = plausibility();
    for k in 0..300 {
        let ratio = if k % 3 == 0 { 1.3 } else { 0.95 };
        let pulse = Pulse {
            approach_m_per_s: 0.08,
            rebound_m_per_s: 0.025,
            impulse_n_s: ratio * MASS_KG * 0.105,
            ..Pulse::default()
        };
        assert_eq!(plausibility.pulse(&pulse), None);
    }
}

fn strobe(ratio: f32, lag_rad: f32) -> Strobe {
    Strobe {
        amplitude_m: ratio * 0.89e-3,
        lag_rad,
        ..Strobe::default()
    }
}

#[test]
fn a_cart_that_does_not_follow_or_goes_the_other_way_trips_and_one_that_droops_does_not() {
    for (ratio, lag, expected) in [
        (0.72, 0.3, None),
        (0.68, 0.3, Some(4)),
        (1.0, 2.0, None),
        (1.0, -2.0, None),
        (1.0, 2.2, Some(4)),
        (1.0, -3.1, Some(4)),
        (5.0, 0.1, None),
    ] {
        let tripped = trips_after(|p| p.strobe(&strobe(ratio, lag), 0.89e-3, 3.6, false));
        assert_eq!(tripped, expected, "{ratio} {lag}");
    }
}

/// Where the rig's own loop is known, the cart is late by what the loop makes it, within 45° and a quarter of the loop's
/// frequency. A sensor that is 50 ms late is 66° late at 3.66 Hz, and was not found.
#[test]
fn a_cart_that_is_later_than_its_own_loop_trips() {
    let loop_of = |frequency_hz: f64, damping_ratio: f64, feed_forward: f64| {
        CartDrive::Loop(LoopParams {
            frequency_hz,
            damping_ratio,
            feed_forward,
            ..ASSUMED_SHAKER
        })
    };
    let (stiff, fed) = (loop_of(50.0, 0.7, 1.0), loop_of(3.0, 0.7, 1.0));
    let resonant = loop_of(3.7, 0.1, 0.0);
    let soft = loop_of(1.5, 0.3, 0.0);
    for (cart, degrees, expected) in [
        (CartDrive::Prescribed, 66.0, None),
        (stiff, 0.0, None),
        (stiff, 44.0, None),
        (stiff, -44.0, None),
        (stiff, 46.0, Some(4)),
        (stiff, -46.0, Some(4)),
        (stiff, 180.0, Some(4)),
        (fed, 44.0, None),
        (fed, 66.0, Some(4)),
        // At its resonance, a quarter of which either way makes it 14° to 141°.
        (resonant, -30.0, None),
        (resonant, 180.0, None),
        (resonant, -70.0, Some(4)),
        // Far above it: 107°.
        (soft, 65.0, None),
        (soft, 150.0, None),
        (soft, 55.0, Some(4)),
        (soft, 160.0, Some(4)),
        (soft, -70.0, Some(4)),
    ] {
        let rig = RigParams { cart, ..WIRES };
        let mut plausibility = Plausibility::new(&Settings::for_rig(&rig));
        let cart = strobe(1.0, f32::to_radians(degrees));
        let tripped = (1..50).find(|_| plausibility.strobe(&cart, 0.89e-3, 3.66, false).is_some());
        assert_eq!(tripped, expected, "{:?} {degrees}", rig.cart);
    }
}

#[test]
fn a_cart_that_follows_less_or_more_from_one_period_to_the_next_trips() {
    for (before, after, expected) in [
        (1.0, 0.84, Some(4)),
        (1.0, 0.87, None),
        (0.9, 0.79, None),
        (1.0, 1.31, Some(4)),
        (1.0, 1.25, None),
    ] {
        let mut plausibility = plausibility();
        for _ in 0..30 {
            assert_eq!(
                plausibility.strobe(&strobe(before, 0.1), 0.89e-3, 3.6, false),
                None
            );
        }
        let tripped = (1..50).find(|_| {
            let after = strobe(after, 0.1);
            plausibility.strobe(&after, 0.89e-3, 3.6, false).is_some()
        });
        assert_eq!(tripped, expected, "{before} {after}");
    }
}

#[test]
fn a_frequency_held_far_from_the_forecast_trips() {
    // The force is over the target's.
    for (hz, amplitude, target_hz, force, expected) in [
        (1.205, 1.0, 1.0, 1.0, Some(48)),
        (0.795, 1.0, 1.0, 0.51, Some(48)),
        (1.205, 1.0, 1.0, 0.49, None),
        (1.195, 1.0, 1.0, 1.0, None),
        (0.805, 1.0, 1.0, 1.0, None),
        (1.205, 0.86, 1.0, 1.0, Some(48)),
        (1.205, 0.84, 1.0, 1.0, None),
        (1.205, 1.0, 0.0, 1.0, None),
        (1.205, 1.0, f32::NAN, 1.0, None),
    ] {
        let found = Strobe {
            peak_n: force * 80.0,
            ..strobe(amplitude, 0.1)
        };
        let tripped = trips_after(|p| p.held(&found, 3.6 * hz, (3.6 * target_hz, 80.0)));
        assert_eq!(tripped, expected, "{hz} {amplitude} {target_hz} {force}");
    }
}

#[test]
fn a_shaker_with_a_resonance_may_be_passed() {
    // Its response rises and falls four-fold while the frequency moves by a fifth.
    let mut plausibility = plausibility();
    for k in 0..60_u8 {
        let hz = 3.0 + 0.01 * f32::from(k);
        let off = 2.0 * 4.0 * (hz / 3.3 - 1.0);
        let ratio = 4.0 / libm::sqrtf(1.0 + off * off);
        let tripped = plausibility.strobe(&strobe(ratio, 1.5), 0.89e-3, hz, false);
        assert_eq!(tripped, None, "{hz}");
    }
}

fn contact(ratio: f32) -> Pulse {
    Pulse {
        approach_m_per_s: 0.08,
        rebound_m_per_s: 0.025,
        impulse_n_s: ratio * MASS_KG * 0.105,
        ..Pulse::default()
    }
}

#[test]
fn a_trip_tells_the_ratio_and_whose_it_is() {
    let trip_of = |pulse: Pulse| {
        let mut plausibility = plausibility();
        let trip = (0..100).find_map(|_| plausibility.pulse(&pulse)).unwrap();
        (trip.origin, trip.value)
    };
    let (origin, ratio) = trip_of(contact(1.5));
    assert_eq!(origin, Origin::Force);
    assert!((ratio - 1.5).abs() < 1e-3, "{ratio}");
    let away = Pulse {
        approach_m_per_s: -0.08,
        rebound_m_per_s: -0.025,
        ..contact(1.0)
    };
    let (origin, ratio) = trip_of(away);
    assert_eq!(origin, Origin::Hammer);
    assert!((ratio + 1.0).abs() < 1e-3, "{ratio}");
    // A number that is none is told as 0.
    let none = Pulse {
        approach_m_per_s: f32::NAN,
        ..contact(1.0)
    };
    assert_eq!(trip_of(none).1, 0.0);
}

#[test]
fn a_gain_that_goes_wrong_later_is_found_and_five_misread_contacts_are_not_one() {
    let mut plausibility = plausibility();
    assert!((0..100).all(|_| plausibility.pulse(&contact(1.0)).is_none()));
    assert!((0..5).all(|_| plausibility.pulse(&contact(1.5)).is_none()));
    assert!((0..50).all(|_| plausibility.pulse(&contact(1.0)).is_none()));
    let found = (1..100).find(|_| plausibility.pulse(&contact(1.5)).is_some());
    assert!(found.is_some_and(|contacts| contacts < 24), "{found:?}");
}

#[test]
fn the_distance_is_from_the_gap_as_contacts_have_shown_it() {
    let at = |relative_m| Pulse {
        relative_m,
        ..contact(1.0)
    };
    let trips = |relative_m: f32| {
        let mut plausibility = plausibility();
        plausibility.believe_surface(2e-3);
        (0..10).any(|_| plausibility.pulse(&at(relative_m)).is_some())
    };
    assert!(!trips(2e-3) && !trips(0.6e-3) && !trips(3.4e-3));
    assert!(trips(0.4e-3) && trips(3.6e-3));
}

/// Between two runs the surface may have come to be anywhere.
#[test]
fn after_a_start_the_first_contacts_tell_where_the_surface_is() {
    let at = |relative_m: f32| Pulse {
        relative_m,
        ..contact(1.0)
    };
    let mut plausibility = plausibility();
    plausibility.believe_surface(2e-3);
    plausibility.restart();
    assert!((0..10).all(|_| plausibility.pulse(&at(0.0)).is_none()));
    plausibility.believe_surface(0.0);
    assert!((0..10).any(|_| plausibility.pulse(&at(2e-3)).is_some()));
}

#[test]
fn a_start_begins_every_count_anew() {
    let far = Pulse {
        relative_m: 2e-3,
        ..contact(1.0)
    };
    let limit_n = Settings::for_rig(&WIRES).limits.force_n;
    type Count = (u8, fn(&mut Plausibility, f32, &Pulse) -> Option<Trip>);
    // All but one of the periods or contacts that trip, for each check.
    let counts: [Count; 5] = [
        (2, |p, _, far| {
            p.believe_surface(0.0);
            p.pulse(far)
        }),
        (15, |p, _, _| p.pulse(&contact(1.4))),
        (3, |p, limit_n, _| p.free_force((0.06 * limit_n, 1))),
        (15, |p, _, _| p.ratio(Some((1.3, 48)), true, 3.66)),
        (47, |p, _, _| p.held(&strobe(1.0, 0.1), 4.5, (3.6, 0.0))),
    ];
    for (count, one) in counts {
        let mut plausibility = plausibility();
        for _ in 0..2 {
            plausibility.restart();
            let tripped = (0..count).find_map(|_| one(&mut plausibility, limit_n, &far));
            assert_eq!(tripped, None, "{count}");
        }
        assert!(one(&mut plausibility, limit_n, &far).is_some(), "{count}");
    }
}

#[test]
fn the_response_of_the_shaker_is_learnt_anew_after_a_start_and_at_another_frequency() {
    let run = |p: &mut Plausibility, ratio: f32, hz: f32| {
        (0..20).any(|_| p.strobe(&strobe(ratio, 0.1), 0.89e-3, hz, false).is_some())
    };
    let mut plausibility = plausibility();
    assert!(!run(&mut plausibility, 1.0, 3.6));
    plausibility.restart();
    assert!(!run(&mut plausibility, 0.8, 3.6));
    assert!(!run(&mut plausibility, 1.1, 1.05 * 3.6));
    // At nearly the same frequency it is the same shaker.
    assert!(run(&mut plausibility, 0.8, 1.07 * 3.6));
}

#[test]
fn what_the_first_periods_show_is_no_step_and_a_slow_fall_is() {
    let mut plausibility = plausibility();
    let mut trips = |ratio: f32| {
        let seen = strobe(ratio, 0.1);
        plausibility.strobe(&seen, 0.89e-3, 3.6, false).is_some()
    };
    assert!(!trips(1.0) && !trips(1.0));
    assert!((0..30).all(|_| !trips(0.8)));
    assert!((0..60).all(|_| !trips(0.99)));
    // Two hundredths a period down to three quarters.
    assert!((0..30).any(|k| trips((0.99 - 0.02 * k as f32).max(0.75))));
}

#[test]
fn a_cart_is_doubted_from_the_first_bad_period_until_a_good_one() {
    for bad in [strobe(0.5, 0.1), strobe(0.8, 0.1), strobe(1.0, 3.0)] {
        let mut plausibility = plausibility();
        let mut see = |seen: &Strobe| {
            assert_eq!(plausibility.strobe(seen, 0.89e-3, 3.6, false), None);
            plausibility.doubts_the_cart()
        };
        assert!((0..30).all(|_| !see(&strobe(1.0, 0.1))));
        assert!(see(&bad), "{bad:?}");
        assert!(!see(&strobe(1.0, 0.1)), "{bad:?}");
    }
    // On the way up, too, where no response is known yet.
    let mut plausibility = plausibility();
    let weak = plausibility.strobe(&strobe(0.5, 0.1), 0.89e-3, 3.6, true);
    assert_eq!((weak, plausibility.doubts_the_cart()), (None, true));
}

#[test]
fn a_command_below_a_tenth_of_the_amplitude_is_not_judged() {
    for (share, expected) in [(0.09, None), (0.11, Some(4)), (0.0, None)] {
        let mut plausibility = plausibility();
        plausibility.restart();
        let still = strobe(0.0, 0.0);
        let tripped = (1..20).find(|_| {
            let command_m = share * 0.89e-3;
            plausibility.strobe(&still, command_m, 3.6, true).is_some()
        });
        assert_eq!(tripped, expected, "{share}");
    }
}

#[test]
fn the_gain_of_the_hammer_over_the_cart_is_doubted_once_it_is_known() {
    let doubted = |ratio: f32, windows: u32| {
        let mut plausibility = plausibility();
        assert_eq!(plausibility.ratio(Some((ratio, windows)), true, 3.66), None);
        plausibility.doubt().travel
    };
    // A hammer that reads a fifth less may go 0.98/0.8 times as far.
    assert!((doubted(0.8, 48) - 1.225).abs() < 1e-4);
    assert_eq!(doubted(0.8, 47), 1.0, "too few windows");
    assert_eq!(doubted(-1.0, 48), 1.0, "no gain at all");
}

#[test]
fn limits_go_by_the_contacts_from_the_fourth_on() {
    let doubted = |ratio: f32, contacts: u32| {
        let mut plausibility = plausibility();
        for _ in 0..contacts {
            plausibility.pulse(&contact(ratio));
        }
        plausibility.doubt()
    };
    assert_eq!(doubted(0.8, 3).force, 1.0);
    assert!((doubted(0.8, 4).force - 0.98 / 0.8).abs() < 1e-3);
    assert!((doubted(1.25, 4).travel - 0.98 * 1.25).abs() < 1e-3);
    assert_eq!(doubted(-1.0, 5).force, 1.0, "no gain at all");
}

#[test]
fn a_gain_that_has_just_changed_is_not_steady_until_the_sums_agree() {
    let mut plausibility = plausibility();
    let steady_for = |plausibility: &mut Plausibility, ratio: f32, contacts: usize| {
        let mut count = 0;
        for _ in 0..contacts {
            plausibility.pulse(&contact(ratio));
            count += usize::from(plausibility.is_steady());
        }
        count
    };
    // What it is at first is not known; the scatter of a healthy rig is steady.
    assert_eq!(steady_for(&mut plausibility, 1.0, 20), 20);
    assert_eq!(steady_for(&mut plausibility, 0.9, 1), 1);
    assert_eq!(steady_for(&mut plausibility, 1.0, 20), 20);
    // A fifth less, or more, is seen with the second contact.
    assert_eq!(steady_for(&mut plausibility, 0.8, 5), 1);
    // Until the mean of 16 is within a twentieth: 15.5 ln(0.2 / 0.042) = 24 contacts after the change, less the first 5.
    let steady = steady_for(&mut plausibility, 0.8, 60);
    assert!((60 - steady).abs_diff(24 - 5) <= 2, "{steady}");
    assert!(plausibility.is_steady());
    assert!(steady_for(&mut plausibility, 1.0, 5) <= 1);
}

#[test]
fn a_surface_farther_out_than_set_may_be_a_zero_that_moved() {
    let mut settings = Settings::for_rig(&WIRES);
    settings.rig.gap_m = 0.5e-3;
    let mut plausibility = Plausibility::new(&settings);
    for (found_m, shift_m) in [(0.5e-3, 0.0), (2.3e-3, 1.8e-3), (-0.5e-3, 0.0)] {
        plausibility.believe_surface(found_m);
        assert!((plausibility.zero_shift_m() - shift_m).abs() < 1e-7);
    }
    plausibility.restart();
    assert_eq!(plausibility.zero_shift_m(), 0.0);
}
