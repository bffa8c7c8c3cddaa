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
    /// No contact begins or ends with this sample.
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
mod tests;
