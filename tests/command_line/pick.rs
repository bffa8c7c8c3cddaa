//! `host-sim pick`: the answer, checked by the other commands.

use std::sync::OnceLock;

use serde_json::Value;

use crate::support::{
    Folder, answer, assert_svg_shows, csv_rows, finish, keys, number, pair, png_size,
};

/// The wires' answer, asked once.
fn wires() -> &'static Value {
    static WIRES: OnceLock<Value> = OnceLock::new();
    WIRES.get_or_init(|| answer("pick --rig wires"))
}

fn simulate(hz: f64) -> Value {
    answer(&format!("simulate --cart recoil --frequency {hz:?}"))
}

#[test]
fn wires_are_run_on_a_stable_one_one_more_than_three_times_as_strong_as_at_resonance() {
    let a = wires();
    assert_eq!((&a["regime"], &a["gap_mm"]), (&"1/1".into(), &0.0.into()));
    let share = number(a, "force_ratio") / number(a, "force_ratio_at_natural_frequency");
    assert!(share > 3.0, "{share}");
    assert!(number(a, "multipliers") < 1.0 && number(a, "multipliers_worst") < 1.0);
    assert_eq!(a["jump_free"], true);
    let (worst, largest) = (
        number(a, "force_ratio_worst"),
        number(a, "force_ratio_largest"),
    );
    assert!(worst < number(a, "force_ratio") && number(a, "force_ratio") < largest);
}

#[test]
fn its_bands_lie_within_each_other() {
    let a = wires();
    let at = number(a, "operating_frequency_hz");
    let [stable, robust, band, safe] = [
        "stable_one_one_hz",
        "robust_band_hz",
        "band_hz",
        "safe_band_hz",
    ]
    .map(|k| pair(a, k));
    let within = |inner: [f64; 2], outer: [f64; 2]| outer[0] <= inner[0] && inner[1] <= outer[1];
    assert!(safe[0] < at && at < safe[1]);
    assert!(within(safe, band) && within(safe, robust));
    assert!(within(band, stable) && within(robust, stable));
    let doubling = number(a, "period_doubling_hz");
    assert_eq!(doubling, stable[1]);
    assert!(band[1] < doubling);
    assert_eq!(a["stable_one_one_ends"][1], "period_doubling");
}

#[test]
fn simulate_confirms_the_force_at_the_operating_frequency_and_resonance() {
    let a = wires();
    let there = simulate(number(a, "operating_frequency_hz"));
    assert_eq!(there["regime"], "1/1");
    for key in [
        "force_n",
        "approach_speed_m_per_s",
        "contact_time_ms",
        "frequency_ratio",
    ] {
        let (said, seen) = (number(a, key), number(&there, key));
        assert!((seen / said - 1.0).abs() < 1e-6, "{key}: {said} {seen}");
    }
    let resonance = answer("simulate --cart recoil --ratio 1");
    let (seen, said) = (
        number(&resonance, "force_ratio"),
        number(a, "force_ratio_at_natural_frequency"),
    );
    assert!((seen / said - 1.0).abs() < 1e-6, "{said} {seen}");
}

#[test]
fn simulate_confirms_the_band() {
    let a = wires();
    let force = number(a, "force_n");
    let [low, high] = pair(a, "band_hz");
    for share in [0.0, 0.2, 0.7, 1.0] {
        let seen = simulate(low + share * (high - low));
        assert_eq!(seen["regime"], "1/1", "{seen}");
        let relative = number(&seen, "force_n") / force;
        assert!((0.899..1.0).contains(&relative), "{relative} at {share}");
        if share == 0.0 || share == 1.0 {
            // The band ends because the force does, not because of the search.
            assert!((relative - 0.9).abs() < 1e-3, "{relative} at {share}");
        }
    }
    let doubling = number(a, "period_doubling_hz");
    assert_eq!(simulate(doubling * 1.01)["regime"], "2/2");
    assert_eq!(simulate(doubling * 0.97)["regime"], "1/1");
}

#[test]
fn no_frequency_of_a_fine_sweep_in_the_stable_one_one_is_stronger() {
    let a = wires();
    let [low, high] = pair(a, "stable_one_one_hz");
    let best = number(a, "force_n");
    let range = format!("{:?}:{:?}:0.02", low + 0.001, 0.98 * high);
    let rows = answer(&format!(
        "sweep --cart recoil --frequency {range} --cycles 120 --transient 100"
    ));
    let rows = rows.as_array().expect("rows");
    assert!(rows.len() > 100);
    for row in rows {
        assert_eq!(row["regime"], "1/1", "{row}");
        assert!(number(row, "force_n") <= best * (1.0 + 1e-6), "{row}");
    }
    let nearest = rows
        .iter()
        .map(|row| number(row, "force_n"))
        .fold(0.0, f64::max);
    assert!(nearest > 0.999 * best, "{nearest}");
}

#[test]
fn all_four_rigs_are_best_near_twice_their_natural_frequency() {
    let all = answer("pick --all --nominal");
    let all = all.as_array().expect("four answers");
    let names: Vec<_> = all.iter().map(|a| a["rig"].as_str()).collect();
    assert_eq!(
        names,
        ["wires", "beam-170", "beam-150", "beam-135"].map(Some)
    );
    for a in all {
        assert_eq!(a["regime"], "1/1");
        assert!((number(a, "frequency_ratio") - 2.0).abs() < 0.05, "{a}");
        let share = number(a, "force_ratio") / number(a, "force_ratio_at_natural_frequency");
        assert!(share > 3.0, "{a}");
    }
}

#[test]
fn every_corner_is_followed_without_samples_too() {
    let bare = answer("pick --samples 0");
    // Samples inside can only narrow what is left.
    let (corners, sampled) = (
        pair(&bare, "robust_band_hz"),
        pair(wires(), "robust_band_hz"),
    );
    let hair = 1e-6;
    assert!(corners[0] <= sampled[0] + hair && sampled[1] <= corners[1] + hair);
    let worst = |a| number(a, "force_ratio_worst");
    assert!(worst(wires()) <= worst(&bare) * (1.0 + 1e-9));
}

/// A column is looked up in the answer by its name: one that it does not have would be empty.
#[test]
fn every_column_of_a_line_is_one_of_the_answer_s() {
    for line in [
        "pick --rig beam-150 --nominal",
        "pick --objective rop --threshold-n 25 --nominal",
    ] {
        let ran = Folder::new().run(&format!("{line} --format csv")).well();
        let rows = csv_rows(&ran.out);
        assert_eq!(rows.len(), 1, "{line}");
        for (column, value) in rows[0].as_object().expect("a row") {
            // Nobody gave a bit, which would take half a minute.
            let given = !value.is_null() && value != "";
            assert!(given != column.starts_with("bit_"), "{line}: {column}");
        }
    }
}

#[test]
fn json_has_every_field_promised() {
    let promised = [
        "rig",
        "gap_mm",
        "cart",
        "recoil_force_ratio",
        "recoil_frequency_hz",
        "prescribed_force_ratio",
        "prescribed_frequency_hz",
        "operating_frequency_hz",
        "frequency_ratio",
        "regime",
        "force_ratio",
        "force_n",
        "force_ratio_worst",
        "force_ratio_largest",
        "approach_speed_m_per_s",
        "contact_time_ms",
        "band_hz",
        "safe_band_hz",
        "stable_one_one_hz",
        "stable_one_one_ends",
        "robust_band_hz",
        "period_doubling_hz",
        "multipliers",
        "multipliers_worst",
        "jump_free",
        "nominal_optimum_hz",
        "force_ratio_at_natural_frequency",
        "shaker",
        "limits",
        "sensitivity",
        "uncertainty",
        "amplitude_mm",
        "amplitude_lowered",
        "modes",
        "modes_force_ratio",
        "one_mode_safe_band_hz",
        "why",
    ];
    let there = keys(wires());
    for key in promised {
        assert!(there.contains(&key), "{key}");
    }
    let shaker = [
        "stroke_mm",
        "velocity_m_per_s",
        "acceleration_m_per_s2",
        "force_n",
        "mean_power_w",
        "reactive_power_w",
        "energy_per_blow_j",
        "blows_per_second",
        "loop_force_n",
    ];
    assert_eq!(keys(&wires()["shaker"]), shaker);
    let uncertainty = &wires()["uncertainty"];
    assert_eq!(
        (&uncertainty["samples"], &uncertainty["seed"]),
        (&256.into(), &1.into())
    );
    assert_eq!(wires()["sensitivity"].as_array().map(Vec::len), Some(12));
    // Wires have no bending modes.
    assert_eq!(wires()["modes"], Value::Null);
}

/// The emulator's two bodies, and an independent model of them, say 29.7 (wires) and 72.5 (beam-170) times the weight where
/// a prescribed cart gives 32.9 and 80.3.
#[test]
fn the_answer_is_for_the_cart_that_recoils_and_has_the_prescribed_one_beside_it() {
    for (rig, recoil, prescribed) in [("wires", 29.70, 32.85), ("beam-170", 72.55, 80.27)] {
        let [ours, chapter] = ["recoil", "prescribed"]
            .map(|cart| answer(&format!("pick --rig {rig} --nominal --cart {cart}")));
        assert_eq!(ours["cart"], "recoil");
        assert_eq!(chapter["cart"], "prescribed");
        for a in [&ours, &chapter] {
            let [r, p] = ["recoil_force_ratio", "prescribed_force_ratio"].map(|key| number(a, key));
            assert!((r / recoil - 1.0).abs() < 2e-3, "{r} for {recoil}");
            assert!((p / prescribed - 1.0).abs() < 2e-3, "{p} for {prescribed}");
        }
        assert_eq!(ours["force_ratio"], ours["recoil_force_ratio"]);
        assert_eq!(chapter["force_ratio"], chapter["prescribed_force_ratio"]);
        for (key, own) in [
            ("recoil_frequency_hz", &ours),
            ("prescribed_frequency_hz", &chapter),
        ] {
            let [a, b] = [&ours, &chapter].map(|a| number(a, key));
            assert!((a / b - 1.0).abs() < 1e-6, "{key}: {a} {b}");
            assert_eq!(own[key], own["operating_frequency_hz"]);
        }
    }
}

#[test]
fn a_rig_without_a_shaker_is_answered_as_prescribed_and_says_so() {
    let whole = Folder::new().run("rigs wires").well().out;
    let kept = whole.lines().filter(|line| !line.starts_with("shaker_"));
    let bare = kept.collect::<Vec<_>>().join("\n");
    let folder = Folder::new().with("bare.toml", &bare);
    let said = folder
        .run("pick --nominal --rig bare.toml --format json --quiet")
        .well()
        .json();
    assert_eq!(
        (&said["cart"], &said["recoil_force_ratio"]),
        (&"prescribed".into(), &Value::Null)
    );
    let text = folder.run("pick --nominal --rig bare.toml").well().out;
    assert!(text.contains("its shaker is not known"), "{text}");
    let refused = folder.run("sweep --ratio 2:2:1 --cart recoil --rig bare.toml");
    assert_eq!(refused.code, Some(2));
    assert!(refused.err.contains("give shaker_loop_hz"), "{refused:?}");
    assert_eq!(refused.err.lines().count(), 1, "{refused:?}");
}

/// Uncertain in its natural frequency alone, the rig that strikes hardest lies between the two corners,
/// so that the samples decide the largest force.
#[test]
fn same_seed_same_bytes_on_one_thread_or_two_and_another_seed_another_largest_force() {
    let folder = Folder::new();
    let with = |seed: &str, threads: &str| {
        let line = format!(
            "pick --samples 12 --seed {seed} --natural-frequency-percent 12 --amplitude-percent 0 \
             --contact-stiffness-percent 0 --contact-damping-percent 0 --gap-tolerance-mm 0 \
             --cart prescribed --format json --quiet"
        );
        let words: Vec<_> = line.split_whitespace().collect();
        let mut command = folder.command(&words);
        command.env("RAYON_NUM_THREADS", threads);
        finish(command).well()
    };
    let one = with("1", "1");
    assert_eq!(one.out, with("1", "2").out);
    let other = with("2", "2").json();
    let one = one.json();
    assert_eq!(other["uncertainty"]["seed"], 2);
    let apart = number(&other, "force_ratio_largest") - number(&one, "force_ratio_largest");
    assert!(apart.abs() > 1e-3, "{apart}");
    assert_eq!(
        other["operating_frequency_hz"],
        one["operating_frequency_hz"]
    );
}

#[test]
fn text_writes_out_and_says_where() {
    let folder = Folder::new();
    let ran = folder.run("pick --nominal").well();
    let names = [
        "pick-wires-nominal-curve.csv",
        "pick-wires-nominal.json",
        "pick-wires-nominal.png",
        "pick-wires-nominal.svg",
    ];
    assert_eq!(folder.names(), names.map(|name| format!("out/{name}")));
    for name in names {
        let end = name.trim_start_matches("pick-wires-nominal");
        assert!(ran.err.contains(end), "{ran:?}");
    }
    for said in [
        "run it at 3.6",
        "safe band",
        "period doubling",
        "shaker must give",
    ] {
        assert!(ran.out.contains(said), "{said} is not in: {}", ran.out);
    }
    let written: Value =
        serde_json::from_str(&folder.read("out/pick-wires-nominal.json")).expect("JSON");
    let at = number(&written, "operating_frequency_hz");
    assert!(ran.out.contains(&format!("{at:.4} Hz")));

    let curve = csv_rows(&folder.read("out/pick-wires-nominal-curve.csv"));
    assert_eq!(
        keys(&curve[0]),
        ["rig", "gap_mm", "frequency_hz", "force_ratio", "cart"]
    );
    let strongest = curve
        .iter()
        .map(|row| number(row, "force_ratio"))
        .fold(0.0, f64::max);
    let best = number(&written, "force_ratio");
    assert!(
        (0.99 * best..=best * (1.0 + 1e-9)).contains(&strongest),
        "{strongest} {best}"
    );

    assert_svg_shows(&folder.read("out/pick-wires-nominal.svg"), &["wires", "Hz"]);
    png_size(&std::fs::read(folder.path("out/pick-wires-nominal.png")).expect("a picture"));
}

#[test]
fn csv_says_what_json_says_and_quiet_is_quiet() {
    let folder = Folder::new();
    let csv = folder
        .run("pick --nominal --format csv --quiet --out o")
        .well();
    assert_eq!(csv.err, "");
    assert_eq!(folder.names().len(), 4);
    let row = &csv_rows(&csv.out)[0];
    let whole: Value =
        serde_json::from_str(&folder.read("o/pick-wires-nominal.json")).expect("JSON");
    for key in keys(row) {
        let said = match key {
            "band_low_hz" => &whole["band_hz"][0],
            "band_high_hz" => &whole["band_hz"][1],
            "safe_band_low_hz" => &whole["safe_band_hz"][0],
            "safe_band_high_hz" => &whole["safe_band_hz"][1],
            "energy_per_blow_j" | "blows_per_second" | "loop_force_n" => &whole["shaker"][key],
            _ => &whole[key],
        };
        assert_eq!(&row[key], said, "{key}");
    }
}

/// What cannot be written is noticed before the answer is printed.
#[cfg(unix)]
#[test]
fn no_answer_is_printed_when_its_files_cannot_be_written() {
    let folder = Folder::new();
    std::os::unix::fs::symlink("not/there", folder.path("o")).expect("a link");
    let ran = folder.run("pick --nominal --out o");
    assert_eq!((ran.code, ran.out.as_str()), (Some(2), ""), "{ran:?}");
    assert_eq!(ran.err.lines().count(), 1, "{ran:?}");
}

/// The forces of the contacts of a run from rest say how long it takes.
#[test]
fn the_time_to_settle_is_when_the_last_contact_differs_by_a_percent() {
    let said = answer("pick --nominal --cart recoil");
    let (hz, force_n) = (
        number(&said, "operating_frequency_hz"),
        number(&said, "force_n"),
    );
    let folder = Folder::new();
    let line = format!(
        "simulate --gap 0 --cart recoil --frequency {hz} --transient 0 --cycles 60 --out out"
    );
    folder.run(&line).well();
    let contacts = csv_rows(&folder.read_made("out/simulate", "-contacts.csv"));
    let differs = |c: &&Value| (number(c, "peak_force_n") / force_n - 1.0).abs() > 0.01;
    let last = contacts
        .iter()
        .rfind(differs)
        .expect("a start that differs");
    let periods = (number(last, "onset_s") * hz).ceil();
    assert_eq!(number(&said, "force_settling_cycles"), periods);
    assert!((number(&said, "force_settling_s") * hz - periods).abs() < 1e-9);
    // A disturbance shrinks by the multiplier: to a hundredth within some periods more than its logarithm says.
    let least = 0.01_f64.ln() / number(&said, "multipliers").ln();
    assert!(
        (0.5 * least..10.0 * least).contains(&periods),
        "{periods} {least}"
    );
}
