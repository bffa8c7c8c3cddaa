//! The controller at a rig whose cart goes where it is told and whose hammer moves with it.

use super::*;
use crate::control::phase::Seeking;
use crate::control::search::Search;
use crate::control::{ActiveLimits, Mode, ResetCause};
use crate::forecast::{Orbit, Target};
use crate::io::AdcCode;
use crate::model::params::WIRES;
use std::vec::Vec;

/// A 1/1 at 3.6 Hz, entered at `entry_hz`.
fn target(entry_hz: f32) -> Target {
    Target {
        frequency_hz: 3.6,
        orbit: Orbit {
            force_n: 96.0,
            impulse_n_s: 0.031,
            approach_m_per_s: 0.08,
            onset_turns: 0.5,
            trace: -0.3,
            determinant: 0.1,
        },
        band_hz: (2.5, 4.8),
        doubling_hz: None,
        entry_hz,
    }
}

struct Rig {
    controller: Controller,
    outputs: [Output; 10],
    chain_open: bool,
    random: u32,
}

impl Rig {
    fn with(change: impl FnOnce(&mut Settings)) -> Self {
        let mut settings = Settings::for_rig(&WIRES);
        change(&mut settings);
        Self {
            controller: Controller::new(&settings, &BootInfo::default()).unwrap(),
            outputs: [Output::SAFE; 10],
            chain_open: false,
            random: 1,
        }
    }

    fn noise(&mut self) -> u16 {
        self.random = self
            .random
            .wrapping_mul(1_664_525)
            .wrapping_add(1_013_904_223);
        (self.random >> 16) as u16 % 4
    }

    fn block(&mut self) {
        let frames = self.outputs.map(|output| {
            // The cart's sensor has about the shaker's scale.
            let cart = (f32::from(output.dac.0) - 2048.0) * 1900.0 / 2047.0;
            Frame {
                force: AdcCode(600 + self.noise()),
                hammer: AdcCode((2048.0 + 0.3 * cart) as u16 + self.noise()),
                cart: AdcCode((2048.0 + cart) as u16 + self.noise()),
                emergency: self.chain_open,
            }
        });
        self.controller.block(&frames, &mut self.outputs);
    }

    fn pass(&mut self, seconds: f32) {
        for _ in 0..(2000.0 * seconds) as u32 {
            self.block();
        }
    }

    /// Answers the forecast that is asked for.
    fn forecast(&mut self, target: Option<Target>) {
        let request = self
            .controller
            .forecast_request()
            .expect("one is asked for");
        let id = request.id;
        self.controller.deliver(&Forecast {
            id,
            target,
            ..Forecast::default()
        });
    }

    fn starts(&mut self, mode: Mode, state: State) {
        self.controller.command(Command::Start(mode)).unwrap();
        for _ in 0..60 * 2000 {
            if self.controller.state() == state {
                return;
            }
            self.block();
        }
        panic!("{:?}", self.controller.status());
    }

    fn events(&mut self) -> Vec<EventKind> {
        core::iter::from_fn(|| self.controller.take_event())
            .map(|event| event.kind)
            .collect()
    }
}

#[test]
fn the_forecast_that_was_asked_for_last_is_reported_and_no_other() {
    let mut rig = Rig::with(|_| {});
    let id = rig.controller.forecast_request().unwrap().id;
    rig.events();
    let answer = |id| Forecast {
        id,
        target: Some(target(3.6)),
        ..Forecast::default()
    };
    rig.controller.deliver(&answer(id.wrapping_sub(1)));
    assert_eq!(rig.events(), []);
    rig.controller.deliver(&answer(id));
    let reported = EventKind::Forecast {
        target_hz: 3.6,
        force_n: 96.0,
    };
    assert_eq!(rig.events(), [reported]);
}

#[test]
fn a_new_forecast_counts_at_once_wherever_there_is_a_search() {
    let search = Search::new(&target(3.6), (1.4, 7.3), false);
    for phase in [
        Phase::Ramp(Some(search)),
        Phase::Seek(Seeking::new(search)),
        Phase::Hold(Seeking::new(search)),
    ] {
        let mut rig = Rig::with(|_| {});
        rig.forecast(Some(target(3.6)));
        rig.starts(Mode::Automatic, State::Ramp);
        assert_eq!(rig.controller.status().frequency_hz, 3.6);
        rig.controller.change(phase);
        rig.controller.request_forecast();
        rig.forecast(Some(target(3.5)));
        rig.pass(0.6);
        assert_eq!(
            rig.controller.status().frequency_hz,
            3.5,
            "{:?}",
            phase.state()
        );
    }
}

#[test]
fn set_points_are_taken_by_hand_only_and_held_within_the_limits() {
    let mut rig = Rig::with(|settings| settings.limits.max_frequency_hz = 4.0);
    let at = |frequency_hz, amplitude_m| Command::SetPoint {
        frequency_hz,
        amplitude_m,
    };
    let wrong = Err(Refused::WrongState);
    assert_eq!(rig.controller.command(at(3.0, 5e-4)), wrong, "in Idle");
    rig.forecast(Some(target(3.6)));
    rig.starts(Mode::Automatic, State::Ramp);
    assert_eq!(
        rig.controller.command(at(3.0, 5e-4)),
        wrong,
        "the search steers"
    );
    rig.controller.command(Command::Stop).unwrap();
    rig.pass(2.0);
    // On the way up already.
    rig.starts(Mode::Manual, State::Ramp);
    assert_eq!(rig.controller.command(at(3.0, 5e-4)), Ok(()));
    rig.pass(4.0);
    let status = rig.controller.status();
    assert_eq!((status.state, status.frequency_hz), (State::Manual, 3.0));
    assert!((status.amplitude_m / 5e-4 - 1.0).abs() < 0.02, "{status:?}");
    assert_eq!(status.limits, ActiveLimits::NONE);
    assert_eq!(rig.controller.command(at(9.0, 5e-4)), Ok(()));
    rig.pass(6.0);
    let status = rig.controller.status();
    assert_eq!(
        (status.frequency_hz, status.limits),
        (4.0, ActiveLimits::FREQUENCY)
    );
    for nonsense in [at(f32::NAN, 5e-4), at(3.0, f32::INFINITY)] {
        assert_eq!(rig.controller.command(nonsense), Err(Refused::NotANumber));
    }
    assert_eq!(rig.controller.status().state, State::Manual);
}

#[test]
fn without_a_forecast_a_start_waits_and_without_a_target_it_is_given_up() {
    let mut rig = Rig::with(|_| {});
    rig.controller
        .command(Command::Start(Mode::Automatic))
        .unwrap();
    rig.pass(5.0);
    assert_eq!(rig.controller.state(), State::SelfTest);
    rig.events();
    rig.forecast(None);
    rig.pass(2.0);
    assert_eq!(rig.controller.state(), State::Idle);
    assert!(rig.events().contains(&EventKind::NoTarget));
    assert!(rig.outputs.iter().all(|output| *output == Output::SAFE));

    // One that never comes is not waited for beyond two minutes.
    let mut rig = Rig::with(|_| {});
    rig.controller
        .command(Command::Start(Mode::Automatic))
        .unwrap();
    rig.pass(119.0);
    assert_eq!(rig.controller.state(), State::SelfTest);
    rig.pass(2.0);
    assert_eq!(rig.controller.state(), State::Idle);
}

#[test]
fn before_a_forecast_the_frequency_is_the_natural_one_within_the_limits() {
    let start_hz = |low_hz, high_hz| {
        let rig = Rig::with(|settings| {
            settings.limits.min_frequency_hz = low_hz;
            settings.limits.max_frequency_hz = high_hz;
        });
        rig.controller.status().frequency_hz
    };
    let natural_hz = WIRES.natural_frequency_hz() as f32;
    assert_eq!(start_hz(1.4, 7.3), natural_hz);
    assert_eq!(start_hz(2.5, 7.3), 2.5);
    assert_eq!(start_hz(1.0, 1.5), 1.5);
}

#[test]
fn it_tells_its_fault_where_its_settings_come_from_and_what_must_be_acknowledged() {
    let mut rig = Rig::with(|settings| settings.operator.acknowledge = true);
    assert_eq!(rig.controller.fault(), None);
    assert!(!rig.controller.awaits_acknowledgement());
    rig.chain_open = true;
    rig.block();
    assert!(rig.controller.awaits_acknowledgement());
    let fault = rig.controller.fault().copied();
    assert_eq!(fault.map(|record| record.fault), Some(Fault::EmergencyStop));
    assert_eq!(fault, rig.controller.status().fault);
    assert_eq!(rig.controller.settings_state(), SettingsState::Stored);
    let boot = BootInfo {
        reset: ResetCause::PowerOn,
        settings: SettingsState::OlderCopy,
        ..BootInfo::default()
    };
    let settings = Settings::for_rig(&WIRES);
    let mut older = Controller::new(&settings, &boot).unwrap();
    assert_eq!(older.settings_state(), SettingsState::OlderCopy);
    older.command(Command::ConfirmSettings).unwrap();
    assert_eq!(older.settings_state(), SettingsState::Stored);
}
