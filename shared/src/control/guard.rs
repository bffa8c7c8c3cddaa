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
    pub fault: Fault,
    /// The sensor that the fault is about; [`Origin::System`] if it is about none.
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
pub struct SampleGuard {
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

impl SampleGuard {
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

    /// The trip levels from now on: those of the settings, nearer by what is doubted, by the contact's true peak over what two
    /// samples in a row reach (`peak_over_two`: so many trip), and by as much as the readings at rest (of the force, N, and of
    /// the hammer relative to the cart, m) are on the far side of 0; away from the surface also by how far the zero may have moved
    /// since (`shift_m`). The cart goes as far to either side, so a zero off its middle makes one of them trip early by itself.
    pub fn set_levels(
        &mut self,
        trips: &Trips,
        doubt: &Doubt,
        peak_over_two: f32,
        (rest_n, rest_m): (f32, f32),
        shift_m: f32,
    ) {
        let travel_m = trips.travel_m / doubt.travel;
        self.force_trip_n = trips.force_n / (doubt.force * peak_over_two) + rest_n.min(0.0);
        self.travel_trip_m = (
            rest_m.max(0.0) + shift_m - travel_m,
            rest_m.min(0.0) + travel_m,
        );
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
mod tests;
