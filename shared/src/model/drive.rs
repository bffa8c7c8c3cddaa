//! The shaker's phase: a u32 accumulator that wraps once per drive period, and a unit phasor rotated
//! beside it so that no tick evaluates a sine.
//!
//! A phasor that is only ever rotated drifts in f32: 4 % to 23 % after 1e7 ticks. This one keeps what
//! rounding drops ([`Compensated`]) and is set afresh from the accumulator at every quarter turn, where
//! the remaining angle is small and its sine a short polynomial. Against an f64 copy of the accumulator
//! over 1e7 ticks the tests hold it to |amplitude − 1| ≤ 1e-6 and phase error ≤ 1e-6 rad.

use core::f64::consts::TAU;

use crate::model::scalar::{Compensated, Real};

/// One turn of the accumulator.
pub const TURN: f64 = 4_294_967_296.0;

/// The largest phase increment per tick: an eighth of a turn (eight ticks per drive period).
pub const MAX_INCREMENT: u32 = 1 << 29;

/// An instant on the drive's clock: whole drive periods and the phase within the period.
///
/// This is the only time in `shared`: it never grows out of precision.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Stamp {
    /// Drive periods since the start (wraps after 2³²).
    pub cycle: u32,
    /// Phase within the period, in 2⁻³² turns.
    pub phase: u32,
}

impl Stamp {
    /// Turns from `earlier` to `self`.
    #[inline]
    pub fn turns_since(self, earlier: Self) -> f64 {
        let cycles = self.cycle.wrapping_sub(earlier.cycle) as i32;
        f64::from(cycles) + (f64::from(self.phase) - f64::from(earlier.phase)) / TURN
    }

    /// Whether `self` is less than one turn after `earlier` (integer arithmetic only).
    #[inline]
    pub fn within_a_turn_of(self, earlier: Self) -> bool {
        match self.cycle.wrapping_sub(earlier.cycle) {
            0 => true,
            1 => self.phase < earlier.phase,
            _ => false,
        }
    }
}

/// A rotation by a small angle: `(sin, 1 − cos)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rotor<R> {
    sin: R,
    versin: R,
}

impl<R: Real> Rotor<R> {
    /// Rotation by `angle` rad.
    #[inline]
    pub fn new(angle: R) -> Self {
        let (sin, versin) = angle.sin_versin();
        Self { sin, versin }
    }
}

/// Why a drive was refused.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DriveError {
    /// Frequency or tick is not a positive finite number.
    NotPositive,
    /// Fewer than eight ticks per drive period.
    TooFast,
    /// The frequency is below the accumulator's grain, 2⁻³² turns per tick.
    TooSlow,
}

impl core::error::Error for DriveError {}

impl core::fmt::Display for DriveError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::NotPositive => "drive frequency and tick must be positive numbers",
            Self::TooFast => "the tick is too long for the drive: at least 8 ticks per period",
            Self::TooSlow => "the drive frequency is below what the phase accumulator can resolve",
        })
    }
}

/// The drive: y = A0 sin(phase), advanced a tick at a time (equation 3-15's Ωt, wrapped).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drive<R> {
    now: Stamp,
    increment: u32,
    sin: Compensated<R>,
    cos: Compensated<R>,
    /// Angle per tick, rad.
    angle: R,
    full: Rotor<R>,
    half: Rotor<R>,
    tick_s: R,
}

impl<R: Real> Drive<R> {
    /// A drive at `frequency_hz`, advanced `tick_s` seconds per tick, at phase 0.
    ///
    /// The frequency is rounded to the accumulator's grain (5e-6 Hz at 20 kHz); [`Self::frequency_hz`]
    /// gives the rounded one.
    ///
    /// # Errors
    /// If frequency or tick are out of range: see [`DriveError`].
    pub fn new(frequency_hz: f64, tick_s: f64) -> Result<Self, DriveError> {
        let mut drive = Self {
            now: Stamp::default(),
            increment: 0,
            sin: Compensated::new(R::ZERO),
            cos: Compensated::new(R::ONE),
            angle: R::ZERO,
            full: Rotor::new(R::ZERO),
            half: Rotor::new(R::ZERO),
            tick_s: R::from_f64(tick_s),
        };
        drive.set_frequency(frequency_hz, tick_s)?;
        Ok(drive)
    }

    /// Changes the frequency without a jump in phase.
    ///
    /// # Errors
    /// If the frequency is out of range ([`DriveError`]); the drive is then unchanged.
    pub fn set_frequency(&mut self, frequency_hz: f64, tick_s: f64) -> Result<(), DriveError> {
        let turns = frequency_hz * tick_s;
        if !(frequency_hz > 0.0 && tick_s > 0.0 && turns.is_finite()) {
            return Err(DriveError::NotPositive);
        }
        if turns * TURN > f64::from(MAX_INCREMENT) {
            return Err(DriveError::TooFast);
        }
        let increment = (turns * TURN + 0.5) as u32;
        if increment == 0 {
            return Err(DriveError::TooSlow);
        }
        let angle = f64::from(increment) * (TAU / TURN);
        self.increment = increment;
        self.tick_s = R::from_f64(tick_s);
        self.angle = R::from_f64(angle);
        self.full = Rotor::new(R::from_f64(angle));
        self.half = Rotor::new(R::from_f64(0.5 * angle));
        Ok(())
    }

    /// This drive, phase included, with each of its numbers converted by `number`.
    pub fn map<S: Real>(&self, number: impl Fn(R) -> S) -> Drive<S> {
        let sum = |x: &Compensated<R>| Compensated {
            hi: number(x.hi),
            lo: number(x.lo),
        };
        let rotor = |x: &Rotor<R>| Rotor {
            sin: number(x.sin),
            versin: number(x.versin),
        };
        Drive {
            now: self.now,
            increment: self.increment,
            sin: sum(&self.sin),
            cos: sum(&self.cos),
            angle: number(self.angle),
            full: rotor(&self.full),
            half: rotor(&self.half),
            tick_s: number(self.tick_s),
        }
    }

    /// Goes back to phase 0 of period 0.
    pub fn restart(&mut self) {
        self.now = Stamp::default();
        self.sin = Compensated::new(R::ZERO);
        self.cos = Compensated::new(R::ONE);
    }

    /// The frequency the accumulator really runs at, Hz.
    pub fn frequency_hz(&self) -> f64 {
        f64::from(self.increment) / TURN / self.tick_s.to_f64()
    }

    /// Angular frequency Ω, rad/s.
    pub fn angular_frequency(&self) -> f64 {
        TAU * self.frequency_hz()
    }

    /// Length of a tick, s.
    #[inline]
    pub fn tick_s(&self) -> R {
        self.tick_s
    }

    /// The instant of the last tick.
    #[inline]
    pub fn now(&self) -> Stamp {
        self.now
    }

    /// sin(phase) at the last tick.
    #[inline]
    pub fn sin(&self) -> R {
        self.sin.hi
    }

    /// cos(phase) at the last tick.
    #[inline]
    pub fn cos(&self) -> R {
        self.cos.hi
    }

    /// sin(phase) a `fraction` (0 to 1) of a tick ahead of the last tick.
    #[inline]
    pub fn sin_ahead(&self, fraction: R) -> R {
        if fraction == R::ONE {
            self.sin_after(&self.full)
        } else if fraction == R::HALF {
            self.sin_after(&self.half)
        } else {
            self.sin_after(&Rotor::new(fraction * self.angle))
        }
    }

    /// sin(phase) and cos(phase) a `fraction` (0 to 1) of a tick ahead of the last tick.
    #[inline]
    pub fn sin_cos_ahead(&self, fraction: R) -> (R, R) {
        let by = Rotor::new(fraction * self.angle);
        let cos = self.cos.hi - (self.sin.hi * by.sin + self.cos.hi * by.versin - self.cos.lo);
        (self.sin_after(&by), cos)
    }

    /// The instant a `fraction` (0 to 1) of a tick ahead of the last tick.
    #[inline]
    pub fn stamp_ahead(&self, fraction: R) -> Stamp {
        let ahead = (fraction.to_f64() * f64::from(self.increment)) as u32;
        let (phase, wrapped) = self.now.phase.overflowing_add(ahead);
        Stamp {
            cycle: self.now.cycle.wrapping_add(u32::from(wrapped)),
            phase,
        }
    }

    /// If the next tick passes phase 0: the fraction of the tick at which it does.
    #[inline]
    pub fn strobe_ahead(&self) -> Option<R> {
        let (_, wraps) = self.now.phase.overflowing_add(self.increment);
        wraps.then(|| {
            let to_go = self.now.phase.wrapping_neg();
            R::from_f64(f64::from(to_go) / f64::from(self.increment))
        })
    }

    /// Moves on by one tick.
    #[inline]
    pub fn advance(&mut self) {
        let before = self.now.phase;
        let (phase, wrapped) = before.overflowing_add(self.increment);
        self.now.phase = phase;
        self.now.cycle = self.now.cycle.wrapping_add(u32::from(wrapped));
        if (phase ^ before) >> 30 != 0 {
            self.seed();
        } else {
            let Rotor { sin, versin } = self.full;
            let (s, c) = (self.sin.hi, self.cos.hi);
            self.sin = self.sin.plus(c * sin - s * versin);
            self.cos = self.cos.plus(-(s * sin) - c * versin);
        }
    }

    #[inline]
    fn sin_after(&self, by: &Rotor<R>) -> R {
        self.sin.hi + (self.cos.hi * by.sin - self.sin.hi * by.versin + self.sin.lo)
    }

    /// Sets the phasor from the accumulator: the angle past the last quarter turn is small.
    fn seed(&mut self) {
        let past = self.now.phase & (u32::MAX >> 2);
        let (sin, versin) = R::from_f64(f64::from(past) * (TAU / TURN)).sin_versin();
        let small = Compensated::new(sin);
        let large = Compensated::new(R::ONE).plus(-versin);
        let negate = |x: Compensated<R>| Compensated {
            hi: -x.hi,
            lo: -x.lo,
        };
        (self.sin, self.cos) = match self.now.phase >> 30 {
            0 => (small, large),
            1 => (large, negate(small)),
            2 => (negate(small), negate(large)),
            _ => (negate(large), small),
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Worst amplitude and phase error of an f32 drive against an f64 copy of its accumulator.
    fn worst(frequency_hz: f64, tick_s: f64, ticks: u32) -> (f64, f64) {
        let mut drive = Drive::<f32>::new(frequency_hz, tick_s).unwrap();
        let (mut amplitude, mut phase) = (0.0_f64, 0.0_f64);
        for _ in 0..ticks {
            drive.advance();
            let exact = f64::from(drive.now().phase) * (TAU / TURN);
            let (s, c) = (f64::from(drive.sin()), f64::from(drive.cos()));
            amplitude = amplitude.max((s.hypot(c) - 1.0).abs());
            let (sin, cos) = exact.sin_cos();
            phase = phase.max((s * cos - c * sin).atan2(c * cos + s * sin).abs());
        }
        (amplitude, phase)
    }

    #[test]
    fn phasor_holds_its_bounds_over_ten_million_ticks() {
        for (frequency_hz, tick_s) in [(2.73, 50e-6), (1.41, 50e-6), (29.9, 50e-6), (3.0, 10e-6)] {
            let (amplitude, phase) = worst(frequency_hz, tick_s, 10_000_000);
            assert!(
                amplitude <= 1e-6,
                "{frequency_hz} Hz: amplitude {amplitude:e}"
            );
            assert!(phase <= 1e-6, "{frequency_hz} Hz: phase {phase:e} rad");
        }
    }

    #[test]
    fn looking_ahead_agrees_with_going_there() {
        let mut drive = Drive::<f32>::new(7.3, 200e-6).unwrap();
        for _ in 0..20_000 {
            let (full, part) = (drive.sin_ahead(1.0), drive.sin_ahead(0.25));
            let here = drive.now();
            let at = f64::from(here.phase) + 0.25 * f64::from(drive.increment);
            assert!((f64::from(part) - (at * TAU / TURN).sin()).abs() < 4e-7);
            drive.advance();
            assert!((full - drive.sin()).abs() < 3e-7);
        }
    }

    #[test]
    fn the_strobe_is_where_the_accumulator_wraps() {
        let mut drive = Drive::<f64>::new(3.3, 50e-6).unwrap();
        let mut strobes = 0;
        for _ in 0..200_000 {
            if let Some(fraction) = drive.strobe_ahead() {
                strobes += 1;
                assert!((0.0..=1.0).contains(&fraction));
                let phase = drive.stamp_ahead(fraction).phase;
                assert!(phase.wrapping_add(2) < 4, "{phase}");
            }
            drive.advance();
        }
        assert_eq!(strobes, 33, "10 s at 3.3 Hz, the last strobe being the end");
    }

    #[test]
    fn refuses_what_it_cannot_run() {
        assert_eq!(Drive::<f32>::new(-1.0, 5e-5), Err(DriveError::NotPositive));
        assert_eq!(
            Drive::<f32>::new(f64::NAN, 5e-5),
            Err(DriveError::NotPositive)
        );
        assert_eq!(Drive::<f32>::new(5_000.0, 5e-5), Err(DriveError::TooFast));
        assert_eq!(Drive::<f32>::new(1e-9, 5e-5), Err(DriveError::TooSlow));
    }

    #[test]
    fn turns_between_stamps() {
        let a = Stamp {
            cycle: u32::MAX,
            phase: 3 << 30,
        };
        let b = Stamp {
            cycle: 0,
            phase: 1 << 30,
        };
        assert_eq!(b.turns_since(a), 0.5);
        assert!(b.within_a_turn_of(a));
        assert!(
            !Stamp {
                cycle: 0,
                phase: 3 << 30
            }
            .within_a_turn_of(a)
        );
    }
}
