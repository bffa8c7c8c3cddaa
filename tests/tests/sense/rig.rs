//! A rig with real sensors: the reference's motion, sampled at 20 kHz as the board would see it.

use std::f64::consts::TAU;

use numerics::reference::{LocatedContact, Reference, Segment, TrajectoryObserver};
use shared::io::{AdcCode, Channel};
use shared::model::drive::Drive;
use shared::model::params::RigParams;
use shared::sense::Sample;
use shared::settings::{Settings, TICK_S};

/// Drive periods before the record: enough for every orbit tested to have settled.
const SETTLE: usize = 150;

/// Force samples per tick before the anti-alias filter.
const FINE: usize = 10;

/// How the surface rings after a blow, at 3 kHz, half the peak, decayed to 5 % in 2 ms.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Ring {
    None,
    /// Starts at its crest.
    Cosine,
    /// Starts at zero, rising.
    Sine,
    /// Starts at the contact's peak at zero, falling; time constant 2 ms.
    Late,
    /// A mode of the surface in series with the sensor, excited by the force itself; adds no net impulse.
    Mode,
}

/// What the sensors add.
#[derive(Clone, Copy)]
pub struct Sensors {
    /// Standard deviations: of the peak force, of A0, of the hammer's stroke.
    pub noise: f64,
    pub ring: Ring,
    /// The force signal of this contact is lost (an index into the true contacts).
    pub dropped: Option<usize>,
    /// Lag of the cart behind the command, rad.
    pub lag: f64,
    pub seed: u64,
}

/// 2 % noise everywhere, the surface rings, the cart lags.
pub const REAL: Sensors = Sensors {
    noise: 0.02,
    ring: Ring::Late,
    dropped: None,
    lag: 0.3,
    seed: 1,
};

/// What happened, and what the sensors made of it.
pub struct Recording {
    pub drive: Drive<f32>,
    pub samples: Vec<Sample>,
    pub contacts: Vec<LocatedContact>,
}

#[derive(Default)]
struct Watch {
    frequency_hz: f64,
    start_cycle: f64,
    shift_s: f64,
    relative: Vec<f64>,
    force: Vec<(usize, f64)>,
    contacts: Vec<LocatedContact>,
}

impl TrajectoryObserver for Watch {
    fn segment(&mut self, segment: &Segment) {
        let origin = (segment.cycle as f64 - self.start_cycle) / self.frequency_hz + self.shift_s;
        let (start, end) = (segment.start.t, segment.end.t);
        loop {
            let t = self.relative.len() as f64 * TICK_S - origin;
            if t >= end {
                break;
            }
            let (q, _) = segment.at(t.max(start));
            self.relative.push(segment.rig.relative_displacement(q));
        }
        if segment.mode == shared::model::rig::SwitchMode::Contact {
            let fine = TICK_S / FINE as f64;
            let mut k = ((start + origin) / fine - 0.5).ceil().max(0.0);
            while (k + 0.5) * fine < end + origin {
                let (q, v) = segment.at((k + 0.5) * fine - origin);
                self.force.push((k as usize, segment.force(q, v)));
                k += 1.0;
            }
        }
    }

    fn contact(&mut self, contact: &LocatedContact) {
        let onset_s = contact.onset_s + self.shift_s - self.start_cycle / self.frequency_hz;
        if onset_s > 0.0 {
            self.contacts.push(LocatedContact {
                onset_s,
                // From the onset on, here.
                peak_at_s: contact.peak_at_s - contact.onset_s,
                ..*contact
            });
        }
    }
}

/// Lets the rig settle, then records `periods` drive periods.
pub fn record(
    rig: &RigParams,
    settings: &Settings,
    ratio: f64,
    periods: usize,
    sensors: &Sensors,
) -> Recording {
    let wanted = ratio * rig.natural_frequency_hz();
    let drive = Drive::<f32>::new(wanted, TICK_S).unwrap();
    let frequency_hz = drive.frequency_hz();
    let mut reference = Reference::<f64>::at_rest(rig, frequency_hz).unwrap();
    for _ in 0..SETTLE {
        reference.run_period(&mut ());
    }
    let mut watch = Watch {
        frequency_hz,
        start_cycle: reference.cycle() as f64,
        // A period earlier, so that the first sample, by the lag before phase 0, is recorded, too.
        shift_s: (sensors.lag / TAU - 1.0) / frequency_hz,
        ..Watch::default()
    };
    for _ in 0..=periods {
        reference.run_period(&mut watch);
    }
    sense(rig, settings, drive, watch, sensors)
}

fn sense(
    rig: &RigParams,
    settings: &Settings,
    drive: Drive<f32>,
    watch: Watch,
    sensors: &Sensors,
) -> Recording {
    let peak = |f: fn(f64, f64) -> f64, from| watch.relative.iter().copied().fold(from, f);
    let stroke_m = peak(f64::max, -1.0) - peak(f64::min, 1.0);
    let peaks = watch.contacts.iter().map(|c| c.peak_force_n);
    let peak_n = peaks.fold(0.0, f64::max);
    let force = force_signal(&watch, sensors);
    let mut dice = Dice(sensors.seed);
    let omega = TAU * watch.frequency_hz;
    let ticks = watch.relative.len();
    let samples = (0..ticks).map(|k| {
        let amplitude = rig.amplitude_m;
        let y = amplitude * (omega * (k as f64 * TICK_S - watch.shift_s)).sin();
        let x = y + watch.relative[k];
        let noise = sensors.noise;
        let read = |channel: &Channel, value: f64| {
            let code = value / f64::from(channel.unit_per_code) + f64::from(channel.zero_code);
            channel.value(AdcCode(code.round().clamp(0.0, 4095.0) as u16))
        };
        Sample {
            force_n: read(&settings.force, force[k] + noise * peak_n * dice.normal()),
            hammer_m: read(&settings.hammer, x + noise * stroke_m * dice.normal()),
            cart_m: read(&settings.cart, y + noise * amplitude * dice.normal()),
        }
    });
    Recording {
        drive,
        samples: samples.collect(),
        contacts: watch.contacts.clone(),
    }
}

/// The contact force with ringing, through a second-order 5 kHz Butterworth filter, once per tick.
fn force_signal(watch: &Watch, sensors: &Sensors) -> Vec<f64> {
    let fine_s = TICK_S / FINE as f64;
    let mut signal = vec![0.0_f64; (watch.relative.len() + 1) * FINE];
    let lost = sensors.dropped.and_then(|i| watch.contacts.get(i));
    let is_lost = |t: f64| {
        lost.is_some_and(|c| t >= c.onset_s - fine_s && t <= c.onset_s + c.duration_s + fine_s)
    };
    for &(k, force) in &watch.force {
        if k < signal.len() && !is_lost(k as f64 * fine_s) {
            signal[k] = force;
        }
    }
    for (i, contact) in watch.contacts.iter().enumerate() {
        if matches!(sensors.ring, Ring::None | Ring::Mode) || Some(i) == sensors.dropped {
            continue;
        }
        let (start, decay_s) = match sensors.ring {
            Ring::Late => (contact.peak_at_s + contact.onset_s, 2e-3),
            _ => (contact.onset_s, 2e-3 / 20.0_f64.ln()),
        };
        let first = (start / fine_s).ceil() as usize;
        for (k, value) in signal.iter_mut().enumerate().skip(first).take(3_000) {
            let t = k as f64 * fine_s - start;
            let angle = TAU * 3_000.0 * t;
            let wave = match sensors.ring {
                Ring::Sine => angle.sin(),
                Ring::Late => -angle.sin(),
                _ => angle.cos(),
            };
            *value += 0.5 * contact.peak_force_n * (-t / decay_s).exp() * wave;
        }
    }
    if sensors.ring == Ring::Mode {
        // r = 0.5 F'' / (s² + 2 ζ w s + w²): no gain at 0 Hz, one half far above.
        let (w, zeta) = (TAU * 3_000.0, 0.08);
        let (mut q, mut rate) = (0.0_f64, 0.0_f64);
        for x in &mut signal {
            // q follows the force at the mode; what it lacks rings.
            rate += fine_s * (w * w * (*x - q) - 2.0 * zeta * w * rate);
            q += fine_s * rate;
            *x += 0.5 * (q - *x);
        }
    }
    // Bilinear transform of ωc²/(s² + √2 ωc s + ωc²) at 200 kHz: the corner is a fortieth of the rate.
    let w = (TAU * 5_000.0 * fine_s / 2.0).tan();
    let norm = 1.0 / (1.0 + std::f64::consts::SQRT_2 * w + w * w);
    let (b0, a1) = (w * w * norm, 2.0 * (w * w - 1.0) * norm);
    let a2 = (1.0 - std::f64::consts::SQRT_2 * w + w * w) * norm;
    let (mut s1, mut s2) = (0.0, 0.0);
    let mut sampled = Vec::with_capacity(watch.relative.len());
    for (k, &x) in signal.iter().enumerate() {
        let y = b0 * x + s1;
        s1 = 2.0 * b0 * x - a1 * y + s2;
        s2 = b0 * x - a2 * y;
        if k % FINE == 0 {
            sampled.push(y);
        }
    }
    sampled
}

/// Normal deviates from a counter (SplitMix64, Box and Muller).
pub struct Dice(pub u64);

impl Dice {
    /// The next one, 0 to 1.
    fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// The next one, of mean 0 and deviation 1.
    pub fn normal(&mut self) -> f64 {
        let radius = (-2.0 * (1.0 - self.uniform()).ln()).sqrt();
        radius * (TAU * self.uniform()).cos()
    }
}
