//! What the program prints for a person, as files in `snapshots/`. After a change that is meant,
//!
//!     UPDATE_EXPECT=1 cargo test -p host-sim --test command_line snapshots
//!
//! writes them anew; the change is then read in `git diff`. Lines here give the same text on every machine: short
//! runs, few digits, nothing that depends on time, paths or the number of threads.

use expect_test::expect_file;

use crate::support::{Folder, Ran};

/// Commands and what they answer.
const ANSWERS: &[(&str, &str)] = &[
    ("pick", "pick"),
    (
        "pick-beam",
        "pick --rig beam-150 --nominal --max-force-n 80",
    ),
    ("pick-all", "pick --all --nominal"),
    ("pick-gaps", "pick --gap 0:2.4:1.2 --nominal --starts 20"),
    ("simulate", "simulate --gap 1 --ratio 1.5"),
    ("simulate-silent", "simulate --gap 2.4 --ratio 0.8"),
    (
        "simulate-switch",
        "simulate --ratio 3.8 --engine switch --cart prescribed --out o",
    ),
    ("sweep", "sweep --gap 1 --ratio 1:4:0.25 --direction up"),
    ("map", "map --gap 0:3:0.5 --ratio 1:4:0.25 --audit 10"),
    (
        "orbits",
        "orbits --gap 1 --ratio 1:2.5 --starts 8 --periods 1",
    ),
    (
        "orbits-curves",
        "orbits --curves --gap 0:1:0.5 --ratio 1:3 --starts 6",
    ),
    (
        "basins",
        "basins --ratio 2 --gap-ratio 2 --grid 20x15 --cycles 100 --recorded 40 --samples 50 --until 200",
    ),
    (
        "bifurcation",
        "bifurcation --gap 1 --ratio 1.4:2:0.1 --direction all",
    ),
    (
        "poincare",
        "poincare --ratio 1.5 --points 100 --transient 200",
    ),
    (
        "modes",
        "modes --rig beam-170 --ratio 1.6:1.8:0.1 --modes 1,3 --cycles 60 --transient 40",
    ),
    ("contact", "contact"),
    ("contact-figure-3-3", "contact --figure-3-3"),
    ("drop", "drop --impacts 2"),
    ("scenarios", "scenarios"),
    (
        "sweep-over",
        "sweep --ratio 2 --over contact_stiffness_n_per_m=1e5:1e7:log5",
    ),
    (
        "pick-beside",
        "pick --nominal --beside wires,amplitude_mm=1.2",
    ),
    ("rigs", "rigs"),
    ("rigs-wires", "rigs wires"),
    ("rigs-beam-135", "rigs beam-135"),
];

#[test]
fn answers() {
    for (name, line) in ANSWERS {
        let folder = Folder::new();
        let shown = shown(line, &folder.run(line));
        expect_file![format!("snapshots/{name}.txt")].assert_eq(&shown);
    }
}

#[test]
fn help() {
    for command in [
        "",
        "pick",
        "simulate",
        "sweep",
        "map",
        "orbits",
        "drill",
        "modes",
        "basins",
        "bifurcation",
        "poincare",
        "emulate",
        "scenarios",
        "replay",
        "figures",
        "contact",
        "drop",
        "identify",
        "compare",
        "rig new",
        "rigs",
        "lab",
        "link",
        "link start",
        "link set",
        "link record",
        "link sweep",
        "link monitor",
    ] {
        let line = format!("{command} --help");
        let name = format!("help {command}").trim_end().replace(' ', "-");
        let shown = shown(line.trim_start(), &Folder::new().run(&line));
        expect_file![format!("snapshots/{name}.txt")].assert_eq(&shown);
    }
}

/// One line for each command line that cannot be used.
const REFUSED: &[&str] = &[
    "pik",
    "pcik",
    "pick wires",
    "pick --rgi wires",
    "emulate --rig wires",
    "pick --set mass_kg=0.3 --set mass_kg=0.4",
    "pick --beside wires,mass_kg=0.3,mass_kg=0.4",
    "pick --rig wire",
    "pick --rig missing.toml",
    "pick --set mass_kg=-1",
    "pick --set mas_kg=1",
    "pick --gap -100",
    "pick --engine switch",
    "pick --nominal --max-force-n 1",
    "pick --amplitude-percent 100",
    "pick --all --rig wires",
    "simulate",
    "simulate --ratio 0",
    "simulate --ratio 1 --frequency 2",
    "simulate --ratio 1.5 --initial 80,0",
    "simulate --ratio 1.5 --gap 0:1:0.5",
    "simulate --ratio 1.5 --tick-us 20",
    "simulate --ratio 1.5 --cycles 10 --transient 10",
    "simulate --ratio 1.5 --out a-file",
    "sweep --ratio 2:1:0.1",
    "sweep --ratio 1:2:0",
    "sweep --ratio 1.5 --measured column.csv",
    "map --gap 0:1:0.5 --ratio 1:2:0.5 --recorded 0",
    "map --gap 0 --ratio 1.5 --beside wires --out o",
    "orbits --gap 0:1",
    "rig new mine.toml --support wires --mass 298g",
    "rig new mine.toml --support beams --mass 298g --swings 20 --swing-time 4.4s --stroke 1.8mm --cart-mass heavy",
    "pick --report mine.doc",
    "sweep --ratio 2 --over mas_kg=1:2:lin5",
    "sweep --ratio 2 --over mass_kg=1:0.1:lin5",
    "basins --ratio 2 --grid 0",
    "poincare --ratio 2 --phase 1.5",
    "contact --gap 1",
    "contact --speed 0:1:0.1",
    "modes --rig wires --ratio 2",
    "drop --release-mm 5",
    "identify missing.csv",
    "identify column.csv --seek-exponent",
    "identify flat.csv",
    "scenarios feild",
    "figures --only 3.7 --out o",
];

#[test]
fn refusals() {
    // A record that was cut before the first impact.
    let flat = (0..100).map(|i| format!("{},0\n", f64::from(i) * 1e-4));
    let flat = "time_s,force_n\n".to_owned() + &flat.collect::<String>();
    let folder = Folder::new()
        .with("a-file", "")
        .with("column.csv", "time_s,force\n1,2\n")
        .with("flat.csv", flat);
    let shown: String = REFUSED
        .iter()
        .map(|line| shown(line, &folder.run(line)) + "\n")
        .collect();
    expect_file!["snapshots/refusals.txt"].assert_eq(&shown);
    assert_eq!(folder.names(), ["a-file", "column.csv", "flat.csv"]);
}

fn shown(line: &str, ran: &Ran) -> String {
    let code = match ran.code {
        Some(0) => String::new(),
        code => format!("exit code {}\n", code.unwrap_or(-1)),
    };
    let err = match ran.err.as_str() {
        "" => String::new(),
        err => format!("--- standard error\n{err}"),
    };
    format!("$ host-sim {line}\n{}{err}{code}", ran.out)
}
