//! Starts, stops and set-points, and the times after which something is given up.

use super::*;
use crate::control::Command;
use crate::control::test_rig::{TestRig, target};
use crate::fault::Origin;
use crate::io::Output;
use crate::model::params::WIRES;

#[test]
fn set_points_are_taken_by_hand_only_and_held_within_the_limits() {
    let mut rig = TestRig::with(|settings| settings.limits.max_frequency_hz = 4.0);
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
    // In the proof of the sensors already: it comes into force after it.
    rig.starts(Mode::Manual, State::Prove);
    assert_eq!(rig.controller.command(at(2.5, 3e-4)), Ok(()));
    assert!(rig.controller.status().frequency_hz < 2.0);
    while rig.controller.state() == State::Prove {
        rig.block();
    }
    assert_eq!(rig.controller.status().frequency_hz, 2.5);
    rig.pass(8.0);
    let status = rig.controller.status();
    assert!((status.amplitude_m / 3e-4 - 1.0).abs() < 0.02, "{status:?}");
    rig.controller.command(Command::Stop).unwrap();
    rig.pass(2.0);
    rig.starts(Mode::Automatic, State::Prove);
    assert_eq!(rig.controller.command(at(2.5, 3e-4)), wrong);
    rig.controller.command(Command::Stop).unwrap();
    rig.pass(2.0);
    // Out of range in the proof already: as told as later.
    rig.starts(Mode::Manual, State::Prove);
    assert_eq!(rig.controller.command(at(1e9, 3e-4)), Ok(()));
    while rig.controller.state() == State::Prove {
        rig.block();
    }
    let status = rig.controller.status();
    assert_eq!(
        (status.frequency_hz, status.limits),
        (4.0, ActiveLimits::FREQUENCY)
    );
    rig.controller.command(Command::Stop).unwrap();
    rig.pass(2.0);
    // On the way up.
    rig.starts(Mode::Manual, State::Ramp);
    assert_eq!(rig.controller.command(at(3.0, 5e-4)), Ok(()));
    rig.pass(8.0);
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
    for no_motion in [at(-10.0, 5e-4), at(0.0, 5e-4), at(3.0, -5e-3)] {
        assert_eq!(rig.controller.command(no_motion), Err(Refused::NoMotion));
    }
    // What is more than the limit is taken as the limit, and the status says so until less is asked for.
    let limit_m = rig.controller.settings().limits.amplitude_m;
    rig.controller.command(at(3.0, 99e-3)).unwrap();
    rig.pass(6.0);
    let status = rig.controller.status();
    assert!(status.amplitude_m <= limit_m, "{status:?}");
    assert!(
        status.limits.contains(ActiveLimits::AMPLITUDE),
        "{status:?}"
    );
    rig.controller.command(at(3.0, 5e-4)).unwrap();
    rig.pass(6.0);
    assert_eq!(rig.controller.status().limits, ActiveLimits::NONE);
    assert_eq!(rig.controller.status().state, State::Manual);
}

#[test]
fn without_a_forecast_a_start_waits_and_without_a_target_it_is_given_up() {
    let mut rig = TestRig::with(|_| {});
    rig.controller
        .command(Command::Start(Mode::Automatic))
        .unwrap();
    rig.pass(5.0);
    assert_eq!(rig.controller.state(), State::Prove);
    rig.events();
    rig.forecast(None);
    rig.pass(2.0);
    assert_eq!(rig.controller.state(), State::Idle);
    assert!(rig.events().contains(&EventKind::NoTarget));
    assert_eq!(rig.outputs, [Output::SAFE; 10]);

    // Known before, the cart is not even moved; by hand it is.
    rig.controller
        .command(Command::Start(Mode::Automatic))
        .unwrap();
    while rig.controller.state() == State::SelfTest {
        rig.block();
        assert!(!rig.is_enabled());
    }
    assert_eq!(rig.controller.state(), State::Idle);
    rig.starts(Mode::Manual, State::Manual);

    // One that never comes is not waited for beyond two minutes.
    let mut rig = TestRig::with(|_| {});
    rig.controller
        .command(Command::Start(Mode::Automatic))
        .unwrap();
    rig.pass(119.0);
    assert_eq!(rig.controller.state(), State::Prove);
    rig.pass(5.0);
    assert_eq!(rig.controller.state(), State::Idle);
}

#[test]
fn the_motion_is_kept_small_until_the_cart_has_followed_it() {
    let a0_m = WIRES.amplitude_m as f32;
    let share = |rig: &TestRig| rig.controller.status().amplitude_m / a0_m;
    // Up to half of the amplitude, until the cart is known to follow.
    let mut rig = TestRig::with(|_| {});
    rig.starts(Mode::Manual, State::Prove);
    rig.block();
    // Far below the natural frequency the cart takes the hammer along.
    let r = rig.controller.status().frequency_hz / WIRES.natural_frequency_hz() as f32;
    assert!((r - 1.0 / 3.0).abs() < 1e-3, "{r}");
    let mut largest = 0.0_f32;
    while rig.controller.state() == State::Prove {
        largest = largest.max(share(&rig));
        rig.block();
    }
    assert_eq!(rig.controller.state(), State::Ramp);
    assert!((largest - 0.5).abs() < 0.01, "{largest}");
    while rig.controller.state() == State::Ramp {
        rig.block();
    }
    assert_eq!(rig.controller.state(), State::Manual);
    assert!((share(&rig) - 1.0).abs() < 0.03, "{}", share(&rig));

    // A cart that does not move is driven no further, and found.
    let mut rig = TestRig::with(|_| {});
    rig.cart_gain = 0.0;
    rig.starts(Mode::Manual, State::Prove);
    let mut largest = 0.0_f32;
    for _ in 0..10_000 {
        largest = largest.max(share(&rig));
        rig.block();
    }
    assert!((largest - 0.5).abs() < 0.01, "{largest}");
    let fault = rig
        .controller
        .fault()
        .map(|record| (record.fault, record.origin));
    assert_eq!(fault, Some((Fault::SensorOutOfFamily, Origin::Cart)));
}

#[test]
fn a_stop_ramps_down_before_the_drive_goes_off_and_does_nothing_where_it_is_off() {
    let mut rig = TestRig::with(|_| {});
    rig.controller.command(Command::Stop).unwrap();
    assert_eq!(rig.controller.state(), State::Idle);
    rig.block();
    assert_eq!(
        (rig.controller.state(), rig.is_enabled()),
        (State::Idle, false)
    );
    rig.controller
        .command(Command::Start(Mode::Manual))
        .unwrap();
    rig.block();
    rig.controller.command(Command::Stop).unwrap();
    assert_eq!(rig.controller.state(), State::Idle, "in the self test");
    rig.starts(Mode::Manual, State::Manual);
    rig.controller.command(Command::Stop).unwrap();
    // One amplitude per second.
    rig.pass(0.9);
    assert_eq!(
        (rig.controller.state(), rig.is_enabled()),
        (State::Stop, true)
    );
    let left = rig.controller.status().amplitude_m / WIRES.amplitude_m as f32;
    assert!((0.05..0.15).contains(&left), "{left}");
    rig.pass(0.2);
    assert_eq!(
        (rig.controller.state(), rig.is_enabled()),
        (State::Idle, false)
    );
    assert_eq!(rig.controller.fault(), None);

    // After a fault it is refused, and the drive stays off.
    rig.chain_open = true;
    rig.block();
    assert_eq!(
        rig.controller.command(Command::Stop),
        Err(Refused::WrongState)
    );
    rig.block();
    assert_eq!(
        (rig.controller.state(), rig.is_enabled()),
        (State::Fault, false)
    );
}

#[test]
fn a_motor_runs_by_hand_only_and_is_stopped_at_once() {
    let mut rig = TestRig::with(|settings| settings.drive.kind = DriveKind::Motor);
    let automatic = rig.controller.command(Command::Start(Mode::Automatic));
    assert_eq!(automatic, Err(Refused::ByHandOnly));
    rig.starts(Mode::Manual, State::Manual);
    assert!(rig.is_enabled());
    rig.controller.command(Command::Stop).unwrap();
    rig.block();
    assert_eq!(
        (rig.controller.state(), rig.is_enabled()),
        (State::Idle, false)
    );
}

#[test]
fn a_search_without_one_one_is_given_up_after_its_time() {
    let mut rig = TestRig::with(|settings| settings.trips.regime_lost_s = 10.0);
    rig.forecast(Some(target(3.6)));
    rig.starts(Mode::Automatic, State::Seek);
    rig.pass(9.98);
    assert_eq!(rig.controller.state(), State::Seek);
    rig.pass(0.04);
    let fault = rig.controller.fault().map(|record| record.fault);
    assert_eq!(fault, Some(Fault::RegimeLost));
}

#[test]
fn a_contact_is_missed_only_where_the_forecast_has_a_strong_one_and_never_on_the_way_down() {
    // A contact is sure to be seen from 28 N on.
    let missed = |strikes_n: f32, stop_after_s: f32| {
        let mut rig = TestRig::with(|settings| settings.trips.no_contact_s = 3.00025);
        rig.forecast_of(Some(target(3.6)), strikes_n);
        rig.starts(Mode::Automatic, State::Seek);
        // It has been counted since a fifth of the amplitude was reached, 0.6 s ago.
        rig.pass(stop_after_s);
        if rig.controller.state() == State::Seek {
            rig.controller.command(Command::Stop).unwrap();
            rig.pass(1.2);
        }
        rig.controller.fault().map(|record| record.fault)
    };
    assert_eq!(missed(90.0, 4.0), Some(Fault::NoContact));
    assert_eq!(missed(90.0, 2.0), None);
    assert_eq!(missed(20.0, 10.0), None);
}
