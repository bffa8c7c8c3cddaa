//! Period doubling, fold and graze as continuation finds them, against the closed form of the bouncing oscillator
//! ([`crate::bouncing`]), against the linear response, and against what simulation does beyond them.

use host_sim::progress::ProgressLine;
use numerics::continuation::{
    Along, CurveEnd, CurveOrigin, Family, Node, OrbitCurve, OrbitDiagram, OrbitsRequest, Special,
    Until, diagram, march,
};
use numerics::engine::{CycleRecorder, Engine, Plan, Start, machine, observe};
use numerics::orbit::{Stability, on_course, shoot, shoot_at};
use shared::model::contact::Law;
use shared::model::params::{BEAM_150, BEAM_170, RigParams, WIRES};
use shared::model::regime::Regime;

use crate::bouncing::{Bouncing, NATURAL_HZ, ZETA, bouncing, stiffened};
use crate::support::close;

const WIDE: (f64, f64) = (0.5, 4.0);

/// The closed form's stable orbit at a ratio Ω/ω.
fn stable(ratio: f64, gap_m: f64) -> Bouncing {
    let inside = |b: &Bouncing| b.trace.abs() < 1.0 + b.determinant && b.speed > 0.0;
    let found = bouncing(ratio * NATURAL_HZ, gap_m).into_iter().find(inside);
    found.expect("a stable orbit")
}

/// The ratio between `low` and `high` at which `test` of the closed form changes sign.
pub fn bisected(mut low: f64, mut high: f64, test: impl Fn(f64) -> f64) -> f64 {
    let sign = test(low).signum();
    assert!(sign != test(high).signum(), "no change of sign");
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if test(middle).signum() == sign {
            low = middle;
        } else {
            high = middle;
        }
    }
    low
}

/// Where the 1/1 followed from `from` (Ω/ω, on the closed form) meets its first special point.
fn first_special(times: f64, gap_m: f64, from: f64, upwards: bool) -> Node {
    let family = Family::new(&stiffened(times, gap_m), Along::Frequency, 1).unwrap();
    let seed = family.node_at(from, on_course(stable(from, gap_m).section));
    let seed = seed.expect("the closed form is near enough to start from");
    let seed = if upwards { seed } else { seed.turned() };
    let (nodes, end) = march(&family, &seed, WIDE, Until::Special);
    assert!(matches!(end, CurveEnd::Special(_)), "{end:?}");
    nodes.last().expect("a special point").clone()
}

/// Located at contacts 8 to 64 times shorter than Table 3.1's, `kind` must approach `exact` (Ω/ω) at first order in the
/// contact time, and extrapolated to no contact time it must meet it within `tolerance`.
fn approaches(kind: Special, exact: f64, tolerance: f64, (gap_m, from, upwards): (f64, f64, bool)) {
    let found: Vec<f64> = [8.0, 16.0, 32.0, 64.0]
        .into_iter()
        .map(|times| {
            let node = first_special(times, gap_m, from, upwards);
            assert_eq!(node.special, Some(kind));
            node.parameter()
        })
        .collect();
    let errors: Vec<f64> = found.iter().map(|f| (f / exact - 1.0).abs()).collect();
    for pair in errors.windows(2) {
        let order = (pair[0] / pair[1]).log2();
        assert!(order > 0.85, "{kind:?}: order {order:.2} of {errors:?}");
    }
    // Two steps of Richardson's extrapolation: the errors of first and second order cancel.
    let once = |k: usize| 2.0 * found[k + 1] - found[k];
    let limit = (4.0 * once(2) - once(1)) / 3.0;
    println!("{kind:?}: exact {exact:.8}, relative errors {errors:?}, extrapolated {limit:.8}");
    close(kind.name(), limit, exact, tolerance);
}

/// The closed form doubles where 1 + trace + determinant = 0 (Shaw and Holmes' λ = −1).
#[test]
fn the_doubling_approaches_the_closed_form_as_the_contact_stiffens() {
    let gap_m = 1e-3;
    let exact = bisected(1.5, 2.3, |r| {
        let [a, b] = bouncing(r * NATURAL_HZ, gap_m);
        if a.speed > b.speed { a } else { b }.doubling_test()
    });
    approaches(Special::PeriodDoubling, exact, 3e-8, (gap_m, 1.5, true));
}

/// The closed form folds where its quadratic's two roots are one.
#[test]
fn the_fold_approaches_the_closed_form_as_the_contact_stiffens() {
    let gap_m = 2.4e-3;
    let exists = |r: f64| bouncing(r * NATURAL_HZ, gap_m)[0].speed.is_finite();
    let exact = bisected(1.4, 1.9, |r| if exists(r) { 1.0 } else { -1.0 });
    // The multiplier is +1 there.
    let at = &bouncing(exact * (1.0 - 1e-12) * NATURAL_HZ, gap_m)[0];
    assert!((1.0 - at.trace + at.determinant).abs() < 1e-4);
    approaches(Special::Fold, exact, 3e-8, (gap_m, 1.4, true));
}

/// The closed form gains a contact where the flight between two impacts turns back at the surface.
#[test]
fn the_graze_approaches_the_closed_form_as_the_contact_stiffens() {
    let gap_m = 0.0;
    let exact = bisected(1.0, 1.5, |r| {
        let miss = stable(r, gap_m).near_miss_m();
        if miss > 0.0 { 1.0 } else { -1.0 }
    });
    approaches(Special::GrazingGained, exact, 3e-8, (gap_m, 1.5, false));
}

/// Behind the fold lies the closed form's other orbit, and it ends where the swing without contact just reaches the
/// surface: A0 r²/√((1 − r²)² + (2ζr)²) = gap, whatever the contact.
#[test]
fn behind_the_fold_lies_the_other_orbit_and_it_ends_at_the_linear_response() {
    let gap_m = 2.4e-3;
    let params = stiffened(8.0, gap_m);
    let family = Family::new(&params, Along::Frequency, 1).unwrap();
    let seed = family
        .node_at(1.4, on_course(stable(1.4, gap_m).section))
        .unwrap();
    let (nodes, end) = march(&family, &seed, WIDE, Until::End);
    assert_eq!(end, CurveEnd::Special(Special::GrazingLost));
    let swing = |r: f64| params.amplitude_m * r * r / (1.0 - r * r).hypot(2.0 * ZETA * r);
    let exact = bisected(1.05, 1.6, |r| swing(r) - gap_m);
    close("graze", nodes.last().unwrap().parameter(), exact, 1e-6);

    let unstable = nodes.iter().filter(|n| !n.orbit.is_stable());
    // Not at the fold itself, which moves with the contact time.
    let behind = unstable.filter(|n| (1.35..1.5).contains(&n.parameter()));
    let behind: Vec<_> = behind.collect();
    assert!(behind.len() > 3);
    for node in behind {
        let speed = node.orbit.contact.approach_speed_m_per_s;
        let closed = bouncing(node.orbit.frequency_hz, gap_m);
        let miss = |b: &Bouncing| (speed / b.speed - 1.0).abs();
        let unstable = closed.iter().filter(|b| b.trace > 1.0 + b.determinant);
        let miss = unstable.map(miss).fold(f64::INFINITY, f64::min);
        // First order in a contact 8 times shorter than 0.6 ms.
        assert!(miss < 1.5e-2, "{}: off by {miss}", node.parameter());
    }
}

/// Twice round an orbit its multipliers are squared.
#[test]
fn the_monodromy_over_two_periods_is_the_square() {
    let hz = 2.5 * WIRES.natural_frequency_hz();
    let mut hammer = machine(Engine::Event, &WIRES, hz, Start::Rest).unwrap();
    for _ in 0..100 {
        hammer.period(None);
    }
    let orbit = shoot(&WIRES, hz, hammer.section()).expect("an orbit");
    let twice = shoot_at(&WIRES, orbit.frequency_hz, on_course(orbit.section), 2).unwrap();
    assert_eq!((orbit.impacts, twice.impacts), (1, 2));
    let square = |(re, im): (f64, f64)| (re * re - im * im, 2.0 * re * im);
    let mut want = orbit.eigenvalues().map(square);
    want.sort_by(|a, b| a.partial_cmp(b).unwrap());
    let mut seen = twice.eigenvalues();
    seen.sort_by(|a, b| a.partial_cmp(b).unwrap());
    for (a, b) in seen.into_iter().zip(want) {
        assert!((a.0 - b.0).hypot(a.1 - b.1) < 1e-8, "{a:?} {b:?}");
    }
}

/// What a simulation from beside an orbit's section settles to.
fn regime(params: &RigParams, frequency_hz: f64, section: [f64; 2], cycles: u32) -> (Regime, f64) {
    let start = Start::Section(section.map(|x| x * (1.0 + 1e-5)));
    let mut hammer = machine(Engine::Event, params, frequency_hz, start).unwrap();
    let plan = Plan {
        cycles,
        transient: cycles - 40,
    };
    let seen = observe(hammer.as_mut(), plan, &mut CycleRecorder::default()).unwrap();
    (seen.regime, seen.force_n)
}

fn curves(
    gap_m: f64,
    limits: (f64, f64),
    periods: u8,
    starts: usize,
) -> (RigParams, Vec<OrbitCurve>) {
    let params = RigParams { gap_m, ..WIRES };
    let request = OrbitsRequest {
        along: Along::Frequency,
        limits,
        periods,
        impacts: 2,
        starts,
        checks: 0,
    };
    let found = diagram(&params, &request, &ProgressLine::new("", 1, true)).unwrap();
    (params, found.curves)
}

/// A contact whose approach speed passes 0 while the hammer is pressed on is not lost: it then begins inside the surface,
/// where F comes back to 0. The 2/3 was said to end there, at 4.66597 (and on beam-150 at 1.5 mm at 4.04236). It ends
/// where its two contacts merge, and the 1/3 begins there.
#[test]
fn a_contact_that_begins_inside_the_surface_is_not_lost() {
    let find = |rig: RigParams, gap_m: f64, limits: (f64, f64)| {
        let request = OrbitsRequest {
            along: Along::Frequency,
            limits,
            periods: 3,
            impacts: 2,
            starts: 40,
            checks: 1600,
        };
        let params = RigParams { gap_m, ..rig };
        diagram(&params, &request, &ProgressLine::new("", 1, true)).unwrap()
    };
    let found = find(BEAM_170, 0.5e-3, (4.65, 4.68));
    let ends = |regime: &str, end: CurveEnd| {
        let curves = (found.curves.iter()).filter(|c| c.regime().to_string() == regime);
        let nodes = curves.flat_map(|c| {
            let first = (c.ends[0] == end).then(|| c.nodes.first().unwrap().parameter());
            let last = (c.ends[1] == end).then(|| c.nodes.last().unwrap().parameter());
            [first, last].into_iter().flatten()
        });
        nodes.collect::<Vec<_>>()
    };
    let merged = ends("2/3", CurveEnd::Merged);
    assert_eq!(merged.len(), 1, "{merged:?}");
    assert!((merged[0] - 4.662_645_4).abs() < 1e-6, "{merged:?}");
    let begins = ends("1/3", CurveEnd::Lost);
    assert!((begins[0] - merged[0]).abs() < 1e-7, "{begins:?}");
    assert!(found.elsewhere.is_empty(), "{:?}", found.elsewhere);
    // The 2/3 below the 1/3 is another branch: it ends where it loses its second contact.
    let over = |c: &&OrbitCurve| {
        let at = |x: f64| c.nodes.iter().any(|n| (n.parameter() - x).abs() < 5e-4);
        c.regime().is(2, 3) && at(4.6583) && at(4.663)
    };
    assert_eq!(found.curves.iter().filter(over).count(), 0);
    let specials = found.curves.iter().flat_map(|c| c.specials());
    let lost = specials.filter(|(n, k)| *k == Special::GrazingLost && n.parameter() > 4.66);
    assert_eq!(lost.count(), 0);

    let found = find(BEAM_150, 1.5e-3, (4.03, 4.06));
    let near = |n: &&Node| (n.parameter() - 4.04236).abs() < 1e-4;
    let specials = found.curves.iter().flat_map(|c| c.specials());
    assert_eq!(specials.filter(|(n, _)| near(n)).count(), 0);
}

/// 3/1 lies between 0.895 and 0.947 at 0.0 mm. Simulations at few frequencies miss it; those that check find it.
#[test]
fn what_checks_settle_on_is_followed() {
    let request = |checks: usize| OrbitsRequest {
        along: Along::Frequency,
        limits: (0.85, 1.2),
        periods: 1,
        impacts: 3,
        starts: 1,
        checks,
    };
    let found =
        |checks: usize| diagram(&WIRES, &request(checks), &ProgressLine::new("", 1, true)).unwrap();
    let has = |d: &OrbitDiagram| d.curves.iter().any(|c| c.regime().is(3, 1));
    assert!(!has(&found(0)));
    let checked = found(40);
    assert!(has(&checked));
    assert!(checked.elsewhere.is_empty(), "{:?}", checked.elsewhere);
    assert_eq!((checked.simulations, checked.failed), (123, 0));
}

/// Just below the doubling of the 1/1 at 2.66068 runs settle so slowly that they are taken for 2/2. The orbit there is the
/// 1/1, and no branch of its own.
#[test]
fn an_orbit_passed_twice_is_no_branch_of_its_own() {
    let request = OrbitsRequest {
        along: Along::Frequency,
        limits: (2.655, 2.665),
        periods: 2,
        impacts: 2,
        starts: 1,
        checks: 200,
    };
    let found = diagram(&WIRES, &request, &ProgressLine::new("", 1, true)).unwrap();
    let names: Vec<_> = (found.curves.iter())
        .map(|c| c.regime().to_string())
        .collect();
    assert_eq!(names, ["1/1", "2/2"]);
    assert!(found.elsewhere.is_empty(), "{:?}", found.elsewhere);
}

/// Hertz's contact takes no energy and the wires have no damping: the map keeps areas, and a complex pair of multipliers
/// lies on the unit circle. With a loss it does not.
#[test]
fn an_orbit_without_any_loss_is_neutral_and_not_stable() {
    let (stiffness, exponent) = (2.51502e9, 1.5);
    let stabilities = |contact: Law<f64>| {
        let params = RigParams { contact, ..WIRES };
        let hz = 2.0 * params.natural_frequency_hz();
        let scale = params.amplitude_m / 0.075;
        let guesses =
            (0..12).flat_map(|i| (0..12).map(move |j| (f64::from(i), f64::from(j) - 6.0)));
        let found = guesses.filter_map(|(q, v)| {
            let guess = [
                -0.5 * q * scale,
                0.5 * v * scale * std::f64::consts::TAU * hz,
            ];
            shoot(&params, hz, guess).filter(|o| o.impacts == 1)
        });
        found.map(|o| o.stability()).collect::<Vec<_>>()
    };
    let hertz = stabilities(Law::Hertz {
        stiffness,
        exponent,
    });
    assert!(hertz.contains(&Stability::Neutral), "{hertz:?}");
    assert!(!hertz.contains(&Stability::Stable), "{hertz:?}");
    let damping_ratio = 0.1;
    let lossy = stabilities(Law::HuntCrossley {
        stiffness,
        exponent,
        damping_ratio,
    });
    assert!(lossy.contains(&Stability::Stable), "{lossy:?}");
    assert!(!lossy.contains(&Stability::Neutral), "{lossy:?}");
}

#[test]
fn beyond_each_doubling_simulation_doubles_and_before_it_does_not() {
    let (params, curves) = curves(0.0, (2.0, 2.95), 2, 4);
    let mut checked = Vec::new();
    for curve in &curves {
        let doublings = curve
            .specials()
            .filter(|(_, k)| *k == Special::PeriodDoubling);
        for (node, _) in doublings {
            let (p, n) = (curve.impacts(), curve.periods());
            let hz = node.orbit.frequency_hz;
            let seen = [0.998, 1.002].map(|r| regime(&params, r * hz, node.orbit.section, 1500).0);
            let (before, after) = (seen[0].is(p, n), seen[1].is(2 * p, 2 * n));
            assert!(before && after, "{p}/{n} at {}: {seen:?}", node.parameter());
            checked.push((p, n));
        }
    }
    assert_eq!(checked, [(1, 1), (2, 2)]);
}

/// The 1/2 at 0.0 mm doubles downwards, and a ten-thousandth lower the 2/4 grazes: a simulation finds each of the
/// three where continuation says.
#[test]
fn a_doubled_orbit_that_soon_grazes_is_found_between_its_two_ends() {
    let (params, curves) = curves(0.0, (3.3, 3.6), 4, 2);
    let find = |regime: &str| {
        let same = |c: &&OrbitCurve| c.regime().to_string() == regime;
        curves.iter().find(same).unwrap()
    };
    let mut specials = find("1/2").specials();
    let (doubling, _) = specials
        .find(|(_, k)| *k == Special::PeriodDoubling)
        .unwrap();
    let doubled = find("2/4");
    assert!(matches!(doubled.origin, CurveOrigin::Doubling(_)));
    let graze = doubled.nodes.last().unwrap();
    assert_eq!(graze.special, Some(Special::GrazingGained));
    let (graze_hz, doubling_hz) = (graze.orbit.frequency_hz, doubling.orbit.frequency_hz);
    assert!(graze_hz < doubling_hz && graze_hz > 0.9998 * doubling_hz);
    let seen = |hz: f64| regime(&params, hz, graze.orbit.section, 2500).0;
    let width = doubling_hz - graze_hz;
    let told = [
        graze_hz - width,
        doubling_hz - 0.5 * width,
        doubling_hz + 20.0 * width,
    ]
    .map(seen);
    assert!(
        told[0].is(3, 4) && told[1].is(2, 4) && told[2].is(1, 2),
        "{told:?}"
    );
}

#[test]
fn past_a_fold_the_simulation_jumps_and_before_it_it_stays() {
    let (params, curves) = curves(2.4e-3, (1.0, 1.9), 1, 6);
    let one_one = curves.iter().find(|c| c.regime().is(1, 1)).unwrap();
    let mut folds = one_one.specials().filter(|(_, k)| *k == Special::Fold);
    let (fold, _) = folds.next().expect("a fold");
    let hz = fold.orbit.frequency_hz;
    let force_n = fold.orbit.force_n;
    // A part in a thousand before the fold it still is a 1/1 of about this force (the curve is a parabola there).
    let stays = regime(&params, 0.999 * hz, fold.orbit.section, 400);
    assert!(
        stays.0.is(1, 1) && (stays.1 / force_n - 1.0).abs() < 0.1,
        "{stays:?}"
    );
    let jumps = regime(&params, 1.001 * hz, fold.orbit.section, 400);
    assert!(
        !jumps.0.is(1, 1) || (jumps.1 / force_n - 1.0).abs() > 0.5,
        "{jumps:?}"
    );
}

/// What is told of an orbit is what happens: it pushes only, misses no contact, closes, and repeats no sooner.
#[test]
fn orbits_are_admissible() {
    for gap_m in [0.0, 1e-3] {
        let (params, curves) = curves(gap_m, (1.6, 3.6), 2, 5);
        assert!(curves.len() >= 2);
        for node in curves.iter().flat_map(|c| &c.nodes) {
            let orbit = &node.orbit;
            // The force's zero at release is located to 1e-13 s.
            assert!(orbit.seen.largest_pull_n < 1e-6);
            assert!(orbit.seen.deepest_flight_m < 1e-12);
            assert!(orbit.seen.near_miss_m.is_none_or(|m| m > 0.0));
            let contacts = usize::from(orbit.impacts);
            assert_eq!(orbit.seen.contacts.len(), contacts, "{}", node.parameter());
            let section = on_course(orbit.section);
            let again = shoot_at(&params, orbit.frequency_hz, section, orbit.periods);
            // At a fold or graze Newton's iteration may find a neighbour, never another kind.
            if let (Some(again), None) = (again, node.special) {
                assert_eq!(again.impacts, orbit.impacts);
            }
            let at_doubling = node.special.is_some();
            if orbit.periods == 2 && !at_doubling {
                let apart = orbit.asymmetry(2, [1e-3 * 0.89 / 0.075, 0.1]);
                assert!(
                    apart[0].abs() + apart[1].abs() > 1e-4,
                    "{}",
                    node.parameter()
                );
            }
        }
    }
}
