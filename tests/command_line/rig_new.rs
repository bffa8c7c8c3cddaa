//! `host-sim rig new`: a rig file from what can be measured.

use crate::support::{Folder, number, pair};

const WIRES: &str = "rig new mine.toml --support wires --mass 298;299;297.5g --swings 20 \
    --swing-time 10.99;11.02;10.95s --stroke 1.78+-0.05mm --cart-mass 5.38kg --shaker-loop 50+-5Hz \
    --restitution 0.32+-0.02 --contact-time 0.57+-0.03ms";

#[test]
fn pick_reads_the_uncertainty_that_was_measured_and_options_come_before_it() {
    let folder = Folder::new();
    let ran = folder.run(WIRES).well();
    let text = folder.read("mine.toml");
    for said in [
        "mass_kg = 0.298167  # weighed: 298;299;297.5g",
        "natural_frequency_hz = 1.82",
        "# 20 swings in 10.99;11.02;10.95s",
        "amplitude_percent = 2.9  # as stated",
        "shaker_loop_percent = 10.0",
    ] {
        assert!(text.contains(said), "{said} is not in {text}");
    }
    assert!(ran.out.contains("What to measure better first"), "{ran:?}");
    let few = "--contact-stiffness-percent 0 --contact-damping-percent 0 --gap-tolerance-mm 0";
    let line = format!("pick --rig mine.toml --samples 0 {few} --format json --quiet");
    let whole = folder.run(&line).well().json();
    let u = &whole["uncertainty"];
    assert_eq!(number(u, "amplitude_percent"), 2.9);
    assert_eq!(number(u, "gap_mm"), 0.0);
    assert!((0.6..0.7).contains(&number(u, "mass_percent")), "{u}");
    assert!(number(u, "natural_frequency_percent") < 1.0, "{u}");
    // Natural frequency, amplitude, the masses as one, the loop and its damping, which nobody stated.
    assert_eq!(number(&whole, "corners"), 32.0);
    assert_eq!(whole["cart"], "recoil");
    let sensitivity = whole["sensitivity"].as_array().expect("rows");
    let amplitude = sensitivity
        .iter()
        .find(|row| row["parameter"] == "amplitude_mm");
    let amplitude = amplitude.expect("the amplitude");
    let open = number(amplitude, "force_over_uncertainty_percent");
    assert!((open - 2.9 * number(amplitude, "force_percent")).abs() < 1e-9);
    let [low, high] = pair(&whole, "safe_band_hz");
    assert!(low < 3.6 && high > 3.7, "{low} to {high}");
    let exact = "--natural-frequency-percent 0 --shaker-loop-percent 0 --cart-mass-percent 0";
    let other = folder.run(&format!("{line} --amplitude-percent 7 {exact}"));
    let other = other.well().json();
    let v = &other["uncertainty"];
    assert_eq!(number(v, "amplitude_percent"), 7.0);
    assert_eq!(v["mass_percent"], u["mass_percent"]);
    assert_eq!(number(&other, "corners"), 8.0);
}

#[test]
fn an_answer_that_leaves_the_uncertainty_out_says_so() {
    let folder = Folder::new();
    folder.run(WIRES).well();
    let said = "note: rig mine states an uncertainty; this answer is for its values alone";
    let short = "--cycles 20 --transient 10";
    for line in [
        format!("simulate --ratio 2 {short}"),
        format!("sweep --ratio 2 {short}"),
        format!("sweep --ratio 2 {short} --over amplitude_mm=0.5,1"),
        format!("map --gap 0 --ratio 2 {short}"),
        "orbits --ratio 2:2.1 --starts 1 --periods 1".to_owned(),
        "bifurcation --ratio 2 --cycles 20 --recorded 10".to_owned(),
        "basins --ratio 2 --grid 2 --samples 0 --cycles 20 --recorded 10".to_owned(),
        "poincare --ratio 2 --points 10 --transient 10".to_owned(),
    ] {
        let noted = |rig: &str| {
            let ran = folder
                .run(&format!("{line} --rig {rig} --format json"))
                .well();
            ran.err.contains(said)
        };
        assert!(noted("mine.toml"), "{line}");
        assert!(!noted("wires"), "{line}");
    }
}

#[test]
fn a_rig_file_is_never_replaced_nor_written_by_halves() {
    let folder = Folder::new().with("mine.toml", "mass_kg = 1\n");
    let ran = folder.run(WIRES);
    assert_eq!((ran.code, ran.err.lines().count()), (Some(2), 1), "{ran:?}");
    assert!(ran.err.contains("is not replaced"), "{ran:?}");
    assert_eq!(folder.read("mine.toml"), "mass_kg = 1\n");

    let folder = Folder::new();
    for (line, said) in [
        (
            "rig new a.toml --support wires --mass 298g",
            "--stroke, --cart-mass",
        ),
        (
            "rig new a.toml --support beams --mass 298g",
            "--swings with --swing-time (or --natural-frequency), --stroke",
        ),
        (
            &*WIRES.replace("0.57+-0.03", "2+-2"),
            "--contact-time: 2+-2ms reaches down to 0 ms",
        ),
        (
            &*WIRES.replace("0.32+-0.02", "0.14"),
            "--restitution: 0.14 reaches from 0.1350 to 0.1450",
        ),
        (&*format!("{WIRES} --gap 400mm"), "400mm is out of range"),
        (
            &*format!("{WIRES} --gap 50mm"),
            "--gap 50mm is more than half the wires' length",
        ),
        (
            &*WIRES.replace("1.78+-0.05mm", "wide"),
            "'wide' is no number",
        ),
        (
            &*WIRES.replace("0.32+-0.02", "0.1"),
            "0.14 (a contact damped critically)",
        ),
        (
            &*WIRES.replace("1.78+-0.05", "1780"),
            "1780mm is out of range",
        ),
    ] {
        let ran = folder.run(line);
        assert_eq!((ran.code, ran.err.lines().count()), (Some(2), 1), "{ran:?}");
        assert!(ran.err.contains(said), "{said}: {ran:?}");
        assert_eq!(ran.out, "");
    }
    assert_eq!(folder.names(), Vec::<String>::new());
}

/// What is left out, cut off or contradicted is said where it stands.
#[test]
fn a_source_says_what_decided() {
    let made = |line: &str| {
        let folder = Folder::new();
        let ran = folder.run(line).well();
        (folder.read("mine.toml"), ran.err)
    };
    let wide = WIRES.replace("298;299;297.5g", "1.7+-5kg");
    let (text, _) = made(&wide);
    let said = "mass_percent = 49.5  # the most that is allowed; as stated: 294 %";
    assert!(text.contains(said), "{text}");
    let (text, _) = made(&format!("{WIRES} --surface rock"));
    let said = "# contact time 0.57+-0.03ms; it decides, not the surface (rock)";
    assert!(text.contains(said), "{text}");
    let (_, notes) = made(&format!("{WIRES} --wire-length 300mm"));
    assert!(notes.contains(" % less than the swings"), "{notes}");
    let (_, notes) = made(&format!("{WIRES} --wire-length 30mm"));
    assert!(notes.contains(" % more than the swings"), "{notes}");
    // As the tutorial has it; a worse reading is known to a factor.
    let (text, _) = made(&WIRES.replace("0.57+-0.03", "0.57+-0.05"));
    assert!(text.contains("contact_stiffness_percent = 24.0"), "{text}");
    let (text, _) = made(&WIRES.replace("0.57+-0.03", "4+-1"));
    assert!(text.contains("contact_stiffness_factor = 1.8"), "{text}");
}

#[test]
fn beams_take_a_drop_test_and_a_ring_down() {
    let folder = Folder::new();
    let made = folder
        .run("drop --rig beam-170 --noise-n 0.2 --format csv --quiet")
        .well();
    let folder = folder.with("drop.csv", made.out);
    let ran = folder
        .run(
            "rig new mine.toml --support beams --mass 298g --swings 100 --swing-time 22.2s \
             --ring-down 5:3.02445:20 --stroke 1.78mm --cart-mass 5.38kg --drop-test drop.csv",
        )
        .well();
    assert!(ran.err.contains("the shaker is not known"), "{ran:?}");
    let rig: String = folder.read("mine.toml");
    let value = |key: &str| {
        let line = rig.lines().find(|line| line.starts_with(key)).expect(key);
        let value = line[key.len()..].trim_start_matches(" = ");
        let value = value.split_whitespace().next().expect("a value");
        value.parse::<f64>().expect("a number")
    };
    assert!(
        (value("contact_stiffness_n_per_m") / 5.5e6 - 1.0).abs() < 0.05,
        "{rig}"
    );
    assert!(
        (value("contact_damping_n_s_per_m") / 1.2e3 - 1.0).abs() < 0.05,
        "{rig}"
    );
    assert!((value("damping_ratio") / 0.004 - 1.0).abs() < 1e-3, "{rig}");
    // Known to what the drop test says, and by one reading of the stopwatch.
    assert!(value("contact_stiffness_percent") < 10.0, "{rig}");
    assert!(
        (value("natural_frequency_percent") - 0.94).abs() < 0.02,
        "{rig}"
    );
}

#[test]
fn a_mass_in_grams_is_doubted() {
    let folder = Folder::new();
    let line = "simulate --ratio 1.5 --cycles 30 --transient 20 --set mass_kg=298 --format json";
    let ran = folder.run(line).well();
    assert!(
        ran.err
            .contains("if it was measured in grams, write mass_kg = 0.298"),
        "{ran:?}"
    );
    let quiet = folder.run(&format!("{line} --quiet")).well();
    assert!(quiet.err.contains("mass_kg = 0.298"), "{quiet:?}");
}

#[test]
fn two_settings_stand_side_by_side() {
    let folder = Folder::new();
    let ran = folder
        .run("pick --nominal --beside wires,amplitude_mm=1.2,gap_mm=0.5 --out o")
        .well();
    for said in [
        "wires, gap 0.0 mm",
        "wires (amplitude_mm=1.2), gap 0.5 mm",
        "amplitude_mm                 0.89  |  1.2",
        "gap_mm                       0.0  |  0.5",
    ] {
        assert!(ran.out.contains(said), "{said} is not in {}", ran.out);
    }
    assert!(!ran.out.contains("mass_kg"), "{}", ran.out);
    let svg = folder.read("o/pick-wires-beside-wires-amplitude_mm=1.2-gap_mm=0.5-nominal.svg");
    assert!(svg.contains("wires (amplitude_mm=1.2)"));
    let refused = folder.run("pick --nominal --beside wires,mas_kg=1");
    assert!(
        refused
            .err
            .contains("--beside wires,mas_kg=1: there is no parameter"),
        "{refused:?}"
    );
}

#[test]
fn a_report_is_one_page_that_needs_no_other_file() {
    let folder = Folder::new();
    let ran = folder
        .run("pick --nominal --quiet --out o --report r.html")
        .well();
    let html = folder.read("r.html");
    assert_eq!(html.matches("<svg").count(), 1);
    for (open, close) in [
        ("<dl>", "</dl>"),
        ("<dt>", "</dt>"),
        ("<figure>", "</figure>"),
    ] {
        assert_eq!(
            html.matches(open).count(),
            html.matches(close).count(),
            "{open}"
        );
    }
    for said in [
        "run it at 3.6",
        "What to measure first",
        "Assumptions",
        "mass_kg = 0.298",
    ] {
        assert!(html.contains(said), "{said}");
    }
    assert!(
        !html.contains("src=") && !html.contains("<link"),
        "another file is needed"
    );
    let head = ran.out.lines().next().expect("a first line");
    let force = ran
        .out
        .lines()
        .find_map(|line| line.trim().strip_prefix("force"));
    let heading = format!("<h1>{head}, {}</h1>", force.expect("a force").trim());
    assert!(html.contains(&heading), "{heading}");
    // The sentence stands once.
    let why = ran.out.lines().nth(1).expect("a sentence");
    assert_eq!(html.matches(&why[..40]).count(), 1, "{why}");
    // The same request replaces it by the same, and another by its own.
    assert!(html.contains("<metadata id=\"made_from\">{\"program\":\"host-sim\""));
    folder
        .run("pick --nominal --quiet --out o --report r.html")
        .well();
    assert_eq!(folder.read("r.html"), html);
    let other = "pick --nominal --set mass_kg=0.31 --quiet --out o --report";
    folder.run(&format!("{other} r.html")).well();
    assert_ne!(folder.read("r.html"), html);
    let refused = folder.run("pick --nominal --report r.doc");
    assert!(refused.err.contains("a report is FILE.html"), "{refused:?}");
}

#[test]
fn a_sweep_over_a_parameter_is_what_set_gives() {
    let line = "sweep --ratio 2 --cycles 60 --transient 40 --format json --quiet";
    let folder = Folder::new();
    let over = folder
        .run(&format!(
            "{line} --over contact_stiffness_n_per_m=1e6:1e7:log3 --out o"
        ))
        .well()
        .json();
    let rows = over.as_array().expect("rows");
    assert_eq!(rows.len(), 3);
    for row in rows {
        let value = number(row, "value");
        let alone = folder
            .run(&format!("{line} --set contact_stiffness_n_per_m={value:?}"))
            .well()
            .json();
        assert_eq!(row["parameter"], "contact_stiffness_n_per_m");
        assert_eq!(row["force_n"], alone[0]["force_n"], "{value}");
    }
    assert_eq!(
        folder.ends("o/sweep-wires-ratio-2-over"),
        [".csv", ".json", ".png", ".svg"]
    );
    // The ratio follows the natural frequency.
    let hz = folder.run(&format!("{line} --over natural_frequency_hz=2.0,3"));
    let hz = hz.well().json();
    assert_eq!(
        (
            number(&hz[0], "frequency_hz"),
            number(&hz[1], "frequency_hz")
        ),
        (4.0, 6.0)
    );
    for (over, said) in [
        ("mas_kg=1:2:lin3", "did you mean 'mass_kg'"),
        ("mass_kg=1:2", "FROM:TO:logN"),
        ("mass_kg=-1.0,1", "--over mass_kg: mass_kg is -1"),
    ] {
        let ran = folder.run(&format!("{line} --over {over}"));
        assert_eq!((ran.code, ran.err.lines().count()), (Some(2), 1), "{ran:?}");
        assert!(ran.err.contains(said), "{said}: {ran:?}");
    }
    let ran = folder.run("sweep --ratio 1:2:0.5 --over mass_kg=1.0,2");
    assert!(ran.err.contains("one drive frequency"), "{ran:?}");
}

#[test]
fn a_limit_that_cannot_be_kept_is_answered_with_the_nearest_that_can() {
    let folder = Folder::new();
    let line = "pick --nominal --format json --quiet";
    let ran = folder.run(&format!("{line} --max-force-n 1"));
    let nearest = ran
        .err
        .split("max_force_n = ")
        .last()
        .expect("a limit")
        .trim();
    assert_eq!(ran.code, Some(2));
    assert!(ran.err.contains("the nearest that can be kept"), "{ran:?}");
    folder
        .run(&format!("{line} --max-force-n {nearest}"))
        .well();
}
