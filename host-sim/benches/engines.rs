//! How fast the engines are: `cargo bench -p host-sim`.
//!
//! Wires at 0.0 mm and twice the natural frequency, near where it is run: one contact per drive period.
//! On a busy machine compare entries of one run with each other, not runs.

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use host_sim::progress::ProgressLine;
use numerics::NamedRig;
use numerics::PickLimits;
use numerics::engine::{CycleRecorder, Engine, Machine, Plan, Start, machine, observe};
use numerics::orbit::shoot;
use numerics::pick::pick;
use shared::Real;
use shared::model::drive::Drive;
use shared::model::params::{RigParams, WIRES};
use shared::model::rig::Rig;
use shared::model::step::{Banded, Corrected, Stepper};
use shared::model::switch::Band;
use shared::model::twin::Twin;

/// Ticks, and drive periods, timed at a stretch.
const TICKS: usize = 100_000;
const PERIODS: usize = 100;
/// The microcontroller's tick, s.
const TICK_S: f64 = 50e-6;
/// The rig where it is run.
const RIG: RigParams = RigParams {
    gap_m: 0.0,
    ..WIRES
};

fn main() {
    divan::main();
}

fn frequency_hz() -> f64 {
    2.0 * RIG.natural_frequency_hz()
}

/// Ticks of the switch model, from where a run has settled.
fn ticks<R: Real, S: Stepper<R>>(bencher: Bencher, stepper: S) {
    let rig = Rig::<R>::new(&RIG).expect("a preset");
    let drive = Drive::<R>::new(frequency_hz(), TICK_S).expect("well below the tick rate");
    let mut twin = Twin::at_rest(rig, drive, stepper);
    for _ in 0..TICKS {
        twin.tick();
    }
    bencher.counter(ItemsCount::new(TICKS)).bench_local(|| {
        for _ in 0..TICKS {
            black_box(twin.tick());
        }
    });
}

#[divan::bench(types = [f32, f64])]
fn corrected_ticks<R: Real>(bencher: Bencher) {
    ticks::<R, _>(bencher, Corrected);
}

#[divan::bench(types = [f32, f64])]
fn banded_ticks<R: Real>(bencher: Bencher) {
    let band = Band::<R>::new(5e-8, 1e-3);
    ticks::<R, _>(bencher, Banded { band });
}

fn reference() -> Box<dyn Machine> {
    machine(Engine::Event, &RIG, frequency_hz(), Start::Rest).expect("a preset from rest")
}

#[divan::bench]
fn reference_drive_periods(bencher: Bencher) {
    let mut hammer = reference();
    bencher.counter(ItemsCount::new(PERIODS)).bench_local(|| {
        for _ in 0..PERIODS {
            black_box(hammer.period(None));
        }
    });
}

#[divan::bench]
fn one_shoot(bencher: Bencher) {
    let mut hammer = reference();
    let plan = Plan {
        cycles: 60,
        transient: 59,
    };
    let settled =
        observe(hammer.as_mut(), plan, &mut CycleRecorder::default()).expect("within reach");
    let near = settled.section[0].map(|x| x * 1.01);
    bencher.bench_local(|| {
        shoot(black_box(&RIG), frequency_hz(), black_box(near)).expect("an orbit near by")
    });
}

#[divan::bench(sample_count = 5, sample_size = 1)]
fn one_nominal_pick(bencher: Bencher) {
    let rig = NamedRig::new("wires", RIG);
    bencher.bench_local(|| {
        let progress = ProgressLine::new("", 1, true);
        pick(black_box(&rig), None, PickLimits::default(), &progress).expect("a stable 1/1")
    });
}
