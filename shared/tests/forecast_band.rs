//! The ends of the forecast's stable 1/1.

use shared::forecast::{Forecast, ForecastRequest, Forecaster};
use shared::model::contact::Law;
use shared::model::params::{BEAM_135, BEAM_150, RigParams};

fn forecast(rig: &RigParams) -> Forecast {
    let mut forecaster = Forecaster::new();
    forecaster.start(&ForecastRequest::bench(rig));
    while forecaster.slice() {}
    forecaster.result().expect("done").clone()
}

/// Lower end of the stable 1/1 over the natural frequency.
fn low_end(rig: &RigParams) -> f64 {
    let target = forecast(rig).target.expect("a stable 1/1");
    f64::from(target.band_hz.0) / rig.natural_frequency_hz()
}

/// At one row of this rig (1.853) Newton's iteration finds no orbit, although the 1/1 is stable there and down to 0.783.
/// The band was said to begin at that row.
#[test]
fn a_row_without_its_orbit_does_not_end_the_band() {
    let rig = RigParams {
        mass_kg: 0.3036184561847073,
        amplitude_m: 0.0008283253614253683,
        gap_m: 0.00030762882576672144,
        contact: Law::SpringDashpot {
            stiffness: 5357072.131693083,
            damping: 904.2179338352215,
        },
        ..BEAM_135
    };
    let rig = RigParams {
        support: match rig.support {
            shared::model::params::SupportParams::Beams {
                natural_frequency_hz,
                cubic_stiffness_n_per_m3,
                ..
            } => shared::model::params::SupportParams::Beams {
                natural_frequency_hz,
                damping_ratio: 0.002318194499540409,
                cubic_stiffness_n_per_m3,
            },
            wires => wires,
        },
        ..rig
    };
    let low = low_end(&rig);
    assert!((low - 0.783).abs() < 0.002, "{low}");
}

/// A band that really ends keeps its end: beam-150 at 1.0 mm.
#[test]
fn a_band_that_ends_between_two_rows_keeps_its_end() {
    let rig = RigParams {
        gap_m: 1e-3,
        ..BEAM_150
    };
    let rows = forecast(&rig);
    let target = rows.target.expect("a stable 1/1");
    let below = (rows.rows.iter()).filter(|r| r.frequency_hz < 0.999 * target.band_hz.0);
    let stable = below.filter(|r| r.orbit.is_some_and(|o| o.is_stable()));
    assert_eq!(stable.count(), 0);
}
