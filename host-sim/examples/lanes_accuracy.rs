//! The lanes against the reference on random cells: `lanes_accuracy [CELLS] [SEED]` of the chapter's map,
//! `lanes_accuracy [CELLS] [SEED] recoil` of such maps of the four rigs, with the cart recoiling on loops of 25 to 100 Hz;
//! a contact law as the last word puts it in the place of the spring-dashpot.

use std::time::Instant;

use numerics::engine::Engine;
use numerics::lanes::{Cell, CellOutcome, CellPlan, Instructions, each_by_engine, run_with};
use rand::{Rng, SeedableRng};
use shared::model::cart::{ASSUMED_SHAKER, CartDrive, LoopParams};
use shared::model::contact::LawKind;
use shared::model::params::{PRESETS, RigParams, WIRES};
use shared::model::regime::Regime;
use shared::model::rig::Rig;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let count: usize = arguments.next().map_or(Ok(2000), |a| a.parse())?;
    let seed: u64 = arguments.next().map_or(Ok(1), |a| a.parse())?;
    let mut recoil = false;
    let mut law = None;
    for word in arguments {
        match LawKind::named(&word) {
            _ if word == "recoil" => recoil = true,
            Some(kind) => law = Some(kind.preset()),
            None => return Err(format!("{word}: expected recoil or a contact law").into()),
        }
    }
    let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
    let cells: Vec<_> = (0..count)
        .map(|_| {
            let gap = random.random_range(0..357);
            let step = random.random_range(0..588);
            let (mut rig, mut frequency_hz) = (WIRES, 1.41 + 0.01 * f64::from(step));
            if recoil {
                rig = PRESETS[random.random_range(0..PRESETS.len())].1;
                frequency_hz *= rig.natural_frequency_hz() / WIRES.natural_frequency_hz();
                rig.cart = CartDrive::Loop(LoopParams {
                    frequency_hz: 25.0 * 4_f64.powf(random.random()),
                    ..ASSUMED_SHAKER
                });
            }
            rig.contact = law.unwrap_or(rig.contact);
            cell(rig, f64::from(gap) * 1e-5, frequency_hz)
        })
        .collect::<Result<_, _>>()?;
    let full = CellPlan {
        early: false,
        ..CellPlan::CHAPTER
    };
    let began = Instant::now();
    let reference = each_by_engine(Engine::Event, &cells, &full).into_iter();
    let reference = reference.collect::<Result<Vec<_>, _>>()?;
    println!(
        "{count} cells, seed {seed}; reference: {:.1} s",
        began.elapsed().as_secs_f64()
    );
    for early in [false, true] {
        let plan = CellPlan {
            early,
            ..CellPlan::CHAPTER
        };
        let began = Instant::now();
        let (ours, report) = run_with(Instructions::Widest, &cells, &plan)?;
        let seconds = began.elapsed().as_secs_f64();
        let rate = report.work.cycles as f64 / seconds * 1e-6;
        println!("\nearly {early}: {seconds:.3} s, {rate:.2} million cycles/s");
        println!("{report:?}");
        compare(&cells, &ours, &reference);
    }
    Ok(())
}

fn cell(
    rig: RigParams,
    gap_m: f64,
    frequency_hz: f64,
) -> Result<Cell, shared::model::params::ParamError> {
    let params = RigParams { gap_m, ..rig };
    Ok(Cell {
        params,
        frequency_hz,
        start: [Rig::<f64>::new(&params)?.rest(), 0.0],
        phase: 0.0,
    })
}

fn compare(cells: &[Cell], ours: &[CellOutcome], reference: &[CellOutcome]) {
    let periodic = |o: &CellOutcome| matches!(o.regime, Regime::Periodic { .. });
    let percent = |part: usize, whole: usize| 100.0 * part as f64 / whole.max(1) as f64;
    let (mut both, mut same, mut force, mut label) = (0, 0, 0, 0);
    let mut worst = Vec::new();
    for ((cell, a), b) in cells.iter().zip(ours).zip(reference) {
        label += usize::from(a.regime.to_string() == b.regime.to_string());
        if !(periodic(a) && periodic(b)) {
            continue;
        }
        both += 1;
        same += usize::from(a.regime == b.regime);
        let off = (a.force_n - b.force_n).abs() / b.force_n;
        force += usize::from(off <= 1e-3);
        if off > 1e-3 || a.regime != b.regime {
            worst.push((off, cell, a, b));
        }
    }
    println!(
        "both periodic: {both}; same p/n {:.2} %; force within 0.1 % {:.2} %; same label {:.2} % of all",
        percent(same, both),
        percent(force, both),
        percent(label, cells.len()),
    );
    worst.sort_by(|x, y| y.0.total_cmp(&x.0));
    for (off, cell, a, b) in worst.iter().take(8) {
        println!(
            "  {:.2} Hz rig, {:.2} mm {:.2} Hz: {} {:.3} N, reference {} {:.3} N, {:.3} %",
            cell.params.natural_frequency_hz(),
            cell.params.gap_m * 1e3,
            cell.frequency_hz,
            a.regime,
            a.force_n,
            b.regime,
            b.force_n,
            100.0 * off
        );
    }
}
