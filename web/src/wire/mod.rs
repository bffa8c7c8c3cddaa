//! The serial protocol in the page: bytes of a board in, messages as JSON out; requests as JSON in, bytes out. It is the same
//! whatever carries the bytes: a WebSocket of `host-sim link PORT --page`, Web Serial, or the emulated board in a worker.

mod request;
mod shown;

use std::cell::RefCell;

use files::settings_file;
use serde::Deserialize;
use shared::link::{FromBoard, Hello, LinkAnswer};
use shared::settings::Settings;
use wire::Caller;

use crate::Function;
use crate::json::{read, write};
use crate::record::StreamRecorder;
use crate::scope::Scope;
use request::PageWanted;
use shown::{Heard, shown};

/// The functions of the protocol and the scope behind it.
pub const FUNCTIONS: &[(&str, Function)] = &[
    ("wire.open", open),
    ("wire.request", request),
    ("wire.hear", hear),
    ("wire.check-settings", check_settings),
    ("wire.trace", trace),
    ("wire.spectrum", spectrum),
    ("wire.blows", blows),
    ("wire.record", record),
    ("wire.recording", recording),
];

/// One conversation with a board.
struct Conversation {
    caller: Caller,
    hello: Option<Hello>,
    settings: Option<Settings>,
    scope: Scope,
    recorder: Option<StreamRecorder>,
}

thread_local! {
    static CONVERSATION: RefCell<Option<Conversation>> = const { RefCell::new(None) };
}

fn with<T>(work: impl FnOnce(&mut Conversation) -> Result<T, String>) -> Result<T, String> {
    CONVERSATION.with_borrow_mut(|open| match open {
        Some(conversation) => work(conversation),
        None => Err("no board is connected; connect one".into()),
    })
}

#[derive(Deserialize)]
struct Open {
    /// Requests are numbered after it: a number by chance.
    sequence: u16,
}

/// Begins a conversation anew.
fn open(argument: &[u8]) -> Result<Vec<u8>, String> {
    let Open { sequence } = read(argument)?;
    CONVERSATION.set(Some(Conversation {
        caller: Caller::new(sequence),
        hello: None,
        settings: None,
        scope: Scope::new(),
        recorder: None,
    }));
    Ok(Vec::new())
}

/// The number of a request (two bytes, least first), then its frame.
fn request(argument: &[u8]) -> Result<Vec<u8>, String> {
    let wanted: PageWanted = read(argument)?;
    with(|open| {
        let message = wanted.message(&open.caller, open.settings.as_ref())?;
        let frame = open.caller.frame(message);
        let frame = frame.ok_or("the request is too long: a fault of the program")?;
        let mut bytes = open.caller.sequence().to_le_bytes().to_vec();
        if matches!(wanted, PageWanted::Hello) {
            // Ends whatever half frame the board may be in.
            bytes.push(0);
        }
        bytes.extend(frame);
        Ok(bytes)
    })
}

/// Bytes of the board in; what they say out.
fn hear(bytes: &[u8]) -> Result<Vec<u8>, String> {
    with(|open| {
        let mut heard = Heard::default();
        for byte in bytes {
            match open.caller.hear(*byte) {
                Some(FromBoard::Answer { request, answer }) => {
                    open.learn(&answer);
                    heard.answers.push(shown(request, &answer));
                }
                Some(FromBoard::Telemetry(telemetry)) => {
                    heard.status = Some(shown::ShownStatus::of(&telemetry.status));
                    heard.dropped_by_board = telemetry.dropped;
                }
                Some(FromBoard::Recording(recording)) => {
                    let block = recording.unpack();
                    open.scope.feed(&block);
                    if let Some(recorder) = &mut open.recorder {
                        recorder.block(&block);
                    }
                }
                None => {}
            }
        }
        heard.lost = open.caller.lost();
        heard.gaps = open.scope.gaps();
        heard.lost_ticks = open.scope.lost_ticks();
        heard.recorded_s = open.recorder.as_ref().map(StreamRecorder::seconds);
        heard.recording_broke = open.recorder.as_ref().and_then(StreamRecorder::broke);
        write(&heard)
    })
}

impl Conversation {
    /// What later requests and the scope need of an answer.
    fn learn(&mut self, answer: &LinkAnswer) {
        match answer {
            LinkAnswer::Hello(hello) => self.hello = Some(hello.clone()),
            LinkAnswer::Settings(settings) => {
                self.settings = Some(*settings);
                self.scope.calibrate(settings);
            }
            LinkAnswer::Session(session) => self.caller.granted(*session),
            _ => {}
        }
    }
}

#[derive(Deserialize)]
struct Text {
    toml: String,
}

/// The board's settings with what a text says otherwise; the line that is wrong in it, if one is.
fn overlaid(now: Option<&Settings>, toml: &str) -> Result<Settings, String> {
    let now = now.ok_or("the settings of the board have not been read yet; read them")?;
    let new = settings_file::overlay(now, toml).map_err(|e| e.to_string())?;
    new.check().map_err(|e| e.to_string())?;
    Ok(new)
}

/// Checks settings without sending them; the whole of them, as they would be.
fn check_settings(argument: &[u8]) -> Result<Vec<u8>, String> {
    let Text { toml } = read(argument)?;
    with(|open| {
        let new = overlaid(open.settings.as_ref(), &toml)?;
        write(&settings_file::to_toml(&new))
    })
}

#[derive(Deserialize)]
struct Trace {
    seconds: f64,
    columns: usize,
}

/// The last seconds, one column per pixel: see [`Scope::trace`].
fn trace(argument: &[u8]) -> Result<Vec<u8>, String> {
    let Trace { seconds, columns } = read(argument)?;
    with(|open| Ok(floats(&open.scope.trace(seconds, columns))))
}

#[derive(Deserialize)]
struct Spectrum {
    signal: usize,
    max_hz: f64,
}

/// The spectrum of a signal as packed floats: see [`Scope::spectrum`].
fn spectrum(argument: &[u8]) -> Result<Vec<u8>, String> {
    let Spectrum { signal, max_hz } = read(argument)?;
    with(|open| Ok(floats(&open.scope.spectrum(signal, max_hz))))
}

fn floats(values: &[f32]) -> Vec<u8> {
    values
        .iter()
        .flat_map(|value| value.to_le_bytes())
        .collect()
}

/// The last blows, oldest first, as JSON.
fn blows(_argument: &[u8]) -> Result<Vec<u8>, String> {
    with(|open| {
        let blows: Vec<_> = open.scope.blows().collect();
        write(&blows)
    })
}

#[derive(Deserialize)]
struct Record {
    made_from: serde_json::Value,
}

/// Begins a recording: it is whole from the next restart of the controller on, which setting the same settings again makes.
fn record(argument: &[u8]) -> Result<Vec<u8>, String> {
    let Record { made_from } = read(argument)?;
    with(|open| {
        let settings = open
            .settings
            .ok_or("the settings of the board have not been read yet")?;
        let hello = open
            .hello
            .as_ref()
            .ok_or("the board has not said its name yet")?;
        open.recorder = Some(StreamRecorder::new(
            hello,
            &settings,
            &made_from.to_string(),
        )?);
        Ok(Vec::new())
    })
}

/// Ends the recording: the file.
fn recording(_argument: &[u8]) -> Result<Vec<u8>, String> {
    with(|open| {
        let recorder = open.recorder.take().ok_or("nothing is being recorded")?;
        recorder.finish()
    })
}
