//! The conditions that trip the drive by themselves, checked at every tick.
//!
//! Counts are consecutive ticks, so that a single bad sample trips nothing; latencies are in the fault
//! table of the documentation, and held by tests.

use crate::fault::{Fault, Origin};
use crate::io::{AdcCode, Channel, Frame, Reading};
use crate::model::drive::Stamp;
use crate::sense::Sample;
use crate::settings::Settings;

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

/// The checks of one channel.
#[derive(Clone, Copy, Debug, Default)]
struct ChannelMonitor {
    last: AdcCode,
    changed: Stamp,
    good: f32,
    open: u8,
    saturated: u8,
    over: u8,
}

impl ChannelMonitor {
    /// Takes in a code; returns its value (the last good one if it has none).
    #[inline]
    fn take(&mut self, channel: &Channel, code: AdcCode, now: Stamp) -> (f32, Option<Fault>) {
        if code != self.last {
            self.last = code;
            self.changed = now;
        }
        match channel.read(code) {
            Reading::Value(value) => {
                self.good = value;
                self.open = 0;
                self.saturated = 0;
                (value, None)
            }
            Reading::Saturated(value) => {
                self.open = 0;
                self.saturated = self.saturated.saturating_add(1);
                let trips = self.saturated >= SATURATED_TICKS;
                (value, trips.then_some(Fault::SensorSaturated))
            }
            Reading::Open => {
                self.open = self.open.saturating_add(1);
                let trips = self.open >= OPEN_TICKS;
                (self.good, trips.then_some(Fault::SensorOpen))
            }
        }
    }

    /// Counts consecutive ticks beyond a level.
    #[inline]
    fn beyond(&mut self, is: bool, ticks: u8) -> bool {
        self.over = if is { self.over.saturating_add(1) } else { 0 };
        self.over >= ticks
    }
}

/// The checks of a tick's samples.
#[derive(Clone, Copy, Debug)]
pub struct Guard {
    force_channel: Channel,
    hammer_channel: Channel,
    cart_channel: Channel,
    force_trip_n: f32,
    travel_trip_m: f32,
    cart_trip_m: f32,
    force: ChannelMonitor,
    hammer: ChannelMonitor,
    cart: ChannelMonitor,
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
            travel_trip_m: settings.trips.travel_m,
            cart_trip_m: settings.trips.cart_m,
            force: ChannelMonitor::default(),
            hammer: ChannelMonitor::default(),
            cart: ChannelMonitor::default(),
            force_is_live: false,
        }
    }

    /// Sets whether the force sensor's code varied with the drive off: only then can a constant one be frozen.
    pub fn set_force_is_live(&mut self, live: bool) {
        self.force_is_live = live;
    }

    /// The drive starts: counts changes of codes from now on.
    pub fn restart(&mut self, now: Stamp) {
        for channel in [&mut self.force, &mut self.hammer, &mut self.cart] {
            channel.changed = now;
            channel.over = 0;
        }
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
        if self
            .force
            .beyond(force_n > self.force_trip_n, OVER_FORCE_TICKS)
        {
            return (sample, trip(Fault::OverForce, Origin::Force, force_n));
        }
        let relative_m = libm::fabsf(hammer_m - cart_m);
        let travels = relative_m > self.travel_trip_m;
        if self.hammer.beyond(enabled && travels, OVER_TRAVEL_TICKS) {
            return (sample, trip(Fault::OverTravel, Origin::Hammer, relative_m));
        }
        let cart_travels = libm::fabsf(cart_m) > self.cart_trip_m;
        if self.cart.beyond(enabled && cart_travels, OVER_TRAVEL_TICKS) {
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
        for (channel, origin, must_move) in [
            (&self.force, Origin::Force, self.force_is_live),
            (&self.hammer, Origin::Hammer, true),
            (&self.cart, Origin::Cart, true),
        ] {
            if must_move && !now.within_a_turn_of(channel.changed) {
                return trip(Fault::SensorFrozen, origin, f32::from(channel.last.0));
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
    fn a_code_that_stands_still_for_a_whole_period_is_frozen() {
        let mut guard = Guard::new(&Settings::for_rig(&WIRES));
        guard.set_force_is_live(true);
        guard.restart(at(5, 100));
        let mut frame = quiet();
        guard.check(&frame, at(5, 101), true, true);
        // Hammer and cart move on, the force's code does not.
        frame.hammer.0 += 1;
        frame.cart.0 += 1;
        let (_, early) = guard.check(&frame, at(6, 100), true, true);
        assert_eq!(early, None);
        let (_, late) = guard.check(&frame, at(6, 102), true, true);
        assert_eq!(
            late.map(|t| (t.fault, t.origin)),
            Some((Fault::SensorFrozen, Origin::Force))
        );
        let (_, still) = guard.check(&frame, at(9, 0), false, true);
        assert_eq!(still, None, "nothing has to move");
    }

    #[test]
    fn a_single_spoilt_sample_trips_nothing() {
        let mut guard = Guard::new(&Settings::for_rig(&WIRES));
        for tick in 0..1000_u32 {
            let mut frame = quiet();
            if tick % 2 == 0 {
                frame.force = AdcCode(0);
                frame.hammer = AdcCode(4095);
            }
            let (_, trip) = guard.check(&frame, at(0, tick), true, true);
            assert_eq!(trip, None);
        }
    }
}
