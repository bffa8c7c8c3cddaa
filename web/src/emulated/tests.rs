use emulator::local::Local;
use emulator::log::LogReader;
use serde_json::{Value, json};
use shared::settings::TICK_RATE_HZ;

use super::*;
use crate::call;

fn told(name: &str, argument: &Value) -> Vec<u8> {
    let bytes = serde_json::to_vec(argument).expect("JSON");
    call(name, &bytes).unwrap_or_else(|why| panic!("{name} {argument}: {why}"))
}

/// Lets the rig's time pass; what the board has said at last.
fn pass(seconds: f64) -> Value {
    let blocks = (seconds * f64::from(TICK_RATE_HZ) / 10.0) as u32;
    let mut last = Value::Null;
    for _ in 0..blocks.div_ceil(20) {
        let bytes = told("emulated.step", &json!({ "blocks": 20 }));
        let heard = call("wire.hear", &bytes).expect("a conversation");
        let heard: Value = serde_json::from_slice(&heard).expect("JSON");
        if !heard["status"].is_null() {
            last = heard;
        }
    }
    last
}

/// Asks the board as the page does; its answer.
fn ask(request: &Value) -> Value {
    let bytes = told("wire.request", request);
    let (number, frame) = bytes.split_first_chunk::<2>().expect("a number");
    call("emulated.receive", frame).expect("a rig");
    for _ in 0..100 {
        let bytes = told("emulated.step", &json!({ "blocks": 2 }));
        let heard = call("wire.hear", &bytes).expect("a conversation");
        let heard: Value = serde_json::from_slice(&heard).expect("JSON");
        let answers = heard["answers"].as_array().expect("a list");
        let number = u64::from(u16::from_le_bytes(*number));
        if let Some(answer) = answers.iter().find(|a| a["request"] == number) {
            return answer.clone();
        }
    }
    panic!("no answer to {request}");
}

fn connect(scenario: &str, events: bool) {
    told(
        "emulated.start",
        &json!({ "name": scenario, "events": events }),
    );
    told("wire.open", &json!({ "sequence": 7 }));
    let hello = ask(&json!({ "kind": "hello" }));
    assert_eq!(
        (&hello["board"], &hello["fits"]),
        (&json!("emulator"), &json!(true))
    );
    assert_eq!(ask(&json!({ "kind": "settings" }))["kind"], "settings");
    ask(&json!({ "kind": "telemetry", "decimation": 200 }));
    ask(&json!({ "kind": "frames", "on": true }));
    let board = ask(&json!({ "kind": "board" }));
    let (boot, granted) = (&board["boot"], &board["granted"]);
    let open = json!({ "kind": "open", "boot": boot, "granted": granted, "take_over": true });
    assert_eq!(ask(&open)["kind"], "session");
}

#[test]
fn a_rig_is_started_broken_stopped_and_recorded_over_its_link() {
    connect("field", false);
    told(
        "wire.record",
        &json!({ "made_from": { "command": "the page" } }),
    );
    assert_eq!(
        ask(&json!({ "kind": "set-settings", "toml": "" }))["kind"],
        "done"
    );
    assert_eq!(
        ask(&json!({ "kind": "start", "manual": false }))["kind"],
        "done"
    );
    let heard = pass(14.0);
    assert_eq!(heard["status"]["fault"], Value::Null);
    let blows = told("wire.blows", &Value::Null);
    let blows: Vec<Value> = serde_json::from_slice(&blows).expect("JSON");
    assert!(blows.len() > 10, "{}", blows.len());
    assert_eq!((&heard["lost"], &heard["gaps"]), (&json!(0), &json!(0)));
    // An event of a scenario file happens now; a wrong one is refused with a line.
    let wrong =
        call("emulated.event", br#"{"toml":"kind = \"pusch\""}"#).expect_err("no such kind");
    assert!(
        wrong.contains("pusch") && wrong.lines().count() == 1,
        "{wrong}"
    );
    told(
        "emulated.event",
        &json!({ "toml": "kind = \"sensor-fault\"\nsensor = \"force\"\nfault = \"open\"" }),
    );
    let heard = pass(0.5);
    assert_eq!(heard["status"]["state"], "fault", "{heard}");
    let truth: Value = serde_json::from_slice(&told("emulated.truth", &Value::Null)).expect("JSON");
    assert_eq!(truth["powered"], false, "{truth}");
    let text = truth["events"].to_string();
    assert!(text.contains("force"), "{text}");
    // What was recorded is a log without a gap.
    let bytes = told("wire.recording", &Value::Null);
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("page.parquet");
    std::fs::write(&path, bytes).expect("room");
    let mut log = LogReader::open(&path).expect("a log");
    assert_eq!(log.header().source, "emulator");
    assert!(log.ticks() > 14 * u64::from(TICK_RATE_HZ));
    let mut driven = false;
    while let Some(logged) = log.block().expect("a whole log") {
        driven |= logged.ticks.iter().any(|tick| tick.output.enable);
    }
    assert!(driven);
}

/// With its events, a scenario in the page is the scenario of `host-sim emulate`.
#[test]
fn a_scenario_in_the_page_is_the_same_run_as_on_the_command_line() {
    told(
        "emulated.start",
        &json!({ "name": "field", "events": true }),
    );
    for _ in 0..2000 {
        told("emulated.step", &json!({ "blocks": 20 }));
    }
    let shown: Value = serde_json::from_slice(&told("emulated.truth", &Value::Null)).expect("JSON");
    let scenario = scenario::load("field").expect("built in");
    let control = Local::new(&scenario.settings).expect("good settings");
    let mut run = Run::new(&scenario, control, Truth::default()).expect("a good rig");
    for _ in 0..40_000 {
        run.block();
    }
    let native = run.observer();
    assert!(native.contacts > 20);
    assert_eq!(shown["contacts"], native.contacts);
    assert_eq!(shown["peak_n"], native.peak_n);
    assert_eq!(shown["impulse_n_s"], native.impulse_n_s);
}

#[test]
fn every_scenario_starts() {
    let known: Vec<Value> =
        serde_json::from_slice(&told("emulated.scenarios", &Value::Null)).expect("JSON");
    assert!(known.len() > 10);
    for scenario in known {
        for events in [false, true] {
            told(
                "emulated.start",
                &json!({ "name": scenario["name"], "events": events }),
            );
            told("emulated.step", &json!({ "blocks": 4 }));
        }
    }
}

#[test]
fn settings_are_checked_before_they_are_sent() {
    connect("field", false);
    let check = |toml: &str| {
        call(
            "wire.check-settings",
            json!({ "toml": toml }).to_string().as_bytes(),
        )
    };
    assert!(check("[trips]\nforce_n = 300\n").is_ok());
    let odd = check("[trips]\nforce = 300\n").expect_err("no such key");
    assert!(odd.contains("force_n"), "{odd}");
    let low = check("[trips]\nforce_n = 1\n").expect_err("too low");
    assert!(low.contains("trips.force_n"), "{low}");
    // While it drives, the board itself refuses them.
    ask(&json!({ "kind": "start", "manual": true }));
    let refused = ask(&json!({ "kind": "set-settings", "toml": "" }));
    assert_eq!(
        (&refused["kind"], &refused["why"]),
        (&json!("refused"), &json!("not in this state"))
    );
    assert_eq!(ask(&json!({ "kind": "stop" }))["kind"], "done");
}
