//! A link in command that falls silent and is heard again.

use shared::control::{Command, Mode, Refused, State};
use shared::fault::Fault;

use crate::bench::{Bench, Happening, episode};

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
