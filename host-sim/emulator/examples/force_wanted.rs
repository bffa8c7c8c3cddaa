//! How well the force wanted is there, whatever the surface rings like: the true peaks of the contacts over what was asked, in Hold,
//! for the four rigs; and the same with a force limit that acts instead. Prints a table of the worst of each row.
//!
//!     cargo run --release -p emulator --example force_wanted -- [NOISE_PERCENT [DECAY_MS]]
//!
//! NOISE_PERCENT is the sensors' noise over the strongest force, 0.5 if left out; DECAY_MS the time within which the ringing
//! decays, 2 if left out. Ends with 1 if a mean is more than 1 % off the force wanted, a blow in Hold above 105 % of the limit, or
//! any above 110 % of it, the trip level.

use std::process::ExitCode;

use emulator::local::Local;
use emulator::record::{BlockRow, RunObserver, TrueContact};
use emulator::run::run;
use emulator::scenario::parse;
use rayon::prelude::*;
use shared::control::State;

/// Rig time of a run, and from when on contacts count, s.
const LONG_S: f64 = 100.0;
const FROM_S: f64 = 60.0;
/// The rigs, and 0.8 of the force of their strongest 1/1, N.
const RIGS: [(&str, f64); 4] = [
    ("wires", 77.0),
    ("beam-170", 186.0),
    ("beam-150", 219.0),
    ("beam-135", 274.0),
];
const RINGING_KHZ: [f64; 4] = [1.0, 2.0, 3.0, 5.0];
const RINGING_PERCENT: [f64; 9] = [0.0, 5.0, 10.0, 15.0, 20.0, 25.0, 30.0, 40.0, 50.0];

/// True peaks once it is in Hold.
#[derive(Default)]
struct Peaks {
    sum_n: f64,
    count: f64,
    largest_n: f64,
    /// From the first block in Hold on.
    in_hold_n: f64,
    holds: bool,
}

impl RunObserver for Peaks {
    fn contact(&mut self, contact: &TrueContact) {
        if contact.onset_s > FROM_S {
            self.sum_n += contact.peak_force_n;
            self.count += 1.0;
        }
        self.largest_n = self.largest_n.max(contact.peak_force_n);
        if self.holds {
            self.in_hold_n = self.in_hold_n.max(contact.peak_force_n);
        }
    }
    fn block(&mut self, row: &BlockRow) {
        self.holds |= row.status.state == State::Hold;
    }
}

/// Mean, largest in Hold and largest of all, % of the force wanted or the limit, if it ended in Hold.
fn peaks(
    rig: &str,
    force_n: f64,
    limited: bool,
    [noise, decay_ms]: [f64; 2],
    khz: f64,
    ringing: f64,
) -> [f64; 3] {
    let asked = if limited {
        format!(
            "[limits]\nforce_n = {force_n:?}\n[trips]\nforce_n = {:?}\n",
            1.1 * force_n
        )
    } else {
        format!("[aim]\nforce_n = {force_n:?}\n")
    };
    let text = format!(
        "duration_s = {LONG_S:?}\nseed = 5\n[true_rig]\npreset = \"{rig}\"\n[sensors]\nnoise_percent = {noise:?}\nringing_decay_ms = {decay_ms:?}\nringing_hz = {:?}\nringing_percent = {ringing:?}\n{asked}[[events]]\nat_s = 0.5\nkind = \"start\"\n",
        1e3 * khz
    );
    let scenario = parse("force", &text, "force").expect("a scenario");
    let mut peaks = Peaks::default();
    let mut control = Local::new(&scenario.settings).expect("good settings");
    let summary = run(&scenario, &mut control, &mut peaks).expect("a good rig");
    if summary.final_state() != State::Hold {
        return [f64::NAN; 3];
    }
    let mean_n = peaks.sum_n / peaks.count;
    [mean_n, peaks.in_hold_n, peaks.largest_n].map(|n| 100.0 * n / force_n)
}

fn main() -> ExitCode {
    let number = |place: usize, or: f64| {
        let text = std::env::args().nth(place);
        text.map_or(or, |text| text.parse().expect("a number"))
    };
    let noise = [number(1, 0.5), number(2, 2.0)];
    println!(
        "| rig | ringing, kHz | asked | not in Hold at the end | mean, % of it | largest in Hold, % | largest, % |"
    );
    println!("|---|---|---|---|---|---|---|");
    let cases: Vec<_> = RIGS
        .iter()
        .flat_map(|rig| RINGING_KHZ.map(|khz| (*rig, khz)))
        .flat_map(|case| [false, true].map(|limited| (case, limited)))
        .collect();
    let mut kept = true;
    for ((rig, strong_n), khz, limited) in cases.iter().map(|((r, k), l)| (*r, *k, *l)) {
        let all: Vec<_> = RINGING_PERCENT
            .par_iter()
            .map(|ringing| peaks(rig, strong_n, limited, noise, khz, *ringing))
            .collect();
        kept &= all.iter().all(|[mean, in_hold, largest]| {
            if limited {
                *in_hold <= 105.0 && *largest <= 110.0
            } else {
                (99.0..=101.0).contains(mean)
            }
        });
        let range = |i: usize| {
            let held = || all.iter().map(|row| row[i]).filter(|peak| !peak.is_nan());
            let (least, most) = (held().reduce(f64::min), held().reduce(f64::max));
            format!(
                "{:.1} to {:.1}",
                least.unwrap_or(f64::NAN),
                most.unwrap_or(f64::NAN)
            )
        };
        let asked = if limited { "limit" } else { "force" };
        let lost = all.iter().filter(|[mean, ..]| mean.is_nan()).count();
        println!(
            "| {rig} | {khz} | {asked} {strong_n} N | {lost} | {} | {} | {} |",
            range(0),
            range(1),
            range(2)
        );
    }
    ExitCode::from(u8::from(!kept))
}
