//! Every sensor made to lie in every way, before the start and in Hold: what the controller finds, how soon, and what the
//! plant truly did until then. Prints a table; `--csv FILE` writes it as well.
//!
//!     cargo run --release -p emulator --example lying_sensors -- [RIG] [--limits FORCE_N,CART_MM,TRAVEL_MM]
//!         [--aim FORCE_N] [--csv FILE]
//!
//!     cargo run --release -p emulator --example lying_sensors -- --pairs COUNT,SEED
//!
//! Ends with 1 if a limit was passed.
//!
//! The second makes two sensors lie in the same run, at times drawn at random, on one of the four rigs drawn at random, with force
//! and travel limits that act (force 0.5 to 1.0 of a strong 1/1's, travel 4.5 to 6 amplitudes), by itself and by hand.
//!
//! RIG is `wires` if left out. `--limits` sets `limits.force_n`, `limits.amplitude_mm` and `limits.travel_mm` in
//! place of the rig's own; one left empty stays. `--aim` sets `aim.force_n`.

use std::fmt::Write as _;
use std::process::ExitCode;

use emulator::local::Local;
use emulator::record::{BlockRow, RunEvent, RunEventKind, RunObserver, TickRow, TrueContact};
use emulator::run::run;
use emulator::scenario::parse;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};
use rayon::prelude::*;
use shared::fault::{Fault, Origin};

/// Rig time of a run, of the start, and of the two beginnings of a lie, s.
const LONG_S: f64 = 60.0;
const START_S: f64 = 0.5;
const LIES_FROM_S: [f64; 2] = [0.1, 20.0];
/// A limit counts as passed beyond this share of it.
const PASSED: f64 = 1.1;
/// One more than the largest number of 32 bits.
const TWO_32: f64 = 4_294_967_296.0;

/// What the plant did while the drive was on, and the first fault.
#[derive(Default)]
struct Truth {
    fault: Option<(Fault, Origin, f64)>,
    force_n: f64,
    cart_mm: f64,
    travel_mm: f64,
    is_limited: bool,
    on: bool,
}

impl RunObserver for Truth {
    fn tick(&mut self, row: &TickRow) {
        self.on = row.output.enable;
        if self.on {
            self.cart_mm = self.cart_mm.max(row.cart_m.abs() * 1e3);
            let travel_mm = (row.hammer_m - row.cart_m).abs() * 1e3;
            self.travel_mm = self.travel_mm.max(travel_mm);
        }
    }
    fn contact(&mut self, contact: &TrueContact) {
        if self.on {
            self.force_n = self.force_n.max(contact.peak_force_n);
        }
    }
    fn block(&mut self, row: &BlockRow) {
        self.is_limited |= !row.status.limits.is_empty();
    }
    fn event(&mut self, event: &RunEvent) {
        if let RunEventKind::Fault { fault, origin, .. } = event.what {
            self.fault.get_or_insert((fault, origin, event.time_s));
        }
    }
}

/// A lie: what the table calls it, and its keys in a scenario.
struct Lie {
    sensor: &'static str,
    name: String,
    keys: String,
}

/// Everything that `sensor` can do.
fn lies(sensor: &'static str) -> Vec<Lie> {
    let lie = |name: String, keys: String| Lie { sensor, name, keys };
    let mut lies = vec![lie("reversed".into(), "fault = \"reversed\"".into())];
    for tenths in (4..=16).filter(|&tenths| tenths != 10) {
        let times = 0.1 * f64::from(tenths);
        lies.push(lie(
            format!("gain {times:.1}"),
            format!("fault = \"gain\"\ntimes = {times:?}"),
        ));
    }
    let (unit, key, offsets, drifts) = if sensor == "force" {
        ("N", "n", [5.0, 20.0, 100.0], [0.1, 1.0, 10.0])
    } else {
        ("µm", "um", [100.0, 400.0, 1600.0], [2.0, 20.0, 200.0])
    };
    for offset in offsets.iter().flat_map(|o| [*o, -o]) {
        lies.push(lie(
            format!("offset {offset:+} {unit}"),
            format!("fault = \"offset\"\noffset_{key} = {offset:?}"),
        ));
    }
    for drift in drifts.iter().flat_map(|d| [*d, -d]) {
        lies.push(lie(
            format!("offset drifts {drift:+} {unit}/s"),
            format!("fault = \"offset-drift\"\ndrift_{key}_per_s = {drift:?}"),
        ));
    }
    lies.push(lie("dead but noisy".into(), "fault = \"dead\"".into()));
    lies.push(lie("frozen".into(), "fault = \"frozen\"".into()));
    for ms in [0.5, 5.0, 50.0] {
        lies.push(lie(
            format!("delayed {ms} ms"),
            format!("fault = \"delayed\"\ndelay_ms = {ms:?}"),
        ));
    }
    lies
}

/// What came out of a lie.
struct Row {
    lie: String,
    from_s: f64,
    /// After how long, what, and the sensor named.
    found: Option<(f64, &'static str, Origin)>,
    force_share: f64,
    cart_share: f64,
    travel_share: f64,
    is_limited: bool,
}

impl Row {
    /// Of `lies` and when each begins; `start` is what the start event says beside its name, and events that follow.
    fn of(lies: &[(&Lie, f64)], rig: &str, limits: &str, start: &str) -> Self {
        let mut text = format!(
            "duration_s = {LONG_S:?}\nseed = 7\n[true_rig]\npreset = \"{rig}\"\n{limits}\
             [sensors]\nnoise_percent = 1.0\n\
             [[events]]\nat_s = {START_S:?}\nkind = \"start\"\n{start}"
        );
        for (Lie { sensor, keys, .. }, from_s) in lies {
            write!(
                text,
                "[[events]]\nat_s = {from_s:?}\nkind = \"sensor-fault\"\nsensor = \"{sensor}\"\n{keys}\n"
            )
            .expect("text");
        }
        let scenario = parse("lie", &text, "lie").expect("a scenario");
        let mut truth = Truth::default();
        let mut control = Local::new(&scenario.settings).expect("a controller");
        run(&scenario, &mut control, &mut truth).expect("a run");
        let bounds = scenario.settings.limits;
        let from_s = lies.iter().map(|(_, s)| *s).fold(LONG_S, f64::min);
        let told = lies
            .iter()
            .map(|(l, _)| format!("{}: {}", l.sensor, l.name));
        let after = |at_s: f64| at_s - from_s.max(START_S);
        Self {
            lie: told.collect::<Vec<_>>().join(", "),
            from_s,
            found: truth.fault.map(|(f, o, at_s)| (after(at_s), f.name(), o)),
            force_share: truth.force_n / f64::from(bounds.force_n),
            cart_share: 1e-3 * truth.cart_mm / f64::from(bounds.amplitude_m),
            travel_share: 1e-3 * truth.travel_mm / f64::from(bounds.travel_m),
            is_limited: truth.is_limited,
        }
    }

    /// Whether a limit was passed, and whether the controller had seen it.
    fn mark(&self) -> &'static str {
        let largest = self.force_share.max(self.cart_share).max(self.travel_share);
        let passed = largest > PASSED;
        match (passed, self.found.is_some(), self.is_limited) {
            (false, true, _) => "found",
            (false, false, _) => "harmless",
            (true, true, _) => "passed, found",
            (true, false, true) => "passed, limited",
            (true, false, false) => "PASSED UNSEEN",
        }
    }

    fn cells(&self) -> [String; 9] {
        let [when, what, who] = match self.found {
            Some((s, what, who)) => [format!("{s:.1}"), what.into(), format!("{who:?}")],
            None => ["–", "–", "–"].map(String::from),
        };
        [
            self.lie.clone(),
            format!("{:.1}", self.from_s),
            when,
            what,
            who.to_lowercase(),
            format!("{:.0} %", 100.0 * self.force_share),
            format!("{:.0} %", 100.0 * self.cart_share),
            format!("{:.0} %", 100.0 * self.travel_share),
            self.mark().into(),
        ]
    }
}

const HEAD: [&str; 9] = [
    "lie",
    "from, s",
    "found after, s",
    "fault",
    "sensor named",
    "force of its limit",
    "cart of its limit",
    "travel of its limit",
    "mark",
];

/// The rigs, and the force of a strong 1/1 of each, N, and the frequency of its optimum, Hz.
const RIGS: [(&str, f64, f64); 4] = [
    ("wires", 96.0, 3.68),
    ("beam-170", 232.0, 9.07),
    ("beam-150", 274.0, 10.57),
    ("beam-135", 342.0, 13.07),
];
const PAIRS: &str = "--pairs COUNT,SEED";
/// Amplitude of the cart on each of the rigs, mm.
const AMPLITUDE_MM: f64 = 0.89;

/// Rows of two sensors that lie in the same run, drawn with `seed`.
fn pairs(all: &[Lie], count: usize, seed: u64) -> Vec<[String; 9]> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut draw = |from: f64, to: f64| from + (to - from) * f64::from(random.next_u32()) / TWO_32;
    let mut cases = Vec::new();
    while cases.len() < count {
        let mut lie = || {
            let which = draw(0.0, all.len() as f64) as usize;
            (&all[which], (draw(0.1, 30.0) * 10.0).round() / 10.0)
        };
        let (one, other) = (lie(), lie());
        if one.0.sensor == other.0.sensor {
            continue;
        }
        let (rig, strong_n, best_hz) = RIGS[draw(0.0, RIGS.len() as f64) as usize];
        let force_n = draw(0.5, 1.0) * strong_n;
        let travel_mm = draw(4.5, 6.0) * AMPLITUDE_MM;
        let limits = format!(
            "[limits]\nforce_n = {force_n:.1}\ntravel_mm = {travel_mm:.2}\n[trips]\ntravel_mm = {:.2}\n",
            1.2 * travel_mm
        );
        let hz = draw(0.6, 1.3) * best_hz;
        let by_hand = format!(
            "mode = \"manual\"\n[[events]]\nat_s = 4.0\nkind = \"set-point\"\nfrequency_hz = {hz:.2}\namplitude_mm = {AMPLITUDE_MM}\n"
        );
        let by_itself = draw(0.0, 1.0) < 0.5;
        let start = if by_itself { String::new() } else { by_hand };
        cases.push(([one, other], rig, limits, start));
    }
    let rows = cases.par_iter().map(|(lies, rig, limits, start)| {
        let mut row = Row::of(lies, rig, limits, start);
        let mode = if start.is_empty() { "" } else { " by hand" };
        row.lie = format!("{rig}{mode}: {}", row.lie);
        row.cells()
    });
    rows.collect()
}

fn main() -> ExitCode {
    let mut arguments = std::env::args().skip(1);
    let (mut rig, mut limits, mut csv) = ("wires".to_string(), String::new(), None);
    let mut drawn = None;
    while let Some(argument) = arguments.next() {
        match argument.as_str() {
            "--csv" => csv = Some(arguments.next().expect("--csv FILE")),
            "--limits" => {
                let all = arguments
                    .next()
                    .expect("--limits FORCE_N,CART_MM,TRAVEL_MM");
                limits += "[limits]\n";
                for (key, value) in ["force_n", "amplitude_mm", "travel_mm"]
                    .into_iter()
                    .zip(all.split(','))
                    .filter(|(_, value)| !value.is_empty())
                {
                    writeln!(limits, "{key} = {value}").expect("text");
                }
            }
            "--pairs" => drawn = Some(arguments.next().expect(PAIRS)),
            "--aim" => {
                let n = arguments.next().expect("--aim FORCE_N");
                write!(limits, "[aim]\nforce_n = {n}\n").expect("text");
            }
            name => rig = name.to_string(),
        }
    }
    let all: Vec<Lie> = ["force", "hammer", "cart"]
        .into_iter()
        .flat_map(lies)
        .collect();
    let cases: Vec<_> = all
        .iter()
        .flat_map(|lie| LIES_FROM_S.map(|from_s| (lie, from_s)))
        .collect();
    let rows: Vec<_> = match drawn {
        Some(text) => {
            assert!(limits.is_empty(), "{PAIRS} draws rig and limits itself");
            let (count, seed) = text.split_once(',').expect(PAIRS);
            let number = |text: &str| text.parse::<u64>().expect(PAIRS);
            pairs(&all, number(count) as usize, number(seed))
        }
        None => cases
            .par_iter()
            .map(|case| Row::of(&[*case], &rig, &limits, "").cells())
            .collect(),
    };
    println!("| {} |\n|{}", HEAD.join(" | "), "---|".repeat(HEAD.len()));
    let mut lines = HEAD.join(";") + "\n";
    for row in &rows {
        println!("| {} |", row.join(" | "));
        writeln!(lines, "{}", row.join(";")).expect("text");
    }
    if let Some(path) = csv {
        std::fs::write(&path, lines).expect("the CSV file can be written");
    }
    let passed = rows
        .iter()
        .any(|[.., mark]| mark.to_lowercase().starts_with("passed"));
    ExitCode::from(u8::from(passed))
}
