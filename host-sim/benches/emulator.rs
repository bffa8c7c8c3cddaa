//! How fast rig time passes in the emulator: `cargo bench -p host-sim --bench emulator`.
//!
//! Real time is 20 000 ticks per second.

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use emulator::cart::Mounting;
use emulator::local::Local;
use emulator::plant::{Plant, ShakerDrive};
use emulator::run::run;
use emulator::scenario::{Scenario, load, parse};
use emulator::sensors::{SensorErrors, SensorParams, Sensors};
use emulator::shaker::{ShakerParams, Smoother};
use shared::model::params::{RigParams, preset};
use shared::settings::{Settings, TICK_S};

/// Ticks timed at a stretch: 5 s of rig time.
const TICKS: usize = 100_000;

fn main() {
    divan::main();
}

/// A rig at twice its natural frequency, one contact per drive period, from where it has settled.
struct Running {
    rig: RigParams,
    plant: Plant,
    smoother: Smoother,
    turns: f64,
}

impl Running {
    fn new(name: &str) -> Self {
        let rig = preset(name).expect("a preset");
        let shaker = ShakerParams::default();
        let mut running = Self {
            rig,
            plant: Plant::mounted(
                &rig,
                &ShakerDrive::Shaker(shaker),
                &Mounting::default(),
                TICK_S,
            )
            .expect("a preset"),
            smoother: Smoother::new(&shaker, TICK_S),
            turns: 0.0,
        };
        for _ in 0..10 * TICKS {
            running.tick();
        }
        running
    }

    fn tick(&mut self) {
        let hz = 2.0 * self.rig.natural_frequency_hz();
        self.turns = (self.turns + hz * TICK_S).fract();
        let metres = self.rig.amplitude_m * (std::f64::consts::TAU * self.turns).sin();
        let path = self.smoother.tick(metres);
        self.plant.tick(path, true);
    }
}

#[divan::bench(args = ["wires", "beam-150"])]
fn plant_ticks(bencher: Bencher, name: &str) {
    let mut running = Running::new(name);
    bencher.counter(ItemsCount::new(TICKS)).bench_local(|| {
        for _ in 0..TICKS {
            running.tick();
        }
        black_box(running.plant.cart_m())
    });
}

#[divan::bench(args = ["wires", "beam-150"])]
fn plant_and_sensor_ticks(bencher: Bencher, name: &str) {
    let mut running = Running::new(name);
    let noisy = SensorErrors {
        noise: 1e-5,
        ..SensorErrors::default()
    };
    let params = SensorParams {
        force: noisy,
        hammer: noisy,
        cart: noisy,
        ..SensorParams::default()
    };
    let settings = Settings::for_rig(&running.rig);
    let mut sensors = Sensors::new(&params, &settings, TICK_S, 1);
    bencher.counter(ItemsCount::new(TICKS)).bench_local(|| {
        for _ in 0..TICKS {
            running.tick();
            black_box(sensors.read(&running.plant));
        }
    });
}

fn ticks_of(scenario: &Scenario) -> usize {
    scenario.blocks() as usize * scenario.block_ticks
}

fn whole(bencher: Bencher, scenario: &Scenario) {
    bencher
        .counter(ItemsCount::new(ticks_of(scenario)))
        .bench_local(|| {
            let mut control = Local::new(&scenario.settings).expect("checked");
            run(scenario, &mut control, &mut ()).expect("checked")
        });
}

/// The field scenario: plant, sensors, controller and its forecast.
#[divan::bench(sample_count = 3, sample_size = 1)]
fn field_scenario_ticks(bencher: Bencher) {
    whole(bencher, &load("field").expect("built in"));
}

/// A day of rig time holding the optimum, only when asked for: `SOAK=1 cargo bench --bench emulator soak`.
#[divan::bench(sample_count = 1, sample_size = 1)]
fn soak(bencher: Bencher) {
    let hours = match std::env::var("SOAK") {
        Ok(hours) => hours.parse::<f64>().unwrap_or(24.0),
        Err(_) => 0.05,
    };
    let text = format!(
        "duration_s = {:?}\nseed = 5\n[true_rig]\npreset = \"wires\"\nnatural_frequency_percent = 1.5\n[sensors]\nnoise_percent = 1.0\n[[events]]\nat_s = 1.0\nkind = \"start\"\n",
        3600.0 * hours
    );
    let scenario = parse("soak", &text, "soak").expect("a scenario");
    whole(bencher, &scenario);
}
