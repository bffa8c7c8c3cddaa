//! Bytes from the wire.

use shared::link::{Decoder, FromBoard, LinkAnswer, MAX_FRAME, Packet, Session, ToBoard, encode};

use super::CRC_32;
use super::device::Bench;

/// Whatever comes over the wire, in either direction: nothing panics, every frame is counted once, what is
/// understood is understood the same way again, and the next good frame gets through and is answered. Odd
/// input begins with a byte below 128 and is a raw stream; else it is cut into packets that get their CRC and
/// COBS here, so that what lies behind those is reached.
pub fn link(data: &[u8]) {
    let Some((mode, rest)) = data.split_first() else {
        return;
    };
    let stream = if *mode < 128 {
        rest.to_vec()
    } else {
        let size = usize::from(*mode - 127);
        rest.chunks(size * 4).flat_map(framed).collect()
    };
    to_the_board(&stream);
    to_the_computer(&stream);
}

fn framed(packet: &[u8]) -> Vec<u8> {
    let mut checked = packet.to_vec();
    checked.extend(CRC_32.checksum(packet).to_le_bytes());
    let mut frame = vec![0; cobs::max_encoding_length(checked.len())];
    let length = cobs::encode(&checked, &mut frame);
    frame.truncate(length);
    frame.push(0);
    frame
}

fn to_the_board(stream: &[u8]) {
    let mut bench = Bench::new();
    let mut session = Session::<2048>::new();
    let mut computer = Decoder::new();
    for byte in stream {
        session.receive(*byte, &mut bench);
        session.poll(&mut bench);
        // A slow wire: a byte out for every byte in.
        if let Some(byte) = session.queue().pop() {
            computer.push::<FromBoard>(byte);
        }
    }
    count(stream, session.counters());
    let mut last = None;
    let mut ask = [0; MAX_FRAME];
    let hello = Packet {
        sequence: 77,
        message: ToBoard::Hello,
    };
    let ask = encode(&hello, &mut ask).expect("it fits");
    while let Some(byte) = session.queue().pop() {
        computer.push::<FromBoard>(byte);
    }
    session.receive(0, &mut bench);
    for byte in ask {
        session.receive(*byte, &mut bench);
    }
    while let Some(byte) = session.queue().pop() {
        last = computer.push::<FromBoard>(byte).or(last);
    }
    let message = last.expect("an answer").message;
    let answered = matches!(
        message,
        FromBoard::Answer {
            request: 77,
            answer: LinkAnswer::Hello(_)
        }
    );
    assert!(answered, "{message:?}");
    assert_eq!(computer.counters().dropped(), 0, "the board's own frames");
}

fn to_the_computer(stream: &[u8]) {
    let mut decoder = Decoder::new();
    for byte in stream {
        let Some(packet) = decoder.push::<FromBoard>(*byte) else {
            continue;
        };
        // By bytes: a NaN is unequal to itself.
        let mut first = [0; MAX_FRAME];
        let mut second = [0; MAX_FRAME];
        let once = encode(&packet, &mut first).expect("what came in can go out");
        let mut again = Decoder::new();
        let mut packets = once.iter().filter_map(|b| again.push::<FromBoard>(*b));
        let back = packets.next().expect("a good frame");
        assert_eq!(Some(once), encode(&back, &mut second));
        if let FromBoard::Recording(recording) = packet.message {
            let block = recording.unpack();
            assert_eq!(block.frames.len(), block.outputs.len());
        }
    }
    count(stream, decoder.counters());
}

/// Every run of bytes between zeros is counted once.
fn count(stream: &[u8], counters: shared::link::Counters) {
    let ended = stream
        .iter()
        .rposition(|b| *b == 0)
        .map_or(&[][..], |end| &stream[..end]);
    let frames = ended.split(|b| *b == 0).filter(|run| !run.is_empty());
    assert_eq!(
        frames.count() as u32,
        counters.good + counters.dropped(),
        "{counters:?}"
    );
}
