//! The microcontroller's forecast with a cart that recoils (f32, long steps) beside `pick`'s (f64, located events): the
//! built-in rigs with their assumed shaker at several gaps. Prints a table.
//!
//!     cargo run -p tests --example recoil_forecast

use numerics::NamedRig;
use numerics::PickLimits;
use numerics::pick::pick;
use shared::forecast::{ForecastRequest, Forecaster, Target};
use shared::model::cart::{ASSUMED_SHAKER, CartDrive};
use shared::model::params::{PRESETS, RigParams};

const GAPS_MM: [f64; 4] = [0.0, 1.0, 2.0, 2.4];

fn forecast(rig: &RigParams) -> Option<Target> {
    let mut forecaster = Forecaster::new();
    forecaster.start(&ForecastRequest::bench(rig));
    while forecaster.slice() {}
    forecaster.result()?.target
}

/// How far `found` is from `exact`, in millionths of it.
fn off(found: f32, exact: f64) -> String {
    format!("{:+.0}", 1e6 * (f64::from(found) / exact - 1.0))
}

fn main() {
    println!(
        "| rig | gap, mm | forecast, Hz | `pick`, Hz | off, 1e-6 | forecast, N | `pick`, N | off, 1e-6 | band, off, 1e-6 | prescribed, force off |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|");
    for (name, rig) in PRESETS {
        for gap_mm in GAPS_MM {
            let prescribed = RigParams {
                gap_m: 1e-3 * gap_mm,
                ..rig
            };
            let rig = RigParams {
                cart: CartDrive::Loop(ASSUMED_SHAKER),
                ..prescribed
            };
            let answer = match pick(&NamedRig::new(name, rig), None, PickLimits::default(), &()) {
                Ok(picked) => picked.answer,
                Err(error) => panic!("{name}, {gap_mm} mm: {error:?}"),
            };
            let (Some(found), Some(old)) = (forecast(&rig), forecast(&prescribed)) else {
                panic!("{name}, {gap_mm} mm: no target");
            };
            let exact_n = answer.nominal_optimum_force_ratio * rig.weight_n();
            let [low_hz, high_hz] = answer.stable_one_one_hz;
            println!(
                "| {name} | {gap_mm:.1} | {:.4} | {:.4} | {} | {:.3} | {exact_n:.3} | {} | {}, {} | {:+.1} % |",
                found.frequency_hz,
                answer.nominal_optimum_hz,
                off(found.frequency_hz, answer.nominal_optimum_hz),
                found.orbit.force_n,
                off(found.orbit.force_n, exact_n),
                off(found.band_hz.0, low_hz),
                off(found.band_hz.1, high_hz),
                1e2 * (f64::from(old.orbit.force_n) / exact_n - 1.0)
            );
        }
    }
}
