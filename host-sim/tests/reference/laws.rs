//! The laws' presets in `shared::model::contact::LAWS`, solved anew.

use shared::model::contact::{Law, LawKind};

use crate::support::{close, reference_contact};

const MASS_KG: f64 = 0.298;
const APPROACH: f64 = 0.08;

fn time_and_restitution(law: Law<f64>) -> (f64, f64) {
    let contact = reference_contact(MASS_KG, law, APPROACH);
    let restitution = contact.rebound_speed_m_per_s / contact.approach_speed_m_per_s;
    (contact.duration_s, restitution)
}

/// The stiffness at which `law` lasts `target_s`: at fixed approach and damping, a contact with exponent
/// 3/2 lasts as long as stiffness^(−2/5).
fn stiffness_for(law: impl Fn(f64) -> Law<f64>, target_s: f64) -> f64 {
    const TRIAL: f64 = 1e9;
    let (duration_s, _) = time_and_restitution(law(TRIAL));
    TRIAL * (duration_s / target_s).powf(2.5)
}

fn hunt_crossley(stiffness: f64, damping_ratio: f64) -> Law<f64> {
    Law::HuntCrossley {
        stiffness,
        exponent: 1.5,
        damping_ratio,
    }
}

#[test]
fn every_preset_makes_the_contact_of_table_3_1_as_far_as_its_law_can() {
    let (target_s, target_e) = time_and_restitution(LawKind::SpringDashpot.preset());
    close("duration", target_s, 0.570751e-3, 1e-6);
    close("restitution", target_e, 0.316902, 1e-6);
    let outcomes = [
        (LawKind::Hertz, 1.0),
        (LawKind::HuntCrossley, target_e),
        (LawKind::LankaraniNikravesh, 0.662_962),
        (LawKind::Flores, target_e),
    ];
    for (law, restitution) in outcomes {
        let name = law.name();
        let (duration_s, e) = time_and_restitution(law.preset());
        println!("{name}: {duration_s} {e}");
        close(&format!("{name}: duration"), duration_s, target_s, 1e-5);
        close(&format!("{name}: restitution"), e, restitution, 1e-5);
    }
}

#[test]
fn solving_the_presets_anew_gives_their_constants() {
    let (target_s, target_e) = time_and_restitution(LawKind::SpringDashpot.preset());
    let hertz = |stiffness| Law::Hertz {
        stiffness,
        exponent: 1.5,
    };
    let lankarani = |stiffness| Law::LankaraniNikravesh {
        stiffness,
        exponent: 1.5,
        restitution: 0.0,
    };
    // Restitution depends on λ times the approach speed alone, and falls with it.
    let (mut a, mut b) = (1.0, 200.0);
    for _ in 0..60 {
        let middle = 0.5 * (a + b);
        if time_and_restitution(hunt_crossley(1e9, middle)).1 > target_e {
            a = middle;
        } else {
            b = middle;
        }
    }
    let damping_ratio = 0.5 * (a + b);
    let solved = [
        (LawKind::Hertz, stiffness_for(hertz, target_s)),
        (
            LawKind::HuntCrossley,
            stiffness_for(|k| hunt_crossley(k, damping_ratio), target_s),
        ),
        (
            LawKind::LankaraniNikravesh,
            stiffness_for(lankarani, target_s),
        ),
    ];
    println!("lambda {damping_ratio:.8} {solved:?}");
    for (law, stiffness) in solved {
        close(law.name(), law.preset().stiffness(), stiffness, 1e-6);
    }
    let Law::HuntCrossley {
        damping_ratio: preset_ratio,
        ..
    } = LawKind::HuntCrossley.preset()
    else {
        panic!("hunt-crossley is what it is called");
    };
    close("lambda", preset_ratio, damping_ratio, 1e-6);
    // At this approach speed Flores's law is Hunt and Crossley's: 8 (1 − e)/(5 e) = λ v.
    let Law::Flores { restitution, .. } = LawKind::Flores.preset() else {
        panic!("flores is what it is called");
    };
    let same = 8.0 / (8.0 + 5.0 * damping_ratio * APPROACH);
    close("flores", restitution, same, 1e-6);
    let stiffness = LawKind::Flores.preset().stiffness();
    close("flores", stiffness, solved[1].1, 1e-6);
}

#[test]
fn lankarani_nikravesh_cannot_rebound_less_at_any_speed_above_its_floor() {
    let lowest = |approach: f64| {
        let law = LawKind::LankaraniNikravesh.preset();
        let contact = reference_contact(MASS_KG, law, approach);
        contact.rebound_speed_m_per_s / approach
    };
    close("0.01 m/s", lowest(0.01), lowest(0.08), 1e-8);
    close("0.5 m/s", lowest(0.5), lowest(0.08), 1e-8);
}
