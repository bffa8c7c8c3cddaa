//! A run for Foxglove: MCAP with JSON messages and their schemas, thinned so that a long run opens at once.
//!
//! | channel | what | how often |
//! |---|---|---|
//! | `/status` | the controller's status | when its state changes; every [`STATUS_TICKS`] when anything else has; every [`STILL_TICKS`] |
//! | `/force` | contact force, sensor and true, N | one of every [`FORCE_TICKS`]: the largest |
//! | `/displacement` | hammer and cart, sensors and true, mm | one of every [`DISPLACEMENT_TICKS`]: the farthest |
//! | `/contacts` | every contact as it truly was | each, at its onset |
//! | `/events` | what happened, in words, as Foxglove's log panel reads it | each |
//! | `/faults` | faults that tripped | each |
//!
//! Times are nanoseconds from the start of the run. Of each window the largest value is kept, so that a contact keeps
//! its peak force; the Parquet log has every tick.

use std::collections::BTreeMap;
use std::io::BufWriter;
use std::path::{Path, PathBuf};

use mcap::McapError;
use mcap::records::{MessageHeader, Metadata};
use serde::Serialize;
use serde_json::{Map, Value, json};
use shared::control::Status;
use shared::fault::{Fault, Origin};
use shared::settings::Settings;

use super::channels::{
    CHANNELS, CONTACTS, DISPLACEMENT, EVENTS, FAULTS, FORCE, LogChannel, STATUS,
};
use super::columns::{FORMAT, VERSION};
use super::writer::failed;
use super::{Header, LogBlock, LogTick, StatusCell, TICK_US, cells, names};
use crate::record::{RunEvent, RunEventKind, TrueContact};
use files::UserError;
use files::columns::PROGRAM;
use files::write::Staged;

/// Ticks between two messages on `/status`: at most 100 a second.
pub const STATUS_TICKS: u64 = 200;

/// Ticks between two messages on `/status` while nothing changes: 10 a second.
pub const STILL_TICKS: u64 = 2000;

/// Ticks that one message on `/force` stands for: 100 a second, more than there are contacts.
pub const FORCE_TICKS: u64 = 200;

/// Ticks that one message on `/displacement` stands for: 200 a second.
pub const DISPLACEMENT_TICKS: u64 = 100;

/// Writes the MCAP file. Dropped before [`finish`](Self::finish), it leaves nothing.
pub struct McapWriter {
    file: mcap::Writer<BufWriter<Staged>>,
    target: PathBuf,
    settings: Settings,
    channels: Vec<u16>,
    sequence: [u32; CHANNELS.len()],
    /// The status written last, and when.
    last: Option<(Status, u64)>,
    force: Window,
    displacement: Window,
    next: u64,
}

/// The tick with the largest value of a window.
#[derive(Clone, Copy, Debug, Default)]
struct Window {
    /// Its number, the quantity it was chosen by, itself.
    best: Option<(u64, f64, LogTick)>,
}

impl Window {
    fn offer(&mut self, number: u64, size: f64, tick: &LogTick) {
        if self.best.is_none_or(|(_, best, _)| size > best) {
            self.best = Some((number, size, *tick));
        }
    }
}

/// The system's own word, where it is the disk that refuses.
fn refused(path: &Path, error: McapError) -> UserError {
    match error {
        McapError::Io(error) => failed(path, error),
        other => failed(path, other),
    }
}

impl McapWriter {
    /// Begins the file `path`; an older one stays until this one is whole.
    ///
    /// # Errors
    /// The file cannot be written there.
    pub fn create(path: impl AsRef<Path>, header: &Header) -> Result<Self, UserError> {
        let staged = Staged::new(path)?;
        let target = staged.path().to_owned();
        let options = mcap::WriteOptions::new().compression(None);
        let begin = || -> mcap::McapResult<_> {
            let mut file = options.create(BufWriter::new(staged))?;
            let mut channels = Vec::with_capacity(CHANNELS.len());
            for channel in CHANNELS {
                let schema = channel.json_schema().to_string();
                let schema = file.add_schema(channel.schema, "jsonschema", schema.as_bytes())?;
                let id = file.add_channel(schema, channel.topic, "json", &BTreeMap::new())?;
                channels.push(id);
            }
            let mut metadata = BTreeMap::from([
                ("format".to_owned(), format!("{FORMAT}{VERSION}")),
                ("program".to_owned(), PROGRAM.to_owned()),
                ("source".to_owned(), header.source.clone()),
            ]);
            if let Some(scenario) = &header.scenario {
                metadata.insert("scenario".to_owned(), scenario.clone());
            }
            if let Some(made) = &header.made_from {
                metadata.insert(files::made_from::KEY.to_owned(), made.clone());
            }
            file.write_metadata(&Metadata {
                name: "run".to_owned(),
                metadata,
            })?;
            Ok((file, channels))
        };
        let (file, channels) = begin().map_err(|e| refused(&target, e))?;
        Ok(Self {
            file,
            target,
            settings: header.settings,
            channels,
            sequence: [0; CHANNELS.len()],
            last: None,
            force: Window::default(),
            displacement: Window::default(),
            next: 0,
        })
    }

    /// Takes a block; the ticks follow on those of the block before.
    ///
    /// # Errors
    /// The disk refuses.
    pub fn block(&mut self, block: &LogBlock) -> Result<(), UserError> {
        for tick in &block.ticks {
            self.tick(tick)?;
        }
        let Some(status) = &block.status else {
            return Ok(());
        };
        if !self.is_due(status) {
            return Ok(());
        }
        self.last = Some((*status, self.next));
        let fields = names().into_iter().zip(cells(status));
        let message: Map<String, Value> = fields
            .filter(|(name, _)| *name != "status_tick")
            .filter_map(|(name, cell)| Some((name.to_owned(), to_json(cell)?)))
            .collect();
        self.write(&STATUS, self.next * NS_PER_TICK, &message)
    }

    fn is_due(&self, status: &Status) -> bool {
        let Some((last, at)) = &self.last else {
            return true;
        };
        // Messages fall on a grid of ticks, however long the blocks are.
        let passed = |grid: u64| self.next / grid > at / grid;
        let same_tick = Status {
            tick: status.tick,
            ..*last
        };
        status.state != last.state
            || passed(STILL_TICKS)
            || passed(STATUS_TICKS) && *status != same_tick
    }

    /// A contact.
    ///
    /// # Errors
    /// The disk refuses.
    pub fn contact(&mut self, contact: &TrueContact) -> Result<(), UserError> {
        self.write(&CONTACTS, nanoseconds(contact.onset_s), contact)
    }

    /// Something that happened.
    ///
    /// # Errors
    /// The disk refuses.
    pub fn event(&mut self, event: &RunEvent) -> Result<(), UserError> {
        let at_ns = nanoseconds(event.time_s);
        let text = event.what.to_string();
        let (level, name) = match event.what {
            RunEventKind::Scenario { .. } => (INFORMATION, "rig"),
            RunEventKind::Fault { .. } => (ERROR, "controller"),
            _ => (INFORMATION, "controller"),
        };
        let message = json!({
            "text": text,
            "timestamp": { "sec": at_ns / NS_PER_S, "nsec": at_ns % NS_PER_S },
            "level": level,
            "message": text,
            "name": name,
            "file": "",
            "line": 0,
        });
        self.write(&EVENTS, at_ns, &message)
    }

    /// A fault that tripped at `time_s`.
    ///
    /// # Errors
    /// The disk refuses.
    pub fn fault(
        &mut self,
        time_s: f64,
        fault: Fault,
        origin: Origin,
        value: f32,
    ) -> Result<(), UserError> {
        let message = json!({
            "code": fault.code(),
            "name": fault.name(),
            "origin": format!("{origin:?}").to_lowercase(),
            "value": value,
        });
        self.write(&FAULTS, nanoseconds(time_s), &message)
    }

    /// Closes the file and gives it its name; returns where it is.
    ///
    /// # Errors
    /// The disk refuses; nothing is left then.
    pub fn finish(self) -> Result<PathBuf, UserError> {
        Ok(self.close()?.commit()?)
    }

    /// Writes what is left; the file is whole then and still has its temporary name.
    pub(super) fn close(mut self) -> Result<Staged, UserError> {
        self.close_force()?;
        self.close_displacement()?;
        let target = self.target;
        self.file.finish().map_err(|e| refused(&target, e))?;
        let staged = self.file.into_inner().into_inner();
        staged.map_err(|e| failed(&target, e.error()))
    }

    fn tick(&mut self, tick: &LogTick) -> Result<(), UserError> {
        if self.next.is_multiple_of(FORCE_TICKS) {
            self.close_force()?;
        }
        if self.next.is_multiple_of(DISPLACEMENT_TICKS) {
            self.close_displacement()?;
        }
        let (force_n, _, _, relative_m) = self.sensed(tick);
        let (force_n, relative_m) = match &tick.truth {
            Some(truth) => (truth.force_n, truth.hammer_m - truth.cart_m),
            None => (force_n, relative_m),
        };
        self.force.offer(self.next, force_n, tick);
        self.displacement.offer(self.next, relative_m.abs(), tick);
        self.next += 1;
        Ok(())
    }

    /// Contact force in N; hammer, cart and hammer relative to the cart in m, by the sensors.
    fn sensed(&self, tick: &LogTick) -> (f64, f64, f64, f64) {
        let settings = &self.settings;
        let force_n = f64::from(settings.force.value(tick.frame.force));
        let hammer_m = f64::from(settings.hammer.value(tick.frame.hammer));
        let cart_m = f64::from(settings.cart.value(tick.frame.cart));
        (force_n, hammer_m, cart_m, hammer_m - cart_m)
    }

    fn close_force(&mut self) -> Result<(), UserError> {
        let Some((number, _, tick)) = self.force.best.take() else {
            return Ok(());
        };
        let mut message = Map::new();
        message.insert("sensor_n".into(), rounded(self.sensed(&tick).0));
        if let Some(truth) = tick.truth {
            message.insert("true_n".into(), rounded(truth.force_n));
        }
        self.write(&FORCE, number * NS_PER_TICK, &message)
    }

    fn close_displacement(&mut self) -> Result<(), UserError> {
        let Some((number, _, tick)) = self.displacement.best.take() else {
            return Ok(());
        };
        let (_, hammer_m, cart_m, relative_m) = self.sensed(&tick);
        let mut message = Map::new();
        let mut put = |name: &str, metres: f64| {
            message.insert(name.into(), rounded(metres * 1e3));
        };
        put("hammer_mm", hammer_m);
        put("cart_mm", cart_m);
        put("relative_mm", relative_m);
        if let Some(truth) = tick.truth {
            put("true_hammer_mm", truth.hammer_m);
            put("true_cart_mm", truth.cart_m);
            put("true_relative_mm", truth.hammer_m - truth.cart_m);
        }
        self.write(&DISPLACEMENT, number * NS_PER_TICK, &message)
    }

    fn write(
        &mut self,
        channel: &LogChannel,
        time_ns: u64,
        message: &impl Serialize,
    ) -> Result<(), UserError> {
        let known = CHANNELS.iter().position(|c| c.topic == channel.topic);
        let at = known.unwrap_or_default();
        let bytes = serde_json::to_vec(message).map_err(|e| failed(&self.target, e))?;
        let header = MessageHeader {
            channel_id: self.channels[at],
            sequence: self.sequence[at],
            log_time: time_ns,
            publish_time: time_ns,
        };
        self.sequence[at] = self.sequence[at].wrapping_add(1);
        let written = self.file.write_to_known_channel(&header, &bytes);
        written.map_err(|e| refused(&self.target, e))
    }
}

/// Severities of a `foxglove.Log` message.
const INFORMATION: u8 = 2;
const ERROR: u8 = 4;

const NS_PER_S: u64 = 1_000_000_000;
const NS_PER_TICK: u64 = TICK_US as u64 * 1000;

fn nanoseconds(time_s: f64) -> u64 {
    (time_s * 1e9).round() as u64
}

/// A number with three decimals (mN, µm); what is not finite is null.
fn rounded(value: f64) -> Value {
    json!((value * 1e3).round() / 1e3)
}

fn to_json(cell: StatusCell) -> Option<Value> {
    match cell {
        StatusCell::Null => None,
        StatusCell::Int(value) => Some(json!(value)),
        StatusCell::Float(value) => Some(json!(value)),
        StatusCell::Text(text) => Some(json!(text)),
    }
}
