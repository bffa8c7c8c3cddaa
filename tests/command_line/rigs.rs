//! `host-sim rigs`, rig files and `--set`.

use crate::support::{Folder, without_origin};

const PRESETS: [&str; 4] = ["wires", "beam-170", "beam-150", "beam-135"];
const SHORT: &str = "simulate --ratio 1.5 --cycles 30 --transient 20 --format json --quiet";

#[test]
fn the_list_names_every_preset() {
    let ran = Folder::new().run("rigs").well();
    for name in PRESETS {
        assert!(
            ran.out.lines().any(|line| line.starts_with(name)),
            "{ran:?}"
        );
    }
    assert!(ran.out.contains("4.50 Hz") && ran.err.is_empty(), "{ran:?}");
}

/// A rig's name is its file's, so the whole answer is the same to the last byte.
#[test]
fn a_printed_rig_is_the_rig() {
    for name in PRESETS {
        let printed = Folder::new().run(&format!("rigs {name}")).well().out;
        let file = format!("{name}.toml");
        let folder = Folder::new().with(&file, &printed);
        let from_file = folder.run(&format!("{SHORT} --rig {file}")).well();
        let by_name = folder.run(&format!("{SHORT} --rig {name}")).well();
        assert_eq!(
            without_origin(from_file.json()),
            without_origin(by_name.json())
        );
        let again = folder.run(&format!("rigs {file}")).well();
        assert_eq!(again.out, printed);
    }
}

/// A file that began with the name of another file would be refused.
#[test]
fn only_a_preset_is_printed_as_one() {
    let folder = Folder::new().with("mine.toml", "preset = \"wires\"\nmass_kg = 0.5\n");
    let said = "A file may also begin with preset";
    assert!(folder.run("rigs wires").well().out.contains(said));
    let mine = folder.run("rigs mine.toml").well().out;
    assert!(
        mine.contains("mass_kg = 0.5") && !mine.contains(said),
        "{mine}"
    );
}

#[test]
fn set_is_the_same_as_a_line_in_a_rig_file() {
    let lines = [
        ("mass_kg", "0.31"),
        ("gap_mm", "0.5"),
        ("natural_frequency_hz", "2"),
        ("contact_stiffness_n_per_m", "4e6"),
    ];
    let file: String = lines
        .iter()
        .map(|(key, value)| format!("{key} = {value}\n"))
        .collect();
    let folder = Folder::new().with("wires.toml", format!("preset = \"wires\"\n{file}"));
    let set: String = lines
        .iter()
        .map(|(key, value)| format!(" --set {key}={value}"))
        .collect();
    let by_file = folder.run(&format!("{SHORT} --rig wires.toml")).well();
    let by_set = folder.run(&format!("{SHORT}{set}")).well();
    // What is set shows in the rig's name; the rest is the same.
    let mut set = without_origin(by_set.json());
    assert!(
        set["rig"].as_str().unwrap().contains("mass_kg=0.31"),
        "{set}"
    );
    set["rig"] = "wires".into();
    assert_eq!(without_origin(by_file.json()), set);
    assert_ne!(by_file.out, folder.run(SHORT).well().out);
    assert_eq!(
        by_file.json()["frequency_hz"],
        3.0,
        "1.5 times the natural frequency set"
    );

    let by_gap = folder.run(&format!("{SHORT} --gap 0.5")).well();
    let by_set = folder.run(&format!("{SHORT} --set gap_mm=0.5")).well();
    assert_eq!(without_origin(by_gap.json()), without_origin(by_set.json()));
}

#[test]
fn every_command_takes_the_rig_file() {
    let folder = Folder::new().with("mine.toml", "preset = \"beam-150\"\namplitude_mm = 0.5\n");
    let rig = "--rig mine.toml --format json --quiet";
    let swept = folder
        .run(&format!(
            "sweep --ratio 1.5:1.6:0.1 --cycles 30 --transient 20 {rig}"
        ))
        .well();
    assert_eq!(swept.json()[0]["rig"], "mine");
    let picked = folder.run(&format!("pick --nominal {rig}")).well();
    assert_eq!(picked.json()["rig"], "mine");
    assert_eq!(picked.json()["shaker"]["stroke_mm"], 1.0);
    assert_eq!(folder.names(), ["mine.toml"]);
}
