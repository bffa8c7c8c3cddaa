use shared::model::cart::{ASSUMED_SHAKER, CartDrive};
use shared::model::params::{BEAM_150, RigParams, SupportParams, WIRES};

use super::starts::one_parameter;
use super::*;
use crate::continuation::{Along, FamilyDrive, OrbitsRequest, Special};
use crate::knob::Knob;

const SEARCH: OrbitsRequest = OrbitsRequest {
    along: Along::Frequency,
    limits: (0.0, 0.0),
    periods: 1,
    impacts: 1,
    starts: 10,
    checks: 0,
};

fn rig(name: &str) -> Varied {
    Varied::Rig(Knob::named(name).unwrap())
}

fn over(params: RigParams, first: (Varied, f64, f64), second: (Varied, f64, f64)) -> Plane {
    let dimension = |(varied, from, to)| Dimension::new(varied, (from, to), false, &params);
    Plane {
        params,
        drive: FamilyDrive::Ratio(2.0),
        dimensions: [dimension(first), dimension(second)],
    }
}

fn curves(plane: &Plane, at: &[f64]) -> Vec<TwoParameterCurve> {
    let found = seeds(plane, at, &SEARCH, &()).unwrap();
    assert_eq!(found.refused, 0);
    followed(&found.seeds, &()).unwrap()
}

/// The special points of one-parameter runs at values of the second parameter that the curve was not begun at are on it.
fn on_one_parameter_runs(plane: &Plane, curves: &[TwoParameterCurve], values: &[f64]) -> usize {
    let mut compared = 0;
    for value in values {
        let alone = one_parameter(plane, *value, &SEARCH, &()).unwrap();
        for (node, special) in alone.curves.iter().flat_map(|c| c.specials()) {
            let condition = match special {
                Special::PeriodDoubling => Condition::PeriodDoubling,
                Special::Fold => Condition::Fold,
                _ => Condition::Grazing,
            };
            let unit = match alone.request.along {
                Along::Rig { unit, .. } => unit,
                _ => 1.0,
            };
            let first = node.parameter() * unit;
            let nearest = (curves.iter().filter(|c| c.condition == condition))
                .flat_map(|c| c.at(1, *value))
                .map(|p| (p.values[0] / first - 1.0).abs())
                .fold(f64::INFINITY, f64::min);
            // A graze of a one-parameter run is extrapolated; the curve's own holds the closed form below to 1e-9.
            let tolerance = if condition == Condition::Grazing {
                2e-7
            } else {
                1e-8
            };
            assert!(
                nearest < tolerance,
                "{special:?} {first} {value}: {nearest}"
            );
            compared += 1;
        }
    }
    compared
}

#[test]
fn points_are_those_of_one_parameter_runs() {
    let plane = over(WIRES, (Varied::Ratio, 0.8, 4.0), (rig("gap_mm"), 0.0, 3.0));
    let found = curves(&plane, &[0.0, 3.0]);
    let compared = on_one_parameter_runs(&plane, &found, &[0.7, 2.4]);
    assert!(compared >= 5, "{compared}");
}

#[test]
fn a_recoiling_cart_and_a_contact_s_stiffness_are_followed_alike() {
    let params = RigParams {
        cart: CartDrive::Loop(ASSUMED_SHAKER),
        ..WIRES
    };
    let plane = over(
        params,
        (Varied::Ratio, 1.6, 3.0),
        (rig("contact_stiffness_n_per_m"), 1e6, 1e7),
    );
    let found = curves(&plane, &[5.5e6]);
    assert_eq!(found.len(), 1);
    let compared = on_one_parameter_runs(&plane, &found, &[2e6]);
    assert_eq!(compared, 1);
}

/// Neither parameter the drive's: the frequency stays at its ratio.
#[test]
fn two_parameters_of_the_rig_are_followed_at_one_ratio() {
    let mut plane = over(
        WIRES,
        (rig("gap_mm"), 0.5, 3.0),
        (rig("amplitude_mm"), 0.7, 1.2),
    );
    plane.drive = FamilyDrive::Ratio(2.2);
    let found = curves(&plane, &[0.89]);
    assert!(!found.is_empty());
    let compared = on_one_parameter_runs(&plane, &found, &[1.0]);
    assert!(compared >= 1);
}

/// A linear hammer that touches without a blow swings as if there were no surface: A0 r²/√((1 − r²)² + (2ζr)²) = gap.
#[test]
fn the_graze_of_a_motion_without_contact_is_the_linear_response() {
    const ZETA: f64 = 0.02;
    let params = RigParams {
        support: SupportParams::Beams {
            natural_frequency_hz: 5.25,
            damping_ratio: ZETA,
            cubic_stiffness_n_per_m3: Some(0.0),
        },
        ..BEAM_150
    };
    let plane = over(params, (Varied::Ratio, 1.1, 3.0), (rig("gap_mm"), 1.0, 4.0));
    let found = curves(&plane, &[2.4]);
    let graze = found
        .iter()
        .find(|c| c.condition == Condition::Grazing && c.impacts() == 0);
    let graze = graze.unwrap();
    assert!(graze.points.len() > 20);
    for point in &graze.points {
        let [r, gap_mm] = point.values;
        let swing = params.amplitude_m * 1e3 * r * r / (1.0 - r * r).hypot(2.0 * ZETA * r);
        assert!((swing / gap_mm - 1.0).abs() < 1e-9, "{r} {gap_mm} {swing}");
        // Nothing but the damping acts on the multipliers: their product is e^(−4πζ/r).
        let [(a, b), (c, d)] = point.multipliers;
        let product = a * c - b * d;
        let exact = (-4.0 * std::f64::consts::PI * ZETA / r).exp();
        assert!((product / exact - 1.0).abs() < 1e-9);
    }
}

/// A doubling of the 1/2 ends where the 1/2 gains a contact; the graze, a continuation of its own with other equations, has
/// its doubling there.
#[test]
fn where_a_doubling_ends_at_a_graze_the_graze_has_its_doubling() {
    let plane = over(
        WIRES,
        (Varied::Ratio, 2.02, 2.6),
        (rig("gap_mm"), 2.4, 2.85),
    );
    let search = OrbitsRequest {
        periods: 2,
        starts: 30,
        ..SEARCH
    };
    let found = seeds(&plane, &[2.65], &search, &()).unwrap();
    let found = followed(&found.seeds, &()).unwrap();
    let marks = |condition: Condition| {
        let curves = found.iter().filter(move |c| c.condition == condition);
        let marks = curves.flat_map(|c| c.marks());
        let wanted = marks.filter(|(_, kind)| *kind == Codimension::DoublingGraze);
        wanted.map(|(p, _)| p.values).collect::<Vec<_>>()
    };
    let (ends, passed) = (marks(Condition::PeriodDoubling), marks(Condition::Grazing));
    assert_eq!((ends.len(), passed.len()), (1, 1), "{ends:?} {passed:?}");
    for k in 0..2 {
        assert!(
            (ends[0][k] / passed[0][k] - 1.0).abs() < 1e-6,
            "{ends:?} {passed:?}"
        );
    }
}
