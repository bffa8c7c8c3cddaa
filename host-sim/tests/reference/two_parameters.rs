//! Curves over two parameters against the closed form of the bouncing oscillator ([`crate::bouncing`]).

use numerics::continuation::two::{self, Condition, Dimension, Plane, Varied, followed, seeds};
use numerics::continuation::{Along, FamilyDrive, OrbitsRequest};
use numerics::knob::Knob;

use crate::bouncing::{NATURAL_HZ, bouncing, stiffened};
use crate::special_points::bisected;

/// Every point of the curve of doublings over frequency and gap approaches the closed form at
/// its own gap.
#[test]
fn the_curve_of_doublings_approaches_the_closed_form_as_the_contact_stiffens() {
    let gaps_mm = [0.8, 0.9, 1.0];
    let found = |times: f64| {
        let params = stiffened(times, 1e-3);
        let gap = Varied::Rig(Knob::named("gap_mm").unwrap());
        let plane = Plane {
            params,
            drive: FamilyDrive::Ratio(2.0),
            dimensions: [
                Dimension::new(Varied::Ratio, (2.15, 2.4), false, &params),
                Dimension::new(gap, (0.79, 1.01), false, &params),
            ],
        };
        let request = OrbitsRequest {
            along: Along::Frequency,
            limits: (0.0, 0.0),
            periods: 1,
            impacts: 1,
            starts: 3,
            checks: 0,
        };
        let seeds = seeds(&plane, &[0.9], &request, &()).unwrap();
        let curves = followed(&seeds.seeds, &()).unwrap();
        let doubling = |c: &&two::TwoParameterCurve| c.condition == Condition::PeriodDoubling;
        let curve = curves.iter().find(doubling).expect("doublings");
        gaps_mm.map(|mm| curve.at(1, mm)[0].values[0])
    };
    let found = [8.0, 16.0, 32.0].map(found);
    for (k, gap_mm) in gaps_mm.into_iter().enumerate() {
        let exact = bisected(1.5, 2.6, |r| {
            let [a, b] = bouncing(r * NATURAL_HZ, gap_mm * 1e-3);
            if a.speed > b.speed { a } else { b }.doubling_test()
        });
        let errors = found.map(|f| f[k] / exact - 1.0);
        for pair in errors.windows(2) {
            let order = (pair[0] / pair[1]).log2();
            assert!(
                (order - 1.0).abs() < 0.15,
                "{gap_mm}: order {order} of {errors:?}"
            );
        }
        let once = [0, 1].map(|i| 2.0 * errors[i + 1] - errors[i]);
        let limit = (4.0 * once[1] - once[0]) / 3.0;
        println!("{gap_mm} mm: {exact:.8}, {errors:?}, {limit:.1e}");
        assert!(limit.abs() < 1e-8, "{gap_mm}: {limit}");
    }
}
