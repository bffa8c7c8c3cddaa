//! Processor time of a step.

use std::time::{Duration, Instant};

/// Processor time of all programs that were started from here, directly or not, and have ended.
#[cfg(unix)]
pub fn of_children() -> Duration {
    use nix::sys::{
        resource::{UsageWho, getrusage},
        time::TimeVal,
    };
    let duration = |time: TimeVal| {
        let seconds = Duration::from_secs(time.tv_sec().try_into().unwrap_or(0));
        seconds + Duration::from_micros(time.tv_usec().try_into().unwrap_or(0))
    };
    getrusage(UsageWho::RUSAGE_CHILDREN).map_or(Duration::ZERO, |usage| {
        duration(usage.user_time()) + duration(usage.system_time())
    })
}

/// Zero: not measured on this system.
#[cfg(not(unix))]
pub fn of_children() -> Duration {
    Duration::ZERO
}

/// Measures time on the wall, and processor time of the programs started and ended since.
pub struct Stopwatch {
    wall: Instant,
    processor: Duration,
}

/// What they show, s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spent {
    /// By the clock on the wall.
    pub wall_s: f64,
    /// By all processors together.
    pub processor_s: f64,
}

impl Stopwatch {
    pub fn start() -> Self {
        Self {
            wall: Instant::now(),
            processor: of_children(),
        }
    }

    /// Times since the start.
    pub fn spent(&self) -> Spent {
        Spent {
            wall_s: self.wall.elapsed().as_secs_f64(),
            processor_s: of_children().saturating_sub(self.processor).as_secs_f64(),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::process::Command;

    use super::*;

    #[test]
    #[cfg(unix)]
    fn the_processor_time_of_a_program_is_counted_when_it_has_ended() {
        let clocks = Stopwatch::start();
        let script = "i=0; while [ $i -lt 200000 ]; do i=$((i+1)); done";
        Command::new("sh").args(["-c", script]).status().unwrap();
        assert!(clocks.spent().processor_s > 0.01);
        assert!(clocks.spent().wall_s > 0.0);
    }
}
