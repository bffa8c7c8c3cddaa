//! Bench mode: the model takes the place of the rig, so that a bare board runs the controller.
//!
//! The controller's own set-points go in, sensor codes come out. The shaker of this rig follows without lag: at
//! each upward zero crossing of the set-point its phase is set afresh, its frequency is the one commanded, and its
//! amplitude the largest of the period before. The hammer is [`shared::model::twin`]'s. What a real rig adds (a shaker of
//! finite force, filters, ringing, noise of a sensor) is in the desktop emulator, not here.

use shared::io::{ADC_FULL_SCALE, AdcCode, Channel, DacCode, Frame, Output};
use shared::model::drive::{Drive, Stamp};
use shared::model::rig::Rig;
use shared::model::step::{Corrected, HammerState};
use shared::model::twin::Twin;
use shared::settings::{DriveKind, DriveSettings, Settings, TICK_RATE_HZ, TICK_S};

/// Ticks in a step of the model: with a step to every tick, the tick of a light touch would take a block past its
/// deadline (docs/flashing.md).
const STEP_TICKS: u32 = 2;
/// Length of a step of the model, s.
const STEP_S: f64 = STEP_TICKS as f64 * TICK_S;
/// Steps in a second.
const STEPS_PER_S: f32 = TICK_RATE_HZ as f32 / STEP_TICKS as f32;
/// Cart amplitude of a drive at rest, m: the model needs one above 0; no sensor resolves it.
const STANDING_M: f64 = 1e-9;
/// The set-point must have been this far below the middle for its rise through it to count, codes.
const ARMED: i32 = 8;
/// Longest period of a set-point that is still followed, ticks: 10 s.
const LONGEST: u32 = 200_000;

/// The model in place of the rig.
#[derive(Clone, Debug)]
pub struct Bench {
    /// The sensors of force, hammer and cart.
    channels: [Channel; 3],
    drive: DriveSettings,
    /// The rig, worked out once: that takes longer than a tick. None: settings that no check has passed.
    rig: Option<Rig<f32>>,
    /// Displacement of the hammer at rest relative to the cart, m.
    rest_m: f32,
    twin: Option<Twin<f32, Corrected>>,
    /// Contact force (N), the hammer's displacement relative to the cart (m) and the cart's displacement (m) in this step.
    seen: (f32, f32, f32),
    /// Cart amplitude that the drive makes now, m.
    amplitude_m: f64,
    /// Largest set-point since the last crossing, codes from the middle.
    peak: i32,
    armed: bool,
    /// Ticks since that crossing; of a motor, since it was switched on.
    since: u32,
    noise: u32,
}

impl Bench {
    /// The rig the settings describe, at rest.
    pub fn new(settings: &Settings) -> Self {
        let rig = Rig::new(&settings.rig).ok();
        Self {
            channels: [settings.force, settings.hammer, settings.cart],
            drive: settings.drive,
            rig,
            rest_m: rig.map_or(0.0, |rig| rig.relative_displacement(rig.rest())),
            twin: None,
            seen: Default::default(),
            amplitude_m: 0.0,
            peak: 0,
            armed: false,
            since: 0,
            noise: 1,
        }
    }

    /// The sensors' readings in the ticks in which `outputs` are played; of unequal numbers the shorter counts.
    pub fn block(&mut self, outputs: &[Output], frames: &mut [Frame]) {
        for (output, frame) in outputs.iter().zip(frames) {
            *frame = self.tick(output);
        }
    }

    fn tick(&mut self, output: &Output) -> Frame {
        self.follow(output);
        let [force, hammer, cart] = self.channels;
        match &mut self.twin {
            None => self.seen = (0.0, self.rest_m, 0.0),
            Some(twin) if self.since.is_multiple_of(STEP_TICKS) => {
                // The step's mean, as a sensor behind its anti-alias filter shows it: the force jumps at onset, and
                // its value at the step's end would alias the impulse.
                let force_n = twin.tick().impulse * STEPS_PER_S;
                let relative_m = twin.rig().relative_displacement(twin.state().q.hi);
                let cart_m = twin.rig().amplitude() * twin.drive().sin();
                self.seen = (force_n, relative_m, cart_m);
            }
            Some(_) => {}
        }
        let (force_n, relative_m, cart_m) = self.seen;
        Frame {
            force: self.code(&force, force_n),
            hammer: self.code(&hammer, cart_m + relative_m),
            cart: self.code(&cart, cart_m),
            emergency: false,
        }
    }

    /// Lets the shaker follow the set-point of this tick.
    fn follow(&mut self, output: &Output) {
        if !output.enable {
            // A hammer without a drive is caught and put at rest.
            (self.twin, self.amplitude_m) = (None, 0.0);
            (self.peak, self.armed, self.since) = (0, false, 0);
            return;
        }
        let code = i32::from(output.dac.0) - i32::from(DacCode::MIDDLE.0);
        let frequency_hz = f64::from(output.frequency_hz);
        self.since = self.since.saturating_add(1);
        match self.drive.kind {
            DriveKind::Shaker => {
                self.armed |= code < -ARMED;
                self.peak = self.peak.max(code.abs());
                if (self.armed && code >= 0) || self.since > LONGEST {
                    self.amplitude_m = f64::from(self.peak) * f64::from(self.drive.m_per_code);
                    (self.peak, self.armed, self.since) = (0, false, 0);
                    self.restart(frequency_hz, true);
                }
            }
            DriveKind::Motor => {
                // The mechanism's amplitude; its frequency follows ten times a second.
                if self.since.is_multiple_of(2_000) || self.twin.is_none() {
                    self.amplitude_m = self.rig.map_or(0.0, |rig| f64::from(rig.amplitude()));
                    self.restart(frequency_hz, false);
                }
            }
        }
    }

    /// Continues from the hammer's state under a drive of that frequency and of the present amplitude.
    fn restart(&mut self, frequency_hz: f64, from_zero: bool) {
        let (Some(rig), Ok(drive)) = (self.rig, Drive::new(frequency_hz, STEP_S)) else {
            return;
        };
        let rig = rig.with_amplitude(self.amplitude_m.max(STANDING_M) as f32);
        let old = self.twin.as_ref().filter(|_| !from_zero);
        let drive = match old {
            Some(twin) => {
                let mut going = *twin.drive();
                if going.set_frequency(frequency_hz, STEP_S).is_err() {
                    return;
                }
                going
            }
            None => drive,
        };
        debug_assert!(old.is_some() || drive.now() == Stamp::default());
        let state = match &self.twin {
            Some(twin) => *twin.state(),
            None => HammerState::at_rest(&rig),
        };
        self.twin = Some(Twin::new(rig, drive, Corrected, state));
    }

    /// A value as a 12-bit code, with a sensor's noise of about a code.
    fn code(&mut self, channel: &Channel, value: f32) -> AdcCode {
        // A linear congruential generator (Numerical Recipes' constants); its upper bits, −1 to 1.
        self.noise = self
            .noise
            .wrapping_mul(1_664_525)
            .wrapping_add(1_013_904_223);
        let noise = (self.noise >> 8) as f32 * (2.0 / 16_777_216.0) - 1.0;
        let code = channel.zero_code + value / channel.unit_per_code + noise + 0.5;
        AdcCode(code.clamp(0.0, f32::from(ADC_FULL_SCALE)) as u16)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use shared::control::{BootInfo, Command, Lockstep, Mode, State as ControllerState};
    use shared::model::params::WIRES;
    use std::f64::consts::TAU;

    /// Drives the bench with a clean sine for `seconds` and hands over every frame of the last second.
    fn driven(frequency_hz: f64, seconds: u32, mut see: impl FnMut(f64, &Settings, Frame)) {
        let settings = Settings::for_rig(&WIRES);
        let mut bench = Bench::new(&settings);
        let amplitude = WIRES.amplitude_m / f64::from(settings.drive.m_per_code);
        for tick in 0..seconds * 20_000 {
            let phase = (f64::from(tick) * frequency_hz * TICK_S).fract();
            let output = Output {
                dac: DacCode((2048.0 + amplitude * (TAU * phase).sin()).round() as u16),
                frequency_hz: frequency_hz as f32,
                enable: true,
            };
            let mut frame = [Frame::default()];
            bench.block(&[output], &mut frame);
            if tick >= (seconds - 1) * 20_000 {
                see(phase, &settings, frame[0]);
            }
        }
    }

    #[test]
    fn the_cart_follows_the_set_point_and_the_hammer_strikes() {
        let frequency_hz = 2.0 * WIRES.natural_frequency_hz();
        let (mut worst_m, mut peak_n) = (0.0_f64, 0.0_f32);
        driven(frequency_hz, 60, |phase, settings, frame| {
            let want_m = WIRES.amplitude_m * (TAU * phase).sin();
            let cart_m = f64::from(settings.cart.value(frame.cart));
            worst_m = worst_m.max((cart_m - want_m).abs());
            peak_n = peak_n.max(settings.force.value(frame.force));
        });
        // Two codes of noise and rounding, the peak's rounding, and a tick of phase (1 µm).
        assert!(worst_m < 6e-6, "{worst_m}");
        // 96 N is the strongest 1/1, and that is near twice the natural frequency.
        assert!((20.0..96.0).contains(&peak_n), "{peak_n}");
    }

    #[test]
    fn a_drive_that_is_off_stands_still() {
        let settings = Settings::for_rig(&WIRES);
        let mut bench = Bench::new(&settings);
        let mut frames = [Frame::default(); 1000];
        bench.block(&[Output::SAFE; 1000], &mut frames);
        assert!(frames.iter().all(|frame| frame.cart.0.abs_diff(2048) <= 1
            && frame.hammer.0.abs_diff(2048) <= 1
            && frame.force.0.abs_diff(600) <= 1));
        // And yet the sensors are alive.
        assert!(frames.windows(2).any(|w| w[0].force != w[1].force));
    }

    #[test]
    fn the_controller_proves_the_sensors_of_the_bench_and_seeks() {
        let settings = Settings::for_rig(&WIRES);
        let mut bench = Bench::new(&settings);
        let mut node = Lockstep::new(&settings, &BootInfo::STORED).unwrap();
        let start = Command::Start(Mode::Automatic);
        node.controller.command(start).unwrap();
        let mut outputs = [Output::SAFE; 10];
        let mut frames = [Frame::default(); 10];
        for _ in 0..10 * 2000 {
            bench.block(&outputs, &mut frames);
            node.exchange(&frames, &mut outputs, 20);
            if node.controller.state() == ControllerState::Seek {
                return;
            }
        }
        panic!("{:?}", node.controller.status());
    }
}
