//! Plausibility of the sensors against each other and against mechanics: the one place that judges it.
//!
//! | check | measured against | trips | after | origin |
//! |---|---|---|---|---|
//! | distance | displacement at a contact against the believed gap | more than [`FAR_M`] off | [`FAR_PULSES`] contacts in a row | force |
//! | momentum | ∫F dt against the believed mass times the change of speed, both as leaky sums | outside [`momentum::MOMENTUM_RANGE`] | [`BAD_PULSES`] contacts in a row, from the sixteenth on | force |
//! | gross | the same of a single contact | outside [`momentum::GROSS_RANGE`] | [`momentum::GROSS_PULSES`] contacts in a row | force |
//! | zero | mean force of a drive period outside contacts, against the zero of the self test | more than [`ZERO_SHARE`] of `limits.force_n` | [`ZERO_PERIODS`] drive periods in a row | force |
//! | follow | cart amplitude against the command as it was put out, whatever the amplitude loop has made of it | below [`follow::LEAST_FOLLOW`] | [`BAD_PERIODS`] drive periods in a row | cart |
//! | step | the same against what it was before at this frequency | by more than [`follow::STEP_RANGE`] | the same | cart |
//! | ratio | gain of the hammer's sensor over the cart's, from the flights alone ([`crate::sense::identification`]) | outside [`RATIO_RANGE`] | [`RATIO_PERIODS`] drive periods with one contact each in a row, from [`RATIO_WINDOWS`] windows on | hammer |
//! | still | motion of the hammer in a drive period, root mean square, against the cart's amplitude | less than [`STILL_SHARE`], without a contact less than half of a free swing | [`STILL_PERIODS`] drive periods in a row | hammer |
//! | target | frequency held in Hold against the newest forecast's target | more than [`TARGET_SHARE`] off | [`TARGET_PERIODS`] drive periods in a row | cart |
//! | sense | lag of the cart behind the command, beyond that of the rig's own loop | more than [`follow::LARGEST_MORE_LAG`] | the same | cart |
//!
//! Sensors that contradict each other by less are doubted, and limits go by the worse of the two ([`Doubt`]).
//!
//! Before any of these, a small motion has proven sign and gain of the cart's and the hammer's sensor ([`super::proof`]).
//!
//! What they cannot tell apart: which of the two sensors of a pair has the wrong gain; all three sensors with the same
//! wrong gain from the start on, within what `follow` allows; a cart's sensor that is late from a rig that is not the one
//! believed.

mod doubt;
mod follow;
mod momentum;

use crate::fault::{Fault, Origin};
use crate::sense::{Pulse, Strobe};
use crate::settings::Settings;

use super::free::FreeSwing;
use super::guard::Trip;
use follow::CartFollowing;
use momentum::Momentum;

#[cfg(test)]
use momentum::MOMENTUM_RANGE;

pub use doubt::Doubt;
pub use follow::{BAD_PERIODS, LEAST_FOLLOW};
pub use momentum::BAD_PULSES;

/// Gain of the hammer's sensor over the cart's; wider by what a late sensor may be worth ([`LATE_S`]).
pub const RATIO_RANGE: (f32, f32) = (0.81, 1.19);
/// By how much one displacement may be read later than the other without being known, s: of 1 ms, 0.6 ms are learnt
/// ([`crate::sense::identification`]). What the drive turns in that time, rad, is what it is worth as a gain: 0.9 % at 3.7 Hz,
/// 3.3 % at 13 Hz. (Of the lag itself, momentum shows a quarter, and it learns none.)
pub const LATE_S: f32 = 0.4e-3;
/// Drive periods in a row outside that trip.
pub const RATIO_PERIODS: u8 = 16;
/// Windows in flight at full amplitude before the ratio is judged.
pub const RATIO_WINDOWS: u32 = 48;

/// Least motion of a hammer that strikes, root mean square, in amplitudes of the cart. A healthy one has 0.21 in its weakest period
/// and 0.3 in one of four in a row (four rigs at 0.5 to 2.2 times the best frequency, gaps of 0 and 0.9 mm).
pub const STILL_SHARE: f32 = 0.2;
/// Least motion of a hammer that swings free, root mean square, in amplitudes of its swing: half of what it has, 1/√2.
const FREE_SHARE: f32 = 0.5 * core::f32::consts::FRAC_1_SQRT_2;
/// How far off the natural frequency may be where the free swing is reckoned.
const NATURAL_OFF: f32 = 1.1;
/// Drive periods in a row below it that trip: fewer than after which a reduced amplitude returns.
pub const STILL_PERIODS: u8 = 8;

/// Largest force outside contacts, as a share of the force limit.
pub const ZERO_SHARE: f32 = 0.05;
/// Drive periods in a row beyond it that trip.
pub const ZERO_PERIODS: u8 = 4;

/// Largest distance of the frequency that is held from the forecast's target, relative. A rig whose natural frequency is
/// 10 % off and not identified yet is up to 18 % off.
pub const TARGET_SHARE: f32 = 0.2;
/// Drive periods in a row beyond it that trip: longer than it takes a changed rig to be identified and forecast.
pub const TARGET_PERIODS: u8 = 48;
/// A motion with less of the target's force is another one: a hammer that leans on the surface chatters.
const TARGET_FORCE: f32 = 0.5;
/// The forecast is for the amplitude that was set: at one further from it, relative, nothing is judged.
const TARGET_AMPLITUDE: f32 = 0.15;

/// Pulses in a row, with the hammer away from the surface, that trip.
pub const FAR_PULSES: u8 = 3;
/// Distance of the hammer from the surface at a contact, m.
pub const FAR_M: f32 = 1.5e-3;

/// How far beyond the surface, m, and how many ticks in a row, a hammer swings that finds none there: more than a soft surface gives way.
const PAST_M: f32 = 0.5e-3;
const PAST_TICKS: u8 = 20;

/// The checks and their counts.
#[derive(Clone, Copy, Debug)]
pub struct Plausibility {
    /// None: not known since the last start.
    surface_m: Option<f32>,
    gap_set_m: f32,
    amplitude_m: f32,
    free: FreeSwing,
    zero_n: f32,
    bad_zeros: u8,
    bad_targets: u8,
    far_pulses: u8,
    ticks_past: u8,
    bad_ratios: u8,
    still: u8,
    momentum: Momentum,
    follow: CartFollowing,
    /// What the drive turns in [`LATE_S`], rad.
    late: f32,
    /// Impulse over momentum, and gain of the hammer's sensor over the cart's, as last known.
    impulse_over_momentum: f32,
    hammer_over_cart: f32,
    /// The latter, from flights in which contacts may hide, too.
    unsure_ratio: f32,
}

impl Plausibility {
    /// For the rig of `settings`.
    pub fn new(settings: &Settings) -> Self {
        Self {
            surface_m: Some(settings.rig.gap_m as f32),
            gap_set_m: settings.rig.gap_m as f32,
            amplitude_m: settings.rig.amplitude_m as f32,
            free: FreeSwing::new(&settings.rig),
            zero_n: ZERO_SHARE * settings.limits.force_n,
            bad_zeros: 0,
            bad_targets: 0,
            far_pulses: 0,
            ticks_past: 0,
            bad_ratios: 0,
            still: 0,
            momentum: Momentum::new(settings),
            follow: CartFollowing::new(settings),
            late: 0.0,
            impulse_over_momentum: 1.0,
            hammer_over_cart: 1.0,
            unsure_ratio: 1.0,
        }
    }

    /// The drive starts anew. What was doubted remains so until the sensors show otherwise; where the surface is now, the first
    /// contacts tell.
    pub fn restart(&mut self) {
        self.surface_m = None;
        self.far_pulses = 0;
        self.bad_zeros = 0;
        self.bad_targets = 0;
        self.bad_ratios = 0;
        self.still = 0;
        self.momentum.restart();
        self.follow.restart();
    }

    /// Where the last contacts have found the surface, m: one that recedes slowly is followed.
    pub fn believe_surface(&mut self, surface_m: f32) {
        self.surface_m = Some(surface_m);
    }

    /// A tick with the hammer at `relative_m` from the cart. Whether, before the first contacts tell where the surface is, it swings freely
    /// past where it was set: that has receded, and no contact is missing.
    #[inline]
    pub fn is_past_the_surface(&mut self, relative_m: f32) -> bool {
        let past = self.surface_m.is_none() && relative_m > self.gap_set_m + PAST_M;
        run(&mut self.ticks_past, past, PAST_TICKS)
    }

    /// A contact has ended.
    pub fn pulse(&mut self, pulse: &Pulse) -> Option<Trip> {
        let far_m =
            (self.surface_m).map_or(0.0, |surface_m| libm::fabsf(pulse.relative_m - surface_m));
        if run(&mut self.far_pulses, far_m > FAR_M, FAR_PULSES) {
            return trip(Origin::Force, far_m);
        }
        let found = self.momentum.pulse(pulse, self.late);
        if let Some(ratio) = self.momentum.ratio() {
            self.impulse_over_momentum = ratio;
        }
        let ratio = found?;
        // A hammer that bounces the wrong way is the hammer's sensor; which of the two has a wrong gain is not known.
        let origin = if ratio > 0.0 {
            Origin::Force
        } else {
            Origin::Hammer
        };
        trip(origin, ratio)
    }

    /// A drive period at `frequency_hz` has ended, in which the command was `command_m` on average; `rising`: the
    /// amplitude is on its way up.
    pub fn strobe(
        &mut self,
        strobe: &Strobe,
        command_m: f32,
        frequency_hz: f32,
        rising: bool,
    ) -> Option<Trip> {
        let ratio = self
            .follow
            .strobe(strobe, command_m, frequency_hz, rising)?;
        trip(Origin::Cart, ratio)
    }

    /// A drive period at `hz` has ended, in which the command was `command_m` on average: a hammer in a cart that moves moves.
    pub fn still(&mut self, strobe: &Strobe, command_m: f32, hz: f32) -> Option<Trip> {
        let share = strobe.hammer_m / strobe.amplitude_m.min(command_m);
        let least = if strobe.contacts == 0 {
            STILL_SHARE.min(FREE_SHARE * self.free.own(NATURAL_OFF * hz))
        } else {
            STILL_SHARE
        };
        let trips = run(&mut self.still, share < least, STILL_PERIODS);
        trips.then_some(())?;
        trip(Origin::Hammer, share)
    }

    /// A drive period has ended with this sum, N, of so many samples of the force outside contacts.
    pub fn free_force(&mut self, (sum_n, samples): (f32, u32)) -> Option<Trip> {
        let mean_n = sum_n / samples.max(1) as f32;
        let off = libm::fabsf(mean_n) > self.zero_n;
        let trips = run(&mut self.bad_zeros, off, ZERO_PERIODS);
        trips.then_some(())?;
        trip(Origin::Force, mean_n)
    }

    /// A drive period at `hz` has ended with this gain of the hammer's sensor over the cart's, from so many windows; `clean`:
    /// of flights in which no contact hides. With contacts in them, a healthy sensor reads 0.5 to 0.8: then the travel limit alone goes by it.
    pub fn ratio(&mut self, found: Option<(f32, u32)>, clean: bool, hz: f32) -> Option<Trip> {
        self.late = core::f32::consts::TAU * LATE_S * hz;
        let (ratio, windows) = found?;
        let (low, high) = RATIO_RANGE;
        let (low, high) = (low - self.late, high + self.late);
        if windows >= RATIO_WINDOWS && ratio > 0.0 {
            self.unsure_ratio = ratio;
            if clean {
                self.hammer_over_cart = ratio;
            }
        }
        let outside = clean && !(low..=high).contains(&ratio) && windows >= RATIO_WINDOWS;
        let trips = run(&mut self.bad_ratios, outside, RATIO_PERIODS);
        trips.then_some(())?;
        trip(Origin::Hammer, ratio)
    }

    /// A drive period of Hold has ended at `hz`, where the newest forecast has its target at `target_hz`, with `target_n`. The frequency
    /// follows the phase of the contacts against the measured cart: one that settles elsewhere has followed a cart's
    /// sensor that is late, or the rig is not the one believed.
    pub fn held(
        &mut self,
        strobe: &Strobe,
        hz: f32,
        (target_hz, target_n): (f32, f32),
    ) -> Option<Trip> {
        let share = hz / target_hz;
        let is_it = strobe.peak_n >= TARGET_FORCE * target_n;
        let as_set = libm::fabsf(strobe.amplitude_m / self.amplitude_m - 1.0) <= TARGET_AMPLITUDE;
        let off = libm::fabsf(share - 1.0) > TARGET_SHARE && as_set && is_it && target_hz > 0.0;
        let trips = run(&mut self.bad_targets, off, TARGET_PERIODS);
        trips.then_some(())?;
        trip(Origin::Cart, share)
    }

    /// How much too little the sensors may read.
    pub fn doubt(&self) -> Doubt {
        Doubt::new(self.impulse_over_momentum, self.hammer_over_cart)
            .or_hammer_reads(self.unsure_ratio)
    }

    /// How much farther out than set the surface was found, m: it has receded, or a zero has moved by as much, and the hammer
    /// swings so much farther to the other side than it reads.
    pub fn zero_shift_m(&self) -> f32 {
        self.surface_m
            .map_or(0.0, |surface_m| (surface_m - self.gap_set_m).max(0.0))
    }

    /// Whether contacts tell the same of the sensors as before. Nothing is made larger while they do not: a gain may have
    /// fallen just now, and the doubt is not there yet.
    #[inline(never)]
    pub fn is_steady(&self) -> bool {
        self.momentum.is_steady()
    }

    /// Whether the cart is under suspicion: nothing may be made good by its measured amplitude meanwhile.
    pub fn doubts_the_cart(&self) -> bool {
        self.follow.doubts()
    }
}

/// Counts bad ones in a row; whether there are `length`.
fn run(count: &mut u8, bad: bool, length: u8) -> bool {
    *count = if bad { count.saturating_add(1) } else { 0 };
    *count >= length
}

fn trip(origin: Origin, value: f32) -> Option<Trip> {
    Some(Trip {
        fault: Fault::SensorOutOfFamily,
        origin,
        value,
    })
}

#[cfg(test)]
mod tests;
