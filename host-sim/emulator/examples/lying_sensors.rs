//! Every sensor made to lie in every way, before the start and in Hold: what the controller finds, how soon, and what the
//! plant truly did until then. Prints a table; `--csv FILE` writes it as well.
//!
//!     cargo run --release -p emulator --example lying_sensors -- [RIG] [--limits FORCE_N,CART_MM,TRAVEL_MM]
//!         [--aim FORCE_N] [--csv FILE]
//!
//! RIG is `wires` if left out. `--limits` sets `limits.force_n`, `limits.amplitude_mm` and `limits.travel_mm` in
//! place of the rig's own; one left empty stays. `--aim` sets `aim.force_n`.

use std::fmt::Write as _;

use emulator::local::Local;
use emulator::record::{BlockRow, RunEvent, RunEventKind, RunObserver, TickRow, TrueContact};
use emulator::run::run;
use emulator::scenario::parse;
use rayon::prelude::*;
use shared::fault::{Fault, Origin};

/// Rig time of a run, of the start, and of the two beginnings of a lie, s.
const LONG_S: f64 = 60.0;
const START_S: f64 = 0.5;
const LIES_FROM_S: [f64; 2] = [0.1, 20.0];
/// A limit counts as passed beyond this share of it.
const PASSED: f64 = 1.1;

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
    sensor: &'static str,
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
    fn of(lie: &Lie, from_s: f64, rig: &str, limits: &str) -> Self {
        let Lie { sensor, name, keys } = lie;
        let text = format!(
            "duration_s = {LONG_S:?}\nseed = 7\n[true_rig]\npreset = \"{rig}\"\n{limits}\
             [sensors]\nnoise_percent = 1.0\n\
             [[events]]\nat_s = {START_S:?}\nkind = \"start\"\n\
             [[events]]\nat_s = {from_s:?}\nkind = \"sensor-fault\"\nsensor = \"{sensor}\"\n{keys}\n"
        );
        let scenario = parse("lie", &text, "lie").expect("a scenario");
        let mut truth = Truth::default();
        let mut control = Local::new(&scenario.settings).expect("a controller");
        run(&scenario, &mut control, &mut truth).expect("a run");
        let bounds = scenario.settings.limits;
        let after = |at_s: f64| at_s - from_s.max(START_S);
        Self {
            sensor,
            lie: name.clone(),
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
            format!("{}: {}", self.sensor, self.lie),
            format!("{}", self.from_s),
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

fn main() {
    let mut arguments = std::env::args().skip(1);
    let (mut rig, mut limits, mut csv) = ("wires".to_string(), String::new(), None);
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
    let rows: Vec<_> = cases
        .par_iter()
        .map(|(lie, from_s)| Row::of(lie, *from_s, &rig, &limits).cells())
        .collect();
    println!("| {} |\n|{}", HEAD.join(" | "), "---|".repeat(HEAD.len()));
    let mut lines = HEAD.join(";") + "\n";
    for row in &rows {
        println!("| {} |", row.join(" | "));
        writeln!(lines, "{}", row.join(";")).expect("text");
    }
    if let Some(path) = csv {
        std::fs::write(&path, lines).expect("the CSV file can be written");
    }
}
