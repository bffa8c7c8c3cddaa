use super::*;

const ROCK: Slider<f64> = Slider {
    stiffness: 5.5e6,
    damping: 1.2e3,
    threshold: 50.0,
};

#[test]
fn the_force_is_never_beyond_the_threshold_and_the_front_never_goes_back() {
    for touch in [Touch::Apart, Touch::Held, Touch::Slipping] {
        for e in [0.0, 1e-6, 5e-6, 9e-6] {
            for speed in [-0.3, -1e-3, 0.0, 1e-3, 0.02, 0.3] {
                let next = ROCK.next(touch, e, e, speed);
                let force = ROCK.force(next, e, speed);
                assert!(next == Touch::Held || force >= 0.0);
                assert!(force <= ROCK.threshold, "{touch:?} {e} {speed}");
                let advance = ROCK.advance_rate(next, e, speed);
                assert!(advance >= -1e-15, "{touch:?} {e} {speed}: {advance}");
            }
        }
    }
}

#[test]
fn parameters_out_of_range_are_named() {
    let key = |slider: Slider<f64>| slider.check().unwrap_err().key;
    assert_eq!(ROCK.check(), Ok(()));
    let (threshold, stiffness, damping) = (0.0, f64::NAN, -1.0);
    assert_eq!(key(Slider { threshold, ..ROCK }), "threshold_n");
    assert_eq!(
        key(Slider { stiffness, ..ROCK }),
        "ground_stiffness_n_per_m"
    );
    assert_eq!(key(Slider { damping, ..ROCK }), "ground_damping_n_s_per_m");
}

/// A free mass on the ground, in fixed steps: progress, and the speed with which it leaves.
fn blow<R: Real>(slider: &Slider<f64>, mass: f64, speed: f64, step_s: f64) -> (f64, f64) {
    let mut ground = Ground::<R>::new(slider, step_s);
    let (h, inverse_mass) = (R::from_f64(step_s), R::from_f64(1.0 / mass));
    let (mut x, mut v) = (R::ZERO, R::from_f64(speed));
    ground.touch = ground.slider.at_onset(R::ZERO, v);
    while ground.touch != Touch::Apart {
        // The force at mid-step, from the state at its beginning: of second order.
        let half = h * R::HALF;
        let middle = v - ground.force(v) * inverse_mass * half;
        let mut ahead = ground;
        ahead.compression += half
            * ground
                .slider
                .compression_rate(ground.touch, ground.compression, v);
        let end = v - ahead.force(middle) * inverse_mass * h;
        x += (v + end) * half;
        v = end;
        ground.step(x, v);
    }
    (ground.drift.hi.to_f64(), -v.to_f64())
}

/// m v²/2 = Pf s: a slider without give takes the whole energy.
#[test]
fn a_stiff_slider_goes_as_far_as_the_energy_of_the_blow_takes_it() {
    let (mass, speed) = (0.298, 0.08);
    let stiff = Slider {
        stiffness: 1e10,
        damping: 1e5,
        threshold: 50.0,
    };
    let (progress, rebound) = blow::<f64>(&stiff, mass, speed, 1e-7);
    let ideal = 0.5 * mass * speed * speed / stiff.threshold;
    assert!((progress / ideal - 1.0).abs() < 1e-3, "{progress} {ideal}");
    assert!(rebound < 0.01 * speed, "{rebound}");
}

#[test]
fn single_precision_steps_of_5_microseconds_dig_what_fine_double_steps_dig() {
    for threshold in [15.0, 25.0, 50.0, 75.0] {
        let rock = Slider { threshold, ..ROCK };
        let (fine, _) = blow::<f64>(&rock, 0.298, 0.08, 1e-8);
        let (coarse, _) = blow::<f32>(&rock, 0.298, 0.08, 5e-6);
        assert!(
            (coarse / fine - 1.0).abs() < 0.01,
            "{threshold}: {coarse} {fine}"
        );
    }
}

#[test]
fn a_light_touch_leaves_no_mark() {
    let (progress, rebound) = blow::<f64>(&ROCK, 0.298, 0.02, 1e-7);
    assert_eq!(progress, 0.0);
    // The spring-dashpot's restitution: 0.317.
    assert!((rebound / 0.02 - 0.317).abs() < 1e-3, "{rebound}");
}

#[test]
fn feeding_brings_the_front_nearer_and_keeps_the_progress() {
    let mut ground = Ground::<f32>::new(&ROCK, 5e-6);
    ground.touch = Touch::Slipping;
    let dug = ground.step(2e-5, 0.0);
    assert!(dug > 0.0 && ground.lead == dug);
    ground.feed(dug);
    assert_eq!(ground.lead, 0.0);
    assert_eq!(ground.drift.hi, dug);
}
