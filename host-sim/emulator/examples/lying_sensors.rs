//! Every sensor, alone and in pairs, made to lie from the start and in Hold: what the controller finds, when, and what
//! the plant truly did meanwhile. Prints a table.
//!
//!     cargo run --release -p emulator --example lying_sensors

use emulator::local::Local;
use emulator::record::{BlockRow, Contact, Event, EventKind, Observer, TickRow};
use emulator::run::run;
use emulator::scenario::parse;
use rayon::prelude::*;
use shared::fault::{Fault, Origin};

#[derive(Default)]
struct Truth {
    fault: Option<(Fault, Origin, f64)>,
    force_n: f64,
    cart_mm: f64,
    hz: f32,
    on: bool,
}

impl Observer for Truth {
    fn tick(&mut self, row: &TickRow) {
        self.on = row.output.enable;
        if self.on {
            self.cart_mm = self.cart_mm.max(row.cart_m.abs() * 1e3);
        }
    }
    fn contact(&mut self, contact: &Contact) {
        if self.on {
            self.force_n = self.force_n.max(contact.peak_force_n);
        }
    }
    fn block(&mut self, row: &BlockRow) {
        if self.on {
            self.hz = row.status.frequency_hz;
        }
    }
    fn event(&mut self, event: &Event) {
        if let EventKind::Fault { fault, origin, .. } = event.what {
            self.fault.get_or_insert((fault, origin, event.time_s));
        }
    }
}

const LONG_S: f64 = 70.0;

fn told(rig: &str, lies: &[(&str, f64)], at_s: f64) -> String {
    let mut text = format!(
        "duration_s = {LONG_S:?}\nseed = 7\n[true_rig]\npreset = \"{rig}\"\n[sensors]\nnoise_percent = 1.0\n[[events]]\nat_s = 0.5\nkind = \"start\"\n"
    );
    for (sensor, times) in lies {
        text += &format!(
            "[[events]]\nat_s = {at_s:?}\nkind = \"sensor-fault\"\nsensor = \"{sensor}\"\nfault = \"gain\"\ntimes = {times:?}\n"
        );
    }
    text
}

fn main() {
    let mut lies: Vec<Vec<(&str, f64)>> = vec![vec![]];
    let gains = [-1.0, 0.0, 0.4, 0.5, 0.64, 0.8, 0.9, 1.1, 1.25, 1.6];
    for sensor in ["force", "hammer", "cart"] {
        lies.extend(gains.map(|times| vec![(sensor, times)]));
    }
    for (a, b) in [("force", "hammer"), ("force", "cart"), ("hammer", "cart")] {
        lies.extend([0.5, 0.7, 0.8, 1.25, 1.5, -1.0].map(|times| vec![(a, times), (b, times)]));
    }
    lies.extend([0.5, 0.7, 0.8, 1.25].map(|g| vec![("force", g), ("hammer", g), ("cart", g)]));
    let rig = std::env::args().nth(1).unwrap_or_else(|| "wires".into());
    println!(
        "| sensors | told from, s | found after, s | fault, sensor | true force, N | cart, mm |"
    );
    println!("|---|---|---|---|---|---|");
    let cases: Vec<_> = lies
        .iter()
        .flat_map(|lie| [0.1, 45.0].map(|at_s| (lie, at_s)))
        .collect();
    let rows: Vec<_> = cases
        .par_iter()
        .map(|(lie, at_s)| {
            let scenario = parse("lie", &told(&rig, lie, *at_s), "lie").unwrap();
            let mut truth = Truth::default();
            let mut control = Local::new(&scenario.settings).unwrap();
            run(&scenario, &mut control, &mut truth).unwrap();
            let who: Vec<_> = lie.iter().map(|(s, t)| format!("{s} {t}")).collect();
            let (when, what) = truth.fault.map_or(("–".into(), "–".into()), |(f, o, t)| {
                (
                    format!("{:.1}", t - at_s.max(0.5)),
                    format!("{}, {o:?}", f.name()),
                )
            });
            format!(
                "| {} | {at_s} | {when} | {what} | {:.0} | {:.2} |",
                who.join(", "),
                truth.force_n,
                truth.cart_mm
            )
        })
        .collect();
    for row in rows {
        println!("{row}");
    }
}
