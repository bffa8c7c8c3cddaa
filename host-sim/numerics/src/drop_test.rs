//! A drop test as a sensor would see it, made from the model: the hammer is displaced, released at rest without drive,
//! falls back, strikes and strikes again, ever more softly (figures 3.8 to 3.10 of the chapter, whose raw data are
//! not public).

use std::collections::VecDeque;
use std::f64::consts::{FRAC_1_SQRT_2, TAU};

use serde::Serialize;
use shared::model::params::RigParams;
use shared::model::rig::{Rig, SwitchMode};

use crate::contact_law::undriven::{Course, MotionPiece, Track, Undriven};
use crate::error::{DropTestError, Error};
use crate::low_pass::{self, LowPass};
use crate::noise::Noise;
use crate::range::within;
use crate::row::tidy;

/// A force channel's converter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Converter {
    /// Samples as they are.
    Plain,
    /// A digital low-pass of second order (Butterworth), corner at a fifth of the sampling rate.
    Iir,
    /// A digital linear-phase low-pass: 31 samples, Hamming's window, corner at a fifth of the sampling rate.
    Fir,
    /// The mean of three samples.
    Mean,
    /// 64 times as many samples, a linear-phase low-pass of 40 samples' length with Hamming's window and its corner at 0.45 of
    /// the sampling rate, and every 64th of what that makes.
    DeltaSigma,
}

impl Converter {
    /// What it adds up: weights of the newest and the older samples.
    fn weights(self) -> Vec<f64> {
        let windowed = |count: usize, corner: f64| {
            let one = |i: usize| {
                let at = i as f64 - 0.5 * (count - 1) as f64;
                let turn = TAU * corner * at;
                let sinc = if turn == 0.0 { 1.0 } else { turn.sin() / turn };
                sinc * (0.54 + 0.46 * (TAU * at / (count - 1) as f64).cos())
            };
            let all: Vec<f64> = (0..count).map(one).collect();
            let sum: f64 = all.iter().sum();
            all.iter().map(|w| w / sum).collect()
        };
        match self {
            Self::Plain => vec![1.0],
            Self::Iir => low_pass::digital(0.2, FRAC_1_SQRT_2).collect(),
            Self::Fir => windowed(31, 0.2),
            Self::Mean => vec![1.0 / 3.0; 3],
            Self::DeltaSigma => windowed(40 * MODULATOR_STEPS + 1, 0.45 / MODULATOR_STEPS as f64),
        }
    }
}

/// The last samples, and their weights.
struct Sum {
    weights: Vec<f64>,
    last: VecDeque<f64>,
}

impl Sum {
    fn new(weights: Vec<f64>) -> Self {
        Self {
            last: VecDeque::new(),
            weights,
        }
    }

    /// Before the first one there were others like it.
    fn take(&mut self, newest: f64) {
        self.last.push_front(newest);
        self.last.resize(self.weights.len(), newest);
    }

    fn now(&self) -> f64 {
        self.weights
            .iter()
            .zip(&self.last)
            .map(|(w, f)| w * f)
            .sum()
    }
}

/// How the test is made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DropTest {
    /// Displacement from rest at which the hammer is released (l sin θ or Δ), m: negative, away from the surface.
    pub release_m: f64,
    /// Impacts in the record.
    pub impacts: usize,
    /// Samples per second.
    pub sampling_hz: f64,
    /// Standard deviation of a force sample, N.
    pub noise_n: f64,
    /// First amplitude of the surface's ringing over the impact's peak; 0: none.
    pub ringing_share: f64,
    /// Frequency of the surface's ringing, Hz.
    pub ringing_hz: f64,
    /// Time constant of the surface's ringing, s.
    pub ringing_decay_s: f64,
    /// Bits of the force channel, over a range from −`full_scale_n` to `full_scale_n`; 0: not quantised.
    pub bits: u32,
    /// Range of the force channel, N.
    pub full_scale_n: f64,
    /// The force channel reads so many percent too much.
    pub force_gain_percent: f64,
    /// The force channel's reading of no force at the release, N.
    pub offset_n: f64,
    /// How fast that reading rises, N/s.
    pub drift_n_per_s: f64,
    /// What the force channel's converter does to the samples.
    pub converter: Converter,
    /// The zero goes up or down by so many N in each 0.1 s, at an instant that is drawn.
    pub step_n: f64,
    /// The record's clock is so many percent fast.
    pub clock_fast_percent: f64,
    /// −3 dB corner of the force channel's second-order Butterworth filter, Hz; 0: no filter.
    pub filter_hz: f64,
    /// The displacement channel reads so many percent too much.
    pub displacement_gain_percent: f64,
    /// Seed of the noise and of the zero's steps.
    pub seed: u64,
}

impl Default for DropTest {
    /// Released 3 mm out; four impacts, 50 kHz, nothing that disturbs. The ringing's pitch and decay are the
    /// emulator's.
    fn default() -> Self {
        Self {
            release_m: -3e-3,
            impacts: 4,
            sampling_hz: 50e3,
            noise_n: 0.0,
            ringing_share: 0.0,
            ringing_hz: RINGING_HZ,
            ringing_decay_s: RINGING_DECAY_S,
            bits: 0,
            full_scale_n: 100.0,
            force_gain_percent: 0.0,
            offset_n: 0.0,
            drift_n_per_s: 0.0,
            converter: Converter::Plain,
            step_n: 0.0,
            clock_fast_percent: 0.0,
            filter_hz: 0.0,
            displacement_gain_percent: 0.0,
            seed: 1,
        }
    }
}

impl DropTest {
    /// Refuses what no drop test and no sensor has.
    ///
    /// # Errors
    /// If a number is out of its range.
    pub fn check(&self) -> Result<(), Error> {
        within([
            ("impacts", self.impacts as f64, 1.0, 100.0),
            ("release-mm", tidy(self.release_m * 1e3), -1000.0, 1000.0),
            ("sampling-hz", self.sampling_hz, 100.0, 10e6),
            ("noise-n", self.noise_n, 0.0, 1e6),
            ("ringing", self.ringing_share, 0.0, 10.0),
            ("ringing-hz", self.ringing_hz, 1.0, 1e6),
            (
                "ringing-decay-ms",
                tidy(self.ringing_decay_s * 1e3),
                1e-3,
                1e4,
            ),
            ("bits", f64::from(self.bits), 0.0, 24.0),
            ("full-scale-n", self.full_scale_n, 1e-6, 1e9),
            ("force-gain-percent", self.force_gain_percent, -90.0, 900.0),
            ("offset-n", self.offset_n, -1e6, 1e6),
            ("drift-n-per-s", self.drift_n_per_s, -1e6, 1e6),
            ("filter-hz", self.filter_hz, 0.0, 1e6),
            ("step-n", self.step_n, 0.0, 1e6),
            ("clock-fast-percent", self.clock_fast_percent, -50.0, 50.0),
            (
                "displacement-gain-percent",
                self.displacement_gain_percent,
                -90.0,
                900.0,
            ),
        ])
    }
}

/// One sample of the record of a drop test.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct DropSample {
    /// Since the release, s.
    pub time_s: f64,
    /// Force as the sensor has it, N.
    pub force_n: f64,
    /// Displacement from rest (l sin θ or Δ) as the sensor has it, without noise, mm.
    pub displacement_mm: f64,
    /// The hammer's acceleration towards the surface, without noise, m/s².
    pub acceleration_m_per_s2: f64,
}

/// Frequency at which the impact surface rings after a contact, Hz.
pub const RINGING_HZ: f64 = 3000.0;

/// Time constant with which the ringing dies away, s.
pub const RINGING_DECAY_S: f64 = 2e-3;

/// After the last impact, s.
const AFTER_S: f64 = 0.02;

/// The simulation ends after this time even if there were fewer impacts than asked for, s.
const PATIENCE_S: f64 = 60.0;

/// Steps of the filter in the time of a sample.
const FILTER_STEPS: usize = 16;

/// Samples that a delta-sigma converter makes one of.
const MODULATOR_STEPS: usize = 64;

/// The zero steps once in this time, s.
const STEP_EACH_S: f64 = 0.1;

/// Most samples of a record.
const MOST_SAMPLES: f64 = 5e6;

/// The first `count` impacts of a hammer released at `release_m` without drive; fewer if the hammer comes to rest, or
/// does not reach the surface, first.
///
/// # Errors
/// If the release is not clear of the surface, or out of the rig's reach.
pub fn impacts(
    params: &RigParams,
    rig: &Rig<f64>,
    release_m: f64,
    count: usize,
) -> Result<Vec<Course>, Error> {
    let mut hammer = released(params, rig, release_m)?;
    Ok((0..count)
        .map_while(|_| hammer.next_contact(PATIENCE_S))
        .collect())
}

/// A hammer at rest at `release_m`.
fn released(params: &RigParams, rig: &Rig<f64>, release_m: f64) -> Result<Undriven, Error> {
    let q = rig.coordinate_at(release_m);
    if !q.is_finite() {
        return Err(DropTestError::OutOfReach { release_m }.into());
    }
    if rig.kinematics(q, 0.0).delta >= 0.0 {
        return Err(DropTestError::NotClear {
            release_m,
            gap_m: params.gap_m,
        }
        .into());
    }
    let natural_hz = params.natural_frequency_hz();
    let size = (q - rig.coordinate_at(0.0)).abs().max(1e-9);
    Ok(Undriven::new(
        rig,
        [q, 0.0],
        (size, size * TAU * natural_hz),
        1.0 / (24.0 * natural_hz),
    ))
}

/// The record.
///
/// # Errors
/// As [`DropTest::check`]; also if a parameter is out of range, or the hammer never reaches the surface.
pub fn record(params: &RigParams, test: &DropTest) -> Result<Vec<DropSample>, Error> {
    test.check()?;
    let rig = Rig::<f64>::new(params)?;
    let courses = impacts(params, &rig, test.release_m, test.impacts)?;
    let Some(last) = courses.last() else {
        return Err(DropTestError::NoContact.into());
    };
    let until = last.contact.onset_s + last.contact.duration_s + AFTER_S;
    let count = until * test.sampling_hz;
    if count > MOST_SAMPLES {
        return Err(DropTestError::Samples {
            count,
            most: MOST_SAMPLES,
        }
        .into());
    }
    let pieces = pieces(params, &rig, test.release_m, until)?;
    let mut noise = Noise::new(test.seed);
    let rate = 1.0 + 0.01 * test.clock_fast_percent;
    let sampling_hz = test.sampling_hz * rate;
    let modulated = test.converter == Converter::DeltaSigma;
    let steps = if modulated {
        MODULATOR_STEPS
    } else {
        FILTER_STEPS
    };
    let mut filter = (test.filter_hz > 0.0)
        .then(|| LowPass::butterworth(test.filter_hz, 1.0 / (sampling_hz * steps as f64)));
    let mut converter = Sum::new(test.converter.weights());
    let zeros = zeros(test, until);
    let mut at = 0;
    let mut stepped_at = 0;
    let rows = (0..=count as usize).map(|i| {
        let shown_s = i as f64 / test.sampling_hz;
        let time_s = shown_s / rate;
        while at + 1 < pieces.len() && pieces[at].end_s() < time_s {
            at += 1;
        }
        let (q, v) = pieces[at].at(time_s);
        let force = pieces[at].force(&rig, time_s);
        let kinematics = rig.kinematics(q, v);
        let acceleration = rig.acceleration(&kinematics, v, 0.0, force);
        let mut seen = force + ringing(test, &courses, time_s);
        if filter.is_some() || modulated {
            for step in (i * steps).saturating_sub(steps - 1)..=i * steps {
                let time_s = step as f64 / (sampling_hz * steps as f64);
                while stepped_at + 1 < pieces.len() && pieces[stepped_at].end_s() < time_s {
                    stepped_at += 1;
                }
                seen = pieces[stepped_at].force(&rig, time_s) + ringing(test, &courses, time_s);
                if let Some(filter) = &mut filter {
                    seen = filter.next(seen);
                }
                if modulated {
                    converter.take(seen);
                }
            }
        }
        let stepped = zeros.iter().filter(|(from_s, _)| *from_s <= time_s);
        let zero = test.offset_n + test.drift_n_per_s * time_s + stepped.map(|z| z.1).sum::<f64>();
        let gain = 1.0 + 0.01 * test.force_gain_percent;
        let disturb =
            |seen: f64, noise: &mut Noise| gain * seen + zero + test.noise_n * noise.sample();
        let shown = if modulated {
            disturb(converter.now(), &mut noise)
        } else {
            // The noise is the amplifier's.
            converter.take(disturb(seen, &mut noise));
            converter.now()
        };
        DropSample {
            time_s: shown_s,
            force_n: quantised(test, shown),
            displacement_mm: rig.relative_displacement(q)
                * 1e3
                * (1.0 + 0.01 * test.displacement_gain_percent),
            acceleration_m_per_s2: rig.penetration_acceleration(&kinematics, v, acceleration),
        }
    });
    Ok(rows.collect())
}

/// When the zero steps, and by how much, s and N.
fn zeros(test: &DropTest, until_s: f64) -> Vec<(f64, f64)> {
    if test.step_n == 0.0 {
        return Vec::new();
    }
    let mut drawn = Noise::new(test.seed ^ 0x57e9);
    let one = |i: usize| {
        let from_s = (i as f64 + drawn.even()) * STEP_EACH_S;
        let up = drawn.even() < 0.5;
        (from_s, if up { test.step_n } else { -test.step_n })
    };
    (0..(until_s / STEP_EACH_S).ceil() as usize)
        .map(one)
        .collect()
}

/// The whole motion until `until_s`.
fn pieces(
    params: &RigParams,
    rig: &Rig<f64>,
    release_m: f64,
    until_s: f64,
) -> Result<Vec<MotionPiece>, Error> {
    let mut hammer = released(params, rig, release_m)?;
    let mut track = Track::default();
    while hammer.now().t < until_s {
        hammer.advance(&mut track).ok_or(DropTestError::Lost)?;
        // A contact that lasts has no end to wait for.
        let touches = |piece: &MotionPiece| piece.mode == SwitchMode::Contact;
        if track.pieces.len() > 1_000_000 && track.pieces.last().is_some_and(touches) {
            break;
        }
    }
    Ok(track.pieces)
}

/// The surface's ringing: after each impact's largest force it swings about zero, falling first.
fn ringing(test: &DropTest, courses: &[Course], time_s: f64) -> f64 {
    if test.ringing_share == 0.0 {
        return 0.0;
    }
    let one = |course: &Course| {
        let since = time_s - course.contact.peak_at_s;
        // After forty time constants 4e-18 is left.
        if !(0.0..=40.0 * test.ringing_decay_s).contains(&since) {
            return 0.0;
        }
        let size = test.ringing_share * course.contact.peak_force_n;
        -size * (-since / test.ringing_decay_s).exp() * (TAU * test.ringing_hz * since).sin()
    };
    courses.iter().map(one).sum()
}

/// To the nearest code, and the range's ends where it is beyond.
fn quantised(test: &DropTest, force_n: f64) -> f64 {
    if test.bits == 0 {
        return force_n;
    }
    let step = 2.0 * test.full_scale_n / 2.0_f64.powi(test.bits as i32);
    let highest = test.full_scale_n - step;
    ((force_n / step).round() * step).clamp(-test.full_scale_n, highest)
}

#[cfg(test)]
mod tests {
    use super::*;
    use shared::model::params::{BEAM_170, WIRES};

    /// On wires at gap 0 the hammer is back after a quarter and then every half swing, and each contact takes the
    /// closed form's share of its speed.
    #[test]
    fn impacts_come_every_half_swing_and_fall_by_the_restitution() {
        let rig = Rig::new(&WIRES).unwrap();
        let courses = impacts(&WIRES, &rig, -3e-3, 4).unwrap();
        let half_swing = std::f64::consts::PI * (0.075_f64 / 9.81).sqrt();
        // In a swing of 3 mm on 75 mm the period is (1 + θ²/16) times that of a small one: 1.0001.
        assert!((courses[0].contact.onset_s / (0.5 * half_swing) - 1.0).abs() < 1.2e-4);
        let speed = 3e-3 * (9.81_f64 / 0.075).sqrt();
        let first = courses[0].contact.approach_speed_m_per_s;
        assert!((first / speed - 1.0).abs() < 1e-3, "{first} {speed}");
        for pair in courses.windows(2) {
            let ratio = pair[1].contact.peak_force_n / pair[0].contact.peak_force_n;
            // The restoring force in contact is 1e-5 of the surface's.
            assert!((ratio - 0.316902).abs() < 2e-4, "{ratio}");
            let apart = pair[1].contact.onset_s - pair[0].contact.onset_s;
            assert!((apart / half_swing - 1.0).abs() < 3e-3, "{apart}");
        }
    }

    #[test]
    fn the_record_holds_what_the_impacts_were() {
        let test = DropTest {
            sampling_hz: 200e3,
            impacts: 2,
            ..DropTest::default()
        };
        let rows = record(&BEAM_170, &test).unwrap();
        let rig = Rig::new(&BEAM_170).unwrap();
        let courses = impacts(&BEAM_170, &rig, -3e-3, 2).unwrap();
        let sum: f64 = rows.iter().map(|r| r.force_n).sum::<f64>() / 200e3;
        let impulse: f64 = courses.iter().map(|b| b.contact.impulse_n_s).sum();
        // A sum over samples misplaces an onset's jump by half a sample: 0.2 % of a contact.
        assert!((sum / impulse - 1.0).abs() < 4e-3, "{sum} {impulse}");
        assert_eq!(rows[0].displacement_mm, -3.0);
        // In contact the hammer's acceleration is −F/m, as in figure 3.8.
        let hardest = rows
            .iter()
            .max_by(|a, b| a.force_n.total_cmp(&b.force_n))
            .unwrap();
        let ratio = -hardest.acceleration_m_per_s2 * 0.298 / hardest.force_n;
        assert!((ratio - 1.0).abs() < 2e-3, "{ratio}");
    }

    #[test]
    fn noise_ringing_and_bits_are_what_was_asked_for() {
        let clean = DropTest {
            impacts: 1,
            ..DropTest::default()
        };
        let of = |test: DropTest| record(&WIRES, &test).unwrap();
        let (plain, noisy) = (
            of(clean),
            of(DropTest {
                noise_n: 0.2,
                ..clean
            }),
        );
        let off = plain.iter().zip(&noisy).map(|(a, b)| b.force_n - a.force_n);
        let square: f64 = off.map(|x| x * x).sum::<f64>() / plain.len() as f64;
        // Of some 8000 samples the deviation is known to 0.8 %.
        assert!((square.sqrt() / 0.2 - 1.0).abs() < 0.04, "{square}");
        let coarse = of(DropTest { bits: 8, ..clean });
        let step = 200.0 / 256.0;
        assert!(coarse.iter().all(|r| (r.force_n / step).fract() == 0.0));
        let ringing = of(DropTest {
            ringing_share: 0.5,
            ..clean
        });
        let peak = plain.iter().fold(0.0_f64, |m, r| m.max(r.force_n));
        let lowest = ringing.iter().fold(0.0_f64, |m, r| m.min(r.force_n));
        // After release the ringing alone is left: below zero by less than half the peak.
        assert!(lowest < -0.3 * peak && lowest > -0.5 * peak, "{lowest}");
    }

    #[test]
    fn what_cannot_strike_is_refused() {
        let rig = Rig::new(&WIRES).unwrap();
        assert!(impacts(&WIRES, &rig, 0.0, 1).is_err());
        assert!(impacts(&WIRES, &rig, -0.08, 1).is_err());
        let wide = RigParams {
            gap_m: 3.5e-3,
            ..WIRES
        };
        assert!(record(&wide, &DropTest::default()).is_err());
    }
}
