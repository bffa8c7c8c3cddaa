//! Long work ends with [`Error::Interrupted`] soon after it is asked to stop, for any number of threads.

use std::sync::atomic::{AtomicU64, Ordering};

use shared::model::params::{RigParams, WIRES};

use super::*;
use crate::basins::{self, BasinsRequest};
use crate::bifurcation;
use crate::engine::{self, Engine};
use crate::lanes;
use crate::limits::PickLimits;
use crate::map::{self, Grid, Runner};
use crate::pick;
use crate::row::NamedRig;
use crate::sweep::{Direction, spread, sweep};
use crate::uncertainty::Uncertainty;

/// Asks the work to stop after so many steps, and counts all of them.
struct StopAfter {
    limit: u64,
    done: AtomicU64,
}

impl Progress for StopAfter {
    fn advance(&self, steps: u64) {
        self.done.fetch_add(steps, Ordering::SeqCst);
    }

    fn interrupted(&self) -> bool {
        self.done.load(Ordering::SeqCst) >= self.limit
    }
}

/// Runs `work`, of `steps` steps, and asks it to stop at the beginning, early, late, and at its last step. Steps come up
/// to `at_once` together.
fn ends_when_asked<T: std::fmt::Debug>(
    (steps, at_once): (u64, u64),
    work: impl Fn(&dyn Progress) -> Result<T, Error> + Sync,
) {
    for threads in [1, 4] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        let pool = pool.build().unwrap();
        for limit in [0, 1, steps / 2, steps] {
            let progress = StopAfter {
                limit,
                done: AtomicU64::new(0),
            };
            let found = pool.install(|| work(&progress).map(drop));
            assert_eq!(found, Err(Error::Interrupted), "after {limit} of {steps}");
            // What other threads had begun is still counted.
            let most = limit + at_once * (1 + threads as u64);
            let done = progress.done.into_inner();
            assert!(done <= most, "{done} steps, stopped after {limit}");
        }
    }
}

fn wires(gap_mm: f64) -> NamedRig {
    NamedRig::new(
        "wires",
        RigParams {
            gap_m: gap_mm * 1e-3,
            ..WIRES
        },
    )
}

const PLAN: lanes::CellPlan = lanes::CellPlan {
    cycles: 20,
    recorded: 10,
    early: true,
    strobes: 0,
};

#[test]
fn a_map_ends_from_rest_and_carried() {
    for (from, at_once) in [(Direction::Rest, 2048), (Direction::Up, 32 * 200)] {
        let request = map::MapRequest {
            rig: wires(0.0),
            grid: Grid {
                gaps_mm: spread(0.0, 2.0, 100),
                frequencies_hz: spread(2.0, 5.0, 200),
            },
            runner: Runner::Lanes,
            plan: PLAN,
            settle: None,
            from,
        };
        let steps = request.grid.len() as u64;
        ends_when_asked((steps, at_once), |progress| map::run(&request, progress));
    }
}

#[test]
fn a_sweep_ends_in_every_direction() {
    let plan = engine::Plan {
        cycles: 12,
        transient: 10,
    };
    let frequencies_hz = spread(2.0, 4.0, 24);
    for direction in [Direction::Rest, Direction::Up, Direction::Down] {
        ends_when_asked((24, 1), |progress| {
            let rig = wires(0.0);
            sweep(
                &rig,
                Engine::Event,
                &frequencies_hz,
                direction,
                plan,
                progress,
            )
        });
    }
}

#[test]
fn basins_end_on_the_grid_and_among_the_random_starts() {
    let query = BasinsRequest {
        cycles: 20,
        recorded: 10,
        samples: 1000,
        until: 40,
        ..BasinsRequest::usual(wires(2.0), 3.6, 80, 80)
    };
    ends_when_asked((query.runs(), 4096), |progress| {
        basins::explore(Engine::Event, &query, progress)
    });
}

#[test]
fn a_bifurcation_diagram_ends_before_its_changes_are_located() {
    let request = bifurcation::DiagramRequest {
        rig: wires(0.0),
        gaps_mm: vec![0.0],
        frequencies_hz: spread(2.0, 5.0, 400),
        directions: vec![Direction::Rest, Direction::Up],
        engine: Engine::Event,
        plan: lanes::CellPlan { strobes: 8, ..PLAN },
        locate: true,
    };
    ends_when_asked((request.simulations(), 256), |progress| {
        bifurcation::diagrams(&request, progress)
    });
}

#[test]
fn a_pick_ends_among_the_members_and_the_sweeps() {
    let rig = wires(0.0);
    let two_members = Some(Uncertainty {
        natural_frequency_percent: 0.0,
        contact_stiffness_percent: 0.0,
        contact_damping_percent: 0.0,
        gap_mm: 0.0,
        samples: 0,
        ..Uncertainty::default()
    });
    ends_when_asked((pick::steps(two_members), 1), |progress| {
        pick::pick(&rig, two_members, PickLimits::default(), progress)
    });
}
