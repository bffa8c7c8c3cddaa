//! How well the force wanted is there: the true mean peak of the contacts over what was asked, in Hold, for two rigs,
//! several forces and several levels of noise. Prints a table.
//!
//!     cargo run --release -p emulator --example force_wanted -- [RINGING_PERCENT]
//!
//! RINGING_PERCENT is the surface's ringing over the contact's peak, 50 if left out.

use emulator::local::Local;
use emulator::record::{BlockRow, Contact, Observer};
use emulator::run::run;
use emulator::scenario::parse;
use rayon::prelude::*;

/// Rig time of a run, and from when on contacts count, s.
const LONG_S: f64 = 60.0;
const FROM_S: f64 = 35.0;
const RIGS: [&str; 2] = ["wires", "beam-135"];
const NOISE_PERCENT: [f64; 4] = [0.0, 0.5, 2.0, 4.0];
const FORCES_N: [f64; 5] = [40.0, 60.0, 87.0, 120.0, 140.0];

/// True peaks, and what the controller measured and was limited by.
#[derive(Default)]
struct Peaks {
    sum_n: f64,
    count: f64,
    largest_n: f64,
    measured_n: (f64, f64),
    limited: bool,
}

impl Observer for Peaks {
    fn contact(&mut self, contact: &Contact) {
        if contact.onset_s > FROM_S {
            self.sum_n += contact.peak_force_n;
            self.count += 1.0;
        }
        self.largest_n = self.largest_n.max(contact.peak_force_n);
    }
    fn block(&mut self, row: &BlockRow) {
        if row.tick as f64 * 5e-5 > FROM_S {
            self.measured_n.0 += f64::from(row.status.peak_n);
            self.measured_n.1 += 1.0;
            self.limited |= !row.status.limits.is_empty();
        }
    }
}

fn row(rig: &str, noise: f64, force_n: f64, ringing: f64) -> String {
    let text = format!(
        "duration_s = {LONG_S:?}\nseed = 5\n[true_rig]\npreset = \"{rig}\"\n[sensors]\nnoise_percent = {noise:?}\nringing_percent = {ringing:?}\n[aim]\nforce_n = {force_n:?}\n[[events]]\nat_s = 0.5\nkind = \"start\"\n"
    );
    let scenario = match parse("force", &text, "force") {
        Ok(scenario) => scenario,
        Err(e) => return format!("| {rig} | {noise} | {force_n} | {e} |"),
    };
    let mut peaks = Peaks::default();
    let mut control = Local::new(&scenario.settings).unwrap();
    let summary = run(&scenario, &mut control, &mut peaks).unwrap();
    let mean = 100.0 * peaks.sum_n / peaks.count / force_n;
    let largest = 100.0 * peaks.largest_n / force_n;
    let measured = 100.0 * peaks.measured_n.0 / peaks.measured_n.1 / force_n;
    let state = summary.final_state();
    let limited = if peaks.limited { ", limited" } else { "" };
    format!(
        "| {rig} | {noise} | {force_n} | {mean:.1} | {largest:.1} | {measured:.1} | {state:?}{limited} |"
    )
}

fn main() {
    let ringing = std::env::args().nth(1);
    let ringing: f64 = ringing.map_or(50.0, |text| text.parse().expect("a number of percent"));
    println!("| rig | noise, % | wanted, N | true mean, % of it | largest, % | measured, % | |");
    println!("|---|---|---|---|---|---|---|");
    let cases: Vec<_> = RIGS
        .iter()
        .flat_map(|rig| NOISE_PERCENT.map(|noise| (*rig, noise)))
        .flat_map(|(rig, noise)| FORCES_N.map(|force_n| (rig, noise, force_n)))
        .collect();
    let rows: Vec<_> = cases
        .par_iter()
        .map(|(rig, noise, force_n)| row(rig, *noise, *force_n, ringing))
        .collect();
    rows.iter().for_each(|row| println!("{row}"));
}
