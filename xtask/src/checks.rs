//! `cargo xtask test`: what must hold before a change is done, one step after
//! the other; the first that fails ends it.

use crate::{
    Outcome,
    command::{self, cargo, run_tee},
    desktop::Build,
    firmware::{self, Board},
    forecast, msrv, pil, size,
    timing::{Spent, Stopwatch},
    tools,
};

/// A step ends with a remark for the summary, often empty.
type Step = (&'static str, fn() -> Outcome<String>);

const STEPS: &[Step] = &[
    ("tools", || silent(tools::list())),
    ("format", || {
        silent(command::run(cargo().args(["fmt", "--all", "--check"])))
    }),
    ("lints, host", || {
        silent(command::run(cargo().args([
            "clippy",
            "--workspace",
            "--all-targets",
            "--",
            "-D",
            "warnings",
        ])))
    }),
    ("oldest Rust", msrv::run),
    ("dependencies", dependencies),
    ("documentation", || {
        silent(command::run(
            cargo()
                .env("RUSTDOCFLAGS", "-D warnings")
                .args(["doc", "--workspace", "--no-deps"]),
        ))
    }),
    ("tests, host", host_tests),
    ("model for the microcontroller", || {
        silent(firmware::build_shared())
    }),
    ("control path free of panics", || {
        silent(firmware::check_panic_free())
    }),
    ("firmware, nucleo", || board(Board::Nucleo)),
    ("firmware, qemu", || board(Board::Qemu)),
    ("firmware run in QEMU, budgets", || silent(size::run())),
    ("forecast in QEMU", || silent(forecast::run())),
    ("processor in the loop", || {
        let run = |plan| pil::run(plan, &Build::Tested);
        silent(pil::Plan::checks().iter().try_for_each(run))
    }),
];

fn silent(outcome: Outcome) -> Outcome<String> {
    outcome.map(|()| String::new())
}

/// Known faults are not looked up: they are fetched from the network, and may be new without any change here.
fn dependencies() -> Outcome<String> {
    if command::find("cargo-deny").is_none() {
        let remark = "skipped: no cargo-deny here; type: cargo install --locked cargo-deny";
        println!("{remark}");
        return Ok(remark.into());
    }
    let mut deny = cargo();
    silent(command::run(
        deny.args(["deny", "check", "licenses", "bans", "sources"]),
    ))
}

fn board(board: Board) -> Outcome<String> {
    firmware::lint(board)?;
    firmware::build(board)?;
    Ok(format!("built with {}", tools::toolchain()?.describe()))
}

fn host_tests() -> Outcome<String> {
    let lines = run_tee(
        cargo().args(["test", "--workspace", "--no-fail-fast"]),
        true,
    )?;
    Ok(format!("{} tests passed", passed(&lines)))
}

/// How many tests passed, summed over cargo's closing lines.
fn passed(lines: &[String]) -> u32 {
    let counts = lines
        .iter()
        .filter_map(|line| line.strip_prefix("test result: ok. "));
    counts
        .filter_map(|rest| rest.split(' ').next()?.parse::<u32>().ok())
        .sum()
}

/// What is known of a step when it has ended.
struct Row {
    name: &'static str,
    spent: Spent,
    outcome: Outcome<String>,
}

/// Runs the steps up to the first that fails, and says in the end what each took.
pub fn run() -> Outcome {
    let mut rows: Vec<Row> = Vec::new();
    for (name, step) in STEPS {
        println!("\n=== {name} ===");
        let clocks = Stopwatch::start();
        let outcome = step();
        rows.push(Row {
            name,
            spent: clocks.spent(),
            outcome,
        });
        if rows.last().is_some_and(|row| row.outcome.is_err()) {
            break;
        }
    }
    println!("\n=== summary ===\n{}", table(&rows));
    match rows.pop() {
        Some(Row {
            name,
            outcome: Err(error),
            ..
        }) => Err(format!("step `{name}` failed: {error}").into()),
        _ => Ok(()),
    }
}

fn table(rows: &[Row]) -> String {
    let mut text = format!("{:<32} {:>8} {:>13}\n", "step", "wall, s", "processor, s");
    let mut line = |name: &str, spent: Spent, remark: &str| {
        let Spent {
            wall_s,
            processor_s,
        } = spent;
        let line = format!("{name:<32} {wall_s:>8.1} {processor_s:>13.1}  {remark}");
        text += line.trim_end();
        text.push('\n');
    };
    let mut all = Spent {
        wall_s: 0.0,
        processor_s: 0.0,
    };
    for row in rows {
        let remark = row.outcome.as_ref().map_or("FAILED", |remark| remark);
        line(row.name, row.spent, remark);
        all.wall_s += row.spent.wall_s;
        all.processor_s += row.spent.processor_s;
    }
    line("all", all, "");
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_has_every_step_that_ran_and_their_sum() {
        let row = |name, wall_s, outcome| Row {
            name,
            spent: Spent {
                wall_s,
                processor_s: 2.0 * wall_s,
            },
            outcome,
        };
        let rows = [
            row("format", 1.25, Ok(String::new())),
            row("tests", 60.0, Ok("7 tests passed".into())),
            row("lints", 2.0, Err("no".into())),
        ];
        let expected = "\
            step                              wall, s  processor, s\n\
            format                                1.2           2.5\n\
            tests                                60.0         120.0  7 tests passed\n\
            lints                                 2.0           4.0  FAILED\n\
            all                                  63.2         126.5\n";
        assert_eq!(table(&rows), expected);
    }

    #[test]
    fn passed_tests_are_summed_up() {
        let lines = [
            "running 2 tests",
            "test result: ok. 2 passed; 0 failed; 0 ignored; 0 measured; 0 filtered out; finished in 0.00s",
            "test result: ok. 41 passed; 0 failed; 0 ignored; 0 measured; 0 filtered out; finished in 0.10s",
        ];
        assert_eq!(passed(&lines.map(String::from)), 43);
    }
}
