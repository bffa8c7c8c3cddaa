//! `cargo xtask test`: what must hold before a change is done. The desktop's part (the Python package last), the firmware's, and that of
//! page and site need nothing of each other and run side by side: the emulator, the linker that optimises a whole image, and
//! a browser that waits keep one processor busy each. Within a part one step follows the other, and the first that fails ends it.

use std::{
    env, fs,
    fs::File,
    path::PathBuf,
    process::{Child, Command, Stdio},
};

use clap::Args;

use crate::{
    JobResult,
    boards::{self, BuiltBoard},
    command::{self, cargo, run_tee},
    desktop::Build,
    dist, firmware, forecast, liveness, msrv, pil, site, size,
    timing::{Spent, Stopwatch},
    tools,
};

/// A step ends with a remark for the summary, often empty.
type Step = (&'static str, fn() -> JobResult<String>);

/// The part of the checks that is run; every part, side by side, where none is chosen.
#[derive(Args, Clone, Copy, Debug, Default, PartialEq)]
#[group(multiple = false)]
pub struct CheckPart {
    /// What needs no microcontroller
    #[arg(long)]
    pub host: bool,
    /// What needs one, or QEMU
    #[arg(long)]
    pub firmware: bool,
    /// What people read, and what needs a browser
    #[arg(long)]
    pub pages: bool,
}

/// The step before the parts: lists the tools that are there.
const TOOLS: Step = ("tools", || silent(tools::list()));

const HOST: &[Step] = &[
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
    ("release archive", || silent(dist::check(&Build::Tested))),
];

const PAGES: &[Step] = &[
    ("site's pages and their links", || {
        silent(site::run(true).map(drop))
    }),
    ("page in a browser", page),
];

/// What needs an interpreter.
const PYTHON: &[Step] = &[("Python package", || {
    silent(crate::python::run(&[], &Build::Tested))
})];

const FIRMWARE: &[Step] = &[
    ("model for the microcontroller", || {
        silent(firmware::build_shared())
    }),
    ("control path free of panics", || {
        silent(firmware::check_panic_free())
    }),
    ("firmware, nucleo", || {
        board(&boards::named(boards::NUCLEO)?)
    }),
    ("firmware, qemu", || board(&boards::named(boards::QEMU)?)),
    ("firmware run in QEMU, budgets", || silent(size::run())),
    ("forecast in QEMU", || silent(forecast::run())),
    ("processor in the loop", || {
        let run = |plan| pil::run(plan, &Build::Tested);
        silent(pil::PilPlan::checks().iter().try_for_each(run))
    }),
    ("image in the model of the board", || {
        silent(crate::board::run(&["--short".into()], &Build::Tested))
    }),
    ("model's processor against Unicorn", oracle),
];

fn silent(outcome: JobResult) -> JobResult<String> {
    outcome.map(|()| String::new())
}

/// The remark of a step that this machine does without.
pub fn skipped(why: impl std::fmt::Display) -> JobResult<String> {
    let remark = format!("skipped: {why}");
    println!("{remark}");
    Ok(remark.lines().next().unwrap_or_default().into())
}

/// A machine that cannot have Unicorn does without.
fn oracle() -> JobResult<String> {
    match crate::board::oracle() {
        Ok(oracle) => silent(crate::board::compare(
            crate::board::FEW_STATES,
            &Build::Tested,
            &oracle,
        )),
        Err(error) => skipped(error),
    }
}

/// A machine for which no browser, nothing to drive it, or no Rust for it can be had does without.
fn page() -> JobResult<String> {
    let lacking = tools::wasm_toolchain().err();
    let lacking = lacking.or_else(|| tools::chromium().err());
    let lacking = lacking.or_else(|| crate::web::environment().err());
    if let Some(error) = lacking {
        return skipped(error);
    }
    silent(crate::web::test(&[], &Build::Tested))
}

/// Known faults are not looked up: they are fetched from the network, and may be new without any change here.
fn dependencies() -> JobResult<String> {
    if command::find("cargo-deny").is_none() {
        return skipped("no cargo-deny here; type: cargo install --locked cargo-deny");
    }
    let mut deny = cargo();
    silent(command::run(
        deny.args(["deny", "check", "licenses", "bans", "sources"]),
    ))
}

fn board(board: &BuiltBoard) -> JobResult<String> {
    firmware::lint(board)?;
    firmware::build(board)?;
    Ok(format!("built with {}", tools::toolchain()?.describe()))
}

fn host_tests() -> JobResult<String> {
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
    outcome: JobResult<String>,
}

/// Runs a part, and says in the end what each step took.
pub fn run(part: &CheckPart) -> JobResult {
    match part {
        CheckPart { host: true, .. } => steps(&[HOST, PYTHON, PAGES].concat()),
        CheckPart { firmware: true, .. } => steps(&[&[TOOLS], FIRMWARE].concat()),
        CheckPart { pages: true, .. } => steps(PAGES),
        _ => side_by_side(),
    }
}

/// Runs the steps up to the first that fails.
fn steps(steps: &[Step]) -> JobResult {
    let mut rows: Vec<Row> = Vec::new();
    for (name, step) in steps {
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

/// A part run by this program once more, with its output in a file until the desktop's has ended.
struct Beside {
    part: &'static str,
    child: Child,
    log: PathBuf,
}

impl Beside {
    fn start(part: &'static str) -> JobResult<Self> {
        let log = command::root().join(format!("target/xtask-{part}.log"));
        let file = File::create(&log)?;
        let mut command = Command::new(env::current_exe()?);
        command
            .args(["test", &format!("--{part}")])
            .stdin(Stdio::null())
            .stdout(file.try_clone()?)
            .stderr(file);
        println!("\n{part} runs beside; its output is in {}", log.display());
        Ok(Self {
            part,
            child: command.spawn()?,
            log,
        })
    }

    /// Waits for its end, and shows its output.
    fn finish(&mut self) -> JobResult {
        let part = self.part;
        println!("\nwaiting for {part}");
        // It gives up its own steps.
        let status = self.child.wait()?;
        println!("\n=== {part} ===");
        println!("{}", String::from_utf8_lossy(&fs::read(&self.log)?));
        if status.success() {
            Ok(())
        } else {
            Err(format!("the part of {part} failed; its output is above").into())
        }
    }
}

fn side_by_side() -> JobResult {
    steps(&[TOOLS])?;
    let mut beside = [Beside::start("firmware")?, Beside::start("pages")?];
    let mut outcome = steps(&[HOST, PYTHON].concat());
    for part in &mut beside {
        if outcome.is_err() {
            liveness::end(&mut part.child);
        } else {
            outcome = part.finish();
        }
    }
    outcome
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
