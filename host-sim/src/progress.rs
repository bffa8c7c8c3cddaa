//! The progress bar of long work, for people at a terminal.

use std::io::{IsTerminal, stderr};
use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

impl numerics::progress::Progress for Progress {
    fn advance(&self, steps: u64) {
        self.inc(steps);
    }
}

/// A bar with count and time left on standard error; silent when `quiet` or
/// when standard error is not a terminal. Clones and threads share one count.
#[derive(Debug, Clone)]
pub struct Progress {
    bar: ProgressBar,
}

impl Progress {
    /// Starts counting to `total` steps of `what`.
    pub fn new(what: impl Into<String>, total: u64, quiet: bool) -> Self {
        let target = if quiet || !stderr().is_terminal() {
            ProgressDrawTarget::hidden()
        } else {
            ProgressDrawTarget::stderr()
        };
        let bar = ProgressBar::with_draw_target(Some(total), target);
        let look = "{msg} [{bar:30}] {pos}/{len}, {eta} left";
        let style = ProgressStyle::with_template(look)
            .unwrap_or_else(|_| ProgressStyle::default_bar())
            .progress_chars("=> ");
        bar.set_style(style);
        bar.set_message(what.into());
        if !bar.is_hidden() {
            bar.enable_steady_tick(Duration::from_millis(250));
        }
        Self { bar }
    }

    /// Adds finished steps; may be called from any thread.
    pub fn inc(&self, steps: u64) {
        self.bar.inc(steps);
    }

    /// Writes a line above the bar; silent when the bar is.
    pub fn note(&self, line: &str) {
        self.bar.println(line);
    }

    /// Steps finished so far.
    pub fn done(&self) -> u64 {
        self.bar.position()
    }

    /// Removes the bar. Dropping the last clone does the same.
    pub fn finish(&self) {
        self.bar.finish_and_clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn progress_counts_from_many_threads() {
        let progress = Progress::new("points", 400, true);
        std::thread::scope(|scope| {
            for _ in 0..4 {
                scope.spawn(|| (0..100).for_each(|_| progress.inc(1)));
            }
        });
        assert_eq!(progress.done(), 400);
        assert!(progress.bar.is_hidden());
        progress.finish();
    }
}
