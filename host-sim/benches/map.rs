//! How long maps take: `cargo bench -p host-sim --bench map`.
//!
//! The chapter's map of the wires, thinned evenly, so that every entry has the same mixture of motions; from the
//! request to the cells, without tables and pictures. Cells, threads and cycles are varied one at a time; time per
//! item is to stay the same. On a busy machine compare entries of one run with each other, not runs.

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use files::table::to_csv;
use host_sim::progress::ProgressLine;
use numerics::NamedRig;
use numerics::lanes::CellPlan;
use numerics::map::request::{chapter_frequencies_hz, chapter_gaps_mm};
use numerics::map::{Grid, MapRequest, Runner, run};
use numerics::sweep::Direction;
use shared::model::params::WIRES;

fn main() {
    divan::main();
}

/// Every `thin`-th gap and frequency of the chapter's map.
fn request(thin: usize, plan: CellPlan) -> MapRequest {
    let every = |all: Vec<f64>| all.into_iter().step_by(thin).collect();
    MapRequest {
        rig: NamedRig::new("wires", WIRES),
        grid: Grid {
            gaps_mm: every(chapter_gaps_mm(&WIRES)),
            frequencies_hz: every(chapter_frequencies_hz(&WIRES)),
        },
        runner: Runner::Lanes,
        plan,
        settle: None,
        from: Direction::Rest,
    }
}

fn timed(bencher: Bencher, request: &MapRequest, threads: usize, items: usize) {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
    let pool = pool.build().expect("threads");
    let quiet = ProgressLine::new("", 1, true);
    bencher.counter(ItemsCount::new(items)).bench_local(|| {
        pool.install(|| run(black_box(request), &quiet).expect("the chapter's map"))
    });
}

/// Items are cells.
#[divan::bench(args = [16, 12, 8, 6, 4], sample_count = 3, sample_size = 1)]
fn cells_thinned_by(bencher: Bencher, thin: usize) {
    let request = request(thin, CellPlan::CHAPTER);
    timed(bencher, &request, 1, request.grid.len());
}

/// Items are cells.
#[divan::bench(args = [1, 2], sample_count = 3, sample_size = 1)]
fn threads(bencher: Bencher, threads: usize) {
    let request = request(6, CellPlan::CHAPTER);
    timed(bencher, &request, threads, request.grid.len());
}

/// Items are cells times cycles; no cell stops early.
#[divan::bench(args = [75, 150, 300, 600], sample_count = 3, sample_size = 1)]
fn cycles(bencher: Bencher, cycles: u32) {
    let plan = CellPlan {
        cycles,
        recorded: 50,
        early: false,
        strobes: 0,
    };
    let request = request(12, plan);
    timed(bencher, &request, 1, request.grid.len() * cycles as usize);
}

/// The whole table of a map thinned by four; items are rows.
#[divan::bench(sample_count = 5, sample_size = 1)]
fn table(bencher: Bencher) {
    let request = request(
        4,
        CellPlan {
            cycles: 20,
            recorded: 10,
            ..CellPlan::CHAPTER
        },
    );
    let map = run(&request, &ProgressLine::new("", 1, true)).expect("the chapter's map");
    bencher
        .counter(ItemsCount::new(map.cells.len()))
        .bench_local(|| {
            let rows: Vec<_> = map.rows().collect();
            to_csv(&rows)
        });
}
