//! The progress bar of long work, for people at a terminal.

use std::fmt::Write;
use std::io::{IsTerminal, stderr};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use indicatif::{HumanDuration, ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};

impl numerics::progress::Progress for ProgressLine {
    fn advance(&self, steps: u64) {
        self.inc(steps);
    }
}

/// A bar with count and time left on standard error; silent when `quiet` or
/// when standard error is not a terminal. Clones and threads share one count.
#[derive(Debug, Clone)]
pub struct ProgressLine {
    bar: ProgressBar,
    parts: Arc<Mutex<Parts>>,
}

impl ProgressLine {
    /// Starts counting to `total` steps of `what`, each of which takes about as long as the others.
    pub fn new(what: impl Into<String>, total: u64, quiet: bool) -> Self {
        let bar = hidden_unless_read(total, quiet);
        let style = style("{msg} [{bar:30}] {pos}/{len}, {left} left").with_key(
            "left",
            |state: &ProgressState, text: &mut dyn Write| {
                let _ = match state.pos() {
                    0 => write!(text, "unknown time"),
                    _ => write!(text, "{:#}", HumanDuration(state.eta())),
                };
            },
        );
        Self::start(bar, style, what.into(), Parts::new(0.0))
    }

    /// Starts on parts of `what` of very different size, `weight` in all; see [`ProgressLine::part_done`].
    pub fn in_parts(what: impl Into<String>, weight: f64, quiet: bool) -> Self {
        let bar = hidden_unless_read(WHOLE, quiet);
        let parts = Parts::new(weight);
        let left = Arc::clone(&parts);
        let style = style("{msg} [{bar:30}] {percent} %, {left} left").with_key(
            "left",
            move |_: &ProgressState, text: &mut dyn Write| {
                let left = left
                    .lock()
                    .ok()
                    .and_then(|parts| parts.left(Instant::now()));
                let _ = match left {
                    Some(left) => write!(text, "about {}", HumanDuration(left)),
                    None => write!(text, "unknown time"),
                };
            },
        );
        Self::start(bar, style, what.into(), parts)
    }

    fn start(
        bar: ProgressBar,
        style: ProgressStyle,
        what: String,
        parts: Arc<Mutex<Parts>>,
    ) -> Self {
        bar.set_style(style.progress_chars("=> "));
        bar.set_message(what);
        if !bar.is_hidden() {
            bar.enable_steady_tick(Duration::from_millis(250));
        }
        Self { bar, parts }
    }

    /// Adds finished steps; may be called from any thread.
    pub fn inc(&self, steps: u64) {
        self.bar.inc(steps);
    }

    /// Adds a finished part of this weight.
    pub fn part_done(&self, weight: f64) {
        if let Ok(mut parts) = self.parts.lock() {
            parts.add(weight, Instant::now());
            self.bar.set_position((parts.share() * WHOLE as f64) as u64);
        }
    }

    /// Writes a line above the bar; silent when the bar is.
    pub fn note(&self, line: &str) {
        self.bar.println(line);
    }

    /// Does what writes on standard error, without the bar.
    pub fn aside(&self, write: impl FnOnce()) {
        self.bar.suspend(write);
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

/// Steps of a bar that counts parts.
const WHOLE: u64 = 1000;

fn hidden_unless_read(total: u64, quiet: bool) -> ProgressBar {
    let target = if quiet || !stderr().is_terminal() {
        ProgressDrawTarget::hidden()
    } else {
        ProgressDrawTarget::stderr()
    };
    ProgressBar::with_draw_target(Some(total), target)
}

fn style(template: &str) -> ProgressStyle {
    ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar())
}

/// Parts of very different size: what is finished, and when the latest of them was.
#[derive(Debug)]
struct Parts {
    whole: f64,
    done: f64,
    begun: Instant,
    latest: Instant,
}

impl Parts {
    fn new(whole: f64) -> Arc<Mutex<Self>> {
        let now = Instant::now();
        Arc::new(Mutex::new(Self {
            whole,
            done: 0.0,
            begun: now,
            latest: now,
        }))
    }

    fn add(&mut self, weight: f64, now: Instant) {
        self.done += weight;
        self.latest = now;
    }

    fn share(&self) -> f64 {
        (self.done / self.whole).min(1.0)
    }

    /// The time left at the pace of the finished parts; none before the first is finished. It
    /// counts down while the next part is made.
    fn left(&self, now: Instant) -> Option<Duration> {
        if self.done <= 0.0 {
            return None;
        }
        let pace = (self.latest - self.begun).as_secs_f64() / self.done;
        let waited = now.saturating_duration_since(self.latest).as_secs_f64();
        let left = pace * (self.whole - self.done) - waited;
        Some(Duration::from_secs_f64(left.max(0.0)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn progress_counts_from_many_threads() {
        let progress = ProgressLine::new("points", 400, true);
        std::thread::scope(|scope| {
            for _ in 0..4 {
                scope.spawn(|| (0..100).for_each(|_| progress.inc(1)));
            }
        });
        assert_eq!(progress.done(), 400);
        assert!(progress.bar.is_hidden());
        progress.finish();
    }

    #[test]
    fn the_time_left_follows_the_weight_of_the_parts_and_the_pace() {
        let parts = Parts::new(100.0);
        let mut parts = parts.lock().unwrap();
        let begun = parts.begun;
        let [ten, sixteen, late] = [10, 16, 9999].map(|s| begun + Duration::from_secs(s));
        assert_eq!(parts.left(ten), None);
        // A fifth took 10 s, so that the rest takes 40 s, of which 6 s pass.
        parts.add(20.0, ten);
        assert_eq!(parts.left(ten), Some(Duration::from_secs(40)));
        assert_eq!(parts.left(sixteen), Some(Duration::from_secs(34)));
        assert_eq!(parts.left(late), Some(Duration::ZERO));
        assert_eq!(parts.share(), 0.2);
    }
}
