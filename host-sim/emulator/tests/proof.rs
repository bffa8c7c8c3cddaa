//! The small motion before the ramp: it proves the sensors before any blow.

use emulator::local::Local;
use emulator::record::{BlockRow, RunEvent, RunEventKind, RunObserver, TickRow};
use emulator::run::run;
use emulator::scenario::parse;
use rayon::prelude::*;
use shared::control::State;
use shared::fault::{Fault, Origin};
use shared::settings::TICK_S;

/// When it is started, s.
const START_S: f64 = 0.5;

/// A blow, N: a contact is detected from 14 N on the wires, and from more on beams.
const BLOW_N: f64 = 5.0;

/// What a start came to.
#[derive(Debug, Default)]
struct Start {
    /// The first fault, and when, s.
    fault: Option<(Fault, Origin, f64)>,
    /// Largest true force before the ramp, N, and true displacement of the cart, mm.
    force_n: f64,
    cart_mm: f64,
    has_ramped: bool,
    /// What was proven, in words.
    proven: Option<String>,
    state: State,
    /// When it held first, s after the start.
    hold_s: Option<f64>,
}

impl RunObserver for Start {
    fn tick(&mut self, row: &TickRow) {
        if !self.has_ramped {
            self.force_n = self.force_n.max(row.true_force_n);
            self.cart_mm = self.cart_mm.max(row.cart_m.abs() * 1e3);
        }
    }
    fn block(&mut self, row: &BlockRow) {
        self.state = row.status.state;
        self.has_ramped |= self.state == State::Ramp;
        if self.state == State::Hold {
            let now_s = row.tick as f64 * TICK_S;
            self.hold_s.get_or_insert(now_s - START_S);
        }
    }
    fn event(&mut self, event: &RunEvent) {
        match &event.what {
            RunEventKind::Fault { fault, origin, .. } => {
                self.fault.get_or_insert((*fault, *origin, event.time_s));
            }
            RunEventKind::Said { text } if text.starts_with("proven") => {
                self.proven = Some(text.clone());
            }
            _ => {}
        }
    }
}

/// A start at 0.5 s, watched for 8 s.
fn start(rig: &str, tables: &str) -> Start {
    after(8.0, rig, tables)
}

/// A start at 0.5 s, watched for `seconds`.
fn after(seconds: f64, rig: &str, tables: &str) -> Start {
    let text = format!(
        "duration_s = {seconds:?}\nseed = 7\n[true_rig]\npreset = \"{rig}\"\n{tables}\
         [[events]]\nat_s = 0.5\nkind = \"start\"\n"
    );
    let scenario = parse("proof", &text, "proof").unwrap();
    let mut start = Start::default();
    run(
        &scenario,
        &mut Local::new(&scenario.settings).unwrap(),
        &mut start,
    )
    .unwrap();
    println!("{rig} {tables:?}: {start:?}");
    start
}

fn lie(sensor: &str, how: &str) -> String {
    format!("[sensors]\nnoise_percent = 1.0\n[[sensors.defects]]\nsensor = \"{sensor}\"\n{how}\n")
}

fn gain(sensor: &str, times: f64) -> String {
    lie(sensor, &format!("fault = \"gain\"\ntimes = {times:?}"))
}

#[test]
fn wrong_sensors_are_found_before_the_ramp_and_before_any_blow() {
    let swapped = lie("displacements", "fault = \"swapped\"");
    let cases = [
        (gain("hammer", -1.0), Origin::Hammer),
        (gain("hammer", 0.5), Origin::Hammer),
        (gain("hammer", 1.6), Origin::Hammer),
        (lie("hammer", "fault = \"dead\""), Origin::Hammer),
        (gain("cart", -1.0), Origin::Cart),
        (gain("cart", 0.5), Origin::Cart),
        (gain("cart", 1.5), Origin::Cart),
        (lie("cart", "fault = \"dead\""), Origin::Cart),
        (gain("displacements", -1.0), Origin::Cart),
        (gain("displacements", 0.5), Origin::Cart),
        (swapped, Origin::Cart),
        ("[shaker]\nreversed = true\n".into(), Origin::Cart),
    ];
    let rigs = ["wires", "beam-135"];
    let gaps = [-0.2, 0.0, 1.0];
    let all = rigs.iter().flat_map(|rig| gaps.map(|gap_mm| (rig, gap_mm)));
    let all: Vec<_> = all
        .flat_map(|at| cases.iter().map(move |case| (at, case)))
        .collect();
    let wrong = all.par_iter().filter_map(|((rig, gap_mm), (lie, origin))| {
        let found = start(rig, &format!("gap_mm = {gap_mm:?}\n{lie}"));
        let named = found.fault.is_some_and(|(fault, named, at_s)| {
            fault == Fault::SensorOutOfFamily && named == *origin && at_s < 5.5
        });
        let unharmed = !found.has_ramped && found.force_n < BLOW_N;
        (!named || !unharmed).then(|| format!("{rig} {gap_mm} {lie:?}: {found:?}"))
    });
    let wrong: Vec<_> = wrong.collect();
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn gains_within_a_tenth_of_the_thresholds_are_not_found_before_the_ramp() {
    // Hammer over cart is 1.2 at 1 mm and 1 while pressed on: 0.75 and 1.52 trip. Cart over command: 0.7 trips.
    let twins = [
        (1.0, gain("hammer", 0.68)),
        (1.0, gain("hammer", 1.2)),
        (-0.2, gain("hammer", 0.8)),
        (-0.2, gain("hammer", 1.45)),
        (-0.2, gain("cart", 0.74)),
        (1.0, gain("cart", 0.84)),
        // At 1.3 the hammer must confirm that the cart goes so far.
        (-0.2, gain("cart", 1.25)),
    ];
    let wrong = twins.par_iter().filter_map(|(gap_mm, lie)| {
        let found = start("wires", &format!("gap_mm = {gap_mm:?}\n{lie}"));
        let healthy = found.has_ramped && found.proven.is_some();
        (!healthy).then(|| format!("{gap_mm} {lie:?}: {found:?}"))
    });
    let wrong: Vec<_> = wrong.collect();
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn a_healthy_rig_is_proven_without_a_blow() {
    // Sensors 5 % off either way, natural frequencies 10 % off, gaps from pressed on to 2 mm, 2 % noise.
    let rigs = ["wires", "beam-170", "beam-150", "beam-135"];
    let cases: Vec<(usize, u32)> = (0..4)
        .flat_map(|rig| (0..8).map(move |k| (rig, k)))
        .collect();
    let wrong = cases.par_iter().filter_map(|&(rig, k)| {
        let sign = |bit: u32| if k >> bit & 1 == 1 { 1.0 } else { -1.0 };
        let tables = format!(
            "gap_mm = {:?}\nnatural_frequency_percent = {:?}\n[sensors]\nnoise_percent = 2.0\n\
             hammer_gain_percent = {:?}\ncart_gain_percent = {:?}\n",
            [-0.3, 0.0, 0.05, 2.0][((k + k / 4) % 4) as usize],
            10.0 * sign(0),
            5.0 * sign(1),
            5.0 * sign(2),
        );
        let found = start(rigs[rig], &tables);
        let healthy = found.has_ramped && found.fault.is_none() && found.force_n < BLOW_N;
        (!healthy).then(|| format!("{} {k}: {found:?}", rigs[rig]))
    });
    let wrong: Vec<_> = wrong.collect();
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn a_guide_with_friction_is_no_wrong_sensor() {
    for rig in ["wires", "beam-135"] {
        let found = start(rig, "[cart]\ncoulomb_n = 20.0\nstatic_n = 30.0\n");
        assert!(
            found.has_ramped && found.fault.is_none(),
            "{rig}: {found:?}"
        );
    }
}

#[test]
fn a_hammer_that_swings_for_ever_is_proven_and_its_sensor_s_sign_still_found() {
    // Pushed at 2 mm: it swings by 1.7 mm, about twice A0, and touches nothing.
    let push = "[[events]]\nat_s = 0.1\nkind = \"push\"\nspeed_m_per_s = -0.02\n";
    let noise = "[sensors]\nnoise_percent = 1.0\n";
    let healthy = start("wires", &format!("gap_mm = 2.0\n{noise}{push}"));
    assert!(healthy.has_ramped && healthy.fault.is_none(), "{healthy:?}");
    // At 1 mm by half of that, it holds as soon as one at rest.
    let softly = push.replace("0.02", "0.01");
    let near = after(10.5, "wires", &format!("gap_mm = 1.0\n{noise}{softly}"));
    assert!(near.hold_s.is_some_and(|s| s < 10.0), "{near:?}");
    let reversed = format!("gap_mm = 2.0\n{}{push}", gain("hammer", -1.0));
    let reversed = start("wires", &reversed);
    let named = reversed.fault.map(|(fault, origin, _)| (fault, origin));
    assert_eq!(named, Some((Fault::SensorOutOfFamily, Origin::Hammer)));
    assert!(!reversed.has_ramped);
}

#[test]
fn limits_that_forbid_so_slow_a_motion_leave_the_cart_proven() {
    let limits = "[limits]\nmin_frequency_hz = 1.3\n";
    let healthy = start("wires", limits);
    assert!(healthy.has_ramped && healthy.fault.is_none(), "{healthy:?}");
    assert!(
        healthy
            .proven
            .as_deref()
            .is_some_and(|text| text.contains("not the hammer"))
    );
    assert!(healthy.force_n < BLOW_N, "{healthy:?}");
    let reversed = start("wires", &format!("{limits}{}", gain("cart", -1.0)));
    assert!(
        !reversed.has_ramped && reversed.fault.is_some(),
        "{reversed:?}"
    );
}

#[test]
fn watches_work_during_the_motion() {
    for (what, fault) in [
        ("kind = \"emergency-stop\"", Fault::EmergencyStop),
        ("kind = \"push\"\nspeed_m_per_s = -0.2", Fault::OverTravel),
        (
            "kind = \"sensor-fault\"\nsensor = \"cart\"\nfault = \"open\"",
            Fault::SensorOpen,
        ),
        ("kind = \"link-loss\"", Fault::LinkTimeout),
    ] {
        // The motion is from 1.6 s to 3.2 s.
        let (link, trips) = if fault == Fault::LinkTimeout {
            (
                "[trips]\nlink_timeout_s = 0.7\n[[events]]\nat_s = 0.4\nkind = \"link\"\n",
                "",
            )
        } else {
            ("", "")
        };
        let found = start(
            "wires",
            &format!("{trips}{link}[[events]]\nat_s = 2.1\n{what}\n"),
        );
        assert_eq!(
            found.fault.map(|(fault, ..)| fault),
            Some(fault),
            "{found:?}"
        );
        assert!(!found.has_ramped, "{found:?}");
    }
    let stopped = start("wires", "[[events]]\nat_s = 2.4\nkind = \"stop\"\n");
    assert!(!stopped.has_ramped && stopped.fault.is_none());
    assert_eq!(stopped.state, State::Idle, "{stopped:?}");
}

#[test]
fn a_frozen_sensor_is_found_before_the_ramp() {
    for sensor in ["hammer", "cart"] {
        let found = start("wires", &lie(sensor, "fault = \"frozen\""));
        let (fault, ..) = found.fault.expect(sensor);
        assert_eq!(fault, Fault::SensorFrozen, "{found:?}");
        assert!(!found.has_ramped, "{found:?}");
    }
}
