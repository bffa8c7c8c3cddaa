//! One kernel for each instruction set, chosen when it runs.

#[cfg(not(target_arch = "wasm32"))]
use pulp::Arch;
use pulp::{Simd, WithSimd};

use super::constants::{Constants, EquationKind};
use super::job::{Job, Tuning, Work};
use super::meet::EventMargins;
use super::pool::run;
use super::ring::Reach;
use super::width::{Double, VectorPair};
use super::{Cell, CellOutcome, CellPlan};

/// The instruction set: it changes the time taken and nothing else.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Instructions {
    /// The widest this machine has.
    #[default]
    Widest,
    /// AVX2 with FMA; without vectors where there is none.
    Avx2,
    /// One lane, no vectors.
    Scalar,
}

/// A motion whose top is nearer to the surface than this, in cart amplitudes, may or may not touch it: about the error of
/// the steps below over a drive cycle (1e-5; more if the hammer swings wider than 0.15 rad).
const GRAZING: f64 = 2e-5;

/// A ring has died out at so many times the error of a step: below about once, the error itself keeps it up.
const RING_OVER: f64 = 3.0;

/// The tuning of the first run.
fn usual() -> Tuning {
    const RING: f64 = 2e-6;
    Tuning {
        step: 1.6,
        margins: EventMargins {
            grazing: GRAZING,
            rest: 1e-5,
        },
        grain: 1e-9,
        reach: Reach::new(RING),
        dead: RING_OVER * RING,
    }
}

/// The tuning with which cells with an uncertain event are run again.
fn fine() -> Tuning {
    Tuning {
        step: 0.8,
        margins: EventMargins {
            grazing: 1e-7,
            rest: 1e-6,
        },
        grain: 1e-9,
        reach: Reach::new(1e-9),
        dead: RING_OVER * 1e-9,
    }
}

/// What the lanes made of cells.
#[derive(Clone, Debug, Default)]
pub struct Tried {
    /// An outcome per cell; `None` if the reference must run it.
    pub outcomes: Vec<Option<CellOutcome>>,
    /// Cells the lanes can run.
    pub fit: Vec<bool>,
    /// Cells that were run again with finer steps, as an event was uncertain.
    pub again: u64,
    /// What the lanes did.
    pub work: Work,
}

/// Runs cells in this thread's lanes; those in which an event was uncertain a second time, with half the step.
pub fn try_run(instructions: Instructions, cells: &[Cell], plan: &CellPlan) -> Tried {
    let mut tried = Tried {
        outcomes: vec![None; cells.len()],
        fit: vec![false; cells.len()],
        ..Tried::default()
    };
    if plan.cycles == 0 {
        return tried;
    }
    let fit: Vec<_> = cells.iter().map(Constants::new).collect();
    let kinds = [EquationKind::Wires, EquationKind::Beams].into_iter();
    let kinds = kinds.flat_map(|kind| [false, true].map(|recoil| (kind, recoil)));
    let kinds = kinds.flat_map(|kind| [false, true].map(|by_law| (kind, by_law)));
    for ((kind, recoil), by_law) in kinds {
        let mut jobs = Vec::new();
        let mut places = Vec::new();
        for (place, (cell, constants)) in cells.iter().zip(&fit).enumerate() {
            let of_kind = |c: &&Constants| {
                let here = (c.kind, c.recoil.is_some(), c.surface.is_some());
                here == (kind, recoil, by_law)
            };
            if let Some(constants) = constants.as_ref().filter(of_kind) {
                tried.fit[place] = true;
                jobs.push(Job::new(cell, *constants));
                places.push(place);
            }
        }
        if jobs.is_empty() {
            continue;
        }
        let op = Run {
            tuning: usual(),
            beams: kind == EquationKind::Beams,
            jobs: &jobs,
            plan,
        };
        let (mut done, work) = dispatch(instructions, recoil, op);
        tried.work += work;
        let lost: Vec<_> = (0..done.len()).filter(|i| done[*i].is_none()).collect();
        tried.again += lost.len() as u64;
        if !lost.is_empty() {
            let jobs: Vec<_> = lost.iter().map(|i| jobs[*i]).collect();
            let finer = Run {
                tuning: fine(),
                jobs: &jobs,
                ..op
            };
            let (better, work) = dispatch(instructions, recoil, finer);
            tried.work += work;
            for (i, outcome) in lost.into_iter().zip(better) {
                done[i] = outcome;
            }
        }
        for (place, outcome) in places.into_iter().zip(done) {
            tried.outcomes[place] = outcome;
        }
    }
    tried
}

#[derive(Clone, Copy)]
struct Run<'a> {
    tuning: Tuning,
    beams: bool,
    jobs: &'a [Job],
    plan: &'a CellPlan,
}

/// A run in which the cart recoils, or not.
struct OfCart<'a, const RECOIL: bool>(Run<'a>);

impl<const RECOIL: bool> WithSimd for OfCart<'_, RECOIL> {
    type Output = (Vec<Option<CellOutcome>>, Work);

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        let Run {
            tuning,
            beams,
            jobs,
            plan,
        } = self.0;
        // Without vectors a pair would only make the kernel larger.
        if const { S::F64_LANES == 1 } {
            return run::<_, RECOIL>(Double(simd), beams, jobs, plan, tuning);
        }
        run::<_, RECOIL>(VectorPair(Double(simd)), beams, jobs, plan, tuning)
    }
}

fn dispatch(
    instructions: Instructions,
    recoil: bool,
    op: Run<'_>,
) -> (Vec<Option<CellOutcome>>, Work) {
    if recoil {
        on(instructions, OfCart::<true>(op))
    } else {
        on(instructions, OfCart::<false>(op))
    }
}

/// Runs `op`. The compiler makes a kernel of every call of `dispatch`: this is the only one.
#[cfg(not(target_arch = "wasm32"))]
fn on<O: WithSimd>(instructions: Instructions, op: O) -> O::Output {
    let arch = match instructions {
        Instructions::Widest => Arch::new(),
        #[cfg(target_arch = "x86_64")]
        Instructions::Avx2 => pulp::x86::V3::try_new().map_or(Arch::Scalar, Arch::V3),
        _ => Arch::Scalar,
    };
    arch.dispatch(op)
}

/// Runs `op` in a page, which is compiled for 128-bit vectors and does not run where there are none.
#[cfg(target_arch = "wasm32")]
fn on<O: WithSimd>(_: Instructions, op: O) -> O::Output {
    match pulp::wasm::Simd128::try_new() {
        Some(simd) => Simd::vectorize(simd, op),
        None => panic!("the module is compiled without simd128"),
    }
}
