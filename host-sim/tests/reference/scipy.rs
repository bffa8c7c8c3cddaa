//! The reference against an independent SciPy integration (tests/data/README.md).

use std::path::Path;

use numerics::engine::{CycleRecorder, Engine, Observation, Plan, Start, machine, observe};
use numerics::reference::{LocatedContact, Reference};
use serde_json::Value;
use shared::model::contact::Law;
use shared::model::params::{RigParams, SupportParams, preset};

use crate::support::{close, reference_contact};

fn data() -> Value {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/data/scipy_reference.json");
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

#[track_caller]
fn number(value: &Value, key: &str) -> f64 {
    value[key].as_f64().unwrap_or_else(|| panic!("{key}"))
}

fn list<'a>(value: &'a Value, key: &str) -> &'a [Value] {
    value[key].as_array().unwrap_or_else(|| panic!("{key}"))
}

/// The preset a case names, checked against the parameters it carries.
fn rig_of(p: &Value) -> RigParams {
    let name = p["rig"].as_str().unwrap();
    let params = preset(name).unwrap();
    let same = |key: &str, want: f64| close(key, number(p, key), want, 1e-14);
    same("mass_kg", params.mass_kg);
    same("a0_m", params.amplitude_m);
    same("contact_ki_n_per_m", 5.5e6);
    same("contact_ci_n_s_per_m", 1.2e3);
    match params.support {
        SupportParams::Wires {
            length_m,
            gravity_m_per_s2,
            ..
        } => {
            same("wire_length_m", length_m);
            same("gravity_m_per_s2", gravity_m_per_s2);
        }
        SupportParams::Beams {
            natural_frequency_hz: f,
            damping_ratio,
            ..
        } => {
            let k = params.mass_kg * (std::f64::consts::TAU * f).powi(2);
            same("stiffness_k_n_per_m", k);
            same("kappa_n_per_m3", k);
            same("damping_ratio", damping_ratio);
        }
    }
    RigParams {
        gap_m: number(p, "gap_m"),
        ..params
    }
}

#[test]
fn every_single_contact() {
    for case in list(&data(), "single_contacts") {
        let get = |key: &str| number(case, key);
        let (stiffness, exponent) = (get("contact_ki_n_per_m_pow_n"), get("exponent_n"));
        let law = match case["law"].as_str().unwrap() {
            "spring-dashpot" => Law::SpringDashpot {
                stiffness,
                damping: get("contact_ci_n_s_per_m"),
            },
            "hertz" => Law::Hertz {
                stiffness,
                exponent,
            },
            "hunt-crossley" => Law::HuntCrossley {
                stiffness,
                exponent,
                damping_ratio: get("hunt_crossley_lambda_s_per_m"),
            },
            _ => Law::LankaraniNikravesh {
                stiffness,
                exponent,
                restitution: get("lankarani_nikravesh_e"),
            },
        };
        let approach = get("approach_speed_m_per_s");
        let seen = reference_contact(get("mass_kg"), law, approach);
        let what = format!("{law:?} at {approach} m/s");
        let same = |key: &str, value: f64| {
            close(&format!("{what}: {key}"), value, get(key), 1e-9);
        };
        same("peak_force_n", seen.peak_force_n);
        same("contact_time_s", seen.duration_s);
        same("rebound_speed_m_per_s", seen.rebound_speed_m_per_s);
        same("impulse_n_s", seen.impulse_n_s);
        let kinetic = 0.5 * get("mass_kg") * approach * approach;
        let lost = (seen.energy_lost_j - get("energy_lost_j")) / kinetic;
        assert!(lost.abs() < 1e-9, "{what}: energy off by {lost:.1e}");
    }
}

#[test]
fn every_sequence_from_rest() {
    for case in list(&data(), "sequences") {
        let p = &case["parameters"];
        let params = rig_of(p);
        let what = format!("{} {} mm, ratio {}", p["rig"], p["gap_mm"], p["ratio"]);
        let mut hammer = Reference::<f64>::at_rest(&params, number(p, "frequency_hz")).unwrap();
        let mut seen = Vec::<LocatedContact>::new();
        let strobes = list(case, "strobes");
        let noise = |key: &str| number(&case["tight_minus_loose_run"], key);
        for (k, strobe) in strobes.iter().enumerate() {
            hammer.run_period(&mut seen);
            let (q, v) = hammer.state();
            let rig = hammer.rig();
            let dx = rig.relative_displacement(q) - number(strobe, "x_rel_m");
            let dv = rig.kinematics(q, v).rate - number(strobe, "v_rel_m_per_s");
            let slack = noise("max_abs_difference_strobe_v_rel_m_per_s").max(2e-11);
            assert!(dx.abs() < 1e-11, "{what}: strobe {k}, x off by {dx:.1e}");
            assert!(dv.abs() < slack, "{what}: strobe {k}, v off by {dv:.1e}");
        }
        while seen.len() < list(case, "contacts").len() {
            hammer.run_period(&mut seen);
        }
        for (k, (seen, want)) in seen.iter().zip(list(case, "contacts")).enumerate() {
            let what = format!("{what}: contact {k} ({})", want["onset_kind"]);
            let near = |key: &str, value: f64, within: f64| {
                let off = (value - number(want, key)).abs();
                assert!(off <= within, "{what}: {key} off by {off:.1e}");
            };
            // The cart presses from t = 0 where SciPy's run says "start"; there δ grows as t³.
            near("onset_time_s", seen.onset_s, 1e-9);
            near("duration_s", seen.duration_s, 1e-9);
            near("approach_speed_m_per_s", seen.approach_speed_m_per_s, 1e-10);
            near("rebound_speed_m_per_s", seen.rebound_speed_m_per_s, 1e-10);
            near(
                "peak_force_n",
                seen.peak_force_n,
                1e-8 * seen.peak_force_n.max(1.0),
            );
        }
    }
}

fn settled(
    params: &RigParams,
    frequency_hz: f64,
    plan: Plan,
    keep: &mut CycleRecorder,
) -> Observation {
    let mut event = machine(Engine::Event, params, frequency_hz, Start::Rest).unwrap();
    observe(event.as_mut(), plan, keep).unwrap()
}

#[test]
fn every_settled_regime_and_force() {
    for case in list(&data(), "regimes") {
        let (p, want) = (&case["parameters"], &case["result"]);
        let params = rig_of(p);
        let count = |key: &str| case[key].as_u64().unwrap() as u32;
        let transient = count("transient_cycles");
        let plan = Plan {
            cycles: transient + count("window_cycles"),
            transient,
        };
        let mut keep = CycleRecorder::default();
        let seen = settled(&params, number(p, "frequency_hz"), plan, &mut keep);
        let what = format!("{} {} mm, ratio {}", p["rig"], p["gap_mm"], p["ratio"]);
        assert_eq!(want["label"], seen.regime.to_string(), "{what}");
        let force = number(want, "strongest_peak_force_n");
        close(&what, seen.force_n, force, 1e-8);
        let ratio = number(want, "force_ratio");
        close(&what, seen.force_n / params.weight_n(), ratio, 1e-8);
        let last = list(want, "contacts_of_last_period");
        let tail = &keep.contacts[keep.contacts.len() - last.len()..];
        for (seen, want) in tail.iter().zip(last) {
            let same = |key: &str, value: f64| {
                close(&format!("{what}: {key}"), value, number(want, key), 1e-8);
            };
            same("peak_force_n", seen.peak_force_n);
            same("duration_s", seen.duration_s);
            same("approach_speed_m_per_s", seen.approach_speed_m_per_s);
            same("rebound_speed_m_per_s", seen.rebound_speed_m_per_s);
            let off = (seen.onset_s - number(want, "onset_time_s")).abs();
            assert!(off < 1e-8, "{what}: onset off by {off:.1e} s");
        }
    }
}

#[test]
fn the_force_curve_of_the_wires_at_gap_zero() {
    for case in list(&data(), "wires_gap_zero_curve") {
        let params = preset(case["rig"].as_str().unwrap()).unwrap();
        let plan = Plan {
            cycles: 332,
            transient: 300,
        };
        let frequency_hz = number(case, "frequency_hz");
        let seen = settled(&params, frequency_hz, plan, &mut CycleRecorder::default());
        let what = format!("ratio {}", case["ratio"]);
        assert_eq!(case["label"], seen.regime.to_string(), "{what}");
        let force = number(case, "strongest_peak_force_n");
        close(&what, seen.force_n, force, 1e-8);
    }
}
