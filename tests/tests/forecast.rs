//! The microcontroller's forecast (f32, long steps) against the reference (f64, located events).

use numerics::NamedRig;
use numerics::PickLimits;
use numerics::engine::{CycleRecorder, Engine, Plan, Start, machine, observe};
use numerics::orbit::{Multipliers, on_course, shoot_at};
use numerics::pick::{PickAnswer, pick};
use shared::forecast::march::ForecastModel;
use shared::forecast::shoot::{Shoot, Shooting, Solution};
use shared::forecast::{Forecast, ForecastRequest, Forecaster, Target};
use shared::model::cart::{ASSUMED_SHAKER, CartDrive, LoopParams};
use shared::model::contact::{LAWS, Law};
use shared::model::params::{BEAM_150, PRESETS, RigParams, WIRES};

fn forecast(request: &ForecastRequest) -> Forecast {
    let mut forecaster = Forecaster::new();
    forecaster.start(request);
    let mut slices = 0_u32;
    while forecaster.slice() {
        slices += 1;
        assert!(slices < 1_000_000, "no end");
    }
    forecaster.result().expect("done").clone()
}

fn with_gap(rig: RigParams, gap_mm: f64) -> RigParams {
    RigParams {
        gap_m: gap_mm * 1e-3,
        ..rig
    }
}

fn shoot_in_f32(rig: &RigParams, hz: f32, guess: [f32; 4]) -> Option<Solution> {
    let model = ForecastModel::new(rig).ok()?;
    let mut run = Shoot::new(&model, hz, guess)?;
    loop {
        match run.step(&model) {
            Shooting::Working => {}
            Shooting::Found(solution) => return Some(solution),
            Shooting::Lost => return None,
        }
    }
}

/// Largest error of the multipliers over every 1/1 orbit of a forecast, and how many there were before
/// and after the doubling.
fn multiplier_error(rig: &RigParams) -> (f64, usize, usize) {
    let (mut worst, mut before, mut after) = (0.0_f64, 0, 0);
    let natural = rig.natural_frequency_hz();
    // Along the branch, each orbit of the reference from the last.
    let mut section: Option<[f64; 4]> = None;
    for step in 0..60 {
        let hz = (natural * (1.25 + 0.03 * f64::from(step))) as f32;
        let exact_hz = f64::from(hz);
        let guess = section.unwrap_or_else(|| {
            let mut run = machine(Engine::Event, rig, exact_hz, Start::Rest).unwrap();
            for _ in 0..200 {
                run.period(None);
            }
            on_course(run.section())
        });
        let Some(exact) = shoot_at(rig, exact_hz, guess, 1).filter(|orbit| orbit.impacts == 1)
        else {
            break;
        };
        section = Some(exact.at());
        let found = shoot_in_f32(rig, hz, exact.at().map(|x| x as f32));
        let found = found.unwrap_or_else(|| panic!("no orbit at {hz} Hz"));
        assert_eq!(found.onsets, 1);
        // Where two real multipliers meet, they are as the square root of an error.
        let modulus = exact.multipliers().modulus();
        // (1 + μ₁)(1 + μ₂) moves by 1 + μ₁ times what μ₂ does.
        let doubling = f64::from(found.orbit.doubling_test) - exact.doubling_test();
        let mut error = doubling.abs() / (1.0 + modulus);
        if !matches!(exact.multipliers(), Multipliers::Real(a, b) if (a - b).abs() < 0.1) {
            error = error.max((f64::from(found.orbit.multiplier) - modulus).abs());
        }
        let force = f64::from(found.orbit.force_n) / exact.force_n - 1.0;
        assert!(force.abs() < 1e-3, "{hz} Hz: force {force}");
        worst = worst.max(error / modulus.max(1.0));
        if modulus < 1.0 {
            before += 1;
        } else {
            after += 1;
        }
    }
    (worst, before, after)
}

#[test]
fn multipliers_are_the_reference_s_on_both_rigs_before_and_after_the_doubling() {
    let (mut before, mut after) = (0, 0);
    for rig in [WIRES, BEAM_150] {
        for gap_mm in [0.0, 0.5, 1.0, 2.4] {
            let (worst, stable, unstable) = multiplier_error(&with_gap(rig, gap_mm));
            println!("gap {gap_mm} mm: {worst:.1e} over {stable} + {unstable} orbits");
            // Measured: at most 1e-4.
            assert!(worst < 5e-4, "gap {gap_mm} mm: {worst}");
            before += stable;
            after += unstable;
        }
    }
    assert!(before > 150 && after > 40, "{before} {after}");
}

/// Hunt–Crossley, Lankarani–Nikravesh and Flores; under Hertz no 1/1 is stable with these rigs.
const NONLINEAR: [(&str, Law<f64>); 3] = [LAWS[2], LAWS[3], LAWS[4]];

/// δⁿ is not smooth where the contact begins and ends, so the derivative is coarser than the spring-dashpot's.
#[test]
fn multipliers_are_the_reference_s_under_the_nonlinear_laws() {
    for (law, contact) in NONLINEAR {
        for rig in [WIRES, BEAM_150] {
            for gap_mm in [0.0, 1.0] {
                let rig = RigParams { contact, ..rig };
                let (worst, stable, unstable) = multiplier_error(&with_gap(rig, gap_mm));
                println!("{law}, gap {gap_mm} mm: {worst:.1e} over {stable} + {unstable} orbits");
                assert!(worst < 2e-2, "{law}, gap {gap_mm} mm: {worst}");
                assert!(stable > 30 && unstable > 8, "{law}: {stable} {unstable}");
            }
        }
    }
}

fn recoiling(rig: RigParams) -> RigParams {
    RigParams {
        cart: CartDrive::Loop(ASSUMED_SHAKER),
        ..rig
    }
}

#[test]
fn multipliers_are_the_reference_s_with_a_cart_that_recoils() {
    let soft = LoopParams {
        frequency_hz: 12.0,
        damping_ratio: 0.3,
        feed_forward: 0.9,
        ..ASSUMED_SHAKER
    };
    for (rig, held) in [
        (WIRES, ASSUMED_SHAKER),
        (WIRES, soft),
        (BEAM_150, ASSUMED_SHAKER),
    ] {
        for gap_mm in [0.0, 2.4] {
            let rig = RigParams {
                cart: CartDrive::Loop(held),
                ..with_gap(rig, gap_mm)
            };
            let (worst, stable, unstable) = multiplier_error(&rig);
            println!("gap {gap_mm} mm: {worst:.1e} over {stable} + {unstable} orbits");
            // Measured: at most 1.2e-4.
            assert!(worst < 5e-4, "gap {gap_mm} mm: {worst}");
            assert!(stable > 5, "{stable}");
        }
    }
}

#[test]
fn the_target_is_the_nominal_optimum_with_a_cart_that_recoils() {
    // All rigs and gaps: `cargo run -p tests --example recoil_forecast`.
    for (name, rig, gap_mm) in [("wires", WIRES, 0.0), ("beam-150", BEAM_150, 2.4)] {
        target_is_the_reference_s(name, &recoiling(with_gap(rig, gap_mm)));
    }
}

fn nominal(name: &str, rig: &RigParams) -> PickAnswer {
    let rig = NamedRig::new(name, *rig);
    pick(&rig, None, PickLimits::default(), &()).unwrap().answer
}

fn share(a: f32, b: f64) -> f64 {
    (f64::from(a) / b - 1.0).abs()
}

fn target_is_the_reference_s(name: &str, rig: &RigParams) -> Target {
    let target = forecast(&ForecastRequest::bench(rig))
        .target
        .expect("a target");
    let answer = nominal(name, rig);
    let force_n = answer.nominal_optimum_force_ratio * rig.weight_n();
    let [low, high] = answer.stable_one_one_hz;
    let errors = [
        share(target.frequency_hz, answer.nominal_optimum_hz),
        share(target.orbit.force_n, force_n),
        share(target.band_hz.0, low),
        share(target.band_hz.1, high),
    ];
    println!(
        "{name} {} mm: frequency, force, band: {:?}",
        rig.gap_m * 1e3,
        errors.map(|e| format!("{e:.1e}"))
    );
    assert!(errors[0] < 2e-3 && errors[1] < 5e-3, "{name}: {errors:?}");
    // The band's ends, to a tenth of the rows' spacing.
    assert!(errors[2] < 2e-3 && errors[3] < 2e-3, "{name}: {errors:?}");
    assert_eq!(
        target.doubling_hz.is_some(),
        answer.period_doubling_hz.is_some()
    );
    if let Some((found, exact)) = target.doubling_hz.zip(answer.period_doubling_hz) {
        assert!(share(found, exact) < 1e-3, "{name}: doubling at {found}");
    }
    target
}

#[test]
fn the_target_is_the_nominal_optimum_of_every_preset() {
    for (name, rig) in PRESETS {
        let target = target_is_the_reference_s(name, &rig);
        assert_eq!(target.entry_hz, target.frequency_hz, "{name}");
    }
}

#[test]
fn the_target_is_the_nominal_optimum_under_the_nonlinear_laws() {
    for (law, contact) in NONLINEAR {
        for (name, rig) in PRESETS {
            target_is_the_reference_s(&format!("{law} {name}"), &RigParams { contact, ..rig });
        }
    }
}

#[test]
fn the_target_is_the_nominal_optimum_with_a_gap_too() {
    for gap_mm in [1.0, 2.4] {
        target_is_the_reference_s("wires", &with_gap(WIRES, gap_mm));
    }
}

#[test]
fn regimes_from_rest_are_the_reference_s() {
    const LONG: Plan = Plan {
        cycles: 400,
        transient: 320,
    };
    // Rows beyond the doubling that have not settled within the periods the forecast affords.
    for (rig, most) in [(WIRES, 2), (BEAM_150, 3), (with_gap(WIRES, 1.0), 4)] {
        let found = forecast(&ForecastRequest::bench(&rig));
        let mut differ = Vec::new();
        for row in &found.rows {
            let hz = f64::from(row.frequency_hz);
            let mut run = machine(Engine::Event, &rig, hz, Start::Rest).unwrap();
            let seen = observe(run.as_mut(), LONG, &mut CycleRecorder::default()).unwrap();
            // In chaos the contacts of the last periods are nobody's.
            if row.regime.to_string() != seen.regime.to_string() {
                differ.push(format!("{hz:.3} Hz: {} not {}", row.regime, seen.regime));
            } else if row.regime.is(1, 1) {
                assert!(share(row.force_n, seen.force_n) < 1e-3, "{hz} Hz");
            }
        }
        println!("gap {} mm: {differ:?}", rig.gap_m * 1e3);
        assert!(differ.len() <= most, "{differ:?}");
    }
}

#[test]
fn a_request_that_cannot_be_is_answered_with_nothing() {
    let bad_rig = RigParams {
        mass_kg: f64::NAN,
        ..WIRES
    };
    let nothing = [
        (bad_rig, (1.0, 2.0)),
        (WIRES, (2.0, 1.0)),
        (WIRES, (f32::NAN, 1.0)),
    ];
    for (rig, range_hz) in nothing {
        let request = ForecastRequest {
            id: 9,
            rig,
            range_hz,
            rows: 40,
        };
        let found = forecast(&request);
        assert_eq!((found.id, found.rows.len(), found.target), (9, 0, None));
    }
}
