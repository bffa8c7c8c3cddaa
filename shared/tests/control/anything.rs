//! The controller against whatever may come: spoilt samples, senseless commands, any order of them.

use proptest::prelude::*;
use shared::control::{Command, MAX_BLOCK, Mode, State};
use shared::io::{Frame, Output};
use shared::settings::Settings;

use crate::bench::{Bench, Happening};

fn command() -> impl Strategy<Value = Command> {
    let any_f32 = prop_oneof![
        Just(f32::NAN),
        Just(f32::INFINITY),
        Just(-1.0_f32),
        0.0_f32..20.0,
        any::<f32>()
    ];
    prop_oneof![
        3 => Just(Command::Start(Mode::Automatic)),
        3 => Just(Command::Start(Mode::Manual)),
        1 => Just(Command::Stop),
        3 => Just(Command::ClearFault),
        1 => Just(Command::Alive),
        1 => any::<bool>().prop_map(|opened| Command::Acknowledge { opened }),
        1 => Just(Command::ConfirmSettings),
        3 => (any_f32.clone(), any_f32.prop_map(|x| x * 1e-3)).prop_map(
            |(frequency_hz, amplitude_m)| Command::SetPoint { frequency_hz, amplitude_m }
        ),
    ]
}

fn happening() -> impl Strategy<Value = Happening> {
    prop_oneof![
        30 => (0_u16..20).prop_map(|noise| Happening::Sound { noise }),
        10 => (50_u16..3000).prop_map(|code| Happening::Striking { code }),
        1 => any::<[u16; 3]>().prop_map(|codes| Happening::Wild { codes }),
        1 => Just(Happening::Emergency),
        2 => Just(Happening::Blind),
        2 => Just(Happening::Overrun),
        10 => command().prop_map(Happening::Told),
    ]
}

/// Whether a run of two samples is above the force trip level.
fn over_force(settings: &Settings, frames: &[Frame]) -> bool {
    let over = |frame: &Frame| settings.force.value(frame.force) > settings.trips.force_n;
    frames
        .windows(2)
        .any(|pair| over(&pair[0]) && over(&pair[1]))
}

/// Whether four samples in a row have the hammer or the cart beyond a trip level.
fn over_travel(settings: &Settings, frames: &[Frame]) -> bool {
    let hammer = |f: &Frame| {
        let relative = settings.hammer.value(f.hammer) - settings.cart.value(f.cart);
        relative.abs() > settings.trips.travel_m
    };
    let cart = |f: &Frame| settings.cart.value(f.cart).abs() > settings.trips.cart_m;
    let readable = |f: &Frame| f.hammer.0 > 40 && f.cart.0 > 40;
    frames.windows(4).any(|four| {
        four.iter().all(|f| readable(f) && hammer(f)) || four.iter().all(|f| readable(f) && cart(f))
    })
}

/// Whatever has happened: with a sound rig, it can be stopped, cleared and started again.
fn starts_again(bench: &mut Bench) -> Result<(), TestCaseError> {
    let _ = bench.controller.command(Command::Stop);
    let stopped = bench.reaches(State::Idle, 3) || bench.controller.state() == State::Fault;
    prop_assert!(stopped, "{:?}", bench.controller.status());
    if bench.controller.state() == State::Fault {
        prop_assert_eq!(bench.controller.command(Command::ClearFault), Ok(()));
    }
    let started = bench.controller.command(Command::Start(Mode::Manual));
    prop_assert_eq!(started, Ok(()));
    prop_assert!(
        bench.reaches(State::Manual, 60),
        "{:?}",
        bench.controller.status()
    );
    Ok(())
}

/// What two samples in a row reached of it was next to nothing, and so was the trip level then.
#[test]
fn a_contact_of_one_sample_leaves_the_trip_level_of_the_force() {
    let mut bench = Bench::new();
    let codes = [40_200, 0, 0];
    bench.block(1, &Happening::Wild { codes });
    for _ in 0..51 {
        bench.block(1, &Happening::Striking { code: 50 });
    }
    starts_again(&mut bench).unwrap();
}

proptest! {
    #![proptest_config(ProptestConfig { cases: if std::env::var_os("LONG_CHECKS").is_some() { 2000 } else { 500 }, failure_persistence: None, ..ProptestConfig::default() })]

    /// Set-points are always within the limits; a block whose samples trip is followed by a safe one; the
    /// drive is on in the states that drive, and in no other.
    #[test]
    fn nothing_that_comes_makes_it_unsafe(
        blocks in prop::collection::vec((1_usize..=MAX_BLOCK, happening(), 1_u16..200), 1..60)
    ) {
        let mut bench = Bench::new();
        let largest = bench.settings.limits.amplitude_m / bench.settings.drive.m_per_code + 1.0;
        let limits = bench.settings.limits;
        for (ticks, happening, times) in blocks {
            let repeated = matches!(happening, Happening::Sound { .. } | Happening::Striking { .. });
            for _ in 0..if repeated { times } else { 1 } {
                let was_driving = bench.outputs[0].enable;
                let frames = bench.block(ticks, &happening);
                let state = bench.controller.state();
                let status = bench.controller.status();
                let outputs = &bench.outputs[..ticks];
                for output in outputs {
                    prop_assert!((f32::from(output.dac.0) - 2048.0).abs() <= largest);
                    prop_assert!(output.frequency_hz.is_finite());
                    if output.enable {
                        prop_assert!(output.frequency_hz >= limits.min_frequency_hz);
                        prop_assert!(output.frequency_hz <= limits.max_frequency_hz);
                    } else {
                        prop_assert_eq!(*output, Output::SAFE);
                    }
                }
                let tripped = frames.iter().any(|f| f.emergency)
                    || over_force(&bench.settings, &frames)
                    || (was_driving && over_travel(&bench.settings, &frames));
                if tripped && !matches!(happening, Happening::Blind) {
                    prop_assert!(outputs.iter().all(|output| !output.enable), "{:?}", status);
                }
                if matches!(state, State::Fault) {
                    prop_assert!(status.fault.is_some());
                }
                for number in [status.frequency_hz, status.amplitude_m, status.measured_amplitude_m,
                    status.lag_rad, status.peak_n, status.impulse_n_s, status.target_hz] {
                    prop_assert!(number.is_finite(), "{:?}", status);
                }
            }
        }
        starts_again(&mut bench)?;
    }
}
