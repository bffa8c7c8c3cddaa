//! The ends of the forecast's stable 1/1, and shakers that no rig has.

use shared::forecast::{Forecast, ForecastRequest, Forecaster};
use shared::model::cart::{ASSUMED_SHAKER, CartDrive, LoopParams};
use shared::model::contact::Law;
use shared::model::params::{BEAM_135, BEAM_150, RigParams, WIRES};

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

/// Shakers at and beyond the ends of what the settings allow: a forecast ends, and what it says are numbers.
#[test]
fn forecasts_with_absurd_shakers_end_and_say_numbers() {
    let held = |frequency_hz, damping_ratio, feed_forward| LoopParams {
        frequency_hz,
        damping_ratio,
        feed_forward,
        ..ASSUMED_SHAKER
    };
    let cases = [
        (5.38, held(1.0, 0.05, 1.0)),
        (5.38, held(1.0, 5.0, 0.0)),
        (5.38, held(3.6, 0.05, 0.0)),
        (5.38, held(50.0, 5.0, 2.0)),
        (5.38, held(500.0, 0.05, 1.0)),
        (0.06, held(50.0, 0.7, 1.0)),
        (0.06, held(1.0, 0.05, 2.0)),
        (1e6, held(50.0, 0.7, 1.0)),
        // Beyond the settings' ranges.
        (5.38, held(0.1, 0.0, 1.0)),
        (5.38, held(50.0, 0.0, 0.0)),
        (5.38, held(0.1, 10.0, 1.0)),
        (1e-3, held(50.0, 0.7, 1.0)),
        (1e-6, held(0.1, 0.0, 2.0)),
    ];
    for (cart_mass_kg, held) in cases {
        for rig in [WIRES, BEAM_135] {
            let rig = RigParams {
                cart_mass_kg,
                cart: CartDrive::Loop(held),
                ..rig
            };
            rig.check().expect("the model takes it");
            let mut request = ForecastRequest::bench(&rig);
            request.rows = 4;
            let mut forecaster = Forecaster::new();
            forecaster.start(&request);
            let mut slices = 0_u32;
            while forecaster.slice() {
                slices += 1;
                assert!(slices < 5_000_000, "{cart_mass_kg} kg, {held:?}: no end");
            }
            let found = forecaster.result().expect("done");
            println!(
                "{cart_mass_kg} kg, {held:?}: {slices} slices, {:?}",
                found.target.map(|t| (t.frequency_hz, t.orbit.force_n))
            );
            assert!(found.rows.iter().all(|row| row.force_n.is_finite()));
            let Some(target) = found.target else { continue };
            let numbers = [
                target.frequency_hz,
                target.orbit.force_n,
                target.orbit.onset_turns,
                target.band_hz.0,
                target.band_hz.1,
                target.entry_hz,
            ];
            assert!(numbers.iter().all(|x| x.is_finite()), "{target:?}");
            assert!(target.orbit.is_stable() && target.orbit.force_n > 0.0);
        }
    }
}

/// A cart so heavy that it cannot recoil leaves what a prescribed one does.
#[test]
fn a_cart_of_a_thousand_tonnes_is_as_good_as_prescribed() {
    let heavy = RigParams {
        cart_mass_kg: 1e6,
        cart: CartDrive::Loop(ASSUMED_SHAKER),
        ..WIRES
    };
    let (there, here) = (forecast(&heavy), forecast(&WIRES));
    let (there, here) = (there.target.expect("a 1/1"), here.target.expect("a 1/1"));
    let force = there.orbit.force_n / here.orbit.force_n - 1.0;
    let onset = there.orbit.onset_turns - here.orbit.onset_turns;
    assert!(force.abs() < 1e-4, "{force}");
    // The frequency itself is where the force is flat.
    assert!(onset.abs() < 2e-3, "{onset}");
    for (a, b) in [
        (there.band_hz.0, here.band_hz.0),
        (there.band_hz.1, here.band_hz.1),
    ] {
        assert!((a / b - 1.0).abs() < 2e-4, "{a} {b}");
    }
}
