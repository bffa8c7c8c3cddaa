use std::f64::consts::TAU;

use shared::control::MAX_BLOCK;
use shared::io::{Frame, Output};

use super::*;

/// A cart that moves with `mm` at `hz`, and a force of 50 N for 2 ms at `at` of each turn.
fn block(tick: u32, hz: f64, mm: f64, at: f64) -> RecordedBlock {
    let settings = Settings::for_rig(&WIRES);
    let code = |channel: &Channel, value: f64| {
        AdcCode(
            (f64::from(channel.zero_code) + value / f64::from(channel.unit_per_code)).round()
                as u16,
        )
    };
    let mut block = RecordedBlock {
        tick,
        ..RecordedBlock::default()
    };
    for k in 0..10 {
        let turns = f64::from(tick + k) * TICK_S * hz;
        let struck = (turns - at).rem_euclid(1.0) < 2e-3 * hz;
        let frame = Frame {
            force: code(&settings.force, if struck { 50.0 } else { 0.0 }),
            hammer: code(&settings.hammer, 0.0),
            cart: code(&settings.cart, 1e-3 * mm * (TAU * turns).sin()),
            emergency: false,
        };
        let output = Output {
            frequency_hz: hz as f32,
            enable: true,
            ..Output::SAFE
        };
        assert!(block.frames.len() < MAX_BLOCK);
        block.frames.push(frame).expect("room");
        block.outputs.push(output).expect("room");
    }
    block
}

fn fed(seconds: f64) -> Scope {
    fed_from(0, seconds)
}

fn fed_from(first: u32, seconds: f64) -> Scope {
    let mut scope = Scope::new();
    for tick in (first..first + (seconds * 20_000.0) as u32).step_by(10) {
        scope.feed(&block(tick, 4.0, 0.8, 0.5));
    }
    scope
}

/// A page that comes late has the board's time, as its events have it.
#[test]
fn its_time_is_the_board_s() {
    let scope = fed_from(1_000_000, 1.0);
    let trace = scope.trace(0.5, 4);
    assert!(
        (trace[0] - 50.5).abs() < 1e-3 && (trace[1] - 51.0).abs() < 1e-3,
        "{trace:?}"
    );
    let last = scope.blows().last().expect("a blow");
    assert!((50.6..51.0).contains(&last.time_s), "{last:?}");
}

#[test]
fn blows_have_their_peak_impulse_and_phase() {
    let scope = fed(5.0);
    let blows: Vec<_> = scope.blows().collect();
    assert!((18..=20).contains(&blows.len()), "{}", blows.len());
    let last = blows.last().expect("a blow");
    assert!((last.peak_n - 50.0).abs() < 0.5, "{last:?}");
    // The sum starts and ends with a whole tick: 40 or 41 of them.
    assert!((last.impulse_n_s - 0.1).abs() < 0.004, "{last:?}");
    assert!(
        (last.phase_deg.expect("it moves") - 180.0).abs() < 1.0,
        "{last:?}"
    );
}

#[test]
fn a_spectrum_has_the_amplitude_at_its_frequency() {
    let scope = fed(4.0);
    let spectrum = scope.spectrum(2, 60.0);
    let step = f64::from(spectrum[0]);
    let (at, largest) = spectrum[1..]
        .iter()
        .enumerate()
        .max_by(|a, b| a.1.total_cmp(b.1))
        .expect("values");
    assert!((at as f64 * step - 4.0).abs() < step, "{at}");
    // Up to 15 % less between two steps.
    assert!((0.67..0.81).contains(largest), "{largest}");
    assert_eq!(fed(1.0).spectrum(2, 60.0).len(), 1, "too short");
    assert_eq!(scope.spectrum(7, 60.0).len(), 1, "no such signal");
}

#[test]
fn a_gap_is_a_hole_in_the_trace_and_is_counted() {
    let mut scope = fed(1.0);
    scope.feed(&block(22_000, 4.0, 0.8, 0.5));
    assert_eq!((scope.gaps(), scope.lost_ticks()), (1, 2000));
    let trace = scope.trace(0.2, 20);
    assert_eq!(trace.len(), 2 + 20 * 6);
    assert!((trace[1] - trace[0] - 0.2).abs() < 1e-6);
    let holes = trace[2..].chunks(6).filter(|column| column[0].is_nan());
    // 2000 of the last 4000 ticks, but for the last block.
    assert_eq!(holes.count(), 9);
    assert_eq!(scope.spectrum(0, 60.0).len(), 1, "not across a gap");
    // A board that counts anew is no gap.
    scope.feed(&block(0, 4.0, 0.8, 0.5));
    scope.feed(&block(10, 4.0, 0.8, 0.5));
    assert_eq!(scope.gaps(), 1);
}
