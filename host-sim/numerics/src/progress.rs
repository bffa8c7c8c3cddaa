//! How long work reports its progress, and how it learns that nobody waits for it any more.

use crate::error::Error;

/// What watches long work. Its methods are called from any thread.
pub trait Progress: Sync {
    /// `steps` more steps are done. What a step is, the function that takes the progress says.
    fn advance(&self, steps: u64);

    /// Whether the work should stop. It then ends within about a step with [`Error::Interrupted`].
    fn interrupted(&self) -> bool {
        false
    }
}

/// Nobody watches.
impl Progress for () {
    fn advance(&self, _: u64) {}
}

/// Counts `steps` more, or ends the work if it should stop.
///
/// # Errors
/// [`Error::Interrupted`] if the work should stop.
pub fn step(progress: &dyn Progress, steps: u64) -> Result<(), Error> {
    progress.advance(steps);
    if progress.interrupted() {
        Err(Error::Interrupted)
    } else {
        Ok(())
    }
}
