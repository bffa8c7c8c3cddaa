//! The lanes, and the reference for what they leave.

use ::lanes::{Instructions, Work, try_run};

use super::{Cell, CellOutcome, CellPlan, run_one};
use crate::engine::Engine;
use crate::error::Error;

/// What became of the cells.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Report {
    /// Cells run by the lanes to their end.
    pub lanes: u64,
    /// Cells the lanes ran again with finer steps, as an event was uncertain.
    pub again: u64,
    /// Of these, cells in which it remained uncertain: the reference ran them.
    pub flagged: u64,
    /// Cells given to the reference at once: the lanes cannot run them.
    pub unfit: u64,
    /// What the lanes did.
    pub work: Work,
}

impl std::ops::AddAssign for Report {
    fn add_assign(&mut self, other: Self) {
        self.lanes += other.lanes;
        self.again += other.again;
        self.flagged += other.flagged;
        self.unfit += other.unfit;
        self.work += other.work;
    }
}

/// Runs cells in this thread's lanes, and by the reference where these cannot.
///
/// # Errors
/// If a cell has a parameter, frequency or start out of range, or its hammer leaves what the model describes: the
/// first such cell.
pub fn run_with(
    instructions: Instructions,
    cells: &[Cell],
    plan: &CellPlan,
) -> Result<(Vec<CellOutcome>, Report), Error> {
    let mut report = Report::default();
    let outcomes = each(instructions, cells, plan, &mut report).collect::<Result<_, _>>()?;
    Ok((outcomes, report))
}

/// [`run_with`] with a result for each cell, in their order: a cell that fails takes no other with it.
pub(super) fn each<'a>(
    instructions: Instructions,
    cells: &'a [Cell],
    plan: &'a CellPlan,
    report: &'a mut Report,
) -> impl Iterator<Item = Result<CellOutcome, Error>> + 'a {
    let tried = try_run(instructions, cells, plan);
    report.again = tried.again;
    report.work = tried.work;
    let tried = tried.outcomes.into_iter().zip(tried.fit);
    cells.iter().zip(tried).map(move |(cell, (done, fit))| {
        if let Some(outcome) = done {
            report.lanes += 1;
            return Ok(outcome);
        }
        report.flagged += u64::from(fit);
        report.unfit += u64::from(!fit);
        let mut outcome = run_one(Engine::Event, cell, plan)?;
        outcome.uncertain = fit;
        Ok(outcome)
    })
}
