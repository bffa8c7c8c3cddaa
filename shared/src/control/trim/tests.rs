use super::*;
use crate::model::params::WIRES;

fn run(trim: &mut Trim, periods: usize, plant: impl Fn(f32) -> Strobe) -> f32 {
    for _ in 0..periods {
        let command = trim.command();
        trim.strobe(&plant(command), command, 4.0, (true, true), Some(0.0));
    }
    trim.command()
}

#[test]
fn a_shaker_that_moves_less_gets_a_larger_command() {
    let mut trim = Trim::new(&Settings::for_rig(&WIRES));
    let command = run(&mut trim, 40, |m| Strobe {
        amplitude_m: 0.8 * m,
        ..Strobe::default()
    });
    assert!((0.8 * command - 0.89e-3).abs() < 1e-6, "{command}");
    assert_eq!(trim.limits(), ActiveLimits::NONE);
}

#[test]
fn a_sensor_that_reads_far_less_raises_the_command_by_no_more_than_a_third() {
    let mut trim = Trim::new(&Settings::for_rig(&WIRES));
    let command = run(&mut trim, 100, |m| Strobe {
        amplitude_m: 0.64 * m,
        ..Strobe::default()
    });
    assert!((command / 0.89e-3 - 1.3).abs() < 1e-3, "{command}");
}

#[test]
fn a_resonance_is_met_at_once_and_the_wanted_amplitude_held() {
    for response in [1.5, 3.0, 10.0] {
        let mut trim = Trim::new(&Settings::for_rig(&WIRES));
        let mut command = 0.3e-3;
        for _ in 0..10 {
            if trim.surge(response * command, command) {
                command = command.min(trim.command());
            }
        }
        assert!(response * command < 1.25 * 0.89e-3, "{response}: {command}");
        let command = run(&mut trim, 40, |m| Strobe {
            amplitude_m: response * m,
            ..Strobe::default()
        });
        let share = response * command / 0.89e-3;
        assert!((share - 1.0).abs() < 0.01, "{response}: {share}");
    }
}

#[test]
fn a_force_above_the_limit_while_the_amplitude_rises_stops_the_rise() {
    let settings = Settings::for_rig(&WIRES);
    let mut trim = Trim::new(&settings);
    // Half of the amplitude makes 1.05 times the force allowed.
    let strobe = Strobe {
        amplitude_m: 0.445e-3,
        peak_n: 1.05 * settings.limits.force_n,
        ..Strobe::default()
    };
    trim.strobe(&strobe, 0.445e-3, 4.0, (true, true), Some(0.0));
    let share = trim.command() / 0.89e-3;
    assert!((share - 0.5 / 1.05).abs() < 1e-3, "{share}");
}

#[test]
fn a_dead_shaker_does_not_wind_up_beyond_the_limit() {
    let settings = Settings::for_rig(&WIRES);
    let mut trim = Trim::new(&settings);
    let command = run(&mut trim, 100, |_| Strobe::default());
    assert!((command / 0.89e-3 - RANGE.1).abs() < 1e-3, "{command}");
    let mut trim = Trim::new(&settings);
    trim.set_wanted_amplitude(1.2e-3);
    let command = run(&mut trim, 100, |_| Strobe::default());
    assert_eq!(command, settings.limits.amplitude_m);
    assert_eq!(trim.limits(), ActiveLimits::AMPLITUDE);
}

#[test]
fn a_force_that_is_forecast_above_the_limit_is_never_reached() {
    let mut settings = Settings::for_rig(&WIRES);
    settings.limits.travel_m = 1.0;
    let mut trim = Trim::new(&settings);
    trim.expect(1.5 * settings.limits.force_n, 3.66);
    let command = trim.command();
    assert!((command / 0.89e-3 - 0.6).abs() < 1e-3, "{command}");
    assert_eq!(trim.limits(), ActiveLimits::FORCE);
    trim.expect(0.5 * settings.limits.force_n, 3.66);
    assert_eq!(
        trim.command(),
        command,
        "a force below the limit changes nothing"
    );
}

#[test]
fn a_travel_that_is_expected_beyond_the_limit_is_never_reached() {
    let mut settings = Settings::for_rig(&WIRES);
    let strong_n = strong_force_n(&WIRES) as f32;
    // At Ω/ω = 2 a strong 1/1 travels 5 amplitudes; at 3, and with half of its force, 4.75.
    for (hz, force_n, travel_m, begins) in [
        (3.6404, strong_n, 4.5e-3, 1.0),
        (3.6404, strong_n, 4.4e-3, 0.89),
        (3.6404, strong_n, 3.4e-3, 0.688),
        (5.4606, 0.5 * strong_n, 4.3e-3, 1.0),
        (5.4606, 0.5 * strong_n, 3.4e-3, 0.724),
    ] {
        settings.limits.travel_m = travel_m;
        let mut trim = Trim::new(&settings);
        trim.expect(force_n, hz);
        let share = trim.command() / 0.89e-3;
        assert!((share - begins).abs() < 2e-3, "{travel_m}: {share}");
        assert_eq!(trim.limits().is_empty(), begins == 1.0);
    }
}

#[test]
fn force_above_the_limit_draws_the_amplitude_back_and_lets_it_return() {
    let settings = Settings::for_rig(&WIRES);
    let mut trim = Trim::new(&settings);
    let strong = |m: f32| Strobe {
        amplitude_m: m,
        peak_n: 1.5 * settings.limits.force_n * m / 0.89e-3,
        ..Strobe::default()
    };
    let command = run(&mut trim, 50, strong);
    assert!((0.6..0.69).contains(&(command / 0.89e-3)), "{command}");
    assert_eq!(trim.limits(), ActiveLimits::FORCE);
    let weak = |m: f32| Strobe {
        amplitude_m: m,
        contacts: 1,
        ..Strobe::default()
    };
    let mut blind = trim;
    let command = run(&mut trim, 50, weak);
    assert!((command / 0.89e-3 - 1.0).abs() < 1e-3, "{command}");
    assert_eq!(trim.limits(), ActiveLimits::NONE);
    let unseen = |m: f32| Strobe {
        contacts: 0,
        ..weak(m)
    };
    let command = run(&mut blind, 50, unseen);
    assert!((0.75..0.9).contains(&(command / 0.89e-3)), "{command}");
}

/// A drive period with one contact, at the amplitude commanded; the command after it.
fn contact(trim: &mut Trim, steady: bool, measured: Strobe) -> f32 {
    let command_m = trim.command();
    let strobe = Strobe {
        amplitude_m: command_m,
        contacts: 1,
        ..measured
    };
    trim.strobe(&strobe, command_m, 4.0, (true, steady), Some(0.0));
    trim.command()
}

#[test]
fn what_a_limit_took_returns_only_while_the_sensors_are_steady() {
    let settings = Settings::for_rig(&WIRES);
    let mut trim = Trim::new(&settings);
    trim.set_wanted_amplitude(0.89e-3);
    let strobe = |trim: &mut Trim, over: f32, steady: bool| {
        let peak_n = over * settings.limits.force_n;
        contact(
            trim,
            steady,
            Strobe {
                peak_n,
                ..Strobe::default()
            },
        )
    };
    let reduced_m = strobe(&mut trim, 1.25, true);
    for _ in 0..30 {
        assert_eq!(strobe(&mut trim, 0.6, false), reduced_m);
    }
    assert!(strobe(&mut trim, 0.6, true) > reduced_m);
    // A limit takes more in any case.
    assert!(strobe(&mut trim, 1.2, false) < reduced_m);
}

/// A hammer's sensor that reads half halves the travel, too.
#[test]
fn what_a_limit_took_at_a_set_point_by_hand_returns_with_the_next_one() {
    let settings = Settings::for_rig(&WIRES);
    let mut trim = Trim::new(&settings);
    trim.set_wanted_amplitude(0.89e-3);
    let strobe = |trim: &mut Trim, over: f32| {
        let travel_m = over * settings.limits.travel_m;
        contact(
            trim,
            true,
            Strobe {
                travel_m,
                ..Strobe::default()
            },
        )
    };
    // What was taken before the limit was reached there returns.
    trim.set_way(Way::ToSetPoint);
    let on_the_way_m = strobe(&mut trim, 1.25);
    trim.set_way(Way::AtSetPoint);
    let there = (0..30).map(|_| strobe(&mut trim, 0.6));
    let there_m = there.last().unwrap_or_default();
    assert!(there_m > 1.05 * on_the_way_m, "{there_m} {on_the_way_m}");
    let least_m = strobe(&mut trim, 0.97);
    for _ in 0..100 {
        assert!(strobe(&mut trim, 0.48) < 1.021 * least_m);
    }
    assert_eq!(trim.limits(), ActiveLimits::TRAVEL);
    trim.expect(0.0, 4.0);
    let next = (0..100).map(|_| strobe(&mut trim, 0.48));
    assert_eq!(next.last(), Some(0.89e-3));
}

#[test]
fn what_is_doubted_comes_nearer_to_its_limit_and_nothing_further_away() {
    let settings = Settings::for_rig(&WIRES);
    let doubt = Doubt {
        force: 1.25,
        travel: 1.2,
        cart: 1.1,
    };
    let limited = |strobe: Strobe, wanted_m: f32| {
        let mut trim = Trim::new(&settings);
        trim.set_wanted_amplitude(wanted_m);
        trim.set_limits(&settings.limits, &doubt, false);
        run(&mut trim, 20, |m| Strobe {
            amplitude_m: m,
            contacts: 1,
            ..strobe
        });
        trim.limits()
    };
    let (n, m) = (settings.limits.force_n, settings.limits.travel_m);
    let force = |peak_n| Strobe {
        peak_n,
        ..Strobe::default()
    };
    let travel = |travel_m| Strobe {
        travel_m,
        ..Strobe::default()
    };
    assert_eq!(limited(force(0.81 * n), 0.89e-3), ActiveLimits::FORCE);
    assert_eq!(limited(force(0.79 * n), 0.89e-3), ActiveLimits::NONE);
    assert_eq!(limited(travel(0.84 * m), 0.89e-3), ActiveLimits::TRAVEL);
    assert_eq!(limited(travel(0.82 * m), 0.89e-3), ActiveLimits::NONE);
    let most_m = settings.limits.amplitude_m;
    let still = Strobe::default();
    assert_eq!(limited(still, 0.92 * most_m), ActiveLimits::AMPLITUDE);
    assert_eq!(limited(still, 0.9 * most_m), ActiveLimits::NONE);
    // A cart that reads a tenth less, of a shaker that makes a tenth more of its command.
    let mut trim = Trim::new(&settings);
    trim.set_wanted_amplitude(most_m);
    trim.set_limits(&settings.limits, &doubt, false);
    let command = run(&mut trim, 100, |m| Strobe {
        amplitude_m: m,
        ..still
    });
    assert!((command * 1.1 / most_m - 1.0).abs() < 1e-3, "{command}");
}

#[test]
fn by_hand_a_part_of_the_limits_of_force_and_travel_is_left() {
    let settings = Settings::for_rig(&WIRES);
    let (n, m) = (settings.limits.force_n, settings.limits.travel_m);
    let none = Doubt {
        force: 1.0,
        travel: 1.0,
        cart: 1.0,
    };
    for (by_hand, force, travel) in [(false, 0.99, 0.99), (true, 0.96, 0.91)] {
        for (peak_n, travel_m, limited) in [
            (force * n, travel * m, ActiveLimits::NONE),
            ((force + 0.02) * n, 0.0, ActiveLimits::FORCE),
            (0.0, (travel + 0.02) * m, ActiveLimits::TRAVEL),
        ] {
            let mut trim = Trim::new(&settings);
            trim.set_limits(&settings.limits, &none, by_hand);
            run(&mut trim, 5, |amplitude_m| Strobe {
                amplitude_m,
                contacts: 1,
                peak_n,
                travel_m,
                ..Strobe::default()
            });
            assert_eq!(trim.limits(), limited, "{by_hand} {peak_n} {travel_m}");
        }
    }
}

/// The amplitude over A0 after each of so many drive periods with a force of `over` times the limit.
fn shares(over: f32, periods: usize) -> std::vec::Vec<f32> {
    let settings = Settings::for_rig(&WIRES);
    let mut trim = Trim::new(&settings);
    let strobe = |command_m: f32| Strobe {
        amplitude_m: command_m,
        contacts: 1,
        peak_n: over * settings.limits.force_n,
        ..Strobe::default()
    };
    (0..periods)
        .map(|_| run(&mut trim, 1, strobe) / 0.89e-3)
        .collect()
}

#[test]
fn a_force_far_above_the_limit_is_answered_every_other_period_and_one_just_above_every_fifth() {
    for (over, every) in [(1.05, 5), (1.3, 2)] {
        let shares = shares(over, 11);
        for (period, share) in shares.iter().enumerate() {
            let wanted = libm::powf(over, -(1.0 + (period / every) as f32));
            assert!((share - wanted).abs() < 1e-3, "{over}: {shares:?}");
        }
    }
    assert_eq!(shares(0.99, 10), [1.0; 10]);
}

#[test]
fn travel_above_its_limit_draws_the_amplitude_back_too_and_it_returns_by_a_hundredth_a_period() {
    let settings = Settings::for_rig(&WIRES);
    let mut trim = Trim::new(&settings);
    let travel = |over: f32| {
        move |command_m: f32| Strobe {
            amplitude_m: command_m,
            contacts: 1,
            travel_m: over * settings.limits.travel_m,
            ..Strobe::default()
        }
    };
    let low = run(&mut trim, 1, travel(1.5)) / 0.89e-3;
    assert!((low - 1.0 / 1.5).abs() < 1e-3, "{low}");
    assert_eq!(trim.limits(), ActiveLimits::TRAVEL);
    // The hammer needs four periods to respond, and close to the limit nothing moves.
    let held = run(&mut trim, 4, travel(0.5)) / 0.89e-3;
    assert!((held - low).abs() < 1e-4, "{held}");
    let held = run(&mut trim, 10, travel(0.97)) / 0.89e-3;
    assert!((held - low).abs() < 1e-4, "{held}");
    let back = run(&mut trim, 10, travel(0.9)) / 0.89e-3;
    assert!((back / low - libm::powf(1.01, 10.0)).abs() < 1e-3, "{back}");
}

#[test]
fn a_cart_that_moves_too_far_is_corrected_at_once_and_under_suspicion_only_downwards() {
    let after = |response: f32, closed: bool| {
        let mut trim = Trim::new(&Settings::for_rig(&WIRES));
        let strobe = Strobe {
            amplitude_m: response * 0.89e-3,
            contacts: 1,
            ..Strobe::default()
        };
        trim.strobe(&strobe, 0.89e-3, 4.0, (closed, true), Some(0.0));
        trim.command() / 0.89e-3
    };
    for closed in [false, true] {
        assert!((after(1.5, closed) - 1.0 / 1.5).abs() < 1e-3);
        assert!((after(1.05, closed) - 0.99).abs() < 1e-3);
    }
    assert!((after(0.9, true) - 1.02).abs() < 1e-3);
    assert_eq!(after(0.9, false), 1.0);
}

#[test]
fn a_surge_is_one_against_the_amplitude_that_the_limits_leave() {
    let settings = Settings::for_rig(&WIRES);
    let mut trim = Trim::new(&settings);
    trim.expect(1.5 * settings.limits.force_n, 3.66);
    let command_m = trim.command();
    assert!(!trim.surge(1.2 * command_m, command_m));
    assert!(trim.surge(1.3 * command_m, command_m));
    // Seven tenths of the command that makes the amplitude: the motion still grows.
    let answer = trim.command() / command_m;
    assert!((answer - 0.7 / 1.3).abs() < 1e-3, "{answer}");
}

/// What a limit took comes back on evidence alone: without contact, as far as the forecast keeps the limit.
#[test]
fn without_contact_the_amplitude_returns_no_further_than_the_forecast_allows() {
    let settings = Settings::for_rig(&WIRES);
    let blind = |trim: &mut Trim, nominal_n: Option<f32>| {
        for _ in 0..4000 {
            let strobe = Strobe {
                amplitude_m: trim.command(),
                ..Strobe::default()
            };
            trim.strobe(&strobe, strobe.amplitude_m, 4.0, (true, true), nominal_n);
        }
        trim.command() / trim.wanted_m()
    };
    let drawn = || {
        let mut trim = Trim::new(&settings);
        trim.expect(4.0 * settings.limits.force_n, 3.66);
        trim
    };
    assert!((drawn().command() / 0.89e-3 - 0.225).abs() < 1e-4);
    assert!((blind(&mut drawn(), None) - 0.225).abs() < 1e-4);
    let twice = Some(2.0 * settings.limits.force_n);
    assert!((blind(&mut drawn(), twice) - 0.45).abs() < 1e-4);
    assert!((blind(&mut drawn(), Some(0.5 * settings.limits.force_n)) - 1.0).abs() < 1e-4);
    // Nor does it stay above.
    let mut full = Trim::new(&settings);
    assert!((blind(&mut full, twice) - 0.45).abs() < 1e-4);
    assert_eq!(full.limits(), ActiveLimits::FORCE);
}
