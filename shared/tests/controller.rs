//! The controller against whatever may come: spoilt samples, senseless commands, any order of them.

use proptest::prelude::*;
use shared::control::{
    BootInfo, Command, Controller, MAX_BLOCK, Mode, Refused, ResetCause, SettingsState, State,
};
use shared::fault::{Fault, Record};
use shared::forecast::{Forecast, Orbit, Row, Target};
use shared::io::{AdcCode, Frame, Output};
use shared::model::params::WIRES;
use shared::model::regime::Regime;
use shared::settings::{Settings, TICK_RATE_HZ};

/// A forecast of a 1/1 about 3.6 Hz.
fn forecast(id: u32) -> Forecast {
    let orbit = Orbit {
        force_n: 96.0,
        impulse_n_s: 0.031,
        approach_m_per_s: 0.08,
        onset_turns: 0.4,
        trace: -0.3,
        determinant: 0.1,
    };
    let rows = [2.0, 3.0, 4.0, 5.0].map(|frequency_hz| Row {
        frequency_hz,
        regime: Regime::Periodic {
            impacts: 1,
            periods: 1,
        },
        force_n: 90.0,
        orbit: Some(orbit),
    });
    Forecast {
        id,
        rows: rows.into_iter().collect(),
        target: Some(Target {
            frequency_hz: 3.6,
            orbit,
            band_hz: (2.5, 4.8),
            doubling_hz: Some(4.8),
            entry_hz: 3.6,
        }),
    }
}

/// What happens in a block.
#[derive(Clone, Debug)]
enum Happening {
    /// Samples of a rig that moves as told, with noise of so many codes.
    Sound { noise: u16 },
    /// Samples with pulses of force, codes above zero.
    Striking { code: u16 },
    /// Any codes.
    Wild { codes: [u16; 3] },
    /// The emergency chain opens.
    Emergency,
    /// No samples.
    Blind,
    /// An overrun.
    Overrun,
    /// A command.
    Told(Command),
}

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
        1 => Just(Command::Acknowledge),
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

/// The controller with the little of a rig it needs: a cart that goes where it is told.
struct Bench {
    settings: Settings,
    controller: Controller,
    outputs: [Output; MAX_BLOCK],
    noise: u32,
}

impl Bench {
    fn new() -> Self {
        let settings = Settings::for_rig(&WIRES);
        Self {
            settings,
            controller: Controller::new(&settings, &BootInfo::STORED).unwrap(),
            outputs: [Output::SAFE; MAX_BLOCK],
            noise: 1,
        }
    }

    fn random(&mut self, below: u16) -> u16 {
        self.noise = self
            .noise
            .wrapping_mul(1_664_525)
            .wrapping_add(1_013_904_223);
        if below == 0 {
            0
        } else {
            (self.noise >> 16) as u16 % below
        }
    }

    fn frame(&mut self, output: Output, happening: &Happening) -> Frame {
        // The cart's sensor has about the shaker's scale: 1900 against 2047 codes for 2.5 mm.
        let cart = (f32::from(output.dac.0) - 2048.0) * 1900.0 / 2047.0;
        let (noise, push) = match happening {
            Happening::Sound { noise } => (*noise, 0),
            Happening::Striking { code } => (3, *code),
            _ => (3, 0),
        };
        let mut sound = Frame {
            force: AdcCode(600 + push + self.random(noise + 1)),
            // The hammer goes with the cart; its sensor reads 4.8 times as far.
            hammer: AdcCode((2048.0 + cart / 4.8) as u16 + self.random(noise + 1)),
            cart: AdcCode((2048.0 + cart) as u16 + self.random(noise + 1)),
            emergency: false,
        };
        match happening {
            Happening::Wild { codes } => {
                [sound.force, sound.hammer, sound.cart] = codes.map(AdcCode);
            }
            Happening::Emergency => sound.emergency = true,
            _ => {}
        }
        sound
    }

    fn block(&mut self, ticks: usize, happening: &Happening) -> Vec<Frame> {
        let outputs = self.outputs;
        let frames: Vec<Frame> = outputs[..ticks]
            .iter()
            .map(|output| self.frame(*output, happening))
            .collect();
        match happening {
            Happening::Blind => self.controller.blind_block(&mut self.outputs[..ticks]),
            _ => self.controller.block(&frames, &mut self.outputs[..ticks]),
        }
        if let Happening::Overrun = happening {
            self.controller.note_overrun();
        }
        if let Happening::Told(command) = happening {
            let _ = self.controller.command(*command);
        }
        while self.controller.take_event().is_some() {}
        if let Some(request) = self.controller.forecast_request() {
            self.controller.deliver(&forecast(request.id));
        }
        frames
    }

    /// Blocks of a sound rig until `state`, at most `seconds`.
    fn reaches(&mut self, state: State, seconds: u32) -> bool {
        for _ in 0..seconds * TICK_RATE_HZ / 10 {
            self.block(10, &Happening::Sound { noise: 4 });
            if self.controller.state() == state {
                return true;
            }
        }
        false
    }
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

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, failure_persistence: None, ..ProptestConfig::default() })]

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
        // Whatever has happened: with a sound rig, it can be stopped, cleared and started again.
        let _ = bench.controller.command(Command::Stop);
        let stopped = bench.reaches(State::Idle, 3) || bench.controller.state() == State::Fault;
        prop_assert!(stopped, "{:?}", bench.controller.status());
        if bench.controller.state() == State::Fault {
            prop_assert_eq!(bench.controller.command(Command::ClearFault), Ok(()));
        }
        prop_assert_eq!(bench.controller.command(Command::Start(Mode::Manual)), Ok(()));
        prop_assert!(bench.reaches(State::Manual, 60), "{:?}", bench.controller.status());
    }
}

/// The faults of the present episode.
fn episode(controller: &Controller) -> Vec<Fault> {
    let record = controller.status().fault;
    record.map_or(vec![], |record| record.episode.faults().collect())
}

#[test]
fn why_the_board_started_is_taken_account_of() {
    let settings = Settings::for_rig(&WIRES);
    let record = Record::new(Fault::OverForce, Default::default(), 7, 400.0, 3.6);
    let born = |boot: BootInfo| {
        let controller = Controller::new(&settings, &boot).unwrap();
        (
            controller.state(),
            controller.status().fault.map(|r| r.fault),
        )
    };
    let kept = |reset, record| BootInfo {
        reset,
        record,
        settings: SettingsState::Stored,
    };
    assert_eq!(born(BootInfo::STORED), (State::Idle, None));
    let after = |cause| born(kept(cause, Some(record)));
    assert_eq!(
        after(ResetCause::Pin),
        (State::Fault, Some(Fault::OverForce))
    );
    // What the start itself is joins the episode and weakens nothing.
    for (cause, fault) in [
        (ResetCause::Watchdog, Fault::WatchdogReset),
        (ResetCause::BrownOut, Fault::BrownOut),
    ] {
        assert_eq!(after(cause), (State::Fault, Some(Fault::OverForce)));
        let boot = kept(cause, Some(record));
        let mut controller = Controller::new(&settings, &boot).unwrap();
        assert_eq!(episode(&controller), [Fault::OverForce, fault]);
        assert!(controller.command(Command::Start(Mode::Manual)).is_err());
        let again = kept(ResetCause::Pin, controller.persisted().record());
        let again = Controller::new(&settings, &again).unwrap();
        assert_eq!(episode(&again), [Fault::OverForce, fault]);
        assert_eq!(again.state(), State::Fault);
    }
    // Without an episode that latches, the start is all there is.
    let silent = Record::new(Fault::LinkTimeout, Default::default(), 7, 2.0, 3.6);
    for record in [None, Some(silent)] {
        let brown_out = kept(ResetCause::BrownOut, record);
        assert_eq!(born(brown_out), (State::Idle, Some(Fault::BrownOut)));
        let watchdog = kept(ResetCause::Watchdog, record);
        assert_eq!(born(watchdog), (State::Fault, Some(Fault::WatchdogReset)));
    }
    let corrupt = BootInfo {
        settings: SettingsState::Damaged,
        ..BootInfo::STORED
    };
    assert_eq!(born(corrupt), (State::Fault, Some(Fault::CorruptSettings)));
}

#[test]
fn after_damaged_settings_nothing_runs_until_new_ones_are_sent() {
    let settings = Settings::for_rig(&WIRES);
    let boot = BootInfo {
        settings: SettingsState::Damaged,
        ..BootInfo::STORED
    };
    let mut controller = Controller::new(&settings, &boot).unwrap();
    let clear = Command::ClearFault;
    let refused = Err(Refused::SettingsUnknown(SettingsState::Damaged));
    assert_eq!(controller.command(clear), refused);
    controller.replace_settings(&settings).unwrap();
    assert_eq!(controller.state(), State::Fault);
    // Under the new settings the samples have to show that nothing stands.
    assert_eq!(controller.command(clear), Err(Refused::StillFaulty));
    let quiet = Frame {
        force: AdcCode(600),
        hammer: AdcCode(2048),
        cart: AdcCode(2048),
        emergency: false,
    };
    controller.block(&[quiet; 10], &mut [Output::SAFE; 10]);
    assert_eq!(controller.command(clear), Ok(()));
}

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
        moves(&mut bench, 3);
        assert_eq!(clear(&mut bench), Err(Refused::StillFaulty));
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
fn a_link_heard_again_ends_its_own_timeout_and_no_other_fault_of_the_episode() {
    for chain_opens in [false, true] {
        let mut bench = Bench::new();
        let sound = Happening::Sound { noise: 2 };
        bench
            .controller
            .command(Command::Start(Mode::Manual))
            .unwrap();
        bench.controller.command(Command::Alive).unwrap();
        assert!(bench.reaches(State::Fault, 10));
        assert_eq!(episode(&bench.controller), [Fault::LinkTimeout]);
        if chain_opens {
            // Pressed and released while the link is away.
            bench.block(10, &Happening::Emergency);
        }
        for _ in 0..100 {
            bench.block(10, &sound);
        }
        bench.controller.command(Command::Alive).unwrap();
        let start = bench.controller.command(Command::Start(Mode::Manual));
        if !chain_opens {
            assert_eq!((bench.controller.state(), start), (State::SelfTest, Ok(())));
            continue;
        }
        assert_eq!(start, Err(Refused::WrongState));
        assert_eq!(bench.controller.state(), State::Fault);
        let both = [Fault::EmergencyStop, Fault::LinkTimeout];
        assert_eq!(episode(&bench.controller), both);
        let record = bench.controller.persisted().record().unwrap();
        assert_eq!(record.fault, Fault::EmergencyStop);
        assert_eq!(bench.controller.command(Command::ClearFault), Ok(()));
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

#[test]
fn a_silent_link_in_command_stops_the_drive_and_a_link_heard_again_releases_it() {
    let mut bench = Bench::new();
    bench.controller.command(Command::Alive).unwrap();
    bench
        .controller
        .command(Command::Start(Mode::Manual))
        .unwrap();
    let mut driven = 0;
    for _ in 0..60 * 2000 {
        bench.block(10, &Happening::Sound { noise: 2 });
        if bench.controller.state() == State::Manual {
            break;
        }
        let _ = bench.controller.command(Command::Alive);
    }
    assert_eq!(bench.controller.state(), State::Manual);
    while bench.controller.state() == State::Manual && driven < 100_000 {
        bench.block(10, &Happening::Sound { noise: 2 });
        driven += 10;
    }
    let fault = bench.controller.status().fault.map(|r| r.fault);
    assert_eq!(fault, Some(Fault::LinkTimeout));
    assert!((40_000..=40_020).contains(&driven), "2 s: {driven}");
    bench.controller.command(Command::Alive).unwrap();
    assert_eq!(bench.controller.state(), State::Idle);

    // Started again by hand at the board, nobody on the link need say anything.
    let start = Command::Start(Mode::Manual);
    bench.controller.command(start).unwrap();
    assert!(bench.reaches(State::Manual, 60));
    assert!(!bench.reaches(State::Fault, 4));
}
