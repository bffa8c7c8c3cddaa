//! Faults: what trips, and what must go before they can be cleared.

use shared::control::{Command, Refused, State};
use shared::fault::Fault;
use shared::io::{AdcCode, Frame};
use shared::settings::TICK_RATE_HZ;

use crate::bench::{Bench, Happening, episode, forecast};

#[test]
fn a_cart_that_moves_with_the_drive_off_is_a_fault_that_stands_until_it_rests() {
    // Units of A0: a tenth above the threshold of an eighth, and a tenth below.
    for (share, expected) in [(0.137, vec![Fault::NotOff]), (0.113, vec![])] {
        let mut bench = Bench::new();
        let moves = |bench: &mut Bench, seconds: u32| {
            for _ in 0..seconds * 2000 {
                let frames: [Frame; 10] = core::array::from_fn(|k| {
                    let tick = bench.controller.status().tick + k as u32;
                    let turns = 3.66 * f64::from(tick) / f64::from(TICK_RATE_HZ);
                    let m = share * 0.89e-3 * (std::f64::consts::TAU * turns).sin();
                    let code = |unit: f32| AdcCode((2048.5 + m / f64::from(unit)).floor() as u16);
                    // The hammer goes along.
                    Frame {
                        force: AdcCode(600),
                        hammer: code(bench.settings.hammer.unit_per_code),
                        cart: code(bench.settings.cart.unit_per_code),
                        emergency: false,
                    }
                });
                bench.controller.block(&frames, &mut bench.outputs[..10]);
            }
        };
        moves(&mut bench, 4);
        assert_eq!(episode(&bench.controller), expected, "{share}");
        if expected.is_empty() {
            continue;
        }
        let clear = |bench: &mut Bench| bench.controller.command(Command::ClearFault);
        assert_eq!(clear(&mut bench), Err(Refused::StillFaulty));
        let settings = bench.settings;
        bench.controller.replace_settings(&settings).unwrap();
        // New settings know nothing of the cart yet: that is no standstill.
        for _ in 0..3 {
            moves(&mut bench, 1);
            assert_eq!(clear(&mut bench), Err(Refused::StillFaulty));
        }
        for _ in 0..6000 {
            bench.block(10, &Happening::Sound { noise: 2 });
        }
        assert_eq!(clear(&mut bench), Ok(()));
    }
}

#[test]
fn new_settings_do_not_make_a_condition_go_away() {
    for happening in [
        Happening::Emergency,
        // Open, and at a rail: twenty ticks, longer than a block.
        Happening::Wild {
            codes: [600, 2048, 0],
        },
        Happening::Wild {
            codes: [100, 2048, 2048],
        },
    ] {
        let mut bench = Bench::new();
        let settings = bench.settings;
        for _ in 0..3 {
            bench.block(10, &happening);
        }
        assert_eq!(bench.controller.state(), State::Fault, "{happening:?}");
        let clear = |bench: &mut Bench| bench.controller.command(Command::ClearFault);
        for _ in 0..4 {
            bench.controller.replace_settings(&settings).unwrap();
            assert_eq!(clear(&mut bench), Err(Refused::StillFaulty));
            bench.block(10, &happening);
            assert_eq!(
                clear(&mut bench),
                Err(Refused::StillFaulty),
                "{happening:?}"
            );
        }
        // No samples: nothing is known.
        bench.controller.replace_settings(&settings).unwrap();
        bench.block(10, &Happening::Blind);
        assert_eq!(clear(&mut bench), Err(Refused::StillFaulty));
        for _ in 0..9 {
            bench.block(10, &Happening::Sound { noise: 2 });
        }
        assert_eq!(clear(&mut bench), Ok(()), "{happening:?}");
    }
}

#[test]
fn a_replacement_of_the_settings_keeps_time_counts_and_the_fault() {
    let mut bench = Bench::new();
    bench.block(10, &Happening::Overrun);
    bench.block(10, &Happening::Emergency);
    bench.block(10, &Happening::Sound { noise: 2 });
    let before = bench.controller.status();
    assert_eq!((before.tick, before.overruns), (30, 1));
    let mut settings = bench.settings;
    settings.limits.travel_m *= 0.9;
    bench.controller.replace_settings(&settings).unwrap();
    let after = bench.controller.status();
    assert_eq!((after.tick, after.overruns), (30, 1));
    assert_eq!((after.state, after.fault), (before.state, before.fault));
    assert_eq!(*bench.controller.settings(), settings);
    // The forecast is of the old settings: a new one is requested, under the next number.
    assert_eq!((before.target_hz, after.target_hz), (3.6, 0.0));
    let request = bench.controller.forecast_request().unwrap();
    bench.controller.deliver(&forecast(request.id - 1));
    assert_eq!(bench.controller.status().target_hz, 0.0);
    bench.controller.deliver(&forecast(request.id));
    assert_eq!(bench.controller.status().target_hz, 3.6);
}

#[test]
fn a_fault_whose_cause_is_there_cannot_be_cleared() {
    let mut bench = Bench::new();
    bench.block(10, &Happening::Emergency);
    assert_eq!(bench.controller.state(), State::Fault);
    let clear = |bench: &mut Bench| bench.controller.command(Command::ClearFault);
    assert_eq!(clear(&mut bench), Err(Refused::StillFaulty));
    bench.block(10, &Happening::Sound { noise: 2 });
    assert_eq!(clear(&mut bench), Ok(()));
    assert_eq!(bench.controller.state(), State::Idle);
}

#[test]
fn overruns_and_missing_blocks_trip_when_three_come_in_a_row_and_not_one_in_six() {
    for (fault, happening) in [
        (Fault::Overrun, Happening::Overrun),
        (Fault::StaleSamples, Happening::Blind),
    ] {
        let mut bench = Bench::new();
        let sound = Happening::Sound { noise: 2 };
        for _ in 0..50 {
            bench.block(10, &happening);
            for _ in 0..5 {
                bench.block(10, &sound);
            }
        }
        assert_eq!(bench.controller.state(), State::Idle, "{fault:?}");
        let blocks = (1..10).find(|_| {
            bench.block(10, &happening);
            bench.controller.state() == State::Fault
        });
        assert_eq!(blocks, Some(3), "{fault:?}");
        assert_eq!(
            bench.controller.status().fault.map(|r| r.fault),
            Some(fault)
        );
    }
}
