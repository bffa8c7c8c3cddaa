//! A session does what it is asked.

use super::*;

#[test]
fn requests_are_carried_out_and_answered() {
    let mut pair = Pair::new();
    assert!(matches!(pair.ask(ToBoard::Hello), LinkAnswer::Hello(h) if h.board == "stub"));
    assert_eq!(pair.ask(ToBoard::GetStatus), LinkAnswer::Status(idle(0)));
    let record = LinkAnswer::FaultRecord(Some(longest_record()));
    assert_eq!(pair.ask(ToBoard::GetFaultRecord), record);
    let mut rows = 0;
    for page in 0.. {
        let LinkAnswer::Forecast(part) = pair.ask(ToBoard::GetForecast { page }) else {
            panic!("a page was asked for");
        };
        assert_eq!(part.rows_in_all, 40);
        if part.rows.is_empty() {
            break;
        }
        assert_eq!(part.rows[0].frequency_hz, rows as f32);
        rows += part.rows.len();
    }
    assert_eq!(rows, 40);
    let mut program = pair.open(false).unwrap();
    let start = Command::Start(Mode::Automatic);
    assert_eq!(pair.command(&mut program, start), LinkAnswer::Done);
    let refused = LinkAnswer::Refused(Refusal::Controller(Refused::WrongState));
    assert_eq!(pair.command(&mut program, start), refused);
}

#[test]
fn settings_are_taken_whole_and_only_if_they_are_good() {
    let mut pair = Pair::new();
    let mut program = pair.open(false).unwrap();
    let mut set = |pair: &mut Pair, new| pair.steer(&mut program, LinkAct::SetSettings(new));
    let old = pair.device.settings;
    let mut new = old;
    new.trips.force_n = f32::NAN;
    let bad = LinkAnswer::Refused(Refusal::Controller(Refused::BadSettings));
    assert_eq!(set(&mut pair, new), bad);
    assert_eq!((pair.device.settings, pair.device.stored), (old, None));
    new.trips.force_n = 1.1 * old.trips.force_n;
    assert_eq!(set(&mut pair, new), LinkAnswer::Done);
    assert_eq!((pair.device.settings, pair.device.stored), (new, Some(new)));
    pair.device.status.state = State::Hold;
    let wrong = LinkAnswer::Refused(Refusal::Controller(Refused::WrongState));
    assert_eq!(set(&mut pair, old), wrong);
    assert_eq!((pair.device.settings, pair.device.stored), (new, Some(new)));
}

#[test]
fn telemetry_comes_at_its_decimation_also_where_ticks_wrap() {
    let mut pair = Pair::new();
    pair.device.status.tick = u32::MAX - 120;
    let stream = ToBoard::StreamTelemetry { decimation: 100 };
    assert_eq!(pair.ask(stream), LinkAnswer::Done);
    let mut seen = Vec::new();
    for _ in 0..40 {
        pair.session.poll(&mut pair.device);
        for packet in pair.heard() {
            if let FromBoard::Telemetry(telemetry) = packet.message {
                seen.push(telemetry.status.tick);
            }
        }
        pair.device.status.tick = pair.device.status.tick.wrapping_add(10);
    }
    let start = u32::MAX - 120;
    let expected = [0, 100, 200, 300].map(|ticks| start.wrapping_add(ticks));
    assert_eq!(seen, expected);
    pair.ask(ToBoard::StreamTelemetry { decimation: 0 });
    pair.session.poll(&mut pair.device);
    assert!(pair.heard().is_empty());
}

#[test]
fn a_full_queue_drops_recordings_whole_counts_them_and_still_answers() {
    let mut pair = Pair::new();
    assert_eq!(
        pair.ask(ToBoard::StreamFrames { on: true }),
        LinkAnswer::Done
    );
    assert!(pair.device.recorded);
    for _ in 0..100 {
        pair.session.poll(&mut pair.device);
    }
    let dropped = pair.session.queue().dropped();
    assert!(dropped > 0);
    // Nothing was read since, and there is room for an answer.
    pair.send(ToBoard::GetForecast { page: 0 });
    let heard = pair.heard();
    let last = &heard.last().unwrap().message;
    assert!(matches!(last, FromBoard::Answer { .. }), "{last:?}");
    // The numbers show what was lost: the first packet answered the request to stream.
    let missing = heard.last().unwrap().sequence - 1 - heard.len() as u16;
    assert_eq!(u32::from(missing), dropped);
    assert_eq!(pair.session.queue().dropped(), dropped);
    // Who says hello begins a conversation without it.
    pair.ask(ToBoard::Hello);
    pair.session.poll(&mut pair.device);
    assert!(pair.heard().is_empty() && !pair.device.recorded);
}
