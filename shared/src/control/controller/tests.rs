//! What the controller tells, and what it takes from forecasts and sensors.

use super::*;
use crate::control::phase::Seeking;
use crate::control::search::Search;
use crate::control::test_rig::{TestRig, target};
use crate::control::{Mode, ResetCause};
use crate::io::AdcCode;
use crate::model::params::WIRES;

#[test]
fn the_forecast_that_was_asked_for_last_is_reported_and_no_other() {
    let mut rig = TestRig::with(|_| {});
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
        let mut rig = TestRig::with(|_| {});
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
fn before_a_forecast_the_frequency_is_the_natural_one_within_the_limits() {
    let start_hz = |low_hz, high_hz| {
        let rig = TestRig::with(|settings| {
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
    let mut rig = TestRig::with(|settings| settings.operator.acknowledge = true);
    assert_eq!(rig.controller.fault(), None);
    assert!(!rig.controller.awaits_acknowledgement());
    rig.chain_open = true;
    rig.block();
    assert!(rig.controller.awaits_acknowledgement());
    let fault = rig.controller.fault().copied();
    assert_eq!(fault.map(|record| record.fault), Some(Fault::EmergencyStop));
    assert_eq!(fault, rig.controller.status().fault);
    rig.events();
    // Another one joins the episode, and its report names both.
    for _ in 0..3 {
        rig.controller.blind_block(&mut rig.outputs);
    }
    let episode = rig.controller.fault().map(|record| record.episode);
    let reported = rig.events().into_iter().find_map(|event| match event {
        EventKind::Fault(record) => Some(record),
        _ => None,
    });
    assert_eq!(
        reported.map(|record| record.fault),
        Some(Fault::StaleSamples)
    );
    assert_eq!(reported.map(|record| record.episode), episode);
    assert!(episode.is_some_and(|all| all.contains(Fault::EmergencyStop)));
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

#[test]
fn a_signal_that_stands_while_the_cart_moves_is_found_above_a_fifth_of_the_amplitude() {
    for (share, expected) in [(0.17, None), (0.23, Some(Fault::SensorFrozen))] {
        let mut rig = TestRig::with(|_| {});
        rig.starts(Mode::Manual, State::Manual);
        let amplitude_m = share * WIRES.amplitude_m as f32;
        let set_point = Command::SetPoint {
            frequency_hz: 3.0,
            amplitude_m,
        };
        rig.controller.command(set_point).unwrap();
        rig.pass(8.0);
        rig.hammer_stuck = Some(AdcCode(2050));
        // A drive period lasts a third of a second.
        rig.pass(0.4);
        let fault = rig.controller.fault().map(|record| record.fault);
        assert_eq!(fault, expected, "{share}");
    }
}
