//! `pick --over`: the operating point over a parameter of the rig.

use std::fs;

use crate::support::{Folder, assert_refused, assert_svg_shows, csv_rows, number, pair};

const LINE: &str = "pick --nominal --cart prescribed --over amplitude_mm=0.5,0.89,1.2";

#[test]
fn each_row_is_the_pick_of_its_value() {
    let folder = Folder::new();
    let json = folder.run(&format!("{LINE} --format json --quiet")).well();
    let rows = json.json();
    let rows = rows.as_array().unwrap();
    assert_eq!(rows.len(), 3);
    for row in rows {
        let value = number(row, "value");
        let one = format!(
            "pick --nominal --cart prescribed --set amplitude_mm={value} --format json --quiet"
        );
        let one = folder.run(&one).well().json();
        for (here, there) in [
            ("operating_frequency_hz", "operating_frequency_hz"),
            ("force_ratio", "force_ratio"),
            ("force_n", "force_n"),
            ("multiplier", "multipliers"),
            ("period_doubling_hz", "period_doubling_hz"),
            ("impact_power_w", "impact_power_w"),
        ] {
            assert_eq!(number(row, here), number(&one, there), "{here} at {value}");
        }
        let [low, high] = pair(&one, "safe_band_hz");
        assert_eq!(number(row, "safe_band_low_hz"), low);
        assert_eq!(number(row, "safe_band_high_hz"), high);
        assert_eq!(
            (&row["rig"], &row["parameter"]),
            (&"wires".into(), &"amplitude_mm".into())
        );
        assert!(row["no_pick"].is_null());
    }
    let csv = folder.run(&format!("{LINE} --format csv --quiet")).well();
    assert_eq!(csv_rows(&csv.out).len(), 3);
}

#[test]
fn text_and_picture_show_how_it_moves_and_a_value_without_a_pick_says_why() {
    let folder = Folder::new();
    // At a gap of 3 mm an amplitude of 0.001 mm never reaches the surface, not even at resonance.
    let line = "pick --nominal --gap 3 --over amplitude_mm=0.001:2:log2";
    let ran = folder.run(line).well();
    assert!(
        ran.out.contains("0.00100000  no pick: rig wires"),
        "{ran:?}"
    );
    assert!(
        ran.out
            .contains("1 of 2 values have no frequency to run at"),
        "{ran:?}"
    );
    assert!(!ran.out.contains("NaN"), "{ran:?}");
    let stem = "out/pick-wires-over-amplitude_mm=0.001-2-log2-nominal-gap-3";
    assert_eq!(folder.ends(stem), [".csv", ".json", ".png", ".svg"]);
    assert_svg_shows(
        &folder.read(&format!("{stem}.svg")),
        &[
            "where to run, over amplitude_mm",
            "frequency and safe band",
            "impact power, W",
        ],
    );
    assert!(folder.read(&format!("{stem}.json")).contains("made_from"));
}

/// What an earlier run of the same request kept is taken over: here a row that no pick would give.
#[test]
fn an_interrupted_run_goes_on_and_another_request_begins_anew() {
    let folder = Folder::new();
    let whole = folder
        .run(&format!("{LINE} --out a --format csv --quiet"))
        .well();
    assert!(
        folder
            .names()
            .iter()
            .all(|name| !name.ends_with(".unfinished"))
    );
    let mut child = folder
        .command(
            &LINE
                .split(' ')
                .chain(["--out", "b", "--format", "csv"])
                .collect::<Vec<_>>(),
        )
        .stdout(std::process::Stdio::null())
        .stderr(std::process::Stdio::null())
        .spawn()
        .unwrap();
    let unfinished = || {
        let names = folder.names();
        names
            .into_iter()
            .find(|name| name.starts_with("b/") && name.ends_with(".unfinished"))
    };
    let found = loop {
        if let Some(name) = unfinished() {
            break Some(name);
        }
        if child.try_wait().unwrap().is_some() {
            break None;
        }
        std::thread::sleep(std::time::Duration::from_millis(1));
    };
    let name = found.expect("a value is kept before all are done");
    child.kill().unwrap();
    child.wait().unwrap();
    let again = folder
        .run(&format!("{LINE} --out b --format csv --quiet"))
        .well();
    assert_eq!(again.out, whole.out);
    assert!(!folder.path(&name).exists());
    // A file that is damaged, or of another request, is as good as none.
    fs::write(folder.path(&name), b"HSROWS01 nonsense").unwrap();
    let again = folder
        .run(&format!("{LINE} --out b --format csv --quiet"))
        .well();
    assert_eq!(again.out, whole.out);
}

#[test]
fn what_makes_no_sense_is_refused() {
    let folder = Folder::new();
    let lines = [
        ("pick --over mass=1,2", "there is no parameter 'mass'"),
        ("pick --over mass_kg=1.0,2 --all", "cannot be used with"),
        (
            "pick --over mass_kg=1.0,2 --gap 0:1:1",
            "cannot be used with",
        ),
        (
            "pick --over mass_kg=1.0,2 --beside beam-170",
            "cannot be used with",
        ),
        (
            "pick --over mass_kg=1.0,2 --objective rop",
            "--over cannot be used with --objective rop",
        ),
        ("pick --over mass_kg=0.3,-1", "--over mass_kg"),
        (
            "pick --over mass_kg=1.0,2 --set mass_kg=3",
            "--set mass_kg and --over mass_kg both set it",
        ),
        (
            "pick --over gap_mm=0.0,1 --gap 2",
            "--gap and --over gap_mm both set it",
        ),
        (
            "sweep --ratio 2 --over gap_mm=0.0,1 --gap 2",
            "--gap and --over gap_mm both set it",
        ),
        (
            "sweep --ratio 2 --over gap_mm=0.0,1 --set gap_mm=2",
            "--set gap_mm and --over gap_mm both set it",
        ),
    ];
    assert_refused(&folder, lines);
}
