//! Long work beside the interpreter: on threads of its own, while the calling thread looks for Ctrl-C and reports.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::time::Duration;

use numerics::Error;
use numerics::progress::Progress;
use pyo3::prelude::*;

use crate::error::{from_numerics, wrong};

/// How often the calling thread looks for Ctrl-C and reports.
const LOOK: Duration = Duration::from_millis(50);

/// Most threads that may be asked for.
const MOST_THREADS: usize = 1024;

/// What the working threads count, and whether they should stop.
#[derive(Default)]
struct Watch {
    done: AtomicU64,
    stop: AtomicBool,
}

impl Progress for Watch {
    fn advance(&self, steps: u64) {
        self.done.fetch_add(steps, Ordering::Relaxed);
    }

    fn interrupted(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }
}

/// How work is done: on how many threads, and who hears of it.
pub struct How<'py> {
    /// Threads; none: one for each processor.
    pub threads: Option<usize>,
    /// Called with the steps done and the steps in all, from the calling thread.
    pub progress: Option<Bound<'py, PyAny>>,
}

impl<'py> How<'py> {
    /// Does `work`, which has `steps` steps, with the interpreter released.
    ///
    /// # Errors
    /// Those of the work; `KeyboardInterrupt` on Ctrl-C; what the progress callback raises.
    pub fn run<T: Send>(
        &self,
        py: Python<'py>,
        steps: u64,
        work: impl FnOnce(&dyn Progress) -> Result<T, Error> + Send,
    ) -> PyResult<T> {
        let pool = match self.threads {
            None => None,
            Some(threads) => Some(pool(threads)?),
        };
        let watch = Watch::default();
        let (put, mut place) = mpsc::channel();
        let answer = std::thread::scope(|scope| {
            let (watched, pool) = (&watch, pool.as_ref());
            scope.spawn(move || {
                // Somebody waits for it until it is there.
                let _ = put.send(match pool {
                    Some(pool) => pool.install(|| work(watched)),
                    None => work(watched),
                });
            });
            let mut raised = None;
            loop {
                let heard;
                (place, heard) = py.detach(move || {
                    let heard = place.recv_timeout(LOOK);
                    (place, heard)
                });
                match heard {
                    Ok(answer) => return raised.map_or(Ok(answer), Err),
                    // It panicked, which the end of the scope passes on.
                    Err(RecvTimeoutError::Disconnected) => {
                        return Err(wrong("the computation broke off; please report it"));
                    }
                    Err(RecvTimeoutError::Timeout) => {}
                }
                if raised.is_some() {
                    continue;
                }
                let done = watch.done.load(Ordering::Relaxed).min(steps);
                let seen = py.check_signals().and_then(|()| self.report(done, steps));
                if let Err(error) = seen {
                    watch.stop.store(true, Ordering::Relaxed);
                    raised = Some(error);
                }
            }
        })?;
        let answer = answer.map_err(from_numerics)?;
        self.report(steps, steps)?;
        Ok(answer)
    }

    fn report(&self, done: u64, steps: u64) -> PyResult<()> {
        match &self.progress {
            Some(progress) => progress.call1((done, steps)).map(drop),
            None => Ok(()),
        }
    }
}

fn pool(threads: usize) -> PyResult<rayon::ThreadPool> {
    if !(1..=MOST_THREADS).contains(&threads) {
        return Err(wrong(format!(
            "threads is {threads}, must be from 1 to {MOST_THREADS}"
        )));
    }
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    pool.map_err(|e| wrong(format!("threads={threads}: {e}")))
}
