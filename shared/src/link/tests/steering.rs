//! Who steers: one program, by what it sends itself and has not sent before.

use proptest::prelude::*;

use super::*;
use crate::control::Command::{Acknowledge, Alive, ClearFault, SetPoint, Start, Stop};
use crate::settings::TICK_RATE_HZ;

const OLD: LinkAnswer = LinkAnswer::Refused(Refusal::Old);
const NO_SESSION: LinkAnswer = LinkAnswer::Refused(Refusal::NoSession);
/// A session is over after it, ticks: the settings' link timeout is as long.
const PATIENCE: u32 = (SESSION_S as u32) * TICK_RATE_HZ;

#[test]
fn only_acts_of_the_session_are_signs_of_life() {
    let mut pair = Pair::new();
    let mut program = pair.open(false).unwrap();
    assert_eq!(
        pair.command(&mut program, Start(Mode::Manual)),
        LinkAnswer::Done
    );
    assert_eq!(pair.command(&mut program, Alive), LinkAnswer::Done);
    // Another program looks, again and again, in every way it can.
    pair.ask(ToBoard::Hello);
    for request in watching() {
        pair.ask(request);
    }
    // A damaged frame is no sign of life either.
    pair.session.receive(1, &mut pair.device);
    pair.session.receive(0, &mut pair.device);
    assert_eq!(pair.session.counters().damaged, 1);
    let told = [Start(Mode::Manual), Alive, Alive];
    assert_eq!(pair.device.told, told);
    assert!(pair.session.is_held());
    // The session does not live on the looking either.
    pair.device.status.tick += PATIENCE + 1;
    pair.ask(ToBoard::GetStatus);
    assert_eq!(pair.command(&mut program, Alive), NO_SESSION);
    assert_eq!(pair.device.told, told);
}

fn watching() -> [ToBoard; 8] {
    [
        ToBoard::GetStatus,
        ToBoard::GetSettings,
        ToBoard::GetForecast { page: 0 },
        ToBoard::StreamTelemetry { decimation: 100 },
        ToBoard::StreamFrames { on: true },
        ToBoard::GetFaultRecord,
        ToBoard::GetIdentified,
        ToBoard::GetBoard,
    ]
}

#[test]
fn without_a_session_nothing_is_obeyed_but_a_stop() {
    let mut pair = Pair::new();
    for command in commands() {
        let expected = match command {
            Stop => LinkAnswer::Done,
            _ => NO_SESSION,
        };
        assert_eq!(pair.ask(ToBoard::Command(command)), expected, "{command:?}");
    }
    let mut made_up = Program {
        session: 0,
        number: 0,
    };
    for command in commands() {
        assert_eq!(
            pair.command(&mut made_up, command),
            NO_SESSION,
            "{command:?}"
        );
    }
    assert_eq!(pair.device.told, [Stop]);
}

fn commands() -> [Command; 8] {
    let point = SetPoint {
        frequency_hz: 3.0,
        amplitude_m: 1e-3,
    };
    let automatic = Start(Mode::Automatic);
    let confirm = Command::ConfirmSettings;
    [
        Stop,
        automatic,
        Start(Mode::Manual),
        ClearFault,
        point,
        Alive,
        Acknowledge { opened: true },
        confirm,
    ]
}

#[test]
fn a_second_program_is_refused_while_the_first_lives_and_may_take_over() {
    let mut pair = Pair::new();
    let mut first = pair.open(false).unwrap();
    pair.command(&mut first, Start(Mode::Manual));
    assert_eq!(pair.open(false).unwrap_err(), Refusal::SomebodySteers);
    // It may stop all the same.
    assert_eq!(pair.ask(ToBoard::Command(Stop)), LinkAnswer::Done);
    assert_eq!(pair.command(&mut first, Alive), LinkAnswer::Done);
    let mut second = pair.open(true).unwrap();
    assert_eq!(pair.command(&mut first, Alive), NO_SESSION);
    assert_eq!(pair.command(&mut second, Alive), LinkAnswer::Done);
    assert_eq!(
        pair.device.told,
        [Start(Mode::Manual), Alive, Stop, Alive, Alive]
    );
    // Whoever has released it, or has been silent for too long, is in nobody's way.
    assert_eq!(pair.steer(&mut second, LinkAct::Release), LinkAnswer::Done);
    assert_eq!(pair.command(&mut second, Alive), NO_SESSION);
    let mut third = pair.open(false).unwrap();
    pair.device.status.tick += PATIENCE;
    assert_eq!(pair.open(false).unwrap_err(), Refusal::SomebodySteers);
    pair.device.status.tick += 1;
    let mut fourth = pair.open(false).unwrap();
    assert_eq!(pair.command(&mut third, Alive), NO_SESSION);
    assert_eq!(pair.command(&mut fourth, Alive), LinkAnswer::Done);
}

#[test]
fn what_was_sent_once_does_nothing_when_it_is_sent_again() {
    let mut pair = Pair::new();
    let open = |pair: &Pair, granted| ToBoard::OpenSession {
        boot: pair.device.boot.number,
        granted,
        take_over: true,
    };
    let opening = open(&pair, 0);
    let LinkAnswer::Session(session) = pair.ask(opening) else {
        panic!("it is granted");
    };
    let mut program = Program { session, number: 0 };
    let mut sent = Vec::new();
    for command in [Start(Mode::Manual), Alive, ClearFault, Alive] {
        let request = program.request(LinkAct::Command(command));
        assert_eq!(pair.ask(request), LinkAnswer::Done);
        sent.push(request);
    }
    pair.device.told.clear();
    for request in &sent {
        assert_eq!(pair.ask(*request), OLD);
    }
    assert_eq!(pair.ask(opening), OLD);
    // Nor after the session, nor after the board has started anew.
    pair.steer(&mut program, LinkAct::Release);
    assert_eq!(pair.ask(opening), OLD);
    pair.session = Session::new();
    pair.device.boot.number = 78;
    assert_eq!(pair.ask(opening), OLD);
    let next = open(&pair, 0);
    let LinkAnswer::Session(other) = pair.ask(next) else {
        panic!("it is granted");
    };
    assert_ne!(other, session);
    for request in &sent {
        assert_eq!(pair.ask(*request), NO_SESSION);
    }
    assert!(pair.device.told.is_empty());
}

#[test]
fn a_session_ends_with_the_boot_and_its_last_number_is_the_last() {
    let mut pair = Pair::new();
    let mut program = pair.open(false).unwrap();
    program.number = u32::MAX - 1;
    assert_eq!(pair.command(&mut program, Alive), LinkAnswer::Done);
    program.number = 0;
    assert_eq!(pair.command(&mut program, Alive), OLD);
    let mut program = pair.open(true).unwrap();
    assert_eq!(pair.command(&mut program, Alive), LinkAnswer::Done);
    // The emulator makes its controller anew behind the same end of the link.
    pair.device.boot.number = 78;
    assert_eq!(pair.command(&mut program, Alive), NO_SESSION);
    assert!(!pair.session.is_held());
}

#[test]
fn the_session_outlives_a_link_timeout_that_is_longer() {
    let mut pair = Pair::new();
    pair.device.settings.trips.link_timeout_s = 10.0;
    let mut program = pair.open(false).unwrap();
    pair.device.status.tick += 10 * TICK_RATE_HZ;
    assert_eq!(pair.command(&mut program, Alive), LinkAnswer::Done);
    pair.device.settings.trips.link_timeout_s = 0.0;
    let settings = pair.device.settings;
    assert_eq!(
        pair.steer(&mut program, LinkAct::SetSettings(settings)),
        LinkAnswer::Done
    );
    pair.device.status.tick += PATIENCE + 1;
    assert_eq!(pair.command(&mut program, Alive), NO_SESSION);
}

#[test]
fn what_is_done_at_the_board_is_refused_over_the_link_and_a_confirmation_is_stored() {
    let mut pair = Pair::new();
    let mut program = pair.open(false).unwrap();
    let at_the_board = LinkAnswer::Refused(Refusal::AtTheBoard);
    assert_eq!(
        pair.command(&mut program, Acknowledge { opened: true }),
        at_the_board
    );
    assert!(pair.device.told.is_empty());
    let confirm = Command::ConfirmSettings;
    assert_eq!(pair.command(&mut program, confirm), LinkAnswer::Done);
    assert_eq!(pair.device.stored, Some(pair.device.settings));
    pair.device.boot.settings = SettingsState::OlderCopy;
    pair.device.boot.awaits_acknowledgement = true;
    let expected = BoardState {
        boot: 77,
        granted: 1,
        held: true,
        settings: SettingsState::OlderCopy,
        awaits_acknowledgement: true,
    };
    assert_eq!(pair.ask(ToBoard::GetBoard), LinkAnswer::Board(expected));
}

/// What happens on a wire with two programs on it, and a third that sends again what it has heard.
#[derive(Clone, Copy, Debug)]
enum Happens {
    Opens { program: usize, take_over: bool },
    Steers { program: usize, act: LinkAct },
    Looks(ToBoard),
    Again(usize),
    Stops,
    Hello,
    Passes { ticks: u32 },
    Restarts,
}

fn happens() -> impl Strategy<Value = Happens> {
    let command = proptest::sample::select(commands().to_vec());
    let act = prop_oneof![
        8 => command.prop_map(LinkAct::Command),
        1 => Just(LinkAct::Release),
        1 => Just(LinkAct::SetSettings(Settings::for_rig(&WIRES))),
        1 => Just(LinkAct::SetBrownOut),
    ];
    // Not a recording: the stub's time goes on with every block taken.
    let mut looks = watching().to_vec();
    looks.retain(|request| !matches!(request, ToBoard::StreamFrames { .. }));
    let looks = proptest::sample::select(looks);
    prop_oneof![
        4 => (0..2_usize, any::<bool>())
            .prop_map(|(program, take_over)| Happens::Opens { program, take_over }),
        10 => (0..2_usize, act).prop_map(|(program, act)| Happens::Steers { program, act }),
        4 => looks.prop_map(Happens::Looks),
        10 => any::<usize>().prop_map(Happens::Again),
        1 => Just(Happens::Stops),
        1 => Just(Happens::Hello),
        4 => (0..2 * PATIENCE).prop_map(|ticks| Happens::Passes { ticks }),
        1 => Just(Happens::Restarts),
    ]
}

/// The rules, once more and simpler: who holds the session, and since when he has been silent.
#[derive(Default)]
struct Rules {
    holder: Option<usize>,
    silent: u32,
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 1000, failure_persistence: None, ..ProptestConfig::default() })]

    /// In every order: the controller is told what the holder sends for the first time, and stops. Nothing else.
    #[test]
    fn the_controller_hears_the_holder_and_nobody_else(events in prop::collection::vec(happens(), 1..80)) {
        let mut pair = Pair::new();
        pair.device.status.tick = u32::MAX - PATIENCE;
        let mut programs: [Option<Program>; 2] = [None; 2];
        let mut rules = Rules::default();
        let mut sent = Vec::new();
        for event in events {
            pair.device.told.clear();
            // The stub refuses a start but in Idle, and settings: here it is always there.
            pair.device.status.state = State::Idle;
            let mut expected = Vec::new();
            match event {
                Happens::Opens { program, take_over } => {
                    let may = rules.holder.is_none() || take_over;
                    match pair.open(take_over) {
                        Ok(granted) => {
                            prop_assert!(may);
                            programs[program] = Some(granted);
                            rules = Rules { holder: Some(program), silent: 0 };
                        }
                        Err(why) => {
                            prop_assert!(!may);
                            prop_assert_eq!(why, Refusal::SomebodySteers);
                        }
                    }
                }
                Happens::Steers { program, act } => {
                    let Some(steering) = &mut programs[program] else { continue };
                    let request = steering.request(act);
                    sent.push(request);
                    let answer = pair.ask(request);
                    if rules.holder == Some(program) {
                        rules.silent = 0;
                        match act {
                            LinkAct::Command(Acknowledge { .. }) | LinkAct::SetSettings(_) | LinkAct::SetBrownOut => {}
                            LinkAct::Command(command) => expected.push(command),
                            LinkAct::Release => rules.holder = None,
                        }
                        if let LinkAct::Command(Start(Mode::Manual) | SetPoint { .. }) = act {
                            expected.push(Alive);
                        }
                        prop_assert!(!matches!(answer, NO_SESSION | OLD), "{:?}", answer);
                    } else {
                        prop_assert_eq!(answer, NO_SESSION);
                    }
                }
                Happens::Looks(request) => {
                    pair.ask(request);
                }
                Happens::Again(which) => {
                    if let Some(request) = which.checked_rem(sent.len()).map(|i| sent[i]) {
                        let answer = pair.ask(request);
                        prop_assert!(matches!(answer, NO_SESSION | OLD), "{:?}", answer);
                    }
                }
                Happens::Stops => {
                    pair.ask(ToBoard::Command(Stop));
                    expected.push(Stop);
                }
                Happens::Hello => {
                    pair.ask(ToBoard::Hello);
                }
                Happens::Passes { ticks } => {
                    pair.device.status.tick = pair.device.status.tick.wrapping_add(ticks);
                    rules.silent += ticks;
                    if rules.silent > PATIENCE {
                        rules.holder = None;
                    }
                }
                Happens::Restarts => {
                    pair.device.boot.number = pair.device.boot.number.wrapping_add(1);
                    rules.holder = None;
                }
            }
            prop_assert_eq!(&pair.device.told, &expected, "{:?}", event);
            pair.session.poll(&mut pair.device);
            pair.heard();
            prop_assert_eq!(pair.session.is_held(), rules.holder.is_some(), "{:?}", event);
        }
    }
}
