//! From cells to lanes and back: which cells the lanes take, by which instructions, and what the reference does instead.

use pulp::{Simd, WithSimd};

use super::constants::{Constants, Kind};
use super::flight::Margins;
use super::number::{Double, Single};
use super::pool::{Job, Tuning, Work, run};
use super::{Cell, Outcome, Plan, run_one};
use crate::engine::Engine;
use crate::error::UserError;

/// What the lanes compute in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Precision {
    /// f64.
    #[default]
    Double,
    /// f32: faster, and further from the reference where an orbit converges slowly. On AVX-512 only; f64 elsewhere.
    Single,
}

/// By which instructions.
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

/// How the lanes run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct How {
    /// What in.
    pub precision: Precision,
    /// By which instructions: changes nothing but the time taken.
    pub instructions: Instructions,
}

/// What became of the cells.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Report {
    /// Cells run by the lanes to their end.
    pub lanes: u64,
    /// Cells given to the reference since an event was uncertain.
    pub flagged: u64,
    /// Cells given to the reference at once: the lanes cannot run them.
    pub unfit: u64,
    /// What the lanes did.
    pub work: Work,
}

impl std::ops::AddAssign for Report {
    fn add_assign(&mut self, other: Self) {
        self.lanes += other.lanes;
        self.flagged += other.flagged;
        self.unfit += other.unfit;
        self.work += other.work;
    }
}

impl Precision {
    fn tuning(self) -> Tuning {
        match self {
            Self::Double => Tuning {
                step: 1.6,
                margins: Margins {
                    grazing: 1e-7,
                    rest: 1e-5,
                },
                grain: 1e-9,
            },
            Self::Single => Tuning {
                step: 2.0,
                margins: Margins {
                    grazing: 4e-6,
                    rest: 2e-4,
                },
                grain: 4e-6,
            },
        }
    }
}

/// Runs cells one thread's lanes at a time, in this thread.
///
/// # Errors
/// The first cell whose parameters, frequency or start cannot be, or whose hammer leaves what the model describes.
pub fn run_with(
    how: How,
    cells: &[Cell],
    plan: &Plan,
) -> Result<(Vec<Outcome>, Report), UserError> {
    let mut out: Vec<Option<Outcome>> = vec![None; cells.len()];
    let mut report = Report::default();
    let mut fit = vec![false; cells.len()];
    for kind in [Kind::Wires, Kind::Beams] {
        let mut jobs = Vec::new();
        let mut places = Vec::new();
        for (place, cell) in cells.iter().enumerate() {
            let Some(constants) = Constants::new(cell).filter(|c| c.kind == kind) else {
                continue;
            };
            fit[place] = true;
            jobs.push(Job {
                x: cell.start[0] / constants.scale,
                v: cell.start[1] / (constants.scale * constants.omega),
                tau: cell.phase * std::f64::consts::TAU,
                constants,
            });
            places.push(place);
        }
        if jobs.is_empty() || plan.cycles == 0 {
            continue;
        }
        let (done, work) = dispatch(how, kind == Kind::Beams, &jobs, plan);
        report.work += work;
        for (place, outcome) in places.into_iter().zip(done) {
            out[place] = outcome;
        }
    }
    let mut outcomes = Vec::with_capacity(cells.len());
    for ((cell, done), fit) in cells.iter().zip(out).zip(fit) {
        if let Some(outcome) = done {
            report.lanes += 1;
            outcomes.push(outcome);
            continue;
        }
        report.flagged += u64::from(fit);
        report.unfit += u64::from(!fit);
        let mut outcome = run_one(Engine::Event, cell, plan)?;
        outcome.uncertain = fit;
        outcomes.push(outcome);
    }
    Ok((outcomes, report))
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
        // One f32 kernel is enough to compare with: every kernel takes seconds to compile.
        if S::F64_LANES == 8 && precision == Precision::Single {
            run(Single(simd), beams, jobs, plan, precision.tuning())
        } else {
            let tuning = Precision::Double.tuning();
            run(Double(simd), beams, jobs, plan, tuning)
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
