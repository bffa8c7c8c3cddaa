//! By which instructions and in which precision: one kernel each.

use pulp::{Simd, WithSimd};

use super::constants::{Constants, Kind};
use super::flight::Margins;
use super::number::{Double, Pair, Single};
use super::pool::{Job, Tuning, Work, run};
use super::{Cell, Outcome, Plan};

/// What the lanes compute in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Precision {
    /// f32: faster by half, but sections converge only to its grain, so that cells stop later. Cells with an uncertain
    /// event are run again in f64.
    Single,
    /// f64.
    #[default]
    Double,
}

/// By which instructions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Instructions {
    /// The widest this machine has.
    #[default]
    Widest,
    /// AVX2 with FMA; without vectors where there is none.
    Avx2,
    /// Two lanes, no vectors.
    Scalar,
}

/// How the lanes run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct How {
    /// What in.
    pub precision: Precision,
    /// By which instructions: changes nothing but the time taken.
    pub instructions: Instructions,
}

impl Precision {
    fn tuning(self) -> Tuning {
        match self {
            Self::Double => Tuning {
                step: 1.6,
                margins: Margins {
                    grazing: 1e-7,
                    rest: 1e-6,
                },
                grain: 1e-9,
            },
            Self::Single => Tuning {
                step: 1.6,
                margins: Margins {
                    grazing: 4e-6,
                    rest: 3e-5,
                },
                grain: 1e-5,
            },
        }
    }
}

/// What the lanes made of cells.
#[derive(Clone, Debug, Default)]
pub struct Tried {
    /// An outcome per cell; none where the reference must run it.
    pub outcomes: Vec<Option<Outcome>>,
    /// Cells the lanes can run.
    pub fit: Vec<bool>,
    /// Cells in which an event was uncertain to the lanes of the precision asked for.
    pub flagged: u64,
    /// What the lanes did.
    pub work: Work,
}

/// Runs cells in this thread's lanes. Outcomes that took a second run in f64 are marked uncertain.
pub fn try_run(how: How, cells: &[Cell], plan: &Plan) -> Tried {
    let mut tried = Tried {
        outcomes: vec![None; cells.len()],
        fit: vec![false; cells.len()],
        ..Tried::default()
    };
    if plan.cycles == 0 {
        return tried;
    }
    for kind in [Kind::Wires, Kind::Beams] {
        let mut jobs = Vec::new();
        let mut places = Vec::new();
        for (place, cell) in cells.iter().enumerate() {
            if let Some(constants) = Constants::new(cell).filter(|c| c.kind == kind) {
                tried.fit[place] = true;
                jobs.push(Job::new(cell, constants));
                places.push(place);
            }
        }
        if jobs.is_empty() {
            continue;
        }
        let beams = kind == Kind::Beams;
        let (mut done, work) = dispatch(how, beams, &jobs, plan);
        tried.work += work;
        let lost: Vec<_> = (0..done.len()).filter(|i| done[*i].is_none()).collect();
        tried.flagged += lost.len() as u64;
        if how.precision == Precision::Single && !lost.is_empty() {
            let again: Vec<_> = lost.iter().map(|i| jobs[*i]).collect();
            let precision = Precision::Double;
            let (better, work) = dispatch(How { precision, ..how }, beams, &again, plan);
            tried.work += work;
            for (i, outcome) in lost.into_iter().zip(better) {
                done[i] = outcome.map(|o| Outcome {
                    uncertain: true,
                    ..o
                });
            }
        }
        for (place, outcome) in places.into_iter().zip(done) {
            tried.outcomes[place] = outcome;
        }
    }
    tried
}

struct Run<'a> {
    precision: Precision,
    beams: bool,
    jobs: &'a [Job],
    plan: &'a Plan,
}

impl WithSimd for Run<'_> {
    type Output = (Vec<Option<Outcome>>, Work);

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        let Self {
            precision,
            beams,
            jobs,
            plan,
        } = self;
        let tuning = precision.tuning();
        match precision {
            Precision::Single => run(Pair(Single(simd)), beams, jobs, plan, tuning),
            Precision::Double => run(Pair(Double(simd)), beams, jobs, plan, tuning),
        }
    }
}

fn dispatch(how: How, beams: bool, jobs: &[Job], plan: &Plan) -> (Vec<Option<Outcome>>, Work) {
    let op = Run {
        precision: how.precision,
        beams,
        jobs,
        plan,
    };
    match how.instructions {
        Instructions::Widest => pulp::Arch::new().dispatch(op),
        #[cfg(target_arch = "x86_64")]
        Instructions::Avx2 => match pulp::x86::V3::try_new() {
            Some(simd) => Simd::vectorize(simd, op),
            None => pulp::Arch::Scalar.dispatch(op),
        },
        _ => pulp::Arch::Scalar.dispatch(op),
    }
}
