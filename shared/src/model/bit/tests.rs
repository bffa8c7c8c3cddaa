use super::*;

const GROUND: Slider<f64> = Slider {
    stiffness: 5.5e6,
    damping: 1.2e3,
    threshold: 25.0,
};

const BIT: Bit<f64> = Bit {
    mass: 0.1,
    stiffness: 5.5e6,
    damping: 1.2e3,
    feed_force: 0.981,
};

#[test]
fn parameters_out_of_range_are_named() {
    let key = |bit: Bit<f64>| bit.check(&GROUND).unwrap_err().key;
    assert_eq!(BIT.check(&GROUND), Ok(()));
    assert_eq!(key(Bit { mass: 0.0, ..BIT }), "bit_mass_kg");
    let (stiffness, damping, feed_force) = (f64::NAN, -1.0, 25.0);
    assert_eq!(key(Bit { stiffness, ..BIT }), "bit_stiffness_n_per_m");
    assert_eq!(key(Bit { damping, ..BIT }), "bit_damping_n_s_per_m");
    assert_eq!(key(Bit { feed_force, ..BIT }), "bit_feed_force_n");
    assert!((Bit::weight_n(0.1) - 0.981).abs() < 1e-12);
}

#[test]
fn hammer_and_bit_touch_exactly_where_they_overlap_and_push() {
    for x in [-1e-4, -1e-6, 1e-7, 1e-5] {
        for rate in [-0.5, -0.01, 0.0, 0.1] {
            let touch = x > 0.0 && BIT.force(x, rate) > 0.0;
            assert_eq!(BIT.indicator(x, rate) > 0.0, touch, "{x} {rate}");
        }
    }
}

#[test]
fn the_rate_of_the_indicator_is_that_of_differences() {
    let (x, acceleration, h) = (2e-6, -40.0, 1e-9);
    for rate in [-0.05, 0.05] {
        let after = |t: f64| BIT.indicator(x + t * rate, rate + t * acceleration);
        let slope = (after(h) - after(-h)) / (2.0 * h);
        let exact = BIT.indicator_rate(rate, acceleration);
        assert!((slope / exact - 1.0).abs() < 1e-6, "{slope} {exact}");
    }
}

/// A bit at rest on the ground stays there: feed and ground balance.
#[test]
fn a_bit_stands_still_where_it_rests() {
    let e = BIT.rest_compression(&GROUND);
    let ground = GROUND.held_force(e, 0.0);
    assert!(BIT.acceleration(BIT.pressed(0.0, ground), 0.0).abs() < 1e-12);
    assert!((e - 0.981 / 5.5e6).abs() < 1e-18);
}
