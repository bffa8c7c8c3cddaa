//! Writes what the fuzzer starts from: every kind of message and stored settings, into `tests/fuzz/corpus`.
//! For when the protocol or the settings change: `cargo run -p tests --example corpus`.

use std::fs;
use std::io;
use std::path::PathBuf;

use serde::Serialize;
use shared::control::{Command, Mode};
use shared::io::{Frame, Output};
use shared::link::{
    FromBoard, LinkAct, MAX_FRAME, Packet, RecordedBlock, Recording, ToBoard, encode,
};
use shared::model::params::PRESETS;
use shared::settings::Settings;

fn main() -> io::Result<()> {
    let settings = PRESETS.map(|(_, rig)| Settings::for_rig(&rig));
    let point = Command::SetPoint {
        frequency_hz: 3.66,
        amplitude_m: 0.89e-3,
    };
    let requests = [
        ToBoard::Hello,
        ToBoard::GetStatus,
        ToBoard::Command(Command::Start(Mode::Manual)),
        ToBoard::Command(point),
        ToBoard::Command(Command::Stop),
        ToBoard::GetSettings,
        ToBoard::GetForecast { page: 6 },
        ToBoard::StreamTelemetry { decimation: 10 },
        ToBoard::StreamFrames { on: true },
        ToBoard::GetFaultRecord,
        ToBoard::GetIdentified,
        ToBoard::GetBoard,
        // What the fuzzer's board grants: boot 0, session after session.
        open(0, false),
        steer(1, LinkAct::SetSettings(settings[0])),
        steer(2, LinkAct::SetSettings(settings[1])),
        steer(3, LinkAct::Command(Command::Start(Mode::Manual))),
        steer(4, LinkAct::Command(point)),
        steer(5, LinkAct::Command(Command::Alive)),
        steer(6, LinkAct::Command(Command::ConfirmSettings)),
        steer(7, LinkAct::Command(Command::Acknowledge { opened: true })),
        open(1, true),
        steer(8, LinkAct::Release),
    ];
    for (i, request) in requests.iter().enumerate() {
        // A raw stream, and a packet that the fuzzer's body frames (chunks of 512 bytes).
        save("link", &format!("request-{i}"), 0, &framed(request))?;
        save("link", &format!("packet-{i}"), 255, &packet(request))?;
    }
    let all: Vec<u8> = requests.iter().flat_map(framed).collect();
    save("link", "conversation", 0, &all)?;
    let block = RecordedBlock {
        tick: 123_456,
        frames: [Frame::default(); 10].into_iter().collect(),
        outputs: [Output::SAFE; 10].into_iter().collect(),
        ..RecordedBlock::default()
    };
    let recording = FromBoard::Recording(Recording::pack(&block));
    save("link", "recording", 0, &framed(&recording))?;
    save("link", "recording-packet", 255, &packet(&recording))?;

    let images = settings.map(|settings| bytes_of(&settings));
    for (i, image) in images.iter().enumerate() {
        // Both slots with a right CRC, then one, then none.
        let both = [image.as_slice(), image.as_slice()].concat();
        save("settings", &format!("both-{i}"), 0b0010_0111, &both)?;
        save("settings", &format!("one-{i}"), 1, &both)?;
        save("settings", &format!("none-{i}"), 0, &both)?;
    }
    Ok(())
}

fn open(granted: u32, take_over: bool) -> ToBoard {
    ToBoard::OpenSession {
        boot: 0,
        granted,
        take_over,
    }
}

/// An act of the first session in boot 0.
fn steer(number: u32, act: LinkAct) -> ToBoard {
    ToBoard::Steer {
        session: 0x9e37_79b9,
        number,
        act,
    }
}

fn save(target: &str, name: &str, mode: u8, bytes: &[u8]) -> io::Result<()> {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("fuzz/corpus");
    fs::create_dir_all(folder.join(target))?;
    fs::write(folder.join(target).join(name), [&[mode], bytes].concat())
}

fn framed<M: Serialize + Clone>(message: &M) -> Vec<u8> {
    let packet = Packet {
        sequence: 1,
        message: message.clone(),
    };
    let mut frame = [0; MAX_FRAME];
    encode(&packet, &mut frame).expect("it fits").to_vec()
}

fn packet<M: Serialize>(message: &M) -> Vec<u8> {
    bytes_of(&(1_u16, message))
}

fn bytes_of<T: Serialize>(value: &T) -> Vec<u8> {
    let mut buffer = [0; 512];
    let bytes = postcard::to_slice(value, &mut buffer).expect("it fits");
    bytes.to_vec()
}
