//! Drive cycles per second on one core, early stopping off: lanes by instructions, the reference and the
//! switch model, over cells spread evenly over the chapter's map.

use divan::{Bencher, counter::ItemsCount};
use numerics::engine::{Engine, Setting};
use numerics::lanes::{Cell, CellPlan, Instructions, run_one, run_with};
use shared::model::cart::{ASSUMED_SHAKER, CartDrive};
use shared::model::params::{RigParams, WIRES};
use shared::model::rig::Rig;

const PLAN: CellPlan = CellPlan {
    early: false,
    ..CellPlan::CHAPTER
};

/// Every `stride`-th of the map's 357 × 588 cells.
fn cells(stride: usize) -> Vec<Cell> {
    (0..357 * 588)
        .step_by(stride)
        .map(|k| {
            let params = RigParams {
                gap_m: (k / 588) as f64 * 1e-5,
                ..WIRES
            };
            Cell {
                params,
                frequency_hz: 1.41 + 0.01 * (k % 588) as f64,
                start: [Rig::<f64>::new(&params).unwrap().rest(), 0.0],
                phase: 0.0,
            }
        })
        .collect()
}

fn main() {
    divan::main();
}

#[divan::bench(
    args = [Instructions::Widest, Instructions::Avx2, Instructions::Scalar],
    sample_count = 3,
    sample_size = 1
)]
fn lanes(bencher: Bencher, instructions: Instructions) {
    let cells = cells(83);
    let cycles = cells.len() * PLAN.cycles as usize;
    bencher
        .counter(ItemsCount::new(cycles))
        .bench_local(|| run_with(instructions, &cells, &PLAN).unwrap());
}

#[divan::bench(sample_count = 3, sample_size = 1)]
fn recoiling_cart(bencher: Bencher) {
    let mut cells = cells(83);
    for cell in &mut cells {
        cell.params.cart = CartDrive::Loop(ASSUMED_SHAKER);
    }
    let cycles = cells.len() * PLAN.cycles as usize;
    bencher
        .counter(ItemsCount::new(cycles))
        .bench_local(|| run_with(Instructions::Widest, &cells, &PLAN).unwrap());
}

fn one_by_one(bencher: Bencher, engine: Engine, recoil: bool) {
    let mut cells = cells(15_013);
    for cell in &mut cells {
        if recoil {
            cell.params.cart = CartDrive::Loop(ASSUMED_SHAKER);
        }
    }
    let cycles = cells.len() * PLAN.cycles as usize;
    bencher.counter(ItemsCount::new(cycles)).bench_local(|| {
        for cell in &cells {
            run_one(engine, cell, &PLAN).unwrap();
        }
    });
}

#[divan::bench(sample_count = 3, sample_size = 1)]
fn reference(bencher: Bencher) {
    one_by_one(bencher, Engine::Event, false);
}

#[divan::bench(sample_count = 3, sample_size = 1)]
fn switch_model(bencher: Bencher) {
    one_by_one(
        bencher,
        Engine::Switch(Setting::corrected_f32(50e-6)),
        false,
    );
}

#[divan::bench(sample_count = 3, sample_size = 1)]
fn reference_recoiling_cart(bencher: Bencher) {
    one_by_one(bencher, Engine::Event, true);
}
