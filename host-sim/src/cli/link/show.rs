//! What `host-sim link` shows.

use std::time::{Duration, Instant};

use serde::Serialize;
use serde_json::{Value, json};
use shared::control::{SettingsState, Status, Unfit};
use shared::fault::{Fault, FaultRecord};
use shared::link::{BoardState, ForecastPage, FromBoard, Hello, LinkAnswer, ToBoard};
use shared::settings::TICK_RATE_HZ;

use super::Port;
use crate::cli::arguments::output::{Format, emit, no_json, to_json};
use crate::cli::terminal::{print, print_if_read};
use crate::link::by_hand;
use crate::link::clock::Clock;
use crate::words::number;
use emulator::names::state_name;
use files::UserError;
use files::made_from::{MadeFrom, into_json};

/// One line: what a person wants to know at a glance.
pub fn line(status: &Status) -> String {
    let time_s = f64::from(status.tick) / f64::from(TICK_RATE_HZ);
    let mut text = format!(
        "{time_s:10.2} s  {:<9} {:7.3} Hz  {:6.3} mm  {:>9}  {:7.1} N",
        state_name(status.state),
        status.frequency_hz,
        1e3 * status.measured_amplitude_m,
        status.regime.to_string(),
        status.peak_n,
    );
    if status.target_hz > 0.0 {
        text.push_str(&format!(
            "  target {:.3} Hz, {:.1} N",
            status.target_hz, status.target_n
        ));
    }
    if !status.limits.is_empty() {
        let names: Vec<_> = status.limits.names().collect();
        text.push_str(&format!("  limited: {}", names.join(", ")));
    }
    if status.events_dropped > 0 {
        text.push_str(&format!("  events lost: {}", status.events_dropped));
    }
    if let Some(record) = &status.fault {
        text.push_str(&format!("  fault: {}", fault(record)));
    }
    text
}

fn fault(record: &FaultRecord) -> String {
    let others = record.episode.without(record.fault);
    let others: Vec<_> = others.faults().map(Fault::name).collect();
    let others = if others.is_empty() {
        String::new()
    } else {
        format!(", with {}", others.join(", "))
    };
    let mut why = String::new();
    if record.fault == Fault::BoardUnfit {
        let reasons: Vec<_> = Unfit::from_bits(record.value as u8).reasons().collect();
        why = format!(": {}", reasons.join("; "));
    }
    format!(
        "{} {}{why} (value {:.4}, at tick {}, {:.3} Hz){others}",
        record.fault.code(),
        record.fault.name(),
        record.value,
        record.tick,
        record.frequency_hz
    )
}

pub fn status(
    port: &mut Port,
    hello: &Hello,
    format: Format,
    made: &MadeFrom,
) -> Result<(), UserError> {
    let status = port.status()?;
    let board = port.board()?;
    if format == Format::Json {
        let mut answer = serde_json::to_value(status).map_err(no_json)?;
        answer["board"] = hello.board.as_str().into();
        answer["firmware"] = hello.firmware.as_str().into();
        answer["state"] = state_name(status.state).into();
        answer["regime"] = status.regime.to_string().into();
        answer["settings"] = serde_json::to_value(board.settings).map_err(no_json)?;
        answer["held"] = board.held.into();
        answer["awaits_acknowledgement"] = board.awaits_acknowledgement.into();
        answer["fault"] = status.fault.map_or(Value::Null, |record| {
            json!({
                "code": record.fault.code(),
                "name": record.fault.name(),
                "value": record.value,
                "tick": record.tick,
                "frequency_hz": record.frequency_hz,
                "episode": record.episode.faults().map(Fault::name).collect::<Vec<_>>(),
            })
        });
        print(&into_json(to_json(&answer)?, made));
        return Ok(());
    }
    print(&format!(
        "{}, firmware {}, {} ticks/s in blocks of {}\n{}\n",
        hello.board,
        hello.firmware,
        hello.tick_rate_hz,
        hello.block_ticks,
        line(&status)
    ));
    for word in remarks(&board) {
        print(&format!("{word}\n"));
    }
    Ok(())
}

/// What a person must do, or should know, before the board can be steered.
fn remarks(board: &BoardState) -> Vec<&'static str> {
    let settings = match board.settings {
        SettingsState::Stored => None,
        SettingsState::Model => Some("the model replaces the rig (bench mode)"),
        SettingsState::Missing => Some("no settings yet: send those of this rig (`set`)"),
        SettingsState::Damaged => {
            Some("the stored settings are damaged: send those of this rig (`set`)")
        }
        SettingsState::OlderCopy => Some(
            "the newest settings are damaged and an older copy is in use: read it (`get`), then `confirm` it or send others (`set`)",
        ),
    };
    let acknowledge = board.awaits_acknowledgement.then_some(
        "the emergency stop must be acknowledged: close the chain and press the board's button",
    );
    let held = board.held.then_some("a program steers");
    [settings, acknowledge, held]
        .into_iter()
        .flatten()
        .collect()
}

/// How often the monitor looks whether it should give up.
const LOOK: Duration = Duration::from_millis(200);

pub fn monitor(port: &mut Port, duration_s: Option<f64>, rate: f64) -> Result<(), UserError> {
    let decimation = (f64::from(TICK_RATE_HZ) / rate).clamp(1.0, 1e9) as u32;
    port.tell(ToBoard::StreamTelemetry { decimation })?;
    let mut begun = None;
    let mut heard = Instant::now();
    let silence = Duration::from_secs_f64(3.0 + 3.0 / rate);
    let mut clock = Clock::new();
    let end = duration_s.map(|s| Instant::now() + by_hand::at_most(s));
    loop {
        if end.is_some_and(|end| Instant::now() > end) {
            return Err(port.complaint("the controller's time does not pass; reset the board"));
        }
        if let Some(FromBoard::Telemetry(telemetry)) = port.streamed(LOOK)? {
            heard = Instant::now();
            let status = telemetry.status;
            clock.goes_on(&status).map_err(|why| port.complaint(why))?;
            let begun = *begun.get_or_insert(status.tick);
            let read = print_if_read(&format!("{}\n", line(&status)));
            let passed = f64::from(status.tick.wrapping_sub(begun)) / f64::from(TICK_RATE_HZ);
            if !read || duration_s.is_some_and(|limit_s| passed >= limit_s) {
                return port.tell(ToBoard::StreamTelemetry { decimation: 0 });
            }
        } else if heard.elapsed() > silence {
            return Err(port.complaint("the board has fallen silent; check the cable"));
        }
    }
}

#[derive(Serialize)]
struct ForecastLine {
    frequency_hz: f32,
    regime: String,
    force_n: f32,
    orbit_force_n: Option<f32>,
    orbit_multiplier: Option<f32>,
    stable: Option<bool>,
}

pub fn forecast(
    port: &mut Port,
    hello: &Hello,
    format: Format,
    made: &MadeFrom,
) -> Result<(), UserError> {
    let settings = port.settings()?;
    let (rows, target) = pages(port)?;
    let lines: Vec<_> = rows
        .iter()
        .map(|row| ForecastLine {
            frequency_hz: row.frequency_hz,
            regime: row.regime.to_string(),
            force_n: row.force_n,
            orbit_force_n: row.orbit.map(|orbit| orbit.force_n),
            orbit_multiplier: row.orbit.map(|orbit| orbit.multiplier),
            stable: row.orbit.map(|orbit| orbit.is_stable()),
        })
        .collect();
    let answer = serde_json::json!({
        "rows": lines,
        "target": target,
        "board": hello.board.as_str(),
        "firmware": hello.firmware.as_str(),
        "settings": settings,
    });
    emit(format, Some(made), &answer, &lines, || {
        let mut text = String::from("       Hz  from rest        N  1/1 orbit, N  multiplier\n");
        for line in &lines {
            text.push_str(&format!(
                "{:9.4}  {:>9} {:8.2}  {:>12}  {:>10}\n",
                line.frequency_hz,
                line.regime,
                line.force_n,
                number(line.orbit_force_n.map(f64::from), 2),
                number(line.orbit_multiplier.map(f64::from), 3),
            ));
        }
        text.push_str(&match target {
            Some(t) => format!(
                "target {:.4} Hz, {:.2} N; stable 1/1 from {:.4} to {:.4} Hz\n",
                t.frequency_hz, t.orbit.force_n, t.band_hz.0, t.band_hz.1
            ),
            None => "no stable 1/1 was found\n".to_owned(),
        });
        text
    })
}

type Pages = (
    Vec<shared::forecast::ForecastRow>,
    Option<shared::forecast::Target>,
);

/// How often a forecast is read from its beginning.
const READS: u32 = 5;

/// Every page of one forecast; begins again when a newer one comes between.
fn pages(port: &mut Port) -> Result<Pages, UserError> {
    let mut whole: Option<ForecastPage> = None;
    let mut rows = Vec::new();
    let mut page = 0_u8;
    let mut begun = 1;
    loop {
        let part = match port.ask(ToBoard::GetForecast { page })? {
            LinkAnswer::Forecast(part) => part,
            other => return Err(port.odd(&other)),
        };
        if part.rows_in_all == 0 {
            return Err(
                port.complaint("there is no forecast yet; it takes some seconds, ask again")
            );
        }
        if whole.as_ref().is_some_and(|first| first.id != part.id) {
            if begun == READS {
                return Err(port.complaint(
                    "the forecast changes each time before it is read to its end; ask again",
                ));
            }
            begun += 1;
            (whole, page) = (None, 0);
            rows.clear();
            continue;
        }
        rows.extend(part.rows.iter().copied());
        if part.rows.is_empty() || rows.len() >= usize::from(part.rows_in_all) {
            return Ok((rows, part.target));
        }
        whole = Some(part);
        page = page
            .checked_add(1)
            .ok_or_else(|| port.complaint("the forecast has no end; reset the board"))?;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_board_that_is_not_fit_says_why() {
        let record = FaultRecord::unfit(Unfit::CLOCK.and(Unfit::SUPPLY));
        let shown = fault(&record);
        let why = "18 board-unfit: the crystal's clock is missing or died; the supply is too low";
        assert!(shown.starts_with(why), "{shown}");
        assert!(!fault(&FaultRecord::CRASH).contains(':'));
    }
}
