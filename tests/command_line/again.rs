//! Every command that writes files, run again in one folder: as before, and after its rig file was edited.

use std::collections::BTreeMap;

use crate::emulate::STOPPED;
use crate::shell::commands;
use crate::support::{Folder, assert_refused};

/// The cheapest form of each. `chapter` has its test in `chapter.rs`, as it takes long.
const WRITE: &[&str] = &[
    "pick --samples 0 --cart prescribed --rig mine.toml --report mine.html",
    "pick --samples 0 --cart prescribed --rig mine.toml --gap 0:0:1 --starts 1",
    "pick --samples 0 --cart prescribed --rig mine.toml --over gap_mm=0",
    "pick --nominal --cart prescribed --rig mine.toml --beside wires",
    "pick --nominal --cart prescribed --rig mine.toml --objective rop --threshold-n 50",
    "pick --nominal --cart prescribed --all",
    "simulate --ratio 2 --cycles 60 --transient 40 --rig mine.toml",
    "sweep --ratio 2 --cycles 20 --transient 10 --rig mine.toml",
    "sweep --ratio 2 --cycles 20 --transient 10 --rig mine.toml --over gap_mm=0.0,1",
    "map --gap 0 --ratio 2 --cycles 20 --rig mine.toml",
    "orbits --ratio 1.5:1.6 --starts 1 --periods 1 --rig mine.toml",
    "drill --threshold-n 25 --frequency 3.6 --cart prescribed --rig mine.toml",
    "modes --ratio 2 --modes 1 --cycles 10 --transient 5 --rig beam.toml",
    "basins --ratio 2 --grid 2 --samples 0 --cycles 20 --recorded 10 --rig mine.toml",
    "bifurcation --ratio 2 --cycles 20 --recorded 10 --rig mine.toml",
    "poincare --ratio 1.5 --points 10 --transient 10 --rig mine.toml",
    "emulate short.toml",
    "trials --count 1 --seconds 20 --rig wires",
    "figures --coarse --only 3.6",
    "contact --speed 0.1:0.2:0.1 --rig mine.toml",
    "drop --impacts 2 --rig mine.toml",
    "identify drop.csv --misfit force --impacts 2 --rig mine.toml",
    "compare record.csv --ratio 2 --cycles 60 --transient 40 --rig mine.toml",
    "man pages",
];

/// These write no file; `rig new`, `link record` and `link sweep` write none that is there already.
const WRITE_NONE: &[&str] = &[
    "chapter",
    "scenarios",
    "replay",
    "link",
    "lab",
    "rig",
    "rigs",
    "completions",
];

fn contents(folder: &Folder) -> BTreeMap<String, Vec<u8>> {
    let names = folder.names().into_iter();
    let read = |name: String| (name.clone(), std::fs::read(folder.path(&name)).unwrap());
    names.map(read).collect()
}

#[test]
fn every_command_answers_again_and_after_an_edit_and_says_what_it_replaced() {
    let edited = |folder: Folder, mass_kg: f64| {
        let scenario = STOPPED.replace("[true_rig]", &format!("[true_rig]\nmass_kg = {mass_kg}"));
        let rig = |preset: &str| format!("preset = \"{preset}\"\nmass_kg = {mass_kg}\n");
        folder
            .with("mine.toml", rig("wires"))
            .with("beam.toml", rig("beam-170"))
            .with("short.toml", scenario)
    };
    let folder = edited(Folder::new(), 0.298);
    for command in commands() {
        let named = |line: &&str| line.split(' ').next() == Some(&command);
        let (writes, none) = (WRITE.iter().any(named), WRITE_NONE.contains(&&*command));
        assert!(writes != none, "{command}: in which list?");
    }
    let drop = "drop --impacts 3 --noise-n 0.1 --format csv --quiet";
    let drop = folder.run(drop).well().out;
    let record = "simulate --ratio 2 --cycles 60 --transient 40 --out s --quiet";
    folder.run(record).well();
    let record = folder.read_made("s/simulate", "-history.csv");
    let folder = folder.with("drop.csv", drop).with("record.csv", record);

    let replaced = |folder: &Folder, line: &str| {
        let ran = folder.run(line).well();
        (ran.out + &ran.err).contains("(replaced)")
    };
    for line in WRITE {
        assert!(!replaced(&folder, line), "{line}: another command's files");
    }
    let folder = edited(folder, 0.305);
    for line in WRITE {
        let before = contents(&folder);
        assert!(replaced(&folder, line), "{line}: after an edit");
        let after = contents(&folder);
        assert!(before.keys().eq(after.keys()), "{line}");
        let changed = before != after;
        assert!(
            changed || !line.contains(".toml"),
            "{line}: the old content"
        );
    }
    // Every command writes in the same way: some are enough for a run that changes nothing.
    for line in WRITE.iter().step_by(4) {
        let before = contents(&folder);
        assert!(replaced(&folder, line), "{line}: the third time");
        assert!(before == contents(&folder), "{line}: other bytes");
    }
    let lines = [
        "record mine.toml",
        "sweep --from-hz 3 --to-hz 4 --step-hz 1 --csv mine.toml",
    ];
    let lines = lines.map(|line| {
        (
            format!("link nowhere {line}"),
            "a measurement is not replaced",
        )
    });
    assert_refused(&folder, lines);
    assert_refused(
        &folder,
        [("rig new mine.toml", "exists already and is not replaced")],
    );
}
