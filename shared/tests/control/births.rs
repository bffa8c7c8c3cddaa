//! What the controller makes of why and with what the board started.

use shared::control::{
    BootInfo, Command, Controller, Mode, Refused, ResetCause, SettingsState, State, Unfit,
};
use shared::fault::{Fault, FaultRecord};
use shared::io::{AdcCode, Frame, Output};
use shared::model::params::WIRES;
use shared::settings::Settings;

use crate::bench::episode;

#[test]
fn what_says_nothing_of_settings_drives_nothing() {
    let settings = Settings::for_rig(&WIRES);
    let mut controller = Controller::new(&settings, &BootInfo::default()).unwrap();
    assert_eq!(episode(&controller), [Fault::CorruptSettings]);
    let start = controller.command(Command::Start(Mode::Manual));
    let missing = Refused::SettingsUnknown(SettingsState::Missing);
    assert_eq!(start, Err(missing));
}

#[test]
fn why_the_board_started_is_taken_account_of() {
    let settings = Settings::for_rig(&WIRES);
    let record = FaultRecord::new(Fault::OverForce, Default::default(), 7, 400.0, 3.6);
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
        ..BootInfo::STORED
    };
    assert_eq!(born(BootInfo::STORED), (State::Idle, None));
    let after = |cause| born(kept(cause, Some(record)));
    assert_eq!(
        after(ResetCause::Pin),
        (State::Fault, Some(Fault::OverForce))
    );
    // What the start itself is joins the episode and weakens nothing.
    let boot_faults = [
        (ResetCause::Watchdog, Fault::WatchdogReset),
        (ResetCause::BrownOut, Fault::BrownOut),
        (ResetCause::WhileDriving, Fault::ResetWhileDriving),
    ];
    for (cause, fault) in boot_faults {
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
    let silent = FaultRecord::new(Fault::LinkTimeout, Default::default(), 7, 2.0, 3.6);
    for record in [None, Some(silent)] {
        for (cause, fault) in boot_faults {
            assert_eq!(born(kept(cause, record)), (State::Fault, Some(fault)));
        }
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
fn a_board_that_is_not_fit_drives_nothing_until_it_is_started_fit() {
    let settings = Settings::for_rig(&WIRES);
    let quiet = Frame {
        force: AdcCode(600),
        hammer: AdcCode(2048),
        cart: AdcCode(2048),
        emergency: false,
    };
    let unfit = BootInfo {
        unfit: Unfit::CLOCK.and(Unfit::REFERENCE),
        ..BootInfo::STORED
    };
    let mut controller = Controller::new(&settings, &unfit).unwrap();
    controller.block(&[quiet; 10], &mut [Output::SAFE; 10]);
    let record = *controller.fault().unwrap();
    assert_eq!((record.fault, record.value), (Fault::BoardUnfit, 9.0));
    // Neither clearing nor new settings help.
    let clear = Command::ClearFault;
    assert_eq!(controller.command(clear), Err(Refused::StillFaulty));
    controller.replace_settings(&settings).unwrap();
    controller.block(&[quiet; 10], &mut [Output::SAFE; 10]);
    assert_eq!(controller.command(clear), Err(Refused::StillFaulty));
    assert!(controller.command(Command::Start(Mode::Manual)).is_err());
    // Without settings both are in the episode, and the settings are named.
    let neither = BootInfo {
        settings: SettingsState::Missing,
        ..unfit
    };
    let neither = Controller::new(&settings, &neither).unwrap();
    let both = [Fault::CorruptSettings, Fault::BoardUnfit];
    assert_eq!(episode(&neither), both);
    // Fit again after a reset: the record is still there, and can be cleared.
    let again = BootInfo {
        record: Some(record),
        ..BootInfo::STORED
    };
    let mut again = Controller::new(&settings, &again).unwrap();
    assert_eq!(again.state(), State::Fault);
    again.block(&[quiet; 10], &mut [Output::SAFE; 10]);
    assert_eq!(again.command(clear), Ok(()));
}
