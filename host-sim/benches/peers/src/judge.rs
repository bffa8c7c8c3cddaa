//! The table: speed, and accuracy beside it.

use std::collections::BTreeMap;
use std::error::Error;
use std::fs;
use std::path::Path;

use numerics::lanes::{Cell, LaneStrobe};
use shared::model::contacts::Period;
use shared::model::regime::{Detector, Regime};

use crate::Timing;

/// Solvers in the table's order.
const SOLVERS: [&str; 6] = ["ours", "reference", "boost", "boost-loose", "crate", "scipy"];

/// What a solver found in a cell.
struct Found {
    regime: Regime,
    force_n: f64,
}

fn read(out: &Path, name: &str, cells: &[Cell]) -> Result<BTreeMap<usize, Found>, Box<dyn Error>> {
    let text = fs::read_to_string(out.join(format!("{name}.csv")))?;
    let mut strobes = BTreeMap::<usize, Vec<LaneStrobe>>::new();
    for line in text.lines().skip(1) {
        let words: Vec<_> = line.split(',').collect();
        let [cell, q, v, onsets, force] = words[..] else {
            return Err(format!("{name}.csv: {line}").into());
        };
        strobes.entry(cell.parse()?).or_default().push(LaneStrobe {
            q: q.parse()?,
            v: v.parse()?,
            onsets: onsets.parse()?,
            force_n: force.parse()?,
        });
    }
    let told = strobes.into_iter().map(|(cell, strobes)| {
        let params = &cells[cell].params;
        let scale = params.amplitude_m / 0.075;
        let rate = scale * std::f64::consts::TAU * cells[cell].frequency_hz;
        let mut detector = Detector::new(scale, rate);
        let mut force_n = 0.0_f64;
        for (i, s) in strobes.iter().enumerate() {
            // Chatter is told from stays, which not all solvers report: p and n alone are compared.
            let period = Period {
                onsets: s.onsets,
                touched: s.force_n > 0.0,
                chatter: false,
                peak_force: s.force_n,
            };
            detector.push(s.q, s.v, &period);
            if i > 0 {
                force_n = force_n.max(s.force_n);
            }
        }
        let regime = detector.regime();
        (cell, Found { regime, force_n })
    });
    Ok(told.collect())
}

/// Prints the table in Markdown.
pub fn run(cells: &[Cell], out: &Path) -> Result<(), Box<dyn Error>> {
    let reference = read(out, "reference", cells)?;
    let timing = |name: &str| -> Result<Timing, Box<dyn Error>> {
        let text = fs::read_to_string(out.join(format!("{name}.json")))?;
        Ok(serde_json::from_str(&text)?)
    };
    let speed = |t: &Timing| t.cycles as f64 / t.cpu_s;
    let ours = speed(&timing("ours")?);
    println!(
        "| solver | cells | drive cycles/s | ours is faster by | both periodic | same p/n of these | force within 0.1 % | median force error |"
    );
    println!("|---|---|---|---|---|---|---|---|");
    for name in SOLVERS {
        let Ok(timing) = timing(name) else {
            println!("| {name} | not run | | | | | | |");
            continue;
        };
        let found = read(out, name, cells)?;
        let settled = |regime: Regime| regime == Regime::None || regime.periods().is_some();
        let mut both: Vec<_> = found
            .iter()
            .map(|(cell, found)| (found, &reference[cell]))
            .filter(|(a, b)| settled(a.regime) && settled(b.regime))
            .collect();
        let same = both.iter().filter(|(a, b)| a.regime == b.regime).count();
        let error = |(a, b): &(&Found, &Found)| (a.force_n - b.force_n).abs() / b.force_n.max(1e-9);
        both.sort_by(|a, b| error(a).total_cmp(&error(b)));
        let within = both.iter().filter(|pair| error(pair) <= 1e-3).count();
        let share = |part: usize| 100.0 * part as f64 / both.len() as f64;
        println!(
            "| {} | {} | {:.0} | {:.1} | {} | {:.1} % | {:.1} % | {:.1e} |",
            timing.name,
            found.len(),
            speed(&timing),
            ours / speed(&timing),
            both.len(),
            share(same),
            share(within),
            error(&both[both.len() / 2])
        );
        for (cell, found) in &found {
            let known = &reference[cell];
            let (a, b) = (found.regime, known.regime);
            if std::env::var_os("PEERS_LIST").is_some() && (a, found.force_n) != (b, known.force_n)
            {
                eprintln!("{name} {cell}: {a} {:.3} N, reference {b} {:.3} N", found.force_n, known.force_n);
            }
        }
    }
    Ok(())
}
