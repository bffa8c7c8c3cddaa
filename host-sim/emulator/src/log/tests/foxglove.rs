//! What the MCAP file holds for those who open it.

use serde_json::Value;

use super::super::channels::CHANNELS;
use super::*;
use crate::record::{RunEvent, RunEventKind};

const NS_PER_S: u64 = 1_000_000_000;

#[test]
fn foxglove_gets_every_channel_and_the_peak() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("run.mcap");
    let mut writer = mcap::McapWriter::create(&path, &header()).unwrap();
    let blocks = 400; // 4000 ticks, 0.2 s
    for k in 0..blocks {
        writer.block(&block(k)).unwrap();
    }
    let contact = TrueContact {
        onset_s: 0.0067,
        peak_force_n: 96.0,
        ..TrueContact::default()
    };
    writer.contact(&contact).unwrap();
    let text = "the gap widens".to_owned();
    for (time_s, what) in [(2.1, RunEventKind::Scenario { text }), (2.15, fault_kind())] {
        let event = RunEvent {
            tick: 0,
            time_s,
            what,
        };
        writer.event(&event).unwrap();
    }
    let fault = writer.fault(0.15, Fault::OverForce, Origin::Force, 400.0);
    fault.unwrap();
    writer.finish().unwrap();

    let bytes = fs::read(&path).unwrap();
    let mut counts: BTreeMap<String, usize> = BTreeMap::new();
    let mut strongest: (f64, u64) = (0.0, 0);
    for message in ::mcap::MessageStream::new(&bytes).unwrap() {
        let message = message.unwrap();
        let channel = &message.channel;
        let schema = channel.schema.as_ref().unwrap();
        assert_eq!(
            (channel.message_encoding.as_str(), schema.encoding.as_str()),
            ("json", "jsonschema")
        );
        let schema: serde_json::Value = serde_json::from_slice(&schema.data).unwrap();
        assert_eq!(schema["type"], "object");
        let data: serde_json::Value = serde_json::from_slice(&message.data).unwrap();
        for key in data.as_object().unwrap().keys() {
            assert!(
                schema["properties"][key]["type"].is_string(),
                "{key} is not in the schema of {}",
                channel.topic
            );
        }
        if channel.topic == "/events" {
            assert_eq!(channel.schema.as_ref().unwrap().name, "foxglove.Log");
            let at = &data["timestamp"];
            let at_ns = at["sec"].as_u64().unwrap() * NS_PER_S + at["nsec"].as_u64().unwrap();
            assert_eq!(at_ns, message.log_time);
            let fault = data["message"].as_str().unwrap().contains("over-force");
            assert_eq!(data["level"], if fault { 4 } else { 2 });
            assert_eq!(data["name"], if fault { "controller" } else { "rig" });
        }
        if channel.topic == "/force" && data["true_n"].as_f64().unwrap() > strongest.0 {
            strongest = (data["true_n"].as_f64().unwrap(), message.log_time);
        }
        *counts.entry(channel.topic.clone()).or_default() += 1;
    }
    let expected = [
        ("/contacts", 1),
        ("/displacement", 40),
        ("/events", 2),
        ("/faults", 1),
        ("/force", 20),
        // Every 200 ticks, the first block's, and the change of state in block 7.
        ("/status", 20 + 2),
    ];
    let expected = expected.map(|(topic, count)| (topic.to_owned(), count));
    assert_eq!(counts, BTreeMap::from(expected));
    // The spike of tick 134, at 6.7 ms, has kept its height and time.
    assert_eq!(strongest, (96.0, 134 * 50_000));
}

/// PlotJuggler reads a file by its summary, and messages by the encoding of their channel.
#[test]
fn the_summary_has_every_channel_its_schema_and_the_count() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("run.mcap");
    let mut writer = mcap::McapWriter::create(&path, &header()).unwrap();
    writer.block(&block(0)).unwrap();
    writer.finish().unwrap();
    let bytes = fs::read(&path).unwrap();
    let summary = ::mcap::Summary::read(&bytes).unwrap().unwrap();
    assert_eq!(summary.channels.len(), CHANNELS.len());
    for channel in summary.channels.values() {
        assert_eq!(channel.message_encoding, "json");
        assert!(channel.schema.is_some(), "{}", channel.topic);
    }
    let stats = summary.stats.unwrap();
    assert_eq!(stats.message_count, 3);
}

/// The layout of docs/ shows fields that are there, and each of its panels has a place.
#[test]
fn the_layout_shows_what_the_log_holds() {
    let place = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../docs/foxglove-layout.json"
    );
    let layout: Value = serde_json::from_str(&fs::read_to_string(place).unwrap()).unwrap();
    let mut shown = 0;
    let mut look = |path: &str| {
        let (topic, field) = path.split_once('.').unwrap_or((path, ""));
        let channel = CHANNELS.iter().find(|channel| channel.topic == topic);
        let channel = channel.unwrap_or_else(|| panic!("no topic {topic}"));
        let known = field.is_empty() || channel.fields.iter().any(|(name, _, _)| *name == field);
        assert!(known, "{path}");
        shown += 1;
    };
    let panels = layout["configById"].as_object().unwrap();
    for panel in panels.values() {
        let paths = panel["paths"].as_array();
        for path in paths.into_iter().flatten() {
            look(path["value"].as_str().unwrap());
        }
        for key in ["topicToRender", "topicPath"] {
            if let Some(path) = panel[key].as_str() {
                look(path);
            }
        }
    }
    assert!(shown >= 10, "{shown}");
    let mut placed = Vec::new();
    leaves(&layout["layout"], &mut placed);
    placed.sort_unstable();
    assert_eq!(
        placed,
        panels.keys().map(String::as_str).collect::<Vec<_>>()
    );
}

/// The panels of a layout's tree.
fn leaves<'a>(node: &'a Value, found: &mut Vec<&'a str>) {
    match node {
        Value::String(name) => found.push(name),
        Value::Object(split) => ["first", "second"]
            .iter()
            .for_each(|side| leaves(&split[*side], found)),
        other => panic!("{other} in the layout"),
    }
}

fn fault_kind() -> RunEventKind {
    RunEventKind::Fault {
        fault: Fault::OverForce,
        origin: Origin::Force,
        value: 400.0,
    }
}

#[test]
fn an_unchanged_status_is_logged_ten_times_a_second() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("still.mcap");
    let mut writer = mcap::McapWriter::create(&path, &header()).unwrap();
    for k in 0..2000 {
        let mut still = block(0);
        still.status = Some(Status {
            tick: k,
            measured_amplitude_m: 0.0,
            ..status(0)
        });
        writer.block(&still).unwrap(); // a second in all
    }
    writer.finish().unwrap();
    let bytes = fs::read(&path).unwrap();
    let messages = ::mcap::MessageStream::new(&bytes).unwrap();
    let found = messages.filter(|m| m.as_ref().unwrap().channel.topic == "/status");
    assert_eq!(found.count(), 1 + 10);
}
