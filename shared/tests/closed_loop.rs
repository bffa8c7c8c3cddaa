//! The whole controller around the model itself as its plant: it finds the operating frequency and holds it.

use shared::control::{BootInfo, Command, EventKind, Lockstep, Mode, State};
use shared::io::{AdcCode, Channel, DacCode, Frame, Output};
use shared::model::drive::Drive;
use shared::model::params::{PRESETS, RigParams};
use shared::model::rig::Rig;
use shared::model::step::Corrected;
use shared::model::twin::Twin;
use shared::settings::{Settings, TICK_S};

/// A rig that follows the drive without error, and sensors without noise.
struct Plant {
    twin: Twin<f64, Corrected>,
    amplitude_m: f64,
    on: bool,
    last: DacCode,
}

impl Plant {
    fn new(params: &RigParams) -> Self {
        let rig = Rig::new(params).unwrap();
        let drive = Drive::new(params.natural_frequency_hz(), TICK_S).unwrap();
        Self {
            twin: Twin::at_rest(rig, drive, Corrected),
            amplitude_m: params.amplitude_m,
            on: false,
            last: DacCode::MIDDLE,
        }
    }

    /// The cart moves at full amplitude, in step with the set-points, from where they first rise through the middle.
    fn tick(&mut self, settings: &Settings, output: &Output) -> Frame {
        let code = |channel: &Channel, value: f64| {
            let code = value / f64::from(channel.unit_per_code) + f64::from(channel.zero_code);
            AdcCode((code + 0.5).clamp(0.0, 4095.0) as u16)
        };
        let rises = self.last < DacCode::MIDDLE && output.dac >= DacCode::MIDDLE;
        self.last = output.dac;
        self.on = output.enable && (self.on || rises);
        let mut force_n = 0.0;
        if self.on {
            let hz = f64::from(output.frequency_hz);
            if (hz - self.twin.drive().frequency_hz()).abs() > 1e-5 {
                self.twin.set_frequency(hz, TICK_S).unwrap();
            }
            force_n = self.twin.tick().impulse / TICK_S;
        }
        let rig = self.twin.rig();
        let relative = rig.relative_displacement(self.twin.state().q.hi);
        let cart = if self.on {
            self.amplitude_m * self.twin.drive().sin()
        } else {
            0.0
        };
        Frame {
            force: code(&settings.force, force_n),
            hammer: code(&settings.hammer, relative + cart),
            cart: code(&settings.cart, cart),
            emergency: false,
        }
    }
}

/// When Hold was reached, s, and the best frequency then, Hz.
fn held(params: &RigParams) -> Option<(f64, f32)> {
    let settings = Settings::for_rig(params);
    let mut node = Lockstep::new(&settings, &BootInfo::STORED).unwrap();
    let mut plant = Plant::new(params);
    let mut outputs = [Output::SAFE; 10];
    let start = Command::Start(Mode::Automatic);
    node.controller.command(start).unwrap();
    let mut best_hz = 0.0;
    for block in 0..120 * 2000 {
        let frames = outputs.map(|output| plant.tick(&settings, &output));
        node.exchange(&frames, &mut outputs, 20);
        while let Some(event) = node.controller.take_event() {
            if let EventKind::Best { frequency_hz, .. } = event.kind {
                best_hz = frequency_hz;
            }
        }
        if node.controller.state() == State::Hold {
            return Some((f64::from(block) * 10.0 * TICK_S, best_hz));
        }
    }
    None
}

#[test]
fn every_preset_is_brought_to_hold_at_its_optimum() {
    // Of the reference (`host-sim pick --nominal`), Hz.
    let optima = [3.664, 9.040, 10.536, 13.023];
    for ((name, params), optimum_hz) in PRESETS.into_iter().zip(optima) {
        let (seconds, best_hz) = held(&params).expect(name);
        assert!(seconds < 60.0, "{name}: {seconds} s");
        // The force is flat there: 1 % of frequency is 0.1 % of force.
        let off = best_hz / optimum_hz - 1.0;
        assert!(off.abs() < 0.005, "{name}: {best_hz} Hz");
    }
}
