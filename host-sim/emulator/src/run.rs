//! A run: the world and the controller, block by block.

use std::collections::VecDeque;
use std::time::Duration;

use shared::control::{self, Command, MAX_BLOCK};
use shared::io::{Frame, Output};

use super::names::{basin_name, state_name};
use super::record::{BlockRow, Given, RunEvent, RunEventKind, RunObserver, TickRow};
use super::scenario::Scenario;
use super::schedule::{Doing, Due, Spell, schedule};
use super::summary::RunSummary;
use super::under_test::{ControlUnderTest, Reset};
use super::world::World;
use files::UserError;

/// How often a link in command sends its keep-alive.
const ALIVE_EVERY: Duration = Duration::from_millis(500);

/// Runs `scenario` with `control`, which was just made with its settings; `observer` watches. Neither is a type parameter: the run
/// is compiled here, and optimised, whoever calls it.
///
/// # Errors
/// `true_rig` is invalid.
pub fn run(
    scenario: &Scenario,
    control: &mut dyn ControlUnderTest,
    observer: &mut dyn RunObserver,
) -> Result<RunSummary, UserError> {
    let mut run = Run::new(scenario, control, observer)?;
    for _ in 0..scenario.blocks() {
        run.block();
    }
    Ok(run.finish().0)
}

/// A run under way. [`run`] is one from beginning to end.
pub struct Run<C, O> {
    scenario: Scenario,
    control: C,
    observer: O,
    world: World,
    due: VecDeque<Due>,
    /// Actions on the controller that are due, kept until the end of the block.
    waiting: Vec<Due>,
    tick: u64,
    /// Tick of the run at which the controller last started.
    born: u64,
    link: Option<u64>,
    /// Whether the link fell silent while it was in command.
    silent: bool,
    overruns: Spell,
    losses: Spell,
    frames: [Frame; MAX_BLOCK],
    outputs: [Output; MAX_BLOCK],
    given: Vec<Given>,
    was_on: bool,
    summary: RunSummary,
}

impl<C: ControlUnderTest, O: RunObserver> Run<C, O> {
    /// Before its first block.
    ///
    /// # Errors
    /// `true_rig` is invalid.
    pub fn new(scenario: &Scenario, control: C, observer: O) -> Result<Self, UserError> {
        Ok(Self {
            control,
            observer,
            world: World::new(scenario)?,
            due: schedule(scenario).into(),
            waiting: Vec::new(),
            tick: 0,
            born: 0,
            link: None,
            silent: false,
            overruns: Spell::default(),
            losses: Spell::default(),
            frames: [Frame::default(); MAX_BLOCK],
            outputs: [Output::SAFE; MAX_BLOCK],
            given: Vec::new(),
            was_on: false,
            summary: RunSummary::new(scenario),
            scenario: scenario.clone(),
        })
    }

    /// The controller under test.
    pub fn control(&mut self) -> &mut C {
        &mut self.control
    }

    /// The observer, which is told of every tick, block, contact and event.
    pub fn observer(&mut self) -> &mut O {
        &mut self.observer
    }

    /// What was counted until now, and who watched.
    pub fn finish(self) -> (RunSummary, O) {
        (self.summary, self.observer)
    }

    /// What `scenario` has in store from now on takes the place of what this run's has.
    pub fn reschedule(&mut self, scenario: &Scenario) {
        let mut due = schedule(scenario);
        due.retain(|due| due.tick >= self.tick);
        self.due = due.into();
    }

    /// True rig time, s.
    pub fn time_s(&self) -> f64 {
        self.tick as f64 * self.scenario.tick_s()
    }

    /// Reports an event to the summary and the observer.
    fn happened(&mut self, what: RunEventKind) {
        let event = RunEvent {
            tick: self.tick,
            time_s: self.time_s(),
            what,
        };
        self.summary.event(&event);
        self.observer.event(&event);
    }

    /// Runs the next block: its ticks of the world first, then the controller's answer to them.
    pub fn block(&mut self) {
        let ticks = self.scenario.block_ticks;
        let first = self.tick;
        self.world.drift();
        self.summary.rig(&self.world.rig());
        for k in 0..ticks {
            self.happen();
            self.one_tick(k);
        }
        self.given.clear();
        self.between();
        self.keep_alive();
        let overrun = self.overruns.hits();
        if overrun {
            self.control.note_overrun();
        }
        let stale = self.losses.hits();
        let slices = self.scenario.slices_per_block;
        let outputs = &mut self.outputs[..ticks];
        if stale {
            self.control.exchange_blind(outputs, slices);
        } else {
            self.control
                .exchange(&self.frames[..ticks], outputs, slices);
        }
        while let Some(event) = self.control.take_event() {
            self.reported(&event);
        }
        let status = self.control.status();
        self.summary.block(self.tick, &status);
        self.summary.progress(self.world.plant().progress_m());
        self.observer.block(&BlockRow {
            tick: first,
            ticks,
            given: &self.given,
            frames: &self.frames[..ticks],
            outputs: &self.outputs[..ticks],
            delivered: true,
            overrun,
            stale,
            slices,
            status: &status,
        });
    }

    #[inline]
    fn one_tick(&mut self, k: usize) {
        let output = self.outputs[k];
        if output.enable != self.was_on {
            self.was_on = output.enable;
            self.happened(RunEventKind::Drive { on: output.enable });
        }
        let frame = self.world.tick(&output);
        self.frames[k] = frame;
        let plant = self.world.plant();
        let row = TickRow {
            tick: self.tick,
            time_s: plant.time_s(),
            frame,
            output,
            true_force_n: plant.force_n(),
            hammer_m: plant.hammer_m(),
            cart_m: plant.cart_m(),
            powered: self.world.is_powered(),
            faulty: self.silent || self.world.is_faulty(),
        };
        for contact in plant.finished() {
            self.summary.contact(contact);
            self.observer.contact(contact);
        }
        self.summary.tick(&row);
        self.observer.tick(&row);
        self.tick += 1;
    }

    /// Carries out the due events of the rig; those of the controller wait for the end of the block.
    #[inline]
    fn happen(&mut self) {
        while self.due.front().is_some_and(|due| due.tick <= self.tick)
            && let Some(due) = self.due.pop_front()
        {
            if !due.what.is_physical() {
                self.waiting.push(due);
                continue;
            }
            self.happened(RunEventKind::Scenario { text: due.text });
            self.world.happen(due.what);
        }
    }

    /// Carries out the due events of the controller.
    fn between(&mut self) {
        for due in std::mem::take(&mut self.waiting) {
            self.happened(RunEventKind::Scenario { text: due.text });
            match due.what {
                Doing::Command(command) => {
                    match command {
                        Command::Start(_) => self.summary.started(self.time_s()),
                        Command::Stop => self.summary.stopped(),
                        _ => {}
                    }
                    self.command(command);
                }
                Doing::Link(on) => {
                    self.silent = !on && self.link.is_some();
                    self.link = on.then_some(self.tick);
                }
                Doing::Overrun(spell) => self.overruns = spell,
                Doing::Lost(spell) => self.losses = spell,
                Doing::Reset(cause) => self.reset(cause),
                _ => {}
            }
        }
    }

    fn command(&mut self, command: Command) {
        let refused = self.control.command(command).err();
        if let Some(why) = refused {
            let text = format!("refused: {why:?}");
            self.happened(RunEventKind::Said { text });
        }
        self.given.push(Given::Command { command, refused });
    }

    fn keep_alive(&mut self) {
        if let Some(next) = self.link
            && self.tick >= next
        {
            let every = ALIVE_EVERY.as_secs_f64() / self.scenario.tick_s();
            self.link = Some(self.tick + every as u64);
            self.command(Command::Alive);
        }
    }

    fn reset(&mut self, cause: Reset) {
        let birth = self.control.reset(cause);
        let settings = *self.control.settings();
        self.given.push(Given::Born(settings, birth));
        self.born = self.tick;
        self.outputs = [Output::SAFE; MAX_BLOCK];
    }

    /// The controller reported an event.
    fn reported(&mut self, event: &control::Event) {
        let what = match event.kind {
            control::EventKind::State { from, to } => RunEventKind::State {
                from: state_name(from),
                to: state_name(to),
            },
            control::EventKind::Fault(record) => {
                // The controller counts its ticks from 1 at its start.
                let tick = self.born + u64::from(record.tick).saturating_sub(1);
                self.summary.fault(&record, tick.min(self.tick));
                RunEventKind::Fault {
                    fault: record.fault,
                    origin: record.origin,
                    value: record.value,
                }
            }
            other => RunEventKind::Said {
                text: in_words(&other),
            },
        };
        self.happened(what);
    }
}

/// The controller's other events in words.
fn in_words(what: &control::EventKind) -> String {
    use control::EventKind as Kind;
    match what {
        Kind::State { from, to } => format!("{} to {}", state_name(*from), state_name(*to)),
        Kind::Fault(record) => record.fault.name().into(),
        Kind::Cleared => "fault cleared".into(),
        Kind::Forecast { target_hz, force_n } if *target_hz > 0.0 => {
            format!("forecast: {target_hz:.3} Hz, {force_n:.1} N")
        }
        Kind::Forecast { .. } => "forecast: no stable 1/1".into(),
        Kind::NoTarget => "nothing to go to: the start is given up".into(),
        Kind::Identified { natural_hz, gap_m } => {
            format!("identified: {natural_hz:.3} Hz, gap {:.3} mm", 1e3 * gap_m)
        }
        Kind::Best {
            frequency_hz,
            impulse_n_s,
        } => format!("best so far: {frequency_hz:.3} Hz, {impulse_n_s:.4} N s per contact"),
        Kind::RegimeLost => "1/1 lost".into(),
        Kind::Doubling { frequency_hz } => format!("doubling at {frequency_hz:.3} Hz"),
        Kind::Basin(basin) => format!("basin: {}", basin_name(*basin)),
        Kind::Limits(limits) if limits.is_empty() => "no limit clamps any more".into(),
        Kind::Limits(limits) => {
            let names: Vec<_> = limits.names().collect();
            format!("limited by {}", names.join(", "))
        }
        Kind::Proven { cart, hammer } => {
            let rest = match hammer {
                Some(ratio) => format!("hammer {ratio:.3} of the cart"),
                None => "not the hammer: limits.min_frequency_hz is too high".into(),
            };
            format!("proven: cart {cart:.3} of its command, {rest}")
        }
    }
}
