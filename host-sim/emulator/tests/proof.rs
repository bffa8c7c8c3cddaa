//! The small motion before the ramp: it proves the sensors before any blow.

use emulator::local::Local;
use emulator::record::{BlockRow, Event, EventKind, Observer, TickRow};
use emulator::run::run;
use emulator::scenario::parse;
use rayon::prelude::*;
use shared::control::State;
use shared::fault::{Fault, Origin};

/// A blow: more than the smallest contact that the force sensor's noise leaves to see, N.
const BLOW_N: f64 = 3.0;

/// What a start came to.
#[derive(Debug, Default)]
struct Start {
    /// The first fault, and when, s.
    fault: Option<(Fault, Origin, f64)>,
    /// Largest true force before the ramp, N, and true displacement of the cart, mm.
    force_n: f64,
    cart_mm: f64,
    has_ramped: bool,
    has_proven: bool,
    state: State,
}

impl Observer for Start {
    fn tick(&mut self, row: &TickRow) {
        if !self.has_ramped {
            self.force_n = self.force_n.max(row.true_force_n);
            self.cart_mm = self.cart_mm.max(row.cart_m.abs() * 1e3);
        }
    }
    fn block(&mut self, row: &BlockRow) {
        self.state = row.status.state;
        self.has_ramped |= self.state == State::Ramp;
        self.has_proven |= self.state == State::Prove;
    }
    fn event(&mut self, event: &Event) {
        if let EventKind::Fault { fault, origin, .. } = event.what {
            self.fault.get_or_insert((fault, origin, event.time_s));
        }
    }
}

/// A start at 0.5 s of a rig with 1 % noise.
fn start(rig: &str, tables: &str) -> Start {
    let text = format!(
        "duration_s = 8.0\nseed = 7\n[true_rig]\npreset = \"{rig}\"\n{tables}\
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
