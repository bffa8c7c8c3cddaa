//! Contacts on the force signal.
//!
//! A contact begins where the force rises through [`Detection::on_n`] and ends once it has stayed below
//! [`Detection::off_n`] for [`Detection::refractory_s`]. The surface rings at about 3 kHz after a contact, so
//! one contact shows several peaks a third of a millisecond apart; each one restarts the refractory time
//! and none is a contact of its own.
//!
//! **What merges.** Two contacts are counted as one if the force between them does not stay below `off_n`
//! for the whole refractory time: with a ringing of half the peak that has decayed within 2 ms, contacts
//! whose onsets lie further apart than about 2 ms plus the refractory time are counted separately, nearer ones
//! are not. A contact whose force never reaches `on_n` is not detected. So chatter is counted down to hops of
//! that length, and its end (sticking, at a force of tenths of a newton) is not detected.
//!
//! A single sample above the threshold whose successor is below `off_n` is electrical interference: behind the
//! anti-alias filter no contact is that short. Such samples are counted ([`PulseDetector::glitches`]).

use crate::settings::Detection;

/// Samples before the crossing that belong to the pulse: the filter's slope.
const LEAD: usize = 3;

/// Samples after the last fall through `off_n` that still belong to it.
const TAIL: u32 = 2;

/// Ticks after which filter and notch have left the onset behind.
const SETTLED: u32 = 4;

/// Longest contact, ticks (0.2 s): one that lasts longer is reported then, as if it had ended.
const LONGEST: u32 = 4_000;

/// A contact on the force signal, times in ticks relative to the sample that crossed the threshold.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RawPulse {
    /// From that sample back to the crossing, 0 to 1 tick.
    pub crossed_before: f32,
    /// From that sample to the end of its refractory time, ticks.
    pub age: u32,
    /// Largest sample, N.
    pub peak_n: f32,
    /// Sum of the samples, N.
    pub sum_n: f32,
    /// First fall of the force without its ringing below the upper threshold, ticks.
    pub first_fall: f32,
    /// Last fall of the force below the lower threshold, ticks.
    pub last_fall: u32,
}

/// Takes the surface's ringing out of the force: y(k) = (f(k) − 2 cos α f(k−1) + f(k−2))/(2 − 2 cos α), α the
/// angle that the ringing turns in a tick. Zero gain at that frequency, one at 0 Hz, a delay of one tick;
/// white noise grows 2.2-fold.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Notch {
    outer: f32,
    inner: f32,
}

/// The surface's ringing, Hz.
pub const RINGING_HZ: f64 = 3_000.0;

impl Notch {
    fn new(tick_s: f32) -> Self {
        let cos = libm::cos(core::f64::consts::TAU * RINGING_HZ * f64::from(tick_s));
        let outer = 1.0 / (2.0 - 2.0 * cos);
        Self {
            outer: outer as f32,
            inner: (-2.0 * cos * outer) as f32,
        }
    }

    #[inline]
    fn of(&self, newest: f32, middle: f32, oldest: f32) -> f32 {
        self.outer * (newest + oldest) + self.inner * middle
    }
}

/// The effect of a sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PulseEdge {
    /// Nothing.
    None,
    /// A contact has begun: the sample before this one crossed the threshold and this one confirms it.
    Began {
        /// From the crossing to this sample, 1 to 2 ticks.
        ago: f32,
    },
    /// A contact has ended.
    Ended(RawPulse),
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Phase {
    Quiet,
    /// One sample above the threshold, waiting for the next to confirm.
    Doubtful(RawPulse),
    Open(OpenPulse),
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct OpenPulse {
    raw: RawPulse,
    /// Last value of the force without ringing, N; none once it has fallen.
    notched: Option<f32>,
    /// Sum since the last fall, which counts only if the force rises again.
    pending: f32,
    low: u32,
}

/// Finds contacts, one sample at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PulseDetector {
    on_n: f32,
    off_n: f32,
    notch: Notch,
    refractory: u32,
    lead: [f32; LEAD],
    phase: Phase,
    glitches: u32,
}

impl PulseDetector {
    /// A detector for samples `tick_s` seconds apart.
    pub fn new(detection: &Detection, tick_s: f32) -> Self {
        Self {
            on_n: detection.on_n,
            off_n: detection.off_n,
            notch: Notch::new(tick_s),
            refractory: (detection.refractory_s / tick_s + 0.5) as u32,
            lead: [0.0; LEAD],
            phase: Phase::Quiet,
            glitches: 0,
        }
    }

    /// Forgets the past, but not the count of disturbances.
    pub fn reset(&mut self) {
        self.lead = [0.0; LEAD];
        self.phase = Phase::Quiet;
    }

    /// Single samples above the threshold that were no contacts.
    pub fn glitches(&self) -> u32 {
        self.glitches
    }

    /// Whether a contact is being followed (its refractory time included).
    #[inline]
    pub fn is_open(&self) -> bool {
        !matches!(self.phase, Phase::Quiet)
    }

    /// The next sample of the force, N.
    #[inline]
    pub fn tick(&mut self, force_n: f32) -> PulseEdge {
        let edge = match &mut self.phase {
            Phase::Quiet => {
                let [_, _, before] = self.lead;
                if force_n >= self.on_n && before < self.on_n {
                    self.phase = Phase::Doubtful(self.rise(before, force_n));
                }
                PulseEdge::None
            }
            Phase::Doubtful(raw) => {
                if force_n < self.off_n {
                    self.glitches = self.glitches.wrapping_add(1);
                    self.phase = Phase::Quiet;
                    PulseEdge::None
                } else {
                    let ago = 1.0 + raw.crossed_before;
                    let mut open = OpenPulse {
                        raw: *raw,
                        notched: Some(force_n),
                        pending: 0.0,
                        low: 0,
                    };
                    open.follow(force_n, self.off_n);
                    self.phase = Phase::Open(open);
                    PulseEdge::Began { ago }
                }
            }
            Phase::Open(open) => {
                let [_, older, before] = self.lead;
                open.follow(force_n, self.off_n);
                open.fall(self.notch.of(force_n, before, older), self.on_n);
                if open.low >= self.refractory || open.raw.age >= LONGEST {
                    let raw = open.raw;
                    self.phase = Phase::Quiet;
                    PulseEdge::Ended(raw)
                } else {
                    PulseEdge::None
                }
            }
        };
        let [_, second, third] = self.lead;
        self.lead = [second, third, force_n];
        edge
    }

    fn rise(&self, before: f32, force_n: f32) -> RawPulse {
        let [first, second, third] = self.lead;
        RawPulse {
            crossed_before: (force_n - self.on_n) / (force_n - before),
            age: 0,
            peak_n: force_n,
            sum_n: force_n + first + second + third,
            first_fall: 0.0,
            last_fall: 0,
        }
    }
}

impl OpenPulse {
    fn follow(&mut self, force_n: f32, off_n: f32) {
        let raw = &mut self.raw;
        raw.age += 1;
        if force_n > raw.peak_n {
            raw.peak_n = force_n;
        }
        self.pending += force_n;
        if force_n >= off_n {
            self.low = 0;
        } else {
            if self.low == 0 {
                raw.last_fall = raw.age;
            }
            self.low += 1;
        }
        if self.low <= TAIL {
            raw.sum_n += self.pending;
            self.pending = 0.0;
        }
    }

    /// Notes the first fall of the force without ringing, `notched`, which is a tick late.
    fn fall(&mut self, notched: f32, on_n: f32) {
        if self.raw.age < SETTLED {
            return;
        }
        if let Some(before) = self.notched {
            if notched < on_n {
                let drop = before - notched;
                let past = if drop > 0.0 {
                    (on_n - notched) / drop
                } else {
                    0.0
                };
                let past = if past < 1.0 { past } else { 1.0 };
                self.raw.first_fall = self.raw.age as f32 - 1.0 - past;
                self.notched = None;
            } else {
                self.notched = Some(notched);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    const DETECTION: Detection = Detection {
        on_n: 14.0,
        off_n: 7.0,
        refractory_s: 1.5e-3,
    };

    /// A contact of Table 3.1 at 0.08 m/s, as a half sine of 96 N and 0.57 ms from sample `at`, with ringing of a share of
    /// it at 3 kHz that decays with 1 ms.
    fn contact(signal: &mut [f32], at: usize, peak_n: f32, ringing: f32) {
        for (k, value) in signal.iter_mut().skip(at).enumerate() {
            let t = k as f32 * 50e-6;
            if t < 0.57e-3 {
                *value += peak_n * libm::sinf(core::f32::consts::PI * t / 0.57e-3);
            }
            let wave = libm::sinf(core::f32::consts::TAU * 3_000.0 * t);
            *value += ringing * peak_n * libm::expf(-t / 1e-3) * wave;
        }
    }

    fn detect(signal: &[f32]) -> (Vec<RawPulse>, u32) {
        let mut detector = PulseDetector::new(&DETECTION, 50e-6);
        let mut began = 0;
        let mut pulses = Vec::new();
        for sample in signal {
            match detector.tick(*sample) {
                PulseEdge::None => {}
                PulseEdge::Began { ago } => {
                    assert!((1.0..=2.0).contains(&ago), "{ago}");
                    began += 1;
                }
                PulseEdge::Ended(raw) => pulses.push(raw),
            }
        }
        assert_eq!(began, pulses.len());
        (pulses, detector.glitches())
    }

    #[test]
    fn a_ringing_contact_is_one_and_keeps_its_duration() {
        let above = |ringing: f32| {
            let mut signal = [0.0; 400];
            contact(&mut signal, 50, 96.0, ringing);
            let (pulses, _) = detect(&signal);
            assert_eq!(pulses.len(), 1);
            pulses[0].first_fall + pulses[0].crossed_before
        };
        let plain = above(0.0);
        for ringing in [0.5, -0.2] {
            let rung = above(ringing);
            assert!((rung - plain).abs() < 0.7, "{ringing}: {rung} {plain}");
        }
    }

    #[test]
    fn what_merges_and_what_does_not() {
        // Onsets 6 ms apart: ringing below 7 N after 2 ms, then the refractory time.
        for (apart, expected) in [(120, 2), (90, 2), (40, 1), (15, 1)] {
            let mut signal = [0.0; 600];
            contact(&mut signal, 50, 96.0, 0.5);
            contact(&mut signal, 50 + apart, 60.0, 0.5);
            assert_eq!(detect(&signal).0.len(), expected, "{apart}");
        }
    }

    #[test]
    fn chatter_counts_down_to_hops_of_the_refractory_time() {
        // Ten contacts, each hop 0.8 of the one before, from 30 ms on.
        let mut signal = [0.0; 4_000];
        let (mut at, mut hop, mut peak, mut apart) = (100.0_f32, 600.0_f32, 96.0_f32, 0);
        for _ in 0..12 {
            contact(&mut signal, at as usize, peak, 0.5);
            apart += usize::from(peak >= 20.0);
            at += hop;
            hop *= 0.8;
            peak *= 0.8;
        }
        // Peaks from 20 N on are seen, all of them more than 5 ms apart.
        let (pulses, _) = detect(&signal);
        assert!(
            pulses.len() >= apart && pulses.len() <= apart + 2,
            "{}",
            pulses.len()
        );
    }

    #[test]
    fn a_lone_sample_is_a_disturbance() {
        let mut signal = [0.0; 400];
        signal[50] = 80.0;
        signal[200] = 80.0;
        assert_eq!(detect(&signal), (Vec::new(), 2));
    }

    #[test]
    fn impulse_is_the_sum_from_before_the_crossing_to_after_the_last_fall() {
        let mut signal = [0.0; 400];
        for (k, value) in signal.iter_mut().skip(50).take(12).enumerate() {
            *value = 50.0 * libm::sinf(core::f32::consts::PI * (k as f32 + 0.5) / 12.0);
        }
        let (pulses, _) = detect(&signal);
        let whole: f32 = signal.iter().sum();
        assert!((pulses[0].sum_n / whole - 1.0).abs() < 1e-5);
        assert_eq!(pulses[0].peak_n, signal.iter().copied().fold(0.0, f32::max));
    }

    #[test]
    fn a_force_that_stays_or_is_no_number_ends_nothing_early_and_breaks_nothing() {
        let mut detector = PulseDetector::new(&DETECTION, 50e-6);
        let ended = (0..2 * LONGEST).filter(|_| matches!(detector.tick(30.0), PulseEdge::Ended(_)));
        assert_eq!(ended.count(), 1);
        for _ in 0..100 {
            assert!(!matches!(detector.tick(f32::NAN), PulseEdge::Ended(_)));
        }
    }
}
