//! The force sensor as the fit has it: a gain, a zero, a clock, a filter, and the surface's ringing after each contact.
//!
//! What the filter is, is nowhere else: a [`FilterKind`] says what is sought of it and where, a [`Filter`] is one found.

use std::f64::consts::{FRAC_1_SQRT_2, TAU};

use serde::Serialize;
use shared::model::rig::Rig;

use crate::contact_law::undriven::Course;
use crate::low_pass::{self, FilterState, FilterStep};

/// Steps in a contact at least.
const STEPS: f64 = 100.0;

/// An analog filter of a shorter time constant, in samples, leaves the onset a jump.
const SHARP: f64 = 0.4;

/// An analog filter of a longer time constant, in samples, is told from none.
const BLURRED: f64 = 0.7;

/// How uncertain a filter's damping ratio is (standard deviation), about Butterworth's 1/√2.
const DAMPING_DEVIATION: f64 = 0.1;

/// The shape of a linear-phase filter's window before the record is seen, and its deviation: Hamming's is near 5, a mean's 0.
const WINDOW_SHAPE: (f64, f64) = (4.0, 4.0);

/// Cells of a linear-phase filter's kernel in half its length.
const CELLS: usize = 512;

/// A kind of filter between the force and the samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum FilterKind {
    /// A low-pass of second order before the force is sampled, or none
    Analog,
    /// A low-pass of second order applied to the samples
    Digital,
    /// A linear-phase low-pass before the samples are taken, as in a delta-sigma converter
    LinearPhase,
    /// An odd number of samples, weighed alike on both sides of the middle (a mean of three)
    OddSamples,
    /// An even number of them
    EvenSamples,
}

impl FilterKind {
    /// Those that are tried where an analog filter leaves more than noise.
    pub const OTHERS: [Self; 4] = [
        Self::Digital,
        Self::OddSamples,
        Self::LinearPhase,
        Self::EvenSamples,
    ];

    /// How many numbers make the filter: time constant in samples and damping ratio; or corner in cycles a sample, half the
    /// length in samples and the shape of Kaiser's window.
    pub fn unknowns(self) -> usize {
        if self.of_second_order() { 2 } else { 3 }
    }

    /// Whether the filter is a low-pass of second order.
    pub fn of_second_order(self) -> bool {
        matches!(self, Self::Analog | Self::Digital)
    }

    /// The range of an unknown; the first impact's window has so many samples.
    pub fn range(self, k: usize, window: f64) -> (f64, f64) {
        match (self, k) {
            (Self::Analog, 0) => (0.0, 0.2 * window),
            // Up to 0.48 of the sampling rate.
            (Self::Digital, 0) => (0.33, 0.2 * window),
            (Self::Analog | Self::Digital, _) => (0.3, 0.98),
            (_, 0) => (0.0, 0.7),
            (_, 1) => (0.6, 40.0),
            _ => (0.0, 12.0),
        }
    }

    /// What is known beforehand of the last unknown: mean and deviation.
    pub fn known(self) -> (f64, f64) {
        if self.of_second_order() {
            (FRAC_1_SQRT_2, DAMPING_DEVIATION)
        } else {
            WINDOW_SHAPE
        }
    }

    /// Where the searches begin: the first are for the first guess of the law, the last is for all other guesses.
    pub fn starts(self) -> &'static [&'static [f64]] {
        match self {
            Self::Analog => &[
                &[0.0, FRAC_1_SQRT_2],
                &[0.8, FRAC_1_SQRT_2],
                &[2.5, FRAC_1_SQRT_2],
                &[0.5, FRAC_1_SQRT_2],
            ],
            Self::Digital => &[
                &[0.5, FRAC_1_SQRT_2],
                &[0.8, FRAC_1_SQRT_2],
                &[2.5, FRAC_1_SQRT_2],
            ],
            _ => &[
                &[0.02, 1.7, 1.0],
                &[0.02, 2.7, 1.0],
                &[0.1, 12.0, 5.0],
                &[0.2, 12.0, 5.0],
                &[0.2, 20.0, 5.0],
                &[0.45, 20.0, 5.0],
            ],
        }
    }

    /// Whether the onset of a force that jumps is a jump in the samples.
    pub fn jumps(self, first: f64) -> bool {
        match self {
            Self::Analog => first <= SHARP,
            Self::LinearPhase => false,
            _ => true,
        }
    }

    /// Whether the record shows an analog filter: if not, filter and onsets make up for each other.
    pub fn shows(self, first: f64) -> bool {
        self != Self::Analog || first > BLURRED
    }

    /// How many samples before the force it may begin to show.
    pub fn leads(self, filter: &[f64]) -> f64 {
        if self.of_second_order() {
            0.0
        } else {
            filter[1]
        }
    }
}

/// A damped swing after each contact's largest force, over that force: the real and the imaginary part of
/// exp(−t/τ + 2πift) are two swings a quarter turn apart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Swing {
    /// Size of the real part.
    pub cos: f64,
    /// Size of the imaginary part.
    pub sin: f64,
    /// Frequency f, Hz.
    pub hz: f64,
    /// Time constant τ of its decay, s.
    pub decay_s: f64,
}

/// How the sensor shows a contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SensorModel {
    /// What it shows over what there is.
    pub gain: f64,
    /// What it shows without force, N.
    pub offset_n: f64,
    /// A second over what its clock makes of one.
    pub clock: f64,
    /// Kind of the filter.
    pub model: FilterKind,
    /// The filter's numbers, as [`FilterKind::unknowns`] lists them; the rest is 0.
    pub filter: [f64; 3],
    /// The surface's ringing; none where it is not sought.
    pub swing: Option<Swing>,
}

impl SensorModel {
    /// The filter's −3 dB corner, in cycles a sample; none: too fast to be seen in the samples.
    pub fn corner(&self) -> Option<f64> {
        let first = self.filter[0];
        match self.model {
            FilterKind::Analog | FilterKind::Digital => (first > 0.3).then(|| 1.0 / (TAU * first)),
            _ => {
                let taps = self.taps(1.0);
                let passed = |cycles: f64| {
                    let (re, im) = taps.iter().fold((0.0, 0.0), |(re, im), tap| {
                        let (sin, cos) = (TAU * cycles * tap.delay_s).sin_cos();
                        (re + tap.weight * cos, im + tap.weight * sin)
                    });
                    f64::hypot(re, im)
                };
                let tried = (1..=100).map(|i| 0.005 * f64::from(i));
                tried.clone().find(|c| passed(*c) < FRAC_1_SQRT_2)
            }
        }
    }

    /// The filter as weights of forces that were so long ago, in order of the delay.
    fn taps(&self, sample_s: f64) -> Vec<Tap> {
        let [first, second, shape] = self.filter;
        let tap = |(delay, weight): (f64, f64)| Tap {
            delay_s: delay * sample_s,
            weight,
        };
        let shared = |delays: Vec<f64>, middle: f64| -> Vec<Tap> {
            let weigh = |d: &f64| kernel(first, second, shape, (d - middle) / second);
            let weights: Vec<f64> = delays.iter().map(weigh).collect();
            let sum: f64 = weights.iter().sum();
            let pairs = delays.into_iter().zip(weights.iter().map(|w| w / sum));
            pairs.map(tap).collect()
        };
        let far = second.ceil() as i32;
        match self.model {
            FilterKind::Analog => Vec::new(),
            FilterKind::Digital => {
                let passed = low_pass::digital(1.0 / (TAU * first), second);
                passed
                    .enumerate()
                    .map(|(i, w)| tap((i as f64, w)))
                    .collect()
            }
            FilterKind::OddSamples => shared((-far..=far).map(f64::from).collect(), 0.0),
            FilterKind::EvenSamples => shared((-far..=far + 1).map(f64::from).collect(), 0.5),
            FilterKind::LinearPhase => {
                // An eighth of a sample is short enough for the ringing, which does not jump.
                let cells = 8 * far;
                shared((-cells..=cells).map(|i| f64::from(i) / 8.0).collect(), 0.0)
            }
        }
    }
}

/// The kernel of a linear-phase low-pass with its corner at so many cycles a sample, half as long as so many samples, under
/// Kaiser's window of this shape; `at`: from −1 to 1 over its length.
fn kernel(corner: f64, half: f64, shape: f64, at: f64) -> f64 {
    if at.abs() >= 1.0 {
        return 0.0;
    }
    let turn = TAU * corner * half * at;
    let sinc = if turn.abs() < 1e-6 {
        1.0
    } else {
        turn.sin() / turn
    };
    sinc * bessel(shape * (1.0 - at * at).sqrt())
}

/// The modified Bessel function I₀.
fn bessel(x: f64) -> f64 {
    let square = 0.25 * x * x;
    let (mut sum, mut term, mut k) = (1.0, 1.0, 1.0);
    while term > 1e-12 * sum {
        term *= square / (k * k);
        sum += term;
        k += 1.0;
    }
    sum
}

/// A force that counts after a delay.
struct Tap {
    delay_s: f64,
    weight: f64,
}

/// How a filter makes its output of the force.
enum By {
    /// It shows the force as it is.
    Nothing,
    /// By its state at each step.
    States {
        filter_s: f64,
        damping: f64,
        states: Vec<FilterState>,
    },
    /// By forces some samples apart.
    Samples,
    /// By the whole course: the kernel's integral from its middle on, over half of its length.
    Course { half_s: f64, integral: Vec<f64> },
}

/// A contact as the filter shows it.
pub struct FilteredPulse<'a> {
    rig: &'a Rig<f64>,
    course: &'a Course,
    step_s: f64,
    /// The force at each step; empty without a filter.
    forces: Vec<f64>,
    by: By,
    taps: Vec<Tap>,
    /// What the taps up to each make of the ringing at the instant of its beginning.
    rung: Vec<[f64; 2]>,
}

impl<'a> FilteredPulse<'a> {
    /// Of `course`, sampled every `sample_s`.
    pub fn new(rig: &'a Rig<f64>, course: &'a Course, sensor: &SensorModel, sample_s: f64) -> Self {
        let sample_s = sensor.clock * sample_s;
        let duration = course.contact.duration_s;
        let count = (duration / (0.25 * sample_s)).clamp(STEPS, 1e5).ceil();
        let mut pulse = Self {
            rig,
            course,
            step_s: duration / count,
            forces: Vec::new(),
            by: By::Nothing,
            taps: sensor.taps(sample_s),
            rung: Vec::new(),
        };
        let [first, second, shape] = sensor.filter;
        if sensor.model == FilterKind::Analog && first <= 1e-3 {
            return pulse;
        }
        let at = |i: usize| course.force(rig, (i as f64 * pulse.step_s).min(duration));
        pulse.forces = (0..=count as usize).map(at).collect();
        if let Some(swing) = sensor.swing {
            let mut sum = [0.0; 2];
            pulse.rung = pulse
                .taps
                .iter()
                .map(|tap| {
                    let [re, im] = swing.at(-tap.delay_s);
                    sum = [sum[0] + tap.weight * re, sum[1] + tap.weight * im];
                    sum
                })
                .collect();
        }
        pulse.by = match sensor.model {
            FilterKind::Analog => pulse.states(first * sample_s, second),
            FilterKind::LinearPhase => {
                let cell = |i: usize| kernel(first, second, shape, (i as f64 + 0.5) / CELLS as f64);
                let mut integral = vec![0.0];
                for i in 0..CELLS {
                    integral.push(integral[i] + cell(i));
                }
                let whole = 2.0 * integral[CELLS];
                integral.iter_mut().for_each(|g| *g /= whole);
                By::Course {
                    half_s: second * sample_s,
                    integral,
                }
            }
            _ => By::Samples,
        };
        pulse
    }

    fn states(&self, filter_s: f64, damping: f64) -> By {
        let step = FilterStep::new(damping, self.step_s / filter_s);
        let mut now = [0.0; 2];
        let mut states = vec![now];
        for pair in self.forces.windows(2) {
            now = step.advance(now, pair[0], pair[1]);
            states.push(now);
        }
        By::States {
            filter_s,
            damping,
            states,
        }
    }

    /// The force at `t` s from the onset, from those at the steps, N.
    fn between(&self, t: f64) -> f64 {
        let place = t / self.step_s;
        let at = place as usize;
        if place < 0.0 || at + 1 >= self.forces.len() {
            return 0.0;
        }
        let [a, b] = [self.forces[at], self.forces[at + 1]];
        a + (b - a) * (place - at as f64)
    }

    /// The filtered force `t` s after the onset, N.
    fn force(&self, t: f64) -> f64 {
        match &self.by {
            By::Nothing => self.course.force(self.rig, t),
            By::States {
                filter_s,
                damping,
                states,
            } => self.decayed(*filter_s, *damping, states, t),
            By::Samples => {
                let each = self.taps.iter();
                each.map(|tap| tap.weight * self.between(t - tap.delay_s))
                    .sum()
            }
            By::Course { half_s, integral } => {
                let passed = |t: f64| {
                    let place = (t.abs() / half_s * CELLS as f64).min(CELLS as f64);
                    let at = (place as usize).min(CELLS - 1);
                    let (a, b) = (integral[at], integral[at + 1]);
                    (a + (b - a) * (place - at as f64)).copysign(t)
                };
                let mut from = passed(t);
                let pieces = self.forces.windows(2).zip(1..);
                let piece = |(pair, i): (&[f64], i32)| {
                    let to = passed(t - f64::from(i) * self.step_s);
                    let share = from - to;
                    from = to;
                    0.5 * (pair[0] + pair[1]) * share
                };
                pieces.map(piece).sum()
            }
        }
    }

    fn decayed(&self, filter_s: f64, damping: f64, states: &[FilterState], t: f64) -> f64 {
        if t < 0.0 {
            return 0.0;
        }
        let last = states.len() - 1;
        let at = ((t / self.step_s) as usize).min(last);
        let (state, from) = (states[at], self.forces[at]);
        let rest = t - at as f64 * self.step_s;
        let phase = rest / filter_s;
        if phase < 1e-9 {
            return state[0];
        }
        let step = FilterStep::new(damping, phase);
        if at == last {
            // After the release the force is 0.
            return step.advance(state, 0.0, 0.0)[0];
        }
        let to = from + (self.forces[at + 1] - from) * rest / self.step_s;
        step.advance(state, from, to)[0]
    }

    /// The filtered ringing `t` s after the onset, N.
    fn ringing(&self, swing: &Swing, t: f64) -> f64 {
        let contact = &self.course.contact;
        let since = t - (contact.peak_at_s - contact.onset_s);
        if since > 40.0 * swing.decay_s {
            return 0.0;
        }
        let shown = match &self.by {
            By::Samples | By::Course { .. } => {
                let begun = self.taps.partition_point(|tap| tap.delay_s <= since);
                let Some(last) = begun.checked_sub(1) else {
                    return 0.0;
                };
                times(self.rung[last], swing.at(since))
            }
            _ if since < 0.0 => return 0.0,
            By::Nothing => swing.at(since),
            By::States {
                filter_s, damping, ..
            } => {
                // An exponential input exp(λt) passes with H(λ) = 1/(μ² + 2ζμ + 1), μ = λ/ωc, and the state (1, μ)H
                // decays.
                let mu = [-filter_s / swing.decay_s, TAU * swing.hz * filter_s];
                let square = times(mu, mu);
                let under = [
                    square[0] + 2.0 * damping * mu[0] + 1.0,
                    square[1] + 2.0 * damping * mu[1],
                ];
                let norm = under[0] * under[0] + under[1] * under[1];
                let passed = [under[0] / norm, -under[1] / norm];
                let [first, _] = FilterStep::new(*damping, since / filter_s).decay;
                let shown = swing.at(since);
                let left = [
                    shown[0] - first[0] - first[1] * mu[0],
                    shown[1] - first[1] * mu[1],
                ];
                times(passed, left)
            }
        };
        contact.peak_force_n * (swing.cos * shown[0] + swing.sin * shown[1])
    }

    /// What `sensor` shows `t` s after the onset, N.
    pub fn shown(&self, sensor: &SensorModel, t: f64) -> f64 {
        let t = sensor.clock * t;
        let ringing = sensor.swing.map_or(0.0, |swing| self.ringing(&swing, t));
        sensor.gain * (self.force(t) + ringing) + sensor.offset_n
    }
}

impl Swing {
    fn at(&self, t: f64) -> [f64; 2] {
        damped(t, self.hz, self.decay_s)
    }
}

/// Cosine and sine of a damped swing of size 1: real and imaginary part of exp(−t/τ + 2πift), `t` in s.
pub fn damped(t: f64, hz: f64, decay_s: f64) -> [f64; 2] {
    let (sin, cos) = (TAU * hz * t).sin_cos();
    let size = (-t / decay_s).exp();
    [size * cos, size * sin]
}

fn times(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0] * b[0] - a[1] * b[1], a[0] * b[1] + a[1] * b[0]]
}
