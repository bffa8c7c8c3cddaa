//! A run: the world and the controller, block by block.

use std::time::Duration;

use shared::control::{Command, Event as Told, EventKind as Saying, MAX_BLOCK};
use shared::io::{Frame, Output};

use super::record::{BlockRow, Event, Given, Observer, TickRow, What};
use super::scenario::Scenario;
use super::schedule::{Doing, Due, Spell, schedule, state_name};
use super::tally::Tally;
use super::under_test::{ControlUnderTest, Reset};
use super::verdict::basin_name;
use super::world::World;
use files::UserError;

/// How often a link in command says that it is there.
const ALIVE_EVERY: Duration = Duration::from_millis(500);

/// Runs `scenario` with `control`, which was just made with its settings; `observer` watches.
///
/// # Errors
/// One line: the true rig is none that can be.
pub fn run(
    scenario: &Scenario,
    control: &mut impl ControlUnderTest,
    observer: &mut impl Observer,
) -> Result<Tally, UserError> {
    let mut run = Run::new(scenario, control, observer)?;
    for _ in 0..scenario.blocks() {
        run.block();
    }
    Ok(run.tally)
}

struct Run<'a, C, O> {
    scenario: &'a Scenario,
    control: &'a mut C,
    observer: &'a mut O,
    world: World,
    due: std::iter::Peekable<std::vec::IntoIter<Due>>,
    /// Due between blocks.
    waiting: Vec<Due>,
    tick: u64,
    /// Tick of the run at which the controller was last born.
    born: u64,
    link: Option<u64>,
    overruns: Spell,
    losses: Spell,
    frames: [Frame; MAX_BLOCK],
    outputs: [Output; MAX_BLOCK],
    given: Vec<Given>,
    was_on: bool,
    tally: Tally,
}

impl<'a, C: ControlUnderTest, O: Observer> Run<'a, C, O> {
    fn new(
        scenario: &'a Scenario,
        control: &'a mut C,
        observer: &'a mut O,
    ) -> Result<Self, UserError> {
        observer.born(0, Reset::PowerOn, control.settings());
        Ok(Self {
            scenario,
            control,
            observer,
            world: World::new(scenario)?,
            due: schedule(scenario).into_iter().peekable(),
            waiting: Vec::new(),
            tick: 0,
            born: 0,
            link: None,
            overruns: Spell::default(),
            losses: Spell::default(),
            frames: [Frame::default(); MAX_BLOCK],
            outputs: [Output::SAFE; MAX_BLOCK],
            given: Vec::new(),
            was_on: false,
            tally: Tally::new(scenario),
        })
    }

    fn time_s(&self) -> f64 {
        self.tick as f64 * self.scenario.tick_s()
    }

    fn tell(&mut self, what: What) {
        let event = Event {
            tick: self.tick,
            time_s: self.time_s(),
            what,
        };
        self.tally.event(&event);
        self.observer.event(&event);
    }

    fn block(&mut self) {
        let ticks = self.scenario.block_ticks;
        let first = self.tick;
        self.world.drift();
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
        while let Some(told) = self.control.take_event() {
            self.told(&told);
        }
        let status = self.control.status();
        self.tally.block(self.tick, &status);
        self.observer.block(&BlockRow {
            tick: first,
            ticks,
            commands: &self.given,
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
            self.tell(What::Drive { on: output.enable });
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
        };
        for contact in plant.finished() {
            self.tally.contact(contact);
            self.observer.contact(contact);
        }
        self.tally.tick(&row);
        self.observer.tick(&row);
        self.tick += 1;
    }

    /// Does to the rig what is due; what is due to the controller waits for the end of the block.
    #[inline]
    fn happen(&mut self) {
        while let Some(due) = self.due.next_if(|due| due.tick <= self.tick) {
            if !due.what.is_physical() {
                self.waiting.push(due);
                continue;
            }
            self.tell(What::Scenario { text: due.text });
            match due.what {
                Doing::Emergency(open) => self.world.set_emergency(open),
                Doing::Defect(sensor, defect) => self.world.set_defect(sensor, defect),
                Doing::Push(speed) => self.world.push(speed),
                Doing::Drift(change, over_s) => {
                    self.tally.drift(self.world.rig(), &change, over_s);
                    self.world.begin_drift(change, over_s);
                }
                _ => {}
            }
        }
    }

    /// Does to the controller what is due.
    fn between(&mut self) {
        for due in std::mem::take(&mut self.waiting) {
            self.tell(What::Scenario { text: due.text });
            match due.what {
                Doing::Command(command) => self.command(command),
                Doing::Link(on) => self.link = on.then_some(self.tick),
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
            self.tell(What::Said { text });
        }
        self.given.push(Given { command, refused });
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
        self.control.reset(cause);
        // What it was told before is gone with it.
        self.given.clear();
        self.born = self.tick;
        self.outputs = [Output::SAFE; MAX_BLOCK];
        self.observer
            .born(self.tick, cause, self.control.settings());
    }

    /// What the controller says, told on.
    fn told(&mut self, told: &Told) {
        let what = match told.kind {
            Saying::State { from, to } => What::State {
                from: state_name(from),
                to: state_name(to),
            },
            Saying::Fault(record) => {
                // The controller counts from 1 at its birth.
                let tick = self.born + u64::from(record.tick).saturating_sub(1);
                self.tally.fault(&record, tick.min(self.tick));
                What::Fault {
                    fault: record.fault,
                    origin: record.origin,
                    value: record.value,
                }
            }
            other => What::Said {
                text: in_words(&other),
            },
        };
        self.tell(what);
    }
}

/// The controller's other events in words.
fn in_words(what: &Saying) -> String {
    match what {
        Saying::State { from, to } => format!("{} to {}", state_name(*from), state_name(*to)),
        Saying::Fault(record) => record.fault.name().into(),
        Saying::Cleared => "fault cleared".into(),
        Saying::Forecast { target_hz, force_n } if *target_hz > 0.0 => {
            format!("forecast: {target_hz:.3} Hz, {force_n:.1} N")
        }
        Saying::Forecast { .. } => "forecast: no stable 1/1".into(),
        Saying::NoTarget => "nothing to go to: the start is given up".into(),
        Saying::Identified { natural_hz, gap_m } => {
            format!("identified: {natural_hz:.3} Hz, gap {:.3} mm", 1e3 * gap_m)
        }
        Saying::Best {
            frequency_hz,
            impulse_n_s,
        } => format!("best so far: {frequency_hz:.3} Hz, {impulse_n_s:.4} N s per contact"),
        Saying::RegimeLost => "1/1 lost".into(),
        Saying::Doubling { frequency_hz } => format!("doubling at {frequency_hz:.3} Hz"),
        Saying::Basin(basin) => format!("basin: {}", basin_name(*basin)),
        Saying::Limits(limits) if limits.is_empty() => "no limit clamps any more".into(),
        Saying::Limits(limits) => {
            let names: Vec<_> = limits.names().collect();
            format!("limited by {}", names.join(", "))
        }
    }
}
