//! Input that cannot be used: exit code 2, one line on standard error that names the fault, nothing on
//! standard output, and no file.

use crate::support::{self, Folder, fault};

/// A folder with what the command lines below refer to.
fn folder() -> Folder {
    Folder::new()
        .with("cut.toml", "preset = \"wires\"\nmass_kg = ")
        .with("typo.toml", "preset = \"wires\"\nmass_kgs = 1\n")
        .with("nan.toml", "preset = \"wires\"\nmass_kg = nan\n")
        .with("bare.toml", "mass_kg = 0.3\n")
        .with("bytes.toml", [0xff, 0xfe, 0x00])
        .with("column.csv", "frequency_hz,force\n1,2\n")
        .with("cut.csv", "frequency_hz,force_n\n1,2\n3")
        .with("comma.csv", "frequency_hz,force_n\n1,\"1,6\"\n")
        .with("words.csv", "frequency_hz,force_n\n1,2\n3,strong\n")
        .with("header.csv", "frequency_hz,force_n\n")
        .with("a-file", "keep")
}

/// As [`support::assert_refused`], in such a folder.
fn assert_refused(lines: &[(&str, &str)]) {
    let folder = folder();
    support::assert_refused(&folder, lines.iter().copied());
    assert_eq!(folder.read("a-file"), "keep");
}

#[test]
fn commands_and_options_that_are_not_there() {
    assert_refused(&[
        ("pik", "unrecognized subcommand 'pik'"),
        ("simulate", "--ratio"),
        ("sweep", "--frequency"),
        ("simulate --rato 1.5", "--ratio"),
        ("simulate --ratio", "a value is required"),
        ("simulate --ratio 1.5 --frequency 2", "cannot be used with"),
        (
            "simulate --ratio 1.5 --format xml",
            "[possible values: text, json, csv]",
        ),
        (
            "simulate --ratio 1.5 --engine magic",
            "[possible values: event, switch]",
        ),
        (
            "sweep --ratio 1:2:0.1 --direction sideways",
            "[possible values: rest, up, down]",
        ),
        ("rigs wires beam-170", "unexpected argument"),
    ]);
}

#[test]
fn parameters_that_cannot_be() {
    assert_refused(&[
        (
            "simulate --ratio 1.5 --set mass_kg=-1",
            "mass_kg is -1, must be a positive number",
        ),
        ("simulate --ratio 1.5 --set mass_kg=NaN", "mass_kg is NaN"),
        ("simulate --ratio 1.5 --set mass_kg=inf", "mass_kg is inf"),
        (
            "simulate --ratio 1.5 --set mass_kg=1e300",
            "mass_kg is 1e300",
        ),
        (
            "simulate --ratio 1.5 --set gravity_m_per_s2=1e9",
            "from 0.001 to 1000",
        ),
        (
            "simulate --ratio 1.5 --set mass_kg=heavy",
            "must be a number",
        ),
        ("simulate --ratio 1.5 --set mass_kg", "key=value"),
        (
            "simulate --ratio 1.5 --set mas_kg=1",
            "did you mean 'mass_kg'?",
        ),
        (
            "simulate --ratio 1.5 --set amplitude_mm=0",
            "amplitude_mm is 0",
        ),
        (
            "simulate --ratio 1.5 --set contact_law=glue",
            "spring-dashpot",
        ),
        (
            "simulate --ratio 1.5 --set damping_ratio=0.1",
            "does not apply",
        ),
        ("simulate --ratio 1.5 --gap 1e6", "gap_mm is 1000000"),
        ("simulate --ratio 1.5 --gap nan", "gap_mm is NaN"),
        ("pick --gap -100", "gap_mm is -100"),
    ]);
}

#[test]
fn basins_and_gaps_that_cannot_be() {
    assert_refused(&[
        ("basins", "--ratio"),
        ("basins --chapter --gap 1", "cannot be used with"),
        (
            "basins --ratio 2 --gap 1 --gap-ratio 1",
            "cannot be used with",
        ),
        (
            "basins --ratio 2 --gap-ratio nan",
            "--gap-ratio NaN: gap_mm is NaN",
        ),
        ("basins --ratio 2 --grid 0", "COLUMNSxROWS"),
        ("basins --ratio 2 --grid 5000x5000", "25000000 cells"),
        ("basins --ratio 2 --phase 1", "from 0 to below 1"),
        ("basins --ratio nan", "must be a positive number"),
        ("basins --ratio 2 --displacement 1:-1", "swap them"),
        ("basins --ratio 2 --displacement -1", "FROM:TO"),
        (
            "basins --ratio 2 --gap 1 --displacement -6:5",
            "inside the impact surface",
        ),
        ("basins --ratio 2 --recorded 301", "--recorded is 301"),
        ("bifurcation --ratio 2:3:1 --cycles 0", "--cycles is 0"),
        ("basins --ratio 2 --until 5", "--until is 5"),
        ("basins --ratio 2 --samples 2000000", "at most 1000000"),
        ("basins --ratio 2 --out a-file", "a-file is a file"),
        ("pick --gap 0:1", "FROM:TO:STEP"),
        ("pick --gap 0:70:70", "--gap: gap_mm is 70"),
        ("pick --gap 0:3:0.0001", "more than 1000"),
        (
            "pick --gap 0 --gap 1 --all",
            "--all cannot be used with several gaps",
        ),
        (
            "pick --gap 0:1:1 --set gap_mm=1",
            "--gap and --set gap_mm both set the gap",
        ),
        ("pick --starts 5", "--gap"),
        (
            "pick --samples -1",
            "'--samples <N>': -1 must be a whole number from 0 to",
        ),
        ("pick --seed -3", "'--seed <N>': write a whole number"),
    ]);
}

#[test]
fn rigs_and_rig_files_that_cannot_be_read() {
    assert_refused(&[
        ("pick --rig wire", "did you mean 'wires'?"),
        ("rigs nope", "presets: wires, beam-170, beam-150, beam-135"),
        ("pick --rig missing.toml", "cannot read missing.toml"),
        ("pick --rig cut.toml", "cut.toml, line 2"),
        (
            "simulate --ratio 1.5 --rig typo.toml",
            "typo.toml, line 2: there is no parameter 'mass_kgs' (did you mean 'mass_kg'?)",
        ),
        (
            "sweep --ratio 1:2:0.1 --rig nan.toml",
            "nan.toml, line 2: mass_kg is NaN",
        ),
        ("rigs bare.toml", "bare.toml: support is missing"),
        ("pick --rig bytes.toml", "save it as UTF-8"),
    ]);
}

#[test]
fn frequencies_ranges_cycles_and_starts_that_cannot_be() {
    assert_refused(&[
        ("simulate --ratio 0", "must be a positive number"),
        ("simulate --ratio=-1", "must be a positive number"),
        ("simulate --ratio inf", "must be a positive number"),
        ("simulate --frequency nan", "must be a positive number"),
        (
            "simulate --ratio fast",
            "invalid value 'fast' for '--ratio <R>': write a number, such as 3.5",
        ),
        ("simulate --ratio 2 --cycles 1.5", "write a whole number"),
        ("simulate --ratio 1e308", "a positive number, and finite"),
        (
            "simulate --ratio 1.5 --cycles 10 --transient 10",
            "give --cycles more than 10, or a smaller --transient",
        ),
        (
            "simulate --ratio 1.5 --transient 700",
            "--transient 700 leaves nothing of the 600 drive cycles of a run to record",
        ),
        (
            "sweep --ratio 1.5 --transient 700",
            "of the 600 drive cycles of a run",
        ),
        (
            "simulate --ratio 1.5 --set gap_mm=1 --gap 2",
            "--gap and --set gap_mm both set the gap; leave one of them out",
        ),
        (
            "map --set gap_mm=1 --gap 2",
            "--gap and --set gap_mm both set the gap",
        ),
        ("simulate --ratio 1.5 --cycles -1", "'-1'"),
        ("simulate --ratio 1.5 --initial up", "write rest, fixed"),
        (
            "simulate --ratio 1.5 --initial 80,0",
            "out of the rig's reach",
        ),
        (
            "simulate --ratio 1.5 --initial 5,0",
            "inside the impact surface",
        ),
        ("sweep --ratio 1:2", "write FROM:TO:STEP"),
        ("sweep --ratio 2:1:0.1", "swap them"),
        ("sweep --ratio 1:2:0", "STEP is 0"),
        ("sweep --ratio 1:2:nan", "finite"),
        ("sweep --ratio 0:1:0.5", "not a positive value"),
        ("sweep --frequency 1:2:1e-9", "use a larger STEP"),
    ]);
}

#[test]
fn decimal_commas() {
    assert_refused(&[
        (
            "sweep --ratio 2 --over mass_kg=1,7",
            "'1,7' may be one value or two: write 1.7 with a point, or 1.0,7 for two",
        ),
        (
            "sweep --ratio 2 --over mass_kg=1,7,2,5",
            "may be 2 values or 4: write 1.7,2.5 with a point each, or 1.0,7.0,2.0,5.0 for 4",
        ),
        (
            "pick --over mass_kg=0,2,0,4",
            "write 0.2,0.4 with a point each",
        ),
        (
            "sweep --ratio 2 --over mass_kg=0,0.4",
            "--over mass_kg: mass_kg is 0",
        ),
        ("pick --gap 0:1,5:0.5", "write 1.5 with a point"),
        ("sweep --ratio 1,5:2:0.1", "write 1.5 with a point"),
        ("sweep --frequency 1,5", "write 1.5 with a point"),
        ("orbits --ratio 1,5:2", "write 1.5 with a point"),
        ("orbits --frequency 2:3,5", "write 3.5 with a point"),
        (
            "orbits --along gap --ratio 2,1",
            "one positive number; write 2.1 with a point",
        ),
        (
            "orbits --along gap --ratio 2 --gap 0:1,5",
            "write 1.5 with a point",
        ),
        ("contact --speed 0,1", "write 0.1 with a point"),
        ("modes --frequency 1,7", "write 1.7 with a point"),
        (
            "pick --nominal --beside wires,mass_kg=1,7",
            "--beside wires,mass_kg=1,7: write 1.7 with a point",
        ),
    ]);
}

#[test]
fn engines_limits_and_uncertainties_that_do_not_go() {
    assert_refused(&[
        ("simulate --ratio 1.5 --tick-us 50", "add --engine switch"),
        (
            "simulate --ratio 1.5 --stepper banded",
            "add --engine switch",
        ),
        (
            "simulate --ratio 1.5 --engine switch --eta-alpha-m 1e-8",
            "has no band",
        ),
        ("simulate --ratio 1e-9", "it must be from 0.01"),
        ("pick --nominal --samples 10", "cannot be used with"),
        (
            "simulate --ratio 1.5 --precision f32",
            "add --engine switch",
        ),
        (
            "simulate --ratio 1.5 --engine switch --tick-us 0",
            "from 0.05 to 1000",
        ),
        (
            "simulate --ratio 1.5 --engine switch --tick-us nan",
            "from 0.05 to 1000",
        ),
        ("pick --engine switch", "unexpected argument '--engine'"),
        ("pick --all --rig wires", "cannot be used with"),
        ("pick --max-force-n 0", "--max-force-n is 0"),
        (
            "pick --max-shaker-force-n nan",
            "--max-shaker-force-n is NaN",
        ),
        ("pick --samples 200000", "at most 100000"),
        ("pick --amplitude-percent 100", "below 90"),
        (
            "pick --nominal --max-force-n 1 --format json",
            "the nearest that can be kept",
        ),
        (
            "pick --nominal --max-frequency-hz 0.1 --format json",
            "max_frequency_hz = 0.1",
        ),
    ]);
}

#[test]
fn measurements_that_cannot_be_read() {
    let sweep = "sweep --ratio 1.5:1.6:0.1 --cycles 20 --transient 10 --measured";
    for (file, says) in [
        ("none.csv", "cannot read none.csv"),
        (
            "column.csv",
            "column.csv, line 1: the column 'force' has no unit; call it force_n",
        ),
        (
            "cut.csv",
            "cut.csv, line 3: 1 fields where the first line has 2",
        ),
        (
            "words.csv",
            "words.csv, line 3: force_n is 'strong', must be a number",
        ),
        (
            "comma.csv",
            "comma.csv, line 2: force_n is '1,6', must be a number; write 1.6 with a point",
        ),
        ("header.csv", "no measurement"),
    ] {
        assert_refused(&[(&format!("{sweep} {file}"), says)]);
    }
}

#[test]
fn a_file_where_a_folder_should_be() {
    let short = "--format json --cycles 20 --transient 10 --out";
    for line in [
        format!("simulate --ratio 1.5 {short} a-file"),
        format!("simulate --ratio 1.5 {short} a-file/deep"),
        format!("sweep --ratio 1.5:1.6:0.1 {short} a-file"),
        "pick --nominal --format json --out a-file".to_owned(),
    ] {
        assert_refused(&[(&line, "choose another folder")]);
    }
}

#[test]
fn a_line_break_in_a_name_does_not_break_the_line() {
    let folder = folder();
    for words in [
        ["pick", "--rig", "a\nb"],
        ["pick", "--rig", "a\nb.toml"],
        ["pick", "--set", "mass_kg=1\n2"],
        ["pick", "--set", "a\nb=1"],
        ["rigs", "--\n", "wires"],
    ] {
        assert_eq!(fault(&folder, &words, ""), None);
    }
}

/// What a file may be, too, and how long a line becomes.
#[cfg(unix)]
#[test]
fn files_that_are_none_and_what_is_too_long() {
    use std::process::Command;
    let folder = folder().with("large.toml", vec![b'#'; (1 << 20) + 1]).with(
        "key.toml",
        format!("preset = \"wires\"\n{} = 1\n", "k".repeat(100_000)),
    );
    let pipe = folder.path("pipe.toml");
    let made = Command::new("mkfifo").arg(&pipe).status().unwrap();
    assert!(made.success());
    let refused = [
        (
            "simulate --ratio 2 --rig pipe.toml",
            "pipe.toml: it is a pipe; give a file",
        ),
        ("emulate pipe.toml", "pipe.toml: it is a pipe; give a file"),
        ("compare pipe.toml", "pipe.toml: it is a pipe; give a file"),
        ("identify pipe.toml", "pipe.toml: it is a pipe; give a file"),
        (
            "sweep --ratio 2 --measured pipe.toml",
            "pipe.toml: it is a pipe; give a file",
        ),
        ("replay pipe.toml", "it is a pipe; give an ordinary file"),
        (
            "simulate --ratio 2 --rig large.toml",
            "it has more than 1 MB",
        ),
        ("emulate large.toml", "it has more than 1 MB"),
        ("simulate --ratio 2 --rig key.toml", "kkk…kkk"),
        (
            "pick --amplitude-percent 1e308",
            "--amplitude-percent is 1e308, must",
        ),
        (
            "simulate --frequency 1e-9",
            "is 0.000000001 Hz, 5.49451e-10 times",
        ),
        ("contact --speed 1e-300:1:1e-300", "that is 1e300 values"),
    ];
    support::assert_refused(&folder, refused);
    for (line, _) in refused {
        let ran = folder.run(line);
        assert!(ran.err.chars().count() < 700, "{ran:?}");
    }
}

/// Also by the commands that drive no rig.
#[test]
fn a_doubt_about_a_unit_is_said_by_every_command() {
    let folder = Folder::new()
        .with("grams.toml", "preset = \"wires\"\nmass_kg = 298\n")
        .with("record.csv", "time_s,force_n\n0,0\n1,0\n");
    for line in [
        "contact --set mass_kg=298 --speed 0.1 --quiet",
        "drop --set mass_kg=298 --impacts 1 --quiet",
        "identify record.csv --set mass_kg=298 --quiet",
        "rigs grams.toml",
    ] {
        let ran = folder.run(line);
        assert!(ran.err.starts_with("warning: mass_kg = 298"), "{ran:?}");
    }
}

/// A value in another unit is doubted whether or not notes are wanted, and the answer keeps the doubt.
#[test]
fn a_doubt_about_a_unit_is_said_with_quiet_too() {
    for set in ["mass_kg=298", "amplitude_mm=0.00089"] {
        let line = format!("simulate --ratio 2 --cycles 10 --set {set} --quiet --format json");
        let ran = Folder::new().run(&line);
        let says = format!("warning: {}", set.replace('=', " = "));
        assert!(ran.err.starts_with(&says), "{ran:?}");
        let rig = &ran.json()["made_from"]["rigs"][0];
        let warnings = rig["warnings"].as_array().expect("warnings");
        assert!(
            warnings[0].as_str().is_some_and(|w| w.starts_with(&says)),
            "{rig}"
        );
    }
}
