//! Contacts on the force signal.
//!
//! A contact begins where the force rises through [`Detection::on_n`] and ends once it has stayed below
//! [`Detection::off_n`] for [`Detection::refractory_s`]. The surface rings at about 3 kHz after the blow, so
//! one contact shows several peaks a third of a millisecond apart; each one restarts the refractory time
//! and none is a contact of its own.
//!
//! **What merges.** Two contacts are counted as one if the force between them does not stay below `off_n`
//! for the whole refractory time: with a ringing of half the peak that has decayed within 2 ms, contacts
//! whose onsets lie further apart than about 2 ms plus the refractory time are told apart, nearer ones are
//! not. A contact whose force never reaches `on_n` is not seen at all. So chatter is counted down to hops of
//! that length, and its end (sticking, at a force of tenths of a newton) is not seen.
//!
//! A single sample above the threshold whose successor is below `off_n` is a disturbance of the wire, not a
//! contact: the anti-alias filter lets no blow be that short. Such samples are counted.

use crate::settings::Detection;

/// Samples before the crossing that belong to the pulse: the filter's slope.
const LEAD: usize = 3;

/// Samples after the last fall through `off_n` that still belong to it.
const TAIL: u32 = 2;

/// Longest stay counted, ticks (0.2 s): one that lasts longer is reported then, as it is.
const LONGEST: u32 = 4_000;

/// A contact on the force signal, times in ticks relative to the sample that crossed the threshold.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Blow {
    /// From that sample back to the crossing, 0 to 1 tick.
    pub crossed_before: f32,
    /// From that sample to the end of its refractory time, ticks.
    pub age: u32,
    /// Largest sample, N.
    pub peak_n: f32,
    /// Sum of the samples, N.
    pub sum_n: f32,
    /// Sum of samples times their distance from the crossing sample, N · ticks.
    pub moment_n: f32,
    /// First fall through the lower threshold, ticks.
    pub first_fall: f32,
    /// Last fall through it, ticks.
    pub last_fall: u32,
}

/// What a sample did.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Edge {
    /// Nothing.
    None,
    /// A contact has begun: the sample before this one crossed the threshold and this one confirms it.
    Began {
        /// From the crossing to this sample, 1 to 2 ticks.
        ago: f32,
    },
    /// A contact has ended.
    Ended(Blow),
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Phase {
    Quiet,
    /// One sample above the threshold, waiting for the next to confirm.
    Doubtful(Blow),
    Open(Open),
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Open {
    blow: Blow,
    fallen: bool,
    /// Sum and moment since the last fall, which count only if the force rises again.
    pending: (f32, f32),
    low: u32,
}

/// Finds contacts, one sample at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PulseDetector {
    on_n: f32,
    off_n: f32,
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
    pub fn tick(&mut self, force_n: f32) -> Edge {
        let edge = match &mut self.phase {
            Phase::Quiet => {
                let [_, _, before] = self.lead;
                if force_n >= self.on_n && before < self.on_n {
                    self.phase = Phase::Doubtful(self.rise(before, force_n));
                }
                Edge::None
            }
            Phase::Doubtful(blow) => {
                if force_n < self.off_n {
                    self.glitches = self.glitches.wrapping_add(1);
                    self.phase = Phase::Quiet;
                    Edge::None
                } else {
                    let ago = 1.0 + blow.crossed_before;
                    let mut open = Open {
                        blow: *blow,
                        fallen: false,
                        pending: (0.0, 0.0),
                        low: 0,
                    };
                    open.follow(force_n, self.off_n, force_n);
                    self.phase = Phase::Open(open);
                    Edge::Began { ago }
                }
            }
            Phase::Open(open) => {
                let [_, _, before] = self.lead;
                open.follow(force_n, self.off_n, before);
                if open.low >= self.refractory || open.blow.age >= LONGEST {
                    let blow = open.blow;
                    self.phase = Phase::Quiet;
                    Edge::Ended(blow)
                } else {
                    Edge::None
                }
            }
        };
        let [_, second, third] = self.lead;
        self.lead = [second, third, force_n];
        edge
    }

    fn rise(&self, before: f32, force_n: f32) -> Blow {
        let [first, second, third] = self.lead;
        Blow {
            crossed_before: (force_n - self.on_n) / (force_n - before),
            age: 0,
            peak_n: force_n,
            sum_n: force_n + first + second + third,
            moment_n: -(3.0 * first + 2.0 * second + third),
            first_fall: 0.0,
            last_fall: 0,
        }
    }
}

impl Open {
    fn follow(&mut self, force_n: f32, off_n: f32, before: f32) {
        let blow = &mut self.blow;
        blow.age += 1;
        let age = blow.age as f32;
        if force_n > blow.peak_n {
            blow.peak_n = force_n;
        }
        let (sum, moment) = self.pending;
        let (sum, moment) = (sum + force_n, moment + age * force_n);
        if force_n >= off_n {
            self.low = 0;
        } else {
            if self.low == 0 {
                blow.last_fall = blow.age;
                if !self.fallen {
                    self.fallen = true;
                    let drop = before - force_n;
                    let past = if drop > 0.0 {
                        (off_n - force_n) / drop
                    } else {
                        0.0
                    };
                    blow.first_fall = age - past;
                }
            }
            self.low += 1;
        }
        if self.low <= TAIL {
            blow.sum_n += sum;
            blow.moment_n += moment;
            self.pending = (0.0, 0.0);
        } else {
            self.pending = (sum, moment);
        }
    }
}
