//! Who must be there: the program that steers over the link, the person at the board, and whoever sent the settings. The
//! real controller behind the real end of the link.

use shared::control::{
    BootInfo, Command, EVENT_CAPACITY, Mode, Refused, ResetCause, SettingsState, State, Status,
};
use shared::fault::{Fault, FaultRecord};
use shared::forecast::Forecast;
use shared::link::{
    Boot, Decoder, Device, ForecastPage, FromBoard, Hello, Identified, LinkAct, LinkAnswer,
    LinkName, MAX_FRAME, PROTOCOL_VERSION, Packet, RecordedBlock, Refusal, Session, ToBoard,
    encode,
};
use shared::model::params::WIRES;
use shared::settings::Settings;

use crate::bench::{Bench, Happening, forecast};

/// Ticks of a block.
const BLOCK: usize = 10;
/// Blocks of a millisecond.
const PER_MS: u32 = 2;

/// A controller at a rig, behind the board's end of the link.
struct Rig {
    bench: Bench,
    chain_open: bool,
    boot: u32,
}

impl Rig {
    fn new(settings: &Settings, boot: &BootInfo) -> Self {
        // Nobody expects a contact of its hammer.
        let mut bench = Bench::born(settings, boot);
        bench.forecast = |id| Forecast {
            rows: Default::default(),
            ..forecast(id)
        };
        Self {
            bench,
            chain_open: false,
            boot: 5,
        }
    }

    fn block(&mut self) {
        let happening = if self.chain_open {
            Happening::Emergency
        } else {
            Happening::Sound { noise: 3 }
        };
        self.bench.block(BLOCK, &happening);
    }

    fn drives(&self) -> bool {
        self.bench.outputs[..BLOCK]
            .iter()
            .any(|output| output.enable)
    }
}

impl Device for Rig {
    fn hello(&mut self) -> Hello {
        Hello {
            protocol: PROTOCOL_VERSION,
            firmware: LinkName::new(),
            board: LinkName::new(),
            tick_rate_hz: 20_000,
            block_ticks: BLOCK as u8,
        }
    }
    fn status(&mut self) -> Status {
        self.bench.controller.status()
    }
    fn command(&mut self, command: Command) -> Result<(), Refused> {
        self.bench.controller.command(command)
    }
    fn settings(&mut self) -> Settings {
        *self.bench.controller.settings()
    }
    fn replace_settings(&mut self, settings: &Settings) -> Result<(), Refused> {
        self.bench.controller.replace_settings(settings)
    }
    fn store_settings(&mut self) -> Result<(), Refusal> {
        Ok(())
    }
    fn forecast(&mut self, page: u8) -> ForecastPage {
        ForecastPage::of(None, page)
    }
    fn fault_record(&mut self) -> Option<FaultRecord> {
        self.status().fault
    }
    fn identified(&mut self) -> Identified {
        Identified::default()
    }
    fn record(&mut self, _on: bool) -> Result<(), Refusal> {
        Ok(())
    }
    fn take_block(&mut self) -> Option<RecordedBlock> {
        None
    }
    fn boot(&mut self) -> Boot {
        Boot {
            number: self.boot,
            settings: self.bench.controller.settings_state(),
            awaits_acknowledgement: self.bench.controller.awaits_acknowledgement(),
        }
    }
}

/// The rig, the board's end of the link, and the wire to it.
struct Board {
    rig: Rig,
    session: Session<2048>,
    heard: Decoder,
    /// Of the program that steers.
    steering: u32,
    number: u32,
    /// Every frame that was sent to steer.
    sent: Vec<Vec<u8>>,
}

impl Board {
    fn new(settings: &Settings, boot: &BootInfo) -> Self {
        Self {
            rig: Rig::new(settings, boot),
            session: Session::new(),
            heard: Decoder::new(),
            steering: 0,
            number: 0,
            sent: Vec::new(),
        }
    }

    /// With the wires' usual settings, changed.
    fn with(change: impl FnOnce(&mut Settings)) -> Self {
        let mut settings = Settings::for_rig(&WIRES);
        change(&mut settings);
        Self::new(&settings, &BootInfo::STORED)
    }

    fn frame(message: ToBoard) -> Vec<u8> {
        let mut frame = [0; MAX_FRAME];
        let packet = Packet {
            sequence: 9,
            message,
        };
        encode(&packet, &mut frame).unwrap().to_vec()
    }

    fn hear(&mut self, frame: &[u8]) -> LinkAnswer {
        for byte in frame {
            self.session.receive(*byte, &mut self.rig);
        }
        let mut last = None;
        while let Some(byte) = self.session.queue().pop() {
            last = self.heard.push::<FromBoard>(byte).or(last);
        }
        match last.expect("an answer").message {
            FromBoard::Answer { answer, .. } => answer,
            other => panic!("{other:?}"),
        }
    }

    fn ask(&mut self, message: ToBoard) -> LinkAnswer {
        self.hear(&Self::frame(message))
    }

    fn open(&mut self) {
        let LinkAnswer::Board(board) = self.ask(ToBoard::GetBoard) else {
            panic!("the board's state was asked for");
        };
        let open = ToBoard::OpenSession {
            boot: board.boot,
            granted: board.granted,
            take_over: true,
        };
        let LinkAnswer::Session(session) = self.ask(open) else {
            panic!("the session was asked for");
        };
        (self.steering, self.number) = (session, 0);
    }

    fn steer(&mut self, act: LinkAct) -> LinkAnswer {
        self.number += 1;
        let frame = Self::frame(ToBoard::Steer {
            session: self.steering,
            number: self.number,
            act,
        });
        self.sent.push(frame.clone());
        self.hear(&frame)
    }

    fn command(&mut self, command: Command) -> LinkAnswer {
        self.steer(LinkAct::Command(command))
    }

    /// Lets a time pass with `each` once in every 50 ms, and says whether the drive was on in the end.
    fn pass(&mut self, ms: u32, mut each: impl FnMut(&mut Self)) -> bool {
        for block in 0..ms * PER_MS {
            if block % (50 * PER_MS) == 0 {
                each(self);
            }
            self.rig.block();
            self.session.poll(&mut self.rig);
        }
        self.rig.drives()
    }

    /// Lets time pass, with signs of life, until the drive is on.
    fn starts(&mut self, mode: Mode) {
        assert_eq!(self.command(Command::Start(mode)), LinkAnswer::Done);
        let mut ms = 0;
        while !self.pass(50, |board| {
            if mode == Mode::Manual {
                assert_eq!(board.command(Command::Alive), LinkAnswer::Done);
            }
        }) {
            ms += 50;
            assert!(ms < 60_000, "{:?}", self.rig.bench.controller.status());
        }
    }

    fn fault(&mut self) -> Option<Fault> {
        self.rig.status().fault.map(|record| record.fault)
    }
}

#[test]
fn status_requests_of_another_program_do_not_keep_the_drive_on() {
    let mut board = Board::with(|_| {});
    board.open();
    board.starts(Mode::Manual);
    // Its own signs of life do, just within the timeout of 2 s.
    for _ in 0..3 {
        assert!(board.pass(1950, |_| {}));
        assert_eq!(board.command(Command::Alive), LinkAnswer::Done);
    }
    // Now it is silent, and another one looks twenty times a second.
    let on = board.pass(2010, |board| {
        assert!(matches!(
            board.ask(ToBoard::GetStatus),
            LinkAnswer::Status(_)
        ));
        board.ask(ToBoard::Hello);
        board.ask(ToBoard::GetBoard);
    });
    assert!(!on);
    assert_eq!(board.fault(), Some(Fault::LinkTimeout));
}

#[test]
fn recorded_frames_sent_again_do_not_keep_the_drive_on_or_start_it() {
    let mut board = Board::with(|_| {});
    board.open();
    board.starts(Mode::Manual);
    let recorded = board.sent.clone();
    assert!(recorded.len() > 3);
    let again = |board: &mut Board| {
        for frame in &recorded {
            let refused = LinkAnswer::Refused(Refusal::Old);
            let over = LinkAnswer::Refused(Refusal::NoSession);
            let answer = board.hear(frame);
            assert!(answer == refused || answer == over, "{answer:?}");
        }
    };
    assert!(!board.pass(2010, again));
    assert_eq!(board.fault(), Some(Fault::LinkTimeout));
    // Nor do they start it, in this boot, under another session or after a reset.
    board.open();
    assert_eq!(board.command(Command::ClearFault), LinkAnswer::Done);
    assert!(!board.pass(3000, again));
    assert_eq!(board.rig.status().state, State::Idle);
    board.rig.boot += 1;
    board.session = Session::new();
    assert!(!board.pass(3000, again));
    assert_eq!(board.rig.status().state, State::Idle);
}

#[test]
fn anybody_may_stop() {
    let mut board = Board::with(|_| {});
    board.open();
    board.starts(Mode::Manual);
    assert_eq!(board.ask(ToBoard::Command(Command::Stop)), LinkAnswer::Done);
    // Who steers goes on with its signs of life, and that does not start it again.
    let on = board.pass(3000, |board| {
        assert_eq!(board.command(Command::Alive), LinkAnswer::Done);
    });
    assert!(!on);
    assert_eq!(
        (board.rig.status().state, board.fault()),
        (State::Idle, None)
    );
}

#[test]
fn automatic_mode_needs_a_heartbeat_only_where_it_is_asked_for() {
    let mut free = Board::with(|_| {});
    free.open();
    free.starts(Mode::Automatic);
    assert_eq!(free.steer(LinkAct::Release), LinkAnswer::Done);
    assert!(free.pass(2600, |_| {}));

    let heartbeat = |settings: &mut Settings| {
        settings.operator.heartbeat = true;
        // Nothing strikes here.
        settings.trips.no_contact_s = 30.0;
    };
    let mut kept = Board::with(heartbeat);
    kept.open();
    kept.command(Command::Start(Mode::Automatic));
    assert_eq!(kept.command(Command::Alive), LinkAnswer::Done);
    for _ in 0..100 {
        kept.pass(50, |_| {});
        assert_eq!(kept.command(Command::Alive), LinkAnswer::Done);
    }
    // As long as it is heard: just within the timeout, and just beyond it.
    assert!(kept.pass(1990, |_| {}), "{:?}", kept.rig.status());
    assert!(!kept.pass(20, |board| {
        board.ask(ToBoard::GetStatus);
    }));
    assert_eq!(kept.fault(), Some(Fault::LinkTimeout));

    // Started at the board with nobody on the link, the drive never comes on.
    let mut alone = Board::with(heartbeat);
    assert_eq!(alone.rig.command(Command::Start(Mode::Automatic)), Ok(()));
    let mut was_on = false;
    for _ in 0..200 {
        was_on |= alone.pass(50, |_| {});
    }
    assert_eq!(alone.fault(), Some(Fault::LinkTimeout));
    assert!(!was_on);
}

/// The chain opens for a moment; it has been closed again for `closed_ms`.
fn after_an_emergency_stop(board: &mut Board, closed_ms: u32) {
    board.rig.chain_open = true;
    board.pass(1, |_| {});
    assert_eq!(board.fault(), Some(Fault::EmergencyStop));
    board.rig.chain_open = false;
    board.pass(closed_ms, |_| {});
}

fn refused(why: Refused) -> LinkAnswer {
    LinkAnswer::Refused(Refusal::Controller(why))
}

#[test]
fn an_emergency_stop_is_acknowledged_at_the_board_where_that_is_asked_for() {
    let mut free = Board::with(|_| {});
    free.open();
    after_an_emergency_stop(&mut free, 5);
    assert_eq!(free.command(Command::ClearFault), LinkAnswer::Done);

    let mut board = Board::with(|settings| settings.operator.acknowledge = true);
    board.open();
    let not_yet = refused(Refused::NotAcknowledged);
    // A button pressed while the chain is open, or bounces, acknowledges nothing.
    board.rig.chain_open = true;
    board.pass(1, |_| {});
    let pressed = board.rig.command(Command::Acknowledge { opened: true });
    assert_eq!(pressed, Err(Refused::StillFaulty));
    after_an_emergency_stop(&mut board, 18);
    let pressed = board.rig.command(Command::Acknowledge { opened: true });
    assert_eq!(pressed, Err(Refused::StillFaulty));
    assert_eq!(board.command(Command::ClearFault), not_yet);
    // The link cannot do it, nor change the rule: neither by settings nor by a confirmation.
    let at_the_board = LinkAnswer::Refused(Refusal::AtTheBoard);
    assert_eq!(
        board.command(Command::Acknowledge { opened: true }),
        at_the_board
    );
    let mut lax = *board.rig.bench.controller.settings();
    lax.operator.acknowledge = false;
    assert_eq!(board.steer(LinkAct::SetSettings(lax)), LinkAnswer::Done);
    board.pass(4, |_| {});
    assert_eq!(board.command(Command::ClearFault), not_yet);
    assert!(matches!(
        board.ask(ToBoard::GetBoard),
        LinkAnswer::Board(state) if state.awaits_acknowledgement
    ));
    // Pressed after the chain has been closed for 20 ms, it does.
    assert_eq!(
        board.rig.command(Command::Acknowledge { opened: true }),
        Ok(())
    );
    assert_eq!(board.rig.status().state, State::Fault);
    assert_eq!(board.command(Command::ClearFault), LinkAnswer::Done);
    let again = board.rig.command(Command::Acknowledge { opened: true });
    assert_eq!(again, Err(Refused::WrongState));
}

#[test]
fn each_start_wants_the_chain_tried_where_an_acknowledgement_is_asked_for() {
    let mut board = Board::with(|settings| settings.operator.acknowledge = true);
    board.open();
    let start = Command::Start(Mode::Automatic);
    let not_tried = refused(Refused::ChainNotTried);
    // A stop that the chain's report never showed tries nothing.
    after_an_emergency_stop(&mut board, 30);
    let opened = false;
    let pressed = board.rig.command(Command::Acknowledge { opened });
    assert_eq!(pressed, Ok(()));
    assert_eq!(board.command(Command::ClearFault), LinkAnswer::Done);
    for _ in 0..2 {
        assert_eq!(board.command(start), not_tried);
        after_an_emergency_stop(&mut board, 30);
        assert_eq!(
            board.rig.command(Command::Acknowledge { opened: true }),
            Ok(())
        );
        assert_eq!(board.command(Command::ClearFault), LinkAnswer::Done);
        assert_eq!(board.command(start), LinkAnswer::Done);
        assert_eq!(board.command(Command::Stop), LinkAnswer::Done);
    }
}

#[test]
fn a_reset_acknowledges_no_emergency_stop() {
    let mut settings = Settings::for_rig(&WIRES);
    settings.operator.acknowledge = true;
    let mut before = Board::new(&settings, &BootInfo::STORED);
    after_an_emergency_stop(&mut before, 30);
    let boot = BootInfo {
        reset: ResetCause::Pin,
        record: before.rig.bench.controller.persisted().record(),
        ..BootInfo::STORED
    };
    let mut board = Board::new(&settings, &boot);
    board.open();
    board.pass(30, |_| {});
    let not_yet = refused(Refused::NotAcknowledged);
    assert_eq!(board.command(Command::ClearFault), not_yet);
    assert_eq!(
        board.rig.command(Command::Acknowledge { opened: true }),
        Ok(())
    );
    assert_eq!(board.command(Command::ClearFault), LinkAnswer::Done);
}

#[test]
fn a_board_whose_settings_are_not_known_to_be_its_rigs_does_not_start() {
    let settings = Settings::for_rig(&WIRES);
    use SettingsState::{Damaged, Missing, Model, OlderCopy, Stored};
    for state in [Stored, Model, Missing, Damaged, OlderCopy] {
        let boot = BootInfo {
            settings: state,
            ..BootInfo::STORED
        };
        let mut board = Board::new(&settings, &boot);
        board.open();
        board.pass(5, |_| {});
        let start = Command::Start(Mode::Manual);
        if state.can_drive() {
            assert_eq!(board.command(start), LinkAnswer::Done, "{state:?}");
            continue;
        }
        let why = Refused::SettingsUnknown(state);
        assert_eq!(board.command(start), refused(why));
        assert_eq!(board.rig.command(start), Err(why), "by the button");
        assert_eq!(board.command(Command::ClearFault), refused(why));
        assert_eq!(board.fault(), Some(Fault::CorruptSettings));
        // Confirmed or sent anew, it does.
        let confirmed = board.command(Command::ConfirmSettings);
        if state == OlderCopy {
            assert_eq!(confirmed, LinkAnswer::Done);
        } else {
            assert_eq!(confirmed, refused(Refused::WrongState));
            assert_eq!(
                board.steer(LinkAct::SetSettings(settings)),
                LinkAnswer::Done
            );
        }
        board.pass(5, |_| {});
        assert_eq!(
            board.command(Command::ClearFault),
            LinkAnswer::Done,
            "{state:?}"
        );
        board.starts(Mode::Manual);
        assert!(board.rig.drives());
    }
}

#[test]
fn new_settings_do_not_clear_a_fault_whose_cause_stands() {
    let mut board = Board::with(|_| {});
    board.open();
    board.rig.chain_open = true;
    board.pass(1, |_| {});
    let settings = *board.rig.bench.controller.settings();
    // Both within one block.
    assert_eq!(
        board.steer(LinkAct::SetSettings(settings)),
        LinkAnswer::Done
    );
    let cleared = board.command(Command::ClearFault);
    assert_eq!(cleared, refused(Refused::StillFaulty));
    assert_eq!(board.fault(), Some(Fault::EmergencyStop));
}

#[test]
fn events_that_nobody_took_are_counted_over_the_link() {
    let mut board = Board::with(|_| ());
    let lost = |board: &mut Board| match board.ask(ToBoard::GetStatus) {
        LinkAnswer::Status(status) => status.events_dropped,
        other => panic!("{other:?}"),
    };
    assert_eq!(lost(&mut board), 0);
    // Each start and each stop is an event; nobody takes them.
    for _ in 0..20 {
        let controller = &mut board.rig.bench.controller;
        controller.command(Command::Start(Mode::Manual)).unwrap();
        controller.command(Command::Stop).unwrap();
    }
    let taken = std::iter::from_fn(|| board.rig.bench.controller.take_event()).count();
    let dropped = usize::from(lost(&mut board));
    assert!(
        taken == EVENT_CAPACITY && dropped >= 40 - taken,
        "{taken} {dropped}"
    );
    // Taking those that are left brings the others not back.
    assert_eq!(usize::from(lost(&mut board)), dropped);
}
