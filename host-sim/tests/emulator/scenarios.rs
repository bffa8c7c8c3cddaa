//! Scenarios as people write them, and runs of them.

use emulator::local::Local;
use emulator::optimum::{held_force, prescribed};
use emulator::record::{BlockRow, RunEvent, RunEventKind, RunObserver, TickRow};
use emulator::run::run;
use emulator::scenario::{BUILTIN, load, parse};
use emulator::under_test::FixedFrequency;
use emulator::verdict::{Best, judge_by};
use shared::model::cart::{ASSUMED_SHAKER, CartDrive, LoopParams, UNLIMITED_N};
use shared::model::params::BEAM_150;

use crate::support::{self, TICK_S};

const SHORT: &str = "duration_s = 12.0\n[true_rig]\npreset = \"wires\"\n";

#[test]
fn every_built_in_scenario_reads_and_says_what_it_is_for() {
    for (name, _) in BUILTIN {
        let scenario = load(name).unwrap();
        assert_eq!(scenario.name, name);
        assert!(scenario.description.len() > 20, "{name}");
    }
}

#[test]
fn the_controller_is_told_the_shaker_that_its_forecast_can_follow() {
    let told = |more: &str| {
        let scenario = parse("mine", &format!("{SHORT}{more}"), "mine.toml").unwrap();
        scenario.settings.rig.cart
    };
    let usual = CartDrive::Loop(ASSUMED_SHAKER);
    assert_eq!(told(""), usual);
    let soft = LoopParams {
        frequency_hz: 35.0,
        damping_ratio: 0.5,
        feed_forward: 0.9,
        max_force_n: 150.0,
    };
    let shaker =
        "[shaker]\nloop_hz = 35.0\nloop_damping_ratio = 0.5\nfeed_forward = 0.9\nforce_n = 150.0\n";
    assert_eq!(told(shaker), CartDrive::Loop(soft));
    let believed = "[believed]\npreset = \"wires\"\n";
    assert_eq!(told(&format!("{shaker}{believed}")), CartDrive::Loop(soft));
    // What it believes may differ, and a loop says nothing of a largest force.
    let other = told(&format!("{shaker}{believed}shaker_loop_hz = 50.0"));
    let unlimited = LoopParams {
        max_force_n: UNLIMITED_N,
        ..ASSUMED_SHAKER
    };
    assert_eq!(other, CartDrive::Loop(unlimited));
    let none = told(&format!(
        "{shaker}{believed}shaker_loop_hz = \"prescribed\""
    ));
    assert_eq!(none, CartDrive::Prescribed);
    // No shaker, or one whose loop the settings do not take.
    assert_eq!(told("[shaker]\nprescribed = true"), CartDrive::Prescribed);
    assert_eq!(
        told("[shaker]\nloop_hz = 400.0\nloop_damping_ratio = 2.0"),
        CartDrive::Prescribed
    );
    assert_eq!(told("[motor]"), CartDrive::Prescribed);
    // The last of them is said.
    let left_out = |more: &str| {
        let scenario = parse("mine", &format!("{SHORT}{more}"), "mine.toml").unwrap();
        scenario.loop_left_out.map(|why| (why.key, why.value))
    };
    assert_eq!(left_out(""), None);
    assert_eq!(left_out("[shaker]\nprescribed = true"), None);
    assert_eq!(left_out("[motor]"), None);
    let fast = "[shaker]\nloop_hz = 400.0\nloop_damping_ratio = 2.0";
    assert_eq!(left_out(fast), Some(("shaker_loop_hz", 400.0)));
    let rig = "duration_s = 3.0\n[true_rig]\npreset = \"wires\"\nshaker_loop_hz = 50.0";
    let line = parse("mine", rig, "mine.toml").unwrap_err().to_string();
    assert!(
        line.contains("shaker_loop_hz does not belong here"),
        "{line}"
    );
}

#[test]
fn every_mistake_gets_one_line_that_names_it() {
    let complaint = |text: &str| {
        let line = parse("mine", text, "mine.toml").unwrap_err().to_string();
        assert!(line.starts_with("mine.toml"), "{line}");
        assert!(!line.contains('\n'), "{line}");
        line
    };
    let with = |more: &str| complaint(&format!("{SHORT}{more}"));
    assert!(complaint("duration_s = ").contains("line 1"));
    assert!(complaint("duraton_s = 3").contains("did you mean 'duration_s'"));
    assert!(complaint("duration_s = 3.0").contains("true_rig"));
    assert!(
        complaint("duration_s = -3.0\n[true_rig]\npreset = \"wires\"").contains("duration_s is -3")
    );
    assert!(with("gap = 1.0").contains("did you mean 'gap_mm'"));
    assert!(with("[believed]\npreset = \"wire\"").contains("did you mean 'wires'"));
    assert!(with("[sensors]\nnoise_percnt = 1.0").contains("did you mean 'noise_percent'"));
    assert!(with("[sensors]\nnoise_percent = -1.0").contains("noise_percent is -1"));
    assert!(with("[shaker]\nlag_ms = 0.0").contains("lag_ms is 0"));
    assert!(with("[limits]\nforce_n = -1.0").contains("limits.force_n"));
    assert!(with("[[events]]\nkind = \"start\"").contains("at_s"));
    assert!(with("[[events]]\nat_s = 13.0\nkind = \"start\"").contains("at_s is 13"));
    assert!(with("[[events]]\nat_s = 1.0\nkind = \"strat\"").contains("did you mean 'start'"));
    let push = with("[[events]]\nat_s = 1.0\nkind = \"push\"\nspeed = 1.0");
    assert!(push.contains("did you mean 'speed_m_per_s'"), "{push}");
    assert!(with("[[events]]\nat_s = 1.0\nkind = \"stop\"\nfor_s = 1.0").contains("for_s"));
    let event = |more: &str| with(&format!("[[events]]\nat_s = 1.0\n{more}"));
    assert!(event("kind = \"stop\"\nfrequency_hz = 1.0").contains("it takes none"));
    assert!(event("kind = \"push\"\nspeed_m_per_s = 1e12").contains("must be -10 to 10"));
    assert!(event("kind = \"emergency-stop\"\nfor_s = -3.0").contains("for_s is -3, must be"));
    let fault = |how: &str| {
        event(&format!(
            "kind = \"sensor-fault\"\nsensor = \"force\"\n{how}"
        ))
    };
    assert!(fault("fault = \"gain\"").contains("needs times"));
    assert!(fault("fault = \"open\"\ntimes = 2.0").contains("times goes with another fault"));
    let drift = |how: &str| event(&format!("kind = \"drift\"\nover_s = 1.0\n{how}"));
    assert!(drift("").contains("changes nothing"));
    assert!(drift("gap_offset_mm = nan").contains("gap_offset_mm is NaN"));
    assert!(drift("natural_frequency_percent = -100.0").contains("must be -90 to 900"));
    assert!(drift("gap_offset_mm = 90.0").contains("gap_mm is 90"));
    let rig = "duration_s = 3.0\n[true_rig]\npreset = \"wires\"\ncontact_damping_percent = -150.0";
    assert!(complaint(rig).contains("contact_damping_percent is -150"));
    assert!(with("[limits]\namplitude_mm = 0.0").contains("limits.amplitude_mm is 0"));
    assert!(complaint("duration_s = \"five\"").contains("expected a number"));
    assert!(with("[expect]\nfinal = \"hold\"").contains("did you mean 'final_state'"));
    let lost = load("feild").unwrap_err().to_string();
    assert!(lost.contains("did you mean 'field'"), "{lost}");
}

/// Keeps what a run told, as text.
#[derive(Default)]
struct Trace {
    ticks: u64,
    blocks: u64,
    sum: u64,
    events: Vec<RunEvent>,
}

impl RunObserver for Trace {
    fn tick(&mut self, row: &TickRow) {
        assert_eq!(row.tick, self.ticks);
        self.ticks += 1;
        // A digest that any changed bit changes.
        for x in [
            u64::from(row.frame.force.0),
            u64::from(row.frame.hammer.0),
            u64::from(row.frame.cart.0),
            u64::from(row.output.dac.0),
            row.true_force_n.to_bits(),
            row.hammer_m.to_bits(),
        ] {
            self.sum = (self.sum ^ x)
                .wrapping_mul(0x9e37_79b9_7f4a_7c15)
                .rotate_left(17);
        }
    }
    fn block(&mut self, row: &BlockRow) {
        self.blocks += 1;
        assert_eq!(row.frames.len(), row.ticks);
    }
    fn event(&mut self, event: &RunEvent) {
        self.events.push(event.clone());
    }
}

#[test]
fn the_same_seed_gives_the_same_run_bit_for_bit_and_another_does_not() {
    let trace = |seed: u64| {
        let text = format!(
            "seed = {seed}\n{SHORT}[sensors]\nnoise_percent = 1.0\n[[events]]\nat_s = 0.5\nkind = \"start\"\n"
        );
        let scenario = parse("short", &text, "short.toml").unwrap();
        let mut control = Local::new(&scenario.settings).unwrap();
        let mut trace = Trace::default();
        run(&scenario, &mut control, &mut trace).unwrap();
        assert_eq!((trace.ticks, trace.blocks), (240_000, 24_000));
        trace
    };
    let (a, b, other) = (trace(1), trace(1), trace(2));
    assert_eq!(a.sum, b.sum);
    assert_eq!(a.events, b.events);
    assert_ne!(a.sum, other.sum);
}

#[test]
fn a_controller_that_only_drives_is_stopped_by_its_emergency_chain_a_block_later() {
    let text = format!(
        "{SHORT}[[events]]\nat_s = 1.0\nkind = \"start\"\n[[events]]\nat_s = 10.0001\nkind = \"emergency-stop\"\n"
    );
    let scenario = parse("short", &text, "short.toml").unwrap();
    let mut control = FixedFrequency::new(scenario.settings, 3.66);
    let mut trace = Trace::default();
    let summary = run(&scenario, &mut control, &mut trace).unwrap();
    assert!(summary.contacts > 20, "{}", summary.contacts);
    let drive: Vec<_> = trace
        .events
        .iter()
        .filter_map(|e| match e.what {
            RunEventKind::Drive { on } => Some((e.tick, on)),
            _ => None,
        })
        .collect();
    // The start comes between blocks, its block's answer with the next; the chain opens at tick 200002.
    assert_eq!(drive, [(20_010, true), (200_010, false)]);
    let verdict = judge_by(&scenario, &summary, Best::default());
    assert_eq!(verdict.final_state, "fault");
}

#[test]
fn a_clock_that_is_fast_makes_the_drive_fast() {
    // Two hundred seconds' worth of phase would show 1000 ppm; the period of contacts shows it at once.
    let period = |ppm: f64| {
        let text =
            format!("clock_ppm = {ppm:?}\n{SHORT}[[events]]\nat_s = 0.1\nkind = \"start\"\n");
        let scenario = parse("short", &text, "short.toml").unwrap();
        let mut control = FixedFrequency::new(scenario.settings, 4.0);
        let mut onsets = Onsets::default();
        run(&scenario, &mut control, &mut onsets).unwrap();
        let (a, b) = (onsets.0[onsets.0.len() - 11], onsets.0[onsets.0.len() - 1]);
        (b - a) / 10.0
    };
    let ratio = period(2000.0) / period(0.0);
    assert!((ratio - 1.002).abs() < 5e-5, "{ratio}");
}

#[derive(Default)]
struct Onsets(Vec<f64>);

impl RunObserver for Onsets {
    fn contact(&mut self, contact: &emulator::record::TrueContact) {
        self.0.push(contact.onset_s);
    }
}

#[test]
fn the_plants_own_force_search_gives_the_references_orbit_when_motion_is_prescribed() {
    let rig = BEAM_150;
    let (_, top) = prescribed(&rig).unwrap();
    let plant = support::prescribed(&rig, TICK_S);
    let force_n = held_force(plant, &rig, top.frequency_hz, top.section).unwrap();
    let off = force_n / top.force_n - 1.0;
    assert!(off.abs() < 1e-6, "{off:.1e}");
}
