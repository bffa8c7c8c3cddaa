//! A rig with its link, brought to where a check begins.

use std::cell::RefCell;
use std::rc::Rc;

use emulator::scenario::{Scenario, load};
use host_sim::link::client::Client;
use shared::control::{Command, Mode, State, Status};
use shared::fault::Fault;
use shared::link::{Hello, LinkAct};

use super::{Setup, must};
use crate::machine::{Around, Change};
use crate::parts::UNITS_PER_US;
use crate::rig::{Rig, Wire, wired};

/// The longest that a start is given until the drive comes on, ms.
const MOST_START_MS: u64 = 8_000;
/// Steps in which it is waited for, ms.
pub const START_STEP_MS: u64 = 5;
/// The longest until Hold, s.
const MOST_SEEK_S: u64 = 240;

type Outcome<T = ()> = Result<T, Box<dyn std::error::Error>>;

/// The rig, and the desktop's end of its link.
pub struct Bench {
    pub rig: Rc<RefCell<Rig>>,
    /// The desktop's end of the link, over the model's wire.
    pub client: Client<Wire>,
    /// The scenario of the plant.
    pub scenario: Scenario,
}

impl Bench {
    /// Power comes on with `around`, and nothing else.
    pub fn power_up(setup: &Setup, around: Around) -> Outcome<Self> {
        Self::power_up_in(setup, load("field")?, around)
    }

    /// Power comes on with `around`, in a rig of `scenario`, and nothing else.
    pub fn power_up_in(setup: &Setup, scenario: Scenario, mut around: Around) -> Outcome<Self> {
        around.patch = setup.patch;
        let rig = Rig::power_up(setup.image()?, &scenario, around)?;
        Ok(Self::of(rig, scenario))
    }

    fn of(rig: Rig, scenario: Scenario) -> Self {
        let rig = Rc::new(RefCell::new(rig));
        // Runs can be compared only if every byte is the same.
        let client = Client::new(Wire(rig.clone()), "the model's link").numbered_from(0);
        Self {
            rig,
            client,
            scenario,
        }
    }

    /// A wired board with the scenario's settings, idle.
    pub fn idle(setup: &Setup) -> Outcome<(Self, Hello)> {
        Self::power_up(setup, wired())?.prepared(None)
    }

    /// With the scenario's settings, idle; with these traps (DEMCR) of a debugger.
    pub fn prepared(self, traps: Option<u32>) -> Outcome<(Self, Hello)> {
        let mut bench = self;
        if traps.is_some() {
            bench.rig.borrow_mut().machine.system.attach(traps);
        }
        bench.advance_ms(100)?;
        let hello = bench.client.hello()?;
        bench.client.open_session(false)?;
        bench
            .client
            .steer(LinkAct::SetSettings(bench.scenario.settings))?;
        let status = bench.client.status()?;
        bench
            .client
            .command(Command::ClearFault)
            .map_err(|e| format!("{e}: {:?}", status.fault))?;
        Ok((bench, hello))
    }

    /// A wired board that drives: the pulses at PA8 have come. Brought there once, and copied for each check.
    pub fn driving(setup: &Setup) -> Outcome<Self> {
        if setup.driving.get().is_none() {
            let bench = Self::driving_with(setup, None)?;
            let rig = bench.rig.borrow().clone();
            setup.driving.set(rig).ok();
        }
        let rig = setup.driving.get().ok_or("no board that drives")?;
        Ok(Self::of(rig.clone(), load("field")?))
    }

    /// In Hold, in the middle of a pulse. Brought there once, and copied for each check.
    pub fn holding(setup: &Setup) -> Outcome<Self> {
        if setup.holding.get().is_none() {
            let bench = Self::brought_to_hold(setup)?;
            let rig = bench.rig.borrow().clone();
            setup.holding.set(rig).ok();
        }
        let rig = setup.holding.get().ok_or("no board in Hold")?;
        Ok(Self::of(rig.clone(), load("field")?))
    }

    fn brought_to_hold(setup: &Setup) -> Outcome<Self> {
        let mut bench = Self::driving(setup)?;
        for _ in 0..MOST_SEEK_S {
            bench.advance_ms(1000)?;
            if bench.status()?.state == State::Hold {
                while !bench.rig.borrow().machine.enabled() {
                    bench.rig.borrow_mut().advance(20)?;
                }
                return Ok(bench);
            }
        }
        let state = bench.status()?.state;
        Err(format!("no Hold within {MOST_SEEK_S} s, but {state:?}").into())
    }

    /// A wired board that drives, in a pulse; with `traps`, a debugger has been attached and has left these (DEMCR).
    pub fn driving_with(setup: &Setup, traps: Option<u32>) -> Outcome<Self> {
        let (mut bench, _) = Self::power_up(setup, wired())?.prepared(traps)?;
        bench.start_drive()?;
        bench.advance_ms(20)?;
        // In the middle of a pulse.
        while !bench.rig.borrow().machine.enabled() {
            bench.rig.borrow_mut().advance(20)?;
        }
        Ok(bench)
    }

    /// Starts it, and goes on until the first pulse at PA8 has come.
    pub fn start_drive(&mut self) -> Outcome {
        self.client.command(Command::Start(Mode::Automatic))?;
        for _ in 0..MOST_START_MS / START_STEP_MS {
            self.advance_ms(START_STEP_MS)?;
            if self.rig.borrow_mut().is_driven() {
                return Ok(());
            }
        }
        let status = self.status()?;
        Err(format!(
            "the drive did not come on within {MOST_START_MS} ms of the start: {:?}",
            status.state
        )
        .into())
    }

    /// Lets rig time go on by `ms` milliseconds.
    pub fn advance_ms(&mut self, ms: u64) -> Outcome {
        Ok(self.rig.borrow_mut().advance(1000 * ms)?)
    }

    /// The time, in units of 1/720 MHz.
    pub fn now(&self) -> u64 {
        self.rig.borrow().machine.now
    }

    /// What the controller says; the board must have started.
    pub fn status(&mut self) -> Outcome<Status> {
        self.client.hello()?;
        Ok(self.client.status()?)
    }

    /// The controller's state must be this.
    pub fn must_be(&mut self, state: State) -> Outcome<Status> {
        let status = self.status()?;
        if status.state != state {
            return Err(format!(
                "the controller is in {:?}, not in {state:?}: {:?}",
                status.state, status.fault
            )
            .into());
        }
        Ok(status)
    }

    /// It must be in Fault, with this one as its record's.
    pub fn must_be_in(&mut self, wanted: Fault) -> Outcome {
        let fault = self.must_be(State::Fault)?.fault;
        let fault = fault.map(|record| record.fault);
        must(fault == Some(wanted), || {
            format!("in Fault by {fault:?}, not {wanted:?}")
        })
    }

    /// What changed at the edge since `from`.
    pub fn changes_since(&self, from: u64) -> Vec<(u64, Change)> {
        let rig = self.rig.borrow();
        rig.machine
            .changes
            .iter()
            .filter(|(at, _)| *at >= from)
            .copied()
            .collect()
    }

    /// Goes on to the first reset since `from`, and until the program runs again: when it was, and its flags. None within
    /// so many seconds is an error.
    pub fn until_reset(&mut self, from: u64, most_s: f64) -> Outcome<(u64, u32)> {
        for _ in 0..(20.0 * most_s) as u64 {
            self.advance_ms(50)?;
            let found = self
                .changes_since(from)
                .into_iter()
                .find_map(|(at, change)| {
                    let Change::Reset(flags) = change else {
                        return None;
                    };
                    Some((at, flags))
                });
            if let Some(found) = found {
                self.advance_ms(100)?;
                return Ok(found);
            }
        }
        Err(format!("no reset within {most_s} s").into())
    }

    /// How long after `from` PA8 last rose or was high, in µs; an error if it is high now.
    pub fn enable_gone_us(&self, from: u64) -> Outcome<f64> {
        let rig = self.rig.borrow();
        if rig.machine.enabled() {
            return Err("PA8 is still high".into());
        }
        let mut last = from;
        let mut high = false;
        for (at, change) in &rig.machine.changes {
            if let Change::Enable(level) = change {
                if high && *at >= from {
                    last = *at;
                }
                high = *level == Some(true);
            }
        }
        Ok((last - from) as f64 / UNITS_PER_US as f64)
    }

    /// Starts of an exception since power-up.
    pub fn entered(&self, number: usize) -> u64 {
        self.rig.borrow().machine.entered[number]
    }
}
