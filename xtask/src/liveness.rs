//! Whether a program that has been started still does something.
//!
//! A test may take any time on a busy or slow machine, so the clock alone ends nothing. A program is given up when it
//! has written nothing and its process tree has used no processor time for [`PATIENCE`]. A limit by the clock is there
//! for continuous integration that asks for one.

use std::{
    env,
    process::Child,
    time::{Duration, Instant},
};

/// How long nothing may happen. Where processor time cannot be read, compilers are silent for much longer.
pub const PATIENCE: Duration = if cfg!(target_os = "linux") {
    Duration::from_secs(5 * 60)
} else {
    Duration::from_secs(60 * 60)
};

/// The environment variable with the most seconds a program may take by the clock; without it there is no such limit.
const LIMIT: &str = "XTASK_STEP_LIMIT_S";

/// A pause between two looks counts as no more than this: a machine that was asleep, or so busy that this watch did
/// not get its turn either, is not a silent program.
const LONGEST_LOOK: Duration = Duration::from_secs(2);

/// Decides when a program is given up: silent for too long, or beyond its limit of time or work.
pub struct ProgramWatch {
    patience: Duration,
    limit: Option<Duration>,
    /// The most processor time it may use.
    work: Option<Duration>,
    /// Whether it may wait as long as it likes while it is the only process of its tree.
    alone: bool,
    start: Instant,
    last_look: Instant,
    /// For how long nothing has happened.
    quiet: Duration,
    /// At the last sign of life.
    lines: usize,
    processor: Duration,
}

impl ProgramWatch {
    /// Watches with the usual patience, and the limit in the environment.
    pub fn new() -> Result<Self, String> {
        let limit = match env::var(LIMIT) {
            Ok(text) => Some(seconds(&text)?),
            Err(_) => None,
        };
        Ok(Self::with(PATIENCE, limit))
    }

    /// Watches with this patience and limit.
    pub fn with(patience: Duration, limit: Option<Duration>) -> Self {
        let now = Instant::now();
        Self {
            patience,
            limit,
            work: None,
            alone: false,
            start: now,
            last_look: now,
            quiet: Duration::ZERO,
            lines: 0,
            processor: Duration::ZERO,
        }
    }

    /// Also gives up what has used that much processor time: a program that may loop for ever, on a machine that may
    /// be slow.
    pub fn working_at_most(self, work: Duration) -> Self {
        Self {
            work: Some(work),
            ..self
        }
    }

    /// Lets it wait as long as it likes before it has started another process, or between two: cargo, while another cargo
    /// holds the target folder. It says so itself.
    pub fn waiting_alone(self) -> Self {
        Self {
            alone: true,
            ..self
        }
    }

    /// Looks again; `lines` is how many the program has written so far. The error says why to give it up.
    pub fn look(&mut self, process: u32, lines: usize) -> Result<(), String> {
        let (processes, processor) = tree::used(process);
        let passed = self.last_look.elapsed();
        self.last_look = Instant::now();
        if !(self.alone && processes == 1) {
            self.observe(passed, lines, processor)?;
        }
        match self.limit {
            Some(limit) if self.start.elapsed() >= limit => Err(format!(
                "had not ended after {} s, the limit in {LIMIT}",
                limit.as_secs()
            )),
            _ => Ok(()),
        }
    }

    fn observe(
        &mut self,
        passed: Duration,
        lines: usize,
        processor: Duration,
    ) -> Result<(), String> {
        if let Some(work) = self.work.filter(|work| processor >= *work) {
            return Err(format!(
                "was given up: it has used {} s of processor time and has not ended",
                work.as_secs()
            ));
        }
        // A program that only waits, and wakes now and then to look, uses some processor time, too.
        let busy = processor.saturating_sub(self.processor) > self.patience / 200;
        if lines > self.lines || busy || processor < self.processor {
            (self.lines, self.processor) = (lines, processor);
            self.quiet = Duration::ZERO;
            return Ok(());
        }
        self.quiet += passed.min(LONGEST_LOOK);
        if self.quiet < self.patience {
            return Ok(());
        }
        Err(format!(
            "was given up: no output and no processor time for {} s, after {} s in all",
            self.quiet.as_secs(),
            self.start.elapsed().as_secs()
        ))
    }
}

fn seconds(text: &str) -> Result<Duration, String> {
    let seconds = text.trim().parse().ok().filter(|seconds| *seconds > 0);
    seconds
        .map(Duration::from_secs)
        .ok_or_else(|| format!("{LIMIT}={text}: give whole seconds from 1, or leave it out"))
}

/// Ends a program and every process it has started.
pub fn end(child: &mut Child) {
    tree::kill(child.id());
    // It may have ended by itself in the meantime.
    let _ = child.kill();
    let _ = child.wait();
}

#[cfg(target_os = "linux")]
mod tree {
    use std::{collections::HashMap, fs, time::Duration};

    use nix::{
        sys::signal::{self, Signal},
        unistd::Pid,
    };

    /// What `/proc/PID/stat` counts processor time in: Linux shows 100 a second on every machine.
    const TICK: Duration = Duration::from_millis(10);

    /// One line of `/proc/PID/stat`.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct Stat {
        pub process: u32,
        pub parent: u32,
        /// Its own processor time and that of its ended children.
        pub processor: Duration,
    }

    /// The name may hold blanks and brackets: the fields count from the last bracket.
    pub fn parse(line: &str) -> Option<Stat> {
        let process = line.split(' ').next()?.parse().ok()?;
        let (_, rest) = line.rsplit_once(") ")?;
        let fields: Vec<&str> = rest.split(' ').collect();
        let ticks: Option<u32> = fields
            .get(11..15)?
            .iter()
            .map(|field| field.parse::<u32>().ok())
            .sum();
        Some(Stat {
            process,
            parent: fields.get(1)?.parse().ok()?,
            processor: TICK * ticks?,
        })
    }

    /// A process and all that descend from it, parents first.
    fn of(root: u32) -> Vec<Stat> {
        let mut children: HashMap<u32, Vec<Stat>> = HashMap::new();
        let mut found = Vec::new();
        for entry in fs::read_dir("/proc").into_iter().flatten().flatten() {
            let stat = fs::read_to_string(entry.path().join("stat"));
            if let Some(stat) = stat.ok().and_then(|line| parse(&line)) {
                if stat.process == root {
                    found.push(stat);
                }
                children.entry(stat.parent).or_default().push(stat);
            }
        }
        let mut next = 0;
        while let Some(stat) = found.get(next) {
            let more = children.remove(&stat.process).unwrap_or_default();
            found.extend(more);
            next += 1;
        }
        found
    }

    /// How many processes there are, the first among them, and the processor time they have used.
    pub fn used(process: u32) -> (usize, Duration) {
        let all = of(process);
        (all.len(), all.iter().map(|stat| stat.processor).sum())
    }

    /// Ends a process and all that descend from it. They are stopped first, so that none starts another meanwhile.
    pub fn kill(root: u32) {
        let mut stopped = 0;
        loop {
            let all = of(root);
            send(&all, Signal::SIGSTOP);
            if all.len() <= stopped {
                return send(&all, Signal::SIGKILL);
            }
            stopped = all.len();
        }
    }

    fn send(processes: &[Stat], signal: Signal) {
        for stat in processes {
            if let Ok(id) = i32::try_from(stat.process) {
                // One that has ended by itself is no error.
                let _ = signal::kill(Pid::from_raw(id), signal);
            }
        }
    }
}

#[cfg(not(target_os = "linux"))]
mod tree {
    use std::time::Duration;

    pub fn used(_: u32) -> (usize, Duration) {
        (0, Duration::ZERO)
    }

    pub fn kill(_: u32) {}
}

#[cfg(test)]
mod tests {
    use super::*;

    const SECOND: Duration = Duration::from_secs(1);

    fn minutes(n: u32) -> Duration {
        60 * n * SECOND
    }

    #[test]
    fn output_or_work_keeps_a_program_alive_however_long_it_takes() {
        let mut watch = ProgramWatch::with(minutes(5), None);
        for second in 1..5_000 {
            // A twentieth of a processor, on a machine shared with many.
            assert!(watch.observe(SECOND, 0, second * SECOND / 20).is_ok());
        }
        for line in 1..5_000 {
            assert!(watch.observe(SECOND, line, 250 * SECOND).is_ok());
        }
    }

    #[test]
    fn silence_ends_it_when_patience_does() {
        let mut watch = ProgramWatch::with(minutes(5), None);
        assert!(watch.observe(SECOND, 3, 7 * SECOND).is_ok());
        let quiet = (0..1_000).take_while(|_| watch.observe(SECOND, 3, 7 * SECOND).is_ok());
        assert_eq!(quiet.count(), 299);
        let error = watch.observe(SECOND, 3, 7 * SECOND).unwrap_err();
        assert!(error.contains("no processor time for 301 s"), "{error}");
    }

    #[test]
    fn a_watch_that_waits_and_wakes_up_does_not_count_as_work() {
        let mut watch = ProgramWatch::with(minutes(5), None);
        // A millisecond of processor time a second.
        let mut looks = (1..1_000).map(|n| watch.observe(SECOND, 0, n * SECOND / 1_000));
        assert!(looks.any(|look| look.is_err()));
    }

    #[test]
    fn what_works_for_ever_is_ended_where_that_is_asked_for() {
        let mut watch = ProgramWatch::with(minutes(5), None).working_at_most(minutes(10));
        assert!(watch.observe(SECOND, 0, minutes(9)).is_ok());
        let error = watch.observe(SECOND, 0, minutes(10)).unwrap_err();
        assert!(error.contains("600 s of processor time"), "{error}");
    }

    #[test]
    fn a_machine_that_slept_is_not_silence() {
        let mut watch = ProgramWatch::with(minutes(5), None);
        assert!(watch.observe(minutes(600), 0, Duration::ZERO).is_ok());
    }

    #[test]
    fn a_limit_that_is_no_number_is_named() {
        assert_eq!(seconds(" 90 "), Ok(90 * SECOND));
        for wrong in ["", "0", "-1", "1h"] {
            assert!(seconds(wrong).unwrap_err().contains("XTASK_STEP_LIMIT_S"));
        }
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn the_process_table_is_read() {
        let line = "4242 (a b) c) S 17 4242 4242 0 -1 4194560 9 9 0 0 50 30 15 5 20 0 1 0 77 1 1";
        let stat = tree::parse(line).unwrap();
        assert_eq!((stat.process, stat.parent), (4242, 17));
        assert_eq!(stat.processor, SECOND);
        assert_eq!(tree::parse("4242 (cut"), None);
    }
}
