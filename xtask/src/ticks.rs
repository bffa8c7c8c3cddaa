//! Instructions per control tick.
//!
//! QEMU counts instructions exactly, but knows nothing of pipelines, flash wait
//! states or the bus: at `-icount shift=0` it lets one nanosecond of the board's
//! time go by per instruction. `firmware/src/bin/ticks.rs` repeats each tick from
//! the same state and reads the time before and after; here the counts are worked
//! out and summed up. They are instructions of the tick's work, without entering
//! and leaving the interrupt, and say nothing about cycles.

use crate::{JobResult, boards, firmware, qemu::Said};

/// Instructions of each tick of these kinds, in rising order.
fn instructions(said: &Said, kinds: &[&str]) -> JobResult<Vec<u64>> {
    let nanoseconds = said.number("nanoseconds")?;
    // What repeating costs without the tick.
    let empty = said.number("empty")?;
    let repeats = match said.number("repeats")? {
        0 => return Err("the program repeated no tick".into()),
        repeats => repeats,
    };
    let mut all = Vec::new();
    for kind in kinds {
        let counts = said.all(kind)?;
        let spent = |counts: u64| counts.saturating_sub(empty) * nanoseconds;
        all.extend(
            counts
                .into_iter()
                .map(|counts| (spent(counts) + repeats / 2) / repeats),
        );
    }
    all.sort_unstable();
    Ok(all)
}

/// Instructions of some ticks.
#[derive(Debug, PartialEq)]
struct Summary {
    ticks: usize,
    median: u64,
    mean: u64,
    worst: u64,
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
    let said = Said::by("ticks")?;
    println!("\ninstructions per control tick, counted under QEMU:");
    println!(
        "{:<16} {:>7} {:>7} {:>7} {:>7}",
        "kind of tick", "ticks", "median", "mean", "worst"
    );
    for (name, kinds) in [
        ("free flight", &["free"][..]),
        ("contact", &["contact"]),
        ("end of period", &["strobe"]),
        ("all", &["free", "contact", "strobe"]),
    ] {
        match summarize(&instructions(&said, kinds)?) {
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

    const RUN: &str =
        "hello, world\nnanoseconds 40\nrepeats 8\nempty 10\nfree 110\ncontact 210\nfree 112\nend";

    #[test]
    fn a_run_is_read_and_summed_up() {
        let said = Said::of(RUN).unwrap();
        let measured = |kinds: &[&str]| instructions(&said, kinds).unwrap();
        assert_eq!(measured(&["free"]), [500, 510]);
        assert_eq!(measured(&["contact"]), [1000]);
        assert_eq!(
            summarize(&measured(&["free", "contact", "strobe"])),
            Some(Summary {
                ticks: 3,
                median: 510,
                mean: 670,
                worst: 1000
            })
        );
    }

    #[test]
    fn no_tick_of_a_kind_is_no_summary() {
        assert_eq!(summarize(&[]), None);
    }

    #[test]
    fn a_run_without_its_scale_is_an_error() {
        for missing in ["nanoseconds 40\n", "repeats 8\n", "empty 10\n"] {
            let said = Said::of(&RUN.replace(missing, "")).unwrap();
            assert!(instructions(&said, &["free"]).is_err(), "{missing}");
        }
        let never = Said::of(&RUN.replace("repeats 8", "repeats 0")).unwrap();
        assert!(instructions(&never, &["free"]).is_err());
    }
}
