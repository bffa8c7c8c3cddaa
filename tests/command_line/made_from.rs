//! Every answer says what it was made from, and replaces nothing but an answer.

use serde_json::Value;

use crate::support::{Folder, assert_refused, assert_svg_shows};

const RUN: &str = "simulate --ratio 1.5 --cycles 20 --transient 10";

/// What the JSON `text` says it was made from: the last field, of a list that of its first object.
fn made_from(text: &str) -> Value {
    let answer: Value = serde_json::from_str(text).unwrap_or_else(|e| panic!("{e}: {text}"));
    let carrier = answer.as_array().map_or(&answer, |list| &list[0]);
    let (key, value) = carrier.as_object().unwrap().iter().next_back().unwrap();
    assert_eq!(key, "made_from", "{text}");
    value.clone()
}

#[test]
fn every_answer_carries_program_rig_and_options() {
    for (line, command) in [
        (RUN, "simulate"),
        (
            "sweep --ratio 1.5:1.6:0.1 --cycles 20 --transient 10",
            "sweep",
        ),
        ("pick --nominal", "pick"),
        ("pick --all --nominal --cart prescribed", "pick"),
        ("map --ratio 1.5:1.6:0.1 --gap 0 --cycles 20", "map"),
        ("orbits --ratio 1.5:1.6 --starts 1 --periods 1", "orbits"),
        ("contact --speed 0.1:0.2:0.1", "contact"),
        ("drop --impacts 1", "drop"),
        (
            "bifurcation --ratio 1.5:1.6:0.1 --cycles 20 --recorded 10",
            "bifurcation",
        ),
        (
            "poincare --ratio 1.5 --points 10 --transient 10",
            "poincare",
        ),
        (
            "basins --ratio 2 --grid 2 --samples 0 --cycles 20 --recorded 10",
            "basins",
        ),
    ] {
        let ran = Folder::new()
            .run(&format!("{line} --format json --quiet"))
            .well();
        let made = made_from(&ran.out);
        assert_eq!(made["program"], "host-sim", "{line}");
        assert_eq!(made["version"], env!("CARGO_PKG_VERSION"));
        let again = made["command"].as_str().unwrap();
        assert!(
            again.starts_with(&format!("host-sim {command} ")),
            "{again}"
        );
        assert!(!again.contains("--quiet") && !again.contains("--format"));
        let rig = &made["rigs"][0];
        assert_eq!(rig["name"], "wires", "{line}");
        assert_eq!(rig["parameters"]["mass_kg"], 0.298);
        assert_eq!(rig["parameters"]["contact_stiffness_n_per_m"], 5.5e6);
    }
}

#[test]
fn seed_uncertainty_and_defaults_are_in_it() {
    let ran = Folder::new()
        .run("pick --samples 0 --seed 7 --format json --quiet")
        .well();
    let made = made_from(&ran.out);
    assert_eq!(made["seed"], 7);
    assert_eq!(made["uncertainty"]["contact_stiffness_percent"], 20.0);
    assert_eq!(made["uncertainty"]["cart_mass_percent"], 5.0);
    assert_eq!(made["options"]["starts"], 400, "a default");
    assert_eq!(made["rigs"][0]["cart"], "recoil");
    assert!(made["rigs"][0]["parameters"]["shaker_loop_hz"].is_number());
    let ran = Folder::new()
        .run("pick --nominal --format json --quiet")
        .well();
    assert_eq!(made_from(&ran.out)["uncertainty"], Value::Null);
}

#[test]
fn pictures_carry_the_same_as_the_json() {
    let folder = Folder::new();
    let line = format!("{RUN} --out o");
    let words: Vec<_> = line.split(' ').collect();
    let ran = folder.command(&words).output().expect("the program runs");
    assert!(ran.status.success());
    let stem = "o/simulate-wires-ratio-1.5-cycles-20-transient-10";
    let said = made_from(&folder.read(&format!("{stem}.json")));
    let svg = folder.read(&format!("{stem}.svg"));
    assert_svg_shows(&svg, &["host-sim simulate --ratio 1.5"]);
    let document = roxmltree::Document::parse(&svg).unwrap();
    let mut nodes = document.descendants();
    let metadata = nodes.find(|n| n.tag_name().name() == "metadata");
    let in_svg: Value = serde_json::from_str(metadata.unwrap().text().unwrap()).unwrap();
    assert_eq!(in_svg, said);
    let png = std::fs::read(folder.path(&format!("{stem}.png"))).unwrap();
    let reader = png::Decoder::new(std::io::Cursor::new(png))
        .read_info()
        .unwrap();
    let texts = &reader.info().utf8_text;
    assert_eq!(texts[0].keyword, "made_from");
    let in_png: Value = serde_json::from_str(&texts[0].get_text().unwrap()).unwrap();
    assert_eq!(in_png, said);
}

#[test]
fn what_is_set_shows_in_title_and_file_name() {
    let folder = Folder::new();
    let line = format!("{RUN} --set mass_kg=0.5 --gap -0.1 --out o");
    let ran = folder.run(&line).well();
    assert!(
        ran.out.starts_with("wires (mass_kg=0.5), gap -0.1 mm"),
        "{ran:?}"
    );
    let names = folder.names();
    let stem = "o/simulate-wires-mass_kg=0.5-ratio-1.5-cycles-20-transient-10-gap-minus-0.1";
    assert!(names.contains(&format!("{stem}.svg")), "{names:?}");
    assert_svg_shows(
        &folder.read(&format!("{stem}.svg")),
        &["wires (mass_kg=0.5)"],
    );
    // The picture at 0.0 mm has another name.
    folder
        .run(&format!("{RUN} --set mass_kg=0.5 --gap 0 --out o"))
        .well();
    assert_eq!(folder.names().len(), 2 * names.len());
}

#[test]
fn the_same_request_writes_the_same_bytes() {
    let folder = Folder::new();
    let line = format!("{RUN} --out o");
    let bytes = || -> Vec<Vec<u8>> {
        let names = folder.names().into_iter();
        let read = |name: String| std::fs::read(folder.path(&name)).unwrap();
        names.map(read).collect()
    };
    folder.run(&line).well();
    let first = bytes();
    folder.run(&format!("{line} --format json")).well();
    assert_eq!(bytes(), first);
}

#[test]
fn what_is_no_answer_of_this_program_stays_where_it_is() {
    let stem = "simulate-wires-ratio-1.5-cycles-20-transient-10";
    let no_answer = "is no answer of this program; move it away, or give --out another folder";
    for end in [".json", ".svg", ".png", ".csv", "-history.csv"] {
        let folder = Folder::new().with(&format!("{stem}{end}"), "{}");
        assert_refused(&folder, [(format!("{RUN} --out ."), no_answer)]);
        let folder = Folder::new();
        std::fs::create_dir(folder.path(&format!("{stem}{end}"))).unwrap();
        assert_refused(
            &folder,
            [(format!("{RUN} --out ."), "is a folder; move it away")],
        );
    }
    let folder = Folder::new()
        .with("mine.html", "<html>")
        .with("index.html", "<html>");
    assert_refused(
        &folder,
        [
            (
                "pick --nominal --report mine.html",
                "mine.html: the file there is no report",
            ),
            (
                "figures --coarse --only 3.6 --out .",
                "index.html is no page of figures",
            ),
        ],
    );
}

#[cfg(unix)]
#[test]
fn a_link_of_a_files_name_is_replaced_and_never_followed() {
    let folder = Folder::new().with("victim", "keep");
    std::fs::create_dir(folder.path("real")).unwrap();
    std::os::unix::fs::symlink("real", folder.path("s")).unwrap();
    for end in [".svg", ".csv"] {
        let link = folder.path(&format!("real/contact-wires-speed-0.1-0.2-0.1{end}"));
        std::os::unix::fs::symlink("../victim", link).unwrap();
    }
    let ran = folder.run("contact --speed 0.1:0.2:0.1 --out s").well();
    assert!(ran.err.contains("(replaced)"), "{ran:?}");
    assert_eq!(folder.read("victim"), "keep");
    let svg = folder.read("real/contact-wires-speed-0.1-0.2-0.1.svg");
    assert_svg_shows(&svg, &["host-sim contact"]);
}

#[test]
fn without_out_a_person_gets_files_in_one_folder_and_a_program_none() {
    for line in ["contact --speed 0.1:0.2:0.1", "drop --impacts 1", RUN] {
        let folder = Folder::new();
        folder.run(&format!("{line} --format csv --quiet")).well();
        assert_eq!(folder.names(), Vec::<String>::new());
        folder.run(line).well();
        let names = folder.names();
        assert!(
            !names.is_empty() && names.iter().all(|n| n.starts_with("out/")),
            "{names:?}"
        );
    }
}

/// What drives a rig and how its files begin. The words about the cart stand in the first line, in every picture and in JSON.
const DRIVEN: &[(&str, &str)] = &[
    (RUN, "simulate"),
    (
        "compare h.csv --ratio 1.5 --cycles 40 --transient 20",
        "compare",
    ),
    (
        "sweep --ratio 1.5:1.6:0.1 --cycles 20 --transient 10",
        "sweep",
    ),
    (
        "sweep --ratio 1.5 --over mass_kg=0.3,0.4 --cycles 20 --transient 10",
        "sweep",
    ),
    ("map --ratio 1.5:1.6:0.1 --gap 0 --cycles 20", "map"),
    (
        "orbits --ratio 1.5:1.6 --starts 1 --periods 1 --checks 0 --behind 2",
        "orbits",
    ),
    (
        "orbits --curves --gap 0:0.05:0.05 --ratio 2.4:2.8 --starts 2",
        "orbits",
    ),
    (
        "bifurcation --ratio 1.5:1.6:0.1 --cycles 20 --recorded 10",
        "bifurcation",
    ),
    (
        "basins --ratio 2 --grid 2 --samples 0 --cycles 20 --recorded 10",
        "basins",
    ),
    (
        "poincare --ratio 1.5 --points 20 --transient 10",
        "poincare",
    ),
    (
        "modes --rig beam-170 --ratio 1.8 --modes 1 --cycles 20 --transient 10",
        "modes",
    ),
];

#[test]
fn every_answer_names_its_cart_which_recoils_where_the_shaker_is_known() {
    // A rig without a shaker: the preset's other keys, written out.
    let bare: String = Folder::new()
        .run("rigs wires")
        .well()
        .out
        .lines()
        .filter(|line| !line.starts_with("shaker"))
        .map(|line| format!("{line}\n"))
        .collect();
    for (command, start) in DRIVEN {
        let mut record = String::from("time_s,displacement_mm\n");
        for k in 0..2000 {
            let t = f64::from(k) * 1e-3;
            record += &format!("{t},{}\n", (std::f64::consts::TAU * 2.73 * t).sin());
        }
        let folder = Folder::new().with("h.csv", record).with("bare.toml", &bare);
        let first = |options: &str| {
            let ran = folder.run(&format!("{command} {options} --quiet")).well();
            ran.out.lines().next().unwrap_or_default().to_owned()
        };
        let said = first("--out o");
        assert!(said.contains("cart recoils"), "{command}: {said}");
        let said = first("--cart prescribed --out p");
        assert!(said.contains("cart prescribed"), "{command}: {said}");
        for (out, words) in [("o", "cart recoils"), ("p", "cart prescribed")] {
            let svg = folder.read_made(&format!("{out}/{start}"), ".svg");
            assert_svg_shows(&svg, &[words]);
        }
        if !command.contains("--rig") {
            let said = first("--rig bare.toml --out b");
            assert!(said.contains("cart prescribed"), "{command}: {said}");
        }
    }
}
