//! `cargo xtask test`: what must hold before a change is done, one step after
//! the other; the first that fails ends it.

use std::time::Instant;

use crate::{
    Outcome,
    command::{self, cargo, run_tee},
    desktop::Build,
    firmware::{self, Board},
    forecast, pil, size, tools,
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

/// Runs every step, then says how it went.
pub fn run() -> Outcome {
    let mut summary = Vec::new();
    for (name, step) in STEPS {
        println!("\n=== {name} ===");
        let start = Instant::now();
        let remark = step().map_err(|error| format!("step `{name}` failed: {error}"))?;
        summary.push(format!(
            "ok {:>5} s  {name:<30} {remark}",
            start.elapsed().as_secs()
        ));
    }
    println!("\n=== summary ===");
    summary
        .iter()
        .for_each(|line| println!("{}", line.trim_end()));
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

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
