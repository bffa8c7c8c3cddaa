//! The conditions that trip the drive by themselves, checked at every tick.
//!
//! Counts are leaky: a bad tick adds [`BAD`], a good one takes one off, and n bad ticks in a row trip. So bad ticks
//! that come again and again trip as well, once they are more than one in five; one in five and fewer, each alone,
//! never do. Latencies are in the fault table of the documentation, and held by tests.

use super::plausibility::Doubt;
use crate::fault::{Fault, Origin};
use crate::io::{AdcCode, Channel, Frame, Reading};
use crate::model::drive::Stamp;
use crate::sense::Sample;
use crate::settings::{Settings, Trips};

/// What a bad tick adds to its count; a good one takes one off.
const BAD: u8 = 4;

/// Consecutive ticks of an open wire that trip.
pub const OPEN_TICKS: u8 = 3;
/// Consecutive ticks at a rail that trip.
pub const SATURATED_TICKS: u8 = 20;
/// Consecutive ticks above the force trip level that trip.
pub const OVER_FORCE_TICKS: u8 = 2;
/// Consecutive ticks beyond a travel trip level that trip.
pub const OVER_TRAVEL_TICKS: u8 = 4;

/// A condition that trips.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trip {
    /// The fault.
    pub fault: Fault,
    /// Which sensor.
    pub origin: Origin,
    /// The value that tripped it.
    pub value: f32,
}

impl Trip {
    /// A fault of the system, not of a sensor.
    pub fn system(fault: Fault, value: f32) -> Self {
        Self {
            fault,
            origin: Origin::System,
            value,
        }
    }
}

/// A leaky count of bad ticks that trips after `N` in a row.
#[derive(Clone, Copy, Debug, Default)]
struct Leaky<const N: u8>(u8);

impl<const N: u8> Leaky<N> {
    const AT: u8 = BAD * N;

    /// A tick; whether the count trips.
    #[inline]
    fn tick(&mut self, bad: bool) -> bool {
        self.0 = if bad {
            // At most a bad tick above the level, so that it comes down again as soon as it went up.
            (self.0 + BAD).min(Self::AT + BAD)
        } else {
            self.0.saturating_sub(1)
        };
        self.0 >= Self::AT
    }

    fn is_quiet(self) -> bool {
        self.0 == 0
    }
}

/// The checks of one channel; `OVER`: ticks in a row beyond its trip level that trip.
#[derive(Clone, Copy, Debug, Default)]
struct ChannelMonitor<const OVER: u8> {
    last: AdcCode,
    changed: Stamp,
    good: f32,
    open: Leaky<OPEN_TICKS>,
    saturated: Leaky<SATURATED_TICKS>,
    over: Leaky<OVER>,
}

impl<const OVER: u8> ChannelMonitor<OVER> {
    /// Takes in a code; returns its value (the last good one if it has none).
    #[inline]
    fn take(&mut self, channel: &Channel, code: AdcCode, now: Stamp) -> (f32, Option<Fault>) {
        if code != self.last {
            self.last = code;
            self.changed = now;
        }
        let reading = channel.read(code);
        let open = self.open.tick(reading == Reading::Open);
        let railed = self
            .saturated
            .tick(matches!(reading, Reading::Saturated(_)));
        let value = match reading {
            Reading::Value(value) => {
                self.good = value;
                value
            }
            Reading::Saturated(value) => value,
            Reading::Open => self.good,
        };
        let fault = if open {
            Some(Fault::SensorOpen)
        } else if railed {
            Some(Fault::SensorSaturated)
        } else {
            None
        };
        (value, fault)
    }

    /// Whether no count is on its way to a trip.
    fn is_quiet(&self) -> bool {
        self.open.is_quiet() && self.saturated.is_quiet() && self.over.is_quiet()
    }

    /// The drive starts: changes of the code count from now on.
    fn restart(&mut self, now: Stamp) {
        self.changed = now;
        self.over = Leaky::default();
    }
}

/// The checks of a tick's samples.
#[derive(Clone, Copy, Debug)]
pub struct Guard {
    force_channel: Channel,
    hammer_channel: Channel,
    cart_channel: Channel,
    force_trip_n: f32,
    /// Lowest and highest reading of the hammer relative to the cart.
    travel_trip_m: (f32, f32),
    cart_trip_m: f32,
    force: ChannelMonitor<OVER_FORCE_TICKS>,
    hammer: ChannelMonitor<OVER_TRAVEL_TICKS>,
    cart: ChannelMonitor<OVER_TRAVEL_TICKS>,
    force_is_live: bool,
}

impl Guard {
    /// Checks with the trip levels of `settings`.
    pub fn new(settings: &Settings) -> Self {
        Self {
            force_channel: settings.force,
            hammer_channel: settings.hammer,
            cart_channel: settings.cart,
            force_trip_n: settings.trips.force_n,
            travel_trip_m: (-settings.trips.travel_m, settings.trips.travel_m),
            cart_trip_m: settings.trips.cart_m,
            force: ChannelMonitor::default(),
            hammer: ChannelMonitor::default(),
            cart: ChannelMonitor::default(),
            force_is_live: false,
        }
    }

    /// The trip levels from now on: those of the settings, nearer by what is doubted, and by as much as the readings at rest
    /// (of the force, N, and of the hammer relative to the cart, m) are on the far side of 0. The cart goes as far to either
    /// side, so a zero off its middle makes one of them trip early by itself.
    pub fn set_levels(&mut self, trips: &Trips, doubt: &Doubt, (rest_n, rest_m): (f32, f32)) {
        let travel_m = trips.travel_m / doubt.travel;
        self.force_trip_n = trips.force_n / doubt.force + rest_n.min(0.0);
        self.travel_trip_m = (rest_m.max(0.0) - travel_m, rest_m.min(0.0) + travel_m);
        self.cart_trip_m = trips.cart_m / doubt.cart;
    }

    /// Sets whether the force sensor's code varied with the drive off: only then can a constant one be frozen.
    pub fn set_force_is_live(&mut self, live: bool) {
        self.force_is_live = live;
    }

    /// The drive starts: counts changes of codes from now on.
    pub fn restart(&mut self, now: Stamp) {
        self.force.restart(now);
        self.hammer.restart(now);
        self.cart.restart(now);
    }

    /// Whether no condition stands and none is on its way: a fault may be cleared only then.
    pub fn is_quiet(&self) -> bool {
        self.force.is_quiet() && self.hammer.is_quiet() && self.cart.is_quiet()
    }

    /// Checks a tick's codes, sampled at drive instant `now`; `moving`: the cart should be moving.
    #[inline]
    pub fn check(
        &mut self,
        frame: &Frame,
        now: Stamp,
        moving: bool,
        enabled: bool,
    ) -> (Sample, Option<Trip>) {
        let (force_n, force_fault) = self.force.take(&self.force_channel, frame.force, now);
        let (hammer_m, hammer_fault) = self.hammer.take(&self.hammer_channel, frame.hammer, now);
        let (cart_m, cart_fault) = self.cart.take(&self.cart_channel, frame.cart, now);
        let sample = Sample {
            force_n,
            hammer_m,
            cart_m,
        };
        if frame.emergency {
            return (sample, Some(Trip::system(Fault::EmergencyStop, 1.0)));
        }
        // At its upper rail the force is beyond all that can be measured. No trip level is ([`Settings::check`]).
        if self.force.over.tick(force_n > self.force_trip_n) {
            return (sample, trip(Fault::OverForce, Origin::Force, force_n));
        }
        let relative_m = hammer_m - cart_m;
        let (lowest_m, highest_m) = self.travel_trip_m;
        let travels = relative_m < lowest_m || relative_m > highest_m;
        if self.hammer.over.tick(enabled && travels) {
            let size_m = libm::fabsf(relative_m);
            return (sample, trip(Fault::OverTravel, Origin::Hammer, size_m));
        }
        let cart_travels = libm::fabsf(cart_m) > self.cart_trip_m;
        if self.cart.over.tick(enabled && cart_travels) {
            return (sample, trip(Fault::OverTravel, Origin::Cart, cart_m));
        }
        for (fault, origin, code) in [
            (force_fault, Origin::Force, frame.force),
            (hammer_fault, Origin::Hammer, frame.hammer),
            (cart_fault, Origin::Cart, frame.cart),
        ] {
            if let Some(fault) = fault {
                return (sample, trip(fault, origin, f32::from(code.0)));
            }
        }
        (sample, self.frozen(now, moving))
    }

    /// Trips on a code that has not changed for a whole drive period although the cart moves.
    #[inline]
    fn frozen(&self, now: Stamp, moving: bool) -> Option<Trip> {
        if !moving {
            return None;
        }
        let (force, hammer, cart) = (&self.force, &self.hammer, &self.cart);
        for (changed, code, origin, must_move) in [
            (force.changed, force.last, Origin::Force, self.force_is_live),
            (hammer.changed, hammer.last, Origin::Hammer, true),
            (cart.changed, cart.last, Origin::Cart, true),
        ] {
            if must_move && !now.within_a_turn_of(changed) {
                return trip(Fault::SensorFrozen, origin, f32::from(code.0));
            }
        }
        None
    }
}

fn trip(fault: Fault, origin: Origin, value: f32) -> Option<Trip> {
    Some(Trip {
        fault,
        origin,
        value,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::params::WIRES;

    fn at(cycle: u32, phase: u32) -> Stamp {
        Stamp { cycle, phase }
    }

    /// Ticks until the guard trips on `frame`, if it does within 10,000.
    fn trips_after(frame: Frame) -> Option<(usize, Fault, Origin)> {
        let mut guard = Guard::new(&Settings::for_rig(&WIRES));
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
        // Zeros, and the readings that trip: force, lowest and highest travel, cart.
        for (rest, levels) in [
            (
                (0.0, 0.0),
                [trips.force_n / 1.25, -8.333e-3, 8.333e-3, 1.818e-3],
            ),
            (
                (-20.0, 1e-3),
                [trips.force_n / 1.25 - 20.0, -7.333e-3, 8.333e-3, 1.818e-3],
            ),
            (
                (20.0, -1e-3),
                [trips.force_n / 1.25, -8.333e-3, 7.333e-3, 1.818e-3],
            ),
        ] {
            for (k, level) in levels.into_iter().enumerate() {
                for (share, trips_there) in [(1.01, true), (0.99, false)] {
                    let mut guard = Guard::new(&settings);
                    guard.set_levels(&trips, &doubt, rest);
                    let code = |channel: &Channel| {
                        AdcCode((channel.zero_code + share * level / channel.unit_per_code) as u16)
                    };
                    let mut frame = quiet();
                    match k {
                        0 => frame.force = code(&settings.force),
                        3 => frame.cart = code(&settings.cart),
                        _ => frame.hammer = code(&settings.hammer),
                    }
                    let tripped =
                        (0..9).any(|_| guard.check(&frame, at(0, 0), true, true).1.is_some());
                    assert_eq!(tripped, trips_there, "{rest:?} {k} {share}");
                }
            }
        }
    }

    #[test]
    fn a_code_that_stands_still_for_a_whole_period_is_frozen() {
        let mut guard = Guard::new(&Settings::for_rig(&WIRES));
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
        let mut guard = Guard::new(&Settings::for_rig(&WIRES));
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
        let mut guard = Guard::new(&Settings::for_rig(&WIRES));
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
}
