//! The controller against lying sensors and odd shakers, judged by what the plant truly did.

use emulator::local::Local;
use emulator::record::{BlockRow, RunEvent, RunEventKind, RunObserver, TickRow, TrueContact};
use emulator::run::run;
use emulator::scenario::parse;
use rayon::prelude::*;
use shared::control::{ActiveLimits, State};
use shared::fault::Fault;

mod healthy;
mod lies;
mod limits;
mod peaks;
mod rig;

/// What truly happened in a run; its observer.
#[derive(Debug, Default)]
struct Truth {
    /// Faults, with the time at which they were reported, s.
    faults: Vec<(Fault, f64)>,
    /// Largest force with the drive on, N.
    force_n: f64,
    /// Largest displacement of the cart with the drive on, mm.
    cart_mm: f64,
    /// Largest displacement of the hammer relative to the cart with the drive on, mm.
    travel_mm: f64,
    /// Largest force of every second, N.
    forces_n: Vec<f64>,
    /// When Hold was reached, s.
    hold_s: Option<f64>,
    end: State,
    limits: ActiveLimits,
    on: bool,
    /// When the drive was last on, s.
    last_on_s: f64,
    verbose: bool,
}

impl RunObserver for Truth {
    fn tick(&mut self, row: &TickRow) {
        self.on = row.output.enable;
        if self.on {
            self.force_n = self.force_n.max(row.true_force_n);
            self.cart_mm = self.cart_mm.max(row.cart_m.abs() * 1e3);
            let travel_mm = (row.hammer_m - row.cart_m).abs() * 1e3;
            self.travel_mm = self.travel_mm.max(travel_mm);
            self.last_on_s = row.tick as f64 / 20_000.0;
        }
    }
    fn contact(&mut self, contact: &TrueContact) {
        if self.on {
            self.force_n = self.force_n.max(contact.peak_force_n);
            let second = contact.onset_s as usize;
            if self.forces_n.len() <= second {
                self.forces_n.resize(second + 1, 0.0);
            }
            self.forces_n[second] = self.forces_n[second].max(contact.peak_force_n);
        }
    }
    fn block(&mut self, row: &BlockRow) {
        self.end = row.status.state;
        self.limits |= row.status.limits;
        if self.end == State::Hold && self.hold_s.is_none() {
            self.hold_s = Some(row.tick as f64 / 20_000.0);
        }
    }
    fn event(&mut self, event: &RunEvent) {
        if self.verbose {
            println!("{:8.3} {:?}", event.time_s, event.what);
        }
        if let RunEventKind::Fault { fault, .. } = event.what {
            self.faults.push((fault, event.time_s));
        }
    }
}

/// Whether campaigns run at their full length.
fn is_long() -> bool {
    std::env::var_os("LONG_CHECKS").is_some()
}

/// One in `of` ways, all if it [is long](is_long).
fn some<T>(of: usize, ways: impl IntoIterator<Item = T>) -> Vec<T> {
    ways.into_iter()
        .step_by(if is_long() { 1 } else { of })
        .collect()
}

/// What a scenario of wires with 1 % noise comes to; `tables` are added to it.
fn truth(duration_s: f64, tables: &str) -> Truth {
    truth_of("wires", duration_s, tables)
}

/// What a scenario of the preset `rig` with 1 % noise comes to; `tables` are added to it.
fn truth_of(rig: &str, duration_s: f64, tables: &str) -> Truth {
    truth_seeded(rig, 7, duration_s, tables)
}

/// What a scenario of `rig` with 1 % noise from `seed` comes to.
fn truth_seeded(rig: &str, seed: u32, duration_s: f64, tables: &str) -> Truth {
    truth_noisy(rig, 1.0, seed, duration_s, tables)
}

/// What a scenario of `rig` with `noise` % noise from `seed` comes to.
fn truth_noisy(rig: &str, noise: f64, seed: u32, duration_s: f64, tables: &str) -> Truth {
    truth_told(&format!(
        "duration_s = {duration_s:?}\nseed = {seed}\n[true_rig]\npreset = \"{rig}\"\n[sensors]\nnoise_percent = {noise:?}\n{tables}"
    ))
}

/// What a whole scenario comes to.
fn truth_told(text: &str) -> Truth {
    let scenario = parse("danger", text, "danger").unwrap();
    let mut truth = Truth {
        verbose: std::env::var_os("VERBOSE").is_some(),
        ..Truth::default()
    };
    run(
        &scenario,
        &mut Local::new(&scenario.settings).unwrap(),
        &mut truth,
    )
    .unwrap();
    println!(
        "{:?} {:?} {:.1} N, cart {:.2} mm, hold {:?}",
        truth.end, truth.faults, truth.force_n, truth.cart_mm, truth.hold_s
    );
    truth
}

fn event(at_s: f64, what: &str) -> String {
    format!("[[events]]\nat_s = {at_s:?}\n{what}\n")
}

fn start() -> String {
    event(0.5, "kind = \"start\"")
}

fn by_hand() -> String {
    event(0.5, "kind = \"start\"\nmode = \"manual\"")
}

fn gain(at_s: f64, sensor: &str, times: f64) -> String {
    event(
        at_s,
        &format!(
            "kind = \"sensor-fault\"\nsensor = \"{sensor}\"\nfault = \"gain\"\ntimes = {times:?}"
        ),
    )
}

fn set_point(at_s: f64, hz: f64, mm: f64) -> String {
    event(
        at_s,
        &format!("kind = \"set-point\"\nfrequency_hz = {hz:?}\namplitude_mm = {mm:?}"),
    )
}

/// Names of the faults, in order.
fn faults(truth: &Truth) -> Vec<Fault> {
    truth.faults.iter().map(|(fault, _)| *fault).collect()
}

fn lie(at_s: f64, sensor: &str, how: &str) -> String {
    event(
        at_s,
        &format!("kind = \"sensor-fault\"\nsensor = \"{sensor}\"\n{how}"),
    )
}

const RIGS: [&str; 4] = ["wires", "beam-170", "beam-150", "beam-135"];
