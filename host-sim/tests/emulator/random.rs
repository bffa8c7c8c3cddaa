//! Random rigs, beliefs, sensors and mishaps: whatever happens, what the sensors show above a trip level switches
//! the drive off in time, nothing that is not a number comes out, and a stop is obeyed.
//!
//! `PROPTEST_CASES=5000 cargo test -p host-sim --test emulator random` for more than the 250 run here.

use emulator::local::Local;
use emulator::record::{BlockRow, Observer, TickRow};
use emulator::run::run;
use emulator::scenario::{Act, Fault, Scenario, Timed, parse};
use emulator::sensors::Sensor;
use emulator::under_test::Reset;
use proptest::prelude::*;
use shared::control::State;
use shared::io::{AdcCode, Channel, Reading};
use shared::settings::Settings;

/// Rig time, s; the last seconds are for the stop to be obeyed.
const DURATION_S: f64 = 16.0;
const STOP_S: f64 = 11.0;
/// Blocks of ten ticks: the rest of the sample's own, one more; and one in which the controller has just come to
/// drive and its outputs have not yet.
const GRACE: u64 = 30;

/// Watches what must never happen.
struct Watch {
    settings: Settings,
    over_force: u64,
    over_travel: u64,
    /// Tick by which the drive must be off.
    deadline: Option<u64>,
    wrong: Option<String>,
}

fn value(channel: &Channel, code: AdcCode) -> Option<f32> {
    match channel.read(code) {
        Reading::Value(value) | Reading::Saturated(value) => Some(value),
        Reading::Open => None,
    }
}

/// Counts ticks in a row.
fn count(in_a_row: &mut u64, is: bool) -> u64 {
    *in_a_row = if is { *in_a_row + 1 } else { 0 };
    *in_a_row
}

impl Watch {
    fn wrong(&mut self, text: String) {
        self.wrong.get_or_insert(text);
    }
}

impl Observer for Watch {
    fn tick(&mut self, row: &TickRow) {
        let (settings, frame) = (&self.settings, &row.frame);
        let on = row.output.enable;
        let force = value(&settings.force, frame.force);
        let travel = value(&settings.hammer, frame.hammer)
            .zip(value(&settings.cart, frame.cart))
            .map(|(x, y)| (x - y).abs());
        let too_strong = on && force.is_some_and(|n| n > settings.trips.force_n);
        let too_far = on && travel.is_some_and(|m| m > settings.trips.travel_m);
        let trips = count(&mut self.over_force, too_strong) >= 2
            || count(&mut self.over_travel, too_far) >= 4;
        if trips || on && frame.emergency {
            self.deadline.get_or_insert(row.tick + GRACE);
        }
        if !on {
            self.deadline = None;
        }
        if self.deadline.is_some_and(|last| row.tick > last) {
            self.wrong(format!("the drive is still on at {} s", row.time_s));
        }
        if !row.output.frequency_hz.is_finite() {
            self.wrong(format!("no number put out at {} s", row.time_s));
        }
    }

    fn block(&mut self, row: &BlockRow) {
        let s = row.status;
        let told = [
            s.frequency_hz,
            s.amplitude_m,
            s.measured_amplitude_m,
            s.lag_rad,
            s.peak_n,
            s.impulse_n_s,
            s.target_hz,
            s.target_n,
        ];
        if !told.iter().all(|x| x.is_finite()) {
            self.wrong(format!("no number told at tick {}: {s:?}", row.tick));
        }
        let driven = row.outputs.iter().any(|output| output.enable);
        if driven && matches!(s.state, State::Idle | State::SelfTest | State::Fault) {
            self.wrong(format!("driven in {:?} at tick {}", s.state, row.tick));
        }
    }
}

fn mishap() -> impl Strategy<Value = Act> {
    let sensor = prop_oneof![
        Just(Sensor::Force),
        Just(Sensor::Hammer),
        Just(Sensor::Cart)
    ];
    let fault = prop_oneof![
        Just(Fault::Open),
        Just(Fault::Saturated),
        Just(Fault::SaturatedLow),
        Just(Fault::Frozen),
        Just(Fault::Gain),
    ];
    let cause = prop_oneof![
        Just(Reset::PowerOn),
        Just(Reset::Watchdog),
        Just(Reset::BrownOut),
        Just(Reset::Crash),
    ];
    prop_oneof![
        (-0.6..0.6).prop_map(|speed_m_per_s| Act::Push { speed_m_per_s }),
        (sensor, fault, -3.0..5.0, 1e-4..2.0).prop_map(|(sensor, fault, times, for_s)| {
            Act::SensorFault {
                sensor: sensor.into(),
                fault,
                times: (fault == Fault::Gain).then_some(times),
                for_s: Some(for_s),
                percent_per_s: None,
                offset_n: None,
                offset_um: None,
                drift_n_per_s: None,
                drift_um_per_s: None,
                noise_n: None,
                noise_um: None,
                delay_ms: None,
                ticks: None,
                of: None,
                at: None,
            }
        }),
        (1_u32..6, 1_u32..8).prop_map(|(blocks, every)| Act::Overrun { blocks, every }),
        (1_u32..6, 1_u32..8).prop_map(|(blocks, every)| Act::LostBlock { blocks, every }),
        (1e-4..1.0).prop_map(|s| Act::EmergencyStop { for_s: Some(s) }),
        (-8.0..8.0, -2.0..4.0, 0.0..2.0).prop_map(|(hz, gap_mm, over_s)| Act::Drift {
            over_s,
            natural_frequency_percent: hz,
            contact_stiffness_percent: 0.0,
            contact_damping_percent: 0.0,
            gap_offset_mm: gap_mm,
            restitution: None,
        }),
        cause.prop_map(|cause| Act::Reset { cause }),
        Just(Act::ClearFault {}),
        Just(Act::Start {
            mode: Default::default()
        }),
        Just(Act::Link {}),
        Just(Act::LinkLoss {}),
    ]
}

prop_compose! {
    fn scenario()(
        rig in prop_oneof![Just("wires"), Just("beam-170"), Just("beam-150"), Just("beam-135")],
        gap_mm in 0.0..3.0_f64,
        hz in -10.0..10.0_f64,
        stiffness in -30.0..30.0_f64,
        damping in -30.0..30.0_f64,
        noise in 0.0..3.0_f64,
        block_ticks in 1_usize..=10,
        seed in any::<u64>(),
        mut events in prop::collection::vec((2.0..STOP_S, mishap()), 0..5),
    ) -> Scenario {
        let text = format!(
            "duration_s = {DURATION_S:?}\nblock_ticks = {block_ticks}\n[true_rig]\npreset = \"{rig}\"\ngap_mm = {gap_mm}\nnatural_frequency_percent = {hz}\ncontact_stiffness_percent = {stiffness}\ncontact_damping_percent = {damping}\n[sensors]\nnoise_percent = {noise}\n"
        );
        let mut scenario = parse("random", &text, "random").unwrap();
        scenario.seed = seed;
        // The command is there however small the block.
        scenario.slices_per_block = 2 * block_ticks as u32;
        let start = Act::Start { mode: Default::default() };
        events.extend([(0.1, start), (STOP_S, Act::Stop {})]);
        events.sort_by(|a, b| a.0.total_cmp(&b.0));
        scenario.events = events.into_iter().map(|(at_s, act)| Timed { at_s, act }).collect();
        scenario
    }
}

fn cases() -> u32 {
    let asked = std::env::var("PROPTEST_CASES").ok();
    asked.and_then(|n| n.parse().ok()).unwrap_or(250)
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: cases(),
        failure_persistence: None,
        max_shrink_iters: 30,
        ..ProptestConfig::default()
    })]

    #[test]
    fn whatever_happens_the_drive_goes_off_in_time(scenario in scenario()) {
        let mut control = Local::new(&scenario.settings).unwrap();
        let mut watch = Watch {
            settings: scenario.settings,
            over_force: 0,
            over_travel: 0,
            deadline: None,
            wrong: None,
        };
        let summary = run(&scenario, &mut control, &mut watch).unwrap();
        prop_assert!(watch.wrong.is_none(), "{:?}", watch.wrong);
        let last = summary.final_state();
        prop_assert!(matches!(last, State::Idle | State::Fault), "stuck in {last:?}");
    }
}
