use super::*;
use crate::model::params::WIRES;

fn at(cycle: u32, phase: u32) -> Stamp {
    Stamp { cycle, phase }
}

/// Ticks until the guard trips on `frame`, if it does within 10,000.
fn trips_after(frame: Frame) -> Option<(usize, Fault, Origin)> {
    let mut guard = SampleGuard::new(&Settings::for_rig(&WIRES));
    (1..10_000).find_map(|tick| {
        let (_, trip) = guard.check(&frame, at(0, 0), true, true);
        trip.map(|trip| (tick, trip.fault, trip.origin))
    })
}

fn quiet() -> Frame {
    Frame {
        force: AdcCode(600),
        hammer: AdcCode(2048),
        cart: AdcCode(2048),
        emergency: false,
    }
}

#[test]
fn each_condition_trips_after_its_ticks_and_just_below_it_nothing_does() {
    let settings = Settings::for_rig(&WIRES);
    let force = |n: f32| AdcCode((600.0 + n / settings.force.unit_per_code) as u16);
    let far = |m: f32| AdcCode((2048.0 + m / settings.hammer.unit_per_code) as u16);
    let cart = |m: f32| AdcCode((2048.0 + m / settings.cart.unit_per_code) as u16);
    let trip_n = settings.trips.force_n;
    assert_eq!(trips_after(quiet()), None);
    type Case = (Frame, Option<(usize, Fault, Origin)>);
    let cases: [Case; 12] = [
        (
            Frame {
                emergency: true,
                ..quiet()
            },
            Some((1, Fault::EmergencyStop, Origin::System)),
        ),
        (
            Frame {
                force: force(1.01 * trip_n),
                ..quiet()
            },
            Some((2, Fault::OverForce, Origin::Force)),
        ),
        (
            Frame {
                force: force(0.99 * trip_n),
                ..quiet()
            },
            None,
        ),
        (
            Frame {
                hammer: far(-10.1e-3),
                ..quiet()
            },
            Some((4, Fault::OverTravel, Origin::Hammer)),
        ),
        (
            Frame {
                hammer: far(-9.9e-3),
                ..quiet()
            },
            None,
        ),
        (
            Frame {
                cart: cart(2.02e-3),
                ..quiet()
            },
            Some((4, Fault::OverTravel, Origin::Cart)),
        ),
        (
            Frame {
                cart: cart(1.98e-3),
                ..quiet()
            },
            None,
        ),
        (
            Frame {
                cart: AdcCode(40),
                ..quiet()
            },
            Some((3, Fault::SensorOpen, Origin::Cart)),
        ),
        (
            Frame {
                force: AdcCode(0),
                ..quiet()
            },
            Some((3, Fault::SensorOpen, Origin::Force)),
        ),
        (
            Frame {
                force: AdcCode(124),
                ..quiet()
            },
            Some((20, Fault::SensorSaturated, Origin::Force)),
        ),
        (
            Frame {
                force: AdcCode(125),
                ..quiet()
            },
            None,
        ),
        (
            Frame {
                force: AdcCode(4000),
                ..quiet()
            },
            Some((2, Fault::OverForce, Origin::Force)),
        ),
    ];
    for (frame, expected) in cases {
        assert_eq!(trips_after(frame), expected, "{frame:?}");
    }
}

#[test]
fn travel_is_of_the_hammer_relative_to_the_cart() {
    let settings = Settings::for_rig(&WIRES);
    let trips = |hammer_m: f32, cart_m: f32| {
        trips_after(Frame {
            hammer: AdcCode((2048.0 + hammer_m / settings.hammer.unit_per_code) as u16),
            cart: AdcCode((2048.0 + cart_m / settings.cart.unit_per_code) as u16),
            ..quiet()
        })
    };
    assert_eq!(trips(9e-3, 1.9e-3), None);
    assert_eq!(trips(11e-3, 1.9e-3), None);
    let beyond = Some((4, Fault::OverTravel, Origin::Hammer));
    assert_eq!(trips(9e-3, -1.9e-3), beyond);
    assert_eq!(trips(-9e-3, 1.9e-3), beyond);
}

#[test]
fn levels_come_nearer_by_what_is_doubted_and_by_a_zero_on_the_far_side() {
    let settings = Settings::for_rig(&WIRES);
    let doubt = Doubt {
        force: 1.25,
        travel: 1.2,
        cart: 1.1,
    };
    let trips = settings.trips;
    // Zeros, how far one may have moved, and the readings that trip: force, lowest and highest travel, cart.
    for (rest, shift_m, levels) in [
        (
            (0.0, 0.0),
            0.0,
            [trips.force_n / 1.25, -8.333e-3, 8.333e-3, 1.818e-3],
        ),
        (
            (-20.0, 1e-3),
            0.0,
            [trips.force_n / 1.25 - 20.0, -7.333e-3, 8.333e-3, 1.818e-3],
        ),
        (
            (20.0, -1e-3),
            0.0,
            [trips.force_n / 1.25, -8.333e-3, 7.333e-3, 1.818e-3],
        ),
        (
            (0.0, 1e-3),
            2e-3,
            [trips.force_n / 1.25, -5.333e-3, 8.333e-3, 1.818e-3],
        ),
    ] {
        for (k, level) in levels.into_iter().enumerate() {
            for (share, trips_there) in [(1.01, true), (0.99, false)] {
                let mut guard = SampleGuard::new(&settings);
                guard.set_levels(&trips, &doubt, 1.0, rest, shift_m);
                let code = |channel: &Channel| {
                    AdcCode((channel.zero_code + share * level / channel.unit_per_code) as u16)
                };
                let mut frame = quiet();
                match k {
                    0 => frame.force = code(&settings.force),
                    3 => frame.cart = code(&settings.cart),
                    _ => frame.hammer = code(&settings.hammer),
                }
                let tripped = (0..9).any(|_| guard.check(&frame, at(0, 0), true, true).1.is_some());
                assert_eq!(tripped, trips_there, "{rest:?} {k} {share}");
            }
        }
    }
}

#[test]
fn a_code_that_stands_still_for_a_whole_period_is_frozen() {
    let mut guard = SampleGuard::new(&Settings::for_rig(&WIRES));
    guard.set_force_is_live(true);
    let mut frame = quiet();
    // Before the start nothing had to move.
    guard.check(&frame, at(0, 0), false, false);
    guard.restart(at(5, 100));
    guard.check(&frame, at(5, 101), true, true);
    // Hammer and cart move on, the force's code does not.
    frame.hammer.0 += 1;
    frame.cart.0 += 1;
    let (_, early) = guard.check(&frame, at(6, 99), true, true);
    assert_eq!(early, None);
    let (_, late) = guard.check(&frame, at(6, 102), true, true);
    assert_eq!(
        late.map(|t| (t.fault, t.origin)),
        Some((Fault::SensorFrozen, Origin::Force))
    );
    let (_, still) = guard.check(&frame, at(9, 0), false, true);
    assert_eq!(still, None, "nothing has to move");
}

/// What trips, and after how many ticks within 300,000, if `spoil` changes the frame of the ticks for which
/// `bad` says so.
fn spoilt(
    spoil: impl Fn(&mut Frame),
    bad: impl Fn(usize) -> bool,
) -> Option<(usize, Fault, Origin)> {
    let mut guard = SampleGuard::new(&Settings::for_rig(&WIRES));
    (0..300_000).find_map(|tick| {
        let mut frame = quiet();
        if bad(tick) {
            spoil(&mut frame);
        }
        let (_, trip) = guard.check(&frame, at(0, 0), false, true);
        trip.map(|trip| (tick + 1, trip.fault, trip.origin))
    })
}

/// Every condition by a count, with the ticks in a row that trip it.
type Spoil = (fn(&mut Frame), Fault, Origin, usize);
const SPOILS: [Spoil; 6] = [
    (|f| f.force.0 = 0, Fault::SensorOpen, Origin::Force, 3),
    (|f| f.hammer.0 = 0, Fault::SensorOpen, Origin::Hammer, 3),
    (|f| f.cart.0 = 0, Fault::SensorOpen, Origin::Cart, 3),
    (
        |f| f.force.0 = 100,
        Fault::SensorSaturated,
        Origin::Force,
        20,
    ),
    (|f| f.force.0 = 4095, Fault::OverForce, Origin::Force, 2),
    (|f| f.hammer.0 = 4095, Fault::OverTravel, Origin::Hammer, 4),
];

#[test]
fn a_spoilt_sample_in_five_trips_nothing_and_two_in_nine_do() {
    for (spoil, fault, origin, in_a_row) in SPOILS {
        assert_eq!(spoilt(spoil, |tick| tick % 5 == 0), None, "{fault:?}");
        let two_in_nine = spoilt(spoil, |tick| matches!(tick % 9, 0 | 4));
        let Some((ticks, seen, of)) = two_in_nine else {
            panic!("{fault:?}");
        };
        assert_eq!((seen, of), (fault, origin));
        // Every nine ticks add one to a level of four per tick in a row.
        assert!(ticks <= 9 * 4 * in_a_row, "{fault:?}: {ticks}");
    }
}

#[test]
fn a_wire_open_two_ticks_of_three_and_a_rail_nineteen_of_twenty_trip() {
    for (spoil, fault, origin, in_a_row) in SPOILS {
        let two_of_three = spoilt(spoil, |tick| tick % 3 != 2).unwrap();
        assert_eq!((two_of_three.1, two_of_three.2), (fault, origin));
        assert!(
            two_of_three.0 <= 2 * in_a_row,
            "{fault:?}: {two_of_three:?}"
        );
        let most = spoilt(spoil, |tick| tick % 20 != 19).unwrap();
        assert!(most.0 <= in_a_row + 2, "{fault:?}: {most:?}");
    }
}

#[test]
fn a_blow_of_eleven_ticks_at_the_lower_rail_in_each_period_trips_nothing() {
    let blow = spoilt(|f| f.force.0 = 100, |tick| tick % 2000 < 11);
    assert_eq!(blow, None);
}

#[test]
fn a_count_is_quiet_again_some_ticks_after_its_condition_has_gone() {
    let mut guard = SampleGuard::new(&Settings::for_rig(&WIRES));
    let mut frame = quiet();
    frame.cart = AdcCode(4095);
    for _ in 0..10_000 {
        guard.check(&frame, at(0, 0), false, false);
    }
    assert!(!guard.is_quiet());
    let ticks = (1..1000).find(|_| {
        guard.check(&quiet(), at(0, 0), false, false);
        guard.is_quiet()
    });
    assert_eq!(ticks, Some(84));
}
