//! Instructions per control tick.
//!
//! QEMU counts instructions exactly, but knows nothing of pipelines, flash wait
//! states or the bus: at `-icount shift=0` it lets one nanosecond of the board's
//! time go by per instruction. `firmware/src/bin/ticks.rs` repeats each tick from
//! the same state and reads the time before and after; here the counts are worked
//! out and summed up. They are instructions of the tick's work, without entering
//! and leaving the interrupt, and say nothing about cycles.

use crate::{JobResult, boards, firmware, qemu};

/// What the program measured, in counts of its stopwatch.
#[derive(Debug, Default, PartialEq)]
struct Measured {
    /// Nanoseconds per count, so instructions per count.
    nanoseconds: u64,
    /// How often each tick was repeated for one reading.
    repeats: u64,
    /// What repeating costs without the tick.
    empty: u64,
    /// One reading per tick, with the kind of tick.
    readings: Vec<(Kind, u64)>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    Free,
    Contact,
    Strobe,
}

/// Reads the program's lines; others than its own are passed over.
fn parse(lines: &[String]) -> JobResult<Measured> {
    let mut measured = Measured::default();
    let mut ended = false;
    for line in lines {
        let Some((word, number)) = line.split_once(' ') else {
            ended |= line == "end";
            continue;
        };
        let target = match word {
            "nanoseconds" => &mut measured.nanoseconds,
            "repeats" => &mut measured.repeats,
            "empty" => &mut measured.empty,
            "free" | "contact" | "strobe" => {
                let kind = match word {
                    "free" => Kind::Free,
                    "contact" => Kind::Contact,
                    _ => Kind::Strobe,
                };
                measured.readings.push((kind, 0));
                &mut measured.readings.last_mut().ok_or("no reading")?.1
            }
            _ => continue,
        };
        *target = number
            .parse()
            .map_err(|_| format!("`{line}` holds no count"))?;
    }
    if !ended || measured.repeats == 0 || measured.nanoseconds == 0 {
        return Err("the program did not get to its end".into());
    }
    Ok(measured)
}

/// Instructions of some ticks.
#[derive(Debug, PartialEq)]
struct Summary {
    ticks: usize,
    median: u64,
    mean: u64,
    worst: u64,
}

impl Measured {
    /// Instructions of each tick of a kind (`None`: of every tick), in rising order.
    fn instructions(&self, kind: Option<Kind>) -> Vec<u64> {
        let chosen = self
            .readings
            .iter()
            .filter(|(of, _)| kind.is_none_or(|kind| kind == *of));
        let one = |counts: &u64| {
            let spent = counts.saturating_sub(self.empty) * self.nanoseconds;
            (spent + self.repeats / 2) / self.repeats
        };
        let mut all: Vec<u64> = chosen.map(|(_, counts)| one(counts)).collect();
        all.sort_unstable();
        all
    }
}

fn summarize(rising: &[u64]) -> Option<Summary> {
    let worst = *rising.last()?;
    Some(Summary {
        ticks: rising.len(),
        median: rising[rising.len() / 2],
        mean: rising.iter().sum::<u64>() / rising.len() as u64,
        worst,
    })
}

/// Measures and prints the table.
pub fn run() -> JobResult {
    firmware::build_named(boards::QEMU)?;
    let lines = qemu::start(&firmware::image("ticks"), &["-icount", "shift=0"], false)?;
    let measured = parse(&lines)?;
    println!("\ninstructions per control tick, counted under QEMU:");
    println!(
        "{:<16} {:>7} {:>7} {:>7} {:>7}",
        "kind of tick", "ticks", "median", "mean", "worst"
    );
    for (name, kind) in [
        ("free flight", Some(Kind::Free)),
        ("contact", Some(Kind::Contact)),
        ("end of period", Some(Kind::Strobe)),
        ("all", None),
    ] {
        match summarize(&measured.instructions(kind)) {
            Some(Summary {
                ticks,
                median,
                mean,
                worst,
            }) => {
                println!("{name:<16} {ticks:>7} {median:>7} {mean:>7} {worst:>7}");
            }
            None => println!("{name:<16} {:>7}", 0),
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(text: &str) -> Vec<String> {
        text.lines().map(str::to_owned).collect()
    }

    const RUN: &str =
        "hello, world\nnanoseconds 40\nrepeats 8\nempty 10\nfree 110\ncontact 210\nfree 112\nend";

    #[test]
    fn a_run_is_read_and_summed_up() {
        let measured = parse(&lines(RUN)).unwrap();
        assert_eq!(measured.instructions(Some(Kind::Free)), [500, 510]);
        assert_eq!(measured.instructions(Some(Kind::Contact)), [1000]);
        let all = summarize(&measured.instructions(None)).unwrap();
        assert_eq!(
            all,
            Summary {
                ticks: 3,
                median: 510,
                mean: 670,
                worst: 1000
            }
        );
    }

    #[test]
    fn no_tick_of_a_kind_is_no_summary() {
        assert_eq!(summarize(&[]), None);
    }

    #[test]
    fn a_run_cut_short_is_an_error() {
        assert!(parse(&lines(RUN.strip_suffix("\nend").unwrap())).is_err());
        assert!(parse(&lines("end")).is_err());
    }

    #[test]
    fn a_broken_count_is_named() {
        let error = parse(&lines("nanoseconds 40\nfree x1\nend")).unwrap_err();
        assert!(error.to_string().contains("free x1"));
    }
}
