//! How long work reports its progress, and how it learns that it should stop.

use crate::error::Error;

/// Who watches long work. The methods are called from any thread.
pub trait Progress: Sync {
    /// `steps` more steps are done. The function that takes the progress says what a step is.
    fn advance(&self, steps: u64);

    /// Whether the work should stop. It then ends within about a step with [`Error::Interrupted`].
    fn interrupted(&self) -> bool {
        false
    }
}

/// Nobody watches, and the work is never interrupted.
impl Progress for () {
    fn advance(&self, _: u64) {}
}

/// The progress of work within one step of other work: it is interrupted as the other is, and counts no steps.
pub struct WithinStep<'a>(pub &'a dyn Progress);

impl Progress for WithinStep<'_> {
    fn advance(&self, _: u64) {}

    fn interrupted(&self) -> bool {
        self.0.interrupted()
    }
}

/// Counts `steps` more, or ends the work if it should stop.
///
/// # Errors
/// [`Error::Interrupted`] if the work should stop.
pub fn step(progress: &dyn Progress, steps: u64) -> Result<(), Error> {
    progress.advance(steps);
    check(progress)
}

/// Ends the work if it should stop.
///
/// # Errors
/// [`Error::Interrupted`] if the work should stop.
pub fn check(progress: &dyn Progress) -> Result<(), Error> {
    if progress.interrupted() {
        Err(Error::Interrupted)
    } else {
        Ok(())
    }
}

#[cfg(test)]
mod tests;
